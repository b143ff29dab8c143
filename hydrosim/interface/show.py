"""What a result shows of itself: its summary, statistics, why a body moved, pictures, a page.

Each function takes a dataset, or the file of a result; of an unfinished study, its folder.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from math import inf
from pathlib import Path

import numpy as np
import xarray as xr

from hydrosim.errors import InputError
from hydrosim.files import arguments
from hydrosim.files.document import Document
from hydrosim.interface import printed
from hydrosim.report.sentences.sections import SUMMARIES, summary_of
from hydrosim.results.channels import channel_names, match_channels
from hydrosim.results.dataset import read_run, write_run
from hydrosim.results.runs_file import COMPLETE, GATHERED, is_of_runs, open_result, runs_at
from hydrosim.simulation import open_run
from hydrosim.statistics import explain as explaining
from hydrosim.statistics import statistics as stats
from hydrosim.statistics.effects import combinations, plans

Result = xr.Dataset | str | Path
MIN_EXTREME_SHARE = 0.1
"""Shortest duration of extremes, as a part of the record."""


def _read(result: Result, read: Callable[[Path], xr.Dataset] = read_run) -> xr.Dataset:
    """Dataset of one run or of many."""
    if isinstance(result, xr.Dataset):
        return result
    path = Path(result)
    runs = runs_at(path)
    return read(path) if runs is None else runs


# Summary.


def summarise(result: Result) -> printed.PrintedResult:
    """The summary of a result of any kind."""
    stored = None if isinstance(result, xr.Dataset) else open_result(Path(result), SUMMARIES)
    dataset = _read(result) if stored is None else stored
    lines = status_lines(dataset) if is_of_runs(dataset) else []
    return printed.PrintedResult(summary_of(dataset), dataset, lines=tuple(lines))


def status_lines(runs: xr.Dataset) -> list[str]:
    """Numbers of runs by status if not all are complete, and the reason why the first failed."""
    if GATHERED in runs.attrs:
        return [f"so far    {runs.attrs[GATHERED]}"]
    if "status" not in runs or set(statuses := runs.status.values.tolist()) == {COMPLETE}:
        return []
    from hydrosim.report.sentences.study import counts_by_status

    first = statuses.index("failed") if "failed" in statuses else None
    failed = [f"run {first}: {runs.status_message.values[first]}"] if first is not None else []
    return [counts_by_status(runs), *failed]


# Statistics.


def find_extremes(
    result: Result,
    *,
    start: arguments.Amount | None = None,
    duration: arguments.Amount | None = None,
    channels: arguments.Names = (),
    output: arguments.Target = None,
    overwrite: bool = False,
) -> printed.PrintedResult:
    """Means, periods and extremes with confidence intervals, and crawl in each contact phase, from
    ``start`` on.

    They cover motions, contacts, lines and the additional ``channels``, which may be patterns such
    as "speed.*". Extremes are those of a ``duration``, by default of the record. Of many runs, the
    result is that of each figure over the runs. With ``output``, files are written as by `hydrosim
    show --statistics`. Raises InputError if hardly any record is left after ``start``.
    """
    path = printed.source_of(result)
    runs = result if isinstance(result, xr.Dataset) else runs_at(path)
    if runs is not None and is_of_runs(runs):
        table = printed.table_output(output, path, overwrite=overwrite)
        files = (printed.write_table(runs, table),) if table else ()
        from hydrosim.report.sentences.study import study_tables

        return printed.PrintedResult(study_tables(runs), runs, files)
    if not isinstance(result, xr.Dataset):
        arguments.require_file(path, "the result of a run or of a study (RUN.nc)")
    name = f"{path.stem}_statistics"
    target = arguments.output_for(output, name, "statistics", path, overwrite=overwrite)
    run = _read(result)
    begin, end = arguments.seconds("start", start), float(run.time[-1])
    if not stats.has_enough_records(run, begin):
        raise InputError(
            f"start: found {begin:g} s; expected a time well before the end of the run at"
            f" {end:g} s."
        )
    least = MIN_EXTREME_SHARE * (end - max(begin, float(run.time[0])))
    exposure = arguments.seconds("duration", duration, inf) if duration not in (None, "") else None
    if exposure is not None and not least <= exposure < inf:
        raise InputError(
            f"duration: found {exposure:g} s; expected at least a tenth of the record,"
            f" {least:g} s. The record itself holds many samples of shorter durations."
        )
    all_channels = channel_names(run)
    patterns = arguments.names_in(channels)
    if any(name.startswith("utilisation.") for name in all_channels):
        patterns.append("utilisation.*")
    picked = match_channels(all_channels, patterns, "channels")
    dataset = stats.statistics(run, begin, exposure, picked)
    if target:
        write_run(dataset, target)
    from hydrosim.report.sentences.statistics import statistics_document

    document = statistics_document(run, dataset)
    remarks = tuple(printed.incomplete_run_warnings(run.attrs))
    return printed.PrintedResult(document, dataset, (target.path,) if target else (), remarks)


# Why a body moved.

Parts = dict[str, xr.Dataset]
"""Runs to explain, by name: one run, or each combination of parameters of a study."""


def explain(
    result: Result,
    *,
    direction: str = "surge",
    start: arguments.Amount | None = None,
    end: arguments.Amount | None = None,
    output: arguments.Target = None,
    overwrite: bool = False,
) -> printed.PrintedResult:
    """Why a body moved in a ``direction``, "surge" or "barge.surge": mean forces, causes of
    friction, displacement and work by contact mode, from ``start`` to ``end``.

    The run needs `output: {impulses: true}`. Of many runs, the text has means over the runs of each
    combination of parameters, with 90 % intervals. Without its name, it is the body that moves
    most. With ``output``, files are written as by `hydrosim show --why`.
    """
    from hydrosim.report.charts.explain import draw_explained
    from hydrosim.report.sentences.explanation import explanation_document

    body, _, direction = direction.rpartition(".")
    if direction not in explaining.DIRECTION_AXES:
        known = ", ".join(explaining.DIRECTION_AXES)
        raise InputError(f"direction: found {direction}; expected one of {known}.")
    path = printed.source_of(result)
    runs = result if isinstance(result, xr.Dataset) else runs_at(path)
    if not isinstance(result, xr.Dataset):
        arguments.require_file(path, "the result of a run or of a study (RUN.nc)")
    name = f"{printed.stem_of(path)}_explained"
    target = arguments.output_for(output, name, "explanation", path, overwrite=overwrite)
    page = arguments.picture_beside(target)
    between = arguments.window_of(start, end)
    run = read_run(path) if runs is None else runs
    try:
        if is_of_runs(run):
            explanations, parts = _explain_runs(run, between)
        else:
            explanations = explaining.explain_run(run, *between)
            parts = {"": explanations}
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    moved = _choose_body(explanations, direction, body)
    if target and page:
        write_run(explanations, target)
        first, of_first = next(iter(parts.items()))
        draw_explained(run, of_first, moved, direction, page, first)
    document = explanation_document(run, parts, moved, direction)
    files = (target.path, page.path) if target and page else ()
    return printed.PrintedResult(document, explanations, files, tuple(status_lines(run)))


def _explain_runs(runs: xr.Dataset, between: tuple[float, float]) -> tuple[xr.Dataset, Parts]:
    if between != (-inf, inf):
        raise InputError("found a study; expected one run, because of a start or an end.")
    explanations = explaining.explanations_of_runs(runs)
    complete = runs.status.values == COMPLETE
    if not complete.any():
        raise InputError("found no complete run; see the variable status_message of the file.")
    return explanations, {
        name: explanations.isel(run=at)
        for name, at in _runs_by_combination(runs)
        if complete[at].any()
    }


def _runs_by_combination(runs: xr.Dataset) -> Iterator[tuple[str, np.ndarray]]:
    """Name of each combination of parameters of a study, with the indices of its runs."""
    from hydrosim.report.sentences.statistics import named_values

    if "design" not in runs.attrs:
        yield "", np.arange(runs.sizes["run"])
        return
    for plan in plans(runs):
        plan_runs = np.flatnonzero(np.isin(runs.run.values, plan.runs.run.values))
        for values, at in combinations(plan):
            values_text = named_values(plan, values)
            yield ": ".join(part for part in (plan.name, values_text) if part), plan_runs[at]


def _choose_body(explanations: xr.Dataset, direction: str, name: str) -> str:
    """Body that was asked for, or the one that moves most."""
    body_names = [str(body) for body in explanations.body.values]
    if name and name not in body_names:
        raise InputError(
            f"direction: found {name}.{direction}; expected a body of {', '.join(body_names)}."
        )
    displacement = abs(explanations.displacement.sel(dof=direction)).fillna(0.0)
    moved = displacement.max([dim for dim in displacement.dims if dim != "body"]).values
    return name or (body_names[int(moved.argmax())])


# Pictures.


def draw_pictures(
    result: Result,
    folder: str | Path | None = None,
    *,
    channels: arguments.Names = (),
    start: arguments.Amount | None = None,
    end: arguments.Amount | None = None,
    format: str = "png",
    overwrite: bool = False,
) -> printed.PrintedResult:
    """Draw the pictures of a run, or the figures of a study, into a ``folder``, by default that of
    the result.

    ``channels`` are drawn in one picture instead, whose name ``folder`` may be. The pictures cover
    the times from ``start`` to ``end``; their ``format`` is png, svg or pdf.
    """
    from hydrosim.report.charts.panels import TimeWindow
    from hydrosim.report.charts.pictures import Format, View, draw

    path = printed.source_of(result)
    place = path.parent if folder is None else Path(folder)
    is_picture = place.suffix[1:] in [*Format] and not os.path.isdir(place)
    is_one_file = bool(channels) and is_picture
    if os.path.exists(place) and not os.path.isdir(place) and not is_one_file:
        raise InputError(f"{place}: is a file; expected a folder for the pictures.")
    if is_picture and not is_one_file:
        raise InputError(
            f"output: found {place}; expected a folder for several pictures. `format`"
            f" {place.suffix[1:]} selects their format."
        )
    kind = arguments.one_of(Format, place.suffix[1:] if is_one_file else format, "format")
    window = TimeWindow(*arguments.window_of(start, end))
    run = _read(result, open_run)
    if is_of_runs(run):
        if channels or start or end:
            raise InputError(
                f"channels, start, end: {path} is a study, which has no time series;"
                " expected the result of a run."
            )
        lines = (
            *status_lines(run),
            *_picture_lines(printed.draw_runs(run, place, path, overwrite, kind)),
        )
        return printed.PrintedResult(Document("", []), run, lines=lines)
    asked = arguments.names_in(channels)
    picked = match_channels(channel_names(run), asked, "channels") if asked else ()
    home, stem = (place.parent, place.stem) if is_one_file else (place, path.stem)
    view = View(window, picked, kind, is_one_file)
    pictures = draw(run, home, stem, path, overwrite, view)
    return printed.PrintedResult(Document("", []), run, lines=_picture_lines(pictures))


def _picture_lines(pictures: list[Path]) -> tuple[str, ...]:
    return tuple(f"picture   {picture}" for picture in pictures)


# Pages.


def write_report(
    result: Result,
    output: arguments.Target = True,
    *,
    replay: bool = False,
    overwrite: bool = False,
) -> printed.PrintedResult:
    """Write the report of a result as one HTML file that needs no network; with ``replay``, its
    three-dimensional animation alone. Results are runs, studies, limits of operation and
    comparisons."""
    from hydrosim.report.document import document_of, replay_of, report_of
    from hydrosim.report.page import written_page

    if str(output).endswith(".pdf"):
        raise InputError(f"output: found {output}; expected .html, which a browser prints to PDF.")
    path = printed.source_of(result)
    what = "replay" if replay else "report"
    if not isinstance(result, xr.Dataset):
        expected = "a run (RUN.nc)" if replay else "`hydrosim run`, `study` or `compare`"
        arguments.require_file(path, f"the result of {expected}")
    name = f"{path.stem}_{what}"
    page = arguments.output_for(output, name, what, path, overwrite=overwrite, suffix=".html")
    if page is None:
        raise InputError("output: found none; expected the page to write.")
    if isinstance(result, xr.Dataset):
        document = document_of(result, replay)
    else:
        document = (replay_of if replay else report_of)(path)
    size = written_page(document, page)
    line = f"{what}    {page.path}, {max(size / 1e6, 0.1):.1f} MB"
    return printed.PrintedResult(Document("", []), files=(page.path,), lines=(line,))
