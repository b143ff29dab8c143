"""A linear analysis: place at rest, motions in the sea, natural modes, RAOs."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees, isfinite, pi

import xarray as xr

from hydrosim.dofs import DOFS
from hydrosim.presentation.document import (
    Cell,
    Document,
    Node,
    Outcome,
    Sentence,
    Table,
    Value,
    Verdict,
)
from hydrosim.presentation.units import unit_of_dof, units_of
from hydrosim.wording.sections import lines_of, title_of

MAX_SHARES = 3
"""Coordinates that a mode is described by."""
MIN_SHARE = 0.05
"""Of the energy of a mode: coordinates with less are left out."""
ROUNDING_BELOW = 1e-10
RESPONSE_COLUMNS = {
    "at rest": "position_at_rest",
    "mean drift": "mean_drift_offset",
    "std in sea": "response_std",
    "std in gusts": "gust_std",
    "maximum in sea": "response_maximum",
    "Tz": "response_period",
}


def linear_document(found: xr.Dataset, raos: bool = False) -> Document:
    """Motions, natural modes and, if so asked, ``raos`` over the period."""
    nodes = [*_remarks(found), _motions(found), _modes(found)]
    nodes += [*_rao_tables(found), *_joint_rao_tables(found)] if raos else []
    return Document(title_of(found), nodes, units=units_of(found.attrs))


def _remarks(found: xr.Dataset) -> Iterator[Node]:
    return (Verdict(Outcome.WARNING, line) for line in lines_of(found, "remarks"))


def _motions(found: xr.Dataset) -> Table:
    columns = {name: variable for name, variable in RESPONSE_COLUMNS.items() if variable in found}
    waves = range(found.sizes.get("wave", 0))
    rows: list[list[Cell]] = []
    for body in map(str, found.body.values):
        for dof in map(str, found.dof.values):
            at = found.sel(body=body, dof=dof)
            figures = [_figure(at, variable, dof) for variable in columns.values()]
            harmonics = [_harmonic(at.isel(wave=k), "regular", unit_of_dof(dof)) for k in waves]
            rows.append([f"{body} {dof}", *figures, *harmonics])
    return Table(("motion", *columns, *(_wave(found, k) for k in waves)), rows, "Motions")


def _wave(found: xr.Dataset, k: int) -> str:
    at = found.isel(wave=k)
    where = f"wave of {float(at.wave_period):g} s to {degrees(float(at.wave_heading)):g} deg"
    return f"{where}: amplitude, phase"


def _figure(at: xr.Dataset, variable: str, dof: str) -> Value:
    number = float(at[variable])
    if variable == "response_period":
        return Value(number, "s")
    return Value(0.0 if abs(number) <= ROUNDING_BELOW else number, unit_of_dof(dof))


def _modes(found: xr.Dataset) -> Table:
    head = ("mode", "natural period", "damped period", "damping ratio", "moves")
    each = {str(mode): found.sel(mode=mode) for mode in found.mode.values}
    rows = [[mode, *_decay(at), _moves(at)] for mode, at in each.items()]
    return Table(head, rows, "Natural modes")


def _decay(at: xr.Dataset) -> list[Cell]:
    """Periods and damping of a mode, or what it is instead."""
    kind = str(at.mode_kind.values)
    if kind == "free":
        return ["free", "", ""]
    natural = float(at.natural_period)
    period: Cell = Value(natural, "s") if isfinite(natural) else "none"
    if kind != "oscillating":
        return [period, kind, ""]
    return [period, Value(float(at.damped_period), "s"), Value(float(at.damping_ratio), "", 3)]


def _moves(at: xr.Dataset) -> str:
    """The coordinates that have most of the energy of a mode."""
    share = at.mode_share.stack(coordinate=("body", "dof"))
    largest = share.sortby(share, ascending=False)[:MAX_SHARES]
    several = at.body.size > 1
    parts = [
        (float(value), f"{f'{body} ' if several else ''}{dof}")
        for (body, dof), value in zip(largest.coordinate.values, largest.values, strict=True)
    ]
    if "joint_mode_share" in at:
        joints = zip(at.joint_mode_share.values, at.joint_motion.values, strict=True)
        parts += [(float(value), str(name)) for value, name in joints]
    parts = sorted(parts, key=lambda part: -part[0])[:MAX_SHARES]
    return ", ".join(f"{name} {value:.0%}" for value, name in parts if value >= MIN_SHARE)


def _rao_tables(found: xr.Dataset) -> Iterator[Node]:
    """RAOs over the period, a table for each body and heading; motions that no wave excites are
    left out."""
    for body in map(str, found.body.values):
        for heading in found.heading.values:
            at = found.sel(body=body, heading=heading)
            moving = [
                d for d in DOFS if d in at.dof and float(at.rao_amplitude.sel(dof=d).max()) > 0.0
            ]
            rows = [_rao(at.sel(frequency=omega), moving) for omega in at.frequency.values[::-1]]
            title = f"RAOs of {body}, waves to {degrees(float(heading)):g} deg: amplitude, phase"
            yield Table(("period", *moving), rows, title)


def _joint_rao_tables(found: xr.Dataset) -> Iterator[Node]:
    """RAOs of the motions of joints over the period, a table for each heading."""
    for heading in found.heading.values if "joint_motion" in found.dims else ():
        at = found.sel(heading=heading)
        names = list(map(str, at.joint_motion.values))
        rows = [
            [
                Value(2.0 * pi / float(omega), "s"),
                *(
                    _harmonic(at.sel(frequency=omega, joint_motion=name), "joint_rao", _unit(name))
                    for name in names
                ),
            ]
            for omega in at.frequency.values[::-1]
        ]
        title = f"RAOs in joints, waves to {degrees(float(heading)):g} deg: amplitude, phase"
        yield Table(("period", *names), rows, title)


def _unit(joint_motion: str) -> str:
    """Unit of the RAO of a motion of a joint."""
    return "m/m" if joint_motion.endswith("offset") else "rad/m"


def _rao(at: xr.Dataset, moving: list[str]) -> list[Cell]:
    of = [_harmonic(at.sel(dof=dof), "rao", f"{unit_of_dof(dof)}/m") for dof in moving]
    return [Value(2.0 * pi / float(at.frequency), "s"), *of]


def _harmonic(at: xr.Dataset, name: str, unit: str) -> Cell:
    """Amplitude and phase lead; no phase of what does not move."""
    size = float(at[f"{name}_amplitude"])
    phase = Value(float(at[f"{name}_phase"]), "rad", 3)
    return Sentence("{}, {}", [Value(size, unit), phase]) if size else "0"
