"""Where the uncertainty of W comes from: a budget after the GUM, with what is shared between
conditions kept apart.

A line is one input quantity with its standard uncertainty u, its degrees of freedom nu and two
sensitivities: c = dW_exp per unit of the input, c_T = dW_T per unit, because W_T is evaluated at
the *measured* acceleration. A scale error e of the accelerometer moves W_exp by W e and W_T by n
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
    """Estimate from independent parts (standard uncertainty in the value's unit, nu)."""
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
    """Type B lines from the channel table; those that contribute nothing are left out.

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
    """The scatter of an AC coupling's corner f_c = w_c/2 pi: it turns the channel and scales it by
    w/sqrt(w^2 + w_c^2). One input quantity, so one line: dlnW = -(w_c^2/(w^2 + w_c^2)) and dphi = w
    w_c/(w^2 + w_c^2) per relative f_c. sign: 1 for the force, -1 for the acceleration."""
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
    """Relative standard uncertainty of a fundamental's amplitude by the sensor's linearity."""
    if not channel.linearity or not channel.full_scale:
        return 0.0
    return 0.375 * channel.linearity * (amplitude / channel.full_scale) ** 2 / math.sqrt(3)


def _coupling_turn(omega: float, channel: ChannelFacts) -> float:
    """Standard uncertainty of the coupling's phase, rad."""
    ratio = 2 * math.pi * channel.corner / omega
    return channel.corner_tolerance / math.sqrt(3) * ratio / (1 + ratio**2)


def _spread(channel: ChannelFacts) -> float:
    return 0.0 if channel.time_constant is None else channel.time_constant_spread


def _turn(omega: float, channel: ChannelFacts) -> float:
    """|d phase / d ln tau| of a channel's pole, rad."""
    return math.sin(2 * pole_phase(omega, channel.time_constant)) / 2


def angle_uncertainty(
    force: ChannelFacts, acceleration: ChannelFacts, frequency: float
) -> Estimate:
    """The angle between the two channels that is left after correction: 0 rad with its standard
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
    """Parts (rad, nu) of the angle that the analyzer alone leaves between two channels: couplings,
    skew, arithmetic.
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
    """The same of the ratio of their gains, relative."""
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
    """What the arithmetic itself may be wrong by; it keeps comparisons of ideal instruments from
    dividing by zero.
    """
    return (
        Line("arithmetic", "1", RESOLUTION, math.inf, W, ratio=1.0),
        Line("arithmetic, angle", "rad", ANGLE_RESOLUTION, math.inf, reactive, turn=1.0),
    )


def prediction_lines(prediction: SessionPrediction, W_T: float) -> tuple[Line, ...]:
    """What W_T itself is uncertain by, those left out that contribute nothing.

    Reading it between levels is wrong by chance, in each condition anew; beds that start at rest
    settle alike.
    """
    found = (
        Line("prediction numerics", "1", prediction.u_rel, math.inf, 0.0, W_T),
        Line(
            "prediction between levels", "1", prediction.u_levels, math.inf, 0.0, W_T, shared=False
        ),
        Line("settling of the bed", "1", prediction.u_settling, math.inf, 0.0, W_T),
    )
    return tuple(line for line in found if line.u > 0)


def mass_and_loss(
    energies: Sequence[Energy], lines: Sequence[Line], u_noise: float, stretch: float = 1.0
) -> tuple[Estimate, Estimate]:
    """Return apparent mass M (kg) and loss factor eta of a condition, means over its runs.

    lines: the budget of W_exp; u_noise: J, of W's mean, from the instruments; stretch: of W's
    scatter. With M + j M_i = F/A at the fundamental and eta = -M_i/M, a relative change r of |F/A|
    and a turn t change M by r M - t eta M and eta by t (1 + eta^2). Noise of the quadrature that
    makes W has an equal in the other, which makes M. A condition measured once has no scatter: that
    noise then takes its place, as it does for W.
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
    """Type A: scatter between runs over the root of their number (GUM 4.2), times a factor for what
    is known of their distribution; nothing for a single run."""
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
    """The factor in the scatter between runs of a budget; 1 where it has none."""
    return next((line.stretch for line in lines if line.source == SCATTER), 1.0)


def refills_line(refills: Sequence[float], W_T: float) -> tuple[Line, ...]:
    """W_T is of the nominal bed and W_exp a mean over refills. By what the prediction's refills
    take more or less in the mean (rectangular) the two may differ; the same sign in many conditions
    stays the same in their sum.

    refills: energies of poured beds over the nominal one's.
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
    """Parts (standard uncertainty, nu) of d_exp W_exp + d_T W_T that are a condition's own, from
    its budget.

    pairs: (W_exp, W_T) of each run, J. A run's level moves both, so that their scatter is that of
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
    """Parts (standard uncertainty, nu) of a condition's W_exp - W_T; pairs: see own_parts."""
    return [
        *((line.part - line.part_T, line.nu) for line in lines if line.shared),
        *own_parts(lines, pairs),
    ]


def noise_of(
    energy: Energy, force: ChannelFacts, acceleration: ChannelFacts, samples: int
) -> float:
    """Standard deviation of W in J from the noise of the two channels, for a window of so many
    samples.

    Each quadrature of a phasor has sigma sqrt(2/N) of white noise; W = -(pi/w^2) Im(F A*) turns
    them into energy. 1/f noise counts with its density at the drive, as white noise of that density
    would.
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
    """As noise_of, from the amplitudes of force F (N) and acceleration a (m/s^2) at the fundamental
    (Hz), sampled at `rate` (Hz)."""
    omega = 2 * math.pi * frequency

    def rms(channel: ChannelFacts) -> float:
        return math.hypot(channel.noise_rms, channel.flicker * math.sqrt(rate / 2 / frequency))

    return (
        math.pi
        / omega**2
        * math.sqrt(2 / samples)
        * math.hypot(F * rms(acceleration), a * rms(force))
    )
