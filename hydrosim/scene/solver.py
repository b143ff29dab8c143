"""Integration: method, step, tolerance, and what a scene may be reduced to."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum


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
        """Whether it chooses its own steps."""
        return self in (Method.DOPRI5, Method.ESDIRK4, Method.AUTOMATIC)


ACCURACY = 1e-4  # of the range of a motion: what `Method.AUTOMATIC` aims at if nothing is said
# the least that roundings of long runs leave, and the most that is an error of a motion
ACCURACIES = (1e-10, 0.1)


class LinearScenes(StrEnum):
    """What to do with a scene that is linear: propagate it exactly, or step it as any other."""

    EXACT = "exact"
    STEP = "step"


class Symmetry(StrEnum):
    """What to do with a scene that is its own mirror image: solve it in its plane, or look away."""

    USE = "use"
    IGNORE = "ignore"


class Kinematics(StrEnum):
    """Rigid-body kinematics: rotation matrices, or small angles throughout."""

    EXACT = "exact"
    LINEAR = "linear"


@dataclass(frozen=True)
class Tolerance:
    """Error per second of a run that an adaptive method keeps to in each step: ``relative`` [1/s]
    and absolute, of ``position`` [m/s] and ``angle`` [rad/s]; of velocities per second more. Of the
    stretch of a contact node it is the ``relative`` part of that which breaks away under a usual
    load, if that is less."""

    relative: float = 1e-6
    position: float = 1e-6
    angle: float = 1e-8


class Unstable(StrEnum):
    """What to do with a step above the stable limit."""

    WARN = "warn"
    ERROR = "error"


@dataclass(frozen=True)
class Solver:
    """Integration method and ``step`` [s]; ``events`` false is for comparison only.

    An adaptive method (dopri5, esdirk4) begins with ``step`` and keeps the error of each step below
    ``tolerance``, times its length; ``unstable`` is about steps of the others. ``automatic`` takes
    one of these with a tolerance of its own, so that the error of motions is at most ``accuracy``
    of their range, see `hydrosim.compiling.automatic`; others have no accuracy. A scene that is
    ``linear`` is not stepped unless asked for, see `hydrosim.linear.propagate`; one that is its own
    mirror image has no sway, roll and yaw unless its ``symmetry`` is ignored, see
    `hydrosim.compiling.symmetry`.
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
