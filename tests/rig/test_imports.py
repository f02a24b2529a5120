"""Who may import whom, read from the source: the packages stay apart, and each library has one
home.
"""

import ast
import importlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

ALLOWED = {
    "daq": ("daq", "numpy", "scipy", "h5py", "numba", "nptdms"),
    "analysis": (
        "analysis",
        "daq.caches",
        "daq.chain.block",
        "daq.chain.channel",
        "daq.child_processes",
        "daq.compiled",
        "daq.documents",
        "daq.json_text",
        "daq.session",
        "daq.strange_text",
        "daq.whole_files",
        "numpy",
        "numba",
        "scipy",
        "matplotlib",
    ),
    "rig.documents": ("rig.documents", "rig.errors", "daq.documents", "daq.regular_files", "yaml"),
    "rig.kernels": ("rig.kernels", "daq.compiled", "numpy", "numba", "llvmlite"),
    "rig.theory": ("rig.theory", "rig.kernels", "numpy"),
    "rig.lammps_engine": (
        "rig.lammps_engine",
        "rig.kernels.grains",
        "rig.theory.contact",
        "rig.errors",
        "numpy",
        "scipy",
        "lammps",
    ),
    "rig.beds": (
        "rig.beds",
        "rig.theory",
        "rig.kernels",
        "rig.protocol.spec",
        "rig.catalog.contact_materials",
        "rig.catalog.entries",
        "rig.drive",
        "rig.errors",
        "numpy",
    ),
}
"""All that a package imports beside the standard library."""

HOMES = {
    "analysis": ("analysis", "rig.campaign", "rig.importing", "rig.cli", "rig.benchmarks"),
    "rig.benchmarks": ("rig.benchmarks", "rig.cli"),
    "daq.session": (
        "daq",
        "analysis",
        "rig.campaign",
        "rig.importing",
        "rig.cli",
        "rig.benchmarks",
    ),
    "daq.formats": ("daq.formats", "rig.importing", "rig.cli"),
    "daq.chain.frontend": ("daq", "rig.campaign", "rig.benchmarks"),
    "daq.chain.acquisition": ("daq", "rig.campaign", "rig.benchmarks"),
    "daq.chain.transducer": ("daq", "rig.campaign"),
    "rig.campaign": ("rig.campaign", "rig.importing", "rig.cli", "rig", "rig.benchmarks"),
    "rig.cli": ("rig.cli",),
    "yaml": ("rig.documents",),
    "typer": ("rig.cli",),
    "rich": ("rig.cli",),
    "h5py": (
        "daq.session",
        "daq.formats",
        "rig.benchmarks.problems.records",
        "rig.benchmarks.problems.recording",
    ),
    "nptdms": ("daq.formats",),
    "lammps": ("rig.lammps_engine.child",),
    "matplotlib": ("analysis.report.figures", "rig.benchmarks"),
    "numba": ("daq", "rig.kernels", "analysis.signals.compiled_loops", "rig.benchmarks"),
}
"""All who import a module. `rig` itself is a home of `rig.campaign` by its lazy names
(`rig/__init__.py`).
"""

HEAVY = {"numpy", "numba", "h5py", "matplotlib", "scipy", "rich", "yaml"}


def within(name: str, places: tuple[str, ...]) -> bool:
    """Is a module one of the places, or inside one?"""
    return any(name == place or name.startswith(f"{place}.") for place in places)


def modules() -> dict[str, ast.Module]:
    found = {}
    for package in ("rig", "daq", "analysis"):
        for path in sorted((ROOT / package).rglob("*.py")):
            parts = path.relative_to(ROOT).with_suffix("").parts
            name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
            found[name] = ast.parse(path.read_text(encoding="utf-8"))
    return found


MODULES = modules()


def imported(name: str) -> Iterator[str]:
    """What a module imports, anywhere in its text, without the standard library; of a package's
    names, the modules.
    """
    for node in ast.walk(MODULES[name]):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{name}: a relative import"
            package = str(node.module)
            names = [
                f"{package}.{alias.name}" if f"{package}.{alias.name}" in MODULES else package
                for alias in node.names
            ]
        else:
            continue
        yield from (
            other for other in names if other.partition(".")[0] not in sys.stdlib_module_names
        )


def test_the_walk_finds_imports() -> None:
    """The rules below hold for nothing at all as well."""
    assert {"h5py", "numpy"} <= set(imported("daq.session.hdf5"))
    assert "rig.protocol.grid" in set(imported("rig.campaign.resolve"))  # from rig import grid
    assert "analysis.pipeline" in set(imported("rig.cli.commands.sessions"))  # inside a function


@pytest.mark.parametrize("package", ALLOWED)
def test_a_package_imports_what_it_may_and_no_more(package: str) -> None:
    inside = [name for name in MODULES if within(name, (package,))]
    assert inside
    assert [
        (name, other)
        for name in inside
        for other in imported(name)
        if not within(other, ALLOWED[package])
    ] == []


@pytest.mark.parametrize("module", HOMES)
def test_a_module_is_imported_where_it_belongs_and_nowhere_else(module: str) -> None:
    users = [
        (name, other) for name in MODULES for other in imported(name) if within(other, (module,))
    ]
    assert users
    packages = tuple(home for home in HOMES[module] if home != "rig")
    assert [
        use for use in users if not within(use[0], packages) and use[0] not in HOMES[module]
    ] == []


MOST_MODULES = 14
"""Files in a folder, its `__init__` among them."""


def test_a_folder_holds_few_modules_and_says_what_it_holds() -> None:
    for package in ("rig", "daq", "analysis"):
        for folder in [path.parent for path in (ROOT / package).rglob("__init__.py")]:
            assert len(list(folder.glob("*.py"))) <= MOST_MODULES, folder
            name = ".".join(folder.relative_to(ROOT).parts)
            assert ast.get_docstring(MODULES[name]), folder


DEEPEST = 17
"""Modules in the longest chain of imports."""


def inside() -> dict[str, set[str]]:
    """The modules of the three packages that each of them imports."""
    return {
        name: {other for other in imported(name) if other in MODULES and other != name}
        for name in MODULES
    }


def test_no_chain_of_imports_is_longer_than_it_has_to_be() -> None:
    imports = inside()
    depth: dict[str, int] = {}
    while waiting := [name for name in imports if name not in depth]:
        for name in waiting:
            if imports[name] <= depth.keys():
                depth[name] = 1 + max((depth[other] for other in imports[name]), default=0)
    assert max(depth.values()) <= DEEPEST


def test_no_circle_of_modules() -> None:
    """Imports inside functions and for the type checker count. What is left after all that imports
    nothing left has been taken away, again and again, is in a circle or imports from one."""
    left = inside()
    while free := [name for name, others in left.items() if not others & left.keys()]:
        for name in free:
            del left[name]
    assert sorted(left) == []


def test_no_class_name_stands_twice() -> None:
    places: dict[str, list[str]] = {}
    for name, module in MODULES.items():
        for node in ast.walk(module):
            if isinstance(node, ast.ClassDef):
                places.setdefault(node.name, []).append(name)
    assert {name: found for name, found in places.items() if len(found) > 1} == {}


@pytest.mark.parametrize("package", ["rig", "daq", "analysis"])
def test_public_names_are_there_and_hide_no_module(package: str) -> None:
    """A module of a public name would take its place as soon as it is imported."""
    public = importlib.import_module(package)
    for name in public.__all__:
        assert getattr(public, name) is not None
        assert f"{package}.{name}" not in MODULES


def in_a_fresh_process(program: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_help_needs_no_heavy_library() -> None:
    assert (
        in_a_fresh_process(f"import sys, rig.cli; print(sorted({HEAVY!r} & set(sys.modules)))")
        == "[]"
    )


def test_the_model_needs_no_records_and_no_analysis() -> None:
    program = "import sys, rig.cli.commands.model; print(sorted({'analysis', 'h5py', 'matplotlib'} & set(sys.modules)))"
    assert in_a_fresh_process(program) == "[]"


def test_what_computes_runs_needs_no_file_no_analysis_and_no_exciter() -> None:
    """A campaign starts its workers before it loads what only the writer needs: they begin half a
    second earlier.
    """
    unwanted = {
        "h5py",
        "rich",
        "matplotlib",
        "scipy.special",
        "analysis.results.run",
        "analysis.session.record",
        "rig.stand.shaker",
        "rig.fidelity.choose",
    }
    program = f"import sys, rig.campaign.workers; print(sorted({unwanted!r} & set(sys.modules)))"
    assert in_a_fresh_process(program) == "[]"


def test_acquisition_and_analysis_live_without_the_stand() -> None:
    program = """
import importlib, pkgutil, sys
sys.modules["rig"] = None
for package in ("daq", "analysis"):
    for module in pkgutil.walk_packages(importlib.import_module(package).__path__, package + "."):
        importlib.import_module(module.name)
print("done")
"""
    assert in_a_fresh_process(program) == "done"
