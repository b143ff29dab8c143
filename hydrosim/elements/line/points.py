"""Points of a line in its plane, and lines at one state of a scene, for pictures and messages."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from hydrosim.elements.kind import KindConstants
from hydrosim.elements.line import catenary
from hydrosim.elements.line.hang import SuspendedLine, branches_at, find_touchdown
from hydrosim.elements.line.kind import CATENARY_KIND
from hydrosim.elements.line.search import is_on_bed, line_frame
from hydrosim.elements.line.shape import LinePull
from hydrosim.elements.signal import value
from hydrosim.modes import INACTIVE, MODE, NO_INDEX
from hydrosim.scene import Scene


def line_points(line: SuspendedLine, pull: LinePull, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 2) [m] of a line with its ``pull``, from the fairlead to the anchor: horizontal
    distance from the fairlead, and height above the anchor; and the tension (n,) [N] there. They
    divide the unstretched length evenly. The slack of a line without pull is spread evenly."""
    f = line_frame(line)
    line_pieces = line.pieces[line.first : line.last]
    ends = np.concatenate([[0.0], np.cumsum(line_pieces["length"])])
    lift = ends[-1]
    friction = line.friction if is_on_bed(line, f) else 0.0
    if pull.touch < lift and not is_on_bed(line, f):
        lift -= find_touchdown(line, -1, -pull.anchor_V).arc
    s = np.linspace(0.0, ends[-1], n)
    H = max(pull.H, f.least)
    corners = [*_corner_arcs(line_pieces, ends, H, pull, friction)]
    cuts = np.unique(np.concatenate([s, ends, [pull.touch, lift, ends[-1] - pull.dead], *corners]))
    cuts = cuts[(cuts >= 0.0) & (cuts <= ends[-1])]
    Va, Vb = _vertical_pull(line_pieces, ends, cuts, pull, lift)
    Ta, Tb = np.hypot(H, Va), np.hypot(H, Vb)
    lies = (cuts[:-1] >= pull.touch) & (cuts[:-1] < lift)
    Ta[lies] = np.maximum(H + friction * Va[lies], 0.0)
    Tb[lies] = np.maximum(H + friction * Vb[lies], 0.0)
    Va, Vb = np.where(lies, 0.0, Va), np.where(lies, 0.0, Vb)
    length = np.diff(cuts)
    middle = np.where(lies, 0.5 * (Ta + Tb), np.hypot(H, 0.5 * (Va + Vb)))
    EA, o = branches_at(line_pieces[_pieces_of(ends, cuts)], middle)
    soft = length / EA
    flat = (1.0 + o) * length + 0.5 * (Ta + Tb) * soft
    if pull.H == 0.0 and np.any(lies):
        flat *= line.x / flat[lies].sum()  # what is slack lies in bights
    longer = (1.0 + o) * length
    dx = np.where(lies, flat, H * (longer * _mean_inverse(H, Va, Vb) + soft))
    dz = np.where(lies, 0.0, (Va + Vb) * (longer / (np.hypot(H, Va) + np.hypot(H, Vb)) + soft / 2))
    loose = (line_pieces["weight"][_pieces_of(ends, cuts)] == 0.0) & ~lies
    if pull.H == 0.0 and np.any(loose):  # without weight and tension it has no shape: straight
        share = np.where(loose, length, 0.0) / length[loose].sum()
        dx = dx + share * (line.x - dx.sum())
        dz = dz + share * (line.z - dz.sum())
    places = np.zeros((cuts.size, 2))
    places[1:] = np.cumsum(np.transpose([dx, -dz]), axis=0)
    places[:, 1] += line.z
    wanted = np.minimum(np.searchsorted(cuts, s), cuts.size - 1)
    return places[wanted], np.append(Ta, Tb[-1])[wanted]


def _corner_arcs(
    line_pieces: np.ndarray, ends: np.ndarray, H: float, pull: LinePull, friction: float
) -> Iterator[np.ndarray]:
    """Arc lengths from the fairlead at which the tension may pass a corner of a curve."""
    above = _loads_above(line_pieces)
    tops = pull.V, pull.anchor_V + above[-1] - line_pieces["hung"][-1]
    for i, piece in enumerate(line_pieces):
        corners = piece["corner"][: piece["corners"]]
        if corners.size and piece["weight"] != 0.0:
            steep = np.sqrt(np.maximum(corners**2 - H**2, 0.0))
            pulls = [top - above[i] - sign * steep for top in tops for sign in (1.0, -1.0)]
            if friction > 0.0:
                pulls.append(tops[0] - above[i] - (corners - H) / friction)
            arcs = ends[i] + np.concatenate(pulls) / piece["weight"]
            yield arcs[(arcs > ends[i]) & (arcs < ends[i + 1])]


def _loads_above(line_pieces: np.ndarray) -> np.ndarray:
    """Weight [N] above the upper end of each piece, and of all."""
    loads = line_pieces["length"] * line_pieces["weight"] + line_pieces["hung"]
    return np.concatenate([[0.0], np.cumsum(loads)])


def _pieces_of(ends: np.ndarray, cuts: np.ndarray) -> np.ndarray:
    """Number of the piece of each interval between ``cuts``."""
    middles = 0.5 * (cuts[:-1] + cuts[1:])
    return np.clip(np.searchsorted(ends, middles) - 1, 0, ends.size - 2)


def _vertical_pull(
    line_pieces: np.ndarray, ends: np.ndarray, cuts: np.ndarray, pull: LinePull, lift: float
) -> tuple[np.ndarray, np.ndarray]:
    """V at the upper and at the lower end of each interval between ``cuts``; where the line lies,
    what it would be if the bed carried nothing."""
    above = _loads_above(line_pieces)
    whole = above[-1] - line_pieces["hung"][-1]
    i = _pieces_of(ends, cuts)
    carried = above[i] + line_pieces["weight"][i] * (cuts[:-1] - ends[i])
    top = np.where(cuts[:-1] >= lift, pull.anchor_V + whole, pull.V)
    Va = top - carried
    return Va, Va - line_pieces["weight"][i] * np.diff(cuts)


def _mean_inverse(H: float, Va: np.ndarray, Vb: np.ndarray) -> np.ndarray:
    """Mean of 1/T over intervals in which V falls from Va to Vb."""
    S = np.hypot(H, Va) + np.hypot(H, Vb)
    q = (Va - Vb) / S
    even = np.abs(q) < 1e-8
    bent = np.abs(q) > 0.9
    fall = np.where(bent, np.arcsinh(Va / H) - np.arcsinh(Vb / H), 2.0 * np.arctanh(q * ~bent))
    return np.where(even, 2.0 / S, fall / np.where(even, 1.0, Va - Vb))


# Lines at one state of a scene: ends, pulls, strains, points.

LINE_POINTS = 41  # of a line in pictures


@dataclass(frozen=True, eq=False)
class LineShape:
    """A line ``name`` with its ``constants``, how it is ``suspended``, its ``ends``, ``pull``."""

    name: str
    constants: Any
    suspended: SuspendedLine
    ends: catenary.EndKinematics
    pull: LinePull

    @property
    def length(self) -> float:
        """Unstretched length [m]."""
        return float(self.line_pieces["length"].sum())

    @property
    def distance(self) -> float:
        """Distance of its ends [m]."""
        return float(np.hypot(self.ends.x, self.ends.z))

    @property
    def strain(self) -> float:
        """`largest_strain` under the largest tension."""
        return largest_strain(self.line_pieces, largest_tension(self.pull))

    @property
    def stiffness(self) -> float:
        """Least slope EA [N] of its pieces under the largest tension."""
        tension = np.full(self.line_pieces.size, largest_tension(self.pull))
        return float(branches_at(self.line_pieces, tension)[0].min())

    @property
    def curve_end(self) -> float:
        """Least tension [N] beyond which a curve goes on by its last slope."""
        limits = self.line_pieces["limit"]
        return float(np.min(limits[limits > 0.0], initial=np.inf))

    def places(self, count: int = LINE_POINTS) -> tuple[np.ndarray, np.ndarray]:
        """Places (count, 3) [m] from the fairlead to the anchor in the earth frame, relative to a
        point straight below or above the fairlead at the still water; tensions (count,) [N]."""
        e = self.ends
        positions, tension = line_points(self.suspended, self.pull, count)
        across, height = positions.T
        return np.stack([across * e.e[0], across * e.e[1], height + e.anchor], axis=1), tension

    @property
    def line_pieces(self) -> np.ndarray:
        """Its pieces alone."""
        return self.suspended.pieces[self.suspended.first : self.suspended.last]


def largest_tension(pull: LinePull) -> float:
    """The larger tension of both ends [N]."""
    return float(max(np.hypot(pull.H, pull.V), np.hypot(pull.anchor_H, pull.anchor_V)))


def largest_strain(line_pieces: np.ndarray, tension: float) -> float:
    """Largest stretch of pieces under a ``tension`` [N], but of those that their curves hold."""
    EA, o = branches_at(line_pieces, np.full(line_pieces.size, tension))
    return float(np.max((o + tension / EA) * (line_pieces["limit"] <= tension)))


def line_shapes(
    parts: KindConstants,
    scene: Scene,
    t: float,
    y: np.ndarray,
    modes: np.ndarray,
    bodies: Any,
    motion: Any,
) -> Iterator[LineShape]:
    """The lines that act at a state ``y`` with its ``modes``; ``motion`` must be filled."""
    p = CATENARY_KIND.constants_in(parts)
    for i, name in enumerate(CATENARY_KIND.unit_names(scene)):
        if modes[p.mode + i, MODE] != INACTIVE:
            line = p.lines[i]
            ends = catenary.end_kinematics(line, bodies, motion)
            pieces = p.pieces.copy()
            if line["paying"] != NO_INDEX:
                paid = value(t, line["paid"], p.signals)
                pieces["length"][line["first"] + line["paying"]] = paid
            guess = y[p.state + catenary.CATENARY_STATES * i :][:2]
            heights = (ends.x, ends.z, ends.bed, float(line["friction"]))
            suspended = SuspendedLine(pieces, int(line["first"]), int(line["last"]), *heights)
            pull = LinePull(*catenary.pull_entries(suspended, *guess))
            yield LineShape(name, line, suspended, ends, pull)
