"""Apply the changes of the command line to a protocol's tree: `--set path=value` replaces a value,
`--vary path=list` adds or replaces an axis of the grid.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from daq.documents.notes import Node, describe
from rig.documents.yaml_reader import read_value
from rig.errors import InputError, Mistake, quote
from rig.protocol.vary import ZIP


def edited(
    root: Node,
    sets: Sequence[str],
    varies: Sequence[str],
    seed: int | None = None,
    rig: str | None = None,
) -> Node:
    """Return the tree with every change made; a value that is set is no longer varied.

    Raises InputError for every change that is not `path=value`.
    """
    root = _with_repeats_as_mapping(root)
    mistakes: list[Mistake] = []
    for option, changes in (("--set", sets), ("--vary", varies)):
        for change in changes:
            try:
                root = _changed(root, option, change)
            except InputError as error:
                mistakes += error.mistakes
    if mistakes:
        raise InputError(*mistakes)
    if seed is not None:
        root = _put(root, ["seed"], Node("--seed", seed, str(seed)))
    if rig is not None:
        root = _put(root, ["rig"], Node("--rig", rig, rig, quoted=True))
    return root


def _with_repeats_as_mapping(root: Node) -> Node:
    """Return the tree with `repeats: 4` written as `repeats: {n: 4}`, so that its parts have paths."""
    repeats = root.value.get("repeats") if isinstance(root.value, dict) else None
    if repeats is None or not isinstance(repeats.value, int) or isinstance(repeats.value, bool):
        return root
    mapping = Node(repeats.where, {"n": repeats}, key_places={"n": repeats.where})
    return _put(root, ["repeats"], mapping)


def _changed(root: Node, option: str, change: str) -> Node:
    """Return the tree with one change made; `--set vary.path=list` is `--vary path=list`."""
    place = f"{option} {change if len(change) <= 60 else change[:57] + '...'}"
    path, equals, text = change.partition("=")
    names = path.strip().split(".")
    if not equals or not all(names):
        raise InputError(Mistake(place, "", quote(change), "path=value, such as scene.bed=empty"))
    value = read_value(text, place)
    if names[0] == "vary" and len(names) > 1:
        option, names = "--vary", names[1:]
    if option == "--vary":
        return _varied(root, ".".join(names), value)
    return _put(_unvaried(root, ".".join(names)), names, value)


def _put(node: Node, names: Sequence[str], value: Node) -> Node:
    """Return the tree with a value at a path; missing mappings on the way are created."""
    name, *rest = names
    if node.value is not None and not isinstance(node.value, dict):
        raise InputError(
            Mistake(value.where, "", f"a path through {describe(node)}", "a path through mappings")
        )
    entries = dict(node.value or {})
    entries[name] = _put(entries.get(name, Node(value.where, {})), rest, value) if rest else value
    return Node(
        node.where,
        entries,
        key_places={**node.key_places, name: node.key_places.get(name, value.where)},
    )


def _varied(root: Node, path: str, value: Node) -> Node:
    """Return the tree with an axis replaced in its position, or added as the last one."""
    for names in _axes(root):
        if names[-1] == path:
            return _put(root, names, value)
    return _put(root, ["vary", path], value)


def _unvaried(root: Node, path: str) -> Node:
    """Return the tree without the axis of a path."""
    for names in _axes(root):
        if names[-1] == path:
            return _without(root, names)
    return root


def _without(node: Node, names: Sequence[str]) -> Node:
    """Return the tree without the entry at a path, and without mappings that this leaves empty."""
    name, *rest = names
    entries = dict(node.value) if isinstance(node.value, dict) else {}
    shrunk = _without(entries[name], rest) if rest else None
    if shrunk is None or shrunk.value == {}:
        del entries[name]
    else:
        entries[name] = shrunk
    return Node(node.where, entries, key_places=node.key_places)


def _axes(root: Node) -> Iterator[tuple[str, ...]]:
    """Yield the keys that lead to each axis: ("vary", path) or ("vary", "zip", path)."""
    vary = root.value.get("vary") if isinstance(root.value, dict) else None
    if vary is None or not isinstance(vary.value, dict):
        return
    for key, node in vary.value.items():
        if ZIP.fullmatch(key) and isinstance(node.value, dict):
            yield from (("vary", key, path) for path in node.value)
        else:
            yield ("vary", key)
