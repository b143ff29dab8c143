"""Scenes of dry bodies: blocks that fly, bounce, stick and slide."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

import hydrosim as hs
from hydrosim.dofs import DOFS
from hydrosim.forces import (
    AppliedForce,
    Fender,
    Frictionless,
    FrictionSlope,
    NormalCurve,
    Plane,
    Signal,
    StickSlip,
    Table,
    constant,
)
from hydrosim.scene import Body, ForceElement, LinearScenes, Scene, Solver

INERTIA = np.array([[3.0, -0.4, 0.2], [-0.4, 4.0, 0.3], [0.2, 0.3, 6.0]])  # per unit of mass [m^2]
FLOOR = Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
Law = StickSlip | FrictionSlope | Frictionless


def block(mass: float, dofs: Sequence[str] = DOFS, name: str = "block", **changes: Any) -> Body:
    """A dry body without symmetry."""
    return replace(Body(name, mass, mass * INERTIA, dofs=tuple(dofs)), **changes)


def moving(**values: float) -> tuple[float, ...]:
    """Six coordinates or velocities by name."""
    return tuple(values.get(dof, 0.0) for dof in DOFS)


def table(time: ArrayLike, force: ArrayLike) -> dict[str, Signal]:
    """Forces and moments (n, 6) at ``time`` (n,), by the names of the DOFs."""
    time, force = np.asarray(time, float), np.asarray(force, float)
    return {dof: Table(time, column) for dof, column in zip(DOFS, force.T, strict=True)}


def steady(body: str = "block", **force: float) -> AppliedForce:
    """A constant force on the centre of gravity."""
    signals = {dof: constant(size) for dof, size in force.items()}
    return AppliedForce(body, (0.0, 0.0, 0.0), signals)


def on_floor(
    stiffness: float,
    friction: Law,
    points: Sequence[Sequence[float]] = ((0.0, 0.0, 0.0),),
    plane: Plane = FLOOR,
    body: str = "block",
) -> Fender:
    """Points with a straight normal curve."""
    curve = NormalCurve(np.array([0.0, 1.0]), np.array([0.0, stiffness]))
    return Fender(body, np.array(points, dtype=float), plane, curve, friction)


def scene(
    bodies: Body | Sequence[Body],
    forces: Mapping[str, ForceElement],
    duration: float,
    output_step: float,
    **solver: Any,
) -> Scene:
    """A scene without water."""
    bodies = (bodies,) if isinstance(bodies, Body) else tuple(bodies)
    settings = Solver(**{"step": output_step, "linear": LinearScenes.STEP, **solver})
    return Scene("dry", duration, bodies, forces=forces, solver=settings, output_step=output_step)


def with_step(scene: Scene, step: float, **changes: Any) -> Scene:
    """The same scene at another step, and other changes of the solver."""
    return replace(scene, solver=replace(scene.solver, step=step, **changes))


def surge(run: xr.Dataset) -> np.ndarray:
    """Surge of the first body (nt,)."""
    return run.position.values[:, 0, 0]


def heave(run: xr.Dataset) -> np.ndarray:
    """Heave of the first body (nt,)."""
    return run.position.values[:, 0, 2]


def errors(scene: Scene, steps: Sequence[float], exact: np.ndarray, dof: int = 0, **solver: Any):
    """Largest error of a coordinate of the first body at the output times, for every step."""
    runs = [hs.simulate(with_step(scene, step, **solver)) for step in steps]
    return np.array([np.abs(run.position.values[:, 0, dof] - exact).max() for run in runs])


def observed_orders(steps: Sequence[float], errors: np.ndarray) -> np.ndarray:
    """log(e1 / e2) / log(h1 / h2) of neighbours."""
    return np.diff(np.log(errors)) / np.diff(np.log(steps))
