"""`fidelity: auto` for a whole protocol: the choice for every condition with its instruments, and
its description.
"""

import math
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from analysis.uncertainty.budget import angle_uncertainty, noise_at
from daq.chain.fir import DELAY
from daq.chain.frontend import FILTER_DELAY
from rig.beds.janssen_stack import nominal
from rig.beds.registry import BEDS
from rig.catalog.entries import Rig
from rig.drive.waveform import Sampling, Waveform
from rig.fidelity.choice import FidelityChoice
from rig.fidelity.choose import Asked, Noise, choose
from rig.fidelity.rows import SHARE
from rig.protocol.spec import Condition, Protocol
from rig.stand.box import box_mass, losses_of
from rig.stand.channels import Instruments

COSTS = ("auto", "written", "resolved")


def chosen(
    protocol: Protocol, conditions: Sequence[Condition], rig: Rig, tools: Instruments
) -> dict[str, FidelityChoice]:
    """Return the choice for every condition, by id. Raises InputError if a bed cannot
    be followed.
    """
    asked = Asked.of(protocol)

    def one(condition: Condition) -> FidelityChoice:
        mass = _moving_mass(condition, rig)
        motion = Waveform(condition.drive.frequency, condition.drive.acceleration)
        losses = float(
            losses_of(condition.scene, rig, mass, motion.frequency).energies(motion).sum()
        )
        return choose(condition, rig, asked, _noise(condition, tools, mass), losses)

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return {
            c.id: choice for c, choice in zip(conditions, pool.map(one, conditions), strict=True)
        }


def choices_text(choices: Mapping[str, FidelityChoice]) -> str:
    """Return one line per condition: a session must agree with it to be resumed."""
    lines = []
    for name, choice in choices.items():
        rows = f"{choice.rows} rows, " if choice.rows else ""
        lines.append(
            f"{name}: {rows}settle {choice.settle} cycles, record {choice.record} cycles\n"
        )
    return "".join(lines)


def choices_document(choices: Mapping[str, FidelityChoice], runs: int) -> dict[str, Any]:
    """Return the choices for session and report; costs are sums over all runs."""
    every = tuple(choices.values())
    return {
        "mode": "auto",
        "tolerance": every[0].tolerance,
        "rows_share": SHARE,
        "conditions": [{"id": name, **choice.document()} for name, choice in choices.items()],
        "cycles": {
            "auto": runs * sum(c.settle + c.record for c in every),
            "written": runs * sum(c.written[1] + c.written[2] for c in every),
            "resolved": runs * sum(c.resolved[1] + c.resolved[2] for c in every),
        },
        "row_cycles": {name: runs * sum(c.row_cycles[name] for c in every) for name in COSTS}
        | {"planning": sum(c.row_cycles["planning"] for c in every)},
        "not_met": [name for name, choice in choices.items() if not choice.met],
    }


def _moving_mass(condition: Condition, rig: Rig) -> float:
    """Return the mass of box, gauge side and bed, kg."""
    scene, drive = condition.scene, condition.drive
    bed = BEDS[scene.bed](
        scene,
        rig,
        nominal(scene, rig),
        Sampling(Waveform(drive.frequency, drive.acceleration), 64.0),
    )
    return box_mass(scene.cavity, rig.wall_density) + rig.gauge_mass + bed.mass


def _noise(condition: Condition, tools: Instruments, mass: float) -> Noise:
    """Return the effect of the instruments in one condition.

    The force amplitude is that of the whole mass riding along: a sliding bed needs no more.
    """
    drive = condition.drive
    rate = tools.analyzer.rate_for(drive.frequency, condition.acquire.samples_per_cycle)
    per_cycle = rate / drive.frequency
    force, acceleration = tools.table(rate, FILTER_DELAY)[:2]
    omega = 2.0 * math.pi * drive.frequency
    reactive = math.pi / omega**2 * mass * drive.acceleration**2
    noise = noise_at(
        drive.frequency,
        mass * drive.acceleration,
        drive.acceleration,
        force,
        acceleration,
        round(per_cycle),
        rate,
    )
    angle = angle_uncertainty(force, acceleration, drive.frequency).U
    return Noise(noise, reactive * angle, math.ceil(DELAY / per_cycle))
