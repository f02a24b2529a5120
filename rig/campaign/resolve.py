"""A protocol with every choice made, before anything is computed.

Choosing rows and lengths is loaded where it is asked for: its kernels take a quarter of the time that the imports of a
run in servo drive would take.
"""

from typing import TYPE_CHECKING

from daq.frontend import FILTER_DELAY
from rig import grid
from rig.campaign.practice import spoiled
from rig.campaign.ranging import auto_ranged
from rig.campaign.setup import Campaign
from rig.catalog.entries import Rig
from rig.instruments import instruments
from rig.scene import Protocol
from rig.schedule import lengths, runs

if TYPE_CHECKING:
    from rig.fidelity.choice import Choice


def campaign_of(protocol: Protocol, rig: Rig, text: str = "") -> Campaign:
    """Resolve a protocol on a rig; `text`: as it was written. Raises InputError for what does not fit together."""
    conditions = grid.conditions(protocol)
    tools = instruments(conditions, rig, protocol.seed)
    rates = {c.id: lengths(c, tools.analyzer, FILTER_DELAY).rate for c in conditions}
    choices: dict[str, Choice] = {}
    if protocol.fidelity == "auto":
        from rig.campaign.fidelity import chosen

        choices = chosen(protocol, conditions, rig, auto_ranged(tools, conditions, rig, rates))
        conditions = tuple(choices[c.id].applied(c) for c in conditions)
    sizes = {c.id: lengths(c, tools.analyzer, FILTER_DELAY) for c in conditions}
    tools = auto_ranged(tools, conditions, rig, rates)
    spoilt = spoiled(tools, protocol.mistake)
    return Campaign(protocol, text, rig, conditions, runs(protocol, conditions), sizes, spoilt, choices=choices)
