"""Heights, periods and wavelengths of drawn seas."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from hydrosim.waves.components import WaveComponents


def height_of(sea: WaveComponents) -> float:
    """Height of a regular wave, significant height of other seas [m]."""
    if sea.omega.size == 1:
        return 2.0 * float(sea.amplitude[0])
    return 4.0 * float(np.sqrt(np.sum(sea.amplitude**2) / 2.0))


def crossing_period(sea: WaveComponents) -> float:
    """Mean zero-crossing period 2 pi sqrt(m0 / m2) [s]."""
    energy = sea.amplitude**2
    return float(2.0 * np.pi * np.sqrt(energy.sum() / np.sum(energy * sea.omega**2)))


def peak_period(sea: WaveComponents) -> float:
    """Period [s] of the mean frequency weighted by the fourth power of the amplitudes, near the
    peak."""
    weight = sea.amplitude**4
    return float(2.0 * np.pi * weight.sum() / np.sum(weight * sea.omega))


def peak_wavelength(seas: Sequence[WaveComponents]) -> float:
    """Wavelength [m] near the peak of the sea with the most energy."""
    sea = max(seas, key=lambda waves: float(np.sum(waves.amplitude**2)))
    at = int(np.argmin(np.abs(sea.omega - 2.0 * np.pi / peak_period(sea))))
    return float(2.0 * np.pi / sea.wavenumber[at])
