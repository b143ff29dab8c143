"""Scenes of dry bodies: their natural modes, and who is named when one of several fails."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scenes import table

import hydrosim as hs
from hydrosim.dofs import DOFS
from hydrosim.elements import AppliedForce, Fender, LinearMooring, NormalCurve, Plane, StickSlip
from hydrosim.linear.modes import NaturalMode
from hydrosim.scene import Body, Scene, Solver

MASS = np.array([4.0, 4.0, 4.0, 2.0, 6.0, 5.0])
BLOCK = Body("block", mass=4.0, inertia=np.diag(MASS[3:]))
SPRING = np.array([9.0, 4.0, 16.0, 5.0, 8.0, 3.0])
RATIO = np.array([0.0, 0.05, 0.02, 0.1, 0.0, 0.3])


def modes_of(scene: Scene) -> list[NaturalMode]:
    return hs.natural_modes(hs.linearise(*hs.compile_scene(scene)))


def test_natural_modes_of_a_dry_body_on_springs() -> None:
    """T = 2 pi sqrt(m / k), the damped one longer by 1 / sqrt(1 - zeta^2), in all six freedoms;
    central differences of a linear force are exact but for rounding."""
    spring = LinearMooring("block", stiffness=np.diag(SPRING), damping_ratio=RATIO)
    modes = modes_of(Scene("block", 1.0, (BLOCK,), forces={"spring": spring}))
    found = {mode.dof: mode for mode in modes}
    natural = 2 * np.pi * np.sqrt(MASS / SPRING)
    damped = natural / np.sqrt(1 - RATIO**2)
    assert_allclose([found[dof].natural_period for dof in DOFS], natural, rtol=1e-6)
    assert_allclose([found[dof].damped_period for dof in DOFS], damped, rtol=1e-6)
    assert_allclose([found[dof].damping_ratio for dof in DOFS], RATIO, atol=1e-6)


def test_a_body_without_springs_has_no_period() -> None:
    modes = modes_of(Scene("adrift", 1.0, (BLOCK,)))
    assert [mode.dof for mode in modes] == list(DOFS)
    assert all(mode.natural_period == mode.damped_period == inf for mode in modes)


def test_the_body_that_turns_over_is_named() -> None:
    """Not the one that is farthest away."""
    far = replace(BLOCK, name="far", velocity=(50.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    turning = replace(BLOCK, name="turning", velocity=(0.0, 0.0, 0.0, 0.0, 1.0, 0.0))
    with pytest.raises(hs.SimulationError, match="pitch of body turning") as caught:
        hs.simulate(Scene("two", 10.0, (far, turning)))
    assert 1.0 <= caught.value.dataset.time[-1] < 1.6  # 85 deg are 1.48 rad


def test_a_node_that_overflows_far_from_contact_is_no_silent_nan() -> None:
    """An open node relaxes at K2 / C2 = 1000 1/s, ten steps of it in one: it overflows while the
    block flies on unharmed, and the run must not be called complete."""
    down, up = np.array([0.0, 0.0, -9810.0, 0, 0, 0]), np.array([0.0, 0.0, 5000.0, 0, 0, 0])
    push = AppliedForce(
        "block", (0.0, 0.0, 0.0), table([0.0, 0.3, 0.4, 10.0], [down, down, up, up])
    )
    curve = NormalCurve(np.array([0.0, 1.0]), np.array([0.0, 1e6]))
    law = StickSlip(0.2, 0.1, stiffness=1e6, damping=1e3, slip_damping=1e4)
    plane = Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    start = {"position": (0, 0, 0.1, 0, 0, 0), "velocity": (1.0, 0, -1.0, 0, 0, 0)}
    block = Body("block", 1e3, np.eye(3), dofs=("surge", "heave"), **start)
    forces = {"push": push, "pad": Fender("block", np.zeros((1, 3)), plane, curve, law)}
    scene = Scene("bounce", 6.0, (block,), forces=forces, solver=Solver(step=0.01))
    with pytest.raises(hs.SimulationError, match=r"blows up.*most of it in pad"):
        hs.simulate(scene)
