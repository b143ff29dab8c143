"""`hydrosim schema`: JSON schemas with which editors complete and check files."""

from __future__ import annotations

import json
from enum import StrEnum
from typing import Annotated, Any

import typer


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
    from hydrosim.documents.json_schema import either_schema, json_schema

    match kind:
        case FileKind.CASE:
            from hydrosim.case.schema import CaseFile

            return json_schema(CaseFile, "Case of hydrosim")
        case FileKind.STUDY:
            from hydrosim.studies.study_file import StudyFile

            return json_schema(StudyFile, "Study of hydrosim")
        case FileKind.RECIPE:
            from hydrosim.database.build.recipe import OneBody, SeveralBodies

            one, several = (json_schema(model, "") for model in (OneBody, SeveralBodies))
            return either_schema("Recipe of a database of hydrosim", "bodies", several, one)
