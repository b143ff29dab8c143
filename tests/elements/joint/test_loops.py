"""Loops of joints: linkages of free bodies against minimal coordinates."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from jointed import moved, places, rotations
from linkages import GRAVITY, IN_PLANE, TILTED, FourBar, Rates, SliderCrank, across, at
from scenes import with_motions
from scipy.spatial.transform import Rotation

import hydrosim as hs
from hydrosim.compile.compile import compile_scene
from hydrosim.errors import InputError, SimulationError
from hydrosim.scene import Body, Method, Scene, Tolerance
from hydrosim.scene.scene import (
    arrange_joints,
    arrangement,
    floating_roots,
    is_anchored,
    joined_with,
)

LINKAGES = [FourBar(), SliderCrank()]
ANGLE, SPEED, END = 1.0, 2.0, 1.6
TIMES = np.arange(0.2, 1.7, 0.2)


def crank(run: xr.Dataset, turn: Rotation) -> np.ndarray:
    """Place (nt, 2) of the crank's centre of gravity in its plane."""
    return np.asarray(turn.inv().apply(places(run, "crank"))[:, :2])


def gaps(scene: Scene, run: xr.Dataset) -> np.ndarray:
    """Ways between the points of all joints, and between their axes, at all output times."""
    rest = {body.name: np.array(body.centre_of_gravity) for body in scene.bodies}
    found = []
    for joint in scene.joints.values():
        R = rotations(run, joint.body)
        here = places(run, joint.body) + R @ np.array(joint.point)
        axis = R @ np.array(joint.axis)
        there = rest[joint.body] + np.array(joint.point)
        other = np.array(joint.axis)
        if joint.to is not None:
            R = rotations(run, joint.to)
            there = places(run, joint.to) + R @ (there - rest[joint.to])
            other = R @ other
        d = here - there
        if joint.type == "slider":
            d = np.cross(d, joint.axis)
        found += [np.abs(d).max(), np.abs(np.cross(axis, other)).max()]
    return np.array(found)


@pytest.mark.parametrize("turn", [IN_PLANE, TILTED], ids=["level", "tilted"])
@pytest.mark.parametrize("linkage", LINKAGES, ids=["four-bar", "slider-crank"])
def test_a_linkage_against_minimal_coordinates(linkage: FourBar, turn: Rotation) -> None:
    """The fourth order of rk4 in the angle of the crank; loops to 1e-12; energy kept."""
    angles = linkage.angles(ANGLE, SPEED, TIMES)
    wanted = np.array([np.cos(angles), np.sin(angles)]).T / 2.0
    errors = []
    for step in (0.02, 0.01, 0.005):
        scene = linkage.scene(ANGLE, SPEED, END, step, turn)
        run = hs.simulate(scene)
        found = crank(run.sel(time=TIMES, method="nearest"), turn)
        errors.append(np.abs(found - wanted).max())
        assert gaps(scene, run).max() < 1e-12
    assert errors[-1] < 2e-7
    assert np.log2(errors[0] / errors[2]) / 2.0 > 3.8
    moved = run.energy_kinetic.max()
    assert np.abs(run.energy_residual).max() < 1e-6 * moved


def test_an_adaptive_method_reaches_the_angle_of_minimal_coordinates() -> None:
    linkage = FourBar()
    (angle,) = linkage.angles(ANGLE, SPEED, np.array([END]))
    scene = linkage.scene(ANGLE, SPEED, END, 0.02, TILTED)
    tolerance = Tolerance(1e-11, 1e-12, 1e-12)
    solver = replace(scene.solver, method=Method.DOPRI5, tolerance=tolerance)
    run = hs.simulate(replace(scene, solver=solver))
    wanted = np.array([np.cos(angle), np.sin(angle)]) / 2.0
    assert np.abs(crank(run, TILTED)[-1] - wanted).max() < 1e-9
    assert gaps(scene, run).max() < 1e-12


@pytest.mark.parametrize("method", [Method.ESDIRK4, Method.HEUN, Method.RK2])
def test_other_methods_keep_loops_closed(method: Method) -> None:
    """Implicit and of second order: the loop to 1e-12, and the angle within their errors."""
    linkage = SliderCrank()
    angles = linkage.angles(ANGLE, SPEED, TIMES)
    wanted = np.array([np.cos(angles), np.sin(angles)]).T / 2.0
    scene = linkage.scene(ANGLE, SPEED, END, 0.002, TILTED)
    run = hs.simulate(replace(scene, solver=replace(scene.solver, method=method)))
    assert gaps(scene, run).max() < 1e-12
    found = crank(run.sel(time=TIMES, method="nearest"), TILTED)
    assert np.abs(found - wanted).max() < 2e-4


def test_the_load_of_a_joint_is_newtons_of_what_is_behind_it() -> None:
    """Rocker alone: m (a - g) = forces of its two hinges, one of the tree and one of the loop."""
    linkage = FourBar()
    scene = linkage.scene(ANGLE, SPEED, 0.4, 0.01, IN_PLANE).with_output(accelerations=True)
    run = hs.simulate(scene)
    force = run.joint_force.values
    names = [*run.joint.values]
    a = run.acceleration.values[:, 2, :3]
    weight = np.array([0.0, -GRAVITY * linkage.masses[2], 0.0])
    # `c` acts on the coupler, so its opposite on the rocker
    found = force[:, names.index("d"), :3] - force[:, names.index("c"), :3] + weight
    assert np.abs(found - linkage.masses[2] * a).max() < 1e-10 * np.abs(force).max()
    assert np.abs(force[:, :, 5]).max() < 1e-9 * np.abs(force).max()  # hinges turn freely
    loop = run.force_joints.sel(body="rocker").values[:, :3]
    assert np.abs(loop + force[:, names.index("c"), :3]).max() < 1e-12 * np.abs(force).max()


def test_redundant_constraints_are_dropped_and_named() -> None:
    """The tree's hinges leave turns in the plane: the loop holds five motions, two freely."""
    scene = FourBar().scene(ANGLE, SPEED, 0.1, 0.01, IN_PLANE)
    compiled = compile_scene(scene)
    told = [text for text in compiled.notes.warnings if "constraints" in text]
    assert len(told) == 1
    assert told[0].startswith("joints.c: other joints or locked directions hold 3 of its 5")
    assert [*hs.simulate(scene).lock_rows.values[-1]] == [2]


def test_a_linkage_continues_to_the_bit() -> None:
    scene = FourBar().scene(ANGLE, SPEED, 1.0, 0.01, TILTED)
    whole = hs.simulate(scene.with_output(states=True))
    rest = replace(scene, duration=0.5, initial=hs.scene.Start(whole, 0.5))
    run = hs.simulate(rest)
    for name in ("position", "velocity", "joint_force"):
        wanted = whole[name].sel(time=run.time.values)
        assert np.array_equal(run[name].values, wanted.values)


class Parallelogram(FourBar):
    """A linkage that comes to lie in a straight line; its coupler does not turn."""

    A, D = np.zeros(2), np.array([2.0, 0.0])
    lengths = (1.0, 2.0, 1.0)

    def corners(self, angle: float) -> tuple[np.ndarray, np.ndarray]:
        B = np.array([np.cos(angle), np.sin(angle)])
        return B, B + self.D

    def rates(self, angle: float, w: float) -> Rates:
        vB = w * across(self.corners(angle)[0])
        return Rates(np.array([vB / 2.0, vB, vB / 2.0]), np.array([w, 0.0, w]))


def test_a_loop_that_becomes_singular_ends_the_run() -> None:
    scene = Parallelogram().scene(0.5, -2.0, 1.0, 0.01, IN_PLANE)
    with pytest.raises(SimulationError) as raised:
        hs.simulate(scene)
    text = str(raised.value)
    assert "four-bar linkage in a straight line" in text
    assert "at t = 0.2" in text
    assert "the joints c come" in text


def test_a_loop_that_is_singular_at_the_start_is_refused() -> None:
    scene = Parallelogram().scene(0.0, 0.0, 1.0, 0.01, IN_PLANE)
    with pytest.raises(InputError, match="do not determine their forces"):
        hs.simulate(scene)


def test_a_loop_that_does_not_close_is_refused_with_its_gap() -> None:
    linkage = FourBar()
    scene = linkage.scene(ANGLE, 0.0, 1.0, 0.01, IN_PLANE)
    off = with_motions(scene.joints["d"], moved(0.1))
    scene = replace(scene, joints={**scene.joints, "d": off})
    with pytest.raises(InputError, match=r"joints.c: does not close .* 0\.3 m and 0 deg"):
        hs.simulate(scene)


def test_velocities_that_joints_do_not_allow_are_refused() -> None:
    linkage = FourBar()
    scene = linkage.scene(ANGLE, SPEED, 1.0, 0.01, IN_PLANE)
    still = with_motions(scene.joints["d"], moved())
    scene = replace(scene, joints={**scene.joints, "d": still})
    with pytest.raises(InputError, match=r"initial velocities part .* m/s"):
        hs.simulate(scene)


def test_joints_that_fight_are_refused() -> None:
    """A second ball holds the block where its slider does not let it begin."""
    linkage = SliderCrank()
    scene = linkage.scene(ANGLE, 0.0, 1.0, 0.01, IN_PLANE)
    bar = linkage.bars(ANGLE)[2]
    second = hs.Ball("block", None, at(bar, bar.a, IN_PLANE))
    off = with_motions(scene.joints["slide"], moved(0.1))
    joints = {**scene.joints, "slide": off, "second": second}
    with pytest.raises(InputError, match=r"does not close at the start: 0\.1 m and 0 deg"):
        hs.simulate(replace(scene, joints=joints))


# Trees of joints: which bodies belong together, and which are anchored, against plain searches.


def random_scene(seed: int, count: int = 12) -> Scene:
    """Bodies with hinges about level or upright axes, to bodies before them or to the earth."""
    rng = np.random.default_rng(seed)
    bodies = tuple(Body(f"b{k}", 1.0, np.eye(3)) for k in range(count))
    joints = {}
    for k in range(count):
        if rng.random() < 0.7:
            to = None if k == 0 or rng.random() < 0.3 else f"b{rng.integers(k)}"
            axis = (0.0, 1.0, 0.0) if rng.random() < 0.7 else (0.0, 0.0, 1.0)
            joints[f"j{k}"] = hs.Hinge(f"b{k}", to, axis=axis)
    return Scene("trees", 1.0, bodies, joints=joints)


def search_connected(scene: Scene, body: str) -> set[str]:
    """Bodies that joints between bodies connect with one, by searching all edges often."""
    found = {body}
    for _ in scene.bodies:
        for joint in scene.joints.values():
            if joint.to is not None and {joint.body, joint.to} & found:
                found |= {joint.body, joint.to}
    return found


def search_anchored(scene: Scene, body: str) -> bool:
    """Whether a path of level axes leads to the earth: each body has one joint towards it."""
    joint = next((each for each in scene.joints.values() if each.body == body), None)
    if joint is None or joint.axis[2] == 1.0:
        return False
    return joint.to is None or search_anchored(scene, joint.to)


@pytest.mark.parametrize("seed", range(20))
def test_trees_are_those_that_a_search_finds(seed: int) -> None:
    scene = random_scene(seed)
    for body in scene.bodies:
        assert joined_with(scene, body.name) == search_connected(scene, body.name)
        tree = search_connected(scene, body.name)
        grounded = any(j.to is None and j.body in tree for j in scene.joints.values())
        if grounded or len(joined_with(scene, body.name)) == 1:
            assert is_anchored(scene, body.name) == search_anchored(scene, body.name)
        else:
            assert not is_anchored(scene, body.name)
    for root, carried in floating_roots(scene).items():
        assert {root, *carried} == search_connected(scene, root)


def test_a_changed_scene_is_arranged_anew() -> None:
    scene = random_scene(1)
    assert arrangement(scene).branches
    assert not arrangement(replace(scene, joints={})).branches


def test_a_long_chain_is_arranged_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever is asked about its bodies."""
    bodies = tuple(Body(f"b{k}", 1.0, np.eye(3)) for k in range(200))
    joints = {f"j{k}": hs.Hinge(f"b{k}", f"b{k - 1}", axis=(0.0, 0.0, 1.0)) for k in range(1, 200)}
    made = []

    def counted(*given: Any) -> Any:
        made.append(given)
        return arrange_joints(*given)

    monkeypatch.setattr("hydrosim.scene.scene.arrange_joints", counted)
    scene = Scene("chain", 1.0, bodies, joints=joints)
    for body in bodies:
        joined_with(scene, body.name)
        is_anchored(scene, body.name)
    assert len(made) == 1
