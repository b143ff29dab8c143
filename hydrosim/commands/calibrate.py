"""`hydrosim calibrate`: roll damping from recorded decay tests."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hydrosim.commands.options import From, Overwrite, To, Verbose, require_file, seconds
from hydrosim.commands.progress import progress
from hydrosim.commands.terminal import print_lines, show_document
from hydrosim.errors import InputError


def calibrate(
    records: Annotated[
        list[Path],
        typer.Argument(
            metavar="DECAY...", help="Recordings of decaying roll: text, netCDF, MATLAB or HDF5."
        ),
    ],
    column: Annotated[
        str, typer.Option(metavar="NAME", help="Column of the roll angle: its name or number.")
    ] = "roll",
    unit: Annotated[
        str, typer.Option(help="Unit of the column, deg or rad, if the file does not say it.")
    ] = "",
    start: From = "",
    end: To = "",
    body: Annotated[str, typer.Option(help="Body in the keys that are written.")] = "barge",
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", metavar="KEYS.yaml", help="File to write the keys of a case to."
        ),
    ] = None,
    verbose: Verbose = False,
    overwrite: Overwrite = False,
) -> None:
    """Fit roll damping p1, p2, p3 and the natural period to decay tests, with 90 % intervals; draw
    the fit, and write the keys of a case."""
    from hydrosim.decay.fit import fit_files
    from hydrosim.outputs import Output
    from hydrosim.plot.decay import draw_decay
    from hydrosim.wording.roll.calibrate import calibration_document, keys_of

    for path in records:
        require_file(path, "a recording of decaying roll")
    if unit not in ("", "deg", "rad"):
        raise InputError(f"--unit: found {unit!r}; expected deg or rad.")
    first = records[0]
    keys = output and Output(output, "keys", first, tuple(records), overwrite).checked_output()
    if output and output.suffix not in (".yaml", ".yml"):
        raise InputError(f"--output: found {output}; expected a name that ends in .yaml.")
    drawn = output.with_suffix(".png") if output else Path(f"{first.stem}_fit.png")
    page = Output(drawn, "picture", first, tuple(records), overwrite).checked_output()
    begin = seconds("--from", start, 0.0) if start else None
    close = seconds("--to", end, 0.0) if end else None
    with progress("fitting"):
        fit = fit_files(records, column, unit or None, begin, close)
    draw_decay(fit, page)
    show_document(calibration_document(fit), verbose)
    lines = keys_of(fit, body)
    if keys:
        with keys.write_complete() as path:
            path.write_text("\n".join([f"# {keys.mark}", *lines, ""]), encoding="utf-8")
        print_lines(f"keys      {keys.path}")
    else:
        print_lines(*lines)
    print_lines(f"picture   {page.path}")
