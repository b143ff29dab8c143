"""Error of a run, measured by a companion run (`hydrosim.studies.run.companion`).

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
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import isnan, nan
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.compiling.without_waves import wave_load_error
from hydrosim.dofs import DOFS
from hydrosim.radiation.threads import one_thread
from hydrosim.results.error_figures import REPORTED, ErrorEstimate
from hydrosim.rigid.attitudes import rotation_vectors
from hydrosim.scene import Kinematics, Scene
from hydrosim.scene.solver import fitting_step
from hydrosim.stepping.state import RECORDS, Run
from hydrosim.studies.run.companion import (
    Companion,
    SampledMotion,
    Watch,
    local_errors,
    new_companion,
    sampled_channels,
)

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled

PARTED = 0.3
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
def estimate_error(compiled: Compiled, run: Run, watch: Watch | None = None) -> ErrorEstimate:
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


def compare_motions(scene: Scene, run: Run, pieces: Iterable[SampledMotion]) -> Distances:
    """Distances from a run of the ``pieces`` of another."""
    exact = scene.solver.kinematics == Kinematics.EXACT
    ranges = motion_ranges(scene, run)
    coordinates, forces = sampled_channels(run, 0, int(run.counters[RECORDS]))
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


def motion_ranges(scene: Scene, run: Run) -> np.ndarray:
    """Ranges (nb, 2) of each body's positions [m] and angles [rad], with a lower bound."""
    solver = scene.solver
    least = np.full(2, MIN_RANGE)
    if solver.accuracy is not None:
        least = np.array(MIN_CHOSEN_RANGE)
    elif solver.method.adapts:
        tolerances = np.array([solver.tolerance.position, solver.tolerance.angle])
        least = np.maximum(least, TOLERANCES_IN_RANGE * tolerances)
    coordinates, _ = sampled_channels(run, 0, int(run.counters[RECORDS]))
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


def error_share(compiled: Compiled, run: Run, companion: Companion) -> float:
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
    beyond = np.flatnonzero(worst >= PARTED)
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
    yield f"{found_text} {error_remedy(compiled, errors, parted)}"


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
