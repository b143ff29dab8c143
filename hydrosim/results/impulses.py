"""Impulses and works of forces, and what contact points did, as variables of a run that records
them (`Scene.output_impulses`). All are integrals since the start.

`impulse` and `work` (time, force, body, dof) are those of every row of forces, and their sums the
changes of `momentum` (time, body, dof) and of `energy_kinetic`. `contact_*` (time, fender, mode)
are those of `hydrosim.forces.contact.tally`, `slip_*` (time, fender, axis) what it has of slip.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.forces.contact.fender import Contact
from hydrosim.forces.contact.tally import EACH, MODES, SIZE, SLIPPING
from hydrosim.stepping.names import force_names

if TYPE_CHECKING:
    from hydrosim.scene import Scene
    from hydrosim.stepping.dynamics import Model

VARIABLES = {
    "contact_time": ("time in a contact mode", "s", "none"),
    "contact_impulse": ("integral of the normal force in a contact mode", "N s", "none"),
    "contact_press": ("impulse of the normal force on the body in a contact mode", "N s", "earth"),
    "contact_friction": ("impulse of friction on the body in a contact mode", "N s", "earth"),
    "contact_moved": ("displacement of the point along the plane in a mode", "m", "earth"),
    "contact_friction_work": ("work of friction on the body in a contact mode", "J", "earth"),
    "contact_press_work": ("work of the normal force in a contact mode", "J", "none"),
    "slip_direction": ("integral of the direction of slip", "s", "earth"),
    "slip_load": ("integral of normal force times direction of slip", "N s", "earth"),
    "slip_damping": ("integral of C3 times the velocity of slip", "N s", "earth"),
    "slip_moved": ("displacement of the contact node in slip", "m", "earth"),
    "slip_direction_ahead": ("the part of slip_direction towards positive axes", "s", "earth"),
    "slip_load_ahead": ("the part of slip_load towards positive axes", "N s", "earth"),
    "slip_moved_ahead": ("the part of slip_moved towards positive axes", "m", "earth"),
}


def coordinates(scene: Scene) -> dict[str, object]:
    """Names of forces and contact modes, and mu_k of each contact point."""
    if not scene.output_impulses:
        return {}
    forces: dict[str, object] = {"force": ("force", list(force_names(scene)))}
    contacts = [
        (e.friction, len(e.points)) for e in scene.forces.values() if isinstance(e, Contact)
    ]
    if not contacts:
        return forces
    kinetic = [getattr(law, "kinetic", 0.0) for law, count in contacts for _ in range(count)]
    said = {"long_name": "coefficient of kinetic friction", "units": "1"}
    return {
        **forces,
        "contact_mode": ("contact_mode", list(MODES)),
        "fender_kinetic": ("fender", kinetic, said),
    }


def recorded(
    scene: Scene, model: Model, values: Mapping[str, np.ndarray]
) -> dict[str, tuple[tuple[str, ...], np.ndarray]]:
    """The variables, of the ``values`` (nt, ...) of a record by name."""
    if not scene.output_impulses:
        return {}
    integrals = values["y"][:, model.impulse :]
    each, points = model.rows * values["momentum"].shape[1], model.elements.fenders.points.size
    forces = integrals[:, : 2 * each].reshape(len(integrals), 2, model.rows, -1, 6)
    tallies = integrals[:, 2 * each :].reshape(len(integrals), points, SIZE)
    return {
        "momentum": (("time", "body", "dof"), values["momentum"].reshape(len(integrals), -1, 6)),
        **{
            name: (("time", "force", "body", "dof"), forces[:, k])
            for k, name in enumerate(("impulse", "work"))
        },
        **(dict(_contacts(tallies)) if points else {}),
    }


def _contacts(tallies: np.ndarray) -> Iterator[tuple[str, tuple[tuple[str, ...], np.ndarray]]]:
    """What contact points did, of their ``tallies`` (nt, nf, SIZE)."""
    dims, axis = ("time", "fender", "contact_mode"), ("axis",)
    width = sum(count for _, count in EACH)
    modes = tallies[:, :, : len(MODES) * width].reshape(*tallies.shape[:2], len(MODES), width)
    at = 0
    for name, count in EACH:
        part = modes[..., at : at + count]
        shape = (dims, part[..., 0]) if count == 1 else ((*dims, *axis), part)
        yield f"contact_{name}", shape
        at += count
    at = len(MODES) * width
    for name, count in SLIPPING:
        yield name, ((*dims[:2], *axis), tallies[:, :, at : at + count])
        at += count
