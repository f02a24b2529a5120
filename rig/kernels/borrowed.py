"""Array views that compiled code passes on without reference counting."""

from typing import Any, Protocol, TypeVar, cast

from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

# numba's compiler modules are untyped.
struct: Any = cgutils.create_struct_proxy
owner: Any = types.MemInfoPointer(types.voidptr)  # type: ignore[no-untyped-call]

View = TypeVar("View")


class Borrowed(Protocol):
    """A function that returns its argument."""

    def __call__(self, array: View, /) -> View: ...


def _borrowed(typing_context: Any, array: types.Array) -> Any:  # noqa: ARG001  numba's signature
    def without_owner(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        view = struct(signature.args[0])(context, builder, value=arguments[0])
        view.meminfo = context.get_constant_null(owner)
        view.parent = context.get_constant_null(types.pyobject)
        return view._getvalue()

    return array(array), without_owner


borrowed = cast(Borrowed, intrinsic(_borrowed))
"""Return the same array as a view without an owner; the owner must outlive it (an argument is owned
by the caller).

Compiled code increments and decrements an atomic counter for every array that it passes on, which
costs more than an event of a row.
"""
