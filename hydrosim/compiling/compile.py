"""`compile_scene`: from a scene to arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from enum import StrEnum
from typing import TYPE_CHECKING

from hydrosim.compiling import symmetry
from hydrosim.compiling.automatic import with_tolerance
from hydrosim.compiling.families import all_groups
from hydrosim.compiling.hydrodynamic_groups import in_states
from hydrosim.compiling.joints.bodies import with_dofs_of_joints
from hydrosim.compiling.restart import memory_before, open_start
from hydrosim.compiling.validate_scene import check_scene
from hydrosim.compiling.without_waves import add_waves, compile_calm
from hydrosim.documents.yaml_nodes import source_context
from hydrosim.radiation.state_space import TOLERANCE
from hydrosim.radiation.threads import one_thread
from hydrosim.scene import RadiationModel
from hydrosim.waves.components import WaveComponents, sea

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled
    from hydrosim.scene import Scene


class Radiation(StrEnum):
    """Source of added mass and damping: the scene's radiation model, or its databases."""

    MODEL = "model"
    DATABASE = "database"


@one_thread
def compile_scene(scene: Scene, in_plane: bool = False) -> Compiled:
    """Compile a scene to arrays. With ``in_plane``, motions that are zero by symmetry are left out,
    as `simulate` does (`hydrosim.compiling.symmetry`).

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
    from its waves (`hydrosim.compiling.symmetry`). Other scenes are unchanged. Its notes give the
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
