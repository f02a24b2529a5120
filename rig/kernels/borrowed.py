"""Arrays that compiled code hands on without counting their references."""

from typing import Any, Protocol, TypeVar, cast

from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

# numba's compiler gives no types
struct: Any = cgutils.create_struct_proxy
owner: Any = types.MemInfoPointer(types.voidptr)  # type: ignore[no-untyped-call]

View = TypeVar("View")


class Borrowed(Protocol):
    """Gives back what it gets."""

    def __call__(self, array: View, /) -> View: ...


def _borrowed(typing_context: Any, array: types.Array) -> Any:  # noqa: ARG001  numba's signature
    def without_owner(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        view = struct(signature.args[0])(context, builder, value=arguments[0])
        view.meminfo = context.get_constant_null(owner)
        view.parent = context.get_constant_null(types.pyobject)
        return view._getvalue()

    return array(array), without_owner


borrowed = cast(Borrowed, intrinsic(_borrowed))
"""The same array, seen without its owner, which has to outlive it (an argument's owner is the caller).

Compiled code counts up and down, atomically, for every array that it hands on: more than an event of a row costs.
"""
