"""`fidelity: auto` from the protocol to the report: within its tolerance, said where not, resumed,
seeds unmoved.
"""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from small_protocol import IDEAL, Rig

from analysis import Report, write_report
from analysis.report.tables.fidelity import fidelity_sentences
from analysis.session.fidelity import CycleCounts, Fidelity
from daq.session.record import open_session
from daq.session.writer import Recorder
from rig.beds.janssen_stack import nominal, stack
from rig.campaign.campaign import Campaign
from rig.campaign.one_run.assemble import assemble
from rig.campaign.one_run.prescribed_run import stand_of
from rig.campaign.one_run.run_inputs import filling_of, motion_of
from rig.campaign.preflight.outlook import preflight
from rig.campaign.resolve import campaign_of
from rig.campaign.runner import run
from rig.campaign.session_plan import session_plan
from rig.catalog.rig_file import load_rig
from rig.errors import InputError
from rig.fidelity.scene_rows import resolved_rows, side_by_side, with_rows
from rig.prediction.forecast import forecast
from rig.prediction.own import layers_variant
from rig.protocol.load import dump_protocol, load_protocol
from rig.stand.force_peaks import use_of
from rig.stand.prescribed import Stand

TEXT = """\
schema: rig/protocol/1
name: auto
scene: {grains: {material: stainless, diameter: 4 mm, fill: 85 %}, losses: []}
vary:
  zip:
    scene.grains.material: [alumina, stainless, stainless, stainless, stainless, heavy]
    scene.grains.diameter: [4 mm, 4 mm, 7 mm, 1 mm, 4 mm, 4 mm]
    scene.grains.fill: [85 %, 30 %, 85 %, 20 %, 95 %, 85 %]
    drive.acceleration: [2 m/s^2, 5 m/s^2, 6 m/s^2, 4 m/s^2, 3 m/s^2, 3 m/s^2]
repeats: {n: 1, refill: false}
fidelity: auto
tolerance: 1 %
"""
"""Conditions as density, fill_rate and size have them, without losses: what is measured is the
bed's.
"""


def campaign(*sets: str, text: str = TEXT) -> Campaign:
    protocol = load_protocol(text, sets)
    return campaign_of(protocol, load_rig(protocol.rig), text)


def resolved_energies(made: Campaign) -> list[float]:
    """L2/d rows in every layer, settled for 64 cycles, rows without a period averaged over 4096
    more, J per cycle.
    """
    found = []
    for condition in made.conditions:
        scene = with_rows(condition.scene, resolved_rows(condition.scene))
        bed, drive = stack(scene, made.rig, nominal(scene, made.rig)), condition.drive
        found.append(layers_variant(scene, bed, drive.acceleration, drive.frequency, 4096).total)
    return found


@pytest.mark.parametrize("tolerance", [0.05, 0.01, pytest.param(0.001, marks=pytest.mark.slow)])
def test_measured_and_predicted_energy_are_within_the_tolerance(
    tolerance: float, tmp_path: Path
) -> None:
    """No refills, exact waveform, ideal instruments: all that is left is rows, settling and record.

    W_exp may be off by 2e-4 more (arithmetic of the analysis: test_campaign), and what it is
    compared with is averaged.
    """
    made = campaign(f"tolerance={tolerance}", *IDEAL)
    report = run(made, tmp_path, workers=1).document()
    for c, true in zip(report["conditions"], resolved_energies(made), strict=True):
        assert c["W_exp"] == pytest.approx(true, rel=tolerance + 2e-4)
        assert c["W_T"] == pytest.approx(true, rel=tolerance + 2e-4)
    told = report["fidelity"]
    assert told["not_met"] == []
    assert all(row["error"] <= tolerance for row in told["conditions"])
    assert told["cycles"]["auto"] < told["cycles"]["resolved"]
    if tolerance >= 0.01:
        assert told["cycles"]["auto"] < told["cycles"]["written"] == 6 * 50


MIXED = (
    "vary={zip: {scene.grains.material: [alumina, stainless, stainless, stainless, stainless], "
    "scene.grains.fill: [0.85, 0.3, 0.85, 0.95, 0.9], drive.acceleration: [2, 5, 3, 4, 2.5]}}"
)


@pytest.mark.parametrize(
    ("tolerance", "seeds"),
    [
        (0.05, (1, 2)),
        (0.01, (1, 2)),
        pytest.param(0.05, range(3, 13), marks=pytest.mark.slow),
        pytest.param(0.01, range(3, 13), marks=pytest.mark.slow),
    ],
)
def test_the_mean_over_poured_runs_is_within_the_tolerance(
    tolerance: float, seeds: Sequence[int], tmp_path: Path
) -> None:
    """Means of four pourings against the same packings and clearances with L2/d rows, averaged over
    1024 cycles.

    Rows and noise count by two standard deviations, hence one mean in twenty may be beyond, and the
    root of the mean square is below the tolerance in any case. Over the seeds 1 to 12 none of 120
    is beyond (worst 0.91, root of the mean square 0.44 of the tolerance).
    """
    errors = []
    for seed in seeds:
        made = campaign(
            MIXED, "repeats={n: 4, refill: true}", f"seed={seed}", f"tolerance={tolerance}", *IDEAL
        )
        report = run(made, tmp_path / str(seed), workers=1).document()
        for condition, found in zip(made.conditions, report["conditions"], strict=True):
            scene, level = side_by_side(condition.scene), condition.drive.acceleration
            beds = (
                filling_of(made, one, scene)
                for one in made.runs
                if one.condition.id == condition.id
            )
            true = np.mean(
                [
                    layers_variant(scene, stack(scene, made.rig, bed), level, 20.0, 1024).total
                    for bed in beds
                ]
            )
            errors.append((found["W_exp"] / float(true) - 1.0) / tolerance)
    assert np.mean(np.abs(errors) > 1.0) <= 0.05
    assert float(np.sqrt(np.mean(np.square(errors)))) < 0.75


BOUNCE = """\
schema: rig/protocol/1
name: bounce
scene:
  cavity: {length: 40 mm, width: 40 mm, height: 60 mm, wall: 2 mm}
  axis: vertical
  grains: {material: stainless, diameter: 2 mm, fill: 10 %}
  bed: single_mass
  single_mass: {gap: 5 mm}
  losses: []
drive: {frequency: 25 Hz}
acquire: {analyzer: ideal, sensors: {force: ideal, acceleration: ideal}}
vary:
  zip:
    scene.single_mass.restitution: [0, 0.3, 0.6, 0.9, 0.6]
    drive.acceleration: [2 g, 2 g, 2 g, 4 g, 3 g]
repeats: 3
fidelity: auto
tolerance: 2 %
"""
"""One mass between floor and lid: orbits of long and short periods, and one that finds none."""


def test_a_single_mass_is_within_the_tolerance_in_the_waveforms_of_its_runs(tmp_path: Path) -> None:
    """Against the same runs settled for 300 cycles and recorded for 1000. On an exact sine 8 cycles
    would do for the third, whose runs, 0.3 % off, take up to 80 % less then."""
    made = campaign(text=BOUNCE)
    found = run(made, tmp_path / "auto", workers=1).document()
    sets = ("fidelity=as_written", "tolerance=null", "acquire.settle=300", "acquire.record=1000")
    long = run(campaign(*sets, text=BOUNCE), tmp_path / "long", workers=1).document()
    met = [row["met"] for row in found["fidelity"]["conditions"]]
    assert met[:4] == [
        True,
        True,
        True,
        True,
    ]  # the fifth wanders: what is found for it hangs on the last bit
    for one, other, held in zip(found["conditions"], long["conditions"], met, strict=True):
        assert not held or one["W_exp"] == pytest.approx(
            other["W_exp"], rel=0.02 + 2e-3
        )  # 1000 cycles are not all
    (text,) = fidelity_sentences(Report.of(found))
    assert "No rows of grains" in text


def test_the_report_says_in_words_what_was_saved() -> None:
    """Numbers of cycles of the drive, and shares; no counts of rows times cycles, which nobody can
    read.
    """
    fidelity = Fidelity(
        tolerance=0.05,
        rows_share=0.5,
        conditions=(),
        cycles=CycleCounts(888, 8000, 51200),
        not_met=("c03",),
        row_cycles=CycleCounts(1.2e5, 2.9e6, 8.5e7, 7.6e5),
    )
    (text,) = fidelity_sentences(SimpleNamespace(fidelity=fidelity))
    assert (
        "888 cycles of the drive were run; the protocol writes 8000, and fully resolved they would be 51200"
        in text
    )
    assert "4.1 % of the work as written and 0.14 % of the fully resolved" in text
    assert "finding the choice took, once, 6.3 times what was run" in text
    assert "NOT met in c03" in text
    assert fidelity_sentences(SimpleNamespace(fidelity=None)) == ()


def test_peaks_beyond_the_exciter_are_those_of_all_rows(tmp_path: Path) -> None:
    """Two rows hit together at 5 m/s^2: 2.8 to 3.7 times the rating, where 37 rows give 1.1 to 1.6.
    What is told of the run is that of the same filling with all rows, and of the fundamental
    nothing changes."""
    made = campaign(
        "vary={}", "drive.acceleration=5", "repeats={n: 3, refill: true}", "tolerance=5%", *IDEAL
    )
    run(made, tmp_path, workers=1)
    with open_session(tmp_path / "session.h5") as record:
        told = [record.scalars(one.name) for one in made.runs]
    for one, scalars in zip(made.runs, told, strict=True):
        assert one.condition.scene.layers.rows < 8
        stand = stand_of(made, one)
        scene = side_by_side(one.condition.scene)
        full = Stand(
            scene, made.rig, motion_of(made, one), filling_of(made, one, scene), stand.rate
        )
        for each in (stand, full):
            each.read(round(40 * stand.rate / 20.0))
        few, all_rows = use_of(made.rig, stand), use_of(made.rig, full)
        assert few.peak > 1.5 * all_rows.peak
        assert scalars["use_peak"] == pytest.approx(
            all_rows.peak, rel=0.02
        )  # 16 cycles after the start, or 40
        assert scalars["use_buckling"] == pytest.approx(all_rows.buckling, rel=0.02)
        assert scalars["use_force"] == pytest.approx(few.force, rel=0.01)
        assert few.force == pytest.approx(all_rows.force, rel=0.03)


def test_check_states_the_peak_with_all_rows() -> None:
    """As written with 8 rows both numbers are told; under auto that of all rows is the one, as in
    the runs.
    """
    sets = ("vary={}", "drive.acceleration=5")
    written, auto = (
        next(preflight(campaign(*sets, *more), 1))
        for more in (("fidelity=as_written", "tolerance=null"), ())
    )
    assert written.side_by_side is not None
    assert written.exciter.peak > 1.3 * written.side_by_side.peak
    (flag,) = (flag for flag in written.flags if "peak" in flag)
    assert flag.endswith(f"{written.side_by_side.peak:.2f} with as many rows as lie side by side")
    assert auto.side_by_side is None
    assert auto.exciter.peak == pytest.approx(written.side_by_side.peak, rel=1e-9)
    assert not any("buckling" in flag for flag in (*written.beyond, *auto.beyond))


def test_as_written_no_fidelity_is_reported(tmp_path: Path) -> None:
    made = campaign(
        "fidelity=as_written", "tolerance=null", "vary={drive.acceleration: [2, 5]}", *IDEAL
    )
    report = run(made, tmp_path, workers=1).document()
    assert made.choices == {}
    assert "fidelity" not in report
    assert "Fidelity" not in (tmp_path / "report.md").read_text()


POURED = (
    "repeats={n: 2, refill: true}",
    "scene.losses=[noise, air]",
    "vary={drive.acceleration: [2, 5]}",
)


def test_the_choice_moves_no_seed() -> None:
    """The same waveform, packing and clearance as written; only where rows lie in their strata has
    another size.
    """
    auto, written = campaign(*POURED), campaign(*POURED, "fidelity=as_written", "tolerance=null")
    assert {run.condition.scene.layers.rows for run in auto.runs} != {8}
    for one, other in zip(auto.runs, written.runs, strict=True):
        assert one.condition.seed_key == other.condition.seed_key
        assert motion_of(auto, one) == motion_of(written, other)
        a, b = filling_of(auto, one), filling_of(written, other)
        assert (a.packing, a.clearance) == (b.packing, b.clearance)


def test_another_condition_in_the_grid_changes_no_choice() -> None:
    few = campaign(*POURED)
    more = campaign(*POURED[:2], "vary={drive.acceleration: [1, 2, 5]}")
    chosen = {c.drive.acceleration: more.choices[c.id] for c in more.conditions}
    assert [few.choices[c.id] for c in few.conditions] == [chosen[2.0], chosen[5.0]]


def test_a_stopped_session_goes_on_with_what_was_chosen(tmp_path: Path) -> None:
    """Half the runs recorded, then resumed: the same report as in one go; another tolerance is
    refused by name.
    """
    made = campaign(*POURED)
    whole = run(made, tmp_path / "whole", workers=1).document()
    folder = tmp_path / "stopped"
    folder.mkdir()
    first = min(made.runs, key=lambda one: one.order)
    refill = made.protocol.repeats.refill
    ahead = {c.id: forecast(c, made.rig, refill, made.averaged.get(c.id)) for c in made.conditions}
    with Recorder.create(folder / "session.h5", session_plan(made, ahead)) as recorder:
        for part in assemble(made, first):
            recorder.append(first.name, part.block)
            if part.scalars is not None:
                recorder.finish(first.name, part.scalars)
    with pytest.raises(InputError) as caught:
        run(campaign(*POURED, "tolerance=5%"), folder, workers=1, resume=True)
    assert "tolerance: 0.01" in str(caught.value)
    run(campaign(*POURED), folder, workers=1, resume=True)
    with open_session(folder / "session.h5") as record:
        assert record.complete
        document = record.document("protocol")
        assert document is not None
        assert document["fidelity"].splitlines()[0].startswith("c01: ")
        assert record.document("fidelity") == whole["fidelity"]
        assert "fidelity: auto" in document["resolved"]


def test_an_unattainable_tolerance_is_said(tmp_path: Path) -> None:
    """No record of 1024 cycles averages the noise of these instruments down to 1e-6 of W."""
    text = TEXT.replace("refill: false", "refill: true")
    sets = ("vary={drive.acceleration: [3, 5]}", "scene.grains.fill=0.1")
    report = run(campaign("tolerance=1e-6", *sets, text=text), tmp_path, workers=2).document()
    told = report["fidelity"]
    assert told["not_met"] == ["c01", "c02"]
    assert all(row["why"] and row["error"] > 1e-6 for row in told["conditions"])
    (flag,) = (flag for flag in report["flags"] if flag["flag"] == "over_tolerance")
    assert flag["runs"] == ["run_0001", "run_0002"]
    assert flag["worst"] > 1.0
    for name in ("report.md", "report.html"):
        assert "NOT met in c01, c02" in (tmp_path / name).read_text()


def test_beds_without_rows_are_not_simulated(tmp_path: Path) -> None:
    sets = (
        "vary={scene.bed: [empty, locked, dashpot]}",
        "repeats={n: 4, refill: true}",
        "scene.losses=[noise]",
    )
    made = campaign(*sets)
    report = run(made, tmp_path, workers=1).document()
    rows = {
        c["bed"]: row
        for c, row in zip(report["conditions"], report["fidelity"]["conditions"], strict=True)
    }
    assert [row["rows"] for row in rows.values()] == [None, None, None]
    assert all(row["row_cycles"] == dict.fromkeys(row["row_cycles"], 0) for row in rows.values())
    assert rows["empty"]["skipped"][0] == "bed: the box is empty"
    assert rows["locked"]["skipped"][0] == "bed: bonded to the box, carried as mass"
    assert report["fidelity"]["cycles"]["auto"] < report["fidelity"]["cycles"]["written"]
    assert report["verdict"] == "passes"


def test_layers_below_their_threshold_and_ideal_components_are_listed() -> None:
    (choice,) = campaign("vary={}", "drive.acceleration=1", *IDEAL).choices.values()
    said = "; ".join(choice.skipped)
    assert "27 of 85 layers" in said
    assert "analyzer: ideal" in said
    assert "force sensor: ideal" in said


def test_check_and_model_show_the_plan(rig_command: Rig, tmp_path: Path) -> None:
    path = tmp_path / "auto.yaml"
    path.write_text(dump_protocol(load_protocol(TEXT, POURED)))
    plan = json.loads(rig_command("check", path, "--json").stdout)["conditions"]
    model = json.loads(rig_command("model", path, "--json").stdout)["conditions"]
    made = campaign(*POURED)
    assert [row["fidelity"]["rows"] for row in plan] == [c.rows for c in made.choices.values()]
    assert [row["W_T"] for row in plan] == [row["W_T"] for row in model]
    assert "Fidelity auto, tolerance 1 %" in rig_command("check", path).stdout


def test_equal_choices_give_equal_reports(tmp_path: Path) -> None:
    reports: list[Report] = []
    for workers in (1, 2):
        made = replace(campaign(*POURED), text="")
        reports.append(run(made, tmp_path / str(workers), workers=workers))
        write_report(reports[-1], tmp_path / str(workers))
    assert (tmp_path / "1/report.html").read_bytes() == (tmp_path / "2/report.html").read_bytes()
    assert reports[0] == reports[1]
