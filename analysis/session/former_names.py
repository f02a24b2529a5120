"""Names of the first edition in sessions that were recorded with it, and what they are today.

A session stays as it was written; whoever reads its conditions or its prediction reads today's
names.
"""

from collections.abc import Mapping
from typing import Any

__all__ = ["condition_today", "prediction_today"]

KEYS: Mapping[str, str] = {"mistake": "deliberate_error"}
WORDS: Mapping[str, Mapping[str, str]] = {
    "drive": {"servo": "prescribed", "coupled": "shaker"},
    "bed": {"slug": "single_mass"},
}
PREDICTED: Mapping[str, str] = {"W_T_paper": "W_T_as_printed"}


def condition_today(condition: Mapping[str, Any]) -> dict[str, Any]:
    """Return a session's condition with today's keys, and today's words for drive and bed."""
    found = _renamed(condition, KEYS)
    for key, words in WORDS.items():
        word = found.get(key)
        if isinstance(word, str):
            found[key] = words.get(word, word)
    return found


def prediction_today(document: Any) -> Any:
    """Return a session's prediction with today's keys; whatever is no prediction as it is."""
    conditions = document.get("conditions") if isinstance(document, Mapping) else None
    if not isinstance(conditions, Mapping):
        return document
    today = {
        name: _renamed(entry, PREDICTED) if isinstance(entry, Mapping) else entry
        for name, entry in conditions.items()
    }
    return {**document, "conditions": today}


def _renamed(entry: Mapping[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    """Return a mapping with new names for old keys, in their places; today's key comes first."""
    return {
        names.get(key, key): value
        for key, value in entry.items()
        if key not in names or names[key] not in entry
    }
