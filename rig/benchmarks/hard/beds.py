"""Hard cases of scenes: fills, sizes, levels and frequencies at the limits of a protocol."""

import math
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from rig.beds.janssen_stack import Filling, nominal, stack
from rig.benchmarks.hard.case import Case, CaseOutcome, at_least, at_most, exactly, no_more
from rig.catalog.entries import Rig
from rig.catalog.rig_file import load_rig
from rig.drive.waveform import Waveform
from rig.errors import InputError
from rig.prediction.own import OwnPrediction, predict_own
from rig.prediction.variants import as_printed_variant
from rig.protocol.grid import conditions
from rig.protocol.spec import Acquire, Cavity, Condition, Drive, Grains, Layers, Protocol, Scene
from rig.stand.ledger import COLUMNS
from rig.stand.prescribed import Stand
from rig.theory.friction import janssen_length
from rig.theory.total import layers_total

Array = NDArray[np.float64]

STEEL = 7900.0


def scene(**grains: float) -> Scene:
    """Return the default box with steel balls."""
    return Scene(grains=replace(Grains(density=STEEL), **grains))  # type: ignore[arg-type]


def model(
    what: Scene, rig: Rig, acceleration: float = 5.0, frequency: float = 20.0
) -> OwnPrediction:
    """Return the prediction of `rig model`."""
    return predict_own(
        Condition("c", what, Drive(frequency=frequency, acceleration=acceleration), Acquire(), ""),
        rig,
    )


def refused(protocol: Protocol) -> bool:
    """Return whether a protocol is bad input."""
    try:
        conditions(protocol)
    except InputError:
        return True
    return False


def fills() -> CaseOutcome:
    """Fill 0, 1e-12, one layer, one mobile layer, w*, 1 less one bit, 1, and 200 in between: 4 mm
    and 7 mm.
    """
    rig = load_rig("paper")
    edge = rig.packing_loose / rig.packing_shaken
    special = [1e-12, 0.005, 0.01, 0.015, edge, np.nextafter(edge, 1.0), 0.999, 0.9999]
    negative, beyond, gone, mobile = 0.0, 0.0, 0, set()
    for w, d in product([*special, *np.linspace(0.001, 0.9999, 200)], (0.004, 0.007)):
        point = model(scene(fill=float(w), diameter=d), rig)
        velocity = Waveform(20.0, 5.0).velocity_unit
        printed = as_printed_variant(scene(fill=float(w), diameter=d), rig, velocity)
        gone += not all(map(math.isfinite, (point.W_T, printed, point.bound, point.bed_mass)))
        negative = max(negative, -point.W_T)
        beyond = max(beyond, point.W_T - point.bound)
        mobile.add(
            stack(
                scene(fill=float(w), diameter=d), rig, Filling(rig.packing_shaken, 1.0)
            ).threshold.size
        )
    none = [model(scene(fill=w), rig).W_T for w in (0.0, float(np.nextafter(1.0, 0.0)), 1.0)]
    one = model(scene(fill=0.01), rig)
    half = Protocol("half a layer", scene=scene(fill=0.004, diameter=0.004))
    return CaseOutcome(
        measured=(
            exactly("predictions that are not finite, of 416", gone, 0.0),
            exactly("W_T below 0 or above the bound 4 m V², J", max(negative, beyond, 0.0), 0.0),
            exactly("W_T at fill 0, 1 less one bit and 1, J", max(map(abs, none)), 0.0),
            exactly("layers at 1 %, 4 mm", one.layers, 1.0),
            at_least("W_T of the one layer, J", one.W_T, 1e-5),
            exactly("beds with no and with one mobile layer met, of 2", len({0, 1} & mobile), 2.0),
            exactly("a fill of less than half a layer: bad input, of 1", refused(half), 1.0),
        )
    )


def many_layers() -> CaseOutcome:
    """1e4 layers; a stack of 18 m, whose deep layers are carried by the walls; 1e10 grains; against
    closed forms.
    """
    rig = load_rig("paper")
    thin = Scene(cavity=Cavity(height=0.5), grains=Grains(density=STEEL, diameter=4e-5, fill=0.8))
    deep = Scene(cavity=Cavity(height=20.0), grains=Grains(density=STEEL, diameter=1e-3, fill=0.9))
    large = Scene(
        cavity=Cavity(1.5, 1.5, 4.0, 0.05), grains=Grains(density=STEEL, diameter=1e-3, fill=0.85)
    )
    error, least, sums = 0.0, 0.0, 0.0
    for what in (thin, deep, large):
        bed = stack(what, rig, nominal(what, rig))
        n, d = bed.threshold.size, what.grains.fill * what.cavity.height / bed.threshold.size
        length = janssen_length(
            what.cavity.length, what.cavity.width, rig.wall_friction, rig.janssen_ratio
        )
        depth = d * np.arange(n)
        exact = (
            rig.grain_friction
            * rig.gravity
            * (length / d)
            * np.exp(-depth / length)
            * -np.expm1(-d / length)
        )
        error = max(error, float(np.abs(bed.threshold - exact).max()) * d / length)
        least = max(least, float(-bed.threshold.min()))
        sums = max(sums, abs(bed.threshold.sum() / exact.sum() - 1.0))
    points = [model(what, rig, 6.0) for what in (thin, deep, large)]
    grains = 0.63 * 0.85 * 1.5 * 1.5 * 4.0 / (math.pi / 6.0 * 1e-9)
    too_many = Protocol(
        "20001 layers",
        scene=Scene(grains=Grains(density=STEEL, diameter=0.4 / 20001.0 / 1.00001, fill=1.0)),
    )
    return CaseOutcome(
        measured=(
            # F_i - F_(i-1) is a difference of numbers near the saturated capacity: round-off is
            # 2e-16 of it
            at_most("error of the thresholds, in saturated capacities", error, 1e-15),
            at_most("most negative threshold, m/s²", least, 0.0),
            at_most("relative error of their sum", sums, 1e-12),
            exactly("layers of the thin stack", points[0].layers, 1e4),
            at_least("grains of the largest box", grains, 9e9),
            exactly(
                "W_T outside 0 and the bound, of 3",
                sum(not 0.0 < p.W_T <= p.bound for p in points),
                0.0,
            ),
            exactly("more than 20000 layers: bad input, of 1", refused(too_many), 1.0),
        )
    )


def sizes() -> CaseOutcome:
    """Grains as large as the box, larger, and just smaller; a tower; a slit."""
    rig = load_rig("paper")
    not_fitting = [
        Protocol("as large", scene=scene(diameter=0.15)),
        Protocol("larger", scene=scene(diameter=0.3)),
        Protocol("slit", scene=Scene(cavity=Cavity(0.15, 1e-4, 0.4), grains=Grains(density=STEEL))),
    ]
    fitting = [
        scene(diameter=0.1499999, fill=0.9),
        Scene(cavity=Cavity(0.15, 0.0041, 0.4), grains=Grains(density=STEEL)),
        Scene(cavity=Cavity(20.0, 20.0, 20.0), grains=Grains(density=STEEL, diameter=0.49)),
        Scene(
            cavity=Cavity(0.15, 0.15, 20.0),
            grains=Grains(density=STEEL, diameter=0.01),
            layers=Layers(clearance=10.0, rows=1),
        ),
    ]
    points = [model(what, rig, a) for what in fitting for a in (1.0, 5.0, 100.0)]
    wrong = sum(not (math.isfinite(p.W_T) and 0.0 <= p.W_T <= p.bound) for p in points)
    elastic = replace(rig, restitution_grains=0.9999)
    long = Scene(cavity=Cavity(length=20.0), grains=Grains(density=STEEL, diameter=0.004))
    try:
        model(long, elastic)
        named = 0
    except InputError:
        named = 1
    return CaseOutcome(
        measured=(
            exactly("grains that do not fit: bad input, of 3", sum(map(refused, not_fitting)), 3.0),
            exactly("W_T not finite or outside 0 and the bound, of 12", wrong, 0.0),
            exactly("rows of 5000 grains with e = .9999: bad input, of 1", named, 1.0),
        )
    )


def extremes() -> CaseOutcome:
    """1 mHz to 10 kHz, 1e-6 to 1e4 m/s²; the same motion in other units is the same to the last bit
    but one.
    """
    rig = load_rig("paper")
    box = replace(scene(fill=0.5), layers=Layers(rows=2))
    bed = stack(box, rig, nominal(box, rig))
    unit = (5.0 / (40.0 * math.pi)) ** 2
    scaled = []
    for power in (-60, -20, 0, 20, 60):
        # accelerations times s, frequency times sqrt(s): equal lengths, energies times s
        s = 4.0**power
        total = layers_total(
            bed.threshold * s,
            bed.clearance,
            bed.row_mass,
            bed.restitution,
            5.0 * s,
            20.0 * 2.0**power,
        )
        scaled.append(total.total / s)
    spread = (max(scaled) - min(scaled)) / (bed.mass * unit)
    wrong, closure, named = 0, 0.0, 0
    for f, a, mu in product((1e-3, 1.0, 20.0, 1e4), (1e-6, 1.0, 1e4), (0.0, 0.25)):
        odd = replace(rig, grain_friction=mu)
        try:
            point = model(box, odd, a, f)
            wrong += not (math.isfinite(point.W_T) and 0.0 <= point.W_T <= point.bound)
        except InputError:
            named += 1
        stand = Stand(box, odd, Waveform(f, a), nominal(box, odd), 4096 * f)
        signal = stand.read(4 * 4096)
        wrong += not np.isfinite(signal).all()
        closure = max(
            closure, float(np.abs(stand.drain_ledger()[:, COLUMNS.index("closure")]).max())
        )
    return CaseOutcome(
        measured=(
            at_most("spread of W_T over five scales 1e-36 to 1e36, in m V²", spread, 1e-13),
            exactly(
                "predictions and records that are not finite or beyond the bound, of 48", wrong, 0.0
            ),
            at_most("closure of the ledger", closure, 1e-9),
            no_more("refused by name (no friction, clearance above 400 X), of 24", named, 4.0),
        )
    )


def one_impact() -> CaseOutcome:
    """One layer, one row: two impacts per cycle, each inside one of 4096 intervals, at phases all
    over an interval.
    """
    rig = load_rig("paper")
    per_cycle, worst, missed = 4096, 0.0, 0.0
    for k in range(16):
        clearance = 0.4 + 0.013 * k
        box = Scene(
            grains=Grains(density=STEEL, fill=0.01),
            losses=(),
            layers=Layers(clearance=clearance, rows=1, spread=0.0),
        )
        motion = Waveform(20.0, 5.0)
        stand = Stand(box, rig, motion, nominal(box, rig), per_cycle * motion.frequency)
        force, acceleration = stand.read(12 * per_cycle)[:, -per_cycle:]
        ledger = stand.drain_ledger()[11]
        true = ledger[COLUMNS.index("W_gauge")]
        force_h, acceleration_h = (
            np.fft.rfft(x)[1] * 2.0 / per_cycle for x in (force, acceleration)
        )
        found = -math.pi / motion.omega**2 * (force_h * acceleration_h.conjugate()).imag
        worst = max(worst, abs(found / true - 1.0))
        # Between impacts the force is smooth: a force sampled at points contains no impact at all.
        smooth = force.copy()
        hits = np.abs(force - np.median(force)) > 10.0 * np.abs(force - np.median(force)).mean()
        smooth[hits] = 0.0
        points = (
            -math.pi
            / motion.omega**2
            * ((np.fft.rfft(smooth)[1] * 2.0 / per_cycle) * acceleration_h.conjugate()).imag
        )
        missed = max(missed, abs(points / true - 1.0))
    return CaseOutcome(
        measured=(
            # The phase of an impact is known to its interval: half of 2 pi/4096 rad, over the
            # tangent of the phase, which is near 1.
            at_most("relative error of W from the record, against the ledger", worst, 2e-3),
        ),
        naive=(
            at_least(
                "force sampled at points, where no impact is met: relative error of W", missed, 0.2
            ),
        ),
    )


CASES = (
    Case(
        "fill 0, one layer, one mobile layer, fill 1",
        "a division by no layers; W where nothing can move",
        "exactly 0 at both ends, between 0 and the bound elsewhere",
        fills,
    ),
    Case(
        "1e4 layers, a stack of 18 m, 1e10 grains",
        "thresholds as differences of equal numbers turn negative",
        "thresholds to round-off, W inside the bound",
        many_layers,
    ),
    Case(
        "grains as large as the box",
        "no grain in a row, no layer in a box",
        "bad input by name, or a finite W",
        sizes,
    ),
    Case(
        "1 mHz to 10 kHz, 1e-6 to 1e4 m/s²",
        "overflow, underflow, a W of 0 where the average is too short",
        "scale invariance, finite records, or a named error",
        extremes,
    ),
    Case(
        "one impact per half cycle",
        "an impact that falls between two samples",
        "it counts whole, to its interval",
        one_impact,
    ),
)
