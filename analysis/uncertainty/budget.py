"""The uncertainty budget of W after the GUM; contributions that conditions have in common are kept
apart.

A line is one input quantity with its standard uncertainty u, its degrees of freedom nu and two
sensitivities: c = dW_exp per unit of the input, c_T = dW_T per unit, because W_T is evaluated at
the *measured* acceleration. A scale error e of the accelerometer changes W_exp by W e and W_T by n
W_T e, n = dlnW/dlna: their difference carries 1 - n.
"""

import math
from collections.abc import Iterable, Sequence

from analysis.energy.energy_and_phasors import Energy
from analysis.session.prediction import SessionPrediction
from analysis.session.record import ChannelFacts
from analysis.signals.correction import pole_phase
from analysis.uncertainty.budget_line import Line
from analysis.uncertainty.estimate import Estimate

__all__ = [
    "angle_uncertainty",
    "certificate_lines",
    "combine",
    "difference_parts",
    "inputs_angle",
    "inputs_gain",
    "mass_and_loss",
    "noise_at",
    "noise_of",
    "own_parts",
    "prediction_lines",
    "refills_line",
    "resolution_lines",
    "scatter_line",
    "stretch_of",
]

SCATTER = "scatter between runs"

CERTIFICATE_NU = 50.0  # degrees of freedom of a calibration certificate that states k = 2
RESOLUTION = 1e-4  # relative standard uncertainty of the arithmetic (interpolation, filter ripple, window edges)
ANGLE_RESOLUTION = 5e-6  # rad, standard uncertainty of the same between the two channels


def combine(value: float, parts: Iterable[tuple[float, float]]) -> Estimate:
    """Return the estimate from independent parts (standard uncertainty in the value's unit, nu)."""
    return Estimate.of(value, list(parts))


def certificate_lines(
    force: ChannelFacts,
    acceleration: ChannelFacts,
    frequency: float,
    W: float,
    reactive: float,
    W_T: float = 0.0,
    exponent: float = 0.0,
    amplitudes: tuple[float, float] = (0.0, 0.0),
) -> tuple[Line, ...]:
    """Return the type B lines from the channel table; lines that contribute nothing are left out.

    frequency: Hz; W, W_T: J per cycle; reactive: (pi/w^2) M_eff a^2 in J; exponent: dlnW_T/dlna;
    amplitudes: of the fundamental force (N) and acceleration (m/s^2). Sensitivities: normal, U/2;
    gains, clock, corners of the coupling and skews: rectangular, half-width/sqrt(3); poles: sigma
    of ln tau, acting through the phase atan(1/(w tau)), whose derivative is -sin(2 phase)/2.
    Linearity: a cubic bend of up to half of it changes the fundamental by 3/4 of that, times
    (amplitude/full scale)^2.
    """
    nT = exponent * W_T
    omega = 2 * math.pi * frequency
    f_turn, a_turn = _turn(omega, force), _turn(omega, acceleration)
    lines = [
        Line("force sensitivity", "1", force.calibration_U / 2, CERTIFICATE_NU, W, ratio=1.0),
        Line(
            "acceleration sensitivity",
            "1",
            acceleration.calibration_U / 2,
            CERTIFICATE_NU,
            W,
            nT,
            ratio=-1.0,
        ),
        Line("force gain", "1", force.gain_tolerance / math.sqrt(3), math.inf, W, ratio=1.0),
        Line(
            "acceleration gain",
            "1",
            acceleration.gain_tolerance / math.sqrt(3),
            math.inf,
            W,
            nT,
            ratio=-1.0,
        ),
        Line("force pole (ln tau)", "1", _spread(force), math.inf, reactive * f_turn, turn=f_turn),
        Line(
            "acceleration pole (ln tau)",
            "1",
            _spread(acceleration),
            math.inf,
            -reactive * a_turn,
            turn=-a_turn,
        ),
        *_coupling_lines(force, omega, W, 0.0, reactive, 1.0),
        *_coupling_lines(acceleration, omega, W, nT, reactive, -1.0),
        Line(
            "skew",
            "rad",
            omega * math.hypot(*(c.skew_tolerance for c in (force, acceleration))) / math.sqrt(3),
            math.inf,
            reactive,
            turn=1.0,
        ),
        Line("force linearity", "1", _bend(force, amplitudes[0]), math.inf, W, ratio=1.0),
        Line(
            "acceleration linearity",
            "1",
            _bend(acceleration, amplitudes[1]),
            math.inf,
            W,
            nT,
            ratio=-1.0,
        ),
        Line(
            "clock",
            "1",
            max(force.clock_ppm, acceleration.clock_ppm) * 1e-6 / math.sqrt(3),
            math.inf,
            -2 * W,
        ),
    ]
    return tuple(line for line in lines if line.u > 0)


def _coupling_lines(
    channel: ChannelFacts, omega: float, W: float, nT: float, reactive: float, sign: float
) -> tuple[Line, ...]:
    """Return the line of an AC coupling's uncertain corner f_c = w_c/2 pi; none for DC.

    It turns the channel's phase and scales it by w/sqrt(w^2 + w_c^2). One input quantity, so one
    line: dlnW = -(w_c^2/(w^2 + w_c^2)) and dphi = w w_c/(w^2 + w_c^2) per relative f_c. sign: 1 for
    the force, -1 for the acceleration.
    """
    if not channel.corner:
        return ()
    ratio = 2 * math.pi * channel.corner / omega
    scale, turn = -(ratio**2) / (1 + ratio**2), ratio / (1 + ratio**2)
    u = channel.corner_tolerance / math.sqrt(3)
    c = scale * W - sign * turn * reactive
    return (
        Line(
            f"{channel.name} coupling",
            "1",
            u,
            math.inf,
            c,
            scale * nT,
            ratio=sign * scale,
            turn=-sign * turn,
        ),
    )


def _bend(channel: ChannelFacts, amplitude: float) -> float:
    """Return the relative standard uncertainty of a fundamental's amplitude that is due to the
    sensor's linearity.
    """
    if not channel.linearity or not channel.full_scale:
        return 0.0
    return 0.375 * channel.linearity * (amplitude / channel.full_scale) ** 2 / math.sqrt(3)


def _coupling_turn(omega: float, channel: ChannelFacts) -> float:
    """Return the standard uncertainty of the coupling's phase, rad."""
    ratio = 2 * math.pi * channel.corner / omega
    return channel.corner_tolerance / math.sqrt(3) * ratio / (1 + ratio**2)


def _spread(channel: ChannelFacts) -> float:
    """Return the standard deviation of ln tau of a channel's pole; 0 for DC."""
    return 0.0 if channel.time_constant is None else channel.time_constant_spread


def _turn(omega: float, channel: ChannelFacts) -> float:
    """Return |d phase / d ln tau| of a channel's pole, rad."""
    return math.sin(2 * pole_phase(omega, channel.time_constant)) / 2


def angle_uncertainty(
    force: ChannelFacts, acceleration: ChannelFacts, frequency: float
) -> Estimate:
    """Return the angle between the two channels after correction: 0 rad with its standard
    uncertainty.
    """
    omega = 2 * math.pi * frequency
    poles = [
        (_spread(channel) * _turn(omega, channel), math.inf) for channel in (force, acceleration)
    ]
    return combine(0.0, [*poles, *inputs_angle(force, acceleration, frequency)])


def inputs_angle(
    force: ChannelFacts, acceleration: ChannelFacts, frequency: float
) -> list[tuple[float, float]]:
    """Return the parts (rad, nu) of that angle that are due to the analyzer alone: couplings, skew,
    arithmetic.
    """
    omega, parts = 2 * math.pi * frequency, [(ANGLE_RESOLUTION, math.inf)]
    for channel in (force, acceleration):
        parts += [
            (_coupling_turn(omega, channel), math.inf),
            (omega * channel.skew_tolerance / math.sqrt(3), math.inf),
        ]
    return parts


def inputs_gain(
    force: ChannelFacts, acceleration: ChannelFacts, frequency: float
) -> list[tuple[float, float]]:
    """Return the parts (relative, nu) of the ratio of the two gains that are due to the analyzer
    alone.
    """
    parts = [(RESOLUTION, math.inf)]
    for channel in (force, acceleration):
        ratio = channel.corner / frequency
        scale = channel.corner_tolerance * ratio**2 / (1 + ratio**2)
        parts += [
            (channel.gain_tolerance / math.sqrt(3), math.inf),
            (scale / math.sqrt(3), math.inf),
        ]
    return parts


def resolution_lines(W: float, reactive: float) -> tuple[Line, ...]:
    """Return the lines of the arithmetic itself, without which comparisons of ideal instruments
    would divide by zero.
    """
    return (
        Line("arithmetic", "1", RESOLUTION, math.inf, W, ratio=1.0),
        Line("arithmetic, angle", "rad", ANGLE_RESOLUTION, math.inf, reactive, turn=1.0),
    )


def prediction_lines(prediction: SessionPrediction, W_T: float) -> tuple[Line, ...]:
    """Return the lines of W_T itself; lines that contribute nothing are left out.

    Interpolation between levels errs at random, independently in each condition; the settling of
    beds that start at rest is a common error,
    and so is what a formula states for itself.
    """
    found = (
        Line("prediction numerics", "1", prediction.u_rel, math.inf, 0.0, W_T),
        Line(
            "prediction between levels", "1", prediction.u_levels, math.inf, 0.0, W_T, shared=False
        ),
        Line("settling of the bed", "1", prediction.u_settling, math.inf, 0.0, W_T),
        Line("prediction as stated", "1", prediction.u_stated, math.inf, 0.0, W_T),
    )
    return tuple(line for line in found if line.u > 0)


def mass_and_loss(
    energies: Sequence[Energy], lines: Sequence[Line], u_noise: float, stretch: float = 1.0
) -> tuple[Estimate, Estimate]:
    """Return apparent mass M (kg) and loss factor eta of a condition, means over its runs.

    lines: the budget of W_exp; u_noise: standard uncertainty of W's mean by noise, J; stretch:
    factor on the scatter of W. With M + j M_i = F/A at the fundamental and eta = -M_i/M, a relative
    change r of |F/A| and a turn t change M by r M - t eta M and eta by t (1 + eta^2). White noise
    is equal in both quadratures, so that the noise of W gives that of M. A condition measured once
    has no scatter: the noise is used instead, as for W.
    """
    n = len(energies)
    masses, losses = [one.M_eff for one in energies], [one.eta for one in energies]
    M, eta = math.fsum(masses) / n, math.fsum(losses) / n
    reactive = math.fsum(one.reactive for one in energies) / n
    angle = u_noise / abs(reactive) if reactive else math.inf
    shared = [line for line in lines if line.ratio or line.turn]
    of_mass = [(line.u * (line.ratio - line.turn * eta) * M, line.nu) for line in shared]
    of_loss = [(line.u * line.turn * (1 + eta**2), line.nu) for line in shared]
    for values, parts, noise, factor in (
        (masses, of_mass, angle * M, 1.0),
        (losses, of_loss, angle * math.sqrt(1 + eta**2), stretch),
    ):
        scatter = scatter_line(values, factor) or (Line(SCATTER, "1", abs(noise), math.inf, 1.0),)
        parts += [(line.u, line.nu) for line in scatter]
    return combine(M, of_mass), combine(eta, of_loss)


def scatter_line(values: Sequence[float], stretch: float = 1.0) -> tuple[Line, ...]:
    """Return the type A line: scatter between runs over the root of their number (GUM 4.2).

    stretch: factor that accounts for a known skewed distribution. Empty for a single run.
    """
    n = len(values)
    if n < 2:
        return ()
    mean = math.fsum(values) / n
    s = math.sqrt(math.fsum((value - mean) ** 2 for value in values) / (n - 1))
    return (
        Line(
            SCATTER,
            "J",
            stretch * s / math.sqrt(n),
            float(n - 1),
            1.0,
            shared=False,
            stretch=stretch,
        ),
    )


def stretch_of(lines: Iterable[Line]) -> float:
    """Return the factor on the scatter between runs of a budget; 1 where it has none."""
    return next((line.stretch for line in lines if line.source == SCATTER), 1.0)


def refills_line(refills: Sequence[float], W_T: float) -> tuple[Line, ...]:
    """Return the line for the difference between the nominal bed, of W_T, and the mean of refills,
    of W_exp.

    refills: predicted energies of refilled beds over the nominal one's. Their mean deviation is
    taken as a rectangular half-width; it has the same sign in many conditions, so it is a common
    error.
    """
    apart = math.fsum(refills) / len(refills) - 1 if refills else 0.0
    line = Line(
        "nominal bed for the mean of refills", "1", 1 / math.sqrt(3), math.inf, 0.0, W_T * apart
    )
    return (line,) if apart else ()


def own_parts(
    lines: Sequence[Line],
    pairs: Sequence[tuple[float, float]],
    d_exp: float = 1.0,
    d_T: float = -1.0,
) -> list[tuple[float, float]]:
    """Return the parts (standard uncertainty, nu) of d_exp W_exp + d_T W_T that are a condition's
    own.

    pairs: (W_exp, W_T) of each run, J. A run's level changes both, so that the scatter is that of
    the combination, run by run (GUM 5.2.3), and not that of W_exp alone.
    """
    parts = [
        (d_exp * line.part + d_T * line.part_T, line.nu)
        for line in lines
        if not line.shared and line.source != SCATTER
    ]  # fmt: skip
    combined = scatter_line([d_exp * W + d_T * W_T for W, W_T in pairs], stretch_of(lines))
    return parts + [(line.u, line.nu) for line in combined]


def difference_parts(
    lines: Sequence[Line], pairs: Sequence[tuple[float, float]]
) -> list[tuple[float, float]]:
    """Return the parts (standard uncertainty, nu) of a condition's W_exp - W_T; pairs: see
    own_parts.
    """
    return [
        *((line.part - line.part_T, line.nu) for line in lines if line.shared),
        *own_parts(lines, pairs),
    ]


def noise_of(
    energy: Energy, force: ChannelFacts, acceleration: ChannelFacts, samples: int
) -> float:
    """Return the standard deviation of W, J, from the noise of the two channels over `samples`
    samples.

    Each quadrature of a phasor has sigma sqrt(2/N) of white noise; W = -(pi/w^2) Im(F A*) turns
    them into energy. 1/f noise counts as white noise of its density at the drive frequency.
    """
    rate = samples * energy.frequency / energy.cycles
    first = abs(complex(energy.force[0]))
    return noise_at(energy.frequency, first, energy.level, force, acceleration, samples, rate)


def noise_at(
    frequency: float,
    F: float,
    a: float,
    force: ChannelFacts,
    acceleration: ChannelFacts,
    samples: int,
    rate: float,
) -> float:
    """Return the same from the amplitudes of force F (N) and acceleration a (m/s^2) at the
    fundamental (Hz), sampled at `rate` (Hz).
    """
    omega = 2 * math.pi * frequency

    def rms(channel: ChannelFacts) -> float:
        return math.hypot(channel.noise_rms, channel.flicker * math.sqrt(rate / 2 / frequency))

    return (
        math.pi
        / omega**2
        * math.sqrt(2 / samples)
        * math.hypot(F * rms(acceleration), a * rms(force))
    )
