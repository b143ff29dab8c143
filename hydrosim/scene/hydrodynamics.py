"""What a body's hydrodynamics may be: databases, coefficients, hulls, families over the draught."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Protocol

import numpy as np

from hydrosim.scene.given import NOTHING_GIVEN, Given


class Hydrodynamics(Protocol):
    """A database in memory, as `hydrosim.database.HydroDatabase` is: what a scene knows of it is
    where it comes from and for how many bodies it is."""

    @property
    def source(self) -> str: ...

    @property
    def bodies(self) -> int: ...


class Without(StrEnum):
    """What of a database is left out."""

    DRIFT = "drift"
    QTF = "qtf"
    LOADS = "loads"


@dataclass(frozen=True)
class Changes:
    """What is done to a database that is read, and recorded in its attributes.

    ``accept`` are names of findings of its checks that do not refuse it; ``frequencies`` [rad/s]
    the lowest and the highest that are kept; ``symmetrise`` makes matrices symmetric and takes away
    what the mirror image forbids; ``without`` leaves parts out; of ``bodies_apart`` each is by
    itself, with the others held.
    """

    accept: tuple[str, ...] = ()
    frequencies: tuple[float, float] | None = None
    symmetrise: bool = False
    without: tuple[Without, ...] = ()
    bodies_apart: bool = False


@dataclass(frozen=True)
class ChangedDatabase:
    """A database, or its file, with ``changes``; ``given`` is what the file does not hold."""

    source: Hydrodynamics | Path
    changes: Changes = Changes()
    given: Given = NOTHING_GIVEN


@dataclass(frozen=True, eq=False)
class Coefficients:
    """Hydrodynamics by numbers alone (6, 6) about the centre of gravity, of no wave loads:
    constant ``added_mass`` and ``damping``, and hydrostatic ``stiffness``."""

    added_mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray


@dataclass(frozen=True, eq=False)
class Hull:
    """A closed hull of triangles, ``corners`` (nt, 3, 3) in the database's frame [m], normals into
    the water; ``source`` says where it is from."""

    corners: np.ndarray
    source: str = "a hull"


@dataclass(frozen=True)
class AtDraught:
    """The database, or its file, of a hull at a ``draught`` [m]."""

    draught: float
    source: Hydrodynamics | Path | ChangedDatabase


@dataclass(frozen=True)
class Family:
    """Databases of one hull at several draughts, between which it takes what belongs to its own,
    see `hydrosim.stepping.blending`. Their frames have one origin on the hull, seen from above. At
    the draught of the first of ``members`` the body is at its place at rest."""

    members: tuple[AtDraught, ...]
