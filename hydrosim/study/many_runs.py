"""Many runs at once into one file: of cases, of a study, or until a mean is known well enough.

What the runs have in common is made once: databases are opened once, and a run that differs from
the one before it in its waves alone takes over its compiled model, its state at the start and its
step limits. Time loops do without Python's lock, so that threads are enough. Results are written
run by run in the order of the cases, whatever the order in which they finish.
"""

from __future__ import annotations

import fnmatch
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Sized
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import partial
from math import inf, isnan
from os import PathLike
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from hydrosim.elements import externals_of
from hydrosim.errors import HydrosimError, InputError
from hydrosim.files import arguments, outputs
from hydrosim.files.locks import is_lock
from hydrosim.files.yaml_nodes import locating_in
from hydrosim.results import runs_file
from hydrosim.results.dataset import KIND, ResultKind, write_run
from hydrosim.results.runs_file import KNOWN, RESULT, RUN, Journal, RunOutcome, RunsWriter
from hydrosim.results.validation import DESIGN
from hydrosim.results.variables import quantity_attributes
from hydrosim.run.checkpoint import digest
from hydrosim.scene import Scene
from hydrosim.simulation import prepare_scene
from hydrosim.statistics import effects
from hydrosim.statistics.statistics import CHANNEL_VARIABLES
from hydrosim.study import run_layout
from hydrosim.study.executors import Threads, make_runs
from hydrosim.study.scene_cache import RunTask, SceneCache, identity
from hydrosim.study.sweep import (
    ParameterStudy,
    figures_by_name,
)

if TYPE_CHECKING:
    import pandas as pd

    from hydrosim.case import Case
    from hydrosim.statistics.figures import RequestedStatistic, ScalarResult
    from hydrosim.statistics.results import MotionCauseResult, StageResult
    from hydrosim.study.executors import Pool
    from hydrosim.study.study_file import SeedTarget

ESTIMATE_INTERVAL = (
    50  # runs, of which the first measures its error: at most 2 % of the cost of all
)
ESTIMATE_NOTE = f"errors are measured in run 0 and in every {ESTIMATE_INTERVAL}th run after it"
MAX_MESSAGES = 5  # messages of runs that are refused
MIN_OUTPUT_TIMES = 4  # output times, to have statistics of

Progress = Callable[[int, int], None]
"""Called after each run with the number of runs that are done and that of all."""


def simulate_many(
    cases: Iterable[Case | Scene | str | Path],
    output: str | PathLike[str] | None = None,
    *,
    variables: Sequence[str] = ("position",),
    channels: Sequence[str] = (),
    labels: Mapping[str, Sequence[object] | xr.Variable] | pd.DataFrame | None = None,
    figures: Sequence[ScalarResult | StageResult | MotionCauseResult]
    | Mapping[str, Mapping[str, object]] = (),
    attributes: Mapping[str, str] | None = None,
    start: float | str = 0.0,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    resume: bool = False,
    pool: Pool | None = None,
    first: int = 0,
) -> xr.Dataset:
    """Run all cases, files of cases or scenes, on as many cores as there are ``workers``, by
    default all, or by a ``pool`` of others (`hydrosim.study.cluster`), which is closed in
    the end.

    The dataset has a dimension ``run``, in the order of the cases, and of each run

    * the ``variables`` chosen from its own dataset, at every output time,
    * its `statistics` from ``start`` [s] on, also of the ``channels`` that patterns fit,
    * `end_position`, and the time of the `first_contact`,
    * the ``figures`` that are asked for, as in a study file by name: ``{"crawl": {"channel":
      "position.barge.surge", "statistic": "change"}}``,
    * ``seed``, and the ``labels`` that are given, with the attributes that these have; a frame of
      pandas has a row for each run. Wave trains with seeds of their own also have ``seed_2`` and
      so on,
    * ``status``, and ``status_message`` where it is not "complete".

    It is the same to the bit as that of single runs, and to the byte whatever the number of
    workers. With ``output`` it is in that netCDF file, and what is returned reads from there when
    asked; else it is in memory. Each run is kept in a folder, ``output``.partial, once it is done:
    a set that was killed or interrupted goes on from there with ``resume``, to the same result.

    Run 0 and every 50th after it measure their errors: ``error_relative`` is NaN in others, and
    their ``warnings`` say nothing of it. `simulate` measures that of any run, and makes one by
    ``automatic`` again if it misses its tolerance; here that is told alone. Runs of a part of a
    longer set count from ``first``, their place in it.

    All runs have one duration and one output step. Names that not all runs have, of contacts,
    elements or bodies, are padded (`hydrosim.study.run_layout`); the attribute
    ``runs_differ`` says which. A run that cannot go on is marked "failed" and the others go on; it
    has no values. After an interrupt from the keyboard the runs done until then are returned, and
    others marked. Raises InputError where the runs do not fit together, where every run would be
    refused before its first step, or where the file must not be replaced; WritingError where it
    cannot be written.

        seas = [replace(scene, environment=in_waves(seed)) for seed in range(1, 101)]
        runs = simulate_many(seas, "seeds.nc")
        runs.motion.sel(dof="surge", statistic="largest").quantile(0.9)

    >>> case = hs.load_case("cases/friction_block/exact.yaml", {"duration": "20 s"})
    >>> hs.simulate_many([case, case], labels={"trial": [1, 2]}).status.values.tolist()
    ['complete', 'complete']
    """
    if isinstance(cases, str | Path):
        raise InputError("found one file; expected several cases: hs.simulate_many([...]).")
    start = arguments.seconds("start", start)
    channels = arguments.names_in(channels)
    variables = arguments.names_in(variables)
    if isinstance(figures, Mapping):
        figures = figures_by_name(figures, start)
    labels = {} if labels is None else {str(name): labels[name] for name in labels}
    scenes = [prepare_scene(case) for case in cases]
    _check_labels(scenes, labels, start)
    along = {**_seed_labels(scenes), **{name: _new_variable(of) for name, of in labels.items()}}
    data_of_runs = along | _source_labels(scenes)
    request: dict[str, Any] = {"variables": (*variables,), "start": start, "figures": (*figures,)}
    request |= {"channels": (*channels,)} if channels else {}
    reduce = partial(run_layout.reduce_run, **request)
    trial = partial(reduce, start=0.0)
    _check_names(scenes[0], figures)
    layout = run_layout.merge_layouts(scenes, partial(trial, lenient=True))
    if not _has_requested(layout, [*variables, *(f.name for f in figures)], channels):
        run = run_layout.try_scene(scenes[0])
        if not isinstance(run, HydrosimError):
            trial(run)  # it has what is asked for
    if layout is not None:
        reduce = partial(reduce, lenient=True, layout=layout)

    cache = SceneCache()
    result = None if output is None else outputs.as_output(output, "sweep")
    attributes_of_file = {
        **({} if result is None else result.attributes),
        KIND: ResultKind.SET.value,
        "error_estimates": ESTIMATE_NOTE,
        **({} if layout is None else run_layout.attributes_of_layout(layout)),
        **(attributes or {}),
    }

    def new_file(path: Path) -> RunsWriter:
        return RunsWriter(path, len(scenes), data_of_runs, along, attributes_of_file)

    def write(path: Path, journal: Journal | None) -> Path:
        def compile_task(run: int) -> RunTask | Exception:
            if run == 0 and not journal:
                _check_possible(scenes, cache)
            return cache.compile_task(scenes[run], (first + run) % ESTIMATE_INTERVAL == 0)

        def take(run: int, outcome: RunOutcome) -> None:
            outcome = file.add(run, outcome)
            if journal is not None and outcome.status == "failed":
                journal.add(run, outcome)

        executor = pool or Threads(workers or os.cpu_count() or 1)
        with new_file(path) as file:
            runs = range(len(scenes))
            make_runs(runs, compile_task, reduce, executor, take, journal, progress)
        return path

    if result is None:
        with TemporaryDirectory() as folder:
            path = write(Path(folder, RESULT), None)
            return runs_file.index_by_seed(xr.load_dataset(path, engine="netcdf4"))
    values = {name: variable.values for name, variable in along.items()}
    set_identity = identity(scenes, cache.open_sources, values, request)
    partial_folder = runs_file.folder_of(result)
    with runs_file.locked_journal(result, resume, set_identity) as journal:
        new_file(partial_folder / f"{KNOWN}.partial").close()
        journal.take_known(partial_folder / f"{KNOWN}.partial")
        path = write(partial_folder / RESULT, journal)
        all_ended = runs_file.is_complete(path)
        is_worse = not all_ended and runs_file.is_complete(result.path)
        place = result.fallback_path() if is_worse else result.resolve_path()
        place.take(path)
        if all_ended:
            journal.remove()
    return runs_file.index_by_seed(xr.open_dataset(place.path, engine="netcdf4"))


def _check_labels(scenes: Sequence[Scene], labels: Mapping[str, Sized], start: float) -> None:
    """Refuse what does not fit into one dataset."""
    if not scenes:
        raise InputError("simulate_many: found no case; expected one or more.")
    for name, values in labels.items():
        if len(values) != len(scenes):
            raise InputError(
                f"labels.{name}: found {len(values)} values; expected one for each of the"
                f" {len(scenes)} runs."
            )
    first = scenes[0]
    for run, scene in enumerate(scenes):
        if functions := externals_of(scene.forces):
            raise InputError(
                f"simulate_many: found functions of Python in run {run}, {', '.join(functions)};"
                " expected none, because runs are made in other processes. Run such cases one by"
                " one with hydrosim.simulate."
            )
        for what, of_first, of_run in (
            ("duration", first.duration, scene.duration),
            ("output_step", first.output_step, scene.output_step),
        ):
            if of_first != of_run:
                raise InputError(
                    f"simulate_many: found {what} {of_first} in run 0 and {of_run} in run {run};"
                    " expected the same in all."
                )
    if first.initial is None and not start + MIN_OUTPUT_TIMES * first.output_step <= first.duration:
        raise InputError(
            f"simulate_many: found start {start:g} s; expected a time well before the end of the"
            f" runs, {first.duration:g} s."
        )


def _has_requested(
    layout: xr.Dataset | None, names: Sequence[str], patterns: Sequence[str]
) -> bool:
    """Whether some run has what is asked for, as far as it is known before the first."""
    if layout is None:
        return not patterns
    channels = layout.attrs[run_layout.CHANNELS]
    fits = (fnmatch.filter(channels, pattern) for pattern in patterns)
    return all(fits) and all(name in layout.data_vars for name in names)


def _check_names(scene: Scene, figures: Iterable[RequestedStatistic]) -> None:
    """Raises InputError where a figure has the name of a dimension or statistic of the runs."""
    layout = run_layout.names_layout(scene)
    if layout is not None:
        dims = {*map(str, layout.dims)} - run_layout.NAMES_OF_LAYOUT
        statistics = [name for name, (_, of, _) in CHANNEL_VARIABLES.items() if dims.issuperset(of)]
        run_layout.check_figure_names([*figures], {*dims, *statistics})


def _seed_labels(scenes: Sequence[Scene]) -> dict[str, xr.Variable]:
    """Seeds of the runs as coordinates; none if the runs have different numbers of wave trains.
    ``seed`` is that of the first train. Where trains and gusts have other seeds, these follow as
    ``seed_2`` and so on."""
    seeds = [scene.environment.seeds for scene in scenes]
    if not seeds[0] or len({len(seeds) for seeds in seeds}) > 1:
        return {}
    first, *others = np.array(seeds).T
    variables = {"seed": xr.Variable(RUN, first, quantity_attributes("seed of the waves", "1"))}
    if any((other != first).any() for other in others):
        for k, other in enumerate(others, 2):
            attributes = quantity_attributes(f"seed of wave train {k}, or of the gusts", "1")
            variables[f"seed_{k}"] = xr.Variable(RUN, other, attributes)
    return variables


def _new_variable(values: Sequence[object] | np.ndarray | xr.Variable) -> xr.Variable:
    """What is known of all runs, with its attributes if it has any."""
    if isinstance(values, xr.Variable):
        return values
    is_text = isinstance(next(iter(values), None), str)
    # texts as objects: each of them once, and not as long as the longest
    array = np.array(values, dtype=object) if is_text else np.asarray(values)
    return xr.Variable((RUN, *(f"{k}" for k in range(1, array.ndim))), array)


def _source_labels(scenes: Sequence[Scene]) -> dict[str, xr.Variable]:
    """Where the scenes come from, as far as they differ in it."""
    texts = {
        name: [str(scene.source.get(name, "")) for scene in scenes] for name in scenes[0].source
    }
    return {name: _new_variable(text) for name, text in texts.items() if len({*text}) > 1}


def _check_possible(scenes: Sequence[Scene], cache: SceneCache) -> None:
    """Raises InputError where every run is refused before its first step. No more is looked at than
    up to the first scene that can be run."""
    refused: dict[str, None] = {}
    for scene in scenes:
        task = cache.compile_task(scene)
        if not isinstance(task, HydrosimError):
            return
        refused[str(task)] = None
    more = len(refused) - MAX_MESSAGES
    overflow = [f"and {more} more messages"] if more > 0 else []
    messages = "\n".join([*list(refused)[:MAX_MESSAGES], *overflow])
    count = len(scenes)
    subject = "The run is" if count == 1 else f"All {count} runs are"
    raise InputError(f"{messages}\n{subject} refused before the first step.")


# `run_study`: the runs of a study into one file.


def run_study(
    study: ParameterStudy,
    output: Path | outputs.Output | None,
    workers: int | None = None,
    progress: Progress | None = None,
    resume: bool = False,
    pool: Pool | None = None,
) -> xr.Dataset:
    """Run a study into the file ``output``, or in memory, see `simulate_many`. Raises InputError
    first where its runs have no such figures."""
    file = study.inputs[0]
    kinds = run_layout.one_scene_of_each_kind(study.scenes) if study.figures else []
    with locating_in(file), _named_as(f"{file}: output:"):
        units = run_layout.check_figures(file, kinds, study.figures)
        run_layout.check_units(file, study.data.bounds(), units)
        return simulate_many(
            study.scenes,
            output,
            variables=study.data.output.variables,
            channels=study.data.output.channels,
            labels=study.labels,
            figures=study.figures,
            attributes={KIND: ResultKind.STUDY.value, DESIGN: study.design},
            start=study.data.output.start,
            workers=workers,
            progress=progress,
            resume=resume,
            pool=pool,
            first=study.first,
        )


@contextmanager
def _named_as(place: str) -> Iterator[None]:
    """Names a ``place`` in the study file where a message names the function that is called."""
    try:
        yield
    except InputError as error:
        raise InputError(str(error).replace("simulate_many:", place)) from None


# `run_until`: more seeds, until the interval of a mean is as narrow as is asked for.

ROUND_NAME_PATTERN = r"\d+-[0-9a-f]{16}\.nc"
"""Names of rounds: the number, and what the round is of."""
Run = Callable[[ParameterStudy, Path], xr.Dataset]
"""Makes the runs of a study into a file, those that are kept of it taken over."""


def run_until(study: ParameterStudy, run: Run, output: outputs.Output, resume: bool = False) -> str:
    """Runs a study in rounds, each with as many seeds as all before it, into the file ``output``;
    says in words how wide the widest interval is, and of how many seeds.

    Rounds are kept until the end in the folder ``output``.rounds, under names that say what they
    are of: as the seeds of a round follow from those before it, a study that was killed goes on
    with ``resume``. Raises InputError where rounds would be lost, or are of another study."""
    wanted = study.data.until
    assert wanted is not None
    all_seeds = [*study.seeds]
    part = study
    folder = Path(f"{output.path}.rounds")
    shared = SceneCache()
    with output.hold_lock(), _remove_if_empty(folder):
        _begin_rounds(folder, resume, output)
        rounds: list[xr.Dataset] = []
        while True:
            one_round = _make_round(part, len(rounds), shared, folder, run)
            rounds.append(one_round.drop_indexes("seed", errors="ignore"))
            runs = xr.concat(rounds, RUN, data_vars="all", combine_attrs="override")
            runs = runs.assign_coords({RUN: np.arange(runs.sizes[RUN])})
            width = widest_interval(runs, wanted.figure)
            count = len(all_seeds)
            count_of_new = min(count, wanted.most - count)
            if width <= wanted.wide.value or count_of_new <= 0 or wanted.figure not in runs:
                break
            new = [max(all_seeds) + 1 + k for k in range(count_of_new)]
            part = replace(study.with_seeds(new), first=runs.sizes[RUN])
            all_seeds = [*all_seeds, *new]
        write_run(runs, output)
        for batch in rounds:
            batch.close()
        _clear_folder(folder)
    unit = str(runs[wanted.figure].attrs.get("units", "")) if wanted.figure in runs else ""
    return _width_text(width, unit, count, wanted)


@contextmanager
def _remove_if_empty(folder: Path) -> Iterator[None]:
    """Leaves no folder of rounds without a round."""
    try:
        yield
    finally:
        with suppress(OSError):  # it holds some, or is gone
            folder.rmdir()


def _width_text(width: float, unit: str, count: int, wanted: SeedTarget) -> str:
    if width == inf:
        return f"{count} seeds: some combination has fewer than two values of {wanted.figure}"
    wide = wanted.wide.value
    unit = unit and f" {unit}"
    text = f"{count} seeds: the widest 90 % interval of the mean of {wanted.figure} is"
    text += f" {width:.3g}{unit}"
    return text if width <= wide else f"{text}, not {wide:g}{unit} as asked for"


def _begin_rounds(folder: Path, resume: bool, output: outputs.Output) -> None:
    """Begins anew, unless rounds are to be taken up; refuses to lose any that nobody has said may
    go, and to touch what is of others."""
    outputs.check_folder(folder, _is_round)
    if not resume and any(folder.glob("*")) and not output.overwrite:
        raise InputError(
            f"{folder}: holds rounds of a study that did not come to its end; --resume goes on from"
            " them (resume=True in Python), --overwrite begins anew."
        )
    if not resume:
        _clear_folder(folder)
    folder.mkdir(exist_ok=True)


def _is_round(path: Path) -> bool:
    """Whether a path is that of a round, of one on its way with all that is in it, or of the lock
    of one that was killed."""
    if re.fullmatch(ROUND_NAME_PATTERN, path.name):
        return outputs.has_mark(path, "sweep")
    if re.fullmatch(rf"{ROUND_NAME_PATTERN}\.partial", path.name):
        return outputs.is_folder(path) and all(map(runs_file.is_part, path.iterdir()))
    return bool(re.fullmatch(rf"\.hydrosim-{ROUND_NAME_PATTERN}\.lock", path.name)) and is_lock(
        path
    )


def _clear_folder(folder: Path) -> None:
    for path in folder.glob("*.partial"):
        if _is_round(path):
            runs_file.remove_journal(path)
    outputs.remove_folder(folder, _is_round)


def _make_round(
    part: ParameterStudy, number: int, shared: SceneCache, folder: Path, run: Run
) -> xr.Dataset:
    """The runs of a round: those that are there, if they are all and of this study."""
    request = {"figures": part.figures, "kept": repr(part.data.output), "design": part.design}
    labels = {name: label.values for name, label in part.labels.items()}
    state = digest(identity(part.scenes, shared.open_sources, labels, request))
    path = folder / f"{number}-{state[:16]}.nc"
    other_files = {
        file for file in folder.glob(f"{number}-*") if not file.name.startswith(path.name)
    }
    if other_files and number == 0:
        raise InputError(
            f"--resume: these have changed since the runs in {folder} were made: the program, a"
            " database, or the study. Restore them to go on, or begin anew with --overwrite, which"
            " replaces the finished runs."
        )
    if path.exists() and runs_file.is_complete(path):
        return xr.open_dataset(path, engine="netcdf4")
    return run(part, path)


def widest_interval(runs: xr.Dataset, figure: str) -> float:
    """The width of the widest interval of the mean of a figure over all combinations, infinite
    where there are too few values."""
    rows = [row for plan in effects.plans(runs) for row in effects.rows(plan)]
    widths = [row.spread.high - row.spread.low for row in rows if row.figure == figure]
    return max((inf if isnan(width) else width for width in widths), default=inf)
