"""Limiting significant heights over peak periods, headings and swells, by bisection on seeds.

The largest height at which enough seeds hold their criteria, by bisection on common seeds.

Of N seeds, k fail at a height h with the probability of a binomial law of the true share q(h). The
limit is the largest height of a grid at which no more fail than are allowed, k <= N (1 - p). The
true limit, q(h) = 1 - p, is by 90 % where k is between the 5 % and 95 % quantiles of the law of
N and 1 - p, which the same search finds.

A seed that fails at a height is taken to fail at all greater ones, and one that holds to hold at
all smaller ones, so that few have to be run. What is found is then run: at the limit there is no
seed that was not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import scipy
import xarray as xr

from hydrosim.case.load import load_case
from hydrosim.errors import InputError
from hydrosim.files.cache import program_version, versions
from hydrosim.files.display_units import units_of
from hydrosim.files.document_layout import text_of
from hydrosim.files.document_nodes import Value
from hydrosim.files.interrupts import raise_if_interrupted
from hydrosim.files.yaml_nodes import locating_in
from hydrosim.results.dataset import KIND, ResultKind
from hydrosim.results.runs_file import INTERRUPTED, NOT_RUN, Journal, RunOutcome
from hydrosim.results.variables import describe_coordinates, describe_values
from hydrosim.simulation import prepare_scene
from hydrosim.statistics.figures import RequestedStatistic
from hydrosim.statistics.results import RunResults
from hydrosim.study import run_layout, sweep
from hydrosim.study.executors import Threads, make_runs
from hydrosim.study.scene_cache import RunTask, SceneCache, identity
from hydrosim.study.seas import Sea, Swell, add_mirrored_limits, scene_in_sea, wind_sea
from hydrosim.study.spectral_limits import Spectral, spectral

if TYPE_CHECKING:
    from hydrosim.scene import Scene
    from hydrosim.study.study_file import Operability, StudyFile

CONFIDENCE = 0.9
INTERVAL = ("limit", "low", "high")  # variables: a limit and the ends of its interval
RUNS_PER_CHUNK = 8  # runs at a time, after which there may be enough

Outcomes = Callable[[Sequence[tuple[int, int]]], np.ndarray]
"""Whether runs (height, seed) hold each criterion: (n, criteria) of truth values."""


class HeightLimit(NamedTuple):
    """The limit between two heights by their numbers, -1 if the smallest fails: the last at which
    no more fail than allowed, and the interval; how many seeds were ``inferred`` there before they
    were run, and how many of these were ``otherwise``."""

    limit: int
    low: int
    high: int
    inferred: int
    otherwise: int


def fewest_seeds(probability: float) -> int:
    """How many seeds bound a limit from below with this confidence."""
    n = 1
    while scipy.stats.binom.ppf(0.5 * (1.0 - CONFIDENCE), n, 1.0 - probability) < 1:
        n += 1
    return n


def allowed_failures(count: int, probability: float) -> tuple[int, int, int]:
    """How many of so many seeds may fail: at the limit, and at the ends of its interval."""
    tail = 0.5 * (1.0 - CONFIDENCE)
    low, high = scipy.stats.binom.ppf([tail, 1.0 - tail], count, 1.0 - probability)
    if low < 1:
        raise InputError(
            f"seeds: found {count}; expected {fewest_seeds(probability)} or more. With fewer"
            " seeds, even zero failures do not exclude a failure rate of"
            f" {1.0 - probability:.3g}."
        )
    return int(np.floor(count * (1.0 - probability) + 1e-9)), int(low) - 1, int(high)


FAILS, HOLDS, UNKNOWN = 0, 1, -1  # of a seed at a height


class LimitSearch:
    """Runs of a sea of so many ``heights`` and ``seeds``, and whether these hold so many
    ``criteria``, as far as it is known from runs that ``outcomes`` makes."""

    def __init__(self, heights: int, seeds: int, criteria: int, outcomes: Outcomes) -> None:
        self.outcomes = outcomes
        self.was_run = np.zeros((heights, seeds), bool)
        self.held = np.zeros((heights, seeds, criteria), bool)

    def find_limit(self, criteria: Sequence[int], probability: float) -> HeightLimit:
        """The limit of some of the ``criteria``, all of which must hold."""
        top, seeds = self.was_run.shape
        most, least, largest = allowed_failures(seeds, probability)
        inferred, otherwise = 0, 0
        limit = self._last_allowed_height(criteria, most, top)
        while limit >= 0:
            guesses = self._states(criteria)[limit]
            is_guess = ~self.was_run[limit] & (guesses != UNKNOWN)
            self._run(limit, np.flatnonzero(~self.was_run[limit]))
            states = self._states(criteria)[limit]
            inferred += int(is_guess.sum())
            otherwise += int((guesses != states)[is_guess].sum())
            if np.sum(states == FAILS) <= most:
                break
            limit = self._last_allowed_height(criteria, most, limit)
        low = self._last_allowed_height(criteria, least, max(limit, 0) + 1)
        high = self._last_allowed_height(criteria, largest, top, limit) + 1
        return HeightLimit(limit, min(low, limit), max(high, limit + 1), inferred, otherwise)

    def governing(self, criteria: Sequence[int], limit: int) -> int | None:
        """Which criterion fails most at the first height beyond the limit that was run."""
        failing = (self.was_run[:, :, None] & ~self.held[:, :, criteria]).sum(axis=1)
        beyond = np.flatnonzero(failing[limit + 1 :].any(axis=1))
        return criteria[int(failing[limit + 1 + beyond[0]].argmax())] if beyond.size else None

    def _last_allowed_height(
        self, criteria: Sequence[int], most: int, above: int, below: int = -1
    ) -> int:
        """The last height below ``above`` at which no more than ``most`` seeds fail."""
        while above - below > 1:
            middle = (below + above) // 2
            if self._is_allowed(criteria, most, middle):
                below = middle
            else:
                above = middle
        return below

    def _is_allowed(self, criteria: Sequence[int], most: int, height: int) -> bool:
        """Whether no more than so many seeds fail, with as few runs as decide it."""
        while True:
            states = self._states(criteria)[height]
            failing, unknown = np.sum(states == FAILS), np.flatnonzero(states == UNKNOWN)
            if failing > most:
                return False
            if failing + unknown.size <= most:
                return True
            self._run(height, unknown[:RUNS_PER_CHUNK])

    def _states(self, criteria: Sequence[int]) -> np.ndarray:
        """Whether seeds hold at heights (heights, seeds), by their runs there, or else by those at
        others: first by those below that fail, then by those above that hold."""
        holds = self.held[:, :, criteria].all(axis=2)
        fails_below = np.logical_or.accumulate(self.was_run & ~holds, axis=0)
        holds_above = np.logical_or.accumulate((self.was_run & holds)[::-1], axis=0)[::-1]
        inferred = np.where(fails_below, FAILS, np.where(holds_above, HOLDS, UNKNOWN))
        return np.where(self.was_run, holds, inferred)

    def _run(self, height: int, seeds: np.ndarray) -> None:
        if seeds.size:
            self.held[height, seeds] = self.outcomes([(height, seed) for seed in seeds.tolist()])
            self.was_run[height, seeds] = True


# Trials: runs on all cores, of which only figures are kept.


class Trials:
    """Runs scenes by so many ``workers`` for their ``figures``; counts them and those that failed,
    of which ``message`` is the first. Runs are numbered in the order in which they are asked for:
    those that a ``journal`` keeps are taken from there, others are added to it."""

    def __init__(
        self,
        figures: Sequence[RequestedStatistic],
        workers: int,
        progress: Callable[[int], None] = lambda _: None,
        journal: Journal | None = None,
    ) -> None:
        self.figures, self.workers, self.progress = tuple(figures), workers, progress
        self.count, self.failed, self.message = 0, 0, ""
        self._cache = SceneCache()
        self._journal = journal

    def values(self, scenes: Sequence[Scene]) -> tuple[np.ndarray, np.ndarray]:
        """The figures (n, nf) of each scene, and whether its run came to its end (n,)."""
        raise_if_interrupted()
        begin = self.count
        figures = np.full((len(scenes), len(self.figures)), np.nan)
        complete = np.zeros(len(scenes), bool)

        def compile_task(run: int) -> RunTask | Exception:
            return self._cache.compile_task(scenes[run - begin])

        def take(run: int, outcome: RunOutcome) -> None:
            if outcome.status in (NOT_RUN, INTERRUPTED):
                raise KeyboardInterrupt
            if outcome.dataset is None:
                self.failed += 1
                self.message = self.message or outcome.message
                return
            complete[run - begin] = True
            row = [float(outcome.dataset[figure.name]) for figure in self.figures]
            figures[run - begin] = row

        runs = range(begin, begin + len(scenes))
        make_runs(runs, compile_task, self._figures, Threads(self.workers), take, self._journal)
        self.count += len(scenes)
        self.progress(self.count)
        return figures, complete

    def _figures(self, run: xr.Dataset) -> xr.Dataset:
        results = RunResults(run)
        return xr.Dataset({figure.name: figure.evaluate(results) for figure in self.figures})


ALL_STAGES = "all"  # stages together
DEFAULT_SEEDS = 50  # where the study says none
Progress = Callable[[str, int, int], None]
"""Called with the sea, the number of runs until now, and the seas that are done."""


@dataclass(frozen=True)
class Limits:
    """What a study of limits asks: a ``scene``, the seas, the ``figures`` and their ``limits``,
    which of these are the ``least`` that a figure may be; the ``settings`` that its result is made
    with."""

    path: Path
    scene: Scene
    data: StudyFile
    wanted: Operability
    figures: tuple[RequestedStatistic, ...]
    limits: tuple[float, ...]
    least: tuple[bool, ...]
    units: dict[str, str]
    inputs: tuple[Path, ...]
    settings: str

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seeds, 1 to 50 if the study says none."""
        return self.data.seeds or tuple(range(1, DEFAULT_SEEDS + 1))

    @property
    def swells(self) -> list[Swell | None]:
        """The swells, of which one is none."""
        swells = [Swell(s.significant_height, s.peak_period, s.heading) for s in self.wanted.swells]
        return [None, *swells]

    @property
    def headings(self) -> tuple[float, ...]:
        """Headings [rad]: those of the study, or that of the case."""
        return self.wanted.headings or (wind_sea(self.scene).heading,)

    @property
    def seas(self) -> dict[tuple[int, int, int], Sea]:
        """All seas, by the numbers of their swell, heading and peak period."""
        return {
            (i, j, k): Sea(period, heading, swell)
            for i, swell in enumerate(self.swells)
            for j, heading in enumerate(self.headings)
            for k, period in enumerate(self.wanted.peak_periods)
        }

    @property
    def identity(self) -> dict[str, str]:
        """What must be the same for the search to go on (`hydrosim.study.scene_cache`)."""
        heights = self.wanted.heights.values()
        varied = {
            "seeds": self.seeds,
            "heights": heights,
            "seas": [*self.seas.values()],
        }
        asked = {"criteria": self.figures, "limits": self.limits, "share": self.wanted.probability}
        return identity([self.scene], SceneCache().open_sources, varied, asked)

    def stages(self) -> dict[str, list[int]]:
        """The numbers of the criteria of all stages together and of each."""
        numbers = {ALL_STAGES: list(range(len(self.figures)))}
        for k, figure in enumerate(self.figures):
            if figure.phase is not None:
                numbers.setdefault(figure.phase, []).append(k)
        return numbers

    def limits_hold(self, values: np.ndarray, complete: np.ndarray) -> np.ndarray:
        """Whether figures (n, nf) of runs hold their limits: not where a run failed; where a run
        never came to a phase there is nothing to hold. A stage that never comes is later than any
        limit."""
        limits = np.array(self.limits)
        late = np.array([figure.is_late_if_missing for figure in self.figures])
        values = np.where(late & np.isnan(values), np.inf, values)
        held = np.where(self.least, ~(values < limits), ~(values > limits))
        return np.asarray(held & complete[:, None])


def load_limits(path: Path) -> Limits:
    """The study of limits in a YAML file; InputError says what is not valid, and which criteria are
    on channels that the case has not."""
    data = sweep.read_study(path)
    if data.operability is None or not data.criteria:
        lacks = "operability" if data.operability is None else "criteria"
        raise InputError(
            f"{path}: found no key {lacks}; expected criteria and seas, as in criteria: {{crawl:"
            " {channel: position.barge.surge, statistic: change_absolute, limit: 1 m}} and"
            " operability: {heights: {from: 0.5 m, to: 4 m, apart: 0.25 m}, peak_periods: [6 s, 8"
            " s]}."
        )
    if data.parameters or data.studies:
        raise InputError(f"{path}: found parameters and operability; expected a file for each.")
    case = load_case(path.parent / data.case, sweep.fixed_settings(data))
    scene = prepare_scene(case)
    wind_sea(scene)
    figures = tuple(c.figure(name, data.output.start) for name, c in data.criteria.items())
    with locating_in(path):
        units = run_layout.check_figures(path, [scene], figures)
        run_layout.check_units(path, data.bounds(), units)
    limits = tuple(criterion.limit.value for criterion in data.criteria.values())
    criteria = zip(data.criteria.values(), figures, strict=True)
    least = tuple(criterion.is_lower_limit(figure) for criterion, figure in criteria)
    named = [data.operability.scatter, data.operability.hindcast]
    files = (path.parent / name for name in named if name is not None)
    inputs = (path, *case.inputs(), *files)
    made_with = sweep.settings_with(data, case)
    wanted = data.operability
    return Limits(path, scene, data, wanted, figures, limits, least, units, inputs, made_with)


def limits_of(
    study: Limits,
    workers: int,
    progress: Progress = lambda *_: None,
    journal: Journal | None = None,
) -> xr.Dataset:
    """Limiting heights ``limit`` [m] by stage, swell, heading and peak period, with their intervals
    and the criterion that governs; 0 where the smallest height fails, and the largest
    height, its interval without an upper end, where that holds. A ``journal`` keeps the runs."""
    about = spectral(study.scene, study.figures, bool(study.wanted.swells))
    if not isinstance(about, Spectral):
        allowed_failures(len(study.seeds), study.wanted.probability)
    trials = Trials(study.figures, workers, journal=journal)
    heights = study.wanted.heights.values()
    limits = _empty_limits(study)
    for done, (place, sea) in enumerate(study.seas.items()):
        progress(_sea_name(sea), trials.count, done)
        before = trials.count
        if isinstance(about, Spectral):
            find = _spectral_finder(study, sea, about)
        else:
            find = _search_finder(study, sea, trials)
        for k, criteria in enumerate(study.stages().values()):
            for name, value in find(criteria).items():
                limits[name].values[(k, *place)] = value
        limits.runs.values[place] = trials.count - before
    limits["governing"] = limits.governing.astype(str)
    if study.wanted.headings:
        limits = add_mirrored_limits(limits, study.scene, study.figures, study.swells)
    is_spectral = isinstance(about, Spectral)
    limits.attrs |= {
        **study.scene.source,
        "program": f"hydrosim {program_version()}",
        "versions": versions(),
        "method": "by response spectra" if is_spectral else f"by runs: {about}",
        "runs": trials.count,
        "runs_of_all": 0 if is_spectral else len(study.seas) * len(heights) * len(study.seeds),
    }
    if trials.failed:
        limits.attrs["failed"] = (
            f"{trials.failed} runs failed and count as not held; the first: {trials.message}"
        )
    return limits


def _sea_name(sea: Sea) -> str:
    swell = f", swell {sea.swell.significant_height:g} m" if sea.swell else ""
    return f"Tp {sea.peak_period:g} s, heading {np.degrees(sea.heading):g} deg{swell}"


Finder = Callable[[list[int]], dict[str, Any]]
"""Finds the limit of some criteria in a sea: values of the variables of limits."""


def _spectral_finder(study: Limits, sea: Sea, about: Spectral) -> Finder:
    """Limits among the heights; outside them as a search has it."""
    lowest, *_, highest = study.wanted.heights.values()
    probability = study.wanted.probability
    figures = zip(study.figures, study.limits, strict=True)
    spectral_limits = [about.limit(sea, figure, limit, probability) for figure, limit in figures]

    def find(criteria: list[int]) -> dict[str, Any]:
        least = min(criteria, key=lambda k: spectral_limits[k])
        limit = spectral_limits[least]
        governing = study.figures[least].name if limit <= highest else ""
        interval = (limit, limit, limit)
        if limit < lowest:
            interval = (0.0, 0.0, lowest)
        elif limit > highest:
            interval = (highest, highest, inf)
        return {**dict(zip(INTERVAL, interval, strict=True)), "governing": governing}

    return find


def _search_finder(study: Limits, sea: Sea, trials: Trials) -> Finder:
    """Limits by bisection on the seeds of the study."""
    heights = study.wanted.heights.values()

    def outcomes(runs: Sequence[tuple[int, int]]) -> np.ndarray:
        scenes = [scene_in_sea(study.scene, sea, heights[h], study.seeds[s]) for h, s in runs]
        return study.limits_hold(*trials.values(scenes))

    search = LimitSearch(len(heights), len(study.seeds), len(study.figures), outcomes)
    values = [*heights, inf, 0.0]  # number -1: the smallest height fails

    def find(criteria: list[int]) -> dict[str, Any]:
        *numbers, inferred, otherwise = search.find_limit(criteria, study.wanted.probability)
        interval = dict(zip(INTERVAL, [values[k] for k in numbers], strict=True))
        governing = search.governing(criteria, numbers[0])
        name = "" if governing is None else study.figures[governing].name
        return {**interval, "inferred": inferred, "otherwise": otherwise, "governing": name}

    return find


def _empty_limits(study: Limits) -> xr.Dataset:
    """Limits of all seas, of which none is known."""
    descriptions = {
        "limit": ("limiting significant height: 0 below, the last above those looked at", "m"),
        "low": (f"its lower end with {CONFIDENCE:.0%}", "m"),
        "high": (f"its upper end with {CONFIDENCE:.0%}, infinite if above all", "m"),
        "inferred": ("seeds at the limit that were inferred, then run", "1"),
        "otherwise": ("of these, seeds that then failed", "1"),
        "governing": ("the criterion that fails first", ""),
        "runs": ("runs", "1"),
    }
    kinds: dict[str, type] = {"inferred": int, "otherwise": int, "runs": int, "governing": object}
    swells = [
        "none"
        if s is None
        else f"{s.significant_height:g} m, {s.peak_period:g} s, {np.degrees(s.heading):g} deg"
        for s in study.swells
    ]
    periods = np.array(study.wanted.peak_periods)
    coordinates = {
        "stage": [*study.stages()],
        "swell": swells,
        "heading": describe_values("heading", np.array(study.headings), "where waves go to", "rad"),
        "peak_period": describe_values("peak_period", periods, "peak period", "s"),
    }
    sizes = (len(study.stages()), len(swells), len(study.headings), periods.size)
    variables = {}
    for name, about in descriptions.items():
        first = 1 if name == "runs" else 0  # runs are of all stages
        kind = kinds.get(name, float)
        values: np.ndarray = np.full(sizes[first:], "" if kind is object else 0, kind)
        variables[name] = describe_values((*coordinates,)[first:], values, *about)
    heights = study.wanted.heights
    attributes = {
        KIND: ResultKind.OPERABILITY.value,
        "title": study.scene.title,
        "probability": study.wanted.probability,
        "confidence": CONFIDENCE,
        "seeds": len(study.seeds),
        "criteria": "\n".join(_criterion_texts(study)),
        "lowest": heights.values()[0],
        "highest": heights.values()[-1],
        "apart": heights.apart,
    }
    return describe_coordinates(xr.Dataset(variables, coordinates, attributes))


def _criterion_texts(study: Limits) -> Iterator[str]:
    units = units_of(study.scene.source)
    criteria = zip(study.figures, study.limits, study.least, strict=True)
    for figure, limit, least in criteria:
        side = "at least" if least else "at most"
        asked = text_of(Value(limit, study.units.get(figure.name, "")), units)
        yield f"{figure.name}: {figure} {side} {asked}"
