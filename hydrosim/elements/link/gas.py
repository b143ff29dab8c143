"""Gas springs with end stops, and the passive compensator: one in a line, which pulls only.

    f(x) = s P (h / (h - s x))^n

x: extension from the middle of the stroke S, where the load is s P: a gas spring with s = -1 pushes
more as it gets shorter, one with s = 1 pulls more as it gets longer, as a compensator does, whose
piston compresses the gas; h: volume of the gas over the area of its piston there; n: exponent of
p V^n = const, 1 for slow and about 1.4 for fast motion of nitrogen.

Beyond the stroke the piston is on a stop, and the gas keeps its pressure:

    f(x) = f(S/2) + k (x - S/2)   or   f(-S/2) - k (-S/2 - x)

k: stiffness of the stop, and of the line of a compensator. The load is T = f(x) + c x', c: damping.
What pulls only is slack where f would be negative, and T is cut where damping alone would push.
Stops, slack and cuts are events. Stored energy is the integral of f from the middle of the stroke.
Dissipation is (T - f) x'.

Limits: no mass of the piston, no heat to or from the gas, no flow to a bottle but by c.
"""

from __future__ import annotations

from math import inf, log
from typing import Any

import numpy as np

from hydrosim.elements.kind import (
    LARGEST,
    LINEARISATION_DEPTH,
    ChartHint,
    SummaryColumn,
    Topic,
    Variable,
    tension_variable,
)
from hydrosim.elements.link import law
from hydrosim.jit.kernels import kernel
from hydrosim.modes import CONTACT_MARGIN, MODE, SEGMENT, SEGMENT_MARGIN
from hydrosim.scene.links import Compensator, GasSpring

PULLING, TENSION_CUT, CYLINDER_INACTIVE = range(3)
SLACK_PIECE, LOWER, IN_STROKE, UPPER = range(4)

CYLINDER = np.dtype(
    [
        *(("sign", float), ("load", float), ("gas", float)),
        *(("exponent", float), ("half", float), ("stiffness", float)),
        *(("low", float), ("high", float)),
    ]
)
"""Constants of a gas spring: s; P, h, n; S/2, k; f at both ends."""


def law_fields(element: Compensator | GasSpring, _: np.ndarray) -> dict[str, Any]:
    """Fields of `LINK` of a gas spring."""
    half = 0.5 * element.stroke
    compressed = half if isinstance(element, Compensator) else -half
    return {
        "first": SLACK_PIECE,
        "last": UPPER,
        "steepest": element.stiffness,
        "idle": IN_STROKE,
        "idle_range": (compressed, compressed),
        "stiff": UPPER,
        "stiff_range": (half + LINEARISATION_DEPTH, half + LINEARISATION_DEPTH),
        "damping": element.damping,
    }


def _cylinder(element: Compensator | GasSpring, sign: float, load: float) -> np.ndarray:
    """Its constants, of `CYLINDER`, with the ``load`` in the middle of the stroke."""
    half = 0.5 * element.stroke
    length = element.gas_length
    low = sign * load * (length / (length + sign * half)) ** element.exponent
    high = sign * load * (length / (length - sign * half)) ** element.exponent
    gas = (sign, load, length, element.exponent)
    return np.array([(*gas, half, element.stiffness, low, high)], dtype=CYLINDER)


COLUMNS = {
    "compensator_tension": law.Column(
        law.LOAD_OUTPUT,
        tension_variable(
            "tension",
            "from the point to the anchor",
            "Tension of compensators",
            3,
            (LARGEST, SummaryColumn("smallest", "smallest")),
        ),
    ),
    "compensator_stroke": law.Column(
        law.OFFSET_OUTPUT,
        Variable(
            "extension from the middle of the stroke",
            "m",
            chart=ChartHint("Stroke of compensators", "stroke", Topic.LINKS + 2),
        ),
    ),
}
COMPENSATOR = law.LinkClass(
    *(Compensator, "compensator", COLUMNS, law_fields),
    constants=lambda element: _cylinder(element, 1.0, element.tension),
    inactive_mode=CYLINDER_INACTIVE,
    pulls_only=True,
)
GAS_SPRING = law.LinkClass(
    *(GasSpring, "gas_spring", law.load_and_place("gas_spring"), law_fields),
    constants=lambda element: _cylinder(element, -1.0, element.push),
)


@kernel
def static_load(gas, segment, x):
    """f(x) on a segment."""
    if segment == IN_STROKE:
        return gas.sign * gas.load * (gas.gas / (gas.gas - gas.sign * x)) ** gas.exponent
    if segment == UPPER:
        return gas.high + gas.stiffness * (x - gas.half)
    if segment == LOWER:
        return gas.low + gas.stiffness * (x + gas.half)
    return 0.0


@kernel
def stored_energy(gas, mode, s):
    """Integral of f from the middle of the stroke to x."""
    segment = mode[SEGMENT]
    x = s.x
    if segment == IN_STROKE:
        return _gas_energy(gas, x)
    if segment == UPPER:
        d = x - gas.half
        return _gas_energy(gas, gas.half) + (gas.high + 0.5 * gas.stiffness * d) * d
    d = -gas.low / gas.stiffness  # where it becomes slack
    if segment == LOWER:
        d = x + gas.half
    return _gas_energy(gas, -gas.half) + (gas.low + 0.5 * gas.stiffness * d) * d


@kernel
def _gas_energy(gas, x):
    h = gas.gas
    n = gas.exponent
    inward = gas.sign * x
    if n == 1.0:
        return gas.load * h * log(h / (h - inward))
    return gas.load * h / (n - 1.0) * ((h / (h - inward)) ** (n - 1.0) - 1.0)


@kernel
def find_loads(link, gas, mode, s):
    """T, and the power that it dissipates."""
    f = static_load(gas, mode[SEGMENT], s.x)
    if link.pulls_only and (mode[MODE] != PULLING or mode[SEGMENT] == SLACK_PIECE):
        return 0.0, -f * s.rate
    T = f + link.damping * s.rate
    return T, (T - f) * s.rate


@kernel
def _ends(link, gas, segment):
    """x where a segment begins and where it ends."""
    slack = -gas.half - gas.low / gas.stiffness
    if segment == SLACK_PIECE:
        return -inf, slack
    if segment == LOWER:
        return slack if link.pulls_only else -inf, -gas.half
    return (-gas.half, gas.half) if segment == IN_STROKE else (gas.half, inf)


@kernel
def find_margins(link, gas, mode, s, out):
    """Margins (4,): T, or its opposite where it is cut; the way to the nearer end of the
    segment."""
    segment = mode[SEGMENT]
    lower, upper = _ends(link, gas, segment)
    out[SEGMENT_MARGIN] = min(s.x - lower, upper - s.x)
    if link.pulls_only and link.damping > 0.0 and segment != SLACK_PIECE:
        T = static_load(gas, segment, s.x) + link.damping * s.rate
        out[CONTACT_MARGIN] = T if mode[MODE] == PULLING else -T


@kernel
def transition(link, gas, which, mode, s):
    """The next mode, after margin ``which`` has reached zero."""
    if which == CONTACT_MARGIN:
        mode[MODE] = TENSION_CUT if mode[MODE] == PULLING else PULLING
        return
    segment = mode[SEGMENT]
    lower, upper = _ends(link, gas, segment)
    mode[SEGMENT] = segment + 1 if upper - s.x < s.x - lower else segment - 1
    if segment == SLACK_PIECE:
        mode[MODE] = PULLING


@kernel
def set_initial_mode(link, gas, mode, s):
    """The mode of a gas spring that becomes active."""
    segment = SLACK_PIECE if link.pulls_only else LOWER
    while segment < UPPER and s.x >= _ends(link, gas, segment)[1]:
        segment += 1
    mode[SEGMENT] = segment
    mode[MODE] = PULLING
    if link.pulls_only and static_load(gas, segment, s.x) + link.damping * s.rate < 0.0:
        mode[MODE] = TENSION_CUT
