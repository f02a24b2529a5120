"""Analysis of records: dissipated energy from force and acceleration, its uncertainty, its
agreement with a model.

Works on any session record, simulated or imported, and imports no simulator. Names load their
module on first use.
"""

import importlib
from typing import TYPE_CHECKING

from daq.caches import place_caches

if TYPE_CHECKING:
    from analysis.comparison.two_sessions import compare
    from analysis.comparison.whole_session import agreement
    from analysis.energy.energy_and_phasors import Energy
    from analysis.energy.per_cycle import dissipated_energy
    from analysis.pipeline import read_session, run_energy
    from analysis.report.files import read_report, write_report
    from analysis.report.two_sessions import write_comparison
    from analysis.results.comparison_rows import Comparison
    from analysis.results.report import Report
    from analysis.results.run import RunEnergy
    from analysis.session.record import AnalysisError, RecordedSession
    from analysis.session.setting import Setting
    from analysis.uncertainty.estimate import Estimate

__all__ = [
    "AnalysisError",
    "Comparison",
    "Energy",
    "Estimate",
    "RecordedSession",
    "Report",
    "RunEnergy",
    "Setting",
    "agreement",
    "compare",
    "dissipated_energy",
    "read_report",
    "read_session",
    "run_energy",
    "write_comparison",
    "write_report",
]

_HOME = {
    "AnalysisError": "analysis.session.record",
    "Comparison": "analysis.results.comparison_rows",
    "Energy": "analysis.energy.energy_and_phasors",
    "Estimate": "analysis.uncertainty.estimate",
    "RecordedSession": "analysis.session.record",
    "Report": "analysis.results.report",
    "RunEnergy": "analysis.results.run",
    "Setting": "analysis.session.setting",
    "agreement": "analysis.comparison.whole_session",
    "compare": "analysis.comparison.two_sessions",
    "dissipated_energy": "analysis.energy.per_cycle",
    "read_report": "analysis.report.files",
    "read_session": "analysis.pipeline",
    "run_energy": "analysis.pipeline",
    "write_comparison": "analysis.report.two_sessions",
    "write_report": "analysis.report.files",
}

place_caches()


def __getattr__(name: str) -> object:
    home = _HOME.get(name)
    if home is None:
        raise AttributeError(f"module 'analysis' has no attribute {name!r}")
    return getattr(importlib.import_module(home), name)
