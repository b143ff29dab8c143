"""Checks of a hydrodynamic database against what physics demands of any floating body.

Each finding is one figure, zero at best, with a limit above which to look closer and, where only a
wrong sign, unit or convention can be the cause, a refusal above which the database is not used.
"""

from __future__ import annotations

from hydrosim.database.checks.finding import Check, Finding
from hydrosim.database.checks.haskind import HASKIND
from hydrosim.database.checks.hydrostatics import HYDROSTATICS
from hydrosim.database.checks.long_waves import LONG_WAVES
from hydrosim.database.checks.radiation import RADIATION
from hydrosim.database.checks.ranges import ORDER, RANGES
from hydrosim.database.checks.second_order import SECOND_ORDER
from hydrosim.database.database import HydroDatabase

CHECKS: tuple[Check, ...] = (
    *ORDER,
    *RANGES,
    *RADIATION,
    *HASKIND,
    *LONG_WAVES,
    *HYDROSTATICS,
    *SECOND_ORDER,
)


def check(db: HydroDatabase) -> list[Finding]:
    """All findings about ``db``; only those about frequencies and headings if they are refused,
    because no other figure means anything then."""
    order = [one(db) for one in ORDER]
    if any(finding.refused for finding in order):
        return order
    return [*order, *(one(db) for one in CHECKS[len(ORDER) :])]
