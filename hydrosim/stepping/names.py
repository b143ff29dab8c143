"""Names of array entries: rows of forces, coordinates, contact points, springs, pins."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.forces import spring
from hydrosim.forces.contact import kind as contact_points
from hydrosim.forces.layout import (
    BALLAST,
    BODY_ROWS,
    JOINTS,
    RADIATION,
    WAVE_FIRST_ORDER,
    WAVE_SECOND_ORDER,
    WEIGHT,
    has_flow,
    row_names,
)
from hydrosim.scene import ForceElement, Scene
from hydrosim.scene.scene import arrangement, tree_joints
from hydrosim.stepping.dynamics import Model

WAVE_ROWS = (BODY_ROWS[WAVE_FIRST_ORDER], BODY_ROWS[WAVE_SECOND_ORDER])


def force_names(scene: Scene) -> tuple[str, ...]:
    """Names of the rows of forces: the body's own and the elements'."""
    return row_names(scene)


def is_work_row(scene: Scene, row: int) -> bool:
    """True if the power of a row of forces is booked as work, false if as dissipation."""
    element = element_of(scene, row)
    if element is not None:
        return element.supplies
    return force_names(scene)[row] in (*WAVE_ROWS, *([WEIGHT, BALLAST] if has_flow(scene) else []))


def may_store_energy(scene: Scene, row: int) -> bool:
    """True if a row of forces may store energy."""
    name = force_names(scene)[row]
    holds = row == RADIATION or name == JOINTS or is_work_row(scene, row)
    return name == WEIGHT or not holds


def may_dissipate(scene: Scene, row: int) -> bool:
    """True if a row of forces may dissipate energy."""
    if row == RADIATION or force_names(scene)[row] in (JOINTS, *scene.joints):
        return True
    return element_of(scene, row) is not None and not is_work_row(scene, row)


def element_of(scene: Scene, row: int) -> ForceElement | None:
    """The element that owns a row of forces; None if the row belongs to a body itself."""
    return scene.forces.get(force_names(scene)[row])


def dofs_of(dofs: Sequence[int] | np.ndarray, bodies: Sequence[str]) -> str:
    """Names of DOFs, six for each of the ``bodies``: "sway, roll of a and sway, roll of b"."""
    parts = [
        f"{', '.join(DOFS[dof % 6] for dof in dofs if dof // 6 == b)} of {name}"
        for b, name in enumerate(bodies)
        if any(dof // 6 == b for dof in dofs)
    ]
    return " and ".join(parts)


class Coordinate(NamedTuple):
    """A degree of freedom of a body, or a motion of a joint."""

    dof: str
    body: str

    @property
    def name(self) -> str:
        """Name in files: "surge of barge"."""
        return f"{self.dof} of {self.body}"


def coordinates(scene: Scene) -> list[Coordinate]:
    """All free coordinates, in the order of y."""
    carried = arrangement(scene).children
    own = [body for body in scene.bodies if body.name not in carried]
    found = [Coordinate(dof, body.name) for body in own for dof in DOFS if dof in body.dofs]
    joints = tree_joints(scene)
    return found + [Coordinate(m.name, name) for name, j in joints.items() for m in j.motions]


def coordinate_at(scene: Scene, index: int) -> Coordinate:
    """The coordinate with this index in `Bodies.active`."""
    body = index // 6
    if body < len(scene.bodies):
        return Coordinate(DOFS[index % 6], scene.bodies[body].name)
    joints = [(name, m) for name, joint in tree_joints(scene).items() for m in joint.motions]
    name, motion = joints[index - 6 * len(scene.bodies)]
    return Coordinate(motion.name, name)


def coordinate_names(scene: Scene) -> list[str]:
    """Names of all free coordinates."""
    return [coordinate.name for coordinate in coordinates(scene)]


def contact_names(scene: Scene) -> list[str]:
    """Names of all contact points, "element 1", "element 2", ..."""
    return contact_points.CONTACT_KIND.unit_names(scene)


def spring_names(scene: Scene) -> list[str]:
    """Names of all springs."""
    return spring.SPRING_KIND.unit_names(scene)


def memory_names(scene: Scene, model: Model) -> list[str]:
    """Names of the coordinates whose velocities a convolution remembers."""
    return [coordinate_of(scene, model, dof).name for dof in np.unique(model.convolution.column)]


def coordinate_of(scene: Scene, model: Model, dof: int) -> Coordinate:
    """Coordinate of a body, or of the body that a member of a family belongs to."""
    body = dof // 6 - len(scene.bodies)
    owner = dof // 6 if body < 0 else model.family.owner[body]
    return Coordinate(DOFS[dof % 6], scene.bodies[owner].name)
