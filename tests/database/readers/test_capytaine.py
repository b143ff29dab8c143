from pathlib import Path
from typing import Any

import damaged
import netCDF4
import numpy as np
import pytest
import xarray

from hydrosim.compile.databases import open_database
from hydrosim.database import HydroDatabase, all_headings, netcdf
from hydrosim.database.changes import apply_changes
from hydrosim.database.load import load, read
from hydrosim.errors import InputError
from hydrosim.scene import ChangedDatabase, Changes
from hydrosim.scene.hydrodynamics import Given

RIGID = ["Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw"]
USED = slice(0, 60, 10)
CDF = {"netcdf4": b"\x89HDF", "scipy": b"CDF"}


def dataset(db: HydroDatabase, names: list[str], trailing: bool = False) -> xarray.Dataset:
    """In Capytaine's layout and time factor; ``trailing`` as its documentation has it."""
    n = len(names)
    matrix = ("omega", "influenced_dof", "radiating_dof")
    waves = ("omega", "wave_direction", "influenced_dof")

    def parts(loads: np.ndarray) -> tuple[tuple[str, ...], np.ndarray]:
        pair = np.stack([loads.real, -loads.imag], axis=-1 if trailing else 0)
        return ((*waves, "complex") if trailing else ("complex", *waves), pair)

    point = ("body", "space_coordinate") if n > 6 else ("space_coordinate",)
    centre = db.reference_point if n > 6 else db.reference_point[0]
    return xarray.Dataset(
        {
            "added_mass": (matrix, db.added_mass[USED]),
            "radiation_damping": (matrix, db.radiation_damping[USED]),
            "excitation_force": parts(db.excitation[USED]),
            "Froude_Krylov_force": parts(db.froude_krylov[USED]),
            "hydrostatic_stiffness": (matrix[1:], db.hydrostatic_stiffness),
            "inertia_matrix": (matrix[1:], db.inertia_matrix),
            "center_of_buoyancy": (point, db.centre_of_buoyancy.reshape(centre.shape)),
            "disp_mass": (point[:-1], (1025.0 * db.volume).reshape(centre.shape[:-1])),
        },
        coords={
            "omega": db.frequency[USED],
            "wave_direction": db.heading,
            "influenced_dof": names,
            "radiating_dof": names,
            "complex": ["re", "im"],
            "rotation_center": (point, centre),
            "center_of_mass": (point, db.centre_of_gravity.reshape(centre.shape)),
            "rho": 1025.0,
            "g": 9.81,
            "water_depth": np.inf,
        },
        attrs={"capytaine_version": "3.0.0"},
    )


@pytest.fixture
def barge_set(barge) -> xarray.Dataset:
    return dataset(barge, RIGID)


def stored(data: xarray.Dataset, path: Path, engine: Any = "netcdf4") -> Path:
    data.to_netcdf(path, engine=engine)
    return path


def same(db: HydroDatabase, other: HydroDatabase) -> None:
    for name in ("added_mass", "radiation_damping", "excitation", "froude_krylov"):
        np.testing.assert_array_equal(getattr(db, name), getattr(other, name)[USED])
    for name in (
        "hydrostatic_stiffness",
        "inertia_matrix",
        "centre_of_buoyancy",
        "centre_of_gravity",
        "reference_point",
    ):
        np.testing.assert_array_equal(getattr(db, name), getattr(other, name))
    np.testing.assert_allclose(db.volume, other.volume, rtol=1e-14)


@pytest.mark.parametrize("engine", CDF)
@pytest.mark.parametrize("trailing", [False, True])
def test_reads_either_layout_of_complex_and_of_netcdf(barge, tmp_path, engine, trailing):
    path = stored(dataset(barge, RIGID, trailing), tmp_path / "barge.nc", engine)
    assert path.read_bytes().startswith(CDF[engine])
    db = read(path)
    same(db, barge)
    assert db.attributes["solver"] == "Capytaine 3.0.0"
    assert db.port_starboard_symmetric


def test_dimensions_and_dofs_in_any_order(barge, barge_set, tmp_path):
    mixed = barge_set.isel(radiating_dof=[5, 3, 1, 0, 2, 4], influenced_dof=[2, 0, 1, 4, 3, 5])
    mixed = mixed.transpose("radiating_dof", "influenced_dof", ...).isel(
        omega=slice(None, None, -1)
    )
    same(read(stored(mixed, tmp_path / "mixed.nc")), barge)


@pytest.mark.parametrize("name", ["freq", "period", "wavenumber", "wavelength"])
def test_any_abscissa(barge, barge_set, tmp_path, name):
    omega = barge.frequency[USED]
    values = {
        "freq": omega / 2 / np.pi,
        "period": 2 * np.pi / omega,
        "wavenumber": omega**2 / 9.81,
        "wavelength": 2 * np.pi * 9.81 / omega**2,
    }
    renamed = barge_set.rename(omega=name).assign_coords({name: values[name]})
    db = read(stored(renamed, tmp_path / "barge.nc"))
    np.testing.assert_allclose(db.frequency, omega, rtol=1e-12)
    beside = renamed.assign_coords(omega=(name, omega))
    np.testing.assert_array_equal(read(stored(beside, tmp_path / "b.nc")).frequency, omega)


def test_two_bodies(made_up, tmp_path):
    db = made_up(2)
    names = [f"{body}__{dof}" for body in ("stern", "bow") for dof in RIGID]
    same(read(stored(dataset(db, names), tmp_path / "two.nc")), db)


NAMES = [f"{body}__{dof}" for body in ("stern", "bow") for dof in RIGID]


def test_two_bodies_of_version_2(made_up, tmp_path):
    """Bodies along rigid_body_component and points along point_coordinates, in an order of their
    own; DOFs of motions in another order than those of loads."""
    db = made_up(2)
    data = dataset(db, NAMES).rename(
        body="rigid_body_component", space_coordinate="point_coordinates"
    )
    plain = read(stored(data, tmp_path / "plain.nc"))
    same(plain, db)
    named = data.assign_coords(rigid_body_component=["stern", "bow"]).isel(
        rigid_body_component=[1, 0], radiating_dof=[*range(6, 12), *range(6)]
    )
    found = read(stored(named, tmp_path / "named.nc"))
    same(found, db)
    assert found.checksum == plain.checksum
    # the remedy for files without points of rotation
    given = Given(reference_point=tuple(float(x) for x in db.reference_point.ravel()))
    bare = data.drop_vars("rotation_center")
    same(read(stored(bare, tmp_path / "bare.nc"), given), db)


@pytest.mark.parametrize("name", ["radiation_damping", "excitation_force"])
def test_frequencies_without_numbers_can_be_left_out(barge_set, barge, tmp_path, name):
    """The solver failed at the two lowest of six frequencies."""
    gaps = barge_set.copy(deep=True)
    gaps[name][{"omega": slice(0, 2)}] = np.nan
    path = stored(gaps, tmp_path / "gaps.nc")
    omega = barge.frequency[USED]
    range_said = rf"frequencies: \[{omega[2]:.6g} rad/s, {omega[-1]:.6g} rad/s\]"
    with pytest.raises(InputError, match=range_said):
        read(path)
    used = (float(omega[2]), float(omega[-1]))
    whole = apply_changes(read(stored(barge_set, tmp_path / "whole.nc")), Changes(frequencies=used))
    for db in (
        open_database(ChangedDatabase(path, frequencies=used)),
        apply_changes(read(path, Given(frequencies=used)), Changes(frequencies=used)),
    ):
        assert db.checksum == whole.checksum
    with pytest.raises(InputError, match=range_said):
        open_database(ChangedDatabase(path, frequencies=(float(omega[1]), used[1])))
    with pytest.raises(InputError):
        open_database(ChangedDatabase(path, frequencies=(1e-9, 2e-9)))


def test_limits_of_frequency(barge, barge_set, tmp_path):
    """Loads and damping there are none of a solver's business."""
    limits = barge_set.isel(omega=[0, 1]).assign_coords(omega=[0.0, np.inf])
    limits["added_mass"][:] = [barge.added_mass_zero, barge.added_mass_infinite]
    limits["excitation_force"][:] = np.nan
    limits["Froude_Krylov_force"][:] = np.nan
    limits["radiation_damping"][:] = np.nan
    path = stored(
        xarray.concat([limits, barge_set], "omega", data_vars="minimal"), tmp_path / "b.nc"
    )
    db = read(path)
    same(db, barge)
    np.testing.assert_array_equal(db.added_mass_zero, barge.added_mass_zero)
    np.testing.assert_array_equal(db.added_mass_infinite, barge.added_mass_infinite)


@pytest.mark.filterwarnings("ignore:.*kernel truncation")
def test_passes_the_checks_of_physics(barge_set, tmp_path):
    load(stored(barge_set, tmp_path / "barge.nc"))


def test_the_independent_barge(barge, validation, tmp_path):
    """The study's database, its names changed to Capytaine's, is the barge of other panels: up to
    1.2 rad/s within 1.5 per cent of the largest loads, 3 per cent of the largest coefficients."""
    names = {"i": "influenced_dof", "j": "radiating_dof", "heading": "wave_direction"}
    with xarray.open_dataset(validation / "h851_independent.nc") as file:
        data = file.load().rename(names)
    data = data.assign_coords(
        wave_direction=np.radians(data.wave_direction),
        complex=["re", "im"],
        rotation_center=("space_coordinate", [0.0, 0.0, -4.9]),
        rho=data.rho,
        g=data.g,
        water_depth=float(data.water_depth),
    )
    for ours, theirs in (
        ("excitation", "excitation_force"),
        ("froude_krylov", "Froude_Krylov_force"),
    ):
        parts = [data[f"{ours}_re"], data[f"{ours}_im"]]
        data[theirs] = xarray.concat(parts, "complex").drop_vars("complex", errors="ignore")
    db = read(stored(data, tmp_path / "independent.nc"))
    low = np.flatnonzero(barge.frequency < 1.21)
    same = np.abs(barge.heading[:, None] - db.heading).argmin(axis=0)
    np.testing.assert_allclose(barge.heading[same], db.heading, atol=1e-9)
    for name, part in (("excitation", 0.015), ("froude_krylov", 0.01)):
        one, other = getattr(db, name)[low], getattr(barge, name)[low][:, same]
        assert (np.abs(one - other).max(axis=(0, 1)) < part * np.abs(other).max(axis=(0, 1))).all()
    for name in ("added_mass", "radiation_damping"):
        one, other = getattr(db, name), getattr(barge, name)
        largest = np.diagonal(np.abs(one), axis1=1, axis2=2).max(axis=0)
        error = np.abs(one[low] - other[low]) / np.sqrt(np.outer(largest, largest))
        assert error.max() < 0.03


@pytest.fixture(scope="module")
def sphere(tmp_path_factory) -> tuple[Path, Any]:
    """A coarse floating sphere off the origin, as Capytaine computes and writes it."""
    reason = "capytaine is not installed (pip install .[bem])"
    cpt = pytest.importorskip("capytaine", reason=reason)
    import capytaine.io.xarray as export

    mesh = cpt.mesh_sphere(radius=5.0, center=(8.0, 3.0, 0.0), resolution=(12, 16)).immersed_part()
    centre = (8.0, 3.0, -1.0)
    dofs = cpt.rigid_body_dofs(rotation_center=centre)
    body = cpt.FloatingBody(mesh=mesh, dofs=dofs, center_of_mass=centre)
    body.inertia_matrix = body.compute_rigid_body_inertia(rho=1025.0)
    grid = {
        "period": [np.inf, 60.0, 8.0, 5.0],
        "wave_direction": [0.0, 0.5],
        "radiating_dof": list(body.dofs),
    }
    matrix = xarray.Dataset(coords=grid | {"rho": [1025.0], "g": [9.81], "water_depth": [np.inf]})
    problems = [
        problem
        for problem in export.problems_from_dataset(matrix, body)
        if problem.omega > 0 or hasattr(problem, "radiating_dof")
    ]
    results = cpt.BEMSolver().solve_all(problems, progress_bar=False)
    path = tmp_path_factory.mktemp("capytaine") / "sphere.nc"
    export.save_dataset_as_netcdf(path, cpt.assemble_dataset(results))
    return path, results


@pytest.mark.bem
def test_capytaines_own_file_has_its_own_results(sphere):
    from capytaine.bem.airy_waves import froude_krylov_force

    path, results = sphere
    db = read(path)
    assert db.added_mass_zero is not None
    names = RIGID
    for result in results:
        omega = float(result.omega)
        if omega == 0:
            continue
        w = int(np.argmin(np.abs(db.frequency - omega)))
        for i, name in enumerate(names):
            if hasattr(result, "radiating_dof"):
                j = names.index(result.radiating_dof)
                assert db.added_mass[w, i, j] == result.added_masses[name]
                assert db.radiation_damping[w, i, j] == result.radiation_dampings[name]
            else:
                b = int(np.argmin(np.abs(db.heading - result.wave_direction)))
                total = result.forces[name] + froude_krylov_force(result.problem)[name]
                assert db.excitation[w, b, i] == pytest.approx(np.conj(total), rel=1e-9, abs=1e-6)


@pytest.mark.bem
def test_capytaines_sphere_rides_long_waves(sphere):
    """Waves of a minute are 5600 m long: the heave load is C33 times the elevation at the sphere,
    the load along the waves leads it by 90 degrees."""
    db = all_headings(read(sphere[0]))
    k = db.frequency[0] ** 2 / 9.81
    late = np.exp(1j * k * (8.0 * np.cos(db.heading) + 3.0 * np.sin(db.heading)))
    load = db.excitation[0] * late[:, None]
    np.testing.assert_allclose(load[:, 2], db.hydrostatic_stiffness[2, 2], rtol=0.02)
    along = load[:, 0] * np.cos(db.heading) + load[:, 1] * np.sin(db.heading)
    np.testing.assert_allclose(np.angle(along), np.pi / 2, atol=0.01)
    np.testing.assert_array_equal(db.reference_point, [[8.0, 3.0, -1.0]])
    assert db.volume[0] == pytest.approx(2 / 3 * np.pi * 125, rel=0.1)  # a coarse sphere


def test_what_is_missing_is_named(barge_set, tmp_path):
    path = tmp_path / "b.nc"
    heave = barge_set.isel(influenced_dof=[2], radiating_dof=[2])
    with pytest.raises(InputError, match=r"b\.nc: variable influenced_dof: found Heave, expected"):
        read(stored(heave, path))
    half = barge_set.rename(excitation_force="diffraction_force").drop_vars("Froude_Krylov_force")
    with pytest.raises(InputError, match="variable Froude_Krylov_force: found none"):
        read(stored(half, path))
    with pytest.raises(InputError, match=r"rotation_center\).*reference_point"):
        load(stored(barge_set.drop_vars("rotation_center"), path))
    with pytest.raises(InputError, match="found no rho"):
        read(stored(barge_set.drop_vars("rho"), path))
    failed = barge_set.copy(deep=True)
    failed["added_mass"][1] = np.nan
    with pytest.raises(InputError, match=r"added_mass: found no numbers at 0\.22 rad/s"):
        read(stored(failed, path))
    several = barge_set.expand_dims(water_depth=[50.0, 60.0])
    with pytest.raises(InputError, match=r"found several values along \['water_depth'\]"):
        read(stored(several, path))


def test_counts_beyond_reason_are_refused_at_once(tmp_path):
    """A variable may promise any size in a few bytes."""
    path = tmp_path / "huge.nc"
    with netCDF4.Dataset(path, "w") as file:
        for name, size in (("omega", 10**6), ("influenced_dof", 600), ("radiating_dof", 600)):
            file.createDimension(name, size)
        file.createVariable(
            "added_mass", "f8", ("omega", "influenced_dof", "radiating_dof"), zlib=True
        )
        file.createVariable("influenced_dof", str, ("influenced_dof",))
    with pytest.raises(InputError, match=r"huge\.nc: variable"):
        read(path)


@pytest.mark.parametrize("engine", CDF)
def test_damaged_files_are_refused(barge_set, tmp_path, engine):
    """Cut off, or with 1 to 60 bytes of junk: refused by name, or what is left is a database. Each
    has its own name, for HDF5 remembers a file that it failed to open."""
    content, count = stored(barge_set, tmp_path / "barge.nc", engine).read_bytes(), 0
    for seed in range(damaged.COUNT):
        random = np.random.default_rng(seed)
        at, junk = int(random.integers(8, len(content))), random.bytes(int(random.integers(1, 60)))
        path = tmp_path / f"barge{seed}.nc"
        path.write_bytes(content[:at] + (junk + content[at + len(junk) :] if seed % 2 else b""))
        message = damaged.message(read, path)
        assert message is None or path.name in message
        count += message is not None
    assert 40 <= 100 * count // damaged.COUNT


def test_radiation_alone_is_a_database_without_loads(barge_set, barge, tmp_path):
    loads = ["excitation_force", "Froude_Krylov_force", "wave_direction"]
    db = read(stored(barge_set.drop_vars(loads), tmp_path / "b.nc"))
    assert db.excitation.shape == (db.frequency.size, 0, 6)
    np.testing.assert_array_equal(db.added_mass, barge.added_mass[USED])
    netcdf.write(db, tmp_path / "own.nc")
    again = read(tmp_path / "own.nc")
    assert again.excitation.shape == db.excitation.shape
    np.testing.assert_array_equal(again.radiation_damping, db.radiation_damping)
