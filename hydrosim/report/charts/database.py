"""Pictures of a database and of its retardation functions.

The former has one column for the translations and one for the rotations of every body."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import floor, log10
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MultipleLocator

from hydrosim.database import HydroDatabase
from hydrosim.database.checks.finding import diagonal
from hydrosim.database.database import Real
from hydrosim.database.kernels import Kernel
from hydrosim.dofs import DOFS
from hydrosim.files.display_units import DEFAULT, Units
from hydrosim.files.document_layout import name_with_unit
from hydrosim.files.outputs import Output, save_picture
from hydrosim.report.charts.panels import COLOURS, PLAIN_NUMBER_POWERS, new_figure, style_axis

TABLE_PANEL_WIDTH_INCH, TABLE_PANEL_HEIGHT_INCH = 7.0, 2.6  # inches of a panel
HEADINGS = (0.0, 90.0, 180.0)  # deg: the nearest headings of the database are drawn
DASHES = ("-", "--", ":")  # number of those headings
NEGLIGIBLE_LINE_FRACTION = 1e-3  # of a panel's largest value: lines below it are not drawn
MIN_PHASE_AMPLITUDE = 0.1  # of a line's largest value: below it the phase means little
DOF_RANGES = (range(3), range(3, 6))  # translations and rotations
LOG_PANEL_RANGE = 1e4  # of a logarithmic panel

COEFFICIENT_UNITS = Units({"rad": "rad"})
"""Coefficients are read per radian, as in all programs that compute them."""
Lines = dict[str, tuple[np.ndarray, str, str]]
"""Lines by name: values (nw,), colour and dashes."""


class _Column(NamedTuple):
    """Three DOFs of a body."""

    db: HydroDatabase
    body: int
    dofs: range

    @property
    def title(self) -> str:
        kind = "rotations" if self.rotates else "translations"
        return kind if self.db.bodies == 1 else f"body {self.body + 1}, {kind}"

    @property
    def rotates(self) -> bool:
        return self.dofs.start == 3

    def three_dofs(self, array: np.ndarray) -> np.ndarray:
        """Three DOFs (..., 3) of an array (..., n)."""
        return array[..., 6 * self.body + self.dofs.start :][..., :3]

    def unit(self, translation: str, rotation: str) -> str:
        return rotation if self.rotates else translation


def draw_database(db: HydroDatabase, output: Path | Output) -> None:
    """Draw added mass, damping, amplitude and phase of the excitation, and mean drift. The suffix
    of the file name is the format. The file appears under its name when it is complete."""
    columns = [_Column(db, body, dofs) for body in range(db.bodies) for dofs in DOF_RANGES]
    rows = [_added_mass, _draw_damping]
    rows += [_draw_amplitude, _draw_phase] if db.heading.size else []
    rows += [_draw_drift] if db.mean_drift is not None else []
    width, height = TABLE_PANEL_WIDTH_INCH * len(columns), TABLE_PANEL_HEIGHT_INCH * len(rows)
    title = db.attributes.get("title", Path(db.source).name)
    figure = new_figure(width, height + 0.6, title)
    axes = figure.subplots(len(rows), len(columns), squeeze=False, sharex=True)
    for column, of_column in zip(columns, axes.T, strict=True):
        for draw, axis in zip(rows, of_column, strict=True):
            draw(column, axis)
            _finish_axis(axis)
        of_column[0].set_title(column.title)
        of_column[-1].set_xlabel("wave frequency [rad/s]")
    axes[0, 0].set_xlim(0.0, db.frequency[-1])
    save_picture(figure, output)


def _added_mass(column: _Column, axis: Axes) -> None:
    lines = _diagonal_lines(column, column.db.added_mass)
    _plot_lines(column, axis, "added mass", column.unit("kg", "kg m^2"), lines)
    _set_logarithmic(axis, lines)


def _draw_damping(column: _Column, axis: Axes) -> None:
    lines = _diagonal_lines(column, column.db.radiation_damping)
    _plot_lines(column, axis, "radiation damping", column.unit("N s/m", "N m s/rad"), lines)
    _set_logarithmic(axis, lines)


def _draw_amplitude(column: _Column, axis: Axes) -> None:
    loads = _excitation_lines(column).items()
    lines = {name: (np.abs(load), colour, dash) for name, (load, colour, dash) in loads}
    _plot_lines(column, axis, "excitation", column.unit("N/m", "N m/m"), lines)


def _draw_phase(column: _Column, axis: Axes) -> None:
    """Phase lead to the crest; NaN without a load."""
    unit, factor = DEFAULT.display_unit("rad")
    loads = _drop_noise(_excitation_lines(column))
    for name, (load, colour, dash) in loads.items():
        seen = np.abs(load) > MIN_PHASE_AMPLITUDE * np.abs(load).max()
        frequency, phase = _break_phase_jumps(
            column.db.frequency, np.where(seen, np.angle(load), np.nan)
        )
        axis.plot(frequency, factor * phase, dash, color=colour, linewidth=1.2, label=name)
    axis.set_ylabel(name_with_unit("phase of excitation\nlead to crest", unit))
    axis.set_ylim(-1.03 * factor * np.pi, 1.03 * factor * np.pi)
    axis.yaxis.set_major_locator(MultipleLocator(0.5 * factor * np.pi))


def _break_phase_jumps(x: np.ndarray, angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Line with a gap wherever the phase jumps by a full turn."""
    jumps = np.flatnonzero(np.abs(np.diff(angle)) > np.pi) + 1
    return np.insert(x, jumps, np.nan), np.insert(angle, jumps, np.nan)


def _draw_drift(column: _Column, axis: Axes) -> None:
    lines = _lines_by_heading(column, np.asarray(column.db.mean_drift))
    _plot_lines(column, axis, "mean drift", column.unit("N/m^2", "N m/m^2"), lines)


def _diagonal_lines(column: _Column, matrices: np.ndarray) -> Lines:
    values = column.three_dofs(diagonal(matrices))
    return {DOFS[dof]: (values[:, i], COLOURS[i], DASHES[0]) for i, dof in enumerate(column.dofs)}


def _excitation_lines(column: _Column) -> Lines:
    return _lines_by_heading(column, column.db.excitation)


def _lines_by_heading(column: _Column, loads: np.ndarray) -> Lines:
    lines: Lines = {}
    for dash, heading in zip(DASHES, _drawn_headings(column.db), strict=False):
        unit, factor = DEFAULT.display_unit("rad")
        to = f"{factor * column.db.heading[heading]:.0f} {unit}"
        for i, dof in enumerate(column.dofs):
            values = column.three_dofs(loads[:, heading])[:, i]
            lines[f"{DOFS[dof]}, waves to {to}"] = (values, COLOURS[i], dash)
    return lines


def _drawn_headings(db: HydroDatabase) -> Iterator[int]:
    nearest = [int(np.abs(np.degrees(db.heading) - wanted).argmin()) for wanted in HEADINGS]
    yield from dict.fromkeys(nearest)


def _drop_noise(lines: Lines) -> Lines:
    """Lines that are not noise."""
    largest = max(np.abs(values).max() for values, *_ in lines.values())
    return {
        name: line
        for name, line in lines.items()
        if np.abs(line[0]).max() > NEGLIGIBLE_LINE_FRACTION * largest
    }


def _plot_lines(column: _Column, axis: Axes, what: str, unit: str, lines: Lines) -> None:
    lines = _drop_noise(lines)
    unit, factor = COEFFICIENT_UNITS.display_unit(unit)
    largest = max((np.abs(values).max() for values, *_ in lines.values()), default=1.0)
    power = 3 * floor(log10(factor * largest) / 3)
    for name, (values, colour, dash) in lines.items():
        scaled = factor * values / 10.0**power
        axis.plot(column.db.frequency, scaled, dash, color=colour, linewidth=1.2, label=name)
    axis.set_ylabel(f"{what}\n[{_power_of_ten_text(power)}{unit}]")


def _set_logarithmic(axis: Axes, lines: Lines) -> None:
    """Whether a logarithmic axis would hide only noise of every line."""
    largest = max(values.max() for values, *_ in lines.values())
    if (
        largest > 0.0
        and min(values.min() for values, *_ in lines.values()) > -largest / LOG_PANEL_RANGE
    ):
        axis.set_yscale("log", nonpositive="mask")
        axis.set_ylim(bottom=max(axis.get_ylim()[0], axis.get_ylim()[1] / LOG_PANEL_RANGE))


def _power_of_ten_text(power: int) -> str:
    return "" if power == 0 else f"$10^{{{power}}}$ "


def _finish_axis(axis: Axes) -> None:
    style_axis(axis)
    if axis.get_legend_handles_labels()[1]:
        axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.03), frameon=False, fontsize="small")


# Retardation functions: each degree of freedom by itself, and couplings.

PANELS_PER_ROW, KERNEL_PANEL_WIDTH_INCH, KERNEL_PANEL_HEIGHT_INCH = (
    3,
    4.6,
    2.4,
)  # panels in a row; inches of each


def draw_kernels(title: str, time: Real, functions: Sequence[Kernel], output: Output) -> None:
    """A panel for each function."""
    rows = max(-(-len(functions) // PANELS_PER_ROW), 1)
    width, height = KERNEL_PANEL_WIDTH_INCH * PANELS_PER_ROW, KERNEL_PANEL_HEIGHT_INCH * rows
    figure = new_figure(width, height + 0.6, f"{title}: retardation functions")
    axes = figure.subplots(rows, PANELS_PER_ROW, squeeze=False, sharex=True).ravel()
    for function, axis in zip(functions, axes, strict=False):
        unit, factor = COEFFICIENT_UNITS.display_unit(function.unit)
        axis.plot(time, factor * function.values, linewidth=1.0)
        axis.axhline(0.0, color="grey", linewidth=0.5)
        first, second = function.name.split(" ")
        axis.set_title(first if first == second else f"{first} by {second}", fontsize="medium")
        axis.set_ylabel(name_with_unit("K", unit))
        axis.ticklabel_format(axis="y", scilimits=PLAIN_NUMBER_POWERS)
    for axis in axes[len(functions) :]:
        axis.set_axis_off()
    for axis in axes[max(len(functions) - PANELS_PER_ROW, 0) : len(functions)]:
        axis.set_xlabel("time [s]")
        axis.tick_params(labelbottom=True)
    save_picture(figure, output)
