"""Kinds answer for themselves: outside `hydrosim.elements` next to nobody names one."""

import ast
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain
from pathlib import Path

import numpy as np
import pytest
from scenes import Acting, JointFriction, block, in_contact, joint_of, on_floor, scene

import hydrosim
import hydrosim as hs
from hydrosim.elements import ELEMENT_KINDS, Elements, Frictionless, coupled_states, modes_of_kind
from hydrosim.elements.events import count_reaction_rows
from hydrosim.elements.kind import (
    ElementKind,
    HasImpulses,
    HasMirrorSymmetry,
    ResetsOnRestart,
    UnitKind,
)
from hydrosim.scene import Active, When

PACKAGE = Path(hydrosim.__file__).parent
NAMING = 8 + 2  # files outside `forces` that may name a kind; two are about constraints alone
MEMBERS = 12


def named(source: str) -> Iterator[str]:
    """The fields of `Elements` that a source names: of any object, as keywords or as strings."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Attribute):
            name = node.attr
        elif isinstance(node, ast.keyword):
            name = str(node.arg)
        elif isinstance(node, ast.Constant):
            name = str(node.value)
        else:
            continue
        if name in Elements._fields:
            yield name


def test_few_files_outside_elements_name_a_kind() -> None:
    outside = (path for path in PACKAGE.rglob("*.py") if PACKAGE / "elements" not in path.parents)
    naming = {
        path.relative_to(PACKAGE).as_posix() for path in outside if [*named(path.read_text())]
    }
    assert len(naming) <= NAMING, sorted(naming)


@pytest.mark.parametrize(
    "source",
    [
        "e = model.elements\nx = e.fenders",
        "f(link_table=x)",
        "getattr(e, 'guides')",
        "e['triggers']",
    ],
)
def test_a_kind_is_seen_under_any_name(source: str) -> None:
    assert len([*named(source)]) == 1


def test_a_kind_has_few_members() -> None:
    own = {*vars(ElementKind), *vars(UnitKind), *ElementKind.__annotations__}
    assert len([name for name in own if not name.startswith("_")]) <= MEMBERS


def test_states_and_modes_are_where_their_kinds_say() -> None:
    """Each kind has its own rows and states, one after another, and all of both."""
    compiled = hs.compile_scene(in_contact(20.0))
    model = compiled.model
    rows = np.arange(len(compiled.state.modes))
    constants = [(kind, kind.constants_in(model)) for kind in ELEMENT_KINDS]
    seen = [modes_of_kind(kind, p, rows[:, None])[:, 0] for kind, p in constants]
    assert np.concatenate(seen).tolist() == rows.tolist()
    names = []
    for kind in ELEMENT_KINDS:
        for states in kind.states(kind.constants_in(model), compiled.scene):
            owners = [f"{states.prefix}{owner}" for owner in states.owners]
            names += [f"{part} of {owner}" for owner in owners for part in states.components]
    assert len(names) == model.slow - model.own
    felt = coupled_states(model)
    assert np.all((felt >= model.own) & (felt < model.slow))


def test_reactions_are_of_one_unit_each() -> None:
    """Contact points, joints that are constraints, and dry friction in joints."""
    friction = Acting(friction=JointFriction(2.0, 1.0))
    joints = {
        "hinge": joint_of("hinge", "block", None, friction),
        "pin": hs.Fixed("block", active=Active(When(1.0))),
        "other pin": hs.Fixed("block", active=Active(When(2.0))),
    }
    feet = on_floor(1e6, Frictionless(), [(1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)])
    made = replace(scene(block(1e3), {"feet": feet}, 1.0, 0.1), joints=joints)
    elements = hs.compile_scene(made).model.elements
    locks, motions = elements.locks, elements.joint_motions
    held = (range(x.reaction, x.reaction + x.each.size) for x in (locks, motions))
    places = [*range(elements.fenders.points.size), *chain(*held)]
    assert places == [*range(count_reaction_rows(elements))]


def test_what_few_kinds_have_is_asked_by_protocols() -> None:
    """Each protocol has a kind that follows it and one that does not."""
    for protocol in (HasMirrorSymmetry, ResetsOnRestart, HasImpulses):
        assert {isinstance(kind, protocol) for kind in ELEMENT_KINDS} == {True, False}
