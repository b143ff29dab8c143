"""The report of a run: what happened, figures, series, energy, and on what all of it rests."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import xarray as xr

from hydrosim.errors import InputError
from hydrosim.report.assumptions import assumed, case_blocks, outcome
from hydrosim.report.blocks import Block, Document, Text
from hydrosim.report.convergence import convergence
from hydrosim.report.envelopes import stretch
from hydrosim.report.figures import contact_blocks, statistics_blocks
from hydrosim.report.parts import sections_of, title_of
from hydrosim.report.replay import replay_blocks
from hydrosim.report.series import READING, energies, ledger, main_charts, more_charts
from hydrosim.results.netcdf import REMEDY

DIMENSIONS = ("time", "body", "dof")


def run_document(run: xr.Dataset) -> Document:
    """The report of a run, also of one that failed or was interrupted."""
    if missing := [name for name in DIMENSIONS if name not in run.coords]:
        raise InputError(f"the result has no coordinate {', '.join(missing)}; {REMEDY}.")
    time = run.time.values.astype(float)
    return Document(title_of(run), _subtitle(run), sections_of(PARTS, run), time)


def _energy(run: xr.Dataset) -> Iterator[Block]:
    yield from ledger(run)
    if run.time.size > 1:
        yield from energies(run)


def _subtitle(run: xr.Dataset) -> str:
    span = float(np.ptp(run.time.values)) if run.time.size else 0.0
    status = run.attrs.get("status", "unknown")
    return f"{span:g} s simulated by {run.attrs.get('program', 'hydrosim')}; status: {status}"


def _series(run: xr.Dataset) -> Iterator[Block]:
    if run.time.size < 2:
        yield Text("The run has fewer than two records: there is nothing to draw.")
        return
    charts = [*main_charts(run), *more_charts(run)]
    every = [*charts, *energies(run)]
    size = stretch(run.time.size, sum(len(chart.series) for chart in every if not chart.modes))
    step = float(run.time[1] - run.time[0])
    if size > 1:
        yield Text(
            f"Lines are envelopes: the smallest and the largest of each {size} records"
            f" ({size * step:g} s); the result file holds every record, {step:g} s apart."
        )
    else:
        yield Text(f"Lines show every record, {step:g} s apart.")
    yield Text(READING)
    yield from charts


PARTS: dict[str, tuple[str, Callable[[xr.Dataset], Iterator[Block]]]] = {
    "outcome": ("Outcome", outcome),
    "case": ("Case", case_blocks),
    "assumptions": ("Assumptions and warnings", assumed),
    "stages": ("Stages and contact", contact_blocks),
    "statistics": ("Statistics", statistics_blocks),
    "replay": ("Replay", replay_blocks),
    "series": ("Series", _series),
    "energy": ("Energy", _energy),
    "convergence": ("Convergence", convergence),
}
"""Sections by name: the heading, and what makes it of a run."""
