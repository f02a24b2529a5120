"""The report's tables, the same in all its forms."""

from collections.abc import Sequence

from analysis.report.tables.cells import (
    UNBOUNDED,
    UNKNOWN,
    Cell,
    Table,
    fixed,
    number,
    significant,
    with_U,
)
from analysis.results.condition_row import ConditionRow, SourceRow
from analysis.results.report import Report

__all__ = [
    "budget",
    "budget_of_W_T",
    "claims",
    "coil",
    "comparisons",
    "conditions",
    "flags",
    "instruments",
    "nulls",
    "recorded",
    "references",
    "values",
]

FEW = 6  # conditions that a note names


def conditions(report: Report) -> Table:
    """Return the table of conditions."""
    known = (
        "id",
        "grains",
        "fill, %",
        "a, m/s²",
        "W_exp ± U, mJ",
        "W_T ± U, mJ",
        "offset, %",
        "E_n",
        "E_n truth",
        "detect, mJ",
        "eta ± U",
        "M_eff ± U, kg",
        "THD box, %",
        "bound, mJ",
    )
    more = list(dict.fromkeys(name for row in report.conditions for name in row.varied))
    head = (*known[:2], *more, *known[2:])
    rows = []
    for row in report.conditions:
        size = "" if row.diameter is None else f" {1e3 * row.diameter:g} mm"
        grains = f"{row.material}{size}" if row.bed not in ("empty", "dashpot") else ""
        bed = "" if row.bed == "unknown" else row.bed
        fill = (
            UNKNOWN
            if row.fill is None or row.bed == "empty"
            else Cell(f"{100 * row.fill:.4g}", row.fill)
        )
        also = (Cell(row.varied.get(name, "")) for name in more)
        rows.append(
            (
                Cell(row.id),
                Cell(f"{bed} {grains}".strip()),
                *also,
                fill,
                fixed(row.acceleration, 3),
                with_U(row.W_exp, row.U_W_exp, 1e3),
                with_U(row.W_T, row.U_W_T, 1e3),
                with_U(row.offset, row.U_offset, 100),
                fixed(row.E_n, 2),
                fixed(row.E_n_truth, 2),
                number(row.W_detect, 2, 1e3),
                with_U(row.eta, row.U_eta),
                with_U(row.M_eff, row.U_M_eff),
                number(row.thd_box, 2, 100),
                number(row.bound, 3, 1e3),
            )
        )
    note = (
        "Energies in mJ per cycle, means over the runs, expanded uncertainties for 95 %. The offset is left out where "
        "W_exp or W_T is below the detection limit or below U. E_n compares with the prediction, E_n truth with the "
        "rig's own ledger: within ±1 they agree."
    )
    impossible = [
        row.id
        for row in report.conditions
        if row.bound is not None and (row.W_T_as_printed or 0) > row.bound * (1 + 1e-9)
    ]
    if impossible:
        many = f"{len(impossible)} of {len(report.conditions)} conditions"
        where = ", ".join(impossible) if len(impossible) <= FEW else many
        note += f" The paper's own formula exceeds the hard bound, and is impossible, in {where}."
    return Table("Conditions", note, head, tuple(rows))


def comparisons(report: Report) -> Table:
    """Return the three comparisons: what was compared with what, and how often it agrees."""
    rows = tuple(
        (
            Cell(row.comparison), Cell(f"W_exp against {row.against}"), Cell(str(row.n), row.n),
            Cell(str(row.within), row.within), Cell(row.why),
        )
        for row in report.comparisons
    )  # fmt: skip
    note = (
        "Three questions that are never mixed. Chain: do instruments and analysis read what was there? Prediction: is "
        "it what the formula gives? Model: is the formula right, as uncertain as its own parameters are?"
    )
    return Table(
        "Comparisons",
        note,
        ("comparison", "what", "conditions", "within U", "what it cannot show"),
        rows,
    )


def recorded(report: Report) -> Table:
    """Return W_exp beside the predictions on a sine and on the recorded waveform; no rows where the
    latter was not made.
    """
    made = any(row.W_T_recorded for row in report.conditions)
    rows = tuple(
        (
            Cell(row.id),
            fixed(row.acceleration, 3),
            number(row.thd_acceleration, 2, 100),
            with_U(row.W_exp, row.U_W_exp, 1e3),
            number(row.W_T, 4, 1e3),
            with_U(row.W_T_recorded, row.U_W_T_recorded, 1e3),
            with_U(row.offset, row.U_offset, 100),
            with_U(row.offset_recorded, row.U_offset_recorded, 100),
            fixed(row.E_n_recorded, 2),
        )
        for row in report.conditions
        if made and row.W_T_recorded is not None
    )
    note = (
        "W_T on the recorded waveform: the same bed driven by the box's measured acceleration, all of its band, in "
        "place of a sine of the same fundamental. What a distorted waveform changes is in it; what is left of the "
        "offset are the losses outside the bed and the scatter of the refills."
    )
    head = (
        "id",
        "a, m/s²",
        "THD a, %",
        "W_exp ± U, mJ",
        "W_T sine, mJ",
        "W_T recorded ± U, mJ",
        "offset sine, %",
        "offset recorded, %",
        "E_n recorded",
    )
    return Table("Recorded waveform", note, head, rows)


def coil(report: Report) -> Table:
    """Return energies from the coil's current beside those from the gauge; no rows where it was not
    recorded.
    """
    rows = tuple(
        (
            Cell(row.id), fixed(row.acceleration, 3), with_U(row.W_exp, row.U_W_exp, 1e3),
            with_U(row.W_coil, row.U_W_coil, 1e3), fixed(row.E_n_coil, 2),
        )
        for row in report.conditions
        if row.W_coil is not None
    )  # fmt: skip
    note = (
        "W_coil is the work at the gauge plane as coil current and box acceleration determine it, without the gauge: BL i "
        "less what armature, flexure and body take, with the exciter's values as known. E_n compares the two; what the "
        "accelerometer may be wrong by is in both and does not count."
    )
    head = ("id", "a, m/s²", "W_exp ± U, mJ", "W_coil ± U, mJ", "E_n coil")
    return Table("Energy from the coil's current", note, head, rows)


def claims(report: Report) -> Table:
    """Return the claims with their findings, and their cases below them."""
    rows = []
    for number_, row in enumerate(report.claims, 1):
        words = Cell(f"{row.claim} ({row.test})")
        rows.append((
            Cell(str(number_), number_), words, Cell("", None), Cell(row.found), Cell(row.verdict),
            Cell(row.why), Cell(", ".join(row.ties)),
        ))  # fmt: skip
        rows += [
            (
                Cell(str(number_), number_),
                Cell(""),
                Cell(case.at),
                Cell(case.found),
                Cell(case.verdict),
                Cell(case.why),
                Cell(", ".join(case.ties)),
            )
            for case in row.cases
        ]
    note = (
        "What the protocol expects, with margins that stand in it, judged from ln W with the scatter of the repeats: a "
        "scale error cancels. Every “holds” is tested at 5 %; a claim over several cases holds where it holds in each. "
        "Claims are findings and fail nothing."
    )
    head = ("no.", "claim", "at", "found", "verdict", "why", "ties")
    return Table("Claims", note, head, tuple(rows))


def nulls(report: Report) -> Table:
    """Return the null tests."""
    rows = tuple(
        (
            Cell(row.null), number(row.bed_mass), _plain(row.frequency),
            _plain(row.levels),
            with_U(row.dphi, row.U_dphi, 1e3), Cell(row.verdict), Cell(row.why),
        )
        for row in report.nulls
    )  # fmt: skip
    note = (
        "A bed that cannot slide must look like mass: the angle between the channels must vanish within its U. A "
        "loop-back is one voltage at both inputs: the angle and the gain between them are the analyzer's own."
    )
    head = ("bed", "mass, kg", "f, Hz", "levels", "angle ± U, mrad", "verdict", "why")
    return Table("Null tests", note, head, rows)


def references(report: Report) -> Table:
    """Return the references."""
    rows = tuple(
        (
            Cell(row.reference), Cell(row.of), with_U(row.value, row.U), number(row.expected, 5),
            Cell(row.unit), Cell(row.verdict), Cell(row.why),
        )
        for row in report.references
    )  # fmt: skip
    note = (
        "What is known without a model: rigid masses, a dashpot of known coefficient, the signs of both channels, and "
        "by the rig's own ledger the phase between them."
    )
    return Table(
        "References",
        note,
        ("reference", "of", "found ± U", "known", "unit", "verdict", "why"),
        rows,
    )


BUDGET = (
    "source",
    "u",
    "sensitivity, mJ per unit",
    "degrees of freedom",
    "part, mJ",
    "fraction of u², %",
)


def budget(report: Report) -> Table:
    """Return the uncertainty budget of W_exp in the condition with the largest energy."""
    title = "Uncertainty budget"
    if not report.conditions:
        return Table(title, "", (), ())
    top = _largest(report)
    nu = "∞" if top.nu is None else f"{top.nu:.0f}"
    note = (
        f"Of W_exp in {top.id}, the condition with the largest energy: "
        f"{with_U(top.W_exp, top.U_W_exp, 1e3).text} mJ (k = {top.k:.2f}, {nu} degrees of freedom). Scatter "
        "between runs holds the instruments' noise. All other lines are common to all conditions; report.json has the "
        "budget of each. Where few runs and certificates come together, k is not Student's at these degrees of freedom "
        "but what covers 95 % (docs/report.md, Uncertainty)."
    )
    return Table(title, note, BUDGET, _lines(top.uncertainty))


def budget_of_W_T(report: Report) -> Table:
    """Return the budget of W_T in the same condition."""
    title = "Uncertainty budget of W_T"
    if not report.conditions or not _largest(report).uncertainty_W_T:
        return Table(title, "", (), ())
    top = _largest(report)
    note = (
        f"Of W_T in {top.id}: {with_U(top.W_T, top.U_W_T, 1e3).text} mJ. It is read at the measured "
        "acceleration, so that the accelerometer's errors enter; between levels it is rough where grains lock to the "
        "drive. Settling of the bed: what a record of this length after this settling holds beside the steady state "
        "that W_T is. report.json has the budget of each condition."
    )
    return Table(title, note, BUDGET, _lines(top.uncertainty_W_T))


def _largest(report: Report) -> ConditionRow:
    """Return the condition with the largest energy."""
    return max(report.conditions, key=lambda row: row.W_exp)


def _lines(lines: Sequence[SourceRow]) -> tuple[tuple[Cell, ...], ...]:
    """Return the rows of a budget."""
    return tuple(
        (
            Cell(line.source), _input(line.u, line.unit),
            number(line.c, 3, 1.0 if line.unit == "J" else 1e3),
            UNBOUNDED if line.nu is None else _plain(line.nu),
            number(1e3 * abs(line.c * line.u), 2), number(line.share, 2, 100),
        )
        for line in lines
    )  # fmt: skip


def _input(u: float, unit: str) -> Cell:
    """Return an input's standard uncertainty: energies in mJ, relative ones without unit."""
    shown = {"J": f"{significant(1e3 * u, 2)} mJ", "1": f"{u:.2g}"}.get(unit, f"{u:.2g} {unit}")
    return Cell(shown, u)


def flags(report: Report) -> Table:
    """Return flags and runs that were left out."""
    rows = [
        (Cell(entry.flag), number(entry.worst), Cell(str(len(entry.runs)), len(entry.runs)),
         Cell(_some(entry.runs)))
        for entry in report.flags
    ]  # fmt: skip
    rows += [
        (Cell("left out"), Cell("–"), Cell("1", 1), Cell(entry.why)) for entry in report.left_out
    ]
    note = (
        "“over_…” says that the exciter would have to give more than it can (used over limit in the second column); it "
        "fails nothing here. Peak and buckling go by the largest force: with fewer rows per layer than lie side by "
        "side many hit together, which raises it."
    )
    return Table("Flags", note, ("flag", "used / limit", "number", "runs"), tuple(rows))


def instruments(report: Report) -> Table:
    """Return the channel table, certified values."""
    rows = tuple(
        (
            Cell(row.channel),
            Cell(row.model),
            Cell(f"{1e3 * row.sensitivity:.5g} mV per {row.unit}"),
            Cell("DC" if row.time_constant is None else f"{row.time_constant:g} s"),
            _plain(100 * row.calibration_U),
            _plain(100 * row.gain_tolerance),
            Cell(f"{row.noise_rms:.2g} {row.unit}"),
        )
        for row in report.instruments
    )
    head = (
        "channel",
        "model",
        "sensitivity",
        "time constant",
        "U (k = 2), %",
        "gain tolerance, %",
        "noise rms",
    )
    return Table(
        "Instruments", "Certified values; corrections use these and nothing else.", head, rows
    )


def values(report: Report) -> Table:
    """Return assumed and other values of the rig file, with their status."""
    rows = tuple(
        (
            Cell(row.path), _plain(row.value), Cell(row.unit or ""),
            Cell(row.status or ""), Cell(row.source or ""),
        )
        for row in report.assumed
    )  # fmt: skip
    note = "Every value that the rig file holds, with where it comes from; “assumed” ones are ours and can be changed."
    return Table("Values of the rig", note, ("value of", "value", "unit", "status", "source"), rows)


def _plain(value: object) -> Cell:
    if isinstance(value, float | int):
        return Cell(f"{value:.6g}", float(value))
    return Cell("" if value is None else str(list(value) if isinstance(value, tuple) else value))


def _some(names: Sequence[str], most: int = 8) -> str:
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more
