"""A recorded run read again: the recorded blocks at their own sizes, every bit kept, and a clear
end.
"""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import session_plans as given

from daq.chain.block import Flag
from daq.chain.replay import Replayed
from daq.session.copy import plan_of
from daq.session.plan import SessionError
from daq.session.record import open_session
from daq.session.writer import Recorder

CUTS = (0, 4000, 9000, 20000)
BITS = ((0, 0), (Flag.GAP, Flag.OVERLOAD_HI), (Flag.IEPE_OPEN, 0))
SCALARS = {"force_use": 0.5, "stroke_use": 0.25}


@pytest.fixture
def path(tmp_path: Path) -> Path:
    place = tmp_path / "session.h5"
    with Recorder.create(place, given.plan()) as recorder:
        codes = given.codes(seed=1)
        for (start, stop), bits in zip(pairwise(CUTS), BITS, strict=True):
            recorder.append("run_0001", given.block(start, codes[:, start:stop], bits))
        recorder.write_ledger("run_0001", 0, np.arange(8.0).reshape(4, 2))
        recorder.finish("run_0001", SCALARS, int(Flag.OVERRUN))
        recorder.append("run_0002", given.block(0, codes[:, :5000]))
    return place


def test_the_recorded_blocks_come_back_as_they_were(path: Path) -> None:
    with open_session(path) as record:
        replayed, rows = Replayed(record, "run_0001"), record.blocks("run_0001")
        assert replayed.sizes == tuple(np.diff(CUTS))
        for row, bits in zip(rows, BITS, strict=True):
            block = replayed.read(int(row["count"]))
            assert block.start == row["start"]
            np.testing.assert_array_equal(
                block.codes, given.codes(seed=1)[:, block.start : block.start + block.count]
            )
            assert tuple(block.flags) == bits
            np.testing.assert_array_equal(block.clipped, row["clipped"])


def test_other_reads_recount_the_rails_and_keep_every_other_bit(path: Path) -> None:
    with open_session(path) as record:
        replayed = Replayed(record, "run_0001")
        codes = given.codes(seed=1)
        first = replayed.read(3000)
        assert not (first.flags & Flag.GAP).any()
        second = replayed.read(3000)  # touches the first recorded block and the second
        assert second.flags[0] & Flag.GAP
        part = codes[:, 3000:6000]
        np.testing.assert_array_equal(
            second.clipped, ((part == 2**23 - 1) | (part == -(2**23))).sum(axis=1)
        )


def test_the_end_is_an_error(path: Path) -> None:
    with open_session(path) as record:
        replayed = Replayed(record, "run_0002")
        assert replayed.read(5000).count == 5000
        with pytest.raises(SessionError, match="ends at sample 5000"):
            replayed.read(1)


def test_the_plan_of_a_record_makes_an_equal_session(path: Path, tmp_path: Path) -> None:
    with open_session(path) as record:
        plan = plan_of(record, replay={"speed": "max"})
        with Recorder.create(tmp_path / "again.h5", plan):
            pass
        with open_session(tmp_path / "again.h5") as again:
            assert again.plans == record.plans
            assert again.channels == record.channels
            assert again.conditions == record.conditions
            assert again.protocol_text == record.protocol_text
            assert again.ledger_columns == record.ledger_columns
            assert set(again.documents) == {*record.documents, "replay"}
            assert {name: again.document(name) for name in record.documents} == {
                name: record.document(name) for name in record.documents
            }
            assert record.truth is not None
            assert again.truth is not None
            assert again.truth.document("instruments") == record.truth.document("instruments")
