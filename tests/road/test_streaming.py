"""While a campaign runs: W of every cycle as it is complete, triggers, pacing, and what a terminal
shows of it.
"""

import io
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console
from small_protocol import SMALL

from analysis import run_energy
from daq.chain.block import Flag
from daq.chain.clock import Overrun, Pacer, Punctuality
from daq.session.record import open_session
from rig.campaign.campaign import Campaign
from rig.campaign.one_run.live import LiveUpdate
from rig.campaign.resolve import campaign_of
from rig.campaign.runner import run
from rig.catalog.rig_file import load_rig
from rig.cli.terminal.live import LiveView, lines_of, timing
from rig.errors import InputError
from rig.protocol.load import load_protocol


def campaign(*sets: str) -> Campaign:
    protocol = load_protocol(SMALL, sets)
    return campaign_of(protocol, load_rig(protocol.rig), SMALL)


ONE = ("vary={}", "repeats.n=1")


def watched(out: Path, *sets: str) -> tuple[Campaign, list[LiveUpdate]]:
    made, looks = campaign(*sets), list[LiveUpdate]()
    run(made, out, workers=2, live=looks.append)
    return made, looks


@pytest.mark.parametrize(
    "sets",
    [(), ("drive.frequency=23.7",), ("acquire.coupling=AC",), ("acquire.record=150 cycles",)],
)
def test_w_while_it_streams_is_the_w_of_the_analysis(tmp_path: Path, sets: tuple[str, ...]) -> None:
    """The same reading over the cycles of a block in place of 64: poles are undone about another
    mean. Poles of 0.5 Hz turn by 25 mrad, and means of cycles scatter by some per cent of the
    signal: 1e-3 of the reactive power's work."""
    _, looks = watched(tmp_path, *ONE, *sets)
    online = np.concatenate([look.W for look in looks])
    with open_session(tmp_path / "session.h5") as record:
        (info,) = record.runs
        energy = run_energy(record, info).energy
    assert online.size == energy.cycles
    bound = 1e-3 if "acquire.coupling=AC" in sets else 1e-4
    assert np.abs(online - energy.W_cycles).max() < bound * abs(energy.reactive)
    assert looks[-1].cycles == looks[-1].of == energy.cycles


def test_a_live_update_has_levels_and_flags(tmp_path: Path) -> None:
    made, looks = watched(
        tmp_path, *ONE, "faults=[{kind: bias, channel: force, start: 20, duration: 1, size: 150 %}]"
    )
    assert {look.run for look in looks} == {run.name for run in made.runs}
    assert looks[-1].samples == looks[-1].planned
    assert looks[0].flags["force"] == ("not_settled",)
    over = [look for look in looks if "overload_hi" in look.flags["force"]]
    assert over
    assert all(look.levels["force"] == pytest.approx(1.0, abs=1e-6) for look in over)
    assert all(0 < look.levels["acceleration"] < 0.1 for look in looks)  # 5 m/s^2 are 51 mV of 1 V


@pytest.mark.parametrize(
    "trigger",
    [
        "{channel: acceleration, level: 2 %}",
        "{channel: acceleration, level: -1 %, slope: falling, kind: level, before: 5000}",
        "{channel: force, level: 0.3 %, before: 100}",
    ],
)
def test_a_trigger_moves_the_record_and_no_energy(tmp_path: Path, trigger: str) -> None:
    """The window starts with a whole cycle of the drive, and the ledger with the same one."""
    report = run(campaign(f"acquire.trigger={trigger}"), tmp_path, workers=2).document()
    assert report["verdict"] == "passes"
    assert all(abs(c["E_n_truth"]) <= 1 for c in report["conditions"])
    with open_session(tmp_path / "session.h5") as record:
        for info in record.runs:
            assert record.scalars(info.name)["trigger_sample"] > 0
            energy = run_energy(record, info)
            assert energy.energy.cycles == 40
            # phase 0 of the window is the drive's: a = -A sin wt, phasor +j A, to half a sample
            assert np.angle(energy.energy.acceleration[0] / 1j) == pytest.approx(
                0.0, abs=2 * np.pi / 512
            )


def test_a_record_that_is_never_triggered_is_reported(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="a level that is not passed"):
        run(campaign(*ONE, "acquire.trigger={channel: force, level: 95 %, patience: 20}"), tmp_path)


def test_a_machine_that_is_too_slow_is_reported_recorded_and_resumed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A million times the speed, no margin: the first late block is recorded with its flag, the run
    is incomplete.
    """
    made = campaign(*ONE, "acquire.record=400 cycles")
    with monkeypatch.context() as patched:
        patched.setattr(
            "rig.campaign.one_run.part.Pacer", lambda rate, speed: Pacer(rate, speed, margin=0.0)
        )
        with pytest.raises(Overrun, match="slower speed"):
            run(made, tmp_path, speed=1e6)
    with open_session(tmp_path / "session.h5") as record:
        (info,) = record.runs
        assert not info.complete
        assert info.flags & Flag.OVERRUN
    report = run(made, tmp_path, resume=True).document()
    assert not any("overrun" in entry["flags"] for c in report["conditions"] for entry in c["runs"])


def test_the_terminal_shows_levels_lamps_and_energies(tmp_path: Path) -> None:
    """80 columns; on anything but a terminal single blocks are nobody's business."""
    made, looks = watched(
        tmp_path, *ONE, "faults=[{kind: bias, channel: force, start: 20, duration: 1, size: 150 %}]"
    )
    text = io.StringIO()
    console = Console(file=text, width=80, force_terminal=True, color_system=None)
    view = LiveView(lines_of(made), console)
    assert view.looks
    for look in looks:
        view.look(look)
    console.print(view)
    shown = text.getvalue()
    assert max(map(len, shown.splitlines())) <= 80
    assert "OVERLOAD_HI" in shown
    assert "acceleration" in shown
    assert "100% of 10 V" in shown.replace("worst ", "")
    assert "cycle 40 of 40, W " in shown
    assert not LiveView(lines_of(made), Console(file=io.StringIO())).looks


def test_lateness_in_a_sentence() -> None:
    view = LiveView({}, Console(file=io.StringIO()))
    assert timing(view) == ""
    view.punctuality = Punctuality(4, 0.008, 2e-5, 0.003)
    assert timing(view) == "paced: 4 blocks, late by 2 ms in the mean (jitter 1 ms), 3 ms at worst"


@pytest.mark.slow
def test_two_minutes_at_sixty_times_the_speed(tmp_path: Path) -> None:
    """The real clock: 2 minutes of rig time in 2 seconds, without overrun, results as at full
    speed.
    """
    sets = ("vary={}", "repeats.n=2", "acquire.record=1190 cycles")
    late: list[Punctuality] = []
    paced = run(
        campaign(*sets),
        tmp_path / "paced",
        speed=60.0,
        progress=lambda step: late.append(step.punctuality),
    )
    assert paced == run(campaign(*sets), tmp_path / "fast", workers=2)
    assert sum(one.count for one in late) > 70
    assert max(one.worst for one in late) < 0.5


def test_pacing_changes_no_sample(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a clock that stands still but for the waits: every block is waited for and none is late
    but by round-off.
    """
    now, waits = [0.0], list[Punctuality]()

    def sleep(seconds: float) -> None:
        now[0] += seconds

    with monkeypatch.context() as patched:
        patched.setattr(
            "rig.campaign.one_run.part.Pacer",
            lambda rate, speed: Pacer(rate, speed, margin=1e-9, clock=lambda: now[0], sleep=sleep),
        )
        report = run(
            campaign(*ONE),
            tmp_path / "paced",
            speed=200.0,
            progress=lambda step: waits.append(step.punctuality),
        ).document()
    assert sum(one.count for one in waits) > 0
    assert report == run(campaign(*ONE), tmp_path / "fast", workers=1).document()
