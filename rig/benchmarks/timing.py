"""Wall times side by side: every call once per round, in a different order each time, the first
call left out.
"""

import statistics
import time
import tracemalloc
from collections.abc import Callable, Mapping
from typing import Any

LEAST = 5e-4
"""Least duration of a measurement, s: shorter calls are repeated, and the time of one of them is
returned.
"""

BATCHES = 7
"""Measurements of a short call per round, the shortest of which counts: other processes can only
add time.
"""

MOST_CALLS = 1000


def interleaved(
    calls: Mapping[str, Callable[[], object]], rounds: int, least: float = LEAST
) -> dict[str, list[float]]:
    """Return the seconds per call, one for each round, by name.

    Each is called once before, to warm up.
    """
    names = list(calls)
    repeats = {name: _repeats(calls[name], least) for name in names}
    found: dict[str, list[float]] = {name: [] for name in names}
    for number in range(rounds):
        turn = number % len(names)
        for name in names[turn:] + names[:turn]:
            batches = BATCHES if repeats[name] > 1 else 1
            found[name].append(min(_batch(calls[name], repeats[name]) for _ in range(batches)))
    return found


def _batch(call: Callable[[], object], times: int) -> float:
    start = time.perf_counter()
    for _ in range(times):
        call()
    return (time.perf_counter() - start) / times


def _repeats(call: Callable[[], object], least: float) -> int:
    start = time.perf_counter()
    call()
    once = time.perf_counter() - start
    if once < 0.5 * least:  # the very first call may have compiled something
        start = time.perf_counter()
        call()
        once = min(once, time.perf_counter() - start)
    return min(max(int(least / max(once, 1e-9)), 1), MOST_CALLS)


def spread(values: list[float]) -> dict[str, Any]:
    """Return median, least, largest and number of some measurements."""
    return {
        "median": statistics.median(values),
        "low": min(values),
        "high": max(values),
        "rounds": len(values),
    }


def ratios(slow: list[float], fast: list[float]) -> dict[str, Any]:
    """Return the spread of slow over fast, round by round: common influences, such as a busy
    machine, cancel.
    """
    return spread([a / b for a, b in zip(slow, fast, strict=True)])


def against(
    times: Mapping[str, list[float]], ours: str, rival: str, demand: float
) -> dict[str, Any]:
    """Return a claim on `interleaved` times, for a row: speed relative to a rival's, and the least
    demanded.
    """
    return {"rival": rival, "demand": demand, **ratios(times[rival], times[ours])}


def peak_memory(call: Callable[[], Any]) -> tuple[Any, float]:
    """Return (result of a call, peak memory of Python and numpy in kB), without memory of compiled
    code.
    """
    tracemalloc.start()
    try:
        result = call()
        return result, tracemalloc.get_traced_memory()[1] / 1024.0
    finally:
        tracemalloc.stop()
