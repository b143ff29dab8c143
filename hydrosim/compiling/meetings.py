"""What there is to say of where waves and a current meet the bodies of a scene."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from hydrosim.compiling.wet import WetGroup, each_alone
from hydrosim.database import HydroDatabase
from hydrosim.forces import CurrentLoad
from hydrosim.scene import Body, Kinematics, Place, Scene
from hydrosim.stepping.dynamics import Model
from hydrosim.waves import Components, places
from hydrosim.waves.coarse import lost_between_headings

LOST = 0.05  # of the loads between the headings of a database is worth a warning
AT_NODE = 1e-6  # rad: waves so near to a heading of the database are at it
BESIDE = 0.01  # of the energy may be between headings without a word


def meetings(
    scene: Scene, wet: Sequence[WetGroup], model: Model, seas: Sequence[Components]
) -> Iterator[str]:
    """Where the waves meet each wet body, and how exactly; what the current does to its water."""
    alone = each_alone(wet)
    for b, body in enumerate(scene.bodies):
        if body.name in alone and seas and body.wave_forces.first_order:
            chosen = places(scene, body, alone[body.name])
            if {chosen.position, chosen.headings} != {Place.MEAN}:
                yield _followed(body, chosen.position, chosen.headings)
            if _between(scene, body, seas, alone[body.name]):
                yield from _interpolated(body, seas, alone[body.name])
        if b in model.headings.turning and scene.environment.current.speed:
            yield from _munk(scene, body, model.added_mass[6 * b : 6 * b + 2, 6 * b : 6 * b + 2])


def coarse_headings(
    scene: Scene, wet: Sequence[WetGroup], seas: Sequence[Components]
) -> Iterator[str]:
    """Warnings of databases whose headings are too coarse for their hulls in this sea."""
    alone = each_alone(wet)
    for body in scene.bodies:
        db = alone.get(body.name)
        if db is None or not body.wave_forces.first_order or not _between(scene, body, seas, db):
            continue
        lost = lost_between_headings(db, seas)
        if lost is not None and max(lost) > LOST:
            yield (
                f"bodies.{body.name}: {_said(lost, db)}; expected less than {LOST:.0%}. Compute the"
                f" database for headings {_spacing(db) / 2.0:.3g} deg apart, or take waves that go"
                " to one of its headings as the body has them."
            )


def _followed(body: Body, position: Place, headings: Place) -> str:
    whole = {Place.MEAN: "at rest", Place.SLOW: "slow", Place.INSTANTANEOUS: "at the time"}
    return f"waves meet {body.name} at its place {whole[position]}, heading {whole[headings]}"


def _interpolated(body: Body, seas: Sequence[Components], db: HydroDatabase) -> Iterator[str]:
    lost = lost_between_headings(db, seas)
    if lost is not None:
        yield f"{body.name}: {_said(lost, db)}"


def _said(lost: tuple[float, float], db: HydroDatabase) -> str:
    return (
        f"between the headings of {db.source}, {_spacing(db):.3g} deg apart, about {lost[0]:.1%} of"
        f" the first-order forces and {lost[1]:.1%} of the moments are lost in this sea"
    )


def _spacing(db: HydroDatabase) -> float:
    return 360.0 / db.heading.size


def _between(scene: Scene, body: Body, seas: Sequence[Components], db: HydroDatabase) -> bool:
    """Whether the body meets waves between the headings of its database."""
    if not seas:
        return False
    if places(scene, body, db).headings != Place.MEAN:
        return True
    energy = np.concatenate([waves.amplitude**2 for waves in seas])
    to = np.concatenate([waves.heading for waves in seas]) - body.heading
    apart = np.abs(np.mod(to[:, None] - db.heading + np.pi, 2.0 * np.pi) - np.pi).min(axis=1)
    return bool(energy[apart > AT_NODE].sum() > BESIDE * energy.sum())


def _munk(scene: Scene, body: Body, A: np.ndarray) -> Iterator[str]:
    """A steady current turns the hull by its added mass, and coefficients often have that too."""
    speed = scene.environment.current.speed
    largest = 0.5 * abs(A[1, 1] - A[0, 0]) * speed**2
    text = f"the current turns {body.name} by its added mass (Munk), with {largest:.3g} N m at most"
    exact = scene.solver.kinematics == Kinematics.EXACT
    if exact and any(
        isinstance(e, CurrentLoad) and e.body == body.name and np.any(e.yaw)
        for e in scene.forces.values()
    ):
        text += (
            "; yaw coefficients of a current_load that were measured or computed for a steady flow"
            f" hold it already, {0.5 * (A[0, 0] - A[1, 1]):.3g} sin(2 a) N m s^2/m^2 at a heading"
            " of a: take that from them"
        )
    yield text
