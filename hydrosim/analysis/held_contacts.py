"""Contacts that are pressed at rest in a linear analysis: how long their state lasts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.elements.contact.fender import normal_load_of
from hydrosim.elements.contact.geometry import EARTH, ContactKinematics, contact_kinematics
from hydrosim.elements.contact.law import STICK
from hydrosim.elements.contact.laws import COULOMB, FRICTIONLESS, friction
from hydrosim.integrate.dynamics import new_work
from hydrosim.integrate.names import contact_names
from hydrosim.linear.equilibrium import (
    Contacts,
    find_rigid_tractions,
    pressed_points,
    with_contacts,
)
from hydrosim.multibody.kinematics import place_bodies

if TYPE_CHECKING:
    from hydrosim.analysis.response import Responder
    from hydrosim.compile.compiled import Compiled
    from hydrosim.linear.equilibrium import Rest

LARGEST_OVER_STD = 3.7  # standard deviations: most probable largest value of a thousand waves


class Grip(NamedTuple):
    """A contact point at rest: the `ContactKinematics`, its normal force N [N], the friction limit
    mu_s N, and the traction per displacement and per velocity along the plane."""

    contact: ContactKinematics
    normal: float
    holds: float
    stiffness: float
    damping: float


def contact_remarks(
    compiled: Compiled, rest: Rest, about: Responder, contacts: Contacts
) -> Iterator[str]:
    """Remarks on the assumed state of contacts, and on whether the waves of the scene would change
    it."""
    names = contact_names(compiled.scene)
    points = pressed_points(rest.model, rest.state)
    if not points.size:
        return
    which = _join_names([names[i] for i in points])
    if contacts != Contacts.STUCK:
        what = "slide without friction" if contacts == Contacts.SLIDING else "are taken as open"
        yield f"pressed at rest, {which} {what}, as requested."
        return
    rigid = compiled.model.elements.fenders.points["law"] == COULOMB
    how = "springs and dampers along the plane"
    if rigid[points].any():
        held = _join_names([names[i] for i in points if rigid[i]])
        how = "no motion along the plane" if rigid[points].all() else f"{how}, none at {held}"
    yield (
        f"pressed at rest, {which} hold by friction: {how}. The position at rest is computed"
        " without friction."
    )
    waves = [(w.omega, about.free_motions(w) @ about.map.T) for w in compiled.sea]
    if not waves:
        return
    omega = np.concatenate([w for w, _ in waves])
    motions = np.concatenate([x for _, x in waves])
    model, stuck = with_contacts(compiled.model, rest.state, contacts, names)
    forces = np.concatenate([about.reactions(w) for w in compiled.sea])
    held_by = find_rigid_tractions(model, stuck, forces)
    for i in points:
        point_grip = grip(int(i), compiled, rest)
        traction = _traction(point_grip, int(i), compiled, omega, motions) + held_by[:, i]
        yield from _let_go(names[i], point_grip, int(i), compiled, motions, traction)


def grip(i: int, compiled: Compiled, rest: Rest) -> Grip:
    """Grip of point ``i`` at ``rest``."""
    model = compiled.model
    y = rest.state.y
    n = rest.model.bodies.active.size
    motion = new_work(model).motion
    fenders = model.elements.fenders
    place_bodies(y[:n], np.zeros(n), model.bodies, motion)
    point = fenders.points[i]
    contact = contact_kinematics(point, model.bodies, motion)
    load = normal_load_of(i, rest.time, rest.state.y, rest.state.modes, contact, fenders)
    still = (0.0, 0.0)
    slip_direction = (1.0, 0.0)
    if point["law"] == FRICTIONLESS:
        return Grip(contact, load.N, np.inf, 0.0, 0.0)
    stiffness, damping = (
        -friction(STICK, load, v, s, point).force[0]
        for v, s in ((still, slip_direction), (slip_direction, still))
    )
    return Grip(contact, load.N, float(point["static"]) * load.N, stiffness, damping)


def _relative_displacements(
    i: int, grip: Grip, compiled: Compiled, motions: np.ndarray
) -> np.ndarray:
    """Complex displacements (nw, 3) of point ``i`` relative to its plane."""
    point = compiled.model.elements.fenders.points[i]
    moved = _point_displacements(int(point["body"]), grip.contact.arm, motions)
    if point["plane_body"] != EARTH:
        moved = moved - _point_displacements(
            int(point["plane_body"]), grip.contact.plane_arm, motions
        )
    return moved


def _traction(
    grip: Grip, i: int, compiled: Compiled, omega: np.ndarray, motions: np.ndarray
) -> np.ndarray:
    """Complex traction (nw, 2) of the node of point ``i``; zero for rigid friction."""
    moved = _relative_displacements(i, grip, compiled, motions)
    along = moved @ np.array([grip.contact.tangent1, grip.contact.tangent2]).T
    return np.asarray((grip.stiffness + 1j * omega * grip.damping)[:, None] * along)


def _let_go(
    name: str,
    grip: Grip,
    i: int,
    compiled: Compiled,
    motions: np.ndarray,
    traction: np.ndarray,
) -> Iterator[str]:
    """Remarks if the most probable largest value of a thousand waves of the ``traction`` (nw, 2)
    exceeds the friction limit, or that of the normal motion exceeds the compression."""
    point = compiled.model.elements.fenders.points[i]
    moved = _relative_displacements(i, grip, compiled, motions)
    apart = LARGEST_OVER_STD * float(
        np.sqrt(0.5 * np.sum(np.abs(moved @ grip.contact.normal) ** 2))
    )
    largest = LARGEST_OVER_STD * float(np.sqrt(0.5 * np.sum(np.abs(traction) ** 2, axis=0).max()))
    if largest > grip.holds:
        yield (
            f"in these waves {name} would slip: its friction would reach {largest:.3g} N, but the"
            f" limit is {grip.holds:.3g} N. The linear analysis holds for smaller waves; use"
            " `hydrosim run` for these."
        )
    if not point["prescribed"] and apart > grip.contact.compression:
        yield (
            f"in these waves {name} would open: it moves by {apart:.3g} m across the plane, but"
            f" is compressed by only {grip.contact.compression:.3g} m. The linear analysis holds"
            " for smaller waves; use `hydrosim run` for these."
        )


def _point_displacements(body: int, arm: tuple[float, ...], motions: np.ndarray) -> np.ndarray:
    """Complex displacements (nw, 3) of a body's point."""
    q = motions[:, 6 * body : 6 * body + 6]
    return np.asarray(q[:, :3] + np.cross(q[:, 3:], np.asarray(arm)))


def _join_names(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
