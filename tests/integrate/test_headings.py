"""Hydrodynamics turn with the heading of each body: conservation laws of Kirchhoff's equations, and
scenes turned as a whole, whose motions must turn with them."""

import warnings
from dataclasses import replace
from functools import lru_cache
from math import cos, pi, radians, sin
from random import Random
from typing import Any

import numpy as np
import pytest
import scenes
import xarray as xr
from markers import few
from numpy.testing import assert_allclose

import hydrosim as hs
from hydrosim.compile.compile import compile_scene
from hydrosim.database import HydroDatabase, load
from hydrosim.dofs import DOFS, about_z
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import (
    ConvolutionRadiation,
    LinearScenes,
    Symmetry,
)

random = Random(20)
SOLVER = hs.Solver(step=0.1, linear=LinearScenes.STEP, symmetry=Symmetry.IGNORE)
PLANAR = ("surge", "sway", "yaw")
LAUNCH = scenes.moving(surge=2.0, sway=0.5, yaw=0.05)  # turns about itself once and a half in 200 s
TUMBLE = scenes.moving(surge=2.0, sway=0.5, heave=0.3, roll=0.01, pitch=0.005, yaw=0.05)


def barge(**changes: Any) -> hs.Scene:
    """The free H-851 in calm water, stepped with all that it could leave out."""
    base = scenes.with_body(scenes.scene_of("base"), **changes)
    return replace(base, duration=200.0, environment=hs.Environment(), forces={}, solver=SOLVER)


def turn(yaw: float) -> np.ndarray:
    """Rz(yaw) of translations and rotations (6, 6)."""
    return np.kron(np.eye(2), about_z(yaw))


def rotation(angles: np.ndarray) -> np.ndarray:
    """R of roll, pitch, yaw."""
    roll, pitch = angles[:2]
    about_x = [[1, 0, 0], [0, cos(roll), -sin(roll)], [0, sin(roll), cos(roll)]]
    about_y = [[cos(pitch), 0, sin(pitch)], [0, 1, 0], [-sin(pitch), 0, cos(pitch)]]
    return turn(angles[2])[:3, :3] @ np.array(about_y) @ np.array(about_x)


def impulses(scene: hs.Scene, run: xr.Dataset) -> np.ndarray:
    """Of body and water: impulse in x and y, and about the earth's z axis, (nt, 3)."""
    model = compile_scene(scene).model
    mass, inertia = model.bodies.each[0]["mass"], model.bodies.each[0]["inertia"]
    found = []
    for q, v in zip(scenes.motion(run), run.velocity.values[:, 0], strict=True):
        P, R = turn(q[5]), rotation(q[3:])
        water = P @ model.added_mass @ P.T @ v
        linear = mass * v[:3] + water[:3]
        spin = R @ inertia @ R.T @ v[3:] + water[3:] + np.cross(q[:3], linear)
        found.append([*linear[:2], spin[2]])
    return np.array(found)


@pytest.mark.parametrize(("dofs", "launch"), [(PLANAR, LAUNCH), (DOFS, TUMBLE)])
def test_a_spinning_drifting_body_keeps_impulse_and_energy(dofs, launch):
    """Without memory nothing is lost; rk4 at 0.05 s leaves 1e-11, of the energy 1e-9."""
    scene = barge(dofs=dofs, velocity=launch, radiation="none")
    scene = replace(scene, solver=replace(SOLVER, step=0.05))
    run = hs.simulate(scene)
    kept = impulses(scene, run)
    assert np.ptp(scenes.motion(run)[:, 5]) > 2.0 * pi
    assert_allclose(kept, np.broadcast_to(kept[0], kept.shape), rtol=0, atol=1e-10 * kept.max())
    assert run.energy_residual_relative < (1e-10 if dofs == PLANAR else 1e-8)


@pytest.mark.parametrize("radiation", ["state_space", "convolution"])
@pytest.mark.parametrize("dofs", [PLANAR, DOFS])
def test_with_memory_it_never_gains_energy(radiation: str, dofs: tuple[str, ...]) -> None:
    """What radiation took is never negative: memory is passive in axes that turn, too."""
    scene = barge(dofs=dofs, velocity=TUMBLE, radiation=radiation)
    scene = replace(scene, bodies=(replace(scene.bodies[0], dofs=dofs),))
    run = hs.simulate(scene)
    lost = run.energy_dissipated_radiation.values
    assert lost.min() >= 0.0
    assert lost[-1] > 0.2 * run.energy_kinetic.values[0]
    assert run.energy_residual_relative < 1e-6


@pytest.mark.parametrize("radiation", ["state_space", "convolution"])
def test_a_roll_decay_does_not_know_the_heading(radiation: str) -> None:
    """At any yaw the same roll, to rounding."""
    runs = []
    for yaw in (0.0, 1.0, 2.0, 5.0, 10.0, 45.0, 90.0):
        start = scenes.moving(roll=radians(2.0), yaw=radians(yaw))
        body = barge(position=start, radiation=radiation)
        runs.append(hs.simulate(replace(body, duration=60.0)))
    roll = [scenes.motion(run)[:, 3] for run in runs]
    for other in roll[1:]:
        assert_allclose(other, roll[0], rtol=0, atol=1e-12)


def test_a_current_carries_the_water_along() -> None:
    """In a current, without memory, a spinning body moves as in still water but for U t."""
    U = np.array([1.1, -0.7, 0.0, 0.0, 0.0, 0.0])
    changes = {"radiation": "none", "position": scenes.moving(yaw=0.4)}
    still = hs.simulate(barge(velocity=TUMBLE, **changes))
    scene = barge(velocity=tuple(TUMBLE + U), **changes)
    carried = hs.simulate(replace(scene, environment=hs.Environment(current=scenes.stream_of(U))))
    drift = U * carried.time.values[:, None]
    assert_allclose(scenes.motion(carried) - drift, scenes.motion(still), rtol=0, atol=1e-9)
    assert carried.energy_residual_relative < 1e-6


@pytest.mark.parametrize("radiation", ["state_space", "convolution"])
def test_munks_moment_and_no_memory_of_a_steady_stream(radiation, validated):
    """u w (A_sway - A_surge) on yaw, and nothing else begins to act after the start."""
    U = np.array([1.1, -0.7, 0.0, 0.0, 0.0, 0.0])
    place = scenes.moving(yaw=0.4)
    scene = barge(position=place, radiation=radiation, dofs=("yaw",))
    scene = replace(scene, environment=hs.Environment(current=scenes.stream_of(U)), duration=1.0)
    scene = scene.with_output(step=0.1)  # soon, before a memory of the spin is felt
    run, model = hs.simulate(scene), compile_scene(scene).model
    along, aside = (about_z(0.4).T @ -U[:3])[:2]
    A, inertia = model.added_mass, model.bodies.each[0]["inertia"][2, 2]
    w = np.array([along, aside, 0.0, 0.0, 0.0, 0.0])
    momentum = A @ w
    moment = -(along * momentum[1] - aside * momentum[0])
    assert_allclose(run.force_radiation.values[0, 0], 0.0, atol=1e-6)
    spin = run.velocity.values[:, 0, 5]
    error = abs(spin[1] / run.time.values[1] / (moment / (inertia + A[5, 5])) - 1.0)
    features = (Feature.CURRENT, Feature.RADIATION)
    claim = "moment of a current on a barge that is turned"
    validated(Kind.CLOSED_FORM, claim, "Munk's moment", error, 1e-3, *features)


def turned_back(run: xr.Dataset, by: float) -> np.ndarray:
    """Positions (nt, nb, 6) of a run of the turned scene in the axes before."""
    q = run.position.values.copy()
    q[..., :3] = q[..., :3] @ turn(by)[:3, :3]
    return q


def assert_turns(scene: hs.Scene, by: float, within: float) -> None:
    """Motions of the turned scene are the turned motions, to ``within`` of each one's range."""
    before, after = hs.simulate(scene), hs.simulate(scenes.turned_scene(scene, by))
    assert before.status == after.status == "complete"
    q, found = before.position.values, turned_back(after, by)
    size = np.ptp(q, axis=0).reshape(-1, 2, 3).max(axis=2).repeat(3, axis=1).reshape(q.shape[1:])
    assert size.min() > 1e-3
    assert np.abs((found - q) / size).max() < within


@pytest.mark.parametrize("by", few([17.0, 90.0, 123.0], 1))
def test_the_base_case_in_an_oblique_sea_turns(by: float) -> None:
    """Waves of both orders, mooring, lift and contact with friction; 40 s with the lift at once."""
    scene = scenes.in_waves(
        scenes.in_contact(40.0), hs.WaveTrain(scenes.SEA, heading=radians(30.0), ramp=20.0)
    )
    mooring = scene.forces["mooring"]
    damping = np.diag([3e5, 3e5, 0.0, 0.0, 0.0, 1e9])
    moored = replace(mooring, stiffness=mooring.stiffness, damping=damping, damping_ratio=None)
    scene = replace(scene, forces={**scene.forces, "mooring": moored})
    assert_turns(scene, radians(by), 1e-9)


@pytest.mark.parametrize("by", few([random.uniform(0.0, 360.0) for _ in range(6)], 2))
def test_ratios_of_critical_damping_and_natural_periods_turn(by: float) -> None:
    """Ratios and periods that differ along surge and sway, where added mass differs too."""
    scene = scenes.in_waves(
        scenes.in_contact(40.0), hs.WaveTrain(scenes.SEA, heading=radians(30.0), ramp=20.0)
    )
    stiffness = np.diag([4e5, 2e5, 0.0, 0.0, 0.0, 1e9])
    stiffness[0, 1] = stiffness[1, 0] = 1e5
    lines, periods, viscous = (
        np.array(scenes.moving(**ratios))
        for ratios in (
            {"surge": 0.2, "sway": 0.4, "yaw": 0.1},
            {"surge": 0.1, "sway": 0.3},
            {"surge": 0.3, "sway": 0.1, "roll": 0.05},
        )
    )
    natural = {"natural_period": np.array(scenes.moving(surge=80.0, sway=120.0))}
    forces = {
        "lines": hs.LinearMooring("barge", stiffness, damping_ratio=lines),
        "periods": hs.LinearMooring("barge", np.zeros((6, 6)), damping_ratio=periods, **natural),
        "viscous": hs.LinearDamping("barge", damping_ratio=viscous),
    }
    rest = {name: e for name, e in scene.forces.items() if name not in ("mooring", "interface")}
    assert_turns(replace(scene, forces={**rest, **forces}), radians(by), 1e-9)


@pytest.mark.parametrize("by", [17.0, 90.0, 123.0])
def test_coupled_bodies_in_a_stream_turn(by: float) -> None:
    """Two barges with cross radiation between them, that spin, a spring to the earth and one from
    one to the other, current and wind on both, a fender between them, waves of first order. The
    current turns over the depth, and differs between the hulls; the wind has gusts."""
    assert_turns(alongside(), radians(by), 1e-9)


def alongside() -> hs.Scene:
    """The two barges of the shipped database, apart in heading as they spin."""
    base = barge().bodies[0]
    mass, inertia = 1.23e6, np.diag(1.23e6 * np.square([3.5, 10.4, 10.4]))
    launch = scenes.moving(surge=0.3, sway=-0.1, heave=0.2, roll=0.02, pitch=0.01, yaw=0.01)
    base = replace(base, hydrodynamics=barges(), mass=mass, inertia=inertia, velocity=launch)
    memory = ConvolutionRadiation(length=30.0)
    base = replace(base, radiation=memory, wave_forces=hs.WaveForces())
    port, starboard = (
        replace(base, name=name, database_body=k, centre_of_gravity=(0.0, y, 0.0), draught=T)
        for name, k, y, T in (("port", 1, 7.0, 3.0), ("starboard", 2, -7.0, 6.0))
    )
    still = replace(starboard, velocity=scenes.moving(surge=-0.2, yaw=-0.01))
    rope = hs.TensionCurve((0.0, 1.0, 3.0), (0.0, 5e4, 4e5))
    loads = {"headings": np.radians([0.0, 90.0, 180.0, 270.0]), "yaw": np.zeros(4)}
    drag = {"surge": np.array([2e3, 0, -2e3, 0]), "sway": np.array([0, 9e3, 0, -9e3]), **loads}
    friction = hs.StickSlip(0.3, 0.2, 2e6, 1e5, 1e4)
    curve = scenes.straight_curve(2e6, 1e4)
    points = np.array([[15.0, -5.0, 1.0], [-15.0, -5.0, 1.0]])
    return hs.Scene(
        title="two barges that spin",
        duration=30.0,
        bodies=(port, still),
        forces={
            "bow": hs.Spring("port", (20.0, 0.0, 1.0), (60.0, 9.0, 1.0), 39.5, curve=rope),
            "breast": hs.Spring(
                "port", (0.0, -5.0, 1.0), (0.0, 5.0, 1.0), 3.8, anchor_body="starboard", curve=rope
            ),
            "side": hs.Fender(
                "port", points, hs.Plane((0.0, 5.0, 0.0), (0, 1, 0), "starboard"), curve, friction
            ),
            "stream": hs.CurrentLoad("starboard", point=(2.0, 0.0, -1.0), **drag),
            "wind": hs.WindLoad("port", point=(1.0, 0.0, 6.0), **drag),
        },
        environment=hs.Environment(
            waves=(hs.WaveTrain(hs.RegularWave(0.4, 6.0), heading=0.5),),
            current=hs.Current(
                profile=hs.CurrentTable((0.0, 3.0, 9.0), (0.8, 0.56, 0.16), (1.1, 1.5, 2.1))
            ),
            wind=hs.Wind(9.0, -2.0, profile="npd", gusts=hs.Gusts("npd", repeat_period=60.0)),
        ),
        solver=replace(SOLVER, step=0.05),
    )


@lru_cache
def barges() -> HydroDatabase:
    """The shipped database of two; what it is warned of does not matter here."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return load(scenes.ROOT / "hydro_db" / "two_barges.nc")
