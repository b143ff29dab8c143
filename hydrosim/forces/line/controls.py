"""What drives the drum of a winch (`hydrosim.forces.line.drum`), as data."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from hydrosim.forces.signal import Signal


@dataclass(frozen=True)
class TensionControl:
    """A set ``tension`` [N] by a drum that pays out or heaves in at most at ``speed`` [m/s]. The
    ``dead_band`` and the friction inwards and outwards are parts of the tension;
    ``acceleration`` [m/s^2] is that of the drum, 0 if it is not limited."""

    tension: float
    speed: float
    dead_band: float = 0.0
    friction_in: float = 0.0
    friction_out: float = 0.0
    acceleration: float = 0.0


@dataclass(frozen=True)
class SpeedControl:
    """The ``speed`` of pay-out [m/s] over time."""

    speed: Signal


@dataclass(frozen=True)
class Compensation:
    """The drum pays out ``gain`` times the rise of a named ``point``, "eye of crane", which it
    knows ``delay`` [s] later; at most at ``speed`` [m/s]."""

    point: str
    gain: float = 1.0
    delay: float = 0.0
    speed: float = inf


Control = TensionControl | SpeedControl | Compensation
