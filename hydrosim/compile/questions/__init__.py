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
    Question.ANGLES: starts.ask_about_angles,
    Question.SPEED: starts.ask_about_speed,
    Question.OVERLAP: starts.ask_about_overlap,
    Question.PLANE: starts.ask_about_planes,
    Question.POINTS: elements.ask_about_contact_points,
    Question.LINES: lambda about: chain(
        starts.ask_about_line_starts(about), attachments.ask_about_line_routes(about)
    ),
    Question.FALL: starts.ask_about_fall,
    Question.MASS: bodies.ask_about_mass,
    Question.INERTIA: bodies.ask_about_inertia,
    Question.TRIM: bodies.ask_about_trim,
    Question.STABILITY: bodies.ask_about_stability,
    Question.PERIODS: bodies.ask_about_natural_periods,
    Question.LIFT: bodies.ask_about_lift,
    Question.SOFTNESS: elements.ask_about_softness,
    Question.FRICTION: elements.ask_about_friction,
    Question.DAMPING: elements.ask_about_damping,
    Question.WATER: waters.ask_about_water,
    Question.STREAMS: lambda about: chain(
        waters.ask_about_streams(about), loads.ask_about_coefficients(about)
    ),
    Question.SHIELDING: bodies.ask_about_shielding,
    Question.SLOSHING: waters.ask_about_sloshing,
    Question.WAVES: waters.ask_about_waves,
    Question.STEEPNESS: waters.ask_about_steepness,
    Question.RAMP: waters.ask_about_ramp,
    Question.STEP: waters.ask_about_step,
    Question.RANGE: waters.ask_about_ranges,
    Question.CAPACITY: loads.ask_about_capacities,
    Question.AXES: attachments.ask_about_axes,
    Question.HULL: bodies.ask_about_hulls,
    Question.BENDING: elements.ask_about_bending,
    Question.FILES: elements.ask_about_files,
}


def query_messages(about: SceneContext) -> list[str]:
    """Messages of all doubts about a scene except accepted ones. Raises InputError for doubts that
    are refusals."""
    queries = list(_all_queries(about))
    refused = [_query_message(doubt, question) for doubt, question in queries if doubt.refused]
    if refused:
        raise InputError("\n".join(refused))
    return [_query_message(doubt, question) for doubt, question in queries]


def describe_doubts(about: SceneContext, apart: Collection[Question]) -> list[str]:
    """Messages of all doubts except accepted ones and those of the questions ``apart``. What would
    refuse a run is among them."""
    return [_query_message(doubt, question) for doubt, question in _all_queries(about, apart)]


def _all_queries(
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
