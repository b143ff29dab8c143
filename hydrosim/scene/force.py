"""The base of all force elements."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from hydrosim.scene.triggers import Active


@dataclass(frozen=True)
class ForceElement:
    """Base of the elements in `hydrosim.forces`. ``body`` is the name of the body that it acts on;
    ``active`` limits the time. ``capacity`` [N] is the allowable force of each of its contact
    points or lines. Forces are compared with it; nothing breaks.

    The work of an element that ``supplies`` is booked as work, otherwise as dissipation. Each
    element declares its properties in its own file. An undeclared property only costs speed.
    """

    supplies: ClassVar[bool] = False
    body: str
    active: Active | None = field(default=None, kw_only=True)
    capacity: float | None = field(default=None, kw_only=True)

    def check(self, name: str) -> None:
        """Raises InputError for values that no case file allows, but a scene written in Python may
        have."""

    def supports_weight(self) -> bool:
        """True if it can carry weight."""
        return True

    def restored_dofs(self) -> Collection[str]:
        """Degrees of freedom among surge, sway and yaw in which it restores its body towards a
        position on earth."""
        return ()

    def dragging_streams(self) -> Collection[str]:
        """The streams, current or wind, that drag its body along through it."""
        return ()

    def can_add_energy(self) -> bool:
        """True if it can give energy to the bodies, though it is booked as dissipation."""
        return False

    def connected_bodies(self) -> Iterator[tuple[str, str | None]]:
        """Keys and names of the other bodies that it acts on."""
        yield from ()

    def signals(self) -> Iterator[tuple[str, Any]]:
        """Keys and signals over time of its prescribed changes."""
        yield from ()

    def jumps(self) -> Iterator[tuple[str, float]]:
        """Keys of its signals at whose corners its force jumps, with the largest jump [N]."""
        yield from ()

    def unit_names(self, name: str) -> Sequence[str]:
        """Names of its parts with states or modes, for an element called ``name``."""
        return ()

    def couplings(self) -> Iterator[np.ndarray]:
        """Its matrices (6, 6) of stiffness or damping, whose entries off the diagonal couple
        the coordinates of its body."""
        yield from ()

    def mirrored_parts(self, y: float) -> Sequence[ForceElement]:
        """Parts that must each have a mirror image in the plane at ``y`` [m], with coordinates
        relative to that plane. Empty if it acts by its `couplings` alone."""
        return (self,)

    def mirror_image(self) -> ForceElement | None:
        """The mirror image of a part in the plane y = 0; None if unknown."""
        return None

    def asymmetry(self) -> str | None:
        """Any other reason, in words, why it is not its own mirror image."""
        return None

    def nonlinearity(self, name: str, turns: Turns) -> str | None:
        """Reason why its force is not linear in the motions of its body; None if it is."""
        return name


@dataclass(frozen=True)
class Turns:
    """Rotations of a body: the ``free`` ones of its coordinates 3, 4, 5, with ``exact`` rotations
    or small angles. ``elements`` are all compiled elements, ``row`` is the row of the element in
    question."""

    free: Sequence[int]
    exact: bool
    elements: Any
    row: int
