"""`method: automatic` keeps its tolerance: a run that misses it is made again.

The tolerance of steps is reduced by as much as the measured error is too large. All repeated runs
together cost at most `MAX_COST` times the first run, or `FREE_EVALUATIONS` if that is more. A run
that misses its accuracy even so says it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from hydrosim.compiling.automatic import MIN_TOLERANCE
from hydrosim.compiling.without_waves import add_waves, compile_calm
from hydrosim.radiation.threads import one_thread
from hydrosim.scene import Tolerance
from hydrosim.stepping.state import EVALUATIONS

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled
    from hydrosim.results.error_figures import ErrorEstimate
    from hydrosim.studies.run.course import RunInProgress

MAX_COST = 3.0
"""Cost of all repeated runs over that of the first."""
FREE_EVALUATIONS = 1_000_000
"""Evaluations that repeated runs may take in any case, a few seconds."""
SAFE_SHARE = 0.3
"""Measured error up to which a run is kept, over the accuracy: the true one may be larger by as
much."""
ERROR_MARGIN = 0.15
"""Error that a repeated run aims at, over the accuracy."""
MAX_TIGHTENING = 1e-4
"""Smallest factor on the tolerance from one run to the next."""

Solve = Callable[["Compiled"], "RunInProgress"]
"""Runs a compiled scene to its end."""
Measure = Callable[["RunInProgress"], "ErrorEstimate"]
"""Measures the error of a course."""


def repeat_until_accurate(
    course: RunInProgress, solve: Solve, measure: Measure
) -> tuple[RunInProgress, ErrorEstimate]:
    """The ``course`` and the estimate of its error if it keeps the accuracy of its scene, or if
    that has none; else those of a run that was made again."""
    estimate = measure(course)
    accuracy = course.compiled.scene.solver.accuracy
    first = int(course.run.counters[EVALUATIONS])
    allowed = max(MAX_COST * first, FREE_EVALUATIONS)
    spent = estimate.evaluations
    while accuracy is not None and estimate.relative > SAFE_SHARE * accuracy:
        factor = max(ERROR_MARGIN * accuracy / estimate.relative, MAX_TIGHTENING)
        cost = int(course.run.counters[EVALUATIONS])
        expected = cost * factor ** (-1.0 / (course.compiled.method.order - 1))
        finer = with_tighter_steps(course.compiled, factor)
        if finer is None or expected > allowed:
            break
        earlier = course
        course = solve(finer)
        if not course.complete:
            course = earlier
            break
        allowed -= int(course.run.counters[EVALUATIONS])
        spent += cost
        estimate = measure(course)
        spent += estimate.evaluations
        allowed -= estimate.evaluations
    return course, estimate._replace(evaluations=spent)


@one_thread
def with_tighter_steps(compiled: Compiled, factor: float) -> Compiled | None:
    """Scene with tolerances of steps that are smaller by a ``factor``, and the same databases and
    sea; None if rounding would exceed them."""
    scene = compiled.scene
    given = scene.solver.tolerance
    if factor * given.relative < MIN_TOLERANCE:
        return None
    tolerance = Tolerance(*(factor * x for x in (given.relative, given.position, given.angle)))
    scene = replace(scene, solver=replace(scene.solver, tolerance=tolerance))
    if not compiled.model.following.slow.any():
        return replace(compiled, scene=scene)
    # rows of waves that follow slow paths are as fine as the tolerance
    made = add_waves(compile_calm(scene, compiled.wet), scene, compiled.sea)
    return replace(compiled, scene=made.scene, facts=made.facts, state=made.state)
