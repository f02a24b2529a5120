"""All hard cases, in the order of the stability page; each runs once per process."""

from functools import cache

from rig.benchmarks.hard import beds, chains, coupled, ledgers, orbits, pairs, rows, single_masses
from rig.benchmarks.hard.case import Case, CaseOutcome

GROUPS: tuple[tuple[str, tuple[Case, ...]], ...] = (
    ("Collision of a pair", pairs.CASES),
    ("Files of grains", chains.CASES),
    ("Rows of bed `layers`", (*rows.CASES, *orbits.CASES)),
    ("Bed `single_mass`", single_masses.CASES),
    ("Shaker-coupled drive", coupled.CASES),
    ("Scenes at the edge", beds.CASES),
    ("Long runs", ledgers.CASES),
)

CASES: tuple[Case, ...] = tuple(case for _, cases in GROUPS for case in cases)


@cache
def outcome(name: str) -> CaseOutcome:
    """Return the outcome of the case with a name."""
    return next(case for case in CASES if case.name == name).run()
