"""Subject and answer of questions about a scene."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.rigid.kinematics import Motion
from hydrosim.scene.trees import arrangement
from hydrosim.stepping.dynamics import Model, motion_at

if TYPE_CHECKING:
    from hydrosim.compiling.derived import Facts
    from hydrosim.database.database import HydroDatabase
    from hydrosim.scene import Body, Scene
    from hydrosim.stepping.state import State
    from hydrosim.waves.components import WaveComponents

MOST_DIGITS = 15  # that a number of double precision has


class Query(NamedTuple):
    """Value ``found`` at a ``key`` of the case, the ``usual`` values, and ``advice`` (whole
    sentences). ``refused`` if the body cannot float, or if the run would take too long."""

    key: str
    found: str
    usual: str
    advice: str = ""
    refused: bool = False


def text_beyond(value: float, limit: float, form: str = ".3g") -> str:
    """A ``value`` beyond a ``limit`` in a ``form`` such as ".3g" or ".0%", with as many more digits
    as show that they differ."""
    digits, kind = int(form[1:-1]), form[-1]
    while digits < MOST_DIGITS and f"{value:.{digits}{kind}}" == f"{limit:.{digits}{kind}}":
        digits += 1
    return f"{value:.{digits}{kind}}"


def text_outside(value: float, low: float, high: float, form: str = ".3g") -> str:
    """A ``value`` below ``low`` or above ``high``, as `text_beyond` shows it."""
    return text_beyond(value, low if value < low else high, form)


@dataclass(frozen=True, eq=False)
class SceneContext:
    """Subject of all questions: a scene as compiled with its ``facts``, its ``sea`` as drawn, the
    ``motion`` of all bodies at the start, and the time of the ``end`` of the run [s]."""

    scene: Scene
    facts: Facts
    state: State
    sea: tuple[WaveComponents, ...]
    motion: Motion
    end: float

    def floating_bodies(self) -> Iterator[tuple[int, Body, HydroDatabase]]:
        """Wet bodies that can move: index, body, database."""
        for i, body in enumerate(self.scene.bodies):
            if body.name in self.facts.databases and body.dofs:
                yield i, body, self.facts.databases[body.name]

    def afloat(self) -> Iterator[tuple[int, Body, HydroDatabase]]:
        """`floating_bodies` bodies that no joint carries."""
        carried = arrangement(self.scene).children
        return ((i, body, db) for i, body, db in self.floating_bodies() if body.name not in carried)

    @property
    def model(self) -> Model:
        """Its constants."""
        return self.facts.model

    def centre(self, b: int) -> np.ndarray:
        """Position of the centre of gravity of body ``b`` at the start (3,) [m]."""
        moved = self.motion.coordinates[6 * b : 6 * b + 3]
        return np.asarray(self.model.bodies.each["origin"][b] + moved)

    @property
    def index(self) -> dict[str, int]:
        """Indices of the bodies, by name."""
        return {body.name: i for i, body in enumerate(self.scene.bodies)}


def describe_start(
    scene: Scene, facts: Facts, state: State, sea: Sequence[WaveComponents], end: float
) -> SceneContext:
    """Subject of the questions, from a scene in its ``sea``, the ``state`` at the start, and the
    time of its ``end`` [s]."""
    motion = motion_at(facts.model, state.y)
    return SceneContext(scene, facts, state, tuple(sea), motion, end)
