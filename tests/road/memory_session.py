"""Sessions in memory: stand, transducers, front end and codes as in a campaign, read by the
analysis without a file.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from daq.chain.channel import ChannelInfo
from daq.chain.frontend import FILTER_DELAY
from rig.campaign.campaign import Campaign
from rig.campaign.one_run.assemble import assemble
from rig.campaign.resolve import campaign_of
from rig.campaign.session_plan import exciter_facts
from rig.catalog.entries import Rig
from rig.catalog.rig_file import load_rig
from rig.prediction.document import condition_facts, prediction_document, predictions
from rig.protocol.load import load_protocol
from rig.protocol.schedule import Run
from rig.protocol.spec import Protocol

OUTSIDE_THE_INSTRUMENTS = ("noise", "air", "gas", "mount", "waveform", "refill")
"""Terms of the offset that are there whatever the instruments do."""


@dataclass(frozen=True)
class Plan:
    """What all sessions of a coverage study share: the protocol with its rig, W_T as plain numbers,
    and the conditions' facts; only the seed differs."""

    protocol: Protocol
    rig: Rig
    prediction: Mapping[str, Any]
    conditions: Mapping[str, Mapping[str, Any]]

    @classmethod
    def of(cls, text: str, sets: Sequence[str] = (), varies: Sequence[str] = ()) -> "Plan":
        """Of a protocol's text, its file or its name, and changes of it."""
        protocol = load_protocol(text, sets, varies)
        rig = load_rig(protocol.rig)
        campaign = campaign_of(protocol, rig)
        found = predictions(campaign.conditions, rig, 1)
        facts = (
            condition_facts(c, rig, found[c.id][0], campaign.lengths[c.id].rate)
            for c in campaign.conditions
        )
        told = {c.id: found[c.id] for c in campaign.conditions if c.has_level}
        return cls(protocol, rig, prediction_document(told), {fact["id"]: fact for fact in facts})

    def session(self, seed: int) -> "MemoryRecord":
        """A session with its own instruments, fillings, levels and noise."""
        campaign = campaign_of(replace(self.protocol, seed=seed), self.rig)
        return MemoryRecord(self, campaign)


@dataclass(frozen=True)
class MemoryRun:
    name: str
    condition: str
    repeat: int
    order: int
    samples: int
    rate: float
    complete: bool = True
    flags: int = 0


@dataclass(frozen=True)
class Samples:
    samples: np.ndarray
    flags: int


@dataclass(frozen=True)
class MemoryTruth:
    ledgers: Mapping[str, np.ndarray]
    columns: tuple[str, ...]
    documents: Mapping[str, Any]

    def ledger(
        self, run: str, start: int = 0, stop: int | None = None
    ) -> tuple[tuple[str, ...], np.ndarray]:
        return self.columns, self.ledgers[run][start:stop]

    def document(self, name: str) -> Any:
        return self.documents.get(name)


class MemoryRecord:
    """The record API (analysis.session.record.Record) over the codes that a campaign delivers."""

    synthetic = True

    def __init__(self, plan: Plan, campaign: Campaign) -> None:
        tools = campaign.instruments
        self.conditions = plan.conditions
        exciter = exciter_facts(plan.rig.exciter)
        self.documents: dict[str, Any] = {"prediction": plan.prediction, "exciter": exciter}
        self._codes: dict[str, np.ndarray] = {}
        self._blocks: dict[str, np.ndarray] = {}
        self._scalars: dict[str, Mapping[str, float]] = {}
        ledgers = {}
        for run in campaign.runs:
            ledgers[run.name] = self._recorded(campaign, run)
        self.channels: dict[str, ChannelInfo] = {
            info.name: info
            for info in tools.table(campaign.lengths[campaign.conditions[0].id].rate, FILTER_DELAY)
        }
        self.runs = tuple(
            MemoryRun(
                run.name, run.condition.id, run.repeat, run.order, self._codes[run.name].shape[1],
                campaign.lengths[run.condition.id].rate,
            )
            for run in campaign.runs
        )  # fmt: skip
        states = {c.name: asdict(s) for c, s in zip(tools.channels, tools.states, strict=True)}
        documents = {"instruments": states, "clock": {"error": tools.clock_error}}
        self.truth = MemoryTruth(ledgers, campaign.ledger_columns, documents)

    def _recorded(self, campaign: Campaign, run: Run) -> np.ndarray:
        """Codes and blocks of a run are kept; gives its ledger."""
        parts = list(assemble(campaign, run))
        self._codes[run.name] = np.concatenate([part.block.codes for part in parts], axis=1)
        blocks = [
            (p.block.start, p.block.codes.shape[1], p.block.flags, p.block.clipped) for p in parts
        ]
        many = len(campaign.instruments.channels)
        kind = [
            ("start", "<u8"),
            ("count", "<u4"),
            ("flags", "<u2", (many,)),
            ("clipped", "<u4", (many,)),
        ]
        self._blocks[run.name] = np.array(blocks, dtype=kind)
        self._scalars[run.name] = parts[-1].scalars or {}
        return np.concatenate([part.ledger for part in parts])

    def run(self, name: str) -> MemoryRun:
        return next(run for run in self.runs if run.name == name)

    def signal(self, run: str, name: str, start: int = 0, stop: int | None = None) -> Samples:
        row = list(self.channels).index(name)
        codes, channel, blocks = self._codes[run][row], self.channels[name], self._blocks[run]
        stop = codes.size if stop is None else stop
        samples = (codes[start:stop] * channel.scale + channel.offset) / channel.sensitivity
        touched = (blocks["start"] < stop) & (blocks["start"] + blocks["count"] > start)
        return Samples(samples, int(np.bitwise_or.reduce(blocks["flags"][touched, row], initial=0)))

    def document(self, name: str) -> Any:
        return self.documents.get(name)

    def forget(self) -> None:
        """Drop the codes, once the runs' energies are read."""
        self._codes.clear()

    def scalars(self, run: str) -> Mapping[str, float]:
        return self._scalars[run]

    def blocks(self, run: str) -> np.ndarray:
        return self._blocks[run]
