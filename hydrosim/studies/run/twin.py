"""How wrong is a run? A twin with finer steps, or a tighter tolerance, tells.

Where contacts and springs change, errors are not those of one smooth vibration: each change adds
its own, and impacts, and blocks that rattle on their corners, can make each grow by a factor every
time they happen (Guckenheimer & Holmes 1983, 2.4). So the two runs are compared. Errors go with the
order p of the method, which makes of the distance d of the two that of the run from the truth,
d / (1 - r^p), for a twin whose steps are r times as long (Richardson 1911). Where finer steps give
another motion each time, they are no remedy, and statistics may hold all the same (Lorenz 1963).

A twin is run only where contacts and springs change often. It begins with the run's own state at
the last record before the first change. A short run is followed to its end. In a longer one half of
the evaluations that are granted, `SHARE` of the run's own or `FIRST`, goes into the beginning. The
other half is spent at places among the later changes. There a path that begins near the run is
followed for a while, and its distance is handed on to the next place (Benettin et al. 1980, see
`hydrosim.studies.run.paths`). If the error at the beginning, grown by so much, would matter, the
twin goes on to the end, or until the error is `LOST` of the range of a motion: two runs of a
chaotic scene may be no further apart by the end. A convolution remembers what no record holds: then
all that is granted goes into the beginning. The attribute `twin_evaluations` of a result says what
it has cost, beside `solver_evaluations`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import ceil
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.compiling.automatic import accuracy_of
from hydrosim.compiling.calm import compile_calm, in_waves
from hydrosim.compiling.facts import facts_of
from hydrosim.radiation.threads import one_thread
from hydrosim.scene import Scene, Solver, Tolerance
from hydrosim.stepping.state import EVALUATIONS, EVENTS, Run
from hydrosim.studies.run.paths import Growth, Path, growth, recorded

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled

WRONG = 5e-4  # of the range of a motion: what is told; half of what matters, being estimated
"""Where the method is chosen for an accuracy, that is told which is beyond it."""
LOST = 0.3  # of the range of a motion: nothing of its path is left
STILL = 1e-6  # m, rad: a smaller range is none
SMALL = (1e-3, 1e-5)  # m, rad: nor is this of a method that is chosen for an accuracy
ASKED = 10.0  # tolerances: an error that adaptive methods may make, however small a motion is
# steps of the twin for one of the run, and tolerances
FINER = 1.4
TIGHTER = 4.0
LEAST = 1e-12  # of a tolerance
OFTEN = 20  # events in a run: with fewer it is what it is in any smooth motion
# evaluations of a twin's equation that are granted: so many, or this share of the run's own
FIRST = 60_000
SHARE = 0.15
LOCAL = 1e-7  # of the range of a motion: an error that steps make in any case


class Estimate(NamedTuple):
    """What to warn of, and the evaluations that it took to know."""

    warnings: tuple[str, ...] = ()
    evaluations: int = 0


def estimated(compiled: Compiled, run: Run) -> Estimate:
    """By how much a ``run`` of the compiled scene, which has ended, is not that of finer steps."""
    if run.counters[EVENTS] < OFTEN:
        return Estimate()
    finer = _finer(compiled)
    ranges = _ranges(run, compiled.scene.solver)
    share = _share(compiled, finer)
    twin, spent = _twin(run, compiled, finer, ranges * share)
    wrong = twin.apart(ranges) / share
    time = recorded(run, "time")[twin.begin : twin.end + 1]
    warnings = tuple(_doubts(compiled.scene, finer.scene, time, wrong))
    return Estimate(warnings, spent + twin.evaluations)


def _doubts(scene: Scene, finer: Scene, time: np.ndarray, wrong: np.ndarray) -> Iterator[str]:
    """What to say of motions that are ``wrong`` by so much of their range, (nt, nb)."""
    limit = _limit(scene.solver)
    far = np.flatnonzero(wrong.max(axis=1) > limit)
    if far.size:
        worst = wrong.max(axis=0)
        name = scene.bodies[int(worst.argmax())].name
        yield (
            f"the motion of {name} may be wrong by {min(worst.max(), 1.0):.1g} of its range by"
            f" {time[-1]:.4g} s, and by more than {limit:g} from {time[far[0]]:.4g} s on: with"
            f" {_said(finer.solver)} it is another. Choose that or less, as long as this"
            " figure shrinks with it. Where it does not, contacts part what begins alike: take"
            " statistics over runs that begin a little apart, or give the contacts more damping or"
            " friction."
        )


def _twin(run: Run, compiled: Compiled, finer: Compiled, ranges: np.ndarray) -> tuple[Path, int]:
    """A twin, as far as it is worth it; the evaluations that other paths took to know that."""
    changes = recorded(run, "events")
    last = len(changes) - 1
    remembers = run.state.history.grid.shape[1] > 0
    before = int(np.flatnonzero(changes == changes[0])[-1])
    twin = Path(run, finer, 0 if remembers else before)
    evaluations = int(run.counters[EVALUATIONS])
    granted = max(FIRST, SHARE * evaluations)
    needed = FINER * evaluations * (last - twin.begin) / last
    at_once = remembers or needed <= granted
    twin.follow(granted if at_once else granted / 2, last)
    if twin.end == last or twin.failed:
        return twin, 0
    grown = Growth() if remembers else growth(run, compiled, twin.end, granted / 2)
    worst = twin.apart(ranges).max()
    at_end = worst * (last - twin.begin) / max(twin.end - twin.begin, 1)
    if max(at_end, max(worst, LOCAL) * grown.factor) > _limit(compiled.scene.solver):
        _follow(twin, last, ranges)
    return twin, grown.evaluations


def _follow(twin: Path, last: int, ranges: np.ndarray) -> None:
    """Go on to the record ``last``, or until nothing is left of the path of a motion."""
    while twin.end < last and not twin.failed and twin.apart(ranges).max() < LOST:
        twin.follow(2 * twin.evaluations, last)


@one_thread
def _finer(compiled: Compiled) -> Compiled:
    """The scene with finer steps or a tighter tolerance, with the same databases and sea."""
    scene = replace(compiled.scene, solver=_finer_solver(compiled.scene))
    calm = compile_calm(scene, compiled.wet)
    ours = compiled.model
    if ours.following.slow.any():  # paths are taken anew every so many steps
        return in_waves(calm, scene, compiled.sea)
    model = calm.model._replace(waves=ours.waves, following=ours.following)
    return replace(calm, facts=facts_of(scene, calm.wet, model))


def _finer_solver(scene: Scene) -> Solver:
    solver = scene.solver
    given = scene.solver.tolerance
    if not solver.method.adapts:
        steps = ceil(FINER * scene.output_step / solver.step)
        return replace(solver, step=scene.output_step / steps)
    each = (max(x / TIGHTER, LEAST) for x in (given.relative, given.position, given.angle))
    return replace(solver, tolerance=Tolerance(*each))


def _share(compiled: Compiled, finer: Compiled) -> float:
    """How much of the error of a run is the distance to its finer twin."""
    if compiled.method.adapts:
        return 1.0 - 1.0 / TIGHTER
    shorter = finer.scene.solver.step / compiled.scene.solver.step
    return 1.0 - shorter**compiled.method.order


def _ranges(run: Run, solver: Solver) -> np.ndarray:
    """What errors are held to, (nb, 2): the range of each body's places [m], and of its angles
    [rad], but no less than is worth it."""
    least = np.full(2, STILL)
    if solver.accuracy is not None:
        least = np.array(SMALL)
    elif solver.method.adapts:
        asked = np.array([solver.tolerance.position, solver.tolerance.angle])
        least = np.maximum(least, asked * ASKED / WRONG)
    motion = recorded(run, "coordinates")
    return np.maximum(np.ptp(motion, axis=0).reshape(-1, 2, 3).max(axis=2), least)


def _limit(solver: Solver) -> float:
    """The error of motions, of their range, beyond which a run is told to be wrong."""
    return WRONG if solver.accuracy is None else solver.accuracy


def _said(solver: Solver) -> str:
    if solver.accuracy is not None:
        return f"solver.tolerance: {accuracy_of(solver):.2g}"
    if solver.method.adapts:
        return f"solver.tolerance.relative: {solver.tolerance.relative:.2g} (and others alike)"
    return f"solver.step: {solver.step:.3g} s"
