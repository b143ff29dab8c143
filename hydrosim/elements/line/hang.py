"""A line under a given pull: its stretches, the part that hangs, and the part that lies.

V falls along the line by the weight of its pieces and of what hangs between them. The line lies
from the last place at which V comes down to zero. That is inside a piece, tangent to the bed, or at
a clump that the bed carries in part. Farther on, -V is the weight since that place. The bed carries
it, and friction takes it from the tension:

    T(s) = max(H + CB V(s), 0)

The derivative of x by V at constant H differs from that of z by H only by this friction.

A stretch of an elastic catenary under a given pull: where it leads, and its derivatives.

    x = integral of H (1/T + 1/EA) ds,   z = integral of V (1/T + 1/EA) ds,   T = sqrt(H^2 + V^2)

V falls from Va to Vb = Va - w L over the unstretched length L. With S = Ta + Tb, M = (Va + Vb)/2
and q = w L / S,

    integral of ds/T = 2 L/S atanh(q)/q,   integral of V/T ds = 2 L M/S

(the potential of a uniform rod depends on the sum of the distances to its ends alone). This form
loses no digits for straight, steep, weightless or buoyant stretches.

The place of an end is known to 1e-16 of the length, which is much of the strain of a stiff line.
Hence a stretch tells how far it falls short of its length along a unit vector e
(`StretchSpan.along`), and how far it leads across e. With Tm = (H, M)

    L - (x, z) e = 2 L/S [(S/2 - |Tm|) + (|Tm| - Tm e) - H ex (atanh(q)/q - 1)] - L (Tm e)/EA

A piece may have a curve of tension over stretch eps(T), straight between its corners (Irvine 1981,
Jonkman 2007 for one slope):

    x = integral of H/T (1 + eps) ds,   z = integral of V/T (1 + eps) ds

On a branch eps = o + T/EA. There a stretch is one without o, (1 + o) times as long, of the same
weight and the same softness L/EA. V is sqrt(Tk^2 - H^2) where T is that of a corner. These places
move with H and V, but eps is continuous there, so the derivatives are sums over branches too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import log, log1p, sqrt
from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import kernel, root_giving
from hydrosim.multibody.kinematics import LINE_PIECE, MAX_CORNERS
from hydrosim.scene.catenary import Segment, StretchCurve

STRAIGHT = 0.1  # |q| below which atanh(q)/q - 1 is its series
UNIT_ROUNDING = 4e-16
SAME_SLOPE_RTOL = 1e-12  # branches of a curve whose slopes differ by less are one
NO_CURVES: Mapping[int, np.ndarray] = {}
BENT = 0.9  # |q| above which 1 - |q| is computed from the ends


class StretchSpan(NamedTuple):
    """Where a stretch leads [m], in axes along and across a unit vector e = (ex, ez): ``along`` is
    the distance less the unstretched length, ``across`` the distance along (-ez, ex). ``xH``,
    ``zH``, ``zV`` are the derivatives of x and z by H and V at the upper end [m/N]; x by V is
    ``zH`` too."""

    along: float
    across: float
    xH: float
    zH: float
    zV: float


@kernel
def tension_less_pull(H, V, T):
    """T - V without cancellation."""
    return H * H / (T + V) if V > 0.0 else T - V


@kernel
def remaining_pull(Va, D):
    """Va - D, which is 0 if it is no more than rounding: a slack line has no H beside it."""
    V = Va - D
    return 0.0 if abs(V) <= UNIT_ROUNDING * abs(Va) else V


@kernel
def curvature(H, Va, Vb, Ta, Tb):
    """atanh(q)/q - 1 with q = (Va - Vb)/(Ta + Tb)."""
    S = Ta + Tb
    q = (Va - Vb) / S
    if abs(q) < STRAIGHT:
        s = q * q
        tail = 1 / 11 + s * (1 / 13 + s * (1 / 15 + s * (1 / 17 + s / 19)))
        return s * (1 / 3 + s * (1 / 5 + s * (1 / 7 + s * (1 / 9 + s * tail))))
    if abs(q) < BENT:
        return 0.5 * log1p(2.0 * q / (1.0 - q)) / q - 1.0
    if q > 0.0:
        gap = tension_less_pull(H, Va, Ta) + tension_less_pull(H, -Vb, Tb)
    else:
        gap = tension_less_pull(H, Vb, Tb) + tension_less_pull(H, -Va, Ta)
    return 0.5 * log((S + abs(Va - Vb)) / gap) / abs(q) - 1.0


@kernel
def elastic_span(H, Va, D, L, soft, ex, ez):
    """The `StretchSpan` of a stretch of the weight ``D`` [N] and softness ``soft`` L/EA [m/N], for
    H > 0."""
    Vb = remaining_pull(Va, D)
    HH = H * H
    VV = Va * Vb
    squares = Va * Va + Vb * Vb
    Ta = sqrt(HH + Va * Va)
    Tb = sqrt(HH + Vb * Vb)
    TT = Ta * Tb
    S = Ta + Tb
    M = 0.5 * (Va + Vb)
    Tm = sqrt(HH + M * M)
    g = curvature(H, Va, Vb, Ta, Tb)
    # TT - VV and (S/2 - Tm), neither as a difference of nearly equal numbers
    if VV > 0.0:
        open_ = HH * (HH + squares) / (TT + VV)
        sag = HH * D * D / ((TT + HH + VV) * (S + 2.0 * Tm))
    else:
        open_ = TT - VV
        sag = D * D / ((1.0 + (HH + squares) / open_) * (S + 2.0 * Tm))
    on = H * ex + M * ez
    off = M * ex - H * ez
    lean = off * off / (Tm + on) if on > 0.0 else Tm - on
    scale = 2.0 * L / S
    along = on * soft - scale * (sag + lean - H * ex * g)
    across = off * soft + scale * (off - H * ez * g)
    zV = L * (open_ + HH) / (S * TT)
    zH = -H * scale * M / TT
    xH = L / S * (2.0 * g + ((HH * squares + VV * VV) / (TT + HH) + VV) / TT)
    return StretchSpan(along, across, xH + soft, zH, zV + soft)


@kernel
def elastic_rest(H, Va, D, L, soft):
    """Integral of T + T^2/(2 EA) over a stretch [N m], for H > 0."""
    Vb = remaining_pull(Va, D)
    Ta = sqrt(H * H + Va * Va)
    Tb = sqrt(H * H + Vb * Vb)
    S = Ta + Tb
    M = 0.5 * (Va + Vb)
    run = 2.0 * H / S * (1.0 + curvature(H, Va, Vb, Ta, Tb))
    tension = 0.5 * L * (0.5 * S + 2.0 * M * M / S + H * run)
    return tension + 0.5 * soft * (H * H + M * M + D * D / 12.0)


# Pieces whose tension over stretch has corners.


def new_pieces(
    length: np.ndarray,
    weight: np.ndarray,
    stiffness: np.ndarray,
    hung: np.ndarray,
    curves: Mapping[int, np.ndarray] = NO_CURVES,
) -> np.ndarray:
    """Pieces (n,) of `LINE_PIECE`. ``curves`` are tension [N] over stretch (2, k) by the number of
    the piece, which begin at (0, 0)."""
    pieces = np.zeros(len(length), dtype=LINE_PIECE)
    columns = {"length": length, "weight": weight, "stiffness": stiffness, "hung": hung}
    for name, values in columns.items():
        pieces[name] = values
    for i, (strain, tension) in curves.items():
        tangent = np.diff(tension) / np.diff(strain)
        bends = 1 + np.flatnonzero(np.abs(np.diff(tangent)) > SAME_SLOPE_RTOL * tangent[1:])
        complementary = np.cumsum(0.5 * np.diff(tension) * (strain[1:] + strain[:-1]))[bends - 1]
        e, T, EA = strain[bends], tension[bends], tangent[bends]
        piece = pieces[i]
        piece["stiffness"], piece["corners"], piece["limit"] = tangent[0], bends.size, tension[-1]
        piece["corner"][: bends.size] = T
        piece["tangent"][: bends.size] = EA
        piece["offset"][: bends.size] = e - T / EA
        piece["energy"][: bends.size] = complementary - e * T + 0.5 * T * T / EA
    return pieces


def pieces_of_segments(segments: Sequence[Segment]) -> np.ndarray:
    """Pieces (n,) of `LINE_PIECE` of the segments of a line; a length over time is left at 0."""
    curves = {
        i: np.array([law.stretch, law.tension])
        for i, law in enumerate(segment.stiffness for segment in segments)
        if isinstance(law, StretchCurve)
    }
    columns = [
        (
            s.length if isinstance(s.length, float) else 0.0,
            s.weight,
            s.stiffness if isinstance(s.stiffness, float) else 0.0,
            s.hung,
        )
        for s in segments
    ]
    length, weight, stiffness, hung = np.array(columns, float).T
    return new_pieces(length, weight, stiffness, hung, curves)


@kernel
def branch_law(piece, k):
    """EA [N], o and c [N] of branch k, where eps = o + T/EA and integral of eps dT = c + o T +
    T^2/(2 EA)."""
    if k == 0:
        return piece.stiffness, 0.0, 0.0
    return piece.tangent[k - 1], piece.offset[k - 1], piece.energy[k - 1]


@kernel
def branch_at(piece, T):
    """Number of the branch of a piece at the tension T."""
    k = 0
    while k < piece.corners and piece.corner[k] <= T:
        k += 1
    return k


def branches_at(pieces: np.ndarray, T: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """EA [N] and o (n,), as `branch_law`, of ``pieces`` (n,) under the tensions T (n,) [N]."""
    has_corner = np.arange(MAX_CORNERS) < pieces["corners"][:, None]
    k = np.count_nonzero(has_corner & (pieces["corner"] <= T[:, None]), axis=1)
    i = np.arange(k.size)
    EA = np.where(k == 0, pieces["stiffness"], pieces["tangent"][i, k - 1])
    return EA, np.where(k == 0, 0.0, pieces["offset"][i, k - 1])


@kernel
def strain_at(piece, T):
    """Stretch of a piece under the tension T."""
    EA, o, _ = branch_law(piece, branch_at(piece, T))
    return o + T / EA


@kernel
def pull_below_branch(piece, j, H):
    """V where branch |j| of a piece ends, as V falls: its part with V > 0 if j > 0."""
    T = piece.corner[max(j, -j + 1) - 1]
    V = sqrt(max((T - H) * (T + H), 0.0))
    return V if j > 0 else -V


@root_giving(float, float, float, float, float, float)
def curved_span(pieces, i, H, V, length, ex, ez):
    """The entries of the `StretchSpan` of ``length`` [m] of piece i, branch by branch, and its
    integral of T + (integral of eps dT) [N m], for H > 0."""
    piece = pieces[i]
    sense = -1.0 if piece.weight < 0.0 else 1.0
    along = across = xH = zH = zV = rest = start = 0.0
    j = piece.corners
    while start < length:
        end = length
        if j > -piece.corners:
            end = (sense * V - pull_below_branch(piece, j, H)) / abs(piece.weight)
        if end > start:  # not so where it is not a number: a weightless piece at a corner
            EA, o, c = branch_law(piece, abs(j))
            part = min(end, length) - start
            top = V - piece.weight * start
            D = piece.weight * part
            s = elastic_span(H, top, D, (1.0 + o) * part, part / EA, ex, ez)
            along += s.along + o * part
            across += s.across
            xH += s.xH
            zH += s.zH
            zV += s.zV
            rest += elastic_rest(H, top, D, (1.0 + o) * part, part / EA) + c * part
            start = min(end, length)
        j -= 1
    return along, across, xH, zH, zV, rest


@kernel
def stretch_span(pieces, i, H, V, length, ex, ez):
    """The `StretchSpan` of ``length`` [m] of piece i with V at its upper end, for H > 0."""
    piece = pieces[i]
    if piece.corners == 0:
        D = piece.weight * length
        return elastic_span(H, V, D, length, length / piece.stiffness, ex, ez)
    along, across, xH, zH, zV, _ = curved_span(pieces, i, H, V, length, ex, ez)
    return StretchSpan(along, across, xH, zH, zV)


@kernel
def rest_energy(pieces, i, H, V, length):
    """Integral of T + (integral of eps dT) over ``length`` [m] of piece i [N m], for H > 0."""
    piece = pieces[i]
    if piece.corners == 0:
        return elastic_rest(H, V, piece.weight * length, length, length / piece.stiffness)
    _, _, _, _, _, rest = curved_span(pieces, i, H, V, length, 1.0, 0.0)
    return rest


@kernel
def even_stretch(EA, o, c, Ta, Tb, length):
    """Stretch [m], elastic energy [J] and softness [m/N] of ``length`` [m] on a branch, under a
    tension that changes evenly from Ta to Tb."""
    stretch = o * length + 0.5 * (Ta + Tb) * length / EA
    energy = (Ta * Ta + Ta * Tb + Tb * Tb) * length / (6.0 * EA) - c * length
    return stretch, energy, length / EA


@root_giving(float, float, float)
def curved_stretch(pieces, i, Ta, Tb, length):
    """`even_stretch` of piece i, branch by branch."""
    piece = pieces[i]
    stretch = energy = soft = 0.0
    low = min(Ta, Tb)
    high = max(Ta, Tb)
    level = branch_at(piece, low)
    for k in range(level, piece.corners + 1):
        start = max(low, piece.corner[k - 1]) if k > level else low
        end = min(high, piece.corner[k]) if k < piece.corners else high
        part = length * (end - start) / (high - low) if high > low else length
        if end > start or high == low:
            EA, o, c = branch_law(piece, k)
            more = even_stretch(EA, o, c, start, end, part)
            stretch += more[0]
            energy += more[1]
            soft += more[2]
        if end >= high:
            break
    return stretch, energy, soft


@kernel
def lying_stretch(pieces, i, Ta, Tb, length):
    """`even_stretch` of ``length`` [m] of piece i."""
    piece = pieces[i]
    if piece.corners == 0:
        return even_stretch(piece.stiffness, 0.0, 0.0, Ta, Tb, length)
    return curved_stretch(pieces, i, Ta, Tb, length)


class SuspendedLine(NamedTuple):
    """A line between its ends: the ``pieces`` from ``first`` to before ``last``, in order from the
    fairlead. ``x`` >= 0 is the horizontal distance of its ends, ``z`` the height of the fairlead
    above the anchor [m]. ``bed`` <= 0 is the height of the seabed above the anchor [m], or -inf;
    ``friction`` is its coefficient.

    A piece has its unstretched length [m]; weight in water per unstretched length [N/m], negative
    if it floats; EA [N]; the weight in water of what hangs at its lower end [N], negative for a
    buoy. What hangs at the last one is the anchor's. EA is that without tension. Behind each of the
    ``corners`` of a curve, which goes on beyond its ``limit`` [N], follows another branch, see
    `branch_law`."""

    pieces: np.ndarray
    first: int
    last: int
    x: float
    z: float
    bed: float
    friction: float


class Touchdown(NamedTuple):
    """Where a line that hangs from one end comes to lie: in piece ``piece``, after ``part`` [m] of
    it, at the arc length ``arc`` [m] from that end. ``V`` [N] is what is left of V at the other
    end. The line ``hangs`` all along if that is not negative."""

    piece: int
    part: float
    arc: float
    V: float
    hangs: bool


class LineReach(NamedTuple):
    """Where a line leads, as a `hydrosim.elements.line.hang.StretchSpan`, with the derivative
    ``xV`` of x by V."""

    along: float
    across: float
    xH: float
    xV: float
    zH: float
    zV: float


@kernel
def weight_after_piece(line, i, step):
    """Weight of what hangs behind piece i, on the way to the anchor (step 1) or back (-1)."""
    return line.pieces[i].hung if step > 0 else line.pieces[i - 1].hung


@kernel
def first_and_stop(line, step):
    """The first piece on the way of ``step``, and what lies beyond the last one."""
    if step > 0:
        return line.first, line.last
    return line.last - 1, line.first - 1


@kernel
def find_touchdown(line, step, V):
    """The `Touchdown` of a line with V at the end where the way of ``step`` starts."""
    start, stop = first_and_stop(line, step)
    touch = Touchdown(start, 0.0, 0.0, V, False)
    arc = 0.0
    i = start
    while i != stop:
        piece = line.pieces[i]
        low = V - piece.weight * piece.length
        if V > 0.0 and low < 0.0:
            part = V / piece.weight
            touch = Touchdown(i, part, arc + part, 0.0, False)
        elif V > 0.0 or low > 0.0:
            touch = Touchdown(i, piece.length, arc + piece.length, 0.0, False)
        arc += piece.length
        V = low
        i += step
        if i != stop:
            V -= weight_after_piece(line, i - step, step)
    hangs = V >= 0.0 and touch.arc >= arc
    return Touchdown(touch.piece, touch.part, touch.arc, V, hangs)


@kernel
def hanging_touchdown(line, step, V):
    """The `Touchdown` of a line that hangs all along."""
    i, stop = first_and_stop(line, step)
    arc = 0.0
    while i != stop:
        V -= line.pieces[i].weight * line.pieces[i].length
        arc += line.pieces[i].length
        i += step
        if i != stop:
            V -= weight_after_piece(line, i - step, step)
    return Touchdown(stop - step, line.pieces[stop - step].length, arc, V, True)


@kernel
def hanging_reach(line, step, H, V, touch, ex, ez):
    """`LineReach` of the part that hangs, up to ``touch`` on the way of ``step``."""
    along = across = xH = zH = zV = 0.0
    end = touch.piece + step
    i, _ = first_and_stop(line, step)
    while i != end:
        piece = line.pieces[i]
        length = touch.part if i == touch.piece else piece.length
        s = stretch_span(line.pieces, i, H, V, length, ex, ez)
        along += s.along
        across += s.across
        xH += s.xH
        zH += s.zH
        zV += s.zV
        V -= piece.weight * length
        if i != touch.piece:
            V -= weight_after_piece(line, i, step)
        i += step
    return LineReach(along, across, xH, zH, zH, zV)


class LevelPart(NamedTuple):
    """What lies level under a tension H: its ``stretch`` o [m] without H l/EA, the sum ``soft`` of
    l/EA [m/N], and the energy ``lack`` [J] by which it holds less than H^2/2 times that."""

    stretch: float
    soft: float
    lack: float


@kernel
def level_part(line, step, H, touch):
    """The `LevelPart` that the pieces up to ``touch`` on the way of ``step`` would be."""
    stretch = soft = lack = 0.0
    end = touch.piece + step
    i, _ = first_and_stop(line, step)
    while i != end:
        piece = line.pieces[i]
        length = touch.part if i == touch.piece else piece.length
        EA, o, c = branch_law(piece, branch_at(piece, H))
        stretch += o * length
        soft += length / EA
        lack += c * length
        i += step
    return LevelPart(stretch, soft, lack)


@kernel
def lying_part(line, H, V, touch):
    """Of the part that lies between ``touch`` and the anchor, with V there if the bed carried
    nothing: its length, its stretch, its elastic energy, the softness of what is under tension,
    the tension at the anchor, and the length without tension."""
    length = stretch = energy = live = dead = 0.0
    tension = max(H + line.friction * V, 0.0)
    for i in range(touch.piece, line.last):
        piece = line.pieces[i]
        L = piece.length - touch.part if i == touch.piece else piece.length
        V -= piece.weight * L
        below = H + line.friction * V
        under = L
        if below < 0.0:
            under = tension / (line.friction * piece.weight) if tension > 0.0 else 0.0
            below = 0.0
        more = lying_stretch(line.pieces, i, tension, below, under)
        stretch += more[0]
        energy += more[1]
        live += more[2]
        tension = below
        length += L
        dead += L - under
        if i + 1 < line.last:
            V -= piece.hung
            tension = max(H + line.friction * V, 0.0)
    return length, stretch, energy, live, tension, dead


@kernel
def pull_at_touchdown(line, V, touch):
    """V behind ``touch``: what it would be there if the bed carried nothing."""
    for i in range(line.first, touch.piece):
        V -= line.pieces[i].weight * line.pieces[i].length + line.pieces[i].hung
    return V - line.pieces[touch.piece].weight * touch.part
