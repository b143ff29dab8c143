"""Pages of keys say of each key its meaning, unit, default and example, in the words of files."""

import json
import re
import sys
from pathlib import Path
from typing import Any

import pytest

from hydrosim.interface.new import FileKind, schema_of

sys.path.insert(0, str(Path(__file__).parents[2] / "docs"))

from key_pages import FOLDER, pages_of, reference_pages

BARE = {"mass_matrix"}  # keys whose example would fill a page
MASS = {"description": "Mass.", "quantity": "mass", "unit": "kg", "examples": ["5 tonne"]}
SMALL: dict[str, Any] = {
    "if": {"required": ["extends"]},
    "else": {"$ref": "#/$defs/Whole"},
    "$defs": {
        "Whole": {
            "description": "A file.",
            "properties": {
                "extends": False,
                "mass": {"$ref": "#/$defs/mass", "description": "How heavy it is. Unit: kg."},
                "law": {"enum": ["hard", "soft"], "description": "A word.", "default": "hard"},
                "depth": {"type": "number", "description": "Down.", "default": float("inf")},
                "parts": {
                    "description": "What it is made of.",
                    "additionalProperties": {"$ref": "#/$defs/by_type"},
                },
                "push": {"description": "By direction.", "anyOf": [{"$ref": "#/$defs/PerDof"}]},
            },
            "required": ["mass"],
            "title": "WholeFile",
        },
        "by_type": {
            "properties": {"type": {"enum": ["cube", "ball"]}},
            "allOf": [
                {
                    "if": {"properties": {"type": {"const": name}}},
                    "then": {"$ref": f"#/$defs/{name.title()}"},
                }
                for name in ("cube", "ball")
            ],
        },
        "Cube": {"properties": {"type": {"const": "cube"}, "side": {"description": "Side."}}},
        "Ball": {"properties": {"type": {"const": "ball"}, "radius": {"description": "Size."}}},
        "PerDof": {"properties": {"surge": {"$ref": "#/$defs/mass"}, "yaw": {"type": "number"}}},
        "mass": MASS,
    },
}


def slugify(title: str) -> str:
    """Anchor of a heading, as GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")


def row(text: str, key: str) -> list[str]:
    """The cells of a key's row: meaning, unit, default, example."""
    (found,) = re.findall(rf"^\| `{key}` \| (.*) \|$", text, re.M)
    return [cell.strip() for cell in found.split(" | ")]


def test_a_key_has_meaning_unit_default_and_example() -> None:
    text = pages_of(SMALL)
    assert row(text, "mass") == ["How heavy it is.", "kg", "needed", "`mass: 5 tonne`"]
    assert row(text, "law") == ["A word. One of `hard`, `soft`.", "", "`hard`", "`law: soft`"]
    assert row(text, "depth")[2] == "`infinite`"
    assert row(text, "push")[0] == "By direction. By name: `surge`, `yaw`."
    assert "extends" not in text


def test_sections_are_named_by_places() -> None:
    text = pages_of(SMALL)
    titles = re.findall(r"^#+ (.*)$", text, re.M)
    assert titles == ["The file", "parts.NAME, type: cube", "parts.NAME, type: ball"]


@pytest.mark.parametrize("kind", list(FileKind))
def test_pages_of_the_program(kind: FileKind) -> None:
    """Every key has a meaning and an example; links hold; nothing is named as in Python."""
    schema = schema_of(kind)
    text = pages_of(schema)
    titles = re.findall(r"^#+ (.*)$", text, re.M)
    anchors = [slugify(title) for title in titles]
    assert len(set(anchors)) == len(anchors)
    assert set(re.findall(r"\]\(#([^)]*)\)", text)) <= set(anchors)
    names = {each.get("title", "") for each in schema["$defs"].values()} - {""}
    assert not {title for title in titles if title in names}
    assert not re.search(r"see `|hydrosim\.", text)
    rows = re.findall(r"^\| `(\w+)` \| (.*) \|$", text, re.M)
    for key, cells in rows:
        meaning, *_, example = cells.split(" | ")
        assert meaning.strip(), key
        assert example.strip() or "Keys: " in meaning or "By name: " in meaning or key in BARE, key
    keys = set(re.findall(r"^\| `(\w+)` \|", text, re.M))
    known = json.dumps(schema)
    assert keys
    assert all(f'"{key}"' in known for key in keys)


def test_kept_pages_are_fresh() -> None:
    """After a change of keys or commands: ``python docs/key_pages.py``."""
    pages = reference_pages()
    assert set(pages) <= set(FOLDER.iterdir())
    assert [path.name for path, text in pages.items() if path.read_text("utf-8") != text] == []
    assert sum(len(text.encode()) for text in pages.values()) < 400_000
