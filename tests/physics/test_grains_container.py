"""A container with grains, dropped: grains take its rebound away.

Pacheco-Vazquez and Dorbolo (Sci. Rep. 3 (2013) 2158) saw no rebound near m_grains = 1.5 e
m_container. The box of the kernel follows a motion; here the motion is made step by step of its
own weight and of the grains' force, one step late. The ground is hard: it turns the velocity of the
container at once. (A ground contact that lasts longer than those of the grains lets them ride up
with the container; where the rebound is least, and how small, then depends on that contact.)
"""

import math

import numpy as np
from grains_scenes import PAIR_TIME, RADIUS, G, box, down, heap, linear

from rig.kernels.grains.engine import Engine

DROP, GROUND = 0.05, 0.7


def rebound(ratio: float) -> float:
    """Return the height of rebound over that of the empty container.

    ratio : mass of the grains over that of the container times the restitution of the ground
    """
    dt = PAIR_TIME / 14.0
    side = 8.0 * RADIUS
    engine = Engine(heap(40, side, side), linear(0.6, 0.3), box(side, side, 0.1, 2, down()), dt)
    engine.advance(np.zeros(20_001))
    mass = engine.mass / (ratio * GROUND)
    # Fall: grains and box fly side by side.
    fall = int(math.sqrt(2.0 * DROP / G) / dt)
    engine.advance(-G * dt * np.arange(fall + 1))
    velocity = -G * dt * fall
    force = engine.advance(np.array([velocity, velocity])).force
    height, top = 0.0, 0.0
    for _ in range(int(-2.0 * GROUND * velocity / G / dt)):
        after = velocity - dt * (force / mass + G)
        if height <= 0.0 and after < 0.0:
            after *= -GROUND
        force = engine.advance(np.array([velocity, after])).force
        velocity = after
        height += dt * velocity
        top = max(top, height)
    return top / (GROUND**2 * DROP)


def test_one_and_a_half_e_times_its_mass_in_grains_take_the_rebound_of_a_container() -> None:
    light, half, one_and_a_half = (rebound(ratio) for ratio in (0.02, 0.5, 1.5))
    # One lump that strikes the floor of the container and stays there leaves it this height; the
    # grains do not stay, they come up, so that they take more.
    lump = [((1.0 - x) / (1.0 + GROUND * x)) ** 2 for x in (0.02, 0.5)]
    assert lump[0] * 0.9 < light < lump[0]
    assert lump[1] * 0.2 < half < lump[1]
    # Nothing to be seen of the 5 cm: half of the grains' radius.
    assert one_and_a_half < 0.01
