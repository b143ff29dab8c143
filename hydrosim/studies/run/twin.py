"""How wrong is a run? A twin with finer steps, or a tighter tolerance, tells.

Where contacts and springs change, errors are not those of one smooth vibration: each change adds
its own, and impacts, and blocks that rattle on their corners, can make each grow by a factor every
time they happen (Guckenheimer & Holmes 1983, 2.4). So the two runs are compared. Errors go with the
order p of the method, which makes of the distance d of the two that of the run from the truth,
d / (1 - r^p), for a twin whose steps are r times as long (Richardson 1911). Where finer steps give
another motion each time, they are no remedy, and statistics may hold all the same (Lorenz 1963).

A twin is run only where contacts and springs change often, and to the end of a long run only if the
two part.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import ceil
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.compiling.calm import compile_calm, in_waves
from hydrosim.compiling.clock import compile_clock
from hydrosim.compiling.facts import facts_of
from hydrosim.jit.refs import Held
from hydrosim.radiation.threads import one_thread
from hydrosim.results.output import unpack
from hydrosim.scene import Scene, Solver, Tolerance
from hydrosim.stepping.record import new_record
from hydrosim.stepping.run import advance
from hydrosim.stepping.state import EVALUATIONS, EVENTS, RECORDS, STATUS, Run, new_run

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled

WRONG = 5e-4  # of the range of a motion: what is told; half of what matters, being estimated
STILL = 1e-6  # m, rad: a smaller range is none
ASKED = 10.0  # tolerances: an error that adaptive methods may make, however small a motion is
# steps of the twin for one of the run, and tolerances
FINER = 1.4
TIGHTER = 4.0
LEAST = 1e-12  # of a tolerance
OFTEN = 20  # events in a run: with fewer it is what it is in any smooth motion
# evaluations of a twin's equation
FIRST = 60_000
MOST = 1_000_000
AT_ONCE = 5_000
STEEP = 4.0  # times farther apart in the second half than in the first: the two part


def doubted(compiled: Compiled, run: Run) -> Iterator[str]:
    """What to warn of if a ``run`` of the compiled scene, which has ended, is not that of finer
    steps."""
    if run.counters[EVENTS] < OFTEN:
        return
    finer = _finer(compiled)
    ranges = _ranges(run, compiled.scene.solver)
    twin = _twin(run, finer, ranges)
    time, wrong = _apart(run, twin, ranges)
    wrong = wrong / _share(compiled, finer)
    far = np.flatnonzero(wrong.max(axis=1) > WRONG)
    if far.size:
        worst = wrong.max(axis=0)
        name = compiled.scene.bodies[int(worst.argmax())].name
        yield (
            f"the motion of {name} may be wrong by {min(worst.max(), 1.0):.1g} of its range by"
            f" {time[-1]:.4g} s, and by more than {WRONG:g} from {time[far[0]]:.4g} s on: with"
            f" {_said(finer.scene.solver)} it is another. Choose that or less, as long as this"
            " figure shrinks with it. Where it does not, contacts part what begins alike: take"
            " statistics over runs that begin a little apart, or give the contacts more damping or"
            " friction."
        )


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
    if solver.method.adapts:
        asked = np.array([solver.tolerance.position, solver.tolerance.angle])
        least = np.maximum(least, asked * ASKED / WRONG)
    motion = unpack(run.model, run.record, int(run.counters[RECORDS]))["coordinates"]
    return np.maximum(np.ptp(motion, axis=0).reshape(-1, 2, 3).max(axis=2), least)


def _said(solver: Solver) -> str:
    if solver.method.adapts:
        return f"solver.tolerance.relative: {solver.tolerance.relative:.2g} (and others alike)"
    return f"solver.step: {solver.step:.3g} s"


def _twin(run: Run, finer: Compiled, ranges: np.ndarray) -> Run:
    """A run with finer steps, of as many evaluations as are worth it."""
    clock = compile_clock(finer)
    model = finer.model
    twin = new_run(clock, model, finer.method, finer.first_state(), new_record(model, clock))
    counters = twin.counters
    allowed = FIRST
    held = Held(twin)
    while counters[EVALUATIONS] < allowed and counters[RECORDS] < run.counters[RECORDS]:
        advance(AT_ONCE, held)
        if counters[STATUS]:
            break
        if not counters[EVENTS]:
            allowed = min(counters[EVALUATIONS] + FIRST, MOST)
        elif counters[EVALUATIONS] >= allowed and _parting(run, twin, ranges):
            allowed = min(2 * allowed, MOST)
    return twin


def _parting(run: Run, twin: Run, ranges: np.ndarray) -> bool:
    """Whether the two may be too far apart at the end, going on as they do."""
    time, wrong = _apart(run, twin, ranges)
    if time.size < 2:
        return False
    worst = wrong.max(axis=1)
    half = time.size // 2
    whole = (run.clock.end - time[0]) / (time[-1] - time[0])
    steep = worst[half:].max() > STEEP * worst[:half].max(initial=0.0)
    return bool(steep or whole * worst.max() > WRONG)


def _apart(run: Run, twin: Run, ranges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Times (nt,) [s] that both have recorded, and how far they are apart then, (nt, nb), over
    ``ranges`` (nb, 2)."""
    count = min(int(twin.counters[RECORDS]), int(run.counters[RECORDS]))
    ours, theirs = (unpack(one.model, one.record, count) for one in (run, twin))
    apart = np.abs(theirs["coordinates"] - ours["coordinates"]).reshape(count, -1, 2, 3).max(axis=3)
    return ours["time"], (apart / ranges).max(axis=2)
