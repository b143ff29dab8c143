"""Hydrodynamic databases: content, reading, checks, change of reference points."""

from hydrosim.database.checks import CheckSubject, Finding, Use, check, doubt_warnings, in_order
from hydrosim.database.database import HydroDatabase, all_headings, require_array
from hydrosim.database.load import load
from hydrosim.database.transfer import body_of, move_reference
