"""The sections of the report below the verdict, in reading order: the source of both page and
Markdown.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from analysis.report import report_sentences
from analysis.report.figures.cycles import repeats_plot, waveform_plot
from analysis.report.figures.drawing import Plot
from analysis.report.figures.energy import energy_plots
from analysis.report.figures.offset import bland_altman, nulls_plot, offset_plot, terms_plot
from analysis.report.figures.sweep import sweep_plot
from analysis.report.tables import report_tables as tables
from analysis.report.tables.cells import Table
from analysis.report.tables.fidelity import fidelity
from analysis.report.tables.gauge_position import at_box
from analysis.report.tables.offset_tables import causes, offset_terms
from analysis.report.tables.predictions import predictions
from analysis.report.tables.sweep import sweeps
from analysis.results.report import Report

__all__ = ["Section", "plots", "sections"]


@dataclass(frozen=True, slots=True)
class Section:
    """A headed part of the report: sentences, figures, tables."""

    title: str
    sentences: tuple[str, ...]
    plots: tuple[Plot, ...]
    tables: tuple[Table, ...]


def sections(report: Report, figures: bool = True) -> tuple[Section, ...]:
    """Return the sections that have content."""

    def part(
        title: str, plots: Sequence[Plot | None], *found: Table, sentences: Sequence[str] = ()
    ) -> Section:
        drawn = tuple(plot for plot in plots if plot is not None) if figures else ()
        return Section(
            title, tuple(sentences), drawn, tuple(table for table in found if table.rows)
        )

    made = (
        part("Flags", (), tables.flags(report)),
        part(
            "Energy per cycle",
            energy_plots(report),
            tables.conditions(report),
            predictions(report),
            tables.recorded(report),
            tables.coil(report),
            at_box(report),
        ),
        part(
            "Offset of measured from predicted", (offset_plot(report),), tables.comparisons(report)
        ),
        part(
            "Nulls and references",
            (nulls_plot(report),),
            tables.nulls(report),
            tables.references(report),
        ),
        part(
            "Where the offset comes from",
            (terms_plot(report),),
            offset_terms(report),
            causes(report),
        ),
        part("Uncertainty", (), tables.budget(report), tables.budget_of_W_T(report)),
        part("Sweeps", (sweep_plot(report),), sweeps(report)),
        part("Waveforms", (waveform_plot(report),)),
        part("Cycles and runs", (repeats_plot(report),)),
        part("What was claimed", (), tables.claims(report)),
        part(
            "Instruments and values",
            (),
            tables.instruments(report),
            tables.values(report),
            fidelity(report),
        ),
        part(
            "To reproduce",
            (),
            sentences=[f"{command}: {why}" for command, why in report_sentences.again(report)],
        ),
        part("Difference against mean", (bland_altman(report),)),
    )
    return tuple(
        section for section in made if section.plots or section.tables or section.sentences
    )


def plots(report: Report) -> tuple[Plot, ...]:
    """Return the figures for which the report has data, in the order of the page."""
    return tuple(plot for section in sections(report) for plot in section.plots)
