"""Bad protocols: every mistake at once, each with its place, what was found, what is allowed and
the nearest word.
"""

from pathlib import Path

import pytest
import yaml

from daq.documents.notes import MOST_MISTAKES
from rig.documents import yaml_reader as reader
from rig.errors import InputError
from rig.protocol.load import load_protocol, protocol_template

LEAST = "schema: rig/protocol/1\nname: least\n"


@pytest.fixture(params=["C", "Python"])
def _either_parser(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Both YAML parsers: the C one is not built everywhere."""
    if request.param == "Python":
        monkeypatch.setattr(reader, "_LOADERS", (yaml.SafeLoader,))


def lines(source: str | Path, **changes: list[str]) -> list[str]:
    with pytest.raises(InputError) as caught:
        load_protocol(source, **changes)  # type: ignore[arg-type]
    return str(caught.value).splitlines()


def line(text: str, **changes: list[str]) -> str:
    (only,) = lines(f"{LEAST}{text}\n", **changes)
    return only


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("fidelity: aut", ["fidelity: found 'aut'", "as_written, auto", "did you mean 'auto'?"]),
        (
            "tolerance: 1 %",
            ["tolerance: found 0.01 with fidelity as_written", "add fidelity: auto"],
        ),
        (
            "{fidelity: auto, tolerance: 0}"[1:-1].replace(", ", "\n"),
            ["tolerance: found 0", "above 0, at most 1"],
        ),
        ("scene: {fidelity: auto}", ["scene.fidelity: found the key", "did you mean fidelity?"]),
        (
            "vary: {tolerance: [0.01]}",
            ["vary.tolerance: found the key 'tolerance'", "the path of a field under"],
        ),
        (
            "fidelity: auto\nvary: {scene.layers.rows: [4, 8]}",
            ["scene.layers.rows varied with fidelity auto"],
        ),
        (
            "fidelity: auto\nvary: {acquire.settle: [4]}",
            ["protocol:4: acquire.settle", "fidelity: as_written"],
        ),
        (
            "fidelity: auto\nvary: {scene.layers: [{rows: 4}, {rows: 8}]}",
            ["scene.layers: found scene.layers varied"],
        ),
        (
            "fidelity: auto\ndeliberate_error: {cycles: 3.5}",
            ["deliberate_error.cycles: found a deliberate error in the cycles"],
        ),
        ("sceen: {}", ["protocol:3: sceen: found the key 'sceen'", "did you mean 'scene'?"]),
        (
            "scene: {frequency: 5 Hz}",
            ["scene.frequency: found the key", "did you mean drive.frequency?"],
        ),
        (
            "scene: {grains: {fil: 0.5}}",
            ["scene.grains.fil: found the key", "did you mean 'fill'?"],
        ),
        (
            "scene: {cavity: {length: '150'}}",
            ["scene.cavity.length: found '150'", "units m, mm, cm, um"],
        ),
        ("scene: {cavity: {length: 150}}", ["150 is 150 m; did you mean 150 mm?", "at most 20 m"]),
        ("scene: {cavity: {length: 150 kg}}", ["found '150 kg'", "units m, mm, cm, um"]),
        ("scene: {cavity: {length: true}}", ["found true", "units m"]),
        ("scene: {cavity: {length: [1]}}", ["found a list", "units m"]),
        ("scene: {cavity: {length: null}}", ["found nothing", "units m"]),
        (
            "scene: {cavity: 5}",
            ["scene.cavity: found 5", "a mapping with the keys length, width, height, wall"],
        ),
        ("scene: {grains: {fill: 1.2}}", ["scene.grains.fill: found 1.2", "at least 0, at most 1"]),
        ("scene: {grains: {fill: 85}}", ["found 85", "did you mean 85 %?"]),
        ("scene: {grains: {fill: .nan}}", ["found .nan"]),
        (
            "scene: {grains: {density: -7900}}",
            ["scene.grains.density: found -7900", "above 0 kg/m^3"],
        ),
        (
            "scene: {grains: {material: stainles}}",
            ["found 'stainles'", "alumina, stainless, heavy", "'stainless'?"],
        ),
        ("scene: {grains: {diameter: 200 mm}}", ["grains of 0.2 m in a cavity of 0.15 m"]),
        ("scene: {grains: {fill: 0.1 %}}", ["less than half a layer"]),
        ("scene: {grains: {diameter: 1 um}}", ["340000 layers", "at most 20000"]),
        ("scene: {layers: {rows: 2.5}}", ["scene.layers.rows: found 2.5", "a whole number"]),
        ("scene: {layers: {side_walls: yes}}", ["found 'yes'", "true or false"]),
        ("scene: {losses: [noise, noise]}", ["'noise' twice"]),
        ("scene: {losses: noise}", ["found 'noise'", "a list of noise, air, gas, mount"]),
        (
            "scene: {bed: empty, axis: vertical, support: guide}",
            ["support guide", "none or cords on this axis"],
        ),
        ("scene: {bed: layer}", ["found 'layer'", "did you mean 'layers'?"]),
        (
            "scene: {bed: grains}",
            ["the bed grains, not built yet", "empty, locked, dashpot, single_mass, layers"],
        ),
        (
            "scene: {bed: single_mass, axis: vertical, single_mass: {friction: 0.3}}",
            [
                "scene.single_mass.friction: found friction 0.3 on axis vertical",
                "allowed: 0 on this axis",
            ],
        ),
        (
            "scene: {bed: single_mass, single_mass: {gap: 5 mm, start: 6 mm}}",
            ["scene.single_mass.start: found a start 0.006 m", "0.005 m"],
        ),
        (
            "scene: {axis: vertical}",
            [
                "scene.axis: found axis vertical with bed layers",
                "empty, locked, dashpot, single_mass",
            ],
        ),
        ("scene: {single_mass: {gap: never}}", ["scene.single_mass.gap: found 'never'"]),
        (
            "scene: {bed: single_mass, axis: vertical, single_mass: {gap: 500 mm}}",
            [
                "a gap of 0.5 m in a cavity of height 0.4 m; allowed: less than the cavity along the axis, or none"
            ],
        ),
        ("scene: {single_mass: {gap: -1}}", ["scene.single_mass.gap: found -1", "or none"]),
        ("drive: {mode: shaker}\nfidelity: auto", ["the drive shaker with fidelity auto"]),
        (
            "drive: {mode: shaker}\ndeliberate_error: {coil: true}",
            ["the deliberate error coil in shaker-coupled drive"],
        ),
        (
            "drive: {mode: shaker}\nacquire: {ranges: {force: auto}}",
            ["auto in shaker-coupled drive"],
        ),
        ("drive: {frequency: 0}", ["drive.frequency: found 0", "above 0 Hz"]),
        ("drive: {frequency: 5 kHz}", ["500 samples per cycle at 5000 Hz", "102400 S/s"]),
        ("drive: {frequency: 1 mHz}", ["found '1 mHz'", "units Hz, kHz"]),
        ("drive: {frequency: 1e-6}", ["samples per cycle at the analyzer's slowest rate"]),
        ("drive: {acceleration: -5}", ["drive.acceleration: found -5"]),
        ("acquire: {samples_per_cycle: 400}", ["found 400", "at least 500", "paper_rule: false"]),
        ("acquire: {settle: 1.5 cycles}", ["acquire.settle: found '1.5 cycles'", "a whole number"]),
        ("acquire: {record: 10000000}", ["samples in a run", "at most 1000000000"]),
        ("acquire: {analyzer: INV3118}", ["did you mean 'INV-3118'?"]),
        (
            "acquire: {sensors: {force: 352C33}}",
            ["acquire.sensors.force: found '352C33'", "208C02, 208C03"],
        ),
        ("vary: [1]", ["vary: found a list"]),
        (
            "vary: {scene.grains.fil: [1]}",
            ["vary.scene.grains.fil: found the key", "'scene.grains.fill'?"],
        ),
        (
            "vary: {seed: [1]}",
            ["vary.seed: found the key 'seed'", "a field under scene, drive, acquire"],
        ),
        ("vary: {scene.bed: layers}", ["found 'layers'", "a list of one or more values"]),
        ("vary: {scene.bed: []}", ["found a list", "a list of one or more values"]),
        ("vary: {zip: 3}", ["vary.zip: found 3"]),
        (
            "vary: {zip: {scene.bed: [layers], drive.frequency: [1, 2]}}",
            ["1 values of scene.bed", "equal length"],
        ),
        (
            "vary: {scene.grains: [{}], scene.grains.fill: [1]}",
            ["scene.grains.fill beside scene.grains"],
        ),
        (
            "vary:\n  drive.frequency:\n  - 10\n  - 10.0",
            ["protocol:6: drive.frequency", "stands in the grid already"],
        ),
        (
            "vary:\n  scene.bed:\n  - empty\n  - grains",
            ["protocol:6: scene.bed: found the bed grains"],
        ),
        ("repeats: 0", ["repeats.n: found 0", "at least 1"]),
        ("repeats: [4]", ["repeats: found a list"]),
        ("seed: -1", ["seed: found -1"]),
        ("seed: 1.5", ["seed: found 1.5", "a whole number"]),
        ("faults: [{channel: force}]", ["faults[1]: found no kind"]),
        ("expect: 3", ["expect: found 3"]),
        ("expect: [3]", ["expect[1]: found 3", "a mapping for each claim"]),
        ("rig: papr", ["protocol:3: rig: found no rig 'papr'", "did you mean 'paper'?"]),
        ("rig: ../nowhere.yaml", ["no rig"]),
        (f"rig: {'x' * 5000}", ["no rig"]),
        (f"rig: {'x' * 5000}.yaml", ["no rig"]),
        (
            "repeats: 10000\nvary: {drive.frequency: [1,2,3,4,5,6,7,8,9,10,11]}",
            ["110000 runs", "at most 100000"],
        ),
        ("<<: {seed: 1}", ["found the key '<<'"]),
        ("3: 4", ["found the key '3'"]),
    ],
)
def test_one_mistake(text: str, parts: list[str]) -> None:
    message = line(text)
    for part in parts:
        assert part in message


@pytest.mark.parametrize("name", ["../x", "", "a b", "x" * 81, "[a]", "-x", "null"])
def test_names_that_are_no_folder(name: str) -> None:
    (message,) = lines(f"schema: rig/protocol/1\nname: {name}\n")
    assert message.startswith("protocol:2: name: found")


def test_schema_and_name_are_needed() -> None:
    assert [m.split(": found")[0] for m in lines("seed: 1\n")] == [
        "protocol:1: name",
        "protocol:1: schema",
    ]
    assert "rig/protocol/1" in lines("schema: rig/protocol/2\nname: x\n")[0]


def test_every_mistake_at_once_in_the_order_of_the_lines() -> None:
    found = lines(
        "schema: rig/protocol/1\n"
        "name: many\n"
        "scene:\n"
        "  bed: layrs\n"
        "  cavity: {length: 150}\n"
        "  axis: vertical\n"
        "drive: {frequency: 0}\n"
        "acquire: {samples_per_cycle: 400}\n"
        "repeats: 0\n"
        "colour: red\n"
        "repeats: 3\n"
    )
    assert [message.split(": found")[0] for message in found] == [
        "protocol:4: scene.bed",
        "protocol:5: scene.cavity.length",
        "protocol:7: drive.frequency",
        "protocol:8: acquire.samples_per_cycle",
        "protocol:9: repeats.n",
        "protocol:10: colour",
        "protocol:11",
    ]


def test_a_flood_of_mistakes_is_cut() -> None:
    found = lines(LEAST + "".join(f"k{n}: 1\n" for n in range(200)))
    assert len(found) == MOST_MISTAKES + 1
    assert f"{200 - MOST_MISTAKES} more mistakes" in found[-1]


@pytest.mark.parametrize(
    ("changes", "start"),
    [
        ({"sets": ["scene.bed=grains"]}, "--set scene.bed=grains: scene.bed: found the bed grains"),
        (
            {"sets": ["scene.bd=single_mass"]},
            "--set scene.bd=single_mass: scene.bd: found the key 'bd'",
        ),
        ({"sets": ["scene.bed"]}, "--set scene.bed: found 'scene.bed'; allowed: path=value"),
        ({"sets": ["=3"]}, "--set =3: found '=3'"),
        ({"sets": ["scene.bed="]}, "--set scene.bed=: found an empty text"),
        ({"sets": ["scene.bed=]"]}, "--set scene.bed=]: found no YAML"),
        ({"sets": ["name.x=1"]}, "--set name.x=1: found a path through 'least'"),
        (
            {"sets": ["scene.axis=vertical"]},
            "--set scene.axis=vertical: scene.axis: found axis vertical",
        ),
        (
            {"varies": ["scene.grains.fill=[0.5, 85]"]},
            "--vary scene.grains.fill=[0.5, 85]: vary.scene.grains.fill: ",
        ),
        (
            {"varies": ["scene.grains.fill=0.5"]},
            "--vary scene.grains.fill=0.5: vary.scene.grains.fill: found 0.5",
        ),
        (
            {"varies": ["scene.bed=[layers, grains]"]},
            "--vary scene.bed=[layers, grains]: scene.bed: found the bed grains",
        ),
    ],
)
def test_command_line_changes_carry_their_place(changes: dict[str, list[str]], start: str) -> None:
    (message,) = lines(LEAST, **changes)
    assert message.startswith(start)


@pytest.mark.usefixtures("_either_parser")
@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("\n", "an empty text"),
        ("# only a comment\n", "an empty text"),
        ("just words\nmore\n", "a mapping with the keys"),
        ("a: [1, 2\nb: 3\n", "no YAML"),
        ("a:\n\tb: 1\n", "spaces, not with tabs"),
        ("a: 'open\n", "no YAML"),
        ("a: b: c\n", "no YAML"),
        ("\x00\x01\x02\n", "not text"),
        ("a: \ud800\n", "not text"),
        ("a: 1\n--- \nb: 2\n", "a second document"),
        ("a: !!python/object/apply:os.system [ls]\n", "the tag"),
        ("!!map {a: 1}\n", "the tag"),
        ("a: &x [*x]\n", "the alias *x"),
        ("a: *x\n", "the alias *x"),
        ("seed: 1\nseed: 2\n", "protocol:2: found the key 'seed' again"),
        ("[a, b]: 1\n", "a key that is not a word"),
        ("? {a: 1}\n: 2\n", "a key that is not a word"),
        ("{a: " + "[" * 100000 + "\n", "more than 20 levels"),
        ("a: [" + "x, " * 30000 + "]\n", "more than 20000 values"),
        ("a: " + "9" * 5000 + "\n", "the key 'a'"),
        ("name: {" + "k" * 100 + ": 1}\n", "name: found a mapping"),
        ("%YAML 9.0\n--- a\n", "no YAML"),
    ],
)
def test_texts_that_are_no_protocol(text: str, part: str) -> None:
    assert any(part in message for message in lines(text))


@pytest.mark.usefixtures("_either_parser")
@pytest.mark.parametrize("levels", [21, 999, 1001, 20_000])
@pytest.mark.parametrize("opener", ["[", "{a: ", "[{a: ", "- ", "? ", "- ? "])
def test_no_limit_of_a_parser_is_met_before_ours(opener: str, levels: int) -> None:
    """A parser may have a limit of its own on nesting (libyaml: 1000, 10000 or none, by version),
    and other words.
    """
    (message,) = lines(f"# a comment\nname:\n {opener * levels}\n")
    assert message.startswith("protocol:3: found more than 20 levels")


@pytest.mark.usefixtures("_either_parser")
def test_a_bomb_of_aliases_is_counted_before_it_goes_off() -> None:
    levels = "".join(f"l{n}: &l{n} [{', '.join([f'*l{n - 1}'] * 10)}]\n" for n in range(1, 16))
    (message,) = lines(f"l0: &l0 [1]\n{levels}")
    assert "more than 20000 values" in message


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    assert lines(tmp_path / "none.yaml") == [
        f"{tmp_path / 'none.yaml'}: found no such file or directory; allowed: a readable file"
    ]
    assert "a folder" in lines(tmp_path)[0]
    assert "an impossible path" in lines("a\0b")[0]
    empty, junk, huge, latin = (tmp_path / name for name in ("empty", "junk", "huge", "latin"))
    empty.write_bytes(b"")
    junk.write_bytes(bytes(range(256)) * 10)
    huge.write_bytes(b"\x00" * 10_000_000)
    latin.write_bytes(f"{LEAST}question: caf\xe9\n".encode("latin-1"))
    assert "an empty text" in lines(empty)[0]
    assert "not UTF-8" in lines(junk)[0]
    assert "more than 1 MiB" in lines(huge)[0]
    assert f"{latin}:3: found bytes that are not UTF-8" in lines(latin)[0]
    (tmp_path / "bom").write_bytes(b"\xef\xbb\xbf" + LEAST.encode())
    assert load_protocol(tmp_path / "bom").name == "least"


def test_long_values_are_cut_in_messages() -> None:
    for message in lines(LEAST, sets=[f"scene.bed={'x' * 5000}"]) + lines(
        f"{LEAST}seed: {'x' * 5000}\n"
    ):
        assert len(message) < 400


def test_the_template_has_no_mistakes() -> None:
    load_protocol(protocol_template())
