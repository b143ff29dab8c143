"""Mean drift of a floating body from its waves, and the water that a hull is computed in.

The Kochin function H(t) describes a body's outgoing waves in the direction t, in Capytaine's
normalisation and time factor exp(-i w t). H is the sum for the diffracted waves of unit amplitude
and for the body's motion.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrosim.water.spectra import wavenumber

# The water that a hull is computed in.

MIN_TESTED_KH = 0.01  # kh down to which `green` is tested


@dataclass(frozen=True)
class Water:
    """Density [kg/m^3], gravity [m/s^2] and depth [m], ``math.inf`` for deep water."""

    density: float = 1025.0
    gravity: float = 9.81
    depth: float = math.inf

    @property
    def is_deep(self) -> bool:
        """True for infinite depth."""
        return math.isinf(self.depth)

    @property
    def lowest_frequency(self) -> float:
        """Lowest frequency [rad/s] that can be computed; 0 in deep water."""
        if self.is_deep:
            return 0.0
        return math.sqrt(self.gravity * MIN_TESTED_KH / self.depth * math.tanh(MIN_TESTED_KH))

    def wavenumber(self, frequency: float) -> float:
        """Wavenumber [1/m] of waves of ``frequency`` [rad/s]."""
        return float(wavenumber(frequency, self.depth, self.gravity))


Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

# |H|^2 has Fourier orders up to 2 k R with the half-length R of the body: 720 directions suffice
# for k R < 180.
DIRECTIONS = np.arange(720) * (2 * np.pi / 720)
DIRECTION_STEP = DIRECTIONS[1]


class Drifting(StrEnum):
    """State of a body for its mean drift: floating freely, or held at rest."""

    FREE = "free"
    HELD = "held"


class MeanDrift(NamedTuple):
    """Mean drift per amplitude squared (headings, 6) [N/m^2, N m/m^2], and the relative energy
    imbalance (headings,) of the far field, which is zero for an exact solution of an undamped
    body."""

    force: Real
    imbalance: Real


def mean_drift(
    kochin: Complex,
    frequency: float,
    headings: Real,
    water: Water,
    about: tuple[float, float] = (0.0, 0.0),
) -> MeanDrift:
    """Drift in surge, sway and yaw in waves of unit amplitude, from ``kochin`` (headings,
    directions). Headings are multiples of half a degree. The moment is about the vertical through
    the point ``about`` [m].

    With the wavenumber k, the heading b and the factors c of `_factors`,

        Fx = c2 int |H|^2 (cos b - cos t) dt            (Maruo 1960; sines for Fy)
        Mz = c1 / k Re H'(b) - c2 / k Im int H* H' dt   (Newman 1967)

    In Newman's own form of the force, the first cosine has the factor -c1 Im H(b) instead of c2 int
    |H|^2. These factors are the energy taken from the incident wave and the energy radiated, which
    are equal without viscous damping. The second one leads to less cancellation. The imbalance is
    their ratio minus one. Heave, roll and pitch do not appear in the far field and are zero.
    """
    k = water.wavenumber(frequency)
    c1, c2 = _factors(k, frequency, water)
    kochin = 1j * kochin * _from_origin(k, headings, about)
    slope = _derivative(kochin)
    ahead = (
        np.arange(len(headings)),
        np.rint(headings / DIRECTION_STEP).astype(int) % DIRECTIONS.size,
    )
    energy = np.abs(kochin) ** 2 * DIRECTION_STEP
    force = np.zeros((len(headings), 6))
    for axis, component in enumerate((np.cos, np.sin)):
        turned = component(headings)[:, None] - component(DIRECTIONS)
        force[:, axis] = c2 * np.sum(energy * turned, axis=1)
    spin = np.sum(np.imag(np.conj(kochin) * slope), axis=1) * DIRECTION_STEP
    force[:, 5] = c1 / k * np.real(slope[ahead]) - c2 / k * spin
    taken = -c1 * np.imag(kochin[ahead])
    return MeanDrift(force, taken / (c2 * np.sum(energy, axis=1)) - 1)


def _from_origin(k: float, headings: Real, point: tuple[float, float]) -> Complex:
    """Factors (headings, directions) that turn Kochin functions about the origin into those about a
    ``point``. The incident wave has its phase there."""
    x, y = point
    incident, outgoing = (x * np.cos(to) + y * np.sin(to) for to in (headings, DIRECTIONS))
    return np.asarray(np.exp(1j * k * (outgoing - incident[:, None])))


def _factors(k: float, frequency: float, water: Water) -> tuple[float, float]:
    """c1 = 2 pi rho g k / w and c2 = 2 pi rho k^3 / ((k^2 - K^2) h + K), with K = w^2 / g.

    In deep water, where k = K, these are 2 pi rho w and 2 pi rho k^2. The bracket is
    K (1 + 2 kh / sinh 2 kh), twice K times the ratio of group to phase velocity.
    """
    K, whole = frequency**2 / water.gravity, 2 * np.pi * water.density
    slowed = K if water.is_deep else (k**2 - K**2) * water.depth + K
    return whole * water.gravity * k / frequency, whole * k**3 / slowed


def _derivative(kochin: Complex) -> Complex:
    """Derivative dH/dt by Fourier series."""
    orders = np.fft.fftfreq(DIRECTIONS.size, 1 / DIRECTIONS.size)
    return np.fft.ifft(1j * orders * np.fft.fft(kochin, axis=-1), axis=-1)
