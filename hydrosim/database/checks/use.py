"""Parts of a database that a scene uses: only these are checked."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from hydrosim.database.database import HydroDatabase, Real

AXES_OF_DOFS = ("dof", "motion")


class CheckSubject(StrEnum):
    """Subjects of checks; a scene may not use some of them."""

    ORDER = "order of frequencies and headings"
    RADIATION = "added mass and radiation damping"
    STIFFNESS = "hydrostatic stiffness"
    LOADS = "wave loads"
    DRIFT = "mean drift"
    DIFFERENCE = "difference-frequency QTF"
    SUM = "sum-frequency QTF"
    SPARE = "data that no simulation reads"


@dataclass(frozen=True)
class Use:
    """Used ``parts`` of a database, the ``dofs`` that move (None: all), and the ``highest``
    frequency [rad/s] of the waves. Errors above that frequency are only doubts, because they only
    affect the memory of radiation."""

    parts: frozenset[CheckSubject] = frozenset(CheckSubject)
    dofs: tuple[int, ...] | None = None
    highest: float = np.inf

    def without_fixed_dofs(self, relative: Real, axes: tuple[str, ...]) -> Real:
        """Errors with NaN for degrees of freedom that do not move."""
        if self.dofs is None:
            return relative
        for axis, name in enumerate(axes):
            if name in AXES_OF_DOFS:
                moves = np.isin(np.arange(relative.shape[axis]), self.dofs)
                across = [1] * relative.ndim
                across[axis] = -1
                relative = np.where(moves.reshape(across), relative, np.nan)
        return relative

    def at_wave_frequencies(self, relative: Real, axes: tuple[str, ...], frequency: Real) -> Real:
        """Errors at frequencies (always the first axis) that the waves have; all errors if none of
        those is judged."""
        if "frequency" not in axes:
            return relative
        waves = frequency[: relative.shape[0]] <= self.highest
        inside = np.where(waves.reshape(-1, *[1] * (relative.ndim - 1)), relative, np.nan)
        return relative if np.isnan(inside).all() else inside

    def without_fixed_damping(self, db: HydroDatabase) -> HydroDatabase:
        """Database without damping of the degrees of freedom that do not move."""
        if self.dofs is None or len(self.dofs) == 6 * db.bodies:
            return db
        moves = np.isin(np.arange(6 * db.bodies), self.dofs)
        return replace(db, radiation_damping=db.radiation_damping * np.outer(moves, moves))


EVERYTHING = Use()
