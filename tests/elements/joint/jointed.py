"""Dry bodies on joints for the tests, and what their runs tell."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike
from scenes import Acting, joint_of

import hydrosim as hs
from hydrosim.scene import ForceElement, LinearScenes, Method, Weight

G = 9.81
FRAME = {"centre": (0.0, 0.0, 0.0), **dict(zip("xyz", map(tuple, np.eye(3).tolist()), strict=True))}
"""Named points of every body, which tell its rotation at any attitude."""
TIGHT = hs.Tolerance(1e-12, 1e-12, 1e-12)


def carried(
    name: str, mass: float, inertia: ArrayLike, place: Sequence[float], **changes: Any
) -> hs.Body:
    """A dry body with weight, at rest at ``place``; ``inertia`` (3,) or (3, 3) about its centre."""
    matrix = np.asarray(inertia, float)
    matrix = np.diag(matrix) if matrix.ndim == 1 else matrix
    x, y, z = place
    where = {"location": (x, y), "centre_of_gravity": (0.0, 0.0, z)}
    given = {"points": FRAME, "weight": Weight.CARRIED, **where, **changes}
    return hs.Body(name, mass, matrix, **given)


def joint(kind: str, body: str, to: str | None = None, *motions: Acting, **place: Any) -> hs.Joint:
    """A joint; ``motions`` are the resistances of its free motions, none without them."""
    return joint_of(kind, body, to, *motions, **place)


def moved(position: float = 0.0, velocity: float = 0.0, **acts: Any) -> Acting:
    """A motion of a joint with its start."""
    return Acting(position=position, velocity=velocity, **acts)


def swivelled(rotation: Sequence[float], rate: Sequence[float]) -> list[Acting]:
    """The motions of a ball joint with their start."""
    return [moved(angle, speed) for angle, speed in zip(rotation, rate, strict=True)]


def scene(
    bodies: Sequence[hs.Body],
    joints: Mapping[str, hs.Joint],
    duration: float,
    forces: Mapping[str, ForceElement] | None = None,
    output_step: float = 0.1,
    gravity: float = G,
    **solver: Any,
) -> hs.Scene:
    """A scene without water, by dopri5 at a tolerance of 1e-12 unless ``solver`` says otherwise."""
    given = {"method": Method.DOPRI5, "step": 0.01, "tolerance": TIGHT, "linear": LinearScenes.STEP}
    solver, water = hs.Solver(**{**given, **solver}), hs.Environment(gravity=gravity)
    parts = {"forces": forces or {}, "joints": joints}
    whole = hs.Scene("joints", duration, tuple(bodies), water, **parts, solver=solver)
    return whole.with_output(step=output_step)


def by_rk4(scene: hs.Scene, step: float) -> hs.Scene:
    """The same scene, solved by rk4."""
    return replace(scene, solver=replace(scene.solver, method=Method.RK4, step=step))


def completed(scene: hs.Scene) -> xr.Dataset:
    """The run of a scene, which must be complete."""
    run = hs.simulate(scene)
    assert run.attrs["status"] == "complete", run.attrs.get("message")
    return run


def places(run: xr.Dataset, body: str) -> np.ndarray:
    """Centre of gravity (nt, 3) in the earth frame."""
    return run.point_position.sel(point=f"centre of {body}").values


def rotations(run: xr.Dataset, body: str) -> np.ndarray:
    """Rotation matrices (nt, 3, 3) from the body frame to the earth frame."""
    centre = places(run, body)
    axes = [run.point_position.sel(point=f"{axis} of {body}").values - centre for axis in "xyz"]
    return np.stack(axes, axis=2)


def apart(found: np.ndarray, exact: np.ndarray) -> float:
    """Largest difference of vectors over time, (nt, ...), over the largest range of an entry."""
    return float(np.abs(found - exact).max() / np.ptp(exact, axis=0).max())


def observed_order(scene: hs.Scene, body: str, exact: np.ndarray, step: float) -> float:
    """Order of rk4 from the errors of a body's place at ``step`` and at half of it."""
    errors = [apart(places(completed(by_rk4(scene, h)), body), exact) for h in (step, step / 2)]
    return float(np.log2(errors[0] / errors[1]))


def assert_order(whole: hs.Scene, body: str, exact: np.ndarray, step: float, figure) -> None:
    """Errors of rk4 fall with an order of 3.8 at least."""
    order = observed_order(whole, body, exact, step)
    figure("order", order)
    assert order >= 3.8
