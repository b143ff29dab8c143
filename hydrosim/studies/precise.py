"""More and more seeds, until the mean of a figure is known as narrowly as is asked for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import inf, isnan
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import xarray as xr

from hydrosim.outputs import Output
from hydrosim.results import effects
from hydrosim.results.output import write
from hydrosim.results.runs_file import RUN
from hydrosim.studies.study_file import Enough
from hydrosim.studies.sweep import Study, seas

Run = Callable[[Study, Path], xr.Dataset]
"""Makes the runs of a study into a file."""


def run_until(
    study: Study, seeds: tuple[int, ...], wanted: Enough, run: Run, output: Output
) -> str:
    """Runs in rounds, each with as many seeds as all before it, into the file ``output``; says in
    words how wide the widest interval is, and of how many seeds."""
    known, part = list(seeds), study
    with TemporaryDirectory() as folder:
        rounds: list[xr.Dataset] = []
        while True:
            rounds.append(run(part, Path(folder, f"{len(rounds)}.nc")))
            runs = xr.concat(rounds, RUN, data_vars="all", combine_attrs="override")
            runs = runs.assign_coords({RUN: np.arange(runs.sizes[RUN])})
            width, count = widest(runs, wanted.figure), len(known)
            more = min(count, wanted.most - count)
            if width <= wanted.wide.value or more <= 0 or wanted.figure not in runs:
                break
            new = [max(known) + 1 + k for k in range(more)]
            part, known = with_seeds(study, len(seeds), new), [*known, *new]
        write(runs, output)
        for each in rounds:
            each.close()
    if width == inf:
        return f"{count} seeds: some combination has fewer than two values of {wanted.figure}"
    said = f"{count} seeds: the widest 90 % interval of the mean of {wanted.figure} is {width:.3g}"
    return said + (
        "" if width <= wanted.wide.value else f", not {wanted.wide.value:g} as asked for"
    )


def widest(runs: xr.Dataset, figure: str) -> float:
    """The width of the widest interval of the mean of a figure over all combinations, infinite
    where there are too few values."""
    rows = [row for plan in effects.plans(runs) for row in effects.rows(plan)]
    widths = [row.spread.high - row.spread.low for row in rows if row.figure == figure]
    return max((inf if isnan(width) else width for width in widths), default=inf)


def with_seeds(study: Study, count: int, new: list[int]) -> Study:
    """The same combinations, of which the study has so many seeds each, with others."""
    scenes = [sea for scene in study.scenes[::count] for sea in seas(scene, new)]
    labels = {
        name: xr.Variable(RUN, np.repeat(label.values[::count], len(new)), label.attrs)
        for name, label in study.labels.items()
    }
    return replace(study, scenes=tuple(scenes), labels=labels)
