"""Step limits: stability functions of the methods, and scenes that diverge where it is said."""

from __future__ import annotations

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from moored_barge import scene_of

import hydrosim as hs
from hydrosim.forces import Fender, FrictionSlope, LinearMooring
from hydrosim.integrate import DOPRI5, HEUN, RK2, RK4, Tableau
from hydrosim.scene import Body, Method, Scene, Solver, Unstable
from hydrosim.simulation import scene_step_limit
from hydrosim.stability import ray_limits


@pytest.mark.parametrize(
    ("method", "angle", "limit"),
    [(RK2, pi, 2.0), (HEUN, pi, 2.0), (RK4, pi, 2.7853), (RK4, pi / 2, 2 * sqrt(2))],
)
def test_limits_on_the_axes(method: Tableau, angle: float, limit: float) -> None:
    """Closed forms (Hairer & Wanner 1996, IV.2); the rays are looked at every 0.005, and growth of
    a thousandth per period is let pass."""
    assert ray_limits(method, np.array([angle]))[0] == pytest.approx(limit, abs=0.01)


def test_limit_of_dopri5_on_the_real_axis() -> None:
    """|R| = 1 of its stability polynomial, 1 + z + ... + z^5/120 + z^6/600."""
    z = ray_limits(DOPRI5, np.array([pi]))[0]
    growth = np.polyval([1 / 600, 1 / 120, 1 / 24, 1 / 6, 1 / 2, 1, 1], -z)
    assert abs(growth) == pytest.approx(1.0, abs=0.03)


def test_growing_motion_sets_no_limit() -> None:
    assert ray_limits(RK4, np.array([0.3]))[0] == np.inf


def dashpot(step: float, method: Method) -> Scene:
    """A mass of 2 kg on a damper of 50 N s/m: eigenvalue -25 1/s."""
    damper = LinearMooring("block", np.zeros((6, 6)), damping=50.0 * np.eye(6))
    body = Body("block", 2.0, np.eye(3), dofs=("surge",), velocity=(1.0, 0, 0, 0, 0, 0))
    solver = Solver(method=method, step=step)
    forces = {"damper": damper}
    return Scene("dashpot", 40.0, (body,), forces=forces, solver=solver, output_step=step)


@pytest.mark.parametrize(("method", "z"), [(Method.RK2, 2.0), (Method.RK4, 2.7853)])
def test_a_run_diverges_where_the_limit_says(method: Method, z: float) -> None:
    """2 % below the limit the velocity dies out, 2 % above it grows."""
    scene = dashpot(0.01, method)
    limit = scene_step_limit(scene, *hs.compile_scene(scene)).step
    assert limit == pytest.approx(z / 25.0, rel=3e-3)
    for factor, dies in ((0.98, True), (1.02, False)):
        run = hs.simulate(dashpot(factor * limit, method))
        speed = np.abs(run.velocity.sel(dof="surge").values[:, 0])
        assert (speed[-1] < 0.1) == dies
        assert (speed[-1] > 10.0) == (not dies)


def test_the_thesis_numerical_oscillation() -> None:
    """Four friction slopes of 1e9 N s/m on the barge's mass and A(inf): the step of 0.1 s is at
    2.47 of rk2's 2, in surge."""
    base = scene_of("base")
    fender = base.forces["interface"]
    assert isinstance(fender, Fender)
    slope = replace(fender, friction=FrictionSlope(0.2, 1e9))
    solver = Solver(method=Method.RK2, step=0.1, unstable=Unstable.ERROR)
    scene = replace(base, forces={**base.forces, "interface": slope}, solver=solver)
    limit = scene_step_limit(scene, *hs.compile_scene(scene))
    assert abs(limit.eigenvalue) * 0.1 == pytest.approx(2.47, abs=0.01)
    assert limit.step * abs(limit.eigenvalue) == pytest.approx(2.0, abs=0.01)
    assert limit.what == "surge of barge"
    with pytest.raises(hs.InputError, match=r"solver\.step 0\.1 s: largest stable step 0\.081\d s"):
        hs.simulate(scene)


def test_an_open_node_limits_the_base_case() -> None:
    """K2 / C2 = 5.6e8 / 3.3e7 1/s: 2.7853 / 16.97 = 0.164 s."""
    scene = scene_of("base")
    limit = scene_step_limit(scene, *hs.compile_scene(scene))
    assert limit.step == pytest.approx(2.7853 * 3.3e7 / 5.6e8, rel=3e-3)
    assert limit.what.startswith("the contact node of interface")
