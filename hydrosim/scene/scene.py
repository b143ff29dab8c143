"""The whole scene, its start, and the questions that it has answered."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hydrosim.scene.body import Body, Clearance
from hydrosim.scene.environment import Environment
from hydrosim.scene.force import ForceElement
from hydrosim.scene.solver import Solver

if TYPE_CHECKING:
    import xarray as xr


class Question(StrEnum):
    """What is asked where a value is possible and hardly meant, see `hydrosim.compiling.questions`;
    those that a scene accepts are not asked."""

    ANGLES = "angles"
    SPEED = "speed"
    OVERLAP = "overlap"
    PLANE = "plane"
    POINTS = "points"
    LINES = "lines"
    FALL = "fall"
    MASS = "mass"
    INERTIA = "inertia"
    TRIM = "trim"
    STABILITY = "stability"
    PERIODS = "periods"
    LIFT = "lift"
    SOFTNESS = "softness"
    FRICTION = "friction"
    DAMPING = "damping"
    WATER = "water"
    STREAMS = "streams"
    SHIELDING = "shielding"
    SLOSHING = "sloshing"
    WAVES = "waves"
    STEEPNESS = "steepness"
    RAMP = "ramp"
    STEP = "step"
    RANGE = "range"


@dataclass(frozen=True)
class Start:
    """The state that a run starts from: that of ``run``, a dataset or its file, at ``time`` [s] or
    at its end.

    Time goes on: the new run begins at that time, and waves, ramps and tables keep their phase;
    `Scene.duration` is the length of the new run alone. Bodies, degrees of freedom and radiation
    must be those of ``run``, but for what is zero by symmetry; `Body.position` then holds for
    locked degrees of freedom only, and `Body.velocity` for none.
    """

    run: xr.Dataset | Path | str
    time: float | None = None


@dataclass(frozen=True)
class Scene:
    """Everything a run needs; ``output_step`` [s] is a multiple of the solver's step.

    ``at_rest``: the run begins at the place at rest near `Body.position`, under the loads of the
    start. ``initial`` is the state of another run to start from; ``output_states`` keeps the whole
    state at every output time, so that other runs can start from each, not only from the end;
    ``output_impulses`` the impulses of all forces, and what contacts did mode by mode;
    ``output_accelerations`` those of the bodies.
    ``wave_probes`` are points x, y [m] by name where the elevation is wanted, ``clearances`` those
    that are recorded besides the named points of bodies. ``accept`` are the
    questions that are not asked of it. ``places`` are file and line of keys of its case file, for
    messages.
    """

    title: str
    duration: float
    bodies: tuple[Body, ...]
    environment: Environment = field(default_factory=Environment)
    forces: Mapping[str, ForceElement] = field(default_factory=dict)
    solver: Solver = field(default_factory=Solver)
    output_step: float = 0.5
    output_states: bool = False
    wave_probes: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    clearances: Mapping[str, Clearance] = field(default_factory=dict)
    initial: Start | None = None
    at_rest: bool = False
    accept: tuple[Question, ...] = ()
    source: Mapping[str, Any] = field(default_factory=dict)
    output_accelerations: bool = False
    output_impulses: bool = False
    places: Mapping[str, str] = field(default_factory=dict, repr=False, compare=False)
