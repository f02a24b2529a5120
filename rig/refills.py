"""What beds poured anew take beside the nominal bed, which W_T is of: one is not the mean of the others.

The nominal bed has the mean play, and W is no straight line over it: at 90 % fill and 5 m/s^2 of protocol fill_rate
poured beds take 3 % less in the mean, and a few of them much less (a skew of -1.5).

Rows are independent of each other, and thresholds do not know the packing: so each layer's energy is computed once over
the plays that pouring may give a row, and a poured bed is a sum over its rows.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from daq.seeds import stream
from rig.beds.stack import Filling, layer_count, mobile_share, stack
from rig.catalog.entries import Rig
from rig.errors import InputError
from rig.model import SLUG_AVERAGE, slug_tier
from rig.scene import Condition
from rig.theory.friction import slip_distance
from rig.theory.total import TooManyEvents, layer_energies

Array = NDArray[np.float64]

COUNT = 128
"""Beds poured; packing and play are drawn once from each of as many equally likely ranges, so that their means are much
better than those of as many free draws."""

PLAYS = 64
"""Plays at which the energy of a layer's row is known: between them the nearest counts."""

CYCLES = 64
"""Averaged where a row has no period: good to 0.4 % of one bed's W_T, and many beds are summed up."""

WIDEST = 4.0
"""Standard deviations of the play within which a layer's energy is known."""

SEED = 1


def refill_ratios(condition: Condition, rig: Rig, W_T: float) -> tuple[float, ...]:
    """Return the energies of poured beds at the set level over W_T (J), that of the nominal one; nothing where that is
    0, for beds of which pouring changes nothing, and where a bed cannot be followed."""
    scene = condition.scene
    if not W_T > 0.0:
        return ()
    try:
        energies = _slugs(condition, rig) if scene.bed == "slug" else _layers(condition, rig)
    except (InputError, TooManyEvents):
        return ()
    return tuple(float(f"{energy / W_T:.5g}") for energy in energies)


def _layers(condition: Condition, rig: Rig) -> Array:
    scene, drive = condition.scene, condition.drive
    settings, layers, deviates = scene.layers, layer_count(scene), _deviates()
    loosest = 1.0 + rig.refill_packing * float(deviates[0].min())
    bed = stack(scene, rig, Filling(rig.packing_shaken * loosest, settings.play))
    low = (1.0 - settings.spread) * max(1.0 - WIDEST * rig.refill_play, 0.0)
    high = (1.0 + settings.spread) * (1.0 + WIDEST * rig.refill_play)
    width = (high - low) / PLAYS
    plays = low + width * (np.arange(PLAYS) + 0.5)
    free = settings.play * slip_distance(scene.grains.diameter) * np.broadcast_to(plays, (len(bed.threshold), PLAYS))
    each = layer_energies(
        bed.threshold, free, bed.row_mass, bed.restitution, drive.acceleration, drive.frequency, CYCLES
    )
    rng, found = stream(SEED, "refills", "rows"), []
    row = np.arange(len(each))[:, None]
    for packed, played in deviates.T:
        packing = 1.0 + rig.refill_packing * packed
        share = mobile_share(scene.grains.fill, rig.packing_shaken * packing, rig.packing_loose)
        stratum = (np.arange(settings.rows) + rng.random((len(each), settings.rows))) / settings.rows
        spread = 1.0 - settings.spread + 2.0 * settings.spread * stratum
        play = max(1.0 + rig.refill_play * played, 0.0) * spread
        place = np.clip(((play - low) / width).astype(int), 0, PLAYS - 1)
        found.append(packing / loosest * float(each[row, place][: round(share * layers)].sum()))
    return np.array(found)


def _slugs(condition: Condition, rig: Rig) -> Array:
    scene, drive = condition.scene, condition.drive
    beds = (Filling(rig.packing_shaken * (1.0 + rig.refill_packing * float(z)), 1.0) for z in _deviates()[0])
    found = (slug_tier(scene, rig, bed, drive.acceleration, drive.frequency, *SLUG_AVERAGE) for bed in beds)
    return np.array([one.total.total for one in found])


def _deviates() -> Array:
    """Normal deviates of packing and play, one for each bed, shape (2, COUNT)."""
    rng = stream(SEED, "refills")
    return np.array([ndtri((rng.permutation(COUNT) + rng.random(COUNT)) / COUNT) for _ in range(2)])
