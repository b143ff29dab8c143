"""Paths beside a run: they begin with its own state at a record, or near it."""

from __future__ import annotations

from itertools import pairwise
from math import exp, log
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.compiling.clock import compile_clock
from hydrosim.jit.refs import Held
from hydrosim.stepping.record import new_record, unpack
from hydrosim.stepping.run import advance
from hydrosim.stepping.state import EVALUATIONS, RECORDS, STATUS, Run, new_run

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled

AT_ONCE = 5_000  # evaluations between two looks at where a path is
PLACES = 8  # among changes, at which it is looked how nearby paths part
NEARBY = 1e-6  # of the range of a motion: how far apart they begin
STEEPEST = 100.0  # of the logarithm of a growth: more cannot be told from it


class Path:
    """A path of what is ``compiled``, with the steps of the ``run`` or others. It begins with the
    state of the run at its record ``begin``, ``moved`` by so much. Of its records it keeps how far
    a ``channel`` is from that of the run."""

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
            state.y[:] = recorded(run, "y", begin, begin)[0]
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
        """Evaluations of its equation, so far."""
        return int(self._run.counters[EVALUATIONS])

    @property
    def failed(self) -> bool:
        """Whether it cannot go on."""
        return bool(self._run.counters[STATUS])

    def follow(self, evaluations: float, last: int) -> None:
        """Go on to the record ``last``, or until it has taken so many evaluations, and one record
        at least."""
        while self.end < last and not self.failed:
            left = int(evaluations) - self.evaluations
            if left <= 0 and self.end > self.begin:
                break
            advance(min(AT_ONCE, max(left, 1)), self._held)
            self._compare()

    def _compare(self) -> None:
        """Keep the gaps at the records that are new, and make room for others: a long record would
        need as much memory as that of the run. A step takes an evaluation at least."""
        counters = self._run.counters
        known = min(len(self._gaps), 1)  # a record without any would begin the path anew
        theirs = recorded(self._run, self._channel, known)
        first = self.end + 1
        self.end += len(theirs)
        self._gaps.append(theirs - recorded(self._beside, self._channel, first, self.end))
        counters[RECORDS] = min(counters[RECORDS], 1)

    def apart(self, ranges: np.ndarray) -> np.ndarray:
        """How far the two are apart at their common records, (nt, nb), over ``ranges`` (nb, 2)."""
        gaps = self.gaps()
        widest = np.abs(gaps).reshape(len(gaps), -1, 2, 3).max(axis=3)
        return (widest / ranges).max(axis=2)

    def gaps(self) -> np.ndarray:
        """How far the channel is from that of the run at the common records, (nt, n)."""
        return np.concatenate(self._gaps)


class Growth(NamedTuple):
    """By what factor the distance of nearby paths grows, at most; evaluations that were taken."""

    factor: float = 1.0
    evaluations: int = 0


def growth(run: Run, compiled: Compiled, begin: int, granted: float) -> Growth:
    """The growth of a small distance from the record ``begin`` of a ``run`` on.

    A nearby path with the steps of the run is followed at some `PLACES` among the changes of modes,
    its distance is handed on from one to the next. What is not followed grows as fast. At the first
    place the distance takes the direction in which it grows.
    """
    changes = recorded(run, "events")
    last = len(changes) - 1
    if changes[begin] == changes[last]:
        return Growth()
    size = _sizes(run)
    coordinates = size.size // 2
    model = run.model
    moved = np.zeros(model.size)
    moved[:coordinates] = NEARBY * size[:coordinates]
    handed_on = 0.0
    levels = []
    spent = 0
    places = _places(changes, begin, last)
    for place, following in pairwise(places):
        path = Path(run, compiled, place, moved, "y")
        path.follow(granted / (len(places) - 1), following)
        spent += path.evaluations
        gaps = path.gaps()[1:]
        gaps[:, model.slow : model.draught] = 0.0  # paths in waves, which each takes anew
        if not len(gaps):  # it has failed before the next record
            continue
        distances = np.abs(gaps[:, : size.size] / size).max(axis=1)
        calm = len(gaps) // 2 + int(distances[len(gaps) // 2 :].argmin())  # between two impacts
        if path.failed or not 0.0 < distances[calm] < np.inf:
            continue
        levels.append(handed_on + log(np.median(distances)))
        handed_on += log(distances[calm] / NEARBY)
        moved = gaps[calm] * NEARBY / distances[calm]
    if not levels:
        return Growth(1.0, spent)
    grown = max(levels) - levels[0]
    share = spent / (run.counters[EVALUATIONS] * (last - begin) / last)
    return Growth(exp(min(grown / min(share, 1.0), STEEPEST)), spent)


def recorded(run: Run, channel: str, first: int = 0, last: int | None = None) -> np.ndarray:
    """A channel of the records ``first`` to ``last``, that included, or to the end."""
    count = int(run.counters[RECORDS]) if last is None else last + 1
    return unpack(run.model, run.record, count, first)[channel]


def _sizes(run: Run) -> np.ndarray:
    """Ranges of coordinates and rates: the largest of three places or angles of a body counts."""
    active = run.model.bodies.active
    ranges = np.ptp(recorded(run, "y")[:, : 2 * active.size], axis=0)
    groups = np.concatenate([active // 3, -1 - active // 3])
    largest = np.array([ranges[groups == group].max() for group in groups])
    return np.maximum(largest, NEARBY)


def _places(changes: np.ndarray, begin: int, last: int) -> list[int]:
    """Records from ``begin`` to ``last`` between which there are as many ``changes``."""
    wanted = np.linspace(changes[begin], changes[last], PLACES + 1)[:-1]
    before = np.searchsorted(changes, wanted, side="right") - 1
    return [*np.unique(np.maximum(before, begin)), last]
