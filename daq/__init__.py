"""The acquisition of a particle-damper test rig: volts, codes, clocks and session files. It knows no grain."""

from typing import TYPE_CHECKING, Any

from daq.caches import place_caches

if TYPE_CHECKING:
    from daq.session import open_session

__all__ = ["open_session"]

place_caches()


def __getattr__(name: str) -> Any:
    """`daq.open_session`, imported on first use: h5py takes a while to load."""
    if name in __all__:
        from daq import session

        return getattr(session, name)
    raise AttributeError(f"module 'daq' has no attribute {name!r}")
