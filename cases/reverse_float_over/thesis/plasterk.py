"""The one-dimensional model of Plasterk (2017, chapter 5), written independently of hydrosim.

A mass u1 on its mooring K1, C1 is pushed by waves, F(t). Behind a spring K2 with damper C2 is a
contact node u2 without mass, which a normal force N(t) presses on the topside (v = u'):

    m v1' = F - K1 u1 - C1 v1 - K2 (u1 - u2) - C2 (v1 - v2)
    T = K2 (u1 - u2) + C2 v1                     traction of a node at rest
    open   v2 = T / C2                           while N < 0 (the node follows the mass)
    stick  v2 = 0                                while |T| < mu_static N
    slip   v2 = (T -+ mu_kinetic N) / (C2 + C3)  while +-T > mu_kinetic N

F and N are cubic splines through recorded samples (`scipy.interpolate.CubicSpline`, not-a-knot, as
`hydrosim.elements.signal` documents). Between two samples they and their three derivatives may be
counted among the unknowns z. Each mode is then z' = A z with a constant A, whose solution is
exp(A t) z (`scipy.linalg.expm`): there is no time step and no error but that of rounding. A
condition that fails and holds again between two looks, 1 ms apart, would not be seen.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import accumulate

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import expm

OPEN, STICK, FORWARD, BACKWARD = "open", "stick", "slip towards +x", "slip towards -x"
FOLLOWING = {  # the mode after each of the conditions below has failed
    STICK: (OPEN, FORWARD, BACKWARD),
    FORWARD: (OPEN, STICK),
    BACKWARD: (OPEN, STICK),
}
U1, V1, U2, F, N = np.eye(11)[[0, 1, 2, 3, 7]]  # unknowns, as rows that pick them from z
DERIVATIVES = [3, 4, 5, 7, 8, 9]  # each of these unknowns has the next one as its rate
LOOKS = 512  # times between two samples at which conditions are looked at, and at least
LEAST = 4  # in any stretch of time
HALVINGS = 36  # of the time between two samples: the end of a mode is found to 1e-11 s


@dataclass(frozen=True)
class Model:
    """Coefficients in SI units: ``mass`` with added mass, mooring, contact, friction."""

    mass: float
    K1: float
    C1: float
    K2: float
    C2: float
    C3: float
    static: float
    kinetic: float

    def traction(self) -> np.ndarray:
        """T as a row."""
        return self.K2 * (U1 - U2) + self.C2 * V1

    def node_velocity(self, mode: str) -> np.ndarray:
        """v2 as a row."""
        T, damping = self.traction(), self.C2 + self.C3
        return {
            OPEN: T / self.C2,
            STICK: 0.0 * T,
            FORWARD: (T - self.kinetic * N) / damping,
            BACKWARD: (T + self.kinetic * N) / damping,
        }[mode]

    def rates(self, mode: str) -> np.ndarray:
        """A."""
        A, v2 = np.zeros((11, 11)), self.node_velocity(mode)
        contact = self.K2 * (U1 - U2) + self.C2 * (V1 - v2)
        A[0] = V1
        A[1] = (F - self.K1 * U1 - self.C1 * V1 - contact) / self.mass
        A[2] = v2
        A[DERIVATIVES] = np.eye(11)[[i + 1 for i in DERIVATIVES]]
        return A

    def conditions(self, mode: str) -> np.ndarray:
        """Rows that are positive as long as the mode lasts."""
        T, held, slipping = self.traction(), self.static * N, self.kinetic * N
        return {
            OPEN: np.array([-N]),
            STICK: np.array([N, held - T, held + T]),
            FORWARD: np.array([N, T - slipping]),
            BACKWARD: np.array([N, -T - slipping]),
        }[mode]

    def next_mode(self, mode: str, z: np.ndarray) -> str:
        """The mode that follows at z, where a condition has just failed."""
        if mode == OPEN:  # N begins at zero and cannot hold the traction that there is
            return FORWARD if self.traction() @ z > 0.0 else BACKWARD
        failed = int((self.conditions(mode) @ z).argmin())
        return FOLLOWING[mode][failed]


def solve(
    model: Model, time: np.ndarray, force: np.ndarray, normal: np.ndarray
) -> tuple[np.ndarray, list[str]]:
    """u1, v1, u2 (n, 3) and the mode (n,) at evenly spaced ``time`` (n,), from rest and open, under
    ``force`` F and ``normal`` N (n,) [N]."""
    loads = np.vstack([_derivatives(time, force), _derivatives(time, normal)])
    stretches = _Stretches(model, float(time[1] - time[0]))
    z, mode = np.zeros(11), OPEN
    states, modes = [z[:3]], [mode]
    for load in loads.T:
        z, mode = stretches.pass_sample(np.concatenate([z[:3], load]), mode)
        states.append(z[:3])
        modes.append(mode)
    return np.array(states), modes


class _Stretches:
    """Exact solutions over the time between two samples, and over its halves, quarters, ..."""

    def __init__(self, model: Model, spacing: float) -> None:
        self.model, self.spacing = model, spacing
        self.known: dict[tuple[str, int], tuple[np.ndarray, np.ndarray]] = {}

    def pass_sample(self, z: np.ndarray, mode: str) -> tuple[np.ndarray, str]:
        """z and the mode at the next sample. Where a condition fails, the stretch is halved until
        it is as short as it may be; then the mode changes."""
        passed, halved = 0, 0  # passed: part of the spacing, in units of its finest stretch
        while passed < 2**HALVINGS:
            advance, conditions = self.solution(mode, halved)
            holds = (conditions @ z).min() > 0.0
            if not holds and halved < HALVINGS:
                halved += 1
                continue
            z = advance @ z
            passed += 2 ** (HALVINGS - halved)
            if not holds:
                mode = self.model.next_mode(mode, z)
            while passed % 2 ** (HALVINGS - halved + 1) == 0 and halved > 0:
                halved -= 1
        return z, mode

    def solution(self, mode: str, halved: int) -> tuple[np.ndarray, np.ndarray]:
        """exp(A t) over a stretch, and the conditions at all looks until its end, as rows."""
        if (mode, halved) not in self.known:
            count = max(LOOKS >> halved, LEAST)
            short = expm(self.model.rates(mode) * self.spacing / 2**halved / count)
            looks = list(accumulate([short] * count, np.matmul))
            conditions = self.model.conditions(mode)
            self.known[mode, halved] = looks[-1], np.vstack([conditions @ look for look in looks])
        return self.known[mode, halved]


def _derivatives(time: np.ndarray, value: np.ndarray) -> np.ndarray:
    """The spline and its three derivatives (4, n - 1) where its pieces begin."""
    spline = CubicSpline(time, value)
    return np.array([spline(time[:-1], order) for order in range(4)])
