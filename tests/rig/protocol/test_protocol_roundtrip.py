"""Random protocols survive the file; damaged files give a protocol or a list of mistakes, nothing
else.
"""

import random
from dataclasses import replace
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rig.catalog.entries import STATUSES, CatalogValue, Material
from rig.catalog.entries_by_name import names, sensors_for
from rig.catalog.stated_values import own_material
from rig.documents.yaml_writer import write_text, write_yaml
from rig.errors import InputError
from rig.protocol.claims import KINDS
from rig.protocol.deliberate_errors import DeliberateError
from rig.protocol.grid import conditions
from rig.protocol.load import dump_protocol, load_protocol, protocol_template
from rig.protocol.spec import (
    BUILT_BEDS,
    LOSSES,
    Acquire,
    Cavity,
    Dashpot,
    Drive,
    Expect,
    Grains,
    Layers,
    Protocol,
    Repeats,
    Scene,
    Sensors,
    SingleMass,
    Vary,
)
from rig.units import SMALLEST


def sizes(least: float, most: float, **ends: bool) -> st.SearchStrategy[float]:
    """Numbers of a range that the reader takes: 0, and none too small to be computed with."""
    return st.floats(least, most, **ends).filter(lambda x: x == 0 or abs(x) >= SMALLEST)


# Ranges inside which every combination fits: grains smaller than any cavity, at least one layer and
# at most 20000, at most 200 Hz so that 500 samples per cycle stay below the analyzer's 102.4 kS/s.
fractions = sizes(0, 1)
fills = sizes(0.1, 1)
diameters = sizes(1e-3, 1e-2)
frequencies = sizes(5, 200)
levels = sizes(1e-3, 1e3)
counts = st.integers(1, 500)
losses = st.permutations(LOSSES).flatmap(
    lambda p: st.integers(0, len(p)).map(lambda n: tuple(p[:n]))
)
densities = sizes(1, 3e4)


def own_materials(name: str) -> st.SearchStrategy[Material]:
    """Materials of one's own: a name stands for one material in a protocol."""
    return st.builds(
        lambda density, friction, status: own_material(
            name,
            {
                "density": CatalogValue("density", density, "kg/m^3", status, "drawn"),
                "wall_friction": CatalogValue("wall_friction", friction, "", "assumed", ""),
            },
        ),
        densities,
        sizes(0, 10),
        st.sampled_from(STATUSES),
    )


named = st.sampled_from(names("material"))
grains = st.builds(
    Grains, named | own_materials("balls"), diameters, fills, st.none() | densities
)  # fmt: skip
scenes = st.builds(
    Scene,
    cavity=st.builds(
        Cavity,
        sizes(0.02, 2),
        sizes(0.02, 2),
        sizes(0.1, 10),
        sizes(1e-4, 0.5),
        st.none() | named | own_materials("box"),
        st.none() | densities,
    ),
    grains=grains,
    bed=st.sampled_from(BUILT_BEDS),
    losses=losses,
    support=st.sampled_from(("none", "cords", "guide")),
    layers=st.builds(Layers, sizes(0, 1000), fractions, st.integers(1, 500), st.booleans()),
    single_mass=st.builds(
        SingleMass,
        fractions,
        st.none() | st.just("none") | sizes(0, 0.02, exclude_max=True),
        sizes(0, 10),
        st.just(0.0),
        sizes(-9, 9),
    ),
    dashpot=st.builds(Dashpot, sizes(0, 1e9)),
)
drives = st.builds(
    Drive,
    frequency=frequencies,
    acceleration=levels,
    imperfection=st.sampled_from(("default", "none")),
)
acquires = st.builds(
    Acquire,
    analyzer=st.sampled_from((*names("analyzer"), "ideal")),
    samples_per_cycle=st.integers(500, 512),
    settle=counts,
    record=counts,
    sensors=st.builds(
        Sensors,
        st.sampled_from((*sensors_for("force"), "ideal")),
        st.sampled_from((*sensors_for("acceleration"), "ideal")),
    ),
    paper_rule=st.booleans(),
)
VALUES: dict[str, st.SearchStrategy[Any]] = {
    "scene.grains.fill": fills,
    "scene.grains.diameter": diameters,
    "scene.bed": st.sampled_from(BUILT_BEDS),
    "scene.losses": losses,
    "scene.layers.rows": st.integers(1, 500),
    "scene.layers.side_walls": st.booleans(),
    "scene.single_mass.gap": st.none() | st.just("none") | sizes(0, 0.02, exclude_max=True),
    "scene.dashpot": st.builds(Dashpot, sizes(0, 1e9)),
    "drive.frequency": frequencies,
    "drive.acceleration": levels,
    "acquire.record": counts,
}


@st.composite
def grids(draw: st.DrawFn) -> tuple[Vary, ...]:
    """Up to four axes of one to three paths each, no row twice in its first column: no condition
    stands twice.
    """
    paths = draw(st.lists(st.sampled_from(sorted(VALUES)), unique=True, max_size=6))
    axes = []
    while paths:
        width = draw(st.integers(1, 3))
        mine, paths = paths[:width], paths[width:]
        first = draw(st.lists(VALUES[mine[0]], min_size=1, max_size=3, unique=True))
        columns = [
            first,
            *(
                draw(st.lists(VALUES[path], min_size=len(first), max_size=len(first)))
                for path in mine[1:]
            ),
        ]
        axes.append(Vary(tuple(mine), tuple(zip(*columns, strict=True))))
    return tuple(axes)


CLAIMED = sorted(set(VALUES) - {"scene.losses", "scene.dashpot"})
words = st.text(min_size=1, max_size=20).filter(str.strip)
margins = sizes(1e-6, 1)


@st.composite
def claims(draw: st.DrawFn) -> Expect:
    """Any claim that a protocol file can hold."""
    kind = draw(st.sampled_from(sorted(KINDS)))
    paths = draw(st.lists(st.sampled_from(CLAIMED), unique=True, max_size=2))
    parts: dict[str, Any] = {
        "claim": draw(words),
        "kind": kind,
        "imposed": draw(st.just("") | words),
    }
    parts["at"] = {
        path: tuple(draw(st.lists(VALUES[path], min_size=1, max_size=2))) for path in paths
    }
    path = parts["path"] = (
        "drive.acceleration" if kind == "nonlinear" else draw(st.sampled_from(CLAIMED))
    )
    several = {
        "optimum": (1, 3),
        "order": (2, 3),
        "rise": (2, 2),
        "fall": (2, 2),
        "nearly_zero": (2, 2),
    }
    if kind in several:
        least, most = several[kind]
        wide = (
            path if path != "scene.layers.side_walls" else "scene.grains.fill"
        )  # it has two values only
        parts["path"] = wide
        parts["values"] = tuple(
            draw(st.lists(VALUES[wide], min_size=least, max_size=most, unique=True))
        )
    if "over" in KINDS[kind]:
        parts["over"] = draw(st.just("") | st.sampled_from(CLAIMED))
    if "margin" in KINDS[kind]:
        parts["limits"] = (draw(margins),)
    if kind == "offset_within":
        parts["path"] = draw(st.just("") | st.just(path))
        parts["limits"] = tuple(
            sorted(draw(st.lists(sizes(-1, 100), min_size=2, max_size=2, unique=True)))
        )
    return Expect(**parts)


deliberate_errors = st.one_of(
    st.just(DeliberateError()),
    st.builds(DeliberateError, corners=sizes(-0.9, 10)),
    st.builds(DeliberateError, skew=st.integers(1, 1000)),
    st.builds(DeliberateError, clock=sizes(1e-9, 1000)),
    st.builds(DeliberateError, offset=sizes(-1, 1)),
    st.builds(DeliberateError, coil=st.booleans()),
)
protocols = st.builds(
    Protocol,
    name=st.from_regex(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,79}", fullmatch=True).map(str.strip),
    question=st.text(max_size=40),
    scene=scenes,
    drive=drives,
    acquire=acquires,
    vary=grids(),
    repeats=st.builds(Repeats, st.integers(1, 100), st.booleans()),
    seed=st.integers(0, 2**63 - 1),
    expect=st.lists(claims(), max_size=3).map(tuple),
    deliberate_error=deliberate_errors,
)
found_by_auto = ("scene.layers.rows", "acquire.record")
with_tolerance = st.builds(
    replace,
    protocols.filter(
        lambda p: not any(path in found_by_auto for axis in p.vary for path in axis.paths)
    ),
    fidelity=st.just("auto"),
    tolerance=st.none() | sizes(0, 1, exclude_min=True),
)
quick = settings(deadline=None, max_examples=100, suppress_health_check=[HealthCheck.too_slow])


@quick
@given(protocols | with_tolerance)
def test_load_of_dump_is_identity(protocol: Protocol) -> None:
    text = dump_protocol(protocol)
    loaded = load_protocol(text)
    assert loaded == protocol
    assert dump_protocol(loaded) == text
    assert conditions(loaded) == conditions(protocol)


def test_a_minus_zero_is_written_as_a_zero() -> None:
    text = dump_protocol(
        Protocol(name="x", expect=(Expect("words", "offset_within", limits=(-0.0, 1.0)),))
    )
    assert "-0.0" not in text
    assert dump_protocol(load_protocol(text)) == text


@quick
@given(st.text())
def test_any_text_is_written_so_that_it_is_read_back(text: str) -> None:
    assert (
        load_protocol(f"schema: rig/protocol/1\nname: x\nquestion: {write_text(text)}\n").question
        == text
    )
    assert yaml.safe_load(f'{{a: {write_text(text)}, "b": 1}}')["b"] == 1


def test_plain_texts_are_texts_for_other_readers_too() -> None:
    """Model names, units and words as the files hold them: PyYAML, which follows YAML 1.1, sees the
    same text.
    """
    for text in (
        "INV-3118",
        "5 m/s^2",
        "85 %",
        "layers",
        "rig/protocol/1",
        "1e5",
        "2100E11",
        "true",
        "null",
        "12:30",
    ):
        assert (
            load_protocol(
                f"schema: rig/protocol/1\nname: x\nquestion: {write_text(text)}\n"
            ).question
            == text
        )
        assert yaml.safe_load(write_yaml({"a": text}))["a"] == text


NASTY = [*"{}[]:,&*!|>'\"%@`#-?~\t\n\r \\", "\x00", "\x85", "\u2028", "\ufeff", "\U0001f600", "é", "- ", ": ", "<<: ",
         "&a ", "*a ", "!!int ", "1e999", ".nan", "-.inf", "0x1F", "1_000", "9" * 400, "null", "---\n", "...\n",
         "  ", "? ", "%YAML 1.2\n", "[" * 30, "{a: " * 30]  # fmt: skip


def damaged_once(text: str, rng: random.Random) -> str:
    """The text with one insertion, deletion or replacement of characters, lines or words."""
    at, upto = sorted((rng.randrange(len(text) + 1), rng.randrange(len(text) + 1)))
    lines = text.splitlines(keepends=True) or [""]
    line = rng.randrange(len(lines))
    match rng.randrange(8):
        case 0:
            return text[:at] + rng.choice(NASTY) + text[at:]
        case 1:
            return text[:at] + text[at + rng.randint(1, 5) :]
        case 2:
            return text[:at] + chr(rng.randrange(1, 0x300)) + text[at + 1 :]
        case 3:
            return text[:at] + text[upto:]
        case 4:
            return "".join(lines[:line] + [lines[line]] * 2 + lines[line + 1 :])
        case 5:
            return "".join(lines[:line] + lines[line + 1 :])
        case 6:
            return "".join([*lines[:line], "  ", *lines[line:]])
        case _:
            return text.replace(rng.choice(text.split() or ["a"]), rng.choice(NASTY))


def outcome_of(text: str) -> Protocol | InputError:
    try:
        return load_protocol(text)
    except InputError as error:
        return error


@pytest.mark.parametrize("seed", range(4))
def test_damaged_files_give_a_protocol_or_mistakes(seed: int) -> None:
    """500 damaged texts for each seed, 2000 in all."""
    rng = random.Random(seed)
    whole = [protocol_template(), dump_protocol(load_protocol(protocol_template()))]
    outcomes = set()
    for _ in range(500):
        text = rng.choice(whole)
        for _ in range(rng.randint(1, 4)):
            text = damaged_once(text, rng)
        outcomes.add(type(outcome_of(f"{text}\n")))
    assert outcomes == {Protocol, InputError}
