"""A database as BEMIO's HDF5 file."""

from __future__ import annotations

import warnings
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.database.database import Complex, HydroDatabase, require_array
from hydrosim.database.readers.common import inverse, quotient
from hydrosim.database.transfer import move_reference
from hydrosim.errors import InputError

if TYPE_CHECKING:
    import h5py


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
    group["wave_dir"] = inverse(np.radians, np.degrees(b), b)[:, None]
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
    damping = quotient(db.radiation_damping, density * db.frequency[:, None, None])
    mass = quotient(db.added_mass, density)
    group["added_mass/all"] = mass[:, rows].transpose(1, 2, 0)
    group["radiation_damping/all"] = damping[:, rows].transpose(1, 2, 0)
    if db.added_mass_infinite is not None:
        group["added_mass/inf_freq"] = quotient(db.added_mass_infinite[rows], density)
    if db.hydrostatic_stiffness is not None:
        stiffness = db.hydrostatic_stiffness[rows, rows]
        group["linear_restoring_stiffness"] = quotient(stiffness, weight)
    if db.mean_drift is not None:
        drift = quotient(db.mean_drift[..., rows].transpose(2, 1, 0), weight)
        group["mean_drift/control_surface/val"] = drift
    loads = {"excitation": db.excitation, "excitation/froude-krylov": db.froude_krylov}
    if db.froude_krylov is not None:
        loads["excitation/scattering"] = db.excitation - db.froude_krylov
    for name, value in loads.items():
        if value is not None:
            _write_loads(value[..., rows].transpose(2, 1, 0), weight, group.require_group(name))


def _write_loads(value: Complex, weight: float, group: h5py.Group) -> None:
    real, imaginary = quotient(value.real, weight), quotient(value.imag, weight)
    group["re"], group["im"] = real, imaginary
    group["mag"], group["phase"] = np.hypot(real, imaginary), np.arctan2(imaginary, real)


def _write_transfer(db: HydroDatabase, rows: slice, group: h5py.Group, name: str) -> None:
    """For each DOF, a column of n^2 numbers; the index of the first wave varies fastest."""
    w = require_array(db, "qtf_frequency")
    period = inverse(lambda T: 2 * np.pi / T, 2 * np.pi / w, w)
    pair = require_array(db, "qtf_heading")[0]
    degrees = inverse(np.radians, np.degrees(pair), pair)
    for kind, transfer in (("Diff", db.qtf_difference), ("Sum", db.qtf_sum)):
        if transfer is None:
            continue
        for dof, one in enumerate(np.moveaxis(transfer[0, ..., rows], -1, 0)):
            flat = one.ravel(order="F")[:, None]
            inner = group.require_group(f"{name}/{kind}{dof + 1}")
            inner["PER_i"] = period[:, None]
            inner["BETA_i"], inner["BETA_j"] = (np.full((w.size, 1), angle) for angle in degrees)
            inner["Re_F_ij"], inner["Im_F_ij"] = flat.real, flat.imag
            inner["PHS_F_ij"] = np.degrees(np.angle(flat))
