"""Factors between units, kept on disk: pint and its units take half a second to load, and the
units that people write are few."""

from __future__ import annotations

import hashlib
import json
from contextlib import suppress
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path

from hydrosim.cache import cache_root, store

MOST = 1000  # in the file


def known(unit: str, si: str) -> float | None:
    """What `keep` was told, by this process or an earlier one."""
    return _factors().get(_key(unit, si))


def keep(unit: str, si: str, factor: float) -> None:
    """Remember that a number in ``unit`` times ``factor`` is in ``si``."""
    factors = _factors()
    factors[_key(unit, si)] = factor
    if len(factors) <= MOST:
        with suppress(OSError):  # a folder that cannot be written costs only time
            store(_file(), lambda file: file.write(json.dumps(factors).encode()))


def _key(unit: str, si: str) -> str:
    return f"{unit} in {si}"


@lru_cache(maxsize=1)
def _factors() -> dict[str, float]:
    with suppress(OSError, ValueError, AttributeError, TypeError):
        found = json.loads(_file().read_bytes())
        return {str(key): float(factor) for key, factor in found.items()}
    return {}


@lru_cache(maxsize=1)
def _file() -> Path:
    """Another pint, or other rules for units, are another file."""
    rules = Path(__file__).with_name("units.py").read_bytes()
    digest = hashlib.sha256(version("pint").encode() + rules)
    return cache_root() / f"units-{digest.hexdigest()[:16]}.json"
