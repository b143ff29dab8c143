"""The case that a run holds, of scenes with joints: it is read again, and gives the same run."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from scenes import turned_scene

import hydrosim as hs
from hydrosim.run.provenance import case_of
from hydrosim.scene import Scene, Symmetry
from hydrosim.scene import joint as joints

CASES = Path(__file__).parents[3] / "cases"
FORMS = [
    *(joints.Hinge, joints.Slider, joints.Cylindrical, joints.Universal),
    *(joints.Planar, joints.Ball, joints.Fixed),
]


CONVOLUTION = {f"bodies.{name}.radiation": {"model": "convolution"} for name in ("spar", "float")}
"""The search for a fit of these two bodies takes minutes."""


@pytest.mark.parametrize(
    ("case", "radiation"),
    [("hinged_barges/irregular", {}), ("point_absorber/irregular", CONVOLUTION)],
)
def test_a_case_is_repeated_from_its_run(case, radiation, tmp_path):
    short = {"duration": 2.0, "environment.waves.ramp": 1.0, "output.step": 0.5, **radiation}
    first = hs.simulate(hs.load_case(CASES / f"{case}.yaml", short))
    path = tmp_path / "again.yaml"
    path.write_text(case_of(first))
    again = hs.simulate(hs.load_case(path))
    assert np.array_equal(first.position.values, again.position.values)
    assert np.array_equal(first.joint_force.values, again.joint_force.values)


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.__name__)
def test_every_type_of_joint_is_written_with_all_that_is_taken_for_it(form, tmp_path):
    """Its example between two dry bodies, of which the joint carries one."""
    dry = {"mass": 100.0, "radii_of_gyration": [1.0, 1.0, 1.0]}
    document = {"title": "a joint", "duration": 1.0, "solver": {"method": "rk4", "step": 0.1}}
    document |= {"bodies": {"topside": dry, "barge": dry}, "joints": {"between": form.example}}
    path = tmp_path / "case.yaml"
    path.write_text(yaml.dump(document))
    case = hs.load_case(path)
    resolved = case.scene().source["case_resolved"]
    path.write_text(resolved)
    assert hs.load_case(path).scene().joints == case.scene().joints


# Wet scenes with joints, turned about the vertical together with their waves.

BY = np.radians(40.0)
SCENES = ["hinged_barges/irregular", "flap/irregular", "point_absorber/irregular"]


def scene_of(case: str) -> Scene:
    """The first 40 s of a case in its sea, without a ramp, in all degrees of freedom."""
    waves = {"environment.waves.ramp": 0.0, "environment.waves.heading": np.radians(30.0)}
    settings = {"duration": 40.0, "output.step": 0.5, **waves}
    if case.startswith("point_absorber"):  # the search for a fit of these two takes minutes
        convolution = {"model": "convolution"}
        settings |= {f"bodies.{name}.radiation": convolution for name in ("spar", "float")}
    scene = hs.load_case(CASES / f"{case}.yaml", settings).scene()
    return replace(scene, solver=replace(scene.solver, symmetry=Symmetry.IGNORE))


@pytest.mark.parametrize("case", SCENES)
def test_joints_do_not_know_where_north_is(case: str, figure) -> None:
    scene = scene_of(case)
    one, other = hs.simulate(scene), hs.simulate(turned_scene(scene, BY))
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
    """Their centres of gravity are 21 m apart, as there, at a tilt of 4 deg too; not at 15 deg."""
    scene = scene_of("point_absorber/irregular")
    assert "waves between them" not in str(hs.simulate(scene).attrs.get("warnings"))
    spar, above = scene.bodies
    tilted = replace(spar, position=(0.0, 0.0, 0.0, 0.0, np.radians(15.0), 0.0))
    run = hs.simulate(replace(scene, bodies=(tilted, above)))
    assert "rest, 21 m apart" in run.attrs["warnings"]
