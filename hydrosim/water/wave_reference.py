"""Choice of a body's position in the waves where the scene leaves it to the program.

The waves follow the slow motion of a body if nothing restores it to its position at rest and
something may move it away. Otherwise they meet the body at rest, which costs less. The choice
depends on the scene alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from hydrosim.dofs import DOFS
from hydrosim.errors import InputError
from hydrosim.scene import Body, Kinematics, Place, Scene, SecondOrder, WaveForces
from hydrosim.scene.scene import is_anchored, joined_with
from hydrosim.water.transfer import TransferFunctions, all_round

BLOCK = 2.0
"""Duration of one slow path [s]; the nearest multiple of the grid of steps is used."""
HORIZONTAL_DOFS = (0, 1)
YAW = (5,)


def chosen_places(scene: Scene, body: Body) -> WaveForces:
    """The wave forces of a body with automatic ``position`` and ``headings`` resolved. Raises
    InputError if the two do not go together."""
    asked = body.wave_forces
    chosen = replace(
        asked,
        position=_chosen(asked.position, scene, body, HORIZONTAL_DOFS),
        headings=_chosen(asked.headings, scene, body, YAW),
    )
    if {chosen.position, chosen.headings} == {Place.SLOW, Place.INSTANTANEOUS}:
        if Place.AUTOMATIC not in (asked.position, asked.headings):
            raise InputError(
                f"bodies.{body.name}.wave_forces: found position: {asked.position} and headings:"
                f" {asked.headings}; expected slow or instantaneous for both, or mean for one."
            )
        return replace(chosen, position=Place.INSTANTANEOUS, headings=Place.INSTANTANEOUS)
    return chosen


def reference_positions(scene: Scene, body: Body, database: TransferFunctions | None) -> WaveForces:
    """`chosen_places` for a body with this database. Automatic means at rest if the database does
    not have headings all round the circle."""
    chosen = chosen_places(scene, body)
    asked = body.wave_forces
    wanted = {asked.headings, asked.position} & {Place.SLOW, Place.INSTANTANEOUS}
    if wanted or database is None or all_round(database):
        return chosen
    return replace(chosen, headings=Place.MEAN, position=Place.MEAN)


def met_by_waves(scene: Scene, databases: Mapping[str, TransferFunctions]) -> dict[str, WaveForces]:
    """Position at which waves act on each body of a scene, by name, with their ``databases``."""
    return {
        body.name: reference_positions(scene, body, databases.get(body.name))
        for body in scene.bodies
    }


def slow_bodies(scene: Scene, met: Mapping[str, WaveForces]) -> list[str]:
    """Names of the bodies whose slow motion the waves follow. ``met`` has the `reference_positions`
    of all."""
    return [body.name for body in scene.bodies if _follows_slowly(scene, body, met[body.name])]


def _follows_slowly(scene: Scene, body: Body, met: WaveForces) -> bool:
    loaded = body.hydrodynamics is not None and met.has_loads and bool(scene.environment.waves)
    return loaded and Place.SLOW in (met.position, met.headings)


def _chosen(asked: Place, scene: Scene, body: Body, dofs: tuple[int, ...]) -> Place:
    if asked != Place.AUTOMATIC:
        return asked
    exact = scene.solver.kinematics == Kinematics.EXACT
    leaves = (
        exact
        and _may_move(scene, body, dofs)
        and (_has_steady_force(scene, body) or _is_displaced(body, dofs))
    )
    return Place.SLOW if leaves else Place.MEAN


def _may_move(scene: Scene, body: Body, dofs: tuple[int, ...]) -> bool:
    """True if the body may leave its position at rest in one of the ``dofs``."""
    joined = joined_with(scene, body.name)
    if is_anchored(scene, body.name):
        return False
    held = {dof for e in scene.forces.values() if e.body in joined for dof in e.restored_dofs()}
    return any(dof in body.dofs and dof not in held for dof in (DOFS[i] for i in dofs))


def _has_steady_force(scene: Scene, body: Body) -> bool:
    """True if a steady force pushes the body, or has pushed it."""
    joined = joined_with(scene, body.name)
    others = [other for other in scene.bodies if other.name in joined]
    loads = any(other.wave_forces.second_order != SecondOrder.NONE for other in others)
    driven = any(e.supplies for e in scene.forces.values() if e.body in joined)
    moving = any(other.velocity[i] for other in others for i in (*HORIZONTAL_DOFS, *YAW))
    return loads or driven or moving or scene.environment.current.speed != 0.0


def _is_displaced(body: Body, dofs: tuple[int, ...]) -> bool:
    return any(body.position[i] for i in dofs)


def grid_step(scene: Scene) -> float:
    """Spacing of the grid of times at which steps end [s]: the output step if the method is
    adaptive, else the step."""
    return scene.output_step if scene.solver.method.adapts else scene.solver.step


def steps_per_block(scene: Scene) -> int:
    """Number of steps of that grid per slow path."""
    return max(round(BLOCK / grid_step(scene)), 1)
