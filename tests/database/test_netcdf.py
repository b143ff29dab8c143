from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path

import h5py
import netCDF4
import numpy as np
import pytest
import xarray

from hydrosim.database import HydroDatabase, check, netcdf
from hydrosim.errors import InputError

OPTIONAL = [name for name, variable in netcdf.VARIABLES.items() if variable.optional]


def same(a: HydroDatabase, b: HydroDatabase) -> bool:
    pairs = [(getattr(a, f.name), getattr(b, f.name)) for f in fields(a)]
    arrays = [(x, y) for x, y in pairs if isinstance(x, np.ndarray)]
    return all(x.tobytes() == y.tobytes() and x.dtype == y.dtype for x, y in arrays)


@pytest.mark.parametrize("bodies", [1, 2])
def test_round_trip_bit_for_bit(made_up, tmp_path, bodies):
    db = made_up(bodies)
    netcdf.write(db, tmp_path / "db.nc")
    back = netcdf.read(tmp_path / "db.nc")
    assert same(db, back)
    assert back.checksum == db.checksum
    assert back.port_starboard_symmetric
    assert np.isinf(back.water_depth)
    assert back.attributes["title"] == "Nobody's hull"
    assert back.source == str(tmp_path / "db.nc")


def test_optional_variables_may_be_absent(made_up, tmp_path):
    db = made_up(port_starboard_symmetric=False, **dict.fromkeys(OPTIONAL))
    netcdf.write(db, tmp_path / "db.nc")
    back = netcdf.read(tmp_path / "db.nc")
    assert same(db, back)
    assert all(getattr(back, name) is None for name in OPTIONAL)
    assert not back.port_starboard_symmetric


def test_xarray_reads_it_by_name(made_up, tmp_path):
    db = made_up(2)
    netcdf.write(db, tmp_path / "db.nc")
    with xarray.open_dataset(tmp_path / "db.nc") as file:
        one = file.added_mass.sel(influenced_dof="body2__roll", radiating_dof="body1__sway")
        np.testing.assert_array_equal(one, db.added_mass[:, 9, 1])
        loads = file.excitation.sel(complex="re") + 1j * file.excitation.sel(complex="im")
        np.testing.assert_array_equal(loads, db.excitation)
        assert list(file.centre_of_gravity.dims) == ["body", "axis"]
        assert "exp(+i w t)" in file.attrs["phase_convention"]


def test_every_variable_says_what_it_is(made_up, tmp_path):
    netcdf.write(made_up(), tmp_path / "db.nc")
    with netCDF4.Dataset(tmp_path / "db.nc") as file:
        assert set(netcdf.VARIABLES) < set(file.variables)
        for name, variable in file.variables.items():
            assert variable.long_name
            assert name not in netcdf.VARIABLES or variable.units


def changed(path: Path, db: HydroDatabase, change: Callable[[netCDF4.Dataset], None]) -> Path:
    """A file of a database, changed."""
    netcdf.write(db, path)
    with netCDF4.Dataset(path, "a") as file:
        change(file)
    return path


def unit_of(name: str, units: str) -> Callable[[netCDF4.Dataset], None]:
    return lambda file: file[name].setncattr("units", units)


WRONG = {
    "variable excitation is missing": lambda file: file.renameVariable("excitation", "exciting"),
    "added_mass: found the dimensions .*mode.*; expected": (
        lambda file: file.renameDimension("influenced_dof", "mode")
    ),
    "variable added_mass: found the unit 'tonne'": unit_of("added_mass", "tonne"),
    "variable frequency: found the unit 'Hz'": unit_of("frequency", "Hz"),
    "variable heading: found the unit 'degree'": unit_of("heading", "degree"),
}


@pytest.mark.parametrize("said", WRONG)
def test_what_is_wrong_is_named(made_up, tmp_path, said):
    path = changed(tmp_path / "db.nc", made_up(), WRONG[said])
    with pytest.raises(InputError, match=rf"db\.nc.*{said}"):
        netcdf.read(path)


@pytest.mark.parametrize("content", [b"", b"not a database\n", b"CDF"])
def test_another_kind_of_file_is_refused(tmp_path, content):
    path = tmp_path / "db.nc"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"db\.nc: not a netCDF"):
        netcdf.read(path)


def scale(name: str, factor: float) -> Callable[[netCDF4.Dataset], None]:
    def change(file: netCDF4.Dataset) -> None:
        file[name][...] *= factor

    return change


CHANGES = [
    *(scale("radiation_damping", 1.1), scale("mean_drift", 2.0), scale("gravity", 0.99)),
    *(
        scale("centre_of_gravity", 1.1),
        lambda file: file.setncattr("port_starboard_symmetric", "no"),
    ),
]


def told(db: HydroDatabase) -> bool:
    (finding,) = (one for one in check(db) if one.name == "numbers as written")
    return not finding.has_passed


@pytest.mark.parametrize("change", CHANGES)
def test_numbers_that_are_changed_in_the_file_are_told(made_up, tmp_path, change):
    """Also of a copy that is written of them; a change in memory is a new database."""
    path = tmp_path / "db.nc"
    netcdf.write(made_up(), path)
    sound = netcdf.read(path)
    assert not told(sound)
    assert told(netcdf.read(changed(path, made_up(), change)))
    netcdf.write(netcdf.read(path), tmp_path / "copy.nc")
    assert told(netcdf.read(tmp_path / "copy.nc"))
    netcdf.write(replace(sound, gravity=9.7), path)
    assert not told(netcdf.read(path))


def test_packed_numbers_are_unpacked(made_up, tmp_path):
    """As xarray packs them, in whole numbers with a factor; what is missing is no number."""
    db = made_up()
    netcdf.write(db, tmp_path / "db.nc")
    size = float(np.abs(db.added_mass).max()) / 30_000
    packing = {"dtype": "int16", "scale_factor": size, "_FillValue": -32_000}
    with xarray.open_dataset(tmp_path / "db.nc") as file:
        file.load().to_netcdf(tmp_path / "packed.nc", encoding={"added_mass": packing})
        file.added_mass[0, 0, 0] = np.nan
        file.to_netcdf(tmp_path / "failed.nc", encoding={"added_mass": packing})
    back = netcdf.read(tmp_path / "packed.nc")
    np.testing.assert_allclose(back.added_mass, db.added_mass, atol=size)
    assert told(back)
    with pytest.raises(InputError, match=r"added_mass has 1 values .* not numbers"):
        netcdf.read(tmp_path / "failed.nc")


def test_counts_beyond_reason_are_refused_at_once(made_up, tmp_path):
    """A few bytes may promise any count of numbers that nobody has written."""
    netcdf.write(made_up(), tmp_path / "db.nc")
    with (
        netCDF4.Dataset(tmp_path / "db.nc") as small,
        netCDF4.Dataset(tmp_path / "huge.nc", "w") as huge,
    ):
        for name, dimension in small.dimensions.items():
            huge.createDimension(name, 3_000_000 if name == "frequency" else dimension.size)
        for name, variable in small.variables.items():
            huge.createVariable(name, variable.dtype, variable.dimensions, zlib=variable.ndim > 0)
    assert (tmp_path / "huge.nc").stat().st_size < 100_000
    with pytest.raises(InputError, match=r"huge\.nc: dimension frequency is 3,000,000; expected"):
        netcdf.read(tmp_path / "huge.nc")


def test_another_file_is_not_looked_into(made_up, tmp_path):
    netcdf.write(made_up(), tmp_path / "db.nc")
    netcdf.write(made_up(), tmp_path / "secret.nc")
    with h5py.File(tmp_path / "db.nc", "a") as file:
        del file["mean_drift"]
        file["mean_drift"] = h5py.ExternalLink("secret.nc", "/mean_drift")
    with pytest.raises(InputError, match=r"db\.nc: .* points to another file; links to files"):
        netcdf.read(tmp_path / "db.nc")
