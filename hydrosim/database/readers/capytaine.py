"""Capytaine's netCDF files, of versions 2 and 3.

Dimensions are recognised by name. The frequency is along omega, freq, period, wavenumber or
wavelength. Real and imaginary parts are along ``complex``, in any position. Capytaine has exp(-i w
t), so loads are conjugated. Its headings are directions that waves go to, and its phases refer to
the origin. Rows at zero and infinite frequency become the limits of the added mass. Every body must
have exactly the six rigid DOFs, because zeros for uncomputed ones would pass for coefficients.
Dimensions of points and bodies have other names in version 2 (point_coordinates,
rigid_body_component) than in version 3 (space_coordinate, body). Version 2 may write files of
several bodies without ``rotation_center``. Their reference points are then unknown, and the
attribute ``assumed`` says so. Only bodies that do not turn can use them.

Verified with files of Capytaine 3.0, for one and two bodies. The layout of version 2 has other
names for hydrostatics, which are read if present.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from hydrosim.database.database import Complex, HydroDatabase, Real, remedy_for_gaps
from hydrosim.database.readers import assembly
from hydrosim.dofs import DOFS
from hydrosim.errors import InputError
from hydrosim.files import text
from hydrosim.scene.hydrodynamics import NOTHING_GIVEN, POINTS_UNKNOWN, Given

NAME = "Capytaine netCDF"

_CLASSIC = b"CDF"
_MAX_VARIABLE_SIZE = 10**7  # numbers in one variable; more is a damaged file's
# exceptions of the libraries about damaged files
_UNREADABLE = (
    OSError,
    RuntimeError,
    ValueError,
    TypeError,
    LookupError,
    AssertionError,
    OverflowError,
    MemoryError,
)
_MATRIX = ("influenced_dof", "radiating_dof")
_LOADS = ("wave_direction", "influenced_dof")
_BODY = ("body", "rigid_body_component", "body_name")
_COORDINATE = ("space_coordinate", "point_coordinates", "xyz")

# angular frequency from each of the abscissae, with depth and gravity
_TO_OMEGA: dict[str, Callable[[Real, float, float], Real]] = {
    "omega": lambda value, h, g: value,
    "freq": lambda value, h, g: 2 * np.pi * value,
    "period": lambda value, h, g: 2 * np.pi / value,
    "wavenumber": lambda value, h, g: np.sqrt(g * value * np.tanh(value * h)),
    "wavelength": lambda value, h, g: np.sqrt(
        2 * np.pi * g / value * np.tanh(2 * np.pi * h / value)
    ),
}


def sniff(path: Path, head: bytes) -> bool:
    """A netCDF file with Capytaine's dimensions."""
    if not head.startswith((text.MAGIC, _CLASSIC)):
        return False
    try:
        with _open_file(path) as file:
            names = set(file.dimensions)
    except _UNREADABLE:
        return False
    return {*_MATRIX} <= names and not names.isdisjoint(_TO_OMEGA)


def read(path: Path, given: Given = NOTHING_GIVEN) -> HydroDatabase:
    """Database in a Capytaine file. Raises `InputError` for data that are missing or do not fit."""
    try:
        with _open_file(path) as file:
            return _File(path, file).database(given)
    except _UNREADABLE as error:
        raise InputError(
            f"{path}: cannot be read as netCDF ({error}). The file is damaged, or is no netCDF"
            " file. Export it again from Capytaine, or make a database with `hydrosim db build`."
        ) from error


def _open_file(path: Path) -> Any:
    """File of netCDF's library. In the classic format, which xarray writes without that library, a
    file of scipy, which allocates no memory for the sizes in a damaged head."""
    import netCDF4  # slow to load, and dry scenes have no databases

    with path.open("rb") as file:
        if file.read(len(_CLASSIC)) == _CLASSIC:
            from scipy.io import netcdf_file  # slow to load, and few files are of that format

            return netcdf_file(path, mmap=False, maskandscale=True)
    if problem := text.fault(path):
        raise OSError(problem)
    return netCDF4.Dataset(path)


class _File:
    """An open file: variables by name, with dimensions in the requested order."""

    def __init__(self, path: Path, file: Any) -> None:
        self.path, self.file = path, file
        self.abscissa = next((name for name in _TO_OMEGA if name in file.dimensions), "omega")
        self.dofs, self.names = self._rigid(self.labels("influenced_dof"))
        self.motions, _ = self._rigid(self.labels("radiating_dof"), self.names)
        self.bodies = len(self.names)

    def database(self, given: Given) -> HydroDatabase:
        """All variables of the file."""
        path, nb = self.path, self.bodies
        density = assembly.require_number(path, "rho", given.water_density, self.scalar("rho"))
        gravity = assembly.require_number(path, "g", given.gravity, self.scalar("g"))
        depth = assembly.require_number(
            path, "water_depth", given.water_depth, self.scalar("water_depth")
        )
        if self.scalar("forward_speed"):
            raise self.wrong("forward_speed", "a ship under way", "a body at rest")
        omega = self.omega(depth, gravity)
        centre = self.of_bodies("rotation_center", 3)
        reference = assembly.points(path, "rotation_center", given.reference_point, centre, nb)
        unknown = {} if reference is not None else {"assumed": POINTS_UNKNOWN}
        used = given.frequencies
        heading, total, froude_krylov = self.loads(omega.size)
        return assembly.assemble(
            path,
            omega,
            heading,
            given.port_starboard_symmetric,
            used=used,
            added_mass=self.matrices("added_mass", omega, used),
            radiation_damping=self.matrices("radiation_damping", omega, used),
            excitation=total,
            froude_krylov=froude_krylov,
            hydrostatic_stiffness=self.square("hydrostatic_stiffness"),
            inertia_matrix=self.square("inertia_matrix"),
            volume=assembly.volumes(path, given.volume, self.volume(density)),
            centre_of_buoyancy=assembly.points(
                path,
                "center_of_buoyancy",
                given.centre_of_buoyancy,
                self.of_bodies("center_of_buoyancy", 3),
                nb,
            ),
            centre_of_gravity=assembly.points(
                path,
                "center_of_mass",
                given.centre_of_gravity,
                self.of_bodies("center_of_mass", 3),
                nb,
            ),
            reference_point=np.zeros((nb, 3)) if reference is None else reference,
            water_depth=depth,
            water_density=density,
            gravity=gravity,
            attributes={"solver": f"Capytaine {self.version()}".strip(), **unknown},
        )

    def wrong(self, name: str, text: str, expected: str) -> InputError:
        """Error to raise about a variable."""
        return InputError(
            f"{self.path}: variable {name}: found {text}, expected {expected}. Write the dataset"
            " with Capytaine's assemble_dataset and save_dataset_as_netcdf."
        )

    def version(self) -> str:
        """Version of Capytaine, if the file has it; scipy returns texts as bytes."""
        version = getattr(self.file, "capytaine_version", "")
        return version.decode() if isinstance(version, bytes) else str(version)

    def variable(self, name: str) -> Any:
        """Variable of a plausible size."""
        if name not in self.file.variables:
            raise self.wrong(name, "none", "one of Capytaine's")
        stored = self.file.variables[name]
        if math.prod(stored.shape) > _MAX_VARIABLE_SIZE:
            raise self.wrong(
                name, f"{math.prod(stored.shape)} values", f"at most {_MAX_VARIABLE_SIZE}"
            )
        return stored

    def real(self, name: str, *dimensions: str) -> Real:
        """Real variable ``name`` with its axes in the order of ``dimensions``. Raises InputError
        if the variable has another dimension whose size is not one."""
        stored = self.variable(name)
        names = list(stored.dimensions)
        if not set(dimensions) <= set(names):
            raise self.wrong(name, f"dimensions {names}", f"{list(dimensions)}")
        others = [d for d in names if d not in dimensions]
        if any(stored.shape[names.index(d)] != 1 for d in others):
            raise self.wrong(name, f"several values along {others}", "one: select it")
        order = [names.index(d) for d in (*others, *dimensions)]
        values = np.ma.asarray(stored[...])
        if values.dtype.kind not in "fiu":
            raise self.wrong(name, f"type {values.dtype}", "numbers")
        array = np.ma.filled(values.astype(float), np.nan).transpose(order)
        return array.reshape(array.shape[len(others) :])

    def scalar(self, name: str) -> float | None:
        """One number; None if absent."""
        return None if name not in self.file.variables else float(self.real(name))

    def optional(self, name: str, dimensions: tuple[str, ...]) -> Real | None:
        """Numbers of a variable that may be absent or unknown, without the dimension ``body``."""
        if name not in self.file.variables:
            return None
        present = self.variable(name).dimensions
        array = self.real(name, *[d for d in dimensions if d in present])
        return None if np.isnan(array).all() else array

    def of_bodies(self, name: str, count: int) -> Real | None:
        """Numbers of each body, if present: (nb,), or (nb, 3) for a ``count`` of three coordinates.
        They are in the order of the bodies of the DOFs, where the file names the bodies."""
        if name not in self.file.variables:
            return None
        present = self.variable(name).dimensions
        body = next((dim for dim in _BODY if dim in present), None)
        along = next((dim for dim in _COORDINATE if dim in present), None) if count == 3 else None
        array = self.optional(name, tuple(filter(None, (body, along))))
        if array is None or body is None or body not in self.file.variables:
            return array
        names = self.labels(body)
        if len(names) == self.bodies > 1 and {*names} == {*self.names}:
            return np.asarray(array[[names.index(body_name) for body_name in self.names]])
        return array

    def labels(self, name: str) -> list[str]:
        """Names along a dimension."""
        values = np.asarray(self.variable(name)[...])
        if values.dtype.kind == "S" and values.ndim == 2:
            from netCDF4 import chartostring

            values = chartostring(values)
        return [str(value) for value in np.atleast_1d(values)]

    def _rigid(
        self, names: list[str], bodies: list[str] | None = None
    ) -> tuple[list[int], list[str]]:
        """Positions of the six DOFs among the names, body by body, and the names of the bodies, in
        their own order or in that of the ``bodies``."""
        wanted = [name.rpartition("__") for name in names]
        body_names = list(dict.fromkeys(prefix for prefix, _, _ in wanted))
        prefixes = body_names if bodies is None or {*bodies} != {*body_names} else bodies
        at = {(prefix, dof.lower()): i for i, (prefix, _, dof) in enumerate(wanted)}
        missing = [f"{p} {dof}" for p in prefixes for dof in DOFS if (p, dof) not in at]
        if missing or len(at) != 6 * len(prefixes) or len(names) != len(at):
            raise self.wrong(
                "influenced_dof", ", ".join(names)[:200], "the six rigid DOFs of each body"
            )
        return [at[prefix, dof] for prefix in prefixes for dof in DOFS], prefixes

    def omega(self, depth: float, gravity: float) -> Real:
        """Angular frequencies, as stored beside the abscissa or computed from it."""
        stored = self.file.variables.get("omega")
        if stored is not None and stored.dimensions == (self.abscissa,):
            value = self.real("omega", self.abscissa)
        else:
            with np.errstate(all="ignore"):
                abscissa = self.real(self.abscissa, self.abscissa)
                value = _TO_OMEGA[self.abscissa](abscissa, depth, gravity)
        return assembly.frequencies(self.path, value, assembly.Abscissa.RADIANS_PER_SECOND)

    def matrices(self, name: str, omega: Real, used: tuple[float, float] | None) -> Real:
        """Matrices (nw, n, n) in the order of the DOFs; damping at the limits is not needed, nor
        are numbers outside the frequencies that are ``used``."""
        array = self.real(name, self.abscissa, *_MATRIX)[:, self.dofs][:, :, self.motions]
        waves = np.isfinite(omega) & (omega > 0)
        lowest, highest = used or (0.0, np.inf)
        bad = np.isnan(array).any(axis=(1, 2)) & waves & (omega >= lowest) & (omega <= highest)
        if bad.any():
            order = np.argsort(omega[waves], kind="stable")
            remedy = remedy_for_gaps(omega[waves][order], bad[waves][order])
            raise self.wrong(
                name,
                f"no numbers at {', '.join(f'{w:g}' for w in omega[bad][:8])} rad/s",
                f"radiation at the frequencies of the diffraction{remedy}",
            )
        return array

    def square(self, name: str) -> Real | None:
        """Matrix (n, n) in the order of the DOFs, if present."""
        array = self.optional(name, _MATRIX)
        return None if array is None else array[np.ix_(self.dofs, self.motions)]

    def loads(self, count: int) -> tuple[Real, Complex, Complex | None]:
        """Headings (nh,), excitation and its Froude-Krylov part (nw, nh, n), for exp(+i w t). There
        are no headings if only radiation was solved."""
        present = self.file.variables
        if not present.keys() & {"excitation_force", "Froude_Krylov_force", "diffraction_force"}:
            return np.zeros(0), np.zeros((count, 0, len(self.dofs)), dtype=complex), None
        heading = self.real("wave_direction", "wave_direction")
        part = self.complex("Froude_Krylov_force") if "Froude_Krylov_force" in present else None
        if "excitation_force" in present:
            return heading, self.complex("excitation_force"), part
        if part is None:
            raise self.wrong("Froude_Krylov_force", "none", "it beside diffraction_force")
        return heading, part + self.complex("diffraction_force"), part

    def complex(self, name: str) -> Complex:
        """Loads conjugated, in the order of the DOFs."""
        parts = self.real(name, self.abscissa, *_LOADS, "complex")
        labels = self.labels("complex") if "complex" in self.file.variables else ["re", "im"]
        if sorted(labels) != ["im", "re"]:
            raise self.wrong("complex", f"{labels}", "re and im")
        real, imaginary = parts[..., labels.index("re")], parts[..., labels.index("im")]
        array = np.stack([real, -imaginary], axis=-1).view(complex)[..., 0]
        return np.asarray(array[..., self.dofs])

    def volume(self, density: float) -> Real | None:
        """Displaced volumes, computed from masses or read directly."""
        mass = self.of_bodies("disp_mass", 1)
        if mass is not None:
            return mass / density if density > 0 else None
        return self.of_bodies("disp_volume", 1)
