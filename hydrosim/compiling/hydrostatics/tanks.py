"""Constants of tanks and pumps. Tanks whose contents stay are part of their bodies."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

import numpy as np

from hydrosim.compiling.hydrostatics.liquids import cut_shape, cut_tanks
from hydrosim.compiling.hydrostatics.tank_checks import check_flow, check_tanks
from hydrosim.compiling.streams.currents import currents_on
from hydrosim.forces.layout import BALLAST, WEIGHT, has_flow, row_names
from hydrosim.scene import Body, FreeSurface, LevelReached, Pump, Scene, Tank
from hydrosim.tanks.contents import (
    REST,
    TANK,
    Tanks,
    changing_tanks,
    no_tanks,
)
from hydrosim.tanks.events import is_triggered, unforeseen_tanks
from hydrosim.tanks.loading import symmetric_matrix
from hydrosim.tanks.mirror import image_indices
from hydrosim.tanks.pieces import FIRST_MOMENT, SECOND_MOMENT, SURFACE_MOMENT, quantities_at
from hydrosim.tanks.pumping import FLOW, PUMP_RATE_DTYPE, SEA_INDEX
from hydrosim.tanks.shapes import capacity, pieces, volume_at


def tanks_of(scene: Scene) -> Tanks:
    """Constants of the tanks whose contents change. Raises InputError if a tank would overflow or
    run dry, or if a pump has nothing to pump."""
    for body in scene.bodies:
        check_tanks(body)
    if not has_flow(scene):
        return no_tanks()
    each = [(b, tank) for b, body in enumerate(scene.bodies) for tank in changing_tanks(body)]
    index = {(b, tank.name): k for k, (b, tank) in enumerate(each)}
    image = [index.get((b, _image(scene.bodies[b], t)), k) for k, (b, t) in enumerate(each)]
    shapes = [_shape(tank, scene.bodies[b], scene) for b, tank in each]
    cut = {(liquid.body, liquid.tank.name): k for k, liquid in enumerate(cut_tanks(scene))}
    liquids = [cut.get((b, tank.name), -1) for b, tank in each]
    last = np.cumsum([len(shape) for shape in shapes]) - 1
    begun = [0, *(last[:-1] + 1)]
    flows, rates = _flows(scene, index)
    names = row_names(scene)
    pumping = {body.name for body in scene.bodies if changing_tanks(body)}
    found = Tanks(
        np.array(
            [
                (b, t.density, capacity(t.shape), volume_at(t.shape, t.level), *places)
                for (b, t), *places in zip(each, begun, last, image, liquids, strict=True)
            ],
            dtype=TANK,
        ),
        np.concatenate(shapes),
        np.array([_rest(b, scene) for b in sorted({b for b, _ in each})], dtype=REST),
        np.array(flows, dtype=FLOW),
        np.array(rates, dtype=PUMP_RATE_DTYPE),
        names.index(BALLAST),
        names.index(WEIGHT),
        scene.environment.gravity,
        currents_on(scene, pumping),
    )
    check_flow(scene, found)
    return found


def steady_surface(body: Body, scene: Scene) -> np.ndarray:
    """Density times second moments (3,) of the free surfaces of tanks whose contents stay and that
    have no cut shape."""
    steady = [tank for tank in body.tanks if tank not in changing_tanks(body)]
    return sum(
        (t.density * _contents_at_start(t, body, scene)[SURFACE_MOMENT:] for t in steady),
        np.zeros(3),
    )


def _shape(tank: Tank, body: Body, scene: Scene) -> np.ndarray:
    """Pieces of a tank about the origin of its body, without the free surface if it is frozen or
    cut."""
    found = pieces(tank.shape, np.asarray(body.centre_of_gravity))
    if tank.surface == FreeSurface.FROZEN or cut_shape(tank, scene):
        found["c"][:, SURFACE_MOMENT:] = 0.0
    return found


def _contents_at_start(tank: Tank, body: Body, scene: Scene) -> np.ndarray:
    """Quantities of `shapes` for a tank at its first level."""
    return quantities_at(_shape(tank, body, scene), volume_at(tank.shape, tank.level))


def _image(body: Body, tank: Tank) -> str:
    """Name of the tank that is the mirror image of a tank; its own name if there is none."""
    tanks, _ = image_indices(body)
    found = tanks[body.tanks.index(tank)]
    return tank.name if found is None else body.tanks[found].name


def _rest(b: int, scene: Scene) -> tuple[object, ...]:
    """Mass properties of a body without the contents of changing tanks."""
    body = scene.bodies[b]
    mass, moment, inertia = body.mass, np.zeros(3), np.array(body.inertia, dtype=float)
    for tank in changing_tanks(body):
        held = tank.density * _contents_at_start(tank, body, scene)
        mass -= tank.density * volume_at(tank.shape, tank.level)
        moment -= held[FIRST_MOMENT : FIRST_MOMENT + 3]
        second = symmetric_matrix(held[SECOND_MOMENT : SECOND_MOMENT + 6])
        inertia -= np.trace(second) * np.eye(3) - second
    return b, mass, moment, inertia, steady_surface(body, scene), not body.constant_inertia


def _flows(scene: Scene, index: dict[tuple[int, str], int]) -> tuple[list[tuple], list[tuple]]:
    """Constants `FLOW` and `PUMP_RATE_DTYPE` of all flows."""
    flows: list[tuple] = []
    rates: list[tuple] = []
    for b, body in enumerate(scene.bodies):
        tanks, inertial = {tank.name: tank for tank in body.tanks}, not body.constant_inertia
        begun, (_, others) = len(flows), image_indices(body)
        for k, pump in enumerate(body.pumps):
            first, waits = len(rates), is_triggered(pump)
            rates += [(inf, pump.rate)] if waits else _pieces(pump)
            ends = (index.get((b, str(name)), SEA_INDEX) for name in (pump.source, pump.target))
            whens = (None, None) if waits else (pump.start, pump.stop)
            limits = [x for when in whens for x in _level(b, when, tanks, index)]
            kind = _is_watched(pump, body), waits, inertial
            other = others[k]
            image = begun + (k if other is None else other)
            flows.append((b, *ends, first, len(rates) - 1, *limits, *kind, image))
        for tank in body.tanks:
            if tank.plan is not None:
                first = len(rates)
                rates += list(_planned_rates(tank))
                place = (b, SEA_INDEX, index[b, tank.name], first, len(rates) - 1)
                flows.append(
                    (*place, *(SEA_INDEX, 0.0, 1.0) * 2, False, False, inertial, len(flows))
                )
    return flows, rates


def _is_watched(pump: Pump, body: Body) -> bool:
    """Whether a pump may end because there is nothing to pump; other pumps are then refused."""
    foreseen = unforeseen_tanks(body).isdisjoint({pump.source, pump.target})
    return not (isinstance(pump.stop, float | int) and foreseen)


def _pieces(pump: Pump) -> Iterator[tuple[float, float]]:
    """Rates of a pump, with the times at which each ends."""
    if isinstance(pump.start, float | int):
        yield pump.start, 0.0
    if isinstance(pump.stop, float | int):
        yield pump.stop, pump.rate
        yield inf, 0.0
    else:
        yield inf, pump.rate


def _planned_rates(tank: Tank) -> Iterator[tuple[float, float]]:
    assert tank.plan is not None
    time = np.asarray(tank.plan.time, float)
    volume = [volume_at(tank.shape, level) for level in tank.plan.level]
    yield time[0], 0.0
    rates = tank.density * np.diff(volume) / np.diff(time)
    yield from zip(time[1:], rates, strict=True)
    yield inf, 0.0


def _level(
    b: int, when: object, tanks: dict[str, Tank], index: dict[tuple[int, str], int]
) -> tuple[int, float, float]:
    """Tank, volume and sign of the level that an event waits for; the sea if there is no tank."""
    if not isinstance(when, LevelReached):
        return SEA_INDEX, 0.0, 1.0
    volume = volume_at(tanks[when.tank].shape, when.level)
    return index[b, when.tank], volume, 1.0 if when.above else -1.0
