"""Estimate of the part of a hull's loads that is lost between the headings of its database.

N headings evenly round the circle resolve the harmonics of the heading up to N / 2. Higher
harmonics are lost, and appear as lower ones (aliasing). Their size is estimated from the decay of
the last resolved harmonics. Beyond their argument Bessel functions decay as J_(n+2) / J_n ~ x^2 /
(4 (n + 1) (n + 2)). (A hull of length L has harmonics up to about k L / 2; Abramowitz and Stegun
1964, 9.3.1.)

On the shipped hulls with every second heading left out, the estimate is 0.7 to 1.4 times the true
loss, as long as that is below a half.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from hydrosim.waves.components import WaveComponents
    from hydrosim.waves.transfer import TransferFunctions

MIN_HEADINGS = 8  # fewest headings for an estimate
EVEN = 1e-6  # rad: largest difference of the spacing of headings
UNRESOLVED = 0.95  # largest ratio of harmonics: above it they do not decay
ARM = 1e-3  # m: moments below the forces times this arm are noise


def lost_between_headings(
    database: TransferFunctions, seas: Sequence[WaveComponents]
) -> tuple[float, float] | None:
    """Loss by interpolation between the headings, for the first-order forces and for the moments in
    the ``seas``: root mean squares over all headings, relative to those of the loads.

    None if the headings are not evenly spaced round the circle, or fewer than `MIN_HEADINGS`.
    """
    order = np.argsort(np.mod(database.heading, 2.0 * np.pi))
    angle = np.mod(database.heading, 2.0 * np.pi)[order]
    count = angle.size
    if count < MIN_HEADINGS or np.abs(np.diff(angle) - 2.0 * np.pi / count).max() > EVEN:
        return None
    X = database.excitation[:, order, :6]
    size, missed = (np.abs(X) ** 2).mean(axis=1), _interpolation_loss(X) ** 2
    weight = _energies(database.frequency, seas)
    total, error = (np.sqrt((weight @ x).reshape(2, 3).sum(axis=1)) for x in (size, missed))
    if total[1] < ARM * total[0]:
        error[1] = 0.0
    forces, moments = np.divide(error, total, out=np.zeros(2), where=total > 0.0)
    return float(forces), float(moments)


def _interpolation_loss(X: np.ndarray) -> np.ndarray:
    """Root mean square (nw, n) over the headings of the loss of X (nw, N, n) between them."""
    last, count = X.shape[1] // 2, X.shape[1]
    power = np.abs(np.fft.fft(X, axis=1) / count) ** 2
    power = power + np.roll(power[:, ::-1], 1, axis=1)  # of n and -n together
    before, end = (np.sqrt(power[:, last - k] + power[:, last - k + 1]) for k in (4, 2))
    n = last - 3.5  # of the first two; even and odd ones may differ, so two at a time
    falling = (n + 1.0) * (n + 2.0) / ((n + 3.0) * (n + 4.0))
    ratio = np.minimum(falling * end / np.maximum(before, np.finfo(float).tiny), 1.0)
    beyond = end * ratio / np.sqrt(1.0 - np.minimum(ratio, UNRESOLVED) ** 2)
    most = np.sqrt((np.abs(X) ** 2).mean(axis=1))
    return np.asarray(np.sqrt(2.0) * np.minimum(beyond, most))


def _energies(frequency: np.ndarray, seas: Sequence[WaveComponents]) -> np.ndarray:
    """Energy of the seas near each of the frequencies (nw,)."""
    middle = 0.5 * (frequency[1:] + frequency[:-1])
    found = np.zeros(frequency.size)
    for waves in seas:
        inside = waves.omega <= frequency[-1]
        near = np.searchsorted(middle, waves.omega[inside])
        np.add.at(found, near, waves.amplitude[inside] ** 2)
    return found
