"""Imports go one way: from a room to those below it. ``ROOMS`` is the house, from the ground up."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import hydrosim

PACKAGE = Path(hydrosim.__file__).parent
ROOMS = """
errors cache dofs interrupts
locks
outputs
leftovers
jit documents scene
rigid integrate waves radiation recordings
database forces
case stepping
linear results
statistics
compiling compare
studies
plot report
accessor
commands
cli
__main__ __init__
"""
FLOOR = {room: k for k, line in enumerate(ROOMS.strip().splitlines()) for room in line.split()}


def imports(package: Path) -> Iterator[tuple[str, str, Path]]:
    """A room, one that it takes something from, be it a type alone, and the file."""
    for path in sorted(package.rglob("*.py")):
        here = path.relative_to(package).with_suffix("").parts[0]
        for node in ast.walk(ast.parse(path.read_text())):
            names = []
            if isinstance(node, ast.ImportFrom) and not node.level:
                names = [f"{node.module}.{alias.name}" for alias in node.names]
            elif isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            for name in names:
                package_name, *rest = name.split(".")
                if package_name == package.name and rest and rest[0] != here:
                    yield here, rest[0], path


def wrong_ways(package: Path) -> list[str]:
    """Imports that do not go down."""
    return [
        f"{path.relative_to(package)}: {here} imports {there}"
        for here, there, path in imports(package)
        if FLOOR[there] >= FLOOR[here]
    ]


def test_imports_go_down() -> None:
    assert {here for here, _, _ in imports(PACKAGE)} <= FLOOR.keys()
    assert wrong_ways(PACKAGE) == []


@pytest.mark.parametrize(
    ("room", "planted"),
    [
        ("scene/scene.py", "from hydrosim.database import HydroDatabase"),
        ("rigid/joints.py", "from hydrosim.forces import spring"),
        ("forces/tug.py", "def f():\n    import hydrosim.stepping.run"),
        ("linear/modes.py", "from hydrosim import compiling"),
    ],
)
def test_an_import_that_is_planted_the_wrong_way_is_found(
    tmp_path: Path, room: str, planted: str
) -> None:
    path = tmp_path / "hydrosim" / room
    path.parent.mkdir(parents=True)
    path.write_text("from hydrosim.errors import InputError\n")
    assert wrong_ways(tmp_path / "hydrosim") == []
    path.write_text(planted + "\n")
    assert len(wrong_ways(tmp_path / "hydrosim")) == 1
