"""Force elements, one file each, and their sum.

An element is one file with

    a frozen dataclass            of `scene.ForceElement`, which declares its properties: its parts
                                  and their mirror images, its signals, whether it is linear
    compile_elements              constants of all of them in a scene, a `NamedTuple` or an array
    add_force                     adds to its row of forces, and its work or dissipation
    add_energy                    if it stores energy
    NAME_KIND                     its states, modes, variables (`hydrosim.elements.kind`)

and one line each in `Elements`, `ELEMENT_KINDS` and the sums below. A kind whose units have modes,
which end at events, also appears in `hydrosim.elements.events`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from hydrosim.elements import (
    applied_force,
    bushing,
    damping,
    drive,
    external,
    linear_mooring,
    stream_load,
    tanks,
    trigger,
    viscous_roll,
)
from hydrosim.elements.contact import fender, landing
from hydrosim.elements.contact import kind as contact_points
from hydrosim.elements.drive import Drive
from hydrosim.elements.external import UserForce
from hydrosim.elements.joint import locks, motions
from hydrosim.elements.kind import (
    CanFail,
    ElementKind,
    ElementLoads,
    HasCoupledStates,
    HasImpulses,
    HasLinearDamping,
    HasLosses,
    HasMirrorSymmetry,
    KindConstants,
    KindWithModeSets,
    Layout,
    LinearResistance,
    UnitKind,
)
from hydrosim.elements.line import catenary, winch
from hydrosim.elements.line import kind as lines
from hydrosim.elements.link import table as links
from hydrosim.elements.link.kind import COMPENSATOR_KIND, LINK_KIND, SPRING_KIND
from hydrosim.jit.kernels import clear, kernel
from hydrosim.modes import MODE_COLUMNS
from hydrosim.scene import ForceElement, Scene
from hydrosim.scene.catenary import Catenary
from hydrosim.scene.contacts import (
    Contact,
    Coulomb,
    Fender,
    Frictionless,
    FrictionSlope,
    Landing,
    LoadPowers,
    NormalCurve,
    NormalLoop,
    Plane,
    PrescribedNormal,
    Seats,
    StickSlip,
    Wall,
)
from hydrosim.scene.damping import LinearDamping, QuadraticDamping, ViscousRoll
from hydrosim.scene.links import (
    Compensator,
    DryFriction,
    GasSpring,
    Spring,
    SpringDamper,
    Stop,
    Strut,
    TorsionSpring,
)
from hydrosim.scene.loads import AppliedForce, CurrentLoad, StreamLoad, WindLoad
from hydrosim.scene.restraints import Bushing, LinearMooring
from hydrosim.scene.signal import Harmonic, Recorded, Signal, SmoothTable, Table, constant
from hydrosim.scene.winch import Winch
from hydrosim.tanks.contents import Tanks
from hydrosim.water.wind import REFERENCE_HEIGHT, GustTable


class Elements(NamedTuple):
    """Constants of all elements of a scene, kind by kind; all rows of modes ``unit_rows`` (n,)
    of `UNIT_ROW`, and where the outputs of kinds begin."""

    linear_moorings: Any
    applied_forces: Any
    fenders: Any
    link_table: Any
    linear_dampings: Any
    quadratic_dampings: Any
    viscous_rolls: Any
    stream_loads: Any
    bushings: Any
    catenaries: Any
    guides: Any
    winches: Any
    locks: Any
    joint_motions: Any
    externals: Any
    drives: Any
    triggers: Any
    unit_rows: Any
    output_starts: Any


ELEMENT_KINDS: tuple[UnitKind, ...] = (
    linear_mooring.LINEAR_MOORING_KIND,
    applied_force.APPLIED_FORCE_KIND,
    contact_points.CONTACT_KIND,
    SPRING_KIND,
    COMPENSATOR_KIND,
    LINK_KIND,
    damping.LINEAR_DAMPING_KIND,
    damping.QUADRATIC_DAMPING_KIND,
    viscous_roll.VISCOUS_ROLL_KIND,
    stream_load.STREAM_LOAD_KIND,
    tanks.TANK_FLOW_KIND,
    bushing.BUSHING_KIND,
    lines.CATENARY_KIND,
    landing.GUIDE_KIND,
    winch.WINCH_KIND,
    locks.LOCK_KIND,
    locks.JOINT_LOAD_KIND,
    motions.JOINT_MOTION_KIND,
    external.EXTERNAL_KIND,
    drive.DRIVE_KIND,
    trigger.TRIGGER_KIND,
)
"""All kinds, in the order of their states in y and of their rows of modes."""


@kernel
def add_elements(t, y, modes, motion, bodies, elements, wrench, rate, dy):
    """Add the forces of all elements, each into its row of ``wrench`` (rows, 6 nb); see the
    elements."""
    e = elements
    loads = ElementLoads(wrench, rate, dy)
    if e.linear_moorings.size > 0:
        linear_mooring.add_force(t, y, modes, motion, bodies, e.linear_moorings, loads)
    if e.applied_forces.each.size > 0:
        applied_force.add_force(t, y, modes, motion, bodies, e.applied_forces, loads)
    fender.add_force(t, y, modes, motion, bodies, e.fenders, loads)
    if e.link_table.links.size > 0:  # passing arguments alone would cost a few percent
        links.add_force(t, y, modes, motion, bodies, e.link_table, loads)
    if e.linear_dampings.size > 0:
        damping.add_linear_damping(t, y, modes, motion, bodies, e.linear_dampings, loads)
    if e.quadratic_dampings.size > 0:
        damping.add_quadratic_damping(t, y, modes, motion, bodies, e.quadratic_dampings, loads)
    if e.viscous_rolls.size > 0:
        viscous_roll.add_force(t, y, modes, motion, bodies, e.viscous_rolls, loads)
    if e.stream_loads.each.size > 0:
        stream_load.add_force(t, y, modes, motion, bodies, e.stream_loads, loads)
    if e.bushings.each.size > 0:
        bushing.add_force(t, y, modes, motion, bodies, e.bushings, loads)
    if e.catenaries.lines.size > 0:
        catenary.add_force(t, y, modes, motion, bodies, e.catenaries, loads)
    if e.guides.pins.size > 0:
        landing.add_force(t, y, modes, motion, bodies, e, wrench)
    if e.winches.each.size > 0:
        winch.add_force(t, y, modes, motion, bodies, e.winches, loads)
    if e.locks.each.size > 0:
        clear(dy[e.locks.state : e.locks.state + locks.LOCK_STATES * e.locks.each.size])
    if e.joint_motions.each.size > 0:
        motions.add_force(y, modes, motion, bodies, e.joint_motions, wrench, rate)
    if e.externals.each.size > 0:
        external.add_force(t, y, modes, motion, bodies, e.externals, loads)
    if e.triggers.each.size > 0:
        trigger.clear_inactive(modes, e.triggers, wrench, rate)
        clear(dy[e.triggers.state : e.triggers.state + e.triggers.each.size])


@kernel
def add_given_forces(t, y, modes, motion, bodies, elements, wrench, work):
    """Add forces that depend on time alone, each into its row of ``wrench``; ``work`` is
    scratch."""
    p = elements.applied_forces
    if p.each.size > 0:
        loads = ElementLoads(wrench, work.rate, work.total)
        applied_force.add_force(t, y, modes, motion, bodies, p, loads)


@kernel
def add_element_energies(t, y, modes, motion, bodies, elements, stored):
    """Add stored energies of all elements, each into its row of ``stored`` (rows,)."""
    e = elements
    if e.linear_moorings.size > 0:
        linear_mooring.add_energy(t, y, modes, motion, bodies, e.linear_moorings, stored)
    if e.fenders.points.size > 0:
        fender.add_energy(t, y, modes, motion, bodies, e.fenders, stored)
    if e.link_table.links.size > 0:
        links.add_energy(t, y, modes, motion, bodies, e.link_table, stored)
    if e.bushings.each.size > 0:
        bushing.add_energy(t, y, modes, motion, bodies, e.bushings, stored)
    if e.catenaries.lines.size > 0:
        catenary.add_energy(t, y, modes, motion, bodies, e.catenaries, stored)
    if e.guides.pins.size > 0:
        landing.add_energy(modes, motion, bodies, e, stored)
    if e.winches.each.size > 0:
        winch.add_energy(t, y, modes, motion, bodies, e.winches, stored)
    if e.joint_motions.each.size > 0:
        motions.add_energy(y, modes, e.joint_motions, stored)
    if e.triggers.each.size > 0:
        trigger.clear_inactive_energy(modes, e.triggers, stored)


def kinds_of(parts: KindConstants) -> Iterator[tuple[UnitKind, Any]]:
    """The kinds that have units with modes, and their constants."""
    every = ((kind, kind.constants_in(parts)) for kind in ELEMENT_KINDS)
    return ((kind, p) for kind, p in every if kind.modes(p).size)


def kinds_with_mode_sets(parts: KindConstants) -> list[tuple[KindWithModeSets, Any]]:
    """The kinds whose units have several postures, and their constants."""
    return [
        (kind, kind.constants_in(parts))
        for kind in ELEMENT_KINDS
        if isinstance(kind, KindWithModeSets)
    ]


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout) -> Elements:
    """Constants of all ``elements``; `assign_indices` assigns the indices of their states and
    modes, `events.with_rows_and_outputs` their rows of modes and outputs."""
    compilers = {k.field: k.compile for k in ELEMENT_KINDS if isinstance(k, ElementKind)}
    constants = {field: compile(elements, layout) for field, compile in compilers.items()}
    return Elements(**constants, unit_rows=(), output_starts=())


def renumber_coordinates(
    parts: KindConstants, elements: Mapping[str, ForceElement], layout: Layout
) -> IndexedConstants:
    """The same constants for coordinates that are numbered otherwise."""
    moved = motions.compile_elements(elements, layout)
    driven = drive.compile_elements(elements, layout)
    return IndexedConstants(
        parts.elements._replace(joint_motions=moved, drives=driven), parts.tanks
    )


def joints_are_linear(parts: KindConstants) -> bool:
    """True if neither stops nor dry friction act in joints."""
    return motions.are_linear(parts.elements.joint_motions)


class IndexedConstants(NamedTuple):
    """Constants of all kinds with indices of their states and modes."""

    elements: Elements
    tanks: Tanks


def assign_indices(parts: KindConstants, scene: Scene, state: int, losses: int) -> IndexedConstants:
    """The same constants, with states in y numbered from ``state`` on, kind by kind, rows of modes
    likewise, and the integrals of losses, row by row, from ``losses`` on. Reactions of joints
    follow those of contact points. Constants with such indices have fields ``state``, ``mode``,
    ``losses`` and ``reaction``."""
    elements = parts.elements
    flows = parts.tanks
    mode = 0
    reaction = elements.fenders.points.size
    for kind in ELEMENT_KINDS:
        p = kind.constants_in(parts)
        places = {"state": state, "mode": mode, "losses": losses, "reaction": reaction}
        indices = {name: places[name] for name in getattr(p, "_fields", ()) if name in places}
        if kind is tanks.TANK_FLOW_KIND:
            flows = p._replace(**indices)
        elif isinstance(kind, ElementKind) and indices:
            elements = kind.replaced_in(elements, p._replace(**indices))
        state += _state_count(kind, p, scene)
        mode += kind.modes(p).size
        reaction += _reaction_count(kind, p)
    return IndexedConstants(elements, flows)


def _reaction_count(kind: UnitKind, p: Any) -> int:
    """Number of reactions of a kind. The loads of joints share the constants of their locks, and
    have no reactions of their own."""
    has_reactions = isinstance(kind, ElementKind) and "reaction" in getattr(p, "_fields", ())
    return len(p.each) if has_reactions else 0


def state_count(parts: KindConstants, scene: Scene) -> int:
    """Number of states in y of all kinds."""
    return sum(_state_count(kind, kind.constants_in(parts), scene) for kind in ELEMENT_KINDS)


def _state_count(kind: UnitKind, p: Any, scene: Scene) -> int:
    return sum(len(blocks.owners) * len(blocks.components) for blocks in kind.states(p, scene))


def tally_count(parts: KindConstants) -> int:
    """Number of the integrals of units, if impulses are asked for."""
    return sum(
        len(k.impulse_names) * k.modes(k.constants_in(parts)).size
        for k in ELEMENT_KINDS
        if isinstance(k, HasImpulses)
    )


def coupled_states(parts: KindConstants) -> np.ndarray:
    """Entries (m,) of y that are states of elements and act on other states."""
    coupled_kinds = [kind for kind in ELEMENT_KINDS if isinstance(kind, HasCoupledStates)]
    return np.concatenate([kind.coupled_states(kind.constants_in(parts)) for kind in coupled_kinds])


def new_modes(parts: KindConstants) -> np.ndarray:
    """New modes (rows, 3) of the units of all kinds, for `events.set_initial_modes`."""
    rows = sum(kind.modes(kind.constants_in(parts)).size for kind in ELEMENT_KINDS)
    return np.zeros((rows, MODE_COLUMNS), dtype=np.int64)


def modes_of_kind(kind: UnitKind, p: Any, modes: np.ndarray) -> np.ndarray:
    """The rows of ``modes`` (..., rows, 3) of one kind with the constants ``p``."""
    first = getattr(p, "mode", 0)
    return modes[..., first : first + kind.modes(p).size, :]


def losses(parts: KindConstants, observed: Mapping[str, np.ndarray]) -> dict[int, np.ndarray]:
    """Energy lost (nt,) [J] by row of forces, beyond the booked dissipation, from the values
    ``observed`` of the units of each kind."""
    losses_by_index: dict[int, np.ndarray] = {}
    for kind in ELEMENT_KINDS:
        if isinstance(kind, HasLosses):
            losses_by_index |= kind.losses(kind.constants_in(parts), observed[kind.unit])
    return losses_by_index


def is_mirrored(parts: KindConstants, y: np.ndarray, modes: np.ndarray) -> bool:
    """True if the states and modes of all kinds are mirror symmetric about y = 0."""
    mirrored_kinds = [kind for kind in ELEMENT_KINDS if isinstance(kind, HasMirrorSymmetry)]
    return all(kind.is_mirrored(kind.constants_in(parts), y, modes) for kind in mirrored_kinds)


def mode_row_names(parts: KindConstants, scene: Scene) -> list[str]:
    """The kind and the name of the unit of every row of modes."""
    names = {kind: kind.unit_names(scene) for kind, _ in kinds_of(parts)}
    return [f"{kind.unit.replace('_', ' ')} {name}" for kind in names for name in names[kind]]


def undefined_units(
    parts: KindConstants, scene: Scene, modes: np.ndarray
) -> Iterator[tuple[str, str]]:
    """Names of the units whose force is not defined in these ``modes``, each with the reason."""
    for kind in ELEMENT_KINDS:
        if isinstance(kind, CanFail):
            p = kind.constants_in(parts)
            names = kind.unit_names(scene)
            yield from (
                (names[i], why) for i, why in kind.undefined_units(p, modes_of_kind(kind, p, modes))
            )


def resistances(parts: KindConstants) -> Iterator[LinearResistance]:
    """The linear damping of all kinds."""
    for kind in ELEMENT_KINDS:
        if isinstance(kind, HasLinearDamping):
            yield from kind.resistances(kind.constants_in(parts))


def has_kind(element: ForceElement) -> bool:
    """True if a kind has this element."""
    kind_classes = [kind.classes for kind in ELEMENT_KINDS if isinstance(kind, ElementKind)]
    return any(isinstance(element, classes) for classes in kind_classes)


def given_rows(elements: Elements) -> np.ndarray:
    """Rows (n,) of forces that depend on time alone."""
    return np.asarray(elements.applied_forces.each["row"], dtype=np.int64)


def given_frequencies(elements: Elements) -> np.ndarray:
    """Frequencies (n,) [rad/s] of forces that depend on time alone; 0 for signals that are not
    harmonic."""
    return np.asarray(elements.applied_forces.parts["signal"]["frequency"])


def pieces_of_lines(elements: Elements) -> np.ndarray:
    """The pieces (n,) of all catenaries."""
    return np.asarray(elements.catenaries.pieces)


def driven_coordinates(elements: Elements) -> np.ndarray:
    """The free coordinate (n,) of each drive."""
    return np.asarray(elements.drives.each["coordinate"], dtype=np.int64)


def lasting_states(parts: KindConstants) -> np.ndarray:
    """Entries (n,) of y that a body at rest keeps: of joints that are constraints, and lengths off
    the drums of winches."""
    joints = locks.states_of(parts.elements.locks)
    drums = winch.lasting_lengths(parts.elements.winches)
    return np.array([*range(joints.start, joints.stop), *drums], dtype=np.int64)


def loop_modes(parts: KindConstants) -> np.ndarray:
    """Rows (n,) of modes of the joints that close loops."""
    p = parts.elements.locks
    return np.asarray(p.mode + np.flatnonzero(p.each["lasts"]))


def without_friction(elements: Elements) -> Elements:
    """The same elements with contacts that slip freely, and drums of winches that stand."""
    fenders = fender.without_friction(elements.fenders)
    return elements._replace(fenders=fenders, winches=winch.drums_locked(elements.winches))


def in_gusts(elements: Elements, gusts: GustTable) -> Elements:
    """The same elements in these gusts; the very same if the gusts are."""
    loads = stream_load.with_gusts(elements.stream_loads, gusts)
    same = loads is elements.stream_loads
    return elements if same else elements._replace(stream_loads=loads)


def in_same_weather(elements: Elements, others: Elements) -> Elements:
    """The same elements with what the sea and the wind have set in ``connected_bodies``: gusts, and
    the linearised drag of lines."""
    catenaries = lines.with_drag_of(elements.catenaries, others.catenaries)
    return in_gusts(elements, others.stream_loads.gusts)._replace(catenaries=catenaries)


def with_linear_rolls(elements: Elements, rates: np.ndarray) -> Elements:
    """The same elements with roll damping that is linear for Gaussian roll ``rates`` of these
    standard deviations (ne,) [rad/s]."""
    return elements._replace(
        viscous_rolls=viscous_roll.linearise_damping(elements.viscous_rolls, rates)
    )


def heights_of_wind(elements: Elements) -> list[float]:
    """Heights [m] of the columns of gusts, the first 10 m."""
    return [REFERENCE_HEIGHT, *(float(z) for z in elements.stream_loads.heights)]


def function_errors(
    elements: Mapping[str, ForceElement],
) -> Iterator[tuple[str, BaseException]]:
    """Names of the external forces whose function has failed, each with its error."""
    for name, element in elements.items():
        if isinstance(element, UserForce) and element.error is not None:
            yield name, element.error


def externals_of(elements: Mapping[str, ForceElement]) -> dict[str, UserForce]:
    """The external forces among ``elements``."""
    return {name: e for name, e in elements.items() if isinstance(e, UserForce)}


def with_own_functions(elements: Mapping[str, ForceElement]) -> dict[str, ForceElement]:
    """The elements with copies of their external forces, for one run: so runs that use the same
    `UserForce` share no errors."""
    owner = object()
    return {
        name: e.copied_for(owner) if isinstance(e, UserForce) else e for name, e in elements.items()
    }


def functions_at_stages(
    t: float, motion: Any, bodies: Any, elements: Elements, rows: int
) -> dict[int, np.ndarray]:
    """Wrenches (6 nb,), by row of forces, of the functions that are called at stages, asked at the
    time ``t`` [s] for this ``motion``; NaN where one fails."""
    p = elements.externals
    wrench = np.zeros((rows, motion.velocity.size))
    external.call_at_stage(t, motion, bodies, p, wrench)
    return {int(e["row"]): wrench[e["row"]] for e in p.each if e["way"] == external.STAGE}


def without_numbers(elements: Elements) -> Elements:
    """The same elements without what differs between two makings of them: numbers of functions."""
    externals = elements.externals.each.copy()
    externals["number"] = 0
    return elements._replace(externals=elements.externals._replace(each=externals))


def signals_of(elements: Mapping[str, ForceElement]) -> Iterator[tuple[str, Signal]]:
    """All signals over time among ``elements``, each with its key in a case file."""
    for name, element in elements.items():
        yield from ((f"forces.{name}.{key}", signal) for key, signal in element.signals())
