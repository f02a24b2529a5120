"""Sessions of the first edition are read with today's names."""

import json
import shutil
from pathlib import Path

import pytest

from analysis import read_session
from analysis.session.documents import document_as
from analysis.session.former_names import (
    condition_today,
    prediction_today,
    protocol_today,
    rig_today,
    text_today,
)
from analysis.session.protocol import SessionProtocol
from daq import open_session
from daq.formats.sidecar import sidecar_of
from rig import load_protocol, load_rig
from rig.campaign.runner import run
from rig.cli.commands.exchange import export_session
from rig.errors import InputError

OLD = Path(__file__).parents[2] / "data" / "session-v1.h5"


def test_a_session_of_the_first_edition_is_read_with_todays_names() -> None:
    with open_session(OLD) as record:
        assert {condition["drive"] for condition in record.conditions.values()} == {"servo"}
        report = read_session(record)
    assert {row.drive for row in report.conditions} == {"prescribed"}
    assert report.waveform == "ideal"
    assert all(row.W_T_as_printed is not None for row in report.conditions if row.W_T is not None)


def test_words_and_keys_have_todays_names_in_their_places() -> None:
    old = {"id": "c01", "bed": "slug", "drive": "coupled", "mistake": {"kind": "skew"}, "more": 1}
    new = {
        "id": "c01",
        "bed": "single_mass",
        "drive": "shaker",
        "deliberate_error": {"kind": "skew"},
        "more": 1,
    }
    assert condition_today(old) == new
    assert list(condition_today(old)) == list(new)
    assert condition_today(new) == new
    assert condition_today({"bed": 3, "drive": None}) == {"bed": 3, "drive": None}


def test_a_prediction_keeps_todays_key_where_both_stand() -> None:
    old = {
        "conditions": {"c01": {"W_T_paper": 1.0}, "c02": {"W_T_paper": 1.0, "W_T_as_printed": 2.0}}
    }
    assert prediction_today(old) == {
        "conditions": {"c01": {"W_T_as_printed": 1.0}, "c02": {"W_T_as_printed": 2.0}}
    }
    for value in (None, [], {"conditions": 3}, {"conditions": {"c01": None}}):
        assert prediction_today(value) == value


def test_what_a_session_holds_written_out_can_be_run_today(tmp_path: Path) -> None:
    """The protocol and the rig of the fixture, with today's names, are what today's reader takes."""
    with open_session(OLD) as record:
        old = {name: record.document(name)["resolved"] for name in ("protocol", "rig")}
        resolved = read_session(record).resolved
    assert resolved is not None
    for name, text in (("protocol", resolved.protocol), ("rig", resolved.rig)):
        (tmp_path / f"{name}.yaml").write_text(text or "")
        assert text != old[name]
    assert load_rig(tmp_path / "rig.yaml").refill_clearance == 0.1
    protocol = load_protocol(tmp_path / "protocol.yaml", rig=str(tmp_path / "rig.yaml"))
    assert (protocol.drive.mode, protocol.acquire.paper_rule) == ("prescribed", True)


def test_claims_have_todays_paths_and_words() -> None:
    """Words only where the path is a drive's or a bed's: a material may be called anything."""
    old = {
        "claim": "W rises with the clearance",
        "kind": "order",
        "about": "scene.bed",
        "over": "scene.layers.play",
        "values": ["slug", "layers"],
        "limits": [],
        "imposed": "",
        "cases": [
            {
                "at": {"drive.mode": "servo", "scene.grains.material": "slug"},
                "levels": [{"value": "slug", "conditions": ["c01"]}],
            }
        ],
    }
    new = old | {
        "about": "scene.bed",
        "over": "scene.layers.clearance",
        "values": ["single_mass", "layers"],
        "cases": [
            {
                "at": {"drive.mode": "prescribed", "scene.grains.material": "slug"},
                "levels": [{"value": "single_mass", "conditions": ["c01"]}],
            }
        ],
    }
    assert protocol_today({"name": "x", "expect": [old]}) == {"name": "x", "expect": [new]}
    protocol = document_as(SessionProtocol, "protocol", {"expect": [old]})
    assert protocol == document_as(SessionProtocol, "protocol", {"expect": [new]})
    damaged = {"about": 1, "over": None, "values": 3, "cases": [{"at": 1, "levels": [1, {}]}, 2]}
    for value in (None, [], {"expect": 3}, {"expect": [3, damaged]}):
        assert protocol_today(value) == value


def test_the_file_beside_an_export_has_todays_names(tmp_path: Path) -> None:
    record = tmp_path / "run.csv"
    export_session(OLD, "csv", "1", record, raw=True, as_json=True)
    document = json.loads(sidecar_of(record).read_text(encoding="utf-8"))
    assert document["condition"]["drive"] == "prescribed"


def test_a_session_of_the_first_edition_is_not_resumed(tmp_path: Path) -> None:
    """Its own protocol, translated, is refused in one sentence that says why."""
    with open_session(OLD) as record:
        resolved = read_session(record).resolved
    assert resolved is not None
    protocol = load_protocol(resolved.protocol or "", rig="paper")
    shutil.copy(OLD, tmp_path / "session.h5")
    with pytest.raises(InputError, match="first edition") as refused:
        run(protocol, tmp_path, resume=True)
    assert len(refused.value.mistakes) == 1
    assert (tmp_path / "session.h5").read_bytes() == OLD.read_bytes()


def test_the_rigs_values_stand_under_todays_paths() -> None:
    old = {
        "values": [{"path": "refill_play", "value": 0.1}, {"path": "drive.mode", "value": "servo"}]
    }
    assert rig_today(old) == {
        "values": [
            {"path": "refill_clearance", "value": 0.1},
            {"path": "drive.mode", "value": "prescribed"},
        ]
    }
    assert text_today("question: may it play: yes\n") == "question: may it play: yes\n"
