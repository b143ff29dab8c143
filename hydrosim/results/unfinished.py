"""Runs of an unfinished study, from its folder `RUNS.nc.partial`."""

from __future__ import annotations

import os
from pathlib import Path
from typing import BinaryIO

import numpy as np
import xarray as xr
from numpy.lib.recfunctions import repack_fields

from hydrosim.errors import InputError
from hydrosim.results.journal import (
    FIRST_RUN_FILE,
    KNOWN,
    RUNS,
    entries,
    first_of,
    form_of,
    is_earlier,
)
from hydrosim.results.runs_file import (
    BY_RUN,
    COMPLETE,
    LARGE,
    MISSING,
    RUN,
    in_common,
    open_runs,
)

PARTIAL = ".partial"
GATHERED = "gathered"  # attribute of unfinished runs: how many are complete, in words


def runs_at(path: Path) -> xr.Dataset | None:
    """Runs in a file of many runs, or in the folder of an unfinished study; None for another file.
    Raises InputError for another folder, or if no run is complete yet."""
    other = path.with_suffix("") if path.suffix == PARTIAL else Path(f"{path}{PARTIAL}")
    if os.path.exists(other) and not os.path.exists(path):
        of = "the result of the sweep" if path.suffix == PARTIAL else "an unfinished sweep"
        raise InputError(f"{path}: does not exist; {other} is {of}.")
    if not os.path.exists(path) and (rounds := _rounds(path)):
        raise InputError(
            f"{path}: does not exist. An unfinished study that adds seeds until a mean is precise"
            f" keeps its last round in {rounds[-1]}."
        )
    return read_unfinished(path) if os.path.isdir(path) else open_runs(path)


def _rounds(path: Path) -> list[Path]:
    """Rounds of a study with `until`, see `hydrosim.studies.sweep.precise`."""
    result = path.with_suffix("") if path.suffix == PARTIAL else path
    folder = Path(f"{result}.rounds")
    return sorted(folder.glob("*.nc*")) if os.path.isdir(folder) else []


def read_unfinished(folder: Path) -> xr.Dataset:
    """Dataset of an unfinished study, in memory, in the form of its later file. Runs that are not
    complete have NaN or -1, and the status "not run". Variables of a thousand or more values per
    run are left out. The attribute ``gathered`` says how many runs are complete. Nothing in the
    folder is changed, and the study may continue meanwhile."""
    if not (folder / RUNS).is_file():
        raise InputError(f"{folder}: has no runs of a sweep{_expected_folder_text(folder)}.")
    if not (folder / KNOWN).is_file():
        raise _earlier(folder, f"lacks {KNOWN}")
    try:
        if is_earlier(folder):
            raise _earlier(folder, f"lines of {RUNS} have no checksums")
        known = xr.load_dataset(folder / KNOWN, engine="netcdf4", decode_times=False)
        first = first_of(folder)
        with (folder / RUNS).open("rb") as file:
            return _gather_runs(folder, known, first, file)
    except FileNotFoundError:
        raise InputError(f"{folder}: no longer exists, because its sweep has ended.") from None
    except (OSError, RuntimeError, ValueError) as error:
        raise InputError(
            f"{folder}: cannot be read ({error}); sweep --resume tells whether the sweep can"
            " continue."
        ) from None


def _earlier(folder: Path, found: str) -> InputError:
    return InputError(
        f"{folder}: {found}, because an earlier version of the program began it; expected a"
        " folder of this version. Let that program finish, or continue with it."
    )


def _gather_runs(
    folder: Path, known: xr.Dataset, first: xr.Dataset | None, file: BinaryIO
) -> xr.Dataset:
    count = known.sizes[RUN]
    status, messages, warnings = (
        known[name].values.astype(object) for name in ("status", "status_message", "warnings")
    )
    whole = np.dtype([]) if first is None else form_of(first)
    small = [name for name in whole.names or () if whole[name].itemsize < 8 * LARGE]
    chosen = whole[small]
    table = _empty_rows(count, repack_fields(chosen))
    common: dict[str, object] | None = None
    file.readline()
    for _, entry, values in entries(file, folder):
        if values and first is None:
            continue
        run = entry["run"]
        status[run] = entry.get("status", COMPLETE)
        messages[run] = entry.get("message", "")
        warnings[run] = entry.get("warnings", "")
        if values:
            table[run] = np.frombuffer(values, chosen)[0]
            common = in_common(
                entry["attributes"] if common is None else common, entry["attributes"]
            )
    done = int(np.sum(status == COMPLETE))
    failed = [f"run {k}: {messages[k]}" for k in np.flatnonzero(status == "failed")]
    said = f"{done:,} of {count:,} runs are complete" + (
        f", {len(failed):,} failed" if failed else ""
    )
    if first is None or not done:
        raise InputError(
            f"{folder}: {said}. Wait for the first complete run, or continue the sweep with"
            f" --resume. {' '.join(failed[:1])}".strip()
        )
    texts = {"status": status, "status_message": messages, "warnings": warnings}
    found = known.assign({name: known[name].copy(data=text) for name, text in texts.items()})
    parts = {name: ((RUN, *first[name].dims), _values(table[name])) for name in small}
    found = found.assign({n: (*part, first[n].attrs) for n, part in parts.items()})
    by_run = [name for name in str(known.attrs.get(BY_RUN, "")).split() if name in small]
    found = found.assign_coords(first.coords).set_coords(by_run)
    return found.assign_attrs({**(common or {}), GATHERED: said})


def _values(column: np.ndarray) -> np.ndarray:
    """Values as xarray reads them from a file: integers with missing values become floats."""
    if column.dtype.kind == "f":
        return np.ascontiguousarray(column)
    found = column.astype(np.promote_types(column.dtype, np.float32))
    found[column == MISSING] = np.nan
    return found


def _empty_rows(count: int, form: np.dtype[np.void]) -> np.ndarray:
    """An empty row for each run."""
    row = np.zeros((), form)
    for name in form.names or ():
        row[name] = np.nan if form[name].base.kind == "f" else MISSING
    return np.full(count, row)


def _expected_folder_text(folder: Path) -> str:
    """Suggestion for a user who gave another folder."""
    meant = sorted(part.parent.name for part in folder.glob(f"*{PARTIAL}/{FIRST_RUN_FILE}"))
    example = f"{folder / meant[0]}" if meant else "RUNS.nc.partial"
    more = f" (others here: {', '.join(meant)})" if len(meant) > 1 else ""
    way = f"the folder of an unfinished sweep, such as {example}{more}"
    return f"; expected the result of a run or of a study, or {way}"
