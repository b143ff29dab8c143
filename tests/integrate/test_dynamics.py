"""Whole runs of the H-851: energy, lift fixed to the body or the earth, memory of the waves."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scenes import SEA, central_force, hull, in_contact, in_waves, motion, scene_of
from scipy.interpolate import CubicSpline

import hydrosim as hs
from hydrosim.elements import AppliedForce, Table
from hydrosim.integrate.methods import ESDIRK4
from hydrosim.integrate.state import new_scratch
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import LinearScenes, Method, Solver, WaveTrain

LIFT = 119.9e6  # N, when the deck is just below the topside
MOORING = 392.4e3  # N/m
SURGE, HEAVE, PITCH = 0, 2, 4


def test_energy_of_the_base_case(base_run: xr.Dataset, validated) -> None:
    """2000 s at 0.1 s: the residual is what the integration makes of 1000 contact events."""
    residual = base_run.attrs["energy_residual_relative"]
    assert base_run.attrs["solver_events"] > 100
    claim = "base case, energy that its integration loses, of what is exchanged"
    features = (Feature.STEPS, Feature.FENDERS, Feature.STICK_SLIP, Feature.RADIATION)
    validated(Kind.CLOSED_FORM, claim, "0", residual, 1e-3, *features)


def test_energy_residual_has_the_order_of_the_method(figure) -> None:
    """RK4 keeps order 4 as steps are cut at events; steps that run past them lose it."""
    steps = (0.05, 0.025, 0.0125)
    runs = [hs.simulate(in_contact(duration=60.0, step=step)) for step in steps]
    residual = np.array([np.abs(run.energy_residual).max() for run in runs])
    order = np.log2(residual[:-1] / residual[1:])
    for step, value in zip(steps, residual, strict=True):
        figure(f"energy residual at a step of {step:g} s [J]", value)
    figure("observed order", order[-1])
    assert all(run.attrs["solver_events"] > 40 for run in runs)
    assert order[-1] == pytest.approx(4.0, abs=0.3)
    crude = in_contact(duration=60.0, step=steps[-1])
    crude = hs.simulate(replace(crude, solver=replace(crude.solver, events=False)))
    past, cut = (np.abs(motion(run) - motion(runs[1])).max() for run in (crude, runs[2]))
    figure("steps that run past events, error over that of steps cut there", past / cut)
    assert past > 100 * cut


def test_the_last_slope_of_a_step_begins_the_next() -> None:
    """A step of dopri5 has seven stages and costs six evaluations; a rejected one has the slope at
    its start already. At a corner of the lift, between records, the slope is found anew."""
    scene = scene_of("free_floating")
    ramp = Table(np.array([0.0, 7.3, 20.0]), np.array([0.0, 1e6, 0.0]))
    lift = central_force("barge", heave=ramp)
    solver = Solver(method=Method.DOPRI5, step=0.1, linear=LinearScenes.STEP)
    scene = replace(scene, forces={**scene.forces, "lift": lift}, duration=20.0, solver=solver)
    run = hs.simulate(scene.with_output(step=1.0))
    tried = run.attrs["solver_steps"] + run.attrs["solver_rejected"]
    assert run.attrs["solver_evaluations"] == 6 * tried + 1


def test_work_of_the_recorded_forces_is_the_kinetic_energy() -> None:
    """int sum(F) v dt = v (M + A_inf) v / 2, integrated here from forces and velocities alone, to
    the error of a cubic spline through records 0.1 s apart; A_inf is that of the database, which
    Ogilvie's relation changes by less than 1 %."""
    sea = WaveTrain(SEA, heading=np.radians(30.0), ramp=20.0)
    scene = replace(in_waves(scene_of("free_floating"), sea), duration=200.0).with_output(step=0.1)
    run = hs.simulate(scene)
    forces = [run[name] for name in run.data_vars if str(name).startswith("force_")]
    power = (sum(forces) * run.velocity).sum(("body", "dof")).values
    work = CubicSpline(run.time, power).antiderivative()(run.time)
    kinetic = run.energy_kinetic.values
    assert np.abs(work - kinetic).max() < 1e-5 * kinetic.max()

    (body,), v = scene.bodies, run.velocity.values[:, 0]
    inertia = np.zeros((6, 6))
    inertia[:3, :3], inertia[3:, 3:] = body.mass * np.eye(3), body.inertia
    inertia += hull().added_mass_infinite
    expected = np.einsum("ti,ij,tj->t", v, inertia, v) / 2
    assert np.abs(kinetic - expected).max() < 1e-2 * kinetic.max()


def lifted(x: float, body_fixed: bool) -> xr.Dataset:
    """The moored barge in calm water, lifted at x on its centre line, until it has settled."""
    ramp = Table(np.array([0.0, 100.0]), np.array([0.0, LIFT]))
    frame = "body" if body_fixed else "earth"
    lift = AppliedForce("barge", (x, 0.0, 0.0), {"heave": ramp}, frame=frame)
    scene = in_waves(scene_of("free_floating"))
    forces = {**scene.forces, "lift": lift}
    run = hs.simulate(replace(scene, forces=forces, duration=1300.0))
    return run.sel(time=slice(1000.0, None))


def static_pitch(x: float) -> float:
    """C33 z + C35 p = F and C53 z + C55 p = -x F, for small angles."""
    C = hull().hydrostatic_stiffness[np.ix_([HEAVE, PITCH], [HEAVE, PITCH])]
    return float(np.linalg.solve(C, [LIFT, -x * LIFT])[1])


@pytest.mark.parametrize("x", [0.0, 10.0, -10.0])
def test_lift_fixed_to_the_body_pushes_the_barge_along(x: float, figure) -> None:
    """R(p) (0, 0, F) has the component F sin p along x, R = Ry(p): bow down (p > 0) drives the
    barge forward. At the centre of gravity C35 > 0 trims the lifted barge by the stern, p < 0."""
    q = motion(lifted(x, body_fixed=True)).mean(axis=0)
    expected = LIFT * np.sin(q[PITCH]) / MOORING
    figure(f"pitch [rad], lifted at x = {x:g} m", q[PITCH])
    figure("mean surge [m]", q[SURGE])
    figure("over F sin(pitch) / K1, less 1", q[SURGE] / expected - 1)
    assert q[PITCH] == pytest.approx(static_pitch(x), rel=1e-2)
    assert np.sign(q[SURGE]) == (1.0 if x < 0 else -1.0)
    assert q[SURGE] == pytest.approx(expected, rel=2e-2)


@pytest.mark.parametrize("x", [0.0, 10.0])
def test_lift_fixed_to_the_earth_does_not(x: float, figure) -> None:
    """The pitch is the same, and surge comes back to zero as its decay says, exp(-0.0097 t)."""
    q = motion(lifted(x, body_fixed=False)).mean(axis=0)
    figure(f"mean surge [m], lifted at x = {x:g} m", q[SURGE])
    assert q[PITCH] == pytest.approx(static_pitch(x), rel=1e-2)
    assert abs(q[SURGE]) < 1e-5


def test_the_implicit_method_solves_for_radiation_pole_by_pole(figure) -> None:
    """A hundred states of radiation: esdirk4 moves as dopri5, and Jacobians cost little."""
    scene = replace(in_waves(scene_of("free_floating"), WaveTrain(SEA, ramp=20.0)), duration=60.0)
    runs = []
    for method in (Method.ESDIRK4, Method.DOPRI5):
        solver = replace(scene.solver, method=method, linear=LinearScenes.STEP)
        runs.append(hs.simulate(replace(scene, solver=solver)))
    apart = np.abs(motion(runs[0]) - motion(runs[1])).max() / np.ptp(motion(runs[1]))
    figure("esdirk4 beside dopri5, over the range", apart)
    assert apart < 1e-4
    model = hs.compile_scene(scene).model
    newton = new_scratch(model, ESDIRK4, 0.1).newton
    assert newton.states.size == 2 * model.bodies.active.size
    assert 2 * newton.filters.one.size > newton.states.size
