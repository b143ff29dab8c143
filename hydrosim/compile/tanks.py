"""Tanks and pumps of a scene: checks, constants for kernels, and bodies that carry their weight."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import inf

import numpy as np

from hydrosim.compile.hydrostatics import cut_shape, cut_tanks
from hydrosim.database.database import HydroDatabase, require_array
from hydrosim.database.hull import integrals
from hydrosim.elements.hydrostatics import Weights
from hydrosim.elements.kind import BALLAST, HYDROSTATIC, WEIGHT, has_flow, row_names
from hydrosim.errors import InputError
from hydrosim.scene import Body, FreeSurface, LevelReached, Pump, Scene, Tank, Weight
from hydrosim.tanks import contents, timeline
from hydrosim.tanks.mirror import image_indices
from hydrosim.tanks.pumping import FLOW, PUMP_RATE_DTYPE, SEA_INDEX
from hydrosim.tanks.shapes import capacity, height, pieces, volume_at
from hydrosim.tanks.surface import FIRST_MOMENT, SECOND_MOMENT, SURFACE_MOMENT, quantities_at
from hydrosim.water.current import currents_on

DENSITY_RTOL = 1e-9  # relative difference of densities


def check_lightship(body: Body, displaced: float, sinks: bool = False) -> None:
    """Refuse a body that without the contents of its tanks is heavier than its displacement [kg]:
    at rest, or of the whole hull if it ``sinks``."""
    empty = body.mass - sum(t.density * volume for t, volume in timeline.tanks_at_start(body.tanks))
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
    tanks_by_name = {tank.name: tank for tank in body.tanks}
    for tank in body.tanks:
        _check_level(f"{key}.tanks.{tank.name}.level", tank.level, tank)
        if tank.plan is not None and tank.name in contents.unforeseen_tanks(body):
            raise InputError(
                f"{key}.tanks.{tank.name}.plan: found a plan, and a pump of this tank that begins"
                " or ends at an event; expected only one of them, because a plan gives all"
                " levels."
            )
        if tank.plan is not None:
            _check_plan(f"{key}.tanks.{tank.name}.plan", tank)
    for pump in body.pumps:
        _check_pump(f"{key}.pumps.{pump.name}", pump, tanks_by_name, contents.changing_tanks(body))
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
    mass = body.mass - sum(t.density * volume for t, volume in timeline.tanks_at_start(body.tanks))
    if mass <= 0.0:
        raise InputError(
            f"bodies.{body.name}: found {body.mass:.4g} kg in all and {body.mass - mass:.4g} kg"
            " in its tanks at the start; expected less in the tanks. The key mass includes the"
            " contents of tanks."
        )


def check_flow(scene: Scene, p: contents.Tanks) -> None:
    """Follow the levels to the end of the run; refuse pumps that overflow a tank or run it dry."""
    end = (scene.initial.time or 0.0 if scene.initial else 0.0) + scene.duration
    names = contents.tank_names(scene)
    course = timeline.integrate_tanks(p, end)
    flows = [
        f"bodies.{body.name}.{flow.key}"
        for body in scene.bodies
        for flow in contents.flows_of(body)
    ]
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
        here = [(tank, next(held)) for tank in contents.changing_tanks(body)]
        gone = [
            (tank, volume)
            for tank, volume in timeline.tanks_at_start(body.tanks)
            if tank in contents.changing_tanks(body)
        ]
        left = timeline.body_without(body, gone)
        least = timeline.least_moment(
            body, timeline.loaded_body(left.mass, left.centre, left.inertia, here).inertia
        )
        if least <= 0.0 and not body.constant_inertia:
            raise InputError(
                f"bodies.{body.name}.inertia, radii_of_gyration: found values for which a moment"
                f" of inertia of {least:.3g} kg m^2 is left at {end:g} s, with the contents of"
                " tanks at that time; expected larger values. They include the contents of tanks"
                " at the start."
            )


# Constants of tanks and pumps; tanks whose contents stay are part of their bodies.


def tanks_of(scene: Scene) -> contents.Tanks:
    """Constants of the tanks whose contents change. Raises InputError if a tank would overflow or
    run dry, or if a pump has nothing to pump."""
    for body in scene.bodies:
        check_tanks(body)
    if not has_flow(scene):
        return contents.no_tanks()
    changing = [
        (b, tank) for b, body in enumerate(scene.bodies) for tank in contents.changing_tanks(body)
    ]
    index = {(b, tank.name): k for k, (b, tank) in enumerate(changing)}
    image = [
        index.get((b, _mirror_image_name(scene.bodies[b], t)), k)
        for k, (b, t) in enumerate(changing)
    ]
    shapes = [_tank_pieces(tank, scene.bodies[b], scene) for b, tank in changing]
    cut = {(liquid.body, liquid.tank.name): k for k, liquid in enumerate(cut_tanks(scene))}
    liquids = [cut.get((b, tank.name), -1) for b, tank in changing]
    last = np.cumsum([len(shape) for shape in shapes]) - 1
    begun = [0, *(last[:-1] + 1)]
    flows, rates = _compile_flows(scene, index)
    names = row_names(scene)
    pumping = {body.name for body in scene.bodies if contents.changing_tanks(body)}
    constants = contents.Tanks(
        np.array(
            [
                (b, t.density, capacity(t.shape), volume_at(t.shape, t.level), *places)
                for (b, t), *places in zip(changing, begun, last, image, liquids, strict=True)
            ],
            dtype=contents.TANK,
        ),
        np.concatenate(shapes),
        np.array(
            [_body_without_contents(b, scene) for b in sorted({b for b, _ in changing})],
            dtype=contents.REST,
        ),
        np.array(flows, dtype=FLOW),
        np.array(rates, dtype=PUMP_RATE_DTYPE),
        names.index(BALLAST),
        names.index(WEIGHT),
        scene.environment.gravity,
        currents_on(scene, pumping),
    )
    check_flow(scene, constants)
    return constants


def steady_surface(body: Body, scene: Scene) -> np.ndarray:
    """Density times second moments (3,) of the free surfaces of tanks whose contents stay and that
    have no cut shape."""
    steady = [tank for tank in body.tanks if tank not in contents.changing_tanks(body)]
    return sum(
        (t.density * _contents_at_start(t, body, scene)[SURFACE_MOMENT:] for t in steady),
        np.zeros(3),
    )


def _tank_pieces(tank: Tank, body: Body, scene: Scene) -> np.ndarray:
    """Pieces of a tank about the origin of its body, without the free surface if it is frozen or
    cut."""
    tank_pieces = pieces(tank.shape, np.asarray(body.centre_of_gravity))
    if tank.free_surface == FreeSurface.FROZEN or cut_shape(tank, scene):
        tank_pieces["c"][:, SURFACE_MOMENT:] = 0.0
    return tank_pieces


def _contents_at_start(tank: Tank, body: Body, scene: Scene) -> np.ndarray:
    """Quantities of `shapes` for a tank at its first level."""
    return quantities_at(_tank_pieces(tank, body, scene), volume_at(tank.shape, tank.level))


def _mirror_image_name(body: Body, tank: Tank) -> str:
    """Name of the tank that is the mirror image of a tank; its own name if there is none."""
    tanks, _ = image_indices(body)
    tank_image = tanks[body.tanks.index(tank)]
    return tank.name if tank_image is None else body.tanks[tank_image].name


def _body_without_contents(b: int, scene: Scene) -> tuple[object, ...]:
    """Mass properties of a body without the contents of changing tanks."""
    body = scene.bodies[b]
    mass, moment, inertia = body.mass, np.zeros(3), np.array(body.inertia, dtype=float)
    for tank in contents.changing_tanks(body):
        held = tank.density * _contents_at_start(tank, body, scene)
        mass -= tank.density * volume_at(tank.shape, tank.level)
        moment -= held[FIRST_MOMENT : FIRST_MOMENT + 3]
        second = timeline.symmetric_matrix(held[SECOND_MOMENT : SECOND_MOMENT + 6])
        inertia -= np.trace(second) * np.eye(3) - second
    return b, mass, moment, inertia, steady_surface(body, scene), not body.constant_inertia


def _compile_flows(
    scene: Scene, index: dict[tuple[int, str], int]
) -> tuple[list[tuple], list[tuple]]:
    """Constants `FLOW` and `PUMP_RATE_DTYPE` of all flows."""
    flows: list[tuple] = []
    rates: list[tuple] = []
    for b, body in enumerate(scene.bodies):
        tanks, inertial = {tank.name: tank for tank in body.tanks}, not body.constant_inertia
        begun, (_, others) = len(flows), image_indices(body)
        for k, pump in enumerate(body.pumps):
            first, waits = len(rates), contents.is_triggered(pump)
            rates += [(inf, pump.rate)] if waits else _pump_pieces(pump)
            ends = (index.get((b, str(name)), SEA_INDEX) for name in (pump.source, pump.target))
            whens = (None, None) if waits else (pump.start, pump.stop)
            limits = [x for when in whens for x in _level_condition(b, when, tanks, index)]
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
    foreseen = contents.unforeseen_tanks(body).isdisjoint({pump.source, pump.target})
    return not (isinstance(pump.stop, float | int) and foreseen)


def _pump_pieces(pump: Pump) -> Iterator[tuple[float, float]]:
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


def _level_condition(
    b: int, when: object, tanks: dict[str, Tank], index: dict[tuple[int, str], int]
) -> tuple[int, float, float]:
    """Tank, volume and sign of the level that an event waits for; the sea if there is no tank."""
    if not isinstance(when, LevelReached):
        return SEA_INDEX, 0.0, 1.0
    volume = volume_at(tanks[when.tank].shape, when.level)
    return index[b, when.tank], volume, 1.0 if when.above else -1.0


# Bodies that carry their own weight, and the elements that can carry them.


def weights_of(scene: Scene, alone: Mapping[str, HydroDatabase], rows: Sequence[str]) -> Weights:
    """Constants of the weights. ``alone`` are the databases of wet bodies, ``rows`` the names of
    the rows of forces. Raises InputError if nothing can carry a body."""
    carried = [i for i, body in enumerate(scene.bodies) if body.weight == Weight.CARRIED]
    _check_supports(scene, alone)
    for body in scene.bodies:
        if body.hydrostatics is not None:
            whole = scene.environment.water_density * integrals(body.hydrostatics.corners).volume
            check_lightship(body, whole, sinks=True)
        elif body.name in alone:
            check_lightship(body, _buoyancy_at_rest(body, alone) / scene.environment.gravity)
    return Weights(
        np.array(carried, dtype=np.int64),
        np.array([_buoyancy_at_rest(scene.bodies[i], alone) for i in carried], dtype=float),
        rows.index(WEIGHT) if carried else HYDROSTATIC,
        scene.environment.gravity,
    )


def _buoyancy_at_rest(body: Body, alone: Mapping[str, HydroDatabase]) -> float:
    """Buoyancy rho g V of a body at rest [N]; 0 for a dry body, and for one whose hull gives it."""
    if body.name not in alone or body.hydrostatics is not None:
        return 0.0
    db = alone[body.name]
    return float(db.water_density * db.gravity * require_array(db, "volume")[0])


def _check_supports(scene: Scene, alone: Mapping[str, HydroDatabase]) -> None:
    supported = _supported_bodies(scene, alone)
    for body in scene.bodies:
        if body.weight == Weight.CARRIED and body.name not in supported:
            weight = body.mass * scene.environment.gravity
            raise InputError(
                f"bodies.{body.name}.weight: found carried, but nothing in the case can carry its"
                f" {weight:.4g} N. Add hydrodynamics with stiffness in heave, or an applied force,"
                " or connect it by a joint, contact, spring or mooring to the earth or to a body"
                " that is carried. Otherwise lock heave; or set weight: balanced, a constant force"
                " equal to the weight."
            )


def _supported_bodies(scene: Scene, alone: Mapping[str, HydroDatabase]) -> set[str]:
    """Names of the bodies that float, that are held, or that hang on or rest on such bodies."""
    standing = {body.name for body in scene.bodies if _has_heave_restoring(body, alone)}
    links = list(_carrying_pairs(scene))
    for _ in scene.bodies:  # chains of bodies are at most this long
        standing |= {a for a, b in links if b is None or b in standing}
    return standing


def _has_heave_restoring(body: Body, alone: Mapping[str, HydroDatabase]) -> bool:
    if "heave" not in body.dofs or body.hydrostatics is not None:
        return True
    if body.name not in alone:
        return False
    return bool(require_array(alone[body.name], "hydrostatic_stiffness")[2, 2] > 0.0)


def _carrying_pairs(scene: Scene) -> Iterator[tuple[str, str | None]]:
    """Pairs of bodies: the second may carry the first; None is the earth."""
    for joint in scene.joints.values():
        yield joint.body, joint.to
        if joint.to is not None:
            yield joint.to, joint.body
    for element in scene.forces.values():
        if element.can_carry_weight():
            others = [name for _, name in element.connected_bodies()] or [None]
            for other in others:
                yield element.body, other
                if other is not None:
                    yield other, element.body
