"""Sentences of more words than people read at once, in docstrings, messages and documentation."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
MOST = 40
"""Words of a sentence."""
FENCE = re.compile(r"^```.*?^```", re.S | re.M)
END = re.compile(r"[.!?:;](?:[\"')\]]*)\s+(?=[A-Z`\"'(*\d{])|\n\s*\n|\n\s*[*#|>-]|\n    ")
"""What ends a sentence: a stop or a semicolon before a new one, an empty line, an item of a list, a
formula."""
WORD = re.compile(r"[A-Za-z][A-Za-z'’-]*")


class Long(NamedTuple):
    """A sentence of too many words, and the file and line in which its text begins."""

    place: str
    words: int
    text: str


def long_sentences(root: Path = ROOT) -> list[Long]:
    """All sentences of more than `MOST` words in the package's docstrings and texts, and in the
    documentation."""
    found: list[Long] = []
    for path in sorted((root / "hydrosim").rglob("*.py")):
        for line, text in _texts(path):
            found += _long(f"{path.relative_to(root)}:{line}", text)
    pages = [root / "README.md", *sorted((root / "docs").glob("*.md"))]
    pages += sorted((root / "cases").rglob("*.md"))
    for path in pages:
        found += _long(str(path.relative_to(root)), FENCE.sub("\n\n", path.read_text()))
    return found


def _texts(path: Path) -> Iterator[tuple[int, str]]:
    """Docstrings, and texts with a blank: what people read; fields of f-strings count as a word."""
    tree = ast.parse(path.read_text())
    inside = {
        id(part)
        for node in ast.walk(tree)
        if isinstance(node, ast.JoinedStr)
        for part in node.values
    }
    for node in ast.walk(tree):
        if (
            isinstance(node, ast.Constant)
            and isinstance(node.value, str)
            and id(node) not in inside
        ):
            yield node.lineno, node.value
        elif isinstance(node, ast.JoinedStr):
            parts = (
                str(p.value) if isinstance(p, ast.Constant) else " value " for p in node.values
            )
            yield node.lineno, "".join(parts)


def _long(place: str, text: str) -> Iterator[Long]:
    for sentence in END.split(text):
        words = len(WORD.findall(sentence))
        if words > MOST:
            yield Long(place, words, " ".join(sentence.split()))


if __name__ == "__main__":
    sentences = long_sentences()
    for each in sorted(sentences, key=lambda each: -each.words):
        print(f"{each.place} {each.words}: {each.text}")
    print(len(sentences), "sentences of more than", MOST, "words")
