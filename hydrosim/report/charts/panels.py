"""Pictures over time: styles of lines, panels of lines or bands of modes, and their layout.

A series with many more records than a panel can show is drawn as a band from the smallest to the
largest value of each interval, with its mean. A series with slightly more is a line through these
values.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import cycle
from math import ceil, inf
from textwrap import fill
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.transforms import ScaledTranslation

from hydrosim.files.display_units import DEFAULT, Units
from hydrosim.files.document_layout import name_with_unit
from hydrosim.files.document_nodes import Chart, ChartLine, ShadedPhase
from hydrosim.results.channels import MIN_SHARE_OF_AXIS, interval_envelope, interval_means

# Styles of lines: the same in all pictures, and distinct without colours.

# Okabe & Ito (2008): colours that the colour-blind can distinguish. The first three are also
# distinct in grey. Later lines are dashed, and dotted in the next round.
COLOURS = ("#0072B2", "#E69F00", "#000000", "#009E73", "#D55E00", "#56B4E9", "#CC79A7")
SOLID = 3
MODES = {2: ("slip", "#E69F00"), 1: ("stick", "#0072B2"), 0: ("open", "#DDDDDD")}  # bottom to top
SHADE = "#EDEDED"  # of every other phase


class Style(NamedTuple):
    """Style of a line."""

    colour: str
    dash: str


STYLES = [
    *(Style(colour, "-") for colour in COLOURS[:SOLID]),
    *(Style(colour, "--") for colour in COLOURS[SOLID:]),
    *(Style(colour, ":") for colour in COLOURS),
    *(Style(colour, "-.") for colour in COLOURS),
]


def styles(names: Iterable[str]) -> dict[str, Style]:
    """Style of each of many names, by their order."""
    return dict(zip(names, cycle(STYLES), strict=False))


PANEL_HEIGHT_INCH = 1.6  # inches of a panel
BAND_HEIGHT_INCH = 0.35  # inches of a band
MAX_LEGEND_LETTERS = 24  # letters of a line of the legend
MAX_LEGEND_ENTRIES = 8  # entries of a column of the legend
LETTERS_PER_INCH = 11.0  # of a title
MAX_LABEL_LETTERS = 20  # letters of a line beside an axis
BINS = 800  # of a line: about the number of pixels of a panel
DENSE = 10  # records in a bin from which on a band is drawn
BAND_COLUMNS = 200  # of bands of modes
MAX_LINES_PER_PANEL = 4  # lines in one panel that may hide each other
EQUAL_LINE_RTOL = 1e-6  # of the largest value: lines that differ less are drawn once
PLAIN_NUMBER_POWERS = (-3, 6)  # powers of ten between which numbers beside an axis are written out


class TimeWindow(NamedTuple):
    """Time interval of a picture [s]."""

    start: float = -inf
    end: float = inf

    def record_slice(self, time: np.ndarray) -> slice:
        """Indices of the records in the interval."""
        return slice(
            int(np.searchsorted(time, self.start)), int(np.searchsorted(time, self.end, "right"))
        )


def wrap_title(title: str, width: float) -> str:
    """Title in lines that fit a picture of this ``width`` [inch]."""
    return "\n".join(fill(line, int(LETTERS_PER_INCH * width)) for line in title.splitlines())


def coarse(time: np.ndarray, window: TimeWindow) -> float:
    """Length [s] of the intervals whose smallest and largest values are drawn as bands; zero if
    lines are drawn."""
    inside = time[window.record_slice(time)]
    size = _size(inside.size)
    return size * float(inside[1] - inside[0]) if size > DENSE else 0.0


def thin_records(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Smallest and largest value of each of `BINS` bins, in their order in time. A line through
    them looks like the line through all values."""
    size = _size(time.size)
    if size <= 2:
        return time, values
    bins = np.pad(values, (0, -time.size % size), mode="edge").reshape(-1, size)
    extremes = np.array([bins.argmin(axis=1), bins.argmax(axis=1)])
    at = np.minimum(extremes + size * np.arange(len(bins)), time.size - 1)
    at = np.unique(np.append(at, [0, time.size - 1]))
    return time[at], values[at]


def merge_equal_lines(lines: Mapping[str, ChartLine]) -> list[tuple[list[str], ChartLine]]:
    """Lines, with equal ones merged under all their names."""
    least = EQUAL_LINE_RTOL * max((line.peak for line in lines.values()), default=0.0)
    groups: list[tuple[list[str], ChartLine]] = []
    for name, line in lines.items():
        for names, first in groups:
            near = line.y.shape == first.y.shape
            if near and np.allclose(line.y, first.y, rtol=0.0, atol=least, equal_nan=True):
                names.append(name)
                break
        else:
            groups.append(([name], line))
    return groups


def group_lines(chart: Chart, most: int) -> Chart:
    """The chart; with a band for each group, if it has groups and more lines than the ``most``. A
    group without a name is of lines."""
    members: dict[str, list[np.ndarray]] = {}
    for name, line in chart.lines.items():
        if name in chart.groups:
            members.setdefault(chart.groups[name], []).append(line.y)
    if not members or len(merge_equal_lines(chart.lines)) <= most:
        return chart
    lines = {
        f"{group}, {len(values)} contacts" if group else f"{len(values)} lines": ChartLine(
            np.array(values)
        )
        for group, values in members.items()
    }
    return replace(chart, lines=lines, order=())


def _joined_names(names: list[str]) -> str:
    """ "barge 1, barge 2" or "barge 1 and 2 more"."""
    return ", ".join(names) if len(names) < 3 else f"{names[0]} and {len(names) - 1} more"


def _size(count: int) -> int:
    return ceil(count / BINS)


def draw_chart(axis: Axes, chart: Chart, frame: PictureFrame) -> None:
    """Draw a chart in a panel. Equal lines are drawn once, with all their names. The subject of a
    line without a name stands in the panel."""
    inside = frame.window.record_slice(frame.time)
    if chart.modes:
        _plot_bands(axis, frame.time[inside], {n: x.y[inside] for n, x in chart.lines.items()})
        return
    shown = frame.units.display_unit(chart.unit)
    style_of = styles(chart.order)
    most = MAX_LINES_PER_PANEL if any(chart.groups.values()) else len(COLOURS)
    merged = merge_equal_lines(group_lines(chart, most).lines)
    for k, (names, line) in enumerate(merged):
        style = style_of.get(names[0], STYLES[k % len(STYLES)])
        values = shown.factor * line.y[..., inside]
        _plot_line(axis, frame.time[inside], values, _joined_names(names), style)
    is_named = any(chart.lines)
    subject = f"{chart.subject}\n" if is_named and chart.subject else ""
    label = subject + name_with_unit(chart.quantity, shown.unit)
    axis.set_ylabel(label if len(label) < MAX_LABEL_LETTERS else fill(label, MAX_LABEL_LETTERS))
    axis.ticklabel_format(axis="y", scilimits=PLAIN_NUMBER_POWERS)
    if is_named:
        _add_legend(axis)
    elif chart.subject:
        axis.margins(y=0.25)  # room for the subject
        paper = {"facecolor": "white", "alpha": 0.7, "edgecolor": "none", "pad": 1.0}
        look: dict[str, Any] = {"ha": "left", "va": "top", "fontsize": "small", "bbox": paper}
        axis.text(0.01, 0.97, chart.subject, transform=axis.transAxes, **look)


def _plot_line(axis: Axes, time: np.ndarray, values: np.ndarray, name: str, style: Style) -> None:
    """Draw a line, or a band with its mean if there are more records than a line can show."""
    look: dict[str, Any] = {
        "color": style.colour,
        "linestyle": style.dash,
        "linewidth": 0.9,
        "label": fill(name, MAX_LEGEND_LETTERS),
    }
    size = _size(time.size)
    if values.ndim == 1 and size <= DENSE:
        axis.plot(*thin_records(time, values), **look)
        return
    curves = np.atleast_2d(values)
    low = interval_envelope(np.fmin.reduce(curves), size)[0]
    high = interval_envelope(np.fmax.reduce(curves), size)[-1]
    mean = interval_means(
        np.array([interval_means(curve, size) for curve in curves]).T.ravel(), len(curves)
    )
    at = time[::size]
    axis.fill_between(at, low, high, color=style.colour, alpha=0.35, linewidth=0.0)
    axis.plot(at, mean, **look)


def _plot_bands(axis: Axes, time: np.ndarray, modes: Mapping[str, np.ndarray]) -> None:
    """Draw a band for each contact, whose height is divided like the time in each mode."""
    edges = np.unique(np.linspace(0, time.size - 1, BAND_COLUMNS + 1).astype(int))
    for row, values in enumerate(modes.values()):
        base = np.full(edges.size - 1, -0.4 - row)
        for mode, (name, colour) in MODES.items():
            there = (values[:-1] == mode).astype(float)
            top = base + 0.8 * np.add.reduceat(there, edges[:-1]) / np.diff(edges)
            band = axis.stairs(top, time[edges], baseline=base, fill=True, color=colour)
            band.set_label(name if row == 0 else "")
            base = top
    axis.set_yticks(-np.arange(len(modes)), labels=list(modes))
    axis.set_ylim(0.5 - len(modes), 0.5)
    _add_legend(axis, "fraction of time in")


def _add_legend(axis: Axes, title: str = "") -> None:
    """Draw the legend beside the panel, where it hides nothing."""
    columns = -(-len(axis.get_legend_handles_labels()[1]) // MAX_LEGEND_ENTRIES)
    legend = axis.legend(
        loc="upper left",
        bbox_to_anchor=(1.0, 1.05),
        ncols=columns,
        frameon=False,
        fontsize="small",
        title=title,
        title_fontsize="small",
    )
    for line in legend.get_lines():
        line.set_linewidth(2.0)


# Layout of a picture: title and remarks, one time axis, shaded phases.

PICTURE_WIDTH_INCH, DPI = 10.0, 100  # inches of a picture; dots per inch
LABEL = 0.65  # inches from an axis to its label
LETTER = 0.008  # of the picture: approximate width of a letter in the name of a phase


def new_figure(width: float, height: float, title: str = "") -> Figure:
    """An empty picture of a size [inch], with its title in lines that fit."""
    figure = Figure((width, height), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    if title:
        figure.suptitle(wrap_title(title, width))
    return figure


def style_axis(axis: Axes) -> None:
    """Give an axis its grid, and no frame above and on the right."""
    axis.grid(alpha=0.3)
    axis.set_axisbelow(True)
    axis.spines[["top", "right"]].set_visible(False)


class PictureFrame(NamedTuple):
    """Common properties of the panels of a picture: time (nt,) [s] and units, title, remarks under
    it, time interval, shaded phases, and number of columns."""

    time: np.ndarray
    units: Units = DEFAULT
    title: str = ""
    remarks: Sequence[str] = ()
    window: TimeWindow = TimeWindow()
    phases: Sequence[ShadedPhase] = ()
    columns: int = 1


def picture(charts: Sequence[Chart], frame: PictureFrame) -> Figure:
    """Draw charts below each other, or row by row, over one time axis."""
    rows = -(-len(charts) // frame.columns)
    heights = [_panel_height(chart) for chart in charts[:: frame.columns]]
    figure = new_figure(PICTURE_WIDTH_INCH, sum(heights) + 0.8, frame.title)
    ratios = {"height_ratios": heights}
    grid = figure.subplots(rows, frame.columns, sharex=True, squeeze=False, gridspec_kw=ratios)
    axes = list(grid.ravel()[: len(charts)])
    for spare in grid.ravel()[len(charts) :]:
        spare.remove()
    for axis, chart in zip(axes, charts, strict=True):
        draw_chart(axis, chart, frame)
        _lay_out_axis(axis, frame)
    _share_value_ranges(axes)
    _name_phases(grid[0], frame.phases)
    above = 15.0 if frame.phases else 6.0  # points, for the names of phases
    for axis in grid[-1]:
        axis.set_xlabel("time [s]")
    grid[0, 0].set_title(
        "\n".join(wrap_title(remark, PICTURE_WIDTH_INCH) for remark in frame.remarks),
        loc="left",
        fontsize="small",
        color="0.3",
        pad=above,
    )
    return figure


def _panel_height(chart: Chart) -> float:
    """Height of a panel [inch]."""
    bands = BAND_HEIGHT_INCH * len(chart.lines) if chart.modes else 0.0
    return max(PANEL_HEIGHT_INCH, bands)


def _lay_out_axis(axis: Axes, frame: PictureFrame) -> None:
    axis.margins(x=0.0)
    style_axis(axis)
    aside = ScaledTranslation(-LABEL, 0.0, axis.figure.dpi_scale_trans)
    axis.yaxis.set_label_coords(0.0, 0.5, axis.transAxes + aside)
    first, last = axis.get_xlim()
    for phase in frame.phases[1::2]:
        start, end = max(phase.start, first), min(phase.end, last)
        if start < end:
            axis.axvspan(start, end, color=SHADE, linewidth=0.0, zorder=0.0)
    axis.set_xlim(first, last)


def _name_phases(top: Sequence[Axes], phases: Sequence[ShadedPhase]) -> None:
    """Write the names of phases above the first row, if there is room."""
    for axis in top:
        first, last = axis.get_xlim()
        for phase in phases:
            start, end = max(phase.start, first), min(phase.end, last)
            if end - start > LETTER * len(top) * len(phase.name) * (last - first):
                middle = (0.5 * (start + end), 1.0)
                look: dict[str, Any] = {
                    "fontsize": "x-small",
                    "color": "0.3",
                    "ha": "center",
                    "va": "bottom",
                }
                axis.annotate(
                    phase.name, middle, (0, 1), axis.get_xaxis_transform(), "offset points", **look
                )


def _share_value_ranges(axes: Sequence[Axes]) -> None:
    """Give panels with the same label and of similar size the same range of values."""
    for label in {axis.get_ylabel() for axis in axes} - {""}:
        left = sorted(
            (a for a in axes if a.get_ylabel() == label), key=_largest_magnitude, reverse=True
        )
        while left:
            least = MIN_SHARE_OF_AXIS * _largest_magnitude(left[0])
            alike = [axis for axis in left if _largest_magnitude(axis) >= least]
            left = left[len(alike) :]
            ends = np.array([axis.get_ylim() for axis in alike])
            for axis in alike:
                axis.set_ylim(ends.min(), ends.max())


def _largest_magnitude(axis: Axes) -> float:
    """Largest magnitude within the range of values of a panel."""
    return float(np.abs(axis.get_ylim()).max())
