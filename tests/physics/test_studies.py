"""The paper's Figs. 5 to 8 as numbers, and their files."""

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analysis.report.figures.studies import write_study
from rig.theory.paper.studies import STUDIES, study
from rig.theory.paper.totals import collision_energy, measured_energy, total_energy


@pytest.fixture(scope="module")
def studies() -> dict[str, dict[str, Any]]:
    return {name: study(name) for name in STUDIES}


def panel(studies: dict[str, dict[str, Any]], name: str) -> dict[str, Any]:
    return next(p for s in studies.values() for p in s["panels"] if p["name"] == name)


def curves(shown: dict[str, Any]) -> np.ndarray:
    return np.array([curve["values"] for curve in shown["curves"]])


def verdicts(studies: dict[str, dict[str, Any]], name: str, words: str) -> list[bool]:
    return [row["holds"] for row in studies[name]["rows"] if words in row["subject"]]


def test_they_are_plain_numbers(studies: dict[str, dict[str, Any]]) -> None:
    text = json.dumps(studies, allow_nan=False)
    assert json.loads(text) == studies
    for found in studies.values():
        for shown in found["panels"]:
            assert all(len(c["values"]) == len(shown["x"]["values"]) for c in shown["curves"])


def test_stress_over_depth_and_aspect_ratio(studies: dict[str, dict[str, Any]]) -> None:
    """Fig. 5: rises with L1/L2 at kept width, falls at kept base area; 4752 Pa is 99 % reached in
    no tested box.
    """
    width, area = (
        curves(panel(studies, "fig5_fixed_width"))[:-1],
        curves(panel(studies, "fig5_fixed_area")),
    )
    assert (np.diff(width[:, 1:], axis=0) > 0).all()
    assert (np.diff(area[:, 1:], axis=0) < 0).all()
    assert verdicts(studies, "friction", "stress rises with L1/L2") == [True, False]
    assert not any(verdicts(studies, "friction", "1.35 m"))
    assert curves(panel(studies, "fig5_fixed_width"))[-1].max() < 1930.0


def test_stress_over_depth_and_fill(studies: dict[str, dict[str, Any]]) -> None:
    """Fig. 6 holds from the lid only; more fill does not weaken eq 5."""
    assert (np.diff(curves(panel(studies, "fig6_fill")), axis=0) >= 0).all()
    assert verdicts(studies, "friction", "same depth rises with fill") == [True, False]
    assert verdicts(studies, "friction", "weakens") == [False]


def test_velocity_along_the_chain(studies: dict[str, dict[str, Any]]) -> None:
    """Fig. 7: .0596, .1452, .3153, .6264 at the seventh grain."""
    np.testing.assert_allclose(
        curves(panel(studies, "fig7_velocity"))[:, 6], [0.0596, 0.1452, 0.3153, 0.6264], atol=5e-5
    )


def test_collision_energy_over_restitution(studies: dict[str, dict[str, Any]]) -> None:
    """Fig. 8: falls with e for two grains only; for seven it peaks near 0.55; struck by a wall it
    rises.
    """
    given = panel(studies, "fig8_given_speed")
    e = np.array(given["x"]["values"])
    two, seven, *_ = curves(given)
    assert (np.diff(two) < 0).all()
    assert e[np.argmax(seven)] == pytest.approx(0.55, abs=0.03)
    # notes 1.5: .383 .411 .407 .292 m v1^2 for 7 grains, .60 .88 1.23 1.64 m V^2 for 85
    at = [25, 45, 65, 85]
    np.testing.assert_allclose(seven[at], [0.383, 0.411, 0.407, 0.292], atol=6e-4)
    np.testing.assert_allclose(
        curves(panel(studies, "fig8_driven"))[3][at], [0.60, 0.88, 1.23, 1.64], atol=6e-3
    )
    assert verdicts(studies, "collision", "falls as e rises") == [True, False, False]


def test_collision_energy_is_quadratic_in_velocity(studies: dict[str, dict[str, Any]]) -> None:
    shown = panel(studies, "fig8_energy")
    V = np.array(shown["x"]["values"])
    for curve in curves(shown):
        np.testing.assert_allclose(curve, curve[-1] * (V / V[-1]) ** 2, rtol=1e-12)


def test_all_hits_lose_everything_where_the_row_collapses(
    studies: dict[str, dict[str, Any]],
) -> None:
    """n (1 - e) > pi: all but a few per cent whatever e; at e = 1 the wall's 1 - e0^2 alone."""
    shown = panel(studies, "fig8_all_hits")
    e, (two, seven, long) = np.array(shown["x"]["values"]), curves(shown)
    assert (np.diff(two) < 0).all()
    assert (seven[7 * (1 - e) > np.pi] > 0.999).all()
    assert (long[37 * (1 - e) > np.pi] > 0.95).all()
    np.testing.assert_allclose([two[-1], seven[-1], long[-1]], 1 - 0.75**2, rtol=1e-12)


def test_files_of_a_study(studies: dict[str, dict[str, Any]], tmp_path: Path) -> None:
    """SVG, PNG and CSV of each panel; two calls, equal bytes; the CSV gives the numbers back
    exactly.
    """
    first, second = (write_study(studies["collision"], tmp_path / name) for name in ("a", "b"))
    assert len(first) == 1 + 3 * len(studies["collision"]["panels"])
    assert [p.read_bytes() for p in first] == [p.read_bytes() for p in second]
    with (tmp_path / "a" / "fig7_velocity.csv").open(encoding="utf-8", newline="") as text:
        head, *lines = csv.reader(text)
    shown = panel(studies, "fig7_velocity")
    assert head == [
        "grain",
        "v_n/v_1; e 0.25",
        "v_n/v_1; e 0.45",
        "v_n/v_1; e 0.65",
        "v_n/v_1; e 0.85",
    ]
    assert (curves(shown) == np.array(lines, dtype=float)[:, 1:].T).all()
    with (tmp_path / "a" / "collision.csv").open(encoding="utf-8", newline="") as text:
        assert {line["holds"] for line in csv.DictReader(text)} == {"yes", "no"}
    assert (tmp_path / "a" / "fig7_velocity.png").read_bytes().startswith(b"\x89PNG")
    assert "does not hold" in (tmp_path / "a" / "fig7_velocity.svg").read_text(encoding="utf-8")


def test_totals() -> None:
    """Eqs 23, 24, 25."""
    assert collision_energy([1.0, 0.5, 0.25]) == 1.75
    assert collision_energy([]) == 0.0
    assert total_energy(1.0, 2.0) == 3.0
    assert measured_energy(5.0, 2.0) == 3.0
