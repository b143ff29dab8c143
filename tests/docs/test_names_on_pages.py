"""Names of files, functions, classes and fields on pages are those of the code."""

import ast
import re
from functools import cache
from itertools import pairwise
from pathlib import Path

import pytest
from test_imports import FLOOR

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "hydrosim"
PAGE = ROOT / "docs" / "how_it_works.md"
PAGES = [ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
IN_FILE = re.compile(r"`(?:hydrosim/)?([\w/]+\.py)(?::([\w.]+))?`")
"""A file, and a name in it."""
IN_CLASS = re.compile(r"`([A-Z][a-z]\w*)\.(\w+)`")
"""A class of the package, and a field or method of it."""
FILES = {"cal", "dat", "md"}
"""Endings of files of other programs, whose names look like classes."""
ROOM = re.compile(r"`(\w+)(?:/|\.py)`")


def definitions(node: ast.AST) -> dict[str, ast.AST]:
    """What the body of a module or a class defines, by name."""
    names: dict[str, ast.AST] = {}
    for statement in getattr(node, "body", []):
        if isinstance(statement, ast.FunctionDef | ast.ClassDef):
            names[statement.name] = statement
        elif isinstance(statement, ast.Assign | ast.AnnAssign):
            targets = getattr(statement, "targets", None) or [statement.target]
            stored = (name for target in targets for name in ast.walk(target))
            names |= {name.id: statement for name in stored if isinstance(name, ast.Name)}
    return names


def has_name(node: ast.AST | None, name: str) -> bool:
    """Whether a dotted ``name`` is defined in a module or a class."""
    for part in name.split("."):
        node = definitions(node).get(part) if node is not None else None
    return node is not None


def lost_names(text: str) -> list[str]:
    """Names in the ``text`` of a page that the code does not have."""
    lost = []
    for file, name in IN_FILE.findall(text):
        if "NAME" in file or (not name and "/" not in file):
            continue
        path = next((path for path in (PACKAGE / file, ROOT / file) if path.is_file()), None)
        if path is None or (name and not has_name(parse(path), name)):
            lost.append(f"{file}:{name}")
    for name, field in IN_CLASS.findall(text):
        if field not in FILES and not any(has_name(node, field) for node in classes(name)):
            lost.append(f"{name}.{field}")
    return lost


@cache
def parse(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


def classes(name: str) -> list[ast.AST]:
    """The classes of the package with this name."""
    modules = (definitions(parse(path)) for path in PACKAGE.rglob("*.py"))
    return [names[name] for names in modules if name in names]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_the_code_has_the_names_on_the_page(page: Path) -> None:
    assert lost_names(page.read_text()) == []


@pytest.mark.parametrize(
    ("text", "lost"),
    [
        ("`integrate/loop.py:advance_until`", []),
        ("`hydrosim/run/course.py:RunInProgress.chunks`", []),
        ("`Model.added_mass`", []),
        ("`integrate/loop.py:hasten`", ["integrate/loop.py:hasten"]),
        ("`integrate/hoop.py`", ["integrate/hoop.py:"]),
        ("`Model.added_moss`", ["Model.added_moss"]),
    ],
)
def test_a_name_that_is_not_there_is_found(text: str, lost: list[str]) -> None:
    assert lost_names(text) == lost


def test_the_house_stands_in_the_direction_of_imports() -> None:
    rows = PAGE.read_text().split("## The house")[1].split("## ")[0].splitlines()
    rooms = [ROOM.findall(row.split("|")[1]) for row in rows if row.startswith("| `")]
    floors = [{FLOOR[room] for room in row} for row in rooms]
    assert all(min(above) > max(below) for above, below in pairwise(floors))
    assert {room for row in rooms for room in row} == FLOOR.keys() - {"__main__", "__init__"}


@pytest.mark.parametrize("page", [PAGE, PAGE.with_name("glossary.md")], ids=lambda page: page.name)
def test_a_glossary_has_each_word_once_and_in_order(page: Path) -> None:
    rows = page.read_text().split("# Glossary")[1].splitlines()
    words = [row.split("|")[1].strip(" *") for row in rows if row.startswith("| ")][2:]
    assert len(words) > 5
    assert words == sorted(set(words))
