"""Wet scenes with joints, turned about the vertical together with their waves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from turning import turned

import hydrosim as hs
from hydrosim.scene import Scene, Symmetry

CASES = Path(__file__).parents[3] / "cases"
BY = np.radians(40.0)
SCENES = ["hinged_barges/irregular", "flap/irregular", "point_absorber/irregular"]


def scene_of(case: str) -> Scene:
    """The first 40 s of a case in its sea, without a ramp, in all degrees of freedom."""
    settings = {
        "duration": 40.0,
        "output.step": 0.5,
        "environment.waves.ramp": 0.0,
        "environment.waves.heading": np.radians(30.0),
    }
    if case.startswith("point_absorber"):  # the search for a fit of these two takes minutes
        convolution = {"model": "convolution"}
        settings |= {f"bodies.{name}.radiation": convolution for name in ("spar", "float")}
    scene = hs.load_case(CASES / f"{case}.yaml", settings).scene()
    return replace(scene, solver=replace(scene.solver, symmetry=Symmetry.IGNORE))


def with_waves_turned(scene: Scene) -> Scene:
    """The whole scene turned, the headings of its waves too."""
    found = turned(scene, BY)
    waves = tuple(replace(w, heading=w.heading + BY) for w in scene.environment.waves)
    return replace(found, environment=replace(found.environment, waves=waves))


@pytest.mark.parametrize("case", SCENES)
def test_joints_do_not_know_where_north_is(case: str, figure: Callable[[str, float], None]) -> None:
    scene = scene_of(case)
    one, other = hs.simulate(scene), hs.simulate(with_waves_turned(scene))
    for name in ("joint_position", "joint_velocity", "pto_power"):
        range_of = np.ptp(one[name].values, axis=0).max()
        error = np.abs(other[name].values - one[name].values).max() / range_of
        figure(f"{name}, of its range", error)
        assert range_of > 0.0
        assert error < 1e-9
    force = one.joint_force.values.reshape(-1, 2, 3)
    there = other.joint_force.values.reshape(-1, 2, 3)
    c, s = np.cos(BY), np.sin(BY)
    back = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    assert np.abs(there @ back - force).max() < 1e-9 * np.ptp(force, axis=0).max()


def test_a_float_above_its_spar_is_where_its_database_has_it() -> None:
    """Their distance is that of the centres of gravity, 21 m, though one is above the other: a tilt
    of 4 deg is no reason for a warning. One of 15 deg is."""
    scene = scene_of("point_absorber/irregular")
    assert "waves between them" not in str(hs.simulate(scene).attrs.get("warnings"))
    spar, above = scene.bodies
    tilted = replace(spar, position=(0.0, 0.0, 0.0, 0.0, np.radians(15.0), 0.0))
    run = hs.simulate(replace(scene, bodies=(tilted, above)))
    assert "rest, 21 m apart" in run.attrs["warnings"]
