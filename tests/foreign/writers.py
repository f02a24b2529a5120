"""Writers of other people's formats with their metadata stated at will."""

import datetime
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import scipy.io

Array = np.ndarray
Properties = Mapping[str, Any]


def text(
    path: Path, columns: Sequence[Sequence[str]], head: Sequence[str] = (), delimiter: str = ",",
    encoding: str = "utf-8", end: str = "",
) -> None:  # fmt: skip
    """Words in columns below lines of a header."""
    rows = [delimiter.join(row) + end for row in zip(*columns, strict=True)]
    path.write_bytes("\n".join([*head, *rows, ""]).encode(encoding))


def words(values: Array, form: str = "%.7f", decimal: str = ".") -> list[str]:
    return [(form % value).replace(".", decimal) for value in values]


def thousands(values: Array, point: str, decimal: str, form: str = "%.3f") -> list[str]:
    """Numbers with a sign between thousands."""
    found = []
    for value in values:
        whole, _, rest = (form % abs(value)).partition(".")
        grouped = f"{int(whole):,}".replace(",", point)
        found.append(("-" if value < 0 else "") + grouped + decimal + rest)
    return found


def tdms(path: Path, channels: Mapping[str, tuple[Array, Properties]]) -> None:
    """Channels of the group "lab"."""
    import nptdms

    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment(
            [
                nptdms.ChannelObject("lab", name, values, dict(told))
                for name, (values, told) in channels.items()
            ]
        )


def linear(slope: float) -> dict[str, Any]:
    """LabVIEW's properties of a linear scale."""
    return {
        "NI_Scaling_Status": "unscaled",
        "NI_Number_Of_Scales": 1,
        "NI_Scale[0]_Scale_Type": "Linear",
        "NI_Scale[0]_Linear_Slope": slope,
        "NI_Scale[0]_Linear_Y_Intercept": 0.0,
        "NI_Scale[0]_Linear_Input_Source": 0xFFFFFFFF,
    }


def start(seconds: float) -> np.datetime64:
    return np.datetime64("2026-11-20T10:00:00", "us") + np.timedelta64(round(seconds * 1e6), "us")


def iso(seconds: float) -> str:
    day = datetime.datetime(2026, 11, 20, 10, tzinfo=datetime.UTC)
    return (day + datetime.timedelta(seconds=seconds)).isoformat()


def sep005(path: Path, entries: Sequence[Properties], arrays: Sequence[Array]) -> None:
    np.savez(
        path,
        channels=np.array(json.dumps(list(entries))),
        **{f"data_{n}": values for n, values in enumerate(arrays)},
    )


def hdf5(path: Path, datasets: Mapping[str, tuple[Array, Properties]]) -> None:
    with h5py.File(path, "w") as file:
        for name, (values, told) in datasets.items():
            file[name] = values
            file[name].attrs.update(dict(told))


def mat(path: Path, values: Mapping[str, Any]) -> None:
    scipy.io.savemat(path, dict(values))


def set58(
    name: str, values: Array, step: float, unit: str = "", *, first: float = 0.0, function: int = 1,
    node: int = 1, times: Array | None = None, kind: int = 4, order: str = "", quantity: int = 12,
) -> bytes:  # fmt: skip
    """A set 58. kind: ordinate type; order: "<" or ">" for a binary one; times: an uneven abscissa."""
    even = times is None
    size = {2: 4, 4: 8, 5: 8, 6: 16}[kind]
    lines = [
        f"{name:80}", f"{'NONE':80}", f"{'20-Nov-26 10:00:00':80}", f"{'NONE':80}", f"{'NONE':80}",
        f"{function:5d}{0:10d}{0:5d}{0:10d} {'PT':>10}{node:10d}{3:4d} {'NONE':>10}{0:10d}{0:4d}",
        f"{kind:10d}{values.size:10d}{int(even):10d}{first if even else 0:13.5e}{step if even else 0:13.5e}{0:13.5e}",
        f"{17:10d}{0:5d}{0:5d}{0:5d} {'Time':20} {'s':20}",
        f"{quantity:10d}{0:5d}{0:5d}{0:5d} {name[:20]:20} {unit or 'NONE':20}",
        *[f"{0:10d}{0:5d}{0:5d}{0:5d} {'NONE':20} {'NONE':20}"] * 2,
    ]  # fmt: skip
    head = "\n".join(lines).encode() + b"\n"
    mark = b"    -1\n"
    if not order:
        wide, digits, per = (13, 5, 6) if kind == 2 else (20, 12, 4)
        flat = values if even else None
        if flat is None:
            rows = [f"{t:13.5e}{y:{wide}.{digits}e}" for t, y in zip(times, values, strict=True)]
            per //= 2
        else:
            rows = [f"{y:{wide}.{digits}e}" for y in flat]
        body = (
            "\n".join("".join(rows[n : n + per]) for n in range(0, len(rows), per)).encode() + b"\n"
        )
        return mark + f"{58:6d}\n".encode() + head + body + mark
    dtype = order + {2: "f4", 4: "f8", 5: "c8", 6: "c16"}[kind]
    table = values if even else np.stack([times, values], axis=1)
    data = np.ascontiguousarray(table).astype(dtype).tobytes()
    assert len(data) == values.size * size * (1 if even else 2)
    binary = f"{58:6d}b{1 if order == '<' else 2:6d}{2:6d}{11:12d}{len(data):12d}{0:6d}{0:6d}{0:12d}{0:12d}\n"
    return mark + binary.encode() + head + data + mark


def set164(length: float, force: float, text: str) -> bytes:
    """Units: factors from SI."""
    factors = [f"{value:25.17e}".replace("e", "D") for value in (length, force, 1.0)]
    lines = [
        f"{-1:6d}",
        f"{164:6d}",
        f"{9:10d}{text:>20}{2:10d}",
        "".join(factors),
        f"{273.15:25.17e}",
        f"{-1:6d}",
        "",
    ]
    return "\n".join(lines).encode()


LVM_HEAD = """\
LabVIEW Measurement\t
Writer_Version\t2
Reader_Version\t2
Separator\tTab
Decimal_Separator\t.
Multi_Headings\tNo
X_Columns\tOne
***End_of_Header***\t
\t
Channels\t2\t\t
Samples\t{count}\t{count}\t
Y_Unit_Label\t{force}\t{acceleration}\t
X0\t{x0}\t{x1}\t
Delta_X\t{step}\t{step}\t
***End_of_Header***\t\t\t
X_Value\tForce\tAcc\tComment"""
"""Head of a LabVIEW measurement file."""


def wav(path: Path, rate: int, table: Array) -> None:
    from scipy.io import wavfile

    wavfile.write(path, rate, table)
