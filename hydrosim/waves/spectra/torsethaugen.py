"""Torsethaugen's spectrum: division of a sea of given height and peak period into wind sea and
swell.

Torsethaugen and Haver (2004), "Simplified double peak spectral model for ocean waves", ISOPE; also
in DNV-RP-C205, 3.5.6. A fully developed wind sea has the peak period T_f = 6.6 Hs^(1/3) (a fetch of
370 km). Up to T_f the main peak is wind sea and the secondary one is swell. Above T_f the main peak
is swell. The squares of the two heights add up to Hs^2.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hydrosim.waves.spectra.peaks import Peak

if TYPE_CHECKING:
    from hydrosim.scene import Torsethaugen

_EXPONENT = 4.0


def wind_sea_and_swell(sea: Torsethaugen) -> tuple[Peak, Peak]:
    """The main peak, which is enhanced, and the secondary one.

    Heights are in m and periods in s: the coefficients depend on these units.
    """
    height, period = sea.significant_height, sea.peak_period
    developed = 6.6 * height ** (1.0 / 3.0)
    if period <= developed:
        lowest = 2.0 * np.sqrt(height)
        young = min((developed - period) / (developed - lowest), 1.0)
        main = (0.7 + 0.3 * np.exp(-((2.0 * young) ** 2))) * height
        other = np.sqrt(height**2 - main**2)
        enhancement = _enhancement(main, period, sea.gravity)
        second_period = developed + 2.0
    else:
        old = min((period - developed) / (25.0 - developed), 1.0)
        main = (0.6 + 0.4 * np.exp(-((old / 0.3) ** 2))) * height
        other = np.sqrt(height**2 - main**2)
        enhancement = _enhancement(height, developed, sea.gravity) * (1.0 + 6.0 * old)
        second_period = 6.6 * other ** (1.0 / 3.0)
    return (
        Peak(float(main), period, _EXPONENT, max(float(enhancement), 1.0)),
        Peak(float(other), float(second_period) or period, _EXPONENT),
    )


def _enhancement(height: float, period: float, gravity: float) -> float:
    """Peak enhancement from the steepness of a sea."""
    return 35.0 * (2.0 * np.pi * height / (gravity * period**2)) ** 0.857 if period else 1.0
