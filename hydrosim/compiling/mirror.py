"""Force elements that are not their own mirror image in a vertical plane along x.

An element that acts on all coordinates of a body is its own image if it does not couple surge,
heave and pitch with sway, roll and yaw. Elements that act at points need an image among the
elements: each point of a fender, each spring, applied force and stream load, on the other side or
in the plane. Points with rigid friction must be in the plane. Beside it, the shares of their load
depend on the motions out of the plane.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.dofs import DOFS, MIRROR_SIGN, SMALL
from hydrosim.forces.mirroring import LATERAL

if TYPE_CHECKING:
    from hydrosim.scene import ForceElement

COUPLES = f"couples {', '.join(x for x in DOFS if x not in LATERAL)} with {', '.join(LATERAL)}"


def couples(matrices: np.ndarray, lateral: np.ndarray) -> bool:
    """Whether any of the ``matrices`` (..., m, m) couples ``lateral`` coordinates (m,) with the
    others by more than `SMALL` times the geometric mean of their diagonals (the largest of all
    matrices)."""
    size = np.abs(matrices).reshape(-1, lateral.size, lateral.size).max(axis=0)
    scale = np.sqrt(np.diag(size))
    coupled = size > SMALL * np.outer(scale, scale)
    return bool(np.any(coupled & (lateral[:, None] != lateral)))


def without_image(elements: Mapping[str, ForceElement], y: float) -> Iterator[str]:
    """Messages on force elements that are not symmetric about the plane at ``y`` [m]."""
    for name, element in elements.items():
        if any(couples(matrix, MIRROR_SIGN < 0.0) for matrix in element.couplings()):
            yield f"{name} {COUPLES}"
        if reason := element.asymmetry():
            yield f"{name} {reason}"
    yield from (f"{name} has no mirror image" for name in dict.fromkeys(_alone(elements, y)))


def _alone(elements: Mapping[str, ForceElement], y: float) -> Iterator[str]:
    """Names of the elements with parts that have no image. One part has at most one image."""
    parts = [(name, part) for name, element in elements.items() for part in element.parts(y)]
    left = [part for _, part in parts]
    for name, part in parts:
        image = part.image()
        found = next((k for k, other in enumerate(left) if _same(image, other)), None)
        if found is None:
            yield name
        else:
            del left[found]


def _same(one: object, other: object) -> bool:
    """Whether parts of elements are equal entry by entry: numbers within `SMALL` of the largest
    number of their array."""
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
