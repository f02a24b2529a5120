"""A protocol with every choice made, before anything is computed.

Choosing rows and lengths is loaded where it is asked for: its kernels take a quarter of the time that the imports of a
run in servo drive would take.
"""

from typing import TYPE_CHECKING

from daq.chain.frontend import FILTER_DELAY
from rig.campaign.campaign import Campaign
from rig.campaign.one_run.deliberate_errors import spoiled
from rig.catalog.entries import Rig
from rig.protocol import grid
from rig.protocol.schedule import lengths, runs
from rig.protocol.spec import Protocol
from rig.stand.auto_range import auto_ranged
from rig.stand.channels import instruments

if TYPE_CHECKING:
    from rig.fidelity.choice import Choice


def campaign_of(protocol: Protocol, rig: Rig, text: str = "") -> Campaign:
    """Resolve a protocol on a rig; `text`: as it was written. Raises InputError for what does not fit together."""
    conditions = grid.conditions(protocol)
    tools = instruments(conditions, rig, protocol.seed)
    rates = {c.id: lengths(c, tools.analyzer, FILTER_DELAY).rate for c in conditions}
    choices: dict[str, Choice] = {}
    if protocol.fidelity == "auto":
        from rig.campaign.auto_fidelity import chosen

        choices = chosen(protocol, conditions, rig, auto_ranged(tools, conditions, rig, rates))
        conditions = tuple(choices[c.id].applied(c) for c in conditions)
    sizes = {c.id: lengths(c, tools.analyzer, FILTER_DELAY) for c in conditions}
    tools = auto_ranged(tools, conditions, rig, rates)
    spoilt = spoiled(tools, protocol.mistake)
    return Campaign(protocol, text, rig, conditions, runs(protocol, conditions), sizes, spoilt, choices=choices)
