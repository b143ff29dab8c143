"""Points of a line in its plane, for pictures."""

from __future__ import annotations

import numpy as np

from hydrosim.forces.line.hang import find_touchdown
from hydrosim.forces.line.rates import is_on_bed
from hydrosim.forces.line.search import line_frame
from hydrosim.forces.line.shape import LinePull


def line_points(
    pieces: np.ndarray,
    first: int,
    last: int,
    x: float,
    z: float,
    bed: float,
    friction: float,
    pull: LinePull,
    n: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 2) [m] of a line with its ``pull``, from the fairlead to the anchor: horizontal
    distance from the fairlead, and height above the anchor; and the tension (n,) [N] there. They
    divide the unstretched length evenly. The slack of a line without pull is spread evenly."""
    f = line_frame(pieces, first, last, x, z)
    own = pieces[first:last]
    ends = np.concatenate([[0.0], np.cumsum(own["length"])])
    lift = ends[-1]
    if pull.touch < lift and not is_on_bed(f, bed):
        lift -= find_touchdown(pieces, last - 1, first - 1, -1, -pull.anchor_V).arc
    s = np.linspace(0.0, ends[-1], n)
    cuts = np.unique(np.concatenate([s, ends, [pull.touch, lift, ends[-1] - pull.dead]]))
    cuts = cuts[(cuts >= 0.0) & (cuts <= ends[-1])]
    H = max(pull.H, f.least)
    Va, Vb = _vertical_pull(own, ends, cuts, pull, lift)
    Ta, Tb = np.hypot(H, Va), np.hypot(H, Vb)
    lies = (cuts[:-1] >= pull.touch) & (cuts[:-1] < lift)
    Ta[lies] = np.maximum(H + friction * Va[lies], 0.0)
    Tb[lies] = np.maximum(H + friction * Vb[lies], 0.0)
    Va, Vb = np.where(lies, 0.0, Va), np.where(lies, 0.0, Vb)
    length = np.diff(cuts)
    soft = length / own["stiffness"][_pieces_of(ends, cuts)]
    flat = length + 0.5 * (Ta + Tb) * soft
    if pull.H == 0.0 and np.any(lies):
        flat *= f.x / flat[lies].sum()  # what is slack lies in bights
    dx = np.where(lies, flat, H * (length * _mean_inverse(H, Va, Vb) + soft))
    dz = np.where(lies, 0.0, (Va + Vb) * (length / (np.hypot(H, Va) + np.hypot(H, Vb)) + soft / 2))
    loose = (own["weight"][_pieces_of(ends, cuts)] == 0.0) & ~lies
    if pull.H == 0.0 and np.any(loose):  # without weight and tension it has no shape: straight
        share = np.where(loose, length, 0.0) / length[loose].sum()
        dx = dx + share * (f.x - dx.sum())
        dz = dz + share * (z - dz.sum())
    places = np.zeros((cuts.size, 2))
    places[1:] = np.cumsum(np.transpose([dx, -dz]), axis=0)
    places[:, 1] += z
    wanted = np.minimum(np.searchsorted(cuts, s), cuts.size - 1)
    return places[wanted], np.append(Ta, Tb[-1])[wanted]


def _pieces_of(ends: np.ndarray, cuts: np.ndarray) -> np.ndarray:
    """Number of the piece of each interval between ``cuts``."""
    middles = 0.5 * (cuts[:-1] + cuts[1:])
    return np.clip(np.searchsorted(ends, middles) - 1, 0, ends.size - 2)


def _vertical_pull(
    own: np.ndarray, ends: np.ndarray, cuts: np.ndarray, pull: LinePull, lift: float
) -> tuple[np.ndarray, np.ndarray]:
    """V at the upper and at the lower end of each interval between ``cuts``; where the line lies,
    what it would be if the bed carried nothing."""
    loads = own["length"] * own["weight"] + own["hung"]
    above = np.concatenate([[0.0], np.cumsum(loads)])
    whole = above[-1] - own["hung"][-1]
    i = _pieces_of(ends, cuts)
    carried = above[i] + own["weight"][i] * (cuts[:-1] - ends[i])
    top = np.where(cuts[:-1] >= lift, pull.anchor_V + whole, pull.V)
    Va = top - carried
    return Va, Va - own["weight"][i] * np.diff(cuts)


def _mean_inverse(H: float, Va: np.ndarray, Vb: np.ndarray) -> np.ndarray:
    """Mean of 1/T over intervals in which V falls from Va to Vb."""
    S = np.hypot(H, Va) + np.hypot(H, Vb)
    q = (Va - Vb) / S
    even = np.abs(q) < 1e-8
    bent = np.abs(q) > 0.9
    fall = np.where(bent, np.arcsinh(Va / H) - np.arcsinh(Vb / H), 2.0 * np.arctanh(q * ~bent))
    return np.where(even, 2.0 / S, fall / np.where(even, 1.0, Va - Vb))
