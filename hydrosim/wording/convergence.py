"""What a run itself knows of its errors, and what it does not."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite, nan
from pathlib import Path
from typing import TYPE_CHECKING

import xarray as xr

from hydrosim.presentation.document import Cell, Document, List, Node, Sentence, Table, Value
from hydrosim.presentation.units import DEFAULT, Units
from hydrosim.results.ledger import CLOSED
from hydrosim.wording.parts import lines_of

if TYPE_CHECKING:
    from hydrosim.studies.run.converge import Study, Trial


def convergence(run: xr.Dataset) -> Iterator[Node]:
    """The residual of energy, errors of radiation; what was not assessed is said to be so."""
    name = Path(str(run.attrs.get("case_file", "CASE.yaml"))).name
    yield Sentence(
        "This run does not assess how motions, crawl and extremes change with the solver's step and"
        " with the seeds. hydrosim converge {} compares steps and methods. hydrosim sweep"
        " compares seeds.",
        [name],
    )
    if "energy_residual_relative" in run.attrs:
        found = Value(float(run.attrs["energy_residual_relative"]), digits=2)
        rows = [("residual of the energy balance", found, Value(CLOSED, digits=2))]
        yield Table(("evidence", "found", "warned of beyond"), rows)
        yield Sentence(
            "The residual is relative to the energy exchanged, over the worst stretch of time. A"
            " small residual shows that the integration keeps energy. It does not show that a finer"
            " step gives the same motions."
        )
    if lines := lines_of(run, "radiation_errors"):
        yield List(lines, "Radiation")


def study_document(study: Study, title: str, units: Units = DEFAULT) -> Document:
    """The errors of each method and setting against run time."""
    head = ("method", "setting", "motion", "order", "crawl", "energy", "evaluations", "time")
    said = Sentence(
        "Errors are against rk4 at {}, whose own error is {}.",
        [Value(study.reference_step, "s"), Value(study.reference_error, "m", 2)],
    )
    return Document(title, [said, Table(head, list(_trials(study)))], units=units)


def _trials(study: Study) -> Iterator[list[Cell]]:
    last: Trial | None = None
    for trial in study.trials:
        same = last is not None and last.method is trial.method
        order = trial.order(last) if last is not None and same else nan
        cells: list[Cell] = [str(trial.method), Value(trial.setting, digits=3)]
        last = trial
        if trial.remark:
            yield [*cells, "failed", "", "", "", "", ""]
            continue
        errors: list[Cell] = [
            Value(trial.motion, "m", 2),
            Value(order, digits=2) if isfinite(order) else "",
        ]
        errors += [Value(trial.crawl, "m", 2), Value(trial.energy, "", 2)]
        cost: list[Cell] = [Value(float(trial.evaluations), digits=9), Value(trial.seconds, "s", 3)]
        yield [*cells, *errors, *cost]
