"""The whole scene, its start, and the questions that its user has answered."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from hydrosim.scene.arrangement import Arrangement, arrange_joints
from hydrosim.scene.body import Body, Clearance
from hydrosim.scene.environment import Environment
from hydrosim.scene.force import ForceElement
from hydrosim.scene.joint import Joint
from hydrosim.scene.solver import Solver

if TYPE_CHECKING:
    import xarray as xr


class Question(StrEnum):
    """Questions about values that are possible but unlikely, see `hydrosim.compiling.questions`. A
    scene lists the questions that it accepts; these are not asked."""

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
    CAPACITY = "capacity"
    AXES = "axes"
    HULL = "hull"
    BENDING = "bending"
    FILES = "files"


class OmittedEntry(NamedTuple):
    """What a file of another program says and the scene has not: the ``question`` that it is asked
    by, what was ``found``, what ``becomes`` of it, and ``advice`` (whole sentences). It is
    ``refused`` unless the question is accepted, or else told. ``key`` of the case has the file."""

    question: Question
    found: str
    becomes: str
    advice: str = ""
    refused: bool = False
    key: str = ""

    @property
    def message(self) -> str:
        """What is left out, where no question is asked."""
        return f"found {self.found}; {self.becomes}. {self.advice}".rstrip()


@dataclass(frozen=True)
class Start:
    """Initial state from another run: the state of ``run``, a dataset or its file, at ``time`` [s]
    or at its end.

    Time continues: the new run begins at that time, and waves, ramps and tables keep their phase.
    `Scene.duration` is the length of the new run alone. Bodies, degrees of freedom and radiation
    must equal those of ``run``, except where motions are zero by symmetry. `Body.position` then
    applies to locked degrees of freedom only; `Body.velocity` is not used.
    """

    run: xr.Dataset | Path | str
    time: float | None = None


@dataclass(frozen=True)
class Scene:
    """Complete input of a run; ``output_step`` [s] is a multiple of the solver's step.

    ``at_rest`` starts the run at the equilibrium near `Body.position`, under the loads of the
    start. ``initial`` is the state of another run to start from.

    ``output_states`` keeps the whole state at every output time, so that other runs can start from
    any of them. ``output_impulses`` keeps the impulses of all forces, and the impulses, works and
    displacements of contacts in each mode. ``output_accelerations`` keeps the accelerations of the
    bodies. ``wave_probes`` are named points x, y [m] with recorded elevation. ``clearances`` are
    recorded besides the named points of bodies.

    ``accept`` lists the questions that are not asked. ``places`` are file and line of keys of its
    case file, for messages.
    """

    title: str
    duration: float
    bodies: tuple[Body, ...]
    environment: Environment = field(default_factory=Environment)
    forces: Mapping[str, ForceElement] = field(default_factory=dict)
    joints: Mapping[str, Joint] = field(default_factory=dict, kw_only=True)
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

    @cached_property
    def arrangement(self) -> Arrangement:
        """How its joints arrange its bodies, found once: it is asked for each body."""
        return arrange_joints(self.joints, [body.name for body in self.bodies])
