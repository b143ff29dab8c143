"""Why a body moved: the balance of mean forces, what friction comes from, how contacts slip."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.files import document_nodes
from hydrosim.files.display_units import units_of
from hydrosim.files.document import Document
from hydrosim.report.sentences.sections import title_of
from hydrosim.results import phases
from hydrosim.statistics import explain
from hydrosim.statistics.effects import seed_spread

if TYPE_CHECKING:
    import xarray as xr

# Why a body moved: figures by span of time; of many runs means with 90 % intervals.

SLIP_ROWS = {
    "mean N in slip": ("slip_mean_load", "N"),
    "mean direction d": ("slip_mean_direction", ""),
    "Cov(N, d)": ("slip_covariance", "N"),
    "mean N, slip towards +": ("load_ahead", "N"),
    "mean N, slip towards -": ("load_astern", "N"),
    "slip towards +": ("slip_ahead", "m"),
    "slip towards -": ("slip_astern", "m"),
}
"""What is said of the slip of a point: the variable and its SI unit."""
CONTACT_MODE_ROWS = {
    "share of time": ("mode_share", "share"),
    "moved": ("mode_moved", "m"),
    "work of friction": ("mode_work", "J"),
}


class ExplainedFigure(NamedTuple):
    """A figure by its name: ``values`` (span,) or (run, span) in an SI ``unit``."""

    name: str
    values: xr.DataArray
    unit: str = ""


def explanation_document(
    run: xr.Dataset, parts: Mapping[str, xr.Dataset], body: str, direction: str
) -> Document:
    """The explanation of a run, or of each combination of parameters of many runs by its name."""
    nodes: list[document_nodes.Node] = []
    for title, explanations in parts.items():
        nodes += [document_nodes.Heading(title)] if title else []
        nodes += explanation(explanations, body, direction)
    return Document(title_of(run), nodes, units=units_of(run.attrs))


def explanation(explanations: xr.Dataset, body: str, direction: str) -> document_nodes.Nodes:
    """The balance of mean forces on a body in a direction; what the friction of each group of
    contacts comes from; how its points slip, and what they do in each mode."""
    explanations = explanations.sel(span=reported_spans(explanations))
    yield _table(
        f"{body} in {direction}", _balance_figures(explanations.sel(body=body, dof=direction))
    )
    if "friction_part" in explanations:
        for group in dict.fromkeys(explanations.fender_group.values.ravel()):
            group_explanations = explanations.sel(
                fender=explanations.fender_group == group,
                direction=explain.DIRECTION_AXES[direction],
            )
            group_explanations = group_explanations.sel(
                span=_spans_of_group(explanations, str(group))
            )
            if group_explanations.friction_part.fillna(0.0).any():
                yield _table(
                    f"mean friction of {group} in {direction}",
                    _friction_figures(group_explanations),
                )
                yield _table(
                    f"mean of the points of {group} in {direction}",
                    _point_figures(group_explanations),
                )
    yield _closing_sentence(explanations)


def _table(title: str, rows: Iterator[ExplainedFigure]) -> document_nodes.Table:
    figures = list(rows)
    spans = explain.stages_with_values(figures[0].values)
    table = [
        [row.name, *(mean_cell(row.values.sel(span=s), row.unit) for s in spans)] for row in figures
    ]
    return document_nodes.Table((title, *spans), table)


def mean_cell(values: xr.DataArray, unit: str) -> document_nodes.Cell:
    """A number, or of many ``run`` their mean and its interval; nothing where there is none."""
    x = np.atleast_1d(values.values)
    x = x[np.isfinite(x)]
    if x.size == 0:
        return ""
    of = seed_spread(x)
    if "run" in values.dims and x.size > 1:
        return document_nodes.Sentence(
            "{} ({})",
            [document_nodes.Value(of.mean, unit), document_nodes.Between(of.low, of.high, unit)],
        )
    return document_nodes.Value(of.mean + 0.0, unit)


def _spans_of_group(explanations: xr.Dataset, group: str) -> list[str]:
    """The spans that are not those of other groups."""
    return [
        s for s in map(str, explanations.span.values) if ": " not in s or s.startswith(f"{group}: ")
    ]


def reported_spans(explanations: xr.Dataset) -> list[str]:
    """All spans but the phases of groups of contacts that go through no operation."""
    there = {
        str(s)
        for s in explanations.span.values
        if explanations.span_end.sel(span=s).notnull().any()
    }
    names = [str(s) for s in explanations.span.values]
    return [
        s
        for s in names
        if _phase_number(s) is None or phases.is_operation(_phases_beside(s, there))
    ]


def _phase_number(span: str) -> int | None:
    """The phase that a span is; none if it is no phase."""
    name = span.rpartition(": ")[2]
    return explain.EXPLAINED_PHASES.index(name) if name in explain.EXPLAINED_PHASES else None


def _phases_beside(span: str, there: set[str]) -> Iterator[int]:
    """The phases of the same group of contacts, among the spans that are ``there``."""
    prefix = span.removesuffix(span.rpartition(": ")[2])
    yield from (
        k for k, phase in enumerate(explain.EXPLAINED_PHASES) if f"{prefix}{phase}" in there
    )


def _balance_figures(explanations: xr.Dataset) -> Iterator[ExplainedFigure]:
    """Times, displacements, mean forces by what exerts them."""
    yield ExplainedFigure("duration", explanations.span_end - explanations.span_begin, "s")
    yield ExplainedFigure("displacement", explanations.displacement, "m")
    for name in explain.significant_entries(explanations.mean_force, "force"):
        yield ExplainedFigure(
            f"mean force, {name.replace('_', ' ')}", explanations.mean_force.sel(force=name), "N"
        )
    yield ExplainedFigure("change of momentum", explanations.momentum_rate, "N")


def _friction_figures(explanations: xr.Dataset) -> Iterator[ExplainedFigure]:
    """Mean friction of a group, by what it comes from."""
    part = explanations.friction_part.sum("fender").where(explanations.span_end.notnull())
    for name in explain.FRICTION_PARTS:
        if name != explain.OTHER or name in explain.significant_entries(part, "part"):
            yield ExplainedFigure(name, part.sel(part=name), "N")
    yield ExplainedFigure("sum", part.sum("part", skipna=False), "N")


def _point_figures(explanations: xr.Dataset) -> Iterator[ExplainedFigure]:
    """How a point of the group slips, on average, and what it does in each mode."""
    for mode in map(str, explanations.contact_mode.values):
        of = explanations.sel(contact_mode=mode)
        for name, (variable, unit) in CONTACT_MODE_ROWS.items():
            yield ExplainedFigure(f"{mode}: {name}", of[variable].mean("fender"), unit)
    for name, (variable, unit) in SLIP_ROWS.items():
        yield ExplainedFigure(name, explanations[variable].mean("fender"), unit)


def _closing_sentence(explanations: xr.Dataset) -> document_nodes.Sentence:
    """How far works and impulses do not add up, the worst of all bodies, spans and runs."""
    missed = float(np.abs(explanations.unbalanced.sel(dof=list(explain.DIRECTION_AXES))).max())
    done = float(np.abs(explanations.force_work).sum(["body", "dof", "force"]).max())
    missing = float(np.abs(explanations.work_missing).max())
    return document_nodes.Sentence(
        "Impulses of all forces add up to the change of momentum, but for a mean force of {}. Works"
        " add up to the change of kinetic energy, but for {} of {}.",
        [
            document_nodes.Value(missed, "N", 1),
            document_nodes.Value(missing, "J", 2),
            document_nodes.Value(done, "J", 2),
        ],
        detail=True,
    )
