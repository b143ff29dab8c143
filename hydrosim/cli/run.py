"""`hydrosim run`: simulate a case."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrosim.cli.results import draw_run
from hydrosim.cli.terminal import (
    CaseFile,
    Overwrite,
    Settings,
    Verbose,
    case_summary_line,
    output_for,
    print_lines,
    print_status,
    run_earlier_stages,
    seconds,
    show_document,
    simulate_with_progress,
)
from hydrosim.errors import InputError, SimulationError

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.case import Case
    from hydrosim.files.outputs import Output


def run(
    case_file: CaseFile,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="RUN.nc", help="netCDF file to write.")
    ] = None,
    settings: Settings = [],  # noqa: B006  typer copies it
    plot_too: Annotated[bool, typer.Option("--plot", help="Also draw the pictures.")] = False,
    overwrite: Overwrite = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Continue a run that was killed or interrupted.")
    ] = False,
    every: Annotated[
        str,
        typer.Option(
            "--checkpoint",
            metavar="TIME",
            help='Interval at which the state of the run is saved to disk: "10 min", or a number'
            " in seconds.",
        ),
    ] = "60 s",
    verbose: Verbose = False,
) -> None:
    """Simulate a case; write netCDF and print a summary."""
    from hydrosim.case.load import load_case
    from hydrosim.report.sentences.run import run_document
    from hydrosim.simulation import require_two_records

    case = load_case(case_file, settings)
    result = output_for(
        output,
        case_file.stem,
        "run",
        case_file,
        inputs=case.inputs(),
        overwrite=overwrite,
        settings=case.settings(),
    )
    if plot_too:
        _planned_pictures(result)

    apart = seconds("--checkpoint", every, 60.0)
    if apart < 0.0:
        raise InputError(f"--checkpoint: found {apart:g} s; expected a time of 0 s or more.")

    def simulate_case(case: Case, result: Output) -> xr.Dataset:
        return simulate_with_progress(case, result, resume, apart)

    print_status(case_summary_line(case))
    with result.hold_lock():
        run_earlier_stages(case, simulate_case)
        _require_room(case, result.path)
        try:
            dataset = simulate_case(case, result)
        except SimulationError as error:
            print_lines(f"result    {_save_result(error.run_data, result)}")
            raise
        path = _save_result(dataset, result)
    show_document(run_document(_locate_warnings(dataset, case)), verbose)
    print_lines(f"result    {path}")
    if plot_too:
        require_two_records(dataset, path)
        draw_run(dataset, path.parent, path, overwrite)
    if dataset.attrs["status"] == "interrupted":
        raise typer.Exit(130)


def _locate_warnings(dataset: xr.Dataset, case: Case) -> xr.Dataset:
    """Dataset of the run, whose warnings name file and line of a key when printed; the result
    itself stores no paths."""
    from hydrosim.files.yaml_nodes import add_source_lines

    text = dataset.attrs.get("warnings")
    return dataset.assign_attrs(warnings=add_source_lines(text, case.places)) if text else dataset


def _require_room(case: Case, path: Path) -> None:
    """Raises InputError if the result of a run would not fit on the disk."""
    from shutil import disk_usage

    from hydrosim.compile import sizes

    size = sizes.result_size(case.scene())
    free = disk_usage(path.parent).free
    if size > free:
        found_text = f"about {sizes.size_text(size)}, and {sizes.size_text(free)} are free"
        raise InputError(
            f"--output: the result is {found_text} in {path.parent}; free some space there, choose"
            " another place, or record less often (a larger output.step)."
        )


def _planned_pictures(result: Output) -> None:
    """Raises InputError before the run if its pictures would replace other files."""
    from hydrosim.report.charts.pictures import picture_outputs

    picture_outputs(result.path.parent, result.path.stem, result.path, result.overwrite)


def _save_result(dataset: xr.Dataset, result: Output) -> Path:
    """Write the result of a run; return its path. A run that did not complete never replaces a
    complete one. No run replaces a file that appeared while it was computed."""
    from hydrosim.results.dataset import status_of, write_run
    from hydrosim.run.checkpoint import checkpoint_of

    status = dataset.attrs["status"]
    better = status != "complete" and status_of(result.path) == "complete"
    place = result.fallback_path() if better else result.resolve_path()
    write_run(dataset, place)
    if status != "interrupted":
        checkpoint_of(result).clear()
    return place.path
