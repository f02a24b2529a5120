"""Flags of a run that stand in the session as scalars, from the drive or from the import."""

from collections.abc import Mapping

__all__ = ["DOUBT", "NOT_REACHED", "stated_flags", "use_of"]

NOT_REACHED = "level_not_reached"  # prefix; the limit that stopped the level follows: level_not_reached_voltage
STOPPED = "stopped_by_"  # scalars of this prefix are 1 for the limit that stopped the level
LIMITS = "use_"  # scalars of this prefix are utilisations of a limit, 1 at the limit
DOUBT = "doubt_"  # scalars of this prefix are 1 for what an import found wrong in a record


def stated_flags(scalars: Mapping[str, float]) -> tuple[str, ...]:
    """Return limits of the exciter that the run exceeds ("over_force"), what kept the level from
    being reached, "clipped" where the amplifier clipped, and what the import found ("held_force").
    """
    over = [f"over_{name}" for name, used in use_of(scalars).items() if used > 1]
    stopped = [f"{NOT_REACHED}_{name}" for name in _set(scalars, STOPPED)]
    clipped = ["clipped"] if scalars.get("clipped", 0.0) > 0 else []
    return (*over, *stopped, *clipped, *_set(scalars, DOUBT))


def use_of(scalars: Mapping[str, float]) -> dict[str, float]:
    """Return the utilisation of the exciter's limits (1: at the limit), by the limit's name."""
    return {
        name.removeprefix(LIMITS): used for name, used in scalars.items() if name.startswith(LIMITS)
    }


def _set(scalars: Mapping[str, float], prefix: str) -> list[str]:
    """Return the names behind a prefix whose scalars are set."""
    return [
        name.removeprefix(prefix)
        for name, value in scalars.items()
        if name.startswith(prefix) and value > 0
    ]
