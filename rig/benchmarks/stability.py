"""`make stability`: run every hard case (rig/benchmarks/hard) and write docs/stability.md; --check
compares instead.
"""

import argparse
import re
import sys
from pathlib import Path

from daq.whole_files import write_whole
from rig.benchmarks.hard.case import Case, Measure, plain
from rig.benchmarks.hard.suite import CASES, GROUPS, outcome

PAGE = Path(__file__).resolve().parents[2] / "docs" / "stability.md"

HEAD = """# Stability: the hard cases

Made by `make stability`; do not edit. Each case provokes a failure, on purpose, and is a test
(`tests/physics/hard/`, definitions in `rig/benchmarks/hard/`). Required everywhere: no NaN, no
energy from nothing, finite time, and a named error or a flagged result in the place of a wrong
number. Errors are shown as the next power of ten, which is what machines agree on, other
numbers ("~") by two digits. Where the failure is cheap to show, "a naive method" says what a
method that falls for it gives. "40 digits" is event-by-event motion in decimal arithmetic
(`rig/benchmarks/hard/exact.py`), which shares nothing with the code that it judges.

"""

COLUMNS = ("case", "provokes", "required", "measured (limit)", "a naive method", "held")

DECADE = re.compile(r"below 1e(-?\d+)|(?<=: )0(?= \(at most)")
NOTHING = "-400"  # stands for the decade of an error of zero, below all others
ROUGH = re.compile(r"~(\d[\d.e-]*)")


def page() -> str:
    """Return the page's text after running every case."""
    held = sum(outcome(case.name).held for case in CASES)
    lines = [HEAD + f"{held} of {len(CASES)} cases held."]
    for title, cases in GROUPS:
        lines += [
            "",
            f"## {title}",
            "",
            _line(COLUMNS),
            _line(["---"] * len(COLUMNS)),
            *map(_row, cases),
        ]
    return "\n".join(lines) + "\n"


def differences(stored: str, made: str) -> list[str]:
    """Return the lines in which two pages differ beyond round-off.

    Machines and libraries round differently: a number stated as below a power of ten may come out
    smaller, or larger by one decade; a number with "~" may differ by a tenth.
    """
    old, new = stored.splitlines(), made.splitlines()
    if len(old) != len(new):
        return [f"{len(old)} lines stored, {len(new)} made"]
    return [f"stored: {a}\nmade:   {b}" for a, b in zip(old, new, strict=True) if not _same(a, b)]


def _same(one: str, other: str) -> bool:
    bare = [ROUGH.sub("~", DECADE.sub("below", line)) for line in (one, other)]
    if bare[0] != bare[1]:
        return False
    decades = zip(DECADE.findall(one), DECADE.findall(other), strict=True)
    numbers = zip(ROUGH.findall(one), ROUGH.findall(other), strict=True)
    return all(int(b or NOTHING) - int(a or NOTHING) <= 1 for a, b in decades) and all(
        abs(float(a) - float(b)) <= 0.1 * max(abs(float(a)), abs(float(b))) for a, b in numbers
    )


def _row(case: Case) -> str:
    found = outcome(case.name)
    return _line(
        (
            case.name,
            case.provokes,
            case.required,
            "<br>".join(map(_measured, found.measured)),
            "<br>".join(map(_measured, found.naive)),
            "yes" if found.held else "**no**",
        )
    )


def _measured(measure: Measure) -> str:
    limit = f" (at most {plain(measure.limit)})" if measure.rule == "at most" else ""
    return f"{measure.what}: {measure.shown}{limit}"


def _line(cells: tuple[str, ...] | list[str]) -> str:
    return f"| {' | '.join(cell.replace('|', '&#124;') for cell in cells)} |"


def main() -> None:
    """Write the page, or compare it; exit 1 where a case did not hold or the page differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--check", action="store_true", help="compare docs/stability.md with what would be written"
    )
    check = parser.parse_args().check
    made = page()
    broken = [case.name for case in CASES if not outcome(case.name).held]
    if check:
        broken += differences(PAGE.read_text(encoding="utf-8"), made)
    else:
        write_whole(PAGE, made)
    print("\n".join(broken) or f"{len(CASES)} cases held")
    sys.exit(1 if broken else 0)


if __name__ == "__main__":
    main()
