"""Readers of other programs' files, one module each, which translate all conventions.

A reader is a module with

    NAME                       what the format is called
    sniff(path, head) -> bool  whether the file is of this format, from its name and first bytes
    read(path, given) -> HydroDatabase

``read`` gives SI units, radians, exp(+i w t), headings that waves go to, and phases at the origin
of the database's frame, whatever the file has. `READERS` are asked in order.
"""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

from hydrosim.database import netcdf
from hydrosim.database.database import HydroDatabase
from hydrosim.database.readers import (
    aqwa,
    bemio,
    capytaine,
    hydrostar,
    marin,
    nemoh,
    orcaflex,
    veres,
    wamit,
)
from hydrosim.scene.hydrodynamics import Given


class Reader(Protocol):
    """Functions that each module of this folder provides."""

    NAME: str

    def sniff(self, path: Path, head: bytes) -> bool:
        """Whether the file is of this format."""
        ...

    def read(self, path: Path, given: Given) -> HydroDatabase:
        """The database in the file."""
        ...


# netCDF comes last, because its reader takes any HDF5 file that the others do not recognise.
READERS: tuple[Reader, ...] = (
    aqwa,
    bemio,
    capytaine,
    hydrostar,
    marin,
    nemoh,
    orcaflex,
    veres,
    wamit,
    netcdf,
)
