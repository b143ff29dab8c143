"""The layout of y: blocks lie where the model has them, and names are not taken apart."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import hydrosim as hs
from hydrosim.integrate.names import StateKind, state_layout

CASES = Path(__file__).parents[2] / "cases"
IRREGULAR = CASES / "sphere" / "irregular.yaml"


def test_radiation_states_are_named_after_their_group_once() -> None:
    """Groups of two degrees of freedom and of one, which a model may fill up."""
    scene = hs.load_case(IRREGULAR).scene()
    compiled = hs.compile_scene(scene)
    model = compiled.model
    layout = state_layout(scene, model, compiled.derived.met)
    names = layout.names()
    assert len(names) == len(set(names)) == model.size
    entries = layout.entries_of(StateKind.RADIATION)
    first = [entry for entry in entries if entry.component == "radiation 1"]
    groups = ("surge, pitch", "sway, roll", "heave")
    assert sorted(entry.owner for entry in first) == sorted(f"{g} of sphere" for g in groups)
    (pair,) = (entry for entry in first if entry.owner == "surge, pitch of sphere")
    assert [q.name for q in pair.coordinates] == ["surge of sphere", "pitch of sphere"]


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("sphere/irregular", {}),
        ("reverse_float_over/base", {"output.impulses": True}),
        ("reverse_float_over/tanks", {}),
        ("topside_removal/tanks", {}),
        ("mating/mating", {}),
    ],
)
def test_blocks_lie_where_the_model_has_them(name: str, changes: dict[str, object]) -> None:
    compiled = hs.compile_scene(hs.load_case(CASES / f"{name}.yaml", changes).scene())
    scene, model = compiled.scene, compiled.model
    layout = state_layout(scene, model, compiled.derived.met)
    at = {block.kind: block.offset for block in layout.blocks}
    p = model.elements
    assert at[StateKind.RATE] == model.bodies.active.size
    assert at[StateKind.RADIATION] == model.radiation
    assert at["contact node"] == model.own == p.fenders.state
    assert at["tank"] == model.tanks.state
    assert at["trigger"] == p.triggers.state
    assert at[StateKind.SLOW_PLACE] == model.slow
    assert at[StateKind.SLOW_DRAUGHT] == model.draught
    assert at[StateKind.ENERGY] == model.energy
    assert at.get(StateKind.IMPULSE, model.size) == model.impulse
    assert len(layout.names()) == model.size
    for index in (0, model.size - 1, model.energy):
        kind, entry = layout.entry_at(index)
        assert (str(kind), entry.name) == (layout.kinds()[index], layout.names()[index])


def renamed(scene: hs.Scene, name: str) -> hs.Scene:
    """The scene with another name of its only body."""
    (body,) = scene.bodies
    forces = {key: replace(force, body=name) for key, force in scene.forces.items()}  # type: ignore[type-var]
    return replace(scene, bodies=(replace(body, name=name),), forces=forces)


@pytest.mark.parametrize(
    "name", ["leg of jacket", "a and b", "heave, roll of one and surge of two"]
)
def test_a_restart_knows_bodies_whatever_their_name_is(name: str) -> None:
    changes = {"duration": 20.0, "solver.linear": "step", "output.states": True}
    scene = renamed(hs.load_case(IRREGULAR, changes).scene(), name)
    run = hs.simulate(scene)
    again = hs.simulate(replace(scene, initial=hs.Start(run, 10.0), duration=10.0))
    assert np.array_equal(again.position.values[-1], run.position.values[-1])
