"""Recordings in HDF5: plain, as MATLAB 7.3 writes them, and netCDF."""

from __future__ import annotations

import h5py
import numpy as np

from hydrosim.documents.hdf5 import fault
from hydrosim.documents.text import Source, readable_unit
from hydrosim.recordings import netcdf
from hydrosim.recordings.recording import Recording, of_arrays

UNIT_ATTRIBUTES = ("units", "unit", "Units", "Unit")  # attributes that may give the unit
OF_NETCDF = "_NCProperties"


def read(source: Source) -> Recording:
    """Datasets over time in an HDF5 file, named by their paths, "group.dataset"."""
    if reason := fault(source.file):
        source.wrong(f"cannot be read as HDF5 ({reason}); is it complete?")
    with h5py.File(source.file) as file:
        if OF_NETCDF not in file.attrs:
            return _read(source, "HDF5", file)
    return netcdf.read(source)


def read_matlab(source: Source) -> Recording:
    """Arrays over time in a MATLAB 7.3 file, with structs as groups."""
    if reason := fault(source.file):
        source.wrong(f"cannot be read as MATLAB 7.3 file ({reason}); is it complete?")
    with h5py.File(source.file) as file:
        return _read(source, "MATLAB 7.3", file)


def _read(source: Source, form: str, file: h5py.File) -> Recording:
    arrays, units = dict[str, np.ndarray](), dict[str, str | None]()

    def take(path: str, item: h5py.Group | h5py.Dataset) -> None:
        # the cells of MATLAB point to "#refs#"
        if isinstance(item, h5py.Dataset) and item.dtype.kind in "iuf" and path[0] != "#":
            name = path.replace("/", ".")
            arrays[name] = item[()]
            said = next((item.attrs[key] for key in UNIT_ATTRIBUTES if key in item.attrs), None)
            text = said.decode() if isinstance(said, bytes) else said
            units[name] = None if text is None else readable_unit(str(text))

    file.visititems(take)
    return of_arrays(source, form, arrays, units)
