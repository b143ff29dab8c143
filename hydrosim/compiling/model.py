"""From a scene to arrays: `compile_scene` makes the constant `Model` and the first `State`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import ceil, cos, sin

import numpy as np

from hydrosim import forces, radiation
from hydrosim.compiling import restart
from hydrosim.compiling.notes import Notes, take_note
from hydrosim.compiling.wet import WetGroup, each_alone, resonance, wet_groups
from hydrosim.database import HydroDatabase, needed
from hydrosim.dofs import DOFS
from hydrosim.errors import InputError
from hydrosim.forces import FENDER, SPRING, Recorded, Spring, new_modes, settle, signals_of
from hydrosim.forces.contact import fender
from hydrosim.forces.contact.modes import MODE, OPEN, STICK
from hydrosim.forces.layout import ROWS, Layout, Resonance
from hydrosim.forces.signal import corners
from hydrosim.forces.spring import stretch
from hydrosim.integrate import DOPRI5, ESDIRK4, HEUN, RK2, RK4, Control, Tableau
from hydrosim.radiation import StateSpace
from hydrosim.radiation.state_space import coupled_groups
from hydrosim.results.names import spring_names
from hydrosim.rigid import BODY, Bodies, Motion, constant_inertia, place_bodies
from hydrosim.scene import (
    ADAPTIVE,
    Body,
    ConvolutionRadiation,
    Environment,
    Kinematics,
    Method,
    Scene,
    Stream,
)
from hydrosim.stepping.dynamics import Model, new_work
from hydrosim.stepping.run import Clock
from hydrosim.stepping.stepper import State
from hydrosim.waves import WaveBody, following_model, sea, wave_loads_model

METHODS: dict[Method, Tableau] = {
    Method.RK2: RK2,
    Method.HEUN: HEUN,
    Method.RK4: RK4,
    Method.DOPRI5: DOPRI5,
    Method.ESDIRK4: ESDIRK4,
}
TOGETHER = 1e-9  # of a spring's length: its ends are at one place


def compile_scene(scene: Scene, notes: Notes | None = None) -> tuple[Model, State]:
    """The scene as arrays, and its state at the start; ``notes`` are filled if given. All degrees
    of freedom are there: `simulate` takes out first what is zero by symmetry, see
    `hydrosim.compiling.symmetry`.

    Raises InputError where a database or a run to start from cannot be read or does not fit the
    scene.
    """
    notes = Notes() if notes is None else notes
    scene = restart.opened(scene)
    model, state = compile_calm(scene, notes)
    return add_waves(scene, model, notes), state


def compile_calm(scene: Scene, notes: Notes) -> tuple[Model, State]:
    """An `opened` scene in calm water: scenes that differ in their waves alone have it in common.

    Fills the databases of ``notes`` unless they are there; raises as `compile_scene` does.
    """
    check_scene(scene)
    notes.wet = notes.wet or wet_groups(scene)
    bodies, alone = _bodies(scene), each_alone(notes.wet)
    groups = [group for wet in notes.wet for group in _groups(wet, bodies.active)]
    states = radiation.state_space_model(groups)
    first = 2 * bodies.active.size
    layout = _layout(scene, first + states.decay.size, alone)
    elements = forces.compile_elements(scene.forces, layout)
    energy = layout.state + fender.STATES * elements[FENDER].points.size
    rows = len(ROWS) + len(scene.forces)
    added_mass = _whole(scene, [(w.dofs, w.added_mass) for w in notes.wet])
    model = Model(
        bodies=bodies,
        added_mass=added_mass,
        inertia=constant_inertia(bodies, added_mass),
        stiffness=_stiffness(scene, alone),
        states=states,
        convolution=_convolution(scene, notes.wet, bodies.active),
        damping=radiation.constant_damping(
            _whole(scene, [(wet.dofs, wet.damping) for wet in notes.wet])
        ),
        waves=wave_loads_model(Environment(), (), 0.0, scene.solver.step, scene.duration),
        following=following_model((), ()),
        elements=elements,
        rows=rows,
        radiation=first,
        energy=energy,
        size=energy + rows + 1,
    )
    state = _first_state(scene, model)
    _check_rigid_friction(scene, model, state)
    _check_springs(scene, model, state)
    if scene.initial is None:
        return model, state
    restart.check_fit(scene, model)
    return model, restart.resume(scene, model, state)


def add_waves(scene: Scene, calm: Model, notes: Notes) -> Model:
    """The model of `compile_calm` in the waves of its scene; ``notes`` are filled but for the
    databases, which must be there. Raises InputError where a database does not fit the waves."""
    in_waves = wave_bodies(scene, notes.wet)
    model = calm._replace(
        waves=wave_loads_model(
            scene.environment,
            in_waves,
            # from 0, wherever the run begins: its loads are then to the bit those of a longer run
            *(0.0, scene.solver.step / 2, restart.begin(scene) + scene.duration),
        ),
        following=following_model(sea(scene.environment), in_waves),
    )
    take_note(scene, model, notes)
    return model


def check_scene(scene: Scene) -> None:
    """Raises InputError where a scene is wrong as no case file can be, but one written in Python
    can."""
    names = [body.name for body in scene.bodies]
    steps = scene.output_step / scene.solver.step if scene.solver.step > 0.0 else 0.0
    whole = scene.solver.method in ADAPTIVE or abs(steps - round(steps)) <= 1e-9 * steps
    problems = {
        "bodies: there are none, or two of one name": not names or len({*names}) < len(names),
        "bodies: none has a degree of freedom": not any(body.dofs for body in scene.bodies),
        "duration, solver.step: must be above 0": not min(scene.duration, scene.solver.step) > 0.0,
        "output_step: must be a whole multiple of solver.step": not (whole and round(steps) >= 1),
    }
    for name, element in scene.forces.items():
        problems[f"forces.{name}.body: there is no body {element.body}"] = element.body not in names
        if isinstance(element, Spring) and element.anchor_body is not None:
            text = f"forces.{name}.anchor_body: there is no body {element.anchor_body}"
            problems[text] = element.anchor_body not in names
    found = [problem for problem, there in problems.items() if there]
    if found:
        raise InputError("scene: " + "; ".join(found) + ".")
    for key, signal in signals_of(scene.forces):
        if isinstance(signal, Recorded):
            _check_record(key, signal.time, scene.duration)
    for name, element in scene.forces.items():
        if isinstance(element, fender.Fender):
            _check_rate_free(name, element)


def _check_record(key: str, time: np.ndarray, duration: float) -> None:
    """A record is not known outside its times."""
    if time[0] > 0.0 or time[-1] < duration * (1.0 - 1e-9):
        raise InputError(
            f"{key}: found a record from {time[0]:g} s to {time[-1]:g} s; expected one of the whole"
            f" run, from 0 s to its end at {duration:g} s. Shorten the duration, or record more."
        )


def _check_rate_free(name: str, element: fender.Fender) -> None:
    """Slip without damping needs N' and constant coefficients."""
    law, curve = element.friction, element.normal
    if not isinstance(law, fender.StickSlip) or law.damping + law.slip_damping > 0.0:
        return
    damped = isinstance(curve, fender.NormalCurve) and curve.damping > 0.0
    if law.load or damped:
        found = "a load" if law.load else "normal damping"
        raise InputError(
            f"forces.{name}.friction: found {found} and friction without damping and slip_damping;"
            f" expected one of the latter above 0, or no {found.split()[-1]}."
        )


def _check_rigid_friction(scene: Scene, model: Model, state: State) -> None:
    """Refuse rigid friction in more directions than there is motion to hold."""
    fenders, work, n = model.elements[FENDER], new_work(model), model.bodies.active.size
    rigid = fenders.points["law"] == fender.COULOMB
    if not rigid.any():
        return
    held = state.modes[: rigid.size].copy()
    held[:, MODE] = np.where(rigid, STICK, OPEN)
    place_bodies(state.y[:n], state.y[n : 2 * n], model.bodies, work.motion)
    fender.hold_points(held, work.motion, model.bodies, fenders, work.total, work.holds)
    rows = work.holds.constraints.J[: work.holds.constraints.number[0]]
    rank = np.linalg.matrix_rank(rows / np.maximum(np.abs(rows).max(axis=0), 1e-12), tol=1e-9)
    if rank < len(rows):
        rows_of = set(fenders.points["row"][rigid] - len(ROWS))
        names = ", ".join(name for i, name in enumerate(scene.forces) if i in rows_of)
        raise InputError(
            f"forces.{names}: rigid friction holds {len(rows)} directions at {rigid.sum()} points"
            f" where the bodies can move in {rank} of them, and how the points share the load is"
            " not defined; expected law: stick_slip there (with a large stiffness, if it must be),"
            " or fewer points."
        )


def _check_springs(scene: Scene, model: Model, state: State) -> None:
    """Refuse springs whose ends are at one place at the start."""
    motion, n = new_work(model).motion, model.bodies.active.size
    place_bodies(state.y[:n], state.y[n : 2 * n], model.bodies, motion)
    for name, line in zip(spring_names(scene), model.elements[SPRING].lines, strict=True):
        if stretch(line, model.bodies, motion).length <= TOGETHER * line["length"]:
            raise InputError(
                f"forces.{name}: its point and its anchor are at the same place at the start;"
                " expected two places (point is in the body's frame, about its centre of gravity;"
                " anchor in the earth's, or in that of anchor_body)."
            )


def compile_clock(scene: Scene, model: Model) -> Clock:
    """The grid of steps, the output times on it, the times that no step may cross, tolerances."""
    solver, begin = scene.solver, restart.begin(scene)
    adaptive = solver.method in ADAPTIVE
    step = scene.output_step if adaptive else solver.step
    # a run that starts on the grid of one from 0 keeps to it, so that its steps are the same
    passed = round(begin / step)
    on_grid = abs(passed * step - begin) <= 1e-9 * step * max(passed, 1)
    ramps = [w.ramp for w in scene.environment.waves]
    tables = [corners(signal) for _, signal in signals_of(scene.forces)]
    breakpoints = np.unique(np.concatenate([ramps, *tables]))
    return Clock(
        start=0.0 if on_grid else begin,
        first=passed if on_grid else 0,
        step=step,
        end=begin + scene.duration,
        points=ceil(scene.duration / step - 1e-9),
        every=round(scene.output_step / step),
        breakpoints=breakpoints[(breakpoints > begin) & (breakpoints < begin + scene.duration)],
        events=solver.events,
        control=Control(adaptive, solver.tolerance.relative, _tolerances(scene, model)),
        pace=solver.step,
    )


def _tolerances(scene: Scene, model: Model) -> np.ndarray:
    """Absolute tolerance of every state (ny,): radiation states by what a velocity of the tolerance
    would make of them in the long run; slip distances and energies do not count."""
    tolerance, fenders = scene.solver.tolerance, model.elements[FENDER]
    n, states = model.bodies.active.size, model.states
    absolute = np.full(model.size, np.inf)
    place = np.where(model.bodies.active % 6 < 3, tolerance.position, tolerance.angle)
    absolute[:n] = absolute[n : 2 * n] = place
    by_dof = np.tile(np.repeat([tolerance.position, tolerance.angle], 3), len(scene.bodies))
    for g, first in enumerate(states.state[:-1]):
        members = states.dof[states.member[g] : states.member[g + 1]]
        size = states.state[g + 1] - first
        B = states.B[states.matrix[g] :][: members.size * size].reshape(members.size, size)
        reach = by_dof[members] @ np.abs(B) / -states.decay[first : first + size]
        absolute[model.radiation + first :][:size] = reach
    for i in range(fenders.points.size):
        absolute[fenders.state + fender.STATES * i :][:2] = tolerance.position
    return absolute


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
        exact=scene.solver.kinematics == Kinematics.EXACT,
    )


def _groups(wet: WetGroup, active: np.ndarray) -> list[StateSpace]:
    """State-space models of a database, on the scene's DOFs; not those of locked DOFs alone."""
    placed = [replace(fit, dofs=wet.dofs[fit.dofs]) for fit in wet.fits]
    return [fit for fit in placed if np.isin(fit.dofs, active).any()]


def _whole(scene: Scene, blocks: Sequence[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """(..., 6 nb, 6 nb) array of blocks (..., m, m), each on its own DOFs (m,) of the scene."""
    leading = next((block.shape[:-2] for _, block in blocks), ())
    whole = np.zeros((*leading, 6 * len(scene.bodies), 6 * len(scene.bodies)))
    for dofs, block in blocks:
        whole[..., dofs[:, None], dofs] = block
    return whole


def _stiffness(scene: Scene, alone: Mapping[str, HydroDatabase]) -> np.ndarray:
    dry = np.zeros((6, 6))
    rows = [
        needed(alone[b.name], "hydrostatic_stiffness") if b.name in alone else dry
        for b in scene.bodies
    ]
    return np.array(rows)


def _convolution(
    scene: Scene, groups: Sequence[WetGroup], active: np.ndarray
) -> radiation.ConvolutionKernel:
    chosen = [wet for wet in groups if isinstance(wet.radiation, ConvolutionRadiation)]
    settings = list({wet.radiation: wet.memory.time[1] for wet in chosen}.values())
    if not settings:
        return radiation.convolution_model(1.0, np.zeros((2, 0, 0)))
    if len(settings) > 1:
        names = ", ".join(name for wet in chosen for name in wet.names)
        raise InputError(
            f"bodies.{names}.radiation: found convolutions with different tables; expected one"
            " length and one step for all of them."
        )
    kernels = _whole(scene, [(wet.dofs, _kernel(wet, active)) for wet in chosen])
    if scene.solver.method in ADAPTIVE:
        return radiation.convolution_model(settings[0], kernels)
    stages = METHODS[scene.solver.method].c.tolist()
    return radiation.convolution_model(settings[0], kernels, scene.solver.step, stages)


def _kernel(wet: WetGroup, active: np.ndarray) -> np.ndarray:
    """Retardation functions of a database, without those of locked DOFs alone."""
    kernel = wet.memory.kernel.copy()
    for dofs in coupled_groups(kernel):
        if not np.isin(wet.dofs[dofs], active).any():
            kernel[:, dofs[:, None], dofs] = 0.0
    return kernel


def wave_bodies(scene: Scene, groups: Sequence[WetGroup]) -> list[WaveBody]:
    """All bodies of a scene in waves, with their own parts of the databases."""
    alone = each_alone(groups)
    return [_wave_body(i, body, alone) for i, body in enumerate(scene.bodies)]


def _wave_body(index: int, body: Body, alone: Mapping[str, HydroDatabase]) -> WaveBody:
    return WaveBody(
        alone.get(body.name),
        body.location,
        body.wave_forces,
        6 * index,
        np.array([dof in body.dofs for dof in DOFS]),
        body.centre_of_gravity[:2],
    )


def _layout(scene: Scene, state: int, alone: Mapping[str, HydroDatabase]) -> Layout:
    def of_body(body: int, stiffness: np.ndarray) -> Resonance:
        return resonance(scene.bodies[body], stiffness, alone.get(scene.bodies[body].name))

    return Layout(
        {body.name: i for i, body in enumerate(scene.bodies)},
        {name: len(ROWS) + i for i, name in enumerate(scene.forces)},
        state,
        *(_velocity(scene.environment.current), _velocity(scene.environment.wind)),
        of_body,
    )


def _velocity(stream: Stream) -> tuple[float, float]:
    return stream.speed * cos(stream.heading), stream.speed * sin(stream.heading)


def _first_state(scene: Scene, model: Model) -> State:
    bodies, n = model.bodies, model.bodies.active.size
    y = np.zeros(model.size)
    y[:n] = bodies.locked[bodies.active]
    modes, motion = new_modes(model.elements), new_work(model).motion
    speeds = np.concatenate([b.velocity for b in scene.bodies])
    y[n : 2 * n] = _rates(bodies, motion, y[:n], speeds)
    place_bodies(y[:n], y[n : 2 * n], bodies, motion)
    settle(0.0, y, modes, motion, bodies, model.elements)
    return State(y, modes, _history(scene, model))


def _rates(bodies: Bodies, motion: Motion, q: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Rates of the free coordinates for given velocities (6 nb,): angles' rates are E^-1 omega."""
    place_bodies(q, np.zeros_like(q), bodies, motion)
    rates = velocity.astype(float).copy()
    for b in range(bodies.each.size if bodies.exact else 0):
        angles = slice(6 * b + 3, 6 * b + 6)
        rates[angles] = np.linalg.solve(motion.rate_map[b], velocity[angles])
    return rates[bodies.active]


def _history(scene: Scene, model: Model) -> radiation.VelocityHistory:
    """Room for what a convolution remembers, with as many events as steps."""
    kernel = model.convolution
    length = (len(kernel.K) - 1) * kernel.step
    capacity = 2 * ceil(length / scene.solver.step) + 1000
    return radiation.history_for(kernel, 6 * model.bodies.each.size, capacity)
