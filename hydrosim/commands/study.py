"""What commands do with a file of the runs of a study: tables, pictures."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from hydrosim.commands.options import placed
from hydrosim.commands.terminal import show

if TYPE_CHECKING:
    import xarray as xr


def tables(
    runs: xr.Dataset, file: Path, output: Path | None, overwrite: bool = False
) -> Iterator[str]:
    """The tables of a study in lines; they go to a file of comma-separated values too."""
    from hydrosim.results.effect_lines import as_csv, study_lines

    table = placed(output, f"{file.stem}", "table", file, overwrite=overwrite, suffix=".csv")
    yield from study_lines(runs)
    with table.written() as path:
        path.write_text(f"# {table.mark}\n{as_csv(runs)}")
    yield f"table     {table.path}"


def draw_runs(runs: xr.Dataset, folder: Path, file: Path, overwrite: bool = False) -> None:
    """Draw a study, and say where the pictures are."""
    from hydrosim.outputs import Output
    from hydrosim.plot.effects import draw_study

    folder.mkdir(parents=True, exist_ok=True)
    pictures = Output(folder / file.name, "picture", file, (file,), overwrite, "pictures")
    for path in draw_study(runs, pictures):
        show(f"picture   {path}")
