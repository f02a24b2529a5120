"""Run all measurements in order: a job that fails gives a row with the reason, and rows are
delivered as they come.
"""

import subprocess
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from rig.benchmarks.machine import header
from rig.benchmarks.results.claims import checked, judged

Row = dict[str, Any]


@dataclass(frozen=True)
class Job:
    """Something to measure; `weight` is its approximate duration in seconds, for the time left."""

    title: str
    weight: float
    rows: Callable[[], Iterable[Row]]


def jobs(quick: bool) -> tuple[Job, ...]:
    """Return the measurements of `rig bench`; quick: fewer problems, settings, sizes and rounds."""
    from rig.benchmarks import fill_protocol
    from rig.benchmarks.problems import (
        beds,
        chain,
        compiling,
        conditions,
        exciter,
        precision,
        recording,
        records,
        scaling,
        sliders,
        small_beds,
    )

    rounds = 3 if quick else 5
    few = min(rounds, 3)
    problems = sliders.sliders() + sliders.single_masses()
    if quick:
        problems = (problems[1], problems[3], problems[6], problems[8])
    found = [
        Job(one.name, 3.0 if quick else 8.0, partial(precision.precision, one, rounds, quick))
        for one in problems
    ]
    found += [
        Job(
            f"layers at {level:g} m/s2",
            3.0 if quick else 8.0,
            partial(beds.layers, level, few - 1, quick),
        )
        for level in ((2.0, 5.0) if quick else (1.0, 2.0, 3.0, 4.0, 5.0))
    ]
    levels = (5.0,) if quick else (3.0, 5.0)
    found += [
        Job(
            "small beds",
            4.0 if quick else 20.0,
            partial(small_beds.small_beds, levels, few - 1, quick),
        ),
        Job(
            "drift of the account",
            1.0 if quick else 5.0,
            partial(beds.drift, 10_000 if quick else 100_000),
        ),
        Job("chain", 0.5 if quick else 2.5, partial(chain.chain, 10, rounds, quick)),
        Job("acquisition", 1.0 if quick else 3.0, partial(records.acquisition, rounds, quick)),
        Job("recorder", 2.0, partial(recording.recorder, rounds)),
        Job("analysis and replay", 4.0 if quick else 8.0, partial(records.reading, few, quick)),
        Job("exciter in the loop", 4.0 if quick else 8.0, partial(exciter.coupled, rounds, quick)),
        Job("fill protocol", 16.0 if quick else 45.0, partial(records.fill, 2 if quick else 5)),
    ]
    found += [
        Job(f"scaling: {axis}", 1.5 if quick else 5.0, partial(scaling.scaling, axis, few, quick))
        for axis in scaling.AXES
    ]
    found.append(
        Job(
            "scaling: conditions",
            20.0 if quick else 120.0,
            partial(conditions.conditions, few - 1, quick),
        )
    )
    if not quick:
        found.append(
            Job("compiling", 90.0, partial(compiling.compiling, fill_protocol.FILL, records.SETS))
        )
        found.append(Job("memory", 40.0, records.memory))
    return tuple(found)


def measured(
    todo: Sequence[Job], quick: bool, watch: Callable[[Job, bool], None] = lambda *_: None
) -> Iterator[Row]:
    """Yield the rows of all jobs, the machine first, the claims last.

    `watch` is called before and after (True) each job.
    """
    from analysis.session.record import AnalysisError
    from daq.session.plan import SessionError
    from rig.errors import InputError

    expected = (
        ArithmeticError,
        ValueError,
        OSError,
        RuntimeError,
        MemoryError,
        subprocess.SubprocessError,
        InputError,
        SessionError,
        AnalysisError,
    )
    yield rounded(header(quick))
    kept = []
    for job in todo:
        watch(job, False)
        try:
            rows = list(job.rows())
        except expected as error:
            rows = [
                {
                    "kind": "failed",
                    "problem": job.title,
                    "failure": f"{type(error).__name__}: {error}",
                }
            ]
        for row in map(rounded, rows):
            kept.append(row)
            yield row
        watch(job, True)
    yield from map(rounded, judged(kept))
    yield from map(rounded, checked(kept))


def rounded(value: Any) -> Any:
    """Return the value with every float rounded to six digits, because the output claims no more
    precision than was measured.
    """
    if isinstance(value, dict):
        return {key: rounded(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [rounded(inner) for inner in value]
    return float(f"{value:.6g}") if isinstance(value, float) else value
