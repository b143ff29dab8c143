"""Modes of units in which a scene is linearised to find its largest stiffness.

`hydrosim.linear.stability` analyses all units of each kind in one mode, for each of its modes, and
single units in a mode while the other units rest.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from hydrosim.forces.kind import ElementKind
from hydrosim.modes import MODE, MODE_COLUMNS, SEGMENT

LINEARISATION_DEPTH = (
    0.01  # m: the compression beyond the start of a piece at which units are linearised
)


class ModeSet(NamedTuple):
    """Units of a kind in given ``modes`` (n, 3), with a description in words, "" for the default
    posture."""

    text: str
    modes: np.ndarray


class KindWithModeSets(ElementKind):
    """A kind whose units have several postures, each with a stiffness of its own."""

    def mode_sets(self, p: Any) -> Sequence[ModeSet]:
        """All units in one mode, for each mode; the posture at rest comes first."""
        raise NotImplementedError

    def one_unit_active(
        self, p: Any, names: Sequence[str], which: Sequence[int]
    ) -> Iterator[ModeSet]:
        """One of the units ``which`` alone in a mode, for each of them."""
        return iter(())

    def equivalence_keys(self, p: Any) -> Sequence[Hashable]:
        """For each unit, all properties that set its stiffness and damping, except its position."""
        return []

    def rates(self, p: Any, bodies: Any, motion: Any) -> np.ndarray:
        """Velocities (n, k) at all units, in their directions."""
        return np.zeros((0, 0))

    def moved_onto_segment(self, p: Any, modes: np.ndarray, bodies: Any, motion: Any) -> Any:
        """The constants with every unit on the piece of its curve given by ``modes``, at its
        position and in its direction, wherever the bodies are."""
        return p

    def time_of_largest_load(self, p: Any) -> float:
        """Time of the largest prescribed load [s]; 0 if nothing is prescribed."""
        return 0.0

    def sliding_speed(self, p: Any, modes: np.ndarray, time: float) -> float:
        """Speed [m/s] at which slipping units certainly slip; 0 if none slips."""
        return 0.0

    def set_steady_slip(
        self, p: Any, modes: np.ndarray, time: float, bodies: Any, motion: Any, y: np.ndarray
    ) -> None:
        """Put the states of slipping units in ``y`` into steady slip."""

    def idle_states(self, p: Any, modes: np.ndarray) -> np.ndarray:
        """States (m,) that act on nothing in these ``modes``."""
        return np.zeros(0, dtype=np.int64)


def rest_at_first(first: np.ndarray, mode: int) -> np.ndarray:
    """Modes (n, 3) of units in a ``mode``, on the ``first`` (n,) segment of each."""
    modes = np.zeros((len(first), MODE_COLUMNS), dtype=np.int64)
    modes[:, MODE] = mode
    modes[:, SEGMENT] = first
    return modes


def with_mode_of_unit(rest: np.ndarray, modes: np.ndarray, i: int) -> np.ndarray:
    """Modes (n, 3) of units at ``rest``, except unit ``i``."""
    found = rest.copy()
    found[i] = modes[i]
    return found


def steepest_segment(segments: np.ndarray, first: int, last: int) -> int:
    """The steepest of the segments ``first`` to ``last``."""
    return first + int(np.argmax(segments["slope"][first : last + 1]))
