"""What there is to say of where waves and a current meet the bodies of a scene."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.forces.stream_load import CurrentLoad
from hydrosim.scene import Body, Place, Scene
from hydrosim.waves.coarse import lost_between_headings
from hydrosim.waves.components import Components
from hydrosim.waves.forms import second_order_at_rest
from hydrosim.waves.transfer import apart

if TYPE_CHECKING:
    from hydrosim.compiling.facts import Facts
    from hydrosim.database.database import HydroDatabase
    from hydrosim.stepping.dynamics import Model

LOST = 0.05  # of the loads between the headings of a database is worth a warning
AT_NODE = 1e-6  # rad: waves so near to a heading of the database are at it
BESIDE = 0.01  # of the energy may be between headings without a word


class Meeting(NamedTuple):
    """Where waves meet a ``body``, and what is ``lost`` of its first-order forces and moments
    between the headings of its ``database``, if it is met there and that is known; whether its
    second-order loads do not follow it."""

    body: Body
    database: HydroDatabase
    position: Place
    headings: Place
    lost: tuple[float, float] | None
    second_at_rest: bool


def meetings(scene: Scene, facts: Facts, seas: Sequence[Components]) -> Iterator[Meeting]:
    """Of each body that waves load."""
    alone = facts.databases
    for body in scene.bodies if seas else ():
        if body.name in alone and body.wave_forces.any:
            db = alone[body.name]
            chosen = facts.met[body.name]
            between = chosen.headings != Place.MEAN or _between(body, seas, db)
            between = between and body.wave_forces.first_order
            lost = lost_between_headings(db, seas) if between else None
            fixed = second_order_at_rest(chosen, db)
            yield Meeting(body, db, chosen.position, chosen.headings, lost, fixed)


def said_of_waves(meeting: Meeting) -> Iterator[str]:
    """Where the waves meet a body, if not at rest, and how exactly."""
    body = meeting.body
    at = (meeting.position, meeting.headings)
    if {*at} != {Place.MEAN}:
        whole = {Place.MEAN: "at rest", Place.SLOW: "slow", Place.INSTANTANEOUS: "at the time"}
        text = f"waves meet {body.name} at its place {whole[at[0]]}, heading {whole[at[1]]}"
        if meeting.second_at_rest and meeting.headings != Place.MEAN:
            text += "; second-order loads are those at rest, for its QTFs are not all round"
        yield text
    if meeting.lost is not None:
        yield f"{body.name}: {_said(meeting.lost, meeting.database)}"


def coarse_headings(meeting: Meeting) -> Iterator[str]:
    """A warning of a database whose headings are too coarse for its hull in this sea."""
    lost = meeting.lost
    db = meeting.database
    if lost is not None and max(lost) > LOST:
        yield (
            f"bodies.{meeting.body.name}: {_said(lost, db)}; expected less than {LOST:.0%}. Compute"
            f" the database for headings {_spacing(db) / 2.0:.3g} deg apart, or take waves that go"
            " to one of its headings as the body has them."
        )


def said_of_current(scene: Scene, model: Model) -> Iterator[str]:
    """What the current does to the water that the bodies move."""
    for b in model.headings.turning if scene.environment.current.speed else ():
        A = model.added_mass[6 * b : 6 * b + 2, 6 * b : 6 * b + 2]
        yield _munk(scene, scene.bodies[b], A)


def _said(lost: tuple[float, float], db: HydroDatabase) -> str:
    return (
        f"between the headings of {db.source}, {_spacing(db):.3g} deg apart, about {lost[0]:.1%} of"
        f" the first-order forces and {lost[1]:.1%} of the moments are lost in this sea"
    )


def _spacing(db: HydroDatabase) -> float:
    return 360.0 / db.heading.size


def _between(body: Body, seas: Sequence[Components], db: HydroDatabase) -> bool:
    """Whether the body at rest meets waves between the headings of its database."""
    energy = np.concatenate([waves.amplitude**2 for waves in seas])
    to = np.concatenate([waves.heading for waves in seas]) - body.heading
    off = np.full(to.size, np.inf)
    for heading in db.heading:  # one at a time: seas of long runs have many waves
        np.minimum(off, apart(to, heading), out=off)
    return bool(energy[off > AT_NODE].sum() > BESIDE * energy.sum())


def _munk(scene: Scene, body: Body, A: np.ndarray) -> str:
    """A steady current turns the hull by its added mass, and coefficients often have that too."""
    speed = scene.environment.current.speed
    largest = 0.5 * abs(A[1, 1] - A[0, 0]) * speed**2
    text = f"the current turns {body.name} by its added mass (Munk), with {largest:.3g} N m at most"
    if any(
        isinstance(e, CurrentLoad) and e.body == body.name and np.any(e.yaw)
        for e in scene.forces.values()
    ):
        text += (
            "; yaw coefficients of a current_load that were measured or computed for a steady flow"
            f" hold it already, {0.5 * (A[0, 0] - A[1, 1]):.3g} sin(2 a) N m s^2/m^2 at a heading"
            " of a: take that from them"
        )
    return text
