"""Error of a run, measured by a companion run; runs are repeated until they are accurate enough.

For a method of order p and a companion whose steps are r times as long, the error of the run is
d / |r^p - 1|, with the distance d of the two (Richardson 1911). With an adaptive method r^p is the
ratio of the local errors that both estimated for their steps, integrated over the run. It is about
the ratio of their tolerances, and less where something else limits the steps.

The distance of positions is that of each coordinate. The distance of attitudes is the rotation from
one to the other, about the axes that turn with the yaw of the body. Errors are the largest over the
run. They are relative to the range of the motion: the largest range of the three positions, or of
the three angles, of a body.

Two runs may part for good: their distance then is as large as the motion itself. Errors that grow
exponentially are those of a chaotic scene (Guckenheimer & Holmes 1983, 2.4). No step follows such a
motion for long, but statistics may still hold (Lorenz 1963).

The companion of a run: the same compiled scene, solved with coarser steps beside the run.

A companion shares the model, the waves and the checks of its run. Only its clock differs:

* With a fixed step it makes ``short`` steps in the time of ``long`` steps of the run. It is coarser
  where a coarser step is stable, and finer elsewhere.
* With an adaptive method its tolerance is `LOOSE_TOLERANCE_RATIO` times that of the run. What
  else limits the steps of the run limits those of the companion less: output times by a wider grid
  (`WIDER_GRIDS`), rates of loads and signals by `WIDER_LIMITS`.

Run and companion are compared at the output times that both have.

`method: automatic` keeps its tolerance: a run that misses it is made again.

The tolerance of steps is reduced by as much as the measured error is too large. All repeated runs
together cost at most `MAX_COST` times the first run, or `FREE_EVALUATIONS` if that is more. A run
that misses its accuracy even so says it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from math import isnan, lcm, nan
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.compile.automatic import MIN_TOLERANCE
from hydrosim.compile.compile import compile_calm
from hydrosim.compile.waves import add_waves, wave_load_error
from hydrosim.dofs import DOFS
from hydrosim.elements import externals_of, modes_of_kind
from hydrosim.elements.contact.fender import NORMAL_FORCE
from hydrosim.elements.contact.kind import CONTACT_KIND as CONTACTS
from hydrosim.elements.contact.law import OPEN
from hydrosim.integrate import state as states
from hydrosim.integrate.loop import advance
from hydrosim.integrate.record import new_record, unpack_channels
from hydrosim.jit.refs import StructReference
from hydrosim.modes import MODE
from hydrosim.multibody.vectors import rotation_vectors
from hydrosim.results.ledger import REPORTED, ErrorEstimate
from hydrosim.scene import Kinematics, Scene, Tolerance
from hydrosim.scene.scene import fitting_step
from hydrosim.water.radiation.history import LONGEST_REMEMBERED
from hydrosim.water.radiation.threads import one_thread

if TYPE_CHECKING:
    from hydrosim.compile.compiled import Compiled
    from hydrosim.run.course import RunInProgress

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

    def __init__(
        self, compiled: Compiled, run: states.Run, clock: states.Clock, stride: Stride
    ) -> None:
        self.stride = stride
        self.clock = clock
        self._every = lcm(stride.long, run.clock.every) // run.clock.every
        self._last = int(run.counters[states.RECORDS]) - 1
        room = clock._replace(points=min(clock.points, EVALUATIONS_AT_ONCE * clock.every))
        record = new_record(compiled.model, room)
        state = compiled.first_state()
        self._run = states.new_run(clock, compiled.model, compiled.method, state, record)
        self._held = StructReference(self._run)
        self._seen = 0

    @property
    def evaluations(self) -> int:
        """Evaluations of the equation of motion so far."""
        return int(self._run.counters[states.EVALUATIONS])

    @property
    def has_failed(self) -> bool:
        """Whether the companion cannot continue."""
        return bool(self._run.counters[states.STATUS] != states.IN_PROGRESS)

    @property
    def local_errors(self) -> float:
        """Integral of the estimated error of its steps, see `local_errors`."""
        return local_errors(self._run)

    def sample_motions(self, watch: Watch | None = None) -> Iterator[SampledMotion]:
        """Advance to the end; yields motions piece by piece, for all common output times."""
        run = self._run
        while (
            run.counters[states.GRID_POINT] < self.clock.points
            and run.counters[states.STATUS] == states.IN_PROGRESS
        ):
            advance(EVALUATIONS_AT_ONCE, self._held)
            count = int(run.counters[states.RECORDS])
            if count > min(self._seen, 1):
                yield self._take_samples(count)
            # the first record stays, because an empty record would begin the run anew
            run.counters[states.RECORDS] = min(count, 1)
            if watch is not None:
                watch(float(run.scratch.pace[states.REACHED_TIME]))

    def _take_samples(self, count: int) -> SampledMotion:
        begin = min(self._seen, 1)
        index = self._every * (self._seen + np.arange(count - begin))
        self._seen += count - begin
        coordinates, force = sampled_channels(self._run, begin, count)
        return SampledMotion(np.minimum(index, self._last), coordinates, force)


def sampled_channels(run: states.Run, begin: int, end: int) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates (nt, 6 nb) and normal forces of contacts (nt, nf) of records ``begin`` to
    ``end``, the latter not included. They are copies."""
    values = unpack_channels(run.model, run.record, end, begin)
    return values["coordinates"].copy(), _normal_forces(run, values, begin, end)


def _normal_forces(
    run: states.Run, values: dict[str, np.ndarray], begin: int, end: int
) -> np.ndarray:
    """Normal forces of all contact points (nt, nf) [N]."""
    if values[CONTACTS.unit].size == 0:
        return np.zeros((end - begin, 0))
    modes = modes_of_kind(CONTACTS, CONTACTS.constants_in(run.model), run.record.modes[begin:end])
    return np.where(modes[:, :, MODE] == OPEN, 0.0, values[CONTACTS.unit][:, :, NORMAL_FORCE])


def local_errors(run: states.Run) -> float:
    """Integral over time of the estimated error of the steps of an adaptive method, in the units of
    its relative tolerance. Its global error grows with it."""
    return float(run.scratch.pace[states.ERROR_INTEGRAL]) * run.clock.control.relative


def new_companion(compiled: Compiled, run: states.Run, finer: bool = False) -> Companion:
    """The companion of a ``run`` that has ended; a ``finer`` one where the coarser one fails."""
    clock = run.clock
    if not clock.control.adaptive:
        return _with_stride(compiled, run, _fixed_stride(compiled, run, finer), 1.0)
    if finer:
        return _with_stride(compiled, run, Stride(1, 2), 1.0 / LOOSE_TOLERANCE_RATIO)
    for stride in map(Stride._make, WIDER_GRIDS):
        if _is_stride_possible(stride, run):
            return _with_stride(compiled, run, stride, LOOSE_TOLERANCE_RATIO)
    limited = run.counters[states.ACCEPTED] < LIMITED_STEPS * clock.points
    if limited:
        return _with_stride(compiled, run, Stride(1, 2), 1.0)
    return _with_stride(compiled, run, Stride(1, 1), LOOSE_TOLERANCE_RATIO)


def _with_stride(compiled: Compiled, run: states.Run, stride: Stride, looser: float) -> Companion:
    """The companion with this stride, and tolerances that are ``looser`` by this factor."""
    clock = run.clock
    step = clock.step * stride.ratio
    first = _steps_since_renewal(clock) * stride.short // stride.long
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


def _fixed_stride(compiled: Compiled, run: states.Run, finer: bool) -> Stride:
    """The stride for a fixed step: the first coarser one that is stable and fits the grid, else a
    ``finer`` one."""
    clock = run.clock
    lengths = {clock.every, clock.block} - {0, 1, 2, 3}
    strides = [Stride(n, round(n / COARSER_BY)) for n in sorted(lengths)]
    stable = STABLE_SHARE * compiled.stable_step
    coarser = [] if finer else [*strides, *map(Stride._make, COARSER_STRIDES)]
    for stride in (*coarser, *map(Stride._make, FINER_STRIDES)):
        is_stable = stride.ratio < 1.0 or stride.ratio * clock.step <= stable
        if is_stable and _is_stride_possible(stride, run):
            return stride
    return Stride(1, 2)


def _is_stride_possible(stride: Stride, run: states.Run) -> bool:
    """True if slow paths in waves are renewed at the same times, and if the memory of a convolution
    has room for steps of that length."""
    clock = run.clock
    remembers = run.state.history.grid.shape[1] > 0
    if remembers and stride.ratio > LONGEST_REMEMBERED:
        return False
    return clock.block % stride.long == 0 and _steps_since_renewal(clock) % stride.long == 0


def _steps_since_renewal(clock: states.Clock) -> int:
    """Steps of the grid since a slow path in waves was renewed, before the run."""
    return clock.first % clock.block if clock.block else 0


PARTING_FRACTION = 0.3
"""Error relative to the range of a motion at which two runs have parted."""
STAYS_PARTED = 0.1
"""Median error, relative to the range, of runs that have parted for good."""
MIN_RANGE = 1e-6
"""Least range of a motion [m, rad]: a smaller one counts as this."""
MIN_CHOSEN_RANGE = (1e-3, 1e-5)
"""The same for a method that is chosen for an accuracy [m], [rad]."""
TOLERANCES_IN_RANGE = 2e4
"""Least range of a motion over the tolerance per second of an adaptive method [s]."""
LINEAR = 0.1
"""Distance relative to the range up to which it is proportional to errors of steps."""
ONSET = 1e-4
"""Error at the time from which growth is measured, over that at which it is proportional."""
MIN_SCALE = 1e-300
MIN_SHARE = 0.5
"""Least ratio of the distance to the error of an adaptive run."""
CHAOS = (
    "The motion is chaotic: no step follows it for long. Use statistics over several seeds or"
    " slightly different starts, or give contacts and joints more damping or friction."
)
REMEDY_MARGIN = 0.7
"""Error at the step that a warning names, over the limit of the warning."""


class Distances(NamedTuple):
    """Distances of two runs: ``relative`` (nt, nb) to the ranges of motions at each common
    ``time`` (nt,) [s]; the ``largest`` (nb, 6) [m, rad]; of the largest normal ``force``, relative
    to it."""

    time: np.ndarray
    relative: np.ndarray
    largest: np.ndarray
    force: float


@one_thread
def estimate_error(
    compiled: Compiled, run: states.Run, watch: Watch | None = None
) -> ErrorEstimate:
    """Error of a ``run`` of the compiled scene, which has ended. ``watch`` is called with the time
    that the companion has reached."""
    companion = new_companion(compiled, run)
    distances = compare_motions(compiled.scene, run, companion.sample_motions(watch))
    evaluations = companion.evaluations
    if companion.has_failed:
        companion = new_companion(compiled, run, finer=True)
        distances = compare_motions(compiled.scene, run, companion.sample_motions(watch))
        evaluations += companion.evaluations
    share = error_share(compiled, run, companion)
    relative = errors_of_run(distances.time, distances.relative, share)
    force = distances.force * _ratio(relative, distances.relative)
    relative += wave_error(compiled)
    largest = distances.largest * _ratio(relative, distances.relative)
    errors = Distances(distances.time, relative, largest, force)
    parted = parting_time(errors.time, errors.relative)
    beside = describe_companion(compiled, companion)
    return ErrorEstimate(
        errors.largest,
        float(relative.max(initial=0.0)),
        errors.force,
        parted,
        beside,
        evaluations,
        tuple(error_warnings(compiled, beside, errors, parted)),
    )


def _ratio(errors: np.ndarray, distances: np.ndarray) -> float:
    return float(errors.max(initial=0.0) / max(distances.max(initial=0.0), MIN_SCALE))


def wave_error(compiled: Compiled) -> float:
    """Error of motions, relative to their range, by the table of waves along slow paths. A run
    shares it with its companion."""
    if not compiled.model.following.slow.any():
        return 0.0
    return wave_load_error(compiled.scene.solver)


def compare_motions(scene: Scene, run: states.Run, pieces: Iterable[SampledMotion]) -> Distances:
    """Distances from a run of the ``pieces`` of another."""
    exact = scene.solver.kinematics == Kinematics.EXACT
    ranges = motion_ranges(scene, run)
    coordinates, forces = sampled_channels(run, 0, int(run.counters[states.RECORDS]))
    indices = []
    relative = []
    largest = np.zeros((len(ranges), 6))
    peaks = np.zeros(2)
    for samples in pieces:
        gaps = motion_gaps(samples.coordinates, coordinates[samples.records], exact)
        widest = gaps.reshape(len(gaps), -1, 2, 3).max(axis=3)
        relative.append((widest / ranges).max(axis=2))
        indices.append(samples.records)
        largest = np.maximum(largest, gaps.max(axis=0, initial=0.0))
        ours = forces[samples.records].max(initial=0.0)
        peaks = np.maximum(peaks, [ours, samples.force.max(initial=0.0)])
    time = run.record.channels[np.concatenate(indices), run.record.at.time]
    force = abs(peaks[1] - peaks[0]) / peaks[0] if peaks[0] > 0.0 else nan
    return Distances(time, np.concatenate(relative), largest, float(force))


def motion_gaps(ours: np.ndarray, theirs: np.ndarray, exact: bool) -> np.ndarray:
    """Sizes (nt, nb, 6) of the differences of coordinates (nt, 6 nb) [m, rad]. With ``exact``
    rotations, those of angles are rotations about axes that turn with the yaw of ``theirs``."""
    both = [x.reshape(len(x), -1, 6) for x in (ours, theirs)]
    gaps = both[0] - both[1]
    if exact:
        gaps[:, :, 3:] = rotation_vectors(both[0][:, :, 3:], both[1][:, :, 3:])
    return np.abs(gaps)


def motion_ranges(scene: Scene, run: states.Run) -> np.ndarray:
    """Ranges (nb, 2) of each body's positions [m] and angles [rad], with a lower bound."""
    solver = scene.solver
    least = np.full(2, MIN_RANGE)
    if solver.accuracy is not None:
        least = np.array(MIN_CHOSEN_RANGE)
    elif solver.method.adapts:
        tolerances = np.array([solver.tolerance.position, solver.tolerance.angle])
        least = np.maximum(least, TOLERANCES_IN_RANGE * tolerances)
    coordinates, _ = sampled_channels(run, 0, int(run.counters[states.RECORDS]))
    return np.maximum(np.ptp(coordinates, axis=0).reshape(-1, 2, 3).max(axis=2), least)


def errors_of_run(time: np.ndarray, apart: np.ndarray, share: float) -> np.ndarray:
    """Errors (nt, nb) of a run that is ``apart`` (nt, nb) from a companion, relative to ranges.

    They are the distances over the ``share``, as long as these are small. A companion that is lost
    says no more by its distance, but by the time of it: the run has the same distance from the
    truth later, because its errors begin ``share`` times as small. If errors grow as any power of
    the time, or exponentially, all times are longer by about the same factor.
    """
    worst = np.maximum.accumulate(apart.max(axis=1, initial=0.0))
    errors = apart / share
    if worst.size == 0 or worst[-1] < LINEAR:
        return errors
    levels = LINEAR / share * np.array([ONSET, 1.0, share])
    onset, smaller, lost = np.searchsorted(worst, levels)
    begin = time[max(onset - 1, 0)]
    slower = (time[lost] - begin) / max(time[min(smaller, lost)] - begin, MIN_SCALE)
    earlier = np.searchsorted(time, begin + (time - begin) / slower, side="right") - 1
    later = np.arange(time.size) >= lost
    errors[later] = np.maximum(errors[later], apart[earlier[later]])
    return errors


def error_share(compiled: Compiled, run: states.Run, companion: Companion) -> float:
    """Ratio of the distance of a companion to the error of its run."""
    if not compiled.method.adapts:
        return float(abs(companion.stride.ratio**compiled.method.order - 1.0))
    looser = companion.local_errors / max(local_errors(run), MIN_SCALE)
    return max(abs(looser - 1.0), MIN_SHARE)


def reported_error(scene: Scene) -> float:
    """Error of motions, relative to their range, above which a run gets a warning."""
    return REPORTED if scene.solver.accuracy is None else scene.solver.accuracy


def parting_time(time: np.ndarray, relative: np.ndarray) -> float:
    """Time [s] at which errors (nt, nb) relative to the range become those of runs that have
    parted for good; NaN if they do not."""
    worst = relative.max(axis=1, initial=0.0)
    beyond = np.flatnonzero(worst >= PARTING_FRACTION)
    if beyond.size == 0 or np.median(worst[beyond[0] :]) < STAYS_PARTED:
        return nan
    return float(time[beyond[0]])


def describe_companion(compiled: Compiled, companion: Companion) -> str:
    """What the run was compared with: "rk4 at 0.125 s"."""
    if not compiled.method.adapts:
        return f"{compiled.method.name} at {companion.clock.step:.3g} s"
    ratio = companion.clock.control.relative / compiled.scene.solver.tolerance.relative
    return f"{compiled.method.name} with {ratio:.3g} times the tolerance"


def error_warnings(
    compiled: Compiled, beside: str, errors: Distances, parted: float
) -> Iterator[str]:
    """Warning if errors of motions are above the limit, with a remedy. The run ``beside`` it shows
    them."""
    scene = compiled.scene
    limit = reported_error(scene)
    worst = errors.relative.max(axis=1, initial=0.0)
    beyond = np.flatnonzero(worst > limit)
    if beyond.size == 0:
        return
    body = int(errors.relative.max(axis=0).argmax())
    dof = DOFS[int(errors.largest[body].argmax())] if body < len(errors.largest) else ""
    found_text = (
        f"the motion of {scene.bodies[body].name} may be wrong by"
        f" {min(worst.max(), 1.0):.1g} of its range by {errors.time[-1]:.4g} s, most in {dof}, and"
        f" by more than {limit:g} from {errors.time[beyond[0]]:.4g} s on;"
        f" {beside} gives a different motion."
    )
    yield f"{found_text} {error_remedy(compiled, errors, parted)}{_advice_on_functions(scene)}"


def _advice_on_functions(scene: Scene) -> str:
    """What to look for in functions of Python that are called at every stage, if there are some."""
    names = [name for name, of in externals_of(scene.forces).items() if not of.delayed]
    if not names:
        return ""
    return (
        f" The function of {', '.join(names)} is called at every stage, also of trial steps: if it"
        " remembers, such as when a latch closed, choose UserForce(..., coupling='held')."
    )


def error_remedy(compiled: Compiled, errors: Distances, parted: float) -> str:
    """What to do about errors above the limit."""
    solver = compiled.scene.solver
    finer = _finer_solver(compiled, float(errors.relative.max()))
    if not isnan(parted) and solver.accuracy is not None:
        return f"The two part at {parted:.4g} s, although steps were made finer. {CHAOS}"
    advice = f"Choose {finer}."
    if solver.accuracy is None:
        advice = f"Choose {finer}, or solver.method: automatic."
    if isnan(parted):
        return advice
    return (
        f"The two part at {parted:.4g} s. {advice} If that run parts from a still finer one:"
        f" {CHAOS}"
    )


def _finer_solver(compiled: Compiled, error: float) -> str:
    """Keys of the solver for an error below the limit, where it is ``error`` now."""
    scene = compiled.scene
    solver = scene.solver
    factor = REMEDY_MARGIN * reported_error(scene) / error
    if not solver.method.adapts:
        step = solver.step * factor ** (1.0 / compiled.method.order)
        return f"solver.step: {fitting_step(scene.output_step, step):.6g} s"
    tolerance = solver.tolerance
    relative = factor * tolerance.relative
    if solver.accuracy is None:
        return (
            f"solver.tolerance.relative: {relative:.2g} (and position and angle reduced likewise)"
        )
    return (
        f"solver.method: {solver.method} with tolerance: {{relative: {relative:.2g}, position:"
        f" {factor * tolerance.position:.2g}, angle: {factor * tolerance.angle:.2g}}}. Steps that"
        " fine cost more than automatic may spend"
    )


MAX_COST = 3.0
"""Cost of all repeated runs over that of the first."""
FREE_EVALUATIONS = 1_000_000
"""Evaluations that repeated runs may take in any case, a few seconds."""
SAFE_SHARE = 0.3
"""Measured error up to which a run is kept, over the accuracy: the true one may be larger by as
much."""
ERROR_MARGIN = 0.15
"""Error that a repeated run aims at, over the accuracy."""
MAX_TIGHTENING = 1e-4
"""Smallest factor on the tolerance from one run to the next."""

Solve = Callable[["Compiled"], "RunInProgress"]
"""Runs a compiled scene to its end."""
Measure = Callable[["RunInProgress"], "ErrorEstimate"]
"""Measures the error of a course."""


def repeat_until_accurate(
    course: RunInProgress, solve: Solve, measure: Measure
) -> tuple[RunInProgress, ErrorEstimate]:
    """The ``course`` and the estimate of its error if it keeps the accuracy of its scene, or if
    that has none; else those of a run that was made again."""
    estimate = measure(course)
    accuracy = course.compiled.scene.solver.accuracy
    first = int(course.run.counters[states.EVALUATIONS])
    allowed = max(MAX_COST * first, FREE_EVALUATIONS)
    spent = estimate.evaluations
    while accuracy is not None and estimate.relative > SAFE_SHARE * accuracy:
        factor = max(ERROR_MARGIN * accuracy / estimate.relative, MAX_TIGHTENING)
        cost = int(course.run.counters[states.EVALUATIONS])
        expected = cost * factor ** (-1.0 / (course.compiled.method.order - 1))
        finer = with_tighter_steps(course.compiled, factor)
        if finer is None or expected > allowed:
            break
        earlier = course
        course = solve(finer)
        if not course.complete:
            course = earlier
            break
        allowed -= int(course.run.counters[states.EVALUATIONS])
        spent += cost
        estimate = measure(course)
        spent += estimate.evaluations
        allowed -= estimate.evaluations
    return course, estimate._replace(evaluations=spent)


@one_thread
def with_tighter_steps(compiled: Compiled, factor: float) -> Compiled | None:
    """Scene with tolerances of steps that are smaller by a ``factor``, and the same databases and
    sea; None if rounding would exceed them."""
    scene = compiled.scene
    given = scene.solver.tolerance
    if factor * given.relative < MIN_TOLERANCE:
        return None
    tolerance = Tolerance(*(factor * x for x in (given.relative, given.position, given.angle)))
    scene = replace(scene, solver=replace(scene.solver, tolerance=tolerance))
    if not compiled.model.following.slow.any():
        return replace(compiled, scene=scene)
    # rows of waves that follow slow paths are as fine as the tolerance
    made = add_waves(compile_calm(scene, compiled.wet), scene, compiled.sea)
    return replace(compiled, scene=made.scene, derived=made.derived, state=made.state)
