"""A program: kills recordings, or workers of theirs, at random instants, looks at what is left,
resumes, and compares with one never stopped.

Arguments: folder, number of kills, seed. Prints one line per kill; a wrong one starts with BAD.
"""

import os
import random
import signal
import sys
import time
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
from small_protocol import SMALL

from daq import open_session
from daq.session.record import Record
from rig.campaign.campaign import Campaign
from rig.campaign.resolve import campaign_of
from rig.campaign.runner import run
from rig.catalog.rig_file import load_rig
from rig.protocol.load import load_protocol

SETS = (
    "vary={scene.bed: [layers, locked]}",
    "repeats.n=3",
    "acquire.settle=4",
    "acquire.record=150",
)


def campaign() -> Campaign:
    protocol = load_protocol(SMALL, sets=SETS)
    return campaign_of(protocol, load_rig(protocol.rig), SMALL)


def started(out: Path, resume: bool) -> int:
    """A recording in a child process of its own group."""
    child = os.fork()
    if not child:
        os.setpgid(0, 0)
        try:
            run(campaign(), out, workers=2, resume=resume)
            os._exit(0)
        finally:
            os._exit(1)
    return child


def same_prefix(cut: Record, whole: Record) -> int:
    """Samples that a cut record has; raises AssertionError where they are not those of the whole
    one.
    """
    count = 0
    for info in cut.runs:
        rows = cut.blocks(info.name)
        assert int(rows["count"].sum()) == info.samples
        np.testing.assert_array_equal(rows, whole.blocks(info.name)[: len(rows)])
        for channel in cut.channels:
            np.testing.assert_array_equal(
                cut.codes(info.name, channel), whole.codes(info.name, channel, 0, info.samples)
            )
        count += info.samples
        if info.complete:
            assert info.samples == info.planned
            assert cut.scalars(info.name) == whole.scalars(info.name)
    return count


def same_whole(one: Path, other: Path) -> None:
    with open_session(one / "session.h5") as a, open_session(other / "session.h5") as b:
        assert a.complete
        assert [replace(info, t0="") for info in a.runs] == [
            replace(info, t0="") for info in b.runs
        ]
        same_prefix(a, b)
        for info in a.runs:
            assert a.truth is not None
            assert b.truth is not None
            np.testing.assert_array_equal(
                a.truth.ledger(info.name)[1], b.truth.ledger(info.name)[1]
            )
    for name in ("report.json", "report.csv", "report.md", "report.html"):
        assert (one / name).read_bytes() == (other / name).read_bytes(), name


def _gone(group: int) -> None:
    """Wait until no process of a killed recording is left; its workers see their pipes closed."""
    for _ in range(100):
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return
        time.sleep(0.1)
    raise AssertionError("workers outlive the recording that they worked for")


def one_kill(folder: Path, whole: Path, delay: float, workers: int) -> str:
    """Kill a recording, or so many of its workers. Ends at the worst by the timeout of who called
    this program.
    """
    out = folder / "cut"
    child = started(out, resume=False)
    time.sleep(delay)
    found = Path(f"/proc/{child}/task/{child}/children").read_text().split()
    for victim in map(int, found[:workers]) if workers else [child]:
        with suppress(ProcessLookupError):
            os.kill(victim, signal.SIGKILL)
    ended = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    _gone(child)
    if workers:  # the recording ends well as long as one of them is left
        assert ended in ((0, 1) if len(found) <= workers else (0,)), f"ended with {ended}"
    left = "no file yet"
    if (out / "session.h5").exists():
        with (
            open_session(out / "session.h5") as cut,
            open_session(whole / "session.h5") as reference,
        ):
            samples = same_prefix(cut, reference)
            left = f"{samples} samples, {sum(info.complete for info in cut.runs)} of {len(cut.runs)} runs"
            assert (
                ended == 0 or not cut.complete or samples == sum(info.planned for info in cut.runs)
            )
    assert os.waitstatus_to_exitcode(os.waitpid(started(out, resume=True), 0)[1]) == 0, (
        "it does not resume"
    )
    same_whole(out, whole)
    for path in sorted(out.rglob("*"), reverse=True):
        path.rmdir() if path.is_dir() else path.unlink()
    return left


def main() -> None:
    folder, kills, rng = Path(sys.argv[1]), int(sys.argv[2]), random.Random(int(sys.argv[3]))
    run(campaign(), folder / "warm", workers=2)
    begun = time.monotonic()
    assert os.waitstatus_to_exitcode(os.waitpid(started(folder / "whole", resume=False), 0)[1]) == 0
    lasts = time.monotonic() - begun
    for number in range(kills):
        delay = rng.uniform(0.0, 0.9 * lasts)
        try:
            left = one_kill(folder, folder / "whole", delay, workers=number % 3)
            print(f"{number}: after {delay:.3f} s: {left}", flush=True)
        except AssertionError as error:
            print(f"BAD {number}: after {delay:.3f} s: {error}", flush=True)
            return


if __name__ == "__main__":
    main()
