"""Stages of groups of contacts: when they come, and what happens when contacts close."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from hydrosim.presentation.document import Cell, Node, Table, Value
from hydrosim.results.stages import FIGURES, STAGE_TIME


def stage_nodes(run: xr.Dataset) -> Iterator[Node]:
    """Times of the stages and figures of the contacts, a column for each group. Groups without a
    stage are left out, and a run without groups has no table."""
    if STAGE_TIME not in run:
        return
    reached = run[STAGE_TIME].notnull().any("stage")
    groups = run.isel(contact_group=np.flatnonzero(reached.values))
    if groups.sizes["contact_group"]:
        head = ("stage or figure", *map(str, groups.contact_group.values))
        yield Table(head, [*_times(groups), *_figures(groups)], "Stages")


def _times(groups: xr.Dataset) -> Iterator[list[Cell]]:
    """The time of each stage that a group has come to."""
    for stage in groups.stage.values:
        times = groups[STAGE_TIME].sel(stage=stage).values
        if np.isfinite(times).any():
            yield [str(stage), *(Value(float(time), "s", 6) for time in times)]


def _figures(groups: xr.Dataset) -> Iterator[list[Cell]]:
    for name, (what, unit) in FIGURES.items():
        yield [what, *(Value(float(figure), unit) for figure in groups[name].values)]
