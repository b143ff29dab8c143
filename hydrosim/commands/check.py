"""`hydrosim check`: validate a case before it is run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Annotated, Any

import typer

from hydrosim.commands.compiling import announce_compiling
from hydrosim.commands.options import CaseFile, Settings, Verbose, quantity
from hydrosim.commands.progress import progress
from hydrosim.commands.terminal import print_lines, progress_console, show_document

err = progress_console()


def check(
    case_file: CaseFile,
    time: Annotated[
        str,
        typer.Option(help='Also print step limits and periods at these times: "30 min, 1 hour".'),
    ] = "",
    verbose: Verbose = False,
    settings: Settings = [],  # noqa: B006
) -> None:
    """Validate a case; print verdicts, step limits and natural periods.

    --verbose adds the data that the scene uses and the data that it ignores. If the contents of
    tanks change, limits and periods are printed for the start and the end. If the case needs
    results of other cases that were not run yet, the command names them and stops. It ends with
    exit code 1 if a verdict is "failed", such as a step that is unstable.
    """
    from hydrosim.case.load import load_case
    from hydrosim.presentation.document import Outcome, Verdict
    from hydrosim.studies.run.stages import outdated_reason
    from hydrosim.wording.check import check_document

    times = [quantity("--time", part, "time", "s", "1 hour") for part in time.split(",") if time]
    case = load_case(case_file, settings)
    missing = [reason for stage in case.stages() if (reason := outdated_reason(stage))]
    for reason in missing:
        print_lines(f"first stage: {reason}; hydrosim run {case_file} simulates it")
    if missing:
        return

    with announce_compiling(err), progress("checking") as report:

        def watch(items: Sequence[Any], what: str) -> Iterator[Any]:
            for k, item in enumerate(items):
                report(k, len(items), f"step limits by {what}")
                yield item

        document = check_document(case.scene(), times, watch)
    show_document(document, verbose)
    if any(isinstance(node, Verdict) and node.outcome is Outcome.BAD for node in document.nodes):
        raise typer.Exit(1)
