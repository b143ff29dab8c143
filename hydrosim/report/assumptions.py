"""How a run ended, the case that it is of, and what was assumed, left out or warned of."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import xarray as xr

from hydrosim.case.tables import plain, tables
from hydrosim.documents.digits import digits_of
from hydrosim.report.blocks import Block, Code, Number, Points, Table, Text, number
from hydrosim.statistics.sentences import scale_of

SOLVER = {
    "solver_method": "method",
    "solver_step": "step [s]",
    "solver_linear": "linear parts",
    "solver_steps": "steps",
    "solver_rejected": "rejected steps",
    "solver_events": "events",
    "solver_evaluations": "evaluations of the equation of motion",
    "twin_evaluations": "evaluations more, to estimate the error",
    "wall_time": "computing time [s]",
}
SAID = {
    "skipped": "Left out",
    "solver_symmetry": "Symmetry",
    "zero_by_symmetry": "Zero by symmetry",
    "wave_ramp": "Waves grow until [s]",
    "seeds": "Seeds of waves",
    "initial_run": "Starts from the run",
    "initial_time": "at its time [s]",
    "program": "Program",
    "versions": "Versions",
    "case_file": "Case file",
}
OF_BODIES = {
    "radiation": "Radiation of",
    "retardation": "Retardation functions of",
    "waves_meet": "Where waves meet (place, headings) of",
    "database": "Database of",
    "database_checksum": "Checksum of the database of",
}


def outcome(run: xr.Dataset) -> Iterator[Block]:
    """How the run ended, and how it was solved."""
    if run.attrs.get("status", "complete") != "complete":
        message = str(run.attrs.get("status_message", "")) or "no message was kept."
        yield Points([f"The run is {run.attrs['status']}: {message}"], grave=True)
    yield Table(("motion", "smallest", "largest", "at the end"), list(_motions(run)))
    rows = [(label, _shown(run.attrs[key])) for key, label in SOLVER.items() if key in run.attrs]
    if "energy_residual_relative" in run.attrs:
        relative = float(run.attrs["energy_residual_relative"])
        rows.append(("energy residual, of the energy exchanged", number(relative, digits=2)))
    yield Table(("solver", ""), rows)


def _motions(run: xr.Dataset) -> Iterator[tuple[str | Number, ...]]:
    """How far bodies have moved from rest, where they have."""
    for body in map(str, run.body.values):
        for dof in map(str, run.dof.values):
            x = run.position.sel(body=body, dof=dof).values
            factor, unit = scale_of(dof)
            if x.size and x.any():
                ends = (x.min(), x.max(), x[-1])
                yield f"{body} {dof}", *(number(factor * float(end), unit) for end in ends)


def case_blocks(run: xr.Dataset) -> Iterator[Block]:
    """The case in short, as it was written, and with every default."""
    data = plain(str(run.attrs.get("case_resolved", "")))
    yield from (Table(*table) for table in tables(data))
    if text := run.attrs.get("case"):
        yield Code("The case as it was written, with its units and remarks", str(text))
    if text := run.attrs.get("case_resolved"):
        yield Code("The case with every default, in SI and radians", str(text))
    if not (data or run.attrs.get("case")):
        yield Text("The result does not hold its case: it was made from Python or otherwise.")


def assumed(run: xr.Dataset) -> Iterator[Block]:
    """Warnings first, then all that the run says of its assumptions."""
    warnings = str(run.attrs.get("warnings", "")).splitlines()
    if warnings:
        yield Points(warnings, grave=True)
    else:
        yield Text("The run holds no warnings.")
    yield assumptions(run)


def assumptions(run: xr.Dataset) -> Table:
    """All that a run, or runs of which each has the same, says of its assumptions."""
    rows = [(label, _shown(run.attrs[key])) for key, label in SAID.items() if key in run.attrs]
    for start, label in OF_BODIES.items():
        for body in map(str, run.body.values if "body" in run.coords else ()):
            if (key := f"{start}_{body}") in run.attrs:
                rows.append((f"{label} {body}", _shown(run.attrs[key])))
    return Table(("assumption", ""), rows)


def _shown(value: Any) -> str | Number:
    """An attribute: lines as sentences, numbers as numbers."""
    if isinstance(value, str):
        return "; ".join(value.splitlines())
    try:
        return Number(float(value), digits_of(float(value), 6))
    except (TypeError, ValueError):
        return str(value)
