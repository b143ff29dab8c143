"""Questions about the positions of fenders on a hull."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from hydrosim.compiling.questions.attachments import attachments
from hydrosim.compiling.questions.extents import COMPACT, ELLIPSE_OVER_RECTANGLE, Extents, extents
from hydrosim.compiling.questions.query import Query, SceneContext, text_beyond
from hydrosim.forces.contact.fender import Fender
from hydrosim.rigid.kinematics import Motion

INNER = 0.8  # of length and breadth, for hulls without sides
FREEBOARD_FRACTION = 0.25  # of the draught: height above the water to which hulls have sides
FAR_SIDE = -0.3  # of the half breadth towards the plane: points behind it are at the other side
MIN_WALL_NORMAL = 0.5  # horizontal part of the normal, below which a plane is no wall
# m, or half of the breadth: largest distance of fenders and brackets from the hull
STANDING_OFF = 5.0


def points(about: SceneContext) -> Iterator[Query]:
    """Ask about fender points inside a hull, which would cross the plane before contact, or far
    outside, and about other points far off their bodies."""
    yield from attachments(about)
    each = {body.name: extents(body, db) for _, body, db in about.floating_bodies()}
    wet = set(about.facts.databases)
    for name, fender in about.scene.forces.items():
        size = each.get(fender.body) if isinstance(fender, Fender) else None
        if size is None or not isinstance(fender, Fender):
            continue
        off = np.array([_outside(size, point) for point in fender.points])
        far = int(np.argmax(off))
        limit = max(STANDING_OFF, float(size.half.min()))
        if off[far] > limit:
            away = text_beyond(off[far], limit, ".2g")
            found_text = f"point {far + 1} about {away} m outside the hull of {fender.body}"
            usual = f"usual is up to {limit:.2g} m"
            yield Query(f"forces.{name}.points", found_text, usual, ADVICE)
        if fender.plane.corners or not {fender.plane.body} <= {None, *wet}:
            continue
        yield from _plane_inside(name, fender, each)
        normal = _normal(about.motion, about.index, fender)
        deep = np.array([_inside(size, point, normal) for point in fender.points])
        worst = int(np.argmax(deep))
        if deep[worst] > 0.0:
            where = (
                "at the far side of" if _is_far(size, fender.points[worst], normal) else "inside"
            )
            found_text = (
                f"point {worst + 1} {where} the hull of {fender.body}, which reaches about"
                f" {deep[worst]:.2g} m further towards the plane"
            )
            usual = "usual is a point at its side"
            yield Query(f"forces.{name}.points", found_text, usual, ADVICE)


def _plane_inside(
    name: str, fender: Fender, sizes: Mapping[str, Extents | None]
) -> Iterator[Query]:
    """Ask about a plane at the other side of the hull that it is fixed to."""
    size = sizes.get(fender.plane.body) if fender.plane.body is not None else None
    if size is None:
        return
    towards = np.array(fender.plane.normal, float)
    point = np.array(fender.plane.point, float)
    deep = _inside(size, point, -towards / np.linalg.norm(towards))
    if deep > float(size.half.min()):
        found_text = f"a plane that {fender.plane.body} exceeds by about {deep:.2g} m"
        usual = "usual is a plane at its side, with a normal that points away from it"
        yield Query(f"forces.{name}.plane", found_text, usual, ADVICE)


ADVICE = (
    "The size of the hull is estimated from its water plane. Points are in the body frame, from"
    " the centre of gravity."
)


def _normal(motion: Motion, index: dict[str, int], fender: Fender) -> np.ndarray:
    """Normal of the plane in the frame of the fender's body, at the start."""
    normal = np.array(fender.plane.normal, float)
    if fender.plane.body is not None:
        normal = motion.rotation[index[fender.plane.body]] @ normal
    own = motion.rotation[index[fender.body]].T @ normal
    return np.asarray(own / np.linalg.norm(own))


def _outside(size: Extents, point: np.ndarray) -> float:
    """Distance of a point beside or below a hull [m]."""
    off = point - size.centre
    aside = np.maximum(np.abs(off[:2]) - ELLIPSE_OVER_RECTANGLE * size.half, 0.0)
    below = max(-off[2] - ELLIPSE_OVER_RECTANGLE * size.draught, 0.0)
    return float(np.linalg.norm([*aside, below]))


def _inside(size: Extents, point: np.ndarray, normal: np.ndarray) -> float:
    """Distance by which a compact hull extends beyond a point inside it or at its other side,
    towards an upright plane with this ``normal`` [m]; 0 for other points."""
    x, y, z = point - size.centre
    level = float(np.linalg.norm(normal[:2]))
    if z >= FREEBOARD_FRACTION * size.draught or size.filled < COMPACT or level < MIN_WALL_NORMAL:
        return 0.0
    towards = -normal[:2] / level
    within = bool(np.all(np.abs([x, y]) < INNER * size.half)) or _is_far(size, point, normal)
    return float(np.abs(towards) @ size.half - towards @ [x, y]) if within else 0.0


def _is_far(size: Extents, point: np.ndarray, normal: np.ndarray) -> bool:
    """Whether a hull is between a point and an upright plane with this ``normal``."""
    x, y, _ = point - size.centre
    towards = -normal[:2] / np.linalg.norm(normal[:2])
    behind = towards @ [x, y] < FAR_SIDE * (np.abs(towards) @ size.half)
    across = np.abs(towards[0] * y - towards[1] * x)
    return bool(behind and across < INNER * (np.abs(towards) @ size.half[::-1]))
