"""The instruments of a protocol: channels with a certified and an actual state, from catalog
entries and rig file.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from daq.chain.auto_range import smallest_range
from daq.chain.channel import (
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
from daq.random_streams import stream
from rig.catalog.entries import Exciter, Rig
from rig.catalog.entries_by_name import analyzer as analyzer_named
from rig.catalog.entries_by_name import transducer
from rig.drive.exciter_limits import PARTS
from rig.errors import InputError, Mistake
from rig.protocol.spec import Acquire, Condition, Ranges

CHANNELS = ("force", "acceleration")
EXCITER_CHANNELS = ("current", "voltage")
AUTO = "auto"
OF_SESSION = ("analyzer", "sensors", "exciter_channels", "coupling", "ranges", "effects")
"""Parts of `acquire` that are common to all conditions, because a session has one channel table."""


@dataclass(frozen=True)
class Instruments:
    """The instruments of a session, the same for all its runs.

    states : the actual states, drawn once per session and channel; only the truth knows them
    clock_error : relative error of the analyzer's clock, which the generator shares
    exciter : the actual exciter; the laboratory knows the values of the rig file
    """

    analyzer: AnalyzerSpec
    channels: tuple[Channel, ...]
    states: tuple[ChannelState, ...]
    clock_error: float
    exciter: Exciter

    def table(self, rate: float, filter_delay: float) -> tuple[ChannelInfo, ...]:
        """Return the channel table of the session file: certified values only."""
        return tuple(
            channel_info(channel, self.analyzer, rate, filter_delay) for channel in self.channels
        )


def instruments(conditions: Sequence[Condition], rig: Rig, seed: int) -> Instruments:
    """Return the instruments that a session seed gives; an ideal one agrees exactly with its
    certificate.

    Raises InputError if conditions ask for different instruments: a session has one channel table.
    """
    if len({tuple(getattr(c.acquire, part) for part in OF_SESSION) for c in conditions}) > 1:
        raise InputError(
            Mistake("", "vary", f"an axis over acquire.{', acquire.'.join(OF_SESSION)}",
                    "one set of instruments in a session; run one session for each and compare")
        )  # fmt: skip
    acquire = conditions[0].acquire
    analyzer = ideal_analyzer() if acquire.analyzer == "ideal" else analyzer_named(acquire.analyzer)
    names = CHANNELS + EXCITER_CHANNELS if acquire.exciter_channels else CHANNELS
    channels = tuple(_channel(name, acquire, analyzer, rig) for name in names)
    states = []
    for channel in channels:
        ideal = acquire.analyzer == "ideal" and channel.transducer.model == "ideal"
        rng = stream(seed, "instrument", channel.name)
        states.append(certified_state(channel) if ideal else draw_state(channel, analyzer, rng))
    # With an ideal current sensor the exciter, too, agrees exactly with the rig file.
    known = acquire.sensors.current == "ideal"
    exciter = rig.exciter if known else drawn_exciter(rig.exciter, stream(seed, "exciter"))
    clock_error = draw_clock_error(analyzer, stream(seed, "clock"))
    return Instruments(analyzer, channels, tuple(states), clock_error, exciter)


def _channel(name: str, acquire: Acquire, analyzer: AnalyzerSpec, rig: Rig) -> Channel:
    """Return one input with its sensor, as the certificates describe them."""
    coupling = getattr(acquire.coupling, name, "DC")
    return Channel(
        name=name,
        transducer=_transducer(name, getattr(acquire.sensors, name), acquire.effects),
        range_V=_range_of(getattr(acquire.ranges, name, None), analyzer, float(rig.ranges[name])),
        serial=f"synthetic-{name}",
        direction="+drive",
        coupling=coupling,
        corner=None if coupling == "DC" else analyzer.ac_corner,
    )


def drawn_exciter(exciter: Exciter, rng: np.random.Generator) -> Exciter:
    """Return a possible actual exciter: force constant and parts, log-normal about the known values
    with U (k = 2) as stated.
    """
    known = {"force_constant": exciter.force_constant_U, **dict.fromkeys(PARTS, exciter.parts_U)}
    errors = 0.5 * np.array(list(known.values())) * rng.standard_normal(len(known))
    factors = [math.exp(error) for error in errors]
    return replace(
        exciter,
        **{
            name: getattr(exciter, name) * factor
            for name, factor in zip(known, factors, strict=True)
        },
    )


def ranged(tools: Instruments, asked: Ranges, peaks: Mapping[str, float]) -> Instruments:
    """Return the instruments with the smallest sufficient range on every automatic channel; peaks :
    by channel.
    """
    channels = []
    for channel in tools.channels:
        range_V = channel.range_V
        if getattr(asked, channel.name, None) == AUTO:
            peak = peaks[channel.name] * channel.transducer.sensitivity
            range_V = smallest_range(tools.analyzer.ranges, peak)
        channels.append(replace(channel, range_V=range_V))
    return replace(tools, channels=tuple(channels))


def _range_of(asked: float | str | None, analyzer: AnalyzerSpec, otherwise: float) -> float:
    """Return the input range, V; the largest one until the dry run has chosen."""
    if asked == AUTO:
        return max(analyzer.ranges)
    return otherwise if asked is None else float(asked)


def _transducer(channel: str, model: str, effects: Sequence[str]) -> TransducerSpec:
    """Return a sensor with the requested optional effects of its data sheet."""
    if model == "ideal":
        return ideal_transducer(channel)  # type: ignore[arg-type]
    full = transducer(model)
    return replace(
        full,
        linearity=full.linearity if "linearity" in effects else None,
        resonance=full.resonance if "resonance" in effects else None,
        noise_spots=full.noise_spots if "flicker" in effects else (),
    )
