"""`run_study`: the runs of a study into one file."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from math import inf, isnan
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from hydrosim.documents.yaml_nodes import locating_in
from hydrosim.errors import InputError
from hydrosim.leftovers import check_folder, has_mark, is_folder, remove_folder
from hydrosim.locks import is_lock
from hydrosim.results.dataset import write_run
from hydrosim.results.journal import is_part, remove_journal
from hydrosim.results.runs_file import RUN
from hydrosim.results.validation import DESIGN
from hydrosim.statistics import effects
from hydrosim.studies.many.many import simulate_many
from hydrosim.studies.many.run_layout import one_scene_of_each_kind
from hydrosim.studies.many.shared import SceneCache
from hydrosim.studies.many.unfinished import identity, is_complete
from hydrosim.studies.run.checkpoint import digest
from hydrosim.studies.sweep.study import (
    ParameterStudy,
    check_figures,
    check_units,
    scenes_with_seeds,
)

if TYPE_CHECKING:
    from hydrosim.outputs import Output
    from hydrosim.studies.many.executors import Pool
    from hydrosim.studies.many.many import Progress
    from hydrosim.studies.study_file import SeedTarget


def run_study(
    study: ParameterStudy,
    output: Path | Output,
    workers: int | None = None,
    progress: Progress | None = None,
    resume: bool = False,
    pool: Pool | None = None,
) -> xr.Dataset:
    """Run a study into the file ``output``, see `simulate_many`. Raises InputError first where its
    runs have no such figures."""
    file = study.inputs[0]
    kinds = one_scene_of_each_kind(study.scenes) if study.figures else []
    with locating_in(file), _named_as(f"{file}: output:"):
        check_units(file, study.bounds, check_figures(file, kinds, study.figures))
        return simulate_many(
            study.scenes,
            output,
            variables=study.kept.variables,
            channels=study.kept.channels,
            labels=study.labels,
            figures=study.figures,
            attributes={DESIGN: study.design},
            start=study.kept.start,
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


# More and more seeds, until the mean of a figure is known as narrowly as is asked for.

ROUND_NAME_PATTERN = r"\d+-[0-9a-f]{16}\.nc"
"""Names of rounds: the number, and what the round is of."""
Run = Callable[[ParameterStudy, Path], xr.Dataset]
"""Makes the runs of a study into a file, those that are kept of it taken over."""


def run_until(
    study: ParameterStudy,
    seeds: tuple[int, ...],
    wanted: SeedTarget,
    run: Run,
    output: Output,
    resume: bool = False,
) -> str:
    """Runs in rounds, each with as many seeds as all before it, into the file ``output``; says in
    words how wide the widest interval is, and of how many seeds.

    Rounds are kept until the end in the folder ``output``.rounds, under names that say what they
    are of: as the seeds of a round follow from those before it, a study that was killed goes on
    with ``resume``. Raises InputError where rounds would be lost, or are of another study."""
    all_seeds = list(seeds)
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
            part = replace(with_seeds(study, len(seeds), new), first=runs.sizes[RUN])
            all_seeds = [*all_seeds, *new]
        write_run(runs, output)
        for each in rounds:
            each.close()
        _clear(folder)
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


def _begin_rounds(folder: Path, resume: bool, output: Output) -> None:
    """Begins anew, unless rounds are to be taken up; refuses to lose any that nobody has said may
    go, and to touch what is of others."""
    check_folder(folder, _is_round)
    if not resume and any(folder.glob("*")) and not output.overwrite:
        raise InputError(
            f"{folder}: holds rounds of a study that did not come to its end; --resume goes on from"
            " them (resume=True in Python), --overwrite begins anew."
        )
    if not resume:
        _clear(folder)
    folder.mkdir(exist_ok=True)


def _is_round(path: Path) -> bool:
    """Whether a path is that of a round, of one on its way with all that is in it, or of the lock
    of one that was killed."""
    if re.fullmatch(ROUND_NAME_PATTERN, path.name):
        return has_mark(path, "sweep")
    if re.fullmatch(rf"{ROUND_NAME_PATTERN}\.partial", path.name):
        return is_folder(path) and all(map(is_part, path.iterdir()))
    return bool(re.fullmatch(rf"\.hydrosim-{ROUND_NAME_PATTERN}\.lock", path.name)) and is_lock(
        path
    )


def _clear(folder: Path) -> None:
    for path in folder.glob("*.partial"):
        if _is_round(path):
            remove_journal(path)
    remove_folder(folder, _is_round)


def _make_round(
    part: ParameterStudy, number: int, shared: SceneCache, folder: Path, run: Run
) -> xr.Dataset:
    """The runs of a round: those that are there, if they are all and of this study."""
    request = {"figures": part.figures, "kept": repr(part.kept), "design": part.design}
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
    if path.exists() and is_complete(path):
        return xr.open_dataset(path, engine="netcdf4")
    return run(part, path)


def widest_interval(runs: xr.Dataset, figure: str) -> float:
    """The width of the widest interval of the mean of a figure over all combinations, infinite
    where there are too few values."""
    rows = [row for plan in effects.plans(runs) for row in effects.rows(plan)]
    widths = [row.spread.high - row.spread.low for row in rows if row.figure == figure]
    return max((inf if isnan(width) else width for width in widths), default=inf)


def with_seeds(study: ParameterStudy, count: int, new: list[int]) -> ParameterStudy:
    """The same combinations, of which the study has so many seeds each, with others."""
    scenes = [sea for scene in study.scenes[::count] for sea in scenes_with_seeds(scene, new)]
    labels = {
        name: xr.Variable(RUN, np.repeat(label.values[::count], len(new)), label.attrs)
        for name, label in study.labels.items()
    }
    return replace(study, scenes=tuple(scenes), labels=labels)
