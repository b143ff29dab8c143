"""Faults planted in the barge's database, as they come from other programs and from haste."""

from __future__ import annotations

import warnings
from dataclasses import replace

import netCDF4
import numpy as np
import pytest

from hydrosim.database import check, load, netcdf
from hydrosim.errors import InputError

RHO_G = 1025 * 9.81


def failed(db) -> set[str]:
    return {finding.name for finding in check(db) if not finding.passed}


def scaled(array, row, factor):
    copy = array.copy()
    copy[row] = copy[row] * factor
    return copy


def swapped_frequencies(db):
    order = np.arange(db.frequency.size)
    order[[3, 4]] = 4, 3
    return replace(db, frequency=db.frequency[order])


FAULTS = {
    "conjugated loads": (
        lambda db: replace(db, excitation=db.excitation.conj()),
        "phase of the horizontal load",
    ),
    "headings where waves come from": (
        lambda db: replace(db, excitation=db.excitation[:, ::-1] * [1, -1, 1, -1, 1, -1]),
        "phase of the horizontal load",
    ),
    "upside down": (
        lambda db: replace(db, excitation=-db.excitation),
        "phase of the heave load",
    ),
    "damping with the other sign": (
        lambda db: replace(db, radiation_damping=-db.radiation_damping),
        "positive damping",
    ),
    "one DOF's damping with the other sign": (
        lambda db: replace(
            db, radiation_damping=scaled(db.radiation_damping, (slice(None), 3, 3), -1)
        ),
        "positive damping",
    ),
    "loads normalised by rho g": (
        lambda db: replace(db, excitation=db.excitation / RHO_G),
        "size of the heave load",
    ),
    "loads times rho g": (
        lambda db: replace(db, excitation=db.excitation * RHO_G),
        "size of the heave load",
    ),
    "per wave height": (
        lambda db: replace(db, excitation=db.excitation / 2),
        "size of the heave load",
    ),
    "headings in degrees": (
        lambda db: replace(db, heading=np.degrees(db.heading)),
        "headings",
    ),
    "descending headings": (
        lambda db: replace(db, heading=db.heading[::-1]),
        "headings",
    ),
    "unsorted frequencies": (swapped_frequencies, "frequencies"),
    "periods for frequencies": (
        lambda db: replace(db, frequency=2 * np.pi / db.frequency),
        "frequencies",
    ),
    "zero frequency among the others": (
        lambda db: replace(db, frequency=db.frequency - db.frequency[0]),
        "frequencies",
    ),
    "coupling with one unit wrong": (
        lambda db: replace(db, added_mass=scaled(db.added_mass, (slice(None), 0, 4), 10)),
        "symmetry of added mass",
    ),
    "stiffness with the other sign": (
        lambda db: replace(db, hydrostatic_stiffness=-db.hydrostatic_stiffness),
        "heave stiffness",
    ),
}


def test_the_barge_passes_everything(barge):
    assert failed(barge) == set()


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_refused_by_name(barge, tmp_path, fault):
    plant, name = FAULTS[fault]
    netcdf.write(plant(barge), tmp_path / "db.nc")
    with pytest.raises(InputError, match=rf"(?s)db\.nc.*\n  {name}[^\n]*: found .* expected"):
        load(tmp_path / "db.nc")


def test_nan_is_refused(barge, tmp_path):
    netcdf.write(barge, tmp_path / "db.nc")
    with netCDF4.Dataset(tmp_path / "db.nc", "a") as file:
        file["excitation"][5, 3, 2, 0] = np.nan
    with pytest.raises(InputError, match="excitation has 1 values"):
        load(tmp_path / "db.nc")


def test_no_file_and_no_directory(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        load(tmp_path / "db.nc")
    with pytest.raises(InputError, match="is a directory"):
        load(tmp_path)


DOUBTS = {
    "kernel truncation": lambda db: between(db, 0.02, 0.8),
    "weight": lambda db: replace(db, inertia_matrix=db.inertia_matrix * 1.05),
    "symmetry of added mass": lambda db: replace(
        db, added_mass=scaled(db.added_mass, (slice(None), 0, 4), 1.1)
    ),
    "positive damping": lambda db: replace(
        db, radiation_damping=db.radiation_damping - 0.01 * db.radiation_damping.max(axis=0)
    ),
}


def between(db, lowest, highest):
    keep = (db.frequency >= lowest) & (db.frequency <= highest)
    by_frequency = (
        "frequency",
        "added_mass",
        "radiation_damping",
        "excitation",
        "froude_krylov",
        "mean_drift",
        "drift_imbalance",
    )
    return replace(db, **{name: getattr(db, name)[keep] for name in by_frequency})


@pytest.mark.parametrize("name", DOUBTS)
def test_a_doubt_is_a_warning(barge, tmp_path, name):
    netcdf.write(DOUBTS[name](barge), tmp_path / "db.nc")
    with pytest.warns(UserWarning, match=rf"db\.nc: {name}: found") as caught:
        load(tmp_path / "db.nc")
    assert all(name in str(warning.message) for warning in caught)


def test_short_lowest_wave_is_no_proof_of_convention(barge):
    """From 0.6 rad/s the loads are far from the limit of long waves: doubts, not refusals."""
    short = between(barge, 0.6, 2.2)
    findings = [finding for finding in check(short) if "long waves" in finding.name]
    assert not all(finding.passed for finding in findings)
    assert not any(finding.refused for finding in findings)


def test_two_barges_far_from_the_origin_are_in_phase_with_their_own_waves(barge):
    """Moved by d, a body has the loads X exp(-i k d cos b); the check must see through that."""
    k = barge.frequency**2 / barge.gravity
    d = 2000.0 * np.cos(barge.heading)
    moved = barge.excitation * np.exp(-1j * k[:, None] * d)[..., None]
    two = np.kron(np.eye(2), np.ones((6, 6)))
    db = replace(
        barge,
        added_mass=np.tile(barge.added_mass, (1, 2, 2)) * two,
        radiation_damping=np.tile(barge.radiation_damping, (1, 2, 2)) * two,
        added_mass_zero=None,
        added_mass_infinite=None,
        excitation=np.concatenate([barge.excitation, moved], axis=2),
        froude_krylov=None,
        mean_drift=None,
        hydrostatic_stiffness=np.tile(barge.hydrostatic_stiffness, (2, 2)) * two,
        inertia_matrix=None,
        volume=np.tile(barge.volume, 2),
        centre_of_buoyancy=np.add(barge.centre_of_buoyancy, [[0, 0, 0], [2000, 0, 0]]),
        centre_of_gravity=np.tile(barge.centre_of_gravity, (2, 1)),
        reference_point=np.tile(barge.reference_point, (2, 1)),
    )
    assert failed(db) == set()
    at_origin = replace(db, centre_of_buoyancy=np.tile(barge.centre_of_buoyancy, (2, 1)))
    assert "phase of the heave load in long waves" not in failed(db)
    phase = {f.name: f.figure for f in check(at_origin)}["phase of the heave load in long waves"]
    assert phase == pytest.approx(np.degrees(k[0] * 2000.0), rel=0.01)


def test_load_is_silent_on_the_barge(barge):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load(barge.source)
