"""Starts at rest: what carries a weight, and what is said where nothing does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import block, moving, scene, steady

import hydrosim as hs
from hydrosim.errors import InputError
from hydrosim.scene import ForceElement, Scene, Weight

WEIGHT = 9.81 * 2e7
CORNERS = np.array([[x, y, -5.0] for x in (-20.0, 18.0) for y in (-15.0, 15.0)])
X = np.array([0.0, 0.1, 0.2])
LOOP = hs.NormalLoop(X, np.array([0.0, 2e7, 8e7]), X, np.array([0.0, 1e7, 8e7]), 2e9)
LAW = hs.StickSlip(0.3, 0.2, 1e8, 1e6)


def topside(height: float = 0.0, **forces: ForceElement) -> Scene:
    """A topside on four legs, whose centre of gravity is not in their middle."""
    inertia, place = 2e7 * np.diag([80.0, 120.0, 150.0]), moving(heave=height)
    body = block(2e7, name="topside", inertia=inertia, weight=Weight.CARRIED, position=place)
    legs = hs.Landing("topside", CORNERS, hs.Seats(CORNERS), LOOP, LAW)
    resting = scene(body, {"legs": legs, **forces}, 20.0, 0.5, step=0.05)
    return replace(resting, at_rest=True)


def test_the_legs_of_a_topside_carry_its_weight_and_nothing_moves():
    run = hs.simulate(topside())
    N = run.fender_normal_force.values
    assert N.sum(axis=1) == pytest.approx(WEIGHT, rel=1e-10)
    lever = run.fender_node.values[0] - run.position.values[0, 0, :3]
    moment = N[0] @ lever[:, :2]
    assert np.abs(moment).max() < 1e-9 * WEIGHT
    assert N[0, 0] == pytest.approx(WEIGHT * 18 / 38 / 2, rel=1e-3)  # levers of the two sides
    assert np.ptp(run.position.values, axis=0).max() < 1e-11
    assert run.attrs["solver_events"] == 0
    assert np.abs(run.fender_friction.values).max() < 1e-6 * WEIGHT
    assert np.abs(run.fender_dissipated.values).max() < 1e-15


def test_legs_lines_and_pads_share_a_load_as_their_stiffness_says():
    """A level body: k (x0 - x) of each, by hand."""
    ends = ("topside", (0.0, 0.0, 5.0), (0.0, 0.0, 15.0))
    hanger = hs.Spring(*ends, 9.0, X[:2], np.array([0.0, 2e6]))
    pads = hs.Fender(
        *("topside", CORNERS[[0, 3]], hs.Plane((0.0, 0.0, -4.9), (0.0, 0.0, 1.0))),
        *(hs.NormalCurve(X[:2], np.array([0.0, 1e7])), hs.Frictionless()),
    )
    only = topside(hanger=hanger, pads=pads)
    body = replace(only.bodies[0], dofs=("heave",))
    run = hs.simulate(replace(only, bodies=(body,)))
    x = run.position.values[0, 0, 2]
    legs = 4 * np.interp(-x, X, LOOP.force)
    pads_force, line = 2 * 1e8 * (0.1 - x), 2e7 * (1.0 - x)
    assert legs + pads_force + line == pytest.approx(WEIGHT, rel=1e-10)
    assert np.ptp(run.position.values[:, 0, 2]) < 1e-11


def test_what_nothing_carries_is_said():
    said = r"nothing carries -1\.962e\+08 N in heave of topside \(the"
    with pytest.raises(InputError, match=said):
        hs.compile_scene(topside(2.0))
    with pytest.raises(InputError, match=r"legs \d, is 2 m away"):
        hs.compile_scene(topside(2.0))


def test_legs_that_cannot_hold_it_level_are_said():
    """Its centre of gravity is outside what carries it: it topples."""
    legs = hs.Landing("topside", CORNERS[:2], hs.Seats(CORNERS[:2]), LOOP, LAW)
    with pytest.raises(InputError, match="initial: found at_rest"):
        hs.compile_scene(topside(legs=legs))


def test_a_mooring_that_is_pulled_begins_where_it_holds():
    """No weight needed: a steady force and a spring."""
    body = block(1e3, ("surge",))
    forces = {"spring": hs.LinearMooring("block", 50.0 * np.eye(6)), "pull": steady(surge=20.0)}
    run = hs.simulate(replace(scene(body, forces, 5.0, 0.1), at_rest=True))
    assert run.position.values[:, 0, 0] == pytest.approx(0.4, abs=1e-12)


def test_a_case_begins_at_rest_and_says_so_again(tmp_path):
    path = tmp_path / "case.yaml"
    path.write_text(
        "title: pull\nduration: 5 s\ninitial: at_rest\nbodies: {block: {mass: 2 kg, dofs: [surge]}}"
        "\nforces:\n  spring: {type: linear_mooring, body: block, stiffness: {surge: 50 N/m}}\n"
        "  pull: {type: applied_force, body: block, force: {surge: [20 N]}}\n"
    )
    found = hs.load_case(path)
    path.write_text(str(found.scene().source["case_resolved"]))
    assert hs.load_case(path).scene().at_rest
    assert hs.simulate(found).position.values[-1, 0, 0] == pytest.approx(0.4, abs=1e-12)
    path.write_text(path.read_text().replace("velocity: [0.0,", "velocity: [1.0,", 1))
    with pytest.raises(InputError, match="at_rest, and a velocity of block"):
        hs.load_case(path)
