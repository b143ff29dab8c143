"""`Compiled`: a scene as arrays, with notes and derived data."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf, nan
from typing import TYPE_CHECKING

from hydrosim.compile.hydrodynamic_groups import HydrodynamicGroup, each_alone
from hydrosim.compile.restart import initial_headings, start_time
from hydrosim.compile.sizes import MemoryErrors, memory_errors
from hydrosim.integrate.methods import IntegrationMethod, method_named
from hydrosim.integrate.names import StateLayout, force_names, state_layout
from hydrosim.linear.linearise import nonlinearities
from hydrosim.scene import LinearScenes, Scene, WaveForces
from hydrosim.water.displaced_loads import met_by_waves

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hydrosim.database.database import HydroDatabase
    from hydrosim.integrate.dynamics import Model
    from hydrosim.integrate.state import State
    from hydrosim.linear.stability import Vibration
    from hydrosim.water.components import WaveComponents

# `Notes`: messages and data from compiling a scene.


@dataclass(frozen=True)
class Notes:
    """Messages and data from compiling: ``skipped`` parts; ``warnings``; ``records`` that are
    interpolated; the ``seas``, a line for each wave train; the ``meetings`` of bodies with waves
    and current; figures of the ``streams``, wind and current. ``symmetry`` is a text on the
    use of symmetry, and ``zero`` has the names of coordinates that are zero by it. ``memory`` holds
    the errors of the radiation memory. ``radiation_error`` is the largest change of motions by
    them, NaN if unknown. ``method`` is the chosen method, and the reason. ``drag`` is about
    drag and friction of lines.
    """

    skipped: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    records: tuple[str, ...] = ()
    seas: tuple[str, ...] = ()
    meetings: tuple[str, ...] = ()
    streams: tuple[str, ...] = ()
    symmetry: str = ""
    zero: tuple[str, ...] = ()
    memory: tuple[str, ...] = ()
    radiation_error: float = nan
    method: str = ""
    drag: tuple[str, ...] = ()

    def of_memory(self, errors: Iterable[MemoryErrors]) -> Notes:
        """Notes with messages on the ``errors`` of the radiation memory."""
        errors = tuple(errors)
        largest = max((error.largest for error in errors), default=nan)
        notes = replace(self, memory=tuple(map(str, errors)), radiation_error=largest)
        return notes.with_warnings(text for error in errors for text in error.warnings())

    def with_warnings(self, more: Iterable[str]) -> Notes:
        """Notes with ``more`` warnings."""
        return replace(self, warnings=(*self.warnings, *more))


# `DerivedData`: derived data of a compiled scene.


@dataclass(frozen=True, eq=False)
class DerivedData:
    """Data derived from a scene, its databases and its ``model``.

    ``rows`` are the names of the rows of forces, ``layout`` is the layout of y. ``databases`` has,
    by name of a wet body, its own part of its database. ``met`` has, by name of a body, the
    position where waves act. ``headings`` are the headings of all bodies at the start of the first
    run [rad]. ``nonlinear`` names the parts that are not linear. An ``exact`` run is propagated,
    not stepped.
    """

    model: Model
    rows: tuple[str, ...]
    layout: StateLayout
    databases: Mapping[str, HydroDatabase]
    met: Mapping[str, WaveForces]
    headings: tuple[float, ...]
    nonlinear: tuple[str, ...]
    exact: bool


def derive_data(scene: Scene, wet: Sequence[HydrodynamicGroup], model: Model) -> DerivedData:
    """Derived data of a scene of `open_start`. Raises InputError if waves cannot act on a body as
    asked."""
    databases = each_alone(wet)
    nonlinear = tuple(nonlinearities(scene, model))
    met = met_by_waves(scene, databases)
    return DerivedData(
        model=model,
        rows=force_names(scene),
        layout=state_layout(scene, model, met),
        databases=databases,
        met=met,
        headings=tuple(initial_headings(scene)),
        nonlinear=nonlinear,
        exact=not nonlinear and scene.solver.linear == LinearScenes.EXACT,
    )


def solution(scene: Scene, derived: DerivedData) -> str:
    """Text on how the motions of a scene are computed."""
    if scene.solver.linear == LinearScenes.STEP:
        return "stepped, as solver.linear asks"
    reasons = "; ".join(derived.nonlinear)
    return f"stepped, not linear: {reasons}" if reasons else "propagated exactly: linear"


@dataclass(frozen=True, eq=False)
class Compiled:
    """Compiled scene, with all data that a run or an analysis needs.

    ``scene`` is the scene that is solved: the run that it starts from is in memory, and motions
    that are zero by symmetry are left out. ``whole`` is the same scene in calm water in all degrees
    of freedom. ``vibrations`` are modes that the step does not resolve; they matter if a run
    excites them. ``wet`` are the databases of the scene. ``derived`` holds its ``model`` (the
    constants) and derived data. ``state`` is the state at the start. ``sea`` holds its drawn waves
    (empty in calm water). ``notes`` are messages. ``stable_step`` is the largest stable step [s] of
    a method with fixed steps, if it is known, and ``step_warnings`` are about a step above it. It
    unpacks as model and state.
    """

    scene: Scene
    wet: tuple[HydrodynamicGroup, ...]
    derived: DerivedData
    state: State
    sea: tuple[WaveComponents, ...] = ()
    notes: Notes = field(default_factory=Notes)
    whole: Compiled | None = None
    vibrations: tuple[Vibration, ...] = ()
    stable_step: float = inf
    step_warnings: tuple[str, ...] = ()

    def __iter__(self) -> Iterator[Model | State]:
        return iter((self.model, self.state))

    @property
    def model(self) -> Model:
        """Its constants."""
        return self.derived.model

    @property
    def method(self) -> IntegrationMethod:
        """Integration method."""
        return method_named(self.scene.solver.method)

    @property
    def begin(self) -> float:
        """Time at which a run begins [s]."""
        return start_time(self.scene)

    @cached_property
    def memory_errors(self) -> tuple[MemoryErrors, ...]:
        """Changes of motions by fits and cuts of the radiation memory, see `memory_errors`."""
        return memory_errors(self.scene, self.wet, self.model, self.state, self.begin)

    def first_state(self) -> State:
        """Copy of the state at the start, which a run may change."""
        return deepcopy(self.state)
