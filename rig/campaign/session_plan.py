"""Contents of a session file before the first sample: conditions, predictions, instruments,
provenance.
"""

from collections.abc import Mapping
from dataclasses import asdict

from daq.chain.frontend import FILTER_DELAY
from daq.session.plan import RunPlan, SessionPlan
from rig.campaign.auto_fidelity import choices_document, choices_text
from rig.campaign.campaign import Campaign
from rig.campaign.claim_cases import cases, varied
from rig.campaign.one_run.deliberate_errors import error_facts
from rig.campaign.one_run.part import LEVEL_SCALARS, RECORDED_SCALARS, TRIGGER_SCALARS
from rig.campaign.open_settings import assumed_settings, material_values
from rig.campaign.provenance import now, provenance
from rig.catalog.entries import Exciter
from rig.catalog.rig_file import dump_rig
from rig.drive.exciter_limits import Demand, solvable_band
from rig.prediction.document import condition_facts, prediction_document
from rig.prediction.forecast import Forecast
from rig.protocol.load import dump_protocol
from rig.protocol.schedule import Run

SCALARS = tuple(Demand(*(0.0,) * 6).scalars())


def session_plan(campaign: Campaign, found: Mapping[str, Forecast]) -> SessionPlan:
    """Return the contents of a session file except the samples; found : the forecasts
    by condition.
    """
    tools, protocol, created = campaign.instruments, campaign.protocol, now()
    facts = [
        condition_facts(c, campaign.rig, found[c.id].point, campaign.lengths[c.id].rate)
        for c in campaign.conditions
    ]
    facts = [
        {**fact, "varied": varied(protocol, c)}
        for fact, c in zip(facts, campaign.conditions, strict=True)
    ]
    rate = campaign.lengths[campaign.conditions[0].id].rate
    if protocol.deliberate_error.kind is not None:
        rates = [campaign.lengths[c.id].rate for c in campaign.conditions]
        facts = [
            {**fact, "deliberate_error": error_facts(protocol.deliberate_error, campaign.rig, own)}
            for fact, own in zip(facts, rates, strict=True)
        ]
    return SessionPlan(
        rate=rate,
        channels=tools.table(rate, FILTER_DELAY),
        runs=tuple(_run_plan(campaign, run, created) for run in campaign.runs),
        conditions=tuple(facts),
        protocol_text=campaign.text,
        protocol={
            "name": protocol.name,
            "question": protocol.question,
            **identity(campaign)["protocol"],
            "expect": cases(protocol, campaign.conditions),
        },
        documents={
            "prediction": prediction_document(
                {
                    c.id: (found[c.id].point, found[c.id].table)
                    for c in campaign.conditions
                    if c.has_level
                },
                {name: one.refills for name, one in found.items()},
            ),
            "rig": {
                "name": campaign.rig.name,
                **identity(campaign)["rig"],
                "provenance": dict(campaign.rig.provenance),
                "values": [
                    *(asdict(value) for value in campaign.rig.values),
                    *assumed_settings(campaign.conditions),
                    *(
                        asdict(value)
                        for value in material_values(campaign.conditions, campaign.rig)
                    ),
                ],
            },
            "provenance": provenance(campaign.text, protocol.seed, campaign.rig_time),
            "exciter": exciter_facts(campaign.rig.exciter),
            **(
                {"fidelity": choices_document(campaign.choices, protocol.repeats.n)}
                if campaign.choices
                else {}
            ),
        },
        truth_documents={
            "instruments": {
                c.name: asdict(s) for c, s in zip(tools.channels, tools.states, strict=True)
            },
            "clock": {"error": tools.clock_error},
            "exciter": exciter_facts(tools.exciter),
        },
        ledger_columns=campaign.ledger_columns,
        ledger_cycles=max(c.acquire.settle + c.acquire.record for c in campaign.conditions),
        scalars=(
            *SCALARS,
            *(LEVEL_SCALARS if campaign.coupled else ()),
            *(TRIGGER_SCALARS if campaign.triggered else ()),
            *(RECORDED_SCALARS if campaign.recorded else ()),
        ),
    )


def exciter_facts(exciter: Exciter) -> dict[str, float | str]:
    """Return an exciter for the session file, SI; `band` (Hz) : up to which its current indicates
    the force at the gauge.
    """
    return {**asdict(exciter), "band": solvable_band(exciter)}


def identity(campaign: Campaign) -> dict[str, dict[str, str | bool]]:
    """Return the data that identify a session as this campaign's, by document and key.

    The protocol with its seed, its fidelity choices, and the rig, written out.
    """
    choices = {"fidelity": choices_text(campaign.choices)} if campaign.choices else {}
    return {
        "protocol": {
            "resolved": dump_protocol(campaign.protocol),
            "ablate": campaign.ablate,
            **choices,
        },
        "rig": {"resolved": dump_rig(campaign.rig)},
    }


def _run_plan(campaign: Campaign, run: Run, created: str) -> RunPlan:
    size, acquire = campaign.lengths[run.condition.id], run.condition.acquire
    return RunPlan(
        name=run.name,
        condition=run.condition.id,
        repeat=run.repeat,
        order=run.order,
        samples=size.samples,
        settle_samples=size.settle,
        blocks=len(size.blocks),
        t0=created,
        rate=size.rate,
        ledger_cycles=acquire.settle + acquire.record,
    )
