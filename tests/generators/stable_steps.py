"""The step at which runs begin to diverge, beside the one that is said before a run.

The base case in calm water with 1 to 8 fenders at random heights, stiffnesses and friction, some of
them bumpers ahead, is put in three places: with all of them open, with all of them
pressed and at rest, and with all of them pressed and sliding. In each of them two runs that begin
1e-9 m apart are compared: below the limit the difference is as at half the step, above it grows
from step to step. The step at which the first of the three begins to diverge is found by bisection.
"""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import xarray as xr

import hydrosim as hs
from hydrosim import InputError, SimulationError, compile_scene, load_case, simulate
from hydrosim.compile.compiled import Compiled
from hydrosim.dofs import DOFS
from hydrosim.elements import constant
from hydrosim.integrate.dynamics import dynamic_states
from hydrosim.run.step_limits import scene_step_limits
from hydrosim.scene import ConvolutionRadiation, LinearScenes, Question, Scene, Solver, Unstable
from hydrosim.scene.contacts import Law

CASE = Path(__file__).parents[2] / "cases" / "reverse_float_over" / "base.yaml"
STEPS = 200
NEARBY, GROWN = 1e-9, 100.0  # m: how far runs begin apart; how many times farther they may end
EARLY = 10  # steps in which a difference spreads over all states
RANGE, FINE = 0.2, 0.005  # about the limit that is said: looked at, and to which parts of it
DECK, GAP, PRESSED, SPEED = 7.5, 1.0, 0.3, 5.0  # m, m, m, m/s
MASS = 1.6e8  # kg
PLACES = ("open", "pressed", "sliding")


@cache
def base_case() -> Scene:
    """The base case, read once for all."""
    return load_case(CASE).scene()


def random_scene(seed: int) -> Scene:
    """The base case with other fenders, without waves and lift."""
    base, random = base_case(), np.random.default_rng(seed)
    count = int(random.integers(1, 9))
    bumpers = int(random.integers(0, count))
    forces = {"mooring": base.forces["mooring"]}
    for k in range(count):
        forces[f"fender {k + 1}"] = _bumper(random) if k < bumpers else _on_deck(random)
    solver = Solver(unstable=Unstable.WARN, linear=LinearScenes.STEP)
    calm = replace(base.environment, waves=())
    return replace(base, environment=calm, forces=forces, solver=solver, accept=tuple(Question))


def with_radiation(scene: Scene, radiation: ConvolutionRadiation) -> Scene:
    """The scene with another memory."""
    return replace(scene, bodies=(replace(scene.bodies[0], radiation=radiation),))


def _on_deck(random: np.random.Generator) -> hs.Fender:
    """A fender below the topside, up to 0.3 m higher or lower than the others."""
    x, y, z = random.uniform((-60.0, -18.0, DECK - 0.3), (60.0, 18.0, DECK + 0.3))
    plane = hs.Plane((0.0, 0.0, 3.6), (0.0, 0.0, -1.0))
    return hs.Fender("barge", np.array([[x, y, z]]), plane, _curve(random), _law(random))


def _bumper(random: np.random.Generator) -> hs.Fender:
    """A bumper ahead, `GAP` from its wall, along which the barge slides freely."""
    place = np.array([[130.0, random.uniform(-15.0, 15.0), random.uniform(0.0, 7.0)]])
    plane = hs.Plane((130.0 + GAP, 0.0, 0.0), (-1.0, 0.0, 0.0))
    return hs.Fender("barge", place, plane, _curve(random), hs.Frictionless())


def _curve(random: np.random.Generator) -> hs.NormalCurve:
    k = 10.0 ** random.uniform(7.0, 9.5)
    damping = random.choice([0.0, 0.05, 0.2]) * np.sqrt(k * MASS)
    return hs.NormalCurve(np.array([0.0, 1.0]), np.array([0.0, k]), float(damping))


def _law(random: np.random.Generator) -> Law:
    kind, k = random.integers(0, 4), 10.0 ** random.uniform(8.0, 9.5)
    if kind == 0:
        return hs.Frictionless()
    if kind == 1:
        return hs.FrictionSlope(0.2, 10.0 ** random.uniform(7.0, 9.5))
    C2, C3 = random.choice([0.05, 0.1, 0.3], 2) * np.sqrt(k * MASS)
    return hs.StickSlip(0.2, 0.1, k, float(C2), float(C3 if kind == 2 else 0.0))


def predicted(scene: Scene) -> float:
    """The limit [s] that is said before a run."""
    return scene_step_limits(compile_scene(scene))[0].step


def observed(scene: Scene) -> float:
    """The step [s] from which on runs diverge, within `RANGE` of the predicted one."""
    placed = [put(scene, place) for place in PLACES]
    limit, low, high = predicted(scene), 1.0 - RANGE, 1.0 + RANGE
    while high - low > FINE:
        middle = 0.5 * (low + high)
        if any(diverges(each, middle * limit) for each in placed):
            high = middle
        else:
            low = middle
    return 0.5 * (low + high) * limit


def put(scene: Scene, place: str) -> Scene:
    """The scene where all its fenders are open, or pressed and held there by a steady force."""
    if place == "open":
        return scene
    closer = np.array([GAP + PRESSED, 0.0, GAP + PRESSED + 0.3, 0.0, 0.0, 0.0])
    there = replace(scene, bodies=(replace(scene.bodies[0], position=tuple(closer)),))
    smooth = {
        name: replace(e, friction=hs.Frictionless()) if isinstance(e, hs.Fender) else e
        for name, e in scene.forces.items()
    }
    step = scene.solver.step
    run = simulate(replace(there, forces=smooth, duration=step).with_output(step=step))
    loads = [run[name].values[0, 0] for name in run.data_vars if str(name).startswith("force_")]
    signals = {dof: constant(-load) for dof, load in zip(DOFS, np.sum(loads, axis=0), strict=True)}
    held = {**scene.forces, "held": hs.AppliedForce("barge", (0.0, 0.0, 0.0), signals)}
    velocity = (0.0, -SPEED, 0.0, 0.0, 0.0, 0.0) if place == "sliding" else (0.0,) * 6
    body = replace(there.bodies[0], velocity=velocity)
    return replace(there, bodies=(body,), forces=held)


def diverges(scene: Scene, step: float) -> bool:
    """Whether two runs of `STEPS` steps that begin close to each other part much farther than those
    at half the step do, which are below the limit: motions that are unstable themselves, such as
    yaw of a barge that is pushed against a bumper ahead, do not count."""
    return not _grown(scene, step, STEPS) <= GROWN * _grown(scene, 0.5 * step, 2 * STEPS)


def _grown(scene: Scene, step: float, steps: int) -> float:
    """How many times farther two runs are apart than they soon were; infinite if one ends."""
    every = steps // STEPS
    solver = replace(scene.solver, step=step)
    timed = replace(scene, solver=solver, duration=steps * step).with_output(step=every * step)
    compiled = compile_scene(timed)
    try:
        here, there = simulate(compiled), simulate(_nearby(compiled))
    except SimulationError:
        return np.inf
    apart = np.abs(_states(here) - _states(there)).max(axis=1)
    return float(apart.max() / apart[:EARLY].max()) if np.isfinite(apart).all() else np.inf


def _nearby(compiled: Compiled) -> Compiled:
    """The same, with all states that act on others `NEARBY` theirs."""
    moved, states = compiled.first_state(), dynamic_states(compiled.model)
    moved.y[states] += NEARBY * np.random.default_rng(1).choice([-1.0, 1.0], states.size)
    return replace(compiled, state=moved)


def _states(run: xr.Dataset) -> np.ndarray:
    """Positions, velocities and contact nodes (nt, n) of a run [m, rad, s]."""
    parts = [run.position.values, run.velocity.values, run.fender_node.values]
    return np.hstack([part.reshape(len(part), -1) for part in parts])


def refused(scene: Scene) -> bool:
    """Whether a run at 0.95 of the predicted limit is refused where unstable steps are."""
    step = 0.95 * predicted(scene)
    solver = replace(scene.solver, step=step, unstable=Unstable.ERROR)
    try:
        simulate(replace(scene, solver=solver, duration=step).with_output(step=step))
    except InputError:
        return True
    return False
