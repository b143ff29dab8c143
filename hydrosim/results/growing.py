"""Runs of a set while they are made: those that are in its folder `RUNS.nc.partial` so far."""

from __future__ import annotations

import os
from pathlib import Path
from typing import BinaryIO

import numpy as np
import xarray as xr
from numpy.lib.recfunctions import repack_fields

from hydrosim.errors import InputError
from hydrosim.results.journal import FIRST, KNOWN, RUNS, entries, first_of, form_of, is_earlier
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
GATHERED = "gathered"  # attribute of runs that are not all in: what is, in words


def runs_at(path: Path) -> xr.Dataset | None:
    """The runs in a file of many, or in the folder of a set on its way; None of another file.
    Raises InputError for a folder that is none of these or has no complete run yet."""
    other = path.with_suffix("") if path.suffix == PARTIAL else Path(f"{path}{PARTIAL}")
    if os.path.exists(other) and not os.path.exists(path):
        of = "the result of the sweep" if path.suffix == PARTIAL else "a sweep on its way"
        raise InputError(f"{path}: is not there; {other} is, {of}.")
    if not os.path.exists(path) and (rounds := _rounds(path)):
        raise InputError(
            f"{path}: is not there; a study on its way that takes seeds until a mean is known well"
            f" keeps its last round in {rounds[-1]}."
        )
    return growing(path) if os.path.isdir(path) else open_runs(path)


def _rounds(path: Path) -> list[Path]:
    """The rounds of a study `until` something is known, see `hydrosim.studies.sweep.precise`."""
    result = path.with_suffix("") if path.suffix == PARTIAL else path
    folder = Path(f"{result}.rounds")
    return sorted(folder.glob("*.nc*")) if os.path.isdir(folder) else []


def growing(folder: Path) -> xr.Dataset:
    """The dataset of a set on its way, in memory and like that of its file in the end: NaN or -1 of
    a run that is not in, whose status is "not run". Variables of a thousand values a run and more
    are left out. The attribute ``gathered`` says in words how many runs are in. Nothing in the
    folder is changed, and whoever makes the runs may go on meanwhile."""
    if not (folder / RUNS).is_file():
        raise InputError(f"{folder}: holds no runs of a sweep{_near(folder)}.")
    if not (folder / KNOWN).is_file():
        raise _earlier(folder, f"lacks {KNOWN}")
    try:
        if is_earlier(folder):
            raise _earlier(folder, f"lines of {RUNS} have no checksums")
        known = xr.load_dataset(folder / KNOWN, engine="netcdf4", decode_times=False)
        first = first_of(folder)
        with (folder / RUNS).open("rb") as file:
            return _gathered(folder, known, first, file)
    except FileNotFoundError:
        raise InputError(f"{folder}: is gone, as its sweep has come to an end.") from None
    except (OSError, RuntimeError, ValueError) as error:
        raise InputError(
            f"{folder}: cannot be read ({error}); sweep --resume says whether it can go on."
        ) from None


def _earlier(folder: Path, found: str) -> InputError:
    return InputError(
        f"{folder}: {found}, as the program that began it is of an earlier version;"
        " expected a folder of this one. Let it end, or go on with that program."
    )


def _gathered(
    folder: Path, known: xr.Dataset, first: xr.Dataset | None, file: BinaryIO
) -> xr.Dataset:
    count = known.sizes[RUN]
    status, messages, warnings = (
        known[name].values.astype(object) for name in ("status", "status_message", "warnings")
    )
    whole = np.dtype([]) if first is None else form_of(first)
    small = [name for name in whole.names or () if whole[name].itemsize < 8 * LARGE]
    chosen = whole[small]
    table = _empty(count, repack_fields(chosen))
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
    said = f"{done:,} of {count:,} runs are in" + (f", {len(failed):,} failed" if failed else "")
    if first is None or not done:
        raise InputError(
            f"{folder}: {said} and whole; wait for the first one or, where nobody makes them any"
            f" more, go on with --resume. {' '.join(failed[:1])}".strip()
        )
    texts = {"status": status, "status_message": messages, "warnings": warnings}
    found = known.assign({name: known[name].copy(data=text) for name, text in texts.items()})
    parts = {name: ((RUN, *first[name].dims), _values(table[name])) for name in small}
    found = found.assign({n: (*part, first[n].attrs) for n, part in parts.items()})
    by_run = [name for name in str(known.attrs.get(BY_RUN, "")).split() if name in small]
    found = found.assign_coords(first.coords).set_coords(by_run)
    return found.assign_attrs({**(common or {}), GATHERED: said})


def _values(column: np.ndarray) -> np.ndarray:
    """As xarray reads them from a file: whole numbers of which some are missing are floats."""
    if column.dtype.kind == "f":
        return np.ascontiguousarray(column)
    found = column.astype(np.promote_types(column.dtype, np.float32))
    found[column == MISSING] = np.nan
    return found


def _empty(count: int, form: np.dtype[np.void]) -> np.ndarray:
    """A row for each run in which nothing is."""
    row = np.zeros((), form)
    for name in form.names or ():
        row[name] = np.nan if form[name].base.kind == "f" else MISSING
    return np.full(count, row)


def _near(folder: Path) -> str:
    """What somebody may have meant who gave another folder."""
    meant = sorted(part.parent.name for part in folder.glob(f"*{PARTIAL}/{FIRST}"))
    example = f"{folder / meant[0]}" if meant else "RUNS.nc.partial"
    more = f" (here are {', '.join(meant)})" if len(meant) > 1 else ""
    way = f"the folder of a sweep on its way, such as {example}{more}"
    return f"; expected the result of a run or of a study, or {way}"
