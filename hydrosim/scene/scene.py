"""The whole scene: solver, start, answered questions, and its trees of joints."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from math import ceil, isclose
from pathlib import Path
from typing import Annotated, Any, ClassVar, NamedTuple

from pydantic import StrictBool, StrictStr

from hydrosim.errors import InputError
from hydrosim.files import quantities as of
from hydrosim.files.arguments import quantity
from hydrosim.files.schema_class import ReadAs, SchemaClass, schema_class
from hydrosim.files.units import value_text
from hydrosim.scene.body import Body, Clearance
from hydrosim.scene.environment import Environment
from hydrosim.scene.force import BuildContext, ForceElement
from hydrosim.scene.joint import Joint, JointMotion, MotionKind, Rod

# Solver: method, step, tolerance, and simplifications of a scene.


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


OUTPUT_STEP = 0.5  # s, about: if a scene does not say
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


@schema_class
class Tolerance(SchemaClass):
    """Error per second of a run that an adaptive method keeps to in each step. Velocities have the
    tolerances of positions and angles per second more. The stretch of a contact node has the
    ``relative`` fraction of its break-away stretch under a usual load, if that is less."""

    has_valid_defaults: ClassVar[bool] = True

    relative: of.Tolerance = 1e-6
    """Relative error per second."""
    position: of.SmallLength = 1e-6
    """Absolute error of positions per second."""
    angle: of.SmallAngle = 1e-8
    """Absolute error of angles per second."""


class Unstable(StrEnum):
    """Treatment of a step above the stable limit."""

    WARN = "warn"
    ERROR = "error"


@schema_class
class SolverSettings(SchemaClass):
    """How time is stepped."""

    has_valid_defaults: ClassVar[bool] = True

    method: Method = Method.RK4
    """Time integration method. The methods automatic, dopri5 and esdirk4 choose their own steps.
    If a step is given and no method, the method is rk4."""
    step: of.Period = 0.1
    """Time step. A method that chooses its own steps begins with it."""
    tolerance: Any = Tolerance()
    """Error of motions relative to their range, of method automatic; a mapping of errors of each
    step, of dopri5 and esdirk4."""
    kinematics: Kinematics = Kinematics.EXACT
    """Whether rotations are exact or small angles throughout."""
    events: StrictBool = True
    """Whether steps end where a contact changes its mode. Without it results are for comparison
    only."""
    unstable: Unstable = Unstable.WARN
    """Whether a time step above the stable limit gives a warning or an error."""
    linear: LinearScenes = LinearScenes.EXACT
    """Whether a linear scene is propagated exactly or stepped as any other."""
    symmetry: Symmetry = Symmetry.USE
    """Whether a scene that is its own mirror image is solved in its plane of symmetry."""


@schema_class
class Solver(SolverSettings):
    """Settings of a scene. An adaptive method (dopri5, esdirk4) begins with ``step`` and keeps the
    error of each step below ``tolerance`` times its length. `automatic` selects an adaptive method
    and its tolerance such that errors of motions are at most ``accuracy`` of their range, see
    `hydrosim.compile.automatic`. Other methods have no accuracy.

    A ``linear`` scene is propagated exactly unless steps are asked for, see
    `hydrosim.linear.propagate`. A scene with mirror symmetry has no sway, roll and yaw unless its
    ``symmetry`` is ignored, see `hydrosim.compile.symmetry`.
    """

    tolerance: Tolerance = Tolerance()
    accuracy: float | None = None


def fitting_step(output_step: float, limit: float) -> float:
    """A step [s] of few digits that is at most ``limit`` [s], and fits the ``output_step`` [s]."""
    fewest = ceil(output_step / limit * (1.0 - 1e-9))
    parts = (output_step / n for n in range(fewest, 10 * fewest))
    few = (part for part in parts if isclose(part, float(f"{part:.2g}")))
    return next(few, output_step / fewest)


class Question(StrEnum):
    """Questions about values that are possible but unlikely, see `hydrosim.compile.questions`. A
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


@schema_class
class RunOutput(SchemaClass):
    """What is recorded: every ``step``, a multiple of the solver's, and with ``states`` all that
    another run needs to start from there; with ``impulses`` what `hydrosim show --why` needs;
    ``accelerations``; the elevation at ``wave_probes``, x and y by name; the ``clearances`` of
    named points by name."""

    has_valid_defaults: ClassVar[bool] = True

    step: of.Period | None = None
    """Time between records, a multiple of the step of the solver. Without it about 0.5 s."""
    states: StrictBool = False
    """Whether all states are recorded, so that another run can start from any record."""
    impulses: StrictBool = False
    """Whether impulses of forces are recorded, for hydrosim show --why."""
    accelerations: StrictBool = False
    """Whether accelerations are recorded."""
    wave_probes: dict[of.Name, of.Position] = field(default_factory=dict)
    """Places x, y by name where the wave elevation is recorded. Example: {bow: [90 m, 0 m]}."""
    clearances: dict[of.Name, Clearance] = field(default_factory=dict)
    """Distances by name that are recorded."""

    def step_beside(self, step: float) -> float:
        """Time between records [s] beside the ``step`` of the solver: about `OUTPUT_STEP` if no
        other is wanted."""
        return self.step or step * max(1, round(OUTPUT_STEP / step))


def _is_result(value: object) -> bool:
    return isinstance(value, Path) or hasattr(value, "data_vars")


@schema_class
class Start(SchemaClass):
    """A run to start from, at a time of it or at its end."""

    # Time continues: the new run begins at that time, and waves, ramps and tables keep their phase.
    # `Scene.duration` is the length of the new run alone. Bodies, degrees of freedom and radiation
    # must equal those of the run, except where motions are zero by symmetry. `Body.position` then
    # applies to locked degrees of freedom only; `Body.velocity` is not used. In Python the run may
    # be a dataset.

    run: Annotated[Any, ReadAs(StrictStr, _is_result)]
    """Result file of the run that this one continues. Example: first.nc."""
    time: of.Instant | None = None
    """Time of that run at which this one begins. Without it that is its end."""


@dataclass(frozen=True)
class Scene:
    """Complete input of a run of a ``duration`` [s], or a text with a unit.

    ``at_rest`` starts the run at the equilibrium near `Body.position`, under the loads of the
    start. ``initial`` is the state of another run to start from.

    ``accept`` lists the questions that are not asked. ``left_out`` is what files of other programs
    say and the scene has not. ``places`` are file and line of keys of its
    case file, for messages.
    """

    title: str
    duration: float
    bodies: tuple[Body, ...]
    environment: Environment = field(default_factory=Environment)
    forces: Mapping[str, ForceElement] = field(default_factory=dict)
    joints: Mapping[str, Joint] = field(default_factory=dict, kw_only=True)
    solver: Solver = field(default_factory=Solver)
    output: RunOutput = field(default_factory=RunOutput)
    initial: Start | None = None
    at_rest: bool = False
    accept: tuple[Question, ...] = ()
    source: Mapping[str, Any] = field(default_factory=dict)
    left_out: tuple[OmittedEntry, ...] = ()
    places: Mapping[str, str] = field(default_factory=dict, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Values, elements and joints that are written as in a file get what the scene has."""
        duration = quantity("Scene.duration", self.duration, "time", "s", "2000 s", above=0.0)
        object.__setattr__(self, "duration", duration)
        if isinstance(self.output, Mapping):
            object.__setattr__(self, "output", RunOutput(**self.output))
        self._check_kinds()
        joints = {name: joint.build_active() for name, joint in self.joints.items()}
        if any(joints[name] is not joint for name, joint in self.joints.items()):
            object.__setattr__(self, "joints", joints)
        water = self.environment.water_density, self.environment.gravity
        built = {
            name: e.build_active(BuildContext(f"forces.{name}", Path("scene"), water, self.joints))
            for name, e in self.forces.items()
            if isinstance(e, ForceElement) and e.is_written()
        }
        if built:
            object.__setattr__(self, "forces", {**self.forces, **built})

    def _check_kinds(self) -> None:
        """Refuse what is no body, no joint, or no object of the kind of its field."""
        for name, kind in (("environment", Environment), ("solver", Solver), ("output", RunOutput)):
            if not isinstance(value := getattr(self, name), kind):
                text = f"found {value_text(value)}; expected hs.{kind.__name__}."
                raise InputError(f"scene: {name}: {text}")
        for body in self.bodies if isinstance(self.bodies, Sequence) else (self.bodies,):
            if not isinstance(body, Body):
                raise InputError(f"scene: bodies: found {value_text(body)}; expected hs.Body.")
        if not isinstance(self.joints, Mapping):
            raise InputError("scene: joints: found no mapping; expected names and joints.")
        for name, joint in self.joints.items():
            if not isinstance(joint, Joint) or not joint.type:
                text = f"found {type(joint).__name__}; expected a joint, such as hs.Hinge."
                raise InputError(f"scene: joints.{name}: {text}")

    @property
    def output_step(self) -> float:
        """Time between records [s], a multiple of the solver's step."""
        return self.output.step_beside(self.solver.step)

    def with_output(self, **keys: Any) -> Scene:
        """The same with other ``keys`` of its output."""
        return replace(self, output=replace(self.output, **keys))

    @cached_property
    def arrangement(self) -> Arrangement:
        """How its joints arrange its bodies, found once: it is asked for each body."""
        return arrange_joints(self.joints, [body.name for body in self.bodies])


# Trees of joints.
#
# Joints that last for the whole run make trees. Each tree grows from the earth or, if it does not
# touch the earth, from one of its bodies, which keeps its own six coordinates. A joint that would
# close a loop, a joint that is only `active` at times, and a rod is no branch: it is a constraint.

EARTH_BODY = None
HORIZONTAL_AXIS_TOL = 1e-3  # of a unit axis: its part along the vertical


class TreeJoint(NamedTuple):
    """A joint of a tree: its ``name``, the ``child`` that it carries and its ``parent`` (None: the
    earth). It is ``reversed`` if the child is the joint's `to`."""

    name: str
    joint: Joint
    child: str
    parent: str | None
    reversed: bool


class Arrangement(NamedTuple):
    """The ``branches``, parents before children, and the names of the joints that are constraints:
    ``loops`` (and rods) for the whole run, and ``passing`` at times. The ``children`` are bodies
    that a joint carries: they have no coordinates of their own. The ``roots`` are the first bodies
    of the trees of bodies that joints carry, or that carry others; a joint to the earth begins a
    tree of its own."""

    branches: tuple[TreeJoint, ...]
    loops: tuple[str, ...]
    passing: tuple[str, ...]
    children: frozenset[str]
    roots: Mapping[str, str]

    def anchors(self, body: str) -> bool:
        """Whether joints to the earth hold a ``body`` near its place and heading."""
        below = {branch.child: branch for branch in self.branches}
        root = below.get(self.roots.get(body, body))
        if root is None or root.parent is not EARTH_BODY:
            return False
        place: str | None = body
        while place is not EARTH_BODY:
            joint = below[place].joint
            if not all(_keeps_level(motion, joint) for motion in joint.motions):
                return False
            place = below[place].parent
        return True


def arrange_joints(joints: Mapping[str, Joint], bodies: Sequence[str]) -> Arrangement:
    """Arrange the ``joints`` between ``bodies``. The order of the bodies decides between equals."""
    lasting = {name: joint for name, joint in joints.items() if joint.lasts}
    carrying = {name: j for name, j in lasting.items() if not isinstance(j, Rod)}
    reached: set[str | None] = {EARTH_BODY}
    branches = list(_grow_branches(carrying, reached))
    for body in _roots(carrying, bodies):
        if body not in reached:
            reached.add(body)
            branches += _grow_branches(carrying, reached)
    used = {branch.name for branch in branches}
    return Arrangement(
        tuple(branches),
        tuple(name for name in lasting if name not in used),
        tuple(name for name in joints if name not in lasting),
        frozenset(branch.child for branch in branches),
        _root_of_each(branches),
    )


def _root_of_each(branches: Sequence[TreeJoint]) -> dict[str, str]:
    """The first body of the tree of each body in the ``branches``."""
    roots: dict[str, str] = {}
    for branch in branches:
        below = branch.child if branch.parent is None else branch.parent
        roots[branch.child] = roots.setdefault(below, below)
    return roots


def _keeps_level(motion: JointMotion, joint: Joint) -> bool:
    """Whether a motion turns about a level axis, or slides along the vertical."""
    up = abs(joint.axes()[motion.axis, 2])
    return (
        up < HORIZONTAL_AXIS_TOL
        if motion.kind == MotionKind.TURN
        else up > 1.0 - HORIZONTAL_AXIS_TOL
    )


def _roots(joints: Mapping[str, Joint], bodies: Sequence[str]) -> list[str]:
    """Bodies in the order in which they become roots: first those that others are joined `to`,
    and that are joined to none."""
    joined = {joint.body for joint in joints.values()}
    return sorted(bodies, key=lambda body: body in joined)


def _grow_branches(joints: Mapping[str, Joint], reached: set[str | None]) -> Iterator[TreeJoint]:
    """Branches from the bodies ``reached``, nearest first; it adds the bodies that they carry."""
    grows = True
    while grows:
        grows = False
        layer = set(reached)
        for name, joint in joints.items():
            if joint.to in layer and joint.body not in reached:
                reached.add(joint.body)
                yield TreeJoint(name, joint, joint.body, joint.to, False)
                grows = True
            elif joint.body in layer and joint.to not in reached:
                reached.add(joint.to)
                yield TreeJoint(name, joint, str(joint.to), joint.body, True)
                grows = True


def arrangement(scene: Scene) -> Arrangement:
    """How the joints of a scene arrange its bodies."""
    return scene.arrangement


def joined_with(scene: Scene, body: str) -> frozenset[str]:
    """The body and all bodies that the joints of its tree connect with it."""
    roots = arrangement(scene).roots
    root = roots.get(body)
    return frozenset({body, *(other for other in roots if roots[other] == root)})


def is_anchored(scene: Scene, body: str) -> bool:
    """True if joints to the earth hold a body near its place and heading: they turn about level
    axes, or slide up and down."""
    return arrangement(scene).anchors(body)


def floating_roots(scene: Scene) -> dict[str, tuple[str, ...]]:
    """Roots of trees that do not touch the earth, each with the bodies that the tree carries."""
    joint_tree = arrangement(scene)
    carried: dict[str, list[str]] = {}
    for body, root in joint_tree.roots.items():
        if root not in joint_tree.children and body != root:
            carried.setdefault(root, []).append(body)
    return {root: tuple(bodies) for root, bodies in carried.items()}


def tree_joints(scene: Scene) -> dict[str, Joint]:
    """The joints whose motions are coordinates, in the order of the scene."""
    branches = arrangement(scene).branches
    used = {branch.name for branch in branches}
    return {name: joint for name, joint in scene.joints.items() if name in used}
