"""Runs that cannot go on end, with a message: no search for an event goes on for ever."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from dry_scenes import block, scene

import hydrosim as hs
from hydrosim.forces import Fender, NormalCurve, Plane, StickSlip, WindLoad
from hydrosim.scene import Environment, Method, Stream

CURVE = NormalCurve(np.array([0.0, 0.03, 0.06, 0.09]), np.array([0.0, 2e6, 8.4e6, 2e7]))
PLANE = Plane((-0.75, 13.0, 5.4), (-0.13, -0.99, 0.085))
POINT = np.array([[0.46, 2.5, -3.9]])
HEADINGS = np.radians([0.0, 90.0, 180.0, 270.0])


@pytest.mark.parametrize("method", [Method.RK4, Method.DOPRI5])
def test_a_node_far_beyond_its_step_limit(method: Method) -> None:
    """K2 / C2 is 190 1/s, and the step 0.05 s: what relaxes grows instead, until nothing is finite
    any more. By steps that adapt it comes to its end."""
    law = StickSlip(0.14, 0.12, stiffness=1.9e8, damping=1e6)
    surge = 4300.0 * np.cos(HEADINGS)
    elements = {
        "fender": Fender("block", POINT, PLANE, CURVE, law),
        "wind": WindLoad("block", (0.0, 0.0, 0.0), HEADINGS, surge, 0.0 * surge, 0.0 * surge),
    }
    windy = scene(block(3.8e6, ["surge"]), elements, 52.0, 0.5, step=0.05, method=method)
    windy = replace(windy, environment=Environment(wind=Stream(18.0)))
    if method is Method.DOPRI5:
        assert hs.simulate(replace(windy, duration=10.0)).attrs["status"] == "complete"
        return
    ends = r"no longer finite|changes its mode endlessly|blows up"
    with pytest.raises(hs.SimulationError, match=ends):
        hs.simulate(windy)
