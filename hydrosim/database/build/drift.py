"""Mean drift of a floating body from the waves it sends out, in deep water.

A body's outgoing waves are described by the Kochin function H(t), t the direction they go to, in
Capytaine's normalisation and time factor exp(-i w t); H is that of the diffracted waves of unit
amplitude plus those of the body's motion.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

# |H|^2 has Fourier orders up to 2 k R, R the body's half-length: 720 directions serve k R < 180.
DIRECTIONS = np.arange(720) * (2 * np.pi / 720)
STEP = DIRECTIONS[1]


class Drift(NamedTuple):
    """Mean drift per amplitude squared (headings, 6) [N/m^2, N m/m^2] and the relative energy
    imbalance (headings,) of the far field: zero for an exact solution of an undamped body."""

    force: Real
    imbalance: Real


def mean_drift(
    kochin: Complex, frequency: float, headings: Real, density: float, gravity: float
) -> Drift:
    """Drift in surge, sway and yaw in waves of unit amplitude, for ``kochin`` (headings,
    directions); headings are multiples of half a degree.

    With k the wavenumber and b the heading,

        Fx = 2 pi rho k^2 int |H|^2 (cos b - cos t) dt      (Maruo 1960; sines for Fy)
        Mz = 2 pi rho (w/k Re H'(b) - k Im int H* H' dt)    (Newman 1967)

    In Newman's own form of the force the first cosine has the factor -w Im H(b) instead of
    k^2 int |H|^2. These are the energy taken from the incident wave and the energy radiated, equal
    without viscous damping; the second cancels less against the rest. The imbalance is their ratio
    less one. The moment is about the vertical through the origin; heave, roll and pitch do not
    show in the far field and are zero.
    """
    k = frequency**2 / gravity
    kochin = 1j * kochin
    slope = _derivative(kochin)
    ahead = np.arange(len(headings)), np.rint(headings / STEP).astype(int)
    energy = np.abs(kochin) ** 2 * STEP
    force = np.zeros((len(headings), 6))
    for axis, component in enumerate((np.cos, np.sin)):
        turned = component(headings)[:, None] - component(DIRECTIONS)
        force[:, axis] = 2 * np.pi * density * k**2 * np.sum(energy * turned, axis=1)
    spin = np.sum(np.imag(np.conj(kochin) * slope), axis=1) * STEP
    force[:, 5] = 2 * np.pi * density * (frequency / k * np.real(slope[ahead]) - k * spin)
    taken = -frequency * np.imag(kochin[ahead])
    return Drift(force, taken / (k**2 * np.sum(energy, axis=1)) - 1)


def _derivative(kochin: Complex) -> Complex:
    """dH/dt by Fourier series."""
    orders = np.fft.fftfreq(DIRECTIONS.size, 1 / DIRECTIONS.size)
    return np.fft.ifft(1j * orders * np.fft.fft(kochin, axis=-1), axis=-1)
