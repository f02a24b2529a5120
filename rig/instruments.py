"""The instruments of a protocol: catalog entries and rig file become channels with a certified and an actual state."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from daq.channel import (
    AnalyzerSpec,
    Channel,
    ChannelInfo,
    ChannelState,
    TransducerSpec,
    certified_state,
    channel_info,
    draw_clock_error,
    draw_state,
    ideal_analyzer,
    ideal_transducer,
)
from daq.seeds import stream
from rig import catalog
from rig.catalog.entries import Exciter, Rig
from rig.drive.exciter import PARTS
from rig.errors import InputError, Mistake
from rig.scene import Condition

CHANNELS = ("force", "acceleration")
EXCITER_CHANNELS = ("current", "voltage")


@dataclass(frozen=True)
class Instruments:
    """What a session measures with: the same for all its runs.

    states : the actual states, drawn once per session and channel; known to nobody but the truth
    clock_error : relative error of the analyzer's clock, on which the generator runs too
    exciter : the actual exciter, the rig file's values being what the laboratory knows of it
    """

    analyzer: AnalyzerSpec
    channels: tuple[Channel, ...]
    states: tuple[ChannelState, ...]
    clock_error: float
    exciter: Exciter

    def table(self, rate: float, filter_delay: float) -> tuple[ChannelInfo, ...]:
        """The channel table of the session file: certified values only."""
        return tuple(channel_info(channel, self.analyzer, rate, filter_delay) for channel in self.channels)


def instruments(conditions: Sequence[Condition], rig: Rig, seed: int) -> Instruments:
    """The instruments that a session seed gives; an ideal one is exactly what its certificate says.

    Raises InputError where conditions ask for different instruments: a session has one channel table.
    """
    wanted = {(c.acquire.analyzer, c.acquire.sensors, c.acquire.exciter_channels) for c in conditions}
    if len(wanted) > 1:
        raise InputError(
            Mistake("", "vary", "an axis over acquire.analyzer, acquire.sensors or acquire.exciter_channels",
                    "one set of instruments in a session; run one session for each and compare")
        )  # fmt: skip
    acquire = conditions[0].acquire
    analyzer = ideal_analyzer() if acquire.analyzer == "ideal" else catalog.analyzer(acquire.analyzer)
    channels = tuple(
        Channel(
            name=name,
            transducer=_transducer(name, getattr(acquire.sensors, name)),
            range_V=float(rig.ranges[name]),
            serial=f"synthetic-{name}",
            direction="+drive",
        )
        for name in (*CHANNELS, *(EXCITER_CHANNELS if acquire.exciter_channels else ()))
    )
    states = tuple(
        certified_state(channel)
        if acquire.analyzer == "ideal" and channel.transducer.model == "ideal"
        else draw_state(channel, analyzer, stream(seed, "instrument", channel.name))
        for channel in channels
    )
    known = acquire.sensors.current == "ideal"
    exciter = rig.exciter if known else drawn_exciter(rig.exciter, stream(seed, "exciter"))
    return Instruments(analyzer, channels, states, draw_clock_error(analyzer, stream(seed, "clock")), exciter)


def drawn_exciter(exciter: Exciter, rng: np.random.Generator) -> Exciter:
    """An exciter as it may really be: force constant and parts normal about what is known, U (k = 2) as stated."""
    known = {"force_constant": exciter.force_constant_U, **dict.fromkeys(PARTS, exciter.parts_U)}
    factors = np.exp(0.5 * np.array(list(known.values())) * rng.standard_normal(len(known)))
    return replace(
        exciter,
        **{name: getattr(exciter, name) * float(factor) for name, factor in zip(known, factors, strict=True)},
    )


def _transducer(channel: str, model: str) -> TransducerSpec:
    if model == "ideal":
        return ideal_transducer(channel)  # type: ignore[arg-type]
    return catalog.transducer(model)
