"""The scene: what is simulated, as frozen dataclasses in SI units and radians.

A scene comes from a case file (`hydrosim.case`) or is written in Python; `hydrosim.compiling.model`
compiles it to arrays. Nothing here computes.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import numpy as np

from hydrosim.dofs import DOFS

if TYPE_CHECKING:
    import xarray as xr


class Hydrodynamics(Protocol):
    """A database in memory, as `hydrosim.database.HydroDatabase` is: what a scene knows of it is
    where it comes from and for how many bodies it is."""

    @property
    def source(self) -> str: ...

    @property
    def bodies(self) -> int: ...


class Without(StrEnum):
    """What of a database is left out."""

    DRIFT = "drift"
    QTF = "qtf"
    LOADS = "loads"


@dataclass(frozen=True)
class Changes:
    """What is done to a database that is read, and recorded in its attributes.

    ``accept`` are names of findings of its checks that do not refuse it; ``frequencies`` [rad/s]
    the lowest and the highest that are kept; ``symmetrise`` makes matrices symmetric and takes away
    what the mirror image forbids; ``without`` leaves parts out; of ``bodies_apart`` each is by
    itself, with the others held.
    """

    accept: tuple[str, ...] = ()
    frequencies: tuple[float, float] | None = None
    symmetrise: bool = False
    without: tuple[Without, ...] = ()
    bodies_apart: bool = False


@dataclass(frozen=True)
class ChangedDatabase:
    """A database, or its file, with ``changes``; ``draught`` names one of several in the file."""

    source: Hydrodynamics | Path
    changes: Changes
    draught: str | None = None


@dataclass(frozen=True, eq=False)
class Coefficients:
    """Hydrodynamics by numbers alone (6, 6) about the centre of gravity, of no wave loads:
    constant ``added_mass`` and ``damping``, and hydrostatic ``stiffness``."""

    added_mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray


@dataclass(frozen=True, eq=False)
class Hull:
    """A closed hull of triangles, ``corners`` (nt, 3, 3) in the database's frame [m], normals into
    the water; ``source`` says where it is from."""

    corners: np.ndarray
    source: str = "a hull"


@dataclass(frozen=True)
class AtDraught:
    """The database, or its file, of a hull at a ``draught`` [m]."""

    draught: float
    source: Hydrodynamics | Path | ChangedDatabase


@dataclass(frozen=True)
class Family:
    """Databases of one hull at several draughts, between which it takes what belongs to its own,
    see `hydrosim.stepping.blending`. Their frames have one origin on the hull, seen from above. At
    the draught of the first of ``members`` the body is at its place at rest."""

    members: tuple[AtDraught, ...]


class RadiationModel(StrEnum):
    """How the memory of the radiated waves is computed, with the defaults of each way."""

    AUTOMATIC = "automatic"
    STATE_SPACE = "state_space"
    CONVOLUTION = "convolution"
    NONE = "none"


@dataclass(frozen=True)
class AutomaticRadiation:
    """Extra states for each group of coupled motions whose passive fit holds the ``tolerance``, and
    the memory integral itself for the others; a run that starts from another takes what that has.

    The functions are tabulated to ``length`` [s], every ``step`` [s].
    """

    tolerance: float = 3e-4
    length: float = 100.0
    step: float = 0.1


@dataclass(frozen=True)
class StateSpaceRadiation:
    """Extra states: a rational fit of the retardation functions within a relative ``tolerance``.

    The functions are tabulated to ``length`` [s], every ``step`` [s].
    """

    tolerance: float = 3e-4
    length: float = 100.0
    step: float = 0.1


@dataclass(frozen=True)
class ConvolutionRadiation:
    """The memory integral itself over ``length`` [s]; the table's ``step`` [s] is not the run's."""

    length: float = 100.0
    step: float = 0.1


@dataclass(frozen=True)
class ConstantRadiation:
    """No memory: added mass and damping of one ``period`` [s]."""

    period: float


Radiation = AutomaticRadiation | StateSpaceRadiation | ConvolutionRadiation | ConstantRadiation
BY_NAME: Mapping[RadiationModel, Radiation | None] = {
    RadiationModel.AUTOMATIC: AutomaticRadiation(),
    RadiationModel.STATE_SPACE: StateSpaceRadiation(),
    RadiationModel.CONVOLUTION: ConvolutionRadiation(),
    RadiationModel.NONE: None,
}


class SecondOrder(StrEnum):
    """Approximation of the slow second-order wave loads."""

    NONE = "none"
    MEAN_DRIFT = "mean_drift"
    NEWMAN = "newman"
    NEWMAN_SQUARE_ROOT = "newman_square_root"
    QTF = "qtf"


class Method(StrEnum):
    """Time integration method."""

    RK2 = "rk2"
    HEUN = "heun"
    RK4 = "rk4"
    DOPRI5 = "dopri5"
    ESDIRK4 = "esdirk4"


ADAPTIVE = frozenset({Method.DOPRI5, Method.ESDIRK4})
"""Methods that choose their own steps."""


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
class Jonswap:
    """JONSWAP spectrum (Hasselmann et al. 1973) of a significant height [m] and peak period [s]."""

    significant_height: float
    peak_period: float
    peak_enhancement: float = 3.3


@dataclass(frozen=True)
class Tma:
    """JONSWAP spectrum limited by a ``water_depth`` [m] (Bouws et al. 1985), scaled to the
    significant height; ``gravity`` [m/s^2]."""

    significant_height: float
    peak_period: float
    water_depth: float
    peak_enhancement: float = 3.3
    gravity: float = 9.81


@dataclass(frozen=True)
class OchiHubblePeak:
    """One of the peaks of `OchiHubble`: significant height [m], peak period [s], and ``shape``
    lambda, the sharpness of the peak."""

    significant_height: float
    peak_period: float
    shape: float = 1.0


@dataclass(frozen=True)
class OchiHubble:
    """Sum of peaks of chosen sharpness (Ochi and Hubble 1976), who have two: swell, wind sea."""

    peaks: tuple[OchiHubblePeak, ...]


@dataclass(frozen=True)
class Torsethaugen:
    """Wind sea and swell of a significant height [m] and peak period [s] (Torsethaugen and Haver
    2004, the simplified form), for the North Sea; ``gravity`` [m/s^2]."""

    significant_height: float
    peak_period: float
    gravity: float = 9.81


@dataclass(frozen=True)
class WhiteNoise:
    """Constant density between two frequencies [rad/s], of a significant height [m]."""

    significant_height: float
    lowest_frequency: float
    highest_frequency: float


@dataclass(frozen=True, eq=False)
class SpectrumTable:
    """``density`` (nf,) [m^2 s/rad] at rising ``frequency`` (nf,) [rad/s]: straight lines between
    them, nothing outside."""

    frequency: np.ndarray
    density: np.ndarray


@dataclass(frozen=True, eq=False)
class DirectionalTable:
    """``density`` (nf, nh) [m^2 s/rad^2] at rising ``frequency`` (nf,) [rad/s] and rising, equally
    spaced ``heading`` (nh,) [rad], where waves go to: straight lines between the frequencies,
    constant over the sector around each heading."""

    frequency: np.ndarray
    heading: np.ndarray
    density: np.ndarray


@dataclass(frozen=True)
class RegularWave:
    """One Airy wave: amplitude * cos(2 pi t / period + phase) at the earth's origin."""

    amplitude: float
    period: float
    phase: float = 0.0


@dataclass(frozen=True, eq=False)
class GivenComponents:
    """Airy waves amplitude * cos(omega t + phase) at the earth's origin: ``omega`` [rad/s],
    ``amplitude`` [m], ``phase`` [rad] and ``heading`` [rad] are (n,) each."""

    omega: np.ndarray
    amplitude: np.ndarray
    phase: np.ndarray
    heading: np.ndarray


@dataclass(frozen=True, eq=False)
class RecordedElevation:
    """``elevation`` (n,) [m] at equally spaced ``time`` (n,) [s] of the run, measured at
    ``position`` x, y [m]; its mean is left out, and what is above ``highest_frequency`` [rad/s]."""

    time: np.ndarray
    elevation: np.ndarray
    position: tuple[float, float] = (0.0, 0.0)
    highest_frequency: float = np.inf


Density = Jonswap | Tma | OchiHubble | Torsethaugen | WhiteNoise | SpectrumTable | DirectionalTable
"""Spectra from which a random sea is drawn."""
Spectrum = Density | RegularWave | GivenComponents | RecordedElevation


class Amplitudes(StrEnum):
    """Of the components of a random sea: sqrt(2 S dw), or Rayleigh distributed about that, which
    makes the sea Gaussian."""

    DETERMINISTIC = "deterministic"
    RAYLEIGH = "rayleigh"


@dataclass(frozen=True)
class WaveTrain:
    """Waves of one spectrum and one mean direction.

    ``heading`` [rad] is where they go to, counter-clockwise from +x (`GivenComponents` and
    `DirectionalTable` have their own); ``ramp`` [s] is the time over which the elevation grows from
    zero; ``repeat_period`` [s] sets the spacing of the components of a random sea, 2 pi /
    repeat_period, so that the sea does not depend on the duration. ``spreading`` is the exponent s
    of directions distributed as cos^2s of half the angle to the heading; None: long crests.
    """

    spectrum: Spectrum
    heading: float = 0.0
    seed: int = 1
    ramp: float = 0.0
    repeat_period: float = 10800.0
    amplitudes: Amplitudes = Amplitudes.DETERMINISTIC
    spreading: float | None = None


@dataclass(frozen=True)
class Stream:
    """Steady and uniform current or wind: ``speed`` [m/s], and the ``heading`` [rad] it goes to,
    counter-clockwise from +x."""

    speed: float = 0.0
    heading: float = 0.0


@dataclass(frozen=True)
class Environment:
    """Water [m, kg/m^3, m/s^2] and the waves on it; an infinite depth is ``math.inf``. ``current``
    and ``wind`` act through force elements alone: the waves do not know of them."""

    water_depth: float = np.inf
    water_density: float = 1025.0
    gravity: float = 9.81
    waves: tuple[WaveTrain, ...] = ()
    current: Stream = field(default_factory=Stream)
    wind: Stream = field(default_factory=Stream)


class Place(StrEnum):
    """Where the waves meet a body: at rest, at the place that it has slowly moved to, or where it
    is at the time; `AUTOMATIC` is one of the first two, see `hydrosim.waves.places`."""

    AUTOMATIC = "automatic"
    MEAN = "mean"
    SLOW = "slow"
    INSTANTANEOUS = "instantaneous"


@dataclass(frozen=True)
class WaveForces:
    """Which wave loads act on a body: of first order, slow ones of second order, and those at
    the sums of the waves' frequencies.

    ``headings`` and ``position`` say whether first-order loads are those of the body at rest, or
    follow its yaw, and its place, see `Place`; second-order loads are those at rest.
    """

    first_order: bool = True
    second_order: SecondOrder = SecondOrder.NONE
    sum_frequency: bool = False
    headings: Place = Place.AUTOMATIC
    position: Place = Place.AUTOMATIC


class Weight(StrEnum):
    """What carries a body: nothing need, for its weight is balanced at rest and no force; or
    contacts, lines and buoyancy, for it is a force of its own."""

    BALANCED = "balanced"
    CARRIED = "carried"


@dataclass(frozen=True)
class Box:
    """A tank between two corners (3,) [m]; ``permeability`` is the part of it that fluid fills."""

    low: tuple[float, ...]
    high: tuple[float, ...]
    permeability: float = 1.0


@dataclass(frozen=True, eq=False)
class TankTable:
    """A tank of which is known, at each ``level`` (n,) above its bottom [m], rising from 0: the
    ``volume`` (n,) of fluid in it [m^3], its ``centroid`` (n, 3), and the second moments xx, xy, yy
    of its free ``surface`` about its centroid (n, 3) [m^4]."""

    level: np.ndarray
    volume: np.ndarray
    centroid: np.ndarray
    surface: np.ndarray


@dataclass(frozen=True, eq=False)
class TankMesh:
    """A tank inside the triangles ``corners`` (nt, 3, 3) [m], normals outward, of a closed mesh;
    ``permeability`` as of a box; ``source`` says where it is from."""

    corners: np.ndarray
    permeability: float = 1.0
    source: str = "a mesh"


TankShape = Box | TankTable | TankMesh


class FreeSurface(StrEnum):
    """Of the fluid in a tank: level at all times, or fixed to the tank."""

    QUASI_STATIC = "quasi_static"
    FROZEN = "frozen"


@dataclass(frozen=True, eq=False)
class Plan:
    """Levels (n,) [m] of a tank at times (n,) [s]: between them its flow, from or to the sea, is
    constant; there is none before and after."""

    time: np.ndarray
    level: np.ndarray


@dataclass(frozen=True)
class Tank:
    """A tank of a body, in the database's frame, with a fluid of this ``density`` [kg/m^3], whose
    ``level`` above the bottom [m] is that at the start."""

    name: str
    shape: TankShape
    level: float
    density: float = 1025.0
    surface: FreeSurface = FreeSurface.QUASI_STATIC
    plan: Plan | None = None


@dataclass(frozen=True)
class LevelReached:
    """When the level of a tank [m] is above or, else, below this."""

    tank: str
    level: float
    above: bool


@dataclass(frozen=True)
class When:
    """A ``time`` [s]; or, of a ``channel``, that it has been ``above`` or ``below`` a value for so
    long, ``lasting`` [s] (the names of channels are in `hydrosim.forces.channels`)."""

    time: float = 0.0
    channel: str | None = None
    above: float | None = None
    below: float | None = None
    lasting: float = 0.0


@dataclass(frozen=True)
class Pump:
    """Moves ``rate`` [kg/s] from the ``source`` to the ``target``, tanks of its body or, None, the
    sea, from ``start`` to ``stop``: times [s], levels or events. Without ``stop`` until the source
    is empty or the target full."""

    name: str
    rate: float
    source: str | None
    target: str | None
    start: float | LevelReached | When = 0.0
    stop: float | LevelReached | When | None = None


@dataclass(frozen=True)
class Clearance:
    """Distance ``of`` a named point ("bow of barge") ``to`` another; or from a plane through
    ``place`` with a ``normal``, in the earth frame or that of ``body``."""

    of: str
    to: str | None = None
    place: tuple[float, ...] = (0.0, 0.0, 0.0)
    normal: tuple[float, ...] = (0.0, 0.0, 1.0)
    body: str | None = None


@dataclass(frozen=True)
class Body:
    """A rigid body: ``mass`` [kg] and ``inertia`` (3, 3) about the centre of gravity [kg m^2].

    ``hydrodynamics`` is a database or its file, changed or not, a family of them over the draught,
    which needs ``hydrostatics``, or coefficients; None makes a dry body. ``database_body`` says
    which of the database's bodies it is, from 1; all of them are in the scene, at one ``location``
    and with one ``heading`` and one ``radiation``, a model by name or with its settings. A database
    of another content than ``database_checksum`` is refused.
    ``hydrostatics`` is the closed hull whose buoyancy is taken at any draught, heel and trim; None
    takes the stiffness of the database, which holds about the place at rest.
    ``centre_of_gravity`` (3,) is in the database's frame and is the body frame's origin.
    ``location`` (2,) places the origin of the database's frame in the earth's x, y; ``heading``
    [rad] is where its x axis points to at rest, from which yaw is counted. ``position`` and
    ``velocity`` (6,) are the initial offsets from the place at rest, along the earth's axes and
    about the body's, and their rates; ``dofs`` not named are locked, and a body without any is
    held. ``points`` are places in the body frame by name, whose motions are recorded.

    What is in its ``tanks`` at the start is part of its mass and inertia, and so is its centre of
    gravity then. ``constant_inertia`` leaves mass and inertia as they are then, whatever is pumped:
    the weight alone changes.
    """

    name: str
    mass: float
    inertia: np.ndarray
    hydrodynamics: Hydrodynamics | Path | ChangedDatabase | Family | Coefficients | None = None
    centre_of_gravity: tuple[float, ...] = (0.0, 0.0, 0.0)
    location: tuple[float, ...] = (0.0, 0.0)
    heading: float = 0.0
    database_body: int = 1
    database_checksum: str | None = None
    dofs: tuple[str, ...] = DOFS
    position: tuple[float, ...] = (0.0,) * 6
    velocity: tuple[float, ...] = (0.0,) * 6
    radiation: RadiationModel | Radiation = RadiationModel.AUTOMATIC
    wave_forces: WaveForces = field(default_factory=WaveForces)
    hydrostatics: Hull | None = None
    points: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    weight: Weight = Weight.BALANCED
    tanks: tuple[Tank, ...] = ()
    pumps: tuple[Pump, ...] = ()
    constant_inertia: bool = False


@dataclass(frozen=True)
class Active:
    """When something begins to act, from the ``start`` if None, and ``until`` when, to the end if
    None. What has begun or ended does not do so again."""

    start: When | None = None
    until: When | None = None


@dataclass(frozen=True)
class ForceElement:
    """Base of the elements in `hydrosim.forces`: ``body`` is the name of the body it acts on, and
    it may be ``active`` for a time only. ``capacity`` [N] is what each of its contact points or
    lines may carry: forces are compared with it, and nothing breaks.

    What an element that ``supplies`` does to the bodies is booked as work, else as dissipation. An
    element says in its own file what it can do; what it says nothing of costs speed alone.
    """

    supplies: ClassVar[bool] = False
    body: str
    active: Active | None = field(default=None, kw_only=True)
    capacity: float | None = field(default=None, kw_only=True)

    def check(self, name: str) -> None:
        """Raises InputError where the element is wrong as no case file can be, but one written in
        Python can."""

    def carries(self) -> bool:
        """Whether it can carry weight."""
        return True

    def holds(self) -> Collection[str]:
        """Of surge, sway and yaw, those in which it takes its body back to its place on earth."""
        return ()

    def may_give(self) -> bool:
        """Whether it can give energy to the bodies, though it is booked as dissipation."""
        return False

    def others(self) -> Iterator[tuple[str, str | None]]:
        """Keys and names of the other bodies that it acts on."""
        yield from ()

    def signals(self) -> Iterator[tuple[str, Any]]:
        """Keys and signals over time of what changes with it."""
        yield from ()

    def unit_names(self, name: str) -> Sequence[str]:
        """Names of its parts that have states or modes, if the element is called ``name``."""
        return ()

    def couplings(self) -> Iterator[np.ndarray]:
        """Matrices (6, 6) by which it couples the coordinates of its body."""
        yield from ()

    def parts(self, y: float) -> Sequence[ForceElement]:
        """Parts of it that must each have a mirror image in the plane at ``y`` [m], as if that were
        the plane y = 0; none if it acts by its `couplings` alone."""
        return (self,)

    def image(self) -> ForceElement | None:
        """The mirror image of a part in the plane y = 0; None if nothing is known of it."""
        return None

    def asymmetry(self) -> str | None:
        """What else keeps it from being its own mirror image, in words."""
        return None

    def nonlinearity(self, name: str, turns: Turns) -> str | None:
        """Why its force is not linear in the motions of its body; None if it is."""
        return name


@dataclass(frozen=True)
class Turns:
    """How a body may turn: about the ``free`` of its coordinates 3, 4, 5, with ``exact`` rotations
    or small ones. ``elements`` are all elements as compiled, ``row`` that of the one in question.
    """

    free: Sequence[int]
    exact: bool
    elements: Any
    row: int


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
    ``tolerance``, times its length; ``unstable`` is about steps of the others. A scene that is
    ``linear`` is not stepped unless asked for, see `hydrosim.linear.propagate`; one that is its own
    mirror image has no sway, roll and yaw unless its ``symmetry`` is ignored, see
    `hydrosim.compiling.symmetry`.
    """

    method: Method = Method.RK4
    step: float = 0.1
    tolerance: Tolerance = field(default_factory=Tolerance)
    kinematics: Kinematics = Kinematics.EXACT
    events: bool = True
    unstable: Unstable = Unstable.WARN
    linear: LinearScenes = LinearScenes.EXACT
    symmetry: Symmetry = Symmetry.USE


class Question(StrEnum):
    """What is asked where a value is possible and hardly meant, see `hydrosim.compiling.questions`;
    those that a scene accepts are not asked."""

    ANGLES = "angles"
    SPEED = "speed"
    OVERLAP = "overlap"
    PLANE = "plane"
    LINES = "lines"
    MASS = "mass"
    INERTIA = "inertia"
    STABILITY = "stability"
    PERIODS = "periods"
    LIFT = "lift"
    FRICTION = "friction"
    DAMPING = "damping"
    WATER = "water"
    STREAMS = "streams"
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
    questions that are not asked of it.
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
