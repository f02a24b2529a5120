"""Distribution of the energy of refilled beds about that of the nominal bed (W_T), which is not
their mean.

The nominal bed has the mean clearance, but W is not linear in the clearance: at 90 % fill and 5
m/s^2 of protocol fill_rate, refilled beds dissipate 3 % less on average, and a few of them much
less (skewness -1.5).

Rows are independent of each other, and thresholds do not depend on the packing. Therefore each
layer's energy is computed once over the possible clearances of a row, and a refilled bed is a sum
over its rows.
"""

from collections.abc import Callable, Mapping
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from daq.random_streams import stream
from rig.beds.janssen_stack import Filling, layer_count, mobile_share, stack
from rig.catalog.entries import Rig
from rig.errors import InputError
from rig.prediction.own import SINGLE_MASS_AVERAGE, single_mass_variant
from rig.protocol.spec import Condition
from rig.theory.friction import slip_distance
from rig.theory.total import TooManyEvents, layer_energies

Array = NDArray[np.float64]

COUNT = 256
"""Number of refilled beds. Packing and clearance are drawn once from each of as many equally likely
ranges (stratified), so that their means are much more accurate than those of as many free draws.
"""

ROWS, FEWEST = 1024, 10
"""Rows whose energy is computed, over all layers, and least number of clearances of a layer. Each
row takes the nearest clearance: the grid is shifted in each layer, so that the errors average out.
"""

CYCLES = 16
"""Cycles averaged for a row without a period, after 64: a bed is a sum of many rows."""

WIDEST = 4.0
"""Standard deviations of the clearance within which a layer's energy is computed."""

SEED = 1


def refill_ratios(condition: Condition, rig: Rig, W_T: float) -> tuple[float, ...]:
    """Return the energies of refilled beds at the set level, divided by W_T (J), that of the
    nominal one.

    Empty if W_T is 0, for beds that a refill does not change, and if a bed cannot be followed.
    """
    scene = condition.scene
    if not W_T > 0.0 or scene.bed not in REFILLED:
        return ()
    try:
        energies = REFILLED[scene.bed](condition, rig, W_T)
    except (InputError, TooManyEvents):
        return ()
    return tuple(float(f"{energy / W_T:.5g}") for energy in energies)


def _layers(condition: Condition, rig: Rig, _W_T: float) -> Array:
    scene, drive = condition.scene, condition.drive
    settings, layers, rng = scene.layers, layer_count(scene), stream(SEED, "refills")
    packed, played = _deviates(rng)
    packing = 1.0 + rig.refill_packing * packed
    loosest = float(packing.min())
    bed = stack(scene, rig, Filling(rig.packing_shaken * loosest, settings.clearance))
    mobile = len(bed.threshold)
    low = (1.0 - settings.spread) * max(1.0 - WIDEST * rig.refill_clearance, 0.0)
    high = (1.0 + settings.spread) * (1.0 + WIDEST * rig.refill_clearance)
    count = max(FEWEST, ROWS // max(mobile, 1))
    width = (high - low) / count
    start = low + width * rng.random((mobile, 1))  # of each layer's grid of clearances
    free = (
        settings.clearance
        * slip_distance(scene.grains.diameter)
        * (start + width * np.arange(count))
    )
    each = layer_energies(
        bed.threshold,
        free,
        bed.row_mass,
        bed.restitution,
        drive.acceleration,
        drive.frequency,
        CYCLES,
    )
    # Positions of the rows in their strata, then clearances, then places in the layer's grid: one
    # array in single precision, because there are millions of them.
    place = rng.random((COUNT, mobile, settings.rows), np.float32)
    place += np.arange(settings.rows, dtype=np.float32)
    place *= 2.0 * settings.spread / settings.rows
    place += 1.0 - settings.spread
    place *= np.maximum(1.0 + rig.refill_clearance * played, 0.0).astype(np.float32)[:, None, None]
    place -= (start - 0.5 * width).astype(np.float32)
    place /= np.float32(width)
    np.clip(place, 0.0, count - 0.5, out=place)
    index = place.astype(np.intp)
    index += count * np.arange(mobile)[:, None]
    of_layers = each.ravel().take(index).sum(axis=2)
    # Denser beds have fewer layers with room to flow, and more mass.
    share = [
        mobile_share(scene.grains.fill, rig.packing_shaken * p, rig.packing_loose) for p in packing
    ]
    top = np.cumsum(np.pad(of_layers, ((0, 0), (1, 0))), axis=1)
    moving = np.rint(np.array(share) * layers).astype(int)
    return np.asarray(packing / loosest * top[np.arange(COUNT), moving])


def _single_masses(condition: Condition, rig: Rig, _W_T: float) -> Array:
    scene, drive = condition.scene, condition.drive
    packed, _ = _deviates(stream(SEED, "refills"))
    beds = (
        Filling(rig.packing_shaken * (1.0 + rig.refill_packing * float(z)), 1.0) for z in packed
    )
    found = (
        single_mass_variant(
            scene, rig, bed, drive.acceleration, drive.frequency, *SINGLE_MASS_AVERAGE
        )
        for bed in beds
    )
    return np.array([one.total.total for one in found])


def _columns(_condition: Condition, rig: Rig, W_T: float) -> Array:
    """Return energies of refilled columns: in proportion to their mass, thresholds do not change."""
    packed, _ = _deviates(stream(SEED, "refills"))
    return np.asarray(W_T * (1.0 + rig.refill_packing * packed), dtype=np.float64)


def _deviates(rng: np.random.Generator) -> Array:
    """Return normal deviates of packing and clearance, one for each bed, shape (2, COUNT)."""
    # Not by scipy.special: its import takes longer than the predictions of a small protocol.
    quantile = NormalDist().inv_cdf
    ranges = [(rng.permutation(COUNT) + rng.random(COUNT)) / COUNT for _ in range(2)]
    return np.array([[quantile(p) for p in drawn.tolist()] for drawn in ranges])


REFILLED: Mapping[str, Callable[[Condition, Rig, float], Array]] = {
    "layers": _layers,
    "single_mass": _single_masses,
    "column": _columns,
}
"""Beds that a refill changes, with the energies of refilled beds (J): (condition, rig, W_T)."""
