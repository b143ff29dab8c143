"""`hydrosim explain`: why a body moved, by force, contact mode and direction."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrosim.commands.options import Overwrite, placed
from hydrosim.commands.terminal import show
from hydrosim.errors import InputError

if TYPE_CHECKING:
    import xarray as xr


def explain(
    run_file: Annotated[
        Path, typer.Argument(metavar="RUN.nc", help="Result of a run, or of a sweep.")
    ],
    direction: Annotated[str, typer.Option(help="Surge, sway or heave.")] = "surge",
    body: Annotated[str | None, typer.Option(help="The body; else the first that moves.")] = None,
    start: Annotated[
        float | None, typer.Option("--from", metavar="SECONDS", help="Leave out what is before.")
    ] = None,
    until: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="Leave out what is after.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="EXPLAINED.nc", help="Result file.")
    ] = None,
    overwrite: Overwrite = False,
) -> None:
    """Mean forces, friction by what makes it, and displacement and work by contact mode, per stage.

    Of a run with `output: {impulses: true}`; of a sweep of such runs means over the runs, with
    intervals of 90 %.
    """
    from hydrosim.plot.explain import draw_explained
    from hydrosim.results.explain import read_explained
    from hydrosim.results.explain_rows import AXES, explanation
    from hydrosim.results.output import write

    if direction not in AXES:
        raise InputError(f"--direction: found {direction}; expected one of {', '.join(AXES)}.")
    name = f"{run_file.stem}_explained"
    result = placed(output, name, "explanation", run_file, overwrite=overwrite)
    page = result.at(result.path.with_suffix(".png"), "picture").checked()
    run, found = read_explained(run_file, start, until)
    moved = _body(found, direction, body)
    write(found, result)
    draw_explained(run, found, moved, direction, page)
    show(*explanation(found, moved, direction), f"result    {result.path}, {page.path}")


def _body(found: xr.Dataset, direction: str, name: str | None) -> str:
    """The body that is asked for, or the first that moves."""
    known = [str(body) for body in found.body.values]
    if name is not None and name not in known:
        raise InputError(f"--body: found {name}; expected one of {', '.join(known)}.")
    displacement = abs(found.displacement.sel(dof=direction)).fillna(0.0)
    moved = displacement.max([dim for dim in displacement.dims if dim != "body"]).values
    return name or (known[int(moved.argmax())])
