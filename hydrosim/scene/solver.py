"""Integration: method, step, tolerance, and simplifications of a scene."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from math import ceil, isclose


class Method(StrEnum):
    """Time integration method."""

    RK2 = "rk2"
    HEUN = "heun"
    RK4 = "rk4"
    DOPRI5 = "dopri5"
    ESDIRK4 = "esdirk4"
    AUTOMATIC = "automatic"

    @property
    def adapts(self) -> bool:
        """True if it chooses its own steps."""
        return self in (Method.DOPRI5, Method.ESDIRK4, Method.AUTOMATIC)


ACCURACY = 1e-4  # default of `Solver.accuracy`: error of motions relative to their range
# Rounding in long runs sets the lower bound. Above the upper bound motions are not resolved.
ACCURACIES = (1e-10, 0.1)


class LinearScenes(StrEnum):
    """Treatment of a linear scene: exact propagation, or time steps as for any other scene."""

    EXACT = "exact"
    STEP = "step"


class Symmetry(StrEnum):
    """Treatment of a scene with mirror symmetry: solve it in its plane, or ignore the symmetry."""

    USE = "use"
    IGNORE = "ignore"


class Kinematics(StrEnum):
    """Rigid-body kinematics: rotation matrices, or small angles throughout."""

    EXACT = "exact"
    LINEAR = "linear"


@dataclass(frozen=True)
class Tolerance:
    """Error tolerances of adaptive methods, per second of a run: ``relative`` [1/s], ``position``
    [m/s] and ``angle`` [rad/s]. Velocities have these per second more. The stretch of a contact
    node has the ``relative`` fraction of its break-away stretch under a usual load, if that is
    less."""

    relative: float = 1e-6
    position: float = 1e-6
    angle: float = 1e-8


class Unstable(StrEnum):
    """Treatment of a step above the stable limit."""

    WARN = "warn"
    ERROR = "error"


@dataclass(frozen=True)
class Solver:
    """Integration method and ``step`` [s]; ``events`` false is for comparison only.

    An adaptive method (dopri5, esdirk4) begins with ``step`` and keeps the error of each step below
    ``tolerance`` times its length. ``unstable`` applies to the other methods. ``automatic`` selects
    an adaptive method and its tolerance such that errors of motions are at most ``accuracy`` of
    their range, see `hydrosim.compiling.automatic`. Other methods have no accuracy.

    A ``linear`` scene is propagated exactly unless steps are asked for, see
    `hydrosim.linear.propagate`. A scene with mirror symmetry has no sway, roll and yaw unless its
    ``symmetry`` is ignored, see `hydrosim.compiling.symmetry`.
    """

    method: Method = Method.RK4
    step: float = 0.1
    tolerance: Tolerance = field(default_factory=Tolerance)
    accuracy: float | None = None
    kinematics: Kinematics = Kinematics.EXACT
    events: bool = True
    unstable: Unstable = Unstable.WARN
    linear: LinearScenes = LinearScenes.EXACT
    symmetry: Symmetry = Symmetry.USE


def fitting_step(output_step: float, limit: float) -> float:
    """A step [s] of few digits that is at most ``limit`` [s], and fits the ``output_step`` [s]."""
    fewest = ceil(output_step / limit * (1.0 - 1e-9))
    parts = (output_step / n for n in range(fewest, 10 * fewest))
    few = (part for part in parts if isclose(part, float(f"{part:.2g}")))
    return next(few, output_step / fewest)
