"""Adaptive steps: what is lost by the end of a run goes with its duration, not with its steps."""

import numpy as np
import pytest
from scenes import block, mooring, moving, scene

import hydrosim as hs
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Method


@pytest.mark.parametrize("method", [Method.DOPRI5, Method.ESDIRK4])
@pytest.mark.parametrize("omega", [2.0, 20.0, 100.0])
def test_a_small_vibration_of_many_periods(method, omega, validated):
    """Free swings of 5 mm for 60 s, against the cosine. The tolerance allows 1e-6 m and 1e-6 m/s a
    second, and so 6e-5 m and, by the velocity, 6e-5 m / omega, whatever the steps; most of that is
    the velocity's. 0.1 of it is what the estimate of the error leaves unused, at most."""
    spring = mooring(surge=omega**2)
    body = block(1.0, ["surge"], position=moving(surge=5e-3))
    run = hs.simulate(scene(body, {"spring": spring}, 60.0, 0.1, method=method, step=0.005))
    error = np.abs(run.position.values[:, 0, 0] - 5e-3 * np.cos(omega * run.time.values)).max()
    allowed = 60.0 * 1e-6 * (1.0 + 1.0 / omega)
    claim = f"vibration over 60 s by {method}, of what the tolerance allows"
    feature = Feature.ADAPTIVE if method == Method.DOPRI5 else Feature.IMPLICIT
    validated(Kind.CLOSED_FORM, claim, "cos ωt", error / allowed, 1.0, feature)
