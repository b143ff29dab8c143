"""Picture of one mooring line: its profile at several offsets, and its pull over the offset."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydrosim.documents.digits import digits_of
from hydrosim.outputs import Output, save_picture
from hydrosim.plot.panels import axis_label, wrap_title
from hydrosim.plot.styles import COLOURS
from hydrosim.presentation.units import DEFAULT, Units
from hydrosim.studies.line import LineResponse, StillLine

PROFILES = 5
BED = "#8a7a5c"


def draw_line(
    title: str,
    line: StillLine,
    responses: tuple[LineResponse, LineResponse],
    output: Path | Output,
    units: Units = DEFAULT,
) -> None:
    """Draw a row for each direction of the offset: profiles, tension and pull, stiffness."""
    figure = Figure(figsize=(14.0, 7.6), layout="constrained")
    for row, found in zip(figure.subplots(2, 3, squeeze=False), responses, strict=True):
        _draw_profiles(row[0], line, found, units)
        _draw_pull(row[1], found, units)
        _draw_stiffness(row[2], found, units)
    figure.suptitle(wrap_title(title, figure.get_figwidth()))
    save_picture(figure, output, dpi=100)


def _way(found: LineResponse) -> str:
    return "upward" if found.up else "away from the anchor"


def _draw_profiles(axis: Axes, line: StillLine, found: LineResponse, units: Units) -> None:
    length = units.display_unit("m")
    last = found.offsets.size - 1
    for k, i in enumerate(np.linspace(0, last, PROFILES).round().astype(int)):
        offset = float(found.offsets[i])
        moved = (
            line.with_moved_fairlead(0.0, offset)
            if found.up
            else line.with_moved_fairlead(offset, 0.0)
        )
        if not moved.end_forces().converged:
            continue
        places, _ = moved.profile()
        label = f"{digits_of(length.factor * offset)} {length.unit}"
        axis.plot(*(length.factor * places.T), color=COLOURS[k], linewidth=1.2, label=label)
        axis.plot(*(length.factor * places[0]), "o", color=COLOURS[k], markersize=3.5)
    if np.isfinite(line.bed):
        axis.axhline(length.factor * line.bed, color=BED, linewidth=1.0, zorder=0.5)
    axis.plot(0.0, 0.0, "k^", markersize=5)
    axis.set_xlabel(axis_label("distance from the anchor", length.unit))
    axis.set_ylabel(axis_label("height above the anchor", length.unit))
    axis.legend(frameon=False, fontsize="small", title=f"offset {_way(found)}")
    axis.grid(alpha=0.3)


def _draw_pull(axis: Axes, found: LineResponse, units: Units) -> None:
    force = units.display_unit("N")
    series = {
        "tension": found.tension,
        "horizontal pull": found.horizontal,
        "down at the fairlead": found.vertical,
        "anchor tension": found.anchor,
    }
    for k, (name, values) in enumerate(series.items()):
        _plot(axis, found, force.factor * values, units, COLOURS[k], name)
    axis.get_lines()[-1].set_linestyle("--")  # on the bed it is the horizontal pull
    axis.set_ylabel(axis_label("force", force.unit))
    axis.legend(frameon=False, fontsize="small")


def _draw_stiffness(axis: Axes, found: LineResponse, units: Units) -> None:
    stiffness, length = units.display_unit("N/m"), units.display_unit("m")
    _plot(axis, found, stiffness.factor * found.stiffness, units, COLOURS[0], "stiffness")
    axis.set_ylabel(axis_label("stiffness", stiffness.unit))
    beside = axis.twinx()
    _plot(beside, found, length.factor * found.grounded, units, COLOURS[1], "grounded length")
    beside.set_ylabel(axis_label("grounded length", length.unit))
    beside.grid(visible=False)
    lines = [*axis.get_lines(), *beside.get_lines()]
    names = [str(each.get_label()) for each in lines]
    axis.legend(lines, names, loc="upper center", frameon=False, fontsize="small")


def _plot(
    axis: Axes, found: LineResponse, values: np.ndarray, units: Units, colour: str, name: str
) -> None:
    length = units.display_unit("m")
    axis.plot(length.factor * found.offsets, values, color=colour, linewidth=1.3, label=name)
    axis.set_xlabel(axis_label(f"offset {_way(found)}", length.unit))
    axis.grid(alpha=0.3)
