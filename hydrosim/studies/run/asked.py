"""Whether a run will have the channels and contacts that the criteria of its case name, from the
names in its records, before it is computed."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from hydrosim.case.criteria import CRITERIA
from hydrosim.compiling.clock import compile_clock
from hydrosim.documents.units import factor
from hydrosim.errors import InputError
from hydrosim.results.output import to_dataset
from hydrosim.statistics.criteria import figure_asked
from hydrosim.statistics.figures import figure_of
from hydrosim.stepping.record import new_record

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.compiling.compiled import Compiled


class NotAskable(InputError):
    """Criteria of a case that its run cannot be held against."""


def check_criteria(compiled: Compiled) -> None:
    """Raises NotAskable with a line for each criterion that the run cannot be held against."""
    asked = json.loads(compiled.scene.source.get(CRITERIA, "[]"))
    if not asked:
        return
    run = blank_run(compiled)
    reasons = [text for each in asked if (text := _refusal_reason(run, each))]
    if reasons:
        raise NotAskable("\n".join(reasons))


def blank_run(compiled: Compiled) -> xr.Dataset:
    """The dataset of a run with a single record of zeros: names, dimensions and units."""
    model = compiled.model
    record = new_record(model, compile_clock(compiled), compiled.scene.output_accelerations)
    history = compiled.first_state().history
    layout = compiled.facts.layout
    return to_dataset(compiled.scene, model, layout, compiled.sea, record, 1, history, {})


def _refusal_reason(run: xr.Dataset, asked: dict[str, str]) -> str:
    """Why a criterion cannot be judged, at its key; empty if it can be."""
    try:
        figure = figure_of(run, figure_asked(asked))
    except InputError as error:
        given = [key for key in ("group", "phase", "channel") if asked.get(key)]
        wrong = next((key for key in given if asked[key] in str(error)), "result")
        return f"criteria.{asked['name']}.{wrong}: {error}"
    return _unit_refusal_reason(str(figure.attrs["units"]), asked)


def _unit_refusal_reason(own: str, asked: dict[str, str]) -> str:
    """Why a limit cannot be compared with a figure in its ``own`` SI unit; empty if it can be."""
    unit = "" if own == "1" else own
    try:
        if asked["unit"]:
            factor(asked["unit"], unit)
    except ValueError as error:
        return (
            f'criteria.{asked["name"]}.limit: found "{asked["text"]}"; expected a limit in'
            f" {unit or 'plain numbers'}, which {asked['channel'] or asked['result']} has; {error}"
        )
    return ""
