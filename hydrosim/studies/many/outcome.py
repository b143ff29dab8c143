"""One run of many: how it ended, and what is kept of it."""

from __future__ import annotations

import fnmatch
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple
from zlib import crc32

import numpy as np
import xarray as xr

from hydrosim.errors import InputError
from hydrosim.results.assembled import assembled
from hydrosim.results.channels import chosen, names
from hydrosim.results.error_figures import (
    COMPANION,
    CONTACT_FORCE,
    EVALUATIONS,
    PARTED,
    RELATIVE,
)
from hydrosim.results.memory import MEMORY_PREFIX
from hydrosim.statistics.figures import RequestedStatistic
from hydrosim.statistics.results import Results
from hydrosim.statistics.statistics import RECORDED_SUFFIX, columns, of_contacts

if TYPE_CHECKING:
    from hydrosim.studies.many.form import Form

COUNTS = ("solver_steps", "solver_events", "energy_residual_relative")
PER_RUN_ATTRIBUTES = {
    *(*COUNTS, "solver_rejected", "solver_evaluations", "wall_time", "seeds", "warnings"),
    *(RELATIVE, CONTACT_FORCE, PARTED, COMPANION, EVALUATIONS),
    *("status", "status_message", "format", "date_created"),
}
"""Attributes of a run that are no attributes of the set."""


class Outcome(NamedTuple):
    """How a run ended, why, what it was warned of; what is kept of it, and its attributes that are
    those of all."""

    status: str
    message: str = ""
    warnings: str = ""
    found: xr.Dataset | None = None
    attributes: Mapping[str, object] = {}


def digested(
    run: xr.Dataset,
    variables: list[str],
    start: float,
    figures: Sequence[RequestedStatistic] = (),
    channels: Sequence[str] = (),
    lenient: bool = False,
) -> xr.Dataset:
    """What is kept of a run. Raises InputError where it has not all variables, figures and
    ``channels`` (patterns) that are asked for; a ``lenient`` one leaves out what it has not."""
    unknown = [name for name in variables if name not in run]
    variables = [name for name in variables if name in run] if lenient else variables
    if unknown and not lenient:
        known = ", ".join(str(name) for name, each in run.items() if "time" in each.dims)
        raise InputError(f"variables: found {', '.join(unknown)}; expected some of: {known}.")
    found, coords, attributes = columns(run, start, None, _chosen(run, channels, lenient))
    found = {name: of for name, of in found.items() if not name.endswith(RECORDED_SUFFIX)}
    more: dict[str, Any] = {**found, **of_contacts(run), "end_position": _end(run)}
    if "fender" in run.dims:
        more |= {"first_contact": _first_contact(run), "contact_sequence": _sequence(run)}
    more |= {name: xr.Variable((), run.attrs[name]) for name in COUNTS}
    more[RELATIVE] = _error(run)
    results = Results(run)
    why = results.explanation if "impulse" in run else xr.Dataset()
    for figure in figures:
        if any(figure.name in each for each in (more, coords, run, why)):
            raise InputError(
                f"figures: found the name {figure.name}, which is that of a variable"
                " of the runs; expected another one."
            )
        try:
            more[figure.name] = figure.evaluate(results).variable
        except InputError:
            if not lenient:
                raise
    kept = assembled(more, coords, attributes)
    if why:
        kept = xr.merge([kept, why], join="exact", compat="equals")
    if variables:
        kept = xr.merge([run[variables], kept], join="outer", compat="equals")
    # adaptive runs end their last steps at different times
    return kept.drop_vars([name for name in kept.coords if str(name).startswith(MEMORY_PREFIX)])


def _chosen(run: xr.Dataset, patterns: Sequence[str], lenient: bool) -> list[str]:
    """The channels of a run that patterns fit."""
    if not patterns:
        return []
    known = names(run)
    if lenient:
        patterns = [pattern for pattern in patterns if fnmatch.filter(known, pattern)]
    return chosen(known, patterns, "output.channels")


def fitted(run: xr.Dataset, form: Form, keep: Callable[[xr.Dataset], xr.Dataset]) -> xr.Dataset:
    """What is kept of a run, in the ``form`` of its set."""
    return form.fitted(keep(run))


def _end(run: xr.Dataset) -> xr.Variable:
    end = run.variables["position"].isel(time=-1)
    end.attrs["long_name"] = "displacement and angles at the end of the run"
    return end


def _error(run: xr.Dataset) -> xr.Variable:
    """The measured error of motions, NaN where a run did not measure it."""
    said = {"units": "1", "long_name": "largest error of a motion, relative to its range"}
    return xr.Variable((), float(run.attrs.get(RELATIVE, np.nan)), said)


def _sequence(run: xr.Dataset) -> xr.Variable:
    """A number for the order in which contacts open, stick and slip, as recorded. Runs with
    other orders have other numbers."""
    modes = run.fender_mode.transpose("time", "fender").values
    changed = np.any(modes[1:] != modes[:-1], axis=1)
    order = modes[np.append(True, changed)].astype(np.int8)
    said = {"long_name": "checksum of the order of contact modes"}
    return xr.Variable((), np.int64(crc32(np.ascontiguousarray(order).tobytes())), said)


def _first_contact(run: xr.Dataset) -> xr.Variable:
    """When each group of contacts touches first, NaN if it does not."""
    phase = run.contact_phase.transpose("contact_group", "time").values
    first = [run.time.values[np.argmax(of > 0)] if of.any() else np.nan for of in phase]
    said = {"units": "s", "long_name": "time of the first contact of a fender of the group"}
    return xr.Variable("contact_group", first, said)
