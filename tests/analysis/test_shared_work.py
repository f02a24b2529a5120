"""Work that processes share gives the values, and the errors, of work that one process does."""

import os
import signal
import sys

import pytest

from analysis.shared_work import both, here, shared_by

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="processes are forked")


@pytest.mark.parametrize("count", [1, 2, 3, 7])
@pytest.mark.parametrize("size", [0, 1, 2, 5, 14])
def test_values_come_in_the_order_of_the_items(count: int, size: int) -> None:
    items = range(size)
    assert shared_by(count)(lambda item: item**2, items) == here(lambda item: item**2, items)


def test_the_work_is_shared() -> None:
    processes = shared_by(3)(lambda _: os.getpid(), range(9))
    assert processes == processes[:3] * 3
    assert len(set(processes)) == 3
    assert processes[0] == os.getpid()


def test_a_killed_process_costs_no_value() -> None:
    home = os.getpid()

    def value(item: int) -> int:
        if item == 3 and os.getpid() != home:
            os.kill(os.getpid(), signal.SIGKILL)
        return -item

    assert shared_by(2)(value, range(6)) == [0, -1, -2, -3, -4, -5]


def test_errors_of_other_processes_are_raised_here() -> None:
    with pytest.raises(ZeroDivisionError):
        shared_by(2)(lambda item: 1 / (item - 1), range(4))


def test_both_values_of_two_functions() -> None:
    assert both(here, lambda: 1, lambda: "two") == (1, "two")
    one, other = both(shared_by(2), os.getpid, os.getpid)
    assert one == os.getpid() != other
