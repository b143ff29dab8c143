"""Error of a run, estimated by a twin run with finer steps or a tighter tolerance.

If contacts and springs change, errors are not those of one smooth vibration. Each change adds an
error. Impacts, and blocks that rattle on their corners, can multiply errors each time they happen
(Guckenheimer & Holmes 1983, 2.4). So the run is compared with a twin. For a method of order p, and
a twin whose steps are r times as long, the error of the run is d / (1 - r^p) with the distance d of
the two (Richardson 1911). If finer steps give a different motion each time, they are no remedy, but
statistics may still hold (Lorenz 1963).

If the method is chosen for an accuracy, errors also add up in a long run where nothing restores a
motion (`compiling.automatic`). Such a run without many changes is compared with a looser twin,
which costs half as much. Its tolerance is `LOOSER` times as large. The error of the run is then
d / (`LOOSER` - 1), because errors of adaptive methods are at least proportional to the tolerance.

Other twins are run only if contacts and springs change often. Such a twin begins with the state of
the run at the last record with all states before the first change. In a short run, it continues to
the end. In a longer run, a budget of evaluations is granted: `SHARE` of those of the run, or
`FIRST`. One half is spent on the beginning. The other half is spent at places among the later
changes. There, a path that begins near the run is followed for some time, and its distance is
handed on to the next place (Benettin et al. 1980, see `hydrosim.studies.run.paths`). If the error
at the beginning times this growth would matter, the twin continues to the end, or until the error
is `LOST` of the range of a motion. The latter is needed because two runs of a chaotic scene may
happen to be close at the end. The memory of a convolution is not in the record; then all granted
evaluations are spent on the beginning. The attribute `twin_evaluations` of a result gives the cost,
beside `solver_evaluations`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import ceil, inf
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.compiling.automatic import accuracy_of
from hydrosim.compiling.calm import compile_calm, in_waves
from hydrosim.compiling.facts import facts_of
from hydrosim.forces import in_same_weather
from hydrosim.radiation.threads import one_thread
from hydrosim.scene import Scene, Solver, Tolerance
from hydrosim.stepping.record import with_states
from hydrosim.stepping.state import EVALUATIONS, EVENTS, Run
from hydrosim.studies.run.paths import Growth, Path, growth, recorded

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled

# of the range of a motion: reported errors are above; half of an error that matters, because it is
# an estimate
WRONG = 5e-4
"""If the method is chosen for an accuracy, errors above that accuracy are reported."""
LOST = 0.3  # of the range of a motion: the path is lost
STILL = 1e-6  # m, rad: a smaller range counts as none
SMALL = (1e-3, 1e-5)  # m, rad: the same for a method that is chosen for an accuracy
ASKED = 10.0  # tolerances: error that adaptive methods may make, however small a motion is
# number of twin steps per step of the run, and ratio of tolerances
FINER = 1.4
TIGHTER = 4.0
LOOSER = 16.0  # ratio of tolerances, for motions that nothing restores
LEAST = 1e-12  # of a tolerance
OFTEN = 20  # events in a run: with fewer events, errors are those of a smooth motion
# evaluations granted to a twin: this number, or this fraction of those of the run
FIRST = 60_000
SHARE = 0.15
LOCAL = 1e-7  # of the range of a motion: error that steps make in any case


class Estimate(NamedTuple):
    """Warnings, and the evaluations spent on them."""

    warnings: tuple[str, ...] = ()
    evaluations: int = 0


def estimated(compiled: Compiled, run: Run) -> Estimate:
    """Error of a ``run`` of the compiled scene, which has ended, against finer steps."""
    if run.counters[EVENTS] < OFTEN:
        return _of_drift(compiled, run) if compiled.growth > 1.0 else Estimate()
    finer = _finer(compiled)
    ranges = _ranges(run, compiled.scene.solver)
    share = _share(compiled, finer)
    twin, spent = _twin(run, compiled, finer, ranges * share)
    wrong = twin.apart(ranges) / share
    time = recorded(run, "time")[twin.begin : twin.end + 1]
    solver = finer.scene.solver
    remedy = (
        f" A run with {_said(solver, compiled.growth)} gives a different motion. Choose that value"
        " or a smaller one, as long as this error decreases with it. If it never does, the"
        " contact is chaotic: use statistics over several runs with slightly different"
        " starts, or give the contacts more damping or friction."
    )
    warnings = tuple(doubt + remedy for doubt in _doubts(compiled.scene, time, wrong))
    return Estimate(warnings, spent + twin.evaluations)


def _of_drift(compiled: Compiled, run: Run) -> Estimate:
    """Error of a long ``run`` in which nothing restores some motion, against a looser twin."""
    twin = Path(run, _with(compiled, _looser_solver(compiled.scene.solver)))
    time = recorded(run, "time")
    twin.follow(inf, len(time) - 1)
    wrong = twin.apart(_ranges(run, compiled.scene.solver)) / (LOOSER - 1.0)
    remedy = (
        " Nothing restores some motion, so errors add up over the run. Choose"
        f" {_said(_finer_solver(compiled.scene), compiled.growth)} or a smaller value."
    )
    doubts = _doubts(compiled.scene, time[: twin.end + 1], wrong)
    return Estimate(tuple(doubt + remedy for doubt in doubts), twin.evaluations)


def _doubts(scene: Scene, time: np.ndarray, wrong: np.ndarray) -> Iterator[str]:
    """Doubts about motions that are ``wrong`` by these fractions of their range, (nt, nb)."""
    limit = _limit(scene.solver)
    far = np.flatnonzero(wrong.max(axis=1) > limit)
    if far.size:
        worst = wrong.max(axis=0)
        name = scene.bodies[int(worst.argmax())].name
        yield (
            f"the motion of {name} may be wrong by {min(worst.max(), 1.0):.1g} of its range by"
            f" {time[-1]:.4g} s, and by more than {limit:g} from {time[far[0]]:.4g} s on."
        )


def _twin(run: Run, compiled: Compiled, finer: Compiled, ranges: np.ndarray) -> tuple[Path, int]:
    """A twin, as far as it is needed; and the evaluations spent on other paths."""
    changes = recorded(run, "events")
    last = len(changes) - 1
    remembers = run.state.history.grid.shape[1] > 0
    before = int(with_states(run.record, int(np.flatnonzero(changes == changes[0])[-1]) + 1)[-1])
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
    """Continue to the record ``last``, or until the path of a motion is lost."""
    while twin.end < last and not twin.failed and twin.apart(ranges).max() < LOST:
        twin.follow(2 * twin.evaluations, last)


def _finer(compiled: Compiled) -> Compiled:
    """Scene with finer steps or a tighter tolerance."""
    return _with(compiled, _finer_solver(compiled.scene))


@one_thread
def _with(compiled: Compiled, solver: Solver) -> Compiled:
    """Scene with another ``solver``, and the same databases and sea."""
    scene = replace(compiled.scene, solver=solver)
    calm = compile_calm(scene, compiled.wet)
    ours = compiled.model
    if ours.following.slow.any():  # slow positions in waves are updated every so many steps
        return in_waves(calm, scene, compiled.sea)
    elements = in_same_weather(calm.model.elements, ours.elements)
    model = calm.model._replace(waves=ours.waves, following=ours.following, elements=elements)
    return replace(calm, facts=facts_of(scene, calm.wet, model))


def _finer_solver(scene: Scene) -> Solver:
    solver = scene.solver
    given = scene.solver.tolerance
    if not solver.method.adapts:
        steps = ceil(FINER * scene.output_step / solver.step)
        return replace(solver, step=scene.output_step / steps)
    each = (max(x / TIGHTER, LEAST) for x in (given.relative, given.position, given.angle))
    return replace(solver, tolerance=Tolerance(*each))


def _looser_solver(solver: Solver) -> Solver:
    given = solver.tolerance
    each = (LOOSER * x for x in (given.relative, given.position, given.angle))
    return replace(solver, tolerance=Tolerance(*each))


def _share(compiled: Compiled, finer: Compiled) -> float:
    """Ratio of the distance to the finer twin to the error of a run."""
    if compiled.method.adapts:
        return 1.0 - 1.0 / TIGHTER
    shorter = finer.scene.solver.step / compiled.scene.solver.step
    return 1.0 - shorter**compiled.method.order


def _ranges(run: Run, solver: Solver) -> np.ndarray:
    """Scales of errors, (nb, 2): the range of each body's positions [m], and of its angles [rad],
    with a lower bound."""
    least = np.full(2, STILL)
    if solver.accuracy is not None:
        least = np.array(SMALL)
    elif solver.method.adapts:
        asked = np.array([solver.tolerance.position, solver.tolerance.angle])
        least = np.maximum(least, asked * ASKED / WRONG)
    motion = recorded(run, "coordinates")
    return np.maximum(np.ptp(motion, axis=0).reshape(-1, 2, 3).max(axis=2), least)


def _limit(solver: Solver) -> float:
    """Error of motions, relative to their range, above which a run gets a warning."""
    return WRONG if solver.accuracy is None else solver.accuracy


def _said(solver: Solver, growth: float) -> str:
    if solver.accuracy is not None:
        return f"solver.tolerance: {accuracy_of(solver, growth):.2g}"
    if solver.method.adapts:
        return (
            f"solver.tolerance.relative: {solver.tolerance.relative:.2g} (and position and"
            " angle reduced likewise)"
        )
    return f"solver.step: {solver.step:.3g} s"
