"""Names of the first edition in sessions that were recorded with it, and their names of today.

A session stays as it was written; whoever reads its conditions or its prediction reads today's
names.
"""

import re
from collections.abc import Mapping
from typing import Any

__all__ = ["condition_today", "path_today", "prediction_today", "rig_today", "text_today"]

KEYS: Mapping[str, str] = {"mistake": "deliberate_error"}
WORDS: Mapping[str, Mapping[str, str]] = {
    "drive": {"servo": "prescribed", "coupled": "shaker"},
    "bed": {"slug": "single_mass"},
}
PATHS: Mapping[str, str] = {
    "slug": "single_mass",
    "play": "clearance",
    "refill_play": "refill_clearance",
    "mistake": "deliberate_error",
    "allow_undersampled": "paper_rule",
}
FIRST = ("allow_undersampled: ", "refill_play: ")
"""Keys by which a file of the first edition is recognised: it wrote one of them into every protocol
and every rig file.
"""

WRITTEN = (
    (r"\bmode: servo\b", "mode: prescribed"),
    (r"\bmode: coupled\b", "mode: shaker"),
    (r"\bbed: slug\b", "bed: single_mass"),
    (r"\bslug: ", "single_mass: "),
    (r"\bslug:$", "single_mass:"),
    (r"\bscene\.slug\b", "scene.single_mass"),
    (r"\bplay: ", "clearance: "),
    (r"\blayers\.play\b", "layers.clearance"),
    (r"\brefill_play: ", "refill_clearance: "),
    (r"^mistake: ", "deliberate_error: "),
    (r"^mistake:$", "deliberate_error:"),
    (r"\ballow_undersampled: false\b", "paper_rule: true"),
    (r"\ballow_undersampled: true\b", "paper_rule: false"),
    (r"^rig: default$", "rig: paper"),
    (r"^name: default$", "name: paper"),
)
PREDICTED: Mapping[str, str] = {"W_T_paper": "W_T_as_printed"}


def condition_today(condition: Mapping[str, Any]) -> dict[str, Any]:
    """Return a session's condition with today's keys, and today's words for drive and bed."""
    found = _renamed(condition, KEYS)
    for key, words in WORDS.items():
        word = found.get(key)
        if isinstance(word, str):
            found[key] = words.get(word, word)
    varied = found.get("varied")
    if isinstance(varied, Mapping):
        found["varied"] = {path_today(str(name)): text for name, text in varied.items()}
    return found


def prediction_today(document: Any) -> Any:
    """Return a session's prediction with today's keys; anything else unchanged."""
    conditions = document.get("conditions") if isinstance(document, Mapping) else None
    if not isinstance(conditions, Mapping):
        return document
    today = {
        name: _renamed(entry, PREDICTED) if isinstance(entry, Mapping) else entry
        for name, entry in conditions.items()
    }
    return {**document, "conditions": today}


def rig_today(document: Any) -> Any:
    """Return a session's rig document with today's paths among its values, and today's words."""
    values = document.get("values") if isinstance(document, Mapping) else None
    if not isinstance(values, list):
        return document
    return {
        **document,
        "values": [_value_today(v) if isinstance(v, Mapping) else v for v in values],
    }


def text_today(text: str | None) -> str | None:
    """Return a protocol or rig file that the first edition wrote out, with today's names, so that
    it can be run again.
    """
    if not text or not any(key in text for key in FIRST):
        return text
    for old, new in WRITTEN:
        text = re.sub(old, new, text, flags=re.MULTILINE)
    return text


def path_today(path: str) -> str:
    """Return a path of a protocol or a rig file with today's names."""
    return ".".join(PATHS.get(part, part) for part in path.split("."))


def _value_today(value: Mapping[str, Any]) -> dict[str, Any]:
    """Return a value of a rig document with today's path, and today's word where it is one."""
    path = value.get("path")
    if not isinstance(path, str):
        return dict(value)
    words = WORDS.get({"drive.mode": "drive", "scene.bed": "bed"}.get(path, ""), {})
    word = value.get("value")
    today = {**value, "path": path_today(path)}
    return {**today, "value": words.get(word, word)} if isinstance(word, str) else today


def _renamed(entry: Mapping[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    """Return a mapping with new names for old keys, in their places; today's key comes first."""
    return {
        names.get(key, key): value
        for key, value in entry.items()
        if key not in names or names[key] not in entry
    }
