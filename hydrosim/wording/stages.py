"""Stages of groups of contacts: when they come, and what happens when contacts close."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from hydrosim.presentation.document import Cell, Node, Table, Value
from hydrosim.results.stages import FIGURES, TIME


def stage_nodes(run: xr.Dataset) -> Iterator[Node]:
    """Two tables: times of the stages, figures of the contacts. Groups without a stage are left
    out, and a run without groups has no tables."""
    if TIME not in run:
        return
    groups = [run.sel(contact_group=name) for name in run.contact_group.values]
    known = [group for group in groups if np.isfinite(group[TIME].values).any()]
    if known:
        reached = [
            str(stage)
            for stage in run.stage.values
            if any(np.isfinite(group[TIME].sel(stage=stage)) for group in known)
        ]
        yield Table(("group", *reached), [_times(group, reached) for group in known])
        head = ("group", *(what for what, _ in FIGURES.values()))
        yield Table(head, [_figures(group) for group in known])


def _times(group: xr.Dataset, stages: list[str]) -> list[Cell]:
    times = (Value(float(group[TIME].sel(stage=stage)), "s", 6) for stage in stages)
    return [str(group.contact_group.values), *times]


def _figures(group: xr.Dataset) -> list[Cell]:
    figures = (Value(float(group[name]), unit) for name, (_, unit) in FIGURES.items())
    return [str(group.contact_group.values), *figures]
