"""Articulated bodies against the matrix of the whole, and placing that forgets what was before."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from test_joint_forces import CHAINS, chain

import hydrosim as hs
from hydrosim.compile.compiled import Compiled
from hydrosim.integrate.dynamics import Model, Work, accelerate, is_articulated, new_work
from hydrosim.multibody.articulated import accelerate_articulated
from hydrosim.multibody.kinematics import place_bodies
from hydrosim.scene import Kinematics, Scene, Weight

SEEDS = range(4)


def floating(kinds: tuple[str, ...], seed: int) -> Scene:
    """The chain without the joint to the earth: its root is free."""
    whole = chain(kinds, seed)
    joints = {name: joint for name, joint in whole.joints.items() if joint.to is not None}
    return replace(whole, joints=joints)


def placed(compiled: Compiled, seed: int) -> tuple[Model, Work, np.ndarray]:
    """The model at random coordinates and rates, and these."""
    model = compiled.model
    work = new_work(model)
    n = model.bodies.active.size
    y = compiled.state.y.copy()
    y[: 2 * n] = np.random.default_rng(seed).uniform(-0.9, 0.9, 2 * n)
    place_bodies(y[:n], y[n : 2 * n], model.bodies, work.motion)
    return model, work, y


@pytest.mark.parametrize("built", [chain, floating])
@pytest.mark.parametrize("kinds", CHAINS, ids="-".join)
def test_accelerations_are_those_of_the_whole_matrix(
    built: Callable[[Sequence[str], int], Scene], kinds: tuple[str, ...]
) -> None:
    for seed in SEEDS:
        compiled = hs.compile_scene(built(kinds, seed))
        model, work, y = placed(compiled, seed)
        assert is_articulated(model)
        rng = np.random.default_rng(seed)
        loads = rng.uniform(-9.0, 9.0, work.total.size)
        added = rng.uniform(-0.3, 0.3, (work.total.size, work.total.size))
        own = np.kron(np.eye(len(loads) // 6), np.ones((6, 6)))
        model = model._replace(added_mass=(added + added.T) * own + 2.0 * np.eye(len(loads)))
        x = np.zeros((2, model.bodies.active.size))
        work.total[:] = loads
        accelerate(y, compiled.state.modes, model, work, x[0])
        added_mass, headings = model.added_mass, model.headings
        accelerate_articulated(
            model.bodies, work.contents, headings, added_mass, work.motion, loads, x[1]
        )
        np.testing.assert_allclose(x[1], x[0], rtol=1e-10, atol=1e-11 * np.abs(x[0]).max())


@pytest.mark.parametrize("kinematics", Kinematics)
def test_places_do_not_depend_on_those_before(kinematics: Kinematics) -> None:
    """Rotations of jointed bodies too, with exact rotations and with small angles."""
    whole = chain(("hinge", "universal", "slider"), 1)
    level = [replace(body, heading=0.0, weight=Weight.BALANCED) for body in whole.bodies]
    solver = replace(whole.solver, kinematics=kinematics)
    still = {name: replace(joint, resistances=()) for name, joint in whole.joints.items()}
    whole = replace(whole, bodies=tuple(level), solver=solver, joints=still)
    compiled = hs.compile_scene(whole)
    model, fresh, y = placed(compiled, 1)
    _, used, other = placed(compiled, 2)
    n = model.bodies.active.size
    place_bodies(y[:n], y[n : 2 * n], model.bodies, used.motion)
    assert not np.array_equal(y, other)
    for name in ("coordinates", "rate", "rotation", "velocity", "bias"):
        assert np.array_equal(getattr(used.motion, name), getattr(fresh.motion, name)), name
