"""Random scenes of contact: what must hold in all of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import block, central_force, scene, table

import hydrosim as hs
from hydrosim.dofs import DOFS
from hydrosim.elements.contact.law import OPEN, SLIP, STICK

MASS, WEIGHT, DURATION = 1e4, 9.81e4, 3.0
FINENESS = 0.2  # of the step times the fastest rate in the scene
CLOSED = (
    6e-5  # of the ledger: RK4 loses (h w)^4 / 72, 2e-5 of the energy of the fastest oscillation
)
# per radian, and a contact has about three
FREE = (DOFS, ("surge", "heave"), ("surge", "sway", "heave"), ("surge", "heave", "pitch"))


def between(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_subnormal=False)


@st.composite
def stick_slips(draw: Any, stiffness: float) -> hs.StickSlip:
    """Light to heavy damping, with or without slip damping, static friction as kinetic or more."""
    static = draw(between(0.05, 1.0))
    kinetic = static * draw(st.sampled_from([1.0, 0.8, 0.5, 0.2]))
    K2 = stiffness * draw(between(0.3, 3.0))
    C2 = draw(st.sampled_from([0.0, 0.05, 0.3])) * np.sqrt(K2 * MASS)
    C3 = draw(st.sampled_from([0.0, 0.1, 0.5] if C2 else [0.3])) * np.sqrt(K2 * MASS)
    return hs.StickSlip(static, kinetic, K2, C2, C3)


def law_of(friction: hs.StickSlip, kind: int) -> hs.StickSlip | hs.FrictionSlope | hs.Frictionless:
    if kind == 0:
        return hs.Frictionless()
    if kind == 1:
        return hs.FrictionSlope(friction.kinetic, 0.5 * np.sqrt(friction.stiffness * MASS))
    return friction


@st.composite
def scenes(draw: Any) -> hs.Scene:
    """A block of one to four fenders on a slope, with or without a corner in its curve."""
    count, k = draw(st.integers(1, 4)), MASS * 10 ** draw(between(1.5, 3.0))
    friction = draw(stick_slips(k))
    steeper = draw(st.sampled_from([1.0, 3.0]))
    force = 0.05 * k / count * np.array([0.0, 1.0, 1.0 + steeper])
    damping = draw(st.sampled_from([0.0, 0.2])) * np.sqrt(k * MASS) / count
    curve = hs.NormalCurve(np.array([0.0, 0.05, 0.1]), force, damping)
    places = np.array(draw(st.lists(between(-1.5, 1.5), min_size=2 * count, max_size=2 * count)))
    points = np.column_stack([places.reshape(count, 2), np.full(count, -1.0)])
    slope = (draw(between(-0.2, 0.2)), draw(between(-0.2, 0.2)), 1.0)
    pushes = draw(st.lists(between(-0.8, 0.8), min_size=12, max_size=12))
    force = np.zeros((6, 6))
    force[:, :2], force[:, 2] = WEIGHT * np.reshape(pushes, (6, 2)), -WEIGHT
    velocity = draw(st.lists(between(-1.0, 1.0), min_size=6, max_size=6))
    dofs, height = draw(st.sampled_from(FREE)), draw(between(0.95, 1.5))
    launch = tuple(np.array(velocity) * [2, 2, 2, 0.3, 0.3, 0.3])
    body = block(MASS, dofs, centre_of_gravity=(0.0, 0.0, height), velocity=launch)
    law = law_of(friction, draw(st.integers(0, 3)))
    times = np.linspace(0.0, DURATION, 6)
    forces = {
        "push": central_force(**table(times, force)),
        "mooring": hs.LinearMooring("block", MASS * np.diag([1.0, 1.0, 0.0, 40.0, 40.0, 10.0])),
        "fender": hs.Fender(
            "block", points, hs.Plane((0.0, 0.0, 0.0), slope), curve, _shared(law, count)
        ),
    }
    rate = np.sqrt(4.0 * max(steeper * k, friction.stiffness) / MASS)
    node = friction.stiffness / (friction.damping + friction.slip_damping)
    relaxing = friction.stiffness / friction.damping if friction.damping else 0.0
    step = FINENESS / max(rate, node, relaxing)
    every = max(round(0.02 / step), 1)
    steps = every * round(DURATION / (every * step))
    return scene(body, forces, steps * step, every * step, step=step)


def _shared(law: Any, count: int) -> Any:
    """The law of one of ``count`` points that have a total."""
    if isinstance(law, hs.StickSlip):
        parts = (law.stiffness / count, law.damping / count, law.slip_damping / count)
        return hs.StickSlip(law.static, law.kinetic, *parts)
    return hs.FrictionSlope(law.coefficient, law.slope / count) if law != hs.Frictionless() else law


@settings(max_examples=30, derandomize=True)
@given(scenes())
def test_what_holds_in_some_scenes_of_contact(scene: hs.Scene) -> None:
    check(scene)


@pytest.mark.slow
@settings(max_examples=200, derandomize=True)
@given(scenes())
def test_what_holds_in_every_scene_of_contact(scene: hs.Scene) -> None:
    check(scene)


def check(scene: hs.Scene) -> None:
    """What holds in a run of the scene."""
    run = hs.simulate(scene)
    assert run.status == "complete"
    assert all(np.isfinite(variable).all() for variable in run.data_vars.values())

    law = scene.forces["fender"].friction
    mode, N = run.fender_mode.values, run.fender_normal_force.values
    friction = run.fender_friction.values
    size = np.linalg.norm(friction, axis=2)
    tiny = 1e-9 * max(N.max(), 1.0)
    assert np.all(N >= -tiny)
    assert np.all(N[mode == OPEN] == 0.0)
    assert np.all(size[mode == OPEN] == 0.0)
    assert np.all(np.abs(friction @ _normal(scene)) <= tiny + 1e-12 * size.max())
    if isinstance(law, hs.StickSlip):
        assert np.all(size[mode == STICK] <= law.static * N[mode == STICK] + tiny)
        assert np.all(size[mode == SLIP] >= law.kinetic * N[mode == SLIP] - tiny)
    if isinstance(law, hs.FrictionSlope):
        assert np.all(size[mode == STICK] <= law.coefficient * N[mode == STICK] + tiny)
        np.testing.assert_allclose(size[mode == SLIP], law.coefficient * N[mode == SLIP], atol=tiny)

    slipped = run.fender_slip_distance.values
    assert np.all(np.diff(slipped, axis=0) >= -1e-15 * max(slipped.max(), 1.0))
    lost = run.fender_dissipated.values
    rounding = 1e-12 * max(lost.max(), 1.0)
    assert np.all(np.diff(lost, axis=0) >= -rounding)
    assert np.all(run.energy_dissipated_fender >= -rounding)
    assert run.energy_residual_relative <= CLOSED
    # a point has some events per oscillation (at most 18 per second were seen), not per step
    assert run.solver_events <= 40 * len(scene.forces["fender"].points) * DURATION


def _normal(scene: hs.Scene) -> np.ndarray:
    n = np.array(scene.forces["fender"].plane.normal)
    return n / np.linalg.norm(n)
