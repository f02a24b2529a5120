"""numba's `njit`, for all kernels: code that is kept on disk is loaded without the compiler.

numba prepares to compile before it looks into its cache: it imports and lists the implementations
of all that it can compile, scipy.linalg among them. That takes longer than loading every kernel of
a run. Here it looks first. What is not kept is compiled as ever, because the compiler prepares
itself.
"""

from functools import wraps
from typing import Any

from numba import njit
from numba.core.caching import Cache
from numba.core.cpu import CPUContext
from numba.core.runtime import rtsys

__all__ = ["njit"]


def _looks_first(load: Any) -> Any:
    """Return numba's function that loads a kernel from the cache, changed to prepare nothing else."""

    @wraps(load)
    def load_overload(cache: Any, signature: Any, context: Any) -> Any:
        if type(context) is CPUContext:
            # Loaded code needs only the memory of its arrays prepared.
            context.refresh = lambda: rtsys.initialize(context)  # type: ignore[method-assign, unused-ignore]
            try:
                return load(cache, signature, context)
            except Exception:  # noqa: BLE001  another numba may need more: then all, as it would itself
                pass
            finally:
                del context.refresh
        return load(cache, signature, context)

    return load_overload


Cache.load_overload = _looks_first(Cache.load_overload)  # type: ignore[method-assign, unused-ignore]
