"""The comparison of two sessions in four forms: comparison.json, .csv, .md and .html."""

import csv
import io
from dataclasses import fields
from pathlib import Path

from analysis.comparison.two_sessions import FARTHEST
from analysis.report.figures.axes import BLUE, GREY, INK, ORANGE, Panel, legend, linear, logarithmic
from analysis.report.figures.drawing import Plot
from analysis.report.html import page
from analysis.report.markdown import plain, section_texts
from analysis.report.sections import Section
from analysis.report.tables.cells import UNKNOWN, Cell, Table, fixed, number, with_U
from analysis.results.comparison_rows import ComparedPair, ComparedSession, Comparison
from analysis.text import counted, escape
from daq.json_text import json_text
from daq.strange_text import cell_text
from daq.whole_files import write_folder

__all__ = ["comparison_sentences", "write_comparison"]

NAMES = {"material": "material", "density": "density", "diameter": "diameter", "fill": "fill", "frequency": "frequency",
         "acceleration": "acceleration"}  # fmt: skip


def write_comparison(found: Comparison, out_dir: Path) -> tuple[Path, ...]:
    """Write the comparison (analysis.comparison.two_sessions.compare) into out_dir; return the
    paths.

    out_dir is made where missing. Equal comparisons give equal bytes.
    """
    name = " against ".join(session.name for session in reversed(found.sessions))
    parts, sentences = _sections(found), comparison_sentences(found)
    head = [f"<h1>{escape(name)}</h1>", f"<p class='lead'>{escape(sentences[0])}</p>", "<section class='verdict good'>",
            f"<h2>Finding</h2><p class='result'>{escape(sentences[1])}</p>",
            *(f"<p>{escape(text)}</p>" for text in sentences[2:]), "</section>"]  # fmt: skip
    lines = [f"# {plain(name)}", *map(plain, sentences), *section_texts(parts)]
    files: dict[str, str | bytes] = {
        "comparison.csv": _csv(found),
        "comparison.md": "\n\n".join(lines) + "\n",
        "comparison.html": page(f"{name}: comparison", head, parts),
        **{f"figures/{plot.name}.svg": plot.svg for part in parts for plot in part.plots},
        "comparison.json": json_text(found.document()) + "\n",
    }
    return write_folder(out_dir, files)


def comparison_sentences(found: Comparison) -> tuple[str, ...]:
    """Return sentences about the sessions, the finding, the ranks, conditions left out, and
    assumptions.
    """
    a, b = (_who(session) for session in found.sessions)
    return tuple(
        filter(
            None,
            (f"A is {a}. B is {b}.", _overall(found), _single(found), _ranks(found), _basis(found)),
        )
    )


def _who(session: ComparedSession) -> str:
    kind = "simulated" if session.synthetic else "measured"
    ratio = "" if session.ratio is None else (
        f", W_exp/W_T = {with_U(session.ratio, session.U_ratio).text}"
    )  # fmt: skip
    what = "no usable condition" if not session.conditions else (
        f"bed {', '.join(session.beds)}, drive {', '.join(session.drives)}, "
        f"{counted(session.conditions, 'condition')}"
    )  # fmt: skip
    return f"{session.name} ({kind}, {what}, {session.verdict}{ratio})"


def _overall(found: Comparison) -> str:
    over = found.overall
    if over is None:
        if found.pairs:
            return "A dissipates nothing over the matched conditions: no ratio can be given."
        return f"No condition of both sessions has the same settings: nothing can be compared{_first_why(found)}."
    amount = with_U(abs(over.relative), over.U, 100).text.split(" ± ")
    margin = f" ± {amount[1]} %" if len(amount) > 1 else ""
    more = "more" if over.relative >= 0 else "less"
    word = "significant" if abs(over.relative) > over.U else "not significant"
    return (
        f"Over {counted(over.n, 'matched condition')} B dissipates {amount[0]} %{margin} {more} than A "
        f"(k = {over.k:.2f}, weighted with energy): {word} at 95 %."
    )


def _first_why(found: Comparison) -> str:
    return f" ({found.alone[0].id}: {found.alone[0].why})" if found.alone else ""


def _single(found: Comparison) -> str:
    rows = found.pairs
    sure = [row for row in rows if row.significant]
    if not rows:
        return ""
    names = (
        f": {', '.join(row.A for row in sure[:8])}{' and more' if len(sure) > 8 else ''}"
        if sure
        else ""
    )
    alone = [row for row in sure if min(row.runs_A, row.runs_B) == 1]
    refilled = (
        f" Of these {len(alone)} with a single run in a session: its U lacks the scatter between refills, and another "
        "refill may be the whole difference."
        if alone
        else ""
    )
    return (
        f"Taken one by one, {len(sure)} of {len(rows)} conditions differ significantly (5 % for all together, "
        f"Holm){names}.{refilled}"
    )


def _ranks(found: Comparison) -> str:
    ranks = found.ranks
    if ranks.tau is None:
        return ""
    interval = "" if ranks.interval is None else (
        f" (95 %: {ranks.interval[0]:.2f} to {ranks.interval[1]:.2f})"
    )  # fmt: skip
    text = (
        f"Ranks: Kendall's tau is {ranks.tau:.3f}{interval}; {ranks.opposite} of {ranks.orders} orders of two "
        f"conditions are opposite, {len(ranks.decided_opposite)} of them decided by both sessions"
    )
    some = ", ".join(ranks.decided_opposite[:5])
    return f"{text}{f' ({some})' if some else ''}."


def _basis(found: Comparison) -> str:
    same = (
        "Both sessions used the same instruments: what these do wrong is common and cancels."
        if found.same_instruments
        else "The instruments of the two sessions are taken for different ones: their errors do not cancel."
    )
    left_out = len(found.alone)
    alone = (
        f"{counted(left_out, 'condition')} {'is' if left_out == 1 else 'are'}"
        if left_out
        else "No condition is"
    )
    keys = ", ".join(NAMES[name] for name in found.matched_by)
    unknown = [
        name for name in found.matched_by if any(name in row.not_compared for row in found.pairs)
    ]
    left = (
        f"Not compared, because one of both does not know it: {', '.join(unknown)}. "
        if unknown
        else ""
    )
    return (
        f"Matched by {keys}, where both know them; bed and drive may differ. {left}{alone} left "
        f"out. {same} Levels up to {100 * FARTHEST:.0f} % apart are matched, the nearest; "
        "W is not corrected for what they differ by, it is in U."
    )


def _sections(found: Comparison) -> tuple[Section, ...]:
    plots, pairs, alone = _plots(found), _pairs(found), _alone(found)
    sections = (
        Section("Condition by condition", (), plots, (pairs,) if pairs.rows else ()),
        Section("Not compared", (), (), (alone,) if alone.rows else ()),
    )
    return tuple(section for section in sections if section.plots or section.tables)


def _plots(found: Comparison) -> tuple[Plot, ...]:
    stated = [
        (row, row.relative, row.U_relative or 0.0)
        for row in found.pairs
        if row.relative is not None
    ]
    if not stated:
        return ()
    rows = [row for row, _, _ in stated]
    W_A, W_B = [1e3 * row.W_A for row in rows], [1e3 * row.W_B for row in rows]
    both = [*W_A, *W_B]
    against = Panel(
        logarithmic(both),
        logarithmic(both),
        "W of A, mJ per cycle",
        "W of B, mJ per cycle",
        "B against A",
    )
    ends = (min(both), max(both))
    against.line(ends, ends, GREY, 1.0, "5 3")
    against.bars(W_A, W_B, [1e3 * row.U_B for row in rows], BLUE)
    offset, U = [100 * relative for _, relative, _ in stated], [100 * U for _, _, U in stated]
    limits = [y + sign * half for y, half in zip(offset, U, strict=True) for sign in (-1, 1)]
    apart = Panel(
        logarithmic(W_A),
        linear([*limits, 0.0]),
        "W of A, mJ per cycle",
        "B over A − 1, %",
        "Difference",
    )
    over = found.overall
    if over is not None:
        apart.spread(100 * (over.relative - over.U), 100 * (over.relative + over.U), ORANGE, 0.2)
        apart.level(100 * over.relative, ORANGE)
    apart.level(0.0, INK)
    apart.bars(W_A, offset, U, BLUE)
    alt = (
        f"{len(rows)} matched conditions: W of B against W of A with the line of equality, and the difference in per "
        "cent with 95 % uncertainty bars against W of A, the energy-weighted difference as a line with its band."
    )
    words = [
        ("o", BLUE, "a condition, with U (95 %)"),
        ("dash", GREY, "equal"),
        ("line", ORANGE, "energy-weighted, with U"),
    ]
    return (
        Plot("comparison", "B against A", alt, (legend(words), against.drawing(), apart.drawing())),
    )


def _pairs(found: Comparison) -> Table:
    head = ("A", "B", "grains", "fill, %", "f, Hz", "a of A, m/s²", "a of B, m/s²", "bed A",
            "bed B", "W of A ± U, mJ", "W of B ± U, mJ",
            "B − A, mJ", "B − A, %", "E_n", "p, Holm", "significant")  # fmt: skip
    rows = tuple(
        (
            Cell(row.A),
            Cell(row.B),
            Cell(_grains(row)),
            _setting(row.fill, 100),
            _setting(row.frequency),
            _setting(row.acceleration_A),
            _setting(row.acceleration_B),
            Cell(row.bed_A),
            Cell(row.bed_B),
            with_U(row.W_A, row.U_A, 1e3),
            with_U(row.W_B, row.U_B, 1e3),
            with_U(row.difference, row.U_difference, 1e3),
            with_U(row.relative, row.U_relative, 100),
            fixed(row.E_n, 2),
            number(row.p_holm, 2),
            Cell("yes" if row.significant else "no"),
        )
        for row in found.pairs
    )
    note = (
        "a: the level reached. The difference in per cent is left out where one of both is below its detection limit "
        "or its U."
    )
    return Table("Matched conditions", note, head, rows)


def _setting(value: float | None, scale: float = 1.0) -> Cell:
    """Return a setting with as many digits as it was written with, at most four."""
    return UNKNOWN if value is None else Cell(f"{scale * value:.4g}", scale * value)


def _grains(row: ComparedPair) -> str:
    size = "" if row.diameter is None else f" {1e3 * row.diameter:.4g} mm"
    return f"{row.material}{size}"


def _alone(found: Comparison) -> Table:
    rows = tuple((Cell(row.session), Cell(row.id), Cell(row.why)) for row in found.alone)
    return Table("Conditions without a match", "", ("session", "id", "why"), rows)


def _csv(found: Comparison) -> str:
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    names = [each.name for each in fields(ComparedPair)] if found.pairs else []
    table.writerow(names)
    table.writerows([[_plain(getattr(row, name)) for name in names] for row in found.pairs])
    return text.getvalue()


def _plain(value: object) -> object:
    if value is None:
        return ""
    return cell_text(" ".join(value) if isinstance(value, tuple) else value)
