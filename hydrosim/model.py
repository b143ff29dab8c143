"""From a scene to arrays: `compile_scene` makes the constant `Model` and the first `State`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import ceil, inf

import numpy as np

from hydrosim import database, forces, radiation
from hydrosim.database import HydroDatabase
from hydrosim.dynamics import Model, new_work
from hydrosim.errors import InputError
from hydrosim.forces import FENDER, AppliedForce
from hydrosim.forces.contact import fender
from hydrosim.forces.layout import ROWS, Layout
from hydrosim.radiation import Retardation, StateSpace
from hydrosim.rigid import BODY, Bodies, Motion, place_bodies
from hydrosim.run import Clock, State
from hydrosim.scene import DOFS, Body, Kinematics, RadiationModel, Scene
from hydrosim.waves import WaveBody, wave_loads_model

MEMORY_LENGTH = 80.0  # s: of the retardation functions
MEMORY_STEP = 0.1  # s: of their tables
MASS_TOLERANCE = 0.01  # relative difference of mass and displaced mass that is worth a word


@dataclass(frozen=True)
class WetBody:
    """A body's database about its own centre of gravity, for all headings, and its radiation in
    the time domain: retardation functions and, for a state-space model, their fits."""

    database: HydroDatabase
    memory: Retardation
    fits: tuple[StateSpace, ...] = ()

    def provenance(self) -> dict[str, str]:
        """What the run's record says of it."""
        report, db = self.memory.report, self.database
        fits = [
            f"{group.B.shape[0]} states for {', '.join(DOFS[i] for i in group.dofs)},"
            f" error {group.report.frequency_error:.1e} in frequency,"
            f" {group.report.time_error:.1e} in time, passivity {group.report.passivity_margin:.1e}"
            for group in self.fits
        ]
        return {
            "database": db.source,
            "database_checksum": db.checksum,
            "radiation": "; ".join(fits) or "no state space",
            "retardation": f"|K(T)|/max|K| {report.end_ratio:.1e}, B(w_max)/max B"
            f" {report.band_ratio:.1e}, Ogilvie residual {report.ogilvie_residual:.1e}, smallest"
            f" eigenvalue of B {report.smallest_eigenvalue:.1e}",
        }


@dataclass
class Notes:
    """What compiling found out: ``skipped`` parts, ``warnings``, and the databases in use."""

    skipped: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    wet: dict[str, WetBody] = field(default_factory=dict)


def compile_scene(scene: Scene, notes: Notes | None = None) -> tuple[Model, State]:
    """The scene as arrays, and its state at time 0; ``notes`` are filled if given.

    Raises InputError where a database cannot be read or does not fit the scene.
    """
    notes = Notes() if notes is None else notes
    notes.wet.update({b.name: w for b in scene.bodies if (w := wet_body(b, scene)) is not None})
    bodies = _bodies(scene)
    groups = [group for i, b in enumerate(scene.bodies) for group in _groups(i, b, notes.wet)]
    states = radiation.state_space_model(groups)
    first = 2 * bodies.active.size
    layout = _layout(scene, first + states.decay.size, notes.wet)
    elements = forces.compile_elements(scene.forces, layout)
    energy = layout.state + fender.STATES * elements[FENDER].points.size
    rows = len(ROWS) + len(scene.forces)
    model = Model(
        bodies=bodies,
        added_mass=_blocks(scene, {n: w.memory.added_mass_infinite for n, w in notes.wet.items()}),
        stiffness=_stiffness(scene, notes.wet),
        states=states,
        convolution=_convolution(scene, notes.wet),
        waves=wave_loads_model(
            scene.environment,
            [_wave_body(i, b, notes.wet) for i, b in enumerate(scene.bodies)],
            *(0.0, scene.solver.step / 2, scene.duration),
        ),
        elements=elements,
        rows=rows,
        radiation=first,
        energy=energy,
        size=energy + rows + 1,
    )
    _note(scene, model, notes)
    return model, _first_state(scene, model)


def compile_clock(scene: Scene) -> Clock:
    """The grid of steps, the output times on it, and the times that no step may cross."""
    ramps = [w.ramp for w in scene.environment.waves]
    tables = [e.time for e in scene.forces.values() if isinstance(e, AppliedForce)]
    corners = np.unique(np.concatenate([ramps, *tables])) if ramps or tables else np.zeros(0)
    return Clock(
        start=0.0,
        step=scene.solver.step,
        end=scene.duration,
        steps=ceil(scene.duration / scene.solver.step - 1e-9),
        every=round(scene.output_step / scene.solver.step),
        breakpoints=corners[(corners > 0.0) & (corners < scene.duration)],
        events=scene.solver.events,
    )


def wet_body(body: Body, scene: Scene) -> WetBody | None:
    """The body's hydrodynamics about its centre of gravity; None for a dry body."""
    if body.hydrodynamics is None:
        return None
    db = body.hydrodynamics
    db = db if isinstance(db, HydroDatabase) else database.load(db)
    if db.bodies != 1:
        raise InputError(
            f"{db.source}: has {db.bodies} bodies, but bodies.{body.name} needs a database of one."
        )
    _check_environment(db, body, scene)
    db = database.all_headings(database.move_reference(db, body.centre_of_gravity))
    memory = radiation.retardation(
        *(db.frequency, db.added_mass, db.radiation_damping), length=MEMORY_LENGTH, step=MEMORY_STEP
    )
    if body.radiation is not RadiationModel.STATE_SPACE:
        return WetBody(db, memory)
    return WetBody(db, memory, radiation.fit(db.checksum, memory, db.frequency))


def _check_environment(db: HydroDatabase, body: Body, scene: Scene) -> None:
    water = scene.environment
    for name in ("water_density", "gravity", "water_depth"):
        here, there = getattr(water, name), getattr(db, name)
        if here != there and not (here < inf and abs(here - there) <= 1e-3 * here):
            raise InputError(
                f"environment.{name}: found {here:g}, but {db.source} of bodies.{body.name} was"
                f" made for {there:g}. Use a database made for this water, or change the case."
            )


def _bodies(scene: Scene) -> Bodies:
    active = [
        6 * i + DOFS.index(dof)
        for i, body in enumerate(scene.bodies)
        for dof in sorted(body.dofs, key=DOFS.index)
    ]
    each = [
        (b.mass, b.inertia, np.add(b.centre_of_gravity, (*b.location, 0.0))) for b in scene.bodies
    ]
    return Bodies(
        each=np.array(each, dtype=BODY),
        active=np.array(active, dtype=np.int64),
        locked=np.concatenate([b.position for b in scene.bodies]).astype(float),
        exact=scene.solver.kinematics is Kinematics.EXACT,
    )


def _groups(index: int, body: Body, wet: dict[str, WetBody]) -> list[StateSpace]:
    """State-space models of a body, on the scene's DOFs; not those of locked DOFs alone."""
    if body.name not in wet:
        return []
    free = np.array([dof in body.dofs for dof in DOFS])
    return [
        replace(fit, dofs=6 * index + fit.dofs)
        for fit in wet[body.name].fits
        if free[fit.dofs].any()
    ]


def _blocks(scene: Scene, blocks: dict[str, np.ndarray]) -> np.ndarray:
    """Block-diagonal (..., 6 nb, 6 nb) array of the bodies' (..., 6, 6) blocks."""
    leading = next((b.shape[:-2] for b in blocks.values()), ())
    whole = np.zeros((*leading, 6 * len(scene.bodies), 6 * len(scene.bodies)))
    for i, body in enumerate(scene.bodies):
        if body.name in blocks:
            whole[..., 6 * i : 6 * i + 6, 6 * i : 6 * i + 6] = blocks[body.name]
    return whole


def _stiffness(scene: Scene, wet: dict[str, WetBody]) -> np.ndarray:
    dry = np.zeros((6, 6))
    rows = [
        wet[b.name].database.hydrostatic_stiffness if b.name in wet else dry for b in scene.bodies
    ]
    return np.array(rows)


def _convolution(scene: Scene, wet: dict[str, WetBody]) -> radiation.ConvolutionKernel:
    chosen = [b.name for b in scene.bodies if b.radiation is RadiationModel.CONVOLUTION]
    kernels = {name: wet[name].memory.kernel for name in chosen if name in wet}
    if not kernels:
        return radiation.convolution_model(MEMORY_STEP, np.zeros((2, 0, 0)))
    return radiation.convolution_model(MEMORY_STEP, _blocks(scene, kernels))


def _wave_body(index: int, body: Body, wet: dict[str, WetBody]) -> WaveBody:
    return WaveBody(
        wet[body.name].database if body.name in wet else None,
        body.location,
        body.wave_forces,
        6 * index,
        np.array([dof in body.dofs for dof in DOFS]),
    )


def _layout(scene: Scene, state: int, wet: dict[str, WetBody]) -> Layout:
    def critical_damping(body: int, stiffness: np.ndarray) -> np.ndarray:
        return _critical_damping(scene.bodies[body], stiffness, wet)

    return Layout(
        {body.name: i for i, body in enumerate(scene.bodies)},
        {name: len(ROWS) + i for i, name in enumerate(scene.forces)},
        state,
        critical_damping,
    )


def _critical_damping(body: Body, stiffness: np.ndarray, wet: dict[str, WetBody]) -> np.ndarray:
    """2 sqrt(k (m + a(w_n))) per DOF (6,), w_n the natural frequency with hydrostatics."""
    mass = np.array([body.mass] * 3 + list(np.diag(body.inertia)))
    if body.name not in wet:
        return 2.0 * np.sqrt(np.maximum(stiffness, 0.0) * mass)
    db = wet[body.name].database
    total = np.maximum(stiffness + np.diag(db.hydrostatic_stiffness), 0.0)
    heavy = mass + [
        _added_mass_in_resonance(db, i, m, k) for i, m, k in zip(range(6), mass, total, strict=True)
    ]
    return 2.0 * np.sqrt(np.maximum(stiffness, 0.0) * heavy)


def _added_mass_in_resonance(db: HydroDatabase, dof: int, mass: float, stiffness: float) -> float:
    """a(w_n) with w_n^2 = k / (m + a(w_n)), by fixed-point iteration."""
    added = db.added_mass[:, dof, dof]
    a = added[0]
    for _ in range(50):
        a = np.interp(np.sqrt(stiffness / (mass + a)), db.frequency, added)
    return float(a)


def _first_state(scene: Scene, model: Model) -> State:
    bodies, n = model.bodies, model.bodies.active.size
    y = np.zeros(model.size)
    y[:n] = bodies.locked[bodies.active]
    p = model.elements[FENDER]
    modes = np.zeros((p.points.size, 2), dtype=np.int64)
    motion = new_work(model).motion
    speeds = np.concatenate([b.velocity for b in scene.bodies])
    y[n : 2 * n] = _rates(bodies, motion, y[:n], speeds)
    place_bodies(y[:n], y[n : 2 * n], bodies, motion)
    fender.settle(y, modes, motion, bodies, p)
    return State(y, modes, radiation.velocity_history(6 * bodies.each.size, _nodes(scene, model)))


def _rates(bodies: Bodies, motion: Motion, q: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Rates of the free coordinates for given velocities (6 nb,): angles' rates are E^-1 omega."""
    place_bodies(q, np.zeros_like(q), bodies, motion)
    rates = velocity.astype(float).copy()
    for b in range(bodies.each.size if bodies.exact else 0):
        angles = slice(6 * b + 3, 6 * b + 6)
        rates[angles] = np.linalg.solve(motion.rate_map[b], velocity[angles])
    return rates[bodies.active]


def _nodes(scene: Scene, model: Model) -> int:
    """Room for the velocities that a convolution remembers, with as many events as steps."""
    if model.convolution.row.size == 0:
        return 0
    return 2 * ceil(MEMORY_LENGTH / scene.solver.step) + 1000


def _note(scene: Scene, model: Model, notes: Notes) -> None:
    notes.skipped.extend(_skipped(scene, model, notes.wet))
    for body in scene.bodies:
        if body.name in notes.wet:
            db = notes.wet[body.name].database
            displaced = db.water_density * float(db.volume[0])
            if abs(body.mass - displaced) > MASS_TOLERANCE * displaced:
                notes.warnings.append(
                    f"bodies.{body.name}.mass {body.mass:.4g} kg is not the displaced mass of its"
                    f" database, {displaced:.4g} kg; weight and buoyancy are taken to balance."
                )


def _skipped(scene: Scene, model: Model, wet: dict[str, WetBody]) -> Sequence[str]:
    lines = []
    for body in scene.bodies:
        locked = [dof for dof in DOFS if dof not in body.dofs]
        if locked:
            lines.append(f"{body.name}: {', '.join(locked)} locked, not in the state")
        if body.name not in wet:
            lines.append(f"{body.name}: dry, no hydrostatics, radiation or wave loads")
    unloaded = [
        f"{scene.bodies[i // 6].name} {DOFS[i % 6]}"
        for i in model.bodies.active
        if scene.bodies[i // 6].name in wet and i not in model.waves.first_dof
    ]
    if scene.environment.waves and unloaded:
        lines.append("no first-order load, not synthesised: " + ", ".join(unloaded))
    if not scene.environment.waves:
        lines.append("no waves: no wave loads")
    if model.waves.second_dof.size == 0:
        lines.append("no second-order loads")
    return lines
