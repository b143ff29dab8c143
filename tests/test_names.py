"""Names say what they name: functions are verbs with an object or nouns, classes are unique, and a
constant of one name is one constant."""

import ast
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "hydrosim"
VAGUE_WORDS = """
at of on in by to from with without above below behind before after beside between
within under over across along around near off out up down away apart together alone
alike same other others own each every all any some most least few fewest many more less
one two both either neither none nothing anything everything such this that these those
what which who whose where when why how here there now then again always still already
only also too so thus else otherwise anew first last next late early it its they them he
we you is are was were be been has have had does did may might can could must shall
should will would lost found said told kept held met lent meant given taken made done
gone come seen left sent let got hit begun known shown drawn built spent dealt led
spread due free calm wet whole half empty
"""
"""Participles, prepositions, pronouns and adverbs of one word."""
NOUNS_AND_VERBS = {"speed", "seed", "need", "feed", "embed"}
"""Words that end as participles do."""
STORED = "its sources are part of the names of stored results: a rename makes all of them anew"
VAGUE_FUNCTIONS = {
    "database/build": STORED,
    "water/radiation": STORED,
    "files/cache.py stored": "called there",
    "elements/external.py delayed": "public",
    "coupling/simulation.py ended": "public",
}
"""Files or functions that the rule leaves out, and why."""
CLASSES_OF_ONE_NAME = {"Floating", "Hull", "Table", "Weight"}
"""Of unlike things; three of them are in sources whose results are stored."""
MAX_MODULES_OF_A_CONSTANT = 2
CONSTANTS_OF_READERS = {"NAME"}
"""What every reader of a format has to define."""


def is_vague(name: str) -> bool:
    """Whether a name is a participle, a preposition, a pronoun or an adverb alone."""
    word = name.strip("_")
    if not word or "_" in word or not word.islower():
        return False
    is_participle = len(word) > 4 and word.endswith("ed") and word not in NOUNS_AND_VERBS
    return word in VAGUE_WORDS.split() or is_participle


@cache
def syntax_trees() -> dict[str, ast.Module]:
    """Syntax tree of each module by its path in the package."""
    return {
        path.relative_to(PACKAGE).as_posix(): ast.parse(path.read_text("utf-8"))
        for path in sorted(PACKAGE.rglob("*.py"))
    }


def functions() -> Iterator[tuple[str, str]]:
    for file, tree in syntax_trees().items():
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                yield file, node.name


def classes() -> dict[str, list[str]]:
    """Files of each class by its name."""
    files = defaultdict(list)
    for file, tree in syntax_trees().items():
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef):
                files[node.name].append(file)
    return files


@pytest.mark.parametrize(
    ("name", "vague"),
    [
        ("pressed", True),
        ("_of", True),
        ("held", True),
        ("speed", False),
        ("merge_layouts", False),
        ("wavenumber", False),
        ("read", False),
        ("__init__", False),
    ],
)
def test_what_is_vague(name: str, vague: bool) -> None:
    assert is_vague(name) == vague


def test_functions_are_named_by_what_they_do_or_return() -> None:
    vague = [f"{file} {name}" for file, name in functions() if is_vague(name)]
    left = [text for text in vague if not text.startswith(tuple(VAGUE_FUNCTIONS))]
    assert left == []
    assert all(any(text.startswith(one) for text in vague) for one in VAGUE_FUNCTIONS)


def test_classes_of_unlike_things_have_unlike_names() -> None:
    several = {name: files for name, files in classes().items() if len(files) > 1}
    assert {*several} == CLASSES_OF_ONE_NAME, several


def test_a_constant_of_one_name_is_one_constant() -> None:
    modules = defaultdict(set)
    for file, tree in syntax_trees().items():
        for node in tree.body:
            targets = node.targets if isinstance(node, ast.Assign) else []
            for target in targets:
                if isinstance(target, ast.Name) and target.id.isupper():
                    modules[target.id].add(file)
    most = MAX_MODULES_OF_A_CONSTANT
    several = {name: files for name, files in modules.items() if len(files) > most}
    assert {*several} == CONSTANTS_OF_READERS, several
