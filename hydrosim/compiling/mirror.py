"""Force elements and joints that are not their own mirror image in a vertical plane along x.

An element that acts on all coordinates of a body is its own image if it does not couple surge,
heave and pitch with sway, roll and yaw. Elements that act at points need an image among the
elements: each point of a fender, each spring, applied force and stream load, on the other side or
in the plane. Points with rigid friction must be in the plane. Beside it, the shares of their load
depend on the motions out of the plane.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.dofs import DOFS, MIRROR_SIGN, SYMMETRY_RTOL
from hydrosim.forces.mirroring import LATERAL
from hydrosim.scene.joint import JointType

if TYPE_CHECKING:
    from hydrosim.scene import Active, ForceElement, Joint, Window

MIRROR = np.diag([1.0, -1.0, 1.0])
AXES = {JointType.FIXED: 0, JointType.BALL: 0, JointType.UNIVERSAL: 2, JointType.ROD: 0}
"""Number of axes that matter, for joints that do not have one."""
COUPLES = f"couples {', '.join(x for x in DOFS if x not in LATERAL)} with {', '.join(LATERAL)}"


def couples(matrices: np.ndarray, lateral: np.ndarray) -> bool:
    """Whether any of the ``matrices`` (..., m, m) couples ``lateral`` coordinates (m,) with the
    others by more than `SYMMETRY_RTOL` times the geometric mean of their diagonals (the largest of
    all matrices)."""
    size = np.abs(matrices).reshape(-1, lateral.size, lateral.size).max(axis=0)
    scale = np.sqrt(np.diag(size))
    coupled = size > SYMMETRY_RTOL * np.outer(scale, scale)
    return bool(np.any(coupled & (lateral[:, None] != lateral)))


def without_image(elements: Mapping[str, ForceElement], y: float) -> Iterator[str]:
    """Messages on force elements that are not symmetric about the plane at ``y`` [m]."""
    for name, element in elements.items():
        if any(couples(matrix, MIRROR_SIGN < 0.0) for matrix in element.couplings()):
            yield f"{name} {COUPLES}"
        if reason := element.asymmetry():
            yield f"{name} {reason}"
    yield from (
        f"{name} has no mirror image" for name in dict.fromkeys(_unpaired_elements(elements, y))
    )


def joints_without_image(joints: Mapping[str, Joint], y: float) -> Iterator[str]:
    """Messages on joints that are not symmetric about the plane through their bodies, at ``y``
    [m]."""
    shapes = {name: _shape(joint, y) for name, joint in joints.items()}
    for name, shape in shapes.items():
        if not any(_is_equal(shape.image(), other) for other in shapes.values()):
            yield f"{name} has no mirror image"


@dataclass(frozen=True, eq=False)
class _Shape:
    """What a joint holds: its axes (m, 3, 3) as a a^T, because their sense does not matter, and
    the ``arrow`` (3,) along which a ratchet goes, or (turning) about which it turns; of a rod, its
    other end."""

    between: str
    times: _Times
    point: np.ndarray
    axes: np.ndarray
    arrow: np.ndarray
    turning: bool

    def image(self) -> _Shape:
        """Its mirror image: a turn about an axis in the plane becomes its opposite."""
        sign = -1.0 if self.turning else 1.0
        axes = MIRROR @ self.axes @ MIRROR
        return replace(self, point=MIRROR @ self.point, axes=axes, arrow=sign * MIRROR @ self.arrow)


class _Times(NamedTuple):
    """When a joint holds, and its teeth."""

    active: Active | None
    window: Window | None
    pitch: float
    breaks_at: float | None
    length: float | None


def _shape(joint: Joint, y: float) -> _Shape:
    axes = joint.axes()
    lines = [np.outer(axes[k], axes[k]) for k in range(AXES.get(joint.type, 1))]
    pawl = joint.ratchet
    return _Shape(
        f"{joint.type} {joint.body} {joint.to}",
        _Times(
            joint.active, joint.window, pawl.pitch if pawl else 0.0, joint.breaks_at, joint.length
        ),
        np.array(joint.point, dtype=float),
        np.array(lines).reshape(-1, 3, 3),
        _arrow(joint, y),
        pawl is not None and pawl.turns,
    )


def _arrow(joint: Joint, y: float) -> np.ndarray:
    """Direction of a ratchet, or the other end of a rod from the plane."""
    if joint.ratchet is not None:
        return joint.axes()[0]
    end = np.array(joint.to_point or (0.0, 0.0, 0.0), dtype=float)
    return end if joint.to is not None or joint.to_point is None else end - (0.0, y, 0.0)


def _unpaired_elements(elements: Mapping[str, ForceElement], y: float) -> Iterator[str]:
    """Names of the elements with parts that have no image. One part has at most one image."""
    parts = [
        (name, part) for name, element in elements.items() for part in element.mirrored_parts(y)
    ]
    left = [part for _, part in parts]
    for name, part in parts:
        image = part.mirror_image()
        found = next((k for k, other in enumerate(left) if _is_equal(image, other)), None)
        if found is None:
            yield name
        else:
            del left[found]


def _is_equal(one: object, other: object) -> bool:
    """Whether parts of elements are equal entry by entry: numbers within `SYMMETRY_RTOL` of the
    largest number of their array."""
    if type(one) is type(other) and is_dataclass(one):
        return all(_is_equal(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(_is_equal(one[key], other[key]) for key in one)
    if one is None or other is None:
        return one is other
    if is_dataclass(one) or isinstance(one, str | _Times):
        return one == other
    a, b = np.asarray(one, dtype=float), np.asarray(other, dtype=float)
    if a.shape != b.shape:
        return False
    infinite = np.isinf(a) | np.isinf(b)
    if not np.array_equal(a[infinite], b[infinite]):
        return False
    a, b = a[~infinite], b[~infinite]
    return bool(np.all(np.abs(a - b) <= SYMMETRY_RTOL * np.abs(a).max(initial=0.0)))
