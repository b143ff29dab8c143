"""A normal curve with a way back of its own, and what a point remembers of how it was pressed.

    loading    N = f(x)          while x' > 0          x: compression
    unloading  N = g(x) <= f(x)  while x' < 0
    between    N = k (x - s)     from where it turned until it meets f or g again

f and g: straight lines through the points of tables from (0, 0); k: a stiff line, steeper than
both; s is set where the motion turns, which is an event, and so are the two ends of the line. Every
place between is a place of rest. At rest a point begins at the upper end of its line, on f.

What such a point gives back is the integral of the line down to g, and of g from there. All else
that f takes is lost: over a whole loop the area between f and g. It is known at every place without
integration in time: only its part before the last event is a state.

Limits: between, the line is the same wherever it turned; a point that has let go is as new. f and g
do not depend on the speed.
"""

from __future__ import annotations

import numpy as np

from hydrosim.errors import InputError
from hydrosim.forces import curve
from hydrosim.forces.contact.normal import NormalCurve, NormalLoop, PrescribedNormal
from hydrosim.jit.kernels import kernel

STATE_NAMES = ("loop set", "loop loss", "closings", "closing speed", "largest force")
"""Of each point that remembers: s [m], energy lost before the last event [J], how often it has
closed, and of the last contact the speed at which it closed [m/s] and the largest N [N]."""
STATES = len(STATE_NAMES)
SET, LOSS, CLOSINGS, SPEED, LARGEST = range(STATES)
LOOP = [("back", int), ("line", int), ("leeway", float), ("memory", int)]
"""Fields of a contact point: its pieces from ``last`` + 1 to ``back`` are g, ``line`` is the stiff
one, or `NONE`; ``leeway``, see `LEEWAY`; which of the points that remember it is, or `NONE`."""
NONE = -1
SAME = 1e-12  # of a force
LEEWAY = 1e-10
"""Of the length of a curve, and per second: so far the line goes on beyond its ends, and so slowly
may a point go back on f or g. What rests in rounding does not turn for ever."""


def segments(normal: NormalCurve | NormalLoop) -> np.ndarray:
    """The pieces of f, and of a loop those of g and the stiff line."""
    loading = curve.segments(normal.compression, normal.force)
    if not isinstance(normal, NormalLoop):
        return loading
    line = curve.segments(np.array([0.0, 1.0]), np.array([0.0, normal.stiffness]))
    return np.concatenate([loading, curve.segments(*_unloading(normal, loading)), line])


def _unloading(normal: NormalLoop, loading: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The table of g, which goes on along f from where it would pass that beyond both tables."""
    x, force = np.array(normal.unloading_compression), np.array(normal.unloading_force)
    slope, on_f = float(np.diff(force[-2:])[0] / np.diff(x[-2:])[0]), float(loading["slope"][-1])
    if slope <= on_f:
        return x, force
    end = max(x[-1], normal.compression[-1])
    f, g = _at(normal.compression, normal.force, end), _at(x, force, end)
    meet = end + max(f - g, 0.0) / (slope - on_f)
    there, known = f + on_f * (meet - end), x < meet
    x, force = (
        np.append(x[known], [meet, meet + 1.0]),
        np.append(force[known], [there, there + on_f]),
    )
    return x, force


def check(normal: NormalLoop) -> None:
    """Raises InputError where the way back is not below f, or the line between not steeper."""
    x = np.union1d(normal.compression, normal.unloading_compression)
    f = np.array([_at(normal.compression, normal.force, at) for at in x])
    g = np.array([_at(normal.unloading_compression, normal.unloading_force, at) for at in x])
    if np.any(over := g > f * (1.0 + SAME)):
        k = int(np.argmax(over))
        raise InputError(
            f"normal.unloading: found {g[k]:.6g} N at {x[k]:g} m, where loading has {f[k]:.6g} N;"
            " expected no more: the loop would make energy."
        )
    steepest = segments(normal)["slope"][:-1].max()
    if steepest >= normal.stiffness:
        raise InputError(
            f"normal.unloading.stiffness: found {normal.stiffness:.6g} N/m, and slopes up to"
            f" {steepest:.6g} N/m in loading and unloading; expected more than these."
        )


def _at(compression: np.ndarray, force: np.ndarray, x: float) -> float:
    """The force of a table at ``x``, also beyond its end."""
    table = curve.segments(compression, force)
    return float(curve.curve_force(table[curve.find_segment(0, len(table) - 1, table, x)], x))


def pieces(
    normal: NormalCurve | NormalLoop | PrescribedNormal, first: int, own: np.ndarray
) -> tuple[int, int, float, float]:
    """The first and the last piece of f, the steepest slope of all pieces, and the damping."""
    count = len(normal.compression) - 1 if isinstance(normal, NormalLoop) else len(own)
    damping = normal.damping if isinstance(normal, NormalCurve) else 0.0
    return first, first + count - 1, own["slope"].max(), damping


def back(normal: object, first: int, own: np.ndarray, memory: int) -> tuple[int, int, float, int]:
    """Values of `LOOP`."""
    if not isinstance(normal, NormalLoop):
        return NONE, NONE, 0.0, memory
    line = first + len(own) - 1
    return line - 1, line, LEEWAY * float(normal.compression[-1]), memory


@kernel
def meets(first, last, start, slope, segments):
    """The compression at which the line from ``start`` with the ``slope`` meets a branch."""
    k = first
    while True:
        piece = segments[k]
        x = (slope * start + piece.force - piece.slope * piece.start) / (slope - piece.slope)
        if k == last or x < piece.upper:
            return x
        k += 1


@kernel
def ends(start, point, segments):
    """The compressions at which the stiff line meets g and f."""
    slope = segments[point.line].slope
    return (
        meets(point.last + 1, point.back, start, slope, segments),
        meets(point.first, point.last, start, slope, segments),
    )


@kernel
def start_of_line(N, x, point, segments):
    """s of the line through the force ``N`` at the compression ``x``."""
    return x - N / segments[point.line].slope


@kernel
def inside_line(start, x, point, segments):
    """Distance to the nearer end of the line, with its leeway."""
    lower, upper = ends(start, point, segments)
    return min(x - lower, upper - x) + point.leeway


@kernel
def after_line(start, x, point, segments):
    """Index of the piece of f or g that follows the line at its end that x is nearer to."""
    lower, upper = ends(start, point, segments)
    if upper - x < x - lower:
        return curve.find_segment(point.first, point.last, segments, x)
    return curve.find_segment(point.last + 1, point.back, segments, x)


@kernel
def recoverable(N, x, point, segments):
    """Energy that a point gives back from the force ``N`` at the compression ``x``."""
    start = start_of_line(N, x, point, segments)
    line = segments[point.line]
    lower = meets(point.last + 1, point.back, start, line.slope, segments)
    piece = segments[curve.find_segment(point.last + 1, point.back, segments, lower)]
    low = curve.curve_force(piece, lower)
    return curve.stored_energy(piece, lower) + 0.5 * (N * N - low * low) / line.slope


@kernel
def lost_on(segment, x, point, segments):
    """Energy that f has taken up to ``x`` and that is not given back, on a ``segment`` of it; zero
    on the others."""
    if point.line == NONE or segment > point.last:
        return 0.0
    piece = segments[segment]
    N = curve.curve_force(piece, x)
    return curve.stored_energy(piece, x) - recoverable(N, x, point, segments)
