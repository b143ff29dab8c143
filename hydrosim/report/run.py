"""The report of a run: what happened, figures, series, energy, and on what all of it rests."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import xarray as xr

from hydrosim.errors import InputError
from hydrosim.report.assumptions import assumed, case_blocks, outcome
from hydrosim.report.blocks import Block, Document, Points, Section, Text
from hydrosim.report.convergence import convergence
from hydrosim.report.envelopes import stretch
from hydrosim.report.figures import contact_blocks, statistics_blocks
from hydrosim.report.series import energies, ledger, main_charts, more_charts
from hydrosim.results.output import REMEDY

DIMENSIONS = ("time", "body", "dof")

READING = (
    "Drag over a chart to look closer, double-click to see all; all charts follow. By keyboard:"
    " arrows move the cursor, + and - look closer and wider, 0 shows all. A name in a legend hides"
    " its line."
)


def run_document(run: xr.Dataset) -> Document:
    """The report of a run, also of one that failed or was interrupted."""
    if missing := [name for name in DIMENSIONS if name not in run.coords]:
        raise InputError(f"the result has no coordinate {', '.join(missing)}; {REMEDY}.")
    parts = ((name, title, list(_tried(of, run))) for name, (title, of) in PARTS.items())
    sections = [Section(*part) for part in parts if part[2]]
    return Document(title_of(run), _subtitle(run), sections, run.time.values.astype(float))


def _tried(of: Callable[[xr.Dataset], Iterator[Block]], run: xr.Dataset) -> Iterator[Block]:
    """A part of the report; of a result of another version or origin, what of it can be made."""
    try:
        yield from of(run)
    except (KeyError, ValueError, AttributeError, IndexError) as error:
        found = f"{type(error).__name__}: {error}"
        yield Points(
            [
                f"The rest cannot be made of this result, which lacks or has otherwise what"
                f" this version of hydrosim writes ({found}). Run the case again."
            ],
            grave=True,
        )


def _energy(run: xr.Dataset) -> Iterator[Block]:
    yield from ledger(run)
    if run.time.size > 1:
        yield from energies(run)


def title_of(run: xr.Dataset) -> str:
    """The title of a run, or that it has none."""
    return str(run.attrs.get("title", "")).strip() or "Run without a title"


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
    "series": ("Series", _series),
    "energy": ("Energy", _energy),
    "convergence": ("Convergence", convergence),
}
"""Sections by name: the heading, and what makes it of a run."""
