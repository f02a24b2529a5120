"""Wall times side by side: every call once per round, in a different order each time, the first call left out."""

import statistics
import time
import tracemalloc
from collections.abc import Callable, Mapping
from typing import Any

LEAST = 2e-3
"""Seconds that one measurement lasts at least: short calls are repeated, and the time of one of them is given."""

MOST_CALLS = 1000


def interleaved(calls: Mapping[str, Callable[[], object]], rounds: int, least: float = LEAST) -> dict[str, list[float]]:
    """Seconds per call, one for each round, by name. Every call has been made once before: that is the warm-up."""
    names = list(calls)
    repeats = {name: _repeats(calls[name], least) for name in names}
    found: dict[str, list[float]] = {name: [] for name in names}
    for number in range(rounds):
        turn = number % len(names)
        for name in names[turn:] + names[:turn]:
            call, times = calls[name], repeats[name]
            start = time.perf_counter()
            for _ in range(times):
                call()
            found[name].append((time.perf_counter() - start) / times)
    return found


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
    """Median, least and largest of some measurements, and how many they are."""
    return {"median": statistics.median(values), "low": min(values), "high": max(values), "rounds": len(values)}


def ratios(slow: list[float], fast: list[float]) -> dict[str, Any]:
    """Spread of slow over fast, round by round: what both have in common, such as a busy machine, falls out."""
    return spread([a / b for a, b in zip(slow, fast, strict=True)])


def peak_memory(call: Callable[[], Any]) -> tuple[Any, float]:
    """Result of a call and the largest sum of what Python and numpy held for it, in kB (compiled code's own is not seen)."""
    tracemalloc.start()
    try:
        result = call()
        return result, tracemalloc.get_traced_memory()[1] / 1024.0
    finally:
        tracemalloc.stop()
