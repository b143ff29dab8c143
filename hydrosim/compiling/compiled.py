"""`Compiled`: a scene as arrays, each part made once."""

from __future__ import annotations

from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

from hydrosim.compiling.memory_errors import MemoryErrors, memory_errors
from hydrosim.compiling.notes import Notes
from hydrosim.compiling.restart import begin
from hydrosim.integrate import Method, method_named

if TYPE_CHECKING:
    from hydrosim.compiling.facts import Facts
    from hydrosim.compiling.wet import WetGroup
    from hydrosim.linear.accuracy import Vibration
    from hydrosim.scene import Scene
    from hydrosim.stepping.dynamics import Model
    from hydrosim.stepping.state import State
    from hydrosim.waves.components import Components


@dataclass(frozen=True, eq=False)
class Compiled:
    """What `compile_scene` makes of a scene, and all that runs or analyses it takes.

    ``scene`` is the one that is solved: the run that it starts from is in memory, and what is zero
    by symmetry is out of it; ``whole`` is then the same in calm water in all degrees of freedom.
    ``vibrations`` are modes that the step does not resolve, which matter if a run excites them.
    ``wet`` are its databases, ``facts`` hold its ``model``, the constants, and what follows from
    it, ``state`` is that of the start, ``sea`` its waves as drawn (none in calm water), ``notes``
    what there is to say. Unpacks as model and state.
    """

    scene: Scene
    wet: tuple[WetGroup, ...]
    facts: Facts
    state: State
    sea: tuple[Components, ...] = ()
    notes: Notes = field(default_factory=Notes)
    whole: Compiled | None = None
    vibrations: tuple[Vibration, ...] = ()

    def __iter__(self) -> Iterator[Model | State]:
        return iter((self.model, self.state))

    @property
    def model(self) -> Model:
        """Its constants."""
        return self.facts.model

    @property
    def method(self) -> Method:
        """The method that steps it."""
        return method_named(self.scene.solver.method)

    @property
    def begin(self) -> float:
        """Time at which a run begins [s]."""
        return begin(self.scene)

    @cached_property
    def memory_errors(self) -> tuple[MemoryErrors, ...]:
        """What fits and cuts of the memory of radiation do to motions, see there."""
        return memory_errors(self.scene, self.wet, self.model, self.state, self.begin)

    def first_state(self) -> State:
        """The state of the start, for a run to carry on."""
        return deepcopy(self.state)
