"""`compile_scene`: from a scene to arrays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from enum import StrEnum
from typing import TYPE_CHECKING, Any

import numpy as np

from hydrosim.compile import symmetry
from hydrosim.compile.automatic import with_method, with_tolerance
from hydrosim.compile.compiled import Compiled, derive_data
from hydrosim.compile.drives import check_driven_start
from hydrosim.compile.families import all_groups, members_of_families
from hydrosim.compile.hydrodynamic_groups import HydrodynamicGroup, in_states
from hydrosim.compile.joints import with_dofs_of_joints
from hydrosim.compile.line_drag import with_line_drag
from hydrosim.compile.model import model_of
from hydrosim.compile.questions import describe_doubts, query_messages
from hydrosim.compile.questions.query import describe_start
from hydrosim.compile.restart import memory_before, open_start, start_time
from hydrosim.compile.scene_notes import notes_of_sea
from hydrosim.compile.start import first_state, start_of, with_slow_places
from hydrosim.compile.validate_scene import check_scene, check_start
from hydrosim.dofs import DOFS
from hydrosim.elements import heights_of_wind, in_gusts
from hydrosim.elements.kind import elements_of
from hydrosim.elements.line.catenary import Catenary
from hydrosim.errors import InputError
from hydrosim.files.yaml_nodes import source_context
from hydrosim.scene import Kinematics, Place, RadiationModel, Scene
from hydrosim.scene.scene import arrangement
from hydrosim.water.body import WaveBody
from hydrosim.water.build import wave_loads_model
from hydrosim.water.components import WaveComponents, check_span, sea
from hydrosim.water.displaced_loads import following_model
from hydrosim.water.loads import MISSED
from hydrosim.water.radiation.state_space import TOLERANCE
from hydrosim.water.radiation.threads import one_thread
from hydrosim.water.wave_reference import grid_step, steps_per_block
from hydrosim.water.wind import gust_table

if TYPE_CHECKING:
    from hydrosim.compile.compiled import DerivedData
    from hydrosim.database.database import HydroDatabase
    from hydrosim.elements.kind import KindConstants
    from hydrosim.scene import Solver, WaveForces

# Scenes in calm water, and their waves. Scenes that differ in their waves only share the rest.

MEAN: dict[str, Any] = {"headings": Place.MEAN, "position": Place.MEAN}

SHARE_OF_WAVES = 0.1
"""Error of wave loads between rows, over the accuracy of a method that is chosen for one."""


def compile_calm(
    scene: Scene, wet: Sequence[HydrodynamicGroup], kind_constants: KindConstants | None = None
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
    bodies = [_as_locked(body, scene) for body in loaded]
    # from 0, wherever the run begins: its loads then equal those of a longer run to the bit
    bodies = list(_at_draughts(bodies, calm.wet))
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
    if not any(line.dragging_streams() for _, line in elements_of(scene, Catenary)):
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


def _at_draughts(
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


def _as_locked(body: WaveBody, scene: Scene) -> WaveBody:
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
    where waves act (`waves.places.met_by_waves`). A body that a joint carries has all of its loads:
    the joint carries those in directions that do not move."""
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
        wet = all_groups(scene, seas, memory_before(scene))
        if states is not None:
            scene, wet = in_states(scene, wet, states)
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
