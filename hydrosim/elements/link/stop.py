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
from hydrosim.modes import CONTACT_MARGIN, SEGMENT, SEGMENT_MARGIN
from hydrosim.scene.links import Stop

AWAY, AT_LOWEST, AT_HIGHEST, BELOW, ABOVE = range(5)

STOPS = np.dtype([("lowest", float), ("highest", float), ("stiffness", float)])
"""Constants of stops: a, b, k."""


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
        "damping": stop.damping,
    }


def constants(stop: Stop) -> np.ndarray:
    """Its constants (1,) of `STOPS`."""
    return np.array([(stop.low, stop.high, stop.stiffness)], dtype=STOPS)


STOP_CLASS = LinkClass(Stop, "stop", load_and_place("stop"), law_fields, constants=constants)


@kernel
def _beyond(stop, segment, x):
    """The load of the spring of a stop: negative below the lowest place."""
    if segment in (AT_LOWEST, BELOW):
        return stop.stiffness * (x - stop.lowest)
    if segment in (AT_HIGHEST, ABOVE):
        return stop.stiffness * (x - stop.highest)
    return 0.0


@kernel
def find_loads(link, stop, mode, s):
    """T, and the power that it dissipates."""
    f = _beyond(stop, mode[SEGMENT], s.x)
    if mode[SEGMENT] == AT_LOWEST or mode[SEGMENT] == AT_HIGHEST:
        lost = link.damping * s.rate
        return f + lost, lost * s.rate
    return 0.0, -f * s.rate


@kernel
def stored_energy(stop, mode, s):
    """k d^2 / 2."""
    f = _beyond(stop, mode[SEGMENT], s.x)
    return 0.5 * f * f / stop.stiffness


@kernel
def find_margins(link, stop, mode, s, out):
    """Margins (4,): way to the stops, or beyond the one that is met; the force of that stop."""
    segment = mode[SEGMENT]
    if segment == AWAY:
        out[CONTACT_MARGIN] = min(s.x - stop.lowest, stop.highest - s.x)
        return
    f = _beyond(stop, segment, s.x)
    sign = -1.0 if segment in (AT_LOWEST, BELOW) else 1.0
    out[CONTACT_MARGIN] = sign * f / stop.stiffness
    if link.damping > 0.0:
        force = sign * (f + link.damping * s.rate)
        pressed = segment in (AT_LOWEST, AT_HIGHEST)
        out[SEGMENT_MARGIN] = force if pressed else -force


@kernel
def transition(stop, which, mode, s):
    """The next mode, after margin ``which`` has reached zero."""
    segment = mode[SEGMENT]
    if which == SEGMENT_MARGIN:
        shift = BELOW - AT_LOWEST
        mode[SEGMENT] = segment + shift if segment < BELOW else segment - shift
    elif segment != AWAY:
        mode[SEGMENT] = AWAY
    elif s.x - stop.lowest < stop.highest - s.x:
        mode[SEGMENT] = AT_LOWEST if s.rate < 0.0 else BELOW
    else:
        mode[SEGMENT] = AT_HIGHEST if s.rate > 0.0 else ABOVE


@kernel
def set_initial_mode(link, stop, mode, s):
    """The mode of a stop that becomes active."""
    mode[SEGMENT] = AWAY
    if s.x < stop.lowest:
        pressed = stop.stiffness * (s.x - stop.lowest) + link.damping * s.rate < 0.0
        mode[SEGMENT] = AT_LOWEST if pressed else BELOW
    elif s.x > stop.highest:
        pressed = stop.stiffness * (s.x - stop.highest) + link.damping * s.rate > 0.0
        mode[SEGMENT] = AT_HIGHEST if pressed else ABOVE
