"""When something begins or ends to act."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LevelReached:
    """When the level of a tank [m] is above or, else, below this."""

    tank: str
    level: float
    above: bool


@dataclass(frozen=True)
class When:
    """A ``time`` [s]; or, of a ``channel``, that it has been ``above`` or ``below`` a value for so
    long, ``lasting`` [s] (the names of channels are in `hydrosim.forces.channels`)."""

    time: float = 0.0
    channel: str | None = None
    above: float | None = None
    below: float | None = None
    lasting: float = 0.0


@dataclass(frozen=True)
class Active:
    """When something begins to act, from the ``start`` if None, and ``until`` when, to the end if
    None. What has begun or ended does not do so again."""

    start: When | None = None
    until: When | None = None
