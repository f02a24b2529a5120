"""A committed session of version 1 keeps being read, and the page of the format names what the file
holds.
"""

import dataclasses
import hashlib
import json
import re
from pathlib import Path

import h5py
import pytest

from analysis import read_session
from analysis.session.documents import session_document_deviations
from analysis.session.setting import CONDITION
from daq import open_session
from daq.chain.channel import ChannelInfo
from daq.session.plan import RunPlan
from daq.session.validate import session_deviations

ROOT = Path(__file__).parents[3]
SESSION = ROOT / "tests" / "data" / "session-v1.h5"
EXPECTED = json.loads(SESSION.with_suffix(".json").read_text())
PAGE = (ROOT / "docs" / "session-format.md").read_text(encoding="utf-8")


def test_the_codes_are_those_that_were_recorded() -> None:
    with open_session(SESSION) as record:
        assert record.complete
        found = {
            info.name: {
                name: hashlib.sha256(
                    record.codes(info.name, name).astype("<i4").tobytes()
                ).hexdigest()
                for name in record.channels
            }
            for info in record.runs
        }
    assert found == EXPECTED["codes"]


def test_the_report_numbers_are_those_of_its_time() -> None:
    """W_exp and M_eff follow from codes and channel table by definition: round-off only. Standard
    uncertainties may be refined by later versions: within a tenth; how they are expanded (k) is the
    report's."""
    with open_session(SESSION) as record:
        report = read_session(record)
    for row, old in zip(report.conditions, EXPECTED["conditions"], strict=True):
        assert (row.id, row.bed) == (old["id"], old["bed"])
        for name in ("W_exp", "M_eff", "acceleration", "W_T"):
            assert getattr(row, name) == pytest.approx(old[name], rel=1e-9, abs=1e-15), name
        assert row.W_detect == pytest.approx(old["W_detect"], rel=0.1)
        assert row.U_W_exp / row.k == pytest.approx(old["u_W_exp"], rel=0.1)
    assert report.verdict == EXPECTED["verdict"]


def test_it_has_no_deviation_from_the_format() -> None:
    with open_session(SESSION) as record:
        assert [*session_deviations(record), *session_document_deviations(record)] == []


def test_the_page_names_every_object_attribute_and_key() -> None:
    names = {item.name for kind in (ChannelInfo, RunPlan) for item in dataclasses.fields(kind)}
    names |= {*CONDITION.required, *CONDITION.optional}
    with h5py.File(SESSION, "r") as file:
        names |= {
            *file.attrs,
            *file["session"],
            *file["session/status"].dtype.names,
            *file["session/truth"],
        }
        run = file["run_0001"]
        names |= {
            *run,
            *run.attrs,
            *run["blocks"].dtype.names,
            *run["data"].attrs,
            *run["data/force"].attrs,
        }
        names |= {*run["truth/ledger"].attrs, *run["scalars"].attrs}
    assert sorted(name for name in names if name not in PAGE) == []


def test_the_reading_of_the_page_gives_the_signal() -> None:
    program = PAGE.partition("```python\n")[2].partition("```")[0]
    scope: dict[str, object] = {}
    program = re.sub(r'"[^"]*\.h5"', repr(str(SESSION)), program)
    exec(
        program.replace(", swmr=True", ""), scope
    )  # the packed file was not written in the newest mode
    with open_session(SESSION) as record:
        signal = record.signal("run_0001", "force").samples
    assert scope["force"] == pytest.approx(signal, rel=1e-12)
