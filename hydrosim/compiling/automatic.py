"""`solver: {method: automatic, tolerance: E}`: which method, and how exact in each step.

E is the largest error of a motion, of its range. It was measured how errors of whole runs go with
the tolerance r [1/s] of each step (benchmarks/README.md, "automatic"): dopri5 makes less than r / 5
in scenes that are smooth or change their contacts now and then, esdirk4 less than 10 r. So

    r = 5 E of dopri5, E / 10 of esdirk4,   both at most `ROUGH` where contacts or springs change,

because a step that is too rough misses what decides whether a point sticks. Contacts that rattle
make errors grow beyond this rule: then the run itself says how wrong it is (`studies.run.twin`).

An explicit method pays 6 evaluations for each step of the largest stable size h_s, however loose E
is; an implicit one 40 for each step h_i = 4.3 r^(1/4) / w (both measured, w a frequency of the
motions). Contacts that are stiff are closed for a part of the time, `CLOSED`. So esdirk4 is taken
where

    6 CLOSED / h_s > 40 / h_i.

h_s is the least over all combinations of contacts of `linear.stability`, w the median frequency of
what vibrates with all contacts open, or 1 rad/s. Neither time nor machine nor the sea counts, so
that all runs of a study take the same method. Methods of equal steps are never taken: how exact
a step is follows from what excites the scene, which its linearisation does not know.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.compiling import restart
from hydrosim.forces import new_modes
from hydrosim.integrate import DOPRI5
from hydrosim.linear.stability import combinations, smallest_step
from hydrosim.radiation.threads import one_thread
from hydrosim.scene import Method, Tolerance
from hydrosim.scene.solver import ACCURACY

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hydrosim.compiling.compiled import Compiled
    from hydrosim.linear.stability import Combination
    from hydrosim.scene import Solver

# error of motions over the tolerance of each step [1/s], at most
OF_DOPRI5 = 0.2
OF_ESDIRK4 = 10.0
# largest tolerances of each step [1/s]: of smooth motions, and by either where contacts change
SMOOTH = 1e-3
ROUGH = 1e-5
ROUGH_IMPLICIT = 1e-6
FINEST = 1e-12
ARM = 100.0  # m, of angles
# cost of a step in evaluations, and the length of an implicit one
EXPLICIT = 6.0
IMPLICIT = 40.0
REACH = 4.3
CLOSED = 0.5
USUAL = 1.0  # rad/s, of motions without a period
SLOW = 1e-3  # rad/s: slower is no vibration


def with_method(compiled: Compiled) -> Compiled:
    """What is compiled of a scene, its method chosen if that is left to the program; notes say
    which, and why. A scene that starts from a run with the same accuracy goes on with its method.
    """
    scene = compiled.scene
    if scene.solver.method != Method.AUTOMATIC:
        return compiled
    accuracy = scene.solver.accuracy or ACCURACY
    before = restart.method_before(scene, accuracy)
    if before is not None:
        chosen = Method(before)
        why = "as in the run that it starts from"
    elif compiled.facts.exact:
        chosen = Method.DOPRI5
        why = "propagated exactly"
    else:
        chosen, why = _chosen(compiled, accuracy)
    solver = _settings(compiled, chosen, accuracy)
    said = f"{chosen} for an error of {accuracy:g} of the range of motions: {why}"
    notes = replace(compiled.notes, method=said)
    return replace(compiled, scene=replace(scene, solver=solver), notes=notes)


def accuracy_of(solver: Solver) -> float:
    """The error of motions, of their range, for which the tolerance of a ``solver`` is chosen."""
    return _ratio(solver.method) * solver.tolerance.relative


def _ratio(method: Method) -> float:
    """Error of motions over the tolerance of each step [s]."""
    return OF_ESDIRK4 if method == Method.ESDIRK4 else OF_DOPRI5


def _rate(method: Method, accuracy: float, changing: bool) -> float:
    """The tolerance of each step [1/s], where contacts or springs are ``changing`` or are none."""
    rough = ROUGH_IMPLICIT if method == Method.ESDIRK4 else ROUGH
    return max(min(accuracy / _ratio(method), rough if changing else SMOOTH), FINEST)


@one_thread
def _chosen(compiled: Compiled, accuracy: float) -> tuple[Method, str]:
    """The method, and why."""
    looked_at = combinations(compiled.scene, compiled.model, compiled.state)
    stable = smallest_step(looked_at, DOPRI5)
    rate = _rate(Method.ESDIRK4, accuracy, changing=True)
    implicit = REACH * rate**0.25 / _frequency(looked_at)
    stiff = EXPLICIT * CLOSED / stable > IMPLICIT / implicit
    if np.isinf(stable):
        why = "explicit steps of any length are stable"
    else:
        why = f"steps above {stable:.2g} s are unstable if explicit,"
        why += f" implicit ones are {implicit:.2g} s"
    return (Method.ESDIRK4 if stiff else Method.DOPRI5), why


def _frequency(looked_at: Sequence[Combination]) -> float:
    """The median of what vibrates with all contacts open [rad/s]."""
    values = looked_at[0].values.imag
    vibrating = values[values > SLOW]
    return float(np.median(vibrating)) if vibrating.size else USUAL


def _settings(compiled: Compiled, chosen: Method, accuracy: float) -> Solver:
    """The solver with the method ``chosen``, and its tolerances."""
    rate = _rate(chosen, accuracy, changing=len(new_modes(compiled.model)) > 0)
    tolerance = Tolerance(rate, rate, rate / ARM)
    solver = compiled.scene.solver
    return replace(solver, method=chosen, tolerance=tolerance, accuracy=accuracy)
