"""The reading of records: dissipated energy from force and acceleration, its uncertainty, its agreement with a model.

Works on any session record, simulated or imported, and imports no simulator. Names load their module on first use.
"""

import importlib
from typing import TYPE_CHECKING

from daq.caches import place_caches

if TYPE_CHECKING:
    from analysis.between import compare
    from analysis.comparison import agreement
    from analysis.energies import Energy
    from analysis.energy import dissipated_energy
    from analysis.estimate import Estimate
    from analysis.reading import read_session, run_energy
    from analysis.record import AnalysisError, Record
    from analysis.report.between import write_comparison
    from analysis.report.files import write_report
    from analysis.runs import RunEnergy
    from analysis.setting import Setting

__all__ = [
    "AnalysisError",
    "Energy",
    "Estimate",
    "Record",
    "RunEnergy",
    "Setting",
    "agreement",
    "compare",
    "dissipated_energy",
    "read_session",
    "run_energy",
    "write_comparison",
    "write_report",
]

_HOME = {
    "AnalysisError": "analysis.record",
    "Energy": "analysis.energies",
    "Estimate": "analysis.estimate",
    "Record": "analysis.record",
    "RunEnergy": "analysis.runs",
    "Setting": "analysis.setting",
    "agreement": "analysis.comparison",
    "compare": "analysis.between",
    "dissipated_energy": "analysis.energy",
    "read_session": "analysis.reading",
    "run_energy": "analysis.reading",
    "write_comparison": "analysis.report.between",
    "write_report": "analysis.report.files",
}

place_caches()


def __getattr__(name: str) -> object:
    home = _HOME.get(name)
    if home is None:
        raise AttributeError(f"module 'analysis' has no attribute {name!r}")
    return getattr(importlib.import_module(home), name)
