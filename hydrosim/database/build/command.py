"""What `hydrosim db build` does."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from hydrosim.errors import InputError
from hydrosim.outputs import Output, settings_text

NEEDED = "hydrosim db build needs Capytaine; install it with: pip install hydrosim[bem]"


def build_database(
    output: Output, jobs: int, picture: bool, settings: Sequence[str] = ()
) -> list[Path]:
    """Compute the database of the recipe that is the ``output``'s origin, with ``settings``
    KEY=VALUE laid over it, by ``jobs`` processes, with a progress bar, and write it; with
    ``picture`` also pages about it. The files written."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # processes share the work, not threads
    try:
        from hydrosim.database.build.afloat import afloat
        from hydrosim.database.build.build import build
        from hydrosim.database.build.recipe import load_recipe
    except ModuleNotFoundError as error:
        raise InputError(f"{NEEDED} (there is no module {error.name}).") from error
    from hydrosim.database.build.picture import draw, draw_qtf
    from hydrosim.database.convert import format_of, write

    format_of(output.path)
    page = output.at(output.path.with_suffix(".png"), "picture")
    transfer = output.at(page.path.with_name(f"{page.path.stem}_qtf.png"), "picture")
    for drawn in (page, transfer) if picture else ():
        drawn.checked()
    given = load_recipe(output.origin, settings)
    made_with = settings_text(
        given.data.model_dump(mode="json", exclude_unset=True, warnings=False)
    )
    output = replace(output, settings=made_with)
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn()
    console = Console(stderr=True, force_terminal=sys.stderr.isatty())
    bar = Progress(*columns, TimeElapsedColumn(), console=console, transient=True)
    with output.held(), bar:
        task = bar.add_task("frequencies", total=given.steps)
        db = build(given, jobs, lambda done, _: bar.update(task, completed=done))
        files = write(db, output)
    if picture:
        files.append(page.path)
        draw(db, afloat(given).panels, page)
    if picture and db.qtf_difference is not None:
        files.append(transfer.path)
        draw_qtf(db, transfer)
    return files
