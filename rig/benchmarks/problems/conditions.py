"""Sessions of many conditions: CPU time and memory of `rig report`, in a process of its own."""

import resource
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from daq.chain.block import Block
from daq.session.plan import SessionPlan
from daq.session.record import Record, open_session
from daq.session.writer import Recorder
from rig.benchmarks.process import run_process
from rig.benchmarks.results.fits import fitted
from rig.campaign.runner import run
from rig.protocol.load import load_protocol

Row = dict[str, Any]

SIZES, FEW = (250, 500, 1000, 2000), (50, 100, 200)
REPEATS = 4
ONE = f"""\
schema: rig/protocol/1
name: many
scene: {{grains: {{material: stainless, diameter: 8 mm}}, layers: {{rows: 2}}}}
drive: {{acceleration: 3 m/s^2}}
acquire: {{settle: 4 cycles, record: 8 cycles}}
repeats: {REPEATS}
seed: 7
"""


def conditions(rounds: int, quick: bool, sizes: Sequence[int] = ()) -> list[Row]:
    """Measure the axis `conditions`: CPU time of a report at each number of conditions, its
    exponent, and peak memory.

    CPU instead of wall time, because the processes that read a large session share the processors.
    """
    sizes = sizes or (FEW if quick else SIZES)
    with TemporaryDirectory() as name:
        folder = Path(name)
        run(load_protocol(ONE), folder / "one", workers=1)
        for size in sizes:
            (folder / str(size)).mkdir()
            with open_session(folder / "one" / "session.h5") as record:
                repeated(record, size, folder / str(size) / "session.h5")
        seconds: dict[float, list[float]] = {size: [] for size in sizes}
        memory = dict.fromkeys(sizes, 0.0)
        for _ in range(rounds):
            for size in sizes:
                before = _cpu()
                memory[size] = max(run_process(["report", str(folder / str(size))], folder))
                seconds[size].append(_cpu() - before)
    what = f"rig report, CPU time of all processes, {REPEATS} runs of 12 cycles a condition"
    return [
        *fitted("conditions", what, seconds),
        *(
            {
                "kind": "memory",
                "problem": f"rig report, {size} conditions",
                "method": f"{REPEATS * size} runs",
                "writer_MB": peak,
                "worker_MB": None,
                "failure": None,
            }
            for size, peak in memory.items()
        ),
    ]


def repeated(record: Record, count: int, path: Path) -> None:
    """Write a session of `count` conditions, each a copy of the recorded condition of `record`."""
    (condition,), plans = record.conditions.values(), record.plans
    ids = [f"c{number:04d}" for number in range(1, count + 1)]
    fixed = {"conditions", "prediction", "protocol", "runs", "scalars"}
    prediction = record.document("prediction")["conditions"][condition["id"]]
    truth = record.truth
    plan = SessionPlan(
        rate=record.rate,
        channels=tuple(record.channels.values()),
        runs=tuple(
            replace(
                one,
                name=f"run_{len(plans) * place + repeat:05d}",
                condition=name,
                order=len(plans) * place + repeat,
            )
            for place, name in enumerate(ids)
            for repeat, one in enumerate(plans, 1)
        ),
        conditions=tuple(
            {**condition, "id": name, "fill": 0.3 + 0.6 * k / count} for k, name in enumerate(ids)
        ),
        protocol_text=record.protocol_text,
        protocol=record.document("protocol"),
        documents={name: record.document(name) for name in record.documents if name not in fixed}
        | {"prediction": {"conditions": dict.fromkeys(ids, prediction)}},
        truth_documents={name: truth.document(name) for name in truth.documents} if truth else {},
        ledger_columns=record.ledger_columns,
        scalars=record.scalar_names,
    )
    sources = [one.name for one in plans]
    with Recorder.create(path, plan) as recorder:
        for place, target in enumerate(plan.runs):
            source = sources[place % len(sources)]
            for row in record.blocks(source):
                start, stop = int(row["start"]), int(row["start"] + row["count"])
                codes = record.all_codes(source, start, stop)
                recorder.append(
                    target.name, Block(start, codes, row["flags"], row["clipped"], False)
                )
            recorder.write_ledger(target.name, 0, record.ledger_rows(source))
            recorder.finish(target.name, record.scalars(source), record.run(source).flags)


def _cpu() -> float:
    """Return the CPU seconds of all child processes that have ended so far."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
