"""Pacing against a clock that the test turns."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from daq.chain.clock import Overrun, Pacer, Punctuality


class Wall:
    """A clock whose sleep takes exactly as long as asked, plus a fixed lag."""

    def __init__(self, lag: float = 0.0) -> None:
        self.now = 1000.0
        self.lag = lag
        self.slept = 0

    def clock(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        assert seconds > 0
        self.now += seconds + self.lag
        self.slept += 1


def pacer(wall: Wall, speed: float | None, margin: float = 0.5) -> Pacer:
    return Pacer(1000.0, speed, margin, wall.clock, wall.sleep)


def test_off_never_waits() -> None:
    wall = Wall()
    for index in range(0, 10**6, 1000):
        pacer(wall, None).wait(index)
    assert wall.slept == 0


@given(speed=st.floats(0.1, 1000), steps=st.lists(st.integers(1, 5000), min_size=1, max_size=50))
def test_samples_come_at_their_time(speed: float, steps: list[int]) -> None:
    wall = Wall()
    paced = pacer(wall, speed)
    index = 0
    paced.wait(0)
    for step in steps:
        index += step
        paced.wait(index)
        assert wall.now - 1000.0 == pytest.approx(index / (1000.0 * speed), rel=1e-9, abs=1e-9)


def test_lags_do_not_add_up() -> None:
    wall = Wall(lag=0.01)
    paced = pacer(wall, 1.0)
    for index in range(0, 100000, 1000):
        paced.wait(index)
    assert wall.now - 1000.0 == pytest.approx(99.0 + 0.01)


def test_work_between_samples_is_part_of_their_time() -> None:
    wall = Wall()
    paced = pacer(wall, 1.0)
    paced.wait(0)
    wall.now += 0.7
    paced.wait(1000)
    assert wall.now == 1001.0


def test_being_late_is_tolerated_within_the_margin_and_then_an_error() -> None:
    wall = Wall()
    paced = pacer(wall, 1.0, margin=0.25)
    paced.wait(0)
    wall.now += 1.25
    paced.wait(1000)
    wall.now += 1.01
    with pytest.raises(Overrun, match="sample 2000") as caught:
        paced.wait(2000)
    assert caught.value.late == pytest.approx(0.26)


def test_a_stream_may_start_anywhere() -> None:
    wall = Wall()
    paced = pacer(wall, 1.0)
    paced.wait(5000)
    paced.wait(6000)
    assert wall.now == 1001.0


@pytest.mark.parametrize(
    ("rate", "speed"), [(0.0, 1.0), (1000.0, 0.0), (1000.0, -1.0), (float("nan"), 1.0)]
)
def test_a_speed_that_is_not_positive_is_refused(rate: float, speed: float) -> None:
    with pytest.raises(ValueError, match="positive"):
        Pacer(rate, speed)


def test_how_late_the_samples_came() -> None:
    """A sleep that lasts 1 and 3 ms too long, in turn: mean 2 ms, jitter 1 ms, at worst 3 ms."""
    wall = Wall()
    paced = pacer(wall, 1.0)
    paced.wait(0)
    for k in range(1, 101):
        wall.lag = 0.001 if k % 2 else 0.003
        paced.wait(1000 * k)
    late = paced.punctuality
    assert late.count == 101
    assert late.worst == pytest.approx(0.003, rel=1e-6)
    assert late.mean == pytest.approx(0.002, rel=0.02)
    assert late.jitter == pytest.approx(0.001, rel=0.03)
    assert (late + late).count == 202
    assert (late + late).mean == pytest.approx(late.mean)
    assert Punctuality().jitter == 0.0


def test_an_hour_at_sixty_times_the_speed() -> None:
    """60 minutes of samples in a minute of wall time, work of 80 % of each block's time on a clock
    that the test turns: not one deadline is missed; with work of 101 % the pacer gives up when it
    is half a second behind."""
    rate, block = 10240.0, 16384
    blocks = int(3600 * rate / block)
    each = block / (rate * 60.0)
    for share, done in ((0.8, blocks), (1.01, int(0.5 / (0.01 * each)) + 1)):
        wall = Wall()
        paced = Pacer(rate, 60.0, 0.5, wall.clock, wall.sleep)
        paced.wait(0)
        count = 0
        try:
            for k in range(1, blocks + 1):
                wall.now += share * each
                paced.wait(k * block)
                count += 1
        except Overrun:
            assert share > 1
        assert abs(count - done) <= 1
    assert paced.punctuality.worst > 0.5
