"""Hydrodynamic databases: content, reading, checks, change of reference points."""

from hydrosim.database.changes import body_of, move_reference
from hydrosim.database.checks import (
    CheckSubject,
    Finding,
    Use,
    check,
    doubt_warnings,
    require_ascending,
)
from hydrosim.database.database import HydroDatabase, all_headings, require_array
from hydrosim.database.load import load
