"""What tanks and pumps cannot do, in words, before the run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hydrosim.errors import InputError
from hydrosim.scene import Body, LevelReached, Pump, Scene, Tank, Weight
from hydrosim.tanks.contents import Tanks, changing, flows_of, tank_names
from hydrosim.tanks.events import unforeseen_tanks
from hydrosim.tanks.loading import at_start, body_without, least_moment, loaded
from hydrosim.tanks.shapes import height
from hydrosim.tanks.timeline import follow

SAME = 1e-9  # of a density


def check_lightship(body: Body, displaced: float, sinks: bool = False) -> None:
    """Refuse a body that is heavier without what is in its tanks than what it displaces [kg], at
    rest or, where it then ``sinks``, with its whole hull."""
    empty = body.mass - sum(t.density * volume for t, volume in at_start(body.tanks))
    if body.tanks and empty > displaced:
        raise InputError(
            f"bodies.{body.name}.lightship: found {empty:.4g} kg without what is in the tanks;"
            f" expected at most {displaced:.4g} kg, what the hull displaces"
            f"{' when all of it is under water' if sinks else ''}: with all tanks empty it would"
            f" still {'sink' if sinks else 'float deeper'}. Look at units, or at the"
            f" {'hull' if sinks else 'draught of the database'}."
        )


def check_tanks(body: Body) -> None:
    """What a case file says by its keys is true of a body that is written in Python, too."""
    key = f"bodies.{body.name}"
    known = {tank.name: tank for tank in body.tanks}
    for tank in body.tanks:
        _check_level(f"{key}.tanks.{tank.name}.level", tank.level, tank)
        if tank.plan is not None and tank.name in unforeseen_tanks(body):
            raise InputError(
                f"{key}.tanks.{tank.name}.plan: found a plan, and a pump of this tank that begins"
                " or ends by an event; expected one of them: a plan says all levels."
            )
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
        if not isinstance(when, LevelReached):
            continue
        if when.tank not in [tank.name for tank in moved]:
            raise InputError(
                f"{key}.{name}.tank: found {when.tank}, whose level nothing changes; expected a"
                " tank that is pumped."
            )
        _check_level(f"{key}.{name}", when.level, tanks[when.tank])
    first = pump.start
    last = pump.stop
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


def check_flow(scene: Scene, p: Tanks) -> None:
    """Follow the levels to the end of the run, and refuse what cannot be pumped."""
    end = (scene.initial.time or 0.0 if scene.initial else 0.0) + scene.duration
    names = tank_names(scene)
    course = follow(p, end)
    flows = [f"bodies.{body.name}.{flow.key}" for body in scene.bodies for flow in flows_of(body)]
    problem = course.problem
    if problem is None:
        _check_inertia(scene, course.at(end), end)
        return
    tank = "" if problem.tank is None else names[problem.tank]
    text = {
        "dry": f"{tank} runs dry at {problem.time:g} s, before the pump stops; expected an earlier"
        " stop, a lower rate, more in the tank at the start, or no stop: it then ends when empty",
        "over": f"{tank} overflows at {problem.time:g} s, before the pump stops; expected an"
        " earlier stop, a lower rate, or no stop: it then ends when the tank is full",
        "nothing": f"has nothing to pump at {problem.time:g} s: its source is empty, its target"
        " full, or the level at which it stops is reached; expected something to pump then",
    }[problem.what]
    raise InputError(f"{flows[problem.flow]}: {text}.")


def _check_inertia(scene: Scene, volumes: np.ndarray, end: float) -> None:
    """Refuse bodies that turn and have no inertia left with these ``volumes`` (nt,) [m^3] in the
    tanks that change."""
    held = iter(volumes.tolist())
    for body in scene.bodies:
        here = [(tank, next(held)) for tank in changing(body)]
        gone = [(tank, volume) for tank, volume in at_start(body.tanks) if tank in changing(body)]
        left = body_without(body, gone)
        least = least_moment(body, loaded(left.mass, left.centre, left.inertia, here).inertia)
        if least <= 0.0 and not body.constant_inertia:
            raise InputError(
                f"bodies.{body.name}.inertia, radii_of_gyration: found such that at {end:g} s, with"
                f" what is in the tanks then, a moment of inertia of {least:.3g} kg m^2 is left;"
                " expected larger ones: they are those of the body with what is in its tanks at"
                " the start."
            )
