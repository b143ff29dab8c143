"""Directions in files of other programs: whether waves come from them or go to them, and spectra
over directions all around."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.documents.text import Source

GOING_WORDS = re.compile("to direction|going to|go to|towards?|to which|propagation|oceanographic")
COMING_WORDS = re.compile("from direction|coming from|come from|from which|meteorological|nautical")
DIRECTION_ATTRIBUTES = ("standard_name", "long_name", "convention")
"""Attributes that tell, the first that does so first."""
SPECTRAL_UNITS = {"freq": ("Hz", "1/s", "s-1", "s^-1"), "dir": ("deg",)}
SAME_DIRECTION_DEG = 1e-6
SAME_DENSITY_RTOL = 1e-6


def is_heading(source: Source, name: str, attributes: Mapping[Any, Any]) -> bool:
    """Whether the directions ``name`` are headings, which waves go to, by their ``attributes``,
    such as the standard name sea_surface_wave_to_direction of CF. Without a word they are those
    that waves come from. Raises InputError if one attribute says both."""
    for key in DIRECTION_ATTRIBUTES:
        text = str(attributes.get(key, "")).lower().replace("_", " ")
        going, coming = GOING_WORDS.search(text), COMING_WORDS.search(text)
        if going and coming:
            source.wrong(
                f'found {name} with {key} "{attributes[key]}"; expected either from or to: the'
                " standard names are sea_surface_wave_from_direction and"
                " sea_surface_wave_to_direction"
            )
        if going or coming:
            return going is not None
    return False


def check_spectral_units(source: Source, efth: xr.DataArray) -> None:
    """Raises InputError unless freq is in Hz and dir in degrees, where the file says so."""
    for name, units in SPECTRAL_UNITS.items():
        text = str(efth[name].attrs.get("units", units[0]))
        if not text.lower().startswith(tuple(unit.lower() for unit in units)):
            source.wrong(f"found {name} in {text}; expected {units[0]}, as wavespectra has it")


def without_repeats(source: Source, efth: xr.DataArray) -> xr.DataArray:
    """Spectra ``efth`` over dir [deg], each direction once: a circle that is closed has its first
    direction again, a turn on. Raises InputError if the densities there differ."""
    bearing = np.asarray(efth["dir"].values, dtype=float)
    keep: list[int] = []
    for k, angle in enumerate(bearing):
        apart = np.abs(np.mod(bearing[keep] - angle + 180.0, 360.0) - 180.0)
        same = [keep[i] for i in np.flatnonzero(apart <= SAME_DIRECTION_DEG)]
        if not same:
            keep.append(k)
            continue
        first, again = (efth.isel(dir=i).values.astype(float) for i in (same[0], k))
        if not np.allclose(first, again, rtol=SAME_DENSITY_RTOL, atol=0.0, equal_nan=True):
            source.wrong(
                f"found {bearing[same[0]]:g} and {angle:g} deg, one direction, with different"
                " densities; expected each direction once"
            )
    return efth if len(keep) == bearing.size else efth.isel(dir=keep)
