"""Which steps are stable, and does the limit that is said before a run agree?

A block of the barge's mass on its mooring, in surge alone, with one point of contact, pushed to and
fro. *Friction slope*: pressed all the time and pushed with half of what friction can hold, so that
it creeps and what slips is the method's doing. *Stick-slip*: pushed with more than static friction
can hold while the contact opens and closes, so that its node sticks, slips and relaxes; C2 is 5 %
of critical. Over steps and slopes, and over steps and stiffnesses K2, with steps cut at events and
without, each run is compared with rk4 at a small step. Steps far above the limit are left out: with
hundreds of events in a step they take long to say nothing more.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import inf, nan, sqrt
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from benchmarks.report import Answer, Row
from hydrosim import SimulationError, compile_scene, simulate
from hydrosim.forces import (
    AppliedForce,
    Fender,
    FrictionSlope,
    LinearMooring,
    Plane,
    PrescribedNormal,
    StickSlip,
    Table,
)
from hydrosim.scene import Body, Method, Scene, Solver
from hydrosim.studies.run.step_limits import scene_step_limits

METHODS = (Method.RK2, Method.RK4)
RECORDED = 0.8  # s
PARTS = (2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 17, 20, 24, 28, 34, 40, 48, 57, 68, 80)
STEPS = np.array([RECORDED / n for n in PARTS])  # s
SLOPES = np.logspace(8.5, 10.5, 21)  # N s/m
STIFFNESSES = np.logspace(7.5, 10.5, 21)  # N/m
DURATION = 48.0  # s
FINE = 2e-3  # s
FAR = 3.0  # times the limit: larger steps are left out
MASS, MOORING = 1.62e8, 392.4e3  # kg, N/m
PRESSED, STATIC, KINETIC = 1e7, 0.2, 0.1  # N
WRONG = 0.3  # error of velocity over its rms from which on a run is called wrong


class Map(NamedTuple):
    """Errors of velocity over its rms (steps, values), NaN where there is no run, by method and
    whether steps are cut at events; and the ``limits`` (values,) of the step, said before the run.
    """

    errors: Mapping[tuple[Method, bool], np.ndarray]
    limits: Mapping[Method, np.ndarray]


def answer() -> Answer:
    """Both maps, and how many of their runs are on the side of the limit where they should be."""
    maps = {
        "friction slope": (_map(_creeping, SLOPES), SLOPES, "friction slope b [N s/m]"),
        "stick-slip": (_map(_knocking, STIFFNESSES), STIFFNESSES, "contact stiffness K2 [N/m]"),
    }
    counts = [row for law, (found, _, _) in maps.items() for row in _counts(law, found)]
    title = f"Runs that are wrong by {WRONG:g} of the rms velocity or more; steps over the limit"
    return Answer({title: counts}, picture=_picture(list(maps.values())))


def _block(push: float, fender: Fender) -> Scene:
    """The block, pushed along straight lines between +-push [N] with a period of 8 s."""
    time = np.arange(0.0, DURATION + 4.0, 4.0)
    force = Table(time, push * np.where(np.arange(time.size) % 2, 1.0, -1.0))
    stiffness = MOORING * (np.eye(6) * (np.arange(6) == 0))
    forces = {
        "mooring": LinearMooring("block", stiffness),
        "push": AppliedForce("block", (0.0, 0.0, 0.0), {"surge": force}),
        "fender": fender,
    }
    body = Body("block", MASS, np.eye(3), dofs=("surge",))
    return Scene("block", DURATION, (body,), forces=forces, output_step=RECORDED)


def _fender(law: FrictionSlope | StickSlip, time: ArrayLike, force: ArrayLike) -> Fender:
    plane = Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    normal = PrescribedNormal(Table(np.array(time), np.array(force)))
    return Fender("block", np.zeros((1, 3)), plane, normal, law)


def _creeping(slope: float) -> Scene:
    law = FrictionSlope(STATIC, slope)
    return _block(0.5 * STATIC * PRESSED, _fender(law, [0.0], [PRESSED]))


def _knocking(stiffness: float) -> Scene:
    """Pressed for 4 of 12 s, open for 4, changing for 2 each time."""
    damping = 0.05 * 2.0 * sqrt(stiffness * MASS)
    law = StickSlip(STATIC, KINETIC, stiffness, damping, slip_damping=1e6)
    starts = np.arange(0.0, DURATION, 12.0)
    time = (starts[:, None] + [0.0, 4.0, 6.0, 10.0]).ravel()
    force = np.tile([0.0, 0.0, PRESSED, PRESSED], starts.size)
    return _block(1.5 * STATIC * PRESSED, _fender(law, time, force))


def _map(scene_of: Callable[[float], Scene], values: np.ndarray) -> Map:
    scenes = [scene_of(value) for value in values]
    references = [_velocity(scene, Method.RK4, FINE, True) for scene in scenes]
    limits = {method: np.array([_limit(scene, method) for scene in scenes]) for method in METHODS}
    errors = {
        (method, events): np.full((STEPS.size, values.size), nan)
        for method in METHODS
        for events in (True, False)
    }
    for (method, events), error in errors.items():
        for i, k in np.argwhere(STEPS[:, None] <= FAR * limits[method]):
            velocity = _velocity(scenes[k], method, STEPS[i], events)
            error[i, k] = _error(velocity, references[k])
    return Map(errors, limits)


def _velocity(scene: Scene, method: Method, step: float, events: bool) -> np.ndarray:
    """Surge velocity [m/s] at the records; infinite after a run has failed."""
    solver = Solver(method=method, step=step, events=events)
    try:
        run = simulate(replace(scene, solver=solver))
    except SimulationError as error:
        run = error.dataset
    found = np.full(round(DURATION / RECORDED) + 1, inf)
    found[: run.sizes["time"]] = run.velocity.values[:, 0, 0]
    return found


def _error(velocity: np.ndarray, reference: np.ndarray) -> float:
    with np.errstate(over="ignore", invalid="ignore"):
        error = np.sqrt(np.mean((velocity - reference) ** 2) / np.mean(reference**2))
    return float(error) if np.isfinite(error) else inf


def _limit(scene: Scene, method: Method) -> float:
    scene = replace(scene, solver=Solver(method=method, step=FINE))
    return scene_step_limits(compile_scene(scene))[0].step


def _counts(law: str, found: Map) -> list[Row]:
    """How many runs are wrong above and below the limit, and how far from it the exceptions are."""
    rows: list[Row] = []
    for (method, events), errors in found.errors.items():
        ratio = np.where(np.isnan(errors), nan, STEPS[:, None] / found.limits[method])
        wrong = errors >= WRONG
        rows.append(
            {
                "law": law,
                "method": method + ("" if events else ", no events"),
                "wrong above": f"{(wrong & (ratio > 1.0)).sum()} of {(ratio > 1.0).sum()}",
                "wrong below": f"{(wrong & (ratio <= 1.0)).sum()} of {(ratio <= 1.0).sum()}",
                "least wrong at": f"{np.nanmin(ratio[wrong]):.2f}",
                "last right at": f"{np.nanmax(ratio[~wrong & ~np.isnan(ratio)]):.2f}",
            }
        )
    return rows


def _picture(maps: Sequence[tuple[Map, np.ndarray, str]]) -> Figure:
    """A row per law, a column per method with and without events; grey is left out."""
    figure = Figure((12.0, 6.4), dpi=100, layout="constrained")
    axes = figure.subplots(len(maps), 2 * len(METHODS), sharey=True, sharex="row")
    for row, (found, values, label) in zip(axes, maps, strict=True):
        for axis, ((method, events), errors) in zip(row, found.errors.items(), strict=True):
            mesh = _draw(axis, values, errors, found.limits[method])
            axis.set_title(f"{method}, {'' if events else 'not '}cut at events", fontsize="medium")
            axis.set_xlabel(label)
        row[0].set_ylabel("step [s]")
    axes[0, 0].legend(loc="lower left", fontsize="small")
    bar = figure.colorbar(mesh, ax=axes, extend="both", shrink=0.6)
    bar.set_label("error of velocity over its rms")
    return figure


def _draw(axis: Axes, values: np.ndarray, errors: np.ndarray, limits: np.ndarray) -> QuadMesh:
    norm = LogNorm(1e-4, 10.0)
    shown = np.minimum(errors, 1e3)
    mesh = axis.pcolormesh(values, STEPS, shown, norm=norm, cmap="viridis", shading="nearest")
    axis.loglog(values, limits, color="white", linewidth=3.0)
    axis.loglog(values, limits, color="#D55E00", linewidth=1.5, label="limit said before the run")
    axis.set_ylim(STEPS[-1], STEPS[0])
    axis.set_facecolor("0.9")
    return mesh
