"""Shipped protocols go by name, in every command that takes a protocol; a file of that name comes
first.
"""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from rig.cli.app import app
from rig.errors import InputError
from rig.protocol import shipped
from rig.protocol.load import load_protocol

ROOT = Path(__file__).parents[3]


def test_every_protocol_of_the_repository_has_a_name() -> None:
    files = {
        path.relative_to(ROOT / "protocols").as_posix()
        for path in (ROOT / "protocols").rglob("*.yaml")
    }
    assert {f"{name}.yaml" for name in shipped.names()} == files
    assert {"fill_rate", "gallery/skew"} <= set(shipped.names())


@pytest.mark.parametrize("name", shipped.names())
def test_a_name_is_read_anywhere(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert load_protocol(name) == load_protocol(ROOT / "protocols" / f"{name}.yaml")


def test_a_file_comes_first_and_a_folder_does_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("density").mkdir()
    Path("fill_rate").write_text("schema: rig/protocol/1\nname: mine\n", encoding="utf-8")
    assert load_protocol("fill_rate").name == "mine"
    assert load_protocol("density").name == "density"


@pytest.mark.parametrize(
    "words", [["run"], ["check"], ["model"], ["calibrate", "--target", "0.07", "--out", "x.yaml"]]
)
def test_an_unknown_name_gets_the_nearest_one_as_hint(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, [words[0], "fil_rate", *words[1:]])
    assert done.exit_code == 2
    said = " ".join(done.stderr.split())
    assert "no file and no shipped protocol 'fil_rate'" in said
    assert "did you mean 'fill_rate'?" in said
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("path", ["protocols/fill_rate.yaml", "fill_rate.yaml", "gallery/scew"])
def test_a_missing_path_gets_the_shipped_name_as_hint(
    path: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=r"did you mean '(fill_rate|gallery/skew)'\?"):
        load_protocol(path)
