"""Write the universal file format, dataset 58 (function at nodal DOF), ASCII in double precision,
which all modal tools read.

Layout: SDRC I-DEAS Test Data Acquisition, "Universal Dataset Number 58". Record 7 has only six
digits for the step, so that the exact rate is stored in ID line 3.
"""

import io
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TextIO

import numpy as np
import numpy.typing as npt

from daq.formats.wave import Spectrum, Wave
from daq.strange_text import visible
from daq.whole_files import whole_file

__all__ = ["write_uff58"]

TIME, FREQUENCY_RESPONSE = 1, 4  # function types
REAL_DOUBLE, COMPLEX_DOUBLE = 4, 6  # ordinate data types
# specific data types; 0 is unknown
KINDS = {"acceleration": 12, "force": 13, "velocity": 11, "displacement": 8}
SECONDS, HERTZ = 17, 18
DIRECTIONS = {"x": 1, "y": 2, "z": 3}
EMPTY_AXIS = (0, "NONE", "NONE")
Axis = tuple[int, str, str]


def write_uff58(
    path: Path, title: str, waves: Sequence[Wave], spectra: Iterable[Spectrum] = ()
) -> None:
    """Write time responses (type 1), one dataset per wave, then frequency responses (type 4).

    Raises OSError.
    """
    with whole_file(path) as file:
        text = io.TextIOWrapper(
            file, encoding="ascii", errors="replace", newline="\n", write_through=True
        )
        _write(text, title, waves, spectra)
        text.detach()


def _write(text: TextIO, title: str, waves: Sequence[Wave], spectra: Iterable[Spectrum]) -> None:
    for node, wave in enumerate(waves, start=1):
        _time(text, title, wave, node)
    nodes = {wave.name: (node, wave) for node, wave in enumerate(waves, start=1)}
    for spectrum in spectra:
        (response_node, response), (reference_node, reference) = (
            nodes[spectrum.response],
            nodes[spectrum.reference],
        )
        _response(text, title, spectrum, (response_node, response), (reference_node, reference))


def _time(text: TextIO, title: str, wave: Wave, node: int) -> None:
    axes = (
        (SECONDS, "Time", "s"),
        (KINDS.get(wave.quantity, 0), wave.name, wave.unit),
        EMPTY_AXIS,
        EMPTY_AXIS,
    )
    ids = (wave.name, title, f"rate {wave.rate!r} Hz", wave.start or "NONE", f"unit {wave.unit}")
    freedom = f"{_word(wave.name):>10}{node:10d}{_direction(wave):4d} {'NONE':>10}{0:10d}{0:4d}"
    _dataset(
        text,
        TIME,
        ids,
        freedom,
        REAL_DOUBLE,
        wave.signal.size,
        0.0,
        1 / wave.rate,
        axes,
        wave.signal.chunks(),
    )


def _response(
    text: TextIO,
    title: str,
    spectrum: Spectrum,
    response: tuple[int, Wave],
    reference: tuple[int, Wave],
) -> None:
    over, under = response[1], reference[1]
    axes = (
        (HERTZ, "Frequency", "Hz"),
        (KINDS.get(over.quantity, 0), over.name, over.unit),
        (KINDS.get(under.quantity, 0), under.name, under.unit),
        EMPTY_AXIS,
    )
    words = f"{over.name} over {under.name} at the harmonics"
    ids = (
        words,
        title,
        f"step {spectrum.step!r} Hz",
        over.start or "NONE",
        f"unit {spectrum.unit}",
    )
    freedom = (
        f"{_word(over.name):>10}{response[0]:10d}{_direction(over):4d} "
        f"{_word(under.name):>10}{reference[0]:10d}{_direction(under):4d}"
    )
    pairs = [np.ascontiguousarray(spectrum.values).view(np.float64)]
    count, step = spectrum.values.size, spectrum.step
    _dataset(text, FREQUENCY_RESPONSE, ids, freedom, COMPLEX_DOUBLE, count, step, step, axes, pairs)


def _dataset(
    text: TextIO,
    kind: int,
    ids: Sequence[str],
    freedom: str,
    ordinate: int,
    count: int,
    first: float,
    step: float,
    axes: Sequence[Axis],
    values: Iterable[npt.NDArray[np.float64]],
) -> None:
    text.write(f"{-1:6d}\n{58:6d}{'':74}\n")
    for line in ids:
        text.write(f"{visible(line)[:80]:80}\n")
    text.write(f"{kind:5d}{0:10d}{0:5d}{0:10d} {freedom}\n")
    text.write(f"{ordinate:10d}{count:10d}{1:10d}{first:13.5e}{step:13.5e}{0.0:13.5e}\n")
    for number, label, unit in axes:
        text.write(
            f"{number:10d}{0:5d}{0:5d}{0:5d} {visible(label)[:20]:20} {visible(unit)[:20]:20}\n"
        )
    for chunk in values:  # the length of each but the last is a multiple of four: whole lines
        whole = chunk.size - chunk.size % 4
        np.savetxt(text, chunk[:whole].reshape(-1, 4), fmt="%20.12e", delimiter="")
        if whole < chunk.size:
            np.savetxt(text, chunk[whole:].reshape(1, -1), fmt="%20.12e", delimiter="")
    text.write(f"{-1:6d}\n")


def _word(name: str) -> str:
    """Return a name cut to the ten characters of an entity name."""
    return visible(name)[:10] or "NONE"


def _direction(wave: Wave) -> int:
    """Return the direction code of a DOF: +-1, 2, 3 for +-x, y, z; 1 for a drive axis without a
    name.
    """
    axis = wave.direction[-1:].lower()
    return DIRECTIONS.get(axis, 1) * (-1 if wave.direction.startswith("-") else 1)
