"""The largest accurate step, in addition to the largest stable one.

A method with stability function R solves, instead of y' = lambda y, in steps of h exactly

    y' = lambda_h y,   lambda_h = log R(h lambda) / h

So Re lambda_h - Re lambda is its numerical damping and Im lambda_h - Im lambda its error of phase,
each per unit of time (van der Houwen & Sommeijer 1987). For the classical method of order 4
|lambda_h - lambda| is (w h)^4 w / 120, of which (w h)^5 w / 144 is damping. After a time t the
error of a free vibration of unit amplitude is |lambda_h - lambda| t exp(Re lambda t). The error of
the resonance of a damped mode is |lambda_h - lambda| / |Re lambda|. So

    error = |lambda_h - lambda| min(T, 1 / |Re lambda|)

is the error of a vibration that lasts for a time T. Parts that the mode's own damping has removed
do not count. Errors accumulate during the vibration, each part with the amplitude of its time. So T
is the integral of the amplitude over a contact, or the run, divided by the largest amplitude. These
amplitudes exclude the numerical damping of the method.

The error matters in proportion to the excitation of the mode by waves, by the start and by impacts.
The excitation of a coordinate q_i is

    2 |r_i| max |mean(l v exp(-i w t))| / |l r'|

with the right eigenvector (r, r', ...) of positions and rates, and the part l of the left one for
rates. The velocities v are those of a run while its contacts have the mode's state, stick or slip.
The mean over four periods of the mode removes motions forced at other frequencies, where the error
is small.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from hydrosim.forces.contact.modes import OPEN
from hydrosim.integrate import IntegrationMethod
from hydrosim.linear.components import expand_to_active
from hydrosim.linear.modes import SMALLEST_FLOAT, participation_factors
from hydrosim.linear.stability import Combination, what_moves
from hydrosim.modes import MODE, SEGMENT
from hydrosim.rigid.free import slopes_at_rest
from hydrosim.stepping.dynamics import Model
from hydrosim.stepping.state_layout import StateLayout

WRONG = 2.0  # error of a vibration that is out of phase
TRIED_STEP_RATIO = 2.0**0.125  # ratio between tried steps
FINEST = 1e-6  # of the step
MIN_VIBRATION_RATE = 1e-9  # rad/s: slower modes do not vibrate
MOVES = 0.05  # share of velocities in a mode, half in one of a body on a spring
# periods of a mean, and its fewest records
PERIODS = 4.0
MIN_RECORDS_PER_MEAN = 5
MAX_EXPONENT = 100.0  # of an exponent
RECORDED_PERIODS = (
    2.0  # records in that many periods: fewer do not distinguish a vibration from forced motion
)


@dataclass(frozen=True, eq=False)
class Vibration:
    """A mode that vibrates while contacts and springs are in ``modes`` (rows, 3), described by
    ``contact``; its ``eigenvalue`` [1/s], and ``what`` moves in it. If nothing else moves,
    velocities v (n,) correspond to the amplitudes ``amplitude`` (n,) |``felt`` (n,) v| of the
    coordinates."""

    contact: str
    modes: np.ndarray
    eigenvalue: complex
    what: str
    amplitude: np.ndarray
    felt: np.ndarray

    def error(self, method: IntegrationMethod, step: float, duration: float) -> float:
        """Error of the vibration relative to its amplitude, in a run of this ``duration`` [s]."""
        return float(vibration_errors(method, step, duration, np.array([self.eigenvalue]))[0])

    def accurate_step(
        self, method: IntegrationMethod, step: float, duration: float, error: float
    ) -> float:
        """The largest step, up to ``step`` [s], with an error of at most ``error``."""
        trial = step
        while self.error(method, trial, duration) > error and trial > FINEST * step:
            trial /= TRIED_STEP_RATIO
        return trial

    def fading(self, method: IntegrationMethod, step: float) -> float:
        """Excess damping rate [1/s] of the vibration by the method."""
        R = method.stability(np.array([step * self.eigenvalue]))
        made = float(np.log(np.maximum(np.abs(R[0]), SMALLEST_FLOAT))) / step
        return max(self.eigenvalue.real - made, 0.0)

    def largest_amplitudes(
        self, time: np.ndarray, velocity: np.ndarray, modes: np.ndarray, fading: float = 0.0
    ) -> tuple[np.ndarray, float]:
        """The largest amplitudes (n,) of the vibration in a run with velocities (nt, n) and
        ``modes`` (nt, rows, 3) at the records' ``time`` (nt,) [s], while contacts are in its modes.

        Also returns the duration [s] for which a vibration of that amplitude would have the error
        that it has in one contact. The method damps it at the rate ``fading`` [1/s].
        """
        touching, alike = self._records_in_mode(modes)
        felt = np.where(alike, velocity @ self.felt, 0.0)
        omega = self.eigenvalue.imag
        step = float(time[1] - time[0])
        samples = PERIODS * 2.0 * np.pi / (omega * step)
        if samples > RECORDED_PERIODS:
            window = np.hanning(max(round(samples), MIN_RECORDS_PER_MEAN) + 2)[1:-1]
            slow = felt * np.exp(-1j * omega * time)
            first = (window.size - 1) // 2
            felt = np.convolve(slow, window / window.sum())[first:][: time.size]
        size = np.where(touching, np.abs(felt), 0.0)
        largest = float(size.max())
        size = np.minimum(
            size * np.exp(np.minimum(fading * (time - time[0]), MAX_EXPONENT)), largest
        )
        ends = np.flatnonzero(np.diff(np.concatenate([[0], touching, [0]])))
        sums = np.add.reduceat(np.append(size, 0.0), ends)[::2] if ends.size else np.zeros(1)
        lasting = step * float(sums.max()) / largest if largest > 0.0 else 0.0
        return self.amplitude * largest, lasting

    def _records_in_mode(self, modes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Two arrays (nt,): records in contact on the mode's piece of the curve, and records that
        stick or slip as in the mode. Records beside such a record count, too. All are true if the
        mode has no contact."""
        closed = self.modes[:, MODE] != OPEN
        if not closed.any():
            return np.ones(len(modes), dtype=bool), np.ones(len(modes), dtype=bool)
        there = modes[:, closed, SEGMENT] == self.modes[closed, SEGMENT]
        there &= modes[:, closed, MODE] != OPEN
        alike = there & (modes[:, closed, MODE] == self.modes[closed, MODE])
        return _widen(there.any(axis=1)), _widen(alike.any(axis=1))


def _widen(here: np.ndarray) -> np.ndarray:
    """True also next to true entries (nt,)."""
    beside = here.copy()
    beside[1:] |= here[:-1]
    beside[:-1] |= here[1:]
    return beside


def vibration_errors(
    method: IntegrationMethod, step: float, duration: float, values: np.ndarray
) -> np.ndarray:
    """Errors of vibrations with eigenvalues ``values`` (m,) [1/s], relative to their amplitudes, as
    above."""
    z = step * values
    made = np.log(np.maximum(np.abs(R := method.stability(z)), SMALLEST_FLOAT)) + 1j * np.angle(R)
    turns = np.round((z.imag - made.imag) / (2.0 * np.pi))
    rate = np.abs(made + 2j * np.pi * turns - z) / step
    lasting = np.minimum(duration, 1.0 / np.maximum(np.abs(values.real), SMALLEST_FLOAT))
    return np.asarray(np.minimum(rate * lasting, WRONG))


def vibrations(
    found: Sequence[Combination],
    method: IntegrationMethod,
    model: Model,
    layout: StateLayout,
    duration: float,
    step: float,
    error: float,
) -> Iterator[Vibration]:
    """Modes that vibrate with more than an ``error`` at a ``step`` [s], from all ``found``
    combinations. A memory by convolution shifts their eigenvalues by its effect at first order, l
    K^(i w) r'."""

    def wrong(values: np.ndarray) -> np.ndarray:
        return (values.imag > MIN_VIBRATION_RATE) & (
            vibration_errors(method, step, duration, values) > error
        )

    active = model.bodies.active
    for combination, (part, spectrum) in [(x, part) for x in found for part in x.components]:
        if not wrong(spectrum.values).any():
            continue
        values, left, right = spectrum.vectors()
        share = participation_factors(left, right)
        n = part.active.size
        own = np.searchsorted(active, part.active)
        for k in np.flatnonzero(wrong(values)):
            felt = left[n : 2 * n, k].conj()
            rate = right[n : 2 * n, k]
            whole = np.vdot(left[:, k], right[:, k])
            if abs(felt @ rate) <= MOVES * abs(whole):
                continue  # hardly a motion of bodies
            K = memory_response(model, values[k].imag)[np.ix_(own, own)]
            memory = np.linalg.solve(part.inertia, K @ rate)
            value = complex(values[k] - felt @ memory / whole)
            if wrong(np.array([value])).any():
                what = what_moves(part, share[:, k], layout)
                amplitude = expand_to_active(2.0 * np.abs(right[:n, k]), part.active, active)
                sensed = expand_to_active(felt / (felt @ rate), part.active, active)
                at = combination.contact, combination.modes
                yield Vibration(*at, value, what, amplitude, sensed)


def memory_response(model: Model, omega: float) -> np.ndarray:
    """Radiation K^(i w), (n, n), of a memory by convolution: force per velocity of the free
    coordinates at ``omega`` [rad/s]."""
    kernel = model.convolution
    size = len(model.added_mass)
    found = np.zeros((size, size), dtype=complex)
    turning = np.exp(-1j * omega * kernel.step * np.arange(len(kernel.K)))
    turning[[0, -1]] *= 0.5  # the trapezoidal rule
    found[kernel.row, kernel.column] = turning @ kernel.K
    S = slopes_at_rest(model.bodies)
    return np.asarray(kernel.step * (S.T @ found @ S))
