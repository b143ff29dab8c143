"""End stops of a coordinate.

    F = k d - c d',   d = a - x below the lowest place a, or x - b above the highest place b

d: way beyond the stop, which presses against it with F. It never pulls: where that would be
negative, there is no force. Meeting a stop, leaving it and the end of its force are events. Stored
energy is k d^2 / 2, also while there is no force; what a stop then releases is dissipated.
"""

from __future__ import annotations

from math import inf
from typing import Any

import numpy as np

from hydrosim.elements.kind import LINEARISATION_DEPTH
from hydrosim.elements.link.law import ANYWHERE, LinkClass, load_and_place
from hydrosim.jit.kernels import kernel
from hydrosim.modes import CONTACT_MARGIN, SEGMENT_MARGIN
from hydrosim.scene.links import Stop

AWAY, AT_LOWEST, AT_HIGHEST, BELOW, ABOVE = range(5)

STOPS = np.dtype([("lowest", float), ("highest", float), ("stiffness", float), ("damping", float)])
"""Constants of stops: a, b, k, c."""
NO_STOPS = (-inf, inf, 0.0, 0.0)


def law_fields(stop: Stop, _: np.ndarray) -> dict[str, Any]:
    """Fields of `LINK` of a stop."""
    low = stop.low > -inf
    place = stop.low - LINEARISATION_DEPTH if low else stop.high + LINEARISATION_DEPTH
    return {
        "last": ABOVE,
        "steepest": stop.stiffness,
        "idle": AWAY,
        "idle_range": ANYWHERE,
        "stiff": AT_LOWEST if low else AT_HIGHEST,
        "stiff_range": (place, place),
    }


def constants(stop: Stop) -> np.ndarray:
    """Its constants (1,) of `STOPS`."""
    return np.array([(stop.low, stop.high, stop.stiffness, stop.damping)], dtype=STOPS)


STOP_CLASS = LinkClass(Stop, "stop", load_and_place("stop"), law_fields, constants=constants)


@kernel
def _way_beyond(stop, segment, x):
    """The way x - a or x - b beyond the stop that is met: negative below the lowest place."""
    if segment in (AT_LOWEST, BELOW):
        return x - stop.lowest
    return x - stop.highest if segment in (AT_HIGHEST, ABOVE) else 0.0


@kernel
def find_loads(stop, segment, x, rate):
    """T, and the power that it dissipates."""
    f = stop.stiffness * _way_beyond(stop, segment, x)
    if segment in (AT_LOWEST, AT_HIGHEST):
        lost = stop.damping * rate
        return f + lost, lost * rate
    return 0.0, -f * rate


@kernel
def stored_energy(stop, segment, x):
    """k d^2 / 2."""
    d = _way_beyond(stop, segment, x)
    return 0.5 * (stop.stiffness * d * d)


@kernel
def find_margins(stop, segment, x, rate, out):
    """Margins (4,): way to the stops, or beyond the one that is met; the force of that stop."""
    if segment == AWAY:
        out[CONTACT_MARGIN] = min(x - stop.lowest, stop.highest - x)
        return
    d = _way_beyond(stop, segment, x)
    sign = -1.0 if segment in (AT_LOWEST, BELOW) else 1.0
    out[CONTACT_MARGIN] = sign * d
    if stop.damping > 0.0:
        force = sign * (stop.stiffness * d + stop.damping * rate)
        pressed = segment in (AT_LOWEST, AT_HIGHEST)
        out[SEGMENT_MARGIN] = force if pressed else -force


@kernel
def next_segment(stop, which, segment, x, rate):
    """The next segment, after margin ``which`` has reached zero."""
    if which == SEGMENT_MARGIN:
        shift = BELOW - AT_LOWEST
        return segment + shift if segment < BELOW else segment - shift
    if segment != AWAY:
        return AWAY
    if x - stop.lowest < stop.highest - x:
        return AT_LOWEST if rate < 0.0 else BELOW
    return AT_HIGHEST if rate > 0.0 else ABOVE


@kernel
def initial_segment(stop, x, rate):
    """The segment of a stop that becomes active."""
    if x < stop.lowest:
        pressed = stop.stiffness * (x - stop.lowest) + stop.damping * rate < 0.0
        return AT_LOWEST if pressed else BELOW
    if x > stop.highest:
        pressed = stop.stiffness * (x - stop.highest) + stop.damping * rate > 0.0
        return AT_HIGHEST if pressed else ABOVE
    return AWAY
