"""Hydrodynamics of a body: databases, coefficients, hulls, families over the draught."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Protocol

import numpy as np

from hydrosim.scene.given import NOTHING_GIVEN, Given


class Hydrodynamics(Protocol):
    """A database in memory, such as `hydrosim.database.HydroDatabase`. A scene knows only its
    source and its number of bodies."""

    @property
    def source(self) -> str: ...

    @property
    def bodies(self) -> int: ...


class Without(StrEnum):
    """Parts of a database that are left out."""

    DRIFT = "drift"
    QTF = "qtf"
    LOADS = "loads"


@dataclass(frozen=True)
class Changes:
    """Changes applied to a database after reading, and recorded in its attributes.

    ``accept`` names findings of its checks that do not refuse it. ``frequencies`` [rad/s] are the
    lowest and highest that are kept. ``symmetrise`` makes matrices symmetric and removes entries
    that mirror symmetry forbids. ``without`` leaves parts out. ``bodies_apart`` takes each body by
    itself, with the others held.
    """

    accept: tuple[str, ...] = ()
    frequencies: tuple[float, float] | None = None
    symmetrise: bool = False
    without: tuple[Without, ...] = ()
    bodies_apart: bool = False


@dataclass(frozen=True)
class ChangedDatabase:
    """A database, or its file, with ``changes``; ``given`` holds values that are missing in the
    file."""

    source: Hydrodynamics | Path
    changes: Changes = Changes()
    given: Given = NOTHING_GIVEN


@dataclass(frozen=True, eq=False)
class Coefficients:
    """Hydrodynamics by numbers alone (6, 6) about the centre of gravity, without wave loads:
    constant ``added_mass`` and ``damping``, and hydrostatic ``stiffness``."""

    added_mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray


@dataclass(frozen=True, eq=False)
class Hull:
    """A closed hull of triangles, ``corners`` (nt, 3, 3) in the database's frame [m], normals into
    the water; ``source`` names its origin in messages."""

    corners: np.ndarray
    source: str = "a hull"


@dataclass(frozen=True)
class AtDraught:
    """The database, or its file, of a hull at a ``draught`` [m]."""

    draught: float
    source: Hydrodynamics | Path | ChangedDatabase


@dataclass(frozen=True)
class Family:
    """Databases of one hull at several draughts. Quantities at the body's own draught are
    interpolated between them, see `hydrosim.stepping.blending`. The origins of their frames are one
    point of the hull, seen from above. The position at rest has the draught of the first of
    ``members``."""

    members: tuple[AtDraught, ...]
