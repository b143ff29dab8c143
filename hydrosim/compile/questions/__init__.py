"""Questions about a scene: values that are possible, but probably mistakes.

A question is a function (one or more for each `scene.Question`) from a subject to its doubts;
`QUESTIONS` has them all. A doubt is a warning that names the key, the value found and the usual
values. It is a refusal if the body cannot float. Users who mean the value write the name of the
question under ``accept`` in the case file, and are not asked again.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from itertools import chain
from typing import TYPE_CHECKING

from hydrosim.compile.questions import attachments, bodies, elements, loads, starts, waters
from hydrosim.errors import InputError
from hydrosim.scene import Question

if TYPE_CHECKING:
    from hydrosim.compile.questions.query import Query, SceneContext

QUESTIONS: Mapping[Question, Callable[[SceneContext], Iterator[Query]]] = {
    Question.ANGLES: starts.angles,
    Question.SPEED: starts.speed,
    Question.OVERLAP: starts.overlap,
    Question.PLANE: starts.plane,
    Question.POINTS: elements.points,
    Question.LINES: lambda about: chain(starts.lines(about), attachments.routes(about)),
    Question.FALL: starts.fall,
    Question.MASS: bodies.mass,
    Question.INERTIA: bodies.inertia,
    Question.TRIM: bodies.trim,
    Question.STABILITY: bodies.stability,
    Question.PERIODS: bodies.periods,
    Question.LIFT: bodies.lift,
    Question.SOFTNESS: elements.softness,
    Question.FRICTION: elements.friction,
    Question.DAMPING: elements.damping,
    Question.WATER: waters.water,
    Question.STREAMS: lambda about: chain(waters.streams(about), loads.coefficients(about)),
    Question.SHIELDING: bodies.shielding,
    Question.SLOSHING: waters.sloshing,
    Question.WAVES: waters.waves,
    Question.STEEPNESS: waters.steepness,
    Question.RAMP: waters.ramp,
    Question.STEP: waters.step,
    Question.RANGE: waters.ranges,
    Question.CAPACITY: loads.capacities,
    Question.AXES: attachments.axes,
    Question.HULL: bodies.hulls,
    Question.BENDING: elements.bending,
    Question.FILES: elements.files,
}


def query_messages(about: SceneContext) -> list[str]:
    """Messages of all doubts about a scene except accepted ones. Raises InputError for doubts that
    are refusals."""
    found = list(_queries(about))
    refused = [_query_message(doubt, question) for doubt, question in found if doubt.refused]
    if refused:
        raise InputError("\n".join(refused))
    return [_query_message(doubt, question) for doubt, question in found]


def describe_doubts(about: SceneContext, apart: Collection[Question]) -> list[str]:
    """Messages of all doubts except accepted ones and those of the questions ``apart``. What would
    refuse a run is among them."""
    return [_query_message(doubt, question) for doubt, question in _queries(about, apart)]


def _queries(
    about: SceneContext, apart: Collection[Question] = frozenset()
) -> Iterator[tuple[Query, Question]]:
    for question, ask in QUESTIONS.items():
        if question not in about.scene.accept and question not in apart:
            yield from ((doubt, question) for doubt in ask(about))


def _query_message(doubt: Query, question: Question) -> str:
    return (
        f"{doubt.key}: found {doubt.found}; {doubt.usual}."
        f" {doubt.advice}{' ' if doubt.advice else ''}If this is intended, accept:"
        f" [{question}]."
    )
