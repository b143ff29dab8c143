"""Struts, torsion springs, springs of joints, power take-offs: curves of both signs, with damping.

    T = f(x) + c x' + d |x'| x'

f: straight lines through the points of a curve, with the first and last slopes continued. Corners
are events. Stored energy is the integral of f. c, d: linear and quadratic damping. c x'^2 + d
|x'|^3 is the dissipated power; it is the absorbed power of a power take-off.

Limits: the slope of |x'| x' has a corner at x' = 0, so methods have order 3 with d.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from hydrosim.elements.contact import curves
from hydrosim.elements.kind import Layout, Variable
from hydrosim.elements.link.coordinate import (
    JointMotionElement,
    TwistElement,
    distance_fields,
)
from hydrosim.elements.link.law import (
    LOAD_OUTPUT,
    PLACE_OUTPUT,
    Column,
    Link,
    curve_fields,
    load_and_place,
)
from hydrosim.elements.pair import TwoPointElement
from hydrosim.jit.kernels import kernel
from hydrosim.modes import SEGMENT, SEGMENT_MARGIN
from hydrosim.scene import ForceElement, Turns


@dataclass(frozen=True)
class ElasticLink(Link):
    """The load ``force`` (n,) [N or N m] over the offset ``offset`` (n,) [m or rad], rising, from
    where the link has its neutral length or angle. Both are empty if it has no spring. ``damping``
    [N s/m or N m s/rad], and ``drag`` [N s^2/m^2 or N m s^2/rad^2]. The power that a link with
    ``absorbs`` dissipates is recorded."""

    offset: np.ndarray
    force: np.ndarray
    damping: float = 0.0
    drag: float = 0.0
    absorbs: bool = False

    def can_carry_weight(self) -> bool:
        return bool(np.any(self.force))

    def curve(self) -> np.ndarray:
        """The pieces of the curve, with no energy stored at offset 0."""
        if not len(self.offset):
            return curves.segments(np.array([0.0, 1.0]), np.zeros(2))
        pieces = curves.segments(self.offset, self.force)
        middle = pieces[curves.piece_at(pieces, 0.0)]
        d = -middle["start"]
        pieces["energy"] -= middle["energy"] + (middle["force"] + 0.5 * middle["slope"] * d) * d
        return pieces

    def law_fields(self, curve: np.ndarray) -> dict[str, Any]:
        idle = curves.piece_at(curve, 0.0)
        fields = curve_fields(curve, idle, (curve["lower"][idle], curve["upper"][idle]))
        stiff = fields["stiff"]
        return {
            **fields,
            "stiff_range": (curve["lower"][stiff], curve["upper"][stiff]),
            "damping": self.damping,
            "drag": self.drag,
            "absorbs": self.absorbs,
        }


@dataclass(frozen=True, kw_only=True)
class Strut(TwoPointElement, ElasticLink):
    """From ``point`` of the body to ``anchor`` on the earth or in the frame of ``anchor_body``.
    ``length`` [m] is the length without force of the spring; None: the length at rest."""

    dimension = "strut"
    columns: ClassVar = {
        "strut_force": Column(
            LOAD_OUTPUT, Variable("force, tension positive", "N", "from the point to the anchor")
        ),
        "strut_length": Column(
            PLACE_OUTPUT, Variable("distance from the point to the anchor", "m")
        ),
    }
    point: tuple[float, ...]
    anchor: tuple[float, ...]
    length: float | None = None
    anchor_body: str | None = None

    def restored_dofs(self) -> Collection[str]:
        return super().restored_dofs() if self.can_carry_weight() else ()

    def coordinate_fields(self, layout: Layout) -> dict[str, Any]:
        return distance_fields(self, self.length, layout)


@dataclass(frozen=True, kw_only=True)
class TorsionSpring(TwistElement, ElasticLink):
    """About ``axis`` in the frame of the body, between it and the body ``to`` or the earth.
    ``neutral`` [rad] is the twist without moment of the spring; the twist is 0 at rest."""

    dimension = "torsion_spring"
    columns: ClassVar = {
        "torsion_moment": Column(
            LOAD_OUTPUT, Variable("moment against the twist", "N m", "about the axis")
        ),
        "torsion_angle": Column(PLACE_OUTPUT, Variable("twist about the axis from rest", "rad")),
    }

    def restored_dofs(self) -> Collection[str]:
        held = self.to is None and np.any(self.force) and self.axis[2] != 0.0
        return ("yaw",) if held else ()

    def can_carry_weight(self) -> bool:
        return False

    def nonlinearity(self, name: str, turns: Turns) -> str | None:
        """Linear with small angles, if its curve and its damping are."""
        straight = len(self.offset) <= 2 and self.drag == 0.0
        return None if straight and not turns.exact else name

    def mirrored_parts(self, y: float) -> Sequence[ForceElement]:
        return [self._in_order()]

    def mirror_image(self) -> ForceElement:
        """A rotation about (x, y, z) has the image of one about (-x, y, -z)."""
        x, y, z = self.axis
        return replace(self, axis=(-x, y, -z))._in_order()

    def _in_order(self) -> TorsionSpring:
        """The same spring with the axis of unit length and, if its curve is odd, towards positive
        coordinates."""
        axis = np.array(self.axis) / np.linalg.norm(self.axis)
        straight = len(self.offset) <= 2 and not (np.any(self.offset[:1]) or np.any(self.force[:1]))
        first = axis[np.flatnonzero(np.abs(axis) > 1e-12)[0]]
        if straight and self.neutral == 0.0 and first < 0.0:
            axis = -axis
        return replace(self, axis=tuple(axis))


@dataclass(frozen=True, kw_only=True)
class JointSpring(JointMotionElement, ElasticLink):
    """In a ``motion`` of a ``joint``, against it. ``neutral`` [m or rad] is the place without load
    of the spring; the motion is 0 at rest."""

    dimension = "joint_spring"
    columns: ClassVar = load_and_place(dimension)


@kernel
def resistance(link, rate):
    """c x' + d |x'| x'."""
    return (link.damping + link.drag * abs(rate)) * rate


@kernel
def find_loads(link, mode, s, p):
    """T, and the power that it dissipates."""
    lost = resistance(link, s.rate)
    return curves.curve_force(p.segments[mode[SEGMENT]], s.x) + lost, lost * s.rate


@kernel
def find_margins(link, mode, s, p, out):
    """Margins (4,): the distance to the nearer corner of the curve."""
    if link.last > link.first:
        out[SEGMENT_MARGIN] = curves.segment_margin(p.segments[mode[SEGMENT]], s.x)


@kernel
def transition(mode, s, p):
    """The next piece of the curve."""
    mode[SEGMENT] = curves.next_segment(mode[SEGMENT], p.segments[mode[SEGMENT]], s.x)


@kernel
def set_initial_mode(link, mode, s, p):
    """The piece of a link that becomes active."""
    mode[SEGMENT] = curves.find_segment(link.first, link.last, p.segments, s.x)
