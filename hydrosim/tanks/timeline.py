"""What is in the tanks over time without any motion, by flows that depend on time and levels.

What flows by triggers is not known without the motion: here it does not flow at all, and tanks that
it fills or empties have no problem.
"""

from __future__ import annotations

from math import inf
from typing import NamedTuple

import numpy as np

from hydrosim.tanks.contents import CLOSE, Tanks
from hydrosim.tanks.pumping import OVER, RUNNING, SEA, WAITING

MOST = 10_000  # changes of flows


class Problem(NamedTuple):
    """A ``flow`` that cannot go on at a ``time`` [s]: a tank is ``dry`` or ``over``, or there is
    ``nothing`` to pump."""

    flow: int
    tank: int | None
    time: float
    what: str


class Timeline(NamedTuple):
    """Times (n,) [s] at which flows change, ``volume`` (n, nt) [m^3] of each tank then, linear in
    between; the first ``problem``, where it ends."""

    time: np.ndarray
    volume: np.ndarray
    problem: Problem | None

    def at(self, time: float) -> np.ndarray:
        """Volumes (nt,) at a time."""
        return np.array([np.interp(time, self.time, v) for v in self.volume.T])


class _Flow:
    """A flow on its way."""

    def __init__(self, p: Tanks, i: int) -> None:
        self.p, self.of, self.piece = p, p.flows[i], int(p.flows["first"][i])
        self.mode = RUNNING if self.of["start_tank"] == SEA else WAITING
        if self.of["triggered"]:
            self.mode = OVER
        self.begun = 0.0

    @property
    def rate(self) -> float:
        return float(self.p.rates["rate"][self.piece]) if self.mode == RUNNING else 0.0

    def into(self, tank: int) -> float:
        """Its rate into a tank, negative out of it."""
        here = int(self.of["target"] == tank) - int(self.of["source"] == tank)
        return self.rate * here

    def next(self, t: float, volume: np.ndarray, speed: np.ndarray) -> float:
        """Time of its next change."""
        found, rates = inf, self.p.rates
        if self.mode == RUNNING and self.piece < self.of["last"]:
            found = max(float(rates["end"][self.piece]), t)
        which = {WAITING: "start", RUNNING: "stop"}.get(self.mode)
        if which and (self.mode == WAITING or self.rate != 0.0):
            tank, sign = int(self.of[f"{which}_tank"]), float(self.of[f"{which}_sign"])
            if tank != SEA:
                missing = sign * (self.of[f"{which}_volume"] - volume[tank])
                found = min(found, _reached(t, missing, sign * speed[tank]))
        if self.of["watched"] and self.rate != 0.0:
            for tank, room in self._rooms(volume):
                sign = -1.0 if tank == self.of["source"] else 1.0
                found = min(found, _reached(t, room, sign * speed[tank]))
        return found

    def _rooms(self, volume: np.ndarray) -> list[tuple[int, float]]:
        source, target = int(self.of["source"]), int(self.of["target"])
        rooms = [] if source == SEA else [(source, volume[source])]
        if target != SEA:
            rooms.append((target, self.p.each["capacity"][target] - volume[target]))
        return rooms

    def change(self, t: float) -> None:
        """Go on to what follows."""
        if self.mode == WAITING:
            self.mode, self.begun = RUNNING, t
            while self.piece < self.of["last"] and self.p.rates["end"][self.piece] <= t:
                self.piece += 1
        elif self.piece < self.of["last"] and self.p.rates["end"][self.piece] <= t:
            self.piece, self.begun = self.piece + 1, t
        else:
            self.mode = OVER


def _reached(t: float, missing: float, speed: float) -> float:
    """When what is missing has come at a speed."""
    if missing <= 0.0:
        return t
    return t + missing / speed if speed > 0.0 else inf


def follow(p: Tanks, end: float) -> Timeline:
    """The tanks from 0 to ``end`` [s], or to their first problem."""
    flows = [_Flow(p, i) for i in range(p.flows.size)]
    t, volume = 0.0, p.each["first_volume"].astype(float)
    times, volumes = [t], [volume.copy()]
    for _ in range(MOST):
        speed = _speeds(flows, p)
        changes = [flow.next(t, volume, speed) for flow in flows]
        then = min([*changes, end])
        problem = _problem(flows, t, then, volume, speed, p)
        if problem:
            return Timeline(np.array(times), np.array(volumes), problem)
        volume = volume + speed * (then - t)
        t = then
        times.append(t)
        volumes.append(volume.copy())
        if t >= end:
            break
        for i, (flow, at) in enumerate(zip(flows, changes, strict=True)):
            if at <= then:
                pumping = flow.rate != 0.0
                flow.change(t)
                known = {int(flow.of["source"]), int(flow.of["target"])}.isdisjoint(unforeseen(p))
                if flow.mode == OVER and pumping and flow.begun == t and known:
                    return Timeline(
                        np.array(times), np.array(volumes), Problem(i, None, t, "nothing")
                    )
    return Timeline(np.array(times), np.array(volumes), None)


def unforeseen(p: Tanks) -> set[int]:
    """The tanks that flows by triggers fill or empty."""
    by_triggers = p.flows[p.flows["triggered"]]
    return {*by_triggers["source"].tolist(), *by_triggers["target"].tolist()} - {SEA}


def _speeds(flows: list[_Flow], p: Tanks) -> np.ndarray:
    """Rates of the volumes (nt,) [m^3/s]."""
    speed = [sum(flow.into(tank) for flow in flows) for tank in range(p.each.size)]
    return np.array(speed) / p.each["density"]


def _problem(
    flows: list[_Flow], t: float, then: float, volume: np.ndarray, speed: np.ndarray, p: Tanks
) -> Problem | None:
    """A tank that runs dry or over before ``then``, with a flow that does it."""
    size = p.each["capacity"]
    after = volume + speed * (then - t)
    beyond = (after < -CLOSE * size) | (after > (1.0 + CLOSE) * size)
    beyond[[*unforeseen(p)]] = False
    for tank in np.flatnonzero(beyond).tolist():
        dry = after[tank] < 0.0
        room = volume[tank] if dry else size[tank] - volume[tank]
        guilty = next(i for i, f in enumerate(flows) if f.into(tank) * (-1.0 if dry else 1.0) > 0.0)
        when = t + max(room, 0.0) / abs(speed[tank])
        return Problem(guilty, tank, float(when), "dry" if dry else "over")
    return None
