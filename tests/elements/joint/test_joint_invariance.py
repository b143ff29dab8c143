"""What must not matter: place and heading of a scene, names and order of bodies, which body tells a
joint, and which body is the root."""

from dataclasses import replace
from functools import cache
from math import radians

import numpy as np
import pytest
import xarray as xr
from jointed import carried, completed, joint, moved, scene, swivelled
from scenes import Acting, turned_scene
from turning import points, renamed, rooted, swapped, turned_back

from hydrosim.elements import AppliedForce, Harmonic, LinearMooring, Spring
from hydrosim.scene import ForceElement, Scene, Tolerance, Weight

WITHIN = 1e-9  # of the range
INERTIA = np.array([[3.0, -0.4, 0.2], [-0.4, 4.0, 0.3], [0.2, 0.3, 6.0]])
TOLERANCE = Tolerance(1e-11, 1e-11, 1e-11)
BY, SHIFT = radians(37.0), (12.0, -7.0)
TREE = ("hull", "arm", "hand", "leg", "foot", "drum")


def tree() -> Scene:
    """A moored hull with five bodies on joints of five types, sprung, damped, pushed and turned."""
    rest = {
        "hull": (20.0, (0.0, 0.0, 0.0), 0.3),
        "arm": (2.0, (3.0, 1.0, 0.5), -0.8),
        "hand": (1.0, (5.0, 1.5, 0.0), 1.2),
        "leg": (3.0, (-2.0, -1.0, -2.0), 2.0),
        "foot": (1.5, (-2.5, -1.5, -4.0), 0.0),
        "drum": (4.0, (0.5, 2.5, 1.0), -2.0),
    }
    bodies = [
        carried(n, m, m * INERTIA, place, heading=angle) for n, (m, place, angle) in rest.items()
    ]
    launch = (0.2, -0.1, 0.1, 0.05, -0.08, 0.1)
    start = {"position": (0.3, 0.2, 0.1, 0.1, -0.2, 0.3), "velocity": launch}
    bodies[0] = replace(bodies[0], weight=Weight.BALANCED, **start)
    joints = {
        "shoulder": joint(
            *("hinge", "arm", "hull", moved(0.3, -0.2, stiffness=40.0, damping=2.0)),
            point=(-1.5, -0.5, 0.0),
            axis=(0.2, 1.0, -0.3),
        ),
        "wrist": joint(
            *("ball", "hand", "arm", *damped(swivelled((0.2, -0.1, 0.3), (0.3, 0.2, -0.4)))),
            point=(-0.8, 0.1, 0.2),
        ),
        "hip": joint(
            *("universal", "leg", "hull", moved(0.2, 0.1, stiffness=60.0), moved(-0.1, 0.2)),
            point=(0.3, 0.2, 1.2),
            axis=(1.0, 0.5, 0.0),
            second_axis=(-0.5, 1.0, 0.4),
        ),
        "shin": joint(
            *("slider", "foot", "leg", moved(0.1, 0.3, stiffness=50.0, neutral=0.1, damping=1.0)),
            axis=(0.2, 0.1, 1.0),
        ),
        "axle": joint(
            *("cylindrical", "drum", "hull"),
            *(moved(0.05, 0.0, stiffness=80.0), moved(-0.4, 0.9, damping=0.5)),
            point=(0.1, 0.2, -0.3),
            axis=(1.0, 0.2, 0.1),
        ),
    }
    stiffness = np.diag([30.0, 25.0, 20.0, 0.0, 0.0, 0.0])
    sides = enumerate(((1, 1), (1, -1), (-1, 1), (-1, -1)))
    forces: dict[str, ForceElement] = {}
    for k, (x, y) in sides:
        ends = (2.0 * x, 1.5 * y, 0.5), (2.5 * x, 2.0 * y, 8.0)
        forces[f"sling {k}"] = Spring("hull", *ends, 7.0, stiffness=60.0)
    thrust = {"surge": Harmonic(6.0, 3.0)}
    tied = {"anchor_body": "foot", "stiffness": 15.0}
    forces |= {
        "mooring": LinearMooring("hull", stiffness, 0.05 * stiffness),
        "tie": Spring("hand", (0.2, 0.0, 0.1), (0.0, 0.3, 0.0), 9.0, **tied),
        "anchor": Spring("foot", (0.0, 0.1, -0.5), (-6.0, 2.0, -8.0), 6.0, stiffness=15.0),
        "thrust": AppliedForce("drum", (0.1, 0.0, 0.0), thrust, frame="body"),
    }
    return scene(bodies, joints, 2.0, forces, output_step=0.1, tolerance=TOLERANCE)


def damped(motions: list[Acting]) -> list[Acting]:
    """A ball joint with damping: as a root the hand's pitch must stay below 85 deg."""
    return [motion._replace(damping=4.0) for motion in motions]


@cache
def as_told() -> xr.Dataset:
    """The run of the tree."""
    return completed(tree())


def apart(found: np.ndarray) -> float:
    """How far the points (nt, np, 3) are from those of the tree as told, over the range of each."""
    exact = points(as_told(), tree())
    ranges = np.ptp(exact, axis=0).max(axis=1)
    assert ranges.min() > 0.1
    return float((np.abs(found - exact).max(axis=(0, 2)) / ranges).max())


def test_the_scene_turned(figure) -> None:
    run = completed(turned_scene(tree(), BY, SHIFT))
    error = apart(turned_back(points(run, tree()), BY, SHIFT))
    figure("error", error)
    assert error <= WITHIN
    before, after = as_told().joint_force.values, run.joint_force.values
    parts = [turned_back(after[..., k : k + 3], BY) for k in (0, 3)]
    back = np.concatenate(parts, axis=-1)
    assert np.abs(back - before).max() <= WITHIN * np.abs(before).max()


def test_the_order_and_the_names_of_bodies_and_joints(figure) -> None:
    whole = renamed(tree(), {name: f"{k} {name[::-1]}" for k, name in enumerate(reversed(TREE))})
    rng = np.random.default_rng(1)
    bodies = tuple(whole.bodies[i] for i in rng.permutation(len(whole.bodies)))
    names = list(whole.joints)
    joints = {f"{i}": whole.joints[names[i]] for i in rng.permutation(len(names))}
    run = completed(replace(whole, bodies=bodies, joints=joints))
    error = apart(points(run, whole))
    figure("error", error)
    assert error <= WITHIN


@pytest.mark.parametrize("name", ["wrist", "shin"])
def test_which_body_tells_a_joint(name: str, figure) -> None:
    """A joint told from the side that the tree grows from. Its load is on the other body now."""
    run = completed(swapped(tree(), name))
    error = apart(points(run, tree()))
    figure("error", error)
    assert error <= WITHIN
    before, after = (r.joint_force.sel(joint=name).values[:, :3] for r in (as_told(), run))
    assert np.abs(after + before).max() <= WITHIN * np.abs(before).max()


@pytest.mark.parametrize("root", TREE)
def test_which_body_is_the_root(root: str, figure) -> None:
    run = completed(rooted(tree(), root, as_told()))
    error = apart(points(run, tree()))
    figure("error", error)
    assert error <= WITHIN
