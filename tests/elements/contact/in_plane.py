"""A contact point that is driven over a floor: its node, apart from hydrosim.

The law of stick-slip in the plane is written out here for a steady normal force, and integrated by
scipy's 8th-order method from one change of mode to the next. Without damping the stretch is of the
length mu_k N / K2 in slip, and the node goes the way that the point goes along it.
"""

from dataclasses import dataclass

import numpy as np
from modes_apart import ModalMotion, integrate
from scenes import block, moving, on_floor, scene, steady

from hydrosim.elements import LinearMooring, StickSlip
from hydrosim.scene import Scene

STICK, SLIP = 1, 2
HEAVY = 1e15  # kg: friction does not change its motion


@dataclass(frozen=True)
class Driven:
    """A point on the figure x_i = size_i cos(frequency_i t + phase_i), pressed by ``normal`` N."""

    law: StickSlip
    normal: float
    size: tuple[float, float]
    frequency: tuple[float, float]
    phase: tuple[float, float]
    duration: float = 20.0

    def place(self, t: np.ndarray | float) -> np.ndarray:
        return np.array(self.size) * np.cos(self._angle(t))

    def velocity(self, t: np.ndarray | float) -> np.ndarray:
        return -np.multiply(self.size, self.frequency) * np.sin(self._angle(t))

    def _angle(self, t: np.ndarray | float) -> np.ndarray:
        return np.multiply.outer(t, self.frequency) + np.array(self.phase)

    def scene(self, step: float, turn: float = 0.0, mass: float = HEAVY) -> Scene:
        """A body on springs that keep it on the figure, all of it turned about z."""
        c, s = np.cos(turn), np.sin(turn)
        R = np.array([[c, -s], [s, c]])
        K = np.zeros((6, 6))
        K[:2, :2] = R @ np.diag(mass * np.square(self.frequency)) @ R.T
        (x, y), (u, v) = R @ self.place(0.0), R @ self.velocity(0.0)
        place, speed = moving(surge=x, sway=y, heave=-self.normal / 1e7), moving(surge=u, sway=v)
        body = block(mass, ("surge", "sway", "heave"), position=place, velocity=speed)
        weight = steady(heave=-self.normal)
        springs, fender = LinearMooring("block", K), on_floor(1e7, self.law)
        forces = {"springs": springs, "weight": weight, "fender": fender}
        return scene(body, forces, self.duration, 0.05, step=step)

    @property
    def rate_free(self) -> bool:
        return self.law.damping + self.law.slip_damping == 0.0

    def traction(self, t: float, s: np.ndarray) -> np.ndarray:
        return self.law.stiffness * s + self.law.damping * self.velocity(t)

    def rates(self, t: float, y: np.ndarray, mode: int) -> np.ndarray:
        """y' of y = (stretch (2), path, loss in C2, loss in C3)."""
        law, v, T = self.law, self.velocity(t), self.traction(t, y[:2])
        node = np.zeros(2)
        if mode == SLIP and self.rate_free:
            d = y[:2] / np.linalg.norm(y[:2])
            node = (d @ v) * d
        elif mode == SLIP:
            excess = np.linalg.norm(T) - law.kinetic * self.normal
            node = excess / (law.damping + law.slip_damping) * T / np.linalg.norm(T)
        ds, speed = v - node, np.linalg.norm(node)
        return np.array([*ds, speed, law.damping * ds @ ds, law.slip_damping * speed**2])


def integrate_in_plane(driven: Driven, times: np.ndarray) -> ModalMotion:
    """From rest, unstretched, by DOP853 at a relative tolerance of 1e-12."""

    def grip(t: float, y: np.ndarray, mode: int) -> float:
        T = float(np.linalg.norm(driven.traction(t, y[:2])))
        law, N = driven.law, driven.normal
        if mode == SLIP and driven.rate_free:
            return float(y[:2] @ driven.velocity(t))
        return law.static * N - T if mode == STICK else T - law.kinetic * N

    def slip(t: float, y: np.ndarray) -> int:
        if driven.rate_free:  # the node jumps
            size, kept = np.linalg.norm(y[:2]), driven.law.kinetic * driven.normal
            kept /= driven.law.stiffness
            y[:3] = [*(y[:2] * kept / size), y[2] + size - kept]
        return SLIP

    after = {STICK: slip, SLIP: lambda t, y: STICK}
    mode = STICK if grip(0.0, np.zeros(5), STICK) >= 0.0 else SLIP
    settings = {"rtol": 1e-12, "atol": 1e-13, "max_step": 0.02}
    slopes, ends = driven.rates, lambda mode: [(grip, after[mode])]
    return integrate(slopes, ends, mode, np.zeros(5), times, **settings)
