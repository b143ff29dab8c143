"""Bodies with tanks: loading conditions, stability with free surfaces, and pump plans.

Loading conditions of bodies with tanks: weight, flotation and stability.

At rest without waves, weight and buoyancy balance all other loads that hold the bodies. Metacentric
heights are those of weight and buoyancy alone, K / (m g), with the stiffness K in heel or trim at
constant displacement. They include the loss J / m by free surfaces (`FreeSurfaces`), with the
second moments J of the surfaces at rest. These values are slopes at rest, even if a surface soon
meets bottom or top. Beyond that angle less is lost: at a heel phi, the loss is the moment over m g
sin(phi), a secant. With the stiffness of lines and contacts, the heights describe the stability of
the body as it is held.

Pump plans: durations of pumping that lift a weight off a body or let it rise, on level keel.

The masses x that the pumps of a body move solve the linear program

    minimise sum x,   A x = b,   0 <= x <= rate T,   0 <= contents of each tank <= its capacity

A: weight that leaves, and its moments about the body's origin, per mass moved between the centroids
of source and target. b: values for which the body rests at the wanted position. A and b first
assume straight walls and small angles. They are corrected by the equilibrium with the plan, until
the body is level (Newton's method).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain
from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from hydrosim.compile.compiled import Compiled, derive_data
from hydrosim.compile.hydrostatics import cut_tanks
from hydrosim.elements import without_friction
from hydrosim.elements.hydrostatics import add_weight
from hydrosim.elements.kind import HYDROSTATIC, WEIGHT, row_names
from hydrosim.errors import InputError
from hydrosim.integrate.dynamics import Model, new_work, update_contents
from hydrosim.linear.equilibrium import WIDE, equilibrium, stiffness_of
from hydrosim.linear.linearise import STEP, linearise, without_waves
from hydrosim.linear.modes import STATIC
from hydrosim.multibody.kinematics import place_bodies
from hydrosim.multibody.tree import NO_TREE
from hydrosim.scene import Body, FreeSurface, Pump, Scene, Tank
from hydrosim.tanks import timeline
from hydrosim.tanks.contents import Tanks, changing_tanks, flow_names, quantity, tank_names
from hydrosim.tanks.shapes import capacity, heel_and_trim, pieces, section, triangles
from hydrosim.tanks.surface import FIRST_MOMENT, FLUID_LEVEL, quantities_at

if TYPE_CHECKING:
    from hydrosim.integrate.state import State

# Loss of stability of bodies by free surfaces: at rest, and at a heel.

XX, YY = 0, 2  # of second moments xx, xy, yy


class FreeSurfaces:
    """Free surfaces of a compiled scene with ``volume`` (nt,) [m^3] in the changing tanks and its
    bodies at a ``position`` (nb, 6)."""

    def __init__(self, compiled: Compiled, volume: np.ndarray, position: np.ndarray) -> None:
        self.compiled = compiled
        self.model = compiled.model
        self.work = new_work(compiled.model)
        self.position = position
        self.y = compiled.first_state().y.copy()
        first = self.model.tanks.state
        self.y[first : first + volume.size] = volume

    def slopes(self, b: int) -> np.ndarray:
        """Moments in heel and trim (2,) per angle and g of body ``b`` at its position [kg m]:
        density times the second moments of the surfaces."""
        from scipy.spatial.transform import Rotation  # slow to load, and few scenes have tanks

        self._place(b, *self.position[b, 3:5])
        moments = self.work.contents.surface[b, [YY, XX]].copy()
        body = self.compiled.scene.bodies[b]
        turn = Rotation.from_euler("YX", self.position[b, [4, 3]])
        for k, cut in enumerate(cut_tanks(self.compiled.scene)):
            if cut.body == b:
                corners = triangles(cut.shape) - np.asarray(body.centre_of_gravity)
                turned = turn.apply(corners.reshape(-1, 3)).reshape(corners.shape)
                area, x, y, xx, _, yy = section(turned, float(self.work.contents.height[k]))
                if area > 0.0:
                    spread = np.array([yy - y * y / area, xx - x * x / area])
                    moments += cut.tank.density * cut.shape.permeability * spread
        return moments

    def lever(self, b: int, heel: float) -> float:
        """Moment in heel divided by g of body ``b`` at this heel and its trim [kg m]."""
        self._place(b, heel, float(self.position[b, 4]))
        contents = self.work.contents
        with_surfaces = self._moment(b)
        contents.shift[:] = 0.0
        contents.surface[:] = 0.0
        return (with_surfaces - self._moment(b)) / self.model.weights.gravity

    def _place(self, b: int, heel: float, trim: float) -> None:
        """Place body ``b`` there, without yaw, and compute its free surfaces."""
        q = self.model.bodies.locked.copy()
        q[6 * b + 3] = heel
        q[6 * b + 4] = trim
        all_bodies = self.model.bodies._replace(active=np.arange(q.size), tree=NO_TREE)
        place_bodies(q, np.zeros(q.size), all_bodies, self.work.motion)
        update_contents(self.y, self.model, self.work)

    def _moment(self, b: int) -> float:
        """Moment of weights [N m] about the level axis along the heading of body ``b``."""
        model = self.model
        motion = self.work.motion
        wrench = np.zeros((model.rows, 6 * model.bodies.each.size))
        add_weight(motion, model.bodies, model.weights, self.work.contents, wrench)
        ahead = motion.rotation[b, :2, 0]
        moment = wrench[model.weights.row, 6 * b + 3 : 6 * b + 5]
        return float(moment @ ahead / np.linalg.norm(ahead))


MIN_DIFFERENCE_STEP = 1e-8  # m, rad: finer differences are lost in rounding


class TankState(NamedTuple):
    """A tank with its ``level`` [m], the ``mass`` [kg] in it, the fraction ``filled``, and the
    ``reach`` (2,) of its free surface: heel and trim [rad] at which it meets bottom or top."""

    tank: Tank
    level: float
    mass: float
    filled: float
    reach: np.ndarray


@dataclass(frozen=True)
class Condition:
    """A body with its ``tanks``: its ``loading`` in the database's frame, that of the
    ``lightship``, and its ``position`` (6,) at rest. ``metacentric`` heights [m] are for heel and
    trim (NaN if it cannot turn), ``loss`` is the part lost by free surfaces, ``held`` are the
    heights as it is held. ``secant`` is the loss at a heel (NaN if none is requested, or if the
    body cannot heel)."""

    body: Body
    loading: timeline.Loading
    lightship: timeline.Loading
    tanks: tuple[TankState, ...]
    position: np.ndarray
    metacentric: np.ndarray
    loss: np.ndarray
    held: np.ndarray
    secant: float


class FloatingEquilibrium(NamedTuple):
    """All bodies at rest: ``position`` (nb, 6), and the stiffness K (6 nb, 6 nb), zero for locked
    coordinates. One K is that of all loads, the other, ``floating``, that of weight and buoyancy
    alone."""

    position: np.ndarray
    stiffness: np.ndarray
    floating: np.ndarray


def volumes_at(compiled: Compiled, time: float) -> np.ndarray:
    """Volumes (nt,) [m^3] in the changing tanks at a time [s], before any of them overflows."""
    p = compiled.model.tanks
    return (
        timeline.integrate_tanks(p, max(time, 1e-9)).volumes_at(time)
        if p.each.size
        else np.zeros(0)
    )


def state_with_contents_at(compiled: Compiled, time: float) -> State:
    """State at the start with the tank contents at a time [s]."""
    state = compiled.first_state()
    p = compiled.model.tanks
    state.y[p.state : p.state + p.each.size] = volumes_at(compiled, time)
    return state


def with_contents_at(compiled: Compiled, time: float) -> Compiled:
    """Scene without waves, with its tank contents at a time [s] and, if there is an equilibrium,
    with its bodies and their slow draught there. The linearisation is about this state. The table
    of wave loads along a slow path covers only the block that contains the state."""
    state = state_with_contents_at(compiled, time)
    scene = compiled.scene
    waveless = without_waves(compiled.model)
    no_flows = _without_flows(waveless)
    frictionless = no_flows._replace(elements=without_friction(no_flows.elements))
    weight = sum(body.mass for body in scene.bodies) * scene.environment.gravity
    n = frictionless.bodies.active.size
    slow = slice(frictionless.draught, frictionless.energy)
    y = state.y.copy()
    y[n : 2 * n] = 0.0
    try:
        rest = equilibrium(
            frictionless, state._replace(y=y, modes=state.modes.copy()), time, weight
        )
        y[:n] = rest.state.y[:n]
        y[slow] = rest.state.y[slow]
    except InputError:
        y[:n] = state.y[:n]
        y[slow] = state.y[slow]
    derived = derive_data(scene, compiled.wet, waveless)
    return replace(compiled, derived=derived, state=state._replace(y=y))


def floating_equilibrium(
    compiled: Compiled, volume: np.ndarray, time: float = 0.0, within: float = np.inf
) -> FloatingEquilibrium:
    """Equilibrium with these tank contents, and the stiffness there, by differences ``within`` an
    angle [rad]. Raises InputError if there is no equilibrium."""
    model = _without_flows(compiled.model)
    state = compiled.first_state()
    scene = compiled.scene
    p = model.tanks
    n = model.bodies.active.size
    state.y[p.state : p.state + p.each.size] = volume
    state.y[n : 2 * n] = 0.0
    weight = sum(body.mass for body in scene.bodies) * scene.environment.gravity
    rest = equilibrium(model, state, time, weight)
    step = max(0.25 * within, MIN_DIFFERENCE_STEP)
    linear = linearise(rest.model, rest.state, time=time, step=min(step, STEP))
    rows = [k for k, row in enumerate(row_names(scene)) if k == HYDROSTATIC or row == WEIGHT]
    stiffness_pair = (
        linear.dynamic_stiffness(np.array([STATIC]))[0].real,
        stiffness_of(rest, rows, min(step, WIDE)),
    )
    whole = [np.zeros((6 * len(scene.bodies),) * 2) for _ in stiffness_pair]
    for K, rest_stiffness in zip(whole, stiffness_pair, strict=True):
        free = linear.active[linear.active < len(K)]  # joints have no loading condition
        K[np.ix_(free, free)] = rest_stiffness[: free.size, : free.size]
    return FloatingEquilibrium(rest.position, *whole)


def _without_flows(model: Model) -> Model:
    """Model without flows."""
    p = model.tanks
    rates = p.rates.copy()
    rates["rate"] = 0.0
    return model._replace(tanks=p._replace(rates=rates))


def conditions(compiled: Compiled, time: float = 0.0, heel: float | None = None) -> list[Condition]:
    """Conditions of all bodies with tanks at a time [s], with the loss by free surfaces at a
    ``heel`` [rad]. Raises InputError if there is no equilibrium."""
    volume = volumes_at(compiled, time)
    scene = compiled.scene
    contents = _tank_contents(scene, volume)
    tanks = [[_tank_state(*item) for item in held] for held in contents]
    equilibrium = floating_equilibrium(compiled, volume, time, _least_reach([*chain(*tanks)]))
    surfaces = FreeSurfaces(compiled, volume, equilibrium.position)
    conditions_in_order = []
    for b, (body, held) in enumerate(zip(scene.bodies, contents, strict=True)):
        if held:
            g = scene.environment.gravity
            k = 6 * b + np.array([2, 3, 4])
            righting = [
                _righting_moment(K[np.ix_(k, k)]) / g
                for K in (equilibrium.floating, equilibrium.stiffness)
            ]
            lost = surfaces.slopes(b)
            lever = np.nan if heel is None else surfaces.lever(b, heel) / np.sin(heel)
            body_position = equilibrium.position[b]
            conditions_in_order.append(
                _ballast_condition(body, held, tanks[b], body_position, righting, lost, lever)
            )
    return conditions_in_order


def _tank_contents(scene: Scene, volume: np.ndarray) -> list[list[tuple[Tank, float]]]:
    """Tanks of each body with the volumes [m^3] in them; ``volume`` (nt,) are those of the changing
    tanks."""
    moved = iter(volume)
    contents_by_body = []
    for body in scene.bodies:
        body_contents = {tank.name: float(next(moved)) for tank in changing_tanks(body)}
        contents_by_body.append(
            [
                (tank, body_contents.get(tank.name, v))
                for tank, v in timeline.tanks_at_start(body.tanks)
            ]
        )
    return contents_by_body


def _least_reach(tanks: Sequence[TankState]) -> float:
    """Smallest angle [rad] at which a free surface meets bottom or top; infinite if none does.
    Empty and full tanks have none."""
    angles = np.array([tank.reach for tank in tanks])
    return float(angles[angles > 0.0].min(initial=np.inf))


def _righting_moment(K: np.ndarray) -> np.ndarray:
    """Stiffness in roll and pitch (2,) from that in heave, roll and pitch, (3, 3), with heave at
    constant displacement."""
    follows = K[0, 1:] * K[1:, 0] / K[0, 0] if K[0, 0] > 0.0 else np.zeros(2)
    return np.asarray(np.diag(K)[1:] - follows)


def _ballast_condition(
    body: Body,
    contents: Sequence[tuple[Tank, float]],
    tanks: Sequence[TankState],
    position: np.ndarray,
    righting: Sequence[np.ndarray],
    lost: np.ndarray,
    lever: float,
) -> Condition:
    empty = timeline.body_without(body, timeline.tanks_at_start(body.tanks))
    full = timeline.loaded_body(empty.mass, empty.centre, empty.inertia, contents)
    free = np.array([dof in body.dofs for dof in ("roll", "pitch")])
    return Condition(
        body,
        full,
        empty,
        tuple(tanks),
        position,
        np.where(free, righting[0] / full.mass, np.nan),
        lost / full.mass,
        np.where(free, righting[1] / full.mass, np.nan),
        lever / full.mass,
    )


def _tank_state(tank: Tank, volume: float) -> TankState:
    level = quantities_at(pieces(tank.shape, np.zeros(3)), volume)[FLUID_LEVEL]
    whole = capacity(tank.shape)
    free = tank.free_surface == FreeSurface.QUASI_STATIC
    reach = heel_and_trim(tank.shape, np.array([volume]))[0] if free else np.full(2, np.nan)
    return TankState(tank, float(level), tank.density * volume, volume / whole, reach)


# Tilt [rad] and rise [m] below which a plan is met.
MAX_TILT_RAD = 1e-8
MAX_RISE_ERROR_M = 1e-7
MAX_CORRECTIONS = 20
RELATIVE_SLACK = 1e-9  # of the largest mass


@dataclass(frozen=True)
class PumpPlan:
    """Pumps by name with the ``mass`` [kg] that each moves within ``within`` [s]. Afterwards,
    ``volume`` (nt,) is in the changing tanks, and ``position`` (nb, 6) is the equilibrium."""

    pumps: tuple[str, ...]
    mass: np.ndarray
    rate: np.ndarray
    within: float
    volume: np.ndarray
    position: np.ndarray


def find_pump_plan(
    compiled: Compiled, body: str, within: float, lift: float | None = None, rise: float = 0.0
) -> PumpPlan:
    """Plan that compensates a weight of ``lift`` [N] taken off a body, or lets it ``rise`` [m] from
    its equilibrium at the start, on level keel, within a time [s] from the start.

    Raises InputError if the pumps cannot do it, and names the limits.
    """
    problem = _Program(compiled, body, within)
    g = compiled.scene.environment.gravity
    volume = problem.first
    wanted = problem.rest.position[problem.body, [2, 3, 4]] * [1.0, 0.0, 0.0] + [rise, 0.0, 0.0]
    b = np.array([-(lift or 0.0) / g, 0.0, 0.0])
    now = problem.rest
    x = np.zeros(len(problem.pumps))
    for correction in range(MAX_CORRECTIONS):
        missing = wanted - now.position[problem.body, [2, 3, 4]]
        if lift is not None:  # estimated rise by that weight, for the moments only
            missing[0] = 0.0 if correction else lift / problem.stiffness(now)[0, 0]
        done = abs(missing[0]) <= MAX_RISE_ERROR_M and np.abs(missing[1:]).max() <= MAX_TILT_RAD
        if done and (lift is None or x.any()):
            names = tuple(name for name, _ in problem.pumps)
            return PumpPlan(names, x, x / within, within, volume, now.position)
        load = problem.stiffness(now) @ missing
        b = b + np.array([0.0 if lift is not None else -load[0], load[2], -load[1]]) / g
        x = problem.find_masses(b, volume)
        volume = problem.volume(x)
        now = floating_equilibrium(compiled, volume)
    raise InputError(
        f"bodies.{body}: found no ballast plan that leaves {body} level. After {MAX_CORRECTIONS}"
        f" corrections of the pumped volumes, it still heels or trims by"
        f" {np.degrees(np.abs(missing[1:]).max()):.2g} deg. Check that {body} is stable"
        " (hydrosim analyse --ballast prints GM)."
    )


class _Program:
    """Linear program of the pumps of one body."""

    def __init__(self, compiled: Compiled, body: str, within: float) -> None:
        scene = compiled.scene
        self.compiled = compiled
        self.within = within
        self.body = [body.name for body in scene.bodies].index(body)
        self.p: Tanks = compiled.model.tanks
        pumps = scene.bodies[self.body].pumps
        self.pumps: list[tuple[str, Pump]] = [(pump.name, pump) for pump in pumps]
        if not self.pumps:
            raise InputError(
                f"bodies.{body}.pumps: found no pump; expected at least one. A ballast plan"
                f" (--lift, --rise) moves water with the pumps of {body}. Add pumps to the case."
            )
        self.names = tank_names(scene)
        first = flow_names(scene).index(f"{pumps[0].name} of {body}")
        flows = self.p.flows[first : first + len(pumps)]
        self.moves = np.zeros((self.p.each.size, len(pumps)))  # of mass into each tank
        for j, flow in enumerate(flows):
            for end, sign in ((flow["source"], -1.0), (flow["target"], 1.0)):
                if end >= 0:
                    self.moves[end, j] += sign
        self.most = np.array([pump.rate * within for _, pump in self.pumps])
        self.first = volumes_at(compiled, 0.0)
        self.rest = floating_equilibrium(compiled, self.first)

    def stiffness(self, now: FloatingEquilibrium) -> np.ndarray:
        """Stiffness in heave, roll and pitch of the body, (3, 3)."""
        k = 6 * self.body + np.array([2, 3, 4])
        return now.stiffness[np.ix_(k, k)]

    def volume(self, x: np.ndarray) -> np.ndarray:
        """Volumes (nt,) in the tanks after the masses ``x`` moved."""
        return self.first + self.moves @ x / self.p.each["density"]

    def find_masses(self, b: np.ndarray, volume: np.ndarray) -> np.ndarray:
        """Masses (n,) that change weight and moments by ``b`` (3,). Tanks have their mean width on
        the way to ``volume`` (nt,)."""
        from scipy.optimize import linprog

        A = self._moment_matrix(volume)
        limits = self._limits()
        scale = np.abs(A).max(axis=1)
        scale[scale == 0.0] = 1.0
        A = A / scale[:, None]
        b = b / scale
        n = len(self.pumps)
        bounds = [(0.0, most) for most in self.most]
        smallest = linprog(np.ones(n), *limits, A, b, bounds)
        if smallest.status != 0:
            raise InputError(self._refusal(A, b, limits))
        # among all plans that pump least, the one with the smallest utilisation of its busiest pump
        zeros = np.zeros((len(limits[0]), 1))
        total = smallest.x.sum() * (1.0 + RELATIVE_SLACK)
        rows = [np.hstack([limits[0], zeros]), np.append(np.ones(n), 0.0)[None]]
        rows.append(np.hstack([np.eye(n), -self.most[:, None]]))
        room = np.concatenate([limits[1], [total], np.zeros(n)])
        sides = np.hstack([A, np.zeros((3, 1))])
        least = np.append(np.zeros(n), 1.0)
        balanced = linprog(least, np.vstack(rows), room, sides, b, [*bounds, (0.0, 1.0)])
        return np.asarray(balanced.x[:n] if balanced.status == 0 else smallest.x)

    def _moment_matrix(self, volume: np.ndarray) -> np.ndarray:
        """A (3, n): mass, and its moments about x and y, per mass moved by each pump."""
        place = np.array([self._place(k, volume[k]) for k in range(self.p.each.size)])
        return np.vstack([self.moves.sum(axis=0), place.T @ self.moves])

    def _place(self, k: int, volume: float) -> np.ndarray:
        """x and y (2,) of the centroid of fluid that enters or leaves a tank."""
        first = self.first[k]
        step = volume - first
        if abs(step) < RELATIVE_SLACK * self.p.each["capacity"][k]:
            step = 1e-6 * self.p.each["capacity"][k] * (1.0 if first == 0.0 else -1.0)
        ends = np.array([first, first + step])
        return np.array(
            [np.diff(quantity(self.p, k, ends, FIRST_MOMENT + i))[0] / step for i in (0, 1)]
        )

    def _limits(self) -> tuple[np.ndarray, np.ndarray]:
        """Limits by the room and the contents of tanks: rows of L x <= l."""
        density = self.p.each["density"]
        held = density * self.first
        room = density * (self.p.each["capacity"] - self.first)
        return np.vstack([self.moves, -self.moves]), np.concatenate([room, held])

    def _refusal(self, A: np.ndarray, b: np.ndarray, limits: tuple[np.ndarray, np.ndarray]) -> str:
        """Message with the feasible fraction and the limits that bind there."""
        from scipy.optimize import linprog

        n = len(self.pumps)
        cost = np.append(np.zeros(n), -1.0)
        free = np.zeros((len(limits[0]), 1))
        feasible: Any = linprog(
            cost,
            A_ub=np.hstack([limits[0], free]),
            b_ub=limits[1],
            A_eq=np.hstack([A, -b[:, None]]),
            b_eq=np.zeros(3),
            bounds=[(0.0, most) for most in self.most] + [(0.0, inf)],
        )
        key = f"bodies.{self.compiled.scene.bodies[self.body].name}.pumps"
        part = 0.0 if feasible.status == 3 else float(feasible.x[-1])
        if part <= RELATIVE_SLACK:
            return (
                f"{key}: found pumps that cannot do any of this on level keel; expected pumps"
                " that move weight on both sides, or in the other direction."
            )
        binding = [
            f"{name} ({pump.rate * 3.6:.4g} t/hour for {self.within:g} s)"
            for (name, pump), dual in zip(self.pumps, feasible.upper.marginals[:n], strict=True)
            if dual < -RELATIVE_SLACK * 1e-9
        ]
        kinds = [f"{name} full" for name in self.names] + [f"{name} empty" for name in self.names]
        duals = zip(kinds, feasible.ineqlin.marginals, strict=True)
        binding += [kind for kind, dual in duals if dual < -RELATIVE_SLACK * 1e-9]
        return (
            f"{key}: found that at most {part:.1%} of this can be pumped on level keel, limited"
            f" by {', '.join(binding)}; expected a longer time, a higher rate or another tank."
        )
