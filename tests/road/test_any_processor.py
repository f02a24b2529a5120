"""Nothing recorded or predicted hangs on numpy's transcendental functions, which choose
instructions by processor.
"""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

OTHER = """
import numba
import numpy as np

numba.njit(lambda x: x)(1.0)  # numba looks numpy's own functions up

def other(function):
    def rounded(*arguments, **more):
        found = function(*arguments, **more)
        return found if np.iscomplexobj(found) else np.nextafter(found, np.inf)
    return rounded

for name in ("sin", "cos", "tan", "exp", "exp2", "expm1", "log", "log2", "log10", "log1p", "sinh", "cosh", "tanh",
             "arcsin", "arccos", "arctan", "arctan2", "power", "cbrt", "sinc", "kaiser", "i0"):
    setattr(np, name, other(getattr(np, name)))
"""
"""A numpy whose results differ in the last digit, as on another kind of processor."""

PROGRAM = """
import hashlib, sys
from rig.campaign.resolve import campaign_of
from rig.campaign.one_run.assemble import assemble
from rig.campaign.campaign import Campaign
from rig.catalog.rig_file import load_rig
from rig.prediction.document import prediction_document, predictions
from rig.protocol.load import load_protocol

protocol = load_protocol("nulls", sets=sys.argv[1:])
campaign = campaign_of(protocol, load_rig(protocol.rig))
digest = hashlib.sha256()
for run in campaign.runs:
    for part in assemble(campaign, run):
        digest.update(part.block.codes.tobytes())
        digest.update(part.ledger.tobytes())
print(digest.hexdigest())
print(prediction_document(predictions(campaign.conditions, campaign.rig, 1)))
"""

SHORT = (
    "repeats.n=1",
    "acquire.settle=2 cycles",
    "acquire.record=8 cycles",
    "drive.acceleration=2",
)
BEDS = "vary={scene.bed: [empty, locked, dashpot, layers, loop_back]}"


def recorded(program: str, *sets: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", program, *SHORT, *sets], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize(
    "sets",
    [
        (BEDS,),
        pytest.param(
            ("vary={scene.bed: [empty, layers]}", "drive.mode=shaker"), marks=pytest.mark.slow
        ),
    ],
    ids=["prescribed", "shaker"],
)
def test_codes_ledger_and_predictions_are_the_same_to_the_byte(sets: tuple[str, ...]) -> None:
    assert recorded(PROGRAM, *sets) == recorded(OTHER + PROGRAM, *sets)
