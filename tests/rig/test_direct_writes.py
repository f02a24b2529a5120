"""Nothing writes to a path directly: a kill would leave half a file, and a link would be followed."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

OWN = {
    "daq/whole_files.py",  # the writer that all others use
    "daq/session/disk_space.py",  # room for a session, under its temporary name
    "daq/session/writer_lock.py",
    "daq/formats/reading.py",  # archives of others, whose `open` reads
    "daq/formats/tdms.py",  # TDMS files of others, whose `open` reads
    "daq/session/hdf5_flags.py",  # one byte of a session in place
    "daq/regular_files.py",  # opens what it has seen to be a file, for reading
    "daq/session/hdf5.py",  # a session grows in place; it is created under a temporary name
    "rig/lammps_engine/child.py",  # the pipe to the engine's parent
    "rig/lammps_engine/process.py",  # what LAMMPS prints, in a temporary folder that ends with it
    "rig/benchmarks/problems/records.py",  # throw-away files in a folder of the benchmark's own
    "rig/benchmarks/problems/recording.py",
}
METHODS = {"write_text", "write_bytes", "touch", "tofile"}
COPIES = {"copyfile", "copy", "copy2", "copytree", "move"}
INTO = {"savefig", "savetxt", "savez", "savez_compressed", "savemat", "save"}
"""Write into their first argument: a path, or a file that somebody has opened."""
OPENERS = {"open", "fdopen", "File"}
MODULES = {"shutil", "os", "Path", "io", "gzip", "h5py"}


def named(call: ast.Call) -> str:
    return call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")


def owner(call: ast.Call) -> str:
    value = call.func.value if isinstance(call.func, ast.Attribute) else None
    return value.id if isinstance(value, ast.Name) else ""


def is_for_writing(call: ast.Call) -> bool:
    """Whether an opening has a mode that writes; one that is not written out counts as such."""
    modes = [word.value for word in call.keywords if word.arg in ("mode", "flags")]
    place = 0 if isinstance(call.func, ast.Attribute) and owner(call) not in MODULES else 1
    modes += call.args[place : place + 1]
    return any(
        not isinstance(mode, ast.Constant) or bool(set("wax+") & set(str(mode.value)))
        for mode in modes
    )


def opened(tree: ast.AST) -> set[str]:
    """Names of open files: bound by `with`, by a call of io, or handed over as one."""
    found = {"file", "stream"}
    for node in ast.walk(tree):
        if isinstance(node, ast.withitem) and isinstance(node.optional_vars, ast.Name):
            found.add(node.optional_vars.id)
        values = [node.value] if isinstance(node, ast.Assign) else []
        for value in values:
            calls = [
                one for one in ast.walk(value) if isinstance(one, ast.Call) and owner(one) == "io"
            ]
            for target in node.targets if calls and isinstance(node, ast.Assign) else ():
                found |= {name.id for name in ast.walk(target) if isinstance(name, ast.Name)}
    return found


def writes(call: ast.Call, files: set[str]) -> bool:
    """Whether a call writes to a path; files: names of open files."""
    name = named(call)
    if name in METHODS:
        return isinstance(call.func, ast.Attribute)
    if name in COPIES:
        return owner(call) == "shutil"
    if name in INTO:
        target = call.args[0] if call.args else None
        return isinstance(call.func, ast.Attribute) and not (
            isinstance(target, ast.Name) and target.id in files
        )
    if name in OPENERS:
        if (owner(call), name) == ("os", "open"):
            return [ast.unparse(word) for word in call.args[:1]] != ["os.devnull"]
        return is_for_writing(call)
    return False


def direct_writes(source: str) -> Iterator[str]:
    """Lines that write to a path."""
    tree = ast.parse(source)
    files = opened(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and writes(node, files):
            yield f"{node.lineno}: {ast.unparse(node)[:60]}"


@pytest.mark.parametrize(
    "source",
    [
        "path.write_text('x')",
        "(a / 'b').write_bytes(b'')",
        "open(path, 'w')",
        "open(path, mode='a')",
        "path.open('wb')",
        "io.open(path, 'x')",
        "path.open('r+')",
        "np.savetxt(path, rows)",
        "figure.savefig(folder / 'a.svg')",
        "savemat = scipy.io.savemat(path, {})",
        "os.open(path, os.O_WRONLY)",
        "h5py.File(path, 'w')",
        "h5py.File(path, mode)",
        "shutil.copyfile(a, b)",
        "rows.tofile(path)",
        "gzip.open(path, 'wt')",
    ],
)
def test_the_walk_finds_direct_writes(source: str) -> None:
    assert list(direct_writes(source))


@pytest.mark.parametrize(
    "source",
    [
        "path.open('rb')",
        "open(path)",
        "path.read_text()",
        "with whole_file(path) as file:\n    np.savetxt(file, rows)",
        "data = io.BytesIO()\nfigure.savefig(data, format='png')",
        "h5py.File(path, 'r')",
        "write_whole(path, text)",
        "row.copy()",
        "zipfile.ZipFile(path)",
        "os.open(os.devnull, os.O_WRONLY)",
    ],
)
def test_reading_and_writing_whole_files_are_none(source: str) -> None:
    assert list(direct_writes(source)) == []


def test_every_module_writes_whole_files() -> None:
    found = []
    for package in ("rig", "daq", "analysis"):
        for path in sorted((ROOT / package).rglob("*.py")):
            place = path.relative_to(ROOT).as_posix()
            if place not in OWN:
                found += [
                    f"{place}:{one}" for one in direct_writes(path.read_text(encoding="utf-8"))
                ]
    assert found == []
