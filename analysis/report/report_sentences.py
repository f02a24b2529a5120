"""The sentences of the report, the same in all its forms."""

import re
from collections import Counter
from collections.abc import Sequence

from analysis.report.tables.cells import significant, with_U
from analysis.results.condition_row import ConditionRow
from analysis.results.report import Report

__all__ = [
    "again",
    "failures",
    "found",
    "headline",
    "only_sweeps",
    "reasons",
    "support",
    "tested",
    "verdict_line",
    "waveform",
]

FEW = 6  # conditions whose energies the verdict names
MENTIONED = 1e-3
"""Least relative difference between refills and nominal bed that the verdict mentions."""


def tested(report: Report) -> str:
    """Return the report's first sentence: the purpose of a run like this."""
    if only_sweeps(report):
        found = sorted({one.bed for one in report.sweeps})
        return f"This run shows force and acceleration against frequency ({', '.join(found)}): it states no energy."
    predicted = {row.bed for row in report.conditions if row.W_T or row.inside is not None}
    beds = sorted(predicted or {row.bed for row in report.conditions})
    listed = " and ".join(filter(None, [", ".join(beds[:-1]), *beds[-1:]])) or "none"
    word = "bed" if len(beds) < 2 else "beds"
    if report.tests == "measurement":
        if not _predicted(report):
            return f"This run checks the measurement chain: nothing is predicted for the {word} {listed}."
        return (
            f"This run checks the measurement chain, not the damper model: the {word} {listed} and the "
            f"prediction W_T{_by(report)} share one mechanism."
        )
    if not _predicted(report):
        return f"This run measures what is dissipated per cycle: nothing is predicted for the {word} {listed}."
    return (
        f"This run tests the damper model: what the {word} {listed} dissipated does not come from the "
        f"model of W_T{_by(report)}."
    )


def _by(report: Report) -> str:
    """Return the name of the prediction in brackets, after a blank; nothing where nobody says."""
    return f" ({report.prediction})" if report.prediction else ""


def waveform(report: Report) -> str:
    """Return the origin of the signals and the assumed waveform."""
    origin = "All signals are synthetic." if report.synthetic else "The signals were measured."
    if only_sweeps(report) and report.synthetic:
        return f"{origin} The box moves as exciter and bed let it."
    shaken = [row.thd_acceleration for row in report.conditions if row.drive == "shaker"]
    distortions = [value for value in shaken if value is not None]
    if distortions:
        given = " W_T is given on a sine of the same fundamental and on the recorded waveform."
        return (
            f"{origin} The box moves as exciter and bed let it: its acceleration is distorted by {_between(distortions)} "
            f"(harmonics over fundamental).{given if _predicted(report) else ''}"
        )
    if report.waveform != "ideal":
        return origin
    found = [row.thd_box for row in report.conditions if row.thd_box is not None]
    spread = _between(found) if found else "an unknown amount"
    return (
        f"{origin} An ideal waveform is assumed: the box follows the programmed motion exactly, where the bed's force "
        f"would distort a real exciter's acceleration by {spread} (harmonics over fundamental)."
    )


def only_sweeps(report: Report) -> bool:
    """Return whether every run that was read is a sweep, which states no energy."""
    return bool(report.sweeps) and not report.conditions


def _predicted(report: Report) -> bool:
    """Return whether any condition has a predicted energy, or a band."""
    return any(row.W_T or row.inside is not None for row in report.conditions)


def _between(fractions: Sequence[float]) -> str:
    """Return a range in per cent."""
    low, high = (f"{significant(100 * edge(fractions), 2)} %" for edge in (min, max))
    return low if low == high else f"{low} to {high}"


def verdict_line(report: Report) -> str:
    """Return the verdict in a word, or that there was no energy to judge."""
    if only_sweeps(report) and report.passes:
        return "Nothing judged, a sweep states no energy"
    return "Passes" if report.passes else "Fails"


def support(report: Report) -> str:
    """Return the assumed support of the box; "" where the session does not state it."""
    kinds = report.support
    if not kinds:
        return ""
    if kinds == ("none",):
        return "No support is assumed: nothing but the gauge holds or drives the box."
    return f"Assumed support of the box: {', '.join(kinds)}."


def reasons(report: Report) -> tuple[str, ...]:
    """Return one sentence for each check that passed or could not be made."""
    failed = set(failures(report))
    return tuple(reason for reason in report.reasons if reason not in failed)


def failures(report: Report) -> tuple[str, ...]:
    """Return the sentences of the failed checks, which come first in the report."""
    return report.failures


def headline(report: Report) -> str:
    """Return the difference between measurement and prediction."""
    if only_sweeps(report):
        return "A sweep states no energy: nothing was compared with a prediction."
    found = report.agreement
    if found.ratio is None and found.bands:
        return f"{_bands(report)} {_measured(report)}".rstrip()
    if found.ratio is None and _predicted(report):
        hidden = "No predicted energy stands out of the detection limit and of U of W_exp, so no offset is stated"
        return f"{hidden}{_ruled(found.put_in)}."
    if found.ratio is None:
        where = "" if found.ratio_recorded is None else " on a sine"
        return f"There is no predicted energy{where} to compare with. {_measured(report)}".rstrip()
    offset, U = found.ratio - 1, found.U_ratio
    nu = "∞" if found.nu is None else f"{found.nu:.0f}"
    amount = with_U(abs(offset), U, 100.0).text.split(" ± ")
    relation = "exceeds" if offset >= 0 else "falls short of"
    margin = f" ± {amount[1]} %" if len(amount) > 1 else ""
    text = f"W_exp {relation} W_T by {amount[0]} %{margin} (k = {found.k:.2f}, nu = {nu}), weighted with energy"
    if found.put_in is not None:
        put_in = f"{significant(100 * found.put_in, 2)} %"
        if found.put_in == 0:
            text += "; the rig file puts in nothing (no losses of the box)"
        elif 0 <= found.put_in <= offset:
            text += f"; of this {put_in} was put in by the rig file (losses of the box)"
        else:
            rest = f"{significant(100 * (offset - found.put_in), 2)} %"
            text += f"; losses of the box that the rig file puts in account for {put_in}, everything else for {rest}"
    return f"{text}. {_bands(report)}" if found.bands else f"{text}."


def _bands(report: Report) -> str:
    """Return in how many conditions W_exp lies in the band of W_T: of a band no ratio is taken."""
    found = report.agreement
    return f"W_exp lies inside the band of W_T in {found.inside} of {found.bands} conditions."


def _ruled(put_in: float | None) -> str:
    """Return that the losses of the box exceed the prediction, where they do."""
    if put_in is None or put_in <= 1:
        return ""
    return f": the losses of the box, which the rig file puts in, dominate with {significant(put_in, 2)} times that energy"


def _measured(report: Report) -> str:
    """Return the measured energies: of each condition where they are few, otherwise the range."""
    rows = report.conditions
    if len(rows) > FEW:
        low, high = (significant(1e3 * edge(row.W_exp for row in rows), 3) for edge in (min, max))
        return f"W_exp is {low} to {high} mJ per cycle in {len(rows)} conditions."
    each = [f"{row.id} {with_U(row.W_exp, row.U_W_exp, 1e3).text}" for row in rows]
    return f"W_exp in mJ per cycle: {', '.join(each)}." if each else ""


def found(report: Report) -> tuple[str, ...]:
    """Return the further findings: slope, mean offset and the condition that dominates it, refills,
    claims, flags.
    """
    parts = (_on_recorded, _line, _mean_offset, _nominal, _coverage, _claims, _flags)
    return tuple(filter(None, (part(report) for part in parts)))


def _on_recorded(report: Report) -> str:
    """Return the comparison with W_T on the recorded waveforms, where it was made."""
    ratio, U = report.agreement.ratio_recorded, report.agreement.U_ratio_recorded
    if ratio is None or U is None:
        return ""
    ruled = _ruled(report.agreement.put_in_recorded)
    amount = with_U(abs(ratio - 1), U, 100).text.replace(" ± ", " % ± ")
    return f"Against W_T on the recorded waveform W_exp is {amount} % {'more' if ratio >= 1 else 'less'}{ruled}."


def _line(report: Report) -> str:
    """Return the slope, or why none is stated (a true line has a chi^2 as large with a probability
    below 0.1 %).
    """
    found = report.agreement
    line = found.line
    if found.slope is None:
        if found.n < 2:
            return ""
        if line is None or line.slope is not None:
            return "The offset is not the same fraction of W_T in all conditions, so no slope is stated."
        return (
            f"No straight line describes W_exp against W_T (chi² {line.chi2:.0f}, {line.dof:.0f} degrees of "
            "freedom): the offset is not in proportion to W_T, and no slope is stated."
        )
    return f"Slope through the origin {with_U(found.slope, found.U_slope).text}."


def _mean_offset(report: Report) -> str:
    """Return the unweighted mean offset, and the condition that dominates it where one does."""
    mean = report.agreement.mean_offset
    rows = [(row.offset, row) for row in report.conditions if row.offset is not None]
    if mean is None or not rows:
        return ""
    offsets = sorted(offset for offset, _ in rows)
    if len(rows) == 1:
        return ""
    half = len(offsets) // 2
    median = (offsets[half] + offsets[~half]) / 2
    text = f"The mean offset of the {len(rows)} conditions above the detection limit is {_percent(mean)}"
    largest, top = max(rows, key=lambda each: abs(each[0]))
    without = (sum(offsets) - largest) / (len(rows) - 1) if len(rows) > 1 else mean
    if abs(largest) < 2 * sum(abs(o) for o in offsets) / 3 or len(rows) < 3:
        return f"{text}, the median {_percent(median)}."
    return (
        f"{text}. {top.id} dominates it: W_T is only {significant(1e3 * (top.W_T or 0.0), 2)} mJ there, and the offset "
        f"{_percent(largest)}. Without {top.id} the mean is {_percent(without)}; the median is "
        f"{_percent(median)}."
    )


def _nominal(report: Report) -> str:
    """Return the predicted difference between refilled beds and the nominal one, of which W_T is."""
    stated = [row for row in report.conditions if row.offset is not None]
    rows = [(row.refill_mean, row.W_T or 0.0, row) for row in stated if row.refill_mean is not None]
    if not rows:
        return ""
    mean = sum(W_T * refill for refill, W_T, _ in rows) / sum(W_T for _, W_T, _ in rows)
    largest, _, most = max(rows, key=lambda each: abs(each[0]))
    if abs(largest) < MENTIONED:
        return ""
    return (
        f"W_T is that of the nominal bed. The model predicts that refilled beds take {_beyond(mean)} on average over "
        f"the conditions (largest difference in {most.id}: {_beyond(largest)}). This difference is part "
        "of U of W_T, offset and ratio; their values are not corrected for it."
    )


def _beyond(relative: float) -> str:
    """Return a relative difference in words: "2 % more"."""
    return f"{_percent(abs(relative))} {'more' if relative > 0 else 'less'}"


def _coverage(report: Report) -> str:
    """Return the coverage of the stated intervals where refills scatter with a large skew, and the
    refills needed.
    """
    known = [
        (row.refill_coverage, row.refill_coverage_plain or 0.0, row) for row in report.conditions
    ]
    rows = [(stated, plain, row) for stated, plain, row in known if stated is not None]
    if not rows:
        return ""
    shown = [
        f"{row.id} (skew {row.refill_skew:.1f}) {100 * stated:.1f} % ({100 * plain:.1f} %{_needs(row)})"
        for stated, plain, row in sorted(rows, key=lambda each: each[1])
    ]
    rest = f"; no less in {len(shown) - FEW} more conditions" if len(shown) > FEW else ""
    return (
        "The scatter between refills is skewed, and a few refills agree too well by chance, so U of W_exp was widened. "
        "Coverage of the 95 % intervals, simulated with the model's refills (in brackets that of Student's t, and the "
        f"refills that it needs for 93 %): {', '.join(shown[:FEW])}{rest}."
    )


def _needs(row: ConditionRow) -> str:
    """Return the number of refills that Student's t needs for 93 %; "" where there are as many."""
    needed = row.refills_needed
    if needed is not None and needed <= len(row.runs):
        return ""
    return ", more than 128 refills" if needed is None else f", {needed} refills"


def _claims(report: Report) -> str:
    """Return how many claims hold, do not hold, are undecided, and are imposed."""
    if not report.claims:
        return ""
    count = Counter(row.verdict for row in report.claims)
    words = {
        "holds": "hold",
        "does not hold": "do not hold",
        "undecided": "are undecided",
        "imposed": "are imposed",
    }
    if len(report.claims) == 1:
        return f"The only claim: {report.claims[0].verdict}."
    single = {
        "holds": "holds",
        "does not hold": "does not hold",
        "undecided": "is undecided",
        "imposed": "is imposed",
    }
    listed = [
        f"{count[word]} {(single if count[word] == 1 else words)[word]}"
        for word in words
        if count[word]
    ]
    return f"Of {len(report.claims)} claims {', '.join(listed)}."


def _flags(report: Report) -> str:
    """Return the flags of the session."""
    names = [entry.flag for entry in report.flags]
    return f"Flags: {', '.join(names)}." if names else "No run carries a flag."


def _percent(value: float) -> str:
    """Return a fraction in per cent with two significant digits."""
    return f"{significant(100 * value, 2)} %"


def again(report: Report) -> tuple[tuple[str, str], ...]:
    """Return the commands that make this report again, with the effect of each."""
    name = re.sub(r"[^\w.-]", "_", report.protocol) or "protocol"
    again = ("rig report session.h5", "makes this report again from the record alone.")
    if not report.synthetic:
        return (again,)
    resolved = report.resolved
    run = (
        "repeats the whole session from its protocol, seed included; the session file holds it too."
    )
    if resolved is not None and resolved.protocol and resolved.rig:
        run = "repeats the whole session, seed included: both files are at the end of this page or in report.json."
        return ((f"rig run {name}.yaml --rig {name}_rig.yaml", run), again)
    return ((f"rig run {name}.yaml", run), again)
