"""Imports go one way: from a room to those below it. ``ROOMS`` is the house, from the ground up.

Within a room, files and folders make no circle. No chain of imports is longer than ``LONGEST``.
"""

import ast
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import hydrosim

PACKAGE = Path(hydrosim.__file__).parent
ROOMS = """
errors dofs modes
files
scene
jit
multibody water
database tanks
elements
case integrate
linear results
compile statistics
analysis compare
run
simulation
coupling study
report
interface
cli
__main__ __init__
"""
FLOOR = {room: k for k, line in enumerate(ROOMS.strip().splitlines()) for room in line.split()}
LONGEST = 33
"""Files, from the first that imports to the last that is imported."""
MOST = 25
"""Files in a folder."""
OPEN = {"cli"}
"""Folders of as many files as there are things to do."""
OF_BENCHMARKS = {
    "test_checksums",
    "test_error_scenes",
    "test_figures_on_pages",
    "test_work_precision",
}
"""Tests of benchmarks themselves, which may import them."""
File = tuple[str, ...]
"""Folders and name of a file in the package."""


def files(package: Path) -> dict[File, Path]:
    """All files of the package."""
    found = sorted(package.rglob("*.py"))
    return {path.relative_to(package).with_suffix("").parts: path for path in found}


def imports(package: Path, types: bool = True) -> Iterator[tuple[File, File]]:
    """A file, and one that it takes something from, at its top or in a function; a type alone only
    if ``types`` count."""
    known = files(package)
    for here, path in known.items():
        for name in _names(ast.parse(path.read_text()), types):
            package_name, *rest = name.split(".")
            there = _file_of(tuple(rest), known)
            if package_name == package.name and rest and there != here:
                yield here, there


def _names(node: ast.AST, types: bool) -> Iterator[str]:
    """Dotted names of what is imported below a node of the syntax."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING" and not types:
            continue
        if isinstance(child, ast.ImportFrom) and not child.level:
            yield from (f"{child.module}.{alias.name}" for alias in child.names)
        elif isinstance(child, ast.Import):
            yield from (alias.name for alias in child.names)
        yield from _names(child, types)


def _file_of(name: File, known: dict[File, Path]) -> File:
    """The file of a module or a package, or of what one of them holds."""
    for file in (name, (*name, "__init__"), name[:-1], (*name[:-1], "__init__")):
        if file in known:
            return file
    return name


def wrong_ways(package: Path) -> list[str]:
    """Imports that do not go down."""
    return [
        f"{'/'.join(here)} imports {'/'.join(there)}"
        for here, there in imports(package)
        if here[0] != there[0] and FLOOR[there[0]] >= FLOOR[here[0]]
    ]


def circles(package: Path) -> list[str]:
    """Of each folder whose files and folders import each other in a circle: these."""
    inside: dict[File, dict[str, set[str]]] = {}
    for here, there in imports(package):
        depth = next(k for k, (a, b) in enumerate(zip(here, there, strict=False)) if a != b)
        inside.setdefault(here[:depth], {}).setdefault(here[depth], set()).add(there[depth])
    found = []
    for folder, taken in inside.items():
        try:
            TopologicalSorter(taken).prepare()
        except CycleError as error:
            found.append(f"{'/'.join(folder)}: {', '.join(error.args[1])}")
    return found


def longest_chain(package: Path) -> list[str]:
    """The files of the longest chain of imports."""
    taken: dict[File, set[File]] = {}
    for here, there in imports(package, types=False):
        taken.setdefault(here, set()).add(there)
    chains: dict[File, list[str]] = {}
    for file in TopologicalSorter(taken).static_order():
        below = max((chains[other] for other in taken.get(file, ())), key=len, default=[])
        chains[file] = ["/".join(file), *below]
    return max(chains.values(), key=len)


def test_imports_go_down() -> None:
    assert {here[0] for here, _ in imports(PACKAGE)} <= FLOOR.keys()
    assert wrong_ways(PACKAGE) == []


def test_folders_make_no_circle() -> None:
    assert circles(PACKAGE) == []


def test_no_chain_of_imports_is_long() -> None:
    assert len(chain := longest_chain(PACKAGE)) <= LONGEST, chain


def test_folders_hold_few_files() -> None:
    held = [file[:-1] for file in files(PACKAGE)]
    assert {folder for folder in held if held.count(folder) > MOST} <= {(one,) for one in OPEN}


def plant(package: Path, sources: dict[str, str]) -> Path:
    """A package of files with these sources."""
    for file, source in sources.items():
        (package / file).parent.mkdir(parents=True, exist_ok=True)
        (package / file).write_text(source + "\n")
    return package


@pytest.mark.parametrize(
    ("room", "planted"),
    [
        ("scene/scene.py", "from hydrosim.database import HydroDatabase"),
        ("multibody/joints.py", "from hydrosim.elements import spring"),
        ("elements/tug.py", "def f():\n    import hydrosim.integrate.loop"),
        ("linear/modes.py", "from hydrosim import compile"),
    ],
)
def test_an_import_that_is_planted_the_wrong_way_is_found(
    tmp_path: Path, room: str, planted: str
) -> None:
    package = plant(tmp_path / "hydrosim", {room: "from hydrosim.errors import InputError"})
    assert wrong_ways(package) == []
    assert len(wrong_ways(plant(package, {room: planted}))) == 1


@pytest.mark.parametrize(
    "planted",
    [
        "from hydrosim.elements import channels",
        "from hydrosim.elements.channels import Channel",
        "def f():\n    import hydrosim.elements.channels",
        "if TYPE_CHECKING:\n    from hydrosim.elements.channels import Channel",
        "from hydrosim import elements",
    ],
)
def test_a_circle_that_is_planted_is_found(tmp_path: Path, planted: str) -> None:
    sources = {
        "elements/__init__.py": "from hydrosim.elements import channels, spring",
        "elements/channels.py": "from hydrosim.elements.contact.fender import Contact",
        "elements/contact/fender.py": "from hydrosim.elements.contact.plane import Plane",
        "elements/contact/plane.py": "from hydrosim.errors import InputError",
        "elements/spring.py": "from hydrosim.elements.contact.plane import Plane",
    }
    package = plant(tmp_path / "hydrosim", sources)
    assert circles(package) == []
    (circle,) = circles(plant(package, {"elements/contact/plane.py": planted}))
    assert circle.startswith("elements: ")


def test_a_circle_of_deep_folders_is_found(tmp_path: Path) -> None:
    sources = {
        "report/charts/studies.py": "from hydrosim.report.sentences.run import title",
        "report/sentences/run.py": "from hydrosim.report.charts.panels import Panel",
    }
    (circle,) = circles(plant(tmp_path / "hydrosim", sources))
    assert circle.startswith("report: ")


@pytest.mark.parametrize(
    "form", ["from hydrosim.a import f{}", "def f():\n    import hydrosim.a.f{}"]
)
def test_a_long_chain_that_is_planted_is_found(tmp_path: Path, form: str) -> None:
    sources = {f"a/f{k}.py": form.format(k + 1) for k in range(LONGEST - 1)}
    package = plant(tmp_path / "hydrosim", {**sources, f"a/f{LONGEST - 1}.py": ""})
    assert len(longest_chain(package)) == LONGEST
    plant(package, {"b/more.py": "from hydrosim.a.f0 import something"})
    assert len(longest_chain(package)) == LONGEST + 1
    plant(package, {"b/more.py": "if TYPE_CHECKING:\n    from hydrosim.a.f0 import something"})
    assert len(longest_chain(package)) == LONGEST


def test_tests_need_no_benchmarks() -> None:
    """What both need is below tests/: generators of scenes and mutants, and their judges."""
    tests = [path for path in Path(__file__).parent.rglob("*.py") if path.stem not in OF_BENCHMARKS]
    asking = {
        path.name
        for path in tests
        for name in _names(ast.parse(path.read_text()), True)
        if name.split(".")[0] == "benchmarks"
    }
    assert asking == set()
