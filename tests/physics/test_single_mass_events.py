"""The single mass's events: energy and hard cases over all settings, another integrator, and long
runs.
"""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from rig.kernels.single_mass.many_cycles import MassCycles, run, steady
from rig.kernels.single_mass.one_cycle import MAX_EVENTS, State, world
from rig.kernels.waveform import Array, motion
from rig.theory import single_mass as theory

SINE = (np.ones(1), np.zeros(1))
THIRD = (np.array([1.0, 0.0, 0.2]), np.array([0.0, 0.0, -0.1]))
REST = State(0, 0.0, 0.0)
NO_LID = np.inf

Waveform = tuple[Array, Array]


def followed(
    cycles: int,
    weight: float = 0.0,
    gap: float = NO_LID,
    e: float = 0.0,
    band: float = 0.0,
    low: float = 0.0,
    start: State = REST,
    waveform: Waveform = SINE,
) -> MassCycles:
    return run(start, *world(weight, band, low, gap, e, *waveform), *waveform, cycles)


def left_over(found: MassCycles, weight: float, start: State, waveform: Waveform) -> Array:
    """Work less losses less change of energy, cycle by cycle."""
    v = motion(0.0, *waveform)[1]
    before = 0.5 * (v + start.u) ** 2 + weight * start.q
    return (
        found.energy[:, 0]
        - found.energy[:, 1]
        - found.energy[:, 2]
        - np.diff(found.energy[:, 3], prepend=before)
    )


restitutions = st.just(0.0) | st.just(1.0) | st.floats(0.0, 1.0)
gaps = st.just(0.0) | st.just(NO_LID) | st.floats(-25.0, 12.0).map(np.exp)


@given(
    kind=st.sampled_from(["vertical", "zero_gravity", "horizontal", "no walls"]),
    pull=st.floats(1e-3, 2.0),
    gap=gaps,
    e=restitutions,
    # At the wall or off it by a rounding at least: of 5e-324 the kernel gives up, by name.
    place=st.just(0.0) | st.floats(1e-15, 1.0),
    speed=st.just(0.0) | st.floats(-3.0, 3.0),
    waveform=st.sampled_from([SINE, THIRD]),
)
@example(kind="horizontal", pull=0.75, gap=NO_LID, e=0.0, place=0.0, speed=0.0, waveform=SINE)
@settings(max_examples=400, deadline=None)
def test_energy_closes_whatever_happens(
    kind: str, pull: float, gap: float, e: float, place: float, speed: float, waveform: Waveform
) -> None:
    """Work = losses + change of kinetic and potential energy, every cycle; no loss negative; the
    single mass stays inside.

    Inside means inside, to the last bit: a single mass that slides off a wall and is brought back
    to it by friction ends at the wall, whatever the rounding of the two ways (5.6e-17 of a length
    of 0.7), and a later cycle starts from there.

    The account is exact but for rounding: 1e-16 of the energies that go to and fro, which are
    (height times weight, speed squared) below 100, and of the box's 0.7 in each of the events.
    """
    low = -np.inf if kind == "no walls" else 0.0
    high = np.inf if kind == "no walls" else gap
    weight = pull if kind == "vertical" else 0.0
    band = pull if kind in ("horizontal", "no walls") else 0.0
    mode = 0 if speed == 0.0 else int(np.sign(speed)) if band else 1
    start = State(mode, place * min(gap, 30.0), speed) if gap else REST
    found = followed(20, weight, high, e, band, low, start, waveform)
    refused = np.flatnonzero(found.counts[:, 0] < 0)
    done = MassCycles(*(part[: refused[0] if refused.size else 20] for part in found))
    assert refused.size == 0 or e > 0.9  # bouncing that takes more than 65536 hits in a cycle
    assert np.isfinite(done.state).all()
    assert (done.energy[:, 1:3] >= 0.0).all()
    assert ((done.state[:, 1] >= low) & (done.state[:, 1] <= high)).all()
    events = np.maximum(done.counts[:, 0], 1)
    assert (np.abs(left_over(done, weight, start, waveform)) < 1e-13 * (1 + events)).all()


@pytest.mark.parametrize("far", [NO_LID, 6.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_single_mass_that_slides_back_to_a_wall_ends_at_it(far: float, sign: float) -> None:
    """A single mass without restitution, thrown off a wall by a sine, slides back by as much in
    each of 20 cycles (from a friction of .73 on; below, it meets the wall again). It ends at the
    wall, never beyond it, and before it by no more than a rounding of its way, below 2 pi, a
    cycle. With the sine turned over, the same at the upper wall."""
    waveform = (np.array([sign]), np.zeros(1))
    low, high = (0.0, far) if sign > 0.0 else (-far, 0.0)
    for band in np.linspace(0.73, 0.99, 100):
        place = followed(20, gap=high, band=band, low=low, waveform=waveform).state[:, 1]
        assert ((place >= low) & (place <= high)).all(), band
        assert (np.abs(place) <= 20 * 2.0 * np.pi * np.finfo(float).eps).all(), band


@pytest.mark.parametrize("cycles", [2000, pytest.param(100_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("weight", "gap", "e", "band"),
    [
        (1 / 1.01, NO_LID, 0.0, 0.0),
        (0.5, NO_LID, 0.0, 0.0),
        (0.3, 2.0, 0.0, 0.0),
        (0.4, NO_LID, 0.8, 0.0),
        (0.0, 5.0, 0.6, 0.0),
        (0.0, 0.7, 0.2, 0.3),
        (0.1, NO_LID, 0.5, 0.0),
    ],
)
def test_the_ledger_does_not_drift(
    weight: float, gap: float, e: float, band: float, cycles: int
) -> None:
    """The account over many cycles closes to 1e-9 of what was dissipated in them."""
    found = followed(cycles, weight, gap, e, band)
    assert (found.counts[:, 0] >= 0).all()
    assert abs(left_over(found, weight, REST, SINE).sum()) < 1e-9 * found.energy[:, 1:3].sum()


def test_an_elastic_single_mass_loses_nothing_and_is_followed() -> None:
    found = followed(2000, weight=0.4, e=1.0)
    assert (found.energy[:, 1:3] == 0.0).all()
    assert np.abs(left_over(found, 0.4, REST, SINE)).max() < 1e-11  # heights of some 1000


def test_bouncing_without_end_is_refused_in_finite_time() -> None:
    """Elastic hops of 2e-9 cycles: 1.6e9 hits in a cycle are not followed, and say so."""
    found = followed(3, weight=0.9, e=1.0, start=State(1, 0.0, 1e-9))
    assert found.counts[0, 0] == -1
    assert (
        steady(State(1, 0.0, 1e-9), *world(0.9, 0.0, 0.0, NO_LID, 1.0, *SINE), *SINE).period == -1
    )
    assert MAX_EVENTS == 65536


@pytest.mark.parametrize(
    "level", [*theory.locking_band(1), *theory.locking_band(2), 1.0001, 4.6, 1.0 + 1e-9]
)
@pytest.mark.parametrize("beside", [-1e-9, -1e-15, 0.0, 1e-15, 1e-9])
def test_grazing_levels(level: float, beside: float) -> None:
    """Landing at the very phase of take-off, and levels at which a flight is born: finite, closed,
    within the bound.
    """
    weight = 1 / (level * (1 + beside))
    found = followed(300, weight)
    assert np.abs(left_over(found, weight, REST, SINE)).max() < 1e-13
    assert 0.0 <= found.energy[100:, 2].mean() <= 2 * np.pi * weight


@pytest.mark.parametrize("beside", [-1e-12, -1e-16, 0.0, 1e-16, 1e-12])
def test_a_lid_that_a_flight_just_touches(beside: float) -> None:
    """At the top of the flight the speed is zero: a lid there changes nothing. A lid 1e-12 lower
    meets it at 1e-6.
    """
    free = followed(40, weight=0.5)
    top, low, high = 0.5, 0.5, 3.0  # halved down to the lowest lid that is not hit
    while high - low > 1e-15 * high:
        top = 0.5 * (low + high)
        low, high = (top, high) if followed(5, weight=0.5, gap=top).counts[-1, 2] else (low, top)
    touched = followed(40, weight=0.5, gap=top * (1 + beside))
    assert np.abs(left_over(touched, 0.5, REST, SINE)).max() < 1e-13
    assert touched.energy[-1, 2] == pytest.approx(free.energy[-1, 2], rel=1e-5)


def test_no_room_and_no_reach() -> None:
    """A gap of zero carries the single mass; a gap out of reach is no lid; below 1 g nothing moves;
    nor above mu g > a.
    """
    jammed = followed(5, weight=0.5, gap=0.0)
    assert (jammed.counts == 0).all()
    assert (jammed.energy[:, 1:3] == 0.0).all()
    wide, open_top = followed(60, 0.3, 1e9), followed(60, 0.3)
    np.testing.assert_array_equal(wide.energy, open_top.energy)
    for found in (
        followed(5, weight=1.0 + 1e-15),
        followed(5, band=1.0 + 1e-15, low=-np.inf),
        followed(5, band=3.0),
    ):
        assert (found.counts == 0).all()


def test_a_start_into_the_wall_is_a_hit() -> None:
    found = followed(1, weight=0.9, e=0.0, start=State(1, 0.0, -0.5))
    assert found.energy[0, 2] >= 0.125


def test_a_mirror_changes_nothing() -> None:
    """Without weight, the box upside down and the single mass at the other wall."""
    P, Q = THIRD
    one = followed(50, gap=1.7, e=0.4, waveform=THIRD, start=State(1, 0.3, 0.2))
    other = followed(50, gap=1.7, e=0.4, waveform=(-P, -Q), start=State(1, 1.4, -0.2))
    # the orbit forgets its start by half a hit: rounding does not grow
    np.testing.assert_allclose(other.energy, one.energy, atol=1e-9)
    np.testing.assert_allclose(1.7 - other.state[:, 1], one.state[:, 1], atol=1e-9)


@pytest.mark.parametrize(
    ("weight", "gap", "e", "band", "start"),
    [
        (0.4, NO_LID, 0.6, 0.0, (0.5, 0.3)),
        (0.3, 1.1, 0.5, 0.0, (0.2, -0.1)),
        (0.0, 2.3, 0.8, 0.0, (1.0, 0.4)),
        (0.0, 1.4, 0.5, 0.2, (0.7, 0.5)),
        (0.7, 0.3, 0.0, 0.0, (0.1, 0.0)),
    ],
)
def test_against_an_independent_integrator(
    weight: float, gap: float, e: float, band: float, start: tuple[float, float]
) -> None:
    """scipy's DOP853 with events on a waveform with a third harmonic, restarted at every hit, stop
    and take-off.
    """
    q, u = start
    mode = 0 if u == 0.0 else (int(np.sign(u)) if band else 1)
    found = followed(2, weight, gap, e, band, 0.0, State(mode, q, u), THIRD)
    expected = integrated(weight, gap, e, band, q, u, 4 * np.pi)
    np.testing.assert_allclose(
        found.state[-1, 1:], expected[:2], atol=1e-10
    )  # rtol of the integrator, some hits
    np.testing.assert_allclose(found.energy[:, 1:3].sum(axis=0), expected[2:], atol=1e-10)


def integrated(
    weight: float, gap: float, e: float, band: float, q: float, u: float, end: float
) -> tuple[float, float, float, float]:
    """q, u, friction and collision loss at a phase, on `THIRD`. A single mass at rest waits in
    steps for a push.
    """
    t, friction, collision = 0.0, 0.0, 0.0
    while t < end:
        s = float(np.sign(u)) or moved(t, q, weight, gap, band)
        if s == 0.0:
            t = departure(lambda x, q=q: moved(x, q, weight, gap, band), t, end)
            continue

        def slope(t: float, y: Array, s: float = s) -> list[float]:
            slip = s * band if band else 0.0
            return [y[1], -motion(t, *THIRD)[2] - weight - slip, abs(y[1]) * band]

        def floor(_: float, y: Array) -> float:
            return float(y[0])

        def lid(_: float, y: Array) -> float:
            return float(y[0]) - gap

        def stop(_: float, y: Array, s: float = s) -> float:
            return s * float(y[1])

        ends: list[Callable[..., float]] = [floor, lid, *([stop] if band else [])]
        for event, direction in zip(ends, (-1, 1, -1), strict=False):
            vars(event).update(terminal=True, direction=direction)
        seen = solve_ivp(
            slope,
            (t, end),
            (q, u, 0.0),
            "DOP853",
            events=ends,
            rtol=1e-12,
            atol=1e-14,
            max_step=0.05,
        )
        t, (q, u, lost) = float(seen.t[-1]), map(float, seen.y[:, -1])
        friction += lost
        at_floor, at_lid = (seen.t_events[n].size > 0 for n in (0, 1))
        if at_floor or at_lid:
            q = 0.0 if at_floor else gap
            collision += 0.5 * (1.0 - e * e) * u * u
            u = -e * u if abs(u) > 1e-8 else 0.0
        elif band and seen.t_events[2].size:
            u = 0.0
    return q, u, friction, collision


def moved(t: float, q: float, weight: float, gap: float, band: float) -> float:
    """Direction in which a single mass at rest starts, 0 for none."""
    push = -motion(t, *THIRD)[2] - weight
    return float(push > band and q < gap) - float(push < -band and q > 0.0)


def departure(direction: Callable[[float], float], t: float, end: float) -> float:
    """First phase after t at which a direction shows, or the end."""
    later = next((x for x in np.arange(t, end, 1e-3)[1:] if direction(x)), None)
    if later is None:
        return end
    before, after = later - 1e-3, float(later)
    while after - before > 1e-15 * end:
        middle = 0.5 * (before + after)
        before, after = (before, middle) if direction(middle) else (middle, after)
    return after


@pytest.mark.parametrize("band", [0.05, 0.3, 1.03])
def test_friction_brings_an_elastic_single_mass_to_rest_at_the_wall(band: float) -> None:
    """e = 1, pressed on by a push p > band over a small gap: each way out is (p - band)/(p + band)
    of the last, so that the bounces are a geometric series. Its end is cut off once what is left is
    1e-13 of the fastest hit."""
    wave = (np.array([1.3]), np.zeros(1))
    found = followed(20, gap=0.02, e=1.0, band=band, waveform=wave)
    # between the thresholds the push changes from band to 1.3; the ratio's square root falls the
    # speeds: at the mean push of .7 a hit leaves at least (p - b)/(p + b) of its energy, .87 for
    # the smallest band: 1e-13 after 215 hits
    assert 0 < found.counts[:, 0].max() < 2000
    assert (found.energy[:, 1] > 0.0).all()
    assert np.abs(left_over(found, 0.0, REST, wave)).max() < 1e-12
    # all of the loss is friction's but for the cut
    assert (found.energy[:, 2] <= 1e-12 * found.energy[:, 1]).all()
