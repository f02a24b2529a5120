"""Rows of a scaling axis: times at each size, and the exponent fitted to them."""

from collections.abc import Mapping
from typing import Any

from rig.benchmarks.results.curve import exponent
from rig.benchmarks.timing import ratios, spread

Row = dict[str, Any]

LINEAR = 1.0
"""Largest exponent that is still at most linear, to which the error of the fit is added."""

CLAIMED = ("layers", "rows", "cycles", "samples", "conditions")


def workers(seconds: Mapping[float, list[float]]) -> list[Row]:
    """Return the rows of the axis `workers` from the wall seconds of one job by number of
    processes, round by round.

    The exponent is -1 where every process counts in full; the title states the speed-up of the
    largest number.
    """
    if len(seconds) < 2:
        return []
    most = max(seconds)
    gain = ratios(seconds[min(seconds)], seconds[most])
    what = (
        f"fill protocol recorded: {most:g} processes are {gain['median']:.2f} times as fast as {min(seconds):g} "
        f"({gain['low']:.2f} to {gain['high']:.2f})"
    )
    rows = fitted("workers", what, seconds)
    return [*rows[:-1], {**rows[-1], "speed_up": gain}]


def fitted(axis: str, what: str, seconds: Mapping[float, list[float]]) -> list[Row]:
    """Return the rows of an axis from its times, by size and round."""
    sizes = tuple(seconds)
    found: list[Row] = []
    for size, each in seconds.items():
        ms = spread([1e3 * value for value in each])
        found.append(
            {"kind": "scaling", "axis": axis, "what": what, "size": size, "ms": ms, "failure": None}
        )
    slope, error = exponent(sizes, [row["ms"]["median"] for row in found])
    fits = [exponent(sizes, each)[0] for each in zip(*seconds.values(), strict=True)]
    held = slope - 2.0 * error <= LINEAR if axis in CLAIMED else None
    found.append({"kind": "exponent", "axis": axis, "what": what, "exponent": slope, "error": error,
                  "rounds": spread(fits), "at_most_linear": held, "sizes": [sizes[0], sizes[-1]],
                  "failure": None})  # fmt: skip
    return found
