"""The JSON Schemas of report.json (rig/agreement/2) and comparison.json (rig/comparison/1), for
other readers.

They are generated from the classes of analysis.results, whose docstrings and docs/report.md have
the meanings. SI units, energies in J per cycle; null means not known. Further keys may be added
under the same schema; those that are required here stay.
"""

from collections.abc import Mapping
from typing import Any

from analysis.results import comparison_rows, report
from daq.documents.classes import shape_of
from daq.documents.json_schema import document_schema

__all__ = ["COMPARED", "REPORT", "comparison_schema", "report_schema"]

REPORT, COMPARED = shape_of(report.Report), shape_of(comparison_rows.Comparison)


def comparison_schema() -> Mapping[str, Any]:
    """Return the JSON Schema of comparison.json."""
    return document_schema(COMPARED, f"Two sessions compared, {comparison_rows.SCHEMA}")


def report_schema() -> Mapping[str, Any]:
    """Return the JSON Schema of report.json."""
    return document_schema(REPORT, f"Agreement report, {report.SCHEMA}")
