"""Checks of a hydrodynamic database against identities that hold for any floating body.

Each finding is one figure, ideally zero, with a limit above which the user should check it. Some
have a refusal: above it, only a wrong sign, unit or convention is possible, and the database is not
used. Data that a scene does not use are not checked, see `Use`.
"""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches
from functools import lru_cache

from hydrosim.database.checks.finding import (
    ACCEPTED_ATTRIBUTE,
    EVERYTHING,
    Check,
    CheckSubject,
    Finding,
    Use,
    accepted_findings,
)
from hydrosim.database.checks.long_waves import LONG_WAVES
from hydrosim.database.checks.radiation import HASKIND, RADIATION
from hydrosim.database.checks.ranges import HYDROSTATICS, ORDER_CHECKS, RANGES
from hydrosim.database.checks.second_order import SECOND_ORDER
from hydrosim.database.database import HydroDatabase
from hydrosim.errors import InputError

CHECKS: tuple[Check, ...] = (
    *ORDER_CHECKS,
    *RANGES,
    *RADIATION,
    *HASKIND,
    *LONG_WAVES,
    *HYDROSTATICS,
    *SECOND_ORDER,
)
SYMMETRIES = {"symmetry of added mass", "symmetry of radiation damping", "port and starboard"}
"""Checks of errors that `symmetrise` removes."""
CHECK_NAMES = tuple(order_check.name for order_check in CHECKS)


def unknown_name_message(name: str) -> str:
    """Message on an unknown name of a finding; empty if a check has that name."""
    if name in CHECK_NAMES:
        return ""
    near = get_close_matches(name, CHECK_NAMES, 1)
    return f'found "{name}"; expected ' + (
        f'"{near[0]}"' if near else f"one of {', '.join(CHECK_NAMES)}"
    )


def check(db: HydroDatabase, use: Use = EVERYTHING) -> list[Finding]:
    """All findings about the data in ``use`` of ``db``. If frequencies or headings are refused,
    only their findings, because no other figure is meaningful then."""
    order = [order_check(db) for order_check in ORDER_CHECKS]
    if any(finding.is_refused for finding in order):
        return order
    return [*order, *(order_check(db, use) for order_check in CHECKS[len(ORDER_CHECKS) :])]


def require_ascending(db: HydroDatabase) -> HydroDatabase:
    """Return the database. Raises `InputError` if frequencies or headings are out of order."""
    refuse_database(db, [order_check(db) for order_check in ORDER_CHECKS])
    return db


@lru_cache(maxsize=8)
def _all_findings(db: HydroDatabase, use: Use) -> tuple[Finding, ...]:
    return tuple(check(db, use))


def refusing_findings(db: HydroDatabase, use: Use) -> tuple[Finding, ...]:
    """Findings that refuse the database for this ``use``."""
    return tuple(finding for finding in _all_findings(db, use) if finding.is_refused)


def doubt_warnings(db: HydroDatabase, use: Use) -> tuple[str, ...]:
    """A warning of all doubted findings, if there are any; `hydrosim db check` has their advice.
    Raises `InputError` if the database is refused for this ``use``."""
    findings = _all_findings(db, use)
    refuse_database(db, findings)
    doubted = [finding.summary for finding in findings if finding.is_doubted]
    if not doubted:
        return ()
    pronoun = "it" if len(doubted) == 1 else "each"
    return (f"{db.source}: {'; '.join(doubted)}. `hydrosim db check` explains {pronoun}.",)


def refuse_database(db: HydroDatabase, findings: Sequence[Finding]) -> None:
    """Raises `InputError` if one of the ``findings`` refuses the database."""
    bad = [finding for finding in findings if finding.is_refused]
    if not bad:
        return
    reasons = "\n".join(f"  {finding}" for finding in bad)
    names = ", ".join(finding.name for finding in bad)
    noise = (
        " If the asymmetry is noise, remove it with `symmetrise: true` or"
        " `--given symmetrise=true`."
    )
    remedy = noise if SYMMETRIES & {finding.name for finding in bad} else ""
    raise InputError(
        f"{db.source}: the database cannot be right:\n{reasons}\nIf you know that it is, set"
        f" `hydrodynamics: {{file: ..., accept: [{names}]}}` in the case, or"
        f" `--given 'accept=[{names}]'` in `hydrosim db convert`.{remedy}"
    )
