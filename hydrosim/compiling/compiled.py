"""`Compiled`: a scene as arrays."""

from __future__ import annotations

from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass, field
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING

from hydrosim.compiling.memory_errors import MemoryErrors, memory_errors
from hydrosim.compiling.notes import Notes
from hydrosim.compiling.restart import start_time
from hydrosim.integrate import IntegrationMethod, method_named

if TYPE_CHECKING:
    from hydrosim.compiling.derived import Facts
    from hydrosim.compiling.hydrodynamic_groups import HydrodynamicGroup
    from hydrosim.linear.stability import Vibration
    from hydrosim.scene import Scene
    from hydrosim.stepping.dynamics import Model
    from hydrosim.stepping.state import State
    from hydrosim.waves.components import WaveComponents


@dataclass(frozen=True, eq=False)
class Compiled:
    """Compiled scene, with all data that a run or an analysis needs.

    ``scene`` is the scene that is solved: the run that it starts from is in memory, and motions
    that are zero by symmetry are left out. ``whole`` is the same scene in calm water in all degrees
    of freedom. ``vibrations`` are modes that the step does not resolve; they matter if a run
    excites them. ``wet`` are the databases of the scene. ``facts`` hold its ``model`` (the
    constants) and derived data. ``state`` is the state at the start. ``sea`` holds its drawn waves
    (empty in calm water). ``notes`` are messages. ``stable_step`` is the largest stable step [s] of
    a method with fixed steps, if it is known, and ``step_warnings`` are about a step above it. It
    unpacks as model and state.
    """

    scene: Scene
    wet: tuple[HydrodynamicGroup, ...]
    facts: Facts
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
        return self.facts.model

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
