"""The terms of an offset: W_exp - W_T of a simulated session, split by origin, as fractions of W_T.

W_exp is followed from the bed to the reading. The bed dissipates E_bed, the box's losses noise,
air, gas and mount: their sum E is what an ideal gauge would read. The instruments turn it into g (E
cos d - R sin d), R = (pi/w^2) M_eff a^2. g is the product of the true scales (1 + s_F)(1 + s_a) of
force and acceleration and of the clock's (1 + e)^2; d is the angle that the correction with
certified poles leaves. W_T in turn is read at the measured acceleration, (1 + s_a) times the true
one:

    waveform + refill = E_bed - W_T(true a)
    scale = (g - 1) E - (W_T(measured a) - W_T(true a))
    phase = g (E (cos d - 1) - R sin d)
    remainder = W_exp - g (E cos d - R sin d)

They add up to W_exp - W_T by construction. The remainder is whatever none of the terms explains;
its size is tested.
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

LARGEST_REMAINDER = 2e-3  # of W_T, in conditions above the detection limit
BOX = {"noise": "W_noise", "air": "W_air", "gas": "W_gas", "mount": "W_mount"}
IN_BED = tuple(name for name in DISSIPATED if name not in BOX.values())


@dataclass(frozen=True)
class Actual:
    """The true states of the instruments and the relative error of the clock: known in simulated
    sessions only.
    """

    states: TrueInstruments
    clock: float

    def response(self, channel: ChannelFacts, omega: float) -> complex:
        """Return the ratio of corrected reading to true value at omega (rad/s), complex: the true
        scale, and the angle that the certified pole leaves.
        """
        state: TrueState = getattr(self.states, channel.name)
        scale = state.sensitivity * state.gain / channel.sensitivity
        true, certified = state.time_constant, channel.time_constant
        coupling = _high_pass(omega, _tau(state.corner)) / _high_pass(omega, _tau(channel.corner))
        skew = cmath.exp(1j * omega * (state.skew - channel.skew))
        return scale * skew * coupling * _high_pass(omega, true) / _high_pass(omega, certified)


def actual_of(truth: Truth | None) -> Actual | None:
    """Return the true instruments of a session; None without truth, or where the truth does not
    state them.
    """
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
    """Return the terms of a condition as fractions of W_T, adding up to its offset.

    None without truth or without an offset. entry: of the prediction document. `refill` also
    contains the prediction's numerical error and incomplete settling; without an ablation in the
    ledger, the effect of the waveform on the bed beyond its level is in `refill` too.
    """
    if actual is None or entry is None or result.W_T is None or not result.comparable:
        return None
    if entry.W_T is None:
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
    """Return the largest remainder of a condition that needs no explanation, as a fraction of W_T.

    It is LARGEST_REMAINDER, or, where W_T is small, the instruments' noise and the arithmetic (k =
    2). None without W_T.
    """
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
    """Return the terms of one run, J per cycle; None without its ledger."""
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
    # The true R: the reading (W, R) is the true pair (lost, R) turned by `turn` and scaled by `gain`.
    reactive = (energy.reactive * math.cos(turn) - energy.W * math.sin(turn)) / gain
    expected = gain * (lost * math.cos(turn) - reactive * math.sin(turn))
    true, measured = curve(energy.level / abs(acceleration)), curve(energy.level)
    exact = _exact(run, bed, measured)
    return OffsetTerms(
        **box,
        waveform=bed - exact,
        phase=expected - gain * lost,
        scale=(gain - 1) * lost - (measured - true),
        refill=exact - true,
        remainder=energy.W - expected,
    )


def _tau(corner: float | None) -> float | None:
    """Return the time constant in s of a corner frequency in Hz; None for none."""
    return 1 / (2 * math.pi * corner) if corner else None


def _exact(run: RunEnergy, bed: float, measured: float) -> float:
    """Return the energy that the bed would have dissipated on a sine, J per cycle.

    From an ablation; without one, the bed's own energy less the change that the recorded waveform
    makes in the nominal bed; without either, the bed's own energy.
    """
    ablated = (run.ledger or {}).get(EXACT, math.nan)
    if math.isfinite(ablated):
        return ablated
    return bed if run.recorded is None else bed - (run.recorded - measured)


def _high_pass(omega: float, time_constant: float | None) -> complex:
    """Return the response of a one-pole high pass at omega (rad/s); 1 without a time constant."""
    return (
        1.0
        if time_constant is None
        else 1j * omega * time_constant / (1 + 1j * omega * time_constant)
    )
