"""The documents of a session about its protocol and its rig file."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from daq.documents.shapes import Text

__all__ = [
    "KINDS",
    "ClaimCase",
    "ClaimLevel",
    "ExpectedClaim",
    "RigValue",
    "SessionProtocol",
    "SessionRig",
]

KINDS = ("optimum", "order", "rise", "fall", "nonlinear", "nearly_zero", "offset_within")
"""Kinds of claims."""


@dataclass(frozen=True, slots=True)
class ClaimLevel:
    """A value of the field that a claim is about, and ids of the conditions that have it."""

    value: str
    conditions: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ClaimCase:
    """One combination of the other fields that vary, with its levels in the order of the claim."""

    at: Mapping[str, str]
    levels: tuple[ClaimLevel, ...]


@dataclass(frozen=True, slots=True)
class ExpectedClaim:
    """A claim in the session's document.

    claim : in words
    kind : of test
    about : the field that it is about
    over : the field that is averaged over; "" for none
    values : the values that it names
    limits : margins, fixed beforehand
    imposed : why it holds by construction; "" where it does not
    """

    claim: str
    kind: Annotated[str, Text(KINDS)]
    about: str
    over: str
    values: tuple[str, ...]
    limits: tuple[float, ...]
    imposed: str
    cases: tuple[ClaimCase, ...]


@dataclass(frozen=True, slots=True)
class SessionProtocol:
    """The document `protocol`; resolved: the protocol written out in full."""

    name: str = ""
    question: str = ""
    expect: tuple[ExpectedClaim, ...] = ()
    resolved: str | None = None


@dataclass(frozen=True, slots=True)
class RigValue:
    """A value of the rig file, with its status and source."""

    path: str
    value: float | str | tuple[float, ...] | None = None
    unit: str | None = None
    status: str | None = None
    source: str | None = None


@dataclass(frozen=True, slots=True)
class SessionRig:
    """The document `rig`; resolved: the rig file written out in full."""

    name: str = ""
    values: tuple[RigValue, ...] = ()
    resolved: str | None = None
