"""`load`: from a file to a checked database."""

from __future__ import annotations

import warnings
from dataclasses import fields, replace
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from hydrosim.database.checks import Finding, check
from hydrosim.database.database import HydroDatabase, Real
from hydrosim.database.given import NOTHING_GIVEN, Given
from hydrosim.database.readers import READERS, Reader
from hydrosim.errors import InputError

HEAD = 4096  # bytes that a format is recognised by
OF_BODIES: dict[str, tuple[int, ...]] = {  # shape for each body
    "volume": (),
    "centre_of_buoyancy": (3,),
    "centre_of_gravity": (3,),
}


def load(path: Path | str, given: Given = NOTHING_GIVEN) -> HydroDatabase:
    """The database in the file ``path``, of any format that `readers` know, checked.

    Raises `InputError` where the file is missing, not a database, incomplete or breaks physics so
    clearly that a sign, unit or convention must be wrong. Milder findings are warnings.
    """
    db = read(path, given)
    findings = check(db)
    refused = [finding for finding in findings if finding.refused]
    if refused:
        reasons = "\n".join(f"  {_message(finding)}" for finding in refused)
        raise InputError(f"{path}: the database cannot be right:\n{reasons}")
    for finding in findings:
        if not finding.passed:
            warnings.warn(f"{path}: {_message(finding)}", stacklevel=2)
    return db


def read(path: Path | str, given: Given = NOTHING_GIVEN) -> HydroDatabase:
    """The database in the file ``path``, unchecked; what the file lacks is what is ``given``."""
    db = recognise(path).read(Path(path), given)
    known = {name: getattr(given, name) for name in OF_BODIES if getattr(db, name) is None}
    places: dict[str, Any] = {
        name: _by_body(db, name, value) for name, value in known.items() if value
    }
    return replace(db, **places) if places else db


def overruled(db: HydroDatabase, given: Given) -> list[str]:
    """Names of what is ``given`` although the file says something else, which counts."""
    values = {item.name: getattr(given, item.name) for item in fields(given)}
    return [
        name
        for name, value in values.items()
        if value is not None
        and hasattr(db, name)
        and not np.array_equal(np.ravel(getattr(db, name)), np.ravel(value))
    ]


def recognise(path: Path | str) -> Reader:
    """What reads the file ``path``; raises `InputError` where it is missing or unknown."""
    path = Path(path)
    if not path.is_file():
        found = "is a directory" if path.is_dir() else "no such file"
        raise InputError(f"{path}: {found}; expected a hydrodynamic database.")
    with path.open("rb") as file:
        head = file.read(HEAD)
    for reader in READERS:
        if reader.sniff(path, head):
            return reader
    names = ", ".join(reader.NAME for reader in READERS)
    raise InputError(f"{path}: is of no format that is known here; expected one of {names}.")


def _by_body(db: HydroDatabase, name: str, value: tuple[float, ...]) -> Real:
    try:
        return np.reshape(np.array(value, dtype=float), (db.bodies, *OF_BODIES[name]))
    except ValueError:
        expected = db.bodies * prod(OF_BODIES[name])
        raise InputError(
            f"{db.source}: {len(value)} numbers are given for the {name.replace('_', ' ')} of"
            f" {db.bodies} bodies; expected {expected}."
        ) from None


def _message(finding: Finding) -> str:
    return (
        f"{finding.name}: found {finding.figure:.3g}, expected at most {finding.limit:g}"
        f" ({finding.advice})."
    )
