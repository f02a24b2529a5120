"""Rates and numbers of other tools' files that are absurd: each is refused in one sentence."""

import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io

from daq.formats.reading import read_columns
from daq.formats.sidecar import read_sidecar
from daq.formats.uff58 import write_uff58
from daq.formats.wave import FormatError, Wave
from daq.session.plan import SessionError
from daq.session.record import open_session
from rig.errors import InputError
from rig.importing.mapping import read_mapping

SESSION = Path(__file__).parents[1] / "data" / "session-v1.h5"
LONG = "1" + "0" * 400
"""A whole number beyond every float."""


def as_npz(path: Path, value: str) -> None:
    told = '[{"name": "F", "fs": 1000.0}, {"name": "a", "fs": %s}]' % value  # noqa: UP031  braces
    np.savez(path, channels=np.array(told), data_0=np.arange(100.0), data_1=np.arange(100.0))


def as_mat(path: Path, value: str) -> None:
    scipy.io.savemat(path, {"F": np.arange(100.0), "a": np.arange(100.0), "fs": float(value)})


def as_tdms(path: Path, value: str) -> None:
    nptdms = pytest.importorskip("nptdms")
    step = {
        "wf_increment": value if value.isalpha() and value not in ("nan", "inf") else float(value)
    }
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment(
            [nptdms.ChannelObject("x", name, np.arange(100.0), step) for name in "Fa"]
        )


def as_uff(path: Path, value: str) -> None:
    pytest.importorskip("pyuff")
    waves = [Wave(name, "force", "N", Held(np.arange(100.0)), 1000.0) for name in "Fa"]
    write_uff58(path, "x", waves)
    path.write_text(path.read_text().replace("  1.00000e-03", f"{float(value):13.5e}"))


class Held:
    """Samples in memory."""

    def __init__(self, values: np.ndarray) -> None:
        self.values, self.size = values, values.size

    def chunks(self, length: int = 64) -> Iterator[np.ndarray]:
        yield from (self.values[start : start + length] for start in range(0, self.size, length))

    def samples(self) -> np.ndarray:
        return self.values


ABSURD = ("0", "-1", "1e-12", "1e12", "nan", "inf")
RATES: dict[str, tuple[str, Callable[[Path, str], None], tuple[str, ...]]] = {
    "sep005": (
        "x.npz",
        as_npz,
        (
            "0",
            "-1",
            "NaN",
            "Infinity",
            "-Infinity",
            "1e999",
            "1e12",
            '"x"',
            "null",
            "true",
            "[]",
            "{}",
            LONG,
        ),
    ),
    "mat": ("x.mat", as_mat, ABSURD),
    "tdms": ("x.tdms", as_tdms, ("-1", "1e-12", "1e12", "nan", "inf", "text")),
    "uff58": ("x.uff", as_uff, ABSURD),
}


@pytest.mark.parametrize("kind", RATES)
def test_an_absurd_rate_is_refused_in_one_sentence(tmp_path: Path, kind: str) -> None:
    name, make, values = RATES[kind]
    first = "x/F" if kind == "tdms" else "F"
    for value in values:
        make(tmp_path / name, value)
        with pytest.raises(FormatError, match=r"fs|rate|wf_increment|reading data-set") as caught:
            read_columns(tmp_path / name, kind, [first, first.replace("F", "a")])
        assert re.search("expected|cannot be read", str(caught.value))
        assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(
    "value", ["0", "-1", "nan", ".nan", ".inf", "-.inf", "1e999", "x", "[]", "true", LONG]
)
@pytest.mark.parametrize(
    "field", ["rate", "frequency", "settle", "length", "condition: {density", "force: {noise"]
)
def test_an_absurd_number_of_a_mapping_is_refused_in_one_sentence(
    tmp_path: Path, field: str, value: str
) -> None:
    if (field, value) in (("settle", "0"), ("force: {noise", "0")):
        return
    head = "schema: rig/map/1\nname: x\nacceleration: {channel: a}\n"
    force = "" if field.startswith("force") else "force: {channel: F}\n"
    close = ", channel: F}" if field.startswith("force") else "}" if "{" in field else ""
    (tmp_path / "map.yaml").write_text(f"{head}{force}{field}: {value}{close}\n")
    with pytest.raises(InputError) as caught:
        read_mapping(tmp_path / "map.yaml")
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize("value", ["0", "-1", "NaN", "Infinity", "1e999", '"x"', "null", LONG])
def test_an_absurd_rate_beside_an_export_is_refused(tmp_path: Path, value: str) -> None:
    (tmp_path / "r.csv.json").write_text('{"schema": "rig/export/1", "rate": %s}' % value)  # noqa: UP031
    with pytest.raises(FormatError, match="rate"):
        read_sidecar(tmp_path / "r.csv", "")


@pytest.mark.parametrize("value", ["0", "-1", "NaN", "Infinity", "1e300", '"x"', "[]", LONG])
@pytest.mark.parametrize("owner", ["session", "run"])
def test_an_absurd_rate_of_a_session_is_refused(tmp_path: Path, owner: str, value: str) -> None:
    path = tmp_path / "theirs.h5"
    path.write_bytes(SESSION.read_bytes())
    with open_session(path):
        pass  # it is readable before its rate is changed
    with h5py.File(path, "r+", libver=("v110", "v110")) as file:
        if owner == "run":
            runs = json.loads(file["session/runs"][()])
            runs[0]["rate"] = "HERE"
            del file["session/runs"]
            file["session/runs"] = np.array(json.dumps(runs).replace('"HERE"', value).encode())
        else:
            odd = {'"x"': np.array(b"x"), "[]": np.array([1.0, 2.0]), LONG: 1e307}
            file["session"].attrs["rate"] = odd[value] if value in odd else float(json.loads(value))
    with pytest.raises(SessionError, match="rate"):
        open_session(path)
