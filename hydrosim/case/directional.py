"""Spectra over frequency and direction from netCDF, in the layout of the package wavespectra."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.documents.text import Source, check_spectral_units, is_heading, without_repeats
from hydrosim.scene import DirectionalTable

if TYPE_CHECKING:
    import xarray as xr

LAYOUT = "efth over freq [Hz] and dir [degrees]"
_TURN = 2.0 * np.pi


def read_directional(source: Source, select: Mapping[str, int], x_axis: float) -> DirectionalTable:
    """The spectrum in a netCDF file, at the indices ``select`` of its other dimensions.

    In the file: efth [m^2/Hz/degree] over freq [Hz] and dir [degrees], the direction that waves
    come from, clockwise from north, or go to, if the attributes of dir say so. ``x_axis`` [rad] is
    the compass bearing of +x, pi / 2 if +x is east, so that waves from dir go to the heading
    x_axis - dir - pi. A circle may be closed (0 and 360). Raises InputError where the file has
    another layout, or values that are negative or not numbers.
    """
    efth = without_repeats(source, _read(source, select))
    bearing = np.radians(efth["dir"].values.astype(float))
    if is_heading(source, "dir", efth["dir"].attrs):
        bearing += np.pi
    frequency = _TURN * efth["freq"].values.astype(float)
    density = efth.transpose("freq", "dir").values.astype(float) * np.degrees(1.0) / _TURN
    if not np.all(density >= 0.0):
        source.wrong("found densities that are negative or missing; expected none; select others")
    if frequency.size < 2 or np.any(np.diff(frequency) <= 0.0) or frequency[0] < 0.0:
        source.wrong("found frequencies that do not rise; expected two or more that do")
    heading, order = _in_order(source, x_axis - bearing - np.pi)
    return DirectionalTable(frequency, heading, density[:, order])


def _read(source: Source, select: Mapping[str, int]) -> xr.DataArray:
    import xarray as xr

    try:
        data = xr.load_dataset(source.file, engine="netcdf4", decode_times=False)
    except (OSError, ValueError, RuntimeError) as error:
        source.wrong(f"cannot be read as netCDF ({error}); expected {LAYOUT}")
    if "efth" not in data or not {"freq", "dir"} <= {*data["efth"].dims}:
        source.wrong(f"found the variables {', '.join(map(str, data))}; expected {LAYOUT}")
    efth = data["efth"]
    if not {"freq", "dir"} <= {*efth.coords}:
        source.wrong(f"found no values of freq or dir; expected {LAYOUT}")
    check_spectral_units(source, efth)
    if "rad" in (units := str(efth.attrs.get("units", ""))):
        source.wrong(f"found efth in {units}; expected m^2/Hz/degree")
    others = {str(dim): efth.sizes[dim] for dim in efth.dims if dim not in ("freq", "dir")}
    for dim, size in others.items():
        index = select.get(dim, 0 if size == 1 else size)
        if not -size <= index < size:
            source.wrong(f"found {size} of {dim}; expected one; select: {{{dim}: 0}} is the first")
        efth = efth.isel({dim: index})
    if unknown := [dim for dim in select if dim not in others]:
        source.unknown("dimension", unknown[0], list(others))
    return efth


def _in_order(source: Source, heading: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Headings that rise, equally far apart, from the one after the widest gap, and their order."""
    order = np.argsort(np.mod(heading, _TURN))
    angle = np.mod(heading[order], _TURN)
    gaps = np.diff(angle, append=angle[0] + _TURN)
    first = int(np.argmax(gaps)) + 1
    order, angle = np.roll(order, -first), np.unwrap(np.roll(angle, -first))
    steps = np.diff(angle)
    if steps.size == 0 or np.ptp(steps) > 1e-6 or steps.min() <= 0.0:
        apart = ", ".join(f"{step:.4g}" for step in np.unique(np.degrees(steps).round(4))[:4])
        found_text = (
            f"directions unequally far apart ({apart} deg)" if apart else "one direction alone"
        )
        source.wrong(f"found {found_text}; expected equal steps of two or more")
    return angle, order
