"""The errata of the paper, with numbers of the printed and the corrected form, computed
on request.
"""

import math

import numpy as np

from rig.theory import chain, collision, friction, wall
from rig.theory.collision import Bodies, Contact
from rig.theory.paper import literal
from rig.theory.paper import totals as balance
from rig.theory.paper.collision_errata import Array, basis_errata, collision_errata, random_hits
from rig.theory.paper.erratum import Erratum
from rig.theory.paper.sentences import (
    CAVITY,
    GRAIN,
    GRAVITY,
    JANSSEN,
    WALL,
    collision_claims,
    friction_claims,
    rig_claims,
)

__all__ = ["Array", "errata", "random_hits"]


def errata() -> tuple[Erratum, ...]:
    """Return every equation and sentence of the paper that was checked, in its order; `holds` marks
    the right ones.
    """
    return (
        *_friction(),
        *basis_errata(),
        *collision_errata(),
        *_wall(),
        *_chain(),
        *friction_claims(),
        *collision_claims(),
        *rig_claims(),
    )


def _friction() -> tuple[Erratum, ...]:
    saturation = friction.janssen_length(CAVITY[0], CAVITY[1], WALL, JANSSEN)
    steel = (85, 0.004, CAVITY[0], CAVITY[1], 0.60 * 7900.0, GRAVITY, GRAIN, saturation)
    right = friction.friction_energy_per_slip(*steel)
    forces = friction.slice_forces(1000.0, 0.0, 1e-3, 0.15, 0.15, 1650.0, GRAVITY, WALL, JANSSEN)
    step = -friction.slice_imbalance(forces)
    balanced = friction.slice_imbalance(
        friction.slice_forces(
            1000.0, step / 0.15**2, 1e-3, 0.15, 0.15, 1650.0, GRAVITY, WALL, JANSSEN
        )
    )
    box = "steel, 4 mm, 85 %, packing 0.60"
    return (
        Erratum(
            "1, 2",
            "imbalance of a slice whose stress steps by its weight less the wall friction",
            "balanced",
            "the same",
            0.0,
            balanced,
            "N",
            True,
            "a silo at rest, which a shaken bed is not",
        ),
        Erratum(
            "3",
            "1 - 1/e of the deepest stress stands at depth lambda",
            "holds",
            "the same",
            -math.expm1(-1.0),
            float(friction.janssen_stress(saturation, 1.0, 1.0, saturation)) / saturation,
            "",
            True,
        ),
        Erratum(
            "4",
            "slip over radius",
            "(4 sqrt(3)/3 - 2) r",
            "the same",
            4.0 * 3.0**0.5 / 3.0 - 2.0,
            friction.slip_distance(2.0),
            "",
            True,
            "one choice of geometry, not 'thinnest to thickest'",
        ),
        Erratum(
            "5",
            f"W_f with h_i = w H in the sum ({box})",
            "every layer at the bottom",
            "h_i = i d",
            literal.friction_energy(*steel),
            right,
            "J",
            False,
            "joules per slip, not per cycle",
        ),
        Erratum(
            "5",
            f"W_f with mu_i read as mu_p in the exponent ({box})",
            "mu_i",
            "mu_s",
            literal.friction_energy(*steel, WALL),
            right,
            "J",
            False,
            "h_i = w H as printed",
        ),
    )


def _wall() -> tuple[Erratum, ...]:
    middle = literal.moved(0.0, -0.2, 0.13, 1e-4)
    event = float(collision.moved(0.0, [-0.2], [0.13], 1e-4, 0.0)[0])
    hit = np.array([1.0, 0.0, -1.0])
    both = wall.compression_impulse(1.0, hit, 0.2) + wall.recovery_impulse(1.0, hit, 0.2, 0.7)
    return (
        Erratum(
            "12",
            "position after 0.1 ms, hit at its start, 0.2 m/s, e = 0.65",
            "mean of both velocities",
            "time of the event",
            middle,
            event,
            "m",
            False,
        ),
        Erratum(
            "13",
            "tangential impulse of compression, 1 kg, mu = 0.2, v_n = v_t = 1",
            "0",
            "-mu m |v_n|",
            0.0,
            float(wall.compression_impulse(1.0, hit, 0.2)[0]),
            "N s",
            False,
            "the superscript c is lost",
        ),
        Erratum(
            "14",
            "v_t after compression, mu = 0.2, v_n = v_t = 1",
            "v_t - mu z'",
            "max(0, v_t - mu |z'|)",
            literal.compression_slip(1.0, -1.0, 0.2),
            float(wall.compression_slip(1.0, 1.0, 0.2)),
            "m/s",
            False,
        ),
        Erratum(
            "15",
            "friction coefficient of a hit that sticks (mu = 2)",
            "mu",
            "impulses' ratio",
            2.0,
            float(wall.impulse_ratio(wall.compression_impulse(1.0, hit, 2.0))),
            "",
            False,
        ),
        Erratum(
            "16",
            "tangential impulse of both phases, e0 = 0.7",
            "compression counted twice",
            "from its end on",
            float(2.0 * wall.compression_impulse(1.0, hit, 0.2)[0] - 0.2 * 0.7),
            float(both[0]),
            "N s",
            False,
            "1 kg, mu = 0.2, v_n = v_t = 1",
        ),
        Erratum(
            "17",
            "e0 of a grain 1 m/s to -0.7 m/s, wall at rest",
            "-1",
            "(V2 - V1)/(v1 - v2)",
            literal.wall_restitution(0.0, 0.0, 1.0, -0.7),
            float(wall.wall_restitution(1.0, -0.7, 0.0, 0.0)),
            "",
            False,
        ),
        Erratum(
            "18",
            "v_t after the hit, mu = 0.2, e0 = 0.7, v_n = v_t = 1",
            "from before the hit",
            "max(0, v_t - mu (1 + e0) |z'|)",
            literal.slip_after(1.0, 0.7, 0.2, 0.7),
            float(wall.slip_after(1.0, 1.0, 0.2, 0.7)),
            "m/s",
            False,
        ),
        Erratum(
            "14, 18",
            "the same, one after the other",
            "from eq 14 corrected",
            "eq 18 stands alone",
            literal.slip_after(0.8, 0.7, 0.2, 0.7),
            float(wall.slip_after(1.0, 1.0, 0.2, 0.7)),
            "m/s",
            False,
        ),
        Erratum(
            "19c",
            "height of a 4 mm grain after 100 hits",
            "z = z0 + r",
            "z = z_wall + r",
            literal.height_after(0.002, 0.002, 100),
            0.002,
            "m",
            False,
        ),
    )


def _chain() -> tuple[Erratum, ...]:
    e, grains = 0.65, np.ones(400)
    lost, struck = chain.first_wave_loss(grains, e, 1.0), chain.struck_velocity(1.0, 3.0, 0.5, 2.0)
    drop = literal.first_wave_loss(grains, e, 1.0)
    heavy = collision.collide(
        Bodies([3.0], [[2.0, 0.0, 0.0]]), Bodies([1.0], [[0.0] * 3]), [[1.0, 0, 0]], Contact(0.5)
    )
    return (
        Erratum(
            "20, 21",
            "velocity of 3 kg at rest struck by 1 kg at 2 m/s, e = 0.5",
            "holds",
            "the same",
            0.75,
            struck,
            "m/s",
            True,
            "for the first wave through grains at rest",
        ),
        Erratum(
            "22",
            "grain at rest, box at 1 m/s, e0 = 0.75: e0 from eq 17",
            "V2 - V1",
            "V2 + e0 V1",
            0.0,
            chain.first_grain_velocity(1.0, 0.75),
            "m/s",
            False,
            "right as printed once eq 17 is",
        ),
        Erratum(
            "23",
            "lost over put in, 400 equal grains, e = 0.65",
            "drop of every grain",
            "loss of every pair",
            drop / 0.5,
            lost / 0.5,
            "",
            False,
        ),
        Erratum(
            "23",
            "loss of one pair, 3 kg at 2 m/s on 1 kg, e = 0.5",
            "-",
            "m_r (1 - e^2) w^2/2",
            None,
            balance.collision_energy(heavy.loss),
            "J",
            False,
        ),
        Erratum(
            "24",
            "W_T of 1 J friction and 2 J collision",
            "W_f + W_c",
            "the same",
            3.0,
            balance.total_energy(1.0, 2.0),
            "J",
            True,
            "leaves open which owns the friction inside hits",
        ),
        Erratum(
            "25",
            "W_exp of a whole cycle: 2 J put in, no change of kinetic energy",
            "W_exc - W_kin",
            "the same",
            2.0,
            balance.measured_energy(2.0, 0.0),
            "J",
            True,
            "whole cycles of a periodic bed",
        ),
    )
