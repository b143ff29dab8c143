"""Reader and writer of BEMIO's HDF5 file, the input of WEC-Sim and HydroChrono.

Groups ``simulation_parameters`` and ``body1``, ``body2``, ... have the rows of the body's six DOFs.
If ``scaled`` is 1, numbers are in SI units. Otherwise the file has A/rho, B/(rho w), X/(rho g),
C/(rho g) and drift/(rho g). Quadratic transfer functions are always in SI units: one group for each
DOF, flattened column by column, for one pair of headings. Phases are for exp(+i w t) and relative
to the elevation at the global origin. WEC-Sim takes each body's coefficients about its centre of
gravity. So does this reader, unless reference points are given. (WEC-Sim, writeBEMIOH5.m and
bodyClass.m.)

The transfer functions are read as WEC-Sim uses them: T(row, column) belongs to the wave of the row
and that of the column, conjugate in the difference. WEC-Sim's conversion of WAMIT files follows
this rule for difference frequencies, but conjugates sum-frequency functions: such a file has their
phases reversed.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hydrosim.database.changes import move_reference
from hydrosim.database.database import Complex, HydroDatabase, Real, require_array
from hydrosim.database.readers import assembly
from hydrosim.errors import InputError
from hydrosim.scene.hydrodynamics import NOTHING_GIVEN, Given

if TYPE_CHECKING:
    import h5py

# Writer: a database as BEMIO's HDF5 file.


def write(db: HydroDatabase, path: Path) -> None:
    """Write a BEMIO file with the coefficients about the centres of gravity.

    `bemio.read` returns numbers from such a file to the bit, other numbers to 2e-16. The file has
    no place for A(0), inertia, drift on held bodies, the imbalance of the drift, and transfer
    functions of more than one pair of headings. These are left out with a warning. WEC-Sim computes
    impulse responses itself.
    """
    import h5py  # slow to load, and dry scenes have no databases

    if not db.heading.size:
        raise InputError(
            f"{db.source}: has no wave loads, which a BEMIO file needs; write an .nc file."
        )
    centre = require_array(db, "centre_of_gravity")
    if not np.array_equal(centre, db.reference_point):
        db = move_reference(db, centre)
    pairs = 0 if db.qtf_heading is None else len(db.qtf_heading)
    if pairs > 1:
        warnings.warn(
            f"{path}: BEMIO files hold transfer functions of one pair of headings; those of"
            f" {pairs} are left out.",
            stacklevel=2,
        )
    image = BytesIO()  # HDF5 crashes if it cannot write to the disk
    with h5py.File(image, "w") as file:
        file["bem_data/code"] = np.bytes_(db.attributes.get("program", "hydrosim"))
        file.attrs["history"] = db.attributes.get("history", "")
        _write_parameters(db, file.create_group("simulation_parameters"))
        for body in range(db.bodies):
            group = file.create_group(f"body{body + 1}")
            rows = slice(6 * body, 6 * body + 6)
            _write_properties(db, body, group.create_group("properties"))
            _write_coefficients(db, rows, group.create_group("hydro_coeffs"))
            if pairs == 1:
                _write_transfer(db, rows, group["hydro_coeffs"], f"excitation/QTF{body + 1}")
    path.write_bytes(image.getbuffer())


def _write_parameters(db: HydroDatabase, group: h5py.Group) -> None:
    w, b = db.frequency, db.heading
    deep = np.isinf(db.water_depth)
    group["w"], group["T"] = w[:, None], 2 * np.pi / w[:, None]
    group["wave_dir"] = assembly.bitwise_inverse(np.radians, np.degrees(b), b)[:, None]
    group["water_depth"] = np.bytes_("infinite") if deep else [[db.water_depth]]
    group["rho"], group["g"], group["scaled"] = [[db.water_density]], [[db.gravity]], [[0.0]]


def _write_properties(db: HydroDatabase, body: int, group: h5py.Group) -> None:
    group["name"], group["body_number"] = np.bytes_(f"body{body + 1}"), [[body + 1.0]]
    group["dof"], group["dof_start"], group["dof_end"] = (
        [[6.0]],
        [[6 * body + 1.0]],
        [[6 * body + 6.0]],
    )
    group["cg"] = require_array(db, "centre_of_gravity")[body][:, None]
    if db.centre_of_buoyancy is not None:
        group["cb"] = db.centre_of_buoyancy[body][:, None]
    if db.volume is not None:
        group["disp_vol"] = [[db.volume[body]]]


def _write_coefficients(db: HydroDatabase, rows: slice, group: h5py.Group) -> None:
    density, weight = db.water_density, db.water_density * db.gravity
    damping = assembly.invertible_quotient(
        db.radiation_damping, density * db.frequency[:, None, None]
    )
    mass = assembly.invertible_quotient(db.added_mass, density)
    group["added_mass/all"] = mass[:, rows].transpose(1, 2, 0)
    group["radiation_damping/all"] = damping[:, rows].transpose(1, 2, 0)
    if db.added_mass_infinite is not None:
        group["added_mass/inf_freq"] = assembly.invertible_quotient(
            db.added_mass_infinite[rows], density
        )
    if db.hydrostatic_stiffness is not None:
        stiffness = db.hydrostatic_stiffness[rows, rows]
        group["linear_restoring_stiffness"] = assembly.invertible_quotient(stiffness, weight)
    if db.mean_drift is not None:
        drift = assembly.invertible_quotient(db.mean_drift[..., rows].transpose(2, 1, 0), weight)
        group["mean_drift/control_surface/val"] = drift
    loads = {"excitation": db.excitation, "excitation/froude-krylov": db.froude_krylov}
    if db.froude_krylov is not None:
        loads["excitation/scattering"] = db.excitation - db.froude_krylov
    for name, value in loads.items():
        if value is not None:
            _write_loads(value[..., rows].transpose(2, 1, 0), weight, group.require_group(name))


def _write_loads(value: Complex, weight: float, group: h5py.Group) -> None:
    real, imaginary = (
        assembly.invertible_quotient(value.real, weight),
        assembly.invertible_quotient(value.imag, weight),
    )
    group["re"], group["im"] = real, imaginary
    group["mag"], group["phase"] = np.hypot(real, imaginary), np.arctan2(imaginary, real)


def _write_transfer(db: HydroDatabase, rows: slice, group: h5py.Group, name: str) -> None:
    """For each DOF, a column of n^2 numbers; the index of the first wave varies fastest."""
    w = require_array(db, "qtf_frequency")
    period = assembly.bitwise_inverse(lambda T: 2 * np.pi / T, 2 * np.pi / w, w)
    pair = require_array(db, "qtf_heading")[0]
    degrees = assembly.bitwise_inverse(np.radians, np.degrees(pair), pair)
    for kind, transfer in (("Diff", db.qtf_difference), ("Sum", db.qtf_sum)):
        if transfer is None:
            continue
        for dof, transfer_of_dof in enumerate(np.moveaxis(transfer[0, ..., rows], -1, 0)):
            flat = transfer_of_dof.ravel(order="F")[:, None]
            inner = group.require_group(f"{name}/{kind}{dof + 1}")
            inner["PER_i"] = period[:, None]
            inner["BETA_i"], inner["BETA_j"] = (np.full((w.size, 1), angle) for angle in degrees)
            inner["Re_F_ij"], inner["Im_F_ij"] = flat.real, flat.imag
            inner["PHS_F_ij"] = np.degrees(np.angle(flat))


NAME = "BEMIO HDF5"

_PARAMETERS = "simulation_parameters"
_MAX_GRID_SIZE = 100_000  # frequencies, headings
_MOST_BODIES = 1000
_MOST_NUMBERS = 50_000_000  # of one variable
_DRIFT = ("momentum_conservation", "control_surface", "pressure_integration")


def sniff(path: Path, head: bytes) -> bool:
    """Whether it is an HDF5 file with the group of BEMIO's parameters, or a damaged file called
    .h5."""
    if not head.startswith(b"\x89HDF"):
        return False
    import h5py  # slow to load, and dry scenes have no databases

    try:
        with h5py.File(path) as file:
            return _PARAMETERS in file
    except (OSError, RuntimeError):
        return path.suffix.lower() == ".h5"


def read(path: Path, given: Given = NOTHING_GIVEN) -> HydroDatabase:
    """Database in a BEMIO file. Raises `InputError` for data that are missing, or whose shape does
    not match the numbers of frequencies, headings and bodies."""
    with _open_file(path) as file:
        return _read_database(_Source(file, path), given)


@contextmanager
def _open_file(path: Path) -> Iterator[h5py.File]:
    """The open file. All exceptions that HDF5 raises for a damaged file become `InputError`."""
    import h5py

    try:
        with h5py.File(path) as file:
            yield file
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, MemoryError) as error:
        raise InputError(
            f"{path}: HDF5 cannot read it ({str(error)[:200]}); expected a BEMIO file. Is it"
            " damaged or cut off?"
        ) from error


@dataclass(frozen=True)
class _Source:
    """An open file and its name."""

    file: h5py.File
    path: Path

    def optional(self, name: str, *shape: int) -> Real | None:
        """Variable in this ``shape``. None if it is absent or all NaN, which BEMIO writes for
        unknown data."""
        import h5py

        item = self.file.get(name)
        if item is None:
            return None
        if not isinstance(item, h5py.Dataset) or item.dtype.kind not in "fiu":
            raise InputError(f"{self.path}: {name} is not an array of numbers.")
        if item.size > _MOST_NUMBERS or (shape and item.size != np.prod(shape)):
            raise InputError(
                f"{self.path}: {name} has shape {item.shape}, expected {shape or 'fewer numbers'}."
                " Its shape follows from the numbers of w, wave_dir and bodies."
            )
        if len(item.shape) == len(shape) and item.shape != shape:
            raise InputError(f"{self.path}: {name} has shape {item.shape}, expected {shape}.")
        value = np.asarray(item[()], dtype=np.float64).reshape(shape or -1)
        if np.isnan(value).all() and value.size:
            return None
        if not (np.abs(value) < 1e60).all():
            raise InputError(f"{self.path}: {name} has values that are not numbers, or too large.")
        return value

    def require_variable(self, name: str, *shape: int) -> Real:
        """A variable that must exist."""
        value = self.optional(name, *shape)
        if value is None:
            raise InputError(
                f"{self.path}: found no {name}, or NaN only; expected numbers, as in every BEMIO"
                " file. Write the file again with BEMIO."
            )
        return value

    def positive(self, name: str) -> float:
        """A parameter above zero."""
        value = float(self.require_variable(f"{_PARAMETERS}/{name}", 1)[0])
        if not 1e-6 < value < 1e9:
            raise InputError(f"{self.path}: {name} is {value:g}, expected a positive number.")
        return value


@dataclass(frozen=True)
class _Layout:
    """Sizes, orders for ascending frequencies and headings, and factors to SI units."""

    bodies: int
    frequency: Real
    heading: Real
    by_frequency: Any
    by_heading: Any
    density: float
    weight: float  # rho g
    rate: Real  # (nw,): w

    @property
    def waves(self) -> tuple[int, int]:
        """Numbers of headings and frequencies."""
        return self.heading.size, self.frequency.size


def _read_database(source: _Source, given: Given) -> HydroDatabase:
    layout = _read_layout(source)
    excitation = _read_loads(source, layout, "excitation")
    if excitation is None:
        lacking = _missing_bodies_text(source, layout.bodies, "hydro_coeffs/excitation/re")
        raise InputError(
            f"{source.path}: {lacking} has no hydro_coeffs/excitation/re, or no .../im; expected"
            " both for every body. Write the file again with them."
        )
    added_mass = _read_matrices(source, layout, "added_mass/all") * layout.density
    damping = _read_matrices(source, layout, "radiation_damping/all")
    damping = damping * (layout.density * layout.rate[:, None, None])
    drift, method = _mean_drift(source, layout)
    symmetric = given.port_starboard_symmetric
    if symmetric is None:
        symmetric = assembly.are_bodies_symmetric(added_mass, layout.heading, excitation)
    points, assumed = _read_points(source, given, layout.bodies), ""
    if points["reference_point"] is None:
        points["reference_point"] = points["centre_of_gravity"]
        assumed = "reference points at the centres of gravity"
    if points["reference_point"] is None:
        raise InputError(
            f"{source.path}: {_missing_bodies_text(source, layout.bodies, 'properties/cg')} has no"
            " properties/cg; expected one for every body. Write the file again with it, or give"
            " reference_point under `hydrodynamics` in the case."
        )
    remarks = {"assumed": assumed, "mean_drift_method": method, "program": _program_name(source)}
    by_frequency: dict[str, Any] = {
        "added_mass": added_mass,
        "radiation_damping": damping,
        "excitation": excitation,
        "froude_krylov": _read_loads(source, layout, "excitation/froude-krylov"),
        "mean_drift": drift,
    }
    frequency, by_frequency = assembly.drop_unused_frequencies(
        layout.frequency, by_frequency, given.frequencies
    )
    return HydroDatabase(
        source=str(source.path),
        frequency=frequency,
        heading=layout.heading,
        added_mass_infinite=_read_infinite_added_mass(source, layout),
        **by_frequency,
        **_read_second_order(source, layout.bodies),
        hydrostatic_stiffness=_read_stiffness(source, layout),
        **points,
        water_depth=_read_depth(source),
        water_density=source.positive("rho"),
        gravity=source.positive("g"),
        port_starboard_symmetric=symmetric,
        attributes={name: text for name, text in remarks.items() if text},
    )


def _read_layout(source: _Source) -> _Layout:
    bodies = sum(f"body{i + 1}" in source.file for i in range(_MOST_BODIES))
    w = source.require_variable(f"{_PARAMETERS}/w")
    degrees = source.require_variable(f"{_PARAMETERS}/wave_dir")
    if (
        not bodies
        or not 0 < w.size <= _MAX_GRID_SIZE
        or not 0 < degrees.size <= _MAX_GRID_SIZE
        or w.min() <= 0
    ):
        raise InputError(
            f"{source.path}: {bodies} bodies, {degrees.size} headings (wave_dir) and {w.size}"
            f" frequencies (w, from {w.min(initial=np.inf):g}); expected at least one of each,"
            " and frequencies above zero."
        )
    scaled = source.optional(f"{_PARAMETERS}/scaled", 1)
    si = scaled is not None and bool(scaled[0])
    density = source.positive("rho")
    by_frequency, by_heading = np.argsort(w), np.argsort(degrees)
    return _Layout(
        bodies,
        w[by_frequency],
        np.radians(degrees[by_heading]),
        by_frequency,
        by_heading,
        1.0 if si else density,
        1.0 if si else density * source.positive("g"),
        np.ones_like(w) if si else w[by_frequency],
    )


def _read_rows(source: _Source, bodies: int, name: str, *shape: int) -> Real | None:
    """Variables of all bodies (6 nb, ...); None if any body lacks it."""
    parts = [source.optional(f"body{i + 1}/{name}", 6, *shape) for i in range(bodies)]
    given_parts = [part for part in parts if part is not None]
    return np.concatenate(given_parts) if len(given_parts) == bodies else None


def _missing_bodies_text(source: _Source, bodies: int, name: str) -> str:
    """The first body without a variable, such as "body2"; "body1" if all have it."""
    names = [f"body{i + 1}" for i in range(bodies)]
    return next((body for body in names if source.optional(f"{body}/{name}") is None), names[0])


def _read_matrices(source: _Source, layout: _Layout, name: str) -> Real:
    name, n = f"hydro_coeffs/{name}", 6 * layout.bodies
    value = _read_rows(source, layout.bodies, name, n, layout.frequency.size)
    if value is None:
        lacking = _missing_bodies_text(source, layout.bodies, name)
        raise InputError(
            f"{source.path}: {lacking} has no {name}; expected one for every body. Write the file"
            " again with it."
        )
    return np.ascontiguousarray(value.transpose(2, 0, 1)[layout.by_frequency])


def _read_infinite_added_mass(source: _Source, layout: _Layout) -> Real | None:
    name = "hydro_coeffs/added_mass/inf_freq"
    value = _read_rows(source, layout.bodies, name, 6 * layout.bodies)
    return None if value is None else value * layout.density


def _sort_frequencies(layout: _Layout, value: Real) -> Real:
    """Loads (nw, nh, n) from (n, nh, nw) in the file's order."""
    value = value.transpose(2, 1, 0)[layout.by_frequency][:, layout.by_heading]
    return np.ascontiguousarray(value)


def _read_loads(source: _Source, layout: _Layout, name: str) -> Complex | None:
    name = f"hydro_coeffs/{name}"
    real, imaginary = (
        _read_rows(source, layout.bodies, f"{name}/{part}", *layout.waves) for part in ("re", "im")
    )
    if real is None or imaginary is None:
        return None
    value = np.empty((*real.shape[::-1],), dtype=complex)
    value.real, value.imag = (
        _sort_frequencies(layout, part) * layout.weight for part in (real, imaginary)
    )
    return value


def _mean_drift(source: _Source, layout: _Layout) -> tuple[Real | None, str]:
    momentum, control_surface, pressure = (
        None if value is None else _sort_frequencies(layout, value) * layout.weight
        for value in (
            _read_rows(source, layout.bodies, f"hydro_coeffs/mean_drift/{name}/val", *layout.waves)
            for name in _DRIFT
        )
    )
    return assembly.preferred_drift(momentum, control_surface, pressure, layout.bodies)


def _read_stiffness(source: _Source, layout: _Layout) -> Real | None:
    value = _read_rows(source, layout.bodies, "hydro_coeffs/linear_restoring_stiffness", 6)
    if value is None:
        return None
    matrix = np.zeros((6 * layout.bodies, 6 * layout.bodies))
    for i in range(0, 6 * layout.bodies, 6):
        matrix[i : i + 6, i : i + 6] = value[i : i + 6] * layout.weight
    return matrix


def _read_points(source: _Source, given: Given, bodies: int) -> dict[str, Any]:
    """Volumes and centres, and reference points if they are given."""
    theirs = {"volume": "disp_vol", "centre_of_buoyancy": "cb", "centre_of_gravity": "cg"}
    points: dict[str, Any] = {}
    for name in (*theirs, "reference_point"):
        per_body = 1 if name == "volume" else 3
        value = getattr(given, name)
        if value is not None and len(value) != bodies * per_body:
            raise InputError(
                f"{source.path}: {name.replace('_', ' ')} is given as {len(value)} numbers,"
                f" expected {bodies * per_body} for {bodies} bodies."
            )
        if name in theirs:
            parts = [
                source.optional(f"body{i + 1}/properties/{theirs[name]}", per_body)
                for i in range(bodies)
            ]
            given_parts = [part for part in parts if part is not None]
            value = np.concatenate(given_parts) if len(given_parts) == bodies else value
        shape = (bodies,) if per_body == 1 else (bodies, per_body)
        points[name] = None if value is None else np.array(value, dtype=float).reshape(shape)
    return points


def _read_depth(source: _Source) -> float:
    """A number, or a word for deep water."""
    item = source.file.get(f"{_PARAMETERS}/water_depth")
    if item is not None and item.dtype.kind in "SO" and item.size == 1:
        word = _decode_text(item)
        if word.lower() in ("infinite", "inf"):
            return float(np.inf)
        raise InputError(f"{source.path}: water_depth is {word[:40]!r}, expected 'infinite'.")
    if item is not None and item.dtype.kind == "f" and item.size == 1 and np.isinf(item[()]).all():
        return float(np.inf)
    return source.positive("water_depth")


def _program_name(source: _Source) -> str:
    item = source.file.get("bem_data/code")
    return (
        _decode_text(item)
        if item is not None and item.dtype.kind in "SO" and item.size == 1
        else ""
    )


def _decode_text(item: h5py.Dataset) -> str:
    value = np.asarray(item[()]).ravel()[0]
    return value.decode("latin-1") if isinstance(value, bytes) else str(value)


def _read_second_order(source: _Source, bodies: int) -> dict[str, Any]:
    """The items of the database on quadratic transfer functions."""
    arrays: dict[str, Any] = {}
    for name, kind in (("qtf_difference", "Diff"), ("qtf_sum", "Sum")):
        groups = [
            f"body{b + 1}/hydro_coeffs/excitation/QTF{b + 1}/{kind}{dof + 1}"
            for b in range(bodies)
            for dof in range(6)
        ]
        if all(f"{group}/Re_F_ij" in source.file for group in groups):
            frequency, pair, arrays[name] = _read_quadratic_transfer(source, groups)
            first = (
                arrays.setdefault("qtf_frequency", frequency),
                arrays.setdefault("qtf_heading", pair),
            )
            if not (np.array_equal(first[0], frequency) and np.array_equal(first[1], pair)):
                raise InputError(
                    f"{source.path}: the sum-frequency QTF has other periods or headings than the"
                    " difference-frequency QTF; expected the same."
                )
    return arrays


def _read_quadratic_transfer(source: _Source, groups: list[str]) -> tuple[Real, Real, Complex]:
    """Frequencies (nq,), headings (1, 2), and T (1, nq, nq, n)."""
    period = source.require_variable(f"{groups[0]}/PER_i")
    nq = period.size
    if not 0 < nq <= 2000 or period.min() <= 1e-4 or np.unique(period).size < nq:
        raise InputError(
            f"{source.path}: {groups[0]}/PER_i has {nq} periods from {period.min(initial=0.0):g} s;"
            " expected up to 2000, all positive and different."
        )
    angles = [source.require_variable(f"{groups[0]}/BETA_{x}", nq) for x in "ij"]
    if any(np.ptp(angle) > 0 for angle in angles):
        raise InputError(f"{source.path}: {groups[0]} has several headings, expected one pair.")
    order = np.argsort(-period)
    T = np.empty((1, nq, nq, len(groups)), dtype=complex)
    for dof, group in enumerate(groups):
        if not np.array_equal(source.require_variable(f"{group}/PER_i", nq), period):
            raise InputError(f"{source.path}: {group}/PER_i differs from that of the first DOF.")
        parts = [
            source.require_variable(f"{group}/{part}_F_ij", nq * nq).reshape(nq, nq, order="F")
            for part in ("Re", "Im")
        ]
        T[0, ..., dof].real, T[0, ..., dof].imag = (part[order][:, order] for part in parts)
    return 2 * np.pi / period[order], np.radians([[angles[0][0], angles[1][0]]]), T
