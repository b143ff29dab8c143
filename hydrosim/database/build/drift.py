"""Mean drift of a floating body from the waves it sends out.

A body's outgoing waves are described by the Kochin function H(t), t the direction they go to, in
Capytaine's normalisation and time factor exp(-i w t); H is that of the diffracted waves of unit
amplitude plus those of the body's motion.
"""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrosim.database.build.water import Water

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

# |H|^2 has Fourier orders up to 2 k R, R the body's half-length: 720 directions serve k R < 180.
DIRECTIONS = np.arange(720) * (2 * np.pi / 720)
STEP = DIRECTIONS[1]


class Drifting(StrEnum):
    """How a body takes part in its mean drift: floating free, or held at rest."""

    FREE = "free"
    HELD = "held"


class Drift(NamedTuple):
    """Mean drift per amplitude squared (headings, 6) [N/m^2, N m/m^2] and the relative energy
    imbalance (headings,) of the far field: zero for an exact solution of an undamped body."""

    force: Real
    imbalance: Real


def mean_drift(kochin: Complex, frequency: float, headings: Real, water: Water) -> Drift:
    """Drift in surge, sway and yaw in waves of unit amplitude, for ``kochin`` (headings,
    directions); headings are multiples of half a degree.

    With k the wavenumber, b the heading and the factors c of `_factors`,

        Fx = c2 int |H|^2 (cos b - cos t) dt            (Maruo 1960; sines for Fy)
        Mz = c1 / k Re H'(b) - c2 / k Im int H* H' dt   (Newman 1967)

    In Newman's own form of the force the first cosine has the factor -c1 Im H(b) instead of
    c2 int |H|^2. These are the energy taken from the incident wave and the energy radiated, equal
    without viscous damping; the second cancels less against the rest. The imbalance is their ratio
    less one. The moment is about the vertical through the origin; heave, roll and pitch do not
    show in the far field and are zero.
    """
    k = water.wavenumber(frequency)
    c1, c2 = _factors(k, frequency, water)
    kochin = 1j * kochin
    slope = _derivative(kochin)
    ahead = np.arange(len(headings)), np.rint(headings / STEP).astype(int) % DIRECTIONS.size
    energy = np.abs(kochin) ** 2 * STEP
    force = np.zeros((len(headings), 6))
    for axis, component in enumerate((np.cos, np.sin)):
        turned = component(headings)[:, None] - component(DIRECTIONS)
        force[:, axis] = c2 * np.sum(energy * turned, axis=1)
    spin = np.sum(np.imag(np.conj(kochin) * slope), axis=1) * STEP
    force[:, 5] = c1 / k * np.real(slope[ahead]) - c2 / k * spin
    taken = -c1 * np.imag(kochin[ahead])
    return Drift(force, taken / (c2 * np.sum(energy, axis=1)) - 1)


def _factors(k: float, frequency: float, water: Water) -> tuple[float, float]:
    """c1 = 2 pi rho g k / w and c2 = 2 pi rho k^3 / ((k^2 - K^2) h + K), with K = w^2 / g.

    In deep water, where k = K, these are 2 pi rho w and 2 pi rho k^2. The bracket is
    K (1 + 2 kh / sinh 2 kh), twice K times the ratio of group to phase velocity.
    """
    K, whole = frequency**2 / water.gravity, 2 * np.pi * water.density
    slowed = K if water.is_deep else (k**2 - K**2) * water.depth + K
    return whole * water.gravity * k / frequency, whole * k**3 / slowed


def _derivative(kochin: Complex) -> Complex:
    """dH/dt by Fourier series."""
    orders = np.fft.fftfreq(DIRECTIONS.size, 1 / DIRECTIONS.size)
    return np.fft.ifft(1j * orders * np.fft.fft(kochin, axis=-1), axis=-1)
