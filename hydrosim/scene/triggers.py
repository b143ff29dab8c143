"""Conditions for the start and the end of an action."""

from __future__ import annotations

from dataclasses import dataclass


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
    ``lasting`` [s]. `hydrosim.forces.channels` lists the names of channels."""

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
