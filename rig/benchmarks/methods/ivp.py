"""scipy's solve_ivp with terminal events, restarted at each, the events as in its documentation.

Helped as a good user would: a mass at rest is not integrated (its start is an arcsine), friction
work is band |du|, and a wall counts only while the mass closes on it, so that no lift-off is taken
for an impact.
"""

import math
from functools import partial

from scipy.integrate import solve_ivp

from rig.benchmarks.methods.method import Failed, Method, Work
from rig.benchmarks.problems.sliders import Slider

TWO_PI = 2.0 * math.pi
CHATTER = 1e-6
LARGEST = 1.0
"""Largest step, rad: a longer one may jump over an event, whatever its tolerance."""

STUCK = 200
"""Integrations per cycle after which the method gives up."""


def solve(method: str, slider: Slider, setting: float, settle: int, average: int) -> Work:
    """Follow a slider with rtol = `setting` and atol a hundredth of it."""
    t, (mode, u, z) = 0.0, slider.start
    lost = [0.0] * (settle + average)
    events, rhs, steps, stretches = 0, 0, 0, 0
    end = TWO_PI * len(lost)
    while t < end:
        cycle = min(int(t / TWO_PI + 1e-12), len(lost) - 1)
        if mode == 0:
            t, mode = _start(t, u, slider, end)
            z = 0.0
            events += mode != 0
            continue
        pull = slider.gravity + mode * slider.band

        def slope(t: float, y: tuple[float, float], pull: float = pull) -> tuple[float, float]:
            return y[1], math.sin(t) - pull

        # One cycle at a time, because the loss is counted by cycles.
        found = solve_ivp(
            slope,
            (t, TWO_PI * (cycle + 1)),
            (u, z),
            method,
            events=_events(slider, mode, t),
            rtol=setting,
            atol=0.01 * setting,
            max_step=LARGEST,
        )
        if not found.success:
            raise Failed(found.message)
        rhs += found.nfev
        steps += found.t.size - 1
        stretches += 1
        if stretches > STUCK * len(lost):
            raise Failed("the events of a cycle do not end")
        t = float(found.t[-1])
        low, high, stop = (times.size > 0 for times in found.t_events)
        before, u, z = u, float(found.y[0, -1]), float(found.y[1, -1])
        if low or high:
            u = 0.0 if low else slider.clearance
            back = -slider.restitution * z
            # Without a cut-off the bounces would not end.
            back = 0.0 if abs(back) < CHATTER else back
            lost[cycle] += 0.5 * (z * z - back * back)
            z, mode = back, 0 if back == 0.0 else int(math.copysign(1, back))
        elif stop:
            z, mode = 0.0, 0
        lost[cycle] += slider.band * abs(u - before)
        events += low or high or stop
    return Work(sum(lost[settle:]) / average, events, rhs, steps, 0, u, z)


def _events(slider: Slider, mode: int, start: float) -> tuple[object, object, object]:
    """Return the terminal events: arrival at the floor, at the lid, and standstill against
    friction.

    `stop` is disabled at the start of a slide, which is a standstill too: the root search would
    find it.
    """

    def floor(_: float, y: tuple[float, float]) -> float:
        return y[0] if y[1] < 0.0 else 1.0

    def lid(_: float, y: tuple[float, float]) -> float:
        return slider.clearance - y[0] if y[1] > 0.0 else 1.0

    def stop(t: float, y: tuple[float, float]) -> float:
        return mode * y[1] if slider.band > 0.0 and t > start else 1.0

    # solve_ivp reads these attributes of the functions.
    for event in (floor, lid, stop):
        vars(event).update(terminal=True, direction=-1)
    return floor, lid, stop


def _start(t: float, u: float, slider: Slider, end: float) -> tuple[float, int]:
    """Return the next phase at which a mass at rest is thrown, and the direction; (end, 0) for
    never.
    """
    push, rising = math.sin(t) - slider.gravity, math.cos(t) > 0.0
    up, down = slider.gravity + slider.band, slider.gravity - slider.band
    # A push within round-off of the friction limit starts a slide only if it grows.
    round_off = 1e-12
    can_rise, can_fall = u < slider.clearance and up < 1.0, u > 0.0 and down > -1.0
    if can_rise and (
        push > slider.band + round_off or (abs(push - slider.band) <= round_off and rising)
    ):
        return t, 1
    if can_fall and (
        push < -slider.band - round_off or (abs(push + slider.band) <= round_off and not rising)
    ):
        return t, -1
    starts = []
    if can_rise:
        starts.append((_after(math.asin(up), t), 1))
    if can_fall:
        starts.append((_after(math.pi - math.asin(down), t), -1))
    found = min(starts, default=(end, 0))
    return found if found[0] < end else (end, 0)


def _after(phase: float, t: float) -> float:
    """Return the first phase + 2 pi k later than t."""
    return phase + TWO_PI * (math.floor((t - phase) / TWO_PI + 1e-13) + 1)


def _method(name: str, finest: int) -> Method:
    ladder = tuple(10.0**-k for k in range(3, finest + 1))
    return Method(
        f"solve_ivp {name}", "solve_ivp", "rtol", ladder, ladder[1::3], partial(solve, name)
    )


IVP = (_method("RK45", 11), _method("DOP853", 12), _method("Radau", 8), _method("LSODA", 11))
