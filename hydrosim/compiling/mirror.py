"""Which force elements are not their own mirror image in a vertical plane along x.

An element that acts on all coordinates of a body is its own image if it does not couple surge,
heave and pitch with sway, roll and yaw. What acts at points needs an image among the elements: each
point of a fender, a spring, an applied force or the load of a stream its own, at the other side or
in the plane. Points with rigid friction must be in the plane: beside it, how they share a load is
not defined without motions that lead aside.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace

import numpy as np

from hydrosim.database.database import TURN
from hydrosim.dofs import DOFS, MIRROR_SIGN
from hydrosim.forces import (
    AppliedForce,
    Coulomb,
    Fender,
    LinearDamping,
    LinearMooring,
    Plane,
    QuadraticDamping,
    Spring,
    StreamLoad,
)
from hydrosim.forces.signal import scaled
from hydrosim.scene import ForceElement

SMALL = 1e-6
"""Of what is there by symmetry: less than this is left of a zero in tables of six digits."""
LATERAL = tuple(dof for dof, sign in zip(DOFS, MIRROR_SIGN, strict=True) if sign < 0.0)
COUPLES = f"couples {', '.join(x for x in DOFS if x not in LATERAL)} with {', '.join(LATERAL)}"
BY_COORDINATES = (LinearMooring, LinearDamping, QuadraticDamping)

Vector = Sequence[float] | np.ndarray


def couples(matrices: np.ndarray, lateral: np.ndarray) -> bool:
    """Whether any of the ``matrices`` (..., m, m) couples those of its coordinates that are
    ``lateral`` (m,) with the others, by more than `SMALL` of the geometric mean of their diagonals
    (the largest of all matrices)."""
    size = np.abs(matrices).reshape(-1, lateral.size, lateral.size).max(axis=0)
    scale = np.sqrt(np.diag(size))
    coupled = size > SMALL * np.outer(scale, scale)
    return bool(np.any(coupled & (lateral[:, None] != lateral)))


def without_image(elements: Mapping[str, ForceElement], y: float) -> Iterator[str]:
    """What is not symmetric about the plane at ``y`` [m] among force elements, in words."""
    for name, element in elements.items():
        if any(couples(matrix, MIRROR_SIGN < 0.0) for matrix in _matrices(element)):
            yield f"{name} {COUPLES}"
        match element:
            case Fender(friction=Coulomb(), points=points) if np.any(points[:, 1]):
                yield f"{name} has rigid friction beside the plane"
    yield from (f"{name} has no mirror image" for name in dict.fromkeys(_alone(elements, y)))


def _matrices(element: ForceElement) -> Iterator[np.ndarray]:
    if isinstance(element, LinearMooring):
        yield element.stiffness
    if isinstance(element, BY_COORDINATES) and element.damping is not None:
        yield element.damping


def _alone(elements: Mapping[str, ForceElement], y: float) -> Iterator[str]:
    """Names of the elements with parts that have no image; an image is that of one part."""
    parts = [
        (name, part)
        for name, element in elements.items()
        if not isinstance(element, BY_COORDINATES)
        for part in _parts(element, y)
    ]
    left = [part for _, part in parts]
    for name, part in parts:
        image = _image(part)
        found = next((k for k, other in enumerate(left) if _same(image, other)), None)
        if found is None:
            yield name
        else:
            del left[found]


def _parts(element: ForceElement, y: float) -> Iterable[ForceElement]:
    """The element in comparable parts, with places on the earth relative to the plane at ``y``."""
    match element:
        case Fender(plane=plane):
            level = replace(plane, point=_foot(plane, 0.0 if plane.body else y))
            return [replace(element, points=point[None], plane=level) for point in element.points]
        case Spring(anchor_body=None):
            return [replace(element, anchor=tuple(np.subtract(element.anchor, (0.0, y, 0.0))))]
        case StreamLoad():
            return [_by_heading(element)]
    return [element]


def _foot(plane: Plane, y: float) -> tuple[float, ...]:
    """The point of the plane that is nearest to the origin, moved by -``y``."""
    n = np.array(plane.normal, dtype=float)
    return tuple(n * (np.subtract(plane.point, (0.0, y, 0.0)) @ n) / (n @ n))


def _by_heading(load: StreamLoad) -> StreamLoad:
    headings = np.mod(load.headings, TURN)
    order = np.argsort(headings)
    surge, sway, yaw = (np.asarray(x)[order] for x in (load.surge, load.sway, load.yaw))
    return replace(load, headings=headings[order], surge=surge, sway=sway, yaw=yaw)


def _image(part: ForceElement) -> ForceElement | None:
    """The mirror image of a part; None if nothing is known of it."""
    match part:
        case Fender(plane=plane):
            turned = replace(plane, point=_turned(plane.point), normal=_turned(plane.normal))
            return replace(part, points=part.points * MIRROR_SIGN[:3], plane=turned)
        case Spring():
            return replace(part, point=_turned(part.point), anchor=_turned(part.anchor))
        case AppliedForce():
            force = {
                dof: scaled(signal, -1.0) if dof in LATERAL else signal
                for dof, signal in part.force.items()
            }
            return replace(part, point=_turned(part.point), force=force)
        case StreamLoad():
            sway, yaw = -part.sway, -part.yaw
            load = replace(part, point=_turned(part.point), sway=sway, yaw=yaw)
            return _by_heading(replace(load, headings=-part.headings))
    return None


def _turned(vector: Vector) -> tuple[float, ...]:
    return tuple(np.asarray(vector) * MIRROR_SIGN[:3])


def _same(one: object, other: object) -> bool:
    """Whether parts of elements are equal, entry by entry: numbers within `SMALL` of the largest of
    their array."""
    if type(one) is type(other) and is_dataclass(one):
        return all(_same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(_same(one[key], other[key]) for key in one)
    if one is None or other is None:
        return one is other
    if is_dataclass(one) or isinstance(one, str):
        return one == other
    a, b = np.asarray(one, dtype=float), np.asarray(other, dtype=float)
    return a.shape == b.shape and bool(np.all(np.abs(a - b) <= SMALL * np.abs(a).max(initial=0.0)))
