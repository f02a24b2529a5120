"""The commands that tell LAMMPS a scene: contacts, walls, box. SI units.

Which of LAMMPS's contacts are ours, to rounding (tests/dem): its classic pairs where the dashpot is
the same for all (balls of one size and mass with linear springs) or absent; its modular ones, for
sizes and for Hertz contacts with a dashpot, whose friction acts at R - overlap/2 instead of R.
Walls are always the modular ones: the classic walls of LAMMPS 2025.7.22 have almost no tangential
spring.
"""

import math
from dataclasses import dataclass

import numpy as np

from rig.errors import InputError, Mistake
from rig.kernels.grains.arrays import Law, Room
from rig.kernels.grains.engine import Packing

SKIN = 0.1
"""Neighbours are closer than touching by this fraction of the smallest diameter, as in ours."""
MOST_CAVITIES = 30
"""LAMMPS has 32 groups of grains, one of which is `all`."""
MARGIN = 2.0
"""LAMMPS's box reaches beyond the walls by this many largest radii."""


@dataclass(frozen=True)
class LammpsCommands:
    """LammpsCommands before and after the grains are made, and what the grains are moved by.

    shift : from the rig's coordinates to LAMMPS's, m, shape (3,)
    """

    before: tuple[str, ...]
    after: tuple[str, ...]
    shift: np.ndarray


def commands(
    packing: Packing, law: Law, room: Room, dt: float, file: str, turning: bool = True
) -> LammpsCommands:
    """Return the commands for a scene.

    file : where LAMMPS writes the force on all grains; turning : False for grains that do not turn

    Raises InputError for what LAMMPS does not have as we have it.
    """
    _refuse(law, room)
    shift = np.zeros(3)
    if room.cylinder:
        shift[:2] = -0.5 * room.length
    lines = _after(packing, law, room, file, "nve/sphere" if turning else "nve")
    return LammpsCommands(_before(packing, room, dt, shift), lines, shift)


def pair_commands(packing: Packing, law: Law) -> tuple[str, str]:
    """Return pair_style and pair_coeff."""
    one_mass = bool(np.all(packing.mass == packing.mass[:1]))
    if law.pair_damping == 0.0 or (one_mass and not law.hertz):
        reduced = 0.5 * float(packing.mass[0]) if packing.mass.size else 1.0
        gamma = law.pair_damping * math.sqrt(law.pair_stiffness / reduced) if not law.hertz else 0.0
        style = "hertz" if law.hertz else "hooke"
        numbers = (law.pair_stiffness, law.pair_shear, gamma, law.shear_damping * gamma)
        words = " ".join(map(_text, (*numbers, law.pair_friction)))
        return f"pair_style gran/{style}/history {words} 1 limit_damping", "pair_coeff * *"
    model = _model(law, law.pair_stiffness, law.pair_shear, law.pair_damping, law.pair_friction)
    return "pair_style granular", f"pair_coeff * * {model}"


def wall_command(law: Law) -> str:
    """Return the contact of a wall, as `fix wall/gran` reads it."""
    model = _model(law, law.wall_stiffness, law.wall_shear, law.wall_damping, law.wall_friction)
    return f"wall/gran granular {model}"


def _text(number: float) -> str:
    """Return a number with all its digits."""
    return repr(float(number))


def _model(law: Law, stiffness: float, shear: float, damping: float, friction: float) -> str:
    """Return a modular contact whose dashpot is ours: damping x sqrt(stiffness x mass)."""
    # LAMMPS computes the dashpot from a restitution of contacts that may pull.
    ratio = damping / (math.sqrt(5.0) if law.hertz else 2.0)
    restitution = math.exp(-math.pi * ratio / math.sqrt(1.0 - ratio * ratio))
    normal = "hertz" if law.hertz else "hooke"
    # Not `..._classic`: they forget the spring (linear), or its stretch at every slip (Hertz).
    tangential = "mindlin" if law.hertz else "linear_history"
    return (
        f"{normal} {_text(stiffness)} {_text(restitution)} damping coeff_restitution "
        f"tangential {tangential} {_text(shear)} {_text(law.shear_damping)} {_text(friction)} limit_damping"
    )


def _before(packing: Packing, room: Room, dt: float, shift: np.ndarray) -> tuple[str, ...]:
    radius = packing.radius
    margin = MARGIN * float(radius.max(initial=0.0))
    top = max(room.height, float(packing.place[:, 2].max(initial=0.0)))
    width = room.pitch * (room.cavities - 1) + room.width
    ends = [
        (low + by - margin, high + by + margin)
        for low, high, by in zip((0.0,) * 3, (room.length, width, top), shift, strict=True)
    ]
    sides = " ".join(f"{_text(low)} {_text(high)}" for low, high in ends)
    return (
        "units si",
        "atom_style sphere",
        f"boundary f f {'f' if room.lid else 'fm'}",
        "newton off",
        "comm_modify vel yes",
        f"region room block {sides}",
        f"create_box {room.cavities} room",
        f"neighbor {_text(2.0 * SKIN * float(radius.min(initial=1.0)))} bin",
        "neigh_modify delay 0 every 1 check yes",
        f"timestep {_text(dt)}",
    )


def _after(packing: Packing, law: Law, room: Room, file: str, mover: str) -> tuple[str, ...]:
    wall = wall_command(law)
    weight = (room.gravity_x, room.gravity_y, room.gravity_z)
    size = math.sqrt(sum(part * part for part in weight))
    towards = " ".join("1" if k == room.axis else "0" for k in range(3))
    lines = [*pair_commands(packing, law), f"fix move all {mover}"]
    if size > 0.0:
        direction = " ".join(_text(part / size) for part in weight)
        lines.append(f"fix weight all gravity {_text(size)} vector {direction}")
    lines += [
        "variable kick vector [0]",
        "variable at equal 1",
        "variable push equal -v_kick[v_at]",
        f"fix box all gravity v_push vector {towards}",
        f"fix floor all {wall} zplane 0.0 {_text(room.height)}"
        if room.lid
        else f"fix floor all {wall} zplane 0.0 NULL",
    ]
    if room.cylinder:
        lines.append(f"fix shell all {wall} zcylinder {_text(0.5 * room.length)}")
    else:
        lines.append(f"fix ends all {wall} xplane 0.0 {_text(room.length)}")
        for k in range(room.cavities):
            low = room.pitch * k
            lines.append(f"group cavity{k} type {k + 1}")
            lines.append(
                f"fix sides{k} cavity{k} {wall} yplane {_text(low)} {_text(low + room.width)}"
            )
    along = "xyz"[room.axis]
    lines += [
        f"compute force all reduce sum f{along}",
        f'fix force all ave/time 1 1 1 c_force file "{file}" format " %.17g"',
    ]
    return tuple(lines)


def _refuse(law: Law, room: Room) -> None:
    wrong = []
    if law.pair_rolling > 0.0 or law.wall_rolling > 0.0:
        wrong.append("rolling friction")
    if max(law.pair_damping, law.wall_damping) >= (math.sqrt(5.0) if law.hertz else 2.0):
        wrong.append("overdamped contacts")
    if room.cylinder and room.cavities > 1:
        wrong.append(f"{room.cavities} cylinders")
    if room.cylinder and law.hertz:
        wrong.append("Hertz contacts in a cylinder")
    if room.cavities > MOST_CAVITIES:
        wrong.append(f"more than {MOST_CAVITIES} cavities")
    if wrong:
        raise InputError(*(refusal(f"lammps with {what}") for what in wrong))


def refusal(found: str) -> Mistake:
    """Return what to say where LAMMPS cannot be taken. found : a phrase"""
    return Mistake("scene.grains_bed.engine", "", found, "own", "write 'engine: own'")
