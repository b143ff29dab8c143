"""Waves and gusts of a scene, added to what was compiled in calm water: scenes that differ in them
share the rest."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from hydrosim.compile.compiled import Compiled, derive_data
from hydrosim.compile.families import members_of_families
from hydrosim.compile.hydrodynamic_groups import (
    HydrodynamicGroup,
)
from hydrosim.compile.line_drag import with_line_drag
from hydrosim.compile.questions import query_messages
from hydrosim.compile.questions.query import describe_start
from hydrosim.compile.restart import start_time
from hydrosim.compile.scene_notes import notes_of_sea
from hydrosim.compile.start import with_slow_places
from hydrosim.database.database import HydroDatabase
from hydrosim.dofs import DOFS
from hydrosim.elements import heights_of_wind, in_gusts, kind
from hydrosim.scene import Kinematics, Place, Scene, Solver, WaveForces
from hydrosim.scene.catenary import Catenary
from hydrosim.scene.scene import arrangement
from hydrosim.water.body import WaveBody
from hydrosim.water.build import wave_loads_model
from hydrosim.water.components import WaveComponents, check_span
from hydrosim.water.displaced_loads import (
    following_model,
    grid_step,
    steps_per_block,
)
from hydrosim.water.loads import MISSED
from hydrosim.water.wind import gust_table

MEAN: dict[str, Any] = {"headings": Place.MEAN, "position": Place.MEAN}

SHARE_OF_WAVES = 0.1
"""Error of wave loads between rows, over the accuracy of a method that is chosen for one."""


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
