"""The electrodynamic exciter with stinger and box as one linear system: matrices and frequency
response.

Armature x_a, body x_b, box x (m), coil current i (A), amplifier voltage e (V); f is the external
force on the box (N), r = x_a - x_b:

    m_a x_a'' = BL i - c_s r' - k_s r - F_st           F_st = k_st (x_a - x) + c_st (x_a' - x')
    m_b x_b'' = -BL i + c_s r' + k_s r - c_i x_b' - k_i x_b
    m x'' = F_st - c x' + f                            L i' + R i + BL r' = e

The force gauge sits at either end of the massless stinger. Its `gauge_mass` moves with the end to
which it is fixed: it reads F_st on the box side, F_st + m_gauge x_a'' on the exciter side. The
coil's inductance is at least `LEAST_TIME` times R, so that the current remains a state variable.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rig.catalog.entries import Exciter
from rig.protocol.spec import Amplifier, GaugeSide

Array = NDArray[np.float64]
Spectrum = NDArray[np.complex128]

XA, VA, XB, VB, X, V, I = range(7)  # noqa: E741
STATES = 7
LEAST_TIME = 1e-8
"""Shortest electrical time constant L/R of the coil, s: a phase of 1e-6 rad at 20 Hz."""


@dataclass(frozen=True)
class Plant:
    """Coefficients of the linear system, SI units.

    box : all mass that moves with the box permanently, kg
    damping : viscous losses between box and ground, N s/m
    read_mass : mass whose inertia the gauge reads in addition to the stinger force, kg
    """

    force_constant: float
    resistance: float
    inductance: float
    flexure: float
    flexure_damping: float
    stinger: float
    stinger_damping: float
    isolation: float
    isolation_damping: float
    armature: float
    body: float
    box: float
    damping: float
    read_mass: float

    @classmethod
    def of(
        cls,
        exciter: Exciter,
        box: float,
        gauge_mass: float = 0.0,
        gauge: GaugeSide = "box",
        damping: float = 0.0,
    ) -> "Plant":
        """Return the system of an exciter and a box of mass `box` (kg, without the gauge mass)."""
        at_box = gauge == "box"
        return cls(
            force_constant=exciter.force_constant,
            resistance=exciter.resistance,
            inductance=max(exciter.inductance, LEAST_TIME * exciter.resistance),
            flexure=exciter.flexure_stiffness,
            flexure_damping=_damping(
                exciter.flexure_stiffness, exciter.flexure_damping_ratio, exciter.moving_mass
            ),
            stinger=exciter.stinger_stiffness,
            stinger_damping=exciter.stinger_damping,
            isolation=exciter.isolation_stiffness,
            isolation_damping=_damping(
                exciter.isolation_stiffness, exciter.isolation_damping_ratio, exciter.body_mass
            ),
            armature=exciter.moving_mass + (0.0 if at_box else gauge_mass),
            body=exciter.body_mass,
            box=box + (gauge_mass if at_box else 0.0),
            damping=damping,
            read_mass=0.0 if at_box else gauge_mass,
        )

    def matrix(self) -> Array:
        """Return A of y' = A y + b e + g f for a voltage amplifier, shape (7, 7).

        y = (x_a, x_a', x_b, x_b', x, x', i)
        """
        a = np.zeros((STATES, STATES))
        a[XA, VA] = a[XB, VB] = a[X, V] = 1.0
        # Newton's third law: each spring-damper pair enters both bodies with opposite signs.
        for first, second, k, c in (
            (XA, XB, self.flexure, self.flexure_damping),
            (XA, X, self.stinger, self.stinger_damping),
        ):
            for this, other in ((first, second), (second, first)):
                a[this + 1, [this, this + 1]] -= (k, c)
                a[this + 1, [other, other + 1]] += (k, c)
        # The isolation acts between body and ground, the box losses between box and ground.
        a[VB, [XB, VB]] -= (self.isolation, self.isolation_damping)
        a[V, V] -= self.damping
        a[VA, I], a[VB, I] = self.force_constant, -self.force_constant
        a[[VA, VB, V]] /= np.array([[self.armature], [self.body], [self.box]])
        a[I, [VA, VB, I]] = (
            -np.array([self.force_constant, -self.force_constant, self.resistance])
            / self.inductance
        )
        return a


@dataclass(frozen=True)
class Response:
    """Complex amplitudes per unit amplitude of the amplifier's command, e^(+jwt), one per
    frequency.

    force : at the gauge, N
    acceleration : of the box, m/s^2
    current : of the coil, A
    voltage : at the amplifier, V
    travel : of the coil relative to the body, m
    """

    force: Spectrum
    acceleration: Spectrum
    current: Spectrum
    voltage: Spectrum
    travel: Spectrum


def steady(plant: Plant, amplifier: Amplifier, frequency: Array | float) -> Spectrum:
    """Return the complex amplitudes of the states per unit command, e^(+jwt), shape (7,
    frequencies).
    """
    jw = 2j * np.pi * np.atleast_1d(np.asarray(frequency, dtype=np.float64))
    a = plant.matrix().astype(np.complex128)
    drive = np.zeros(STATES, np.complex128)
    drive[I] = 1.0 / plant.inductance if amplifier == "voltage" else 1.0
    if amplifier == "current":
        a[I] = 0.0
    left = jw[:, None, None] * np.eye(STATES) - a
    if amplifier == "current":
        # A current amplifier imposes the current: the row of i becomes i = command.
        left[:, I, I] = 1.0
    y = np.linalg.solve(left, np.broadcast_to(drive[:, None], (jw.size, STATES, 1)))
    return np.asarray(y[..., 0].T, dtype=np.complex128)


def response(plant: Plant, amplifier: Amplifier, frequency: Array | float) -> Response:
    """Return the frequency response of exciter and box to the amplifier's command, V or A, at
    frequencies above 0 (Hz).
    """
    jw = 2j * np.pi * np.atleast_1d(np.asarray(frequency, dtype=np.float64))
    y = steady(plant, amplifier, frequency)
    pull = plant.stinger * (y[XA] - y[X]) + plant.stinger_damping * (y[VA] - y[V])
    back = plant.force_constant * (y[VA] - y[VB])
    return Response(
        force=pull + plant.read_mass * jw * y[VA],
        acceleration=jw * y[V],
        current=y[I],
        voltage=(plant.resistance + jw * plant.inductance) * y[I] + back,
        travel=y[XA] - y[XB],
    )


@dataclass(frozen=True)
class Propagator:
    """Exact solution of the linear system over one interval: y+ = phi y + now u + next u+.

    The input u varies linearly within the interval.

    phi : voltage-driven [0] and current-driven [1], shape (2, 7, 7)
    now, next : shape (2, 7). Voltage-driven [0], the input is the voltage; current-driven [1], it
        is the rate of change of the current, constant, in `now` alone
    thrust : state after 0 .. J intervals of a constant unit force on the box, shape (2, J + 1, 7)
    """

    phi: Array
    now: Array
    next: Array
    thrust: Array


def propagator(plant: Plant, interval: float, longest: int) -> Propagator:
    """Return the matrices for steps of 1 to `longest` intervals (s).

    The matrix exponential is exact for any stiffness.
    """
    from scipy.linalg import expm

    phi, now, following = (
        np.zeros((2, STATES, STATES)),
        np.zeros((2, STATES)),
        np.zeros((2, STATES)),
    )
    thrust = np.zeros((2, longest + 1, STATES))
    scale = np.ones(STATES)
    # Positions in units of the interval: this balances the matrix, which the exponential needs.
    scale[[XA, XB, X]] = interval  # positions in units of the interval balance the matrix
    for kind in (0, 1):
        a = plant.matrix()
        if kind == 1:
            a[I] = 0.0
        a = interval * a * scale[None, :] / scale[:, None]
        b = np.zeros((STATES, 2))
        b[I, 0] = interval * (1.0 / plant.inductance if kind == 0 else 1.0)
        b[V, 1] = interval / plant.box
        one = _hold(expm, a, b)
        phi[kind] = one[0] * scale[:, None] / scale[None, :]
        hold, ramp = one[1] * scale[:, None], one[2] * scale[:, None]
        # A linear input is a constant u plus a ramp (u+ - u): collect the coefficients of u and of
        # u+.
        now[kind] = hold[:, 0] - (ramp[:, 0] if kind == 0 else 0.0)
        following[kind] = ramp[:, 0] if kind == 0 else 0.0
        for k in range(longest):
            thrust[kind, k + 1] = phi[kind] @ thrust[kind, k] + hold[:, 1]
    return Propagator(phi, now, following, thrust)


def _hold(expm: Callable[[Array], Array], a: Array, b: Array) -> tuple[Array, Array, Array]:
    """Return e^a and the responses after unit time to a constant input of 1 and to a ramp from 0 to
    1.
    """
    n, m = b.shape
    block = np.zeros((n + 2 * m, n + 2 * m))
    block[:n, :n], block[:n, n : n + m] = a, b
    block[n : n + m, n + m :] = np.eye(m)
    # Van Loan (1978): the exponential of the augmented block matrix holds all three in its first
    # rows.
    power = expm(block)
    return power[:n, :n], power[:n, n : n + m], power[:n, n + m :]


def _damping(stiffness: float, ratio: float, mass: float) -> float:
    """Return c = 2 zeta sqrt(k m), N s/m."""
    return float(2.0 * ratio * np.sqrt(stiffness * mass))
