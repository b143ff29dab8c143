"""Two hinged barges in regular waves in the frequency domain, by numpy from the database's file.

Positions q (12,), fore and then aft, are those of the centres of gravity, per wave amplitude. The
hinge allows q = S z (7), with six motions of the aft barge and the angle of the hinge; or they obey
G q = 0 (5), with multipliers L, the forces of the hinge:

    S^T Z S z = S^T X,      [Z G^T; G 0] [q; L] = [X; 0]
    Z(w) = C + K - w^2 (M + A(w)) + i w (B(w) + D)

By Ogilvie's relation added mass follows from damping: A(w) = A_inf - 2/pi int B(s)/(w^2 - s^2) ds,
the principal value. A_inf is its mean over the lower three quarters of the band, as the memory in
the time domain has it, and so has it the power law beyond the band.
"""

from functools import cached_property
from pathlib import Path

import numpy as np
import xarray as xr

FILE = Path(__file__).parents[3] / "hydro_db" / "hinged_barges.nc"
CENTRES = np.array([22.0, 0.0, 0.0]), np.array([-22.0, 0.0, 0.0])  # of gravity, fore and aft
HINGE = np.array([0.0, 0.0, 1.5])
MOORING = np.diag([60e3, 60e3, 0.0, 0.0, 0.0, 60e6])  # of the aft barge: stiffness
MOORING_DAMPING = np.diag([120e3, 120e3, 0.0, 0.0, 0.0, 60e6])
HINGE_DAMPING = 100e6
NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)


def arm(r: np.ndarray) -> np.ndarray:
    """Matrix of r x."""
    x, y, z = r
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def carried(r: np.ndarray) -> np.ndarray:
    """Motion (6, 6) of a point at ``r`` from another that moves and turns with the same body."""
    motion = np.eye(6)
    motion[:3, 3:] = -arm(r)
    return motion


def allowed_motions() -> np.ndarray:
    """S (12, 7)."""
    fore, aft = CENTRES
    S = np.zeros((12, 7))
    S[6:, :6] = np.eye(6)
    S[:6, :6] = carried(fore - HINGE) @ carried(HINGE - aft)
    S[:6, 6] = carried(fore - HINGE) @ [0.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    return S


def constraints() -> np.ndarray:
    """G (5, 12): no gap at the hinge, no relative roll and yaw."""
    fore, aft = CENTRES
    gap = np.hstack([carried(HINGE - fore), -carried(HINGE - aft)])
    return gap[[0, 1, 2, 3, 5]]


class Barges:
    """The pair with its mooring and the damping of the hinge."""

    def __init__(self) -> None:
        with xr.open_dataset(FILE) as db:
            self.frequency = db.frequency.values
            self.heading = db.heading.values
            self.mass = db.inertia_matrix.values
            self.stiffness = db.hydrostatic_stiffness.values.copy()
            self.added_mass = db.added_mass.values
            self.damping = db.radiation_damping.values
            self.load = db.excitation.values[..., 0] + 1j * db.excitation.values[..., 1]
        self.stiffness[6:, 6:] += MOORING
        self.other_damping = np.zeros((12, 12))
        self.other_damping[6:, 6:] = MOORING_DAMPING
        bend = np.eye(12)[4] - np.eye(12)[10]
        self.other_damping += HINGE_DAMPING * np.outer(bend, bend)

    def impedance(self, row: int, added_mass: np.ndarray) -> np.ndarray:
        """Z (12, 12) at a frequency of the database."""
        w = self.frequency[row]
        damping = self.damping[row] + self.other_damping
        return self.stiffness - w**2 * (self.mass + added_mass[row]) + 1j * w * damping

    def by_coordinates(self, row: int, column: int, added_mass: np.ndarray) -> np.ndarray:
        """Motions (12,) at a frequency and heading of the database, by S."""
        S, Z = allowed_motions(), self.impedance(row, added_mass)
        return S @ np.linalg.solve(S.T @ Z @ S, S.T @ self.load[row, column])

    def by_multipliers(
        self, row: int, column: int, added_mass: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """The same motions, and the forces (5,) on fore that hold the hinge together."""
        G, Z = constraints(), self.impedance(row, added_mass)
        whole = np.block([[Z, G.T], [G, np.zeros((5, 5))]])
        found = np.linalg.solve(whole, np.append(self.load[row, column], np.zeros(5)))
        return found[:12], -found[12:]

    @cached_property
    def causal_added_mass(self) -> np.ndarray:
        """A(w) (nw, 12, 12) that belongs to B by Ogilvie's relation."""
        w = self.frequency
        A, B = (0.5 * (M + M.swapaxes(1, 2)) for M in (self.added_mass, self.damping))
        without = np.array([_ogilvie(w, B, row) for row in range(w.size)])
        return (A - without)[w <= 0.75 * w[-1]].mean(axis=0) + without


def _ogilvie(w: np.ndarray, B: np.ndarray, row: int) -> np.ndarray:
    """-2/pi int (B(s) - B(w)) / (w^2 - s^2) ds, (n, n), with B linear between the frequencies and a
    power law beyond them. B(w) adds nothing, as the principal value of its part is zero."""
    here, knots = w[row], np.append(0.0, w)
    values = np.append(np.zeros_like(B[:1]), B, axis=0)
    share = 0.5 * (NODES + 1.0)[:, None, None]
    total = np.zeros_like(B[0])
    for k, h in enumerate(np.diff(knots)):
        s = knots[k] + h * share[:, 0, 0]
        inside = (1.0 - share) * values[k] + share * values[k + 1]
        total += np.tensordot(0.5 * h * WEIGHTS / (here**2 - s**2), inside - B[row], 1)
    u, weight = np.polynomial.legendre.leggauss(60)
    u = 0.5 * (u + 1.0)  # s = w_max / u
    beyond = B[-1] * u[:, None, None] ** _decay(w, B)
    ds = 0.5 * weight * w[-1] / u**2
    total += np.tensordot(ds / (here**2 - (w[-1] / u) ** 2), beyond - B[row], 1)
    return -2.0 / np.pi * total


def _decay(w: np.ndarray, B: np.ndarray) -> np.ndarray:
    """Exponents q of B ~ w^-q from the end of the band, 1.2 to 12; couplings: at least the mean."""
    end = w >= 0.85 * w[-1]
    x = np.log(w[end] / w[end].mean())
    x -= x.mean()
    one_sign = (B[end] * B[-1] > 0.0).all(axis=0)
    slope = np.tensordot(x, np.log(np.where(one_sign, np.abs(B[end]), 1.0)), 1) / (x @ x)
    q = np.where(-slope >= 1.2, np.minimum(-slope, 12.0), 12.0)
    return np.maximum(q, 0.5 * (np.diag(q)[:, None] + np.diag(q)))
