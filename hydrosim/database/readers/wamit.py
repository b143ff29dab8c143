"""WAMIT's numeric output: name.1, .3 and the other files of the set beside them.

Files: .1; one of .3, .2 or .3fk + .3sc in this order (a set without them has no loads); .3fk; .8 .9
.7 (mean drift); one each of .12d .11d .10d and .12s .11s .10s; .hst, .mmx, .gdf, .pot, .out. Rows
may be in any order, and pairs of DOFs that are zero by symmetry may be absent. Numbers are
dimensionless, with the length L of .out, .mmx or .gdf, and with the density of .out:

    A = rho L^k A',  B = rho w L^k B'                k = 3 + number of rotations among I, J
    X = rho g L^m X',  C = rho g L^k C'              m, k = 2 + number of rotations
    second order: F = rho g L^m F'                   m = 1 + rotation

The time factor is exp(+i w t), and phases refer to the elevation at the global origin. Headings are
directions that waves go to. Coefficients refer to each body's origin (XBODY of .out or .pot). Data
that neither a file nor the user gives are assumed, and the attribute ``assumed`` says so. Rows of
negative I in the drift files are left out. (WAMIT user manual, version 7.4, chapters 4 and 5.)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from hydrosim.database.database import Complex, HydroDatabase, Real
from hydrosim.database.readers import wamit_header
from hydrosim.database.readers.assembly import are_bodies_symmetric, preferred_drift
from hydrosim.database.readers.text import Index, NumberTable, read_table
from hydrosim.database.readers.wamit_writer import write as write
from hydrosim.errors import InputError
from hydrosim.scene import hydrodynamics

NAME = "WAMIT"

_EXCITATION = (".3", ".2")
_DRIFT = (".8", ".7", ".9")  # momentum, control surface, pressure
_DIFFERENCE = (".12d", ".11d", ".10d")  # complete by two methods, quadratic part alone
_SUM = (".12s", ".11s", ".10s")
_NUMERIC = {".1", ".3fk", ".3sc", ".hst", ".mmx", *_EXCITATION, *_DRIFT, *_DIFFERENCE, *_SUM}
_TEXT = {".out", ".pot", ".gdf"}

_NOTHING = hydrodynamics.NOTHING_GIVEN
_ASSUMED = _NOTHING.with_values(
    length=1.0, water_density=1025.0, gravity=9.80665, water_depth=np.inf
)
_FREQUENCY_RTOL = 1e-4  # relative difference of equal frequencies, printed with 5 to 7 digits
_SAME_DEGREES = 1e-3
_HIGHEST_INDEX = 6000
_LONG = 0.3  # of the largest heave load: larger ones belong to long waves


@dataclass(frozen=True)
class WamitUnits:
    """Factors that convert the numbers of ``bodies`` bodies to SI units."""

    bodies: int
    length: float
    density: float
    gravity: float
    depth: float
    column: hydrodynamics.FrequencyColumn

    @property
    def rotations(self) -> Real:
        """Rotations (n,): 1 for roll, pitch, yaw."""
        return np.tile([0.0, 0.0, 0.0, 1.0, 1.0, 1.0], self.bodies)

    def matrix(self, power: int) -> Real:
        """Factors (n, n): the length to ``power`` plus one for each rotation."""
        return self.length ** (power + self.rotations[:, None] + self.rotations)

    def load(self, power: int) -> Real:
        """Factors (n,): rho g times the length to ``power`` plus one for a rotation."""
        return self.density * self.gravity * self.length ** (power + self.rotations)

    def frequency(self, table: NumberTable, column: int) -> Real:
        """Frequency of each row [rad/s]; zero and infinity where the column has their codes."""
        value = table.values[:, column]
        w = angular(self.column, value, self)
        wrong = np.isfinite(w) & (w > 0) & ((w < 1e-5) | (w > 1e4))
        if wrong.any():
            row = int(np.argmax(wrong))
            expected = f"a {self.column} of waves (see frequency_column)"
            raise table.problem(row, f"{value[row]:g}", expected)
        return w


def angular(column: hydrodynamics.FrequencyColumn, value: Real, units: WamitUnits) -> Real:
    """Frequency [rad/s]. A zero period is infinite frequency, a negative one zero frequency. For
    frequencies and wavenumbers, zero is zero and a negative value is infinity."""
    size = np.maximum(np.abs(value), 1e-30)
    k = size / units.length
    if column is hydrodynamics.FrequencyColumn.PERIOD:
        return np.where(value > 0, 2 * np.pi / size, np.where(value < 0, 0.0, np.inf))
    if column is hydrodynamics.FrequencyColumn.FREQUENCY:
        w = size
    elif column is hydrodynamics.FrequencyColumn.DEEP_WAVENUMBER:
        w = np.sqrt(units.gravity * k)
    else:
        w = np.sqrt(units.gravity * k * np.tanh(k * units.depth))
    return np.where(value > 0, w, np.where(value < 0, np.inf, 0.0))


def sniff(path: Path, head: bytes) -> bool:
    """Whether the suffix fits; the main output and the geometry count only beside a .1 file."""
    suffix = path.suffix.lower()
    return suffix in _NUMERIC or (suffix in _TEXT and ".1" in _find_files(path))


def read(path: Path, given: hydrodynamics.Given = hydrodynamics.NOTHING_GIVEN) -> HydroDatabase:
    """Database of the set that the file ``path`` belongs to. A name without suffix is the name of
    the set. Raises `InputError` if files are missing, malformed or inconsistent."""
    files = _find_files(path)
    if ".1" not in files:
        raise InputError(f"{path.with_suffix('.1')}: no such file; expected WAMIT's added mass.")
    radiation = read_table(files[".1"], (4, 5))
    bodies = -(-int(_read_dofs(radiation, 1, _HIGHEST_INDEX).max() + 1) // 6)
    excitation = _excitation_tables(path, files)
    facts, assumed = _read_header(path, files, given, bodies)
    units, remark = _choose_units(facts, bodies, radiation, excitation)
    return _build_database(path, files, facts, units, radiation, excitation, [*assumed, *remark])


def _build_database(
    path: Path,
    files: dict[str, Path],
    facts: hydrodynamics.Given,
    units: WamitUnits,
    radiation: NumberTable,
    excitation: list[NumberTable],
    assumed: list[str],
) -> HydroDatabase:
    frequency, added_mass, damping, limits = _read_radiation(radiation, units)
    heading = np.unique(excitation[0].values[:, 1]) if excitation else np.zeros(0)
    total = np.zeros((frequency.size, heading.size, 6 * units.bodies), dtype=complex)
    for table in excitation:
        total += _read_loads(table, units, frequency, heading)
    part = read_table(files[".3fk"], (7,)) if ".3fk" in files else None
    drift, method = _mean_drift(files, units, frequency, heading) if excitation else (None, "")
    symmetric = facts.port_starboard_symmetric
    if symmetric is None:
        symmetric = are_bodies_symmetric(added_mass, np.radians(heading), total)
    remarks = {"assumed": ", ".join(assumed), "mean_drift_method": method}
    return HydroDatabase(
        source=str(path),
        frequency=frequency,
        heading=np.radians(heading),
        added_mass=added_mass,
        radiation_damping=damping,
        added_mass_zero=limits.get(0.0),
        added_mass_infinite=limits.get(np.inf),
        excitation=total,
        froude_krylov=None if part is None else _read_loads(part, units, frequency, heading),
        mean_drift=drift,
        **(_read_second_order(files, units) if excitation else {}),
        hydrostatic_stiffness=_read_stiffness(files, units),
        inertia_matrix=_read_inertia(files, units),
        **_read_points(path, facts, units.bodies),
        water_depth=units.depth,
        water_density=units.density,
        gravity=units.gravity,
        port_starboard_symmetric=symmetric,
        attributes={"program": NAME, **{name: text for name, text in remarks.items() if text}},
    )


def _find_files(path: Path) -> dict[str, Path]:
    """The files of the set by their suffixes in lower case. Names may differ in case, as they may
    under Windows; the file with the same case is preferred."""
    suffixes = _NUMERIC | _TEXT
    stem = path.stem if path.suffix.lower() in suffixes else path.name
    beside = path.parent.iterdir() if path.parent.is_dir() else ()
    alike = [p for p in beside if p.stem.lower() == stem.lower() and p.suffix.lower() in suffixes]
    return {p.suffix.lower(): p for p in sorted(alike, key=lambda p: (p.stem == stem, p.name))}


def _excitation_tables(path: Path, files: dict[str, Path]) -> list[NumberTable]:
    """Tables whose sum is the excitation; empty for a set without loads."""
    for suffix in _EXCITATION:
        if suffix in files:
            return [read_table(files[suffix], (7,))]
    if ".3fk" in files and ".3sc" in files:
        return [read_table(files[suffix], (7,)) for suffix in (".3fk", ".3sc")]
    if lone := {".3fk", ".3sc"} & files.keys():
        raise InputError(
            f"{path.with_suffix('.3')}: no such file, and {', '.join(lone)} without its other half;"
            " expected WAMIT's excitation in .3, in .2 or in .3fk and .3sc."
        )
    return []


def _read_header(
    path: Path, files: dict[str, Path], given: hydrodynamics.Given, bodies: int
) -> tuple[hydrodynamics.Given, list[str]]:
    """Header data of all files, and the names of data that were assumed."""
    readers: dict[str, Callable[[Path], hydrodynamics.Given]] = {
        ".out": wamit_header.main_output,
        ".pot": wamit_header.control_file,
        ".mmx": wamit_header.matrix_file,
        ".gdf": wamit_header.geometry_file,
    }
    file_facts = hydrodynamics.first_given(
        *(read(files[suffix]) for suffix, read in readers.items() if suffix in files)
    )
    origin = hydrodynamics.first_given(
        file_facts, given, _NOTHING.with_values(reference_point=(0.0,) * 3 * bodies)
    ).reference_point
    where = ", ".join(str(files[suffix]) for suffix in readers if suffix in files) or str(path)
    _check_units(where, hydrodynamics.first_given(file_facts, given, _ASSUMED))
    _check_bodies(where, file_facts, bodies)
    file_facts = file_facts.with_values(
        centre_of_buoyancy=_shift_points(file_facts.centre_of_buoyancy, origin),
        centre_of_gravity=_shift_points(file_facts.centre_of_gravity, origin),
    )
    facts = hydrodynamics.first_given(file_facts, given)
    assumed = [
        f"{name.replace('_', ' ')} {getattr(_ASSUMED, name):g}"
        for name in ("length", "water_density", "gravity", "water_depth")
        if getattr(facts, name) is None
    ]
    if facts.reference_point is None:
        assumed.append(hydrodynamics.ORIGIN_ASSUMED)
    return hydrodynamics.first_given(
        facts, _ASSUMED, _NOTHING.with_values(reference_point=origin)
    ), assumed


def _check_units(where: str, facts: hydrodynamics.Given) -> None:
    """Raises `InputError` if the numbers cannot be in SI units."""
    ranges = {
        "length": (1e-3, 1e4),
        "gravity": (9.0, 11.0),
        "water_density": (500.0, 2000.0),
        "water_depth": (1e-3, np.inf),
    }
    for name, (lowest, highest) in ranges.items():
        value = getattr(facts, name)
        if not lowest <= value <= highest:
            raise InputError(
                f"{where}: {name.replace('_', ' ')} is {value:g}, expected {lowest:g} to"
                f" {highest:g} in SI units. Was WAMIT run in feet? Convert its files first."
            )


def _check_bodies(where: str, particulars: hydrodynamics.Given, bodies: int) -> None:
    """Raises `InputError` if the headers have another number of bodies."""
    for name in ("volume", "reference_point", "centre_of_buoyancy", "centre_of_gravity"):
        items, per_body = getattr(particulars, name), 1 if name == "volume" else 3
        if items is not None and len(items) != bodies * per_body:
            raise InputError(
                f"{where}: {name.replace('_', ' ')} is given for {len(items) // per_body} bodies,"
                f" but the .1 file has {bodies}. Generalised modes are not supported."
            )


def _shift_points(points: tuple[float, ...] | None, by: tuple[float, ...] | None) -> tuple | None:
    if points is None or by is None or len(points) != len(by):
        return points
    return tuple(p + b for p, b in zip(points, by, strict=True))


def _read_points(path: Path, facts: hydrodynamics.Given, bodies: int) -> dict[str, Any]:
    """Fields of the database about bodies, not waves."""
    arrays = {}
    for name in ("volume", "centre_of_buoyancy", "centre_of_gravity", "reference_point"):
        items, shape = getattr(facts, name), (bodies,) if name == "volume" else (bodies, 3)
        if items is not None and len(items) != np.prod(shape):
            raise InputError(
                f"{path}: {name.replace('_', ' ')} is given as {len(items)} numbers, expected"
                f" {np.prod(shape)} for {bodies} bodies."
            )
        arrays[name] = None if items is None else np.array(items, dtype=float).reshape(shape)
    return arrays


def _choose_units(
    facts: hydrodynamics.Given, bodies: int, radiation: NumberTable, excitation: list[NumberTable]
) -> tuple[WamitUnits, list[str]]:
    """Units, and a remark if the kind of the first column is a guess."""
    names = ("length", "water_density", "gravity", "water_depth")
    length, density, gravity, depth = (float(getattr(facts, name)) for name in names)
    units = WamitUnits(
        bodies, length, density, gravity, depth, hydrodynamics.FrequencyColumn.PERIOD
    )
    if facts.frequency_column is not None:
        return replace(units, column=facts.frequency_column), []
    guess = hydrodynamics.FrequencyColumn.PERIOD
    if excitation:
        guess = _guessed_column(units, radiation, excitation[0])
    return replace(units, column=guess), [f"first column {guess}"]


def _guessed_column(
    units: WamitUnits, radiation: NumberTable, excitation: NumberTable
) -> hydrodynamics.FrequencyColumn:
    """By Haskind's relation, w^2 L/g = 2 B33'/|X3'|^2 in deep water if the heave load does not
    depend on the heading. This nearly holds in long waves (Newman 1962, J. Ship Research 6)."""
    heave = radiation.select_rows((radiation.values[:, 1:3] == 3).all(axis=1)).values
    loads = excitation.select_rows(excitation.values[:, 2] == 3).values
    both = [x for x in heave[:, 0] if x > 0 and x in loads[:, 0]]
    square = np.array([np.mean(loads[loads[:, 0] == x, 3] ** 2) for x in both])
    damping = heave[np.isin(heave[:, 0], both), 4]
    is_reliable = (square > _LONG**2 * square.max(initial=0.0)) & (damping > 0)
    value, expected = np.array(both)[is_reliable], 2 * damping[is_reliable] / square[is_reliable]
    errors = {
        column: float(np.median(np.abs(np.log(_deep_number(column, value, units) / expected))))
        for column in hydrodynamics.FrequencyColumn
        if column is not hydrodynamics.FrequencyColumn.WAVENUMBER and is_reliable.any()
    }
    return min(
        errors, key=lambda column: errors[column], default=hydrodynamics.FrequencyColumn.PERIOD
    )


def _deep_number(column: hydrodynamics.FrequencyColumn, value: Real, units: WamitUnits) -> Real:
    return angular(column, value, units) ** 2 * units.length / units.gravity


def _read_dofs(table: NumberTable, column: int, highest: int) -> Index:
    """Indices from zero of DOFs in one column, or in two for .1 and .hst."""
    both = [table.whole_numbers(c, 1, highest) for c in (column, column + 1)]
    return np.stack(both) - 1


def _read_radiation(
    table: NumberTable, units: WamitUnits
) -> tuple[Real, Real, Real, dict[float, Real]]:
    """Frequencies, A, B, and A at the frequencies zero and infinity."""
    n = 6 * units.bodies
    every, row = np.unique(units.frequency(table, 0), return_inverse=True)
    index, shape = (row, *_read_dofs(table, 1, n)), (every.size, n, n)
    mass = _require_complete(table, table.fill_array(index, shape, table.values[:, 3]), every)
    damping = table.fill_array(index, shape, table.values[:, 4])
    waves = np.isfinite(every) & (every > 0)
    lacking = np.isnan(table.values[:, 4]) & waves[row]
    if lacking.any():
        raise table.problem(int(np.argmax(lacking)), "4 columns", "damping in the fifth")
    if not waves.any():
        raise table.problem(0, "no frequency above zero", "at least one")
    mass *= units.density * units.matrix(3)
    factor = units.density * units.matrix(3) * every[waves, None, None]
    limits = {float(w): mass[i] for i, w in enumerate(every) if not waves[i]}
    return every[waves], mass[waves], np.nan_to_num(damping[waves]) * factor, limits


def _require_complete(table: NumberTable, array: Any, frequency: Real) -> Any:
    """Array (nw, ...) with zero for entries that no frequency has. Raises `InputError` for an entry
    that only some frequencies have."""
    absent = np.isnan(array)
    lost = absent & ~absent.all(axis=0)
    if lost.any():
        place = np.unravel_index(int(np.argmax(lost)), lost.shape)
        indices = " ".join(str(int(i) + 1) for i in place[1:])
        raise InputError(
            f"{table.path}, line {table.line[-1]}: found the end and no row {indices} for"
            f" {frequency[place[0]]:.6g} rad/s, expected one as for other frequencies. Is the file"
            " cut off?"
        )
    return np.where(absent, 0.0, array)


def _nearest_grid_index(
    table: NumberTable, column: int, values: Real, grid: Real, same: Real | float
) -> Index:
    """Position of each row's value in the grid. Raises `InputError` for a value that is not in the
    grid."""
    order = np.argsort(grid)
    middle = (grid[order][1:] + grid[order][:-1]) / 2
    place = order[np.searchsorted(middle, values)]
    wrong = np.abs(grid[place] - values) > same
    if wrong.any():
        row = int(np.argmax(wrong))
        expected = f"one of the {grid.size} values of the other tables"
        raise table.problem(row, f"{table.values[row, column]:g} in column {column + 1}", expected)
    return place


def _fill_grid(
    table: NumberTable, units: WamitUnits, frequency: Real, heading: Real, dof_column: int
) -> Real:
    """Real and imaginary parts (2, nw, nh, n) of a table of loads, NaN for missing ones."""
    w = units.frequency(table, 0)
    waves = np.isfinite(w) & (w > 0)
    table, w = table.select_rows(waves), w[waves]
    n = 6 * units.bodies
    index = (
        _nearest_grid_index(table, 0, w, frequency, _FREQUENCY_RTOL * w),
        _nearest_grid_index(table, 1, table.values[:, 1], heading, _SAME_DEGREES),
        table.whole_numbers(dof_column, 1, n) - 1,
    )
    shape = (frequency.size, heading.size, n)
    return np.stack([table.fill_array(index, shape, table.values[:, -part]) for part in (2, 1)])


def _fill_missing_dofs(table: NumberTable, loads: Real, frequency: Real, heading: Real) -> Real:
    """Loads (nw, nh, n) with zero for DOFs that the table never has. Raises `InputError` for a DOF
    that it has for some waves only."""
    nw, nh, n = loads.shape
    waves = np.repeat(frequency, nh)
    return _require_complete(table, loads.reshape(nw * nh, n), waves).reshape(loads.shape)


def _read_loads(table: NumberTable, units: WamitUnits, frequency: Real, heading: Real) -> Complex:
    parts = _fill_grid(table, units, frequency, heading, 2)
    real, imaginary = (_fill_missing_dofs(table, part, frequency, heading) for part in parts)
    return np.asarray((real + 1j * imaginary) * units.load(2))


def _mean_drift(
    files: dict[str, Path], units: WamitUnits, frequency: Real, heading: Real
) -> tuple[Real | None, str]:
    momentum, control_surface, pressure = (
        _read_drift(read_table(files[suffix], (8,)), units, frequency, heading)
        if suffix in files
        else None
        for suffix in _DRIFT
    )
    return preferred_drift(momentum, control_surface, pressure, units.bodies)


def _read_drift(table: NumberTable, units: WamitUnits, frequency: Real, heading: Real) -> Real:
    """Drift from the rows with equal headings; other rows belong to a transfer function."""
    table.whole_numbers(3, -6 * units.bodies, 6 * units.bodies)
    is_same_heading = np.abs(table.values[:, 1] - table.values[:, 2]) < _SAME_DEGREES
    table = table.select_rows(is_same_heading & (table.values[:, 3] > 0))
    if not table.line.size:
        raise InputError(f"{table.path}: no row has equal headings and I > 0, expected some.")
    real = _fill_grid(table, units, frequency, heading, 3)[0]
    return _fill_missing_dofs(table, real, frequency, heading) * units.load(1)


def _read_second_order(files: dict[str, Path], units: WamitUnits) -> dict[str, Any]:
    """Fields of the database on quadratic transfer functions."""
    tables = {
        name: read_table(files[suffixes_there[0]], (9,))
        for name, suffixes in (("qtf_difference", _DIFFERENCE), ("qtf_sum", _SUM))
        if (suffixes_there := [suffix for suffix in suffixes if suffix in files])
    }
    if not tables:
        return {}
    first = next(iter(tables.values()))
    frequency = np.unique([units.frequency(first, column) for column in (0, 1)])
    if frequency[0] <= 0 or not np.isfinite(frequency[-1]):
        raise first.problem(0, "the limits of frequency in the table", "waves only")
    pairs = np.unique(first.values[:, 2:4], axis=0)
    return {
        "qtf_frequency": frequency,
        "qtf_heading": np.radians(pairs),
        **{
            name: _read_transfer(table, units, frequency, pairs, name == "qtf_difference")
            for name, table in tables.items()
        },
    }


def _read_transfer(
    table: NumberTable, units: WamitUnits, frequency: Real, pairs: Real, difference: bool
) -> Complex:
    """Array (np, nq, nq, n); the missing triangle is the other with waves swapped."""
    n, nq = 6 * units.bodies, frequency.size
    w_1, w_2 = (units.frequency(table, column) for column in (0, 1))
    first = _nearest_grid_index(table, 0, w_1, frequency, _FREQUENCY_RTOL * w_1)
    second = _nearest_grid_index(table, 1, w_2, frequency, _FREQUENCY_RTOL * w_2)
    apart = np.abs(table.values[:, None, 2:4] - pairs).max(axis=2)
    if (apart.min(axis=1) > _SAME_DEGREES).any():
        row = int(np.argmax(apart.min(axis=1)))
        raise table.problem(row, "headings that the difference file lacks", "the same pairs")
    index = (np.argmin(apart, axis=1), first, second, table.whole_numbers(4, 1, n) - 1)
    value = table.values[:, 7] + 1j * table.values[:, 8]
    transfer = table.fill_array(index, (len(pairs), nq, nq, n), value)
    swapped = _swap_waves(transfer, pairs)
    full = np.where(np.isnan(transfer), swapped.conj() if difference else swapped, transfer)
    flat = _require_complete(
        table, full.reshape(-1, n), np.tile(np.repeat(frequency, nq), len(pairs))
    )
    return flat.reshape(full.shape) * units.load(1)


def _swap_waves(transfer: Complex, pairs: Real) -> Complex:
    """Transfer function with the waves exchanged, NaN if the pair of headings has no partner."""
    result = np.full_like(transfer, np.nan)
    for p, pair in enumerate(pairs):
        for partner in np.flatnonzero((np.abs(pairs - pair[::-1]) < _SAME_DEGREES).all(axis=1)):
            result[p] = transfer[partner].transpose(1, 0, 2)
    return result


def _read_stiffness(files: dict[str, Path], units: WamitUnits) -> Real | None:
    if ".hst" not in files:
        return None
    table, n = read_table(files[".hst"], (3,)), 6 * units.bodies
    row, column = _read_dofs(table, 0, n)
    stiffness = table.fill_array((row, column), (n, n), table.values[:, 2])
    return np.nan_to_num(stiffness) * (units.density * units.gravity * units.matrix(2))


def _read_inertia(files: dict[str, Path], units: WamitUnits) -> Real | None:
    if ".mmx" not in files:
        return None
    return wamit_header.inertia(files[".mmx"], units.bodies, units.density)
