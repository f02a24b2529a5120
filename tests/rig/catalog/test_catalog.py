"""The catalog: every number has an origin, names give the nearest, rig files are strict and survive
a round trip.
"""

import dataclasses
import math
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from daq.chain.channel import LISTED_RATES
from rig.catalog.entries import STATUSES, Exciter, Rig
from rig.catalog.entries_by_name import analyzer, exciter, material, names, transducer
from rig.catalog.rig_file import RANGES, dump_rig, load_rig, rig_with_losses
from rig.catalog.stated_values import stated_fields
from rig.catalog.table import listing
from rig.errors import InputError
from rig.units import SMALLEST


def mistakes_of(text: str, tmp_path: Path) -> list[str]:
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        load_rig(path)
    return str(caught.value).replace(f"{tmp_path}/", "").splitlines()


def test_every_number_has_an_origin() -> None:
    rows = listing()
    assert {row.kind for row in rows} == {"material", "exciter", "transducer", "analyzer", "rig"}
    assert all(row.status in STATUSES and row.source for row in rows)
    assert all(value.status in STATUSES and value.source for value in load_rig().values)


def test_the_default_rig_states_every_number_it_holds() -> None:
    rig = load_rig()
    wanted = {
        *stated_fields(Rig),
        *(f"ranges.{key}" for key in RANGES),
        *(f"exciter.{key}" for key in stated_fields(Exciter)),
    }
    assert {value.path for value in rig.values} == wanted
    for value in rig.values:
        owner, _, name = value.path.rpartition(".")
        holder = getattr(rig, owner) if owner else rig
        assert value.value == (holder[name] if owner == "ranges" else getattr(holder, name))


def test_the_file_of_the_default_rig_and_the_defaults_of_the_class_agree() -> None:
    rig = load_rig()
    bare = Rig(name="clean", exciter=exciter("JZ-30"))
    for item in dataclasses.fields(Rig):
        if item.name != "values":
            assert getattr(rig, item.name) == getattr(bare, item.name), item.name


@pytest.mark.parametrize(
    ("name", "density"), [("alumina", 3400.0), ("stainless", 7900.0), ("heavy", 18400.0)]
)
def test_densities_of_the_paper(name: str, density: float) -> None:
    assert material(name).density == density


def test_the_heavy_material_keeps_the_papers_label_in_words() -> None:
    assert "tungsten carbide" in material("heavy").label
    assert "heavy alloy" in material("heavy").label


@pytest.mark.parametrize("name", names("exciter"))
def test_derived_exciter_figures(name: str) -> None:
    """A steel rod of 3 mm x 150 mm: EA/L and the fixed-fixed Euler load pi^2 E I / (L/2)^2; E = 206
    GPa, to 3 %.
    """
    unit = exciter(name)
    youngs, radius, length = 206e9, 1.5e-3, 0.15
    assert unit.stinger_stiffness == pytest.approx(youngs * math.pi * radius**2 / length, rel=0.03)
    buckling = math.pi**2 * youngs * math.pi * radius**4 / 4 / (length / 2) ** 2
    assert unit.stinger_buckling == pytest.approx(buckling, rel=0.03)
    assert math.sqrt(unit.isolation_stiffness / unit.body_mass) / (2 * math.pi) == pytest.approx(
        5, rel=0.01
    )


def test_the_exciter_can_give_its_rated_force() -> None:
    for name in names("exciter"):
        unit = exciter(name)
        assert unit.force_constant * unit.current_peak == pytest.approx(unit.force_peak, rel=0.01)


def test_transducers_in_si() -> None:
    gauge, pickup = transducer("208C03", "force"), transducer("352C33", "acceleration")
    assert (gauge.sensitivity, gauge.unit, gauge.time_constant) == (0.002248, "N", 2000.0)
    assert pickup.sensitivity == pytest.approx(0.1 / 9.80665, rel=1e-15)
    assert pickup.full_scale == pytest.approx(50 * 9.80665, rel=1e-15)
    assert transducer("dc-accelerometer", "acceleration").time_constant is None
    assert {transducer(f"288D01-{half}", half).model for half in ("force", "acceleration")}  # type: ignore[arg-type]
    assert gauge.statuses["sensitivity"] == "recalled"
    assert transducer("208C03") == gauge
    assert transducer("ideal", "force").calibration_U == 0


def test_analyzer_rates() -> None:
    spec = analyzer("INV-3118")
    assert spec.rates == LISTED_RATES
    assert spec.rate_for(20.0, 500) == 10240.0
    assert (spec.bits, spec.oversampling, spec.noise_rms, spec.clock_ppm) == (24, 8, 50e-6, 50.0)
    assert analyzer("ideal").noise_rms == 0


@pytest.mark.parametrize(
    ("call", "hint"),
    [
        (lambda: material("stainles"), "did you mean 'stainless'?"),
        (lambda: exciter("JZ30"), "did you mean 'JZ-30'?"),
        (lambda: transducer("208C3", "force"), "did you mean '208C03'?"),
        (lambda: analyzer("INV3118"), "did you mean 'INV-3118'?"),
        (lambda: load_rig("papr"), "did you mean 'paper'?"),
    ],
)
def test_unknown_names_give_the_nearest(call, hint: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(InputError) as caught:
        call()
    assert hint in str(caught.value)


def test_a_gauge_in_the_place_of_an_accelerometer() -> None:
    with pytest.raises(InputError, match="which measures force; allowed: ideal, 352C33"):
        transducer("208C03", "acceleration")


def test_a_rig_file_may_change_a_few_values(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(
        "schema: rig/rig/1\nname: mine\ngauge_mass: 30 g\nranges: {force: 1 V}\n"
        "exciter: {preset: 2100E11, stroke: {value: 10, unit: mm, status: sourced, source: measured}}\n"
    )
    rig, default = load_rig(str(path)), load_rig()
    assert (rig.name, rig.gauge_mass, rig.ranges["force"], rig.exciter.stroke) == (
        "mine",
        0.03,
        1.0,
        0.01,
    )
    assert rig.ranges["acceleration"] == default.ranges["acceleration"]
    assert rig.wall_friction == default.wall_friction
    assert rig.exciter == dataclasses.replace(exciter("2100E11"), stroke=0.01)
    origins = {value.path: (value.status, value.source) for value in rig.values}
    assert origins["gauge_mass"] == ("assumed", "given in the rig file")
    assert origins["exciter.stroke"] == ("sourced", "measured")
    path.write_text(dump_rig(rig))
    assert load_rig(path) == rig


def test_dump_of_the_default_rig(tmp_path: Path) -> None:
    path = tmp_path / "copy.yaml"
    path.write_text(dump_rig(load_rig()))
    assert load_rig(path) == load_rig()
    assert dump_rig(load_rig(path)) == path.read_text()


@settings(deadline=None)
@given(
    noise=st.just(0.0) | st.floats(SMALLEST, 1e6),
    air=st.just(0.0) | st.floats(SMALLEST, 1e6),
    note=st.dictionaries(
        st.text(min_size=1, max_size=20), st.floats(-1e9, 1e9) | st.text() | st.lists(st.integers())
    ),
)
def test_identified_losses_survive_the_file(
    tmp_path_factory: pytest.TempPathFactory, noise: float, air: float, note: dict[str, object]
) -> None:
    path = tmp_path_factory.mktemp("rig") / "calibrated.yaml"
    rig = rig_with_losses(load_rig(), noise, air, {"ratio": 1.07, "found": note})
    path.write_text(dump_rig(rig), encoding="utf-8")
    again = load_rig(path)
    assert again == rig
    assert (again.loss_noise, again.loss_air, again.provenance["ratio"]) == (noise, air, 1.07)
    assert {v.status for v in again.values if v.path in ("loss_noise", "loss_air")} == {"computed"}


def test_every_mistake_of_a_rig_file_at_once(tmp_path: Path) -> None:
    found = mistakes_of(
        "schema: rig/rig/2\n"
        "gauge_mas: 20 g\n"
        "gravity: -9.8 m/s^2\n"
        "wall_density: {value: 7.85, unit: kg/m, status: sourced, source: x}\n"
        "grain_friction: {value: 0.2, status: guessed}\n"
        "restitution_wall: {value: 0.7}\n"
        "packing_loose: 0.7\n"
        "ranges: {forse: 10 V}\n"
        "exciter: JZ-3\n",
        tmp_path,
    )
    assert [line.split(": found")[0] for line in found] == [
        "mine.yaml:1: schema",
        "mine.yaml:2: gauge_mas",
        "mine.yaml:3: gravity",
        "mine.yaml:4: wall_density.unit",
        "mine.yaml:5: grain_friction.status",
        "mine.yaml:6: restitution_wall",
        "mine.yaml:7: packing_loose",
        "mine.yaml:8: ranges.forse",
        "mine.yaml:9: exciter",
    ]
    assert any("did you mean 'gauge_mass'?" in line for line in found)
    assert any("did you mean 'JZ-30'?" in line for line in found)


def test_loose_packing_denser_than_shaken_is_refused(tmp_path: Path) -> None:
    (line,) = mistakes_of("schema: rig/rig/1\npacking_loose: 0.7\n", tmp_path)
    assert line.startswith("mine.yaml:2: packing_loose: found 0.7; allowed: at most packing_shaken")


@pytest.mark.parametrize(
    "text", ["", "[1]", "schema: rig/rig/1\nexciter: [a]", "schema: rig/rig/1\nprovenance: 3"]
)
def test_what_is_no_rig_file(text: str, tmp_path: Path) -> None:
    assert mistakes_of(text, tmp_path)
