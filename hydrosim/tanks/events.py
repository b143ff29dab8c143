"""Pumps that begin or end by events, whose times are known only during the run."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from hydrosim.scene import Active, Body, LevelReached, Pump, Scene, When
from hydrosim.tanks.contents import flows_of


class TriggeredPump(NamedTuple):
    """A ``flow`` that begins and ends by events, and the ``key`` of its pump in a case."""

    flow: int
    key: str
    active: Active


def unforeseen_tanks(body: Body) -> set[str | None]:
    """Names of the tanks that pumps with events fill or empty."""
    pumps = [pump for pump in body.pumps if is_triggered(pump)]
    return {end for pump in pumps for end in (pump.source, pump.target)} - {None}


def is_triggered(pump: Pump) -> bool:
    """True if a pump begins or ends by an event."""
    return isinstance(pump.start, When) or isinstance(pump.stop, When)


def triggered_pumps(scene: Scene) -> Iterator[TriggeredPump]:
    """The pumps that begin or end by events, with the index of their flow."""
    first = 0
    for body in scene.bodies:
        for i, pump in enumerate(body.pumps, first):
            if is_triggered(pump):
                start, until = (_event(when, body) for when in (pump.start, pump.stop))
                key = f"bodies.{body.name}.pumps.{pump.name}"
                yield TriggeredPump(i, key, Active(start, until))
        first += len(flows_of(body))


def _event(when: float | LevelReached | When | None, body: Body) -> When | None:
    """The condition of a trigger for a time or a level."""
    if isinstance(when, LevelReached):
        side = {"above" if when.above else "below": when.level}
        return When(channel=f"tank_level.{when.tank} of {body.name}", **side)
    return When(float(when)) if isinstance(when, float | int) else when
