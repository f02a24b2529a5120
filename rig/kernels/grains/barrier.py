"""A barrier between threads that run compiled code without the interpreter's lock.

A step of the grains takes about 0.1 ms, too short for the barriers of the interpreter. Each thread
publishes the number of the barrier that it has reached and waits until every other thread has
published it too. Waiting threads spin for a while and then give their core away, so that a machine
with other work on it does not stand still.
"""

from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.typing import NDArray

from daq.compiled import njit

LINE = 16
"""Integers per thread: two cache lines, so that no two threads write to one (false sharing)."""
SPINS = 2000
"""Looks at the other threads before the core is given away: about 5 microseconds."""


def new_flags(threads: int) -> NDArray[np.int64]:
    """Return the flags of a barrier for a number of threads, nobody having arrived."""
    return np.zeros(threads * LINE, np.int64)


def _element(context: Any, builder: Any, array_type: Any, array: Any, index: Any) -> Any:
    data = context.make_array(array_type)(context, builder, array).data
    return builder.gep(data, [index])


@intrinsic  # type: ignore[misc, unused-ignore]
def _publish(_typing: Any, flags: Any, _index: Any, _value: Any) -> Any:
    """Store `value` in flags[index]; everything written before is visible to who reads it."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = _element(context, builder, signature.args[0], args[0], args[1])
        builder.store_atomic(args[2], place, "release", 8)
        return context.get_dummy_value()

    return types.void(flags, types.int64, types.int64), generate


@intrinsic  # type: ignore[misc, unused-ignore]
def _observe(_typing: Any, flags: Any, _index: Any) -> Any:
    """Return flags[index]; what was written before it was published is visible afterwards."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = _element(context, builder, signature.args[0], args[0], args[1])
        return builder.load_atomic(place, "acquire", 8)

    return types.int64(flags, types.int64), generate


@intrinsic  # type: ignore[misc, unused-ignore]
def _give_way(_typing: Any) -> Any:
    """Let the system run another thread on this core (POSIX sched_yield)."""

    def generate(_context: Any, builder: Any, _signature: Any, _args: Any) -> Any:
        kind = ir.FunctionType(ir.IntType(32), [])
        function = cgutils.get_or_insert_function(builder.module, kind, "sched_yield")
        return builder.call(function, [])

    return types.int32(), generate


@njit(cache=True, nogil=True)
def wait_for_all(flags: NDArray[np.int64], thread: int, threads: int, number: int) -> None:
    """Return when every thread has reached barrier `number` (1, 2, ...).

    flags : from `new_flags`; thread : this thread, 0 .. threads - 1
    """
    if threads == 1:
        return
    _publish(flags, thread * LINE, number)  # type: ignore[call-arg]  # numba passes the context
    for other in range(threads):
        spins = 0
        while _observe(flags, other * LINE) < number:
            spins += 1
            if spins > SPINS:
                _give_way()
