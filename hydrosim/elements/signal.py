"""Signals: a force, a length or a speed over time, from a table, a record or a sine.

    f(t) = A sin(w t + phase) + a + b x + c x^2 + d x^3,   x = t - t_k,  t_k <= t < t_{k+1}

A table is linear between its points and constant outside; its corners are breakpoints of the
integration. A record is the cubic spline with two continuous derivatives through its values
(not-a-knot at the ends; de Boor 1978, chapter 4). It is smooth enough for methods up to order 4 to
keep their order, and undefined outside. A harmonic is mean + A sin(2 pi t / period + phase).

A path is what prescribed motion takes for a table: its acceleration must be finite. It is the
monotone cubic of Fritsch & Butland (1984, SIAM J. Sci. Stat. Comput. 5): it has a continuous rate
and never overshoots. Its acceleration jumps at the points, which are breakpoints.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import copysign, cos, pi, sin
from typing import Any

import numpy as np

from hydrosim.jit.kernels import kernel, piece_of
from hydrosim.scene.signal import Harmonic, Recorded, Signal, SmoothTable, Table, spline_through


def value_at(signal: Signal, t: float = 0.0) -> float:
    """Value of a signal at a time [s]."""
    compiled, pieces = compile_signals([signal])
    return float(value(t, compiled[0], pieces))


def corners(signal: Signal) -> np.ndarray:
    """Times (n,) at which the rate of a signal jumps, or the acceleration of a path, so that no
    step may cross them."""
    return signal.time if isinstance(signal, Table | SmoothTable) else np.zeros(0)


def signal_rate(signal: Signal) -> float:
    """Frequency [rad/s] of the sine that changes as fast as a ``signal``. A table or path has none:
    steps end at its corners, and it is one polynomial between them.

    A record is judged by its third derivative, which is constant between its values. So this is the
    frequency at which cubic interpolation of the record and of the sine have the same error.
    """
    if isinstance(signal, Harmonic):
        return 2.0 * pi / signal.period if signal.amplitude != 0.0 else 0.0
    if isinstance(signal, Table | SmoothTable):
        return 0.0
    size = float(np.std(signal.value))
    if size == 0.0:
        return 0.0
    spline = spline_through(signal.time, signal.value)
    third = np.sqrt(np.average((6.0 * spline.c[0]) ** 2, weights=np.diff(spline.x)))
    return float((third / size) ** (1.0 / 3.0))


SIGNAL = np.dtype(
    [
        *(("amplitude", float), ("frequency", float), ("phase", float)),
        *(("first", int), ("last", int), ("spacing", float)),
    ]
)
"""A signal: its sine, and the pieces ``first`` to ``last`` of its polynomials, about ``spacing``
apart; 0 means unevenly spaced."""

SIGNAL_PIECE = np.dtype([(name, float) for name in ("start", "a", "b", "c", "d")])
"""A piece of a signal from ``start`` to the start of the next."""

NOTHING = np.zeros(1, dtype=SIGNAL)[0]


def compile_signals(signals: Sequence[Signal]) -> tuple[np.ndarray, np.ndarray]:
    """The signals as `SIGNAL` (n,), and all their pieces as `SIGNAL_PIECE` (m,)."""
    constants, pieces, first = (
        np.zeros(len(signals), dtype=SIGNAL),
        [np.zeros(0, dtype=SIGNAL_PIECE)],
        0,
    )
    for i, signal in enumerate(signals):
        new = _pieces(signal)
        last = first + new.size - 1
        constants[i] = (*_sine_constants(signal), first, last, _even_spacing(new["start"]))
        pieces.append(new)
        first = last + 1
    return constants, np.concatenate(pieces)


def _sine_constants(signal: Signal) -> tuple[float, float, float]:
    if isinstance(signal, Harmonic):
        return signal.amplitude, 2.0 * pi / signal.period, signal.phase
    return 0.0, 0.0, 0.0


def _pieces(signal: Signal) -> np.ndarray:
    """Polynomials of a signal."""
    if isinstance(signal, Harmonic):
        return np.array([(0.0, signal.mean, 0.0, 0.0, 0.0)], dtype=SIGNAL_PIECE)
    time, value = signal.time, signal.value
    if isinstance(signal, Recorded):
        return _signal_pieces(time[:-1], spline_through(time, value).c[::-1])
    if isinstance(signal, SmoothTable):
        return _signal_pieces(time[:-1], _monotone_cubic(time, value).c[::-1])
    slopes = np.append(np.diff(value) / np.diff(time), 0.0)  # constant after the last
    return _signal_pieces(time, np.array([value, slopes, 0.0 * value, 0.0 * value]))


def _monotone_cubic(time: np.ndarray, value: np.ndarray) -> Any:
    from scipy.interpolate import PchipInterpolator

    return PchipInterpolator(time, value)


def _signal_pieces(start: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
    pieces = np.zeros(start.size, dtype=SIGNAL_PIECE)
    for name, column in zip(SIGNAL_PIECE.names or (), (start, *coefficients), strict=True):
        pieces[name] = column
    return pieces


def _even_spacing(time: np.ndarray) -> float:
    """Spacing of times that deviate from even ones by less than half of it; else 0."""
    spacing = (time[-1] - time[0]) / max(time.size - 1, 1)
    even = time[0] + spacing * np.arange(time.size)
    return float(spacing) if np.all(np.abs(time - even) < 0.5 * spacing) else 0.0


def time_of_largest(signal: np.void, pieces: np.ndarray) -> float:
    """A time at which a compiled signal is largest, among the points of a table or record."""
    if signal["amplitude"] != 0.0:
        turned = copysign(pi / 2, signal["amplitude"]) - signal["phase"]
        return float(turned / signal["frequency"])
    mine = pieces[signal["first"] : signal["last"] + 1]
    return float(mine["start"][mine["a"].argmax()])


@kernel
def value(t, signal, pieces):
    """f(t)."""
    p = pieces[find_piece(t, signal, pieces)]
    x = max(t - p.start, 0.0)
    polynomial = p.a + x * (p.b + x * (p.c + x * p.d))
    if signal.amplitude == 0.0:
        return polynomial
    return polynomial + signal.amplitude * sin(signal.frequency * t + signal.phase)


@kernel
def rate(t, signal, pieces):
    """f'(t); at a corner, the rate of the piece that begins there."""
    p = pieces[find_piece(t, signal, pieces)]
    x = t - p.start
    polynomial = p.b + x * (2.0 * p.c + x * 3.0 * p.d) if x >= 0.0 else 0.0
    if signal.amplitude == 0.0:
        return polynomial
    turning = signal.frequency * t + signal.phase
    return polynomial + signal.amplitude * signal.frequency * cos(turning)


@kernel
def find_motion(t, signal, piece):
    """f(t), f'(t) and f''(t) of a signal on this ``piece`` of it."""
    x = t - piece.start
    position = piece.a + x * (piece.b + x * (piece.c + x * piece.d))
    speed = piece.b + x * (2.0 * piece.c + x * 3.0 * piece.d)
    acceleration = 2.0 * piece.c + x * 6.0 * piece.d
    if signal.amplitude == 0.0:
        return position, speed, acceleration
    w = signal.frequency
    turning = w * t + signal.phase
    swing = signal.amplitude * sin(turning)
    return (
        position + swing,
        speed + w * signal.amplitude * cos(turning),
        acceleration - w * w * swing,
    )


@kernel
def find_piece(t, signal, pieces):
    """Index of the piece that holds ``t``; the first one before all of them."""
    low, high = signal.first, signal.last
    if signal.spacing > 0.0:  # the piece is this one or a neighbour
        guess = low + int((t - pieces[low].start) / signal.spacing)
        low, high = min(max(guess - 1, low), high), max(min(guess + 1, high), low)
    return piece_of(t, low, high, pieces)
