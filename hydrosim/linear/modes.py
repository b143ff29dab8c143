"""Natural modes of a linearised scene, and the effect of a change of a radiation force on motions.

A natural mode is a motion in which stiffness balances inertia: det(K - w^2 (M + A(w))) = 0. Its
free decay is the eigenvalue of J in which it has the largest participation factor, in the
coordinates of the natural modes. So modes of two bodies, or close to modes of the memory, are not
confused.

A mode without stiffness is free: it has no period, and drifts. With constraints, K, M and shapes
belong to the allowed motions.

Effect of a change of a radiation force, without a run: Z v = F for harmonic motions.

Z(s) = s (M + A_inf) + D + C / s + K^(s), s = i w, all other forces linearised at the start. An
additional force dZ v changes v by -Z^-1 dZ v. Coordinates are scaled by the roots of their
inertias, so that metres and radians compare. The spectral norm of Z^-1 dZ is then the largest
possible change at a frequency, relative to the motion there: at resonance, dZ over the damping.

In a run of T s no resonance is sharper than 1/T, and s = 1/T + i w. Only motions that constraints
allow count.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from scipy import linalg

from hydrosim.dofs import DOFS
from hydrosim.errors import InputError
from hydrosim.linear.linearise import Freedom, Linear, expand_to_active


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


def interpolate_frequencies(w: np.ndarray, nodes: np.ndarray, values: np.ndarray) -> np.ndarray:
    """``values`` (nk, n, n) at the frequencies ``w`` (nw,): linear between the ``nodes`` (nk,),
    constant beyond."""
    k = np.clip(np.searchsorted(nodes, w), 1, nodes.size - 1)
    x = np.clip((w - nodes[k - 1]) / (nodes[k] - nodes[k - 1]), 0.0, 1.0)[:, None, None]
    return np.asarray((1.0 - x) * values[k - 1] + x * values[k])


STATIC = 1e-5  # rad/s: slower modes count as static
# rad/s; relative to the largest stiffness over inertia: below them there is no stiffness
MIN_STIFFNESS_FREQUENCY = 1e-3
MIN_STIFFNESS_RATIO = 1e-9
# iterations of the frequencies of natural modes; their relative change
MAX_MODE_ITERATIONS = 200
FREQUENCY_RTOL = 1e-12
SMALLEST_FLOAT = np.finfo(float).tiny
MIN_OSCILLATION_FREQUENCY = 1e-9  # rad/s: slower modes do not oscillate
EQUAL_MODE_RTOL = 1e-6  # of w^2: the shapes of modes this close come from one eigenvalue problem

Stiffness = Callable[[np.ndarray], np.ndarray]
"""D(w), (nw, n, n), at frequencies (nw,) [rad/s]."""


class ModeKind(StrEnum):
    """Behaviour of a mode that is released."""

    OSCILLATING = "oscillating"
    OVERDAMPED = "overdamped"
    FREE = "free"
    UNSTABLE = "unstable"


@dataclass(frozen=True, eq=False)
class NaturalMode:
    """One mode of motion.

    ``coordinate`` (among `Bodies.active`) gives its name; each is used once. ``eigenvalue`` [1/s]
    is that of its free decay (0 for a free mode). ``natural_period`` [s] is 2 pi / w with
    det Re D(w) = 0: the period at which inertia with the added mass A(w) balances stiffness,
    infinite without stiffness.
    ``shape`` (n,) is the undamped motion of the free coordinates, 1 where its energy is largest.
    ``share`` (n,) is the kinetic energy of each as a fraction.
    """

    coordinate: int
    eigenvalue: complex
    natural_period: float
    shape: np.ndarray
    share: np.ndarray

    @property
    def dof(self) -> str:
        """Name of the degree of freedom of a body that names it."""
        return DOFS[self.coordinate % 6]

    @property
    def kind(self) -> ModeKind:
        """Oscillation, or another kind of motion."""
        if not np.isfinite(self.natural_period) and self.eigenvalue == 0.0:
            return ModeKind.FREE
        if self.eigenvalue.real > MIN_OSCILLATION_FREQUENCY:
            return ModeKind.UNSTABLE
        return (
            ModeKind.OSCILLATING
            if abs(self.eigenvalue.imag) > MIN_OSCILLATION_FREQUENCY
            else ModeKind.OVERDAMPED
        )

    @property
    def damped_period(self) -> float:
        """Period of the free decay, 2 pi / imaginary part [s]; infinite without oscillation."""
        rate = abs(self.eigenvalue.imag)
        return 2 * np.pi / rate if rate > MIN_OSCILLATION_FREQUENCY else np.inf

    @property
    def damping_ratio(self) -> float:
        """Fraction of critical damping; 0 for a free mode."""
        size = abs(self.eigenvalue)
        return -self.eigenvalue.real / size if size > MIN_OSCILLATION_FREQUENCY else 0.0


def natural_modes(linear: Linear) -> list[NaturalMode]:
    """The modes, in number the free coordinates minus constraints, in the order of the coordinates
    that give their names."""
    return _modes_of_components(linear, _decaying_modes)


def natural_periods(linear: Linear) -> dict[int, float]:
    """The natural periods [s] of `natural_modes`, without their decays, by the coordinate (among 6
    nb) that names each mode."""
    modes = _modes_of_components(linear, _undamped_modes)
    return {mode.coordinate: mode.natural_period for mode in modes}


def _modes_of_components(
    linear: Linear, find: Callable[[Linear], list[NaturalMode]]
) -> list[NaturalMode]:
    """The modes that ``find`` finds for each component, with shapes of all coordinates, in the
    order of the coordinates that name them."""
    modes = []
    for part in linear.split(linear.coupled_states):
        for mode in find(part) if part.freedom.basis.shape[1] else []:  # unless all is held
            shape = expand_to_active(mode.shape, part.active, linear.active)
            share = expand_to_active(mode.share, part.active, linear.active)
            modes.append(replace(mode, shape=shape, share=share))
    return sorted(modes, key=lambda mode: mode.coordinate)


def _undamped_modes(linear: Linear) -> list[NaturalMode]:
    """The modes of one component, without their decays."""
    squares, shapes = _undamped_shapes(linear.dynamic_stiffness, linear)
    return _name_modes(squares, shapes, np.zeros(squares.size, dtype=complex), linear)


def _decaying_modes(linear: Linear) -> list[NaturalMode]:
    """The modes of one component."""
    squares, shapes = _undamped_shapes(linear.dynamic_stiffness, linear)
    values, share = modal_participation(linear, shapes)
    # constant states are no decay: a position without stiffness, the position of a node
    moving = np.flatnonzero((values.imag >= 0.0) & _has_stiffness(np.abs(values) ** 2))
    bound = _has_stiffness(squares)
    decays = np.zeros(squares.size, dtype=complex)
    decays[bound] = values[moving[_match_rows(share[bound][:, moving])[1]]]
    return _name_modes(squares, shapes, decays, linear)


def modes_of_stiffness(stiffness: Stiffness, linear: Linear) -> list[NaturalMode]:
    """`natural_modes` from D(w) alone, for a radiation that is known at frequencies only. Free
    decays use added mass and damping at the frequency of their oscillation."""
    squares, shapes = _undamped_shapes(stiffness, linear)
    decays = np.zeros(squares.size, dtype=complex)
    allowed = _constrained_stiffness(stiffness, linear.freedom)
    parts = linear.freedom.project_motions(shapes)
    for k in np.flatnonzero(_has_stiffness(squares)):
        decays[k] = _decay_root(allowed, float(np.sqrt(abs(squares[k]))), parts[:, k])
    return _name_modes(squares, shapes, decays, linear)


def _constrained_stiffness(stiffness: Stiffness, freedom: Freedom) -> Stiffness:
    """The stiffness of the motions that constraints allow."""
    return lambda omega: freedom.project_matrix(stiffness(omega))


def _undamped_shapes(stiffness: Stiffness, linear: Linear) -> tuple[np.ndarray, np.ndarray]:
    """w^2 (k,) of all natural modes that constraints allow, and their shapes (n, k)."""
    free = linear.freedom
    squares, shapes = undamped_modes(
        _constrained_stiffness(stiffness, free), free.project_matrix(linear.inertia)
    )
    return squares, free.expand(shapes)


def undamped_modes(stiffness: Stiffness, inertia: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """w^2 (n,) [1/s^2] of all natural modes and their shapes (n, n), one per column. For the k-th
    mode the k-th smallest eigenvalue of (K, M + A(w)) is w^2 itself. Modes with equal w, such as
    roll and pitch of a body of revolution, take their shapes from one eigenvalue problem, so that
    these differ."""
    K = stiffness(np.array([STATIC]))[0].real
    squares, shapes = _sorted_modes(K, inertia)
    for _ in range(MAX_MODE_ITERATIONS):
        omega = np.sqrt(np.maximum(np.abs(squares), MIN_STIFFNESS_FREQUENCY**2))
        last = squares.copy()
        masses = (K - stiffness(omega).real) / (omega**2 - STATIC**2)[:, None, None]
        eigenvalues, vectors = _sorted_modes(K, masses)
        alike = [
            int(np.isclose(last, square, rtol=EQUAL_MODE_RTOL, atol=0.0).argmax())
            for square in last
        ]
        for k in np.flatnonzero(_has_stiffness(squares)):
            squares[k] = 0.5 * (squares[k] + eigenvalues[k, k])
            shapes[:, k] = vectors[alike[k], :, k]
        if np.all(np.abs(squares - last) <= FREQUENCY_RTOL * np.abs(last)):
            break
    return squares, shapes


def _sorted_modes(K: np.ndarray, mass: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues of (K, M), rising, and shapes of unit kinetic energy, for M (..., n, n)."""
    try:
        values, vectors = np.linalg.eig(np.linalg.solve(mass, np.broadcast_to(K, mass.shape)))
    except np.linalg.LinAlgError:
        raise InputError(
            "natural modes: there is a motion without inertia, or inertia and stiffness are not"
            " finite; expected mass with added mass above zero in every motion. Look at the masses"
            " and radii of gyration of the bodies, and at `hydrosim db check` of their databases."
        ) from None
    order = np.argsort(values.real, axis=-1)
    values = np.take_along_axis(values.real, order, axis=-1)
    vectors = np.take_along_axis(vectors.real, order[..., None, :], axis=-1)
    size = np.sqrt(np.abs(np.einsum("...ik,...ij,...jk->...k", vectors, mass, vectors)))
    return values, vectors / np.maximum(size, SMALLEST_FLOAT)[..., None, :]


def _has_stiffness(squares: np.ndarray) -> np.ndarray:
    """Modes with a stiffness, as a mask."""
    return np.abs(squares) > max(
        MIN_STIFFNESS_FREQUENCY**2, MIN_STIFFNESS_RATIO * np.abs(squares).max(initial=0.0)
    )


def participation_factors(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Participation factors (m, k) of the states (rows) in the modes, from left and right
    eigenvectors (m, k), both as columns. They do not depend on units (Perez-Arriaga et al. 1982).
    """
    share = np.abs(left.conj() * right)
    return np.asarray(share / np.maximum(share.sum(axis=0), SMALLEST_FLOAT))


def modal_participation(linear: Linear, shapes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues (m,), and the share (k, m) of each natural mode with its rate (row):
    participation factors in coordinates along the ``shapes`` (n, k)."""
    values, left, right = linear.eigenvectors()
    # free shapes may be parallel
    n = linear.active.size
    along = np.linalg.pinv(shapes, MIN_STIFFNESS_RATIO)
    motion = [
        np.abs((shapes.T @ left[at].conj()) * (along @ right[at]))
        for at in (slice(0, n), slice(n, 2 * n))
    ]
    others = np.abs(left[2 * n :].conj() * right[2 * n :]).sum(axis=0)
    share = motion[0] + motion[1]
    return values, share / np.maximum(share.sum(axis=0) + others, SMALLEST_FLOAT)


def _match_rows(share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows, rising, and a column for each, all different, such that the sum of shares is
    largest."""
    if share.size == 0:
        nothing = np.zeros(0, dtype=int)
        return nothing, nothing
    if len(share) == 1:
        return np.zeros(1, dtype=int), share.argmax(axis=1)

    from scipy.optimize import linear_sum_assignment  # slow to load, few runs need it

    rows, columns = linear_sum_assignment(share, maximize=True)
    return rows, columns


def _name_modes(
    squares: np.ndarray, shapes: np.ndarray, decays: np.ndarray, linear: Linear
) -> list[NaturalMode]:
    """Modes named after coordinates, by their shares of kinetic energy."""
    energy = np.abs(shapes * (linear.inertia @ shapes))
    energy = energy / np.maximum(energy.sum(axis=0), SMALLEST_FLOAT)
    named_modes = []
    for i, k in zip(*_match_rows(energy), strict=True):
        bound = squares[k] > 0.0 and _has_stiffness(squares)[k]
        named_modes.append(
            NaturalMode(
                int(linear.active[i]),
                complex(decays[k]),
                2.0 * np.pi / float(np.sqrt(squares[k])) if bound else np.inf,
                shapes[:, k] / shapes[np.argmax(energy[:, k]), k],
                energy[:, k],
            )
        )
    return named_modes


def _decay_root(stiffness: Stiffness, omega: float, shape: np.ndarray) -> complex:
    """The root s of det(K + s B(w) + s^2 (M + A(w))) = 0, w = Im s, whose motion is most similar to
    a ``shape`` (n,)."""
    K = stiffness(np.array([STATIC]))[0].real
    n = shape.size
    value = 0j
    for _ in range(MAX_MODE_ITERATIONS):
        D = stiffness(np.array([omega]))[0]
        mass = (K - D.real) / (omega**2 - STATIC**2)
        damping = D.imag / omega
        state = np.block([[np.zeros((n, n)), np.eye(n)], [-K, -damping]])
        values, vectors = linalg.eig(state, linalg.block_diag(np.eye(n), mass))
        along = np.abs(shape @ mass @ vectors[:n]) / np.sqrt(
            np.abs(np.einsum("ik,ij,jk->k", vectors[:n].conj(), mass, vectors[:n]))
        )
        value = complex(values[np.argmax(np.where(values.imag >= 0.0, along, -1.0))])
        last = omega
        omega = max(abs(value.imag), MIN_STIFFNESS_FREQUENCY)
        if abs(omega - last) <= FREQUENCY_RTOL * last:
            break
    return value
