"""Tanks whose contents change: mass and inertia of their bodies over time, pumps with triggers.

The states are the volumes of fluid V. With S, P, J of `hydrosim.tanks.surface`, density d, and
index 0 for the body without these contents,

    m = m_0 + sum d V,   m c = (m c)_0 + sum d S,   I = I_0 + sum d (tr P - P),   J = J_0 + sum d J

I about the body's origin. Neglected: the flow inside a tank, sloshing, and the effect of the slope
of a free surface on inertia. Tanks with constant contents are parts of their bodies.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import kernel, piece_of, root
from hydrosim.modes import MODE
from hydrosim.scene import Active, Body, LevelReached, Pump, Scene, Tank, When
from hydrosim.tanks import surface
from hydrosim.tanks.pumping import FLOW, PUMP_RATE_DTYPE

EQUAL_VOLUME_RTOL = 1e-9  # of a capacity: volumes this close are equal
TANK = np.dtype(
    [
        *(("body", int), ("density", float), ("capacity", float), ("first_volume", float)),
        *(("first", int), ("last", int), ("image", int)),
        ("liquid", int),
    ]
)
"""Constants of a tank. ``image`` is the index of its mirror image, or its own index if it has none.
``liquid`` is the index among tanks with a level surface (`hydrosim.tanks.surface`), -1 if its
surface is not level."""
REST = np.dtype(
    [
        *(("body", int), ("mass", float), ("moment", float, 3), ("inertia", float, (3, 3))),
        *(("surface", float, 3), ("inertial", bool)),
    ]
)
"""Constants of a body with such tanks, without their contents, and whether inertia follows the
contents."""


class Tanks(NamedTuple):
    """Constants: ``each`` (nt,) of `TANK` with the ``pieces`` of their shapes, ``rests`` of their
    bodies; ``flows`` (nf,) and their ``rates``. ``row`` and ``weight`` are the rows of forces of
    flow and of weight."""

    each: np.ndarray
    pieces: np.ndarray
    rests: np.ndarray
    flows: np.ndarray
    rates: np.ndarray
    row: int
    weight: int
    gravity: float
    current: np.ndarray  # (nb, 2) [m/s], on each body
    state: int = 0
    mode: int = 0


def no_tanks() -> Tanks:
    """Constants of a scene without such tanks."""
    tanks, pieces, rests = (np.zeros(0, dtype=kind) for kind in (TANK, surface.PIECE_DTYPE, REST))
    flows, rates = (np.zeros(0, dtype=kind) for kind in (FLOW, PUMP_RATE_DTYPE))
    return Tanks(tanks, pieces, rests, flows, rates, 0, 0, 0.0, np.zeros((0, 2)))


def changing_tanks(body: Body) -> list[Tank]:
    """The tanks of a body that a pump or a plan changes."""
    pumped = {name for pump in body.pumps for name in (pump.source, pump.target)}
    return [tank for tank in body.tanks if tank.plan or tank.name in pumped]


def tank_names(scene: Scene) -> list[str]:
    """Names of all tanks that change: "tank of body"."""
    return [f"{tank.name} of {body.name}" for body in scene.bodies for tank in changing_tanks(body)]


class FlowName(NamedTuple):
    """A flow by its ``key`` in a body of a case, and by its ``name``."""

    key: str
    name: str


def flows_of(body: Body) -> list[FlowName]:
    """The flows of a body, pumps before plans, in the order of `Tanks.flows`."""
    of = f"of {body.name}"
    pumps = [FlowName(f"pumps.{pump.name}", f"{pump.name} {of}") for pump in body.pumps]
    planned = [tank.name for tank in body.tanks if tank.plan is not None]
    return [*pumps, *(FlowName(f"tanks.{name}.plan", f"plan of {name} {of}") for name in planned)]


def flow_names(scene: Scene) -> list[str]:
    """Names of all flows: "pump of body", "plan of tank of body"."""
    return [flow.name for body in scene.bodies for flow in flows_of(body)]


@kernel
def level(k, y, p):
    """Level of tank ``k`` [m]."""
    tank = p.each[k]
    volume = y[p.state + k]
    piece = p.pieces[piece_of(volume, tank.first, tank.last, p.pieces)]
    return surface.value(piece, surface.FLUID_LEVEL, volume - piece.start)


@root
def fill(y, p, contents):
    """Fill ``contents`` with the contents of the tanks."""
    for rest in p.rests:
        b = rest.body
        contents.mass[b] = rest.mass
        for i in range(3):
            contents.moment[b, i] = rest.moment[i]
            contents.surface[b, i] = rest.surface[i]
            if rest.inertial:
                for j in range(3):
                    contents.inertia[b, i, j] = rest.inertia[i, j]
    for k in range(p.each.size):
        _fill_tank(y[p.state + k], p.each[k], p, contents)
    for rest in p.rests:
        if rest.inertial:
            b = rest.body
            contents.moving_mass[b] = contents.mass[b]
            for i in range(3):
                contents.moving_moment[b, i] = contents.moment[b, i]


@kernel
def _fill_tank(volume, tank, p, contents):
    """Add the contents of one tank."""
    b = tank.body
    d = tank.density
    piece = p.pieces[piece_of(volume, tank.first, tank.last, p.pieces)]
    x = volume - piece.start
    contents.mass[b] += d * volume
    for i in range(3):
        contents.moment[b, i] += d * surface.value(piece, surface.FIRST_MOMENT + i, x)
        contents.surface[b, i] += d * surface.value(piece, surface.SURFACE_MOMENT + i, x)
    for rest in p.rests:
        if rest.body == b and rest.inertial:
            _add_inertia(d, piece, x, contents.inertia[b])


@kernel
def _add_inertia(d, piece, x, inertia):
    """Add d (tr P - P)."""
    xx = surface.value(piece, surface.SECOND_MOMENT, x)
    yy = surface.value(piece, surface.SECOND_MOMENT + 1, x)
    zz = surface.value(piece, surface.SECOND_MOMENT + 2, x)
    xy = surface.value(piece, surface.SECOND_MOMENT + 3, x)
    xz = surface.value(piece, surface.SECOND_MOMENT + 4, x)
    yz = surface.value(piece, surface.SECOND_MOMENT + 5, x)
    inertia[0, 0] += d * (yy + zz)
    inertia[1, 1] += d * (xx + zz)
    inertia[2, 2] += d * (xx + yy)
    inertia[0, 1] -= d * xy
    inertia[1, 0] -= d * xy
    inertia[0, 2] -= d * xz
    inertia[2, 0] -= d * xz
    inertia[1, 2] -= d * yz
    inertia[2, 1] -= d * yz


def level_of(p: Tanks, k: int, volume: np.ndarray) -> np.ndarray:
    """Levels (n,) [m] of tank ``k`` at volumes (n,) [m^3]."""
    return quantity(p, k, volume, surface.FLUID_LEVEL)


def quantity(p: Tanks, k: int, volume: np.ndarray, which: int) -> np.ndarray:
    """Values of one quantity of `pieces` of tank ``k`` at volumes (n,)."""
    mine = p.pieces[p.each["first"][k] : p.each["last"][k] + 1]
    return surface.values_at(mine, volume, which)


def quantities(p: Tanks, volume: np.ndarray, which: int) -> np.ndarray:
    """Values of one quantity of `pieces` (nt, tanks) of all tanks at volumes (nt, tanks)."""
    values_by_tank = [quantity(p, k, volume[:, k], which) for k in range(p.each.size)]
    return np.stack(values_by_tank, axis=1)


def mass_and_centre(
    p: Tanks, mass_at_rest: np.ndarray, volume: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Mass (nt, nb) [kg] of bodies of ``mass_at_rest`` (nb,) at volumes (nt, tanks), and centre of
    gravity (nt, nb, 3) [m] from the origin, in the body frame."""
    mass = np.tile(mass_at_rest, (len(volume), 1))
    moment = np.zeros((*mass.shape, 3))
    for rest in p.rests:
        mass[:, rest["body"]] = rest["mass"]
        moment[:, rest["body"]] = rest["moment"]
    first = np.stack([quantities(p, volume, surface.FIRST_MOMENT + i) for i in range(3)], axis=2)
    for k, tank in enumerate(p.each):
        mass[:, tank["body"]] += tank["density"] * volume[:, k]
        moment[:, tank["body"]] += tank["density"] * first[:, k]
    return mass, moment / mass[:, :, None]


def is_mirrored(p: Tanks, y: np.ndarray, modes: np.ndarray) -> bool:
    """True if the contents and the flows are mirror symmetric about y = 0."""
    volume = y[p.state : p.state + p.each.size]
    image = p.each["image"]
    flow_modes = modes[p.mode : p.mode + p.flows.size]
    held = np.abs(volume - volume[image]) <= EQUAL_VOLUME_RTOL * p.each["capacity"]
    same = flow_modes[:, MODE] == flow_modes[p.flows["image"], MODE]
    return bool(held.all() and same.all())


# Pumps that begin or end by events, at times that only the run shows.


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
                start, until = (_event_of_moment(when, body) for when in (pump.start, pump.stop))
                key = f"bodies.{body.name}.pumps.{pump.name}"
                yield TriggeredPump(i, key, Active(start, until))
        first += len(flows_of(body))


def _event_of_moment(when: float | LevelReached | When | None, body: Body) -> When | None:
    """The condition of a trigger for a time or a level."""
    if isinstance(when, LevelReached):
        channel = f"tank_level.{when.tank} of {body.name}"
        return When(channel=channel, above=when.above, below=when.below)
    return When(float(when)) if isinstance(when, float | int) else when
