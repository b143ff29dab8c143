"""Tanks and pumps of a scene as constants; those that nothing changes are part of their bodies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import cos, inf, sin

import numpy as np

from hydrosim.errors import InputError
from hydrosim.forces.ballast.flows import FLOW, RATE, SEA
from hydrosim.forces.ballast.loading import at_start, symmetric
from hydrosim.forces.ballast.mirror import images
from hydrosim.forces.ballast.pieces import FIRST, SECOND, SURFACE, at
from hydrosim.forces.ballast.shapes import capacity, height, pieces, volume_at
from hydrosim.forces.ballast.tanks import (
    REST,
    TANK,
    Tanks,
    changing,
    flow_keys,
    no_tanks,
    tank_names,
)
from hydrosim.forces.ballast.timeline import follow
from hydrosim.forces.layout import BALLAST, WEIGHT, has_flow, row_names
from hydrosim.scene import Body, FreeSurface, LevelReached, Pump, Scene, Tank, Weight

SAME = 1e-9  # of a density


def tanks_of(scene: Scene) -> Tanks:
    """Constants of the tanks that change. Raises InputError where one would overflow or run dry, or
    a pump has nothing to take."""
    for body in scene.bodies:
        _check_body(body)
    if not has_flow(scene):
        return no_tanks()
    each = [(b, tank) for b, body in enumerate(scene.bodies) for tank in changing(body)]
    index = {(b, tank.name): k for k, (b, tank) in enumerate(each)}
    image = [index.get((b, _image(scene.bodies[b], t)), k) for k, (b, t) in enumerate(each)]
    shapes = [_shape(tank, scene.bodies[b]) for b, tank in each]
    last = np.cumsum([len(shape) for shape in shapes]) - 1
    flows, rates = _flows(scene, index)
    names, current = row_names(scene), scene.environment.current
    found = Tanks(
        np.array(
            [
                (b, t.density, capacity(t.shape), volume_at(t.shape, t.level), first, end, other)
                for (b, t), first, end, other in zip(
                    each, [0, *(last[:-1] + 1)], last, image, strict=True
                )
            ],
            dtype=TANK,
        ),
        np.concatenate(shapes),
        np.array([_rest(b, scene.bodies[b]) for b in sorted({b for b, _ in each})], dtype=REST),
        np.array(flows, dtype=FLOW),
        np.array(rates, dtype=RATE),
        names.index(BALLAST),
        names.index(WEIGHT),
        scene.environment.gravity,
        (current.speed * cos(current.heading), current.speed * sin(current.heading)),
    )
    _check_flow(scene, found)
    return found


def steady_surface(body: Body) -> np.ndarray:
    """Density times second moments (3,) of the free surfaces of tanks that do not change."""
    steady = [tank for tank in body.tanks if tank not in changing(body)]
    return sum((t.density * _held(t, body)[SURFACE:] for t in steady), np.zeros(3))


def check_lightship(body: Body, displaced: float) -> None:
    """Refuse a body that is heavier without what is in its tanks than what it displaces [kg]."""
    empty = body.mass - sum(t.density * volume for t, volume in at_start(body.tanks))
    if body.tanks and empty > displaced:
        raise InputError(
            f"bodies.{body.name}.lightship: found {empty:.4g} kg without what is in the tanks;"
            f" expected at most {displaced:.4g} kg, what the hull displaces: with all tanks empty"
            " it would still float deeper. Look at units, or at the draught of the database."
        )


def _shape(tank: Tank, body: Body) -> np.ndarray:
    """Pieces of a tank about the origin of its body."""
    found = pieces(tank.shape, np.asarray(body.centre_of_gravity))
    if tank.surface == FreeSurface.FROZEN:
        found["c"][:, SURFACE:] = 0.0
    return found


def _held(tank: Tank, body: Body) -> np.ndarray:
    """Quantities of `shapes` of a tank at its first level."""
    return at(_shape(tank, body), volume_at(tank.shape, tank.level))


def _image(body: Body, tank: Tank) -> str:
    """Name of the tank that is the mirror image of one, of the tank itself if none is."""
    tanks, _ = images(body)
    found = tanks[body.tanks.index(tank)]
    return tank.name if found is None else body.tanks[found].name


def _rest(b: int, body: Body) -> tuple[object, ...]:
    """What a body is without what is in the tanks that change."""
    mass, moment, inertia = body.mass, np.zeros(3), np.array(body.inertia, dtype=float)
    for tank in changing(body):
        held = tank.density * _held(tank, body)
        mass -= tank.density * volume_at(tank.shape, tank.level)
        moment -= held[FIRST : FIRST + 3]
        second = symmetric(held[SECOND : SECOND + 6])
        inertia -= np.trace(second) * np.eye(3) - second
    return b, mass, moment, inertia, steady_surface(body), not body.constant_inertia


def _flows(scene: Scene, index: dict[tuple[int, str], int]) -> tuple[list[tuple], list[tuple]]:
    """All flows as `FLOW` and `RATE`."""
    flows: list[tuple] = []
    rates: list[tuple] = []
    for b, body in enumerate(scene.bodies):
        tanks, inertial = {tank.name: tank for tank in body.tanks}, not body.constant_inertia
        begun, (_, others) = len(flows), images(body)
        for k, pump in enumerate(body.pumps):
            pieces, first = list(_pieces(pump)), len(rates)
            ends = (index.get((b, str(name)), SEA) for name in (pump.source, pump.target))
            levels = (_level(b, when, tanks, index) for when in (pump.start, pump.stop))
            rates += pieces
            watched = not isinstance(pump.stop, float | int)
            place = (b, *ends, first, len(rates) - 1)
            image, limits = others[k], [x for level in levels for x in level]
            image = begun + (k if image is None else image)
            flows.append((*place, *limits, watched, inertial, image))
        for tank in body.tanks:
            if tank.plan is not None:
                first = len(rates)
                rates += list(_planned(tank))
                place = (b, SEA, index[b, tank.name], first, len(rates) - 1)
                flows.append((*place, *(SEA, 0.0, 1.0) * 2, False, inertial, len(flows)))
    return flows, rates


def _pieces(pump: Pump) -> Iterator[tuple[float, float]]:
    """Rates of a pump by the times at which they end."""
    if not isinstance(pump.start, LevelReached):
        yield pump.start, 0.0
    if isinstance(pump.stop, float | int):
        yield pump.stop, pump.rate
        yield inf, 0.0
    else:
        yield inf, pump.rate


def _planned(tank: Tank) -> Iterator[tuple[float, float]]:
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
    """Tank, volume and sign of a level that is waited for; the sea if there is none."""
    if not isinstance(when, LevelReached):
        return SEA, 0.0, 1.0
    volume = volume_at(tanks[when.tank].shape, when.level)
    return index[b, when.tank], volume, 1.0 if when.above else -1.0


def _check_body(body: Body) -> None:
    """What a case file says by its keys is true of a body that is written in Python, too."""
    key, known = f"bodies.{body.name}", {tank.name: tank for tank in body.tanks}
    for tank in body.tanks:
        _check_level(f"{key}.tanks.{tank.name}.level", tank.level, tank)
        if tank.plan is not None:
            _check_plan(f"{key}.tanks.{tank.name}.plan", tank)
    for pump in body.pumps:
        _check_pump(f"{key}.pumps.{pump.name}", pump, known, changing(body))
    if body.tanks and body.weight != Weight.CARRIED:
        raise InputError(
            f"{key}.weight: found {body.weight} and tanks; expected carried: what is in them is"
            " weight that changes, or shifts."
        )
    if body.tanks:
        _check_lightship(body)


def _check_level(key: str, level: float, tank: Tank) -> None:
    if not 0.0 <= level <= height(tank.shape) * (1.0 + SAME):
        raise InputError(
            f"{key}: found {level:g} m; expected 0 to {height(tank.shape):g} m, the height of the"
            f" tank {tank.name}."
        )


def _check_plan(key: str, tank: Tank) -> None:
    assert tank.plan is not None
    for level in tank.plan.level:
        _check_level(f"{key}.level", float(level), tank)
    if abs(tank.plan.level[0] - tank.level) > SAME * height(tank.shape):
        raise InputError(
            f"{key}.level: found {tank.plan.level[0]:g} m at the first time; expected the level at"
            f" the start, {tank.level:g} m."
        )


def _check_pump(key: str, pump: Pump, tanks: dict[str, Tank], moved: Sequence[Tank]) -> None:
    for end, name in (("source", pump.source), ("target", pump.target)):
        if name is not None and name not in tanks:
            names = ", ".join([*tanks, "sea"])
            raise InputError(f"{key}.{end}: there is no tank {name}; expected one of {names}.")
    if pump.source == pump.target:
        raise InputError(f"{key}: found {pump.source or 'sea'} at both ends; expected two places.")
    ends = [tanks[name] for name in (pump.source, pump.target) if name is not None]
    if abs(ends[0].density - ends[-1].density) > SAME * ends[0].density:
        raise InputError(
            f"{key}: found fluids of {ends[0].density:g} and {ends[-1].density:g} kg/m^3 at its"
            " ends; expected one density: mixtures are not known."
        )
    for name, when in (("start", pump.start), ("stop", pump.stop)):
        if isinstance(when, LevelReached) and when.tank not in [tank.name for tank in moved]:
            raise InputError(
                f"{key}.{name}.tank: found {when.tank}, whose level nothing changes; expected a"
                " tank that is pumped."
            )
    first, last = pump.start, pump.stop
    if isinstance(first, float | int) and isinstance(last, float | int) and first >= last:
        raise InputError(f"{key}.stop: found {last:g} s; expected after the start, {first:g} s.")


def _check_lightship(body: Body) -> None:
    """What is left of a body without what is in its tanks must be one."""
    mass = body.mass - sum(t.density * volume for t, volume in at_start(body.tanks))
    if mass <= 0.0:
        raise InputError(
            f"bodies.{body.name}: found {body.mass:.4g} kg in all and {body.mass - mass:.4g} kg in"
            " its tanks at the start; expected less in the tanks: mass is that of the body with"
            " what is in them."
        )


def _check_flow(scene: Scene, p: Tanks) -> None:
    """Follow the levels to the end of the run, and refuse what cannot be pumped."""
    end = (scene.initial.time or 0.0 if scene.initial else 0.0) + scene.duration
    names = tank_names(scene)
    flows = [f"bodies.{body.name}.{key}" for body in scene.bodies for key in flow_keys(body)]
    problem = follow(p, end).problem
    if problem is None:
        return
    tank = "" if problem.tank is None else names[problem.tank]
    text = {
        "dry": f"{tank} runs dry at {problem.time:g} s, before the pump stops; expected an earlier"
        " stop, a lower rate, more in the tank at the start, or no stop: it then ends when empty",
        "over": f"{tank} overflows at {problem.time:g} s, before the pump stops; expected an"
        " earlier stop, a lower rate, or no stop: it then ends when the tank is full",
        "nothing": f"has nothing to pump at {problem.time:g} s: its source is empty or its target"
        " full; expected a source that holds something when it starts",
    }[problem.what]
    raise InputError(f"{flows[problem.flow]}: {text}.")
