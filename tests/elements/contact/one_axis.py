"""A block that is pressed on a floor and pushed along it: an integration apart from hydrosim.

The laws of friction and contact are written out here for one axis, and integrated by scipy's
8th-order method from event to event and from corner to corner of the tables of forces.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scenes import block, central_force, foot, mooring, moving, table
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import hydrosim as hs
from hydrosim.elements import Harmonic, Recorded, Table
from hydrosim.scene import Scene, Solver

OPEN, STICK, SLIP = range(3)
X, V, Z, W, S = range(5)


@dataclass(frozen=True)
class Block:
    """``push`` and ``press`` (n,) [N] at ``time`` (n,) along x and z; ``spring`` [N/m] along x and
    z; ``start``: x, x', z, z'. The points of a prescribed table or record are among ``time``."""

    mass: float
    curve: hs.NormalCurve | hs.PrescribedNormal
    friction: hs.StickSlip | hs.FrictionSlope | hs.Frictionless
    time: np.ndarray
    push: np.ndarray
    press: np.ndarray
    spring: tuple[float, float] = (0.0, 0.0)
    start: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    duration: float = 20.0

    def scene(self, step: float, output_step: float = 0.1, events: bool = True) -> Scene:
        """The same block for hydrosim."""
        x, v, z, w = self.start
        force = np.zeros((self.time.size, 6))
        force[:, 0], force[:, 2] = self.push, self.press
        start = {"position": moving(surge=x, heave=z), "velocity": moving(surge=v, heave=w)}
        body = block(self.mass, ("surge", "heave"), **start)
        push, spring = central_force(**table(self.time, force)), self.spring
        held = mooring(surge=spring[0], heave=spring[1])
        forces = {"push": push, "spring": held, "fender": foot(self.curve, self.friction)}
        solver = Solver(step=step, events=events)
        whole = Scene("one axis", self.duration, (body,), forces=forces, solver=solver)
        return whole.with_output(step=output_step)

    @cached_property
    def prescribed(self) -> Callable[[float], float]:
        """The prescribed normal force over time."""
        return signal(self.curve.force)

    def normal_force(self, t: float, y: np.ndarray) -> float:
        """f(delta) + c delta', or f(t), not cut at zero."""
        if isinstance(self.curve, hs.PrescribedNormal):
            return float(self.prescribed(t))
        x, f = self.curve.compression, self.curve.force
        k = min(max(int(np.searchsorted(x, -y[Z])) - 1, 0), x.size - 2)
        elastic = f[k] + (f[k + 1] - f[k]) / (x[k + 1] - x[k]) * (-y[Z] - x[k])
        return elastic - self.curve.damping * y[W]

    def friction_force(self, mode: int, t: float, y: np.ndarray) -> tuple[float, float]:
        """Force on the block, rate of the stretch."""
        law, v, s = self.friction, y[V], y[S]
        if isinstance(law, hs.FrictionSlope):
            limit = law.coefficient * self.normal_force(t, y)
            return {OPEN: 0.0, STICK: -law.slope * v, SLIP: -limit * np.sign(v)}[mode], 0.0
        if isinstance(law, hs.Frictionless):
            return 0.0, 0.0
        if mode == OPEN:
            return 0.0, -law.stiffness / law.damping * s if law.damping else 0.0
        T = law.stiffness * s + law.damping * v
        excess = abs(T) - law.kinetic * self.normal_force(t, y)
        node = excess / (law.damping + law.slip_damping) * np.sign(T) if mode == SLIP else 0.0
        return -(law.stiffness * s + law.damping * (v - node)), v - node

    def rates(self, t: float, y: np.ndarray, mode: int) -> np.ndarray:
        """y' of y = (x, x', z, z', stretch)."""
        friction, stretching = self.friction_force(mode, t, y)
        normal = self.normal_force(t, y) if mode != OPEN else 0.0
        along = np.interp(t, self.time, self.push) - self.spring[0] * y[X] + friction
        up = np.interp(t, self.time, self.press) - self.spring[1] * y[Z] + normal
        return np.array([y[V], along / self.mass, y[W], up / self.mass, stretching])

    def grip(self, mode: int, t: float, y: np.ndarray) -> float:
        """Positive while the point sticks, or while it slips."""
        law, N = self.friction, self.normal_force(t, y)
        if isinstance(law, hs.Frictionless):
            return 1.0 if mode == SLIP else -1.0
        if isinstance(law, hs.FrictionSlope):
            margin = law.coefficient * N - law.slope * abs(y[V])
            return margin if mode == STICK else -margin
        T = abs(law.stiffness * y[S] + law.damping * y[V])
        return law.static * N - T if mode == STICK else T - law.kinetic * N

    def touches(self, t: float, y: np.ndarray) -> float:
        """Positive in contact."""
        if isinstance(self.curve, hs.PrescribedNormal):
            return self.normal_force(t, y)
        steepness = self.curve.force[1] / self.curve.compression[1]
        return min(-y[Z] * steepness, self.normal_force(t, y))

    def next_mode(self, mode: int, ended: int, t: float, y: np.ndarray) -> int:
        """The mode after the event ``ended``: contact, grip or a corner of the curve."""
        if ended == 0:
            if mode != OPEN:
                return OPEN
            return STICK if self.grip(STICK, t, y) >= 0.0 else SLIP
        if ended == 1:
            return SLIP if mode == STICK else STICK
        return mode


def signal(force: Table | Recorded | Harmonic) -> Callable[[float], float]:
    """The force over time, by numpy and scipy."""
    if isinstance(force, Table):
        return lambda t: float(np.interp(t, force.time, force.value))
    if isinstance(force, Recorded):
        return CubicSpline(force.time, force.value)
    w = 2 * np.pi / force.period
    return lambda t: force.mean + force.amplitude * np.sin(w * t + force.phase)


@dataclass(frozen=True)
class Exact:
    """States (nt, 5) and modes (nt,) at the output times, and the times of all changes of mode."""

    states: np.ndarray
    modes: np.ndarray
    events: np.ndarray


def integrate(block: Block, times: np.ndarray, resolution: float = 0.02) -> Exact:
    """The motion by DOP853 at 1e-12, in pieces of at most ``resolution`` to see every change."""
    y = np.array([*block.start, 0.0])
    mode = STICK if block.grip(STICK, 0.0, y) >= 0.0 else SLIP
    mode = mode if block.touches(0.0, y) > 0.0 else OPEN
    corners = block.time[(block.time > 0.0) & (block.time < block.duration)]
    states, modes, events, t = np.zeros((times.size, 5)), np.zeros(times.size, int), [], 0.0
    for stop in [*corners, block.duration]:
        while t < stop:
            settings = {"dense_output": True, "rtol": 1e-12, "atol": 1e-14}
            settings |= {"max_step": resolution, "events": _watch(block, mode, y)}
            piece = solve_ivp(block.rates, (t, stop), y, "DOP853", args=(mode,), **settings)
            inside = (times >= t) & (times <= piece.t[-1] + 1e-12)
            if inside.any():
                states[inside], modes[inside] = piece.sol(times[inside]).T, mode
            t, y = piece.t[-1], piece.y[:, -1]
            if piece.status == 1:
                ended = next(i for i, at in enumerate(piece.t_events) if at.size)
                mode = block.next_mode(mode, ended, t, y)
                events.append(t)
    return Exact(states, modes, np.array(events))


def _watch(block: Block, mode: int, start: np.ndarray):
    """Events: the end of contact or its begin, the end of the grip, corners of the curve."""

    def contact(t: float, y: np.ndarray, mode: int) -> float:
        return block.normal_force(t, y) if mode != OPEN else -block.touches(t, y)

    def grip(t: float, y: np.ndarray, mode: int) -> float:
        return block.grip(mode, t, y) if mode != OPEN else 1.0

    def corner(at: float):
        def passed(t: float, y: np.ndarray, mode: int) -> float:
            return y[Z] + at if mode != OPEN else 1.0

        # on the corner itself, only coming back counts
        passed.direction = -np.sign(start[W]) if abs(start[Z] + at) < 1e-10 else 0
        return passed

    contact.direction = grip.direction = -1
    curve = block.curve
    inner = [] if isinstance(curve, hs.PrescribedNormal) else curve.compression[1:-1]
    watched = [contact, grip, *(corner(x) for x in inner)]
    for event in watched:
        event.terminal = True
    return watched
