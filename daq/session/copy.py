"""Rebuild the plan from which a record was made."""

from typing import Any

from daq.session.layout import OWN_NAMES, ROOT_NAMES
from daq.session.plan import SessionPlan
from daq.session.record import Record

__all__ = ["plan_of"]


def plan_of(record: Record, **documents: Any) -> SessionPlan:
    """Return the plan of a session that equals `record` in everything but the samples, with
    additional documents.
    """
    truth = record.truth
    attributes = {
        name: value for name, value in record.attributes("").items() if name not in ROOT_NAMES
    }
    return SessionPlan(
        rate=record.rate,
        channels=tuple(record.channels.values()),
        runs=record.plans,
        conditions=tuple(record.conditions.values()),
        protocol_text=record.protocol_text,
        protocol=record.document("protocol") or {},
        documents={
            name: record.document(name) for name in record.documents if name not in OWN_NAMES
        }
        | documents,
        truth_documents={}
        if truth is None
        else {name: truth.document(name) for name in truth.documents},
        ledger_columns=record.ledger_columns,
        scalars=tuple(record.document("scalars")),
        attrs=attributes,
        synthetic=record.synthetic,
    )
