"""The examples that stand in the schema of case files, as elements of scenes."""

import json
from pathlib import Path
from typing import Any, get_args

from pydantic import TypeAdapter

from hydrosim.case.lines.element import Lines
from hydrosim.case.schema import AnyElement
from hydrosim.scene import ForceElement
from hydrosim.scene.contacts import Fender, Friction
from hydrosim.scene.force import BuildContext

KINDS = [kind for kind in get_args(get_args(AnyElement)[0]) if kind is not Lines]
"""Those that are one element of the scene; a file with lines is several."""
LAWS = get_args(get_args(Friction)[0])
ELEMENT = TypeAdapter(AnyElement)
NAMES = {"barge": "block", "topside": "carrier"}


def built(example: dict[str, Any]) -> ForceElement:
    """The element of an example, on the bodies that tests have."""
    text = json.dumps(example)
    for name, ours in NAMES.items():
        text = text.replace(f'"{name}"', f'"{ours}"')
    context = BuildContext("forces.it", Path("case.yaml"))
    return ELEMENT.validate_python(json.loads(text)).build_active(context)


def all_examples() -> dict[str, ForceElement]:
    """By what is said of them; of fenders one with each friction law."""
    found = {f"example: {kind.example['type']}": built(kind.example) for kind in KINDS}
    for law in LAWS:
        fender = {**Fender.example, "friction": law.example}
        found[f"fender, example: {law.example['law']}"] = built(fender)
    return found
