"""How a run ended, the case that it is of, and what was assumed, left out or warned of."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees
from typing import Any

import xarray as xr
import yaml

from hydrosim.report.blocks import Block, Code, Number, Points, Table, Text, digits_of, number
from hydrosim.results.sentences import scale_of

SOLVER = {
    "solver_method": "method",
    "solver_step": "step [s]",
    "solver_linear": "linear parts",
    "solver_steps": "steps",
    "solver_rejected": "rejected steps",
    "solver_events": "events",
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
SEA = {
    "spectrum": ("spectrum", 1.0, ""),
    "significant_height": ("significant height", 1.0, "m"),
    "peak_period": ("peak period", 1.0, "s"),
    "peak_enhancement": ("peak enhancement", 1.0, ""),
    "amplitude": ("amplitude", 1.0, "m"),
    "period": ("period", 1.0, "s"),
    "heading": ("goes to", degrees(1.0), "deg"),
    "seed": ("seed", 1.0, ""),
}
WATER = {
    "water_depth": ("Water depth", 1.0, "m"),
    "water_density": ("Water density", 1.0, "kg/m^3"),
    "gravity": ("Gravity", 1.0, "m/s^2"),
}
BODY = {
    "mass": (1.0, "kg"),
    "centre_of_gravity": (1.0, "m"),
    "radii_of_gyration": (1.0, "m"),
    "heading": (degrees(1.0), "deg"),
    "dofs": (1.0, ""),
    "hydrodynamics": (1.0, ""),
    "hydrostatics": (1.0, ""),
    "weight": (1.0, ""),
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
    data = _plain(str(run.attrs.get("case_resolved", "")))
    if data:
        yield Table(("environment", ""), list(_environment(data.get("environment"))))
        yield Table(("body", "", ""), list(_bodies(data.get("bodies"))))
        if forces := data.get("forces"):
            yield Table(("force element", "type", "on"), list(_forces(forces)))
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


def _environment(water: Any) -> Iterator[tuple[str, str]]:
    for key, (label, scale, unit) in WATER.items():
        if key in (water or {}):
            yield label, _scaled(water[key], scale, unit)
    for key in ("current", "wind"):
        stream = (water or {}).get(key) or {}
        if stream.get("speed"):
            heading = _scaled(stream.get("heading", 0.0), degrees(1.0), "deg")
            yield key.capitalize(), f"{_scaled(stream['speed'], 1.0, 'm/s')}, goes to {heading}"
    waves = (water or {}).get("waves") or []
    for k, train in enumerate(waves if isinstance(waves, list) else [waves]):
        said = [
            f"{label} {_scaled(train[key], scale, unit)}"
            for key, (label, scale, unit) in SEA.items()
            if key in train
        ]
        yield f"Waves {k + 1}", ", ".join(said)


def _bodies(bodies: Any) -> Iterator[tuple[str, str, str]]:
    for name, body in (bodies or {}).items():
        for key, (scale, unit) in BODY.items():
            if body.get(key) is not None:
                yield str(name), key.replace("_", " "), _scaled(body[key], scale, unit)


def _forces(forces: Any) -> Iterator[tuple[str, str, str]]:
    for name, element in forces.items():
        kind = str(element.get("type", "")).replace("_", " ")
        yield str(name), kind, str(element.get("body", ""))


def _scaled(value: Any, scale: float, unit: str) -> str:
    """A value of a case in a unit that people read."""
    if isinstance(value, bool) or not isinstance(value, int | float | list):
        return str(value)
    if isinstance(value, int) and not unit:
        return str(value)
    each = value if isinstance(value, list) else [value]
    shown = [digits_of(scale * x, 6) if isinstance(x, int | float) else str(x) for x in each]
    return f"{', '.join(shown)} {unit}".strip()


def _shown(value: Any) -> str | Number:
    """An attribute: lines as sentences, numbers as numbers."""
    if isinstance(value, str):
        return "; ".join(value.splitlines())
    try:
        return Number(float(value), digits_of(float(value), 6))
    except (TypeError, ValueError):
        return str(value)


def _plain(text: str) -> dict[str, Any]:
    """A resolved case as it is; empty where it is none."""
    try:
        data = yaml.safe_load(text)
        ok = isinstance(data, dict) and all(
            isinstance(body, dict)
            for key in ("bodies", "forces")
            for body in (data.get(key) or {}).values()
        )
    except (yaml.YAMLError, AttributeError, RecursionError):
        return {}
    return data if ok else {}
