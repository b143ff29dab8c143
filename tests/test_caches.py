"""What is computed twice is rather held by whom it belongs to: caches placed by hand are few.

One that stays pays for itself: what it keeps is dear to compute, and asked for again by design.
"""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import hydrosim

PACKAGE = Path(hydrosim.__file__).parent
MAKERS = {"lru_cache", "cache", "cached_property"}
MOST = 28


def caches(source: str) -> Iterator[str]:
    """The places in a source that make a cache: by a decorator, or by a call."""
    tree = ast.parse(source)
    known = dict(_makers(tree))
    for node in ast.walk(tree):
        if isinstance(node, ast.Name | ast.Attribute) and ast.unparse(node) in known:
            yield f"{known[ast.unparse(node)]} in line {node.lineno}"


def _makers(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """What makes caches, as it is called in a module, and its own name."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module == "functools":
            yield from ((a.asname or a.name, a.name) for a in node.names if a.name in MAKERS)
        elif isinstance(node, ast.Import):
            for module in (a.asname or a.name for a in node.names if a.name == "functools"):
                yield from ((f"{module}.{name}", name) for name in MAKERS)


def test_caches_are_few() -> None:
    found = [
        f"{path.relative_to(PACKAGE)}: {place}"
        for path in sorted(PACKAGE.rglob("*.py"))
        for place in caches(path.read_text())
    ]
    assert len(found) <= MOST, "\n".join(found)


@pytest.mark.parametrize(
    "form",
    [
        "from functools import lru_cache\n@lru_cache\ndef f(): ...",
        "from functools import lru_cache\n@lru_cache(maxsize=8)\ndef f(): ...",
        "from functools import cache\nf = cache(len)",
        "from functools import lru_cache\ndef f(g):\n    return lru_cache(maxsize=4)(g)",
        "from functools import cached_property\nclass A:\n    @cached_property\n    def a(b): 1",
        "from functools import cache as remembered\n@remembered\ndef f(): ...",
        "import functools\n@functools.cache\ndef f(): ...",
        "import functools as ft\nf = ft.lru_cache(maxsize=None)(len)",
    ],
)
def test_each_form_of_a_cache_counts(form: str) -> None:
    assert len(list(caches(form))) == 1


@pytest.mark.parametrize(
    "form",
    ["from hydrosim.files import cache\ncache.store('a', b'')", "cache = {}\ncache['a'] = 1"],
)
def test_what_is_no_cache_of_a_function_does_not_count(form: str) -> None:
    assert not list(caches(form))
