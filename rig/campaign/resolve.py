"""Resolution of a protocol: every choice made, before anything is computed.

The choice of rows and lengths is imported on demand: its kernels take a quarter of the import time
of a run in prescribed motion.
"""

from typing import TYPE_CHECKING

from daq.chain.frontend import FILTER_DELAY
from rig.campaign.campaign import Campaign
from rig.campaign.one_run.deliberate_errors import with_instrument_error
from rig.catalog.entries import Rig
from rig.protocol import grid
from rig.protocol.schedule import lengths, runs
from rig.protocol.spec import Protocol
from rig.stand.auto_range import auto_ranged
from rig.stand.channels import instruments

if TYPE_CHECKING:
    from rig.fidelity.choice import FidelityChoice


def campaign_of(protocol: Protocol, rig: Rig, text: str = "") -> Campaign:
    """Resolve a protocol on a rig; `text` : its source text. Raises InputError for settings that do
    not fit together.
    """
    conditions = grid.conditions(protocol)
    tools = instruments(conditions, rig, protocol.seed)
    rates = {c.id: lengths(c, tools.analyzer, FILTER_DELAY).rate for c in conditions}
    choices: dict[str, FidelityChoice] = {}
    if protocol.fidelity == "auto":
        from rig.campaign.auto_fidelity import chosen

        # The noise depends on the input ranges, so these are chosen for the protocol as written
        # first.
        choices = chosen(protocol, conditions, rig, auto_ranged(tools, conditions, rig, rates))
        conditions = tuple(choices[c.id].applied(c) for c in conditions)
    sizes = {c.id: lengths(c, tools.analyzer, FILTER_DELAY) for c in conditions}
    # Ranges of the final scenes.
    tools = auto_ranged(tools, conditions, rig, rates)
    tools_with_error = with_instrument_error(tools, protocol.deliberate_error)
    return Campaign(
        protocol,
        text,
        rig,
        conditions,
        runs(protocol, conditions),
        sizes,
        tools_with_error,
        choices=choices,
    )
