"""The prediction that a protocol names, its default for each bed, and those that stand beside it."""

import math
from dataclasses import replace

import pytest

from rig.catalog.entries import Rig
from rig.errors import InputError
from rig.prediction import own
from rig.prediction.model import SINGLE_MASS_FOR_GRAINS, predict, predict_about
from rig.protocol.grid import conditions
from rig.protocol.load import load_protocol
from rig.protocol.spec import Acquire, Cavity, Condition, Drive, Grains, Scene
from rig.theory.single_mass import thrown_height

G = 9.80665
SMALL = Scene(
    cavity=Cavity(0.1, 0.025, 0.05), grains=Grains("stainless", 0.005, 0.85, 7900.0), losses=()
)
TALL = replace(SMALL, cavity=Cavity(0.04, 0.04, 0.1), axis="vertical", bed="grains")
MASS = 0.63 * 7900.0 * 0.1 * 0.025 * 0.05 * 0.85


def condition(scene: Scene, level: float, name: str | None = None) -> Condition:
    """A condition at a level in g."""
    drive = Drive(frequency=20.0, acceleration=level * G)
    return Condition("c", scene, drive, Acquire(), "", name)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("bed", "level", "name", "shares"),
    [
        ("layers", 1.0, "layers", True),
        ("column", 1.0, "own", True),
        ("single_mass", 1.0, "own", True),
        ("empty", 1.0, "own", True),
        ("locked", 1.0, "own", True),
        ("grains", 1.0, "column", False),
        ("grains", 0.3, "band", False),
    ],
)
def test_defaults(rig: Rig, bed: str, level: float, name: str, shares: bool) -> None:
    found = predict(condition(replace(SMALL, bed=bed), level), rig)
    assert (found.prediction, found.shares_mechanism) == (name, shares)
    assert (found.W_T is None) == (name == "band")


@pytest.mark.parametrize("bed", ["layers", "column", "grains"])
@pytest.mark.parametrize("name", ["layers", "column", "as_printed"])
def test_the_same_three_stand_beside_every_bed_of_grains(rig: Rig, bed: str, name: str) -> None:
    """They know the scene and not the bed; the headline is the one that is named."""
    found = predict(condition(replace(SMALL, bed=bed), 1.0, name), rig)
    alone = predict(condition(replace(SMALL, bed="layers"), 1.0), rig)
    for key in ("W_T_as_printed", "W_T_layers", "W_T_column"):
        assert getattr(found, key) == getattr(alone, key)
    assert getattr(alone, f"W_T_{name}") == found.W_T
    assert found.reasons == {}
    assert found.shares_mechanism == (bed == name == "layers")
    # U of the column: k = 2 of ln 1.3/1.645 above 0.7 g
    assert found.U_W_T_column == pytest.approx(2 * math.log(1.3) / 1.645 * found.W_T_column)


def test_what_is_not_stated_says_why_and_is_no_number(rig: Rig) -> None:
    found = predict(condition(SMALL, 0.3, "column"), rig)
    assert (found.W_T, found.W_T_column, found.U_W_T_column) == (None, None, None)
    assert "level" in found.reasons["W_T_column"]
    assert found.reasons["W_T"] == found.reasons["W_T_column"]
    other = predict(condition(SMALL, 1.0), replace(rig, grain_friction=0.4))
    assert "mu_p" in other.reasons["W_T_column"]
    upright = predict(condition(TALL, 2.0), rig)
    assert {"W_T_as_printed", "W_T_layers", "W_T_column"} <= upright.reasons.keys()
    assert all("vertical" in why for key, why in upright.reasons.items() if key != "W_T")


def test_an_empty_box_has_a_column_of_nothing(rig: Rig) -> None:
    bare = replace(SMALL, grains=replace(SMALL.grains, fill=0.0))
    found = predict(condition(bare, 0.3, "column"), rig)
    assert (found.W_T, found.W_T_column, found.reasons) == (0.0, 0.0, {})


@pytest.mark.parametrize("level", [0.8, 2.0, 3.2])
def test_vertical_grains_fly_as_one_mass_up_to_3_3_g(rig: Rig, level: float) -> None:
    found = predict(condition(TALL, level), rig)
    one = predict(condition(replace(TALL, bed="single_mass"), level), rig)
    assert (found.prediction, found.W_T) == ("own", one.W_T)
    assert (found.u_stated, found.shares_mechanism) == (SINGLE_MASS_FOR_GRAINS, False)


@pytest.mark.parametrize(("fill", "lid"), [(0.3, False), (0.95, True)])
def test_above_it_a_band_up_to_the_bound_that_holds(rig: Rig, fill: float, lid: bool) -> None:
    """m g V/f where no grain reaches the lid, 4 m V^2 else. The engine's own case at 6 g and 0.95
    (0.1173 J/kg at 30 Hz) lies above the first and below the second.
    """
    scene = replace(TALL, grains=replace(TALL.grains, fill=fill))
    drive = Drive(frequency=30.0, acceleration=6.0 * G)
    found = predict(Condition("c", scene, drive, Acquire(), ""), rig)
    V = 6.0 * G / (60.0 * math.pi)
    assert ((1 - fill) * 0.1 < thrown_height(V, 30.0, rig.gravity)) == lid
    known = 4.0 * V**2 if lid else G * V / 30.0
    assert found.prediction == "band"
    assert (found.W_T, found.W_T_low) == (None, 0.0)
    assert found.W_T_high == pytest.approx(known * found.bed_mass, rel=1e-12)
    if lid:
        assert G * V / 30.0 < 0.1173 < known


def test_the_table_holds_every_variant_at_every_level(rig: Rig) -> None:
    point, table = predict_about(condition(replace(SMALL, bed="grains"), 1.0), rig)
    size = len(table["acceleration"])
    assert table["W_T"] == table["variants"]["column"]["W_T"]
    assert table["W_T"][size // 2] == point.W_T
    for name in ("as_printed", "layers", "column"):
        assert len(table["variants"][name]["W_T"]) == size
    assert sorted(table["W_T"]) == table["W_T"]  # rises with the level
    _, band = predict_about(condition(TALL, 4.0), rig)
    assert band["W_T"] is None
    assert len(band["W_T_high"]) == len(band["W_T_low"]) == len(band["acceleration"])
    assert sorted(band["W_T_high"]) == band["W_T_high"]


PROTOCOL = "schema: rig/protocol/1\nname: p\nprediction: {name}\nscene: {{{scene}}}\n"


@pytest.mark.parametrize(
    ("name", "scene", "words"),
    [
        ("column", "bed: single_mass", "own for this bed"),
        ("band", "bed: single_mass", "own for this bed"),
        ("layer", "bed: layers", "did you mean 'layers'"),
    ],
)
def test_a_prediction_that_can_never_be_stated_is_bad_input(
    name: str, scene: str, words: str
) -> None:
    with pytest.raises(InputError, match=words):
        load_protocol(PROTOCOL.format(name=name, scene=scene))


def test_beds_that_cannot_slide_keep_their_own(rig: Rig) -> None:
    protocol = load_protocol(
        PROTOCOL.format(name="column", scene="losses: []")
        + "vary: {scene.bed: [empty, locked, layers]}\ndrive: {acceleration: 1 g}\n"
    )
    found = [predict(each, rig).prediction for each in conditions(protocol)]
    assert found == ["own", "own", "column"]


def test_rows_of_bed_layers_are_followed_once_a_level(monkeypatch, rig):
    """Its own prediction is the layers variant: computing both is work for nothing."""
    followed, whole = [], own.layers_total

    def counted(*arguments, **more):
        followed.append(arguments)
        return whole(*arguments, **more)

    monkeypatch.setattr(own, "layers_total", counted)
    point, _ = predict_about(condition(replace(SMALL, bed="layers"), 0.5), rig)
    assert point.W_T_layers == point.W_T
    assert len(followed) == len(own.LEVELS)
