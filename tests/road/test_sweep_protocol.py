"""A sweep as a user writes it: what it shows is the exciter's frequency response; what does not fit
it is refused.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from analysis import Report
from analysis.energy.sweep import fundamentals, shift
from analysis.report import report_sentences
from analysis.report.figures.sweep import sweep_plot
from rig.beds.janssen_stack import nominal
from rig.campaign.preflight.dry_run import dry_run_coupled
from rig.campaign.resolve import campaign_of
from rig.campaign.runner import run
from rig.catalog.rig_file import load_rig
from rig.cli.commands.check import check_protocol
from rig.drive.electrodynamic import response
from rig.errors import InputError
from rig.protocol.load import load_protocol
from rig.stand.shaker import CoupledStand

SWEEP = """\
schema: rig/protocol/1
name: short
scene: {grains: {material: stainless}, bed: empty, losses: []}
drive: {mode: shaker, control: open, command: 2.5 %, amplifier: voltage, frequency: 9 Hz, sweep_to: 2.5 Hz}
acquire: {analyzer: ideal, samples_per_cycle: 1000, settle: 40 cycles, record: 200 cycles,
          sensors: {force: ideal, acceleration: ideal}}
vary: {scene.bed: [empty, locked]}
repeats: {n: 1, refill: false}
seed: 3
"""


def test_a_cycle_of_a_chirp_has_the_phasor_that_went_in() -> None:
    """Any sampling that resolves it: a harmonic and a mean do not leak in, up to the rectangle
    rule's edges (one sample of a thousand in a cycle)."""
    rate, first, pace, cycles = 9000.0, 4.0, 0.25, 60
    time = np.arange(round(16 * rate)) / rate - 0.7
    turns = (first + 0.5 * pace * time) * time
    wave = 3.0 * np.cos(2 * np.pi * turns + 0.4) + 0.5 * np.cos(4 * np.pi * turns) + 2.0
    sums = fundamentals(wave, time, first, pace, cycles)
    assert sums[0] / sums[1].real == pytest.approx(np.full(cycles, 3.0 * np.exp(0.4j)), abs=2e-2)
    assert (sums[0] / sums[1].real).mean() == pytest.approx(3.0 * np.exp(0.4j), abs=1e-3)


def test_the_shift_of_a_parabola_is_its_curvature() -> None:
    """H = 2 + w^2 over a few points: (b/2) |H''| = b."""
    f = np.linspace(1.0, 2.0, 30)
    curve = (2.0 + (2.0 * np.pi * f) ** 2).astype(np.complex128)
    assert shift(f, curve, 0.1) == pytest.approx(2.0 * np.pi * 0.1 / np.abs(curve).max(), rel=1e-9)
    assert shift(f[:5], curve[:5], 0.1) is None


def test_a_sweep_shows_the_frequency_response(tmp_path: Path) -> None:
    """Through the resonance of the mount, downwards: every point is off the exact response by no
    more than the shift that the sweep states of itself and 0.5 % for what comes after the
    curvature, the apparent mass is right. Not at the end: under the locked bed the box meets its
    own resonance at 2.2 Hz, which the sweep does not see whole."""
    protocol = load_protocol(SWEEP)
    campaign = campaign_of(protocol, load_rig("paper"), SWEEP)
    rig = replace(campaign.rig, exciter=campaign.instruments.exciter)
    report = run(campaign, tmp_path)
    assert report.verdict == "passes"
    assert report.left_out == ()
    assert report.conditions == ()
    _told_truly(report)
    drive = protocol.drive
    for one, condition in zip(report.sweeps, campaign.conditions, strict=True):
        stand = CoupledStand(condition.scene, rig, drive,
                             nominal(condition.scene, rig), 10240.0)  # fmt: skip
        exact = response(stand.plant, "voltage", np.array(one.frequency))
        volts = drive.command * rig.exciter.voltage_peak
        for name in ("force", "acceleration"):
            steady = volts * np.abs(getattr(exact, name))
            off = (
                np.abs(np.array(getattr(one, name)) - steady)[np.array(one.frequency) > 3.0].max()
                / steady.max()
            )
            assert off < getattr(one, f"shift_{name}") + 0.005, (name, condition.scene.bed)
        assert np.median(one.M_eff) == pytest.approx(
            stand.plant.box + stand.bed.mass - stand.bed.bonded, rel=2e-3
        )
        assert one.frequency[0] > 8.9
        assert one.frequency[-1] < 2.6
        assert one.rate == pytest.approx((6.25 - 81.0) / 400.0)


def _told_truly(report: Report) -> None:
    """Sweeps alone: no ideal waveform, no prediction, no verdict on an energy, and a truth that is
    there.
    """
    assert report.waveform == "measured"
    assert {row.why for row in report.comparisons} == {"not made: no run states an energy"}
    assert "empty, locked" in report_sentences.tested(report)
    assert "ideal" not in report_sentences.waveform(report)
    assert "states no energy" in report_sentences.headline(report)
    assert report_sentences.verdict_line(report).startswith("Nothing judged")
    assert not any("truth" in reason or "can be used" in reason for reason in report.reasons)
    drawn = sweep_plot(report)
    assert drawn is not None
    assert all(one.run in str(drawn) for one in report.sweeps)


def test_flags_of_swept_runs_are_reported(tmp_path: Path) -> None:
    """An amplifier that clips fails the session, and the flags say in which runs and how far beyond
    the limit.
    """
    protocol = load_protocol(SWEEP, ["drive.command=95 %", "acquire.record=60 cycles"])
    report = run(campaign_of(protocol, load_rig("paper"), SWEEP), tmp_path)
    assert report.verdict == report_sentences.verdict_line(report).lower() == "fails"
    flags = {row.flag: row for row in report.flags}
    assert {flag for one in report.sweeps for flag in one.flags} == set(flags)
    for name, flag in flags.items():
        assert list(flag.runs) == [one.run for one in report.sweeps if name in one.flags]
    assert flags["clipped"].worst is None
    assert (flags["over_stroke"].worst or 0.0) > 1.0
    assert "clipped" in report_sentences.found(report)[-1]


def test_check_predicts_no_energy_of_a_sweep(capsys: pytest.CaptureFixture[str]) -> None:
    protocol = load_protocol(SWEEP, ["acquire.record=60 cycles"])
    assert (
        check_protocol(campaign_of(protocol, load_rig("paper"), SWEEP), strict=False, as_json=False)
        == 0
    )
    told = capsys.readouterr().out
    assert "W_T" not in told
    assert "No energy is stated for sweeps: c01, c02" in told


def test_looking_ahead_sees_the_whole_sweep() -> None:
    """The largest force lies where the sweep passes, not where it begins."""
    protocol = load_protocol(SWEEP, ["drive.frequency=5 Hz", "drive.sweep_to=12 Hz"])
    campaign = campaign_of(protocol, load_rig("paper"), SWEEP)
    first = campaign.conditions[0]
    held = replace(first, drive=replace(first.drive, sweep_to=None))
    rate = campaign.lengths[first.id].rate
    swept, dwelt = (dry_run_coupled(campaign, one, rate) for one in (first, held))
    assert swept.acceleration > 1.2 * dwelt.acceleration
    assert swept.level == pytest.approx(dwelt.level, rel=0.05)


@pytest.mark.parametrize(
    ("setting", "field", "words"),
    [
        ("drive.mode=prescribed", "drive.sweep_to", "prescribed"),
        ("drive.control=level", "drive.sweep_to", "level control"),
        ("drive.sweep_to=9 Hz", "drive.sweep_to", "from the same"),
        ("acquire.record=10 cycles", "acquire.record", "10 cycles"),
        ("acquire.trigger.channel=force", "drive.sweep_to", "trigger"),
        ("drive.sweep_too=3 Hz", "drive.sweep_too", ""),
    ],
)
def test_what_does_not_fit_a_sweep_is_named(setting: str, field: str, words: str) -> None:
    with pytest.raises(InputError) as caught:
        load_protocol(SWEEP, [setting])
    found = [mistake for mistake in caught.value.mistakes if mistake.field == field]
    assert [words in mistake.found for mistake in found] == [True]
    if field == "drive.sweep_too":
        assert "sweep_to" in found[0].hint
