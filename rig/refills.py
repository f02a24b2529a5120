"""What beds poured anew take beside the nominal bed, which W_T is of: one is not the mean of the others.

The nominal bed has the mean play, and W is no straight line over it: at 90 % fill and 5 m/s^2 of protocol fill_rate
poured beds take 3 % less in the mean, and a few of them much less (a skew of -1.8).
"""

import numpy as np
from scipy.special import ndtri

from daq.seeds import stream
from rig.beds.stack import Filling, layer_count, nominal, stack
from rig.catalog.entries import Rig
from rig.errors import InputError
from rig.model import SLUG_AVERAGE, closed, slug_tier
from rig.scene import Condition, Scene

COUNT = 64
"""Beds poured; packing and play are drawn from as many equally likely ranges, so that their means are much better than
those of as many free draws (tests/physics/test_refills.py)."""

CYCLES = 64
"""Averaged where a row has no period: good to 0.4 % of W_T, one bed."""

SEED = 1


def refill_ratios(condition: Condition, rig: Rig) -> tuple[float, ...]:
    """Return W_T of poured beds over the nominal bed's W_T at the set level; nothing where W_T is 0 or a bed cannot be
    followed."""
    scene = condition.scene
    if scene.bed not in ("layers", "slug"):
        return ()
    try:
        point = _energy(condition, rig, nominal(scene, rig))
        if not point > 0.0:
            return ()
        return tuple(_energy(condition, rig, filling) / point for filling in poured(scene, rig))
    except InputError:
        return ()


def poured(scene: Scene, rig: Rig, count: int = COUNT) -> list[Filling]:
    """Return fillings as `rig.beds.stack.refill` draws them, packing and play each once from every `count`-th of their
    distributions."""
    rng = stream(SEED, "refills")
    packing, play = (ndtri((rng.permutation(count) + rng.random(count)) / count) for _ in range(2))
    shape = layer_count(scene), scene.layers.rows
    return [
        Filling(
            rig.packing_shaken * (1.0 + rig.refill_packing * float(p)),
            scene.layers.play * max(1.0 + rig.refill_play * float(q), 0.0),
            rng.random(shape),
        )
        for p, q in zip(packing, play, strict=True)
    ]


def _energy(condition: Condition, rig: Rig, filling: Filling) -> float:
    scene, drive = condition.scene, condition.drive
    if scene.bed == "slug":
        return slug_tier(scene, rig, filling, drive.acceleration, drive.frequency, *SLUG_AVERAGE).total.total
    return closed(scene, stack(scene, rig, filling), drive.acceleration, drive.frequency, CYCLES).total
