"""The case that a run holds, of scenes with joints: it is read again, and gives the same run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

import hydrosim as hs
from hydrosim.case import joints
from hydrosim.run.provenance import case_of

CASES = Path(__file__).parents[3] / "cases"
FORMS = [
    joints.Hinge,
    joints.Slider,
    joints.Cylindrical,
    joints.Universal,
    joints.Planar,
    joints.Ball,
    joints.Fixed,
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
    document = {
        "title": "a joint",
        "duration": 1.0,
        "bodies": {"topside": dry, "barge": dry},
        "joints": {"between": form.example},
        "solver": {"method": "rk4", "step": 0.1},
    }
    path = tmp_path / "case.yaml"
    path.write_text(yaml.dump(document))
    case = hs.load_case(path)
    resolved = case.scene().source["case_resolved"]
    path.write_text(resolved)
    assert hs.load_case(path).scene().joints == case.scene().joints
