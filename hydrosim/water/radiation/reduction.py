"""Fits with fewer states, as exact as the motions of the free bodies require.

An additional force dK^ v changes harmonic motions v by -Y dK^ v. Y = (s (M + A_inf) + C / s +
K^)^-1 is the admittance of bodies that float freely. A large inertia makes motions insensitive to
errors of K^ that are large compared with K^ itself.

So a fit is repeated with errors weighted by |Y|. Its error is the largest spectral norm of Y dK^ in
the band, with coordinates scaled by the roots of their inertias. Y does not contain lines and
contacts. The effect of a fit on the whole scene is measured later (`compiling.memory_errors`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from hydrosim.water.radiation.retardation import SLOWEST, Retardation
from hydrosim.water.radiation.state_space import (
    HELD_DOWN,
    StateSpace,
    Target,
    fit_once,
    state_space_of,
    target_of,
)
from hydrosim.water.radiation.threads import one_thread

PART = 0.5  # of the tolerance: largest change of motions by a reduced model
BETWEEN = 8  # points of an integral for each frequency: poles are narrower than the spacing


class Floating(NamedTuple):
    """Bodies that float freely: their ``inertia`` (n, n), without added mass, and hydrostatic
    ``stiffness`` (n, n), both along the DOFs of their database; SI."""

    inertia: np.ndarray
    stiffness: np.ndarray

    def among(self, dofs: np.ndarray) -> Floating:
        """The bodies with all DOFs held except ``dofs`` (m,)."""
        block = dofs[:, None], dofs
        return Floating(self.inertia[block], self.stiffness[block])


class Felt(NamedTuple):
    """The weight |W| = ``size`` (nw,) at the frequencies ``w`` (nw,), zero beyond them."""

    w: np.ndarray
    size: np.ndarray

    def at(self, w: np.ndarray) -> np.ndarray:
        """|W| at the frequencies w [rad/s], linear between the known ones."""
        return np.interp(w, self.w, self.size)

    def gramian(self, A: np.ndarray, B: np.ndarray) -> np.ndarray:
        """1 / 2 pi int |W|^2 (i w - A)^-1 B B^T (i w - A)^-H dw, over the known frequencies."""
        places = np.arange(BETWEEN * (self.w.size - 1) + 1) / BETWEEN
        w = np.interp(places, np.arange(self.w.size), self.w)
        width = np.gradient(w)
        width[[0, -1]] *= 0.5  # the trapezoidal rule
        share = self.at(w) ** 2 * width / np.pi  # of w and -w together
        poles, vectors = np.linalg.eig(A)
        b = np.linalg.solve(vectors, B.astype(complex))
        resolved = 1.0 / (1j * w[:, None] - poles)
        modal = (share * resolved.T) @ resolved.conj() * (b @ b.conj().T)
        result = (vectors @ modal @ vectors.conj().T).real
        return np.asarray(0.5 * (result + result.T))


@dataclass(frozen=True, eq=False)
class FeltTarget(Target):
    """A target whose errors are changes of motion: ``admittance`` (nw, m, m) is Y, scaled."""

    admittance: np.ndarray

    def error(self, found: np.ndarray) -> float:
        """Largest change of motion in the band if K^ is replaced by ``found`` (nw, m, m)."""
        change = self.admittance @ (found - self.values)
        return float(np.linalg.norm(change, 2, axis=(1, 2))[: self.inside].max())


@one_thread
def reduced(full: StateSpace, memory: Retardation, band: float, floating: Floating) -> StateSpace:
    """A passive model with fewer states than the fit ``full``, which changes the motions of
    ``floating`` bodies by at most `PART` of its tolerance. Returns ``full`` itself if none was
    found.

    ``memory`` and ``band`` [rad/s] are those of the fit.
    """
    target = felt_target(memory, full.dofs, band, floating)
    tolerance = full.report.tolerance
    model, report = fit_once(target, PART * tolerance)
    good = report.passive and report.frequency_error <= PART * tolerance
    if not good or model.decay.size >= full.order:
        return full
    felt = replace(report, tolerance=tolerance, motion_error=report.frequency_error)
    result = state_space_of(model, felt, target, memory)
    plain = target_of(memory, full.dofs, band)
    K = result.modes.transfer_function(1j * plain.w) / np.outer(plain.scale, plain.scale)
    return replace(result, report=replace(result.report, frequency_error=plain.error(K)))


def felt_target(
    memory: Retardation, dofs: np.ndarray, band: float, floating: Floating
) -> FeltTarget:
    """K^ between the ``dofs`` (m,) as in `target_of`, with the admittance of the `floating`
    bodies."""
    plain = target_of(memory, dofs, band)
    inertia, stiffness = floating.among(dofs)
    inertia = inertia + memory.added_mass_infinite[dofs[:, None], dofs]
    scale = np.sqrt(np.diag(inertia))
    size = np.outer(scale, scale)
    values = plain.values * np.outer(plain.scale, plain.scale) / size
    s = (SLOWEST + 1j * plain.w)[:, None, None]
    admittance = np.linalg.inv(s * (inertia / size) + stiffness / size / s + values)
    felt = np.linalg.norm(admittance, 2, axis=(1, 2))
    held_down = np.where(np.arange(plain.w.size) >= plain.inside, HELD_DOWN, 1.0)
    return FeltTarget(
        dofs=dofs,
        w=plain.w,
        inside=plain.inside,
        band=band,
        values=values,
        scale=scale,
        emphasis=Felt(plain.w, felt),
        weight=held_down * felt,
        gain=0.0,  # one attempt is made, without regard to the limit of passive models
        admittance=admittance,
    )
