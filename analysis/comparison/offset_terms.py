"""Where an offset comes from: W_exp - W_T of a simulated session, term by term, as fractions of
W_T.

W_exp is taken apart along its way. The bed takes E_bed, the box's losses take noise, air, gas and
mount: their sum E is what the gauge should read. The instruments make g (E cos d - R sin d) of it,
R = (pi/w^2) M_eff a^2: g is the product of the true scales (1 + s_F)(1 + s_a) of force and
acceleration and of the clock's (1 + e)^2, d the angle that the correction by certified poles
leaves. W_T in turn is read at the measured acceleration, (1 + s_a) times the true one:

    waveform + refill = E_bed - W_T(true a)         scale = (g - 1) E - (W_T(measured a) - W_T(true
    a)) phase = g (E (cos d - 1) - R sin d)             remainder = W_exp - g (E cos d - R sin d)

They add up to W_exp - W_T by construction; the remainder is what was not accounted for, and is
tested.
"""

import cmath
import math
from collections.abc import Mapping
from dataclasses import dataclass

from analysis.results.condition import Result
from analysis.results.condition_row import TERMS, OffsetTerms
from analysis.results.run import RunEnergy
from analysis.session.documents import truth_as
from analysis.session.exciter import TrueClock, TrueInstruments, TrueState
from analysis.session.ledger_columns import DISSIPATED, EXACT
from analysis.session.prediction import Curve
from analysis.session.prediction_entry import PredictionEntry
from analysis.session.record import ChannelFacts, Truth
from analysis.uncertainty.budget import resolution_lines

__all__ = ["LARGEST_REMAINDER", "Actual", "actual_of", "allowed_remainder", "offset_terms"]

LARGEST_REMAINDER = 2e-3  # of W_T, in conditions that stand out of the detection limit
BOX = {"noise": "W_noise", "air": "W_air", "gas": "W_gas", "mount": "W_mount"}
IN_BED = tuple(name for name in DISSIPATED if name not in BOX.values())


@dataclass(frozen=True)
class Actual:
    """What only a simulated session knows of its instruments: their states, and the clock's
    relative error.
    """

    states: TrueInstruments
    clock: float

    def response(self, channel: ChannelFacts, omega: float) -> complex:
        """Corrected reading over true value at omega (rad/s): true scale, angle left by the
        certified pole.
        """
        state: TrueState = getattr(self.states, channel.name)
        scale = state.sensitivity * state.gain / channel.sensitivity
        true, certified = state.time_constant, channel.time_constant
        coupling = _high_pass(omega, _tau(state.corner)) / _high_pass(omega, _tau(channel.corner))
        skew = cmath.exp(1j * omega * (state.skew - channel.skew))
        return scale * skew * coupling * _high_pass(omega, true) / _high_pass(omega, certified)


def actual_of(truth: Truth | None) -> Actual | None:
    """The actual instruments of a session; None without truth or where it does not say."""
    if truth is None:
        return None
    states, clock = (
        truth_as(TrueInstruments, "instruments", truth),
        truth_as(TrueClock, "clock", truth),
    )
    return None if states is None or clock is None else Actual(states, clock.error)


def offset_terms(
    result: Result,
    entry: PredictionEntry | None,
    channels: Mapping[str, ChannelFacts],
    actual: Actual | None,
) -> OffsetTerms | None:
    """The terms of a condition as fractions of W_T, adding up to its offset; None without truth or
    without an offset.

    entry: of the prediction document. Without an ablation in the ledger the waveform's effect on
    the bed beyond its level stays inside `refill`. `refill` also holds the prediction's numerics
    and what had not settled.
    """
    if actual is None or entry is None or result.W_T is None or not result.comparable:
        return None
    curve = Curve.of(entry.acceleration, entry.W_T)
    runs = [_of_run(run, curve, channels, actual) for run in result.runs]
    known = [terms for terms in runs if terms is not None]
    if len(known) < len(runs):
        return None
    W_T, n = result.W_T.value, len(known)
    return OffsetTerms(
        **{name: math.fsum(getattr(terms, name) for terms in known) / n / W_T for name in TERMS}
    )


def allowed_remainder(result: Result) -> float | None:
    """Largest remainder of a condition, as a fraction of W_T, that leaves nothing to explain:
    `LARGEST_REMAINDER`, or where W_T is small the instruments' noise and the arithmetic (k = 2).
    None without W_T."""
    if result.W_T is None or not result.W_T.value > 0:
        return None
    n = len(result.runs)
    noise = math.sqrt(math.fsum(run.u_noise**2 for run in result.runs)) / n
    resolution = [
        line.part for line in resolution_lines(result.W_exp.value, result.mean("reactive"))
    ]
    return max(LARGEST_REMAINDER, 2 * math.hypot(noise, *resolution) / result.W_T.value)


def _of_run(
    run: RunEnergy, curve: Curve, channels: Mapping[str, ChannelFacts], actual: Actual
) -> OffsetTerms | None:
    """The terms of one run, J per cycle; None without its ledger."""
    if run.ledger is None:
        return None
    energy, ledger = run.energy, run.ledger
    omega = 2 * math.pi * energy.frequency
    force, acceleration = (
        actual.response(channels[name], omega) for name in ("force", "acceleration")
    )
    both = force * acceleration.conjugate()
    gain, turn = abs(both) * (1 + actual.clock) ** 2, cmath.phase(both)
    box = {name: ledger.get(column, 0.0) for name, column in BOX.items()}
    bed = math.fsum(ledger.get(name, 0.0) for name in IN_BED)
    lost = bed + math.fsum(box.values())
    reactive = (energy.reactive * math.cos(turn) - energy.W * math.sin(turn)) / gain
    seen = gain * (lost * math.cos(turn) - reactive * math.sin(turn))
    true, measured = curve(energy.level / abs(acceleration)), curve(energy.level)
    exact = _exact(run, bed, measured)
    return OffsetTerms(
        **box,
        waveform=bed - exact,
        phase=seen - gain * lost,
        scale=(gain - 1) * lost - (measured - true),
        refill=exact - true,
        remainder=energy.W - seen,
    )


def _tau(corner: float | None) -> float | None:
    """Time constant in s of a corner in Hz; None for none."""
    return 1 / (2 * math.pi * corner) if corner else None


def _exact(run: RunEnergy, bed: float, measured: float) -> float:
    """What the bed would have taken on a sine, J per cycle: from an ablation, or its own energy
    less what the recorded waveform adds to the nominal bed's; with neither, its own energy."""
    ablated = (run.ledger or {}).get(EXACT, math.nan)
    if math.isfinite(ablated):
        return ablated
    return bed if run.recorded is None else bed - (run.recorded - measured)


def _high_pass(omega: float, time_constant: float | None) -> complex:
    return (
        1.0
        if time_constant is None
        else 1j * omega * time_constant / (1 + 1j * omega * time_constant)
    )
