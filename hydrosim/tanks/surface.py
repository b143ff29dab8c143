"""Contents of tanks over their volume, and below surfaces that stay level at any heel and trim.

    V = int_{n.r < s} dV,   S(V, n) = int_{n.r < s} r dV,   U / (rho g) = n . S

n: the earth's vertical in the body's axes; s: height of the surface above the body's origin; U: the
potential energy of the fluid. Phi(s, n) = int max(s - n.r, 0) dV is a sum over the triangles of the
tank (`hydrosim.multibody.solids`), with V = dPhi/ds and S = -dPhi/dn. So U / (rho g) = s V - Phi is
the Legendre transform of Phi:

    dU/dV = rho g s,   dU/dn = rho g S   (V constant)

s is found by Newton's method on V(s), from the plane through the centroid of the level surface.
That plane is the solution while the surface meets upright walls only. S has two continuous
derivatives where the surface passes a corner, and one where it passes an edge that is parallel to
it: steps end there (`find_clearances`).

Contents of a tank over the volume V of its fluid.

    S(V) = int r dV,   P(V) = int r r^T dV,   level h(V),   J(V) of the free surface

in the body frame, as cubics in V on pieces. Added or removed fluid lies at the surface, about its
centroid S'(V). So P' = S' S'^T + J / (dV/dh) for a surface that is level in the body. An empty tank
and a full one have no free surface: J vanishes smoothly over the last `SHALLOW` of the volume. J
counts where the tilted surface is not computed: in tables, and in linear kinematics.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import clear, kernel, piece_of, root
from hydrosim.multibody.kinematics import vertical_in_body
from hydrosim.multibody.solids import Solids, area_below, sums_below
from hydrosim.multibody.vectors import dot, scale, vector

FIRST_MOMENT, SECOND_MOMENT, FLUID_LEVEL, SURFACE_MOMENT, TANK_QUANTITIES = 0, 3, 9, 10, 13
"""First entries of S (3), P (xx, yy, zz, xy, xz, yz), h and J (xx, xy, yy); number of all
entries."""
SHALLOW = 0.01  # of a tank's volume
PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
PIECE_DTYPE = np.dtype([("start", float), ("c", float, (TANK_QUANTITIES, 4))])
"""Coefficients of 1, x, x^2, x^3, x = V - start."""


def quantities_at(table: np.ndarray, volume: float) -> np.ndarray:
    """All quantities (13,) of the pieces of a tank at a volume [m^3]."""
    piece = table[max(int(np.searchsorted(table["start"], volume, side="right")) - 1, 0)]
    return np.asarray(piece["c"] @ (volume - piece["start"]) ** np.arange(4))


def values_at(table: np.ndarray, volume: np.ndarray, which: int) -> np.ndarray:
    """One quantity (n,) of the pieces of a tank at volumes (n,) [m^3]."""
    c, x = _cubic_pieces(table, volume, which)
    return np.asarray(np.einsum("nk,nk->n", c, x[:, None] ** np.arange(4)))


def slopes_at(table: np.ndarray, volume: np.ndarray, which: int) -> np.ndarray:
    """Derivatives (n,) of one quantity by the volume."""
    c, x = _cubic_pieces(table, volume, which)
    return np.asarray(c[:, 1] + x * (2.0 * c[:, 2] + x * 3.0 * c[:, 3]))


def _cubic_pieces(
    table: np.ndarray, volume: np.ndarray, which: int
) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients (n, 4) of a quantity at volumes (n,), and the offsets of these from the start of
    their piece."""
    of = np.maximum(np.searchsorted(table["start"], volume, side="right") - 1, 0)
    return table["c"][of, which], volume - table["start"][of]


def hermite(
    start: np.ndarray, gain: np.ndarray, slope: np.ndarray, last: np.ndarray, length: np.ndarray
) -> np.ndarray:
    """Coefficients (n, 6, 4) of cubics with these values and slopes at both ends."""
    x = length[:, None]
    bend = (3.0 * gain / x - 2.0 * slope - last) / x
    return np.stack([start, slope, bend, (slope + last - 2.0 * gain / x) / x**2], axis=2)


def with_ends(table: np.ndarray, full: float) -> np.ndarray:
    """The pieces of a tank of this volume [m^3], with a surface J that vanishes at both ends."""
    low, high = SHALLOW * full, (1.0 - SHALLOW) * full
    starts = np.union1d(table["start"], [low, high])
    of = np.searchsorted(table["start"], starts, side="right") - 1
    pieces = np.zeros(starts.size, dtype=PIECE_DTYPE)
    pieces["start"], pieces["c"] = (
        starts,
        _shift_cubics(table["c"][of], starts - table["start"][of]),
    )
    inner = [pieces["c"][np.searchsorted(starts, v), SURFACE_MOMENT:, :2].T for v in (low, high)]
    nothing = np.zeros((1, TANK_QUANTITIES - SURFACE_MOMENT))
    for begin, first, last in ((0.0, nothing, inner[0]), (high, inner[1], nothing)):
        ends = (
            np.broadcast_to(end, (2, TANK_QUANTITIES - SURFACE_MOMENT))[:, None]
            for end in (first, last)
        )
        (value, slope), (then, slope_then) = ends
        curve = hermite(value, then - value, slope, slope_then, np.array([low]))[0]
        in_piece = (starts >= begin) & (starts < begin + low)
        pieces["c"][in_piece, SURFACE_MOMENT:] = _shift_cubics(
            curve[None], starts[in_piece] - begin
        )
    return pieces


def _shift_cubics(c: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Coefficients (n, m, 4) of the same cubics about a point shifted by x (n,)."""
    a, b, d, e = np.moveaxis(c, -1, 0)
    x = x[:, None]
    coefficients = (a + x * (b + x * (d + x * e)), b + x * (2 * d + x * 3 * e), d + x * 3 * e)
    return np.stack([*coefficients, np.broadcast_to(e, coefficients[0].shape)], axis=-1)


@kernel
def value(piece, i, x):
    """Quantity i at x from the start of a piece."""
    c = piece.c
    return c[i, 0] + x * (c[i, 1] + x * (c[i, 2] + x * c[i, 3]))


@kernel
def slope(piece, i, x):
    """Derivative of quantity i by V."""
    c = piece.c
    return c[i, 1] + x * (2.0 * c[i, 2] + x * 3.0 * c[i, 3])


@kernel
def bend(piece, i, x):
    """Second derivative of quantity i by V."""
    c = piece.c
    return 2.0 * c[i, 2] + x * 6.0 * c[i, 3]


VOLUME_RTOL = 1e-14  # of a tank's volume
FEW = 16  # most triangles that are not upright: passing a corner of a finer mesh changes little
CORNER_ATOL_M = 1e-9  # m: a surface that rests at a corner does not pass it
CORNER_TIME_RTOL = 1e-6  # of a step
MAX_BISECTIONS = 100  # most iterations: bisection alone ends after 50
LIQUID = np.dtype(
    [
        *(("body", int), ("tank", int), ("volume", float), ("first", int), ("last", int)),
        *(("density", float), ("capacity", float), ("permeability", float)),
    ]
)
"""Constants of a level surface; ``tank`` is its index among tanks that change, -1 if the ``volume``
is constant."""


class Liquids(NamedTuple):
    """Constants: ``each`` (nl,) of `LIQUID`, tanks with a known shape and a level surface, with the
    ``pieces`` of their shapes and their ``solids``, about the body's origin. ``roll`` (nr,) are the
    entries of y with the roll of a body that has one of them."""

    each: np.ndarray
    pieces: np.ndarray
    solids: Solids
    roll: np.ndarray


@root
def level_surfaces(y, motion, bodies, tanks, p, contents):
    """Compute level surfaces for a filled ``motion``: their shift of the moments of the contents
    into ``contents.shift``, and their heights into ``contents.height``."""
    clear(contents.shift.reshape(contents.shift.size))
    for k in range(p.each.size):
        liquid = p.each[k]
        b = liquid.body
        volume = y[tanks.state + liquid.tank] if liquid.tank >= 0 else liquid.volume
        piece = p.pieces[piece_of(volume, liquid.first, liquid.last, p.pieces)]
        x = volume - piece.start
        n = vertical_in_body(b, motion, bodies)
        middle = (
            slope(piece, FIRST_MOMENT, x),
            slope(piece, FIRST_MOMENT + 1, x),
            slope(piece, FIRST_MOMENT + 2, x),
        )
        s, moment = surface(volume, dot(n, middle), n, k, p)
        contents.height[k] = s
        for i in range(3):
            contents.shift[b, i] += liquid.density * (moment[i] - value(piece, FIRST_MOMENT + i, x))


@root
def find_clearances(y, motion, bodies, tanks, p, heights, out):
    """Distance of the surface above every corner of tanks with few corners, into ``out`` (nt, 3)
    [m]. It is 1 for other tanks, and for empty or full ones."""
    for k in range(p.each.size):
        liquid = p.each[k]
        volume = y[tanks.state + liquid.tank] if liquid.tank >= 0 else liquid.volume
        n = vertical_in_body(liquid.body, motion, bodies)
        first = p.solids.begin[p.solids.first[k]]
        last = p.solids.begin[p.solids.first[k + 1]]
        within = VOLUME_RTOL * liquid.capacity < volume < (1.0 - VOLUME_RTOL) * liquid.capacity
        for i in range(first, last):
            for j in range(3):
                corner = vector(p.solids.corners[i, j], 0)
                looked_at = within and last - first <= FEW
                out[i, j] = heights[k] - dot(n, corner) if looked_at else 1.0


@kernel
def first_passage(before, after):
    """Fraction of the step at which the surface first passes a corner, from the clearances (nt, 3)
    at both ends; 1 if it passes none."""
    first = 1.0
    for i in range(before.shape[0]):
        for j in range(3):
            a = before[i, j]
            b = after[i, j]
            if (a < 0.0) != (b < 0.0) and max(abs(a), abs(b)) > CORNER_ATOL_M:
                part = a / (a - b)
                if CORNER_TIME_RTOL < part < 1.0 - CORNER_TIME_RTOL:
                    first = min(first, part)
    return first


@kernel
def surface(volume, guess, n, k, p):
    """Height s of the surface and first moment S (3,) of a ``volume`` in tank ``k``."""
    part = p.each[k].permeability
    rounding = VOLUME_RTOL * p.each[k].capacity
    lowest, highest = _tank_height_range(n, k, p.solids)
    s = min(max(guess, lowest), highest)
    if volume <= rounding:
        s = lowest
    elif volume >= p.each[k].capacity - rounding:
        s = highest
    half = 0.5 * part / n[2]
    total, depth, arm = sums_below(-s, n, k, p.solids)
    for _ in range(MAX_BISECTIONS):
        over = -half * depth - volume
        if abs(over) <= rounding:
            break
        if over > 0.0:
            highest = s
        else:
            lowest = s
        area = -2.0 * half * area_below(-s, n, k, p.solids)
        s = s - over / area if area > 0.0 else lowest
        if not lowest < s < highest:
            s = 0.5 * (lowest + highest)
        total, depth, arm = sums_below(-s, n, k, p.solids)
    return s, scale(-half, (arm[0], arm[1], arm[2] + total / n[2]))


@kernel
def _tank_height_range(n, k, p):
    """Lowest and highest height of all corners of tank ``k``."""
    lowest = np.inf
    highest = -np.inf
    for i in range(p.first[k], p.first[k + 1]):
        side = vector(p.box[i, 1], 0)
        middle = dot(n, vector(p.box[i, 0], 0))
        reach = abs(n[0]) * side[0] + abs(n[1]) * side[1] + abs(n[2]) * side[2]
        lowest = min(lowest, middle - reach)
        highest = max(highest, middle + reach)
    return lowest, highest
