"""The report of a study: what its parameters do to its figures, and how its runs went."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np
import xarray as xr

from hydrosim.errors import InputError
from hydrosim.wording.assumptions import assumptions, case_nodes
from hydrosim.presentation.document import Cell, Document, List, Node, Sentence, Table, Value, warnings
from hydrosim.presentation.figures import Curve, Curves
from hydrosim.presentation.units import units_of
from hydrosim.wording.parts import Parts, nodes_of, title_of
from hydrosim.results.ledger import CLOSED
from hydrosim.results.runs_file import COMPLETE
from hydrosim.statistics import effects
from hydrosim.statistics.effects import DRAWN, Plan, Row
from hydrosim.statistics.sentences import lines_of_runs

MOST = 300  # rows of a table, and remarks of a list
NAMED = 10  # runs that a remark is of
LINES = 12  # of a picture


def study_document(runs: xr.Dataset) -> Document:
    """The report of a file of many runs."""
    count, status = runs.sizes["run"], _counts(runs)
    said = ", ".join(f"{number} {name}" for name, number in status.items())
    return Document(title_of(runs), f"{count} runs: {said}", nodes_of(PARTS, runs))


def _counts(runs: xr.Dataset) -> Counter[str]:
    return Counter(map(str, runs.status.values))


def _outcome(runs: xr.Dataset) -> Iterator[Node]:
    yield Table(("runs", ""), [(name, Number(n, str(n))) for name, n in _counts(runs).items()])
    found: dict[str, list[int]] = {}
    for k, (status, message) in enumerate(
        zip(runs.status.values, runs.status_message.values, strict=True)
    ):
        if status != COMPLETE:
            found.setdefault(f"{status}: {message}".removesuffix(": "), []).append(k)
    if found:
        yield Points(_at_most([_of_runs(text, own) for text, own in found.items()]), grave=True)
        yield Sentence("Figures below are of the runs that are complete.")


def _of_runs(text: str, own: list[int]) -> str:
    """A remark with the numbers of the runs that it is of."""
    named = ", ".join(map(str, own[:NAMED])) + (", ..." if len(own) > NAMED else "")
    return f"{text} ({len(own)} runs: {named})"


def _results(runs: xr.Dataset) -> Iterator[Node]:
    """Tables and pictures of each plan; of seeds alone what lies between them."""
    if "design" not in runs.attrs:
        yield Sentence("The file does not say its plan: it was made by an earlier version.")
    for plan in effects.plans(runs) if "design" in runs.attrs else ():
        title = " ".join(f"{plan.name} {plan.design}".replace("_", " ").split())
        yield Sentence(f"Plan: {title}, {plan.runs.sizes['run']} runs.")
        if plan.figures:
            yield from _of_samples(plan) if plan.design in DRAWN else _of_values(plan)
        elif not plan.parameters and "motion" in runs:
            yield Sentence("Seeds alone. Between which values motions are, and extremes of a run:")
            yield Points(list(lines_of_runs(plan.runs)))
        else:
            yield Sentence("No figures were asked for in the study file.")


def _of_values(plan: Plan) -> Iterator[Node]:
    rows = list(effects.rows(plan))
    yield Sentence(
        "Means over seeds with their 90 % interval, and between which values another seed is by"
        " 90 %, both by Student's t: exact where a figure is normal over seeds."
    )
    names = [*dict.fromkeys(name for row in rows for name in row.values)]
    head = (*(names or ["of"]), "figure", "mean", "interval", "another seed", "runs")
    yield Table(head, [_cells(row, names) for row in rows[:MOST]])
    if len(rows) > MOST:
        yield Sentence(f"And {len(rows) - MOST} rows more: hydrosim statistics writes all of them.")
    yield from _pictures(plan, rows)


def _cells(row: Row, names: list[str]) -> list[Cell]:
    s = row.spread
    values = [_value(row.values.get(name, "")) for name in names] or ["all"]
    sure = [_between(s.low, s.high, row.unit), _between(s.another_low, s.another_high, row.unit)]
    return [*values, row.figure, number(s.mean, row.unit), *sure, Number(s.n, str(s.n))]


def _between(low: float, high: float, unit: str) -> str:
    return f"{number(low).text} to {number(high).text} {unit}" if np.isfinite(low) else "–"


def _value(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _pictures(plan: Plan, rows: list[Row]) -> Iterator[Node]:
    """Each figure over the first parameter that is a number, a line for each value of others."""
    axes = [plan.axis(parameter) for parameter in plan.parameters]
    numbers = [a for a in axes if np.asarray(plan.runs[a].values).dtype.kind in "if"]
    if not numbers or plan.design == "one_at_a_time":
        return
    axis = numbers[0]
    label = f"{axis} [{plan.runs[axis].attrs.get('units', 'SI')}]"
    for figure in plan.figures:
        own = [row for row in rows if row.figure == figure]
        others = [tuple(v for k, v in row.values.items() if k != axis) for row in own]
        kinds = list(dict.fromkeys(others))
        if len(kinds) <= LINES:
            curves = {
                ", ".join(map(_value, kind)) or figure: _curve(
                    [row for row, other in zip(own, others, strict=True) if other == kind], axis
                )
                for kind in kinds
            }
            unit = own[0].unit if own else ""
            title = f"{figure}: means over seeds with their 90 % intervals"
            yield Curves(title, label, f"{figure} [{unit}]", curves)


def _curve(rows: list[Row], axis: str) -> Curve:
    rows = sorted(rows, key=lambda row: float(row.values[axis]))
    x = np.array([float(row.values[axis]) for row in rows])
    y, low, high = np.array([row.spread[1:4] for row in rows], float).T
    return Curve(x, y, low, high, [f"at {value:.6g}" for value in x])


def _of_samples(plan: Plan) -> Iterator[Node]:
    if plan.design != "sobol_indices":
        rows = [(f, p, number(r, digits=3)) for f, p, r in effects.correlations(plan)]
        yield Table(("figure", "parameter", "Spearman's rank correlation"), rows)
        return
    try:
        found = list(effects.indices(plan))
    except InputError as error:
        yield Points([str(error)], grave=True)
        return
    head = ("figure", "parameter", "alone", "90 % interval", "with all others", "90 % interval")
    yield Sentence("Sobol's indices: shares of the variance of a figure.")
    yield Table(head, [[e.figure, e.parameter, *_share(e.first), *_share(e.total)] for e in found])


def _share(of: tuple[float, float, float]) -> tuple[Number, str]:
    return number(of[0], digits=2), f"{of[1]:.2f} to {of[2]:.2f}"


def _case(runs: xr.Dataset) -> Iterator[Node]:
    """The case that all have, or that of the first run; parameters and seeds vary about it."""
    yield Sentence("The case of the first run; parameters of the study and seeds differ in others.")
    first = {name: str(runs[name].values[0]) for name in ("case", "case_resolved") if name in runs}
    yield from case_nodes(runs.assign_attrs(first))


def _assumed(runs: xr.Dataset) -> Iterator[Node]:
    """Warnings with how many runs have them, then what the runs have in common."""
    lines = Counter(line for text in runs.warnings.values for line in str(text).splitlines())
    if lines:
        of = runs.sizes["run"]
        said = [f"{line} ({n} of {of} runs)" for line, n in lines.most_common()]
        yield Points(_at_most(said), grave=True)
    else:
        yield Sentence("The runs hold no warnings.")
    yield Sentence("What is below is alike in all complete runs.")
    yield assumptions(runs)


def _convergence(runs: xr.Dataset) -> Iterator[Node]:
    yield Sentence(
        "Not assessed by this study: how its figures change with the step of the solver. Intervals"
        " are of the seeds alone. hydrosim converge compares steps and methods for its case."
    )
    if "energy_residual_relative" in runs:
        worst = float(runs.energy_residual_relative.max())
        rows = [("largest residual of an energy ledger", number(worst, digits=2), f"{CLOSED:g}")]
        yield Table(("evidence", "found", "warned of beyond"), rows)


def _at_most(lines: list[str]) -> list[str]:
    more = len(lines) - MOST
    return [*lines[:MOST], f"and {more} more, see the result file"] if more > 0 else lines


PARTS: Parts = {
    "outcome": ("Outcome", _outcome),
    "results": ("What parameters do", _results),
    "case": ("Case", _case),
    "assumptions": ("Assumptions and warnings", _assumed),
    "convergence": ("Convergence", _convergence),
}
"""Sections by name: the heading, and what gives the nodes below it, of many runs."""
