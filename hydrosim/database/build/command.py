"""What `hydrosim db build` does."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from hydrosim.errors import InputError

NEEDED = "hydrosim db build needs Capytaine; install it with: pip install hydrosim[bem]"


def build_database(
    recipe: Path, output: Path | None, jobs: int, picture: bool, settings: Sequence[str] = ()
) -> list[Path]:
    """Compute the database of ``recipe``, with ``settings`` KEY=VALUE laid over it, by ``jobs``
    processes, with a progress bar, and write it to ``output``, or beside the recipe; with
    ``picture`` also pages about it. The files written.
    """
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # processes share the work, not threads
    try:
        from hydrosim.database.build.afloat import afloat
        from hydrosim.database.build.build import build
        from hydrosim.database.build.recipe import load_recipe
    except ModuleNotFoundError as error:
        raise InputError(f"{NEEDED} (there is no module {error.name}).") from error
    from hydrosim.database.build.picture import draw, draw_qtf
    from hydrosim.database.convert import writable, write

    path = recipe.with_suffix(".nc") if output is None else output
    writable(path)
    given = load_recipe(recipe, settings)
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn()
    console = Console(stderr=True)
    with Progress(*columns, TimeElapsedColumn(), console=console, transient=True) as bar:
        task = bar.add_task("frequencies", total=given.steps)
        db = build(given, jobs, lambda done, _: bar.update(task, completed=done))
    files = write(db, path)
    if picture:
        files.append(path.with_suffix(".png"))
        draw(db, afloat(given).panels, files[-1])
    if picture and db.qtf_difference is not None:
        files.append(path.with_name(f"{path.stem}_qtf.png"))
        draw_qtf(db, files[-1])
    return files
