"""Picture of a loading condition: tanks from the side and from above, and their filling."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from hydrosim.database.hull import immersed_triangles
from hydrosim.documents.digits import digits_of
from hydrosim.outputs import Output, save_picture
from hydrosim.plot.panels import axis_label
from hydrosim.presentation.units import DEFAULT, DisplayUnit, Units
from hydrosim.scene import TankMesh, TankTable
from hydrosim.studies.ballast.loading import Condition, TankState

FLUID, WALL = "#4c8fbd", "#444444"
PALE = "#b7d2e5"  # opacity of the fluid, reduced where triangles overlap
AXES = "xyz"


def draw_loading(
    found: Sequence[Condition], time: float, output: Path | Output, units: Units = DEFAULT
) -> None:
    """Draw a row for each body: x and z, x and y, y and z."""
    figure = Figure(figsize=(14.0, 3.6 * len(found)), layout="constrained")
    rows = figure.subplots(len(found), 3, squeeze=False)
    for condition, row in zip(found, rows, strict=True):
        for axis, (i, j) in zip(row, ((0, 2), (0, 1), (1, 2)), strict=True):
            _draw(condition, i, j, axis)
            _dress(axis, i, j, units.display_unit("m"))
        row[0].set_title(f"{condition.body.name} at {time:g} s")
    rows[0, 0].legend(frameon=False, fontsize="small")
    save_picture(figure, output, dpi=100)


def _draw(found: Condition, i: int, j: int, axis: Axes) -> None:
    for state in found.tanks:
        _draw_tank(state, i, j, axis)
    for loading, marker, label in (
        (found.lightship, "x", "lightship"),
        (found.loading, "o", "with its tanks"),
    ):
        axis.plot(loading.centre[i], loading.centre[j], marker, color="#c0392b", label=label)


def _dress(axis: Axes, i: int, j: int, length: DisplayUnit) -> None:
    """Names of the axes, and their numbers in the unit of ``length``; drawn is in m."""
    axis.set_xlabel(axis_label(AXES[i], length.unit))
    axis.set_ylabel(axis_label(AXES[j], length.unit))
    for each in (axis.xaxis, axis.yaxis):
        each.set_major_formatter(lambda x, _: digits_of(length.factor * x))
    axis.set_aspect("equal", adjustable="datalim")
    axis.grid(alpha=0.3)


def _draw_tank(state: TankState, i: int, j: int, axis: Axes) -> None:
    """Draw a box or a mesh and the fluid in it, seen along an axis; for a table, its centroid."""
    shape = state.tank.shape
    if isinstance(shape, TankMesh):
        _draw_mesh(shape.corners, state, i, j, axis)
        return
    if isinstance(shape, TankTable):
        at = shape.centroid[int(np.searchsorted(shape.level, state.level) % len(shape.level))]
        axis.plot(at[i], at[j], "s", color=FLUID)
        _label(state, at[i], at[j], j, axis)
        return
    low, high = np.array(shape.low), np.array(shape.high)
    size = high - low
    filled = size[j] * (state.filled if j == 2 else 1.0)
    axis.bar(low[i], filled, size[i], low[j], align="edge", color=FLUID, alpha=0.4)
    axis.bar(low[i], size[j], size[i], low[j], align="edge", fill=False, edgecolor=WALL)
    x, y = (0.5 * (low + high))[[i, j]]
    _label(state, x, y, j, axis)


def _draw_mesh(corners: np.ndarray, state: TankState, i: int, j: int, axis: Axes) -> None:
    surface = np.array([0.0, 0.0, corners[..., 2].min() + state.level])
    fluid = immersed_triangles(corners - surface) + surface
    for triangles, face, edge in ((fluid, PALE, "none"), (corners, "none", WALL)):
        seen = list(triangles[..., [i, j]])
        shown = PolyCollection(seen, facecolor=face, edgecolor=edge, lw=0.3)
        axis.add_collection(shown)
    axis.autoscale_view()
    x, y = 0.5 * (corners.min(axis=(0, 1)) + corners.max(axis=(0, 1)))[[i, j]]
    _label(state, x, y, j, axis)


def _label(state: TankState, x: float, y: float, j: int, axis: Axes) -> None:
    """Write name and filling in the view from above, where tanks do not hide each other."""
    if j == 1:
        text = f"{state.tank.name}\n{100.0 * state.filled:.0f} %"
        axis.annotate(text, (x, y), ha="center", va="center", fontsize=7)
