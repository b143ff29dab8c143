"""`solver: {method: automatic, tolerance: E}`: choice of the method and of its tolerance per step.

E is the largest error of a motion, relative to its range. Errors of whole runs were measured
against the tolerance r [1/s] of each step (benchmarks/answered.md, "automatic"). The error with
dopri5 is below r in smooth scenes and in scenes whose contacts change now and then. The error with
esdirk4 is below 10 r. Therefore

    r = E / g for dopri5, E / (10 g) for esdirk4,
    both at most `ROUGH` where contacts or springs change,

because a coarser step misses whether a point sticks. Contacts that rattle and motions that nothing
damps make larger errors than this rule says. Each run measures its error, and is made again with
smaller tolerances if it is too large (`hydrosim.run.error_estimate`).

g = 1 if all motions are restored, because errors then decay. Errors of a motion that nothing
restores, such as the yaw of a moored sphere, grow with the time T of the run: as T^1.5 to T^1.7 of
its range, measured beyond `MEASURED`. Then g = (T / `MEASURED`)^1.5, at least 1. Bodies whose
weight contacts carry count as restored, although they are free if all contacts are open.

An explicit method costs 6 evaluations for each step of the largest stable size h_s, however large E
is. An implicit method costs 40 evaluations for each step h_i = 4.3 r^(1/4) / w (both measured, w is
a frequency of the motions). Stiff contacts are closed for a fraction of the time,
`CONTACT_TIME_FRACTION`. So esdirk4 is chosen if

    6 CONTACT_TIME_FRACTION / h_s > 40 / h_i.

h_s is the smallest value over all combinations of contacts in `linear.stability`. w is the median
frequency of the vibrations with all contacts open, or 1 rad/s. Computing time, machine and sea do
not count, so all runs of a study use the same method. Methods of equal steps are never chosen,
because the accuracy of their step depends on the excitation, which the linearisation does not know.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.compile import restart
from hydrosim.elements import new_modes
from hydrosim.elements.kind import carried_weights
from hydrosim.integrate.methods import DOPRI5
from hydrosim.linear import stability
from hydrosim.multibody.kinematics import coordinate_owners
from hydrosim.scene import Method, Tolerance
from hydrosim.scene.scene import ACCURACY
from hydrosim.water.radiation.threads import one_thread

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hydrosim.compile.compiled import Compiled


# Upper bound of the error of motions over the tolerance of each step [1/s].
OF_DOPRI5 = 1.0
OF_ESDIRK4 = 10.0
# largest tolerances of each step [1/s]: for smooth motions, and for either method if contacts
# change
SMOOTH = 1e-3
ROUGH = 1e-5
MAX_IMPLICIT_CONTACT_TOLERANCE = 1e-6
MIN_TOLERANCE = 1e-12  # of a step, per second: rounding is larger than smaller ones
ARM = 100.0  # m, for angles
# cost of a step in evaluations, and factor of the length of an implicit step
EXPLICIT = 6.0
IMPLICIT = 40.0
REACH = 4.3
CONTACT_TIME_FRACTION = 0.5
DEFAULT_FREQUENCY = 1.0  # rad/s, for motions without a period
MIN_VIBRATION_FREQUENCY = 1e-3  # rad/s: slower motions are no vibrations
MEASURED = 600.0  # s: duration of the runs whose errors were measured
GROWS = 1.5  # power of the duration with which errors grow where nothing restores a motion


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
    elif compiled.derived.exact:
        chosen = Method.DOPRI5
        why = "propagated exactly"
    else:
        chosen, why = _choose_method(compiled, accuracy)
    solver = replace(scene.solver, method=chosen, accuracy=accuracy)
    text = f"{chosen} for an error of {accuracy:g} of the range of motions: {why}"
    notes = replace(compiled.notes, method=text)
    return with_tolerance(replace(compiled, scene=replace(scene, solver=solver), notes=notes))


def with_tolerance(compiled: Compiled) -> Compiled:
    """Compiled scene with the tolerances of its accuracy, if it has one. In the plane of a
    symmetry, where less may drift, they are chosen again; the method stays."""
    solver = compiled.scene.solver
    if solver.accuracy is None:
        return compiled
    changing = len(new_modes(compiled.model)) > 0
    rate = _step_tolerance_rate(solver.method, solver.accuracy / _error_growth(compiled), changing)
    solver = replace(solver, tolerance=Tolerance(rate, rate, rate / ARM))
    return replace(compiled, scene=replace(compiled.scene, solver=solver))


def _error_per_tolerance(method: Method) -> float:
    """Error of motions over the tolerance of each step [s]."""
    return OF_ESDIRK4 if method == Method.ESDIRK4 else OF_DOPRI5


def _step_tolerance_rate(method: Method, accuracy: float, changing: bool) -> float:
    """Tolerance of each step [1/s]; ``changing`` says that contacts or springs change."""
    rough = MAX_IMPLICIT_CONTACT_TOLERANCE if method == Method.ESDIRK4 else ROUGH
    return max(
        min(accuracy / _error_per_tolerance(method), rough if changing else SMOOTH), MIN_TOLERANCE
    )


@one_thread
def _choose_method(compiled: Compiled, accuracy: float) -> tuple[Method, str]:
    """Chosen method, and the reason."""
    looked_at = stability.combinations(compiled.scene, compiled.model, compiled.state)
    stable = stability.smallest_step(looked_at, DOPRI5)
    rate = _step_tolerance_rate(Method.ESDIRK4, accuracy, changing=True)
    implicit = REACH * rate**0.25 / _median_frequency(looked_at)
    stiff = EXPLICIT * CONTACT_TIME_FRACTION / stable > IMPLICIT / implicit
    if np.isinf(stable):
        why = "explicit steps of any length are stable"
    else:
        why = f"explicit steps above {stable:.2g} s are unstable,"
        why += f" implicit steps are {implicit:.2g} s"
    return (Method.ESDIRK4 if stiff else Method.DOPRI5), why


def _median_frequency(looked_at: Sequence[stability.Combination]) -> float:
    """Median frequency of the vibrations with all contacts open [rad/s]."""
    values = looked_at[0].values.imag
    vibrating = values[values > MIN_VIBRATION_FREQUENCY]
    return float(np.median(vibrating)) if vibrating.size else DEFAULT_FREQUENCY


def _error_growth(compiled: Compiled) -> float:
    """Factor on the errors of a run because it is long and nothing restores some motion."""
    longer = compiled.scene.duration / MEASURED
    if longer <= 1.0 or compiled.derived.exact or not _can_drift(compiled):
        return 1.0
    return longer**GROWS


@one_thread
def _can_drift(compiled: Compiled) -> bool:
    """True if nothing restores a motion within the run, except of bodies that contacts carry."""
    scene = compiled.scene
    held = carried_weights(scene).keys()
    for part in stability.open_contacts_combination(compiled.model, compiled.state).components:
        here = np.searchsorted(compiled.model.bodies.active, part.linear.active)
        bodies = {scene.bodies[b].name for b in coordinate_owners(compiled.model.bodies)[here]}
        slow = np.abs(part.values) * scene.duration < 1.0
        if slow.any() and not bodies <= held:
            return True
    return False
