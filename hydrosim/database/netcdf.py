"""hydrosim's own database file: netCDF-4 with dimensions by name, all in SI.

Variables are those of `HydroDatabase`; a complex one has a last dimension ``complex`` (re, im).
DOFs are ``surge`` to ``yaw``; with several bodies, ``body1__surge`` and so on. Optional variables
may be absent. Packed numbers (``scale_factor``) are unpacked, and other units are refused. A
checksum over all numbers tells whether the file was changed. netCDF4 is used because importing
xarray takes longer than everything else; xarray can open the files all the same.
"""

from __future__ import annotations

from dataclasses import replace
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from hydrosim.database.database import HydroDatabase
from hydrosim.dofs import DOFS
from hydrosim.errors import InputError
from hydrosim.files import text
from hydrosim.files.interrupts import delay_interrupts
from hydrosim.scene.hydrodynamics import NOTHING_GIVEN, Given

if TYPE_CHECKING:
    import netCDF4

NAME = "hydrosim netCDF"
CHECKSUM_ATTRIBUTE = "checksum"  # attribute of a file: checksum of the database when it was written
NUMBERS_ATTRIBUTE = "numbers"
"""Attribute of a database: result of the comparison with that checksum."""
AS_WRITTEN, ALTERED = "as written", "altered"
_MOST_ALONG = 10_000  # frequencies, headings, pairs of headings
_MAX_NUMBERS = 10**8  # numbers in a file
FRAME_CONVENTION = (
    "origin on the still waterline, x forward, y to port, z up; headings: directions that"
    " waves go to"
)
PHASE_CONVENTION = "F(t) = Re{X a exp(+i w t)}, elevation at the origin Re{a exp(+i w t)}"


class StoredVariable(NamedTuple):
    """Storage of one array. A row of loads has the unit of a force or of a moment."""

    dimensions: tuple[str, ...]
    units: str
    long_name: str
    optional: bool = False
    is_complex: bool = False


_MATRIX = ("influenced_dof", "radiating_dof")
_LOADS = ("frequency", "heading", "influenced_dof")
_POINT = ("body", "axis")
_QTF = ("qtf_pair", "qtf_frequency", "qtf_frequency_2", "influenced_dof")

# Matrices and loads mix translations and rotations. With metres and radians every entry is in
# coherent SI, and the given unit is that of translations.
VARIABLES = {
    "frequency": StoredVariable(("frequency",), "rad s-1", "wave frequency"),
    "heading": StoredVariable(
        ("heading",), "rad", "direction the waves go to, counter-clockwise from x"
    ),
    "added_mass": StoredVariable(("frequency", *_MATRIX), "kg", "added mass"),
    "radiation_damping": StoredVariable(("frequency", *_MATRIX), "kg s-1", "radiation damping"),
    "added_mass_zero": StoredVariable(_MATRIX, "kg", "added mass at zero frequency", optional=True),
    "added_mass_infinite": StoredVariable(
        _MATRIX, "kg", "added mass at infinite frequency", optional=True
    ),
    "excitation": StoredVariable(
        _LOADS, "N m-1", "wave excitation per wave amplitude", False, True
    ),
    "froude_krylov": StoredVariable(
        _LOADS, "N m-1", "Froude-Krylov part of the excitation", True, True
    ),
    "mean_drift": StoredVariable(
        _LOADS, "N m-2", "mean drift load per wave amplitude squared", optional=True
    ),
    "drift_imbalance": StoredVariable(
        ("frequency", "heading"), "1", "relative energy imbalance of the mean drift", optional=True
    ),
    "mean_drift_held": StoredVariable(
        _LOADS, "N m-2", "mean drift load per amplitude squared on bodies held at rest", True
    ),
    "qtf_frequency": StoredVariable(
        ("qtf_frequency",), "rad s-1", "frequency of the first wave", True
    ),
    "qtf_heading": StoredVariable(("qtf_pair", "wave"), "rad", "directions of both waves", True),
    "qtf_difference": StoredVariable(
        _QTF, "N m-2", "difference-frequency quadratic transfer function", True, True
    ),
    "qtf_sum": StoredVariable(
        _QTF, "N m-2", "sum-frequency quadratic transfer function", True, True
    ),
    "hydrostatic_stiffness": StoredVariable(
        _MATRIX, "N m-1", "hydrostatic and gravity stiffness", optional=True
    ),
    "inertia_matrix": StoredVariable(_MATRIX, "kg", "inertia matrix of the body", optional=True),
    "volume": StoredVariable(("body",), "m3", "displaced volume", optional=True),
    "centre_of_buoyancy": StoredVariable(_POINT, "m", "centre of buoyancy", optional=True),
    "centre_of_gravity": StoredVariable(_POINT, "m", "centre of gravity", optional=True),
    "reference_point": StoredVariable(_POINT, "m", "point the coefficients refer to"),
    "water_depth": StoredVariable((), "m", "water depth, inf for deep water"),
    "water_density": StoredVariable((), "kg m-3", "density of the water"),
    "gravity": StoredVariable((), "m s-2", "gravitational acceleration"),
}


def sniff(path: Path, head: bytes) -> bool:
    """Whether it is a netCDF-4 file. This reader is asked last, so a damaged hydrosim file still
    gets a message about its missing parts."""
    return head.startswith(text.MAGIC)


def read(path: Path, given: Given = NOTHING_GIVEN) -> HydroDatabase:
    """Database in a netCDF file of this layout. Volumes and centres that the file lacks come from
    ``given``. Raises `InputError` for missing variables."""
    import netCDF4  # slow to load, and dry scenes have no databases

    if problem := text.fault(path):
        raise InputError(
            f"{path}: not a netCDF-4/HDF5 file ({problem}); expected a hydrosim database."
        )
    try:
        with delay_interrupts():  # netCDF4 loses an interrupt that arrives while it opens a file
            file = netCDF4.Dataset(path)
    except (OSError, RuntimeError) as error:
        raise InputError(f"{path}: cannot be read as netCDF ({error}).") from error
    with file:
        missing = [n for n, v in VARIABLES.items() if not v.optional and n not in file.variables]
        if missing:
            raise InputError(
                f"{path}: variable {', '.join(missing)} is missing; expected a hydrosim database"
                " with the layout of hydrosim.database.netcdf. Is it another program's file?"
            )
        _check_sizes(file)
        try:
            arrays = {
                n: _read_array(file, n, v) for n, v in VARIABLES.items() if n in file.variables
            }
        except RuntimeError as error:
            raise InputError(
                f"{path}: is damaged ({error}); expected a hydrosim database. Copy it again."
            ) from error
        texts = {name: str(file.getncattr(name)) for name in file.ncattrs()}
    symmetric = texts.pop("port_starboard_symmetric", "no") == "yes"
    written = texts.pop(CHECKSUM_ATTRIBUTE, None)
    db = HydroDatabase(
        source=str(path), port_starboard_symmetric=symmetric, attributes=texts, **arrays
    )
    if written is not None and texts.get(NUMBERS_ATTRIBUTE) != ALTERED:
        texts[NUMBERS_ATTRIBUTE] = AS_WRITTEN if db.checksum == written else ALTERED
    added = _given_body_values(given, path, db.bodies)
    lacking = {name: value for name, value in added.items() if getattr(db, name) is None}
    return replace(db, **lacking) if lacking else db


def _check_sizes(file: netCDF4.Dataset) -> None:
    """Raises `InputError` for implausibly large arrays, which a few damaged bytes may request."""
    for name in ("frequency", "heading", "qtf_frequency", "qtf_pair"):
        size = file.dimensions[name].size if name in file.dimensions else 0
        if size > _MOST_ALONG:
            raise InputError(
                f"{file.filepath()}: dimension {name} is {size:,}; expected at most"
                f" {_MOST_ALONG:,}. The file is damaged."
            )
    count = sum(file.variables[name].size for name in VARIABLES if name in file.variables)
    if count > _MAX_NUMBERS:
        raise InputError(
            f"{file.filepath()}: has {count:,} numbers; expected at most {_MAX_NUMBERS:,}. The file"
            " is damaged, or has more pairs of waves than needed."
        )


def write(db: HydroDatabase, path: Path) -> None:
    """Write the database; ``read`` returns the same numbers to the bit."""
    import netCDF4

    with netCDF4.Dataset(path, "w", format="NETCDF4") as file:
        file.setncatts(_database_attributes(db))
        _define_dimensions(file, db)
        for name, variable in VARIABLES.items():
            value = getattr(db, name)
            if value is not None:
                _write_variable(file, name, variable, value)


def dof_names(bodies: int) -> list[str]:
    """``surge`` to ``yaw``, with the prefix ``body1__`` and so on if there are several bodies."""
    if bodies == 1:
        return list(DOFS)
    return [f"{body}__{dof}" for body in body_names(bodies) for dof in DOFS]


def body_names(bodies: int) -> list[str]:
    """``body1``, ``body2`` and so on."""
    return [f"body{number + 1}" for number in range(bodies)]


def _read_array(file: netCDF4.Dataset, name: str, variable: StoredVariable) -> Any:
    stored = file.variables[name]
    expected = variable.dimensions + (("complex",) if variable.is_complex else ())
    if stored.dimensions != expected:
        raise InputError(
            f"{file.filepath()}: variable {name}: found the dimensions"
            f" {', '.join(stored.dimensions) or 'none'}; expected {', '.join(expected) or 'none'}."
            " Change the program that wrote the file, or convert the original database again."
        )
    units = str(getattr(stored, "units", variable.units))
    if units != variable.units:
        raise InputError(
            f"{file.filepath()}: variable {name}: found the unit {units!r}; expected"
            f" {variable.units!r}. Convert its numbers, and change the attribute units."
        )
    try:
        numbers = np.ma.filled(np.ma.asarray(stored[...]).astype(np.float64), np.nan)
        value = np.array(numbers, order="C")
    except (RuntimeError, ValueError, TypeError) as error:
        raise InputError(
            f"{file.filepath()}: variable {name} cannot be read ({error}). The file is damaged."
        ) from error
    if variable.is_complex:
        return value.view(np.complex128)[..., 0]
    return value if expected else float(value)


def _given_body_values(given: Given, path: Path, bodies: int) -> dict[str, Any]:
    """Given volumes and centres, in the shapes of the database."""
    shapes = {"volume": (bodies,), "centre_of_buoyancy": (bodies, 3)}
    shapes["centre_of_gravity"] = (bodies, 3)
    arrays = {}
    for name, shape in shapes.items():
        numbers = getattr(given, name)
        if numbers is not None and len(numbers) != prod(shape):
            raise InputError(
                f"{path}: {len(numbers)} numbers are given for the {name.replace('_', ' ')} of"
                f" {bodies} bodies; expected {prod(shape)}."
            )
        if numbers is not None:
            arrays[name] = np.reshape(np.array(numbers, dtype=float), shape)
    return arrays


def _database_attributes(db: HydroDatabase) -> dict[str, str]:
    standard = {
        "Conventions": "CF-1.11",
        "title": "Hydrodynamic database",
        "frame": FRAME_CONVENTION,
        "phase_convention": PHASE_CONVENTION,
        "port_starboard_symmetric": "yes" if db.port_starboard_symmetric else "no",
    }
    attributes = dict(db.attributes)
    if attributes.get(NUMBERS_ATTRIBUTE) != ALTERED:
        attributes.pop(NUMBERS_ATTRIBUTE, None)
    return {**standard, **attributes, CHECKSUM_ATTRIBUTE: db.checksum}


def _define_dimensions(file: netCDF4.Dataset, db: HydroDatabase) -> None:
    """Dimensions, and the labels of dimensions without numbers."""
    file.createDimension("frequency", db.frequency.size)
    file.createDimension("heading", db.heading.size)
    if db.qtf_frequency is not None and db.qtf_heading is not None:
        file.createDimension("qtf_frequency", db.qtf_frequency.size)
        file.createDimension("qtf_frequency_2", db.qtf_frequency.size)
        file.createDimension("qtf_pair", len(db.qtf_heading))
        file.createDimension("wave", 2)
    labels = {
        "influenced_dof": (dof_names(db.bodies), "degree of freedom of the load"),
        "radiating_dof": (dof_names(db.bodies), "degree of freedom of the motion"),
        "body": (body_names(db.bodies), "body"),
        "axis": (["x", "y", "z"], "axis of the database's frame"),
        "complex": (["re", "im"], "real and imaginary part"),
    }
    for name, (values, long_name) in labels.items():
        file.createDimension(name, len(values))
        variable = file.createVariable(name, str, (name,))
        variable.long_name = long_name
        variable[:] = np.array(values, dtype=object)


def _write_variable(file: netCDF4.Dataset, name: str, variable: StoredVariable, value: Any) -> None:
    numbers = np.asarray(value)
    dimensions = variable.dimensions
    if variable.is_complex:
        numbers = np.stack([numbers.real, numbers.imag], axis=-1)
        dimensions = (*dimensions, "complex")
    stored = file.createVariable(name, "f8", dimensions, zlib=bool(dimensions))
    stored.units, stored.long_name = variable.units, variable.long_name
    stored[...] = numbers
