"""The single mass's orbits that are known in closed form, solved here with 40 digits: the promise
is 1e-9 of W.
"""

import mpmath as mp
import numpy as np
import pytest

from rig.kernels.single_mass.many_cycles import MeanCycle, run, steady
from rig.kernels.single_mass.one_cycle import State, world
from rig.theory import single_mass as theory

SINE = (np.ones(1), np.zeros(1))
REST = State(0, 0.0, 0.0)
NO_LID = np.inf
PROMISED = 1e-9

mp.mp.dps = 40


def settled(
    weight: float = 0.0,
    gap: float = NO_LID,
    e: float = 0.0,
    band: float = 0.0,
    low: float = 0.0,
    start: State = REST,
) -> MeanCycle:
    """Mean cycle of a single mass on a sine, units of the sine: weight and band are accelerations
    over its peak.
    """
    return steady(start, *world(weight, band, low, gap, e, *SINE), *SINE)


class Flight:
    """A flight over a box that moves as x = sin t: height and speed against the box a time t after
    phase `start`.
    """

    def __init__(
        self, level: float, start: mp.mpf, u: mp.mpf | int = 0, height: mp.mpf | float = 0
    ) -> None:
        self.pull = 1 / mp.mpf(level) if level else mp.mpf(0)
        self.start, self.u, self.begin = start, u, height

    def height(self, t: mp.mpf) -> mp.mpf:
        moved = mp.sin(self.start + t) - mp.sin(self.start)
        return self.begin + (self.u + mp.cos(self.start)) * t - self.pull * t * t / 2 - moved

    def speed(self, t: mp.mpf) -> mp.mpf:
        return self.u + mp.cos(self.start) - self.pull * t - mp.cos(self.start + t)

    def meets(self, height: mp.mpf | float, step: float = 1e-3) -> mp.mpf:
        """First time at which a height is reached from the side of the start: small steps, then a
        root in the last.
        """
        t = mp.mpf(step)
        side = mp.sign(self.height(t) - height)
        while mp.sign(self.height(t + step) - height) == side:
            t += step
        return mp.findroot(
            lambda s: self.height(s) - height, (t, t + step), solver="anderson", tol=1e-60
        )


def take_off(level: float) -> mp.mpf:
    return mp.asin(1 / mp.mpf(level))


def state_at_cycle_start(level: float, phase: mp.mpf, u: mp.mpf | int = 0) -> State:
    """A single mass that leaves the floor at `phase` with speed u, at the end of that cycle."""
    flight, t = Flight(level, phase, u), 2 * mp.pi - phase
    return State(1, float(flight.height(t)), float(flight.speed(t)))


@pytest.mark.parametrize("level", [1.0001, 1.01, 1.1, 1.5, 2.0, 2.5, 3.0, 3.2, 3.29])
def test_a_plastic_single_mass_leaves_at_sin_1_over_gamma_and_lands_once_a_cycle(
    level: float,
) -> None:
    """W = m u^2/2 at the first root of the flight, u the closing speed; it lands while the floor
    pushes.
    """
    flight = Flight(level, take_off(level))
    exact = float(flight.speed(flight.meets(0)) ** 2 / 2)
    found = settled(weight=1 / level)
    assert (found.period, found.friction, found.lid) == (1, 0.0, False)
    # near 1 the take-off phase hangs on 1 - 1/level: its rounding, 1e-16, is 1e-12 of it at 1.0001
    assert found.collision == pytest.approx(exact, rel=PROMISED)
    assert theory.plastic_energy(level) == pytest.approx(exact, rel=PROMISED)


@pytest.mark.parametrize(
    ("level", "gap"), [(1.2, 0.005), (1.5, 0.1), (2.0, 0.2), (2.0, 1.0), (3.0, 0.02), (10.0, 0.3)]
)
def test_a_lid_in_reach(level: float, gap: float) -> None:
    """A plastic hit at the lid; it stays there while the lid pushes, sin > 1/Gamma; then it falls
    to the floor.
    """
    start = take_off(level)
    rise = Flight(level, start)
    t = rise.meets(mp.mpf(gap))
    energy, phase = rise.speed(t) ** 2 / 2, max(start + t, mp.pi - start)
    fall = Flight(level, phase, 0, mp.mpf(gap))
    t = fall.meets(0)
    assert (
        phase + t < 2 * mp.pi + start
    )  # it rests on the floor before it is thrown again: period 1
    found = settled(weight=1 / level, gap=gap)
    assert (found.period, found.lid) == (1, True)
    assert found.collision == pytest.approx(float(energy + fall.speed(t) ** 2 / 2), rel=PROMISED)


@pytest.mark.parametrize("k", [1, 2, 3])
@pytest.mark.parametrize("share", [0.02, 0.3, 0.6, 0.95])
def test_the_locking_bands(k: int, share: float) -> None:
    """Between sqrt(1 + k^2 pi^2) and sqrt(4 + k^2 pi^2) a flight lasts k cycles: r(2 pi k) = 0 is
    cos phi = pi k/Gamma, the landing speed 2 pi k g/w. That is 2 pi^2 k^2 m g^2/w^2 in each landing
    and 2 pi^2 k m g^2/w^2 a cycle."""
    low, high = theory.locking_band(k)
    level = low + share * (high - low)
    start = state_at_cycle_start(level, mp.acos(mp.pi * k / mp.mpf(level)))
    found = settled(weight=1 / level, start=start)
    exact = float(2 * mp.pi**2 * k / mp.mpf(level) ** 2)
    assert found.period in (
        k,
        2 * k,
    )  # near the upper end one flight is a little long, the next a little short
    assert found.collision == pytest.approx(exact, rel=PROMISED)
    assert theory.locked_energy(level, k) == pytest.approx(exact, rel=1e-14)


@pytest.mark.parametrize("k", [1, 2])
@pytest.mark.parametrize(("beyond", "stays"), [(-1e-2, True), (1e-2, False)])
def test_the_upper_end_of_a_locking_band(k: int, beyond: float, stays: bool) -> None:
    """A deviation is multiplied by 1 - Gamma sin(phi) in each flight: -1 at Gamma^2 = 4 + k^2 pi^2."""
    level = theory.locking_band(k)[1] + beyond
    mode, q, u = state_at_cycle_start(level, mp.acos(mp.pi * k / mp.mpf(level)))
    found = run(
        State(mode, q, u + 1e-6), *world(1 / level, 0.0, 0.0, NO_LID, 0.0, *SINE), *SINE, 4000 * k
    )
    assert (abs(found.state[-1, 2] - u) < 1e-9) == stays


@pytest.mark.parametrize("gap", [1e-9, 1e-3, 0.05, 0.5, 1.0, 2.0, 3.0, 3.14])
def test_without_weight(gap: float) -> None:
    """t - sin t = L/A; (1 - cos t)^2 m (A w)^2/2 in each of the two hits of a cycle."""
    guess = (6 * mp.mpf(gap)) ** (mp.mpf(1) / 3)
    t = mp.findroot(lambda t: t - mp.sin(t) - gap, guess)
    exact = float((1 - mp.cos(t)) ** 2)
    found = settled(gap=gap)
    assert (found.period, found.friction) == (1, 0.0)
    assert found.collision == pytest.approx(exact, rel=PROMISED)
    assert theory.zero_gravity_energy(gap) == pytest.approx(
        exact, rel=1e-6 if gap < 1e-3 else PROMISED
    )


@pytest.mark.parametrize("eta", [0.01, 0.1, 0.3, 0.5, 0.536])
def test_a_block_that_never_stops_on_a_rough_floor(eta: float) -> None:
    found = settled(band=eta, low=-np.inf)
    exact = float(4 * mp.mpf(eta) * mp.sqrt(1 - (mp.pi * eta / 2) ** 2))
    assert (found.period, found.collision) == (1, 0.0)
    assert found.friction == pytest.approx(exact, rel=PROMISED)
    assert theory.friction_block_energy(eta) == pytest.approx(exact, rel=1e-14)


@pytest.mark.parametrize("eta", [0.5375, 0.6, 0.8, 0.95, 0.999])
def test_a_block_that_sticks_twice_a_cycle(eta: float) -> None:
    """Above 2/sqrt(4 + pi^2) it starts at sin(phi) = eta and stops where the speed is zero again; W
    = 2 eta way.
    """
    start = mp.asin(mp.mpf(eta))

    def speed(t: mp.mpf) -> mp.mpf:
        return mp.cos(start) - mp.cos(t) - eta * (t - start)

    stop = mp.findroot(
        speed, (mp.pi - start + 1e-9, start + mp.pi + 1e-3), solver="anderson", tol=1e-60
    )
    assert stop < start + mp.pi
    way = (
        mp.cos(start) * (stop - start)
        - mp.sin(stop)
        + mp.sin(start)
        - eta * (stop - start) ** 2 / 2
    )
    found = settled(band=eta, low=-np.inf)
    assert found.period == 1
    assert found.friction == pytest.approx(float(2 * eta * way), rel=PROMISED)


@pytest.mark.parametrize("k", [1, 2])
@pytest.mark.parametrize("e", [0.2, 0.5, 0.9])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_a_bouncing_single_mass_locked_to_a_resonance(k: int, e: float, share: float) -> None:
    """One bounce in k cycles: it rises with u = e times the speed of landing, u (1 + 1/e) = 2 pi k
    g/w; loss per hit 2 pi^2 k^2 (1 - e)/(1 + e) m g^2/w^2."""
    low, high = theory.bouncing_band(k, e)
    level = low + share * (high - low)
    phase = mp.acos(mp.pi * k * (1 - mp.mpf(e)) / ((1 + mp.mpf(e)) * level))
    start = state_at_cycle_start(
        level, phase, 2 * mp.pi * k * mp.mpf(e) / ((1 + mp.mpf(e)) * level)
    )
    found = settled(weight=1 / level, e=e, start=start)
    exact = float(2 * mp.pi**2 * k**2 * (1 - mp.mpf(e)) / (1 + mp.mpf(e)) / mp.mpf(level) ** 2)
    assert found.period % k == 0
    assert found.collision * k == pytest.approx(exact, rel=PROMISED)
    assert theory.bouncing_loss(level, k, e) == pytest.approx(exact, rel=1e-14)


@pytest.mark.parametrize(
    ("e", "share", "stays"),
    [(0.5, 0.95, True), (0.5, 1.05, False), (0.8, 0.9, True), (0.8, 1.1, False)],
)
def test_where_a_resonance_is_stable(e: float, share: float, stays: bool) -> None:
    """Within the band a deviation of 1e-6 dies out, above it does not."""
    low, high = theory.bouncing_band(1, e)
    level = low + share * (high - low)
    phase = mp.acos(mp.pi * (1 - mp.mpf(e)) / ((1 + mp.mpf(e)) * level))
    mode, q, u = state_at_cycle_start(
        level, phase, 2 * mp.pi * mp.mpf(e) / ((1 + mp.mpf(e)) * level)
    )
    found = run(
        State(mode, q, u + 1e-6), *world(1 / level, 0.0, 0.0, NO_LID, e, *SINE), *SINE, 2000
    )
    assert (abs(found.state[-1, 2] - u) < 1e-9) == stays


@pytest.mark.parametrize(("level", "e"), [(1.2, 0.3), (1.5, 0.3), (1.2, 0.7), (1.1, 0.9)])
def test_bouncing_that_dies_out_is_ended_without_a_trace(level: float, e: float) -> None:
    """Bounce by bounce with 40 digits down to 1e-18 of the speed; what is cut off is proven to be
    below 1e-13 of W.
    """
    energy, phase, u = mp.mpf(0), take_off(level), mp.mpf(0)
    first = phase
    while True:
        flight = Flight(level, phase, u)
        push = 1 / mp.mpf(level) - mp.sin(phase)
        t = (
            flight.meets(0)
            if u == 0 or push < 1e-3 * u
            else mp.findroot(flight.height, 2 * u / push)
        )
        assert t > 0
        closing = -flight.speed(t)
        energy += (1 - mp.mpf(e) ** 2) * closing**2 / 2
        phase, u = phase + t, e * closing
        if u < 1e-18:
            break
    assert phase < first + 2 * mp.pi
    found = settled(weight=1 / level, e=e)
    assert found.period == 1
    assert found.collision == pytest.approx(float(energy), rel=2e-13)
