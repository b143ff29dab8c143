"""Factors between units, stored on disk: pint and its units take half a second to load, and people
write few different units."""

from __future__ import annotations

import hashlib
import json
from functools import lru_cache
from pathlib import Path

from hydrosim.cache import store, stored
from hydrosim.program import digest_of_sources, version_of

MAX_FACTORS = 1000  # factors in the file


def stored_factor(unit: str, si: str) -> float | None:
    """A factor that `store_factor` has stored, in this process or an earlier one; None if
    unknown."""
    return _factors().get(_key(unit, si))


def store_factor(unit: str, si: str, factor: float) -> None:
    """Store that a number in ``unit`` times ``factor`` is in ``si``."""
    factors = _factors()
    factors[_key(unit, si)] = factor
    if len(factors) <= MAX_FACTORS:
        store(_name(), json.dumps(factors).encode())


def _key(unit: str, si: str) -> str:
    return f"{unit} in {si}"


@lru_cache(maxsize=1)
def _factors() -> dict[str, float]:
    found = stored(_name())
    return {} if found is None else dict(json.loads(found))


def _name() -> str:
    """Name of the file; another version of pint or other rules for units give another name."""
    rules = digest_of_sources(Path(__file__).parent, "units.py")
    digest = hashlib.sha256(f"{version_of('pint')} {rules}".encode())
    return f"units-{digest.hexdigest()[:16]}.json"
