"""Questions about where catenaries run: through the seabed, under a hull, and how soft they are."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hydrosim.compiling.questions.chains import bar_diameters
from hydrosim.compiling.questions.extents import COMPACT, Extents, extents
from hydrosim.compiling.questions.query import Query, SceneContext, text_beyond
from hydrosim.forces.line.catenary import Catenary
from hydrosim.forces.line.now import LineShape, line_shapes

# m
BURIED = 1.0
HOVERING = 0.25  # of the water depth, for lines that know no seabed
ABOVE_BED = 0.03  # of the water depth, for lines that do
MIN_ABOVE_BED = 2.0
SOFT = 1e-3  # EA over the weight of the lightest body; a nylon hawser of a large tanker has 1.5e-3
AT_SIDE = 0.7  # of half of the breadth or length: fairleads further out are at a side
WIDE_CHAIN = 20.0  # bar diameters: coefficient times diameter, 2.4 of studless chain
WIDEST = 10.0  # m, of other lines
CROSSING = 0.5  # of the breadth of a hull
KEEL = 0.8  # of the draught: fairleads deeper are at the keel


def routes(about: SceneContext) -> Iterator[Query]:
    """Ask about lines that run through the seabed or a hull, hang above it, or are too soft."""
    state = about.state
    depth = about.scene.environment.water_depth
    sizes = {body.name: extents(body, db) for _, body, db in about.floating_bodies()}
    bodies = about.model.bodies
    begin = about.end - about.scene.duration
    every = line_shapes(about.model, about.scene, begin, state.y, state.modes, bodies, about.motion)
    for line in every:
        of = about.scene.forces[line.name]
        assert isinstance(of, Catenary)
        yield from _beside_bed(line, of, depth)
        yield from _softness(about, line, of)
        yield from _drag(about, line, of)
        size = sizes.get(of.body)
        if size is not None and of.anchor_body is None and of.anchor[2] < 0.0:
            yield from _under_hull(about, line, of, size)


def _beside_bed(line: LineShape, of: Catenary, depth: float) -> Iterator[Query]:
    """Ask about a line that runs below the seabed, and about an anchor high above it."""
    key = f"forces.{line.name}"
    lowest = -float(line.places()[0][:, 2].min())
    if of.friction is None and lowest > depth + BURIED:
        found_text = f"a line down to {text_beyond(lowest, depth)} m in water of {depth:g} m"
        usual = "usual is a line above the seabed"
        yield Query(key, found_text, usual, "With the key seabed, it rests on the seabed.")
    moored = of.anchor_body is None and of.anchor[2] < 0.0
    above = depth + of.anchor[2]
    limit = max(HOVERING * depth, BURIED)
    if of.friction is not None:
        limit = max(ABOVE_BED * depth, MIN_ABOVE_BED)
    if moored and np.isfinite(depth) and above > limit:
        found_text = f"an anchor {above:.3g} m above the seabed, in water of {depth:g} m"
        yield Query(f"{key}.anchor", found_text, "usual is an anchor on the seabed")


def _softness(about: SceneContext, line: LineShape, of: Catenary) -> Iterator[Query]:
    """Ask about mooring lines whose EA is hardly a thousandth of the weight that they hold."""
    if of.anchor_body is not None or of.body not in about.facts.databases:
        return
    weight = about.scene.environment.gravity * about.scene.bodies[about.index[of.body]].mass
    stiffness = float(line.line_pieces["stiffness"].min())
    if stiffness < SOFT * weight:
        found_text = f"an EA of {stiffness:.3g} N, for a body whose weight is {weight:.3g} N"
        usual = f"usual is above {SOFT:g} of the weight"
        advice = "Check the diameter and its unit."
        yield Query(f"forces.{line.name}.segments", found_text, usual, advice)


def _drag(about: SceneContext, line: LineShape, of: Catenary) -> Iterator[Query]:
    """Ask about drag of a line that is far wider than its chain, or wider than any line."""
    widest = float(of.drag_width.max())
    bars = list(bar_diameters(of, about.scene.environment))
    limit = WIDE_CHAIN * max(bars) if bars else WIDEST
    if widest > limit:
        found_text = f"a drag coefficient times diameter of {text_beyond(widest, limit)} m"
        usual = f"usual is up to {limit:.3g} m"
        yield Query(f"forces.{line.name}.segments", found_text, usual, "Is the diameter in mm?")


def _under_hull(
    about: SceneContext, line: LineShape, of: Catenary, size: Extents
) -> Iterator[Query]:
    """Ask about a line from a side of a compact hull that crosses under it to the other side."""
    aside = (np.array(of.point[:2]) - size.centre[:2]) / size.half
    at_keel = of.point[2] < size.centre[2] - KEEL * size.draught
    if size.filled < COMPACT or at_keel or np.abs(aside).max() < AT_SIDE:
        return
    turn = about.motion.rotation[about.index[of.body]]
    away = turn.T @ np.array([*line.ends.e, 0.0])
    inside = _length_inside(aside, away[:2] / size.half)
    limit = CROSSING * 2.0 * float(size.half.min())
    if inside > limit:
        found_text = f"a line that runs {text_beyond(inside, limit)} m under the hull of {of.body}"
        usual = "usual is a fairlead on the side of its anchor"
        advice = "Has point the sign of the other side?"
        yield Query(f"forces.{line.name}.point", found_text, usual, advice)


def _length_inside(start: np.ndarray, direction: np.ndarray) -> float:
    """Length [m] inside the square |x|, |y| < 1 of the ray from ``start`` (2,) along ``direction``
    (2,), per metre."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.sort([(-1.0 - start) / direction, (1.0 - start) / direction], axis=0)
    enters = float(np.nanmax([0.0, *ends[0]]))
    leaves = float(np.nanmin(ends[1]))
    return max(leaves - enters, 0.0)
