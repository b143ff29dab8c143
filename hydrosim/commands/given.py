"""What a database's file does not hold, and what is done to it: `--given KEY=VALUE`."""

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
        help="Give what the file lacks, or change the database, with a key of `hydrodynamics` in a"
        ' case: density="1.025 tonne/m^3", reference_point="[0, 0, -4.9 m]", symmetrise=true.',
    ),
]


def given_database(file: Path, given: Sequence[str]) -> ChangedDatabase:
    """The database in a ``file`` with what is ``given``, texts KEY=VALUE with the keys that a case
    has under `hydrodynamics`. Raises InputError that names the option."""
    from hydrosim.case.hydrodynamics import DatabaseFile
    from hydrosim.documents.layers import apply_setting
    from hydrosim.documents.nodes import GIVEN, compose
    from hydrosim.documents.validate import validated

    document = compose(json.dumps({"file": str(file)}), GIVEN)
    assert document is not None
    for setting in given:
        if setting.partition("=")[0].strip() == "file":
            raise InputError(f"{GIVEN}{setting}: expected another key; the file is the argument.")
        document = apply_setting(document, setting, GIVEN)
    return validated(document, DatabaseFile).build(lambda _: file)
