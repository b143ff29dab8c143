"""Scenes in general: any number of bodies and fenders, dry bodies, locked degrees of freedom."""

from dataclasses import replace
from itertools import pairwise
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose
from scenes import SEA, in_contact, in_waves, motion, scene_of, with_body

import hydrosim as hs
from hydrosim.dofs import DOFS
from hydrosim.elements.contact.law import SLIP, STICK
from hydrosim.errors import InputError
from hydrosim.scene import ConvolutionRadiation, Kinematics
from hydrosim.water.radiation import Retardation, StateSpace, fits, kept

FAR = (300.0, 120.0)  # m


def side_by_side(scene: hs.Scene, **locations: tuple[float, float]) -> hs.Scene:
    """The scene's barge, with all that acts on it, once for each name."""
    (barge,) = scene.bodies
    bodies = [replace(barge, name=name, location=place) for name, place in locations.items()]
    forces = {
        f"{kind}_{name}": replace(element, body=name)
        for name in locations
        for kind, element in scene.forces.items()
    }
    return replace(scene, bodies=tuple(bodies), forces=forces)


def assert_same_motion(found: np.ndarray, expected: np.ndarray, tolerance: float) -> None:
    """Within ``tolerance`` of the largest value, for each degree of freedom by itself."""
    assert (np.abs(found - expected) <= tolerance * np.abs(expected).max(axis=0)).all()


def test_two_barges_move_as_each_alone() -> None:
    """No interaction, one irregular sea with all loads, at two places: the same to rounding."""
    sea = hs.WaveTrain(SEA, heading=np.radians(30.0), ramp=20.0)
    scene = replace(in_waves(scene_of("free_floating"), sea), duration=200.0)
    both = hs.simulate(side_by_side(scene, near=(0.0, 0.0), far=FAR))
    near = hs.simulate(side_by_side(scene, near=(0.0, 0.0)))
    far = hs.simulate(side_by_side(scene, far=FAR))
    for i, alone in enumerate((near, far)):
        assert_same_motion(motion(both, i), motion(alone), 1e-12)
        assert_allclose(both.force_radiation[:, i], alone.force_radiation[:, 0], rtol=1e-9, atol=1)
    assert np.abs(motion(near) - motion(far)).max() > 0.1


@pytest.mark.slow
def test_two_barges_in_contact_move_as_each_alone(figure) -> None:
    """The step is cut at the events of both, so that they differ from one alone by the error of the
    integration, which halving the step measures; at one place they are the same to the last bit."""
    scene = in_contact(duration=60.0)
    alone, finer = motion(hs.simulate(scene)), motion(hs.simulate(in_contact(60.0, step=0.05)))
    both = hs.simulate(side_by_side(scene, one=(0.0, 0.0), other=FAR))
    twins = hs.simulate(side_by_side(scene, one=(0.0, 0.0), other=(0.0, 0.0)))
    difference = np.abs(motion(both, 0) - alone).max()
    figure("difference from one barge [m]", difference)
    figure("error of the integration [m]", np.abs(finer - alone).max())
    assert difference <= 2 * np.abs(finer - alone).max()
    assert np.array_equal(motion(twins, 0), motion(twins, 1))
    assert_same_motion(motion(twins, 0)[:, [0, 2, 4]], alone[:, [0, 2, 4]], 1e-9)


def test_a_barge_elsewhere_meets_the_wave_later() -> None:
    """At x, y a regular wave in deep water has the phase -k (x cos b + y sin b), k = w^2 / g."""
    period, heading = 9.0, np.radians(30.0)
    lag = (2 * pi / period) ** 2 / 9.81 * (FAR[0] * np.cos(heading) + FAR[1] * np.sin(heading))
    scene = replace(scene_of("free_floating"), duration=100.0)

    def run(location: tuple[float, float], phase: float) -> np.ndarray:
        wave = hs.WaveTrain(hs.RegularWave(1.0, period, phase), heading=heading, ramp=20.0)
        return motion(hs.simulate(with_body(in_waves(scene, wave), location=location)))

    assert_same_motion(run(FAR, 0.0), run((0.0, 0.0), -lag), 1e-9)


BLOCK = hs.Body("block", mass=4.0, inertia=np.diag([2.0, 6.0, 5.0]))
SPRING = np.array([9.0, 4.0, 16.0, 5.0, 8.0, 3.0])
RATIO = np.array([0.0, 0.05, 0.02, 0.1, 0.0, 0.03])
OFFSET = np.array([1.0, -0.5, 0.3, 0.2, -0.1, 0.15])
SPEED = np.array([0.2, 0.1, -0.3, 0.1, 0.2, -0.1])


def oscillation(time: np.ndarray) -> np.ndarray:
    """Closed form (nt, 6) of six damped oscillators that start from OFFSET with SPEED."""
    w = np.sqrt(SPRING / np.array([4.0, 4.0, 4.0, 2.0, 6.0, 5.0]))
    damped, decay = w * np.sqrt(1 - RATIO**2), RATIO * w
    t = time[:, None]
    turning = OFFSET * np.cos(damped * t) + (SPEED + decay * OFFSET) / damped * np.sin(damped * t)
    return np.exp(-decay * t) * turning


def on_springs(dofs: tuple[str, ...], kinematics: Kinematics) -> xr.Dataset:
    """A dry block on a spring and damper in each of its free degrees of freedom."""
    free = np.array([dof in dofs for dof in DOFS])
    block = replace(BLOCK, dofs=dofs, position=tuple(OFFSET * free), velocity=tuple(SPEED * free))
    spring = hs.LinearMooring("block", stiffness=np.diag(SPRING), damping_ratio=RATIO)
    solver = hs.Solver(step=0.02, kinematics=kinematics)
    swinging = hs.Scene("block", 20.0, (block,), forces={"spring": spring}, solver=solver)
    return hs.simulate(swinging.with_output(step=0.1))


# RK4's error over 20 s at w = 2 rad/s: t w (w h)^4 / 120 = 9e-7 of the amplitude.
RK4_ERROR = 2e-6


def test_a_dry_body_on_springs_swings_as_its_closed_form(figure) -> None:
    """Small angles, all six at once."""
    run = on_springs(DOFS, Kinematics.LINEAR)
    error = np.abs(motion(run) - oscillation(run.time.values)).max()
    figure("largest error of a motion of about 1", error)
    assert error < RK4_ERROR


@pytest.mark.parametrize("dof", DOFS)
def test_a_dry_body_in_one_freedom_swings_as_its_closed_form(dof: str) -> None:
    """Exact kinematics: about one axis the angle's rate is the angular velocity."""
    run, i = on_springs((dof,), Kinematics.EXACT), DOFS.index(dof)
    error = motion(run)[:, i] - oscillation(run.time.values)[:, i]
    assert np.abs(error).max() < RK4_ERROR
    assert not np.delete(motion(run), i, axis=1).any()


CENTRE = np.array([[0.0, 0.0, 7.5]])
PAIR = np.array([[20.0, 0.0, 7.5], [-20.0, 0.0, 7.5]])
FOUR = np.array([[20.0, 20.0, 7.5], [20.0, -20.0, 7.5], [-20.0, 20.0, 7.5], [-20.0, -20.0, 7.5]])
AROUND = 2 * pi * np.arange(7) / 7
SEVEN = np.column_stack([20 * np.cos(AROUND), 20 * np.sin(AROUND), np.full(7, 7.5)])


@pytest.mark.parametrize("points", [CENTRE, FOUR, SEVEN], ids=["one", "four", "seven"])
def test_any_number_of_fenders(points: np.ndarray, figure) -> None:
    """They stick and slip, the ledger closes, the normal forces add up to what the barge feels."""
    run = hs.simulate(in_contact(duration=200.0, points=points))
    figure(f"energy residual with {len(points)} fenders", run.attrs["energy_residual_relative"])
    assert run.sizes["fender"] == len(points)
    assert run.attrs["energy_residual_relative"] <= 1e-3
    assert {STICK, SLIP} <= set(np.unique(run.fender_mode))
    pressed = run.fender_normal_force.sum("fender")
    assert_allclose(run.force_interface.sel(body="barge", dof="heave"), -pressed, rtol=1e-12)


@pytest.mark.parametrize("points", [PAIR, np.repeat(FOUR, 2, axis=0)], ids=["merged", "doubled"])
def test_fenders_that_share_a_total_differently(points: np.ndarray) -> None:
    """In head waves a pair abreast is one between, and two at one place one there, to rounding."""
    four, other = (hs.simulate(in_contact(60.0, points=p)) for p in (FOUR, points))
    assert np.abs(motion(other) - motion(four)).max() < 1e-9
    totals = [run.fender_normal_force.sum("fender").values for run in (other, four)]
    assert np.abs(totals[0] - totals[1]).max() < 1e-9 * totals[1].max()


def test_locked_freedoms_leave_the_state() -> None:
    """In waves along the barge sway, roll and yaw are not missed, also in contact."""
    free = in_contact(duration=60.0)
    planar = with_body(free, dofs=("surge", "heave", "pitch"))
    assert hs.compile_scene(planar).model.size < hs.compile_scene(free).model.size - 6
    run, whole = hs.simulate(planar), hs.simulate(free)
    assert not run.position.sel(dof=["sway", "roll", "yaw"]).any()
    assert_same_motion(motion(run), motion(whole), 1e-9)
    assert_allclose(run.fender_normal_force, whole.fender_normal_force, atol=1.0)


def test_what_cannot_move_is_not_fitted(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Heave alone for heave; a hull across the earth's axes radiates in sway, free in surge."""
    fitted: list[list[int]] = []
    real = fits.fit_group

    def noted(memory: Retardation, dofs: np.ndarray, band: float, tolerance: float) -> StateSpace:
        fitted.append([int(dof) for dof in dofs])
        return real(memory, dofs, band, tolerance)

    monkeypatch.setattr(fits, "fit_group", noted)
    monkeypatch.setattr(kept, "_version", lambda: str(tmp_path))  # as if never fitted

    def groups(**changes: Any) -> list[list[int]]:
        still = with_body(replace(scene_of("free_floating"), forces={}, duration=1.0), **changes)
        states = hs.compile_scene(replace(still, environment=hs.Environment())).model.states
        return [sorted({*states.dof[a:b].tolist()}) for a, b in pairwise(states.member)]

    assert groups(dofs=("heave",)) == [[2]]
    assert fitted == [[2]]
    assert groups(dofs=("surge",), heading=pi / 4) == [[0], [1]]


def test_a_table_that_is_too_coarse_for_the_database_is_refused() -> None:
    coarse = with_body(scene_of("free_floating"), radiation=ConvolutionRadiation(100.0, 3.0))
    with pytest.raises(InputError, match=r"radiation.step: found 3 s; expected at most 1.26 s"):
        hs.compile_scene(coarse)
