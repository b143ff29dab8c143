"""The companion of a run: the same compiled scene, solved with coarser steps beside the run.

A companion shares the model, the waves and the checks of its run. Only its clock differs:

* With a fixed step it makes ``short`` steps in the time of ``long`` steps of the run. It is coarser
  where a coarser step is stable, and finer elsewhere.
* With an adaptive method its tolerance is `LOOSE_TOLERANCE_RATIO` times that of the run. What
  else limits the steps of the run limits those of the companion less: output times by a wider grid
  (`WIDER_GRIDS`), rates of loads and signals by `WIDER_LIMITS`.

Run and companion are compared at the output times that both have.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import lcm
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.forces import modes_of_kind
from hydrosim.forces.contact.fender import NORMAL_FORCE
from hydrosim.forces.contact.kind import CONTACT_KIND as CONTACTS
from hydrosim.forces.contact.modes import OPEN
from hydrosim.jit.refs import StructReference
from hydrosim.modes import MODE
from hydrosim.radiation.history import LONGEST_REMEMBERED
from hydrosim.stepping.clock import Clock
from hydrosim.stepping.record import new_record, unpack_channels
from hydrosim.stepping.run import advance
from hydrosim.stepping.state import (
    ACCEPTED,
    ERROR_INTEGRAL,
    EVALUATIONS,
    GRID_POINT,
    IN_PROGRESS,
    REACHED_TIME,
    RECORDS,
    STATUS,
    Run,
    new_run,
)

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled

LOOSE_TOLERANCE_RATIO = 16.0
"""Ratio of the tolerance of a companion to that of its run."""
COARSER_BY = 1.25
"""Ratio of the fixed step of a companion to that of its run, where nothing is against it."""
COARSER_STRIDES = ((5, 4), (4, 3), (6, 5), (7, 6), (8, 7), (10, 9))
FINER_STRIDES = ((4, 5), (3, 4), (1, 2))
WIDER_GRIDS = ((4, 1), (3, 1), (2, 1))
"""Strides for adaptive steps."""
WIDER_LIMITS = 2.0
"""Ratio of the longest steps that loads and signals allow, for adaptive steps."""
LIMITED_STEPS = 1.5
"""Steps from one output time to the next, in the mean, below which output times limit them."""
STABLE_SHARE = 0.98
"""Largest step of a companion, as a share of the largest stable step."""
EVALUATIONS_AT_ONCE = 5_000
"""Evaluations between two comparisons."""

Watch = Callable[[float], None]
"""Called at times with the time [s] that a companion has reached; it may raise."""


class Stride(NamedTuple):
    """A companion makes ``short`` steps of its grid in the time of ``long`` steps of the run's."""

    long: int
    short: int

    @property
    def ratio(self) -> float:
        """Step of the companion over that of the run."""
        return self.long / self.short


class SampledMotion(NamedTuple):
    """Motions at output times: the numbers of the ``records`` (nt,) in the run, ``coordinates``
    (nt, 6 nb) [m, rad], and ``force`` (nt, nf), the normal forces of contacts [N]."""

    records: np.ndarray
    coordinates: np.ndarray
    force: np.ndarray


class Companion:
    """A companion of a ``run`` of the ``compiled`` scene, by the ``clock`` and with the
    ``stride``."""

    def __init__(self, compiled: Compiled, run: Run, clock: Clock, stride: Stride) -> None:
        self.stride = stride
        self.clock = clock
        self._every = lcm(stride.long, run.clock.every) // run.clock.every
        self._last = int(run.counters[RECORDS]) - 1
        room = clock._replace(points=min(clock.points, EVALUATIONS_AT_ONCE * clock.every))
        record = new_record(compiled.model, room)
        state = compiled.first_state()
        self._run = new_run(clock, compiled.model, compiled.method, state, record)
        self._held = StructReference(self._run)
        self._seen = 0

    @property
    def evaluations(self) -> int:
        """Evaluations of the equation of motion so far."""
        return int(self._run.counters[EVALUATIONS])

    @property
    def has_failed(self) -> bool:
        """Whether the companion cannot continue."""
        return bool(self._run.counters[STATUS] != IN_PROGRESS)

    @property
    def local_errors(self) -> float:
        """Integral of the estimated error of its steps, see `local_errors`."""
        return local_errors(self._run)

    def sample_motions(self, watch: Watch | None = None) -> Iterator[SampledMotion]:
        """Advance to the end; yields motions piece by piece, for all common output times."""
        run = self._run
        while run.counters[GRID_POINT] < self.clock.points and run.counters[STATUS] == IN_PROGRESS:
            advance(EVALUATIONS_AT_ONCE, self._held)
            count = int(run.counters[RECORDS])
            if count > min(self._seen, 1):
                yield self._take_samples(count)
            # the first record stays, because an empty record would begin the run anew
            run.counters[RECORDS] = min(count, 1)
            if watch is not None:
                watch(float(run.scratch.pace[REACHED_TIME]))

    def _take_samples(self, count: int) -> SampledMotion:
        begin = min(self._seen, 1)
        index = self._every * (self._seen + np.arange(count - begin))
        self._seen += count - begin
        coordinates, force = sampled_channels(self._run, begin, count)
        return SampledMotion(np.minimum(index, self._last), coordinates, force)


def sampled_channels(run: Run, begin: int, end: int) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates (nt, 6 nb) and normal forces of contacts (nt, nf) of records ``begin`` to
    ``end``, the latter not included. They are copies."""
    values = unpack_channels(run.model, run.record, end, begin)
    return values["coordinates"].copy(), _normal_forces(run, values, begin, end)


def _normal_forces(run: Run, values: dict[str, np.ndarray], begin: int, end: int) -> np.ndarray:
    """Normal forces of all contact points (nt, nf) [N]."""
    if values[CONTACTS.unit].size == 0:
        return np.zeros((end - begin, 0))
    modes = modes_of_kind(CONTACTS, CONTACTS.constants_in(run.model), run.record.modes[begin:end])
    return np.where(modes[:, :, MODE] == OPEN, 0.0, values[CONTACTS.unit][:, :, NORMAL_FORCE])


def local_errors(run: Run) -> float:
    """Integral over time of the estimated error of the steps of an adaptive method, in the units of
    its relative tolerance. Its global error grows with it."""
    return float(run.scratch.pace[ERROR_INTEGRAL]) * run.clock.control.relative


def new_companion(compiled: Compiled, run: Run, finer: bool = False) -> Companion:
    """The companion of a ``run`` that has ended; a ``finer`` one where the coarser one fails."""
    clock = run.clock
    if not clock.control.adaptive:
        return _with_stride(compiled, run, _fixed_stride(compiled, run, finer), 1.0)
    if finer:
        return _with_stride(compiled, run, Stride(1, 2), 1.0 / LOOSE_TOLERANCE_RATIO)
    for stride in map(Stride._make, WIDER_GRIDS):
        if _fits(stride, run):
            return _with_stride(compiled, run, stride, LOOSE_TOLERANCE_RATIO)
    limited = run.counters[ACCEPTED] < LIMITED_STEPS * clock.points
    if limited:
        return _with_stride(compiled, run, Stride(1, 2), 1.0)
    return _with_stride(compiled, run, Stride(1, 1), LOOSE_TOLERANCE_RATIO)


def _with_stride(compiled: Compiled, run: Run, stride: Stride, looser: float) -> Companion:
    """The companion with this stride, and tolerances that are ``looser`` by this factor."""
    clock = run.clock
    step = clock.step * stride.ratio
    first = _phase(clock) * stride.short // stride.long
    begin = clock.start + clock.first * clock.step
    control = clock.control
    longest = WIDER_LIMITS if control.adaptive and looser > 1.0 else stride.ratio
    wider = clock._replace(
        start=begin - first * step,
        first=first,
        step=step,
        points=-(-clock.points * stride.short // stride.long),
        every=lcm(stride.long, clock.every) * stride.short // stride.long,
        block=clock.block * stride.short // stride.long,
        signal_step=longest * clock.signal_step,
        held_step=longest * clock.held_step,
        control=control._replace(
            relative=looser * control.relative, absolute=looser * control.absolute
        ),
    )
    return Companion(compiled, run, wider, stride)


def _fixed_stride(compiled: Compiled, run: Run, finer: bool) -> Stride:
    """The stride for a fixed step: the first coarser one that is stable and fits the grid, else a
    ``finer`` one."""
    clock = run.clock
    lengths = {clock.every, clock.block} - {0, 1, 2, 3}
    own = [Stride(n, round(n / COARSER_BY)) for n in sorted(lengths)]
    stable = STABLE_SHARE * compiled.stable_step
    coarser = [] if finer else [*own, *map(Stride._make, COARSER_STRIDES)]
    for stride in (*coarser, *map(Stride._make, FINER_STRIDES)):
        is_stable = stride.ratio < 1.0 or stride.ratio * clock.step <= stable
        if is_stable and _fits(stride, run):
            return stride
    return Stride(1, 2)


def _fits(stride: Stride, run: Run) -> bool:
    """True if slow paths in waves are renewed at the same times, and if the memory of a convolution
    has room for steps of that length."""
    clock = run.clock
    remembers = run.state.history.grid.shape[1] > 0
    if remembers and stride.ratio > LONGEST_REMEMBERED:
        return False
    return clock.block % stride.long == 0 and _phase(clock) % stride.long == 0


def _phase(clock: Clock) -> int:
    """Steps of the grid since a slow path in waves was renewed, before the run."""
    return clock.first % clock.block if clock.block else 0
