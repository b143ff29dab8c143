"""Databases as the equation of motion needs them: about the centres of gravity, in the time
domain."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.linalg import block_diag

from hydrosim import database
from hydrosim import scene as scenes
from hydrosim.compile import databases
from hydrosim.compile.hydrostatics import with_hulls
from hydrosim.database.changes import CHANGED_ATTRIBUTE
from hydrosim.database.checks import ACCEPTED_ATTRIBUTE
from hydrosim.dofs import DOFS
from hydrosim.elements.kind import UncoupledResonance
from hydrosim.errors import InputError
from hydrosim.integrate.names import dofs_of
from hydrosim.water import radiation

if TYPE_CHECKING:
    from hydrosim.compile.restart import MemoryBefore
    from hydrosim.database.database import HydroDatabase
    from hydrosim.water.components import WaveComponents
    from hydrosim.water.radiation.retardation import Retardation
    from hydrosim.water.radiation.state_space import StateSpace

Memory = scenes.AutomaticRadiation | scenes.StateSpaceRadiation | scenes.ConvolutionRadiation


SAME_HEADING_TURNS = 1e-12  # of a turn: rounding


class Convolved(NamedTuple):
    """A group of DOFs (m,) of a database whose memory is computed by convolution, and the
    reason."""

    dofs: np.ndarray
    reason: str = ""


@dataclass(frozen=True)
class HydrodynamicGroup:
    """``bodies`` of a scene that share a database, in its order, and their ``dofs`` (n,) among
    those of the scene.

    ``database`` is about their centres of gravity, for all headings. ``read`` is the database as
    read. ``alone`` has, by name of a body, the part of that body while the others are held.
    Radiation in the time domain includes all couplings: the radiation model of the bodies,
    retardation functions, their state-space fits, the groups of DOFs whose memory is convolved
    (with the reason if the user did not ask for it), and the constant matrices ``added_mass`` and
    ``damping`` (n, n). These are A_inf and zero, except for constant radiation.

    A family of draughts (`compile.families`) has ``members``, a group for each ``draught``. Its
    own database and added mass are interpolated at the start. All other data are those of the
    nearest member.
    """

    bodies: tuple[scenes.Body, ...]
    dofs: np.ndarray
    database: HydroDatabase
    read: HydroDatabase
    alone: Mapping[str, HydroDatabase]
    radiation: scenes.Radiation | None
    memory: Retardation
    added_mass: np.ndarray
    damping: np.ndarray
    fits: tuple[StateSpace, ...] = ()
    convolved: tuple[Convolved, ...] = ()
    members: tuple[HydrodynamicGroup, ...] = ()
    draught: float = 0.0

    @property
    def free_dofs(self) -> np.ndarray:
        """DOFs of the database that can move."""
        return moving(self.bodies)

    def doubts(self, seas: Sequence[WaveComponents]) -> tuple[str, ...]:
        """Warnings from the checks of the database. Only data count that the scene uses in its
        ``seas``, one for each wave train. Raises InputError if a check refuses such data."""
        members = self.members or (self,)
        warning_sets = (
            databases.database_warnings(member.read, member.bodies, member.free_dofs, seas)
            for member in members
        )
        return tuple(dict.fromkeys(text for texts in warning_sets for text in texts))

    @property
    def names(self) -> list[str]:
        """Names of the bodies."""
        return [body.name for body in self.bodies]

    def with_states(self, tolerance: float) -> HydrodynamicGroup:
        """Group with states instead of a convolution, whose memory cannot be linearised."""
        bodies = tuple(with_states(body, tolerance) for body in self.bodies)
        chosen = radiation_of(bodies[0])
        if not isinstance(chosen, scenes.StateSpaceRadiation):
            return self
        if chosen == self.radiation and not self.convolved:
            return self
        fits = _fit_states(self, chosen.tolerance)
        members = tuple(member.with_states(tolerance) for member in self.members)
        group = replace(self, bodies=bodies, radiation=chosen, fits=fits, convolved=())
        return replace(group, members=members)

    def provenance(self) -> dict[str, str]:
        """Record entries of a run about the radiation of the group."""
        if self.members:
            provenances = [(member.draught, member.provenance()) for member in self.members]
            keys = dict.fromkeys(key for _, attributes in provenances for key in attributes)
            return {
                key: "; ".join(
                    f"at {draught:g} m: {attributes.get(key)}"
                    for draught, attributes in provenances
                )
                for key in keys
            }
        if self.has_given_coefficients:
            return {"database": self.read.source, "radiation": self._radiation_text()}
        provenance = {
            f"database_{key}": self.read.attributes.get(key)
            for key in (CHANGED_ATTRIBUTE, ACCEPTED_ATTRIBUTE)
        }
        return {
            "database": self.read.source,
            "database_checksum": self.read.checksum,
            **{key: text for key, text in provenance.items() if text},
            "radiation": self._radiation_text(),
            "retardation": str(self.memory.report),
        }

    @property
    def cut_lengths(self) -> tuple[str, ...]:
        """Messages about lengths of memory that were given and that the frequencies do not
        resolve."""
        if self.members:
            return tuple(text for member in self.members for text in member.cut_lengths)
        length = self.radiation.length if isinstance(self.radiation, Memory) else None
        resolved = radiation.resolved_length(self.read.frequency)
        if self.has_given_coefficients or length is None or length <= resolved:
            return ()
        keys = ", ".join(f"bodies.{name}.radiation.length" for name in self.names)
        return (
            f"{keys}: found {length:g} s, but the frequencies of {self.read.source} are"
            f" {np.pi / resolved:.3g} rad/s apart and resolve {resolved:.3g} s. The memory ends at"
            f" {self.memory.time[-1]:g} s. Remove `length`, or compute frequencies in between.",
        )

    @property
    def has_given_coefficients(self) -> bool:
        """Whether the coefficients are numbers of the case, not of a database."""
        return self.read.source == databases.SOURCE

    def _radiation_text(self) -> str:
        if self.has_given_coefficients:
            return "constant added mass and damping, as given"
        match self.radiation:
            case scenes.ConstantRadiation(period=period):
                return f"constant added mass and damping at {period:g} s"
            case None:
                return "none"
        model_text = (
            "; ".join([*self._states(), *self._convolutions()]) or "no motion radiates waves"
        )
        if isinstance(self.radiation, scenes.AutomaticRadiation):
            return f"{self.radiation.model}: {model_text}"
        return model_text

    def _states(self) -> Iterator[str]:
        for fit in self.fits:
            yield f"{fit.order} states for {dofs_of(fit.dofs, self.names)}, {fit.report}"

    def _convolutions(self) -> Iterator[str]:
        time = self.memory.time
        for dofs, reason in self.convolved:
            yield (
                f"convolution over the last {time[-1]:g} s, retardation functions every"
                f" {time[1]:g} s, for"
                f" {dofs_of(dofs, self.names)}" + (f": {reason}" if reason else "")
            )


def wet_groups(
    scene: scenes.Scene, seas: Sequence[WaveComponents], before: MemoryBefore
) -> list[HydrodynamicGroup]:
    """Hydrodynamics of all wet bodies without families of databases. A database of several bodies
    occurs once for all of them.

    Raises InputError if a database cannot be read or does not fit the scene, or if data that the
    scene uses in the ``seas`` cannot be right. ``before`` is the memory of the run to start from.
    """
    return [group_of(group, scene, seas, before) for group in databases.database_groups(scene)]


def group_of(
    group: databases.DatabaseGroup,
    scene: scenes.Scene,
    seas: Sequence[WaveComponents],
    before: MemoryBefore,
) -> HydrodynamicGroup:
    """Hydrodynamics of the bodies of one database."""
    read = group.database
    bodies = tuple(group.bodies)
    _check_members(read, bodies)
    _check_content(read, bodies)
    chosen = radiation_of(bodies[0])
    if isinstance(chosen, Memory):
        _check_table(read, bodies[0], chosen)
    whole = databases.suitable_database(
        read, bodies, moving(bodies), scene.environment, seas
    )  # before it is fitted
    centres = [body.centre_of_gravity for body in bodies]
    db = database.all_headings(database.move_reference(whole, centres))
    db = with_hulls(db, bodies, scene.environment)
    memory = (
        databases.constant_retardation(db)
        if read.source == databases.SOURCE
        else _choose_retardation(db, chosen)
    )
    wet = HydrodynamicGroup(
        bodies,
        np.concatenate([np.arange(6 * i, 6 * i + 6) for i in group.places]),
        db,
        read,
        {body.name: database.body_of(db, k) for k, body in enumerate(bodies)},
        chosen,
        memory,
        memory.added_mass_infinite,
        np.zeros_like(memory.added_mass_infinite),
    )
    return _add_memory(wet, before)


def _choose_retardation(db: HydroDatabase, chosen: scenes.Radiation | None) -> Retardation:
    table = chosen if isinstance(chosen, Memory) else scenes.ConvolutionRadiation()
    return radiation.retardation(
        db.frequency,
        db.added_mass,
        db.radiation_damping,
        length=radiation.memory_length(db.frequency, table.length, table.step),
        step=table.step,
        checksum=db.checksum,
    )


def _add_memory(wet: HydrodynamicGroup, before: MemoryBefore) -> HydrodynamicGroup:
    """Group with the data of its radiation model."""
    match wet.radiation:
        case scenes.ConstantRadiation(period=period):
            if wet.has_given_coefficients:
                return replace(wet, damping=wet.database.radiation_damping[0])
            added_mass, damping = _coefficients_at_period(wet.database, wet.bodies[0], period)
            return replace(wet, added_mass=added_mass, damping=damping)
        case scenes.StateSpaceRadiation(tolerance=tolerance):
            return _choose_fits(wet, _fit_states(wet, tolerance), before, radiation.is_tolerable)
        case scenes.ConvolutionRadiation():
            memory = radiation.groups_free_to_reduce(wet.memory, wet.free_dofs)
            return replace(wet, convolved=tuple(map(Convolved, memory)))
        case scenes.AutomaticRadiation(tolerance=tolerance):
            return _choose_fits(
                wet, _fit_states(wet, tolerance), before, radiation.is_within_tolerance
            )
    return wet


def _fit_states(wet: HydrodynamicGroup, tolerance: float) -> tuple[StateSpace, ...]:
    """State-space fits of all groups of DOFs of a database, with no more states than its bodies
    need."""
    db = wet.database
    fits = radiation.fit_state_space(
        db.checksum, wet.memory, db.frequency, wet.free_dofs, tolerance
    )
    return radiation.reduce_states(fits, db.checksum, wet.memory, db.frequency, floating_of(wet))


def floating_of(wet: HydrodynamicGroup) -> radiation.Floating:
    """The bodies without all restoring elements except the water."""
    parts = (part for body in wet.bodies for part in (body.mass * np.eye(3), body.inertia))
    inertia = block_diag(*parts)
    stiffness = wet.database.hydrostatic_stiffness
    return radiation.Floating(inertia, np.zeros_like(inertia) if stiffness is None else stiffness)


def _choose_fits(
    wet: HydrodynamicGroup,
    fits: Sequence[StateSpace],
    run: MemoryBefore,
    is_good: Callable[[StateSpace], bool],
) -> HydrodynamicGroup:
    """Group with those ``fits`` that are good, and convolutions for the others. It has the memory
    of the ``run`` that the scene starts from, if that run has one."""
    states = []
    convolved = []
    for fit in fits:
        names = [dofs_of([dof], wet.names) for dof in fit.dofs]
        if run.convolved.intersection(names):
            convolved.append(Convolved(fit.dofs, "as in the run that this one starts from"))
        elif is_good(fit) or run.states.intersection(names):
            states.append(fit)
        else:
            convolved.append(Convolved(fit.dofs, fit.report.refusal))
    return replace(wet, fits=tuple(states), convolved=tuple(convolved))


def moving(bodies: Sequence[scenes.Body]) -> np.ndarray:
    """DOFs of ``bodies``, six each along their headings, that can move. Surge and sway are locked
    along the earth's axes, so if either is free, both move on a rotated body."""
    return np.array(
        [6 * k + i for k, b in enumerate(bodies) for i in _moving_dofs(b)], dtype=np.int64
    )


def _moving_dofs(body: scenes.Body) -> list[int]:
    free = {DOFS.index(dof) for dof in body.dofs}
    turned = 5 in free or abs(np.sin(body.heading + body.position[5])) > SAME_HEADING_TURNS
    return sorted(free | {0, 1} if turned and free & {0, 1} else free)


def radiation_of(body: scenes.Body) -> scenes.Radiation | None:
    """Radiation model of the body with its settings."""
    return None if isinstance(body.radiation, scenes.NoRadiation) else body.radiation


def with_states(body: scenes.Body, tolerance: float) -> scenes.Body:
    """Body with states instead of a possible convolution, whose memory cannot be linearised."""
    chosen = radiation_of(body)
    if not isinstance(chosen, scenes.ConvolutionRadiation | scenes.AutomaticRadiation):
        return body
    states = scenes.StateSpaceRadiation(tolerance=tolerance, length=chosen.length, step=chosen.step)
    return replace(body, radiation=states)


def scene_with_states(
    scene: scenes.Scene, groups: Sequence[HydrodynamicGroup], tolerance: float
) -> tuple[scenes.Scene, list[HydrodynamicGroup]]:
    """Scene and its hydrodynamics with states in place of all convolutions. Fits are within the
    ``tolerance``, or as close as passive fits come."""
    bodies = tuple(with_states(body, tolerance) for body in scene.bodies)
    return replace(scene, bodies=bodies), [group.with_states(tolerance) for group in groups]


def _coefficients_at_period(
    db: HydroDatabase, body: scenes.Body, period: float
) -> tuple[np.ndarray, np.ndarray]:
    """A and B (n, n), interpolated linearly between the frequencies of the database, and
    reciprocal."""
    w = db.frequency
    at = 2.0 * np.pi / period
    if not w[0] <= at <= w[-1]:
        raise InputError(
            f"bodies.{body.name}.radiation.period: found {period:g} s; expected a period in the"
            f" range of {db.source}, {2.0 * np.pi / w[-1]:.3g} to {2.0 * np.pi / w[0]:.3g} s."
        )
    k = min(int(np.searchsorted(w, at, side="right")) - 1, w.size - 2)
    part = (at - w[k]) / (w[k + 1] - w[k])
    A, B = (
        (1.0 - part) * matrices[k] + part * matrices[k + 1]
        for matrices in (db.added_mass, db.radiation_damping)
    )
    return 0.5 * (A + A.T), 0.5 * (B + B.T)


def _check_members(db: HydroDatabase, bodies: Sequence[scenes.Body]) -> None:
    """Refuse a group that does not have all bodies of the database, or that mixes radiation
    models."""
    first = bodies[0]
    if [body.database_body for body in bodies] != list(range(1, db.bodies + 1)):
        body_names = ", ".join(f"{body.database_body} ({body.name})" for body in bodies)
        x, y = first.location
        raise InputError(
            f"bodies.{first.name}.database_body: {db.source} has {db.bodies} bodies, and those of"
            f" the scene at location [{x:g}, {y:g}], heading {np.degrees(first.heading):g} deg,"
            f" are {body_names}; expected each of 1 to {db.bodies} once. All have the location and"
            " heading of the database's frame. A body that does not move has `dofs: []`."
        )
    models = {body.radiation for body in bodies}
    if len(models) > 1:
        names = sorted({radiation.model for radiation in models})
        found_text = " and ".join(names) if len(names) > 1 else f"{names[0]} with other settings"
        raise InputError(
            f"bodies.{first.name}.radiation: found {found_text} for bodies of one database,"
            f" {db.source}; expected one model for all, because their radiated waves are coupled."
        )


def _check_content(db: HydroDatabase, bodies: Sequence[scenes.Body]) -> None:
    """Refuse a database whose checksum differs from the one in the case."""
    for body in bodies:
        if body.database_checksum not in (None, db.checksum):
            raise InputError(
                f"bodies.{body.name}.database_checksum: the content of {db.source} has changed:"
                f" found {db.checksum}; expected {body.database_checksum}. Use the database with"
                " that checksum, or remove the key."
            )


def _check_table(db: HydroDatabase, body: scenes.Body, table: Memory) -> None:
    """Refuse a table of retardation functions with a step too long for the shortest periods."""
    longest = np.pi / float(db.frequency[-1])
    if table.step > longest:
        raise InputError(
            f"bodies.{body.name}.radiation.step: found {table.step:g} s; expected at most"
            f" {longest:.3g} s, half the shortest wave period of {db.source}. A better choice is"
            f" {0.4 * longest:.3g} s, a fifth of that period."
        )


def each_database(groups: Sequence[HydrodynamicGroup]) -> Iterator[HydrodynamicGroup]:
    """All groups, with the members of families in place of the families."""
    for group in groups:
        yield from group.members or (group,)


def each_alone(groups: Sequence[HydrodynamicGroup]) -> dict[str, HydroDatabase]:
    """Own part of its database for each wet body, by name."""
    return {name: database for wet in groups for name, database in wet.alone.items()}


def uncoupled_resonance(
    body: scenes.Body, stiffness: np.ndarray, db: HydroDatabase | None
) -> UncoupledResonance:
    """Resonance of each DOF of a body by itself, along its axes at rest, with ``stiffness`` (6,)
    besides hydrostatics. ``db`` is the body's own part of its database, None if it is dry."""
    mass = np.array([body.mass] * 3 + list(np.diag(body.inertia)))
    if db is None:
        return UncoupledResonance(stiffness, mass)
    total = stiffness + np.diag(database.require_array(db, "hydrostatic_stiffness"))
    A = np.diagonal(db.added_mass, axis1=1, axis2=2)
    added = [
        _added_mass_in_resonance(db.frequency, a, m, k)
        for a, m, k in zip(A.T, mass, np.maximum(total, 0.0), strict=True)
    ]
    return UncoupledResonance(total, mass + added)


def _added_mass_in_resonance(
    frequency: np.ndarray, added: np.ndarray, mass: float, stiffness: float
) -> float:
    """a(w_n) with w_n^2 = k / (m + a(w_n)), by fixed-point iteration."""
    a = added[0]
    before = np.nan
    for _ in range(50):
        if a == before:
            break
        a, before = np.interp(np.sqrt(stiffness / (mass + a)), frequency, added), a
    return float(a)
