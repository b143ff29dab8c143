"""Checks of tanks and pumps before a run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hydrosim.errors import InputError
from hydrosim.scene import Body, LevelReached, Pump, Scene, Tank, Weight
from hydrosim.tanks.contents import Tanks, changing_tanks, flows_of, tank_names
from hydrosim.tanks.events import unforeseen_tanks
from hydrosim.tanks.loading import at_start, body_without, least_moment, loaded_body
from hydrosim.tanks.shapes import height
from hydrosim.tanks.timeline import integrate_tanks

DENSITY_RTOL = 1e-9  # relative difference of densities


def check_lightship(body: Body, displaced: float, sinks: bool = False) -> None:
    """Refuse a body that without the contents of its tanks is heavier than its displacement [kg]:
    at rest, or of the whole hull if it ``sinks``."""
    empty = body.mass - sum(t.density * volume for t, volume in at_start(body.tanks))
    if body.tanks and empty > displaced:
        raise InputError(
            f"bodies.{body.name}.lightship: found {empty:.4g} kg without the contents of tanks;"
            f" expected at most {displaced:.4g} kg, the"
            f" displacement{' of the submerged hull' if sinks else ''}. With all tanks empty the"
            f" body would still {'sink' if sinks else 'float deeper'}. Check the units, and the"
            f" {'hull' if sinks else 'draught of the database'}."
        )


def check_tanks(body: Body) -> None:
    """Check rules that the keys of a case file ensure, for a body that is written in Python."""
    key = f"bodies.{body.name}"
    known = {tank.name: tank for tank in body.tanks}
    for tank in body.tanks:
        _check_level(f"{key}.tanks.{tank.name}.level", tank.level, tank)
        if tank.plan is not None and tank.name in unforeseen_tanks(body):
            raise InputError(
                f"{key}.tanks.{tank.name}.plan: found a plan, and a pump of this tank that begins"
                " or ends at an event; expected only one of them, because a plan gives all"
                " levels."
            )
        if tank.plan is not None:
            _check_plan(f"{key}.tanks.{tank.name}.plan", tank)
    for pump in body.pumps:
        _check_pump(f"{key}.pumps.{pump.name}", pump, known, changing_tanks(body))
    if body.tanks and body.weight != Weight.CARRIED:
        raise InputError(
            f"{key}.weight: found {body.weight} and tanks; expected carried, because the contents"
            " are weight that changes or shifts."
        )
    if body.tanks:
        _check_lightship(body)


def _check_level(key: str, level: float, tank: Tank) -> None:
    if not 0.0 <= level <= height(tank.shape) * (1.0 + DENSITY_RTOL):
        raise InputError(
            f"{key}: found {level:g} m; expected 0 to {height(tank.shape):g} m, the height of the"
            f" tank {tank.name}."
        )


def _check_plan(key: str, tank: Tank) -> None:
    assert tank.plan is not None
    for level in tank.plan.level:
        _check_level(f"{key}.level", float(level), tank)
    if abs(tank.plan.level[0] - tank.level) > DENSITY_RTOL * height(tank.shape):
        raise InputError(
            f"{key}.level: found {tank.plan.level[0]:g} m at the first time; expected the level at"
            f" the start, {tank.level:g} m."
        )


def _check_pump(key: str, pump: Pump, tanks: dict[str, Tank], moved: Sequence[Tank]) -> None:
    for end, name in (("source", pump.source), ("target", pump.target)):
        if name is not None and name not in tanks:
            names = ", ".join([*tanks, "sea"])
            raise InputError(
                f"{key}.{end}: found {name}, which is no tank; expected one of {names}."
            )
    if pump.source == pump.target:
        raise InputError(
            f"{key}: found {pump.source or 'sea'} at both ends; expected two different places."
        )
    ends = [tanks[name] for name in (pump.source, pump.target) if name is not None]
    if abs(ends[0].density - ends[-1].density) > DENSITY_RTOL * ends[0].density:
        raise InputError(
            f"{key}: found fluids of {ends[0].density:g} and {ends[-1].density:g} kg/m^3 at its"
            " ends; expected one density. Mixtures are not modelled."
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
        raise InputError(
            f"{key}.stop: found {last:g} s; expected a time after the start, {first:g} s."
        )


def _check_lightship(body: Body) -> None:
    """Refuse a body whose tanks hold more than its mass."""
    mass = body.mass - sum(t.density * volume for t, volume in at_start(body.tanks))
    if mass <= 0.0:
        raise InputError(
            f"bodies.{body.name}: found {body.mass:.4g} kg in all and {body.mass - mass:.4g} kg"
            " in its tanks at the start; expected less in the tanks. The key mass includes the"
            " contents of tanks."
        )


def check_flow(scene: Scene, p: Tanks) -> None:
    """Follow the levels to the end of the run; refuse pumps that overflow a tank or run it dry."""
    end = (scene.initial.time or 0.0 if scene.initial else 0.0) + scene.duration
    names = tank_names(scene)
    course = integrate_tanks(p, end)
    flows = [f"bodies.{body.name}.{flow.key}" for body in scene.bodies for flow in flows_of(body)]
    problem = course.problem
    if problem is None:
        _check_inertia(scene, course.volumes_at(end), end)
        return
    tank = "" if problem.tank is None else names[problem.tank]
    text = {
        "dry": f"{tank} runs dry at {problem.time:g} s, before the pump stops; expected an"
        " earlier stop, a lower rate, a higher level at the start, or no stop. Without a"
        " stop, the pump ends when the tank is empty",
        "over": f"{tank} overflows at {problem.time:g} s, before the pump stops; expected an"
        " earlier stop, a lower rate, or no stop. Without a stop, the pump ends when the"
        " tank is full",
        "nothing": f"has nothing to pump at {problem.time:g} s: its source is empty, its target"
        " full, or its final level reached; expected fluid to pump then",
    }[problem.what]
    raise InputError(f"{flows[problem.flow]}: {text}.")


def _check_inertia(scene: Scene, volumes: np.ndarray, end: float) -> None:
    """Refuse bodies that rotate and whose inertia without the contents is not positive at these
    ``volumes`` (nt,) [m^3] of the changing tanks."""
    held = iter(volumes.tolist())
    for body in scene.bodies:
        here = [(tank, next(held)) for tank in changing_tanks(body)]
        gone = [
            (tank, volume) for tank, volume in at_start(body.tanks) if tank in changing_tanks(body)
        ]
        left = body_without(body, gone)
        least = least_moment(body, loaded_body(left.mass, left.centre, left.inertia, here).inertia)
        if least <= 0.0 and not body.constant_inertia:
            raise InputError(
                f"bodies.{body.name}.inertia, radii_of_gyration: found values for which a moment"
                f" of inertia of {least:.3g} kg m^2 is left at {end:g} s, with the contents of"
                " tanks at that time; expected larger values. They include the contents of tanks"
                " at the start."
            )
