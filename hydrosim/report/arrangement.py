"""Drawing of the arrangement to scale: bodies, contacts and lines in plan and from the side, with
the directions of waves, current and wind, the axes, and a scale."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from math import cos, floor, log10, sin
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.files.display_units import Units, units_of
from hydrosim.files.document_layout import digits_of
from hydrosim.files.document_nodes import Drawing, Nodes
from hydrosim.report.replay import catenaries_at_rest, keel_of, lines_of, poses_at_rest, shape_of
from hydrosim.scene import GivenComponents, Scene
from hydrosim.scene.contacts import Contact

if TYPE_CHECKING:
    import xarray as xr

DRAWING_WIDTH = 720.0
DRAWING_MARGIN = 70.0
"""Margin around the drawing, for names and arrows."""
MAX_VIEW_HEIGHT = 420.0
"""Largest height of a view; taller views are scaled down."""
LABEL_HEIGHT = 12.0
"""Height of a line of text."""
ARROW_LENGTH = 46.0
CONTACT_LABEL_SHIFT, LINE_LABEL_SHIFT = np.array([6.0, -6.0]), np.array([6.0, 14.0])
"""Offset of a name from its contact, and from the start of its line."""
PLAN, SIDE = (0, 1), (0, 2)
SCALE_BAR_STEPS = (1.0, 2.0, 5.0, 10.0)
Points = np.ndarray


class DrawnBody(NamedTuple):
    """A body at rest: its ``name`` and the corners (n, 3) of its shape [m]."""

    name: str
    corners: Points


class DrawnLine(NamedTuple):
    """A line from one point to another (3,) [m], straight or through the points ``between`` (n, 3)
    which include both."""

    name: str
    start: Points
    end: Points
    between: Points | None = None


class SceneArrangement(NamedTuple):
    """Content of the drawing: bodies, contact points (n, 3) by element, lines, streams by name, as
    arrows to a heading [rad], and the places (1, 3) of joints by name."""

    bodies: list[DrawnBody]
    contacts: dict[str, Points]
    lines: list[DrawnLine]
    streams: list[tuple[str, float]]
    joints: dict[str, Points]


def arrangement_nodes(run: xr.Dataset, scene: Scene | None) -> Nodes:
    """Drawing of the ``scene`` of a run; nothing if its case cannot be read again."""
    if scene is not None:
        drawn = svg(arrange_scene(scene), units_of(run.attrs))
        yield Drawing("Arrangement at rest, to scale", drawn, DRAWING_NOTE)


DRAWING_NOTE = (
    "Bodies, contacts, joints and lines at rest, in plan and from the side, with waves, wind and"
    " current"
)


def arrange_scene(scene: Scene) -> SceneArrangement:
    """The scene at rest, in the earth frame."""
    poses = poses_at_rest(scene)

    def to_earth(body: str | None, points: Sequence[float] | Points) -> Points:
        body_points = np.asarray(points, float)
        if body is None:
            return body_points
        return body_points @ poses[body].turn.T + poses[body].centre

    bodies = []
    for body in scene.bodies:
        shape = shape_of(body, keel_of(scene, body.name))
        bodies.append(DrawnBody(body.name, to_earth(body.name, shape.triangles.reshape(-1, 3))))
    contacts = {
        name: to_earth(element.body, element.points)
        for name, element in scene.forces.items()
        if isinstance(element, Contact)
    }
    catenaries = catenaries_at_rest(scene)
    lines = [
        DrawnLine(name, to_earth(line.body, line.point), to_earth(line.anchor_body, line.anchor))
        for name, line in lines_of(scene).items()
        if name not in catenaries
    ]
    lines += [DrawnLine(name, points[0], points[-1], points) for name, points in catenaries.items()]
    joints = {
        name: to_earth(joint.body, np.array([joint.point])) for name, joint in scene.joints.items()
    }
    return SceneArrangement(bodies, contacts, lines, list(_mean_streams(scene)), joints)


def svg(of: SceneArrangement, units: Units) -> str:
    """Drawing as SVG: the plan above, the side view below, at one scale."""
    low, high = _extent_of_scene(of)
    views = [("plan", PLAN), ("side", SIDE)]
    scale = (DRAWING_WIDTH - 2.0 * DRAWING_MARGIN) / (high - low)[0]
    tall = max(float((high - low)[axes[1]]) for _, axes in views)
    scale = min(scale, MAX_VIEW_HEIGHT / tall)
    parts = []
    top = 0.0
    for name, axes in views:
        view = _View(axes, low, high, scale, top)
        parts += [_svg_text(70.0, top + 22.0, name, "start"), *_svg_elements(of, view, name)]
        top = view.bottom
    parts += _scale_bar(units, scale, top)
    height = top + 30.0
    box = f"0 0 {DRAWING_WIDTH:g} {height:.0f}"
    return f'<svg viewBox="{box}" class="arrangement">{"".join(parts)}</svg>'


class _View:
    """Projection on two earth axes, to the pixels of the picture."""

    def __init__(self, axes: tuple[int, int], low: Points, high: Points, scale: float, top: float):
        self.axes = axes
        self.scale = scale
        self._low = low[list(axes)]
        self._high = high[list(axes)]
        span = self._high - self._low
        self._left = 0.5 * (DRAWING_WIDTH - scale * span[0])
        self._top = top + DRAWING_MARGIN
        self.bottom = self._top + scale * float(span[1]) + 0.6 * DRAWING_MARGIN

    def to_pixels(self, points: Points) -> Points:
        """Pixels (n, 2) of points (n, 3) in the earth frame."""
        points_in_plane = np.atleast_2d(points)[:, list(self.axes)]
        across = self._left + self.scale * (points_in_plane[:, 0] - self._low[0])
        down = self._top + self.scale * (self._high[1] - points_in_plane[:, 1])
        return np.stack([across, down], axis=1)

    @property
    def top(self) -> float:
        """Upper edge of the drawn content."""
        return self._top


def _svg_elements(of: SceneArrangement, view: _View, name: str) -> Iterator[str]:
    if view.axes == SIDE:
        y = float(view.to_pixels(np.zeros(3))[0, 1])
        yield f'<line class="water" x1="0" x2="{DRAWING_WIDTH:g}" y1="{y:.1f}" y2="{y:.1f}"/>'
        yield _svg_text(DRAWING_WIDTH - 4.0, y - 4.0, "still water", "end")
    for k, body in enumerate(of.bodies):
        outline = _convex_outline(view.to_pixels(body.corners))
        yield f'<polygon class="hull c{k % 7}" points="{_points_text(outline)}"/>'
    for line in of.lines:
        if line.between is not None:
            path = _points_text(view.to_pixels(line.between))
            yield f'<polyline class="mooring" points="{path}"/>'
            continue
        (x1, y1), (x2, y2) = view.to_pixels(np.stack([line.start, line.end]))
        yield f'<line class="mooring" x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"/>'
    for points in of.contacts.values():
        for x, y in view.to_pixels(points):
            yield f'<circle class="contact" cx="{x:.1f}" cy="{y:.1f}" r="3"/>'
    for points in of.joints.values():
        for x, y in view.to_pixels(points):
            yield f'<circle class="joint" cx="{x:.1f}" cy="{y:.1f}" r="4"/>'
    yield from _names_svg(of, view)
    if view.axes == PLAN:
        yield from _arrows_svg(of.streams, view)
    yield from _axes_svg(view)


def _names_svg(of: SceneArrangement, view: _View) -> Iterator[str]:
    """Names of bodies at their centres, and of contacts, joints and lines beside them, without
    overlaps."""
    middles = {body.name: view.to_pixels(body.corners).mean(axis=0) for body in of.bodies}
    marked = of.contacts | of.joints
    contacts = {
        name: view.to_pixels(points)[0] + CONTACT_LABEL_SHIFT for name, points in marked.items()
    }
    lines = {line.name: view.to_pixels(line.start)[0] + LINE_LABEL_SHIFT for line in of.lines}
    taken: list[tuple[float, float]] = []
    for kind, labels in (("middle strong", middles), ("start", contacts), ("start", lines)):
        for name, (x, y) in labels.items():
            while any(abs(y - b) < LABEL_HEIGHT and abs(x - a) < 6.0 * len(name) for a, b in taken):
                y += LABEL_HEIGHT
            taken.append((x, y))
            yield _svg_text(x, y, name, kind)


def _arrows_svg(streams: Sequence[tuple[str, float]], view: _View) -> Iterator[str]:
    """An arrow for each sea, wind and current, in the upper right corner of the plan."""
    for k, (name, heading) in enumerate(streams):
        x = DRAWING_WIDTH - 60.0 - 110.0 * k
        yield _arrow_svg((x, 36.0), heading)
        yield _svg_text(x, 78.0, name, "middle")


def _axes_svg(view: _View) -> Iterator[str]:
    """Axes of the earth frame, in the upper left corner of a view."""
    x, y = 30.0, view.top - 12.0
    second = "y" if view.axes == PLAN else "z"
    yield _arrow_svg((x + 17.0, y), 0.0, 34.0)
    yield _arrow_svg((x, y - 17.0), 0.5 * np.pi, 34.0)
    yield _svg_text(x + 44.0, y + 4.0, "x", "middle")
    yield _svg_text(x, y - 40.0, second, "middle")


def _arrow_svg(middle: tuple[float, float], heading: float, length: float = ARROW_LENGTH) -> str:
    """An arrow towards a heading, counter-clockwise from the x axis to the right."""
    along = np.array([cos(heading), -sin(heading)])
    across = np.array([-along[1], along[0]])
    tip = np.array(middle) + 0.5 * length * along
    tail = np.array(middle) - 0.5 * length * along
    corners = [tip, tip - 9.0 * along + 4.0 * across, tip - 9.0 * along - 4.0 * across]
    head = _points_text(np.array(corners))
    shaft = f'x1="{tail[0]:.1f}" y1="{tail[1]:.1f}" x2="{tip[0]:.1f}" y2="{tip[1]:.1f}"'
    return f'<line class="arrow" {shaft}/><polygon class="arrow" points="{head}"/>'


def _scale_bar(units: Units, scale: float, top: float) -> Iterator[str]:
    unit, factor = units.display_unit("m")
    wanted = 120.0 / scale * factor
    power = 10.0 ** floor(log10(wanted))
    length = max(step * power for step in SCALE_BAR_STEPS if step * power <= wanted)
    pixels = length / factor * scale
    y = top + 10.0
    ends = f'x1="20" x2="{20.0 + pixels:.1f}" y1="{y:.1f}" y2="{y:.1f}"'
    yield f'<line class="scale" {ends}/>'
    yield _svg_text(28.0 + pixels, y + 4.0, f"{digits_of(length)} {unit}", "start")


def _mean_streams(scene: Scene) -> Iterator[tuple[str, float]]:
    """Waves, current and wind with the heading that they go to."""
    water = scene.environment
    for k, waves in enumerate(water.waves):
        if not isinstance(waves.spectrum, GivenComponents):
            yield ("waves" if len(water.waves) == 1 else f"waves {k + 1}"), float(waves.heading)
    for name in ("current", "wind"):
        stream = getattr(water, name)
        if stream.speed:
            yield name, float(stream.heading)


def _extent_of_scene(of: SceneArrangement) -> tuple[Points, Points]:
    """Corners of the box around bodies, contacts and joints, and the water surface; lines may
    extend beyond it."""
    marked = [*of.contacts.values(), *of.joints.values()]
    points = [body.corners for body in of.bodies] + marked + [np.zeros((1, 3))]
    every = np.concatenate([points[0], *points[1:]])
    low, high = every.min(axis=0), every.max(axis=0)
    least = 0.05 * float((high - low).max()) + 1e-3
    thin = np.maximum(0.5 * (least - (high - low)), 0.0)
    return low - thin, high + thin


def _convex_outline(points: Points) -> Points:
    """Convex outline (n, 2) of points (m, 2), or the box around them if they are on one line."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except QhullError:
        (x1, y1), (x2, y2) = points.min(axis=0), points.max(axis=0)
        return np.array([(x1, y1), (x2, y1), (x2, y2), (x1, y2)])


def _points_text(points: Points) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)


def _svg_text(x: float, y: float, text: str, kind: str) -> str:
    return f'<text class="{kind}" x="{x:.1f}" y="{y:.1f}">{escape(text)}</text>'
