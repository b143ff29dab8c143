"""Does a run say what will happen, or one thing of many that may? A twin tells.

It begins `NEARBY` away and takes the same steps. Impacts, and blocks that rattle on their corners,
can part the two by a factor each time they happen: then the errors of steps and of arithmetic grow
as much, and a finer step gives another motion, not a better one (Lorenz 1963; bouncing bodies:
Guckenheimer & Holmes 1983, 2.4). Statistics may hold all the same.

A twin is run only where contacts and springs change often, and to the end of a long run only if the
two have begun to part.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hydrosim.compiling.compiled import Compiled
from hydrosim.results.output import unpack
from hydrosim.scene import ADAPTIVE
from hydrosim.stepping.record import new_record
from hydrosim.stepping.run import advance
from hydrosim.stepping.state import EVALUATIONS, EVENTS, RECORDS, STATUS, Run, new_run

NEARBY = 1e-9  # m
PARTED = 1e4  # times: a step's error of 1e-7 of the motions is then 1e-3
LOST, LITTLE = 1e-4, 30.0
"""What the part of the energy that is lost may grow to, and times never told.
(Of 38 random scenes that agree with a finer run it was 2e-5 at most, of 4 others 2e-4 to 2e-3.)"""
SLACK = 100.0  # tolerances: adaptive methods take other steps for a twin, whose errors differ
OFTEN = 20  # events in a run: with fewer it is what it is in any smooth motion
GROWING = 5.0  # times: what is not so far away after `FIRST` comes no farther
FIRST, MOST, AT_ONCE = 60_000, 1_000_000, 5_000  # evaluations of a twin's equation


def parted(compiled: Compiled, run: Run, lost: float) -> Iterator[str]:
    """What to warn of if a ``run`` of the compiled scene, which has ended and ``lost`` that part of
    the energy exchanged, parts from its twin."""
    places = compiled.model.bodies.active % 6 < 3
    if run.counters[EVENTS] < OFTEN or not places.any():
        return
    twin = _twin(compiled, run, places)
    time, apart = _apart(run, twin)
    limit = min(PARTED, max(LOST / lost, LITTLE)) if lost > 0.0 else PARTED
    solver = compiled.scene.solver
    if solver.method in ADAPTIVE:
        limit = max(limit, SLACK * solver.tolerance.position / NEARBY)
    far = np.flatnonzero(apart.max(axis=1) > limit)
    if far.size:
        worst = apart[far[0] :].max(axis=0)
        name = compiled.scene.bodies[int(worst.argmax())].name
        yield (
            f"the motion of {name} cannot be foretold: a run that begins {NEARBY:g} m away is"
            f" {limit:.0f} times as far from it after {time[far[0]]:.4g} s, and {worst.max():.1e}"
            f" times by {time[-1]:.4g} s; expected to stay near. Errors of the steps grow as much,"
            f" and {lost:.1e} of the energy exchanged is lost in them."
            " Take statistics over runs that begin a little apart, or give the contacts more"
            " damping or friction."
        )


def _twin(compiled: Compiled, run: Run, places: np.ndarray) -> Run:
    """A run of as many evaluations as are worth it, whose bodies begin `NEARBY`, each elsewhere:
    bodies that are moved together do not notice."""
    state = compiled.first_state()
    state.y[: places.size][places] += NEARBY * np.cos(np.arange(np.count_nonzero(places)))
    twin = new_run(run.clock, run.model, run.method, state, new_record(run.model, run.clock))
    counters, allowed = twin.counters, FIRST
    while counters[EVALUATIONS] < allowed and counters[RECORDS] < run.counters[RECORDS]:
        advance(AT_ONCE, twin)
        if counters[STATUS]:
            break
        if not counters[EVENTS]:
            allowed = min(counters[EVALUATIONS] + FIRST, MOST)
        elif counters[EVALUATIONS] >= allowed and _apart(run, twin)[1].max() > GROWING:
            allowed = MOST
    return twin


def _apart(run: Run, twin: Run) -> tuple[np.ndarray, np.ndarray]:
    """Times (nt,) [s] that both have recorded, and how far the bodies are apart then, (nt, nb), in
    the distances at the start."""
    count = min(int(twin.counters[RECORDS]), int(run.counters[RECORDS]))
    ours, theirs = (unpack(one.model, one.record, count) for one in (run, twin))
    apart = np.abs(theirs["coordinates"] - ours["coordinates"]).reshape(count, -1, 6)
    return ours["time"], apart[..., :3].max(axis=2) / NEARBY
