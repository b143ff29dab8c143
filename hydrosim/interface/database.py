"""`build_database` computes the hydrodynamic database of a recipe, as `hydrosim db build` does."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from hydrosim.errors import InputError
from hydrosim.files.arguments import output_for
from hydrosim.files.layers import settings_of
from hydrosim.files.outputs import settings_text
from hydrosim.files.text import unreadable_reason

Progress = Callable[[int, int], None]
REQUIRED_MODULES = ("capytaine", "joblib")
"""What the extra bem installs."""


def build_database(
    recipe: str | Path,
    *,
    output: str | Path | None = None,
    workers: int = 1,
    plot: bool = False,
    overwrite: bool = False,
    settings: Mapping[str, Any] | Sequence[str] = (),
    progress: Progress = lambda done, total: None,
    announce: Callable[[float], None] | None = None,
) -> list[Path]:
    """Compute the database of a ``recipe`` with Capytaine; return the files.

    It is written to ``output``, by default the recipe's name with .nc, by so many processes
    (``workers``). ``settings`` override keys of the recipe. With ``plot``, pictures are drawn, too.
    ``progress`` receives the numbers of frequencies that are done and of all, ``announce`` an
    estimate of the time [s]. After an interruption the same call goes on. Raises InputError for a
    wrong recipe, and where Capytaine is not installed.
    """
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # processes share the work, not threads
    recipe = Path(recipe)
    if reason := unreadable_reason(recipe):
        raise InputError(f"{recipe}: {reason}; expected the recipe of a database (YAML).")
    place = output or recipe.with_suffix(".nc")
    result = output_for(place, "", "database", recipe, overwrite=overwrite, suffix=None)
    assert result is not None
    _require_modules()
    from hydrosim.database.build.afloat import hulls_afloat
    from hydrosim.database.build.build import build
    from hydrosim.database.build.picture import draw, draw_qtf
    from hydrosim.database.build.recipe import load_recipe
    from hydrosim.database.load import format_of, write

    format_of(result.path)
    page = result.output_at(result.path.with_suffix(".png"), "picture")
    transfer = result.output_at(page.path.with_name(f"{page.path.stem}_qtf.png"), "picture")
    for drawn in (page, transfer) if plot else ():
        drawn.checked_output()
    laid_over = settings_of(settings) if isinstance(settings, Mapping) else settings
    given = load_recipe(result.origin, laid_over)
    made_with = settings_text(
        given.data.model_dump(mode="json", exclude_unset=True, warnings=False)
    )
    result = replace(result, settings=made_with)
    with result.hold_lock():
        db = build(given, workers, progress, announce)
        files = write(db, result)
    if plot:
        files.append(page.path)
        draw(db, hulls_afloat(given).panels, page)
    if plot and db.qtf_difference is not None:
        files.append(transfer.path)
        draw_qtf(db, transfer)
    return files


def _require_modules() -> None:
    """Raises InputError that names all modules which are not installed."""
    absent = [name for name in REQUIRED_MODULES if find_spec(name) is None]
    if absent:
        raise InputError(
            f"build of a database: found no module {' and no '.join(absent)}; expected"
            f" {' and '.join(REQUIRED_MODULES)}. Install the extra: pip install 'hydrosim[bem]'."
        )
