"""One check of a database and what it found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hydrosim.database.database import HydroDatabase


@dataclass(frozen=True)
class Finding:
    """Outcome of one check: ``figure`` is to stay below ``limit``; above ``refusal`` the database
    is unusable. ``advice`` says what the figure is and what to do or, if the check was
    ``left_out`` (its figure is zero then), why."""

    name: str
    figure: float
    limit: float
    advice: str
    refusal: float = np.inf
    left_out: bool = False

    @property
    def passed(self) -> bool:
        """True up to the limit."""
        return self.figure <= self.limit

    @property
    def refused(self) -> bool:
        """True above the refusal."""
        return self.figure > self.refusal


class LeftOut(Exception):
    """A figure cannot be had of this database; the message says why."""


def always(db: HydroDatabase) -> bool:
    """A figure that proves something in any database."""
    return True


@dataclass(frozen=True)
class Check:
    """A ``figure`` of a database, zero at best, that may raise `LeftOut`; ``needs`` are the
    optional arrays without which it is left out. A figure above ``refusal`` can only come from a
    wrong sign, unit or convention, provided that this database ``proves`` it."""

    name: str
    figure: Callable[[HydroDatabase], float]
    limit: float
    advice: str
    refusal: float = np.inf
    needs: tuple[str, ...] = ()
    proves: Callable[[HydroDatabase], bool] = always

    def __call__(self, db: HydroDatabase) -> Finding:
        """What the check finds in ``db``."""
        lacking = [name for name in self.needs if getattr(db, name) is None]
        try:
            if lacking:
                raise LeftOut(f"the database has no {lacking[0].replace('_', ' ')}")
            figure = float(self.figure(db))
        except LeftOut as reason:
            return Finding(self.name, 0.0, self.limit, f"left out: {reason}", left_out=True)
        refusal = self.refusal if self.proves(db) else np.inf
        return Finding(self.name, figure, self.limit, self.advice, refusal)
