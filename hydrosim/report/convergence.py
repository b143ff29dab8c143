"""What a run itself knows of its errors, and what it does not."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import xarray as xr

from hydrosim.report.blocks import Block, Points, Table, Text, number
from hydrosim.results.ledger import CLOSED


def convergence(run: xr.Dataset) -> Iterator[Block]:
    """The residual of energy, errors of radiation; what was not assessed is said to be so."""
    name = Path(str(run.attrs.get("case_file", "CASE.yaml"))).name
    yield Text(
        "Not assessed by this run: how motions, crawl and extremes change with the step of the"
        f" solver and with the seeds. hydrosim converge {name} compares steps and methods, and"
        " hydrosim sweep compares seeds."
    )
    if "energy_residual_relative" in run.attrs:
        relative = float(run.attrs["energy_residual_relative"])
        rows = [
            ("residual of the energy ledger", number(relative, digits=2), f"at most {CLOSED:g}")
        ]
        yield Table(("evidence", "found", "warned of beyond"), rows)
        yield Text(
            "The residual is relative to the energy exchanged, of the stretch of time that adds up"
            " worst. A small one shows that the integration keeps energy; by itself it does not"
            " show that a finer step gives the same motions."
        )
    if lines := str(run.attrs.get("radiation_errors", "")).splitlines():
        yield Points([f"Radiation: {line}" for line in lines])
