"""Sentences and tables of a run: its end, criteria, stages, motions, contacts, lines and errors."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from math import isfinite, isinf, nan
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.elements.contact.law import OPEN, SLIP, STICK
from hydrosim.elements.joint.locks import CLOSED as CLOSED_JOINT
from hydrosim.elements.joint.locks import WAITING
from hydrosim.elements.kind import SummaryColumn, Topic, Variable
from hydrosim.elements.trigger import BEFORE
from hydrosim.files.display_units import DEFAULT, Units, unit_of_dof, units_of
from hydrosim.files.document import Document
from hydrosim.files.document_nodes import (
    Cell,
    List,
    Nodes,
    Outcome,
    Part,
    Row,
    Sentence,
    Table,
    Value,
    Verdict,
    value_cells,
    warning,
    warnings,
)
from hydrosim.files.series import unit_of, units_along
from hydrosim.report.sentences.sections import attribute_text, lines_of, title_of
from hydrosim.results import ledger, phases
from hydrosim.results.channels import largest_loads
from hydrosim.results.dataset import is_part
from hydrosim.results.variables import BY_RANK
from hydrosim.statistics.figures import Criterion, criteria_of

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.study.converge import ConvergenceStudy, ConvergenceTrial

# Stages of groups of contacts, and impacts where contacts close.


def stage_nodes(run: xr.Dataset) -> Nodes:
    """Times of the stages and figures of the contacts, a column for each group. Groups without a
    stage are left out, and a run without groups has no table."""
    if phases.STAGE_TIME not in run:
        return
    times = run[phases.STAGE_TIME].transpose("contact_group", "stage").values
    groups = run.isel(contact_group=np.flatnonzero(np.isfinite(times).any(axis=1)))
    if groups.sizes["contact_group"]:
        head = ("stage or figure", *map(str, groups.contact_group.values))
        yield Table(head, [*_stage_time_rows(groups), *_stage_figure_rows(groups)], "Stages")


def _stage_time_rows(groups: xr.Dataset) -> Iterator[Row]:
    """The time of each stage that a group has come to."""
    for stage in groups.stage.values:
        times = groups[phases.STAGE_TIME].sel(stage=stage).values
        if np.isfinite(times).any():
            yield [str(stage), *value_cells(times, "s", 6)]


def _stage_figure_rows(groups: xr.Dataset) -> Iterator[Row]:
    for name, (what, unit) in phases.FIGURES.items():
        yield [what, *value_cells(groups[name].values, unit)]


# Criteria of a run: values, limits and margins.


def criteria_nodes(run: xr.Dataset) -> Nodes:
    """A verdict on all criteria of a run, one on each that is not met, and the register."""
    criteria = criteria_of(run)
    if not criteria:
        return
    yield criteria_verdict(criteria)
    yield from (criterion_not_met(criterion) for criterion in criteria if not criterion.is_met)
    head = ("criterion", "value", "limit", "margin", "used", "", "source of the limit")
    rows = [
        [*criterion_figures(criterion), met_or_not(criterion), criterion.source]
        for criterion in criteria
    ]
    yield Table(head, rows, "Criteria")
    yield meanings(criteria)


def criteria_verdict(
    criteria: Sequence[Criterion], where: str = "", best: Outcome = Outcome.GOOD
) -> Verdict:
    """How many criteria are met ``where``; the ``best`` outcome if all are."""
    met = sum(criterion.is_met for criterion in criteria)
    counts = [str(met), str(len(criteria))]
    text = f"{{}} of {{}} criteria are met{where}."
    if met < len(criteria):
        return Verdict(Outcome.BAD, text, counts)
    used = [criterion for criterion in criteria if isfinite(criterion.utilisation)]
    if not used:
        return Verdict(best, text, counts)
    most = max(used, key=lambda criterion: criterion.utilisation)
    share = Value(most.utilisation, "share", 3)
    text += " {} uses the most of its limit: {}."
    return Verdict(best, text, [*counts, most.name, share])


def criterion_not_met(of: Criterion, at: str = "", more: str = "") -> Verdict:
    """What a criterion comes to ``at`` a place, what is allowed, and ``more``."""
    if of.missing:
        return Verdict(Outcome.BAD, "{} has no value: {}", [of.name, of.missing])
    side = "at least" if of.is_least else "at most"
    return Verdict(
        Outcome.BAD,
        "{}: {} is {}{}; allowed is {} {}.{}",
        [of.name, of.what, _shown_value(of), at, side, Value(of.limit, of.unit), more],
    )


def criterion_figures(of: Criterion) -> Row:
    """Name, value, limit, margin, and the share of the limit that is used."""
    limits = value_cells((of.limit, of.margin), of.unit)
    return [of.name, _shown_value(of), *limits, Value(of.utilisation, "share", 3)]


def _shown_value(of: Criterion) -> Value | str:
    return "never" if isinf(of.value) else Value(of.value, of.unit)


def met_or_not(of: Criterion) -> str:
    """The verdict in a table."""
    return "met" if of.is_met else "NOT MET"


def meanings(criteria: Sequence[Criterion]) -> List:
    """What each criterion is of, for readers who ask for more."""
    return List(
        [Sentence("{}: {}", [criterion.name, criterion.what]) for criterion in criteria],
        detail=True,
    )


MODE_NUMBERS = (OPEN, STICK, SLIP)
RADIATION_GOOD = 0.01
"""Change of motions by the fits of radiation up to which they are good."""
SOLVER = {
    "solver_method": "method",
    "solver_chosen": "chosen for its tolerance",
    "solver_step": "step [s]",
    "solver_linear": "linear parts",
    "solver_steps": "steps",
    "solver_rejected": "rejected steps",
    "solver_events": "events",
    "solver_evaluations": "evaluations of the equation of motion",
    ledger.EVALUATIONS: "evaluations more, to measure the error",
    ledger.COMPANION: "compared with, to measure the error",
    "wall_time": "computing time [s]",
}


def run_document(run: xr.Dataset) -> Document:
    """The summary of a run, also of one that failed or was interrupted."""
    return Document(title_of(run), list(summary(run)), units=units_of(run.attrs))


def summary(run: xr.Dataset) -> Nodes:
    """Criteria and verdicts first, then tables, then how the run was solved."""
    if not is_part(run):
        yield from criteria_nodes(run)
    yield from verdicts(run)
    if seas := lines_of(run, "seas"):
        yield List(seas, "Waves")
    yield from result_tables(run)
    yield from solver_tables(run)


def result_tables(run: xr.Dataset) -> Nodes:
    """Motions, contacts, lines and clearances."""
    head = ("motion", "mean", "std", "smallest", "largest", "at the end")
    measured = "position_error" in run and not is_part(run)
    yield Table((*head, "error") if measured else head, list(_motion_rows(run, measured)))
    yield from _unit_tables(run, Topic.JOINTS, Topic.DRIVES)
    if "drive" in run.dims and run.time.size:
        driven = ("drive", "largest force", "work done")
        yield Table(driven, list(_drive_rows(run)), "Prescribed motion")
    if rows := list(_lock_rows(run)):
        held = ("joint", "first closed", "last closed", "closed", "energy lost")
        yield Table(held, rows, "Joints that come and go, at output times")
    if "fender" in run.dims:
        head = ("contact", "first", "open", "stick", "slip", "slipped")
        title = "Contacts: time of the first, then the share of the time since it in each mode"
        yield Table(head, list(_contact_rows(run)), title)
        if not is_part(run):
            yield from stage_nodes(run)
    yield from _unit_tables(run, Topic.TENSIONS, Topic.JOINTS)
    yield from _unit_tables(run, Topic.LINKS, Topic.CAPACITIES)
    yield from _unit_tables(run, Topic.COORDINATES, Topic.LINKS)
    if "pto" in run.dims:
        powers = ("power take-off", "mean power", "largest", "absorbed")
        yield Table(powers, list(_pto_rows(run)))
    if rows := list(_capacity_rows(run)):
        shares = ("of a capacity", "largest load", "at", "capacity", "used")
        yield Table(shares, rows, "Loads beside capacities, at output times")
    if acted := lines_of(run, "external_forces"):
        yield List(acted, "External forces, by functions of Python", detail=True)
    yield from _unit_tables(run, Topic.CAPACITIES, Topic.DETAILS)


def solver_tables(run: xr.Dataset) -> Nodes:
    """Method and steps of the solver, and models of radiation."""
    if not is_part(run):
        yield Table(("solver", ""), list(_solver_rows(run)), detail=True)
    if told := list(_radiation_texts(run)):
        yield List(told, "Radiation", detail=True)


def verdicts(run: xr.Dataset) -> Nodes:
    """How the run ended, whether its energy adds up, how good its radiation is, and warnings."""
    yield status_verdict(run)
    yield from solution_verdicts(run)
    yield from warnings(lines_of(run, "warnings"))
    yield from element_verdicts(run)


def solution_verdicts(run: xr.Dataset) -> Iterator[Verdict]:
    """Whether energy adds up, how large errors of steps are, how good radiation is."""
    if "energy_residual_relative" in run.attrs and not is_part(run):
        yield _energy_verdict(float(run.attrs["energy_residual_relative"]))
    if ledger.RELATIVE in run.attrs and not is_part(run):
        yield from _error_verdicts(run)
    if "radiation_error" in run.attrs:
        yield radiation_verdict(float(run.attrs["radiation_error"]))


def element_verdicts(run: xr.Dataset) -> Nodes:
    """Elements that have not begun, joints that have not closed, loads above capacities."""
    if "trigger" in run.dims:
        yield from _describe_waiting(run)
    yield from _never_closed(run)
    yield from _overload_warnings(run)


def status_verdict(run: xr.Dataset) -> Verdict:
    """How the run ended."""
    simulated = Value(float(np.ptp(run.time.values)) if run.time.size else 0.0, "s", 6)
    status = str(run.attrs.get("status", "unknown"))
    if is_part(run):
        text = (
            "This is a part of a run ({}): {} records over {}."
            " Figures of the whole run are left out."
        )
        return warning(text, [status, str(run.time.size), simulated])
    start = ""
    if "initial_run" in run.attrs:
        start = f", started from {run.attrs['initial_run']} at {run.attrs['initial_time']:g} s"
    if status == "complete":
        return Verdict(Outcome.GOOD, "The run is complete: {} simulated{}.", [simulated, start])
    message = str(run.attrs.get("status_message", "")) or "no message was kept"
    parts: list[Value | str] = [status, simulated, start, message]
    return Verdict(Outcome.BAD, "The run is {} after {}{}: {}", parts)


def _energy_verdict(residual: float) -> Verdict:
    outcome = Outcome.GOOD if residual <= ledger.MAX_RESIDUAL_FRACTION else Outcome.WARNING
    text = "The energy balance closes to {} of the energy exchanged; the limit is {}."
    return Verdict(
        outcome, text, [Value(residual, digits=2), Value(ledger.MAX_RESIDUAL_FRACTION, digits=2)]
    )


def _error_verdicts(run: xr.Dataset) -> Iterator[Verdict]:
    """The measured error of motions; what is too large is a warning of the run."""
    error = float(run.attrs[ledger.RELATIVE])
    if error <= ledger.reported_beyond(run):
        text = "Errors of motions are {} of their range, measured against {}."
        yield Verdict(
            Outcome.GOOD, text, [Value(error, digits=1), str(run.attrs[ledger.COMPANION])]
        )


def radiation_verdict(error: float) -> Verdict:
    """How good radiation is, by the largest change of motions that its fits and cut make."""
    outcome = Outcome.GOOD if error <= RADIATION_GOOD else Outcome.WARNING
    text = "The model of radiation changes motions by at most {}; the limit is {}."
    return Verdict(outcome, text, [Value(error, "share", 2), Value(RADIATION_GOOD, "share", 2)])


def _describe_waiting(run: xr.Dataset) -> Nodes:
    """Elements and pumps that have not begun by the end."""
    before = np.all(run.trigger_stage.values == BEFORE, axis=0)
    for name in run.trigger.values[before]:
        text = "{} has not begun: its condition was not met."
        yield warning(text, [str(name)])


def _never_closed(run: xr.Dataset) -> Nodes:
    """Joints that wait for their window until the end."""
    for name in _names_of_locks(run):
        modes = run.lock_mode.sel(lock=name).values
        if modes.size and modes[-1] == WAITING and not (modes == CLOSED_JOINT).any():
            text = "{} has not closed: it was never within its window."
            yield warning(text, [name])


def _overload_warnings(run: xr.Dataset) -> Nodes:
    """Contacts and lines whose load was above their capacity."""
    for load in largest_loads(run):
        if load.largest > load.capacity:
            text = "{} carried {} at {}, more than its capacity of {}."
            values = [Value(load.largest, "N", 4), Value(load.time, "s", 4)]
            parts: list[Part] = [load.unit, *values, Value(load.capacity, "N", 4)]
            yield warning(text, parts)


def _capacity_rows(run: xr.Dataset) -> Iterator[Row]:
    """Largest loads beside capacities."""
    for load in largest_loads(run):
        used = Value(load.largest / load.capacity, "share", 3)
        largest = Value(load.largest, "N")
        yield [load.unit, largest, Value(load.time, "s"), Value(load.capacity, "N"), used]


def _largest_norm(vectors: np.ndarray) -> float:
    return float(np.linalg.norm(vectors, axis=1).max())


FIGURES: dict[str, tuple[Callable[[np.ndarray], float], str, int]] = {
    "at the start": (lambda x: x[0], "", 4),
    "mean": (np.mean, "", 4),
    "std": (np.std, "", 4),
    "smallest": (np.min, "", 4),
    "largest": (np.max, "", 4),
    "at the end": (lambda x: x[-1], "", 4),
    "share of zeros": (lambda x: np.mean(x == 0), "share", 2),
    "count": (lambda x: x[-1], "1", 0),
    "largest force": (lambda load: _largest_norm(load[:, :3]), "N", 4),
    "largest moment": (lambda load: _largest_norm(load[:, 3:]), "N m", 4),
}
"""Figures of a variable over time (nt, ...), each with its SI unit, by default that of the
variable, and its digits; without digits it is a whole number."""


def _unit_tables(run: xr.Dataset, first: int, end: int) -> Iterator[Table]:
    """A table for each dimension of units, of the summaries of its variables. These are about
    topics from the ``first`` up to, and without, the ``end``."""
    described: dict[str, Variable] = {}
    columns: dict[str, list[tuple[str, SummaryColumn]]] = {}
    for name, variable in BY_RANK.items():
        if variable.summary and name in run and run.sizes["time"]:
            dim = next(str(dim) for dim in run[name].dims if dim != "time")
            described.setdefault(dim, variable)
            columns.setdefault(dim, []).extend((c.variable or name, c) for c in variable.summary)
    for dim, variable in described.items():
        if not first <= variable.chart.rank < end:
            continue
        rows: list[Row] = [
            [unit, *(_figure_cell(run, name, column, dim, unit) for name, column in columns[dim])]
            for unit in map(str, run[dim].values)
        ]
        label = variable.row_label or dim.replace("_", " ")
        yield Table((label, *(column.heading for _, column in columns[dim])), rows)


def _figure_cell(run: xr.Dataset, name: str, column: SummaryColumn, dim: str, unit: str) -> Cell:
    """A figure of a unit. A part of a run has no start."""
    if column.figure == "at the start" and is_part(run):
        return ""
    figure, shown_unit, digits = FIGURES[column.figure]
    values = run[name].sel({dim: unit}).transpose("time", ...).values
    number = float(figure(values))
    if not digits:
        return f"{number:.0f}"
    return Value(number, shown_unit or units_along(run, name)[unit], digits)


def _motion_rows(run: xr.Dataset, measured: bool) -> Iterator[Row]:
    """How bodies move about their place at rest, where they do; with their ``measured`` errors."""
    for body in map(str, run.body.values):
        for dof in map(str, run.dof.values):
            x = run.position.sel(body=body, dof=dof).values
            if x.size and x.any():
                figures = (x.mean(), x.std(), x.min(), x.max(), x[-1])
                unit = unit_of_dof(dof)
                cells = value_cells(figures, unit)
                if measured:
                    error = float(run.position_error.sel(body=body, dof=dof))
                    cells.append(Value(error, unit, digits=1))
                yield [f"{body} {dof}", *cells]


def _drive_rows(run: xr.Dataset) -> Iterator[Row]:
    """The largest force of each drive, and its work over the run."""
    for label in map(str, run.drive.values):
        force = run.drive_force.sel(drive=label).values
        work = run[f"energy_work_{label.rpartition(' ')[0]}"].values
        unit = unit_of(run.drive_force.attrs, [label])
        largest = Value(float(np.abs(force).max()), unit)
        yield [label, largest, Value(float(work[-1] - work[0]), "J")]


def _lock_rows(run: xr.Dataset) -> Iterator[Row]:
    """When joints that come and go hold, and what their closing costs."""
    for name in _names_of_locks(run):
        closed = run.lock_mode.sel(lock=name).values == CLOSED_JOINT
        at = run.time.values[closed]
        if closed.all():
            continue
        first: Row = [Value(float(at[0]), "s"), Value(float(at[-1]), "s")] if at.size else []
        loss = run.lock_loss.sel(lock=name).values
        share = Value(float(closed.mean()), "share", 2)
        yield [name, *(first or ["never", ""]), share, Value(float(loss[-1] - loss[0]), "J")]


def _names_of_locks(run: xr.Dataset) -> list[str]:
    return list(map(str, run.lock.values)) if "lock" in run.dims else []


def _contact_rows(run: xr.Dataset) -> Iterator[Row]:
    modes = run.fender_mode.values
    time = run.time.values
    for i, name in enumerate(map(str, run.fender.values)):
        touching = np.flatnonzero(modes[:, i] != OPEN)
        if touching.size == 0:
            yield [name, "none", *("" for _ in MODE_NUMBERS), ""]
            continue
        later = modes[touching[0] :, i]
        shares = (Value(float(np.mean(later == mode)), "share", 2) for mode in MODE_NUMBERS)
        first = Value(float(time[touching[0]]), "s")
        slip = run.fender_slip_distance.values[:, i]
        before = slip[0] if is_part(run) else 0.0
        yield [name, first, *shares, Value(float(slip[-1] - before), "m")]


def _pto_rows(run: xr.Dataset) -> Iterator[Row]:
    """Power and energy of each power take-off; the energy is the integral of the power over the
    steps of the run."""
    lasts = float(run.time[-1] - run.time[0])
    for name in map(str, run.pto.values):
        lost = run[f"energy_dissipated_{name}"].values
        energy = float(lost[-1] - lost[0])
        largest = float(run.pto_power.sel(pto=name).max())
        mean = energy / lasts if lasts > 0.0 else largest
        yield [name, Value(mean, "W"), Value(largest, "W"), Value(energy, "J")]


def _solver_rows(run: xr.Dataset) -> Iterator[Row]:
    for key, label in SOLVER.items():
        if key in run.attrs:
            yield [label, attribute_text(run.attrs[key])]
    seconds = max(float(run.attrs.get("wall_time", 0.0)), 1e-9)
    if run.attrs.get("solver_steps"):
        yield ["steps in a second", attribute_text(float(run.attrs["solver_steps"]) / seconds)]


def _radiation_texts(run: xr.Dataset) -> Iterator[str]:
    """The model of each body, once for those of one database, and what its errors come to."""
    models = {str(body): str(run.attrs.get(f"radiation_{body}", "")) for body in run.body.values}
    first = {model: body for body, model in models.items() if model}
    yield from (f"{body}: {model}" for model, body in first.items())
    yield from lines_of(run, "radiation_errors")


# Errors of a run, as far as the run knows them.


def convergence(run: xr.Dataset) -> Nodes:
    """The residual of energy, errors of radiation; what was not assessed is said to be so."""
    name = Path(str(run.attrs.get("case_file", "CASE.yaml"))).name
    yield from _step_errors(run)
    yield Sentence(
        "This run does not assess how motions, crawl and extremes change with the seeds. hydrosim"
        " sweep compares seeds. hydrosim analyse --converge {} compares steps and methods.",
        [name],
    )
    if rows := list(_evidence_entries(run)):
        yield Table(("evidence", "found", "warned of beyond"), rows)
        yield Sentence(
            "The residual is relative to the energy exchanged, over the worst stretch of time. A"
            " small residual shows that the integration keeps energy."
        )
    if lines := lines_of(run, "radiation_errors"):
        yield List(lines, "Radiation")


def _step_errors(run: xr.Dataset) -> Nodes:
    """What the errors by the steps of the solver were measured against."""
    if ledger.COMPANION in run.attrs:
        yield Sentence(
            "Errors by the steps of the solver were measured: the run was compared with {}.",
            [str(run.attrs[ledger.COMPANION])],
        )
    elif "solver_linear" in run.attrs and str(run.attrs["solver_linear"]).startswith("stepped"):
        yield Sentence("Errors by the steps of the solver were not measured.")


def _evidence_entries(run: xr.Dataset) -> Iterator[tuple[str, Value, Value | str]]:
    """Measured errors and the residual of the energy balance, each with its limit."""
    limit = Value(ledger.reported_beyond(run), digits=2)
    for text, figure in (
        ("error of motions, relative to their range", ledger.RELATIVE),
        ("error of the largest contact force, relative to it", ledger.CONTACT_FORCE),
    ):
        if figure in run.attrs:
            beyond = limit if figure == ledger.RELATIVE else ""
            yield text, Value(float(run.attrs[figure]), digits=2), beyond
    if "energy_residual_relative" in run.attrs:
        residual = Value(float(run.attrs["energy_residual_relative"]), digits=2)
        yield (
            "residual of the energy balance",
            residual,
            Value(ledger.MAX_RESIDUAL_FRACTION, digits=2),
        )


def study_document(study: ConvergenceStudy, title: str, units: Units = DEFAULT) -> Document:
    """The errors of each method and setting against run time."""
    head = ("method", "setting", "motion", "order", "crawl", "energy", "evaluations", "time")
    reference = Sentence(
        "Errors are against rk4 at {}, whose own error is {}.",
        [Value(study.reference_step, "s"), Value(study.reference_error, "m", 2)],
    )
    return Document(title, [reference, Table(head, list(_trial_rows(study)))], units=units)


def _trial_rows(study: ConvergenceStudy) -> Iterator[Row]:
    last: ConvergenceTrial | None = None
    for trial in study.trials:
        same = last is not None and last.method is trial.method
        order = trial.order(last) if last is not None and same else nan
        cells: Row = [str(trial.method), Value(trial.setting, digits=3)]
        last = trial
        if trial.remark:
            yield [*cells, "failed", "", "", "", "", ""]
            continue
        errors: Row = [
            Value(trial.motion, "m", 2),
            Value(order, digits=2) if isfinite(order) else "",
        ]
        errors += [Value(trial.crawl, "m", 2), Value(trial.energy, "", 2)]
        cost: Row = [Value(float(trial.evaluations), digits=9), Value(trial.seconds, "s", 3)]
        yield [*cells, *errors, *cost]
