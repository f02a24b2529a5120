"""A protocol's deliberate error: in the actual instruments, in their input, and in the facts for
the session.
"""

from dataclasses import replace
from typing import Any

from daq.chain.fir import OVERSAMPLING
from daq.chain.source import PhysicalSource
from daq.faults.in_sources import AcCoupled, Drifting, Late, Offset
from rig.catalog.entries import Rig
from rig.drive.coil_force import Armature, CoilForce
from rig.drive.waveform import Waveform
from rig.protocol.deliberate_errors import AC_CORNER, DeliberateError
from rig.protocol.spec import LOOP_BACK, Condition
from rig.stand.channels import CHANNELS, Instruments

ACCELERATION = CHANNELS.index("acceleration")


def with_instrument_error(tools: Instruments, error: DeliberateError) -> Instruments:
    """Return the instruments with the accelerometer's actual time constant changed by the factor
    `pole`.
    """
    certified = tools.channels[ACCELERATION].transducer.time_constant
    if error.pole is None or certified is None:
        return tools
    states = list(tools.states)
    states[ACCELERATION] = replace(states[ACCELERATION], time_constant=error.pole * certified)
    return replace(tools, states=tuple(states))


def with_signal_error(
    source: PhysicalSource, error: DeliberateError, condition: Condition, rig: Rig, motion: Waveform
) -> PhysicalSource:
    """Return the input of a run's transducers with the deliberate error; the source itself if the
    error lies elsewhere or there is none.
    """
    if error.corners is not None:
        return AcCoupled(source, (AC_CORNER, AC_CORNER * (1.0 + error.corners)))
    if error.skew is not None:
        return Late(source, ACCELERATION, error.skew * OVERSAMPLING)
    if error.clock is not None:
        return Drifting(source, ACCELERATION, 1e-6 * error.clock)
    if condition.scene.bed == LOOP_BACK:  # neither the coil nor the sensors are in it
        return source
    if error.coil:
        return CoilForce(source, Armature.of(rig.exciter), motion)
    if error.offset is not None:
        return Offset(source, ACCELERATION, error.offset * condition.drive.acceleration)
    return source


def error_facts(error: DeliberateError, rig: Rig, rate: float) -> dict[str, Any] | None:
    """Return the facts of the error for the report: its kind, its value, and the quantities in its
    rule (SI).
    """
    kind = error.kind
    if kind is None:
        return None
    facts: dict[str, Any] = {"kind": kind, "value": float(getattr(error, kind))}
    if kind == "corners":
        facts["corner"] = AC_CORNER
    elif kind == "skew":
        facts["delay"] = facts["value"] / rate
    elif kind == "coil":
        facts["value"] = Armature.of(rig.exciter).damping
    elif kind == "friction":
        facts |= {"value": rig.guide_friction, "gravity": rig.gravity}
    return facts
