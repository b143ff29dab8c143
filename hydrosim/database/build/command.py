"""The command `hydrosim db build`."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

from hydrosim.errors import InputError
from hydrosim.outputs import Output, settings_text

Progress = Callable[[int, int], None]
REQUIRED_MODULES = ("capytaine", "joblib")
"""What the extra bem installs."""


def build_database(
    output: Output,
    jobs: int,
    picture: bool,
    settings: Sequence[str] = (),
    progress: Progress = lambda done, total: None,
    announce: Callable[[float], None] | None = None,
) -> list[Path]:
    """Compute the database of the recipe that is the origin of ``output``, with ``settings``
    KEY=VALUE that override it. ``jobs`` processes share the work, with a progress bar. ``announce``
    receives an estimate of the time [s]. With ``picture``, draw pages about it, too. Returns the
    paths of the files."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # processes share the work, not threads
    _require_modules()
    from hydrosim.database.build.afloat import hulls_afloat
    from hydrosim.database.build.build import build
    from hydrosim.database.build.picture import draw, draw_qtf
    from hydrosim.database.build.recipe import load_recipe
    from hydrosim.database.convert import format_of, write

    format_of(output.path)
    page = output.output_at(output.path.with_suffix(".png"), "picture")
    transfer = output.output_at(page.path.with_name(f"{page.path.stem}_qtf.png"), "picture")
    for drawn in (page, transfer) if picture else ():
        drawn.checked_output()
    given = load_recipe(output.origin, settings)
    made_with = settings_text(
        given.data.model_dump(mode="json", exclude_unset=True, warnings=False)
    )
    output = replace(output, settings=made_with)
    with output.hold_lock():
        db = build(given, jobs, progress, announce)
        files = write(db, output)
    if picture:
        files.append(page.path)
        draw(db, hulls_afloat(given).panels, page)
    if picture and db.qtf_difference is not None:
        files.append(transfer.path)
        draw_qtf(db, transfer)
    return files


def _require_modules() -> None:
    """Raises InputError that names all modules which are not installed."""
    absent = [name for name in REQUIRED_MODULES if find_spec(name) is None]
    if absent:
        raise InputError(
            f"hydrosim db build: found no module {' and no '.join(absent)}; expected"
            f" {' and '.join(REQUIRED_MODULES)}. Install the extra: pip install 'hydrosim[bem]'."
        )
