"""The paper's parametric figures (5 to 8) as plain numbers, each with the paper's statement and
whether it holds.

A study is a dict {"study", "panels", "rows"}. A panel: {"name", "title", "paper", "x", "y",
"legend", "curves", "marks"}; x: {"label", "unit", "values"}; y: {"label", "unit"}; a curve:
{"label", "values"}; a mark: {"label", "x", "y", "holds"}. Rows: see
`rig.theory.paper.erratum.Erratum`, here one per sentence of the paper. SI units.
"""

from collections.abc import Callable
from dataclasses import asdict
from typing import Any

import numpy as np

from rig.theory.chain import (
    chain_collision,
    chain_velocities,
    first_grain_velocity,
    first_wave_loss,
    wall_loss,
)
from rig.theory.friction import janssen_length, janssen_stress
from rig.theory.paper.errata import Array, errata
from rig.theory.paper.sentences import (
    BASE,
    CAVITY,
    DENSITY,
    GRAVITY,
    JANSSEN,
    QUOTED_DEPTH,
    QUOTED_GRAIN,
    QUOTED_SHARE,
    QUOTED_STRESS,
    RESTITUTIONS,
    WALL,
    collision_claims,
    friction_claims,
)

__all__ = ["STUDIES", "collision_study", "errata", "errata_study", "friction_study", "study"]

Study = dict[str, Any]

ASPECTS = (1.0, 1.5, 2.0, 3.0, 4.0)
FILLS = (0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 1.0)
LAYER_MASS = 0.6 * 7900.0 * 0.15 * 0.34 * 0.004
"""Mass of the first layer of grains at the struck wall, kg: rho_b L2 w H d of the tested box,
steel, 4 mm, 85 %.
"""

FILE = 37
"""Number of 4 mm grains along 150 mm."""

FOLLOWED = 7
"""Largest number of grains for which a collapse is followed hit by hit (some 10^4 of them); longer
ones are ended by a contact duration.
"""


def study(name: str) -> Study:
    """Return a study by name: friction, collision or errata."""
    return STUDIES[name]()


def friction_study() -> Study:
    """Return stress over depth and aspect ratio (Fig. 5), over depth and fill (Fig. 6), and the
    sentences on eq 3.
    """
    depth = np.linspace(0.0, 1.5, 151)
    fixed_width = [(f"{a:g}", _stress(depth, a * BASE, BASE)) for a in ASPECTS]
    fixed_width.append(("tested box", _stress(depth, CAVITY[0], CAVITY[1])))
    fixed_area = [(f"{a:g}", _stress(depth, BASE * a**0.5, BASE / a**0.5)) for a in ASPECTS]
    quoted = {
        "label": f"paper: {QUOTED_STRESS:g} Pa at {QUOTED_DEPTH} m",
        "x": QUOTED_DEPTH,
        "y": QUOTED_STRESS,
        "holds": False,
    }
    height = CAVITY[2]
    below_lid = np.linspace(0.0, height, 81)
    filled = [
        (f"{w:g}", _stress(np.maximum(0.0, below_lid - (1.0 - w) * height), *CAVITY[:2]))
        for w in FILLS
    ]
    legend = "L1/L2"
    stress = {"label": "vertical stress", "unit": "Pa"}
    panels = [
        _panel("fig5_fixed_width", "Fig. 5", f"Stress over depth, width L2 = {BASE:.3g} m kept",
               ("depth", "m", depth), stress, legend, fixed_width, [quoted]),
        _panel("fig5_fixed_area", "Fig. 5", f"Stress over depth, base area {BASE**2:.3g} m² kept",
               ("depth", "m", depth), stress, legend, fixed_area, [quoted]),
        _panel("fig6_fill", "Fig. 6", "Stress over depth below the lid, tested box",
               ("depth below the lid", "m", below_lid), stress, "fill", filled, []),
    ]  # fmt: skip
    return {
        "study": "friction",
        "panels": panels,
        "rows": [asdict(row) for row in friction_claims()],
    }


def collision_study() -> Study:
    """Return velocity along the chain (Fig. 7), collision energy (Fig. 8), and the loss in all hits
    until separation.
    """
    number = np.arange(1.0, 21.0)
    decay = [(f"{e:g}", chain_velocities(np.ones(20), e, 1.0)) for e in RESTITUTIONS]
    quoted = {
        "label": "paper: 6 % at the 7th, e < 0.65",
        "x": float(QUOTED_GRAIN),
        "y": QUOTED_SHARE,
        "holds": False,
    }
    speed = np.linspace(0.0, 1.0, 51)
    energy = [(f"{e:g}", np.array([_wall_and_wave(e, V) for V in speed])) for e in RESTITUTIONS]
    e_axis = np.linspace(0.0, 1.0, 101)
    lengths = (2, 7, FILE, 85)
    given = [(str(n), _over_restitution(e_axis, n, lambda _: 1.0)) for n in lengths]
    driven = [
        (str(n), _over_restitution(e_axis, n, lambda e: first_grain_velocity(1.0, e)))
        for n in lengths
    ]
    coarse = np.linspace(0.5, 1.0, 51)
    whole = [(str(n), np.array([_whole_loss(n, float(e)) for e in coarse])) for n in (2, 7, FILE)]
    restitution = ("restitution e", "", e_axis)
    share = {"label": "loss of the first wave", "unit": "m v1²"}
    share_driven = {"label": "loss of the first wave", "unit": "m V²"}
    panels = [
        _panel(
            "fig7_velocity",
            "Fig. 7",
            "Velocity along the chain, first wave",
            ("grain", "", number),
            {"label": "v_n/v_1", "unit": ""},
            "e",
            decay,
            [quoted],
        ),
        _panel(
            "fig8_energy",
            "Fig. 8",
            f"First wave and wall hit, {FILE} layers of {LAYER_MASS:.2f} kg, e0 = e",
            ("velocity of the wall", "m/s", speed),
            {"label": "W_c, one wall", "unit": "J"},
            "e",
            energy,
            [],
        ),
        _panel(
            "fig8_given_speed",
            "Fig. 8",
            "First wave, speed of the first grain given",
            restitution,
            share,
            "grains",
            given,
            [],
        ),
        _panel(
            "fig8_driven",
            "Fig. 8",
            "First wave, struck by a wall of speed V, e0 = e",
            restitution,
            share_driven,
            "grains",
            driven,
            [],
        ),
        _panel(
            "fig8_all_hits",
            "not in the paper",
            "All hits until separation, thrown onto a wall, e0 = 0.75",
            ("restitution e", "", coarse),
            {"label": "share of the energy lost", "unit": ""},
            "grains",
            whole,
            [],
        ),
    ]
    return {
        "study": "collision",
        "panels": panels,
        "rows": [asdict(row) for row in collision_claims()],
    }


def errata_study() -> Study:
    """Return every erratum of equations and text with its numbers; no panels."""
    return {"study": "errata", "panels": [], "rows": [asdict(row) for row in errata()]}


STUDIES: dict[str, Callable[[], Study]] = {
    "friction": friction_study,
    "collision": collision_study,
    "errata": errata_study,
}


def _stress(depth: Array, length: float, width: float) -> Array:
    return janssen_stress(depth, DENSITY, GRAVITY, janssen_length(length, width, WALL, JANSSEN))


def _wall_and_wave(e: float, speed: float) -> float:
    """Return the loss at one struck wall, J, with e0 = e."""
    wave = first_wave_loss(np.full(FILE, LAYER_MASS), e, first_grain_velocity(speed, e))
    return wave + wall_loss(LAYER_MASS, e, speed)


def _over_restitution(e_axis: Array, grains: int, first: Callable[[float], float]) -> Array:
    return np.array([first_wave_loss(np.ones(grains), float(e), first(float(e))) for e in e_axis])


def _whole_loss(grains: int, e: float) -> float:
    """Return the fraction of the energy that a row of unit grains, thrown onto a wall of e0 = 0.75,
    loses in all its hits.
    """
    after = chain_collision(
        np.ones(grains),
        e,
        -1.0,
        restitution_wall=0.75,
        contact_time=0.0 if grains <= FOLLOWED else 1e-4,
    )
    return (after.loss + after.wall_loss) / (0.5 * grains)


def _panel(
    name: str,
    paper: str,
    title: str,
    x: tuple[str, str, Array],
    y: dict[str, str],
    legend: str,
    curves: list[tuple[str, Array]],
    marks: list[dict[str, Any]],
) -> dict[str, Any]:
    return {
        "name": name, "paper": paper, "title": title, "legend": legend, "y": y, "marks": marks,
        "x": {"label": x[0], "unit": x[1], "values": x[2].tolist()},
        "curves": [{"label": label, "values": values.tolist()} for label, values in curves],
    }  # fmt: skip
