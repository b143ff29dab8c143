"""Pump plans: durations of pumping that lift a weight off a body or let it rise, on level keel.

The masses x that the pumps of a body move solve the linear program

    minimise sum x,   A x = b,   0 <= x <= rate T,   0 <= contents of each tank <= its capacity

A: weight that leaves, and its moments about the body's origin, per mass moved between the centroids
of source and target. b: values for which the body rests at the wanted position. A and b first
assume straight walls and small angles. They are corrected by the equilibrium with the plan, until
the body is level (Newton's method).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from hydrosim.errors import InputError
from hydrosim.studies.ballast.loading import FloatingEquilibrium, floating_equilibrium, volumes_at
from hydrosim.tanks.contents import Tanks, flow_names, quantity, tank_names
from hydrosim.tanks.pieces import FIRST_MOMENT

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled
    from hydrosim.scene import Pump

# rad; m: the plan is met
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
        " (hydrosim ballast prints GM)."
    )


class _Program:
    """Linear program of the pumps of one body."""

    def __init__(self, compiled: Compiled, body: str, within: float) -> None:
        scene = compiled.scene
        self.compiled = compiled
        self.within = within
        self.body = [each.name for each in scene.bodies].index(body)
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

        A = self._matrix(volume)
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

    def _matrix(self, volume: np.ndarray) -> np.ndarray:
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
