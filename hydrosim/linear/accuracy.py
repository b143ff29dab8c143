"""The largest step that is accurate, beside the largest that is stable.

A method with stability function R makes of y' = lambda y, in steps of h, exactly the solution of

    y' = lambda_h y,   lambda_h = log R(h lambda) / h

so that Re lambda_h - Re lambda is its numerical damping and Im lambda_h - Im lambda its error of
phase, each per unit of time (van der Houwen & Sommeijer 1987; of the classical method of order 4
|lambda_h - lambda| is (w h)^4 w / 120, and (w h)^5 w / 144 of it is damping). A free vibration of
unit amplitude is then wrong by |lambda_h - lambda| t exp(Re lambda t) after a time t, and the
resonance of a damped mode by |lambda_h - lambda| / |Re lambda|; so

    error = |lambda_h - lambda| min(T, 1 / |Re lambda|)

is that of a vibration that lasts for a time T, the run or the longest contact: what a mode's own
damping makes it forget does not count. It counts in the motions as much as the mode is excited, by
waves, by the start, by impacts: of a coordinate q_i by

    2 |r_i| max |mean(l v exp(-i w t))| / |l r'|

with the right eigenvector (r, r', ...) of places and rates, the left one's part l that goes with
rates, and the velocities v of a run while contacts were as the mode wants them. The mean over four
periods of the mode leaves out what is forced at other frequencies, where the error is small.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import linalg

from hydrosim.forces.modes import MODE, OPEN, SEGMENT
from hydrosim.integrate import Tableau
from hydrosim.linear.modes import TINY, shares
from hydrosim.linear.stability import Combination, stability_function, what_moves
from hydrosim.stepping.dynamics import Model

WRONG = 2.0  # error of a vibration that is out of phase
FINER = 2.0**0.125  # ratio of steps that are looked at
FINEST = 1e-6  # of the step
SLOW = 1e-9  # rad/s: no vibration
MOVES = 0.05  # share of velocities in a mode, half in one of a body on a spring
PERIODS, FEWEST = 4.0, 5  # of a mean, and its fewest records
SEEN = 2.0  # records in that many periods: fewer do not tell a vibration from what is forced


@dataclass(frozen=True, eq=False)
class Vibration:
    """A mode that vibrates while contacts and springs are as ``modes`` (rows, 3) has them, and as
    ``contact`` says; its ``eigenvalue`` [1/s] and ``what`` moves in it. Where it is all that moves,
    velocities v (n,) mean amplitudes ``amplitude`` (n,) |``felt`` (n,) v| of the coordinates."""

    contact: str
    modes: np.ndarray
    eigenvalue: complex
    what: str
    amplitude: np.ndarray
    felt: np.ndarray

    def error(self, method: Tableau, step: float, duration: float) -> float:
        """Of the vibration, of its amplitude, in a run of this ``duration`` [s]."""
        return float(vibration_errors(method, step, duration, np.array([self.eigenvalue]))[0])

    def accurate_step(self, method: Tableau, step: float, duration: float, error: float) -> float:
        """The largest step, up to ``step`` [s], at which the error is no more than ``error``."""
        trial = step
        while self.error(method, trial, duration) > error and trial > FINEST * step:
            trial /= FINER
        return trial

    def excited(
        self, time: np.ndarray, velocity: np.ndarray, modes: np.ndarray
    ) -> tuple[np.ndarray, float]:
        """The largest amplitudes (n,) of the vibration in a run with velocities (nt, n) and
        ``modes`` (nt, rows, 3) at the records' ``time`` (nt,) [s], while it is in contact, and how
        long [s] it can have lasted."""
        touching = self._touching(modes)
        felt = np.where(touching, velocity @ self.felt, 0.0)
        omega, step = self.eigenvalue.imag, float(time[1] - time[0])
        samples = PERIODS * 2.0 * np.pi / (omega * step)
        if samples > SEEN:
            window = np.hanning(max(round(samples), FEWEST) + 2)[1:-1]
            slow = felt * np.exp(-1j * omega * time)
            felt = np.convolve(slow, window / window.sum(), mode="same")
        ends = np.flatnonzero(np.diff(np.concatenate([[0], touching, [0]])))
        longest = step * float((ends[1::2] - ends[::2]).max(initial=0))
        return self.amplitude * float(np.abs(felt).max()), longest

    def _touching(self, modes: np.ndarray) -> np.ndarray:
        """Whether (nt,) records are in contact, on the piece of the curve that this is about, or
        beside one that is; all are, if none need be."""
        closed = self.modes[:, MODE] != OPEN
        if not closed.any():
            return np.ones(len(modes), dtype=bool)
        there = modes[:, closed, SEGMENT] == self.modes[closed, SEGMENT]
        here = (there & (modes[:, closed, MODE] != OPEN)).any(axis=1)
        beside = here.copy()
        beside[1:] |= here[:-1]
        beside[:-1] |= here[1:]
        return beside


def vibration_errors(
    method: Tableau, step: float, duration: float, values: np.ndarray
) -> np.ndarray:
    """Of vibrations with eigenvalues ``values`` (m,) [1/s], over their amplitudes: see above."""
    z = step * values
    made = np.log(np.maximum(np.abs(R := stability_function(method)(z)), TINY)) + 1j * np.angle(R)
    turns = np.round((z.imag - made.imag) / (2.0 * np.pi))
    rate = np.abs(made + 2j * np.pi * turns - z) / step
    lasting = np.minimum(duration, 1.0 / np.maximum(np.abs(values.real), TINY))
    return np.asarray(np.minimum(rate * lasting, WRONG))


def vibrations(
    found: Sequence[Combination],
    method: Tableau,
    model: Model,
    names: list[str],
    duration: float,
    step: float,
    error: float,
) -> Iterator[Vibration]:
    """Modes that vibrate with more than an ``error`` at a ``step`` [s], of all ``found``
    combinations. A memory by convolution moves their eigenvalues as far as it does at first
    order, l K^(i w) r'."""

    def wrong(values: np.ndarray) -> np.ndarray:
        return (values.imag > SLOW) & (vibration_errors(method, step, duration, values) > error)

    for contact, modes, linear in found:
        if not wrong(linalg.eigvals(linear.jacobian)).any():
            continue
        values, left, right = linalg.eig(linear.jacobian, left=True, right=True)
        share, n = shares(left, right), linear.active.size
        for k in np.flatnonzero(wrong(values)):
            felt, rate = left[n : 2 * n, k].conj(), right[n : 2 * n, k]
            whole = np.vdot(left[:, k], right[:, k])
            if abs(felt @ rate) <= MOVES * abs(whole):
                continue  # hardly a motion of bodies
            memory = np.linalg.solve(linear.inertia, remembered(model, values[k].imag) @ rate)
            value = complex(values[k] - felt @ memory / whole)
            if wrong(np.array([value])).any():
                what = what_moves(linear, share[:, k], model, names)
                amplitude = 2.0 * np.abs(right[:n, k])
                yield Vibration(contact, modes, value, what, amplitude, felt / (felt @ rate))


def remembered(model: Model, omega: float) -> np.ndarray:
    """Radiation K^(i w), (n, n), of a memory by convolution: force per velocity of the free
    coordinates at ``omega`` [rad/s]."""
    kernel, size = model.convolution, len(model.added_mass)
    found = np.zeros((size, size), dtype=complex)
    turning = np.exp(-1j * omega * kernel.step * np.arange(len(kernel.K)))
    turning[[0, -1]] *= 0.5  # the trapezium rule
    found[kernel.row, kernel.column] = turning @ kernel.K
    active = model.bodies.active
    return np.asarray(kernel.step * found[np.ix_(active, active)])
