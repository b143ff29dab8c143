"""Hydrodynamics of a body: memory, databases, given data, coefficients, hulls, families."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Protocol, Self

import numpy as np
from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    StrictBool,
    StrictStr,
    model_validator,
)

from hydrosim.files import quantities as of
from hydrosim.files.key_rules import at_least_one
from hydrosim.files.schema_class import EqualByValue, ReadAs, SchemaClass, schema_class
from hydrosim.files.units import Quantity, problem
from hydrosim.scene.environment import WaterDepth

# Models for the memory of radiated waves.

LENGTH = 100.0
"""Length of the memory [s] if none is given."""


@schema_class
class TabulatedRadiation(SchemaClass):
    """What all retardation functions have: how long they are, and the step of their tables."""

    has_valid_defaults: ClassVar[bool] = True

    length: of.Period | None = None
    """Length of the retardation functions. Without it they are 100 s long, or as long as the
    frequencies of the database resolve."""
    step: of.Period = 0.1
    """Time step of the tables of the retardation functions. It is not the step of the run."""

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        length = LENGTH if self.length is None else self.length
        if length < 2.0 * self.step:
            found_text = f"length {length:g} s, step {self.step:g} s"
            raise problem(found_text, "a length of two steps or more")
        return self


@schema_class
class AutomaticRadiation(TabulatedRadiation):
    """States where their fit holds the tolerance, else the memory integral itself: by groups of
    coupled motions. A run that starts from another run keeps that run's choice."""

    positional: ClassVar[tuple[str, ...]] = ("tolerance", "length", "step")

    model: Literal["automatic"] = field(default="automatic", kw_only=True)
    """States where their fit is within the tolerance, the memory integral elsewhere."""
    tolerance: of.Tolerance = 3e-4
    """Largest error of the fit, relative to the largest diagonal entries."""


@schema_class
class StateSpaceRadiation(TabulatedRadiation):
    """A rational fit of the retardation functions. Groups whose nearest passive fit has more than
    ten times the tolerance use the memory integral."""

    positional: ClassVar[tuple[str, ...]] = ("tolerance", "length", "step")

    model: Literal["state_space"] = field(default="state_space", kw_only=True)
    """A rational fit of the retardation functions."""
    tolerance: of.Tolerance = 3e-4
    """Largest error of the fit, relative to the largest diagonal entries."""


@schema_class
class ConvolutionRadiation(TabulatedRadiation):
    """The memory integral itself."""

    model: Literal["convolution"] = field(default="convolution", kw_only=True)
    """The memory integral itself."""


@schema_class
class ConstantRadiation(SchemaClass):
    """Added mass and damping of one period."""

    model: Literal["constant"] = field(default="constant", kw_only=True)
    """Added mass and damping of one period, without memory."""
    period: of.Period
    """Wave period whose added mass and damping are used."""


@schema_class
class NoRadiation(SchemaClass):
    """No radiation; the other keys may stay, so that one word turns it off."""

    __pydantic_config__: ClassVar = ConfigDict(extra="ignore")

    model: Literal["none"] = field(default="none", kw_only=True)
    """No radiation forces."""


Radiation = AutomaticRadiation | StateSpaceRadiation | ConvolutionRadiation | ConstantRadiation
_MODEL = Annotated[Radiation | NoRadiation, Discriminator("model")]
_NAME = Literal["automatic", "state_space", "convolution", "none"]


def _require_model(value: Any) -> Any:
    return {"model": value} if isinstance(value, str) else value


BodyRadiation = Annotated[
    _MODEL, BeforeValidator(_require_model, json_schema_input_type=_MODEL | _NAME)
]
"""Radiation of a body: a name, or a mapping with a model and its settings."""


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


def _read_points(value: Any) -> Any:
    """A point of one body as a list of one."""
    return value if isinstance(value, list) and value and isinstance(value[0], list) else [value]


def _is_flat(value: Any) -> bool:
    """True for the numbers of points, one after the other."""
    return value is None or (isinstance(value, tuple) and isinstance(value[0], int | float))


Points = Annotated[
    tuple[float, ...] | None,
    ReadAs(
        Annotated[tuple[of.Point, ...], of.one_or_more(of.Point, _read_points)] | None,
        _is_flat,
        lambda points: tuple(x for point in points for x in point),
    ),
]
Volume = Annotated[float, Quantity("volume", "m^3", "1000 m^3", above=0)]
Frequencies = tuple[of.TableFrequency, of.TableFrequency]


def _require_range(frequencies: Frequencies | None) -> Frequencies | None:
    if frequencies is not None and not frequencies[0] < frequencies[1]:
        range_text = "frequencies {:g} to {:g} rad/s".format(*frequencies)
        raise problem(range_text, "the lower one first")
    return frequencies


FrequencyRange = Annotated[Frequencies | None, AfterValidator(_require_range)]


@schema_class
class Given(SchemaClass):
    """Values in the database's frame that a file lacks; those that it has must agree. Points of
    several bodies are one after the other. Readers use the values that they need."""

    water_density: Annotated[of.Density | None, Field(alias="density")] = None
    """Water density of the database, where the file does not hold it."""
    gravity: of.Gravity | None = None
    """Gravity of the database, where the file does not hold it."""
    water_depth: Annotated[WaterDepth | None, Field(alias="depth")] = None
    """Water depth of the database, where the file does not hold it."""
    length: of.LineLength | None = None
    """Length that the file's values are made dimensionless with (WAMIT's ULEN)."""
    volume: Annotated[tuple[Volume, ...], of.one_or_more(Volume)] | None = None
    """Displaced volume of the hull, or a list with one of each body."""
    centre_of_buoyancy: Points = None
    """Centre of buoyancy in the database's frame, or a list with one of each body."""
    centre_of_gravity: Points = None
    """Centre of gravity that the database was computed with, or a list with one of each body."""
    reference_point: Points = None
    """Point that moments and motions of the file are about, or a list with one of each body."""
    frequency_column: FrequencyColumn | None = None
    """Kind of the frequency column in the file's tables."""
    port_starboard_symmetric: Annotated[StrictBool | None, Field(alias="symmetric")] = None
    """Whether the hull is its own mirror image, port and starboard."""
    frequencies: FrequencyRange = None
    """Lowest and highest frequency that are used: others need no numbers. Example: [0 rad/s, 3
    rad/s]."""
    draught: StrictStr | None = None
    """Name of one of several draughts in the file. Example: draught_6m."""

    def with_values(self, **values: Any) -> Given:
        """The same with values of a file, which its reader checks."""
        return Given.build_from(self, **values)


NOTHING_GIVEN = Given()


def key_of(item: str) -> str:
    """Name of an item in a case; the same after --given."""
    return Given.schema_fields()[item].alias or item


def first_given(*sources: Given) -> Given:
    """For each item, the first value that is not None."""
    chosen = {}
    for item in fields(Given):
        values = (getattr(source, item.name) for source in sources)
        chosen[item.name] = next((value for value in values if value is not None), None)
    return NOTHING_GIVEN.with_values(**chosen)


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


@schema_class
class Changes(SchemaClass):
    """Changes applied to a database after reading, and recorded in its attributes."""

    accept: tuple[StrictStr, ...] = ()
    """Names of findings of the database check that are accepted. Example: [positive damping]."""
    frequencies: FrequencyRange = None
    """Lowest and highest frequency that are used. Example: [0 rad/s, 3 rad/s]."""
    symmetrise: StrictBool = False
    """Whether matrices are made symmetric and values that symmetry forbids are removed."""
    without: tuple[Without, ...] = ()
    """Parts of the database that are left out."""
    bodies_apart: StrictBool = False
    """Whether each body of the database is taken by itself, with the others held."""


@schema_class
class ChangedDatabase(Changes, Given):
    """A database in a ``file``: values that the file lacks, and changes to it. In Python it may be
    in memory."""

    own_keys_first: ClassVar[bool] = True
    positional: ClassVar[tuple[str, ...]] = ("source",)

    source: Annotated[
        Hydrodynamics | Path,
        ReadAs(StrictStr, lambda value: not isinstance(value, str), Path),
        Field(alias="file"),
    ] = field(kw_only=True)
    """Database file, relative to the case file. Example: ../hydro_db/barge.nc."""


AddedMassMatrix = Annotated[np.ndarray, ReadAs(of.AddedMassMatrix | None, np.ndarray, of.as_matrix)]
StiffnessMatrix = Annotated[np.ndarray, ReadAs(of.StiffnessMatrix | None, np.ndarray, of.as_matrix)]
DampingMatrix = Annotated[np.ndarray, ReadAs(of.DampingMatrix | None, np.ndarray, of.as_matrix)]


@schema_class
class Coefficients(SchemaClass):
    """Numbers instead of a database: constant, about the centre of gravity, and without wave
    loads."""

    key_rules = (
        at_least_one(
            "added_mass",
            "damping",
            "stiffness",
            nothing="none of them",
            expected="a file, or some of added_mass, damping, stiffness",
        ),
    )

    added_mass: AddedMassMatrix = None  # type: ignore[assignment]
    """Constant added mass: per degree of freedom, or a 6 x 6 matrix."""
    damping: DampingMatrix = None  # type: ignore[assignment]
    """Constant damping: per degree of freedom, or a 6 x 6 matrix."""
    stiffness: StiffnessMatrix = None  # type: ignore[assignment]
    """Hydrostatic stiffness: per degree of freedom, or a 6 x 6 matrix."""


@dataclass(frozen=True, eq=False)
class Hull(EqualByValue):
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
