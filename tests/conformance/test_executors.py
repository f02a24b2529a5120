"""What every executor must do, wherever it computes. A new implementation joins by one line in
MAKERS.

Runs are stood in for by counted numbers: what is tested is who computes them, in what order they
come and what becomes of them when a worker is killed. Whole campaigns: tests/road/test_campaign.py
(bytes), kill_workers.py (kills).
"""

import os
import random
import select
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from multiprocessing import active_children
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from daq.chain.block import Block, Flag
from daq.chain.clock import Overrun, Pacer
from rig.campaign.executor import Compute, Executor, Task
from rig.campaign.one_run.part import Part, paced
from rig.campaign.workers import Processes
from rig.errors import InputError, Mistake, WorkerFailed, WorkerLost

BLOCKS, CHANNELS, SAMPLES = 4, 4, 20_000
HANGS = 120  # s after which a test counts as hung; all take seconds


class Here:
    """The reference: one run after the other, in this process."""

    @contextmanager
    def started(
        self, compute: Compute, stages: Sequence[Sequence[Task]]
    ) -> Iterator[Iterator[Any]]:
        yield (item for stage in stages for task in stage for item in compute(task))


MAKERS: dict[str, Callable[[], Executor]] = {
    "here": Here,
    "one process": lambda: Processes(1),
    "three processes": lambda: Processes(3),
    "more processes than runs": lambda: Processes(20),
}


@dataclass
class Counted:
    """A campaign of `runs` runs; `then` is called before every part, with the run's number and the
    part's.
    """

    runs: int
    samples: int = SAMPLES
    then: Callable[[int, int], None] = lambda _run, _part: None

    @property
    def waiting(self) -> list[Any]:
        return [
            SimpleNamespace(
                name=f"run_{number:04d}", number=number, condition=SimpleNamespace(id="c")
            )
            for number in range(self.runs)
        ]

    @property
    def computed(self) -> Compute:
        """As fast as possible."""
        return self.parts

    def parts(self, run: Any) -> Iterator[Part]:
        rng = np.random.default_rng(run.number)
        for k in range(BLOCKS):
            self.then(run.number, k)
            codes = rng.integers(-(2**23), 2**23, (CHANNELS, self.samples), dtype=np.int32)
            zero = np.zeros(CHANNELS)
            block = Block(
                k * self.samples, codes, zero.astype(np.uint16), zero.astype(np.uint32), False
            )
            yield Part(
                run.name,
                block,
                np.full((1, 2), k),
                {"last": run.number} if k == BLOCKS - 1 else None,
            )


@pytest.fixture(autouse=True)
def nothing_hangs() -> Iterator[None]:
    """A test that hangs fails."""

    def hung(*_: object) -> None:
        raise AssertionError("hangs")

    before = signal.signal(signal.SIGALRM, hung)
    signal.alarm(HANGS)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)
    assert not active_children()


def taken(
    executor: Executor, campaign: Any, each: Callable[[int], None] = lambda _: None
) -> dict[str, list[Part]]:
    """Parts by run; `each` hears how many have come."""
    found: dict[str, list[Part]] = {}
    with executor.started(campaign.computed, [campaign.waiting]) as parts:
        for number, part in enumerate(parts):
            found.setdefault(part.run, []).append(part)
            each(number)
    return found


def test_processes_begin_before_anybody_asks() -> None:
    """The writer predicts and makes its file meanwhile: a worker that waits to be asked would be
    idle.
    """
    begun, tell = os.pipe()
    campaign = Counted(3, then=lambda _run, _part: os.write(tell, b"."))
    with Processes(2).started(campaign.computed, [campaign.waiting]):
        assert select.select([begun], [], [], HANGS / 2)[0]
        os.read(begun, 1 << 16)  # the part that loads the kernels, computed here
        assert select.select([begun], [], [], HANGS / 2)[0]
    os.close(begun)
    os.close(tell)


@pytest.mark.parametrize("name", MAKERS)
@pytest.mark.parametrize("sizes", [(0, 3), (3, 0), (1, 4), (5, 5), (0, 0), (2, 0, 6)])
def test_a_stage_begins_when_the_one_before_has_come(name: str, sizes: Sequence[int]) -> None:
    """Every task says when it begins; before that, all items of earlier stages have been taken from
    the workers.
    """
    begun, tell = os.pipe()
    campaign = Counted(
        sum(sizes), samples=10, then=lambda run, _: os.write(tell, run.to_bytes(2, "big"))
    )
    first = [sum(sizes[:k]) for k in range(len(sizes) + 1)]
    stages = [campaign.waiting[a:b] for a, b in pairwise(first)]
    came: list[int] = []
    with MAKERS[name]().started(campaign.computed, stages) as items:
        came.extend(int(item.run[-4:]) for item in items)
    os.close(tell)
    with os.fdopen(begun, "rb") as pipe:
        told = pipe.read()
    order = [next(k for k in range(len(sizes)) if number < first[k + 1]) for number in came]
    assert order == sorted(order)
    assert sorted(came) == sorted(BLOCKS * list(range(sum(sizes))))
    assert set(zip(told[::2], told[1::2], strict=True)) == {
        (0, number) for number in range(sum(sizes))
    }


def test_the_next_stage_begins_before_anybody_asks_for_it() -> None:
    """The writer makes its file between the stages."""
    begun, tell = os.pipe()
    campaign = Counted(6, samples=10, then=lambda run, _: os.write(tell, b"x" if run == 3 else b""))
    with Processes(2).started(
        campaign.computed, [campaign.waiting[:2], campaign.waiting[2:]]
    ) as items:
        for _ in range(2 * BLOCKS):
            next(items)
        assert select.select([begun], [], [], HANGS / 2)[0]
    os.close(begun)
    os.close(tell)


def assert_same(found: dict[str, list[Part]], campaign: Any, whole: bool = True) -> None:
    """Every part once, in order, to the byte; not `whole`: of what there is."""
    expected = {run.name: list(campaign.parts(run)) for run in campaign.waiting}
    if whole:
        assert set(found) == set(expected)
    for name, parts in found.items():
        if whole:
            assert len(parts) == BLOCKS
        for one, other in zip(parts, expected[name], strict=False):
            np.testing.assert_array_equal(one.block.codes, other.block.codes)
            np.testing.assert_array_equal(one.ledger, other.ledger)
            assert (one.block.start, one.scalars) == (other.block.start, other.scalars)


@pytest.mark.parametrize("name", MAKERS)
@pytest.mark.parametrize("runs", [0, 1, 2, 7])
def test_every_part_comes_once_and_in_order(name: str, runs: int) -> None:
    campaign = Counted(runs)
    assert_same(taken(MAKERS[name](), campaign), campaign)


@pytest.mark.parametrize("name", MAKERS)
def test_leaving_early_ends_the_work(name: str) -> None:
    campaign = Counted(7)
    with MAKERS[name]().started(campaign.computed, [campaign.waiting]) as parts:
        next(parts)
    assert not active_children()


@pytest.mark.parametrize("name", MAKERS)
@pytest.mark.parametrize(
    "error",
    [
        InputError(Mistake("protocol.yaml", "scene", "this", "that")),
        Overrun(3, 2.0, 0.5),
        MemoryError("too large"),
    ],
)
def test_an_error_comes_as_it_was_raised(name: str, error: Exception) -> None:
    def fails(run: int, part: int) -> None:
        if (run, part) == (2, 1):
            raise error

    with pytest.raises(type(error)) as caught:
        taken(MAKERS[name](), Counted(7, then=fails))
    assert str(caught.value) == str(error)


def test_a_defect_brings_its_traceback() -> None:
    def fails(run: int, part: int) -> None:
        raise ZeroDivisionError(f"in run {run}, part {part}")

    with pytest.raises(WorkerFailed, match=r"ZeroDivisionError: in run 0, part 0"):
        taken(Processes(1), Counted(2, then=fails))


@pytest.mark.parametrize("name", MAKERS)
def test_what_came_too_late_is_flagged_and_ends_it(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Held to a thousand million times real time, without an allowance: the second part is late."""
    monkeypatch.setattr(
        "rig.campaign.one_run.part.Pacer", lambda rate, speed: Pacer(rate, speed, margin=0.0)
    )
    campaign, found = Counted(1), []
    with (
        pytest.raises(Overrun),
        MAKERS[name]().started(
            lambda run: paced(campaign.parts(run), 1e4, 1e9), [campaign.waiting]
        ) as parts,
    ):
        found.extend(parts)  # what came before the error stays in the list
    assert [int(part.block.flags[0]) for part in found] == [0, int(Flag.OVERRUN)]


@pytest.mark.parametrize("count", [1, 2, 5])
def test_a_run_that_kills_its_workers_is_named(count: int) -> None:
    """Run 3 ends every process that computes it; one sentence names it."""

    def poison(run: int, part: int) -> None:
        if (run, part) == (3, 2) and os.getpid() != here:
            os.kill(os.getpid(), signal.SIGKILL)

    here = os.getpid()
    with pytest.raises(WorkerLost) as caught:
        taken(Processes(count), Counted(9, then=poison))
    sentence = str(caught.value)
    assert "\n" not in sentence
    assert "run_0003" in sentence
    assert "rig run --resume goes on" in sentence


def test_a_run_whose_worker_is_lost_goes_on_in_another(caplog: pytest.LogCaptureFixture) -> None:
    """Two of three workers are killed after parts of theirs have come: nothing comes twice and
    nothing is missing.
    """
    campaign = Counted(8)
    killed: list[int] = []

    def kill(number: int) -> None:
        if number in (2, 9):
            victim = sorted(child.pid for child in active_children() if child.pid not in killed)[0]
            killed.append(victim)
            os.kill(victim, signal.SIGKILL)

    assert_same(taken(Processes(3), campaign, kill), campaign)
    assert caplog.text.count("another one computes run_000") == 2


def lived(campaign: Any, count: int, victims: int, moment: float) -> str:
    """How a campaign ends some of whose workers are killed at a moment (s after the start)."""

    def kill() -> None:
        found = [child.pid for child in active_children()]
        for pid in random.Random(moment).sample(found, min(victims, len(found))):
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                continue

    timer = threading.Timer(moment, kill)
    timer.start()
    try:
        found = taken(Processes(count), campaign)
    except WorkerLost as lost:
        return str(lost)
    finally:
        timer.cancel()
        timer.join()
    assert_same(found, campaign)
    return ""


@pytest.mark.parametrize("kills", [12, pytest.param(100, marks=pytest.mark.slow)])
def test_kills_at_random_moments(kills: int) -> None:
    """One to three of three workers, from before the first is there until after the last part: each
    campaign ends, with every part in its place or with the sentence. Parts of 0.6 MB, more than a
    pipe holds, are under way most of the time."""
    rng, campaign = random.Random(12), Counted(4, samples=40_000)
    begun = time.monotonic()
    taken(Processes(3), campaign)
    lasts = time.monotonic() - begun
    ends = [lived(campaign, 3, 1 + k % 3, rng.uniform(0.0, 1.1 * lasts)) for k in range(kills)]
    assert all("run_000" in end for end in ends if end)
    assert not any(
        end for k, end in enumerate(ends) if k % 3 < 2
    )  # a worker was left, and did it all


def alive(pid: int) -> bool:
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.skipif(not os.path.exists("/proc/self/stat"), reason="looks into /proc")
@pytest.mark.parametrize("busy", [True, False])
def test_workers_end_with_their_parent(busy: bool) -> None:
    """The parent is killed while its workers compute without a word, or wait with full pipes; one
    of them is stopped and must not hold up the others."""
    read, write = os.pipe()

    def tell(run: int, part: int) -> None:
        if run < 3 and part == 0 and os.getpid() != parent:
            os.write(write, f"{os.getpid():10d}".encode())
            if busy:
                threading.Event().wait()

    child = os.fork()
    if not child:
        parent = os.getpid()
        with Processes(3).started(Counted(9, then=tell).computed, [Counted(9).waiting]) as parts:
            next(parts)
            threading.Event().wait()
    parent = child
    found = [int(os.read(read, 10)) for _ in range(3)]
    os.close(read)
    os.close(write)
    os.kill(found[-1], signal.SIGSTOP)
    os.kill(parent, signal.SIGKILL)
    os.waitpid(parent, 0)
    while any(alive(pid) for pid in found[:-1]):
        threading.Event().wait(0.01)
    os.kill(found[-1], signal.SIGKILL)
    while alive(found[-1]):
        threading.Event().wait(0.01)
