"""`joint_force` against the multipliers of a model whose bodies are all free."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from jointed import G, by_rk4, carried, completed, joint, moved, places, rotations, scene
from redundant import EARTH, Link, Rigid, joint_wrenches, openings
from scenes import Acting, with_motions
from turning import at_rest

import hydrosim as hs
from hydrosim.compile.compiled import Compiled
from hydrosim.elements import AppliedForce, constant
from hydrosim.integrate.dynamics import Model, Work, accelerate, is_articulated, new_work
from hydrosim.multibody.articulated import accelerate_articulated
from hydrosim.multibody.kinematics import place_bodies
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Joint, Kinematics, Scene, Weight

WITHIN = 1e-10  # of the largest force or moment
HELD = 1e-13  # m, and of the cosine of a right angle
CHAINS = (
    ("hinge", "ball", "universal"),
    ("universal", "hinge", "ball"),
    ("ball", "universal", "hinge"),
    ("slider", "cylindrical", "planar"),
    ("fixed", "planar", "slider"),
    ("cylindrical", "fixed", "ball"),
)
SEEDS = range(3)


def random_inertia(rng: np.random.Generator) -> np.ndarray:
    """An inertia without symmetry that a body may have [kg m^2]."""
    masses = rng.uniform(0.2, 1.0, 12)
    points = rng.uniform(-1.5, 1.5, (12, 3))
    return sum(
        m * (np.eye(3) * (p @ p) - np.outer(p, p)) for m, p in zip(masses, points, strict=True)
    )


def random_direction(rng: np.random.Generator) -> np.ndarray:
    found = rng.normal(size=3)
    return found / np.linalg.norm(found)


def random_motions(kind: str, rng: np.random.Generator) -> list[Acting]:
    """Any place and speed of all free motions."""
    count = len(getattr(hs, kind.capitalize()).motions)
    return [moved(*rng.uniform(-1.2, 1.2, 2)) for _ in range(count)]


def random_joint(kind: str, body: str, to: str | None, rng: np.random.Generator) -> Joint:
    first = random_direction(rng)
    second = np.cross(first, random_direction(rng))
    axes = {"axis": tuple(first), "second_axis": tuple(second)}
    point = tuple(rng.uniform(-1.0, 1.0, 3))
    return joint(kind, body, to, *random_motions(kind, rng), point=point, **axes)


def chain(kinds: Sequence[str], seed: int) -> Scene:
    """Three bodies on each other, the first on the earth, with loads, in any state."""
    rng = np.random.default_rng(seed)
    names = ["a", "b", "c"]
    bodies = []
    for name in names:
        mass, inertia = float(rng.uniform(1.0, 4.0)), random_inertia(rng)
        place, heading = rng.uniform(-2.0, 2.0, 3).tolist(), float(rng.uniform(-3.0, 3.0))
        bodies.append(carried(name, mass, inertia, place, heading=heading))
    links = zip(kinds, names, [None, "a", "b"], strict=True)
    joints = {f"joint of {name}": random_joint(kind, name, to, rng) for kind, name, to in links}
    forces = {}
    for name in names:
        point, dofs = tuple(rng.uniform(-1.0, 1.0, 3)), ("surge", "sway", "heave", "yaw")
        signals = {dof: constant(rng.uniform(-20.0, 20.0)) for dof in dofs}
        forces[name] = AppliedForce(name, point, signals)
    return scene(bodies, joints, 0.01, forces, output_step=0.01, step=0.01)


def redundant(scene: Scene, run: xr.Dataset, k: int = 0) -> tuple[list[Rigid], list[Link]]:
    """Bodies and joints of a scene at output time ``k``, by places, rotations and velocities."""
    number = {body.name: b for b, body in enumerate(scene.bodies)}
    rigid = []
    for body in scene.bodies:
        R = rotations(run, body.name)[k]
        velocity = run.velocity.sel(body=body.name).values[k]
        pushed = scene.forces[body.name]
        force = np.array([pushed.force[dof].value[0] for dof in ("surge", "sway", "heave")])
        moment = np.array([0.0, 0.0, pushed.force["yaw"].value[0]])
        load = [*force, *(moment + np.cross(R @ pushed.point, force))]
        load[2] -= body.mass * G
        inertia = R @ body.inertia @ R.T
        place = places(run, body.name)[k]
        rigid.append(
            Rigid(body.mass, inertia, place, R, velocity[:3], velocity[3:], np.array(load))
        )
    links = []
    for each in scene.joints.values():
        place, R = at_rest(scene, each.body)
        to_place, to_R = at_rest(scene, each.to)
        point, axes = np.array(each.point), each.axes()
        to_point, to_axes = to_R.T @ (place + R @ point - to_place), axes @ R.T @ to_R
        ends = (number[each.body], number.get(each.to or "", EARTH))
        links.append(Link(each.type, *ends, point, to_point, axes, to_axes))
    return rigid, links


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("kinds", CHAINS, ids="-".join)
def test_joint_forces_are_the_multipliers(kinds, seed, validated):
    whole = chain(kinds, seed)
    run = completed(whole)
    exact = joint_wrenches(*redundant(whole, run))
    found = run.joint_force.isel(time=0).sel(joint=list(whole.joints)).values
    error = np.abs(found - exact).max() / np.abs(exact).max()
    claim, against = "loads in chains of joints, of the largest", "multipliers of free bodies"
    validated(Kind.INDEPENDENT, claim, against, error, WITHIN, Feature.JOINTS)


@pytest.mark.parametrize("kinds", CHAINS, ids="-".join)
def test_trees_hold_identically(kinds: Sequence[str], figure) -> None:
    """At a coarse step, too, where motions are wrong by far more than joints open."""
    whole = by_rk4(replace(chain(kinds, 7), duration=1.0).with_output(step=0.05), 0.05)
    run = completed(whole)
    last = run.time.size - 1
    error = 0.0
    for k in range(run.time.size):
        rigid, links = redundant(whole, run, k)
        error = max(error, *(abs(x) for link in links for x in openings(rigid, link)))
    figure("opening", error)
    assert error <= HELD
    exact = joint_wrenches(rigid, links)
    found = run.joint_force.isel(time=last).sel(joint=list(whole.joints)).values
    assert np.abs(found - exact).max() <= WITHIN * np.abs(exact).max()


def test_what_acts_in_a_joint_is_no_part_of_its_load(figure) -> None:
    """Springs and dampers of hinges are moments on both bodies, and none of `joint_force`."""
    whole = chain(("hinge", "hinge", "hinge"), 5)
    joints = {name: _sprung(held) for name, held in whole.joints.items()}
    run = completed(replace(whole, joints=joints))
    rigid, links = redundant(whole, run)
    axes = [rigid[link.body].rotation @ link.axes[0] for link in links]
    for link, held, axis in zip(links, joints.values(), axes, strict=True):
        acts = held.resistances[0]
        moment = -acts.stiffness * (acts.position - acts.neutral) - acts.damping * acts.velocity
        rigid[link.body].load[3:] += moment * axis
        if link.to != EARTH:
            rigid[link.to].load[3:] -= moment * axis
    exact = np.array(joint_wrenches(rigid, links))
    found = run.joint_force.isel(time=0).sel(joint=list(joints)).values
    error = np.abs(found - exact).max() / np.abs(exact).max()
    figure("error", error)
    assert error <= WITHIN
    about_axes = np.sum(found[:, 3:] * axes, axis=1)
    assert np.abs(about_axes).max() <= WITHIN * np.abs(found).max()


def _sprung(held: Joint) -> Joint:
    return replace(held, stiffness=30.0, neutral=0.2, damping=4.0)


# Articulated bodies against the matrix of the whole, and placing that forgets what was before.

PLACE_SEEDS = range(4)


def floating(kinds: tuple[str, ...], seed: int) -> Scene:
    """The chain without the joint to the earth: its root is free."""
    whole = chain(kinds, seed)
    joints = {name: joint for name, joint in whole.joints.items() if joint.to is not None}
    return replace(whole, joints=joints)


def placed(compiled: Compiled, seed: int) -> tuple[Model, Work, np.ndarray]:
    """The model at random coordinates and rates, and these."""
    model = compiled.model
    work = new_work(model)
    n = model.bodies.active.size
    y = compiled.state.y.copy()
    y[: 2 * n] = np.random.default_rng(seed).uniform(-0.9, 0.9, 2 * n)
    place_bodies(y[:n], y[n : 2 * n], model.bodies, work.motion)
    return model, work, y


@pytest.mark.parametrize("built", [chain, floating])
@pytest.mark.parametrize("kinds", CHAINS, ids="-".join)
def test_accelerations_are_those_of_the_whole_matrix(built, kinds):
    for seed in PLACE_SEEDS:
        compiled = hs.compile_scene(built(kinds, seed))
        model, work, y = placed(compiled, seed)
        assert is_articulated(model)
        rng = np.random.default_rng(seed)
        loads = rng.uniform(-9.0, 9.0, work.total.size)
        added = rng.uniform(-0.3, 0.3, (work.total.size, work.total.size))
        own = np.kron(np.eye(len(loads) // 6), np.ones((6, 6)))
        model = model._replace(added_mass=(added + added.T) * own + 2.0 * np.eye(len(loads)))
        x = np.zeros((2, model.bodies.active.size))
        work.total[:] = loads
        accelerate(y, compiled.state.modes, model, work, x[0])
        added_mass, headings = model.added_mass, model.headings
        bodies, contents = model.bodies, work.contents
        accelerate_articulated(bodies, contents, headings, added_mass, work.motion, loads, x[1])
        np.testing.assert_allclose(x[1], x[0], rtol=1e-10, atol=1e-11 * np.abs(x[0]).max())


@pytest.mark.parametrize("kinematics", Kinematics)
def test_places_do_not_depend_on_those_before(kinematics: Kinematics) -> None:
    """Rotations of jointed bodies too, with exact rotations and with small angles."""
    whole = chain(("hinge", "universal", "slider"), 1)
    level = [replace(body, heading=0.0, weight=Weight.BALANCED) for body in whole.bodies]
    solver = replace(whole.solver, kinematics=kinematics)
    still = {
        name: with_motions(joint, *[Acting()] * len(joint.motions))
        for name, joint in whole.joints.items()
    }
    whole = replace(whole, bodies=tuple(level), solver=solver, joints=still)
    compiled = hs.compile_scene(whole)
    model, fresh, y = placed(compiled, 1)
    _, used, other = placed(compiled, 2)
    n = model.bodies.active.size
    place_bodies(y[:n], y[n : 2 * n], model.bodies, used.motion)
    assert not np.array_equal(y, other)
    for name in ("coordinates", "rate", "rotation", "velocity", "bias"):
        assert np.array_equal(getattr(used.motion, name), getattr(fresh.motion, name)), name
