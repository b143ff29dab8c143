"""`hydrosim line`: offset of a mooring line's fairlead against tension and stiffness."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from hydrosim.commands.compiling import announce_compiling
from hydrosim.commands.options import (
    Overwrite,
    Settings,
    Verbose,
    output_for,
    quantity,
    require_file,
)
from hydrosim.commands.progress import progress
from hydrosim.commands.terminal import print_lines, progress_console, show_document
from hydrosim.errors import InputError

if TYPE_CHECKING:
    from hydrosim.outputs import Output
    from hydrosim.presentation.units import Units
    from hydrosim.studies.line import StillLine

err = progress_console()
EXPECTED_FILE = "a case file (YAML), or an input file of MoorDyn or MoorPy"


def line(
    file: Annotated[
        Path,
        typer.Argument(metavar="CASE.yaml|FILE", help="Case, or file of MoorDyn or MoorPy."),
    ],
    name: Annotated[
        str | None,
        typer.Option("--line", metavar="NAME", help="The line; default: all at rest, and one."),
    ] = None,
    offset: Annotated[
        str | None,
        typer.Option(help='Largest offset, both ways: "20 m"; default: 10 % of the height.'),
    ] = None,
    keys: Annotated[
        bool, typer.Option("--case", help="Print the lines of the file as keys of a case.")
    ] = False,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="PICTURE.png", help="Picture file to write."),
    ] = None,
    verbose: Verbose = False,
    overwrite: Overwrite = False,
    settings: Settings = [],  # noqa: B006  typer copies it
) -> None:
    """Print and draw tension, pull, stiffness and grounded length of a mooring line over offsets of
    its fairlead, with the lines of the file at rest."""
    from hydrosim.case.lines.chains import is_mooring_file

    require_file(file, EXPECTED_FILE)
    of_others = is_mooring_file(file)
    if of_others and settings:
        raise InputError(f"--set: found a setting, and {file} is no case; expected a case.")
    if keys:
        if not of_others:
            raise InputError(f"--case: found {file}, a case; expected a file of MoorDyn or MoorPy.")
        _print_keys(file)
        return
    largest = quantity("--offset", offset, "length", "m", "20 m") if offset else None
    if largest is not None and not largest > 0.0:
        raise InputError(f"--offset: found {largest:g} m; expected a length above 0.")
    page = output_for(output, f"{file.stem}_line", "line", file, overwrite=overwrite, suffix=".png")
    with page.hold_lock(), announce_compiling(err), progress("lines"):
        found = _of_file(file) if of_others else _of_case(file, settings)
    chosen = _chosen(file, found.lines, name)
    shown = found._replace(lines=[chosen] if name else found.lines)
    _show(shown, chosen, largest, page, verbose)


class LinesToShow(NamedTuple):
    """The ``lines`` of a case or file with its ``title``, the ``units`` to show them in, and what
    of the file is ``left_out``."""

    title: str
    lines: list[StillLine]
    units: Units
    left_out: list[str]


def _of_file(file: Path) -> LinesToShow:
    """The lines of a file of another program."""
    from hydrosim.case.lines.chains import read_mooring_system
    from hydrosim.documents.text import Source
    from hydrosim.presentation.units import DEFAULT
    from hydrosim.studies.line import lines_of_system

    system = read_mooring_system(Source(file))
    left_out = [each.message for each in system.left_out]
    return LinesToShow(file.name, lines_of_system(system), DEFAULT, left_out)


def _of_case(file: Path, settings: list[str]) -> LinesToShow:
    """Those of a case, with its bodies as they are at the start."""
    from hydrosim.case.load import load_case
    from hydrosim.compiling.compile import compile_in_calm
    from hydrosim.presentation.units import units_of
    from hydrosim.studies.line import lines_of_case

    scene = load_case(file, settings).scene()
    lines = lines_of_case(compile_in_calm(scene))
    return LinesToShow(scene.title, lines, units_of(scene.source), [])


def _chosen(file: Path, lines: list[StillLine], name: str | None) -> StillLine:
    """The line that is asked for, or the first."""
    known = {each.name: each for each in lines}
    if not known:
        raise InputError(f"{file}: found no catenary; expected one under forces.")
    if name is not None and name not in known:
        raise InputError(f"--line: found {name}; expected one of {', '.join(known)}.")
    return known[name] if name is not None else lines[0]


def _show(
    found: LinesToShow, chosen: StillLine, largest: float | None, page: Output, verbose: bool
) -> None:
    from hydrosim.plot.line import draw_line
    from hydrosim.studies.line import offsets_to, response
    from hydrosim.wording.line import line_document

    offsets = offsets_to(largest or chosen.usual_offset())
    along, up = (response(chosen, offsets, way) for way in (False, True))
    named = f"{found.title}: line {chosen.name}"
    draw_line(named, chosen, (along, up), page, found.units)
    document = line_document(named, found.lines, (along, up), found.units, found.left_out)
    show_document(document, verbose)
    print_lines(f"picture   {page.path}")


def _print_keys(file: Path) -> None:
    from hydrosim.case.lines.keys import case_keys

    typer.echo(case_keys(file), nl=False)
