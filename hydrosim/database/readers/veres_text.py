"""Common parts of VERES's result files: lines of text, then rows of numbers by speed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hydrosim.database.database import Real
from hydrosim.database.readers.text import Text, read_text
from hydrosim.errors import InputError

HALF_TURN_SIGNS = np.array([-1.0, -1.0, 1.0, -1.0, -1.0, 1.0])  # half a turn about z
NO_SPEED = 1e-6  # m/s

_TEXT = 6  # lines of it
_MIN_DIMENSION, _MAX_DIMENSION = 1e-3, 1e5  # of dimensions of a ship and properties of water


class NumberLines:
    """Rows of numbers, one after the other."""

    def __init__(self, path: Path) -> None:
        self.text: Text = read_text(path)
        self.at = _TEXT

    def row(self, what: str, *counts: int) -> list[float]:
        """The next line, with one of these counts of numbers."""
        words = self.text.line(self.at, what).split()
        self.at += 1
        if len(words) not in counts:
            raise self.wrong(f"{len(words)} numbers", f"{' or '.join(map(str, counts))}: {what}")
        return self.text.numbers(self.at - 1, words)

    def counts(self, what: str, count: int) -> list[int]:
        """The next line, of whole numbers."""
        return [self.text.count(self.at - 1, f"{value:g}") for value in self.row(what, count)]

    def matrix(self, what: str) -> Real:
        """Six rows of six, in our axes."""
        return np.array([self.row(what, 6) for _ in range(6)]) * np.outer(
            HALF_TURN_SIGNS, HALF_TURN_SIGNS
        )

    def wrong(self, found: str, expected: str, *advice: str) -> InputError:
        """Error to raise about the last line read."""
        return self.text.wrong(self.at - 1, found, expected, *advice)


@dataclass(frozen=True)
class Ship:
    """Data in the head of a file, in SI units."""

    density: float
    gravity: float
    length: float
    breadth: float
    draught: float


def ship_of(lines: NumberLines) -> Ship:
    """Values of the next two lines."""
    density, gravity = lines.row("density and gravity", 2)
    found = Ship(density, gravity, *lines.row("length, breadth and draught", 3))
    sizes = density, gravity, found.length, found.breadth
    if not _MIN_DIMENSION <= min(sizes) <= max(sizes) <= _MAX_DIMENSION:
        raise lines.wrong("numbers of no ship", "density, gravity, length and breadth in SI units")
    return found


def counts_of(lines: NumberLines) -> tuple[int, int, int]:
    """Numbers of speeds, headings and frequencies."""
    *counts, dofs = lines.counts("numbers of speeds, headings, frequencies and DOFs", 4)
    if dofs != 6 or 0 in counts:
        raise lines.wrong(
            f"{counts} speeds, headings and frequencies and {dofs} DOFs",
            "one at least of each and 6 DOFs",
            "Leave out the air cushion.",
        )
    return counts[0], counts[1], counts[2]


def at_rest(lines: NumberLines, speeds: int, size: int) -> tuple[float, float]:
    """Skip to the speed of zero, with ``size`` lines for each speed. Returns the position of its
    motion coordinate system, aft of amidships and above the keel."""
    found = []
    for _ in range(speeds):
        speed, sinkage, trim, *place = lines.row("speed, sinkage, trim, and X and Z of motions", 5)
        if sinkage or trim:
            raise lines.wrong(
                f"a sinkage of {sinkage:g} m and a trim of {trim:g} degrees",
                "none",
                "Give VERES the draught at which the ship floats, and no trim.",
            )
        if abs(speed) < NO_SPEED:
            return place[0], place[1]
        found.append(f"{speed:g}")
        lines.at += size
    raise lines.wrong(
        f"speeds of {', '.join(found)} m/s",
        "one of zero",
        "Let VERES compute a speed of zero, too.",
    )
