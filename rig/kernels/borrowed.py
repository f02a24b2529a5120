"""Arrays that compiled code hands on without counting their references."""

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.base import BaseContext
from numba.core.typing import Signature
from numba.extending import intrinsic


@intrinsic
def borrowed(typing_context: Any, array: types.Array) -> Any:  # noqa: ARG001
    """The same array, seen without its owner, which has to outlive it: the caller's argument does.

    Compiled code counts up and down, atomically, for every array that it hands on: more than an event of a row costs.
    """

    def without_owner(context: BaseContext, builder: ir.IRBuilder, signature: Signature, arguments: Any) -> Any:
        view = cgutils.create_struct_proxy(signature.args[0])(context, builder, value=arguments[0])
        view.meminfo = context.get_constant_null(types.MemInfoPointer(types.voidptr))
        view.parent = context.get_constant_null(types.pyobject)
        return view._getvalue()

    return array(array), without_owner
