"""The reverse float-over of the thesis: what must come out of it for any seed."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from markers import few
from scenes import SEA, in_waves, scene_of

import hydrosim as hs
from hydrosim.elements.contact.law import OPEN, SLIP, STICK
from hydrosim.scene import Method, Tolerance, WaveTrain

Figure = Callable[[str, float], None]


def share(run: xr.Dataset, mode: int, start: float, end: float) -> float:
    """Share of the time from start to end [s] that the fenders spend in a mode."""
    return float((run.fender_mode.sel(time=slice(start, end)) == mode).mean())


@pytest.mark.parametrize("seed", few(range(1, 7), 2))
def test_the_barge_floats_then_knocks_then_sticks(seed: int, figure: Figure) -> None:
    run = hs.simulate(in_waves(scene_of("base"), WaveTrain(SEA, seed=seed, ramp=200.0)))
    first = float(run.time[(run.fender_mode > OPEN).any("fender")][0])
    figure(f"seed {seed}: first contact [s]", first)
    figure(f"seed {seed}: energy residual", run.attrs["energy_residual_relative"])
    figure(f"seed {seed}: surge at the end [m]", run.position.sel(dof="surge").values[-1, 0])
    figure(f"seed {seed}: stick after 1500 s", share(run, STICK, 1500.0, 2000.0))
    assert run.attrs["status"] == "complete"
    assert run.attrs["energy_residual_relative"] <= 1e-3
    assert 400.0 <= first <= 750.0
    assert share(run, OPEN, 0.0, first - 0.5) == 1.0
    assert all(share(run, mode, 700.0, 1000.0) > 0.1 for mode in (OPEN, STICK, SLIP))
    assert share(run, STICK, 1500.0, 2000.0) > 0.75
    assert share(run, OPEN, 1500.0, 2000.0) < 0.05


def test_waves_along_the_barge_do_not_push_it_sideways(base_run: xr.Dataset) -> None:
    sideways = base_run.position.sel(dof=["sway", "roll", "yaw"])
    assert np.abs(sideways).max() < 1e-12


def test_without_friction_it_swings_about_its_moorings() -> None:
    """The second half of the operation: no stick at all, and surge keeps to both sides of where
    mean drift holds it, about 0.1 m from rest; with friction it is carried off."""
    run = hs.simulate(scene_of("no_friction"))
    surge = run.position.sel(body="barge", dof="surge", time=slice(1000.0, None))
    assert share(run, STICK, 0.0, 2000.0) == 0.0
    assert float(surge.min()) < 0.0 < float(surge.max())
    assert not run.fender_friction.any()


def test_the_second_order_loads_alone_bring_the_offset() -> None:
    """Newman's loads have the mean sum_i D_i a_i^2; on the free barge its quotient with the mooring
    stiffness is the mean surge."""
    free = scene_of("free_floating").with_output(step=1.0)
    run = hs.simulate(free).sel(body="barge", dof="surge", time=slice(600.0, None))
    assert 0.05 < float(run.position.mean()) < 0.4
    assert float(run.position.mean()) == pytest.approx(
        float(run.force_wave_second_order.mean()) / 392.4e3, rel=0.2
    )


@pytest.mark.slow
def test_the_implicit_method_keeps_its_tolerance_through_contact(figure: Figure) -> None:
    """Right after a contact closes the direction of slip turns so fast that Newton's method ends
    nowhere, or the error is too large: shorter steps are then taken. Error and tolerance
    go together: a hundredth of one has a hundredth of the other, against rk4 at 0.0125 s, whose
    own error is 1e-10 m."""
    scene = replace(scene_of("base"), duration=660.0).with_output(step=0.4)
    exact = replace(scene, solver=replace(scene.solver, step=0.0125))
    there, errors = hs.simulate(exact).position.sel(dof="surge").values, []
    for relative in (1e-6, 1e-8):
        tolerance = Tolerance(relative, relative, relative / 100)
        solver = replace(scene.solver, method=Method.ESDIRK4, tolerance=tolerance)
        run = hs.simulate(replace(scene, solver=solver))
        errors.append(np.abs(run.position.sel(dof="surge").values - there).max())
        figure(f"error of esdirk4 at {relative:g} [m]", float(errors[-1]))
    assert run.attrs["status"] == "complete"
    assert run.attrs["solver_rejected"] > 0
    assert errors[0] < 1e-3
    assert errors[1] < errors[0] / 30.0
