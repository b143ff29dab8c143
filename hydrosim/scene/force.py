"""The base of all force elements."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from hydrosim.scene.triggers import Active


@dataclass(frozen=True)
class ForceElement:
    """Base of the elements in `hydrosim.forces`: ``body`` is the name of the body it acts on, and
    it may be ``active`` for a time only. ``capacity`` [N] is what each of its contact points or
    lines may carry: forces are compared with it, and nothing breaks.

    What an element that ``supplies`` does to the bodies is booked as work, else as dissipation. An
    element says in its own file what it can do; what it says nothing of costs speed alone.
    """

    supplies: ClassVar[bool] = False
    body: str
    active: Active | None = field(default=None, kw_only=True)
    capacity: float | None = field(default=None, kw_only=True)

    def check(self, name: str) -> None:
        """Raises InputError where the element is wrong as no case file can be, but one written in
        Python can."""

    def carries(self) -> bool:
        """Whether it can carry weight."""
        return True

    def holds(self) -> Collection[str]:
        """Of surge, sway and yaw, those in which it takes its body back to its place on earth."""
        return ()

    def feels(self) -> Collection[str]:
        """Of current and wind, those that drag its body along by it."""
        return ()

    def may_give(self) -> bool:
        """Whether it can give energy to the bodies, though it is booked as dissipation."""
        return False

    def others(self) -> Iterator[tuple[str, str | None]]:
        """Keys and names of the other bodies that it acts on."""
        yield from ()

    def signals(self) -> Iterator[tuple[str, Any]]:
        """Keys and signals over time of what changes with it."""
        yield from ()

    def unit_names(self, name: str) -> Sequence[str]:
        """Names of its parts that have states or modes, if the element is called ``name``."""
        return ()

    def couplings(self) -> Iterator[np.ndarray]:
        """Matrices (6, 6) by which it couples the coordinates of its body."""
        yield from ()

    def parts(self, y: float) -> Sequence[ForceElement]:
        """Parts of it that must each have a mirror image in the plane at ``y`` [m], as if that were
        the plane y = 0; none if it acts by its `couplings` alone."""
        return (self,)

    def image(self) -> ForceElement | None:
        """The mirror image of a part in the plane y = 0; None if nothing is known of it."""
        return None

    def asymmetry(self) -> str | None:
        """What else keeps it from being its own mirror image, in words."""
        return None

    def nonlinearity(self, name: str, turns: Turns) -> str | None:
        """Why its force is not linear in the motions of its body; None if it is."""
        return name


@dataclass(frozen=True)
class Turns:
    """How a body may turn: about the ``free`` of its coordinates 3, 4, 5, with ``exact`` rotations
    or small ones. ``elements`` are all elements as compiled, ``row`` that of the one in question.
    """

    free: Sequence[int]
    exact: bool
    elements: Any
    row: int
