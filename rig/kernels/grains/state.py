"""The whole state of an engine between two stretches as plain arrays, for a checkpoint."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rig.kernels.grains.arrays import NEIGHBOURS, WALL_ENTRIES, Floats, GrainArrays, Ints, Lists


class EngineState(NamedTuple):
    """What an engine needs to go on with the same bits; SI units, in its own order of the grains.

    `state._asdict()` names the arrays, `EngineState(**arrays)` takes them back.

    place, motion, load, ident, cavity : of the grains, as `GrainArrays`
    pair : first and second grain of each contact, shape (contacts, 2)
    pair_memory, pair_rolling : what each remembers, shapes (contacts, 6), (contacts or 0, 6)
    wall : grain and number of the wall of each contact with a wall, shape (contacts, 2)
    wall_memory, wall_rolling : what each remembers
    elastic : energy stored in contacts by kind, J, shape (4,)
    totals : as `TOTALS` has them, shape (16,)
    force : of the walls on the grains by slab and direction, N, shape (2, 3)
    impulse : of the walls since the start, N s, shape ()
    steps : taken since the start, shape ()
    """

    place: Floats
    motion: Floats
    load: Floats
    ident: Ints
    cavity: Ints
    pair: Ints
    pair_memory: Floats
    pair_rolling: Floats
    wall: Ints
    wall_memory: Floats
    wall_rolling: Floats
    elastic: Floats
    totals: Floats
    force: Floats
    impulse: Floats
    steps: NDArray[np.int64]


class Contacts(NamedTuple):
    """The contacts of an engine, as `EngineState` has them."""

    pair: Ints
    pair_memory: Floats
    pair_rolling: Floats
    wall: Ints
    wall_memory: Floats
    wall_rolling: Floats


def contacts(lists: Lists) -> Contacts:
    """Return the neighbours that touch and what they remember."""
    pairs, entries = lists.sizes[NEIGHBOURS], lists.sizes[WALL_ENTRIES]
    touching = np.flatnonzero(lists.touching[:pairs])
    first = np.repeat(np.arange(lists.first.size - 1, dtype=np.int32), np.diff(lists.first))
    at_wall = np.flatnonzero(lists.wall_touching[:entries])
    rolls = lists.rolling.size > 0
    return Contacts(
        np.column_stack((first[touching], lists.other[touching])),
        lists.memory[touching],
        lists.rolling[touching if rolls else touching[:0]],
        np.column_stack((lists.wall_grain[at_wall], lists.wall[at_wall].astype(np.int32))),
        lists.wall_memory[at_wall],
        lists.wall_rolling[at_wall if rolls else at_wall[:0]],
    )


def restore(state: EngineState, grains: GrainArrays, lists: Lists) -> None:
    """Give empty arrays the grains and contacts of a state.

    The lists then hold contacts alone: each stretch begins by making them anew.
    """
    for field in GrainArrays._fields:
        getattr(grains, field)[:] = getattr(state, field)
    pairs, entries = len(state.pair), len(state.wall)
    lists.first[:] = np.searchsorted(state.pair[:, 0], np.arange(lists.first.size))
    lists.other[:pairs] = state.pair[:, 1]
    lists.touching[:pairs] = 1
    lists.memory[:pairs] = state.pair_memory
    lists.wall_grain[:entries], lists.wall[:entries] = state.wall.T
    lists.wall_touching[:entries] = 1
    lists.wall_memory[:entries] = state.wall_memory
    if lists.rolling.size:
        lists.rolling[:pairs] = state.pair_rolling
        lists.wall_rolling[:entries] = state.wall_rolling
    lists.sizes[NEIGHBOURS], lists.sizes[WALL_ENTRIES] = pairs, entries
