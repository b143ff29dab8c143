"""Weight of each frequency in a fit: low frequencies count more, because small forces matter to
slow motions.

The relative change of a motion is the change of K^ over the impedance, which is about i w (M + A).
So the same error of K^ has the more effect, the slower the motion. Errors of K^ are therefore
multiplied by |W(i w)|, W(s) = (s + b) / (s + a), which is 1 above b and `RATIO` below a. Since W is
a filter, balanced truncation still needs only matrix equations: frequency-weighted Gramians (Enns
1984).
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
import scipy.linalg

RATIO = 10.0  # b / a


class Weight(Protocol):
    """Weight of errors of K^ at each frequency."""

    def at(self, w: np.ndarray) -> np.ndarray:
        """|W(i w)| at the frequencies w (nw,) [rad/s]."""
        ...

    def gramian(self, A: np.ndarray, B: np.ndarray) -> np.ndarray:
        """The Gramian of the states of A and inputs B, weighted by W over all frequencies w:
        (1 / (2 pi)) int |W|^2 (i w - A)^-1 B B^T (i w - A)^-H dw."""
        ...


class Emphasis(NamedTuple):
    """W(s) = (s + b) / (s + a); ``corner`` b [rad/s], ``ratio`` b / a."""

    corner: float
    ratio: float = RATIO

    @property
    def low(self) -> float:
        """a [rad/s]."""
        return self.corner / self.ratio

    def at(self, w: np.ndarray) -> np.ndarray:
        """|W(i w)|, at least 1."""
        return np.abs((1j * w + self.corner) / (1j * w + self.low))

    def gramian(self, A: np.ndarray, B: np.ndarray) -> np.ndarray:
        """P = 1 / 2 pi int |W|^2 (i w - A)^-1 B B^T (i w - A)^-H dw: the Gramian of the states of A
        in W (s - A)^-1 B, which has one more state for each column of B."""
        n, m = B.shape
        joined = np.block([[A, (self.corner - self.low) * B], [np.zeros((m, n)), np.zeros((m, m))]])
        joined[n:, n:] -= self.low * np.eye(m)
        driven = np.vstack([B, np.eye(m)])
        return scipy.linalg.solve_continuous_lyapunov(joined, -driven @ driven.T)[:n, :n]


def emphasis_of(w: np.ndarray, target: np.ndarray) -> Emphasis:
    """Emphasis whose corner is the frequency of the largest ``target`` (nw, m, m). ``w`` (nw,)
    rises from 0; w = 0 does not count, because nothing radiates there."""
    return Emphasis(float(w[1 + np.abs(target[1:]).max(axis=(1, 2)).argmax()]))
