"""Curves of force over compression, straight between corners, and normal forces of contact points.

Corners of curves are events.

A curve consists of rows of `SEGMENT`. On each the force is smooth; the owner of a curve stores the
present segment in a column of its modes. The last slope continues beyond the last point.

Normal force of a contact point: from a compression-force curve and a damper, or prescribed.

    N = f(delta) + c delta'   or   N = f(t),   N >= 0

f(delta): straight lines through the points of the table; c: damping;
f(t): a signal. Stored energy is the integral of f; dissipation is c delta'^2 while in contact.

A normal curve with a separate unloading curve, and a point's memory of its loading.

    loading    N = f(x)          while x' > 0          x: compression
    unloading  N = g(x) <= f(x)  while x' < 0
    between    N = k (x - s)     from where it turned until it meets f or g again

f and g: straight lines through the points of tables from (0, 0); k: a stiff line, steeper than
both. s is set where the motion reverses. The reversal is an event, and so are the two ends of the
line. Every position between f and g can be at rest. A point that starts at rest begins at the upper
end of its line, on f.

The recoverable energy is the integral of the line down to g, and of g from there. The rest of the
work along f is lost: over a whole loop the area between f and g. It is known at every position
without integration in time: only its part before the last event is a state.

Limits: the stiff line does not depend on where it turned. A released contact forgets its history. f
and g do not depend on the speed.
"""

from __future__ import annotations

from math import inf

import numpy as np

from hydrosim.errors import InputError
from hydrosim.jit.kernels import kernel
from hydrosim.modes import NO_INDEX
from hydrosim.scene.contacts import NormalCurve, NormalForce, NormalLoop

SEGMENT = np.dtype(
    [(name, float) for name in ("start", "lower", "upper", "force", "slope", "energy")]
)
"""A straight piece of a curve over x. From ``lower`` to ``upper`` the force is ``force + slope (x -
start)``; ``energy`` is the stored energy at start."""


def segments(x: np.ndarray, force: np.ndarray) -> np.ndarray:
    """The straight pieces, of `SEGMENT`, through the points x (n,) [m], rising, and ``force`` (n,)
    [N]."""
    x, f = np.asarray(x, float), np.asarray(force, float)
    pieces = np.zeros(x.size - 1, dtype=SEGMENT)
    pieces["start"], pieces["force"] = x[:-1], f[:-1]
    pieces["lower"] = np.concatenate([[-inf], x[1:-1]])
    pieces["upper"] = np.concatenate([x[1:-1], [inf]])
    pieces["slope"] = np.diff(f) / np.diff(x)
    pieces["energy"][1:] = np.cumsum(np.diff(x) * (f[1:] + f[:-1]) / 2)[:-1]
    return pieces


def piece_at(pieces: np.ndarray, x: float) -> int:
    """Number of the piece of a curve that holds x."""
    return int(np.searchsorted(pieces["upper"], x, side="right"))


@kernel
def curve_force(piece, x):
    """f(x) on one piece of a curve."""
    return piece.force + piece.slope * (x - piece.start)


@kernel
def stored_energy(piece, x):
    """Integral of the curve up to x on one piece."""
    d = x - piece.start
    return piece.energy + piece.force * d + 0.5 * piece.slope * d * d


@kernel
def find_segment(first, last, pieces, x):
    """Index of the piece, from ``first`` to ``last``, that holds x."""
    k = first
    while k < last and x >= pieces[k].upper:
        k += 1
    return k


@kernel
def next_segment(k, piece, x):
    """Index of the neighbour of piece ``k`` at its end nearer to x."""
    return k + 1 if piece.upper - x < x - piece.lower else k - 1


@kernel
def segment_margin(piece, x):
    """Distance to the nearer end of a piece; negative outside."""
    return min(x - piece.lower, piece.upper - x)


NO_CURVE = NormalCurve(np.array([0.0, 1.0]), np.zeros(2))
"""The curve of a point with prescribed normal force: no corners, nothing stored."""


LOOP_STATE_NAMES = ("loop set", "loop loss", "closings", "closing speed", "largest force")
"""States of each point with memory: s [m], energy lost before the last event [J], number of
closings. For the last contact: its closing speed [m/s] and the largest N [N]."""
LOOP_STATES = len(LOOP_STATE_NAMES)
BRANCH_START, LOOP_LOSS, CLOSINGS, CLOSING_SPEED, LARGEST_NORMAL = range(LOOP_STATES)
LOOP = [("back", int), ("line", int), ("leeway", float), ("memory", int)]
"""Fields of a contact point. Its pieces from ``last`` + 1 to ``back`` are g; ``line`` is the stiff
one, or `NO_INDEX`; ``leeway``, see `LEEWAY`. The last field is its index among points with memory,
or `NO_INDEX`."""
FORCE_RTOL = 1e-12  # of a force
LEEWAY = 1e-10
"""Fraction of the length of a curve by which the line continues beyond its ends. Per second it is
the speed at which a point may move back on f or g. So a point at rest does not reverse endlessly by
rounding."""


def normal_segments(normal: NormalCurve | NormalLoop) -> np.ndarray:
    """The pieces of f and, for a loop, those of g and the stiff line."""
    loading = segments(normal.compression, normal.force)
    if not isinstance(normal, NormalLoop):
        return loading
    line = segments(np.array([0.0, 1.0]), np.array([0.0, normal.stiffness]))
    return np.concatenate([loading, segments(*_unloading_curve(normal, loading)), line])


def _unloading_curve(normal: NormalLoop, loading: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The table of g; it continues along f from where it would exceed f beyond both tables."""
    x, force = np.array(normal.unloading_compression), np.array(normal.unloading_force)
    slope, on_f = float(np.diff(force[-2:])[0] / np.diff(x[-2:])[0]), float(loading["slope"][-1])
    if slope <= on_f:
        return x, force
    end = max(x[-1], normal.compression[-1])
    f, g = _force_at(normal.compression, normal.force, end), _force_at(x, force, end)
    meet = end + max(f - g, 0.0) / (slope - on_f)
    there, is_before = f + on_f * (meet - end), x < meet
    x, force = (
        np.append(x[is_before], [meet, meet + 1.0]),
        np.append(force[is_before], [there, there + on_f]),
    )
    return x, force


def check(normal: NormalLoop) -> None:
    """Raises InputError if unloading is not below loading, or the line between is not steeper than
    both."""
    x = np.union1d(normal.compression, normal.unloading_compression)
    f = np.array([_force_at(normal.compression, normal.force, at) for at in x])
    g = np.array([_force_at(normal.unloading_compression, normal.unloading_force, at) for at in x])
    if np.any(over := g > f * (1.0 + FORCE_RTOL)):
        k = int(np.argmax(over))
        raise InputError(
            f"normal.unloading: found {g[k]:.6g} N at {x[k]:g} m, where loading has {f[k]:.6g} N;"
            " expected at most that; otherwise the loop would create energy."
        )
    steepest = normal_segments(normal)["slope"][:-1].max()
    if steepest >= normal.stiffness:
        raise InputError(
            f"normal.unloading.stiffness: found {normal.stiffness:.6g} N/m, and slopes up to"
            f" {steepest:.6g} N/m in loading and unloading; expected a larger stiffness."
        )


def _force_at(compression: np.ndarray, force: np.ndarray, x: float) -> float:
    """The force of a table at ``x``, also beyond its end."""
    table = segments(compression, force)
    return float(curve_force(table[find_segment(0, len(table) - 1, table, x)], x))


def loading_fields(
    normal: NormalForce, first: int, segments: np.ndarray
) -> tuple[int, int, float, float]:
    """The first and the last piece of f, the steepest slope of all pieces, and the damping."""
    count = len(normal.compression) - 1 if isinstance(normal, NormalLoop) else len(segments)
    damping = normal.damping if isinstance(normal, NormalCurve) else 0.0
    return first, first + count - 1, segments["slope"].max(), damping


def unloading_fields(
    normal: object, first: int, segments: np.ndarray, memory: int
) -> tuple[int, int, float, int]:
    """Values of `LOOP`."""
    if not isinstance(normal, NormalLoop):
        return NO_INDEX, NO_INDEX, 0.0, memory
    line = first + len(segments) - 1
    return line - 1, line, LEEWAY * float(normal.compression[-1]), memory


@kernel
def branch_crossing(first, last, start, slope, segments):
    """The compression at which the line from ``start`` with the ``slope`` meets a branch."""
    k = first
    while True:
        piece = segments[k]
        x = (slope * start + piece.force - piece.slope * piece.start) / (slope - piece.slope)
        if k == last or x < piece.upper:
            return x
        k += 1


@kernel
def reload_ends(start, point, segments):
    """The compressions at which the stiff line meets g and f."""
    slope = segments[point.line].slope
    return (
        branch_crossing(point.last + 1, point.back, start, slope, segments),
        branch_crossing(point.first, point.last, start, slope, segments),
    )


@kernel
def reload_start(N, x, point, segments):
    """s of the line through the force ``N`` at the compression ``x``."""
    return x - N / segments[point.line].slope


@kernel
def inside_reload_branch(start, x, point, segments):
    """Distance to the nearer end of the line, with its leeway."""
    lower, upper = reload_ends(start, point, segments)
    return min(x - lower, upper - x) + point.leeway


@kernel
def segment_after_reload(start, x, point, segments):
    """Index of the piece of f or g that follows the line at its end nearer to x."""
    lower, upper = reload_ends(start, point, segments)
    if upper - x < x - lower:
        return find_segment(point.first, point.last, segments, x)
    return find_segment(point.last + 1, point.back, segments, x)


@kernel
def recoverable_energy(N, x, point, segments):
    """Recoverable energy of a point from the force ``N`` at the compression ``x``."""
    start = reload_start(N, x, point, segments)
    line = segments[point.line]
    lower = branch_crossing(point.last + 1, point.back, start, line.slope, segments)
    piece = segments[find_segment(point.last + 1, point.back, segments, lower)]
    low = curve_force(piece, lower)
    return stored_energy(piece, lower) + 0.5 * (N * N - low * low) / line.slope


@kernel
def branch_loss(segment, x, point, segments):
    """Energy that the loading curve has taken up to ``x`` and that is not recoverable, on a
    ``segment`` of it; zero on other segments."""
    if point.line == NO_INDEX or segment > point.last:
        return 0.0
    piece = segments[segment]
    N = curve_force(piece, x)
    return stored_energy(piece, x) - recoverable_energy(N, x, point, segments)
