"""Mutated protocols: a protocol, or a list of mistakes with their places. Nothing else ever comes
out.
"""

import random
from collections import Counter
from pathlib import Path

import pytest

from rig.campaign.resolve import campaign_of
from rig.catalog.rig_file import load_rig
from rig.errors import InputError
from rig.protocol.load import dump_protocol, load_protocol

ROOT = Path(__file__).parents[3]
SOURCES = sorted((ROOT / "protocols").rglob("*.yaml"))
VALUES = (
    "",
    "null",
    "true",
    "-1",
    "0",
    "1e308",
    "-1e308",
    "1e-320",
    "99999999999999999999",
    ".nan",
    ".inf",
    "[]",
    "{}",
    "[1, [2, [3]]]",
    "{a: {b: {c: d}}}",
    "'20'",
    "20 Hz",
    "20 mm",
    "5 m/s^2",
    "-3 %",
    "300 %",
    "x" * 300,
    "größe",
    "!!python/object:os.system x",
    "&a [*a]",
    "*nothing",
    "|\n  text",
    "\t",
    "none",
    "layers",
    "[layers, single_mass, grains]",
    "1 2 3",
    "0x10",
    "1_000",
    "~",
    "@",
    "\x00",
    "\x1b[2J",
    "- - -",
    "? :",
    "2026-11-22",
    "12:30:45",
    "yes",
    "=",
    "<<: *a",
)
KEYS = (
    "scene",
    "grains",
    "fill",
    "vary",
    "zip",
    "repeats",
    "seed",
    "drive.acceleration",
    "scene.bed",
    "schema",
    "deliberate_error",
    "faults",
    "expect",
    "rig",
    "name",
    "__class__",
    "",
    "0",
)


def mutated(text: str, rng: random.Random) -> str:
    for _ in range(rng.choice((1, 1, 2, 4))):
        lines = text.splitlines() or [""]
        at = rng.randrange(len(lines))
        line = lines[at]
        match rng.randrange(11):
            case 0:  # another value
                lines[at] = line.partition(":")[0] + ": " + rng.choice(VALUES)
            case 1:  # another key
                lines[at] = (
                    " " * (len(line) - len(line.lstrip()))
                    + rng.choice(KEYS)
                    + ":"
                    + line.partition(":")[2]
                )
            case 2:
                del lines[at]
            case 3:
                lines.insert(at, line)
            case 4:
                lines[at] = " " * rng.randrange(9) + line.lstrip()
            case 5 if line:
                place = rng.randrange(len(line))
                lines[at] = (
                    line[:place] + rng.choice("{}[]:,&*!|>'\"%@`#- \t\x00é0") + line[place + 1 :]
                )
            case 6:
                other = rng.randrange(len(lines))
                lines[at], lines[other] = lines[other], lines[at]
            case 7:
                return text[: rng.randrange(len(text) + 1)]
            case 8:
                lines.insert(
                    at, f"{' ' * rng.randrange(5)}{rng.choice(KEYS)}: {rng.choice(VALUES)}"
                )
            case 9:
                words = line.split(" ")
                words[rng.randrange(len(words))] = rng.choice(VALUES)
                lines[at] = " ".join(words)
            case _:
                start = rng.randrange(len(text) + 1)
                return text[:start] + text[rng.randrange(len(text) + 1) :]
        text = "\n".join(lines) + "\n"
    return text


def outcome(text: str) -> str:
    """What reading a text comes to. Anything but an InputError goes up to the test."""
    try:
        protocol = load_protocol("\n" + text)
    except InputError as error:
        return "refused" if error.mistakes and str(error) else "refused without a word"
    assert load_protocol(dump_protocol(protocol)) == protocol
    try:
        campaign_of(protocol, load_rig(protocol.rig))
    except InputError:
        return "refused as a whole"
    return "runs"


def fuzz(seeds: range) -> Counter[str]:
    texts = [path.read_text(encoding="utf-8") for path in SOURCES]
    found: Counter[str] = Counter()
    for seed in seeds:
        rng = random.Random(seed)
        found[outcome(mutated(rng.choice(texts), rng))] += 1
    return found


def test_four_hundred_mutated_protocols() -> None:
    found = fuzz(range(400))
    assert found["refused"] > 150
    assert not found["refused without a word"]
    assert found["runs"] > 40  # comments, order and harmless values may change


@pytest.mark.slow
def test_ten_thousand_mutated_protocols() -> None:
    found = fuzz(range(10000, 20000))
    assert sum(found.values()) == 10000
    assert not found["refused without a word"]
