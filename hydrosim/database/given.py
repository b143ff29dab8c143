"""What a file does not hold and its user knows."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Given:
    """In SI units and the database's frame; None where the file is to say it.

    ``length`` is the one that a program divides by (WAMIT's ULEN). Points are of one body or, for
    several, one after the other. Readers use what they need and leave the rest.
    """

    length: float | None = None
    water_density: float | None = None
    gravity: float | None = None
    water_depth: float | None = None
    volume: tuple[float, ...] | None = None
    centre_of_buoyancy: tuple[float, ...] | None = None
    centre_of_gravity: tuple[float, ...] | None = None
    reference_point: tuple[float, ...] | None = None


NOTHING_GIVEN = Given()
