"""What a run itself knows of its errors, and what it does not."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite, nan
from pathlib import Path
from typing import TYPE_CHECKING

import xarray as xr

from hydrosim.presentation.document import Cell, Document, List, Node, Sentence, Table, Value
from hydrosim.presentation.units import DEFAULT, Units
from hydrosim.results.error_figures import (
    COMPANION,
    CONTACT_FORCE,
    RELATIVE,
    reported_beyond,
)
from hydrosim.results.ledger import MAX_RESIDUAL_FRACTION
from hydrosim.wording.sections import lines_of

if TYPE_CHECKING:
    from hydrosim.studies.run.converge import ConvergenceStudy, ConvergenceTrial


def convergence(run: xr.Dataset) -> Iterator[Node]:
    """The residual of energy, errors of radiation; what was not assessed is said to be so."""
    name = Path(str(run.attrs.get("case_file", "CASE.yaml"))).name
    yield from _step_errors(run)
    yield Sentence(
        "This run does not assess how motions, crawl and extremes change with the seeds. hydrosim"
        " sweep compares seeds. hydrosim converge {} compares steps and methods.",
        [name],
    )
    if rows := list(_evidence(run)):
        yield Table(("evidence", "found", "warned of beyond"), rows)
        yield Sentence(
            "The residual is relative to the energy exchanged, over the worst stretch of time. A"
            " small residual shows that the integration keeps energy."
        )
    if lines := lines_of(run, "radiation_errors"):
        yield List(lines, "Radiation")


def _step_errors(run: xr.Dataset) -> Iterator[Node]:
    """What the errors by the steps of the solver were measured against."""
    if COMPANION in run.attrs:
        yield Sentence(
            "Errors by the steps of the solver were measured: the run was compared with {}.",
            [str(run.attrs[COMPANION])],
        )
    elif "solver_linear" in run.attrs and str(run.attrs["solver_linear"]).startswith("stepped"):
        yield Sentence("Errors by the steps of the solver were not measured.")


def _evidence(run: xr.Dataset) -> Iterator[tuple[str, Value, Value | str]]:
    """Measured errors and the residual of the energy balance, each with its limit."""
    limit = Value(reported_beyond(run), digits=2)
    for text, figure in (
        ("error of motions, relative to their range", RELATIVE),
        ("error of the largest contact force, relative to it", CONTACT_FORCE),
    ):
        if figure in run.attrs:
            beyond = limit if figure == RELATIVE else ""
            yield text, Value(float(run.attrs[figure]), digits=2), beyond
    if "energy_residual_relative" in run.attrs:
        found = Value(float(run.attrs["energy_residual_relative"]), digits=2)
        yield "residual of the energy balance", found, Value(MAX_RESIDUAL_FRACTION, digits=2)


def study_document(study: ConvergenceStudy, title: str, units: Units = DEFAULT) -> Document:
    """The errors of each method and setting against run time."""
    head = ("method", "setting", "motion", "order", "crawl", "energy", "evaluations", "time")
    said = Sentence(
        "Errors are against rk4 at {}, whose own error is {}.",
        [Value(study.reference_step, "s"), Value(study.reference_error, "m", 2)],
    )
    return Document(title, [said, Table(head, list(_trials(study)))], units=units)


def _trials(study: ConvergenceStudy) -> Iterator[list[Cell]]:
    last: ConvergenceTrial | None = None
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
