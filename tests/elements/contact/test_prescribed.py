"""Normal forces that are prescribed: one that touches zero, and goes on."""

import numpy as np
import pytest
from markers import few
from scenes import block, central_force, foot, mooring, moving, scene, surge

import hydrosim as hs
from hydrosim.elements import Harmonic
from hydrosim.scene import Method, Scene
from hydrosim.scene.contacts import Law

LAWS: dict[str, Law] = {
    "stick-slip": hs.StickSlip(0.3, 0.2, 1e6, 2e4),
    "stick-slip without dampers": hs.StickSlip(0.3, 0.2, 1e6, 0.0),
    "friction slope": hs.FrictionSlope(0.2, 1e5),
    "coulomb": hs.Coulomb(0.3, 0.2),
    "frictionless": hs.Frictionless(),
}
PERIODS = (6.262589, 8.0, 13.247637)  # s: some touch on the grid of the steps, some do not
DURATION = 60.0


def pressed(law: Law, period: float, phase: float, method: Method, step: float) -> Scene:
    """A block that is pushed to and fro under a normal force from 0 to 2e5 N."""
    normal = hs.PrescribedNormal(Harmonic(1e5, period, 1e5, phase))
    push, spring = central_force(surge=Harmonic(4e4, 7.0)), mooring(surge=2e4)
    forces = {"push": push, "spring": spring, "floor": foot(normal, law)}
    body = block(1e5, ("surge",), velocity=moving(surge=0.3))
    return scene(body, forces, DURATION, 0.1, method=method, step=step)


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("period", few(PERIODS, 1))
def test_a_force_that_touches_zero(name: str, period: float) -> None:
    """Contact lets go at most once at each touch, seen or not; all methods move alike."""
    law = LAWS[name]
    for phase in (0.0, -0.5 * np.pi):
        there = hs.simulate(pressed(law, period, phase, Method.DOPRI5, 0.1))
        fine = (Method.RK4, 0.02), (Method.RK4, 0.01), (Method.ESDIRK4, 0.05)
        runs = [hs.simulate(pressed(law, period, phase, *each)) for each in fine]
        touches = DURATION // period + 1
        for run in runs:
            assert abs(run.solver_events - there.solver_events) <= 2 * touches
            apart = np.abs(surge(run) - surge(there)).max()
            assert apart < 2e-5 * np.ptp(surge(there))
