"""One check of a database and what it found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hydrosim.database.checks.use import EVERYTHING, CheckSubject, Use
from hydrosim.database.database import HydroDatabase, Real
from hydrosim.dofs import DOFS

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
        said = ", accepted" if self.accepted and not self.has_passed else ""
        return f"{self.name}: found {self.figure:.3g}{place}, expected at most {self.limit:g}{said}"

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


def proves_always(db: HydroDatabase) -> bool:
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
    proves: Callable[[HydroDatabase], bool] = proves_always
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
            place=_place(db, errors, worst) if largest_error(worst) > self.limit else "",
            accepted=self.name in accepted_findings(db),
        )


def accepted_findings(db: HydroDatabase) -> list[str]:
    """Names of the findings that neither refuse the database nor cause a warning."""
    return [name for name in db.attributes.get(ACCEPTED_ATTRIBUTE, "").split(", ") if name]


def largest_error(errors: Real) -> float:
    """Largest error; zero if none is judged."""
    return 0.0 if np.isnan(errors).all() else float(np.nanmax(errors))


def _place(db: HydroDatabase, errors: RelativeErrors, worst: Real) -> str:
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
        words.append("in " + " by ".join(_dof(db, dof) for dof in dofs))
    size = "" if errors.size is None else _size_text(float(np.abs(errors.size[at])), errors, dofs)
    return ", ".join(words) + size


def _dof(db: HydroDatabase, dof: int) -> str:
    body = f"body {dof // 6 + 1} " if db.bodies > 1 else ""
    return body + DOFS[dof % 6]


def _size_text(size: float, errors: RelativeErrors, dofs: list[int]) -> str:
    before, after = errors.unit
    power = sum(dof % 6 > 2 for dof in dofs)
    metres = {0: "", 1: " m", 2: " m²"}[power]
    return f" (an error of {size:.3g} {before}{metres}{after})"
