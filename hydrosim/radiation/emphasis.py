"""What a frequency counts in a fit: low ones more, because slow motions feel small forces.

A relative change of motion is a change of K^ over the impedance, which is about i w (M + A): the
same error of K^ matters the more, the slower the motion is. So errors of K^ count times |W(i w)|,
W(s) = (s + b) / (s + a), 1 above b and `RATIO` below a. That W is a filter keeps balanced
truncation to matrix equations: frequency-weighted Gramians (Enns 1984).
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
import scipy.linalg

RATIO = 10.0  # b / a


class Weight(Protocol):
    """What errors of K^ count at each frequency."""

    def at(self, w: np.ndarray) -> np.ndarray:
        """|W(i w)| at the frequencies w (nw,) [rad/s]."""
        ...

    def gramian(self, A: np.ndarray, B: np.ndarray) -> np.ndarray:
        """1 / 2 pi int |W|^2 (i w - A)^-1 B B^T (i w - A)^-H dw."""
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
        """P = 1 / 2 pi int |W|^2 (i w - A)^-1 B B^T (i w - A)^-H dw: that of the states of A in
        W (s - A)^-1 B, which has a state more for each column of B."""
        n, m = B.shape
        joined = np.block([[A, (self.corner - self.low) * B], [np.zeros((m, n)), np.zeros((m, m))]])
        joined[n:, n:] -= self.low * np.eye(m)
        driven = np.vstack([B, np.eye(m)])
        return scipy.linalg.solve_continuous_lyapunov(joined, -driven @ driven.T)[:n, :n]


def emphasis_of(w: np.ndarray, target: np.ndarray) -> Emphasis:
    """With its corner where the ``target`` (nw, m, m) is largest, at ``w`` (nw,) that rise from 0,
    which does not count: nothing radiates there."""
    return Emphasis(float(w[1 + np.abs(target[1:]).max(axis=(1, 2)).argmax()]))
