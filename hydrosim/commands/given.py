"""`--given KEY=VALUE`: data that a database's file lacks, and changes of the database."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrosim.errors import InputError

if TYPE_CHECKING:
    from hydrosim.scene import ChangedDatabase

GivenSettings = Annotated[
    list[str],
    typer.Option(
        "--given",
        metavar="KEY=VALUE",
        help="Data that the file lacks, or a change of the database; KEY as under"
        ' `hydrodynamics` in a case: density="1.025 tonne/m^3", depth="30 m",'
        " symmetrise=true.",
    ),
]


def given_database(file: Path, given: Sequence[str]) -> ChangedDatabase:
    """Database in a ``file``, with the ``given`` texts KEY=VALUE, whose keys are those under
    `hydrodynamics` in a case. Raises InputError that names the option."""
    from hydrosim.case.hydrodynamics import DatabaseFile
    from hydrosim.documents.layers import apply_setting
    from hydrosim.documents.nodes import COMMAND_LINE_PREFIX, compose_nodes
    from hydrosim.documents.validate import validate_document

    document = compose_nodes(json.dumps({"file": str(file)}), COMMAND_LINE_PREFIX)
    assert document is not None
    for setting in given:
        if setting.partition("=")[0].strip() == "file":
            raise InputError(
                f"{COMMAND_LINE_PREFIX}{setting}: found file; expected another key. The file is"
                " the argument."
            )
        document = apply_setting(document, setting, COMMAND_LINE_PREFIX)
    return validate_document(document, DatabaseFile).build(lambda _: file)
