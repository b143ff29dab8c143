"""Hydrodynamics of a body: memory, databases, given data, coefficients, hulls, families."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import StrEnum
from pathlib import Path
from typing import Protocol

import numpy as np

# Models for the memory of radiated waves.

LENGTH = 100.0
"""Length of the memory [s] if none is given."""


class RadiationModel(StrEnum):
    """Models for the memory of the radiated waves, each with its defaults."""

    AUTOMATIC = "automatic"
    STATE_SPACE = "state_space"
    CONVOLUTION = "convolution"
    NONE = "none"


@dataclass(frozen=True)
class AutomaticRadiation:
    """State-space models where they suffice, convolution elsewhere.

    Each group of coupled motions gets extra states if its passive fit is within the relative
    ``tolerance``, and otherwise the memory integral. A run that starts from another run keeps that
    run's choice.

    The functions are tabulated every ``step`` [s] to ``length`` [s], or to `LENGTH` if none is
    given, but not longer than the frequencies of the database resolve.
    """

    tolerance: float = 3e-4
    length: float | None = None
    step: float = 0.1


@dataclass(frozen=True)
class StateSpaceRadiation:
    """Extra states: a rational fit of the retardation functions within a relative ``tolerance``.
    Groups whose nearest passive fit has more than ten times this error use the memory integral.

    The functions are tabulated every ``step`` [s] to ``length`` [s], or to `LENGTH` if none is
    given, but not longer than the frequencies of the database resolve.
    """

    tolerance: float = 3e-4
    length: float | None = None
    step: float = 0.1


@dataclass(frozen=True)
class ConvolutionRadiation:
    """The memory integral over ``length`` [s], or `LENGTH` if none is given, but not longer than
    the frequencies of the database resolve. ``step`` [s] is the step of the table, not of the
    run."""

    length: float | None = None
    step: float = 0.1


@dataclass(frozen=True)
class ConstantRadiation:
    """No memory: added mass and damping of one ``period`` [s]."""

    period: float


Radiation = AutomaticRadiation | StateSpaceRadiation | ConvolutionRadiation | ConstantRadiation


BY_NAME: Mapping[RadiationModel, Radiation | None] = {
    RadiationModel.AUTOMATIC: AutomaticRadiation(),
    RadiationModel.STATE_SPACE: StateSpaceRadiation(),
    RadiationModel.CONVOLUTION: ConvolutionRadiation(),
    RadiationModel.NONE: None,
}


# Data of a user that a file lacks.

# In a database's attribute ``assumed``: reference points at the program's default, or unknown.
ORIGIN_ASSUMED = "reference points at the origin"
POINTS_UNKNOWN = "unknown reference points"


class FrequencyColumn(StrEnum):
    """Meaning of the frequency column in a program's tables (WAMIT's IPEROUT, 1 to 4)."""

    PERIOD = "period"  # [s]
    FREQUENCY = "frequency"  # [rad/s]
    DEEP_WAVENUMBER = "deep wavenumber"  # w^2/g, times the length
    WAVENUMBER = "wavenumber"  # wavenumber in this water depth, times the length


@dataclass(frozen=True)
class Given:
    """Values in SI units and the database's frame; None where the file must give them.

    ``length`` is the length by which a program divides (WAMIT's ULEN). Points are of one body or,
    for several bodies, one after the other. ``draught`` is the name of one of several draughts in a
    file. ``frequencies`` [rad/s] are the lowest and highest that are used: others need no numbers.
    Readers use the values that they need.
    """

    length: float | None = None
    water_density: float | None = None
    gravity: float | None = None
    water_depth: float | None = None
    volume: tuple[float, ...] | None = None
    centre_of_buoyancy: tuple[float, ...] | None = None
    centre_of_gravity: tuple[float, ...] | None = None
    reference_point: tuple[float, ...] | None = None
    frequency_column: FrequencyColumn | None = None
    port_starboard_symmetric: bool | None = None
    draught: str | None = None
    frequencies: tuple[float, float] | None = None


NOTHING_GIVEN = Given()


def key_of(item: str) -> str:
    """Name of an item in a case; the same after --given."""
    return {"port_starboard_symmetric": "symmetric"}.get(item, item.removeprefix("water_"))


def first_given(*sources: Given) -> Given:
    """For each item, the first value that is not None."""
    chosen = {}
    for item in fields(Given):
        values = (getattr(source, item.name) for source in sources)
        chosen[item.name] = next((value for value in values if value is not None), None)
    return Given(**chosen)


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
    interpolated between them, see `hydrosim.integrate.draught_interpolation`. The origins of their
    frames are one point of the hull, seen from above. The position at rest has the draught of the
    first of ``members``."""

    members: tuple[AtDraught, ...]
