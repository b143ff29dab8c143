"""`hydrosim case`: print the case that repeats a run."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from hydrosim.cli.options import CaseFile, Settings, Verbose, quantity
from hydrosim.cli.progress import announce_compiling, progress
from hydrosim.cli.terminal import print_lines, progress_console, show_document
from hydrosim.errors import InputError

# `hydrosim check`: validate a case before it is run.

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
    from hydrosim.files.document_nodes import Outcome, Verdict
    from hydrosim.report.sentences.check import check_document
    from hydrosim.simulation import outdated_reason

    times = [quantity("--time", part, "time", "s", "1 hour") for part in time.split(",") if time]
    case = load_case(case_file, settings)
    missing = [reason for stage in case.stages() if (reason := outdated_reason(stage))]
    for reason in missing:
        print_lines(f"first stage: {reason}; hydrosim run {case_file} simulates it")
    if missing:
        return

    with announce_compiling(err), progress("checking") as report:

        def report_items(items: Sequence[Any], what: str) -> Iterator[Any]:
            for k, item in enumerate(items):
                report(k, len(items), f"step limits by {what}")
                yield item

        document = check_document(case.scene(), times, report_items)
    show_document(document, verbose)
    if any(isinstance(node, Verdict) and node.outcome is Outcome.BAD for node in document.nodes):
        raise typer.Exit(1)


def case(
    run_file: Annotated[Path, typer.Argument(metavar="RUN.nc", help="Result of a run.")],
    number: Annotated[
        int | None,
        typer.Option("--run", help="Number of the run in a file of many runs, counted from 0."),
    ] = None,
) -> None:
    """Print the case that repeats a run, with all defaults and automatic choices written out.

    The case is in SI units and radians. It has absolute paths and the checksums of databases, so it
    can be kept anywhere: hydrosim case RUN.nc > AGAIN.yaml.
    """
    from hydrosim.compare.exact import read_result
    from hydrosim.run.provenance import case_of

    result = read_result(run_file)
    try:
        text = case_of(result, number)
    except InputError as error:
        raise InputError(f"{run_file}: {error}") from None
    typer.echo(text, nl=False)


# `hydrosim schema`: JSON schemas with which editors complete and check files.


class FileKind(StrEnum):
    """Kinds of files that hydrosim reads."""

    CASE = "case"
    STUDY = "study"
    RECIPE = "recipe"


def schema(
    kind: Annotated[FileKind, typer.Argument(help="Kind of file.")] = FileKind.CASE,
) -> None:
    """Print the JSON schema of case files, of studies, or of recipes of databases.

    Save it beside a case: hydrosim schema case > case.schema.json. Begin the case with the line "#
    yaml-language-server: $schema=case.schema.json". Editors with a YAML language server then
    complete keys, show their meaning and mark mistakes.
    """
    typer.echo(json.dumps(schema_of(kind)))


def schema_of(kind: FileKind) -> dict[str, Any]:
    """JSON schema (draft 2020-12) of files of a ``kind``."""
    from hydrosim.files.json_schema import either_schema, json_schema

    match kind:
        case FileKind.CASE:
            from hydrosim.case.schema import CaseFile

            return json_schema(CaseFile, "Case of hydrosim")
        case FileKind.STUDY:
            from hydrosim.study.study_file import StudyFile

            return json_schema(StudyFile, "Study of hydrosim")
        case FileKind.RECIPE:
            from hydrosim.database.build.recipe import OneBody, SeveralBodies

            single, several = (json_schema(model, "") for model in (OneBody, SeveralBodies))
            return either_schema("Recipe of a database of hydrosim", "bodies", several, single)
