"""Joints in pictures, drawings and replays: at their places, and with their bodies."""

from base64 import b64decode
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from report_pages import data_of
from scipy.spatial.transform import Rotation

import hydrosim as hs
from hydrosim.report.arrangement import arrange_scene
from hydrosim.report.charts.pictures import figure
from hydrosim.report.document import run_document
from hydrosim.report.page import html
from hydrosim.report.replay import replay_document, scene_of, shape_of

CASES = Path(__file__).parents[2] / "cases"
SHORT = {"duration": 12.0, "output.step": 1.0, "environment.waves.ramp": 2.0}


def run_of(case: str) -> xr.Dataset:
    """The first seconds of an irregular case."""
    return hs.simulate(hs.load_case(CASES / case / "irregular.yaml", SHORT))


@pytest.fixture(scope="module")
def barges() -> xr.Dataset:
    return run_of("hinged_barges")


def test_bodies_of_one_database_are_drawn_where_they_float_and_the_hinge_between(barges):
    """40 m each, 4 m apart, with the hinge over the middle of the gap at deck level."""
    drawing = arrange_scene(scene_of(barges))
    fore, aft = (body.corners[:, 0] for body in drawing.bodies)
    np.testing.assert_allclose([fore.min(), fore.max()], [2.0, 42.0], atol=1e-9)
    np.testing.assert_allclose([aft.min(), aft.max()], [-42.0, -2.0], atol=1e-9)
    np.testing.assert_allclose(drawing.joints["hinge"], [[0.0, 0.0, 1.5]], atol=1e-9)


def test_the_bar_of_a_hinge_lies_across_both_barges_at_all_times(barges):
    """It is longer than the beam of 10 m. Its place on the fore barge is that of the same point of
    the aft one, in every record: what the page draws is together."""
    data = data_of(html(replay_document(barges), ""))["replay"]
    (joint,) = data["joints"]
    assert (joint["name"], joint["body"], data["factor"]) == ("hinge", 0, 1)
    corners = np.frombuffer(b64decode(joint["triangles"]), "<f4").reshape(-1, 3)
    np.testing.assert_allclose(corners.mean(axis=0), [-22.0, 0.0, 1.5], atol=1e-4)
    assert np.ptp(corners[:, 1]) == pytest.approx(11.0, rel=1e-3)
    shape = (-1, len(data["bodies"]), 6)
    q = np.frombuffer(b64decode(data["position"]), "<f4").reshape(shape).astype(float)
    assert np.abs(q[:, :, 4]).max() > 1e-3
    ends = []
    for body, point in ((0, [-22.0, 0.0, 1.5]), (1, [22.0, 0.0, 1.5])):
        turns = Rotation.from_euler("ZYX", q[:, body, 5:2:-1])
        ends.append(data["rest"][body] + q[:, body, :3] + turns.apply(point))
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-4)


def test_a_submerged_hull_is_drawn_as_it_is():
    run = run_of("point_absorber")
    scene = scene_of(run)
    spar = next(body for body in scene.bodies if body.name == "spar")
    corners = shape_of(spar).triangles.reshape(-1, 3)
    assert "recipe" in shape_of(spar).said
    np.testing.assert_allclose([corners[:, 2].min(), corners[:, 2].max()], [-9.0, 16.0])
    assert np.hypot(corners[:, 0], corners[:, 1]).max() == pytest.approx(5.0)


SLUNG = """\
title: A load on a sling
duration: 2 s
bodies:
  boom:
    {mass: 10 tonne, radii_of_gyration: [1, 3, 3], centre_of_gravity: [5, 0, 2], dofs: [heave]}
  load:
    {mass: 1 tonne, radii_of_gyration: [1, 1, 1], centre_of_gravity: [10, 0, -6], weight: carried}
joints:
  sling: {type: rod, body: load, to: boom, point: [0, 0, 1 m], to_point: [5 m, 0, 0]}
forces:
  lift: {type: drive, body: boom, dof: heave, offset: {amplitude: 0.2 m, period: 5 s}}
solver: {step: 0.02 s}
output: {step: 0.1 s}
"""


def test_a_rod_is_drawn_as_a_line_between_its_ends(tmp_path):
    """7 m long in every record, in the colour of its force."""
    path = tmp_path / "case.yaml"
    path.write_text(SLUNG)
    run = hs.simulate(hs.load_case(path))
    data = data_of(html(replay_document(run), ""))["replay"]
    assert data["joints"] == []
    (line,) = data["lines"]
    assert (line["name"], line["body"], line["anchor_body"]) == ("sling", 1, 0)
    q = np.frombuffer(b64decode(data["position"]), "<f4").reshape(-1, 2, 6).astype(float)
    ends = []
    for body, point in ((line["body"], line["point"]), (line["anchor_body"], line["anchor"])):
        turns = Rotation.from_euler("ZYX", q[:, body, 5:2:-1])
        ends.append(data["rest"][body] + q[:, body, :3] + turns.apply(point))
    np.testing.assert_allclose(np.linalg.norm(ends[0] - ends[1], axis=1), 7.0, atol=1e-5)
    tensions = np.frombuffer(b64decode(data["tensions"]), "<f4")
    acceleration = -0.2 * (2 * np.pi / 5) ** 2 * np.sin(2 * np.pi / 5 * run.time.values)
    np.testing.assert_allclose(tensions, 1e3 * (9.81 + acceleration), rtol=1e-4)


def test_panels_and_charts_of_joints(barges):
    """Motion and force. In head seas the moment of the hinge is rounding and has no panel."""
    labels = [axis.get_ylabel() for axis in figure(barges, "joints").axes]
    assert labels == ["joint motion [deg]", "joint force [kN]"]
    page = html(run_document(barges), "")
    for title in ("Motions of joints", "Rates of joints", "load of joint hinge: force"):
        assert title in page
