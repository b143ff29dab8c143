from __future__ import annotations

from dataclasses import fields

import netCDF4
import numpy as np
import pytest
import xarray

from hydrosim.database import HydroDatabase, netcdf
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


def test_a_missing_variable_is_named(made_up, tmp_path):
    netcdf.write(made_up(), tmp_path / "db.nc")
    with netCDF4.Dataset(tmp_path / "db.nc", "a") as file:
        file.renameVariable("excitation", "exciting")
    with pytest.raises(InputError, match=r"db\.nc.*variable excitation is missing"):
        netcdf.read(tmp_path / "db.nc")


def test_other_dimensions_are_refused(made_up, tmp_path):
    netcdf.write(made_up(), tmp_path / "db.nc")
    with netCDF4.Dataset(tmp_path / "db.nc", "a") as file:
        file.renameDimension("influenced_dof", "mode")
    with pytest.raises(InputError, match=r"added_mass has dimensions .*'mode'.* expected"):
        netcdf.read(tmp_path / "db.nc")


@pytest.mark.parametrize("content", [b"", b"not a database\n", b"CDF"])
def test_another_kind_of_file_is_refused(tmp_path, content):
    path = tmp_path / "db.nc"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"db\.nc: not a netCDF"):
        netcdf.read(path)
