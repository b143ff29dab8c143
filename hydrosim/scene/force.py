"""The base of all force elements, conditions for their action, and properties of chain."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

# Conditions for the start and the end of an action.


@dataclass(frozen=True)
class LevelReached:
    """The moment when the level of a tank [m] is above this ``level``, or below it if ``above`` is
    false."""

    tank: str
    level: float
    above: bool


@dataclass(frozen=True)
class When:
    """A ``time`` [s], or the moment when a ``channel`` has been ``above`` or ``below`` a value for
    ``lasting`` [s]. `hydrosim.elements.trigger` lists the names of channels."""

    time: float = 0.0
    channel: str | None = None
    above: float | None = None
    below: float | None = None
    lasting: float = 0.0


@dataclass(frozen=True)
class Active:
    """Period in which an element acts: from ``start`` (the beginning if None) ``until`` the given
    moment (the end if None). Neither start nor end occurs twice."""

    start: When | None = None
    until: When | None = None


@dataclass(frozen=True)
class ForceElement:
    """Base of the elements in `hydrosim.elements`. ``body`` is the name of the body that it acts
    on; ``active`` limits the time. ``capacity`` [N] is the allowable force of each of its contact
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

    def can_carry_weight(self) -> bool:
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


# Chain by its bar diameter d (Orcina, OrcaFlex manual, "Chain: mechanical properties"), and the
# breaking load of offshore grades (IACS UR W22),
#
#     C d^2 (44 - 0.08 d) kN,   d in mm,   C = 0.0223 (R3), 0.0249 (R3S), 0.0274 (R4), 0.0320 (R5).

STEEL = 7850.0  # kg/m^3
CHAIN = {"studless": (19.9e3, 85.4e9), "studlink": (21.9e3, 101.0e9)}
"""Mass per length over squared diameter [kg/m^3] and axial stiffness over squared diameter
[N/m^2]."""
STRONGEST = 0.0320  # C of grade R5


def strongest_breaking_load(diameter: float) -> float:
    """Breaking load [N] of chain of grade R5 with this bar ``diameter`` [m]."""
    d = 1e3 * diameter
    return 1e3 * STRONGEST * d**2 * (44.0 - 0.08 * d)
