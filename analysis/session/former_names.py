"""Translate the names of the first edition, in sessions that were recorded with it, to today's.

The file of a session stays as it was written. Its conditions, prediction, claims and rig are
translated when they are read.
"""

import re
from collections.abc import Mapping
from typing import Any

__all__ = [
    "condition_today",
    "of_first_edition",
    "path_today",
    "prediction_today",
    "protocol_today",
    "rig_today",
    "text_today",
]

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
WORDS_AT: Mapping[str, Mapping[str, str]] = {
    "drive.mode": WORDS["drive"],
    "scene.bed": WORDS["bed"],
}
"""Path of a protocol -> its renamed values."""

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
    """Return a session's prediction with today's keys; any other value as it is."""
    conditions = document.get("conditions") if isinstance(document, Mapping) else None
    if not isinstance(conditions, Mapping):
        return document
    today = {
        name: _renamed(entry, PREDICTED) if isinstance(entry, Mapping) else entry
        for name, entry in conditions.items()
    }
    return {**document, "conditions": today}


def protocol_today(document: Any) -> Any:
    """Return a session's protocol with today's paths and words in its claims; any other value as it
    is.
    """
    claims = document.get("expect") if isinstance(document, Mapping) else None
    if not isinstance(claims, list):
        return document
    today = [_claim_today(claim) if isinstance(claim, Mapping) else claim for claim in claims]
    return {**document, "expect": today}


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
    """Return a protocol or rig file that the first edition wrote out in a session, with today's
    names, so that it can be run again; any other text as it is.
    """
    if not text or not of_first_edition(text):
        return text
    for old, new in WRITTEN:
        text = re.sub(old, new, text, flags=re.MULTILINE)
    return text


def of_first_edition(text: str) -> bool:
    """Return whether a protocol or rig file was written out by the first edition."""
    return any(key in text for key in FIRST)


def path_today(path: str) -> str:
    """Return a path of a protocol or a rig file with today's names."""
    return ".".join(PATHS.get(part, part) for part in path.split("."))


def _claim_today(claim: Mapping[str, Any]) -> dict[str, Any]:
    """Return a claim with today's paths and words; parts of another type as they are, because the
    document is checked afterwards.
    """
    found, about = dict(claim), claim.get("about")
    for key in ("about", "over"):
        if isinstance(found.get(key), str):
            found[key] = path_today(found[key])
    if isinstance(found.get("values"), list):
        found["values"] = [_word_today(about, value) for value in found["values"]]
    if isinstance(found.get("cases"), list):
        found["cases"] = [
            _case_today(case, about) if isinstance(case, Mapping) else case
            for case in found["cases"]
        ]
    return found


def _case_today(case: Mapping[str, Any], about: Any) -> dict[str, Any]:
    """Return a case of a claim about the old path `about`."""
    found, at, levels = dict(case), case.get("at"), case.get("levels")
    if isinstance(at, Mapping):
        found["at"] = {path_today(str(path)): _word_today(path, at[path]) for path in at}
    if isinstance(levels, list):
        found["levels"] = [_level_today(level, about) for level in levels]
    return found


def _level_today(level: Any, about: Any) -> Any:
    """Return a level of a case with today's word for its value."""
    if not isinstance(level, Mapping) or "value" not in level:
        return level
    return {**level, "value": _word_today(about, level["value"])}


def _word_today(path: Any, value: Any) -> Any:
    """Return today's word for a value of the field at a path; any other value as it is."""
    words = WORDS_AT.get(path, {}) if isinstance(path, str) else {}
    return words.get(value, value) if isinstance(value, str) else value


def _value_today(value: Mapping[str, Any]) -> dict[str, Any]:
    """Return an entry of a rig's values with today's path and word."""
    path = value.get("path")
    if not isinstance(path, str):
        return dict(value)
    today = {**value, "path": path_today(path)}
    return today | ({"value": _word_today(path, value["value"])} if "value" in value else {})


def _renamed(entry: Mapping[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    """Return a mapping with new names for old keys, in their places; today's key comes first."""
    return {
        names.get(key, key): value
        for key, value in entry.items()
        if key not in names or names[key] not in entry
    }
