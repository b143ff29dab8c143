"""Paths beside a run, which begin with or near the state of the run at a record."""

from __future__ import annotations

from itertools import pairwise
from math import exp, log
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.compiling.clock import compile_clock
from hydrosim.jit.refs import Held
from hydrosim.rigid.free import groups
from hydrosim.stepping.record import new_record, states_at, unpack, with_states
from hydrosim.stepping.run import advance
from hydrosim.stepping.state import EVALUATIONS, RECORDS, STATUS, Run, new_run

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled

AT_ONCE = 5_000  # evaluations between two tests of a path
PLACES = 8  # among changes, at which the growth of distances is measured
NEARBY = 1e-6  # of the range of a motion: initial distance
STEEPEST = 100.0  # of the logarithm of a growth: larger values are indistinguishable


class Path:
    """A path of a ``compiled`` scene, with the steps of the ``run`` or others. It begins with the
    state of the run at its record ``begin``, displaced by ``moved``. That record must have all
    states (`with_states`). At each record it keeps the difference of a ``channel`` from the run."""

    def __init__(
        self,
        run: Run,
        compiled: Compiled,
        begin: int = 0,
        moved: np.ndarray | float = 0.0,
        channel: str = "coordinates",
    ) -> None:
        self.begin = begin
        self.end = begin - 1
        self._beside = run
        self._channel = channel
        self._gaps: list[np.ndarray] = []
        state = compiled.first_state()
        if begin > 0:
            state.y[:] = states_at(run.model, run.record, np.array([begin]))[0]
            state.modes[:] = run.record.modes[begin]
        state.y[:] += moved
        clock = compile_clock(compiled)
        passed = begin * clock.every
        clock = clock._replace(first=clock.first + passed, points=clock.points - passed)
        at_once = min(clock.points, AT_ONCE * clock.every)
        record = new_record(compiled.model, clock._replace(points=at_once))
        self._run = new_run(clock, compiled.model, compiled.method, state, record)
        self._held = Held(self._run)

    @property
    def evaluations(self) -> int:
        """Evaluations of the equation of motion so far."""
        return int(self._run.counters[EVALUATIONS])

    @property
    def failed(self) -> bool:
        """Whether the path cannot continue."""
        return bool(self._run.counters[STATUS])

    def follow(self, evaluations: float, last: int) -> None:
        """Continue to the record ``last``, or until so many evaluations are spent, but at least to
        the next record."""
        while self.end < last and not self.failed:
            left = evaluations - self.evaluations
            if left <= 0 and self.end > self.begin:
                break
            advance(int(min(AT_ONCE, max(left, 1))), self._held)
            self._compare()

    def _compare(self) -> None:
        """Keep the differences at new records, and clear the record: a long one would need as much
        memory as that of the run. A step takes at least one evaluation."""
        counters = self._run.counters
        known = min(len(self._gaps), 1)  # an empty record would begin the path anew
        theirs = recorded(self._run, self._channel, known)
        first = self.end + 1
        self.end += len(theirs)
        self._gaps.append(theirs - recorded(self._beside, self._channel, first, self.end))
        counters[RECORDS] = min(counters[RECORDS], 1)

    def apart(self, ranges: np.ndarray) -> np.ndarray:
        """Distance (nt, nb) between this path and the run, for each common recorded time and each
        body: the largest of the differences of its position [m] over ``ranges[:, 0]`` and of its
        angles [rad] over ``ranges[:, 1]``."""
        gaps = self.gaps()
        widest = np.abs(gaps).reshape(len(gaps), -1, 2, 3).max(axis=3)
        return (widest / ranges).max(axis=2)

    def gaps(self) -> np.ndarray:
        """Differences of the channel from the run at the common records, (nt, n)."""
        return np.concatenate(self._gaps)


class Growth(NamedTuple):
    """Largest factor by which the distance of nearby paths grows, and the evaluations spent."""

    factor: float = 1.0
    evaluations: int = 0


def growth(run: Run, compiled: Compiled, begin: int, granted: float) -> Growth:
    """Growth of a small distance from the record ``begin`` of a ``run`` on.

    A nearby path with the steps of the run is followed at `PLACES` records among the changes of
    modes. Its distance is handed on from one place to the next. Intervals that are not followed are
    assumed to grow at the same rate. At the first place, the distance turns into the direction of
    growth. Radiation states begin each time as those of the run, and follow within the memory.
    """
    changes = recorded(run, "events")
    last = len(changes) - 1
    if changes[begin] == changes[last]:
        return Growth()
    size = _sizes(run)
    coordinates = size.size // 2
    model = run.model
    remembered = model.states.decay.size
    moved = np.zeros(model.size)
    moved[:coordinates] = NEARBY * size[:coordinates]
    handed_on = 0.0
    levels = []
    spent = 0
    places = _places(changes, begin, last, with_states(run.record, last))
    for place, following in pairwise(places):
        path = Path(run, compiled, place, moved, "y")
        path.follow(granted / (len(places) - 1), following)
        spent += path.evaluations
        gaps = path.gaps()[1:]
        # slow positions in waves, which each path determines anew
        gaps[:, model.slow - remembered : model.draught - remembered] = 0.0
        if not len(gaps):  # it failed before the next record
            continue
        distances = np.abs(gaps[:, : size.size] / size).max(axis=1)
        calm = len(gaps) // 2 + int(distances[len(gaps) // 2 :].argmin())  # between two impacts
        if path.failed or not 0.0 < distances[calm] < np.inf:
            continue
        levels.append(handed_on + log(np.median(distances)))
        handed_on += log(distances[calm] / NEARBY)
        moved[: model.radiation] = gaps[calm, : model.radiation] * NEARBY / distances[calm]
        others = moved[model.radiation + remembered :]
        others[:] = gaps[calm, model.radiation :] * NEARBY / distances[calm]
    if not levels:
        return Growth(1.0, spent)
    grown = max(levels) - levels[0]
    share = spent / (run.counters[EVALUATIONS] * (last - begin) / last)
    return Growth(exp(min(grown / min(share, 1.0), STEEPEST)), spent)


def recorded(run: Run, channel: str, first: int = 0, last: int | None = None) -> np.ndarray:
    """A channel of the records ``first`` to ``last``, inclusive, or to the end. Of the states "y",
    all but those of radiation."""
    count = int(run.counters[RECORDS]) if last is None else last + 1
    found = unpack(run.model, run.record, count, first)[channel]
    return np.asarray(found.values if channel == "y" else found)


def _sizes(run: Run) -> np.ndarray:
    """Ranges of coordinates and rates: the largest of the three positions or angles of a body."""
    active = run.model.bodies.active
    ranges = np.ptp(recorded(run, "y")[:, : 2 * active.size], axis=0)
    each = groups(run.model.bodies)
    both = np.concatenate([each, -1 - each])
    largest = np.array([ranges[both == group].max() for group in both])
    return np.maximum(largest, NEARBY)


def _places(changes: np.ndarray, begin: int, last: int, complete: np.ndarray) -> list[int]:
    """Records from ``begin`` to ``last`` with about equal numbers of ``changes`` between them. Each
    is the last of the ``complete`` records up to there, which have all states."""
    wanted = np.linspace(changes[begin], changes[last], PLACES + 1)[:-1]
    before = np.searchsorted(changes, wanted, side="right") - 1
    wanted = np.maximum(before, begin)
    return [*np.unique(complete[np.searchsorted(complete, wanted, side="right") - 1]), last]
