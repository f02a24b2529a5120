"""The main job and its parts (acquisition, recorder, analysis, replay), each beside its rival."""

import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from analysis.pipeline import read_session
from analysis.results.report import Report
from daq.chain.acquisition import Emulated
from daq.chain.channel import (
    AnalyzerSpec,
    Channel,
    certified_state,
    ideal_analyzer,
    ideal_transducer,
)
from daq.chain.fir import DELAY, STAGE1, STAGE2
from daq.chain.frontend import FrontEnd
from daq.session.record import open_session
from rig.benchmarks.fill_protocol import FILL, fill_campaign
from rig.benchmarks.machine import ROOT, cores
from rig.benchmarks.process import IMPORTS, imported_by, run_process, timed_process, weighed_imports
from rig.benchmarks.results.fits import workers
from rig.benchmarks.timing import against, interleaved, peak_memory, spread
from rig.campaign.campaign import Campaign
from rig.campaign.replayer import analysed, replay
from rig.campaign.runner import run

Row = dict[str, Any]
Array = np.typing.NDArray[np.float64]

FIXED = ("acquire.settle=10 cycles", "acquire.record=40 cycles")
"""Settings of the fill protocol in the comparison: 160 runs of 50 cycles, whatever the shipped
protocol settles.
"""

SETS = tuple(word for one in FIXED for word in ("--set", one))

WHOLE = "whole process: start, run, report, figures"

REPLAY, PLAIN = "replay: blocks and energies (ours)", "plain h5py and trapezoids"
RIG = [sys.executable, "-c", "from rig.cli.app import main; main()"]


def recording_seconds(campaign: Campaign, workers: int) -> float:
    """Return wall seconds from the start of the workers to the last run recorded and analysed,
    including predictions.
    """
    last = [0.0]

    def watch(_: object) -> None:
        last[0] = time.perf_counter()

    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        run(campaign, Path(folder), workers, progress=watch)
    return last[0] - start


def fill(rounds: int) -> list[Row]:
    """Measure the fill protocol against its rig time: recording alone, by number of workers, and
    the whole process.

    Also measures the decrease of the recording time with the number of workers.
    """
    campaign = fill_campaign(*FIXED)
    counts = [1, cores()] if cores() > 1 else [1]
    recording_seconds(fill_campaign("repeats=1", *FIXED), counts[-1])
    times: dict[float, list[float]] = {count: [] for count in counts}
    for _ in range(rounds):
        for count in counts:
            times[count].append(recording_seconds(campaign, count))
    rows = [
        _against_rig_time(
            f"recording, {count} worker{'s' * (count > 1)}", values, campaign.rig_time
        )
        for count, values in times.items()
    ]
    with tempfile.TemporaryDirectory() as folder:
        command = [*RIG, "run", str(FILL), *SETS, "--workers", str(counts[-1]), "--out"]
        timed_process([*command, f"{folder}/first"], ROOT)  # keeps the compiled modules
        whole = [timed_process([*command, f"{folder}/{number}"], ROOT) for number in range(rounds)]
        start = [timed_process([*RIG, "run", "--help"], ROOT) for _ in range(rounds)]
        modules = imported_by([*command[len(RIG) :], f"{folder}/last"], ROOT)
        imports = [
            timed_process([sys.executable, "-c", IMPORTS, *modules], ROOT) for _ in range(rounds)
        ]
    rows.append(_against_rig_time(f"{WHOLE}, {counts[-1]} workers", whole, campaign.rig_time))
    rows += [
        {
            "kind": "fill",
            "problem": "fill protocol",
            "method": method,
            "s": spread(seconds),
            "rig_time_s": None,
            "times_faster": None,
            "failure": None,
        }
        for method, seconds in (
            ("of it: Python and the command line alone (--help)", start),
            ("of it: an interpreter that imports the same modules, one after the other", imports),
        )
    ]
    return rows + workers(times)


def _against_rig_time(method: str, seconds: list[float], rig_time: float) -> Row:
    return {
        "kind": "fill",
        "problem": "fill protocol",
        "method": method,
        "s": spread(seconds),
        "rig_time_s": rig_time,
        "times_faster": spread([rig_time / value for value in seconds]),
        "failure": None,
    }


def memory() -> list[Row]:
    """Measure peak memory of `rig run` and of its worker for runs of 1 and of 100 minutes of rig
    time; it should not grow.

    The first row is an interpreter with the same imports that does nothing.
    """
    rows: list[Row] = []
    with tempfile.TemporaryDirectory() as folder:
        for minutes in (1, 100):
            arguments = [
                "run",
                str(FILL),
                "--out",
                f"{folder}/{minutes}",
                "--set",
                "vary={}",
                "--set",
                "repeats.n=1",
                "--set",
                f"acquire.record={1200 * minutes} cycles",
                "--force",
            ]
            if not rows:
                baseline = weighed_imports(imported_by(arguments, ROOT), ROOT)
                rows.append(
                    {
                        "kind": "memory",
                        "problem": "an interpreter with the same imports",
                        "method": "-",
                        "writer_MB": baseline,
                        "worker_MB": None,
                        "failure": None,
                    }
                )
            writer, worker = run_process(arguments, ROOT)
            rows.append({"kind": "memory", "problem": "rig run, one run",
                         "method": f"{minutes} min of rig time", "writer_MB": writer, "worker_MB": worker,
                         "failure": None})  # fmt: skip
    return rows


class Tone:
    """An analog source of one record, played from memory: a tone in the pass band and one that
    would alias onto it.
    """

    def __init__(self, volts: Array, names: tuple[str, ...], rate: float) -> None:
        self._volts, self.names, self.rate, self._next = volts, names, rate, 0

    def volts(self, n: int) -> Array:
        """Return the next n intervals; silence after the end."""
        part = self._volts[:, self._next : self._next + n]
        self._next += n
        return np.ascontiguousarray(np.pad(part, ((0, 0), (0, n - part.shape[1]))))


def acquisition(rounds: int, quick: bool) -> list[Row]:
    """Compare the front end (two stages, noise off, 24 bit) with scipy's polyphase filter alone.

    The rivals are the best single stage, and the same two stages as ours.
    """
    from scipy.signal import firwin, kaiserord, upfirdn  # type: ignore[attr-defined, unused-ignore]

    samples = 50_000 if quick else 200_000
    tools = fill_campaign("repeats=1").instruments
    rate = 10240.0
    t = (np.arange(8 * samples) + 0.5) / 8.0
    wanted, alias = np.sin(2.0 * np.pi * 0.2 * t), np.sin(2.0 * np.pi * 0.83 * t)
    volts = np.tile(0.1 * (wanted + 0.5 * alias), (len(tools.channels), 1))
    silent = [
        replace(channel, transducer=ideal_transducer(channel.transducer.quantity))
        for channel in tools.channels
    ]

    def ours(
        channels: Sequence[Channel] = tools.channels, analyzer: AnalyzerSpec = tools.analyzer
    ) -> Array:
        states = [certified_state(channel) for channel in channels]
        noise = [np.random.Generator(np.random.SFC64(0)) for _ in states]
        front = FrontEnd(analyzer, channels, states, rate, noise, samples)
        codes = Emulated(Tone(volts, front.names, 8.0 * rate), front).read(samples).codes[0]
        return np.asarray(codes * analyzer.volts_per_code(channels[0].range_V))

    taps, beta = kaiserord(108.0, 0.1 / 4.0)
    taps += (1 - taps) % 16
    single = firwin(taps, 1.0 / 8.0, window=("kaiser", beta))

    def theirs() -> Array:
        return np.asarray(upfirdn(single, volts, 1, 8, axis=1)[0])

    def two_stages() -> Array:
        return np.asarray(upfirdn(STAGE2, upfirdn(STAGE1, volts, 1, 4, axis=1), 1, 2, axis=1)[0])

    n = np.arange(samples)
    first, second = (
        "front end: filter, noise, codes, flags (ours)",
        "scipy.signal.upfirdn, one stage, filter alone",
    )
    third = "scipy.signal.upfirdn, our two stages, filter alone"
    calls = {first: ours, second: theirs, third: two_stages}
    checks: tuple[Callable[[], Array], ...] = (
        partial(ours, silent, ideal_analyzer()),
        theirs,
        two_stages,
    )
    delays = (DELAY - 0.5 / 8.0, (taps - 1) / 2.0 / 8.0 - 0.5 / 8.0, DELAY - 0.5 / 8.0)
    rows: dict[str, Row] = {}
    for (name, call), check, delay in zip(calls.items(), checks, delays, strict=True):
        found = check()
        _, kilobytes = peak_memory(call)
        inside = slice(200, samples - 200)
        exact = 0.1 * np.sin(2.0 * np.pi * 0.2 * (n - delay))
        rows[name] = {
            "kind": "part",
            "problem": "acquisition",
            "method": name,
            "failure": None,
            "memory_kB": kilobytes,
            "error": float(np.sqrt(np.mean((found[:samples][inside] - exact[inside]) ** 2)) / 0.1),
            "what": f"2 channels of {samples} samples; rms error of a tone at 0.2 of the rate, one at 0.83 beside it",
        }
    times = interleaved(calls, rounds)
    for name, seconds in times.items():
        rows[name]["ms"] = spread([1e3 * value for value in seconds])
    rows[first]["speed"] = against(times, first, third, 1.0)
    return list(rows.values())


def reading(rounds: int, quick: bool) -> list[Row]:
    """Compare replay and analysis with plain reading and trapezoids over the same samples, for
    short and long runs.
    """
    long = fill_campaign("vary={}", "repeats=2", f"acquire.record={2000 if quick else 4000} cycles")
    problems = (
        ("reading, short runs", fill_campaign(f"repeats={1 if quick else 2}")),
        ("reading, long runs", long),
    )
    return [row for problem, campaign in problems for row in _reading(problem, campaign, rounds)]


def _reading(problem: str, campaign: Campaign, rounds: int) -> list[Row]:
    with tempfile.TemporaryDirectory() as folder:
        run(campaign, Path(folder), cores())
        path = Path(folder) / "session.h5"
        calls = {
            REPLAY: partial(_replayed, path),
            "replay: blocks, energies and report (ours)": partial(_reported, path),
            "analysis and report (ours)": partial(_analysed, path),
            PLAIN: partial(_plain, path),
        }
        with open_session(path) as record:
            truth = record.truth
            exact = (
                {r.name: _true_energy(truth, r.name, campaign) for r in record.runs}
                if truth
                else {}
            )
        rows: dict[str, Row] = {}
        cycles = campaign.conditions[0].acquire.record
        for name, call in calls.items():
            call()
            found, kilobytes = peak_memory(call)
            rows[name] = {
                "kind": "part",
                "problem": problem,
                "method": name,
                "failure": None,
                "memory_kB": kilobytes,
                "error": float(np.median([abs(found[key] / exact[key] - 1.0) for key in exact])),
                "what": f"{len(campaign.runs)} runs of {cycles} cycles; median error of W at the gauge, by the ledger",
            }
        times = interleaved(calls, rounds)
        for name, seconds in times.items():
            rows[name]["ms"] = spread([1e3 * value for value in seconds])
        rows[REPLAY]["speed"] = against(times, REPLAY, PLAIN, 0.5)
    return list(rows.values())


def _energies(report: Report) -> dict[str, float]:
    return {one.run: one.W_exp for condition in report.conditions for one in condition.runs}


def _analysed(path: Path) -> dict[str, float]:
    with open_session(path) as record:
        return _energies(read_session(record))


def _reported(path: Path) -> dict[str, float]:
    return _energies(replay(path))


def _replayed(path: Path) -> dict[str, float]:
    """Return every run's energy from its blocks, with quality checks but without the report."""
    with open_session(path) as record:
        return {name: found.energy.W for name, found in analysed(record).items()}


def _true_energy(truth: Any, name: str, campaign: Campaign) -> float:
    columns, rows = truth.ledger(name)
    settle = campaign.conditions[0].acquire.settle
    return float(np.mean(rows[settle:, columns.index("W_gauge")]))


def _plain(path: Path) -> dict[str, float]:
    """Return every run's energy as a short script would: whole cycles, mean removed, trapezoids;
    nothing corrected.
    """
    found = {}
    with h5py.File(path, "r") as file:
        for name in (key for key in file if key.startswith("run_")):
            data, rate = file[name]["data"], float(file[name].attrs["rate"])
            first = int(file[name].attrs["settle_samples"])
            F, a = (
                (data[channel][first:] * data[channel].attrs["scale"])
                / data[channel].attrs["sensitivity"]
                for channel in ("force", "acceleration")
            )
            per_cycle = round(rate / 20.0)
            cycles = a.size // per_cycle
            F, a = F[: cycles * per_cycle], a[: cycles * per_cycle]
            a = a - a.mean()
            v = np.concatenate(([0.0], np.cumsum(0.5 * (a[1:] + a[:-1])))) / rate
            v -= v.mean()
            power = F * v
            found[name] = float(0.5 * np.sum(power[1:] + power[:-1]) / rate / cycles)
    return found
