"""One check of a database and what it found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hydrosim.database.checks.use import EVERYTHING, Part, Use
from hydrosim.database.database import HydroDatabase, Real
from hydrosim.dofs import DOFS

ACCEPTED = "accepted"  # attribute of a database: names of findings that somebody has looked into


@dataclass(frozen=True)
class Finding:
    """Outcome of one check: ``figure`` is to stay below ``limit``; above ``refusal`` the database
    is unusable, unless that is ``accepted``. ``place`` says where the figure is the largest, and
    what size the error has there; ``advice`` what the figure is and what to do or, if the check was
    ``left_out`` (its figure is zero then), why."""

    name: str
    figure: float
    limit: float
    advice: str
    refusal: float = np.inf
    left_out: bool = False
    place: str = ""
    accepted: bool = False

    @property
    def passed(self) -> bool:
        """True up to the limit."""
        return self.figure <= self.limit

    @property
    def doubted(self) -> bool:
        """True above the limit, unless that is accepted; above the refusal all the same."""
        return not self.passed and not (self.accepted and self.figure <= self.refusal)

    @property
    def refused(self) -> bool:
        """True above the refusal."""
        return self.figure > self.refusal and not self.accepted

    def __str__(self) -> str:
        place = f" {self.place}" if self.place else ""
        said = ", which is accepted" if self.accepted and not self.passed else ""
        return (
            f"{self.name}: found {self.figure:.3g}{place}, expected at most {self.limit:g}{said}"
            f" ({self.advice})."
        )


class Errors(NamedTuple):
    """Errors ``relative`` to what is usual, NaN where nothing is judged, along ``axes``
    ("frequency", "heading", "dof", "motion" or "body"); what they are in themselves, ``size``, in
    a ``unit`` of translations before and after the metres; and ``where`` all of them are."""

    relative: Real
    axes: tuple[str, ...] = ()
    size: Real | None = None
    unit: tuple[str, str] = ("", "")
    where: str = ""


def one(figure: float) -> Errors:
    """A figure of the whole database."""
    return Errors(np.array(float(figure)))


class LeftOut(Exception):
    """A figure cannot be had of this database; the message says why."""


def always(db: HydroDatabase) -> bool:
    """A figure that proves something in any database."""
    return True


@dataclass(frozen=True)
class Check:
    """The ``errors`` of a database, zero at best, which may raise `LeftOut`; ``needs`` are the
    optional arrays without which it is left out, and ``of`` the parts that it compares: it is made
    for a scene that uses one of them, and refuses where all are used. An error above ``refusal``
    can only come from a wrong sign, unit or convention, provided that this database ``proves`` it;
    it may be one ``of_all`` that moves."""

    name: str
    errors: Callable[[HydroDatabase], Errors]
    limit: float
    advice: str
    of: frozenset[Part]
    refusal: float = np.inf
    needs: tuple[str, ...] = ()
    proves: Callable[[HydroDatabase], bool] = always
    of_all: bool = False

    def __call__(self, db: HydroDatabase, use: Use = EVERYTHING) -> Finding:
        """What the check finds in ``db``, of what there is ``use`` for."""
        lacking = [name for name in self.needs if getattr(db, name) is None]
        try:
            if not self.of & use.parts:
                raise LeftOut(f"nothing uses the {min(self.of)}")
            if lacking:
                raise LeftOut(f"the database has no {lacking[0].replace('_', ' ')}")
            if Part.LOADS in self.of and not db.excitation.any():
                raise LeftOut("the database has no wave loads")
            errors = self.errors(use.seen(db) if self.of_all else db)
        except LeftOut as reason:
            return Finding(self.name, 0.0, self.limit, f"left out: {reason}", left_out=True)
        return self._found(db, use, errors)

    def _found(self, db: HydroDatabase, use: Use, errors: Errors) -> Finding:
        """Refused is what the waves excite; the rest is a doubt."""
        whole = use.of(np.asarray(errors.relative), errors.axes)
        excited = use.excited(whole, errors.axes, db.frequency)
        proves = self.of <= use.parts and self.proves(db)
        refuses = proves and largest(excited) > self.refusal
        worst = excited if refuses else whole
        return Finding(
            self.name,
            largest(worst),
            self.limit,
            self.advice,
            self.refusal if refuses or (proves and largest(whole) <= self.refusal) else np.inf,
            place=_place(db, errors, worst) if largest(worst) > self.limit else "",
            accepted=self.name in accepted(db),
        )


def accepted(db: HydroDatabase) -> list[str]:
    """Names of the findings that do not refuse the database, and are not warned of."""
    return [name for name in db.attributes.get(ACCEPTED, "").split(", ") if name]


def largest(errors: Real) -> float:
    """Zero where nothing is judged."""
    return 0.0 if np.isnan(errors).all() else float(np.nanmax(errors))


def _place(db: HydroDatabase, errors: Errors, worst: Real) -> str:
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
    size = "" if errors.size is None else _sized(float(np.abs(errors.size[at])), errors, dofs)
    return ", ".join(words) + size


def _dof(db: HydroDatabase, dof: int) -> str:
    body = f"body {dof // 6 + 1} " if db.bodies > 1 else ""
    return body + DOFS[dof % 6]


def _sized(size: float, errors: Errors, dofs: list[int]) -> str:
    before, after = errors.unit
    power = sum(dof % 6 > 2 for dof in dofs)
    metres = {0: "", 1: " m", 2: " m²"}[power]
    return f" (an error of {size:.3g} {before}{metres}{after})"
