"""Names of what a run keeps."""

from __future__ import annotations

from pathlib import Path

import hydrosim as hs
from hydrosim.results.names import moving_names, state_names

CASE = Path(__file__).parents[2] / "cases" / "sphere" / "irregular.yaml"


def test_radiation_states_are_named_after_their_group_once() -> None:
    """Groups of two degrees of freedom and of one, which a model may fill up."""
    scene = hs.load_case(CASE).scene()
    model = hs.compile_scene(scene).model
    names = state_names(scene, model)
    assert len(names) == len(set(names)) == model.size
    first = [name for name in names if name.startswith("radiation 1 of")]
    groups = ("surge, pitch", "sway, roll", "heave")
    assert sorted(first) == sorted(f"radiation 1 of {group} of sphere" for group in groups)
    assert moving_names(scene, model)["radiation 1 of surge, pitch of sphere"] == [
        "surge of sphere",
        "pitch of sphere",
    ]
