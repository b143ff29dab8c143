"""`solver: {method: automatic, tolerance: E}`: choice of the method and of its tolerance per step.

E is the largest error of a motion, relative to its range. Errors of whole runs were measured
against the tolerance r [1/s] of each step (benchmarks/README.md, "automatic"). The error with
dopri5 is below r / 5 in smooth scenes and in scenes whose contacts change now and then. The error
with esdirk4 is below 10 r. Therefore

    r = 5 E for dopri5, E / 10 for esdirk4,   both at most `ROUGH` where contacts or springs change,

because a coarser step misses whether a point sticks. Contacts that rattle make larger errors than
this rule says. Then the run itself reports its error (`studies.run.twin`).

An explicit method costs 6 evaluations for each step of the largest stable size h_s, however large E
is. An implicit method costs 40 evaluations for each step h_i = 4.3 r^(1/4) / w (both measured, w is
a frequency of the motions). Stiff contacts are closed for a fraction of the time, `CLOSED`. So
esdirk4 is chosen if

    6 CLOSED / h_s > 40 / h_i.

h_s is the smallest value over all combinations of contacts in `linear.stability`. w is the median
frequency of the vibrations with all contacts open, or 1 rad/s. Time, machine and sea do not count,
so all runs of a study use the same method. Methods of equal steps are never chosen, because the
accuracy of their step depends on the excitation, which the linearisation does not know.
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

# upper bound of the error of motions over the tolerance of each step [1/s]
OF_DOPRI5 = 0.2
OF_ESDIRK4 = 10.0
# largest tolerances of each step [1/s]: for smooth motions, and for either method if contacts
# change
SMOOTH = 1e-3
ROUGH = 1e-5
ROUGH_IMPLICIT = 1e-6
FINEST = 1e-12
ARM = 100.0  # m, for angles
# cost of a step in evaluations, and factor of the length of an implicit step
EXPLICIT = 6.0
IMPLICIT = 40.0
REACH = 4.3
CLOSED = 0.5
USUAL = 1.0  # rad/s, for motions without a period
SLOW = 1e-3  # rad/s: slower motions are no vibrations


def with_method(compiled: Compiled) -> Compiled:
    """Compiled scene with the method chosen if the scene leaves it to the program. Notes give the
    choice and its reason. A scene that starts from a run of the same accuracy keeps its method.
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
    """Error of motions, relative to their range, for which the tolerance of a ``solver`` is
    chosen."""
    return _ratio(solver.method) * solver.tolerance.relative


def _ratio(method: Method) -> float:
    """Error of motions over the tolerance of each step [s]."""
    return OF_ESDIRK4 if method == Method.ESDIRK4 else OF_DOPRI5


def _rate(method: Method, accuracy: float, changing: bool) -> float:
    """Tolerance of each step [1/s]; ``changing`` says that contacts or springs change."""
    rough = ROUGH_IMPLICIT if method == Method.ESDIRK4 else ROUGH
    return max(min(accuracy / _ratio(method), rough if changing else SMOOTH), FINEST)


@one_thread
def _chosen(compiled: Compiled, accuracy: float) -> tuple[Method, str]:
    """Chosen method, and the reason."""
    looked_at = combinations(compiled.scene, compiled.model, compiled.state)
    stable = smallest_step(looked_at, DOPRI5)
    rate = _rate(Method.ESDIRK4, accuracy, changing=True)
    implicit = REACH * rate**0.25 / _frequency(looked_at)
    stiff = EXPLICIT * CLOSED / stable > IMPLICIT / implicit
    if np.isinf(stable):
        why = "explicit steps of any length are stable"
    else:
        why = f"explicit steps above {stable:.2g} s are unstable,"
        why += f" implicit steps are {implicit:.2g} s"
    return (Method.ESDIRK4 if stiff else Method.DOPRI5), why


def _frequency(looked_at: Sequence[Combination]) -> float:
    """Median frequency of the vibrations with all contacts open [rad/s]."""
    values = looked_at[0].values.imag
    vibrating = values[values > SLOW]
    return float(np.median(vibrating)) if vibrating.size else USUAL


def _settings(compiled: Compiled, chosen: Method, accuracy: float) -> Solver:
    """Solver settings with the method ``chosen`` and its tolerances."""
    rate = _rate(chosen, accuracy, changing=len(new_modes(compiled.model)) > 0)
    tolerance = Tolerance(rate, rate, rate / ARM)
    solver = compiled.scene.solver
    return replace(solver, method=chosen, tolerance=tolerance, accuracy=accuracy)
