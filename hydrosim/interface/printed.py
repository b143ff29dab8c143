"""`PrintedResult`, a result with the text that its command prints; files beside many runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from hydrosim.files.arguments import Target, lock_of, output_for
from hydrosim.files.document import Document, document_text
from hydrosim.files.outputs import Output, make_folder

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


@dataclass(frozen=True, repr=False)
class PrintedResult:
    """A result as its command prints it: a ``document`` and ``lines`` of text. It has a ``dataset``
    if there are numbers to compute with, the ``files`` that were written, and whether a check
    ``failed``, for which the command ends with exit code 1."""

    document: Document
    dataset: xr.Dataset | None = None
    files: tuple[Path, ...] = ()
    lines: tuple[str, ...] = ()
    failed: bool = False

    def __repr__(self) -> str:
        text = document_text(self.document, details=False).strip("\n")
        return "\n".join(part for part in (text, *self.lines) if part)

    def _repr_html_(self) -> str:
        return self.document._repr_html_()

    def to_dataframe(self) -> pd.DataFrame:
        """Numbers of the dataset as a frame of pandas: a row for each channel of statistics, or for
        each of many runs; of others all variables. Raises InputError without a dataset."""
        from hydrosim.interface.frames import frame_of_result

        return frame_of_result(self.dataset)


class Findings(NamedTuple):
    """What an analysis found: a ``document`` to print, the ``dataset`` to write if there is one,
    how to ``draw`` it, and whether a check ``failed``."""

    document: Document
    dataset: xr.Dataset | None = None
    draw: Callable[[Output], object] | None = None
    failed: bool = False


def run_analysis(
    compute: Callable[[], Findings], result: Output | None = None, page: Output | None = None
) -> PrintedResult:
    """Compute while the output is held, so that no other process writes there; write the dataset to
    ``result`` and the picture to ``page``. Without output all stays in memory."""
    from hydrosim.results.dataset import write_run

    with lock_of(result or page):
        found = compute()
        if result and found.dataset is not None:
            write_run(found.dataset, result)
    if page and found.draw:
        found.draw(page)
    files = tuple(output.path for output in (result, page) if output)
    return PrintedResult(found.document, found.dataset, files, failed=found.failed)


def source_of(run: xr.Dataset | str | Path) -> Path:
    """The file of a run; that of a run in memory is said to be "run.nc"."""
    if isinstance(run, str | Path):
        return Path(run)
    return Path(run.encoding.get("source", "run.nc"))


# Tables and pictures of many runs.


def stem_of(file: Path) -> str:
    """Stem of the results of a file of runs; "runs" for "runs.partial"."""
    return file.stem.replace(".nc", ".partial") if file.suffix == ".partial" else file.stem


def table_output(
    output: Target,
    file: Path,
    folder: Path = Path(),
    inputs: tuple[Path, ...] = (),
    overwrite: bool = False,
) -> Output | None:
    """Output for the tables of a ``file`` of runs: ``output``, or else a file in ``folder`` with
    the same stem. Raises InputError if it cannot be written; ``inputs`` are never replaced."""
    return output_for(
        output,
        str(folder / stem_of(file)),
        "table",
        file,
        inputs=inputs,
        overwrite=overwrite,
        suffix=".csv",
    )


def write_table(runs: xr.Dataset, table: Output) -> Path:
    """Write the tables of runs as comma-separated values; return the path."""
    from hydrosim.statistics.over_seeds import as_csv

    with table.write_complete() as path:
        path.write_text(f"# {table.mark}\n{as_csv(runs)}")
    return table.path


def draw_runs(
    runs: xr.Dataset, folder: Path, file: Path, overwrite: bool = False, suffix: str = "png"
) -> list[Path]:
    """Draw the runs of a ``file``; return where the pictures are."""
    from hydrosim.report.charts.studies import draw_study

    make_folder(folder)
    path = folder / f"{stem_of(file)}.{suffix}"
    return draw_study(runs, Output(path, "picture", file, (file,), overwrite, "pictures"))


def incomplete_run_warnings(attributes: Mapping[str, object]) -> list[str]:
    """Warning about the end of a run, from its attributes; empty if the run is complete."""
    status = attributes.get("status", "complete")
    text = f"warning   the run is {status}: {attributes.get('status_message', '')}"
    return [] if status == "complete" else [text]
