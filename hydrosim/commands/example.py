"""`hydrosim example`: a case that comes with the program, to begin with."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Annotated

import typer

from hydrosim.commands.terminal import show
from hydrosim.errors import InputError
from hydrosim.outputs import make_folder

NAMED = re.compile(r"[\w./]*\.(?:nc|yaml|txt|stl)\b")


def example(
    name: Annotated[
        str | None, typer.Argument(help="Which one to write; without, all are listed.")
    ] = None,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="FOLDER", help="Write it into this folder.")
    ] = Path("."),
) -> None:
    """Write a case that comes with hydrosim, with its databases; or list them.

    A folder cases/NAME has the case files, hydro_db the databases that they name. What exists is
    left as it is.
    """
    home = _home()
    known = sorted(path.name for path in (home / "cases").iterdir() if list(path.glob("*.yaml")))
    if name is None:
        show(*known)
        return
    if name not in known:
        raise InputError(f"example: found {name!r}; expected one of {', '.join(known)}")
    for file in _files(home, home / "cases" / name):
        made = output / file.relative_to(home.resolve())
        if not os.path.lexists(made):  # a link that leads nowhere stays, too
            make_folder(made.parent)
            made.write_bytes(file.read_bytes())
    cases = sorted((output / "cases" / name).glob("*.yaml"))
    show(*(f"case      {path}" for path in cases))


def _home() -> Path:
    """Where cases and databases are: in the package, or beside it in a clone."""
    package = Path(__file__).parents[1]
    for folder in (package / "examples", package.parent):
        if (folder / "cases").is_dir() and (folder / "hydro_db").is_dir():
            return folder
    raise InputError("example: this installation has no examples; take them from the repository.")


def _files(home: Path, folder: Path) -> list[Path]:
    """The case files of a folder, its studies, and all files that any of them names."""
    waiting = [*folder.glob("*.yaml"), *folder.glob("studies/*.yaml")]
    found = set[Path]()
    while waiting:
        path = waiting.pop().resolve()
        if path in found or not path.is_file():
            continue
        found.add(path)
        if path.suffix == ".yaml":
            waiting += [path.parent / name for name in NAMED.findall(path.read_text("utf-8"))]
    return sorted(path for path in found if path.is_relative_to(home.resolve()))
