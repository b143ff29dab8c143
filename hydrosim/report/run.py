"""Report of a run: events, figures, series, energy, assumptions, and evidence."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from hydrosim.errors import InputError
from hydrosim.presentation.document import Document, Node, Sentence
from hydrosim.presentation.units import units_of
from hydrosim.report.arrangement import arrangement_nodes
from hydrosim.report.envelopes import stretch
from hydrosim.report.evidence import evidence_nodes
from hydrosim.report.replay import replay_nodes
from hydrosim.report.scenery import scene_of
from hydrosim.results.netcdf import RUN_FILE_HINT
from hydrosim.wording.assumptions import assumption_nodes, case_nodes
from hydrosim.wording.convergence import convergence
from hydrosim.wording.main_results import largest_values, main_results, next_steps
from hydrosim.wording.run import result_tables, solution_verdicts, solver_tables
from hydrosim.wording.sections import Sections, build_sections, title_of
from hydrosim.wording.series import CHARTS_NOTE, energies, ledger, main_charts, more_charts
from hydrosim.wording.statistics import statistics_nodes, statistics_of
from hydrosim.wording.title_block import title_block

DIMENSIONS = ("time", "body", "dof")


def run_document(run: xr.Dataset) -> Document:
    """Report of a run, also of one that failed or was interrupted."""
    if missing := [name for name in DIMENSIONS if name not in run.coords]:
        raise InputError(f"the result has no coordinate {', '.join(missing)}; {RUN_FILE_HINT}.")
    time = run.time.values.astype(float)
    nodes = [*title_block(run), *build_sections(RUN_SECTIONS, ReportData(run))]
    return Document(title_of(run), nodes, _subtitle(run), units_of(run.attrs), time)


class ReportData:
    """A ``run`` that is shown, and what several sections need of it: its ``statistics``, if it has
    any, and its ``scene``, if its case can be read again."""

    def __init__(self, run: xr.Dataset) -> None:
        self.run = run
        self.statistics = statistics_of(run)
        self.scene = scene_of(run)


def _results(of: ReportData) -> Iterator[Node]:
    yield from main_results(of.run)
    if of.statistics is not None:
        yield from largest_values(of.statistics)


def _computation(run: xr.Dataset) -> Iterator[Node]:
    """Verdicts on the solution, the solver, what was assessed, and what could be run next."""
    yield from solution_verdicts(run)
    yield from solver_tables(run)
    yield from convergence(run)
    yield from next_steps(run)


def _energy(run: xr.Dataset) -> Iterator[Node]:
    yield from ledger(run)
    if run.time.size > 1:
        yield from energies(run)


def _subtitle(run: xr.Dataset) -> str:
    span = float(np.ptp(run.time.values)) if run.time.size else 0.0
    status = run.attrs.get("status", "unknown")
    return f"{span:g} s simulated by {run.attrs.get('program', 'hydrosim')}; status: {status}"


def _series(run: xr.Dataset) -> Iterator[Node]:
    if run.time.size < 2:
        yield Sentence("The run has fewer than two recorded times: there is nothing to draw.")
        return
    charts = [*main_charts(run), *more_charts(run)]
    every = [*charts, *energies(run)]
    size = stretch(run.time.size, sum(len(chart.series) for chart in every if not chart.modes))
    step = float(run.time[1] - run.time[0])
    if size > 1:
        yield Sentence(
            f"Lines are envelopes: the smallest and the largest of each {size} records"
            f" ({size * step:g} s). The result file has every record, {step:g} s apart."
        )
    else:
        yield Sentence(f"Lines show every record, {step:g} s apart.")
    yield Sentence(CHARTS_NOTE)
    yield from charts


RUN_SECTIONS: Sections[ReportData] = {
    "results": ("Results", _results),
    "arrangement": ("Arrangement", lambda of: arrangement_nodes(of.run, of.scene)),
    "outcome": ("Motions and contacts", lambda of: result_tables(of.run)),
    "case": ("Case", lambda of: case_nodes(of.run)),
    "assumptions": ("Assumptions and warnings", lambda of: assumption_nodes(of.run)),
    "statistics": ("Statistics", lambda of: statistics_nodes(of.run, of.statistics)),
    "replay": ("Replay", lambda of: replay_nodes(of.run, of.scene)),
    "series": ("Series", lambda of: _series(of.run)),
    "energy": ("Energy", lambda of: _energy(of.run)),
    "evidence": ("Evidence", lambda of: evidence_nodes(of.run, of.scene)),
    "computation": ("How it was computed", lambda of: _computation(of.run)),
}
"""Sections by name: the heading, and the function that gives its nodes."""
