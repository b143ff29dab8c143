"""`hydrosim check`: what there is to say of a case before it is run."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Annotated, Any

import typer

from hydrosim.commands.compiling import announced
from hydrosim.commands.options import CaseFile, Settings, quantity
from hydrosim.commands.terminal import progress_console, show

err = progress_console()


def check(
    case_file: CaseFile,
    time: Annotated[
        str,
        typer.Option(help='Tell step limits and periods at these times, too: "30 min, 1 hour".'),
    ] = "",
    settings: Settings = [],  # noqa: B006
) -> None:
    """Validate a case; print what the scene needs and skips, step limits and natural periods.

    Where tanks change, those are told of the start and of the end. Of a case that is driven by the
    runs of others it says which of those have to be made first.
    """
    from rich.progress import track

    from hydrosim.case.load import load_case
    from hydrosim.studies.run.check import survey
    from hydrosim.studies.run.stages import outdated

    times = [quantity("--time", part, "time", "s", "1 hour") for part in time.split(",") if time]
    case = load_case(case_file, settings)
    missing = [reason for stage in case.stages() if (reason := outdated(stage))]
    for reason in missing:
        show(f"first stage: {reason}; hydrosim run {case_file} simulates it")
    if missing:
        return

    def watch(items: Sequence[Any], what: str) -> Iterable[Any]:
        return track(
            items,
            f"step limits by {what}",
            console=err,
            transient=True,
            disable=not err.is_terminal,
        )

    with announced(err):
        for part in survey(case.scene(), times, watch):
            show(part)
