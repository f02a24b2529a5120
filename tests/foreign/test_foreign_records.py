"""Records as other people's tools write them: each kind of statement that a file makes, right,
refused or flagged; never a silent wrong energy.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from known_box import (
    FREQUENCY,
    GRAVITY,
    MASS,
    RATE,
    Outcome,
    W,
    energy,
    motion,
    outcome,
    record,
)
from writers import (
    LVM_HEAD,
    hdf5,
    iso,
    linear,
    mat,
    sep005,
    set58,
    set164,
    start,
    tdms,
    text,
    thousands,
    wav,
    words,
)

Make = Callable[[Path], tuple[str, str]]
STEP = 1 / RATE
PLAIN = "force: {channel: F, calibration_U: 1 %}\nacceleration: {channel: a, calibration_U: 1 %}\n"
TIME = "time: {channel: t}\n" + PLAIN
LAB = PLAIN.replace("channel: ", "channel: lab/")
AT = f"rate: {RATE:g} Hz\n"
UFF = PLAIN + AT


def csv(folder: Path, r: object, **more: object) -> str:
    """A plain text file of t, F, a."""
    columns = [words(r.t, "%.9e"), words(r.F, "%.9e"), words(r.a, "%.9e")]  # type: ignore[attr-defined]
    text(folder / "r.csv", columns, ["t,F,a"], **more)  # type: ignore[arg-type]
    return "r.csv"


# --- right energies -------------------------------------------------------------------------------


def start_times(late: float, force_at: float, acceleration_at: float, offset: float = 0.0) -> Make:
    """TDMS channels that start at their own times."""

    def make(folder: Path) -> tuple[str, str]:
        r = record(late)
        told = {"wf_increment": STEP, "wf_start_offset": 0.0}
        tdms(folder / "r.tdms", {
            "F": (r.F, told | {"wf_start_time": start(force_at), "wf_start_offset": offset, "unit_string": "N"}),
            "a": (r.a, told | {"wf_start_time": start(acceleration_at), "unit_string": "m/s^2"}),
        })  # fmt: skip
        return "r.tdms", LAB

    return make


def sep005_starts(folder: Path) -> tuple[str, str]:
    r = record(0.004)
    entries = [{"name": "F", "fs": RATE, "unit_str": "N", "start_timestamp": iso(0.004)},
               {"name": "a", "fs": RATE, "unit_str": "m/s^2", "start_timestamp": iso(0.0)}]  # fmt: skip
    sep005(folder / "r.npz", entries, [r.F, r.a])
    return "r.npz", PLAIN


def sep005_units(folder: Path) -> tuple[str, str]:
    r = record()
    entries = [
        {"name": "F", "fs": RATE, "unit_str": "kN"},
        {"name": "a", "fs": RATE, "unit_str": "g"},
    ]
    sep005(folder / "r.npz", entries, [r.F / 1e3, r.a / GRAVITY])
    return "r.npz", PLAIN


def hdf5_starts(folder: Path) -> tuple[str, str]:
    r = record(0.00153)
    hdf5(folder / "r.h5", {"F": (r.F, {"fs": RATE, "units": "N", "start_time": 10.00153}),
                           "a": (r.a, {"dt": STEP, "units": "m s-2", "start_time": 10.0})})  # fmt: skip
    return "r.h5", PLAIN


def hdf5_codes(folder: Path) -> tuple[str, str]:
    r = record()
    scales = [np.abs(values).max() / 30000 for values in (r.F, r.a)]
    codes = [np.rint(v / s + 100).astype(">i2") for v, s in zip((r.F, r.a), scales, strict=True)]
    told = [{"scale_factor": s, "add_offset": -100 * s} for s in scales]
    hdf5(folder / "r.h5", {"F": (codes[0], told[0]), "a": (codes[1], told[1])})
    return "r.h5", UFF


def hdf5_compound(folder: Path) -> tuple[str, str]:
    r = record()
    table = np.empty(r.t.size, dtype=[("t", "<f8"), ("F", ">f4"), ("a", ">f4")])
    table["t"], table["F"], table["a"] = r.t, r.F, r.a
    hdf5(folder / "r.h5", {"table": (table, {})})
    return "r.h5", UFF.replace("channel: ", "channel: table#")


def hdf5_single_times(folder: Path) -> tuple[str, str]:
    """Times in single precision have steps that differ by their digits."""
    r = record()
    hdf5(folder / "r.h5", {"t": (r.t.astype("f4"), {}), "F": (r.F, {}), "a": (r.a, {})})
    return "r.h5", TIME


def tdms_codes(folder: Path) -> tuple[str, str]:
    r = record()
    scales = [np.abs(values).max() / 30000 for values in (r.F, r.a)]
    codes = [np.rint(v / s).astype("i2") for v, s in zip((r.F, r.a), scales, strict=True)]
    told = {"wf_increment": STEP}
    tdms(
        folder / "r.tdms",
        {"F": (codes[0], told | linear(scales[0])), "a": (codes[1], told | linear(scales[1]))},
    )
    return "r.tdms", LAB


def tdms_stamps(folder: Path) -> tuple[str, str]:
    r = record()
    stamps = np.array([start(t) for t in r.t])
    tdms(folder / "r.tdms", {"Stamp": (stamps, {}), "F": (r.F, {}), "a": (r.a, {}),
                             "Comment": (["start", "box 85 %"], {})})  # fmt: skip
    return "r.tdms", "time: {channel: lab/Stamp}\n" + LAB


def tdms_volts(folder: Path) -> tuple[str, str]:
    r = record()
    tdms(
        folder / "r.tdms",
        {
            "F": (r.F * 2.25e-3, {"unit_string": "Volts"}),
            "a": (r.a / GRAVITY * 100, {"unit_string": "mV"}),
        },
    )
    mapping = LAB.replace("lab/F,", "lab/F, unit: V, sensitivity: 2.25 mV/N,")
    return "r.tdms", AT + mapping.replace("lab/a,", "lab/a, unit: mV, sensitivity: 100 mV/g,")


def uff_label(label: str, size: float, order: str = "<", kind: int = 4) -> Make:
    """A unit in the label of an axis."""

    def make(folder: Path) -> tuple[str, str]:
        r = record()
        sets = [
            set58("F", r.F, STEP, "N", order=order, kind=kind),
            set58("a", r.a / size, STEP, label, order=order, kind=kind),
        ]
        (folder / "r.uff").write_bytes(b"".join(sets))
        return "r.uff", UFF

    return make


def uff_units_set(folder: Path) -> tuple[str, str]:
    r = record()
    sets = [set164(1e3, 1e-3, "mm,kN,s"), set58("F", r.F * 1e-3, STEP, quantity=13, order="<"),
            set58("a", r.a * 1e3, STEP, order="<")]  # fmt: skip
    (folder / "r.uff").write_bytes(b"".join(sets))
    return "r.uff", UFF


def uff_minimum(folder: Path) -> tuple[str, str]:
    """Sets whose abscissas begin at different times."""
    r = record(0.0025)
    sets = [set58("F", r.F, STEP, "N", first=0.0025), set58("a", r.a, STEP, "m/s^2")]
    (folder / "r.uff").write_bytes(b"".join(sets))
    return "r.uff", UFF


def uff_uneven(order: str) -> Make:
    """The first step is shorter than all others; x stands beside y."""

    def make(folder: Path) -> tuple[str, str]:
        t = np.arange(round(4 * RATE)) / 4650.0
        t[1:] -= 0.00002
        r = record(t=t)
        sets = [
            set58("F", r.F, 0, "N", times=t, order=order),
            set58("a", r.a, 0, "m/s^2", times=t, order=order),
        ]
        (folder / "r.uff").write_bytes(b"".join(sets))
        return "r.uff", PLAIN

    return make


def uff_odds(folder: Path) -> tuple[str, str]:
    """Function type 0 over time, an unknown set before, CR LF after the numbers, the word of the end
    mark inside them, and zeros that fill the last line.
    """
    r = record()
    F = r.F.copy()
    bits = F[np.abs(F).argmin() :][:1].view(np.uint8)
    bits[:6] = np.frombuffer(b"    -1", np.uint8)  # the lowest bits of a small number
    one = set58("F", F, STEP, "N", order="<", function=0)
    assert b"    -1" in one[1000:-7]
    rows = set58("a", r.a[:-2], STEP, "m/s^2", kind=2, function=0).split(b"\n")
    rows[-3] = rows[-3] + f"{0:13.5e}".encode() * 4
    strange = b"    -1\n  1858\n  words\n    -1\n"
    cut = one.replace(f"{r.F.size:10d}{1:10d}".encode(), f"{r.F.size - 2:10d}{1:10d}".encode())
    (folder / "r.unv").write_bytes(strange + cut[:-7] + b"\r\n" + cut[-7:] + b"\n".join(rows))
    return "r.unv", UFF


def mat_struct(folder: Path) -> tuple[str, str]:
    r = record()
    units = {"F": "N", "a": "g"}
    mat(
        folder / "r.mat",
        {"rec": {"F": r.F, "a": r.a / GRAVITY, "fs": RATE, "units": units}, "fs": 1.0},
    )
    return "r.mat", PLAIN.replace("channel: ", "channel: rec.")


def mat_new(folder: Path) -> tuple[str, str]:
    """Version 7.3 is HDF5; a struct is a group there."""
    r = record()
    hdf5(folder / "x.h5", {"rec/F": (r.F[:, None], {}), "rec/a": (r.a[:, None], {})})
    data = (folder / "x.h5").read_bytes()
    (folder / "r.mat").write_bytes(b"MATLAB 7.3 MAT-file".ljust(512, b" ") + data)
    return "r.mat", UFF.replace("channel: ", "channel: rec.")


def headers(time: str, force: str, acceleration: str, sizes: tuple[float, float, float]) -> Make:
    """Units in the headers of a text file."""

    def make(folder: Path) -> tuple[str, str]:
        r = record()
        columns = [
            words(r.t / sizes[0], "%.8e"),
            words(r.F / sizes[1], "%.8e"),
            words(r.a / sizes[2], "%.8e"),
        ]
        text(
            folder / "r.csv",
            columns,
            [f"{time};{force};{acceleration}"],
            delimiter=";",
            encoding="utf-16",
        )
        mapping = PLAIN.replace("channel: F", f'channel: "{force}"').replace(
            "channel: a", f'channel: "{acceleration}"'
        )
        return "r.csv", f'time: {{channel: "{time}"}}\n' + mapping

    return make


def clocks(form: Callable[[float], str]) -> Make:
    """Times of day."""

    def make(folder: Path) -> tuple[str, str]:
        r = record()
        text(folder / "r.csv", [[form(t) for t in r.t], words(r.F), words(r.a)], ["t,F,a"])
        return "r.csv", TIME

    return make


def midnight(t: float) -> str:
    """Twelve-hour times from two seconds before midnight."""
    at = (86398 + t) % 86400
    hour, rest = divmod(at, 3600)
    minute, second = divmod(rest, 60)
    half = "PM" if hour >= 12 else "AM"
    return f"20.11.2026 {int(hour) % 12 or 12}:{int(minute):02d}:{second:09.6f} {half}"


def rounded_times(form: str) -> Make:
    def make(folder: Path) -> tuple[str, str]:
        r = record()
        text(folder / "r.csv", [words(r.t, form), words(r.F), words(r.a)], ["t,F,a"])
        return "r.csv", TIME

    return make


def jittered(folder: Path) -> tuple[str, str]:
    """Steps that vary by 1 % rms, known well."""
    rng = np.random.default_rng(1)
    t = np.cumsum(STEP * (1 + 0.01 * rng.standard_normal(round(4 * RATE))))
    csv(folder, record(t=t))
    return "r.csv", TIME


def european(folder: Path) -> tuple[str, str]:
    r = record()
    columns = [words(r.t, "%.7f", ","), thousands(1e3 * r.F, ".", ","), words(r.a, "%.6f", ",")]
    head = [
        "sep=;",
        "Pr\u00fcfstand: R\u00fcttler",
        "Datum;20.11.2026 10:00",
        "Zeit;Kraft;Beschleunigung;",
        "[s];[mN];[m/s\u00b2];",
    ]
    text(folder / "r.csv", columns, head, ";", "latin-1", end=";")
    return "r.csv", PLAIN.replace("channel: F", "channel: Kraft").replace(
        "channel: a", "channel: Beschleunigung"
    )


def european_skipped(folder: Path) -> tuple[str, str]:
    european(folder)
    mapping = PLAIN.replace("channel: F", "channel: 2").replace("channel: a", "channel: 3")
    return "r.csv", "time: {channel: 1}\ncsv: {delimiter: ';', decimal: ',', skip: 4}\n" + mapping


def american(folder: Path) -> tuple[str, str]:
    """Thousands with a comma, in quotes, CR LF."""
    r = record()
    quoted = [f'"{word}"' for word in thousands(1e3 * r.F, ",", ".")]
    text(
        folder / "r.csv",
        [words(r.t), quoted, words(r.a / GRAVITY)],
        ["time (s),force (mN),acc (g)"],
        end="\r",
    )
    return "r.csv", TIME.replace("channel: F", "channel: force").replace(
        "channel: a,", "channel: acc,"
    ).replace("channel: t", "channel: time")


def aligned_columns(folder: Path) -> tuple[str, str]:
    r = record()
    columns = [words(r.t, "%14.8f"), words(r.F, "%14.6f"), words(r.a, "%14.7f")]
    text(folder / "r.dat", columns, [f"header line {n}: value" for n in range(20)], delimiter=" ")
    mapping = TIME.replace("channel: t", "channel: 1").replace("channel: F", "channel: 2")
    return "r.dat", 'csv: {delimiter: " ", skip: 20}\n' + mapping.replace(
        "channel: a", "channel: 3"
    )


def labview(
    folder: Path, acceleration: str = "g", size: float = GRAVITY, late: float = 0.0
) -> tuple[str, str]:
    r = record(late)
    head = LVM_HEAD.format(
        count=r.t.size, force="Newtons", acceleration=acceleration, x0=late, x1=0.0, step=repr(STEP)
    )
    text(
        folder / "r.lvm",
        [words(r.t, "%.8f"), words(r.F), words(r.a / size), [""] * r.t.size],
        head.split("\n"),
        "\t",
    )
    return "r.lvm", PLAIN.replace("channel: F", "channel: Force").replace(
        "channel: a", "channel: Acc"
    )


def labview_starts(folder: Path) -> tuple[str, str]:
    return labview(folder, "m/s^2", 1.0, 0.001)


def third_harmonic(folder: Path) -> tuple[str, str]:
    csv(folder, record(harmonics={3: 1.5 * 5}))
    return "r.csv", TIME


def second_harmonic(folder: Path) -> tuple[str, str]:
    csv(folder, record(harmonics={2: 5 * 5}))
    return "r.csv", TIME


def drifting(folder: Path) -> tuple[str, str]:
    r = record()
    csv(folder, type(r)(r.t, r.F + 20 * r.t, r.a))
    return "r.csv", TIME


def coarse(folder: Path) -> tuple[str, str]:
    r = record()
    csv(folder, type(r)(r.t, np.rint(r.F), 0.05 * np.rint(r.a / 0.05)))
    return "r.csv", TIME


def wav_codes(folder: Path) -> tuple[str, str]:
    r = record()
    table = np.rint(np.stack([r.F / 0.01, r.a / 0.001], axis=1)).astype("i2")
    wav(folder / "r.wav", int(RATE), table)
    mapping = PLAIN.replace("channel: F", "channel: 1, unit: mN, scale: 10")
    return "r.wav", mapping.replace("channel: a", "channel: 2, scale: 0.001")


RIGHT: dict[str, Make] = {
    "TDMS: force starts later": start_times(0.0025, 0.0025, 0.0),
    "TDMS: force starts earlier": start_times(-0.001, 0.0, 0.001),
    "TDMS: a third of a sample by wf_start_offset": start_times(0.3 * STEP, 0.0, 0.0, 0.3 * STEP),
    "SEP-005: start_timestamp": sep005_starts,
    "SEP-005: unit_str": sep005_units,
    "HDF5: start_time, dt": hdf5_starts,
    "HDF5: scale_factor of big-endian codes": hdf5_codes,
    "HDF5: compound": hdf5_compound,
    "HDF5: times in single precision": hdf5_single_times,
    "TDMS: scaled codes": tdms_codes,
    "TDMS: time stamps, and a channel of text": tdms_stamps,
    "TDMS: volts": tdms_volts,
    "UFF58: label g": uff_label("g", GRAVITY),
    "UFF58: label mm/s^2, big-endian single": uff_label("mm/s^2", 1e-3, ">", 2),
    "UFF58: label in/s^2, ASCII": uff_label("in/s^2", 0.0254, ""),
    "UFF58: set 164": uff_units_set,
    "UFF58: abscissa minimum": uff_minimum,
    "UFF58: uneven, binary": uff_uneven("<"),
    "UFF58: odds and ends": uff_odds,
    "MAT: struct": mat_struct,
    "MAT 7.3: struct": mat_new,
    "text: units in brackets, UTF-16": headers("time [ms]", "force [kN]", "acc [g]", (1e-3, 1e3, GRAVITY)),
    "text: units in other ways": headers("t / \u00b5s", "Kraft (lbf)", "a <cm/s\u00b2>", (1e-6, 4.4482216152605, 1e-2)),
    "text: ISO times": clocks(lambda t: iso(t).replace("T", " ")[:26].replace("+00:00", "")),
    "text: times over midnight": clocks(midnight),
    "text: four decimals": rounded_times("%.4f"),
    "text: three decimals, times repeat": rounded_times("%.3f"),
    "text: six digits": rounded_times("%.6g"),
    "text: jitter": jittered,
    "text: European": european,
    "text: European by number": european_skipped,
    "text: American": american,
    "text: aligned columns": aligned_columns,
    "LabVIEW text": labview,
    "LabVIEW text: X0": labview_starts,
    "drift": drifting,
    "coarse steps": coarse,
    "WAV with a scale": wav_codes,
}  # fmt: skip


@pytest.mark.parametrize("kind", RIGHT)
def test_the_energy_is_right_by_what_the_file_states(tmp_path: Path, kind: str) -> None:
    """Within U, which is 1.4 % by the certificates; the noise alone leaves 0.1 % of W here."""
    name, mapping = RIGHT[kind](tmp_path)
    found = outcome(tmp_path / name, mapping)
    assert not found.refused
    assert found.near(W)
    assert found.frequency == pytest.approx(FREQUENCY, rel=1e-4)
    assert not found.fails, found.flags


@pytest.mark.parametrize("make", [third_harmonic, second_harmonic])
def test_the_drive_is_found_below_its_stronger_harmonic(tmp_path: Path, make: Make) -> None:
    name, mapping = make(tmp_path)
    found = outcome(tmp_path / name, mapping)
    harmonics = {3: 7.5} if make is third_harmonic else {2: 25.0}
    t = np.arange(200000) / 200000 / FREQUENCY
    F, a = motion(t, harmonics)
    v = np.cumsum(a - a.mean()) / 200000 / FREQUENCY
    # the loop integral over one cycle of the motion itself
    assert found.near(float((F * (v - v.mean())).sum() / 200000 / FREQUENCY))
    assert found.frequency == pytest.approx(FREQUENCY, rel=1e-4)


# --- refusals -------------------------------------------------------------------------------------


def contradicted(label: str, mapping: str, values: float = 1.0) -> Make:
    def make(folder: Path) -> tuple[str, str]:
        r = record()
        hdf5(folder / "r.h5", {"F": (r.F * values, {"units": label}), "a": (r.a, {})})
        return "r.h5", UFF.replace("channel: F", f"channel: F{mapping}")

    return make


def codes_without_scale(folder: Path) -> tuple[str, str]:
    r = record()
    hdf5(folder / "r.h5", {"F": (np.rint(100 * r.F).astype("i2"), {"units": "N"}), "a": (r.a, {})})
    return "r.h5", UFF


def text_codes(folder: Path) -> tuple[str, str]:
    r = record()
    text(folder / "r.csv", [words(r.t), words(100 * r.F, "%.0f"), words(r.a)], ["t,F,a"])
    return "r.csv", TIME


def wav_without_scale(folder: Path) -> tuple[str, str]:
    name, mapping = wav_codes(folder)
    return name, mapping.replace(", scale: 0.001", "")


def complex_numbers(folder: Path) -> tuple[str, str]:
    r = record()
    sep005(
        folder / "r.npz", [{"name": "F", "fs": RATE}, {"name": "a", "fs": RATE}], [r.F + 0.1j, r.a]
    )
    return "r.npz", PLAIN


def complex_set(folder: Path) -> tuple[str, str]:
    r = record()
    sets = [set58("F", r.F + 0j, STEP, kind=6, order="<"), set58("a", r.a, STEP)]
    (folder / "r.uff").write_bytes(b"".join(sets))
    return "r.uff", UFF


def same_names(folder: Path) -> tuple[str, str]:
    r = record()
    sets = [
        set58("Shaker test", v, STEP, node=n, order="<") for n, v in enumerate((r.a, r.F, r.a), 1)
    ]
    (folder / "r.uff").write_bytes(b"".join(sets))
    return "r.uff", UFF.replace("channel: F", "channel: Shaker test").replace(
        "channel: a", "channel: 3"
    )


def doubled_comma(folder: Path) -> tuple[str, str]:
    r = record()
    text(folder / "r.csv", [words(v, "%.4f", ",") for v in (r.t, r.F, r.a)])
    return "r.csv", UFF.replace("channel: F", "channel: 3").replace("channel: a", "channel: 5")


def empty_cells(folder: Path) -> tuple[str, str]:
    r = record()
    slow = [word if n % 2 == 0 else "" for n, word in enumerate(words(r.a))]
    text(folder / "r.csv", [words(r.t), words(r.F), slow], ["t,F,a"])
    return "r.csv", TIME


def empty_line(folder: Path) -> tuple[str, str]:
    csv(folder, record())
    rows = (folder / "r.csv").read_text().split("\n")
    rows[5000] = ""
    (folder / "r.csv").write_text("\n".join(rows))
    return "r.csv", PLAIN + AT


def cut_line(folder: Path) -> tuple[str, str]:
    csv(folder, record())
    (folder / "r.csv").write_text((folder / "r.csv").read_text()[:-20])
    return "r.csv", TIME


def lost_sample(form: str) -> Make:
    def make(folder: Path) -> tuple[str, str]:
        r = record()
        columns = [words(r.t, form), words(r.F), words(r.a)]
        text(folder / "r.csv", [column[:9000] + column[9001:] for column in columns], ["t,F,a"])
        return "r.csv", TIME

    return make


def lost_beside(folder: Path) -> tuple[str, str]:
    """The time column is not asked for, but it is there."""
    name, _ = lost_sample("%.7f")(folder)
    return name, PLAIN + AT


def wrong_rate(folder: Path) -> tuple[str, str]:
    csv(folder, record())
    return "r.csv", PLAIN + "rate: 5000 Hz\n"


def two_rates(folder: Path) -> tuple[str, str]:
    r = record()
    tdms(
        folder / "r.tdms",
        {"F": (r.F, {"wf_increment": STEP}), "a": (r.a, {"wf_increment": 2 * STEP})},
    )
    return "r.tdms", LAB


def far_rates(folder: Path) -> tuple[str, str]:
    r = record()
    entries = [{"name": name, "fs": 2 * RATE, "time": "data_2"} for name in ("F", "a")]
    sep005(folder / "r.npz", [*entries, {"name": "time"}], [r.F, r.a, r.t])
    return "r.npz", PLAIN


def starts_and_delay(folder: Path) -> tuple[str, str]:
    name, mapping = start_times(0.0025, 0.0025, 0.0)(folder)
    return name, mapping.replace("lab/F,", "lab/F, delay: 2.5 ms,")


def milliseconds_unsaid(folder: Path) -> tuple[str, str]:
    r = record()
    text(folder / "r.csv", [words(1e3 * r.t), words(r.F), words(r.a)], ["t,F,a"])
    return "r.csv", TIME


def struct_array(folder: Path) -> tuple[str, str]:
    r = record()
    mat(folder / "r.mat", {"rec": np.array([(r.F,), (r.a,)], dtype=[("x", object)]), "fs": RATE})
    return "r.mat", PLAIN.replace("channel: F", "channel: rec").replace(
        "channel: a", "channel: rec"
    )


def ambiguous_decimal(folder: Path) -> tuple[str, str]:
    r = record()
    text(folder / "r.csv", [words(r.F, "%.3f", ","), words(r.a, "%.3f", ",")], ["F;a"], ";")
    return "r.csv", UFF


REFUSED: dict[str, tuple[Make, str]] = {
    "unit against the mapping": (contradicted("kN", ", unit: N"), "correct one of them"),
    "volts without a sensitivity": (contradicted("mV", ""), "sensitivity from the certificate"),
    "unit of another quantity": (contradicted("Pa", ""), "no unit of force"),
    "unknown unit": (contradicted("poods", ""), "no unit that is known"),
    "codes without a scale": (codes_without_scale, "no scale beside them"),
    "whole numbers in text without a unit": (text_codes, "no scale beside them"),
    "WAV without a scale": (wav_without_scale, "no scale beside them"),
    "complex array": (complex_numbers, "complex numbers"),
    "complex set": (complex_set, "complex numbers"),
    "one name for three sets": (same_names, "3 sets have it"),
    "decimal comma as delimiter": (doubled_comma, "both delimiter and decimal sign"),
    "empty cells": (empty_cells, "two rates"),
    "empty line": (empty_line, "line 5001 is empty"),
    "cut line": (cut_line, "columns, the others have 3"),
    "lost sample": (lost_sample("%.7f"), "from sample 8999 to 9000"),
    "lost sample, four decimals": (lost_sample("%.4f"), "time column is not even"),
    "lost sample, three decimals": (lost_sample("%.3f"), "time column is not even"),
    "lost sample, time column not asked for": (lost_beside, "is not even"),
    "rate against a time column": (wrong_rate, "rate"),
    "two rates": (two_rates, "different rates"),
    "rate against the times": (far_rates, "correct one of them"),
    "starts and a delay": (starts_and_delay, "states a delay"),
    "milliseconds unsaid": (milliseconds_unsaid, "unit of the time column"),
    "struct array": (struct_array, "struct array"),
}  # fmt: skip


@pytest.mark.parametrize("kind", REFUSED)
def test_what_cannot_be_known_is_refused_with_what_to_do(tmp_path: Path, kind: str) -> None:
    make, said = REFUSED[kind]
    name, mapping = make(tmp_path)
    assert said in outcome(tmp_path / name, mapping).refused


def test_a_comma_with_three_digits_is_read_where_zeros_prove_it(tmp_path: Path) -> None:
    """-0,123 is no thousands; were all numbers like 1,234 the decimal sign would be asked for."""
    name, mapping = ambiguous_decimal(tmp_path)
    assert outcome(tmp_path / name, mapping).near(W)
    r = record()
    text(
        tmp_path / "r.csv",
        [words(np.abs(r.F) + 1, "%.3f", ","), words(np.abs(r.a) + 1, "%.3f", ",")],
        ["F;a"],
        ";",
    )
    assert "decimal" in outcome(tmp_path / name, mapping).refused


def test_overrule_puts_the_mapping_before_the_file(tmp_path: Path) -> None:
    name, mapping = contradicted("kN", ", unit: N, overrule: true")(tmp_path)
    found = outcome(tmp_path / name, mapping)
    assert found.near(W)
    assert "overruled" in " ".join(found.told)
    name, mapping = start_times(0.0, 0.0025, 0.0)(tmp_path)
    assert not outcome(tmp_path / name, mapping).near(W)
    assert outcome(tmp_path / name, mapping.replace("lab/F,", "lab/F, overrule: true,")).near(W)


# --- flags ----------------------------------------------------------------------------------------


def saturated(channel: str) -> Make:
    def make(folder: Path) -> tuple[str, str]:
        limit = 0.93 * (MASS * 5 if channel == "F" else 5)
        if channel == "F":
            csv(folder, record(before=lambda F, a: (np.clip(F, -limit, limit), a)))
        else:
            csv(folder, record(before=lambda F, a: (F, np.clip(a, -limit, limit))))
        return "r.csv", TIME

    return make


def held(counts: tuple[int, ...]) -> Make:
    def make(folder: Path) -> tuple[str, str]:
        r = record()
        at = np.cumsum(np.resize(np.array(counts), r.t.size))
        place = np.concatenate(([0], at))[np.searchsorted(at, np.arange(r.t.size), side="right")]
        csv(folder, type(r)(r.t, r.F[np.minimum(place, r.t.size - 1)], r.a))
        return "r.csv", TIME

    return make


def interpolated(folder: Path) -> tuple[str, str]:
    r = record()
    csv(folder, type(r)(r.t, np.interp(r.t, r.t[::4], r.F[::4]), r.a))
    return "r.csv", TIME


def two_clocks(folder: Path) -> tuple[str, str]:
    t = np.arange(round(8 * RATE)) / RATE
    r = record(t=t)
    F = motion(t * (1 + 20e-6))[0] + (r.F - motion(t)[0])
    csv(folder, type(r)(t, F, r.a))
    return "r.csv", TIME


def gain_step(folder: Path) -> tuple[str, str]:
    r = record()
    csv(folder, type(r)(r.t, r.F * np.where(r.t < 2, 1, 1.15), r.a))
    return "r.csv", TIME


def lost_without_times(folder: Path) -> tuple[str, str]:
    r = record()
    keep = np.delete(np.arange(r.t.size), 9000)
    csv(folder, type(r)(r.t[:-1], r.F[keep], r.a[keep]))
    return "r.csv", TIME


def nominal_rate(folder: Path) -> tuple[str, str]:
    r = record()
    entries = [{"name": name, "fs": 1.05 * RATE, "time": "data_2"} for name in ("F", "a")]
    sep005(folder / "r.npz", [*entries, {"name": "time"}], [r.F, r.a, r.t])
    return "r.npz", PLAIN


def unit_skipped(folder: Path) -> tuple[str, str]:
    name, mapping = labview(folder)
    return name, mapping + "csv: {skip: 15}\ntime: {channel: X_Value}\n"


def weak_drive(folder: Path) -> tuple[str, str]:
    """The drive is 5 % of its second harmonic."""
    csv(folder, record(harmonics={2: 100.0}))
    return "r.csv", TIME


FLAGGED: dict[str, tuple[Make, str]] = {
    "force saturated before noise": (saturated("F"), "saturated_force"),
    "acceleration saturated before noise": (saturated("a"), "saturated_acceleration"),
    "held four times": (held((4,)), "held_force"),
    "held three and four times": (held((3, 4, 3)), "held_force"),
    "interpolated": (interpolated, "resampled_force"),
    "two clocks": (two_clocks, "clock_slip_force"),
    "gain step": (gain_step, "gain_step_force"),
    "lost sample with even times": (lost_without_times, "clock_slip"),
    "nominal rate beside times": (nominal_rate, "rate_force"),
    "unit in skipped lines": (unit_skipped, "unit_acceleration"),
    "a weak line at half the frequency": (weak_drive, "drive_line_acceleration"),
}  # fmt: skip


@pytest.mark.parametrize("kind", FLAGGED)
def test_what_the_signals_show_fails_the_verdict_by_its_name(tmp_path: Path, kind: str) -> None:
    make, flag = FLAGGED[kind]
    name, mapping = make(tmp_path)
    found: Outcome = outcome(tmp_path / name, mapping)
    assert not found.refused
    assert any(one.startswith(flag) for one in found.flags), found.flags
    assert found.fails


def test_the_times_of_a_nominal_rate_are_taken(tmp_path: Path) -> None:
    name, mapping = nominal_rate(tmp_path)
    assert outcome(tmp_path / name, mapping).near(energy())
