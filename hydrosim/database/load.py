"""`load`: from a file to a checked database."""

from __future__ import annotations

import warnings
from pathlib import Path

from hydrosim.database import netcdf
from hydrosim.database.checks import Finding, check
from hydrosim.database.database import HydroDatabase
from hydrosim.errors import InputError


def load(path: Path | str) -> HydroDatabase:
    """The database in the file ``path``, checked.

    Raises `InputError` where the file is missing, not a database, incomplete or breaks physics so
    clearly that a sign, unit or convention must be wrong. Milder findings are warnings.
    """
    path = Path(path)
    if not path.is_file():
        found = "is a directory" if path.is_dir() else "no such file"
        raise InputError(f"{path}: {found}; expected a hydrodynamic database (netCDF).")
    db = netcdf.read(path)
    findings = check(db)
    refused = [finding for finding in findings if finding.refused]
    if refused:
        reasons = "\n".join(f"  {_message(finding)}" for finding in refused)
        raise InputError(f"{path}: the database cannot be right:\n{reasons}")
    for finding in findings:
        if not finding.passed:
            warnings.warn(f"{path}: {_message(finding)}", stacklevel=2)
    return db


def _message(finding: Finding) -> str:
    return (
        f"{finding.name}: found {finding.figure:.3g}, expected at most {finding.limit:g}"
        f" ({finding.advice})."
    )
