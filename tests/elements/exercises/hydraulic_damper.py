"""Hydraulic damper with a stroke and end stops: an orifice behind oil that is compressed.

    T' = K (x' - T / c),   and beyond the stroke   T + k (x - end)

T: load of the oil, a state; K: its stiffness; c: damping of the orifice; k: stiffness of the stops.
Meeting and leaving a stop are events. Stored energy is T^2 / 2 K + k (x - end)^2 / 2; T^2 / c is
dissipated.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from hydrosim.elements.link.law import ANYWHERE, LinkClass, load_and_place
from hydrosim.jit.kernels import kernel
from hydrosim.modes import SEGMENT, SEGMENT_MARGIN
from hydrosim.scene.links import HydraulicDamper

RETRACTED, IN_STROKE, EXTENDED = range(3)
DAMPER = np.dtype([(name, float) for name in ("oil", "orifice", "low", "high", "stop")])


def law_fields(damper: HydraulicDamper, _: np.ndarray) -> dict[str, Any]:
    """Fields of `LINK` of a damper."""
    fields = {"last": EXTENDED, "steepest": damper.stop, "idle": IN_STROKE, "stiff": EXTENDED}
    return {**fields, "idle_range": ANYWHERE, "stiff_range": (damper.longest, damper.longest)}


def constants(damper: HydraulicDamper) -> np.ndarray:
    """Its constants (1,) of `DAMPER`."""
    stroke = (damper.shortest, damper.longest, damper.stop)
    return np.array([(damper.oil, damper.orifice, *stroke)], dtype=DAMPER)


DAMPER_CLASS = LinkClass(
    *(HydraulicDamper, "hydraulic_damper", load_and_place("hydraulic_damper"), law_fields),
    constants=constants,
    state_names=("load of the oil",),
)


@kernel
def _beyond(damper, mode, s):
    """Way beyond the stroke."""
    if mode[SEGMENT] == IN_STROKE:
        return 0.0
    return s.x - (damper.high if mode[SEGMENT] == EXTENDED else damper.low)


@kernel
def find_loads(damper, mode, s, oil_load):
    """T with the stop, and the power that is dissipated."""
    return oil_load + damper.stop * _beyond(damper, mode, s), oil_load * oil_load / damper.orifice


@kernel
def load_rate(damper, s, oil_load):
    """T'."""
    return damper.oil * (s.rate - oil_load / damper.orifice)


@kernel
def stored_energy(damper, mode, s, oil_load):
    """Energy of the oil and of the stop."""
    d = _beyond(damper, mode, s)
    return 0.5 * (oil_load * oil_load / damper.oil + damper.stop * d * d)


@kernel
def find_margins(damper, mode, s, out):
    """Margin (4,): the way to the nearer stop, or back from the one that is met."""
    if mode[SEGMENT] == IN_STROKE:
        out[SEGMENT_MARGIN] = min(s.x - damper.low, damper.high - s.x)
    else:
        sign = 1.0 if mode[SEGMENT] == EXTENDED else -1.0
        out[SEGMENT_MARGIN] = sign * _beyond(damper, mode, s)


@kernel
def transition(damper, mode, s):
    """The next mode, where a stop is met or left."""
    if mode[SEGMENT] != IN_STROKE:
        mode[SEGMENT] = IN_STROKE
    else:
        mode[SEGMENT] = EXTENDED if damper.high - s.x < s.x - damper.low else RETRACTED


@kernel
def set_initial_mode(damper, mode, s):
    """The mode of a damper that becomes active."""
    mode[SEGMENT] = EXTENDED if s.x > damper.high else IN_STROKE
    if s.x < damper.low:
        mode[SEGMENT] = RETRACTED
