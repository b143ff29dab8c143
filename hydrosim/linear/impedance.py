"""Effect of a change of a radiation force on motions, without a run: Z v = F for harmonic motions.

Z(s) = s (M + A_inf) + D + C / s + K^(s), s = i w, all other forces linearised at the start. An
additional force dZ v changes v by -Z^-1 dZ v. Coordinates are scaled by the roots of their
inertias, so that metres and radians compare. The spectral norm of Z^-1 dZ is then the largest
possible change at a frequency, relative to the motion there: at resonance, dZ over the damping.

In a run of T s no resonance is sharper than 1/T, and s = 1/T + i w. Only motions that constraints
allow count.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from hydrosim.linear.linearise import Linear


class Change(NamedTuple):
    """The largest relative change of motion, its frequency ``w`` [rad/s], and the coordinate (among
    6 nb) that changes most."""

    size: float
    w: float
    coordinate: int


@dataclass(frozen=True, eq=False)
class Admittance:
    """The ``velocities`` (nw, p, k) per force on the k coordinates of a database. They belong to
    the component ``active`` (n,), along the ``motions`` (n, p) that constraints allow, orthonormal
    in scaled coordinates. ``units`` (k, r) are velocities of the k coordinates that span all
    effects of a unit of these motions, up to a rotation, which changes no norm."""

    active: np.ndarray
    motions: np.ndarray
    units: np.ndarray
    velocities: np.ndarray

    def largest_change(self, w: np.ndarray, dZ: np.ndarray) -> Change:
        """Largest relative change of the motions, over all frequencies ``w`` (nw,) [rad/s], if
        ``dZ`` (nw, k, k) is added to the impedance [N s/m, N m s/rad]. To first order in ``dZ``."""
        relative = self.velocities @ dZ @ self.units
        if not relative.size:  # none of these coordinates can move
            return Change(0.0, float(w[0]), int(self.active[0]))
        size = np.linalg.norm(relative, 2, axis=(1, 2))
        k = int(size.argmax())
        most = self.motions @ np.linalg.svd(relative[k])[0][:, 0]
        return Change(float(size[k]), float(w[k]), int(self.active[np.abs(most).argmax()]))


def find_admittances(
    s: np.ndarray,
    slopes: Sequence[np.ndarray],
    memories: Sequence[np.ndarray],
    linear: Linear,
) -> list[Admittance]:
    """Z^-1 for the DOFs of each database at ``s`` (nw,) [1/s], which move by its ``slopes`` (k, n)
    with the free coordinates. ``memories`` (nw, k, k) are K^ of the databases; ``linear`` has
    positions and rates, without memory. Z contains forces of constraints, but they do no work on
    allowed motions. Each component is solved by itself."""
    active = linear.active
    coupled = linear.coupled_states
    for slope in slopes:
        at = np.flatnonzero(slope.any(axis=0))
        coupled[at[:, None], at] = True
    admittances: dict[int, Admittance] = {}
    for part in linear.split(coupled):
        here = np.searchsorted(active, part.active)
        felt = [slope[:, here] for slope in slopes]
        indices = [k for k, is_felt in enumerate(felt) if is_felt.any()]
        solved = _admittances(s, [felt[k] for k in indices], [memories[k] for k in indices], part)
        admittances.update(zip(indices, solved, strict=True))
    return [admittances[k] for k in range(len(slopes))]


def _admittances(
    s: np.ndarray, slopes: Sequence[np.ndarray], memories: Sequence[np.ndarray], part: Linear
) -> Iterator[Admittance]:
    """Admittances of the databases of one component."""
    n = part.active.size
    N = part.freedom.basis
    felt = [slope @ N for slope in slopes]
    MJ = part.inertia @ part.jacobian[n:]
    s = s[:, None, None]
    Z = s * (N.T @ part.inertia @ N) - N.T @ MJ[:, n:] @ N - N.T @ MJ[:, :n] @ N / s
    for S, memory in zip(felt, memories, strict=True):
        moved = np.flatnonzero(S.any(axis=0))  # of a chain of bodies, few
        own_slopes = S[:, moved]
        Z[:, moved[:, None], moved] += own_slopes.T @ memory @ own_slopes
    velocities = np.linalg.inv(Z)
    motions = np.sqrt(np.diag(part.inertia))[:, None] * N
    for S in felt:
        moved = np.flatnonzero(S.any(axis=0))
        units = np.asarray(np.linalg.qr(S.T, mode="r"))
        yield Admittance(part.active, motions, units.T, velocities[:, :, moved] @ S[:, moved].T)


def at_frequencies(w: np.ndarray, nodes: np.ndarray, values: np.ndarray) -> np.ndarray:
    """``values`` (nk, n, n) at the frequencies ``w`` (nw,): linear between the ``nodes`` (nk,),
    constant beyond."""
    k = np.clip(np.searchsorted(nodes, w), 1, nodes.size - 1)
    x = np.clip((w - nodes[k - 1]) / (nodes[k] - nodes[k - 1]), 0.0, 1.0)[:, None, None]
    return np.asarray((1.0 - x) * values[k - 1] + x * values[k])
