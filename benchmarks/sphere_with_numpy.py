"""The sphere as one writes it with numpy and scipy alone: `solve_ivp`, or a loop by hand.

Small angles. The radiated waves are a dense state-space model, which has hydrosim's poles and
residues, or a convolution of first order: velocities kept every 0.1 s, one product with the
retardation functions per step. Wave loads are straight lines in a table that is fine enough for it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import interp1d
from scipy.linalg import block_diag

from benchmarks.limit import sphere_of, wave_loads
from benchmarks.scenes import Several
from hydrosim import compile_scene

TABLE = 0.0025  # s, of the wave loads
Rates = Callable[[float, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Equation:
    """Matrices (6, 6), of the radiation A (s, s), B (s, 6), C (6, s), and the table of wave loads
    (rows, 6), every `TABLE` [s], which is read by `np.interp`, or ``by_hand``, which is faster.

    The ``kernel`` (lags, 6, 6), every ``lag`` [s], is for a convolution with steps as long.
    """

    inverse: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    waves: np.ndarray
    kernel: np.ndarray
    lag: float
    by_hand: bool = False

    def load(self, t: float) -> np.ndarray:
        """Wave loads (6,)."""
        if not self.by_hand:
            return np.array([np.interp(t, self.times, column) for column in self.columns])
        place = t / TABLE
        row = min(int(place), len(self.waves) - 2)
        return self.waves[row] + (place - row) * (self.waves[row + 1] - self.waves[row])

    @cached_property
    def times(self) -> np.ndarray:
        """Of the table [s]."""
        return TABLE * np.arange(len(self.waves))

    @cached_property
    def columns(self) -> np.ndarray:
        """The table by DOF, (6, rows)."""
        return self.waves.T.copy()

    @property
    def sizes(self) -> np.ndarray:
        """What 1 m, m/s, rad and rad/s are worth in all states, for absolute tolerances."""
        return np.concatenate([np.ones(12), np.abs(self.B).max(axis=1) / -np.diag(self.A)])

    def with_states(self, t: float, y: np.ndarray) -> np.ndarray:
        """y' of y = (displacements, velocities, radiation states)."""
        q, v, x = y[:6], y[6:12], y[12:]
        force = self.load(t) - self.stiffness @ q - self.damping @ v - self.C @ x
        return np.concatenate((v, self.inverse @ force, self.A @ x + self.B @ v))


def equation(run: Several) -> Equation:
    """The matrices of a scene, out of the compiled one, and a finer table of its waves."""
    scene, (wet,) = run.scene, run.compiled.wet
    constants = sphere_of(run)
    fine = compile_scene(replace(scene, solver=replace(scene.solver, step=2 * TABLE))).model
    B = [np.eye(6)[:, fit.dofs] @ fit.B.T for fit in run.fits]
    C = [np.eye(6)[:, fit.dofs] @ fit.C for fit in run.fits]
    lags = np.arange(0.0, wet.memory.time[-1], scene.solver.step)
    return Equation(
        inverse=constants.inverse,
        stiffness=constants.stiffness,
        damping=constants.damping,
        A=block_diag(np.zeros((0, 0)), *(fit.matrix for fit in run.fits)),
        B=np.hstack([np.zeros((6, 0)), *B]).T.copy(),
        C=np.hstack([np.zeros((6, 0)), *C]),
        waves=wave_loads(fine, TABLE),
        kernel=interp1d(wet.memory.time, wet.memory.kernel, axis=0)(lags),
        lag=scene.solver.step,
    )


def by_solve_ivp(
    rates: Rates, size: int, times: np.ndarray, method: str = "RK45", **settings: Any
) -> np.ndarray:
    """Displacements and angles (nt, 6) at ``times`` [s] from 0 on, from rest."""
    span = 0.0, float(times[-1])
    return solve_ivp(rates, span, np.zeros(size), method, times, **settings).y[:6].T


def by_rk4(rates: Rates, size: int, steps: int, h: float, every: int) -> np.ndarray:
    """Displacements and angles (steps / every + 1, 6) of the classical Runge-Kutta method."""
    y, out = np.zeros(size), np.zeros((steps // every + 1, 6))
    for n in range(steps):
        t = n * h
        a = rates(t, y)
        b = rates(t + h / 2, y + h / 2 * a)
        c = rates(t + h / 2, y + h / 2 * b)
        d = rates(t + h, y + h * c)
        y = y + h / 6 * (a + 2 * b + 2 * c + d)
        if (n + 1) % every == 0:
            out[(n + 1) // every] = y[:6]
    return out


class Convolution:
    """The equation with a convolution: velocities every ``lag`` [s], the newest last."""

    def __init__(self, p: Equation) -> None:
        self.p, self.force, self.next = p, np.zeros(6), 0.0
        self.velocity = np.zeros((len(p.kernel), 6))
        weights = np.full(len(p.kernel), p.lag)
        weights[0] /= 2
        self.kernel = (weights[:, None, None] * p.kernel)[::-1].transpose(1, 0, 2).reshape(6, -1)

    def rates(self, t: float, y: np.ndarray) -> np.ndarray:
        """y' of y = (displacements, velocities); the first call past a lag is remembered."""
        p, q, v = self.p, y[:6], y[6:]
        if t > self.next - 1e-9:
            self.velocity[:-1] = self.velocity[1:]
            self.velocity[-1] = v
            self.force = self.kernel @ self.velocity.ravel()
            self.next += p.lag
        force = p.load(t) - p.stiffness @ q - p.damping @ v - self.force
        return np.concatenate((v, p.inverse @ force))
