"""Types of models of files: quantities, vectors and matrices of them, and keys of meshes."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Generic, Literal, Self, TypeVar

import numpy as np
import pydantic

from hydrosim.dofs import DOFS
from hydrosim.files.key_rules import Rules, check_key_rules
from hydrosim.files.units import Cyclic, Quantity, problem

NAME_PATTERN = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_PER_HZ = 0.5 / math.pi  # of a density over frequency in Hz, in one over rad/s

Length = Annotated[float, Quantity("length", "m", "12.4 m")]
Angle = Annotated[float, Quantity("angle", "rad", "20 deg")]
Speed = Annotated[float, Quantity("velocity", "m/s", "0.5 m/s")]
TopSpeed = Annotated[float, Quantity("velocity", "m/s", "0.3 m/s", above=0)]
Acceleration = Annotated[float, Quantity("acceleration", "m/s^2", "0.1 m/s^2", above=0)]
FlowSpeed = Annotated[float, Quantity("velocity", "m/s", "1 knot", at_least=0)]
TurnRate = Annotated[float, Quantity("angular velocity", "rad/s", "1 deg/s")]
Instant = Annotated[float, Quantity("time", "s", "500 s")]
Span = Annotated[float, Quantity("time", "s", "200 s", at_least=0)]
Period = Annotated[float, Quantity("time", "s", "8 s", above=0)]
Height = Annotated[float, Quantity("wave height", "m", "1.5 m", at_least=0)]
Frequency = Annotated[float, Cyclic("frequency", "rad/s", "0.1 Hz", above=0)]
FREQUENCY_OR_ZERO = Cyclic("frequency", "rad/s", "0.1 Hz", at_least=0)
TableFrequency = Annotated[float, FREQUENCY_OR_ZERO]
WaveDensity = Annotated[
    float,
    Cyclic(
        "spectral density", "m^2*s/rad", "2 m^2/Hz", at_least=0, cycles="m^2/Hz", radians=_PER_HZ
    ),
]
Sharpness = Annotated[float, Quantity("sharpness of a peak", "", "3", above=0)]
Depth = Annotated[float, Quantity("depth", "m", "100 m", above=0, infinite=True)]
Density = Annotated[float, Quantity("density", "kg/m^3", "1.025 tonne/m^3", above=0)]
Gravity = Annotated[float, Quantity("acceleration", "m/s^2", "9.81 m/s^2", above=0)]
GravityOrNone = Annotated[float, Quantity("acceleration", "m/s^2", "9.81 m/s^2", at_least=0)]
Mass = Annotated[float, Quantity("mass", "kg", "1000 tonne", above=0)]
Radius = Annotated[float, Quantity("radius of gyration", "m", "20 m", above=0)]
Tolerance = Annotated[float, Quantity("relative tolerance", "", "1e-6", above=0)]
SmallLength = Annotated[float, Quantity("tolerance of positions", "m", "1e-6 m", above=0)]
SmallAngle = Annotated[float, Quantity("tolerance of angles", "rad", "1e-8 rad", above=0)]
Factor = Annotated[float, Quantity("number", "", "20 %", at_least=0)]
ProfileExponent = Annotated[float, Quantity("exponent", "", "0.11", above=0, at_most=2)]
GasExponent = Annotated[float, Quantity("exponent", "", "1.3", at_least=1, at_most=2)]
Peak = Annotated[float, Quantity("peak enhancement factor", "", "3.3", at_least=1)]
Component = Annotated[float, Quantity("number", "", "-1")]
Force = Annotated[float, Quantity("force", "N", "100 kN")]
Moment = Annotated[float, Quantity("moment", "N*m", "100 kN*m")]
LineLength = Annotated[float, Quantity("length", "m", "150 m", above=0)]
Stiffness = Annotated[float, Quantity("stiffness", "N/m", "40 tonne_force/m", above=0)]
LineWeight = Annotated[float, Quantity("weight in water per length", "N/m", "1.2 kN/m")]
AxialStiffness = Annotated[float, Quantity("axial stiffness EA", "N", "600 MN", above=0)]
Diameter = Annotated[float, Quantity("diameter", "m", "84 mm", above=0)]
Damping = Annotated[float, Quantity("damping coefficient", "N*s/m", "100 kN*s/m", at_least=0)]
ReferenceForce = Annotated[float, Quantity("force", "N", "1000 kN", above=0)]
Power = Annotated[float, Quantity("power", "", "0.5", at_least=0, at_most=1)]
Level = Annotated[float, Quantity("level", "m", "3 m", at_least=0)]
Slope = Annotated[float, Quantity("friction slope", "N*s/m", "1e6 kN*s/m", above=0)]
EitherStiffness = Annotated[float, Quantity("stiffness", "N/m", "40 tonne_force/m")]
EitherTurnStiffness = Annotated[float, Quantity("rotational stiffness", "N*m/rad", "1 MN*m/deg")]
TurnStiffness = Annotated[
    float, Quantity("rotational stiffness", "N*m/rad", "1e9 N*m/rad", above=0)
]
TurnDamping = Annotated[
    float, Quantity("damping coefficient", "N*m*s/rad", "1 MN*m*s/rad", at_least=0)
]
Drag = Annotated[float, Quantity("quadratic damping", "N*s^2/m^2", "10 kN*s^2/m^2", at_least=0)]
TurnDrag = Annotated[
    float, Quantity("quadratic damping", "N*m*s^2/rad^2", "1 MN*m*s^2/rad^2", at_least=0)
]
TurnCube = Annotated[
    float, Quantity("cubic damping", "N*m*s^3/rad^3", "1 MN*m*s^3/rad^3", at_least=0)
]
DecayRate = Annotated[float, Quantity("decay rate", "s^-1", "0.02 s^-1", at_least=0)]
DecaySquare = Annotated[float, Quantity("quadratic decay", "rad^-1", "0.15 rad^-1", at_least=0)]
DecayCube = Annotated[float, Quantity("cubic decay", "s/rad^2", "0.5 s/rad^2", at_least=0)]
Viscosity = Annotated[float, Quantity("kinematic viscosity", "m^2/s", "1.19e-6 m^2/s", above=0)]
FrictionForce = Annotated[float, Quantity("force", "N", "100 kN", at_least=0)]
FrictionMoment = Annotated[float, Quantity("moment", "N*m", "100 kN*m", at_least=0)]

_Mass = Annotated[float, Quantity("mass", "kg", "1000 tonne")]
_MassMoment = Annotated[float, Quantity("first moment of mass", "kg*m", "1 tonne*m")]
_Inertia = Annotated[float, Quantity("moment of inertia", "kg*m^2", "1e6 tonne*m^2")]
_Stiffness = Annotated[float, Quantity("stiffness", "N/m", "40 tonne_force/m")]
_CrossStiffness = Annotated[float, Quantity("force per angle", "N/rad", "40 kN/deg")]
_TurnStiffness = Annotated[float, Quantity("rotational stiffness", "N*m/rad", "1 MN*m/deg")]
_Damping = Annotated[float, Quantity("damping coefficient", "N*s/m", "100 kN*s/m")]
_CrossDamping = Annotated[float, Quantity("damping coefficient", "N*s/rad", "100 kN*s/rad")]
_TurnDamping = Annotated[float, Quantity("damping coefficient", "N*m*s/rad", "1 MN*m*s/rad")]

_Drag = Annotated[float, Quantity("quadratic damping", "N*s^2/m^2", "100 kN*s^2/m^2")]
_CrossDrag = Annotated[float, Quantity("quadratic damping", "N*s^2/rad^2", "1 kN*s^2/rad^2")]
_DragMoment = Annotated[float, Quantity("quadratic damping", "N*m*s^2/m^2", "1 kN*s^2/m")]
_TurnDrag = Annotated[float, Quantity("quadratic damping", "N*m*s^2/rad^2", "1 MN*m*s^2/rad^2")]
_StreamForce = Annotated[float, Quantity("force per squared speed", "N*s^2/m^2", "2 kN*s^2/m^2")]
_StreamMoment = Annotated[float, Quantity("moment per squared speed", "N*m*s^2/m^2", "50 kN*s^2/m")]

T = TypeVar("T")  # of surge, sway, heave
C = TypeVar("C")  # of couplings between them
R = TypeVar("R")  # of roll, pitch, yaw

Vector = tuple[T, T, T]
Six = tuple[T, T, T, R, R, R]
SixBySix = Six[Six[T, C], Six[C, R]]


class SchemaModel(pydantic.BaseModel):
    """A mapping in a case file. Unknown keys are errors. The context has `messages.Readers`."""

    model_config = pydantic.ConfigDict(extra="forbid", frozen=True, defer_build=True)
    key_rules: ClassVar[Rules] = ()
    """Which keys go together, besides what base classes say."""

    @pydantic.model_validator(mode="before")
    @classmethod
    def _tell_who_reads(cls, value: Any, info: pydantic.ValidationInfo) -> Any:
        if info.context is not None:
            info.context.update({id(value): cls, cls.__name__: cls})
        return value

    @pydantic.model_validator(mode="after")
    def _check_key_rules(self) -> Self:
        check_key_rules(self)
        return self

    def keys_with_value(self, *keys: str) -> list[str]:
        """The ``keys`` that have a value."""
        return [key for key in keys if getattr(self, key) is not None]

    def __reduce_ex__(self, protocol: Any) -> Any:
        """Pickle as the generic class: those of two quantities may have the same name."""
        generic = self.__pydantic_generic_metadata__["origin"]
        if generic is None:
            return super().__reduce_ex__(protocol)
        return _make_unpickled, (generic,), self.__getstate__()


def _make_unpickled(generic: type[SchemaModel]) -> SchemaModel:
    return generic.__new__(generic)


class PerDof(SchemaModel, Generic[T, R]):
    """A value for each DOF that is named."""

    surge: T | None = None
    """Value along the x axis, forward."""
    sway: T | None = None
    """Value along the y axis, to port."""
    heave: T | None = None
    """Value along the z axis, upward."""
    roll: R | None = None
    """Value about the x axis."""
    pitch: R | None = None
    """Value about the y axis."""
    yaw: R | None = None
    """Value about the z axis."""

    def values(self, absent: Any = 0.0) -> list[Any]:
        """Six values, ``absent`` where none is given."""
        return [absent if (x := getattr(self, dof)) is None else x for dof in DOFS]


class PerTurn(SchemaModel, Generic[R]):
    """A value for each rotation."""

    roll: R
    """Value about the x axis."""
    pitch: R
    """Value about the y axis."""
    yaw: R
    """Value about the z axis."""


def _listed_six(value: Any) -> Any:
    return tuple(value.values()) if isinstance(value, PerDof) else value


def _listed_turns(value: Any) -> Any:
    return (value.roll, value.pitch, value.yaw) if isinstance(value, PerTurn) else value


def _diagonal(value: Any) -> Any:
    if not isinstance(value, PerTurn):
        return value
    return tuple(tuple(row) for row in np.diag(_listed_turns(value)).tolist())


def as_matrix(value: Any) -> np.ndarray:
    """(n, n) array of a full matrix in rows, or of the diagonal in a `PerDof`; (6, 6) zeros of
    None."""
    if value is None:
        return np.zeros((6, 6))
    return np.diag(value.values()) if isinstance(value, PerDof) else np.array(value, float)


def as_matrix_or_none(value: Any) -> np.ndarray | None:
    """The same of what may be left out."""
    return None if value is None else as_matrix(value)


def as_six_or_none(value: PerDof[float, float] | None) -> np.ndarray | None:
    """Array (6,) of values per DOF, 0 where none is given."""
    return None if value is None else np.array(value.values())


def as_array_or_none(value: Any) -> np.ndarray | None:
    """Array of a list that may be left out."""
    return None if value is None else np.array(value, float)


def _form_tag(value: object) -> str:
    return "matrix" if isinstance(value, list | tuple) else "diagonal"


def _kind(value: object) -> str:
    return "by name" if isinstance(value, dict | pydantic.BaseModel) else "list"


def _scale_to_unit_diagonal(matrix: np.ndarray) -> np.ndarray:
    """The matrix scaled to a unit diagonal, so that metres and radians weigh the same."""
    diagonal = np.diag(matrix)
    size = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    return matrix / np.outer(size, size)


def _require_symmetric(value: Any) -> Any:
    matrix = as_matrix(value)
    gap = np.abs(_scale_to_unit_diagonal(matrix) - _scale_to_unit_diagonal(matrix).T)
    i, j = np.unravel_index(gap.argmax(), gap.shape)
    if gap[i, j] > 1e-6:
        found_text = (
            f"{matrix[i, j]:g} in row {i + 1}, column {j + 1} and {matrix[j, i]:g} opposite it"
        )
        raise problem(found_text, "a symmetric matrix")
    return value


def _refuse_driving(value: Any) -> Any:
    diagonal = np.diag(as_matrix(value))
    negative = [f"{x:g} for {dof}" for x, dof in zip(diagonal, DOFS, strict=True) if x < 0.0]
    if negative:
        raise problem(", ".join(negative), "0 or more")
    return value


def _require_semidefinite(value: Any) -> Any:
    matrix = as_matrix(_refuse_driving(value))
    if np.linalg.eigvalsh(_scale_to_unit_diagonal(matrix))[0] < -1e-9:
        raise problem("a matrix with a negative eigenvalue", "one that cannot give energy away")
    return value


def _require_definite(value: Any) -> Any:
    if np.linalg.eigvalsh(_scale_to_unit_diagonal(as_matrix(value)))[0] <= 0.0:
        raise problem("a matrix that is not positive definite", "one of a body with mass")
    return value


def require_inertia(matrix: np.ndarray) -> None:
    """Refuses an array that is no inertia (3, 3) of a body with mass."""
    if matrix.shape != (3, 3) or not np.isfinite(matrix).all():
        sizes = " x ".join(map(str, matrix.shape))
        raise problem(f"an inertia of {sizes} values", "3 x 3 finite numbers")
    _require_definite(_require_symmetric(matrix))


def _require_steps(holds: Callable[[float, float], bool], expected: str) -> pydantic.AfterValidator:
    """Validator of a list in which ``holds(next, this)`` for all neighbours."""

    def check(values: tuple[float, ...]) -> tuple[float, ...]:
        for this, after in pairwise(values):
            if not holds(after, this):
                raise problem(f"{after:g} after {this:g}", expected)
        return values

    return pydantic.AfterValidator(check)


def require_start_at_zero(values: tuple[float, ...]) -> tuple[float, ...]:
    """Refuses a table that does not begin at 0 or has only one point."""
    if len(values) < 2 or values[0] != 0.0:
        values_text = "[" + ", ".join(f"{x:g}" for x in values) + "]"
        raise problem(values_text, "a table of at least two points, the first at 0")
    return values


def _require_full_headings(values: tuple[float, ...]) -> tuple[float, ...]:
    """Refuses headings that cover neither 0 to 180 deg nor the whole circle."""
    range_text = "headings from {:g} to {:g} deg".format(*np.degrees([values[0], values[-1]]))
    if values[-1] <= np.pi * (1.0 + 1e-9):
        if values[0] != 0.0 or values[-1] < np.pi * (1.0 - 1e-9):
            raise problem(range_text, "0 to 180 deg for half a circle, or more than that")
        gap = np.diff(values).max()
    else:
        gap = np.diff([*values, values[0] + 2.0 * np.pi]).max()
        if values[-1] - values[0] > 2.0 * np.pi - 1e-6:
            raise problem(range_text, "each direction once; leave 360 deg out where there is 0")
    if gap > 0.5 * np.pi * (1.0 + 1e-9):
        raise problem(f"a gap of {np.degrees(gap):g} deg", "headings at most 90 deg apart")
    return values


def _valid_name(name: str) -> str:
    if not NAME_PATTERN.fullmatch(name):
        raise problem(f'the name "{name}"', "letters, digits and _, beginning with a letter")
    return name


def require_entries(value: Any) -> Any:
    """Refuses an empty list or mapping."""
    if not value:
        raise problem("nothing in it", "one or more")
    return value


def require_two_entries(values: tuple[Any, ...]) -> tuple[Any, ...]:
    """Refuses a list with fewer than two entries."""
    if len(values) < 2:
        raise problem(f"{len(values)} in the list", "two or more")
    return values


def as_list(value: Any) -> Any:
    """The value as a list; a single value becomes a list of one."""
    return value if isinstance(value, list | tuple) else [value]


def one_or_more(item: Any, listed: Callable[[Any], Any] = as_list) -> pydantic.BeforeValidator:
    """Annotation of a tuple of ``item``; a file may give a single one, which becomes a list by
    ``listed``."""
    return pydantic.BeforeValidator(listed, json_schema_input_type=item | tuple[item, ...])


def _or_by_name(listed: Any, named: Any, convert: Callable[[Any], Any]) -> Any:
    """Annotation of a list that a file may also give as a mapping by names."""
    either = Annotated[named, pydantic.Tag("by name")] | Annotated[listed, pydantic.Tag("list")]
    return Annotated[either, pydantic.Discriminator(_kind), pydantic.AfterValidator(convert)]


RISING = _require_steps(operator.gt, "values that rise")
NOT_FALLING = _require_steps(operator.ge, "values that do not fall")

StiffnessMatrix = Annotated[
    Annotated[PerDof[_Stiffness, _TurnStiffness], pydantic.Tag("diagonal")]
    | Annotated[SixBySix[_Stiffness, _CrossStiffness, _TurnStiffness], pydantic.Tag("matrix")],
    pydantic.Discriminator(_form_tag),
    pydantic.AfterValidator(_require_symmetric),
    pydantic.AfterValidator(_require_semidefinite),
]
DampingMatrix = Annotated[
    Annotated[PerDof[_Damping, _TurnDamping], pydantic.Tag("diagonal")]
    | Annotated[SixBySix[_Damping, _CrossDamping, _TurnDamping], pydantic.Tag("matrix")],
    pydantic.Discriminator(_form_tag),
    pydantic.AfterValidator(_require_symmetric),
    pydantic.AfterValidator(_require_semidefinite),
]
QuadraticMatrix = Annotated[
    Annotated[PerDof[_Drag, _TurnDrag], pydantic.Tag("diagonal")]
    | Annotated[
        Six[Six[_Drag, _CrossDrag], Six[_DragMoment, _TurnDrag]],
        pydantic.Tag("matrix"),
    ],
    pydantic.Discriminator(_form_tag),
    pydantic.AfterValidator(_refuse_driving),
]
AddedMassMatrix = Annotated[
    Annotated[PerDof[_Mass, _Inertia], pydantic.Tag("diagonal")]
    | Annotated[SixBySix[_Mass, _MassMoment, _Inertia], pydantic.Tag("matrix")],
    pydantic.Discriminator(_form_tag),
    pydantic.AfterValidator(_require_symmetric),
    pydantic.AfterValidator(_require_semidefinite),
]
MassMatrix = Annotated[
    SixBySix[_Mass, _MassMoment, _Inertia],
    pydantic.AfterValidator(_require_symmetric),
    pydantic.AfterValidator(_require_definite),
]
InertiaMatrix = Annotated[
    Annotated[PerTurn[_Inertia], pydantic.Tag("diagonal")]
    | Annotated[Vector[Vector[_Inertia]], pydantic.Tag("matrix")],
    pydantic.Discriminator(_form_tag),
    pydantic.AfterValidator(_diagonal),
    pydantic.AfterValidator(_require_symmetric),
    pydantic.AfterValidator(_require_definite),
]
Name = Annotated[str, pydantic.AfterValidator(_valid_name)]
if TYPE_CHECKING:  # types after reading; a file may give names in place of a list
    Offsets = Six[float, float]
    Velocities = Six[float, float]
    Radii = Vector[float]
else:
    Offsets = _or_by_name(Six[Length, Angle], PerDof[Length, Angle], _listed_six)
    Velocities = _or_by_name(Six[Speed, TurnRate], PerDof[Speed, TurnRate], _listed_six)
    Radii = _or_by_name(Vector[Radius], PerTurn[Radius], _listed_turns)
Point = Vector[Length]
Direction = Vector[Component]
Times = Annotated[tuple[Instant, ...], pydantic.AfterValidator(require_entries), RISING]
Frequencies = Annotated[
    tuple[TableFrequency, ...], pydantic.AfterValidator(require_two_entries), RISING
]
WaveDensities = tuple[WaveDensity, ...]
Position = tuple[Length, Length]
Headings = Annotated[
    tuple[Angle, ...],
    pydantic.AfterValidator(require_entries),
    RISING,
    pydantic.AfterValidator(_require_full_headings),
]
StreamForces = tuple[_StreamForce, ...]
StreamMoments = tuple[_StreamMoment, ...]
Compressions = Annotated[tuple[Length, ...], RISING, pydantic.AfterValidator(require_start_at_zero)]
Extensions = Annotated[tuple[Length, ...], RISING]
Angles = Annotated[tuple[Angle, ...], RISING]
NormalForces = Annotated[
    tuple[Force, ...], NOT_FALLING, pydantic.AfterValidator(require_start_at_zero)
]
Stretch = Annotated[float, Quantity("stretch", "", "20 %", at_least=0, at_most=2)]
Stretches = Annotated[tuple[Stretch, ...], RISING, pydantic.AfterValidator(require_start_at_zero)]
RisingForces = Annotated[tuple[Force, ...], RISING, pydantic.AfterValidator(require_start_at_zero)]


# Keys of a mesh file: transformation of its coordinates to the database's frame.

Scale = Annotated[float, Quantity("scale", "", "0.001", above=0)]
Axis = Literal["x", "-x", "y", "-y", "z", "-z"]
Axes = tuple[Axis, Axis, Axis]


class MeshKeys(SchemaModel):
    """The coordinates of a file times ``scale``, turned so that its ``axes`` are x forward, y to
    port and z up, plus ``offset``. The still water is then ``waterline`` above z = 0."""

    scale: Scale = 1.0
    """Factor that turns the coordinates of the file into metres."""
    axes: Axes = ("x", "y", "z")
    """The axes of the file that point forward, to port and up, such as [x, -y, -z] for z down.
    Example: [x, -y, -z]."""
    offset: Point = (0.0, 0.0, 0.0)
    """Vector that is added to the scaled and turned coordinates."""
    waterline: Length = 0.0
    """Height of the still water above z = 0, after scale, axes and offset."""

    @pydantic.model_validator(mode="after")
    def _check_axes(self) -> Self:
        if round(np.linalg.det(self._turn())) != 1:
            found_text = f"axes [{', '.join(self.axes)}]"
            expected = "three different ones that turn the file, such as [x, -y, -z] for z down"
            raise problem(found_text, expected, "others make a mirror image, or no hull at all")
        return self

    def _turn(self) -> np.ndarray:
        """Matrix (3, 3) from the file's axes to the frame's."""
        return np.array(
            [
                (-1.0 if axis[0] == "-" else 1.0) * np.eye(3)["xyz".index(axis[-1])]
                for axis in self.axes
            ]
        )

    def to_database_frame(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) of the file in the database's frame."""
        lift = np.array([0.0, 0.0, self.waterline])
        return np.asarray(self.scale * points @ self._turn().T + np.array(self.offset) - lift)
