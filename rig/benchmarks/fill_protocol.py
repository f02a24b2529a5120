"""The shipped fill protocol, the problem of several measurements."""

from rig.campaign.campaign import Campaign
from rig.campaign.resolve import campaign_of
from rig.catalog.rig_file import load_rig
from rig.protocol import shipped
from rig.protocol.load import read_protocol

FILL = shipped.folder() / "fill_rate.yaml"


def fill_campaign(*sets: str) -> Campaign:
    """Return the shipped fill protocol with values replaced.

    Raises InputError where the protocols are not installed.
    """
    loaded = read_protocol(str(FILL), sets, (), None, None)
    return campaign_of(loaded.protocol, load_rig(loaded.protocol.rig), loaded.text)
