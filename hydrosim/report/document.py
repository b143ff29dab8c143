"""Reports and replays of results: `report_of` gives the document of a result of any kind."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from hydrosim.errors import InputError
from hydrosim.files.display_units import units_of
from hydrosim.files.document import Document
from hydrosim.files.document_nodes import Nodes, Sentence
from hydrosim.report import run_charts
from hydrosim.report.arrangement import arrangement_nodes
from hydrosim.report.evidence import evidence_nodes
from hydrosim.report.page import records_per_interval
from hydrosim.report.replay import replay_document, replay_nodes, scene_of
from hydrosim.report.sentences import run as run_sentences
from hydrosim.report.sentences import sections, statistics
from hydrosim.results.dataset import RUN_FILE_HINT, ResultKind, kind_of, read_run
from hydrosim.results.runs_file import RUN, open_result, open_runs

# Report of a run: events, figures, series, energy, assumptions, evidence.

REQUIRED_COORDINATES = ("time", "body", "dof")


def run_document(run: xr.Dataset) -> Document:
    """Report of a run, also of one that failed or was interrupted."""
    if missing := [name for name in REQUIRED_COORDINATES if name not in run.coords]:
        source = run.encoding.get("source", "the result")
        raise InputError(f"{source}: has no coordinate {', '.join(missing)}; {RUN_FILE_HINT}.")
    time = run.time.values.astype(float)
    of = ReportData(run)
    nodes = [*sections.title_block(run, of.case), *sections.build_sections(RUN_SECTIONS, of)]
    subtitle, units = _subtitle_text(run), units_of(run.attrs)
    phases, _ = run_charts.shaded_phases(run)
    return Document(sections.title_of(run), nodes, subtitle, units, time, phases)


class ReportData:
    """A ``run`` that is shown, and what several sections need of it: its ``case``, its
    ``statistics``, if it has any, and its ``scene``, if its case can be read again."""

    def __init__(self, run: xr.Dataset) -> None:
        self.run = run
        self.case = sections.case_data(run)
        self.statistics = statistics.statistics_of(run)
        self.scene = scene_of(run)


def _describe_results(of: ReportData) -> Nodes:
    yield from statistics.main_results(of.run, of.case)
    if of.statistics is not None:
        yield from statistics.largest_values(of.statistics)


def _describe_computation(of: ReportData) -> Nodes:
    """Verdicts on the solution, the solver, what was assessed, and what could be run next."""
    yield from run_sentences.solution_verdicts(of.run)
    yield from run_sentences.solver_tables(of.run)
    yield from run_sentences.convergence(of.run)
    yield from statistics.next_steps(of.run, of.case)


def _describe_energy(run: xr.Dataset) -> Nodes:
    yield from run_charts.ledger_nodes(run)
    if run.time.size > 1:
        yield from run_charts.energy_charts(run)


def _subtitle_text(run: xr.Dataset) -> str:
    span = float(np.ptp(run.time.values)) if run.time.size else 0.0
    status = run.attrs.get("status", "unknown")
    return f"{span:g} s simulated by {run.attrs.get('program', 'hydrosim')}; status: {status}"


def _describe_series(run: xr.Dataset) -> Nodes:
    if run.time.size < 2:
        yield Sentence("The run has fewer than two recorded times: there is nothing to draw.")
        return
    charts = run_charts.page_charts(run)
    size = records_per_interval(run.time.size, [*charts, *run_charts.energy_charts(run)])
    step = float(run.time[1] - run.time[0])
    if size > 1:
        yield Sentence(
            f"Lines are envelopes: the smallest and the largest of each {size} records"
            f" ({size * step:g} s). The result file has every record, {step:g} s apart."
        )
    else:
        yield Sentence(f"Lines show every record, {step:g} s apart.")
    yield Sentence(run_charts.CHARTS_NOTE)
    if phases_text := run_charts.shaded_phases(run)[1]:
        yield Sentence("Grey and white: {}.", [phases_text])
    yield from charts


RUN_SECTIONS: sections.Sections[ReportData] = {
    "results": ("Results", _describe_results),
    "arrangement": ("Arrangement", lambda of: arrangement_nodes(of.run, of.scene)),
    "outcome": ("Motions and contacts", lambda of: run_sentences.result_tables(of.run)),
    "case": ("Case", lambda of: sections.case_nodes(of.run, of.case)),
    "assumptions": ("Assumptions and warnings", lambda of: sections.assumption_nodes(of.run)),
    "statistics": ("Statistics", lambda of: statistics.statistics_nodes(of.run, of.statistics)),
    "replay": ("Replay", lambda of: replay_nodes(of.run, of.scene)),
    "series": ("Series", lambda of: _describe_series(of.run)),
    "energy": ("Energy", lambda of: _describe_energy(of.run)),
    "evidence": ("Evidence", lambda of: evidence_nodes(of.run, of.scene)),
    "computation": ("How it was computed", _describe_computation),
}
"""Sections by name: the heading, and the function that gives its nodes."""


REPORTS: dict[str, str] = {
    ResultKind.SET: "study:study_document",
    ResultKind.STUDY: "study:study_document",
    ResultKind.OPERABILITY: "limits:limits_document",
    ResultKind.COMPARISON: "comparison:comparison_document",
    ResultKind.SET_COMPARISON: "comparison:studies_document",
}
"""Reports of results besides runs, by kind: functions of `hydrosim.report.sentences`."""
EXPECTED_RESULTS = "expected the result of `hydrosim run`, `study` or `compare`"


def report_of(path: Path) -> Document:
    """Document that presents the result in the netCDF file ``path``. The result is a run, many
    runs, limits of operation or a comparison. Raises InputError if the file holds none of
    these."""
    result = open_result(path, REPORTS)
    if result is None:
        return run_document(read_run(path, EXPECTED_RESULTS))
    with result:
        return document_of(result)


def document_of(dataset: xr.Dataset, replay: bool = False) -> Document:
    """Document that presents a result in memory, or the replay of a run alone."""
    if replay:
        return replay_document(dataset)
    kind = kind_of(dataset)
    if kind not in REPORTS:
        return run_document(dataset)
    return sections.make_document(REPORTS[kind], dataset)


def replay_of(path: Path) -> Document:
    """Replay of the run in a file. Raises InputError if the file has no run."""
    if (runs := open_runs(path)) is not None:
        raise InputError(
            f"{path}: holds {runs.sizes[RUN]} runs, without their motions over time; expected the"
            " result of `hydrosim run`. `hydrosim report` shows studies."
        )
    return replay_document(read_run(path))
