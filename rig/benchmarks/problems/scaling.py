"""Growth of cost with the size of a problem: times at some sizes, and a fitted exponent."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from rig.benchmarks.problems.beds import PROTOCOL, bed
from rig.benchmarks.results.fits import fitted
from rig.benchmarks.timing import interleaved
from rig.campaign.one_run.assemble import assemble
from rig.campaign.resolve import campaign_of
from rig.catalog.rig_file import load_rig
from rig.prediction.own import predict_own
from rig.protocol.load import load_protocol
from rig.theory.total import layers_total

Row = dict[str, Any]


def layers(count: float) -> None:
    """Run the layers variant at 5 m/s^2 for a bed with `count` layers: the standard bed's thresholds,
    interpolated.
    """
    stack = bed(5.0).stack
    place = np.linspace(0.0, 1.0, int(count))
    known = np.linspace(0.0, 1.0, stack.threshold.size)
    threshold = np.interp(place, known, stack.threshold)
    layers_total(threshold, np.tile(stack.clearance[0], (threshold.size, 1)), 1.0, 0.0, 5.0, 20.0)


def rows(count: float) -> None:
    """Run the layers variant at 5 m/s^2 with `count` rows per layer."""
    bed(5.0, int(count)).energy()


def cycles(count: float) -> None:
    """Record a run of `count` cycles at 2 m/s^2, where rows without a period are simulated
    throughout.
    """
    _records(f"acquire.record={int(count)} cycles")


def samples(count: float) -> None:
    """Record a run of 40 cycles with `count` samples per cycle."""
    _records(f"acquire.samples_per_cycle={int(count)}")


def grains(count: float) -> None:
    """Compute W_T at 5 m/s^2 of the standard box filled with `count` grains of the diameter that
    fits.
    """
    standard = bed(5.0)
    per_grain = (
        np.pi / 6.0 * standard.condition.scene.grains.diameter**3 / standard.rig.packing_shaken
    )
    cavity = standard.condition.scene.cavity
    volume = cavity.length * cavity.width * cavity.height * standard.condition.scene.grains.fill
    diameter = standard.condition.scene.grains.diameter * (volume / per_grain / count) ** (
        1.0 / 3.0
    )
    found = bed(5.0, 8, (f"scene.grains.diameter={diameter!r}",))
    predict_own(found.condition, found.rig)


def _records(setting: str) -> None:
    sets = ["acquire.settle=2 cycles", "drive.acceleration=2", "repeats=1", setting]
    loaded = load_protocol(PROTOCOL, sets=sets)
    campaign = campaign_of(loaded, load_rig("paper"), "")
    for _ in assemble(campaign, campaign.runs[0]):
        pass


AXES: dict[str, tuple[Callable[[float], None], Sequence[float], Sequence[float], str]] = {
    "layers": (
        layers,
        (64, 256, 1024, 4096),
        (64, 512, 4096),
        "layers variant, 5 m/s2, 8 rows per layer",
    ),
    "rows": (rows, (8, 32, 128, 512), (8, 64, 512), "layers variant, 5 m/s2, 85 layers"),
    "cycles": (cycles, (64, 256, 1024, 2048), (64, 256, 1024), "stand and acquisition, 2 m/s2"),
    "samples": (
        samples,
        (512, 1280, 2560, 5120),
        (512, 1280, 2560),
        "stand and acquisition, 40 cycles, per cycle",
    ),
    "grains": (
        grains,
        (1e5, 1e6, 1e7, 1e8, 1e9, 1e10),
        (1e5, 1e7, 1e10),
        "both variants of W_T, diameter changes",
    ),
}


def scaling(axis: str, rounds: int, quick: bool) -> list[Row]:
    """Return rows with the time at each size, and one with the exponent of their medians and its
    standard error.

    `at_most_linear`: the exponent less twice that error is at most 1 (None where no claim is made).
    """
    call, full, few, what = AXES[axis]
    sizes = few if quick else full
    for size in sizes:
        call(size)
    seconds = interleaved({repr(size): partial(call, size) for size in sizes}, rounds)
    return fitted(axis, what, {size: seconds[repr(size)] for size in sizes})
