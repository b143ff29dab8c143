"""Messages on the positions where waves and current act on the bodies of a scene."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.forces.stream_load import CurrentLoad
from hydrosim.scene import Body, Place, Scene
from hydrosim.waves.components import WaveComponents
from hydrosim.waves.heading_aliasing import lost_between_headings
from hydrosim.waves.quadratic_loads import second_order_at_rest
from hydrosim.waves.transfer import angle_between

if TYPE_CHECKING:
    from hydrosim.compiling.derived import Facts
    from hydrosim.database.database import HydroDatabase
    from hydrosim.stepping.dynamics import Model

HEADING_LOSS_WARNING = (
    0.05  # relative loss of loads between headings of a database that is worth a warning
)
AT_NODE = 1e-6  # rad: waves this close to a heading of the database count as at it
MAX_ENERGY_BETWEEN_HEADINGS = 0.01  # relative energy between headings that needs no message


class Meeting(NamedTuple):
    """At which place and heading of a ``body`` the waves meet it. ``lost`` are the parts of its
    first-order forces and moments that interpolation between the headings of the ``database``
    loses, if known. ``second_at_rest`` is true if second-order loads stay those at rest."""

    body: Body
    database: HydroDatabase
    position: Place
    headings: Place
    lost: tuple[float, float] | None
    second_at_rest: bool


def meetings(scene: Scene, facts: Facts, seas: Sequence[WaveComponents]) -> Iterator[Meeting]:
    """Meeting of each body that waves load."""
    alone = facts.databases
    for body in scene.bodies if seas else ():
        if body.name in alone and body.wave_forces.has_loads:
            db = alone[body.name]
            chosen = facts.met[body.name]
            between = chosen.headings != Place.MEAN or _is_between_headings(body, seas, db)
            between = between and body.wave_forces.first_order
            lost = lost_between_headings(db, seas) if between else None
            fixed = second_order_at_rest(chosen, db)
            yield Meeting(body, db, chosen.position, chosen.headings, lost, fixed)


def said_of_waves(meeting: Meeting) -> Iterator[str]:
    """Text on the position where waves act on the body, and on the method; empty at rest."""
    body = meeting.body
    if {meeting.position, meeting.headings} != {Place.MEAN}:
        position = meeting.position.describe("position")
        heading = meeting.headings.describe("heading")
        text = f"waves act on {body.name} at its {position} and its {heading}"
        if meeting.second_at_rest and meeting.headings != Place.MEAN:
            text += (
                "; second-order loads are those at rest, because its QTFs do not cover all headings"
            )
        yield text
    if meeting.lost is not None:
        yield f"{body.name}: {_loss_text(meeting.lost, meeting.database)}"


def coarse_headings(meeting: Meeting) -> Iterator[str]:
    """Warning about a database whose headings are too coarse for its hull in this sea."""
    lost = meeting.lost
    db = meeting.database
    if lost is not None and max(lost) > HEADING_LOSS_WARNING:
        yield (
            f"bodies.{meeting.body.name}: {_loss_text(lost, db)}; expected less than"
            f" {HEADING_LOSS_WARNING:.0%}. Compute the database for headings"
            f" {_spacing(db) / 2.0:.3g} deg apart, or choose waves that meet the body at a heading"
            " of the database."
        )


def said_of_current(scene: Scene, model: Model) -> Iterator[str]:
    """Note on the effect of the current on the added-mass loads of the bodies."""
    for b in model.headings.turning if scene.environment.current.speed else ():
        A = model.added_mass[6 * b : 6 * b + 2, 6 * b : 6 * b + 2]
        yield _munk(scene, scene.bodies[b], A, float(np.hypot(*model.headings.current[b])))


def _loss_text(lost: tuple[float, float], db: HydroDatabase) -> str:
    return (
        f"the headings of {db.source} are {_spacing(db):.3g} deg apart; interpolation between"
        f" them loses about {lost[0]:.1%} of the first-order forces and {lost[1]:.1%} of the"
        " moments in this sea"
    )


def _spacing(db: HydroDatabase) -> float:
    return 360.0 / db.heading.size


def _is_between_headings(body: Body, seas: Sequence[WaveComponents], db: HydroDatabase) -> bool:
    """Whether waves meet the body at rest between the headings of its database."""
    energy = np.concatenate([waves.amplitude**2 for waves in seas])
    to = np.concatenate([waves.heading for waves in seas]) - body.heading
    off = np.full(to.size, np.inf)
    for heading in db.heading:  # one at a time, because seas of long runs have many waves
        np.minimum(off, angle_between(to, heading), out=off)
    return bool(energy[off > AT_NODE].sum() > MAX_ENERGY_BETWEEN_HEADINGS * energy.sum())


def _munk(scene: Scene, body: Body, A: np.ndarray, speed: float) -> str:
    """Note on the Munk moment, which measured coefficients often contain as well, for the ``speed``
    of the current on the body."""
    largest = 0.5 * abs(A[1, 1] - A[0, 0]) * speed**2
    text = (
        f"the current turns {body.name} by its added mass (Munk moment), by at most"
        f" {largest:.3g} N m"
    )
    if any(
        isinstance(e, CurrentLoad) and e.body == body.name and np.any(e.yaw)
        for e in scene.forces.values()
    ):
        text += (
            ". Yaw coefficients of a current_load that were measured or computed in a steady"
            f" flow include this moment: subtract {0.5 * (A[0, 0] - A[1, 1]):.3g} sin(2 a) N m"
            " s^2/m^2 at a heading of a"
        )
    return text
