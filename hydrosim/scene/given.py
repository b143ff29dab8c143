"""Data that a file does not hold and its user knows."""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import StrEnum

# In a database's attribute ``assumed``: reference points at the program's default, or unknown.
ORIGIN_ASSUMED = "reference points at the origin"
POINTS_UNKNOWN = "unknown reference points"


class FrequencyColumn(StrEnum):
    """Meaning of the frequency column in a program's tables (WAMIT's IPEROUT, 1 to 4)."""

    PERIOD = "period"  # [s]
    FREQUENCY = "frequency"  # [rad/s]
    DEEP_WAVENUMBER = "deep wavenumber"  # w^2/g, times the length
    WAVENUMBER = "wavenumber"  # wavenumber in this water depth, times the length


@dataclass(frozen=True)
class Given:
    """Values in SI units and the database's frame; None where the file must give them.

    ``length`` is the length by which a program divides (WAMIT's ULEN). Points are of one body or,
    for several bodies, one after the other. ``draught`` is the name of one of several draughts in a
    file. ``frequencies`` [rad/s] are the lowest and highest that are used: others need no numbers.
    Readers use the values that they need.
    """

    length: float | None = None
    water_density: float | None = None
    gravity: float | None = None
    water_depth: float | None = None
    volume: tuple[float, ...] | None = None
    centre_of_buoyancy: tuple[float, ...] | None = None
    centre_of_gravity: tuple[float, ...] | None = None
    reference_point: tuple[float, ...] | None = None
    frequency_column: FrequencyColumn | None = None
    port_starboard_symmetric: bool | None = None
    draught: str | None = None
    frequencies: tuple[float, float] | None = None


NOTHING_GIVEN = Given()


def key_of(item: str) -> str:
    """Name of an item in a case; the same after --given."""
    return {"port_starboard_symmetric": "symmetric"}.get(item, item.removeprefix("water_"))


def first_given(*sources: Given) -> Given:
    """For each item, the first value that is not None."""
    chosen = {}
    for item in fields(Given):
        values = (getattr(source, item.name) for source in sources)
        chosen[item.name] = next((value for value in values if value is not None), None)
    return Given(**chosen)
