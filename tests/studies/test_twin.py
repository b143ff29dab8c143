"""Runs that begin near each other and part are told."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from dry_scenes import block, moving, on_floor, scene, steady
from numpy.typing import ArrayLike

import hydrosim as hs
from hydrosim.forces import Frictionless, StickSlip
from hydrosim.scene import Method, Scene, Tolerance

LEGS = [(x, y, -0.5) for x in (-1.0, 1.0) for y in (-0.7, 0.7)]
NEARBY, WARNED = 1e-9, "cannot be foretold"


def bouncing(points: ArrayLike, damping: float = 0.0, **start: float) -> Scene:
    """A block of 100 kg that falls on stiff legs, without friction."""
    floor = on_floor(2e5, Frictionless(), points=np.atleast_2d(points).tolist())
    curve = replace(floor.normal, damping=damping)
    body = block(100.0, position=moving(heave=1.0, **start))
    forces = {"floor": replace(floor, normal=curve), "weight": steady(heave=-981.0)}
    return scene(body, forces, duration=20.0, output_step=0.05, step=0.001)


def warnings(run: xr.Dataset) -> list[str]:
    return [x for x in str(run.attrs.get("warnings", "")).splitlines() if WARNED in x]


def test_a_block_that_rattles_on_its_legs() -> None:
    """It has been said for how far two runs part that begin as near as that, and when; the bodies
    come down on one leg or the other."""
    start = {"roll": 0.1, "pitch": 0.07}
    run = hs.simulate(bouncing(LEGS, **start))
    other = bouncing(LEGS, **start)
    moved = other.bodies[0].position[:3] + NEARBY * np.cos([0.0, 1.0, 2.0])
    body = replace(other.bodies[0], position=(*moved, *other.bodies[0].position[3:]))
    near = hs.simulate(replace(other, bodies=(body,)))
    apart = np.abs((near.position - run.position).values[:, 0, :3]).max(axis=1) / NEARBY
    assert apart.max() > 1e4
    (said,) = warnings(run)
    found = re.search(r"(\d+) times as far from it after ([\d.]+) s, and (\S+) times", said)
    assert found is not None
    limit = float(found[1])
    assert limit == pytest.approx(min(1e4, 1e-4 / run.attrs["energy_residual_relative"]), abs=1.0)
    assert float(found[2]) == pytest.approx(run.time.values[apart > limit][0], abs=0.051)
    assert np.log(float(found[3])) == pytest.approx(np.log(apart.max()), rel=0.1)


def test_a_ball_that_bounces_is_known() -> None:
    """Neighbours of an elastic ball part by as much in every bounce: not for ever more."""
    run = hs.simulate(bouncing((0.0, 0.0, 0.0)))
    assert run.attrs["solver_events"] > 20
    assert not warnings(run)


def test_a_block_that_comes_to_rest_is_known() -> None:
    start = {"roll": 0.1, "pitch": 0.07}
    run = hs.simulate(bouncing(LEGS, damping=3e3, **start))
    assert run.attrs["solver_events"] > 20
    assert not warnings(run)


def test_other_steps_are_no_parting() -> None:
    """An adaptive method takes other steps for a twin, and with a large tolerance other motions."""
    calm = bouncing(LEGS, damping=3e3, roll=0.1, pitch=0.07)
    loose = Tolerance(relative=1e-4, position=1e-4)
    solver = replace(calm.solver, method=Method.DOPRI5, tolerance=loose)
    assert not warnings(hs.simulate(replace(calm, solver=solver)))


def test_what_slides_and_sticks_is_known() -> None:
    law = StickSlip(0.3, 0.2, 1e5, 300.0)
    held = on_floor(1e5, law, points=LEGS)
    body = block(100.0, position=moving(heave=0.5 - 981.0 / 4e5))
    forces = {"floor": held, "weight": steady(heave=-981.0), "push": steady(surge=300.0)}
    run = hs.simulate(scene(body, forces, duration=10.0, output_step=0.05, step=0.001))
    assert not warnings(run)
