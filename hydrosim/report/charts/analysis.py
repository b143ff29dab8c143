"""Pictures of analyses: RAOs, mooring lines, loading conditions, decay tests, work and precision.

A picture of RAOs is over frequency, with a line for each heading."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from hydrosim.analysis.ballast import Condition, TankState
from hydrosim.analysis.line import LineResponse, StillLine
from hydrosim.database.hull import immersed_triangles
from hydrosim.elements.roll_decay import DecayFit
from hydrosim.files.display_units import DEFAULT, DisplayUnit, Units, unit_of_dof, units_of
from hydrosim.files.document_layout import digits_of, name_with_unit
from hydrosim.files.outputs import Output, save_picture
from hydrosim.report.charts.panels import COLOURS, DPI, STYLES, new_figure, style_axis, wrap_title
from hydrosim.scene import TankMesh, TankTable

if TYPE_CHECKING:
    import xarray as xr

NEGLIGIBLE_RESPONSE_RATIO = 1e-6  # of the largest motion: it has no phase


def draw_response(response: xr.Dataset, output: Path | Output) -> None:
    """Draw amplitudes and phases of all motions that waves excite, with all bodies together."""
    units = units_of(response.attrs)
    dofs = [str(d) for d in response.dof.values if np.any(response.rao_amplitude.sel(dof=d) > 0.0)]
    rows = max(len(dofs), 1)
    height = 2.2 * rows + 0.8
    figure = Figure((11.0, height), dpi=DPI)
    figure.subplots_adjust(0.07, 0.45 / height, 0.99, 1.0 - 0.7 / height, 0.15, 0.25)
    axes = figure.subplots(rows, 2, squeeze=False, sharex=True)
    for dof, (size, phase) in zip(dofs, axes, strict=False):
        amplitude = units.display_unit(f"{unit_of_dof(dof)}/m")
        for body in response.body.values:
            _draw_motion(response.sel(body=body, dof=dof), amplitude, units, size, phase)
        size.set_ylabel(name_with_unit(dof, amplitude.unit))
        _label_rao(units, size, phase)
    for axis in axes[-1]:
        axis.set_xlabel("frequency [rad/s]")
    if dofs:
        axes[0, 0].legend(frameon=False, fontsize="small")
    figure.suptitle(
        wrap_title(f"{response.title}: response to waves of unit amplitude", figure.get_figwidth())
    )
    save_picture(figure, output)


def _draw_motion(
    at: xr.Dataset, amplitude: DisplayUnit, units: Units, size: Axes, phase: Axes
) -> None:
    """Draw a line of one body for each heading."""
    angle = units.display_unit("rad")
    for heading in at.heading.values:
        rao = at.sel(heading=heading)
        label = f"{at.body.values}, waves to {digits_of(angle.factor * heading)} {angle.unit}"
        size.plot(at.frequency, amplitude.factor * rao.rao_amplitude, label=label, linewidth=1.2)
        moves = rao.rao_amplitude > NEGLIGIBLE_RESPONSE_RATIO * float(at.rao_amplitude.max())
        phase.plot(at.frequency, angle.factor * rao.rao_phase.where(moves), ".", markersize=2.5)


def _label_rao(units: Units, size: Axes, phase: Axes) -> None:
    angle = units.display_unit("rad")
    phase.set_ylabel(name_with_unit("phase", angle.unit))
    phase.set_yticks(angle.factor * np.pi * np.array([-1.0, -0.5, 0.0, 0.5, 1.0]))
    for axis in (size, phase):
        style_axis(axis)


# Mooring line: its profile at several offsets, and its pull over the offset.

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
    figure = new_figure(14.0, 7.6, title)
    for row, response in zip(figure.subplots(2, 3, squeeze=False), responses, strict=True):
        _draw_profiles_at_offsets(row[0], line, response, units)
        _draw_pull(row[1], response, units)
        _draw_stiffness(row[2], response, units)
    save_picture(figure, output)


def _offset_text(response: LineResponse) -> str:
    return "upward" if response.up else "away from the anchor"


def _draw_profiles_at_offsets(
    axis: Axes, line: StillLine, response: LineResponse, units: Units
) -> None:
    length = units.display_unit("m")
    last = response.offsets.size - 1
    for k, i in enumerate(np.linspace(0, last, PROFILES).round().astype(int)):
        offset = float(response.offsets[i])
        moved = (
            line.with_moved_fairlead(0.0, offset)
            if response.up
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
    axis.set_xlabel(name_with_unit("distance from the anchor", length.unit))
    axis.set_ylabel(name_with_unit("height above the anchor", length.unit))
    axis.legend(frameon=False, fontsize="small", title=f"offset {_offset_text(response)}")
    axis.grid(alpha=0.3)


def _draw_pull(axis: Axes, response: LineResponse, units: Units) -> None:
    force = units.display_unit("N")
    series = {
        "tension": response.tension,
        "horizontal pull": response.horizontal,
        "down at the fairlead": response.vertical,
        "anchor tension": response.anchor,
    }
    for k, (name, values) in enumerate(series.items()):
        _plot_response(axis, response, force.factor * values, units, COLOURS[k], name)
    axis.get_lines()[-1].set_linestyle("--")  # on the bed it is the horizontal pull
    axis.set_ylabel(name_with_unit("force", force.unit))
    axis.legend(frameon=False, fontsize="small")


def _draw_stiffness(axis: Axes, response: LineResponse, units: Units) -> None:
    stiffness, length = units.display_unit("N/m"), units.display_unit("m")
    _plot_response(
        axis, response, stiffness.factor * response.stiffness, units, COLOURS[0], "stiffness"
    )
    axis.set_ylabel(name_with_unit("stiffness", stiffness.unit))
    beside = axis.twinx()
    _plot_response(
        beside, response, length.factor * response.grounded, units, COLOURS[1], "grounded length"
    )
    beside.set_ylabel(name_with_unit("grounded length", length.unit))
    beside.grid(visible=False)
    lines = [*axis.get_lines(), *beside.get_lines()]
    names = [str(plotted.get_label()) for plotted in lines]
    axis.legend(lines, names, loc="upper center", frameon=False, fontsize="small")


def _plot_response(
    axis: Axes, response: LineResponse, values: np.ndarray, units: Units, colour: str, name: str
) -> None:
    length = units.display_unit("m")
    axis.plot(length.factor * response.offsets, values, color=colour, linewidth=1.3, label=name)
    axis.set_xlabel(name_with_unit(f"offset {_offset_text(response)}", length.unit))
    axis.grid(alpha=0.3)


# Loading condition: tanks from the side and from above, and their filling.

FLUID, WALL = "#4c8fbd", "#444444"
PALE = "#b7d2e5"  # opacity of the fluid, reduced where triangles overlap
AXES = "xyz"


def draw_loading(
    conditions: Sequence[Condition], time: float, output: Path | Output, units: Units = DEFAULT
) -> None:
    """Draw a row for each body: x and z, x and y, y and z."""
    figure = new_figure(14.0, 3.6 * len(conditions))
    rows = figure.subplots(len(conditions), 3, squeeze=False)
    for condition, row in zip(conditions, rows, strict=True):
        for axis, (i, j) in zip(row, ((0, 2), (0, 1), (1, 2)), strict=True):
            _draw_condition(condition, i, j, axis)
            _label_section(axis, i, j, units.display_unit("m"))
        row[0].set_title(f"{condition.body.name} at {time:g} s")
    rows[0, 0].legend(frameon=False, fontsize="small")
    save_picture(figure, output)


def _draw_condition(condition: Condition, i: int, j: int, axis: Axes) -> None:
    for state in condition.tanks:
        _draw_tank(state, i, j, axis)
    for loading, marker, label in (
        (condition.lightship, "x", "lightship"),
        (condition.loading, "o", "with its tanks"),
    ):
        axis.plot(loading.centre[i], loading.centre[j], marker, color="#c0392b", label=label)


def _label_section(axis: Axes, i: int, j: int, length: DisplayUnit) -> None:
    """Names of the axes, and their numbers in the unit of ``length``; drawn is in m."""
    axis.set_xlabel(name_with_unit(AXES[i], length.unit))
    axis.set_ylabel(name_with_unit(AXES[j], length.unit))
    for axis_ in (axis.xaxis, axis.yaxis):
        axis_.set_major_formatter(lambda x, _: digits_of(length.factor * x))
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
        _label_condition(state, at[i], at[j], j, axis)
        return
    low, high = np.array(shape.low), np.array(shape.high)
    size = high - low
    filled = size[j] * (state.filled if j == 2 else 1.0)
    axis.bar(low[i], filled, size[i], low[j], align="edge", color=FLUID, alpha=0.4)
    axis.bar(low[i], size[j], size[i], low[j], align="edge", fill=False, edgecolor=WALL)
    x, y = (0.5 * (low + high))[[i, j]]
    _label_condition(state, x, y, j, axis)


def _draw_mesh(corners: np.ndarray, state: TankState, i: int, j: int, axis: Axes) -> None:
    surface = np.array([0.0, 0.0, corners[..., 2].min() + state.level])
    fluid = immersed_triangles(corners - surface) + surface
    for triangles, face, edge in ((fluid, PALE, "none"), (corners, "none", WALL)):
        seen = list(triangles[..., [i, j]])
        shown = PolyCollection(seen, facecolor=face, edgecolor=edge, lw=0.3)
        axis.add_collection(shown)
    axis.autoscale_view()
    x, y = 0.5 * (corners.min(axis=(0, 1)) + corners.max(axis=(0, 1)))[[i, j]]
    _label_condition(state, x, y, j, axis)


def _label_condition(state: TankState, x: float, y: float, j: int, axis: Axes) -> None:
    """Write name and filling in the view from above, where tanks do not hide each other."""
    if j == 1:
        text = f"{state.tank.name}\n{100.0 * state.filled:.0f} %"
        axis.annotate(text, (x, y), ha="center", va="center", fontsize=7)


# Fit of decay tests: records, residuals, and damping against amplitude.

CURVE_POINTS = 60
DEGREES = 180.0 / np.pi


def draw_decay(fit: DecayFit, output: Path | Output) -> None:
    """Draw a column for each record, with residuals below, and the damping ratio over amplitude."""
    count = len(fit.decays)
    figure = new_figure(max(10.0, 5.0 * count), 8.0)
    grid = figure.add_gridspec(3, count, height_ratios=(2.0, 1.0, 1.6))
    for k, decay in enumerate(fit.decays):
        above = figure.add_subplot(grid[0, k])
        below = figure.add_subplot(grid[1, k], sharex=above)
        above.plot(decay.time, DEGREES * decay.angle, ".", markersize=2.0, label="record")
        above.plot(decay.time, DEGREES * fit.modelled[k], linewidth=1.0, label="fit")
        above.set_title(decay.called, fontsize="small")
        residual = DEGREES * (decay.angle - fit.modelled[k])
        below.plot(decay.time, residual, linewidth=0.7, color="0.3")
        below.set_xlabel("time [s]")
        above.set_ylabel("roll [deg]")
        below.set_ylabel("residual [deg]")
        above.legend(frameon=False, fontsize="small")
        style_axis(above)
        style_axis(below)
    _draw_damping(fit, figure.add_subplot(grid[2, :]))
    save_picture(figure, output)


def _draw_damping(fit: DecayFit, axis: Axes) -> None:
    """Draw equivalent linear damping, with its 90 % band, up to the largest roll."""
    amplitudes = np.linspace(0.0, fit.size, CURVE_POINTS)
    value, low, high = 100.0 * np.array([fit.terms.damping_ratio(a) for a in amplitudes]).T
    axis.fill_between(DEGREES * amplitudes, low, high, alpha=0.25, label="90 %")
    axis.plot(DEGREES * amplitudes, value, label="p1, p2 and p3")
    axis.set_xlabel("amplitude of roll [deg]")
    axis.set_ylabel("damping ratio [%]")
    axis.set_ylim(bottom=min(0.0, float(low.min())))
    axis.legend(frameon=False, fontsize="small")
    style_axis(axis)


# Convergence study: work and precision.


def draw_work_precision(study: xr.Dataset, output: Path | Output) -> None:
    """Draw the error of the motion against run time and against evaluations, a line per method."""
    length = units_of(study.attrs).display_unit("m")
    figure = new_figure(10.0, 4.5, study.attrs["title"])
    costs = {"wall_time": "run time [s]", "evaluations": "evaluations of the equation of motion"}
    for axes, (cost, label) in zip(figure.subplots(1, 2, sharey=True), costs.items(), strict=True):
        names = dict.fromkeys(study.method.values)
        for method, (colour, dash) in zip(names, STYLES, strict=False):
            of_method = study.isel(trial=study.method.values == method)
            line = {"marker": "o", "color": colour, "linestyle": dash}
            error = length.factor * of_method.motion_error
            axes.loglog(of_method[cost], error, **line, label=str(method))
        least = length.factor * study.attrs["reference_error"]
        axes.axhline(least, color="0.5", linestyle=":", label="reference")
        axes.set_xlabel(label)
        axes.grid(alpha=0.3)
    figure.axes[0].set_ylabel(name_with_unit("largest error of a place", length.unit))
    figure.axes[1].legend()
    save_picture(figure, output)
