"""Checks of a database and their findings, its parts in use, and scales of its bodies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from hydrosim.database.database import HydroDatabase, Real
from hydrosim.dofs import DOFS
from hydrosim.water.spectra import wavenumber

# Parts of a database that a scene uses; only these are checked.

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


ACCEPTED_ATTRIBUTE = "accepted"  # attribute of a database: names of accepted findings


@dataclass(frozen=True)
class Finding:
    """Result of one check. ``figure`` should be below ``limit``; above ``refusal`` the database is
    unusable, unless this is ``accepted``. ``place`` is the position of the largest error and its
    size there. ``advice`` explains the figure and gives a remedy. If the check was ``left_out``,
    the figure is zero, and ``advice`` is the reason."""

    name: str
    figure: float
    limit: float
    advice: str
    refusal: float = np.inf
    left_out: bool = False
    place: str = ""
    accepted: bool = False

    @property
    def has_passed(self) -> bool:
        """Whether the figure is within the limit."""
        return self.figure <= self.limit

    @property
    def is_doubted(self) -> bool:
        """Whether the figure exceeds the limit and is not accepted; always true above the
        refusal."""
        return not self.has_passed and not (self.accepted and self.figure <= self.refusal)

    @property
    def is_refused(self) -> bool:
        """Whether the figure exceeds the refusal."""
        return self.figure > self.refusal and not self.accepted

    @property
    def summary(self) -> str:
        """The figure, its place and its limit, without advice."""
        place = f" {self.place}" if self.place else ""
        remark = ", accepted" if self.accepted and not self.has_passed else ""
        return (
            f"{self.name}: found {self.figure:.3g}{place}, expected at most {self.limit:g}{remark}"
        )

    def __str__(self) -> str:
        return f"{self.summary} ({self.advice})."


class RelativeErrors(NamedTuple):
    """Errors ``relative`` to a usual size, NaN if not judged, along ``axes`` ("frequency",
    "heading", "dof", "motion" or "body"). ``size`` are absolute errors, in a ``unit`` of
    translations before and after the metres. ``where`` is the position of all of them."""

    relative: Real
    axes: tuple[str, ...] = ()
    size: Real | None = None
    unit: tuple[str, str] = ("", "")
    where: str = ""


def single_error(figure: float) -> RelativeErrors:
    """Errors with a single figure for the whole database."""
    return RelativeErrors(np.array(float(figure)))


class LeftOut(Exception):
    """Raised if the figure cannot be computed for this database; the message is the reason."""


def is_always_proof(db: HydroDatabase) -> bool:
    """Default: the figure is a proof in any database."""
    return True


def no_cause(db: HydroDatabase) -> str:
    """Default: the advice is the same for any database."""
    return ""


@dataclass(frozen=True)
class Check:
    """A check. ``errors`` of a database are ideally zero and may raise `LeftOut`. Without the
    optional arrays ``needs`` the check is left out. ``of`` are the parts that it compares. It is
    made for a scene that uses one of them, and refuses if the scene uses all. An error above
    ``refusal`` proves a wrong sign, unit or convention, if this database ``proves`` it. With
    ``of_all``, the error may be in any DOF that moves. ``cause`` adds to the ``advice`` what may be
    wrong with this database."""

    name: str
    errors: Callable[[HydroDatabase], RelativeErrors]
    limit: float
    advice: str
    of: frozenset[CheckSubject]
    refusal: float = np.inf
    needs: tuple[str, ...] = ()
    proves: Callable[[HydroDatabase], bool] = is_always_proof
    of_all: bool = False
    cause: Callable[[HydroDatabase], str] = no_cause

    def __call__(self, db: HydroDatabase, use: Use = EVERYTHING) -> Finding:
        """Finding of the check in ``db``, for the data in ``use``."""
        lacking = [name for name in self.needs if getattr(db, name) is None]
        try:
            if not self.of & use.parts:
                raise LeftOut(f"nothing uses the {min(self.of)}")
            if lacking:
                raise LeftOut(f"the database has no {lacking[0].replace('_', ' ')}")
            if CheckSubject.LOADS in self.of and not db.excitation.any():
                raise LeftOut("the database has no wave loads")
            errors = self.errors(use.without_fixed_damping(db) if self.of_all else db)
        except LeftOut as reason:
            return Finding(self.name, 0.0, self.limit, f"left out: {reason}", left_out=True)
        return self._find_worst(db, use, errors)

    def _find_worst(self, db: HydroDatabase, use: Use, errors: RelativeErrors) -> Finding:
        """Refusal applies to DOFs that the waves excite; errors of others are doubts."""
        whole = use.without_fixed_dofs(np.asarray(errors.relative), errors.axes)
        excited = use.at_wave_frequencies(whole, errors.axes, db.frequency)
        proves = self.of <= use.parts and self.proves(db)
        refuses = proves and largest_error(excited) > self.refusal
        worst = excited if refuses else whole
        return Finding(
            self.name,
            largest_error(worst),
            self.limit,
            self.advice + self.cause(db),
            self.refusal
            if refuses or (proves and largest_error(whole) <= self.refusal)
            else np.inf,
            place=_place_text(db, errors, worst) if largest_error(worst) > self.limit else "",
            accepted=self.name in accepted_findings(db),
        )


def accepted_findings(db: HydroDatabase) -> list[str]:
    """Names of the findings that neither refuse the database nor cause a warning."""
    return [name for name in db.attributes.get(ACCEPTED_ATTRIBUTE, "").split(", ") if name]


def largest_error(errors: Real) -> float:
    """Largest error; zero if none is judged."""
    return 0.0 if np.isnan(errors).all() else float(np.nanmax(errors))


def _place_text(db: HydroDatabase, errors: RelativeErrors, worst: Real) -> str:
    """Frequency, heading and pair of the largest error, and its size."""
    at = np.unravel_index(int(np.nanargmax(worst)), worst.shape)
    index = dict(zip(errors.axes, map(int, at), strict=True))
    words = [errors.where] if errors.where else []
    if "frequency" in index:
        words.append(f"at {db.frequency[index['frequency']]:.4g} rad/s")
    if "heading" in index:
        words.append(f"heading {np.degrees(db.heading[index['heading']]):.4g} deg")
    if "body" in index and db.bodies > 1:
        words.append(f"body {index['body'] + 1}")
    dofs = [index[name] for name in ("dof", "motion") if name in index]
    if dofs:
        words.append("in " + " by ".join(_dof_name(db, dof) for dof in dofs))
    size = "" if errors.size is None else _size_text(float(np.abs(errors.size[at])), errors, dofs)
    return ", ".join(words) + size


def _dof_name(db: HydroDatabase, dof: int) -> str:
    body = f"body {dof // 6 + 1} " if db.bodies > 1 else ""
    return body + DOFS[dof % 6]


def _size_text(size: float, errors: RelativeErrors, dofs: list[int]) -> str:
    before, after = errors.unit
    power = sum(dof % 6 > 2 for dof in dofs)
    metres = {0: "", 1: " m", 2: " m²"}[power]
    return f" (an error of {size:.3g} {before}{metres}{after})"


# Scales of a body; from the added mass if there is no volume.

# A DOF with less than this fraction of its body's scale counts as having no added mass or damping
MASS_NOISE_FRACTION = 1e-4
LONG_WAVE = 0.3  # k V^(1/3) below which the limits of long waves must hold
GYRATION = 2.5  # half a length over its radius of gyration: 1.7 for a box, 2.2 for an ellipsoid
LENGTH_POWERS = np.array([0, 0, 0, 1, 1, 1])  # power of a length in the loads of the six DOFs


def displaced_mass(db: HydroDatabase) -> Real:
    """Displaced mass (nb,); without volumes, the largest added mass of a translation, which has the
    same order."""
    if db.volume is not None:
        return db.water_density * db.volume
    added = np.abs(diagonal(db.added_mass)).reshape(-1, db.bodies, 6)
    return np.maximum(added[..., :3].max(axis=(0, 2)), np.finfo(float).tiny)


def length(db: HydroDatabase) -> Real:
    """(nb,): V^(1/3)."""
    return np.cbrt(displaced_mass(db) / db.water_density)


def radius(db: HydroDatabase) -> Real:
    """Estimate (nb,) of half the longest side or more, from the distribution of added mass over the
    body and from its waterplane. Shallow water adds more mass in heave than in pitch."""
    added = np.abs(diagonal(db.added_mass)[0]).reshape(db.bodies, 6)
    heave = np.maximum(added[:, 2], MASS_NOISE_FRACTION * displaced_mass(db))
    of_mass = GYRATION * np.sqrt(added[:, 3:].max(axis=1) / heave)
    return np.maximum.reduce([of_mass, length(db), _waterplane_radius(db)])


def _waterplane_radius(db: HydroDatabase) -> Real:
    """Half the diagonal (nb,) of a rectangle with the moments of the waterplane; zero without."""
    if db.hydrostatic_stiffness is None:
        return np.zeros(db.bodies)
    stiffness = np.diag(db.hydrostatic_stiffness).reshape(db.bodies, 6)
    moments = np.maximum(stiffness[:, 3:5], 0.0).sum(axis=1)
    heave = stiffness[:, 2]
    return np.sqrt(3.0 * np.divide(moments, heave, out=np.zeros(db.bodies), where=heave > 0.0))


def first_wavenumber(db: HydroDatabase) -> float:
    """Wavenumber at the lowest frequency."""
    return float(wavenumber(db.frequency[0], db.water_depth, db.gravity))


def reaches_long_waves(db: HydroDatabase) -> bool:
    """Whether the longest wave is long compared with every body."""
    return bool(first_wavenumber(db) * length(db).max() < LONG_WAVE)


def added_mass_scale(db: HydroDatabase) -> Real:
    """Square root of the largest diagonal (n,), or of the noise if that is larger."""
    largest = np.abs(diagonal(db.added_mass)).max(axis=0)
    return np.sqrt(np.maximum(largest, MASS_NOISE_FRACTION * _displaced_inertia(db)))


def damping_scale(db: HydroDatabase) -> Real:
    """The same as `added_mass_scale`, for the radiation damping."""
    largest = np.abs(diagonal(db.radiation_damping)).max(axis=0)
    return np.sqrt(np.maximum(largest, damping_floor(db)))


def damping_floor(db: HydroDatabase) -> Real:
    """Noise (n,) on the diagonal of the damping."""
    rate = np.sqrt(db.gravity / np.repeat(length(db), 6))
    return MASS_NOISE_FRACTION * _displaced_inertia(db) * rate


def load_floor(db: HydroDatabase) -> Real:
    """Noise (n,) in the loads per wave amplitude."""
    side = length(db)[:, None]
    return (
        MASS_NOISE_FRACTION * db.water_density * db.gravity * side ** (2 + LENGTH_POWERS)
    ).ravel()


def diagonal(matrices: Real) -> Real:
    """Diagonals (..., n) of (..., n, n)."""
    return np.diagonal(matrices, axis1=-2, axis2=-1)


def _displaced_inertia(db: HydroDatabase) -> Real:
    """Displaced mass (n,), times V^(2/3) for rotations."""
    return (displaced_mass(db)[:, None] * length(db)[:, None] ** (2 * LENGTH_POWERS)).ravel()
