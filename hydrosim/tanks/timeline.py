"""Contents of tanks over time without motion, and bodies together with these contents.

Flows with triggers depend on the motion. They are zero here, and tanks that they fill or empty
raise no problem.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.modes import MARGINS, MODE, MODE_COLUMNS, SEGMENT
from hydrosim.scene import Body, FreeSurface, Tank
from hydrosim.tanks import pumping
from hydrosim.tanks.contents import EQUAL_VOLUME_RTOL, Tanks, changing_tanks
from hydrosim.tanks.shapes import pieces, volume_at
from hydrosim.tanks.surface import FIRST_MOMENT, PAIRS, SECOND_MOMENT, SURFACE_MOMENT, quantities_at

MAX_FLOW_CHANGES = 10_000  # most changes of flows


class FlowProblem(NamedTuple):
    """A ``flow`` that cannot continue at a ``time`` [s]: a tank is ``dry`` or ``over``, or there is
    ``nothing`` to pump."""

    flow: int
    tank: int | None
    time: float
    what: str


class Timeline(NamedTuple):
    """Times (n,) [s] at which flows change, and the ``volume`` (n, nt) [m^3] of each tank then,
    linear in between. It ends at the first ``problem``."""

    time: np.ndarray
    volume: np.ndarray
    problem: FlowProblem | None

    def volumes_at(self, time: float) -> np.ndarray:
        """Volumes (nt,) at a time."""
        return np.array([np.interp(time, self.time, v) for v in self.volume.T])


def integrate_tanks(p: Tanks, end: float) -> Timeline:
    """Integrate the tanks from 0 to ``end`` [s], or to their first problem."""
    p = p._replace(state=0, mode=0)
    modes = np.zeros((p.flows.size, MODE_COLUMNS), dtype=np.int64)
    pumping.set_initial_modes(0.0, modes, p)
    modes[p.flows["triggered"], MODE] = pumping.PUMP_ENDED
    t = 0.0
    volume = p.each["first_volume"].astype(float)
    begun = np.zeros(p.flows.size)
    times = [t]
    volumes = [volume.copy()]
    problem = None
    for _ in range(MAX_FLOW_CHANGES):
        speed = _volume_rates(modes, p)
        changes = _times_of_changes(t, volume, speed, modes, p)
        then = min(changes.min(initial=np.inf), end)
        problem = _flow_problem(modes, t, then, volume, speed, p)
        if problem:
            break
        volume = volume + speed * (then - t)
        t = then
        times.append(t)
        volumes.append(volume.copy())
        if t < end:
            problem = _switch_flows(t, changes, modes, begun, p)
        if problem or t >= end:
            break
    return Timeline(np.array(times), np.array(volumes), problem)


def _mass_flows(modes: np.ndarray, p: Tanks) -> np.ndarray:
    """Mass per time (nf,) of the flows."""
    return np.where(modes[:, MODE] == pumping.PUMP_RUNNING, p.rates["rate"][modes[:, SEGMENT]], 0.0)


def _volume_rates(modes: np.ndarray, p: Tanks) -> np.ndarray:
    """Rates of the volumes (nt,) [m^3/s]."""
    return (_mass_flows(modes, p) @ _flow_matrix(p)) / p.each["density"]


def _flow_matrix(p: Tanks) -> np.ndarray:
    """Matrix (nf, nt) of flows and tanks: 1 if the flow fills the tank, -1 if it empties it."""
    tanks = np.arange(p.each.size)
    filled = p.flows["target"][:, None] == tanks
    emptied = p.flows["source"][:, None] == tanks
    return filled.astype(float) - emptied


def _times_of_changes(
    t: float, volume: np.ndarray, speed: np.ndarray, modes: np.ndarray, p: Tanks
) -> np.ndarray:
    """Times (nf, 4) [s] at which the margins of the flows reach zero: margins are linear in
    time."""
    now = np.zeros((p.flows.size, MARGINS))
    later = np.zeros_like(now)
    pumping.find_margins(t, volume, modes, p, now.reshape(-1))
    pumping.find_margins(t + 1.0, volume + speed, modes, p, later.reshape(-1))
    shrinking = np.where(later < now, now - later, np.nan)
    reached = t + np.nan_to_num(now / shrinking, nan=np.inf)
    return np.where(now <= 0.0, t, reached)


def _switch_flows(
    t: float, changes: np.ndarray, modes: np.ndarray, begun: np.ndarray, p: Tanks
) -> FlowProblem | None:
    """Switch the flows that change now. The first flow that ends as it begins, with ``begun`` (nf,)
    [s], is a problem, unless a trigger fills or empties its tanks."""
    rates = _mass_flows(modes, p)
    foreseen = triggered_tanks(p)
    for i in np.flatnonzero((changes <= t).any(axis=1)).tolist():
        pumping.switch_flow(i, int(np.argmax(changes[i] <= t)), t, modes, p)
        ends = {int(p.flows["source"][i]), int(p.flows["target"][i])}
        over = modes[i, MODE] == pumping.PUMP_ENDED and rates[i] != 0.0
        if over and begun[i] == t and ends.isdisjoint(foreseen):
            return FlowProblem(i, None, t, "nothing")
        begun[i] = begun[i] if modes[i, MODE] == pumping.PUMP_ENDED else t
    return None


def triggered_tanks(p: Tanks) -> set[int]:
    """The tanks that flows with triggers fill or empty."""
    by_triggers = p.flows[p.flows["triggered"]]
    return {*by_triggers["source"].tolist(), *by_triggers["target"].tolist()} - {pumping.SEA_INDEX}


def _flow_problem(
    modes: np.ndarray, t: float, then: float, volume: np.ndarray, speed: np.ndarray, p: Tanks
) -> FlowProblem | None:
    """A tank that runs dry or over before ``then``, with a flow that causes it."""
    size = p.each["capacity"]
    after = volume + speed * (then - t)
    beyond = (after < -EQUAL_VOLUME_RTOL * size) | (after > (1.0 + EQUAL_VOLUME_RTOL) * size)
    beyond[[*triggered_tanks(p)]] = False
    given = _mass_flows(modes, p)[:, None] * _flow_matrix(p)
    for tank in np.flatnonzero(beyond).tolist():
        dry = after[tank] < 0.0
        room = volume[tank] if dry else size[tank] - volume[tank]
        guilty = int(np.argmax(given[:, tank] * (-1.0 if dry else 1.0) > 0.0))
        when = t + max(room, 0.0) / abs(speed[tank])
        return FlowProblem(guilty, tank, float(when), "dry" if dry else "over")
    return None


# A body with its contents: mass, centre of gravity, inertia, free surfaces.


class Loading(NamedTuple):
    """``mass`` [kg], ``centre`` of gravity (3,) [m], ``inertia`` (3, 3) about it [kg m^2], and
    ``surface`` (3,) [kg m^2], density times second moments xx, xy, yy of the free surfaces."""

    mass: float
    centre: np.ndarray
    inertia: np.ndarray
    surface: np.ndarray

    @property
    def matrix(self) -> np.ndarray:
        """6 x 6 matrix about the origin of the frame in which the centre is given."""
        cross = np.cross(np.eye(3), self.mass * self.centre)
        turning = self.inertia + self.mass * _moments_of_inertia(np.outer(self.centre, self.centre))
        return np.block([[self.mass * np.eye(3), cross.T], [cross, turning]])


def loaded_body(
    mass: float,
    centre: Iterable[float],
    inertia: np.ndarray,
    contents: Iterable[tuple[Tank, float]],
    sign: float = 1.0,
) -> Loading:
    """A body with the ``contents``, tanks and their volumes [m^3], added (or subtracted if ``sign``
    is -1); all in one frame."""
    c = np.array([*centre], dtype=float)
    first, second, surface = mass * c, mass * np.outer(c, c), np.zeros(3)
    for tank, volume in contents:
        held = sign * tank.density * quantities_at(pieces(tank.shape, np.zeros(3)), volume)
        mass += sign * tank.density * volume
        first += held[FIRST_MOMENT : FIRST_MOMENT + 3]
        second += symmetric_matrix(held[SECOND_MOMENT : SECOND_MOMENT + 6])
        if tank.free_surface == FreeSurface.QUASI_STATIC:
            surface += held[SURFACE_MOMENT:]
    C = first / mass
    about = inertia + _moments_of_inertia(second - mass * np.outer(C, C))
    return Loading(float(mass), C, about, surface)


def body_without(body: Body, contents: Iterable[tuple[Tank, float]]) -> Loading:
    """A body without the contents of some of its tanks at the start."""
    return loaded_body(body.mass, body.centre_of_gravity, body.inertia, contents, -1.0)


def least_moment(body: Body, inertia: np.ndarray) -> float:
    """The least moment [kg m^2] of an ``inertia`` (3, 3) about the free axes of rotation; infinite
    if the body may not turn."""
    turns = [i for i in range(3) if DOFS[3 + i] in body.dofs]
    return float(np.linalg.eigvalsh(inertia[np.ix_(turns, turns)])[0]) if turns else np.inf


def tanks_at_start(tanks: Iterable[Tank]) -> list[tuple[Tank, float]]:
    """Tanks with their contents at the start."""
    return [(tank, volume_at(tank.shape, tank.level)) for tank in tanks]


def contents_at(
    bodies: Sequence[Body], moved: Iterable[float]
) -> Iterator[tuple[int, Tank, float]]:
    """All tanks by the number of their body, with their volumes [m^3]; ``moved`` are the volumes in
    tanks that change."""
    volumes = iter(moved)
    for b, body in enumerate(bodies):
        every = changing_tanks(body)
        for tank, volume in tanks_at_start(body.tanks):
            yield b, tank, float(next(volumes)) if tank in every else volume


def symmetric_matrix(six: np.ndarray) -> np.ndarray:
    """Matrix (3, 3) from xx, yy, zz, xy, xz, yz."""
    full = np.zeros((3, 3))
    for (i, j), value in zip(PAIRS, six, strict=True):
        full[i, j] = full[j, i] = value
    return full


def _moments_of_inertia(P: np.ndarray) -> np.ndarray:
    """tr P - P: moments of inertia of second moments."""
    return np.trace(P) * np.eye(3) - P
