"""`hydrosim example`: write a case that comes with the program."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Annotated

import typer

from hydrosim.commands.terminal import print_lines
from hydrosim.errors import InputError
from hydrosim.outputs import make_folder

FILE_NAME_PATTERN = re.compile(r"[\w./]*\.(?:nc|yaml|txt|stl|obj)\b")


def example(
    name: Annotated[
        str | None, typer.Argument(help="Name of the example; without a name, all are listed.")
    ] = None,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="FOLDER", help="Folder to write into.")
    ] = Path("."),
) -> None:
    """Write an example case with its databases, or list all examples.

    Case files go to cases/NAME, and their databases to hydro_db. Existing files are kept.
    """
    home = _home()
    known = sorted(path.name for path in (home / "cases").iterdir() if list(path.glob("*.yaml")))
    if name is None:
        print_lines(*known)
        return
    if name not in known:
        raise InputError(f"example: found {name!r}; expected one of {', '.join(known)}")
    for file in _files(home, home / "cases" / name):
        made = output / file.relative_to(home.resolve())
        if not os.path.lexists(made):  # a broken link also counts as existing
            make_folder(made.parent)
            made.write_bytes(file.read_bytes())
    cases = sorted((output / "cases" / name).glob("*.yaml"))
    print_lines(*(f"case      {path}" for path in cases))


def _home() -> Path:
    """Folder of the examples: in the package, or beside it in a clone of the repository."""
    package = Path(__file__).parents[1]
    for folder in (package / "examples", package.parent):
        if (folder / "cases").is_dir() and (folder / "hydro_db").is_dir():
            return folder
    raise InputError(
        "example: this installation has no examples; copy the folder cases from the repository."
    )


def _files(home: Path, folder: Path) -> list[Path]:
    """Case files and studies of a folder, and all files that they name."""
    waiting = [*folder.glob("*.yaml"), *folder.glob("studies/*.yaml")]
    found = set[Path]()
    while waiting:
        path = waiting.pop().resolve()
        if path in found or not path.is_file():
            continue
        found.add(path)
        if path.suffix == ".yaml":
            waiting += [
                path.parent / name for name in FILE_NAME_PATTERN.findall(path.read_text("utf-8"))
            ]
    return sorted(path for path in found if path.is_relative_to(home.resolve()))
