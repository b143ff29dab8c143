"""`compare` holds a run against a recording, a file of many runs against another, or two results
against each other to the bit; `export` writes channels of a run for other programs."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import UTC, datetime
from enum import StrEnum
from functools import partial
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hydrosim.errors import InputError
from hydrosim.files import arguments
from hydrosim.files.display_units import unit_choice_attribute, units_of
from hydrosim.files.document import Document
from hydrosim.interface.printed import (
    Findings,
    PrintedResult,
    incomplete_run_warnings,
    run_analysis,
    source_of,
)
from hydrosim.results.dataset import read_run
from hydrosim.results.runs_file import is_of_runs, open_runs
from hydrosim.simulation import open_run

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from hydrosim.compare.export import ExportTable
    from hydrosim.files.outputs import Output

BANDS = "0.1,2.5"
"""Lowest and highest frequency of the wave band [rad/s]."""


def compare(
    run: xr.Dataset | str | Path,
    recorded: str | Path | pd.DataFrame,
    *,
    mapping: str | Path | Mapping[str, Any] | None = None,
    tolerance: float | Mapping[str, float] | None = None,
    shift: bool = False,
    channels: arguments.Names | None = None,
    start: arguments.Amount | None = None,
    end: arguments.Amount | None = None,
    bands: arguments.Amount | tuple[float, float] = BANDS,
    exact: bool = False,
    ignore: arguments.Names = (),
    output: arguments.Target = None,
    overwrite: bool = False,
) -> PrintedResult:
    """Compare a run, or the run in a file, with a recording, channel by channel. The recording is a
    file or a frame of pandas, which may name units ("Heave [mm]"), and whose index is the time [s]
    if no column is.

    ``mapping`` assigns columns to channels: a file, or its keys, such as ``{"channels":
    {"position.buoy.heave": {"column": "z", "unit": "mm"}}}``. ``tolerance`` limits the rms of the
    difference over the standard deviation, of all channels or by pattern; the tolerance of a
    constant channel is absolute. ``shift`` first estimates a shift in time. ``channels`` are
    patterns. The comparison covers the times from ``start`` to ``end``. ``bands`` are the lowest
    and the highest frequency [rad/s] of waves. Two files of many runs are compared figure by
    figure, beyond chance. With ``exact``, two results must be identical, but for the variables to
    ``ignore``.

    ``dataset`` has both series and their difference, ``failed`` says whether a tolerance is
    exceeded or results differ. With ``output``, files are written as by `hydrosim compare`.

    >>> case = hs.load_case("cases/friction_block/exact.yaml", {"duration": "60 s"})
    >>> run = hs.simulate(case, output="block.nc")
    >>> hs.compare("block.nc", "block.nc").dataset.attrs["compared"]
    'at the same times'
    """
    of, run = run, source_of(run)
    frame = None if isinstance(recorded, str | Path) else recorded
    recorded = Path("frame") if not isinstance(recorded, str | Path) else Path(recorded)
    settings = {
        "mapping": mapping,
        "tolerance": tolerance,
        "shift": shift,
        "channels": channels,
        "start": start,
        "end": end,
        "bands": bands != BANDS,
    }
    if exact:
        settings |= {"output": output not in (None, True), "overwrite": overwrite}
        _refuse(settings, "`exact`, which compares all variables")
        return _compare_exactly(run, recorded, arguments.names_in(ignore))
    if ignore:
        raise InputError(
            "ignore: found no `exact`; expected both. `ignore` names variables that `exact` skips."
        )
    inputs = [Path(path) for path in (recorded, mapping) if isinstance(path, str | Path)]
    runs = _many_runs(of)
    if runs is not None:
        _refuse(settings, f"{run}, a file of many runs")
    else:
        if isinstance(of, str | Path):
            arguments.require_file(run, "the result of a run (RUN.nc)")
        if frame is None:
            arguments.require_file(recorded, "a recorded series (csv, MATLAB, HDF5 or netCDF)")
    result = arguments.output_for(
        output, f"{run.stem}_compare", "comparison", run, inputs=inputs, overwrite=overwrite
    )
    if runs is not None:
        return _compare_studies(runs, run, recorded, result)
    from hydrosim.compare import compare as comparison_of
    from hydrosim.compare import read_mapping
    from hydrosim.compare.comparison import exceeded_tolerances, tolerances_by_channel
    from hydrosim.compare.dataset import to_dataset
    from hydrosim.files.recordings import read_recording, recording_of_frame
    from hydrosim.report.charts.explain import draw_comparison
    from hydrosim.report.sentences.comparison import comparison_tables

    page = arguments.picture_beside(result)
    between = arguments.window_of(start, end)
    limits = _tolerances(tolerance)
    dataset_of_run = open_run(run) if isinstance(of, str | Path) else of
    edges = _band_edges(bands)

    def compute() -> Findings:
        comparison = comparison_of(
            dataset_of_run,
            read_recording(recorded) if frame is None else recording_of_frame(frame),
            None if mapping is None else read_mapping(mapping),
            shift=shift,
            between=between,
            edges=edges,
            only=arguments.names_in(channels) or ("*",),
        )
        exceeded = exceeded_tolerances(comparison, limits)
        attributes = _comparison_attributes(dataset_of_run, run, recorded)
        dataset = to_dataset(comparison, attributes, tolerances_by_channel(comparison, limits))
        title = f"{run.name} and {recorded.name}"
        draw = partial(draw_comparison, dataset, title)
        return Findings(comparison_tables(dataset), dataset, draw, bool(exceeded))

    return run_analysis(compute, result, page)


def _many_runs(result: xr.Dataset | str | Path) -> xr.Dataset | None:
    """The runs of a result of many; None for the result of one."""
    if isinstance(result, str | Path):
        return open_runs(Path(result))
    return result if is_of_runs(result) else None


def _refuse(settings: Mapping[str, Any], reason: str) -> None:
    """Raises InputError that names the settings which are given."""
    names = [name for name, value in settings.items() if value]
    if names:
        these = "this option" if len(names) == 1 else "these options"
        raise InputError(f"{', '.join(names)}: not possible with {reason}. Leave {these} out.")


def _compare_studies(
    ours: xr.Dataset, run: Path, recorded: Path, result: Output | None
) -> PrintedResult:
    """Compare two files of many runs. Raises InputError if ``recorded`` is not such a file."""
    from hydrosim.compare.dataset import studies_dataset
    from hydrosim.compare.studies import compare_studies
    from hydrosim.report.sentences.comparison import studies_tables

    theirs = open_runs(recorded)
    if theirs is None:
        raise InputError(
            f"{recorded}: is a result of one run; expected a file of many runs, because"
            f" {run} is one."
        )

    def compute() -> Findings:
        comparison = compare_studies(ours, theirs)
        dataset = studies_dataset(comparison, _comparison_attributes(ours, run, recorded))
        return Findings(studies_tables(dataset), dataset)

    return run_analysis(compute, result)


def _comparison_attributes(ours: xr.Dataset, run: Path, recorded: Path) -> dict[str, object]:
    """Title, files and units of a comparison, for the attributes of its result."""
    return {
        "title": str(ours.attrs.get("title", "")),
        "run": str(run),
        "recording": str(recorded),
        **unit_choice_attribute(ours.attrs),
    }


def _compare_exactly(first_file: Path, second_file: Path, ignored: list[str]) -> PrintedResult:
    """The differences between two results, or that they are identical."""
    from hydrosim.compare.dataset import OF_MAKING, differences, read_result

    first, second = read_result(first_file), read_result(second_file)
    lines = differences(first, second, ignored)
    if not lines:
        names = ", ".join(sorted({*OF_MAKING, *ignored}))
        counts = f"{len(first.variables)} variables and {len(first.attrs)} attributes"
        return PrintedResult(Document("", []), lines=(f"identical: {counts}, apart from {names}",))
    return PrintedResult(Document("", []), lines=tuple(lines), failed=True)


def _tolerances(tolerance: float | Mapping[str, float] | None) -> dict[str, float]:
    """Tolerances by pattern of channels."""
    if tolerance is None:
        return {}
    limits = dict(tolerance) if isinstance(tolerance, Mapping) else {"*": tolerance}
    for limit in limits.values():
        if not (isfinite(limit) and limit > 0.0):
            raise InputError(f"tolerance: found '{limit:g}'; expected a positive number.")
    return limits


def _band_edges(bands: arguments.Amount | tuple[float, float]) -> tuple[float, float]:
    edges = arguments.numbers(bands, "bands")
    if len(edges) != 2 or edges[0] >= edges[1]:
        raise InputError(
            f"bands: found {bands!r}; expected two increasing frequencies in rad/s,"
            " such as 0.1,2.5."
        )
    return edges[0], edges[1]


# Export: channels of a run for other programs, a recording, or the case that repeats the run.


class ExportUnits(StrEnum):
    """Whose units are written."""

    CASE = "case"
    SI = "si"


def export(
    run: xr.Dataset | str | Path,
    output: str | Path,
    *,
    channels: arguments.Names = (),
    start: arguments.Amount | None = None,
    end: arguments.Amount | None = None,
    date: str = "",
    recording: bool = False,
    step: arguments.Amount | None = None,
    digits: int = 17,
    units: str = "",
    overwrite: bool = False,
) -> PrintedResult:
    """Write channels of a run, or of the run in a file, as CF netCDF, CSV, MATLAB or Parquet, which
    the suffix of ``output`` selects, or as a ``recording`` in text.

    ``channels`` are patterns; by default all are written. ``date`` (UTC) is that of time 0 s, for
    netCDF. A recording has a time ``step`` and so many significant ``digits``. ``units`` are "case"
    or "si": CF netCDF and recordings are in SI by default, others in the units of the case.

    >>> case = hs.load_case("cases/friction_block/exact.yaml", {"duration": "20 s"})
    >>> run = hs.simulate(case, output="block.nc")
    >>> _ = hs.export("block.nc", "block.csv")
    >>> Path("block.csv").exists()
    True
    """
    of, run, output = run, source_of(run), Path(output)
    if recording:
        read_in = arguments.one_of(ExportUnits, units or ExportUnits.SI, "units")
        return _write_recording(
            of, output, arguments.names_in(channels), step, digits, overwrite, read_in
        )
    if step not in (None, ""):
        raise InputError(
            "step: found no `recording`; expected both. Other files have the output times of the"
            " run."
        )
    from hydrosim.compare.export import check_suffix, table_of

    suffix = check_suffix(output)
    unit_system = _chosen_units(units, suffix)
    begin = _read_date(date, suffix)
    window = arguments.window_of(start, end)
    result = arguments.output_for(output, "", "export", run, overwrite=overwrite, suffix=suffix)
    assert result is not None
    runs = _many_runs(of)
    if runs is not None:
        raise InputError(
            f"{run}: holds {runs.sizes['run']} runs; expected the result of one run."
            " `hydrosim export --case --run` prints the case of one of them, and `hydrosim run`"
            " makes its result."
        )
    dataset = read_run(run) if isinstance(of, str | Path) else of
    table = table_of(dataset, arguments.names_in(channels), *window)
    if unit_system is ExportUnits.CASE:
        table = table.read_in(units_of(dataset.attrs))
    _write_table(table, result, begin)
    count, span = len(table.columns), f"{table.time[0]:g} to {table.time[-1]:g} s"
    lines = (
        f"export    {count} channels at {table.time.size} times, {span}",
        *incomplete_run_warnings(table.attributes),
        f"result    {result.path}",
    )
    return PrintedResult(Document("", []), lines=lines)


def _chosen_units(units: str, suffix: str) -> ExportUnits:
    """Whose units a table has. That of CF is in SI."""
    if suffix == ".nc":
        if units not in ("", ExportUnits.SI):
            raise InputError(f"units: found {units}; expected si, as .nc is always in SI.")
        return ExportUnits.SI
    return arguments.one_of(ExportUnits, units or ExportUnits.CASE, "units")


def _write_recording(
    run: xr.Dataset | str | Path,
    output: Path,
    patterns: list[str],
    step: arguments.Amount | None,
    digits: int,
    overwrite: bool,
    unit_system: ExportUnits,
) -> PrintedResult:
    """Write channels as a recording. Without names, it has the channels of motions, waves, forces,
    fenders and springs that are not zero."""
    from hydrosim.files.recordings import write_recording
    from hydrosim.files.series import columns_of
    from hydrosim.results.channels import default_channels, match_channels

    origin = source_of(run)
    result = arguments.output_for(output, "", "recording", origin, overwrite=overwrite, suffix=None)
    assert result is not None
    interval = None if step in (None, "") else arguments.seconds("step", step)
    if interval is not None and not interval > 0.0:
        raise InputError(f"step: found {interval:g} s; expected a positive time, such as 0.5 s.")
    dataset = open_run(run) if isinstance(run, str | Path) else run
    if patterns:
        names = match_channels(columns_of(dataset), patterns, "channels")
    else:
        names = default_channels(dataset)
    case_units = units_of(dataset.attrs).display_unit if unit_system is ExportUnits.CASE else None
    write_recording(dataset, result, names, interval, digits, case_units)
    line = f"result    {result.path}, {len(names)} channels"
    return PrintedResult(Document("", []), lines=(line,))


def _read_date(text: str, suffix: str) -> datetime | None:
    if not text:
        return None
    if suffix != ".nc":
        raise InputError(
            f"date: only .nc has dates; {suffix} has times since the start of the run. Leave"
            " `date` out."
        )
    try:
        date = datetime.fromisoformat(text)
    except ValueError:
        raise InputError(
            f"date: found {text!r}; expected a date such as 2026-05-31T06:00."
        ) from None
    return date.astimezone(UTC) if date.tzinfo else date.replace(tzinfo=UTC)


def _write_table(table: ExportTable, result: Output, date: datetime | None) -> None:
    from hydrosim.compare import export as exports

    with result.write_complete() as path:
        match path.suffix:
            case ".nc":
                exports.write_netcdf(table, path, result.mark, date)
            case ".csv":
                exports.write_text(table, path, result.mark)
            case ".mat":
                exports.write_matlab(table, path, result.mark)
            case _:
                exports.write_parquet(table, path, result.mark)


def repeating_case(file: str | Path, number: int | None = None) -> str:
    """Case (YAML) that repeats a run, with all defaults and automatic choices written out; of a
    file of many runs that of run ``number``, from 0 on. Of a file of MoorDyn or MoorPy, its lines
    as keys of a case."""
    from hydrosim.case.lines.chains import case_keys, is_mooring_file

    file = Path(file)
    if file.suffix in (".yaml", ".yml") and not is_mooring_file(file):
        raise InputError(
            f"case: found {file}, a case; expected a file of MoorDyn or MoorPy, or a result."
        )
    if file.suffix != ".nc" and file.is_file() and is_mooring_file(file):
        return case_keys(file)
    from hydrosim.compare.dataset import read_result
    from hydrosim.run.provenance import case_of

    result = read_result(file)
    try:
        return case_of(result, number)
    except InputError as error:
        raise InputError(f"{file}: {error}") from None
