"""Modes of units in which a scene is made linear, to see how stiff it can be.

`hydrosim.linear.stability` looks at all units of each kind in one mode, for each of its modes, and
at single units in a mode while the others rest.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from hydrosim.forces.kind import ElementKind
from hydrosim.modes import COLUMNS, MODE, SEGMENT

PRESSED = 0.01  # m: the compression beyond the start of a piece at which units are linearised


class Posture(NamedTuple):
    """Units of a kind in modes: how they stand in words, "" if that goes without saying, and their
    ``modes`` (n, 3)."""

    text: str
    modes: np.ndarray


class PosingKind(ElementKind):
    """A kind whose units have several postures, each with a stiffness of its own."""

    def postures(self, p: Any) -> Sequence[Posture]:
        """All units in one mode, for each mode; those that rest come first."""
        raise NotImplementedError

    def alone(self, p: Any, names: Sequence[str], which: Sequence[int]) -> Iterator[Posture]:
        """One of the units ``which`` alone in a mode, for each of them."""
        return iter(())

    def alike(self, p: Any) -> Sequence[Hashable]:
        """Of each unit all that sets its stiffness and damping, but for its place."""
        return []

    def rates(self, p: Any, bodies: Any, motion: Any) -> np.ndarray:
        """Velocities (n, k) at all units, in their directions."""
        return np.zeros((0, 0))

    def pressed(self, p: Any, modes: np.ndarray, bodies: Any, motion: Any) -> Any:
        """The constants with every unit where the piece of its curve wants it that ``modes`` say;
        in its place and direction, wherever the bodies are."""
        return p

    def time_of_most(self, p: Any) -> float:
        """Time at which the most is prescribed [s]; 0 if nothing is."""
        return 0.0

    def sliding_speed(self, p: Any, modes: np.ndarray, time: float) -> float:
        """Speed [m/s] at which units that slip do so without a doubt; 0 if none slips."""
        return 0.0

    def slide(
        self, p: Any, modes: np.ndarray, time: float, bodies: Any, motion: Any, y: np.ndarray
    ) -> None:
        """Put the states of units that slip in ``y`` into steady slip."""

    def idle_states(self, p: Any, modes: np.ndarray) -> np.ndarray:
        """States (m,) that act on nothing in these ``modes``."""
        return np.zeros(0, dtype=np.int64)


def rest_at_first(first: np.ndarray, mode: int) -> np.ndarray:
    """Modes (n, 3) of units in a ``mode``, on the ``first`` (n,) segment of each."""
    modes = np.zeros((len(first), COLUMNS), dtype=np.int64)
    modes[:, MODE] = mode
    modes[:, SEGMENT] = first
    return modes


def with_one(rest: np.ndarray, modes: np.ndarray, i: int) -> np.ndarray:
    """Modes (n, 3) of units at ``rest``, but for unit ``i``."""
    found = rest.copy()
    found[i] = modes[i]
    return found


def steepest(segments: np.ndarray, first: int, last: int) -> int:
    """The steepest of the segments ``first`` to ``last``."""
    return first + int(np.argmax(segments["slope"][first : last + 1]))
