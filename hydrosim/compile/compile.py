"""Compilation of a scene to arrays: constants of its equation of motion, with or without waves."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from enum import StrEnum
from typing import Any

import numpy as np

from hydrosim import elements as forces
from hydrosim.compile import families, symmetry
from hydrosim.compile.automatic import with_method, with_tolerance
from hydrosim.compile.compiled import Compiled, DerivedData, derive_data
from hydrosim.compile.drives import check_driven_start
from hydrosim.compile.families import members_of_families, scene_groups
from hydrosim.compile.hydrodynamic_groups import (
    HydrodynamicGroup,
    each_alone,
    moving,
    scene_with_states,
    uncoupled_resonance,
)
from hydrosim.compile.hydrostatics import hulls_of, liquids_of
from hydrosim.compile.joints import bodies_of, with_dofs_of_joints
from hydrosim.compile.line_drag import with_line_drag
from hydrosim.compile.questions import describe_doubts, query_messages
from hydrosim.compile.questions.query import describe_start
from hydrosim.compile.restart import initial_headings, memory_before, open_start, start_time
from hydrosim.compile.roll_mode import roll_mode
from hydrosim.compile.scene_notes import notes_of_sea
from hydrosim.compile.start import first_state, start_of, with_slow_places
from hydrosim.compile.tanks import tanks_of, weights_of
from hydrosim.compile.validate_scene import check_scene, check_start
from hydrosim.database.database import HydroDatabase, require_array
from hydrosim.dofs import DOFS, about_z
from hydrosim.elements import events, heights_of_wind, in_gusts, kind
from hydrosim.elements.line.catenary import Catenary
from hydrosim.errors import InputError
from hydrosim.files.yaml_nodes import source_context
from hydrosim.integrate import draught_interpolation
from hydrosim.integrate.dynamics import Model
from hydrosim.multibody.heading import Headings, new_headings
from hydrosim.multibody.kinematics import Bodies
from hydrosim.multibody.mass import constant_inertia
from hydrosim.results.memory import named_points, point_names
from hydrosim.scene import Kinematics, Place, RadiationModel, Scene, Solver, WaveForces
from hydrosim.scene.scene import arrangement
from hydrosim.tanks.contents import Tanks, tank_names, triggered_pumps
from hydrosim.water import radiation
from hydrosim.water.body import WaveBody
from hydrosim.water.build import wave_loads_model
from hydrosim.water.components import WaveComponents, check_span, sea
from hydrosim.water.current import current_table, currents_on, draught_of
from hydrosim.water.displaced_loads import (
    STATES_PER_FOLLOWED_BODY,
    following_model,
    grid_step,
    met_by_waves,
    slow_bodies,
    steps_per_block,
)
from hydrosim.water.loads import MISSED
from hydrosim.water.radiation.state_space import TOLERANCE, StateSpace
from hydrosim.water.radiation.threads import one_thread
from hydrosim.water.wind import gust_table, mean_wind

# Constants of the equation of motion, from a scene and its databases.

SAME_STEP = 1e-9  # relative difference of table steps that is rounding


def model_of(
    scene: Scene, wet: Sequence[HydrodynamicGroup], kind_constants: kind.KindConstants | None = None
) -> Model:
    """Model of a scene in calm water; its elements and tanks are compiled unless they are
    ``kind_constants``.

    Raises InputError if radiation or an element does not fit the scene.
    """
    bodies = bodies_of(scene)
    alone = each_alone(wet)
    free = moving(scene.bodies)
    family = families.family_constants(scene, wet)
    size = 6 * (len(scene.bodies) + family.owner.size)
    members = list(families.groups_with_dofs(wet, len(scene.bodies)))
    groups = [fit for dofs, group in members for fit in _compile_groups(group, dofs, free)]
    states = radiation.state_space_model(groups)
    radiating = 2 * bodies.active.size
    own_states = radiating + states.decay.size
    if kind_constants is None:
        tanks = tanks_of(scene)
        elements = forces.compile_elements(
            scene.forces, _compile_layout(scene, bodies, alone, tanks)
        )
        kind_constants = forces.IndexedConstants(elements, tanks)
    elif bodies.tree.moves.size or forces.driven_coordinates(kind_constants.elements).size:
        # numbers of coordinates may differ
        layout = _compile_layout(scene, bodies, alone, kind_constants.tanks)
        kind_constants = forces.renumber_coordinates(kind_constants, scene.forces, layout)
    slow = own_states + forces.state_count(kind_constants, scene)
    draught = slow + STATES_PER_FOLLOWED_BODY * len(slow_bodies(scene, met_by_waves(scene, alone)))
    energy = draught + draught_interpolation.DRAUGHT_STATES * family.body.size
    parts = forces.assign_indices(kind_constants, scene, own_states, energy)
    rows = kind.row_names(scene)
    impulse = energy + len(rows) + 1
    blocks = [(group.dofs, group.added_mass) for group in wet]
    added_mass = _assemble_blocks(6 * len(scene.bodies), blocks)
    return Model(
        bodies=bodies,
        headings=_compile_headings(scene, bodies, alone),
        added_mass=added_mass,
        inertia=constant_inertia(bodies, added_mass),
        stiffness=_compile_stiffness(scene, alone),
        hulls=hulls_of(scene, bodies),
        states=states,
        convolution=_compile_convolution(6 * len(scene.bodies), wet, free),
        damping=radiation.constant_damping(
            _assemble_blocks(size, [(dofs, group.damping) for dofs, group in members])
        ),
        waves=wave_loads_model((), (), 0.0, scene.solver.step, scene.duration),
        following=following_model((), ()),
        family=family,
        elements=events.with_output_starts(parts.elements),
        tanks=parts.tanks,
        liquids=liquids_of(scene, bodies),
        weights=weights_of(scene, alone, rows),
        rows=len(rows),
        radiation=radiating,
        own=own_states,
        slow=slow,
        draught=draught,
        energy=energy,
        impulse=impulse,
        size=impulse + (_impulse_count(len(rows), bodies, parts) if scene.output_impulses else 0),
    )


def _impulse_count(rows: int, bodies: Bodies, parts: kind.KindConstants) -> int:
    """Number of integrals of impulses: of forces, of their works, and of units."""
    return 2 * rows * 6 * bodies.each.size + forces.tally_count(parts)


def _compile_headings(scene: Scene, bodies: Bodies, wet: Collection[str]) -> Headings:
    """Heading axes of the bodies, and the current in these axes, at the start of the first run."""
    current = currents_on(scene, wet)
    stream = np.zeros((len(scene.bodies), 6))
    for b, psi in enumerate(initial_headings(scene)):
        stream[b, :3] = about_z(psi).T @ (*current[b], 0.0)
    has_water = np.array([body.name in wet for body in scene.bodies])
    return new_headings(bodies, has_water, current, stream.ravel())


def _compile_groups(wet: HydrodynamicGroup, dofs: np.ndarray, free: np.ndarray) -> list[StateSpace]:
    """State-space models of a database on its own ``dofs``, without DOFs that are zero by
    symmetry."""
    moving = [fit for fit in wet.fits if np.isin(wet.dofs[fit.dofs], free).any()]
    return [replace(fit, dofs=dofs[fit.dofs]) for fit in moving]


def _assemble_blocks(size: int, blocks: Sequence[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Array (..., size, size) of blocks (..., m, m), each on its own DOFs (m,)."""
    leading = next((block.shape[:-2] for _, block in blocks), ())
    whole = np.zeros((*leading, size, size))
    for dofs, block in blocks:
        whole[..., dofs[:, None], dofs] = block
    return whole


def _compile_stiffness(scene: Scene, alone: Mapping[str, HydroDatabase]) -> np.ndarray:
    none = np.zeros((6, 6))
    rows = [
        require_array(alone[b.name], "hydrostatic_stiffness")
        if b.name in alone and b.hydrostatics is None
        else none
        for b in scene.bodies
    ]
    return np.array(rows)


def _compile_convolution(
    size: int, groups: Sequence[HydrodynamicGroup], free: np.ndarray
) -> radiation.ConvolutionKernel:
    chosen = [wet for wet in groups if wet.convolved]
    if not chosen:
        return radiation.convolution_model(1.0, np.zeros((2, 0, 0)))
    times = [wet.memory.time for wet in chosen]
    steps = [time[1] for time in times]
    if max(steps) - min(steps) > SAME_STEP * min(steps):
        names = ", ".join(name for wet in chosen for name in wet.names)
        raise InputError(
            f"bodies.{names}.radiation: found convolutions with tables of different steps;"
            " expected one step for all. Some of them may be chosen by automatic because no fit"
            " meets the tolerance."
        )
    rows = max(time.size for time in times)
    kernels = _assemble_blocks(
        size, [(wet.dofs, _pad_kernel(_compile_kernel(wet, free), rows)) for wet in chosen]
    )
    return radiation.convolution_model(steps[0], kernels)


def _pad_kernel(kernel: np.ndarray, rows: int) -> np.ndarray:
    """Kernel padded with zeros, because a memory may be shorter than another."""
    return np.pad(kernel, ((0, rows - len(kernel)), (0, 0), (0, 0)))


def _compile_kernel(wet: HydrodynamicGroup, free: np.ndarray) -> np.ndarray:
    """Retardation functions of the convolved groups of DOFs of a database, without groups whose
    DOFs are all locked."""
    kernel = np.zeros_like(wet.memory.kernel)
    for dofs, _ in wet.convolved:
        if np.isin(wet.dofs[dofs], free).any():
            kernel[:, dofs[:, None], dofs] = wet.memory.kernel[:, dofs[:, None], dofs]
    return kernel


def _compile_layout(
    scene: Scene, bodies: Bodies, alone: Mapping[str, HydroDatabase], tanks: Tanks
) -> kind.Layout:
    def of_body(body: int, stiffness: np.ndarray) -> kind.UncoupledResonance:
        return uncoupled_resonance(
            scene.bodies[body], stiffness, alone.get(scene.bodies[body].name)
        )

    def roll_of_body(body: int, stiffness: np.ndarray) -> kind.RollMode:
        return roll_mode(scene.bodies[body], stiffness, alone.get(scene.bodies[body].name))

    rows = {*scene.forces, *kind.acting_joints(scene)}
    return kind.Layout(
        {body.name: i for i, body in enumerate(scene.bodies)},
        {name: i for i, name in enumerate(kind.row_names(scene)) if name in rows},
        current_table(scene.environment),
        mean_wind(scene.environment),
        of_body,
        roll_of_body,
        tuple(body.heading for body in scene.bodies),
        tuple(body.mass * scene.environment.gravity for body in scene.bodies),
        0.0 if scene.solver.method.adapts else scene.solver.step,
        scene.solver.events,
        tanks.row,
        tuple(tank_names(scene)),
        tuple(triggered_pumps(scene)),
        kind.carried_weights(scene),
        scene.joints,
        _joined_bodies(scene, bodies),
        len(kind.row_names(scene)) - 1,
        bodies.tree,
        tuple(bodies.each["origin"]),
        dict(zip(point_names(scene), named_points(scene), strict=True)),
        scene.clearances,
        scene.environment.water_depth,
        scene.environment.water_density,
        tuple(draught_of(body) for body in scene.bodies),
        bodies.active,
    )


def _joined_bodies(scene: Scene, bodies: Bodies) -> dict[str, kind.JoinedBodies]:
    """The bodies of all joints that are constraints."""
    bodies_by_name = {
        body.name: kind.BodyAtRest(i, tuple(bodies.each[i]["origin"]), body.heading)
        for i, body in enumerate(scene.bodies)
    }
    return {
        name: kind.JoinedBodies(
            bodies_by_name[joint.body], bodies_by_name[joint.to] if joint.to else None, bodies.exact
        )
        for name, joint in ((name, scene.joints[name]) for name in kind.constraint_names(scene))
    }


# Scenes in calm water, to which waves are added; scenes that differ in waves share the rest.

MEAN: dict[str, Any] = {"headings": Place.MEAN, "position": Place.MEAN}

SHARE_OF_WAVES = 0.1
"""Error of wave loads between rows, over the accuracy of a method that is chosen for one."""


def compile_calm(
    scene: Scene, wet: Sequence[HydrodynamicGroup], kind_constants: kind.KindConstants | None = None
) -> Compiled:
    """Compile a scene of `open_start` in calm water with its databases ``wet``, and with its
    elements and tanks if they are ``kind_constants``.

    Raises InputError if the scene cannot be compiled or started.
    """
    model = model_of(scene, wet, kind_constants)
    derived = derive_data(scene, wet, model)
    try:
        fresh = first_state(scene, model)
    except InputError as error:
        causes = _odd_values(scene, derived) if scene.at_rest else []
        raise InputError("\n".join([str(error), *causes])) from None
    check_start(scene, model, fresh)
    state = start_of(scene, model, derived.layout, fresh)
    check_driven_start(scene, model, state, start_time(scene))
    return with_method(Compiled(scene, tuple(wet), derived, state))


def _odd_values(scene: Scene, derived: DerivedData) -> list[str]:
    """What questions ask of a scene that has no place at rest: the cause may be among it."""
    where = replace(scene, at_rest=False)
    fresh = first_state(where, derived.model)
    about = describe_start(where, derived, fresh, (), start_time(scene) + scene.duration)
    return [f"A cause may be: {text}" for text in describe_doubts(about, ())]


def add_waves(calm: Compiled, scene: Scene, sea: Sequence[WaveComponents]) -> Compiled:
    """Scene of `compile_calm` in the ``sea`` drawn from its waves, and in its gusts. ``scene`` may
    differ from the calm one in waves, seed of gusts, title and source. Raises InputError if a
    database does not fit the sea, or if sea or gusts are shorter than the run."""
    end = start_time(scene) + scene.duration
    check_span(scene.environment, 0.0, end)
    loaded = wave_bodies(scene, calm.derived.databases, calm.derived.met)
    bodies = [_lock_wave_place(body, scene) for body in loaded]
    # from 0, wherever the run begins: its loads then equal those of a longer run to the bit
    bodies = list(_bodies_at_draughts(bodies, calm.wet))
    loads = wave_loads_model(sea, bodies, 0.0, scene.solver.step / 2, end)
    block = steps_per_block(scene) * grid_step(scene)
    following = following_model(sea, bodies, block, wave_load_error(calm.scene.solver))
    heights = heights_of_wind(calm.model.elements)
    gusts = gust_table(scene.environment, heights, scene.solver.step / 2, end)
    elements = in_gusts(calm.model.elements, gusts)
    model = calm.model._replace(waves=loads, following=following, elements=elements)
    model, drag = with_line_drag(scene, model, calm.state, sea, _met_at_rest(calm, scene))
    state = with_slow_places(scene, model, calm.derived.met, calm.state)
    derived = derive_data(scene, calm.wet, model)
    compiled = replace(calm, scene=scene, derived=derived, state=state, sea=tuple(sea))
    notes_so_far = calm.notes.of_memory(calm.memory_errors)
    notes = notes_of_sea(scene, calm.wet, derived, state, sea, notes_so_far)
    about = describe_start(scene, derived, state, sea, end)
    return replace(compiled, notes=replace(notes, drag=drag).with_warnings(query_messages(about)))


def _met_at_rest(calm: Compiled, scene: Scene) -> list[WaveBody]:
    """Bodies on which waves act at rest, wherever they are; only lines with drag need them."""
    if not any(line.dragging_streams() for _, line in kind.elements_of(scene, Catenary)):
        return []
    met = {body.name: replace(calm.derived.met[body.name], **MEAN) for body in scene.bodies}
    return wave_bodies(scene, calm.derived.databases, met)


def wave_load_error(solver: Solver) -> float:
    """Error of wave loads between rows, relative to the sea's standard deviation: at most the
    tolerance of the steps that read them, and far below an accuracy that is asked for."""
    if not solver.method.adapts:
        return MISSED
    if solver.accuracy is None:
        return min(MISSED, solver.tolerance.relative)
    return min(MISSED, solver.tolerance.relative, SHARE_OF_WAVES * solver.accuracy)


def _bodies_at_draughts(
    bodies: Sequence[WaveBody], wet: Sequence[HydrodynamicGroup]
) -> Iterator[WaveBody]:
    """Bodies in waves; a body with a family of databases occurs once per member."""
    members = members_of_families(wet)
    owners = {int(member.dofs[0]) for member in members}
    yield from (body for body in bodies if body.offset not in owners)
    for k, member in enumerate(members, len(bodies)):
        (wave_body,) = member.alone.values()
        owner = int(member.dofs[0]) // 6
        loads = wave_body if wave_body.heading.size else None
        yield replace(bodies[owner], database=loads, offset=6 * k, owner=owner)


def _lock_wave_place(body: WaveBody, scene: Scene) -> WaveBody:
    """Body with the position that waves use: its position at rest, and its locked offsets."""
    at = np.where(body.active, 0.0, scene.bodies[body.offset // 6].position)
    loads = body.wave_forces
    if loads.position != Place.MEAN:
        at[:2] = 0.0
    if loads.headings != Place.MEAN or scene.solver.kinematics == Kinematics.LINEAR:
        at[5] = 0.0
    return body.moved_by(at)


def wave_bodies(
    scene: Scene, databases: Mapping[str, HydroDatabase], met: Mapping[str, WaveForces]
) -> list[WaveBody]:
    """All bodies of a scene in waves, with their ``databases`` that have loads, and the positions
    where waves act (`displaced_loads.met_by_waves`). A body that a joint carries has all of its
    loads: the joint carries those in directions that do not move."""
    alone = {name: db for name, db in databases.items() if db.heading.size}
    joined = arrangement(scene).children
    return [
        WaveBody(
            alone.get(body.name),
            body.location,
            met[body.name],
            6 * index,
            np.array([dof in body.dofs or body.name in joined for dof in DOFS]),
            body.centre_of_gravity[:2],
            body.heading,
        )
        for index, body in enumerate(scene.bodies)
    ]


class Radiation(StrEnum):
    """Source of added mass and damping: the scene's radiation model, or its databases."""

    MODEL = "model"
    DATABASE = "database"


@one_thread
def compile_scene(scene: Scene, in_plane: bool = False) -> Compiled:
    """Compile a scene to arrays. With ``in_plane``, motions that are zero by symmetry are left out,
    as `simulate` does (`hydrosim.compile.symmetry`).

    Raises InputError if a database, or a run to start from, cannot be read or does not fit the
    scene.
    """
    with source_context(scene.places):
        check_scene(scene)  # also whether its sea can be drawn
        drawn = sea(scene.environment)
        calm = compile_in_calm(scene, seas=drawn)
        calm = without_symmetric_motions(calm, drawn) if in_plane else calm
        return add_waves(calm, calm.scene, drawn)


def without_symmetric_motions(calm: Compiled, seas: Sequence[WaveComponents]) -> Compiled:
    """Scene in calm water without motions that are zero by symmetry, also in the ``seas`` drawn
    from its waves (`hydrosim.compile.symmetry`). Other scenes are unchanged. Its notes give the
    reason."""
    plane, notes = symmetry.in_plane(calm, seas)
    if plane is None:
        return replace(calm, notes=notes)
    reduced = with_tolerance(compile_calm(plane, calm.wet, calm.model))
    return replace(reduced, notes=notes, whole=calm)


@one_thread
def compile_in_calm(
    scene: Scene, states: float | None = None, seas: Sequence[WaveComponents] = ()
) -> Compiled:
    """Compile a scene without its waves; raises as `compile_scene` does. With ``states``, the
    tolerance of fits, state-space models replace all convolutions, which cannot be linearised.
    Databases are checked for their use in the ``seas``."""
    with source_context(scene.places):
        scene = open_start(scene)
        check_scene(scene)
        scene = with_dofs_of_joints(scene)
        wet = scene_groups(scene, seas, memory_before(scene))
        if states is not None:
            scene, wet = scene_with_states(scene, wet, states)
        return compile_calm(scene, wet)


def compile_for_linear(
    scene: Scene, radiation: Radiation = Radiation.MODEL, time: float = 0.0
) -> Compiled:
    """Scene from its own start, in calm water, with radiation that can be linearised: state-space
    models, or the frequency-dependent coefficients of databases. It lasts until ``time`` [s]."""
    calm = replace(scene, initial=None, duration=max(scene.duration, time))
    if radiation == Radiation.MODEL:
        return compile_in_calm(calm, TOLERANCE)
    dry = tuple(replace(body, radiation=RadiationModel.NONE) for body in scene.bodies)
    return compile_in_calm(replace(calm, bodies=dry))
