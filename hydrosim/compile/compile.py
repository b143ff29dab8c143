"""Compilation of a scene to the arrays that a run needs, in five passes.

    read      databases, radiation models, a run to start from       `read_databases`
    build     constants, state at the start, method                   `compile_calm`
    reduce    leave out what is zero by symmetry                      `without_symmetric_motions`
    waves     draw the sea, add its loads and those of gusts          `hydrosim.compile.waves`
    check     what is odd about the scene as it will run              `hydrosim.compile.questions`

The model is built before it is reduced, because a motion is left out only if it is stable, which
its linearisation tells. Elements and databases are compiled once for both. Scenes that differ in
waves alone share what comes before them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from enum import StrEnum

from hydrosim.compile import symmetry
from hydrosim.compile.automatic import with_method, with_tolerance
from hydrosim.compile.compiled import Compiled, DerivedData, derive_data
from hydrosim.compile.drives import check_driven_start
from hydrosim.compile.families import scene_groups
from hydrosim.compile.hydrodynamic_groups import (
    HydrodynamicGroup,
    scene_with_states,
)
from hydrosim.compile.joints import with_dofs_of_joints
from hydrosim.compile.model import model_of
from hydrosim.compile.questions import describe_doubts
from hydrosim.compile.questions.query import describe_start
from hydrosim.compile.restart import memory_before, open_start, start_time
from hydrosim.compile.start import first_state, start_of
from hydrosim.compile.validate_scene import check_scene, check_start
from hydrosim.compile.waves import add_waves
from hydrosim.elements import kind
from hydrosim.errors import InputError
from hydrosim.files.yaml_nodes import source_context
from hydrosim.scene import NoRadiation, Scene
from hydrosim.water.components import WaveComponents, sea
from hydrosim.water.radiation.state_space import TOLERANCE
from hydrosim.water.radiation.threads import one_thread


@one_thread
def compile_scene(scene: Scene, in_plane: bool = False) -> Compiled:
    """Compile a scene to arrays. With ``in_plane``, motions that are zero by symmetry are left out,
    as `simulate` does (`hydrosim.compile.symmetry`).

    Raises InputError if a database, or a run to start from, cannot be read or does not fit the
    scene.
    """
    with source_context(scene.places):
        scene = open_start(scene)
        check_scene(scene)  # also whether its sea can be drawn
        seas = sea(scene.environment)
        scene, groups = read_databases(scene, seas)
        calm = compile_calm(scene, groups)
        if in_plane:
            calm = without_symmetric_motions(calm, seas)
        return add_waves(calm, calm.scene, seas)


def read_databases(
    scene: Scene, seas: Sequence[WaveComponents], states: float | None = None
) -> tuple[Scene, list[HydrodynamicGroup]]:
    """The scene with the degrees of freedom that its joints leave, and its databases with their
    radiation models, checked for their use in the ``seas``. With ``states``, the tolerance of fits,
    state-space models replace all convolutions, which cannot be linearised."""
    scene = with_dofs_of_joints(scene)
    groups = scene_groups(scene, seas, memory_before(scene))
    return (scene, groups) if states is None else scene_with_states(scene, groups, states)


@one_thread
def compile_in_calm(scene: Scene, states: float | None = None) -> Compiled:
    """Compile a scene without its waves; raises as `compile_scene` does. ``states`` as in
    `read_databases`."""
    with source_context(scene.places):
        scene = open_start(scene)
        check_scene(scene)
        return compile_calm(*read_databases(scene, (), states))


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


def without_symmetric_motions(calm: Compiled, seas: Sequence[WaveComponents]) -> Compiled:
    """Scene in calm water without motions that are zero by symmetry, also in the ``seas`` drawn
    from its waves (`hydrosim.compile.symmetry`). Other scenes are unchanged. Its notes give the
    reason."""
    plane, notes = symmetry.in_plane(calm, seas)
    if plane is None:
        return replace(calm, notes=notes)
    reduced = with_tolerance(compile_calm(plane, calm.wet, calm.model))
    return replace(reduced, notes=notes, whole=calm)


class Radiation(StrEnum):
    """Source of added mass and damping: the scene's radiation model, or its databases."""

    MODEL = "model"
    DATABASE = "database"


def compile_for_linear(
    scene: Scene, radiation: Radiation = Radiation.MODEL, time: float = 0.0
) -> Compiled:
    """Scene from its own start, in calm water, with radiation that can be linearised: state-space
    models, or the frequency-dependent coefficients of databases. It lasts until ``time`` [s]."""
    calm = replace(scene, initial=None, duration=max(scene.duration, time))
    if radiation == Radiation.MODEL:
        return compile_in_calm(calm, TOLERANCE)
    dry = tuple(replace(body, radiation=NoRadiation()) for body in scene.bodies)
    return compile_in_calm(replace(calm, bodies=dry))
