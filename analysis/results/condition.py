"""The evaluation of one condition: mean over its runs, uncertainty, and the prediction at its
level.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from analysis.results.coil_current import coil_estimates
from analysis.results.recorded_waveform import Recorded, on_recorded
from analysis.results.run import RunEnergy
from analysis.session.ledger_columns import DISSIPATED, STINGER
from analysis.session.prediction import Predicted, middle
from analysis.session.prediction_entry import PredictionEntry
from analysis.session.record import ChannelFacts
from analysis.session.setting import Setting
from analysis.signals.correction import net_of_mass
from analysis.uncertainty.budget import (
    angle_uncertainty,
    certificate_lines,
    combine,
    difference_parts,
    mass_and_loss,
    prediction_lines,
    refills_line,
    resolution_lines,
    scatter_line,
)
from analysis.uncertainty.budget_line import Line
from analysis.uncertainty.estimate import Estimate
from analysis.uncertainty.other_predictions import other_predictions
from analysis.uncertainty.skewed_scatter import stretch

__all__ = ["Result", "evaluate"]

NOISE = 3.0
"""Standard deviations of the instruments' noise that an energy must exceed to count as seen."""


@dataclass(frozen=True, eq=False)
class Result:
    """A condition evaluated; energies in J per cycle.

    W_exp, W_T, difference : measured, predicted, and W_exp - W_T
    chain : W_exp less the ledger; None without truth
    lines : the budget
    mass, loss : apparent mass, kg, and loss factor
    detect : detection limit: below it W cannot be distinguished from a phase error
    predicted : means of the prediction at the runs' measured accelerations; empty without one
    coil, coil_apart : W_coil, and W_coil - W_exp, where the coil's current is recorded in every run
    recorded : the prediction on the recorded waveforms
    pairs : (W_exp, W_T) of each run; empty without a prediction
    model : W_T over its nominal value, for draws of the model's parameters; empty where none were
        given
    refills : the same for refilled beds
    beyond : there is a prediction, but not for the level of a run
    prediction : name of what W_T is of
    shares_mechanism : whether the bed's energy comes from the mechanism of W_T; None if not stated
    band : lower and upper end of W_T where it is a band
    others : predictions beside W_T by name
    reasons : why a prediction is not stated, by its key in the report
    """

    setting: Setting
    runs: tuple[RunEnergy, ...]
    lines: tuple[Line, ...]
    W_exp: Estimate
    mass: Estimate
    loss: Estimate
    W_T: Estimate | None
    difference: Estimate | None
    chain: Estimate | None
    detect: float
    predicted: Predicted
    coil: Estimate | None = None
    coil_apart: Estimate | None = None
    recorded: Recorded | None = None
    pairs: tuple[tuple[float, float], ...] = ()
    model: tuple[float, ...] = ()
    refills: tuple[float, ...] = ()
    beyond: bool = False
    prediction: str | None = None
    shares_mechanism: bool | None = None
    band: tuple[float, float] | None = None
    others: Mapping[str, Estimate] = field(default_factory=dict)
    reasons: Mapping[str, str] = field(default_factory=dict)

    @property
    def inside(self) -> bool | None:
        """Whether W_exp lies in the band of W_T, or less than its U outside; None without a band."""
        if self.band is None:
            return None
        low, high = self.band
        return low - self.W_exp.U <= self.W_exp.value <= high + self.W_exp.U

    @property
    def comparable(self) -> bool:
        """Whether W_exp and W_T both exceed the detection limit and the uncertainty of W_exp."""
        return self._stands_out(self.W_T)

    @property
    def comparable_recorded(self) -> bool:
        """The same for the prediction on the recorded waveforms."""
        return self._stands_out(None if self.recorded is None else self.recorded.W_T)

    def _stands_out(self, W_T: Estimate | None) -> bool:
        floor = max(self.detect, self.W_exp.U)
        return W_T is not None and W_T.value > 0 and min(W_T.value, self.W_exp.value) >= floor

    @property
    def is_seen(self) -> bool:
        """Whether every run exceeds the detection limit and the instruments' noise."""
        return all(max(self.detect, NOISE * run.u_noise) < run.energy.W for run in self.runs)

    @property
    def log_energy(self) -> float:
        """Mean of ln W; where W is not seen, ln of the largest W that is compatible with the record."""
        if self.is_seen:
            return math.fsum(math.log(run.energy.W) for run in self.runs) / len(self.runs)
        return math.log(max(self.W_exp.value, 0.0) + max(self.detect, self.W_exp.U, 1e-300))

    def mean(self, name: str) -> float:
        """Return the mean over the runs of an attribute of their Energy."""
        return math.fsum(getattr(run.energy, name) for run in self.runs) / len(self.runs)

    def ledger_mean(self, column: str) -> float | None:
        """Return the mean of a ledger column over the runs, J per cycle.

        None where the ledger of a run is missing or has no such column.
        """
        values = [
            run.ledger[column]
            for run in self.runs
            if run.ledger is not None and column in run.ledger
        ]
        return math.fsum(values) / len(values) if len(values) == len(self.runs) else None


def evaluate(
    setting: Setting,
    runs: Sequence[RunEnergy],
    entry: PredictionEntry | None,
    channels: Mapping[str, ChannelFacts],
) -> Result:
    """Evaluate a condition from its runs, at least one.

    entry: of the prediction document, None for none.
    """
    force, acceleration = channels["force"], channels["acceleration"]
    n = len(runs)
    W = math.fsum(run.energy.W for run in runs) / n
    reactive = math.fsum(run.energy.reactive for run in runs) / n
    levels = [run.energy.level for run in runs]
    predicted, totals, own = _predicted(levels, entry)
    W_T, exponent = predicted.W_T, predicted.exponent
    # A condition measured once has no scatter: the instruments' noise is used instead.
    noise = math.sqrt(math.fsum(run.u_noise**2 for run in runs)) / n
    noise_line = (
        (Line("instrument noise", "J", noise, math.inf, 1.0, shared=False),) if noise > 0 else ()
    )
    certified = (
        *certificate_lines(
            force,
            acceleration,
            setting.frequency,
            W,
            reactive,
            W_T or 0.0,
            exponent or 0.0,
            (
                max(abs(complex(run.energy.force[0])) for run in runs),
                max(run.energy.level for run in runs),
            ),
        ),
        *resolution_lines(W, reactive),
    )
    refills = entry.refills if entry is not None else ()
    factor = stretch(refills, n)
    scatter = scatter_line([run.energy.W for run in runs], factor) or noise_line
    lines = (*scatter, *certified, *own, *refills_line(refills, W_T or 0.0))
    angle = angle_uncertainty(force, acceleration, setting.frequency)
    pairs = tuple(zip((run.energy.W for run in runs), totals, strict=True)) if totals else ()
    coils = [run.coil for run in runs if run.coil is not None]
    by_coil = (
        coil_estimates([run.energy for run in runs], coils, lines, noise)
        if len(coils) == n
        else (None, None)
    )
    mass, loss = mass_and_loss([run.energy for run in runs], certified, noise, factor)
    total = None
    if W_T is not None:
        total = combine(W_T, [(line.part_T, line.nu) for line in lines])
    curves = entry.others() if entry is not None else {}
    others = dict(other_predictions(curves, levels, (force, acceleration), setting.frequency))
    if entry is not None and total is not None and entry.prediction in others:
        others[entry.prediction] = total  # one number, one uncertainty
    return Result(
        setting=setting,
        runs=tuple(runs),
        lines=lines,
        W_exp=combine(W, [(line.part, line.nu) for line in lines]),
        mass=mass,
        loss=loss,
        W_T=total,
        difference=None if W_T is None else combine(W - W_T, difference_parts(lines, pairs)),
        chain=_chain(setting, W, runs, (*noise_line, *certified)),
        detect=abs(reactive) * angle.U,
        predicted=predicted,
        coil=by_coil[0],
        coil_apart=by_coil[1],
        recorded=on_recorded(runs, W, (*scatter, *certified), exponent, refills),
        pairs=pairs,
        model=entry.model if entry is not None else (),
        refills=refills,
        beyond=entry is not None and entry.W_T is not None and W_T is None,
        prediction=entry.prediction if entry is not None else None,
        shares_mechanism=entry.shares_mechanism if entry is not None else None,
        band=entry.band(levels) if entry is not None else None,
        others=others,
        reasons=_reasons(entry),
    )


def _reasons(entry: PredictionEntry | None) -> dict[str, str]:
    """Return why a prediction is not stated, by its key in the report."""
    if entry is None:
        return {}
    found = {f"W_T_{name}": one.why for name, one in entry.variants.items() if one.why}
    return {"W_T": entry.why, **found} if entry.why else found


def _predicted(
    levels: Sequence[float], entry: PredictionEntry | None
) -> tuple[Predicted, list[float], tuple[Line, ...]]:
    """Return the prediction of a condition, W_T of each run, and the budget lines of the
    prediction.

    Means over the runs, each at its measured acceleration. Empty without an entry, and where a
    run's level lies outside the prediction's.
    """
    if entry is None:
        return Predicted(), [], ()
    prediction, a = entry.curves(), entry.acceleration
    if prediction is None:
        return Predicted(bound=middle(entry.bound, a)), [], ()
    if not all(prediction.total.reaches(level) for level in levels):
        return Predicted(), [], ()
    n = len(levels)
    totals = [prediction.total(level) for level in levels]
    W_T = math.fsum(totals) / n
    found = Predicted(
        W_T=W_T,
        W_f=math.fsum(prediction.friction(level) for level in levels) / n,
        W_c=math.fsum(prediction.collision(level) for level in levels) / n,
        exponent=prediction.total.exponent(math.fsum(levels) / n),
        W_T_as_printed=middle(entry.W_T_as_printed, a),
        bound=middle(entry.bound, a),
        period=middle(entry.period, a),
        periodic_share=middle(entry.periodic_share, a),
    )
    return found, totals, prediction_lines(prediction, W_T)


def _chain(
    setting: Setting, W: float, runs: Sequence[RunEnergy], lines: Sequence[Line]
) -> Estimate | None:
    """Return W_exp less the runs' own ledgers, with the uncertainty of the instruments alone.

    Through the stinger, W_exp includes its loss, and so does the ledger then. None without truth.
    """
    columns = (*DISSIPATED, STINGER) if setting.through_stinger else DISSIPATED
    ledgers = [run.ledger for run in runs if run.ledger is not None]
    if len(ledgers) < len(runs):
        return None
    true = math.fsum(ledger.get(name, 0.0) for ledger in ledgers for name in columns) / len(runs)
    return combine(W - true, [(line.part, line.nu) for line in lines])


def box_distortion(run: RunEnergy, setting: Setting) -> float | None:
    """Return the distortion of the box's acceleration; None without motion.

    On an exciter, as measured. In prescribed motion, the distortion that a real exciter would show:
    the harmonics of the bed's force over the mass that they would accelerate, relative to the
    fundamental.
    """
    energy = run.energy
    if not energy.level:
        return None
    if setting.drive != "prescribed":
        return energy.thd_acceleration
    on_box = net_of_mass(
        energy.force[1:], energy.acceleration[1:], setting.box_mass + setting.gauge_mass
    )
    moved = setting.box_mass + setting.gauge_mass + setting.moving_mass
    return float(np.linalg.norm(on_box)) / moved / energy.level if moved else None
