"""What is `explained` as text: a column for each span of time, a row for each figure; of many runs
means, each with half of its 90 % interval."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import xarray as xr

from hydrosim.statistics.effects import spread
from hydrosim.statistics.explain import OTHER, PARTS

AXES = {"surge": "x", "sway": "y", "heave": "z"}
LITTLE = 1e-6  # of the largest: what is less throughout is not shown
KILO = 1e-3
SLIPS = {  # of a point: name, variable, factor
    "mean N in slip [kN]": ("slip_mean_load", KILO),
    "mean direction d": ("slip_mean_direction", 1.0),
    "Cov(N, d) [kN]": ("slip_covariance", KILO),
    "mean N, slip towards + [kN]": ("load_ahead", KILO),
    "mean N, slip towards - [kN]": ("load_astern", KILO),
    "slip towards + [m]": ("slip_ahead", 1.0),
    "slip towards - [m]": ("slip_astern", 1.0),
}
MODES = {
    "share of time": ("mode_share", 1.0),
    "moved [m]": ("mode_moved", 1.0),
    "friction's work [kJ]": ("mode_work", KILO),
}


class Row(NamedTuple):
    """A figure by its name: ``values`` (span,) or (run, span), a factor, and digits to print."""

    name: str
    values: xr.DataArray
    scale: float = 1.0
    digits: int = 2


def explanation(found: xr.Dataset, body: str, direction: str) -> Iterator[str]:
    """Lines: the balance of mean forces on a body in a direction; what friction of each group of
    contacts comes from; how its points slip, and what they do in each mode."""
    yield from _section(f"{body} in {direction}", _balance(found.sel(body=body, dof=direction)))
    if "friction_part" in found:
        for group in dict.fromkeys(found.fender_group.values.ravel()):
            own = found.sel(fender=found.fender_group == group, direction=AXES[direction])
            own = own.sel(span=_of_group(found, str(group)))
            if not own.friction_part.any():
                continue
            yield from _section(f"mean friction of {group} in {direction} [kN]", _friction(own))
            yield from _section(f"mean of its points in {direction}", _points(own))
    yield _closing(found)


def figure(values: xr.DataArray, scale: float = 1.0, digits: int = 2) -> str:
    """A number, or of many ``run`` their mean and half of its interval, see `effects.spread`;
    nothing where there is none."""
    x = scale * np.atleast_1d(values.values)
    x = x[np.isfinite(x)]
    if x.size == 0:
        return ""
    of = spread(x)
    apart = f" ± {of.high - of.mean:.{digits}f}" if "run" in values.dims and x.size > 1 else ""
    return f"{of.mean + 0.0:.{digits}f}{apart}"


def lasting(values: xr.DataArray) -> list[str]:
    """The spans for which there are numbers."""
    known = values.notnull().any([dim for dim in values.dims if dim != "span"])
    return [str(span) for span in known.span.values[known.values]]


def matter(values: xr.DataArray, dim: str, share: float = LITTLE) -> list[str]:
    """The entries of a dimension that are more than a share of the largest, somewhere."""
    largest = abs(values).max([d for d in values.dims if d != dim])
    return [str(name) for name in values[dim].values[largest.values > share * float(largest.max())]]


def _section(title: str, rows: Iterator[Row]) -> Iterator[str]:
    """The rows under a title, in columns as wide as they need."""
    each = list(rows)
    spans = lasting(each[0].values)
    cells = [[title, *spans]]
    for name, values, scale, digits in each:
        cells.append([f"  {name}", *(figure(values.sel(span=s), scale, digits) for s in spans)])
    width = [max(map(len, column)) for column in zip(*cells, strict=True)]
    for first, *others in cells:
        ends = (f"  {x:>{w}}" for x, w in zip(others, width[1:], strict=True))
        yield f"{first:<{width[0]}}{''.join(ends)}".rstrip()
    yield ""


def _of_group(found: xr.Dataset, group: str) -> list[str]:
    """The spans that are not those of other groups."""
    return [s for s in map(str, found.span.values) if ": " not in s or s.startswith(f"{group}: ")]


def _balance(found: xr.Dataset) -> Iterator[Row]:
    """Times, displacements, mean forces by what exerts them."""
    yield Row("duration [s]", found.span_end - found.span_begin, 1.0, 0)
    yield Row("displacement [m]", found.displacement, 1.0, 3)
    for name in matter(found.mean_force, "force"):
        yield Row(f"mean force, {name} [kN]", found.mean_force.sel(force=name), KILO, 1)
    yield Row("change of momentum [kN]", found.momentum_rate, KILO, 1)


def _friction(found: xr.Dataset) -> Iterator[Row]:
    """Mean friction of a group, by what it comes from."""
    part = found.friction_part.sum("fender").where(found.span_end.notnull())
    for name in PARTS:
        if name != OTHER or name in matter(part, "part"):
            yield Row(name, part.sel(part=name), KILO, 1)
    yield Row("sum", part.sum("part", skipna=False), KILO, 1)


def _points(found: xr.Dataset) -> Iterator[Row]:
    """How a point of the group slips, on average, and what it does in each mode."""
    for mode in map(str, found.contact_mode.values):
        of = found.sel(contact_mode=mode)
        for name, (variable, scale) in MODES.items():
            yield Row(f"{mode}: {name}", of[variable].mean("fender"), scale)
    for name, (variable, scale) in SLIPS.items():
        yield Row(name, found[variable].mean("fender"), scale)


def _closing(found: xr.Dataset) -> str:
    """How far works and impulses do not add up, the worst of all bodies, spans and runs."""
    missed = float(np.abs(found.unbalanced.sel(dof=list(AXES))).max())
    done = float(np.abs(found.force_work).sum(["body", "dof", "force"]).max())
    missing = float(np.abs(found.work_missing).max())
    return (
        f"impulses of all forces are the change of momentum but for {missed:.0e} N of mean force;"
        f" works that of kinetic energy but for {KILO * missing:.2g} of {KILO * done:.2g} kJ"
    )
