"""Tables and pictures of the runs of a study."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from hydrosim.commands.options import output_for
from hydrosim.commands.terminal import print_lines, show_document

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.outputs import Output

HERE = Path()  # folder in which the command was given


def stem_of(file: Path) -> str:
    """Stem of the results of a file of runs; "runs" for "runs.partial"."""
    return file.stem.replace(".nc", ".partial") if file.suffix == ".partial" else file.stem


def so_far(runs: xr.Dataset) -> list[str]:
    """Numbers of runs by status if not all are complete, and the reason why the first failed."""
    from hydrosim.results.runs_file import COMPLETE
    from hydrosim.results.unfinished import GATHERED
    from hydrosim.wording.study import counts_by_status

    if GATHERED in runs.attrs:
        return [f"so far    {runs.attrs[GATHERED]}"]
    if "status" not in runs or set(ends := runs.status.values.tolist()) == {COMPLETE}:
        return []
    first = ends.index("failed") if "failed" in ends else None
    failed = [f"run {first}: {runs.status_message.values[first]}"] if first is not None else []
    return [counts_by_status(runs), *failed]


def place_table(
    file: Path,
    output: Path | None,
    folder: Path = HERE,
    inputs: Iterable[Path] = (),
    overwrite: bool = False,
) -> Output:
    """Output for the tables of a ``file`` of runs: ``output``, or else a file in ``folder`` with
    the same stem. Raises InputError if it cannot be written; ``inputs`` are never replaced."""
    default = str(folder / stem_of(file))
    return output_for(
        output, default, "table", file, inputs=inputs, overwrite=overwrite, suffix=".csv"
    )


def show_study(runs: xr.Dataset, table: Output | None, verbose: bool = False) -> None:
    """Print a study; with a ``table``, also write it as comma-separated values."""
    from hydrosim.statistics.effect_table import as_csv
    from hydrosim.wording.study import study_tables

    show_document(study_tables(runs), verbose)
    if table is not None:
        with table.write_complete() as path:
            path.write_text(f"# {table.mark}\n{as_csv(runs)}")
        print_lines(f"table     {table.path}")


def draw_runs(
    runs: xr.Dataset, folder: Path, file: Path, overwrite: bool = False, form: str = "png"
) -> None:
    """Draw a study in the format ``form``, and print where the pictures are."""
    from hydrosim.outputs import Output, make_folder
    from hydrosim.plot.effects import draw_study

    make_folder(folder)
    pictures = Output(
        folder / f"{stem_of(file)}.{form}", "picture", file, (file,), overwrite, "pictures"
    )
    for path in draw_study(runs, pictures):
        print_lines(f"picture   {path}")
