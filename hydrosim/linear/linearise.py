"""The one linearisation of a scene: natural periods, responses to harmonic loads.

About a state y0 and with the contact modes held, the mechanical, radiation and stretch states z
obey z' = J z + G F, with J the derivative of the right hand side by central differences (exact but
for rounding where the scene is linear) and G the inverse inertia in the rows of the velocities.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from hydrosim.dofs import DOFS
from hydrosim.rigid import acceleration_map, mass_matrix, place_bodies
from hydrosim.stepping.dynamics import Model, dynamic_states, jacobian, new_work
from hydrosim.stepping.state import State

STEP = 1e-4  # of the central differences: m, rad and their rates
SLOW = 1e-5  # rad/s: as good as static


@dataclass(frozen=True)
class Linear:
    """``jacobian`` (m, m) of the ``states`` (m,) of y, the first 2 n of which are the n free
    coordinates ``active`` (among 6 nb) and their rates; ``inertia`` (n, n), added mass included."""

    jacobian: np.ndarray
    states: np.ndarray
    active: np.ndarray
    inertia: np.ndarray

    def dynamic_stiffness(self, omega: float) -> np.ndarray:
        """D(w) = K - w^2 (M + A(w)) + i w B(w), (n, n): loads Re(D q exp(i w t)) keep up the
        harmonic motion Re(q exp(i w t)). All other states are eliminated."""
        n, s = self.active.size, 1j * omega
        motion = np.vstack([np.eye(n), s * np.eye(n)])
        J = self.jacobian[n:]
        inner = s * np.eye(len(J) - n) - J[n:, 2 * n :]
        others = linalg.solve(inner, J[n:, : 2 * n] @ motion)
        acceleration = J[:n, : 2 * n] @ motion + J[:n, 2 * n :] @ others
        return self.inertia @ (s * s * np.eye(n) - acceleration)

    def response(self, omega: float, load: np.ndarray) -> np.ndarray:
        """Complex amplitudes (n,) of the coordinates under loads Re(load exp(i omega t)), (n,)."""
        return linalg.solve(self.dynamic_stiffness(omega), load)


@dataclass(frozen=True)
class NaturalMode:
    """One mode of motion: the coordinate (among 6 nb) that takes part most, the eigenvalue of its
    free decay [1/s], and its ``natural_period`` [s], 2 pi / w with det Re D(w) = 0: the period at
    which inertia with the added mass A(w) balances stiffness. Infinite without stiffness."""

    coordinate: int
    eigenvalue: complex
    natural_period: float

    @property
    def dof(self) -> str:
        """Name of the coordinate."""
        return DOFS[self.coordinate % 6]

    @property
    def damped_period(self) -> float:
        """Period of the free decay, 2 pi / imaginary part [s]; infinite without oscillation."""
        rate = abs(self.eigenvalue.imag)
        return 2 * np.pi / rate if rate > 1e-9 else np.inf

    @property
    def damping_ratio(self) -> float:
        """Fraction of critical damping."""
        size = abs(self.eigenvalue)
        return -self.eigenvalue.real / size if size > 1e-9 else 0.0


def linearise(
    model: Model,
    state: State,
    modes: np.ndarray | None = None,
    time: float = 0.0,
    step: float = STEP,
) -> Linear:
    """Linearise about ``state`` with its contact modes, or with ``modes`` (nf + ns, 3).

    ``step`` is that of the differences: what is linear is found to rounding by one of 1.
    The memory of a radiation by convolution is left out: use the state-space model for it.
    """
    work, held = new_work(model), state.modes if modes is None else modes
    states, n = dynamic_states(model), model.bodies.active.size
    J, scratch = np.zeros((states.size, states.size)), np.zeros((3, model.size))
    jacobian(time, state.y, held, state.history, model, work, states, step, scratch, J)
    inertia = np.zeros((n, n))
    place_bodies(state.y[:n], state.y[n : 2 * n], model.bodies, work.motion)
    mass_matrix(model.bodies, work.motion.rotation, model.added_mass, work.mass)
    acceleration_map(model.bodies, work.motion, work.mass, inertia)
    return Linear(J, states, model.bodies.active, inertia)


def natural_modes(linear: Linear) -> list[NaturalMode]:
    """The mode of each free coordinate, by `participation`."""
    from scipy.optimize import linear_sum_assignment  # slow to load, and no run needs it

    values, share = participation(linear)
    upper, n = np.flatnonzero(values.imag >= 0.0), linear.active.size
    per_coordinate = share[:n, upper] + share[n : 2 * n, upper]
    rows, columns = linear_sum_assignment(-per_coordinate)
    return [
        NaturalMode(int(linear.active[i]), complex(value), _natural_period(linear, i, value))
        for i, value in zip(rows, values[upper[columns]], strict=True)
    ]


def participation(linear: Linear) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues (m,) [1/s], and the share (m, m) that each state (row) has in the mode of each
    (column): participation factors, the products of the left and right eigenvectors' entries, which
    do not depend on units (Perez-Arriaga et al. 1982)."""
    values, left, right = linalg.eig(linear.jacobian, left=True, right=True)
    share = np.abs(left.conj() * right)
    return values, share / np.maximum(share.sum(axis=0), np.finfo(float).tiny)


def _natural_period(linear: Linear, i: int, eigenvalue: complex) -> float:
    """Fixed point of w^2 = the eigenvalue of (K, M + A(w)) whose mode has most of coordinate i."""
    stiffness = linear.dynamic_stiffness(SLOW).real
    omega = abs(eigenvalue)
    for _ in range(100):
        if omega < SLOW:
            return np.inf
        mass = (stiffness - linear.dynamic_stiffness(omega).real) / (omega**2 - SLOW**2)
        squares, modes = linalg.eig(stiffness, mass)
        energy = np.abs(modes * (mass @ modes))[i] / np.abs(modes * (mass @ modes)).sum(axis=0)
        last, omega = omega, float(np.sqrt(max(squares[np.argmax(energy)].real, 0.0)))
        if abs(omega - last) <= 1e-10 * last:
            break
    return 2 * np.pi / omega if omega > SLOW else np.inf
