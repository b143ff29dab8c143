"""Barges on a vertical hinge that drift and turn with memory: they never gain energy.

From rest the memory can only take energy: what it gives back is less than it took, whatever the
motion is. So kinetic energy with A_inf and stored energy together never exceed those at the start.
Kinetic energy is by hand from the record, in the axes that turn with each hull.
"""

from dataclasses import replace
from functools import cache
from math import radians
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from jointed import FRAME, completed, joint, moved, scene
from scenes import Acting, joint_of, turned_scene
from scipy.spatial.transform import Rotation
from turning import points, turned_back

import hydrosim as hs
from hydrosim.compile.compile import compile_scene
from hydrosim.dofs import about_z
from hydrosim.scene import ConvolutionRadiation, Method, Radiation, Symmetry

DATABASES = Path(__file__).parents[3] / "hydro_db"
LAUNCH = (1.0, -0.5, 0.1, 0.02, 0.01, 0.03)
FOLDING = Acting(velocity=-0.05)
PAIRS = {  # database, length, mass, radii, whether the database has both
    "coupled": ("hinged_barges.nc", 22.0, 1230e3, (3.5, 10.4, 10.4), True),
    "apart": ("box.nc", 52.0, 10250e3, (7.0, 26.0, 26.0), False),
}


def drifting(pair: str, radiation: str) -> hs.Scene:
    """Two equal barges of a pair, hinged about the vertical between them, launched."""
    file, arm, mass, radii, both = PAIRS[pair]
    inertia = mass * np.diag(np.square(radii))
    own = {"hydrodynamics": DATABASES / file, "radiation": radiation}
    bodies = []
    for name, x, number in (("fore", arm, 1), ("aft", -arm, 2)):
        apart = {"centre_of_gravity": (x, 0.0, 0.0), "database_body": number}
        at = apart if both else {"location": (x, 0.0)}
        bodies.append(hs.Body(name, mass, inertia, **at, **own))
    fore, aft = bodies
    hinge = joint_of("hinge", "fore", "aft", FOLDING, point=(-arm, 0.0, 0.0))
    bodies, solver = (fore, replace(aft, velocity=LAUNCH)), hs.Solver(Method.RK4, 0.05)
    water, solver = hs.Environment(water_density=1025.0), replace(solver, symmetry=Symmetry.IGNORE)
    whole = hs.Scene("drifting pair", 60.0, bodies, water, joints={"hinge": hinge}, solver=solver)
    return whole.with_output(step=0.5)


def energy_of(scene: hs.Scene, run: xr.Dataset) -> np.ndarray:
    """Kinetic energy with A_inf, and what is stored, (nt,)."""
    compiled = compile_scene(scene)
    added = np.zeros((12, 12))
    for group in compiled.wet:
        added[np.ix_(group.dofs, group.dofs)] = group.added_mass
    velocity = run.velocity.values.reshape(-1, 12)
    attitude = run.position.values[:, :, 3:]
    aft = attitude[:, 1, 2]
    headings = np.stack([aft + run.joint_position.values[:, 0], aft], axis=1)
    kinetic = np.zeros(run.time.size)
    for k, v in enumerate(velocity):
        turns = np.zeros((12, 12))
        for b, body in enumerate(scene.bodies):
            R = Rotation.from_euler("ZYX", attitude[k, b, ::-1]).as_matrix()
            angular = v[6 * b + 3 : 6 * b + 6]
            kinetic[k] += 0.5 * body.mass * v[6 * b : 6 * b + 3] @ v[6 * b : 6 * b + 3]
            kinetic[k] += 0.5 * angular @ R @ body.inertia @ R.T @ angular
            turns[6 * b :, 6 * b :][:6, :6] = np.kron(np.eye(2), about_z(headings[k, b]))
        w = turns.T @ v
        kinetic[k] += 0.5 * w @ added @ w
    return kinetic + run.energy_stored_hydrostatic.values


@pytest.mark.parametrize("radiation", ["state_space", "convolution"])
@pytest.mark.parametrize("pair", PAIRS)
def test_memory_never_gives_energy(pair, radiation, figure) -> None:
    scene = drifting(pair, radiation)
    run = hs.simulate(scene)
    energy = energy_of(scene, run)
    turned = np.degrees(np.abs(run.joint_position.values).max())
    figure("largest energy after the start", energy[1:].max() / energy[0])
    figure("energy left", energy[-1] / energy[0])
    figure("largest angle of the hinge [deg]", turned)
    assert turned > 90.0
    assert ("waves between them" in run.attrs.get("warnings", "")) == (pair == "coupled")
    assert energy.max() <= energy[0] * (1.0 + 1e-9)
    assert energy[-1] < 0.97 * energy[0]
    lost = run.energy_dissipated_radiation.values
    assert lost.min() >= -1e-9 * energy[0]
    np.testing.assert_allclose(energy + lost, energy[0], rtol=1e-6)


# Two barges on a vertical hinge that drift and turn, with the memory of the waves they radiate.

BOX = Path(__file__).parents[3] / "hydro_db" / "box.nc"  # 100 m by 20 m, 5 m deep
MASS, RADII = 1.025e7, (7.0, 26.0, 26.0)
APART = 104.0  # m between centres
PAIR_LAUNCH = (1.5, 0.6, 0.2, 0.01, 0.005, 0.04)
MEMORIES: dict[str, str | Radiation] = {
    "states": "state_space",
    "convolution": ConvolutionRadiation(length=40.0),
}
CURRENT = hs.Stream(0.8, 1.1)


PIN = (APART / 2, 0.0, 0.0)
ENDS = ("aft", "fore")
AXES = {"axis": (0, 0, 1), "second_axis": (0, 1, 0)}
JOINTS = {
    "hinge": joint("hinge", *ENDS, moved(0.2, -0.09), point=PIN, axis=(0, 0, 1)),
    "ball": joint("ball", *ENDS, moved(), moved(), moved(0.2, -0.09), point=PIN),
    "universal": joint("universal", *ENDS, moved(0.2, -0.09), moved(), point=PIN, **AXES),
}


def barges(memory: str, current: hs.Stream = CURRENT, held: str = "hinge") -> hs.Scene:
    """Two barges end to end; each makes waves by itself."""
    points = {"centre": FRAME["centre"], "bow": (50.0, 0.0, 0.0), "mast": (0.0, 0.0, 20.0)}
    hull = ("fore", MASS, MASS * np.diag(np.square(RADII)), BOX)
    fore = hs.Body(*hull, radiation=MEMORIES[memory], velocity=PAIR_LAUNCH, points=points)
    aft = replace(fore, name="aft", location=(-APART, 0.0), velocity=(0.0,) * 6)
    pin = {"pin": JOINTS[held]}
    found = scene([fore, aft], pin, 60.0, output_step=0.5, method=Method.RK4, step=0.1)
    solver = replace(found.solver, symmetry=Symmetry.IGNORE)
    return replace(found, environment=hs.Environment(current=current), solver=solver)


@cache
def the_run(memory: str) -> xr.Dataset:
    """The run in a current."""
    return completed(barges(memory))


@pytest.mark.parametrize("memory", list(MEMORIES))
@pytest.mark.parametrize("held", list(JOINTS))
def test_with_memory_a_pair_never_gains_energy(held: str, memory: str, figure) -> None:
    """In still water: the waves have taken energy at any time, though the pair folds and turns."""
    run = completed(barges(memory, hs.Stream(), held))
    lost = run.energy_dissipated_radiation.values
    figure("lost", lost[-1] / run.energy_kinetic.values[0])
    assert np.ptp(run.joint_position.values, axis=0).max() > 1.0
    assert lost.min() >= 0.0
    assert lost[-1] > 0.1 * run.energy_kinetic.values[0]
    assert run.attrs["energy_residual_relative"] < 1e-6


@pytest.mark.parametrize("memory", list(MEMORIES))
def test_a_pair_with_memory_turns_with_the_scene(memory: str, figure) -> None:
    by, shift = radians(37.0), (30.0, -20.0)
    whole = barges(memory)
    found = turned_back(points(completed(turned_scene(whole, by, shift)), whole), by, shift)
    exact = points(the_run(memory), whole)
    error = np.abs(found - exact).max() / np.ptp(exact, axis=0).max()
    figure("error", error)
    assert error <= 1e-9
