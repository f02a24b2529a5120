"""Random inputs of a run: motion, bed and noise. Seeds depend on content: (seed, condition, repeat,
word).
"""

import numpy as np

from daq.chain.fir import OVERSAMPLING
from daq.random_streams import stream
from rig.beds.janssen_stack import Filling, nominal, refill
from rig.campaign.campaign import Campaign
from rig.drive.waveform import Waveform, waveform
from rig.protocol.schedule import Run
from rig.protocol.spec import Scene


def random_stream(campaign: Campaign, run: Run, word: str) -> np.random.Generator:
    """Return the random generator of one quantity in a run, named by `word`; it depends on nothing
    else in the campaign.
    """
    return stream(campaign.protocol.seed, run.condition.seed_key, str(run.repeat), word)


def motion_of(campaign: Campaign, run: Run) -> Waveform:
    """Return the motion that an ideal waveform controller reaches in a run, on the analyzer's
    clock.
    """
    drive, rig = run.condition.drive, campaign.rig
    rng = None if drive.imperfection == "none" else random_stream(campaign, run, "drive")
    return waveform(
        drive, rig.level_error, rig.third_harmonic, rng, 1.0 + campaign.instruments.clock_error
    )


def filling_of(campaign: Campaign, run: Run, scene: Scene | None = None) -> Filling:
    """Return the filling of a run: a refill for each repeat, or the nominal one. scene : with a
    different number of rows.
    """
    scene = scene or run.condition.scene
    if not campaign.protocol.repeats.refill:
        return nominal(scene, campaign.rig)
    return refill(scene, campaign.rig, random_stream(campaign, run, "refill"))


def oversampled_rate(campaign: Campaign, run: Run) -> float:
    """Return the rate (Hz) at which a run is simulated: oversampled, on the analyzer's actual
    clock.
    """
    return (
        OVERSAMPLING
        * campaign.lengths[run.condition.id].rate
        * (1.0 + campaign.instruments.clock_error)
    )
