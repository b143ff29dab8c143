"""What questions are asked about, and what they give."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.rigid.kinematics import Motion, place_bodies
from hydrosim.stepping.dynamics import Model, new_work

if TYPE_CHECKING:
    from hydrosim.compiling.facts import Facts
    from hydrosim.database.database import HydroDatabase
    from hydrosim.scene import Body, Scene
    from hydrosim.stepping.state import State
    from hydrosim.waves.components import Components


class Doubt(NamedTuple):
    """What was ``found`` at a ``key`` of the case, what would be ``usual``, and ``advice``, whole
    sentences; ``refused`` where nothing can float, or nobody would wait for it."""

    key: str
    found: str
    usual: str
    advice: str = ""
    refused: bool = False


@dataclass(frozen=True, eq=False)
class About:
    """A scene as compiled with its ``facts``, its ``sea`` as drawn, the ``motion`` of all
    bodies at the start, and the time of the ``end`` of the run [s]."""

    scene: Scene
    facts: Facts
    state: State
    sea: tuple[Components, ...]
    motion: Motion
    end: float

    def wet(self) -> Iterator[tuple[int, Body, HydroDatabase]]:
        """Wet bodies that may move: index, body, database."""
        for i, body in enumerate(self.scene.bodies):
            if body.name in self.facts.databases and body.dofs:
                yield i, body, self.facts.databases[body.name]

    @property
    def model(self) -> Model:
        """Its constants."""
        return self.facts.model

    def centre(self, b: int) -> np.ndarray:
        """Where the centre of gravity of body ``b`` is at the start (3,) [m]."""
        moved = self.motion.coordinates[6 * b : 6 * b + 3]
        return np.asarray(self.model.bodies.each["origin"][b] + moved)

    @property
    def index(self) -> dict[str, int]:
        """The numbers of the bodies, by their names."""
        return {body.name: i for i, body in enumerate(self.scene.bodies)}


def describe_start(
    scene: Scene, facts: Facts, state: State, sea: Sequence[Components], end: float
) -> About:
    """What questions are asked about, of a scene in its ``sea``, the ``state`` of its start, and
    the time of its ``end`` [s]."""
    n = facts.model.bodies.active.size
    motion = new_work(facts.model).motion
    y = state.y
    place_bodies(y[:n], y[n : 2 * n], facts.model.bodies, motion)
    return About(scene, facts, state, tuple(sea), motion, end)
