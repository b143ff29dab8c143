"""Versions of packages and digests of sources: which program computed a result."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from platform import python_version

PACKAGE = Path(__file__).parent
SHIPPED_FITS = PACKAGE / "radiation" / "shipped.zip"
"""Fits of radiation that came with the package, under their names in the cache."""
NUMERICAL = ("numpy", "scipy", "numba", "llvmlite")


def version_of(package: str) -> str:
    """Version of an installed package."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def program_version() -> str:
    """Version of this program."""
    return version_of("hydrosim")


def versions() -> str:
    """Versions of Python and of the packages that numbers depend on."""
    packages = (f"{name} {version_of(name)}" for name in NUMERICAL)
    return ", ".join([f"Python {python_version()}", *packages])


@cache
def digest_of_sources(home: Path, *parts: str) -> str:
    """SHA-256 (hex) of the files ``parts`` of the folder ``home``, and of all modules in folders
    among them. It does not depend on where ``home`` is."""
    digest = hashlib.sha256()
    for path in _files(home, parts):
        content = path.read_bytes()
        digest.update(f"{path.relative_to(home).as_posix()} {len(content)} ".encode() + content)
    return digest.hexdigest()


def _files(home: Path, parts: Sequence[str]) -> Iterator[Path]:
    for place in map(home.joinpath, parts):
        yield from [place] if place.is_file() else sorted(place.rglob("*.py"))
