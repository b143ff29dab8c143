"""One run of many: how it ended, and what is kept of it."""

from __future__ import annotations

import fnmatch
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple
from zlib import crc32

import numpy as np
import xarray as xr

from hydrosim.errors import InputError
from hydrosim.results.channels import channel_names, match_channels
from hydrosim.results.dataset import new_dataset
from hydrosim.results.ledger import COMPANION, CONTACT_FORCE, EVALUATIONS, PARTED, RELATIVE
from hydrosim.results.memory import MEMORY_PREFIX
from hydrosim.results.variables import describe_coordinates
from hydrosim.statistics.figures import RequestedStatistic
from hydrosim.statistics.results import RunResults
from hydrosim.statistics.statistics import RECORDED_SUFFIX, columns, of_units

if TYPE_CHECKING:
    from hydrosim.study.run_layout import RunLayout

COUNT_ATTRIBUTES = {
    "solver_steps": "steps of the solver",
    "solver_events": "events of the solver",
    "energy_residual_relative": "largest residual of the energy balance, of the energy exchanged",
}
"""Attributes of a run that are variables of a set, and what they are."""
PER_RUN_ATTRIBUTES = {
    *(*COUNT_ATTRIBUTES, "solver_rejected", "solver_evaluations", "wall_time", "seeds", "warnings"),
    *(RELATIVE, CONTACT_FORCE, PARTED, COMPANION, EVALUATIONS),
    *("status", "status_message", "format", "date_created"),
}
"""Attributes of a run that are no attributes of the set."""


class RunOutcome(NamedTuple):
    """How a run ended, why, what it was warned of; what is kept of it, and its attributes that are
    those of all."""

    status: str
    message: str = ""
    warnings: str = ""
    found: xr.Dataset | None = None
    attributes: Mapping[str, object] = {}


def reduce_run(
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
        series_names = ", ".join(
            str(name) for name, variable in run.items() if "time" in variable.dims
        )
        raise InputError(
            f"variables: found {', '.join(unknown)}; expected some of: {series_names}."
        )
    statistics, coords, attributes = columns(
        run, start, None, _chosen_channels(run, channels, lenient)
    )
    statistics = {name: of for name, of in statistics.items() if not name.endswith(RECORDED_SUFFIX)}
    variables_of_run: dict[str, Any] = {
        **statistics,
        **of_units(run),
        "end_position": _end_position(run),
    }
    if "fender" in run.dims:
        variables_of_run |= {
            "first_contact": _first_contact_times(run),
            "contact_sequence": _contact_sequence(run),
        }
    variables_of_run |= {
        name: xr.Variable((), run.attrs[name], {"units": "1", "long_name": what})
        for name, what in COUNT_ATTRIBUTES.items()
    }
    variables_of_run[RELATIVE] = _relative_error(run)
    results = RunResults(run)
    why = results.explanation if "impulse" in run else xr.Dataset()
    for figure in figures:
        if any(figure.name in names for names in (variables_of_run, coords, run, why)):
            raise InputError(
                f"figures: found the name {figure.name}, which is that of a variable"
                " of the runs; expected another one."
            )
        try:
            variables_of_run[figure.name] = figure.evaluate(results).variable
        except InputError:
            if not lenient:
                raise
    reduced = new_dataset(variables_of_run, coords, attributes)
    if why:
        reduced = xr.merge([reduced, why], join="exact", compat="equals")
    if variables:
        reduced = xr.merge([run[variables], reduced], join="outer", compat="equals")
    describe_coordinates(reduced)
    # adaptive runs end their last steps at different times
    return reduced.drop_vars(
        [name for name in reduced.coords if str(name).startswith(MEMORY_PREFIX)]
    )


def _chosen_channels(run: xr.Dataset, patterns: Sequence[str], lenient: bool) -> list[str]:
    """The channels of a run that patterns fit."""
    if not patterns:
        return []
    channels = channel_names(run)
    if lenient:
        patterns = [pattern for pattern in patterns if fnmatch.filter(channels, pattern)]
    return match_channels(channels, patterns, "output.channels")


def pad_to_layout(
    run: xr.Dataset, form: RunLayout, keep: Callable[[xr.Dataset], xr.Dataset]
) -> xr.Dataset:
    """What is kept of a run, in the ``form`` of its set."""
    return form.pad_run(keep(run))


def _end_position(run: xr.Dataset) -> xr.Variable:
    end = run.variables["position"].isel(time=-1)
    end.attrs["long_name"] = "displacement and angles at the end of the run"
    return end


def _relative_error(run: xr.Dataset) -> xr.Variable:
    """The measured error of motions, NaN where a run did not measure it."""
    attributes = {"units": "1", "long_name": "largest error of a motion, relative to its range"}
    return xr.Variable((), float(run.attrs.get(RELATIVE, np.nan)), attributes)


def _contact_sequence(run: xr.Dataset) -> xr.Variable:
    """A number for the order in which contacts open, stick and slip, as recorded. Runs with
    other orders have other numbers."""
    modes = run.fender_mode.transpose("time", "fender").values
    changed = np.any(modes[1:] != modes[:-1], axis=1)
    order = modes[np.append(True, changed)].astype(np.int8)
    attributes = {"units": "1", "long_name": "checksum of the order of contact modes"}
    return xr.Variable((), np.int64(crc32(np.ascontiguousarray(order).tobytes())), attributes)


def _first_contact_times(run: xr.Dataset) -> xr.Variable:
    """When each group of contacts touches first, NaN if it does not."""
    phase = run.contact_phase.transpose("contact_group", "time").values
    first = [run.time.values[np.argmax(of > 0)] if of.any() else np.nan for of in phase]
    attributes = {"units": "s", "long_name": "time of the first contact of a fender of the group"}
    return xr.Variable("contact_group", first, attributes)
