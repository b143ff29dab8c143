"""Every kind of force element, and every friction law, can be asked for in a case file, is compiled
and goes through the battery."""

from typing import Any

import numpy as np
import pytest
from examples import KINDS, LAWS, all_examples, built
from pydantic import TypeAdapter
from scenes import block, scene
from test_elements import ELEMENTS

from hydrosim.elements import ELEMENT_KINDS as KINDS_OF_UNITS
from hydrosim.elements import ForceElement, UserForce
from hydrosim.elements.contact import landing
from hydrosim.elements.contact.laws import LAWS as ALL_LAWS
from hydrosim.elements.kind import ElementKind, Layout, RollMode, UncoupledResonance
from hydrosim.report.evidence import features_of
from hydrosim.scene import Environment
from hydrosim.water.current import current_table
from hydrosim.water.wind import mean_wind

LAYOUT = Layout(
    body={"block": 0, "carrier": 1},
    row={"it": 4},
    current_profile=current_table(Environment()),
    wind=mean_wind(Environment()),
    resonance=lambda body, stiffness: UncoupledResonance(stiffness, stiffness),
    roll_mode=lambda body, stiffness: RollMode(1.0, 1.0, 0.0),
    heading=(0.0, 0.0),
    weight=(1.0, 1.0),
    origin=(np.zeros(3), np.ones(3)),
    active=np.arange(12),
)


def leaves(kind: type) -> list[type]:
    """The classes below ``kind`` that have none below themselves."""
    below = kind.__subclasses__()
    return [leaf for one in below for leaf in leaves(one)] if below else [kind]


OF_PYTHON = {UserForce}
"""Functions of the user: no case file holds one, and what they do is their own. Their tests are in
`tests/coupling`."""
OWN = [kind for kind in leaves(ForceElement) if kind.__module__.startswith("hydrosim.")]
OF_FILES = {"hydrosim.case.lines.element"}
"""Modules of elements that a file gives in another form than a scene has."""
SHIPPED = [kind for kind in OWN if kind not in OF_PYTHON and kind.__module__ not in OF_FILES]


def test_every_element_and_law_can_be_asked_for() -> None:
    assert {type(built(kind.example)) for kind in KINDS} == {*SHIPPED}
    assert {type(TypeAdapter(law).validate_python(law.example)) for law in LAWS} == {*ALL_LAWS}


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: str(kind.example["type"]))
def test_every_example_is_in_the_schema_and_compiled_by_one_kind(kind: Any) -> None:
    assert TypeAdapter(kind).json_schema()["examples"] == [kind.example]
    element = built(kind.example)
    kinds = [kind for kind in KINDS_OF_UNITS if isinstance(kind, ElementKind)]
    homes = [kind for kind in kinds if _count(kind, element) > _count(kind, None)]
    homes = [
        kind for kind in homes if kind.field != "link_table" or isinstance(element, kind.classes)
    ]
    walls = [landing.GUIDE_KIND] if getattr(element, "wall", None) else []  # a kind of their own
    assert homes[1:] == walls
    assert isinstance(element, homes[0].classes)


def _count(kind: ElementKind, element: ForceElement | None) -> int:
    """Number of the elements of a kind among one or none."""
    p = kind.compile({} if element is None else {"it": element}, LAYOUT)
    return len(p if not isinstance(p, tuple) else p[0])


def test_all_of_them_are_in_the_battery() -> None:
    inside = [*ELEMENTS.values()]
    assert {*SHIPPED} <= {type(element) for element in inside}
    laws = {type(element.friction) for element in inside if hasattr(element, "friction")}
    assert {*ALL_LAWS} <= laws


@pytest.mark.parametrize("element", all_examples().values(), ids=all_examples())
def test_every_element_and_law_is_a_feature_that_evidence_is_about(element: ForceElement) -> None:
    bare = features_of(scene(block(1e3), {}, 1.0, 0.1))
    assert features_of(scene(block(1e3), {"it": element}, 1.0, 0.1)) - bare
