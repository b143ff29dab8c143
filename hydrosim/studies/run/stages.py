"""Runs in stages: cases that use the results of other cases.

A recorded series of a case may name the case that produces it. `complete_stages` simulates such a
case if its result is missing, or was made from a different text of that case or by another version
of the program.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from hydrosim.errors import InputError
from hydrosim.outputs import Output
from hydrosim.program import program_version
from hydrosim.results.netcdf import write_run

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.case.load import Case, Stage


def outdated_reason(stage: Stage) -> str | None:
    """Reason why the case of a stage must be run, for the first time or again. None if the
    existing result belongs to the present case and program."""
    if not os.path.isfile(stage.file):
        return f"{stage.file} does not exist"

    import xarray as xr  # slow to load, and few cases have stages

    try:
        with xr.open_dataset(stage.file, engine="netcdf4") as run:
            made = run.attrs
    except (OSError, ValueError, RuntimeError):
        return f"{stage.file} is not the result of a run"
    if made.get("case") != stage.case.text:
        return f"{stage.file} was made from a different text of {stage.case.path}"
    if made.get("program") != f"hydrosim {program_version()}":
        return f"{stage.file} was made by {made.get('program')}"
    if made.get("status") != "complete":
        return f"{stage.file} is the result of an incomplete run"
    return None


def complete_stages(
    case: Case,
    run: Callable[[Case, Output], xr.Dataset],
    announce: Callable[[str], None] = lambda _: None,
    above: tuple[Path, ...] = (),
) -> bool:
    """Make the runs that ``case`` needs with ``run``, which receives the path of the result, in
    order; True if any was made.

    ``announce`` receives the reason for each run. ``above`` are the cases that need this one.
    Raises InputError if cases need each other, and KeyboardInterrupt if a run is interrupted; only
    complete runs are written.
    """
    from hydrosim.studies.run.checkpoint import checkpoint_of  # slow to load

    chain = (*above, case.path.resolve())
    made = False
    for stage in case.stages():
        if stage.case.path.resolve() in chain:
            raise InputError(
                f"{case.path}: found a series from a run of {stage.case.path}, which itself needs"
                " a run of this case; expected cases that do not need each other."
            )
        anew = complete_stages(stage.case, run, announce, chain)
        reason = f"{stage.file} needs another run" if anew else outdated_reason(stage)
        if reason:
            result = _result(stage)
            announce(f"{reason}: simulating {stage.case.path}")
            with result.hold_lock():
                dataset = run(stage.case, result)
                if dataset.attrs["status"] == "interrupted":
                    raise KeyboardInterrupt
                write_run(dataset, result)
                checkpoint_of(result).clear()
            made = True
    return made


def _result(stage: Stage) -> Output:
    """Output of a stage, beside its own case. A case file writes no file elsewhere, and replaces
    only an earlier run of that case."""
    home = stage.case.path.parent
    key = f"file: {stage.file.name} (a run of {stage.case.path})"
    if not stage.file.parent.resolve() == home.resolve() or stage.file.suffix != ".nc":
        raise InputError(
            f"{key}: found {stage.file}; expected a file that ends in .nc, in the folder {home}."
            " hydrosim runs the earlier case first, and writes its result into that case's folder."
        )
    inputs = stage.case.inputs()
    made = Output(
        stage.file, "run", stage.case.path, inputs, option=key, settings=stage.case.settings()
    )
    return made.checked_output()
