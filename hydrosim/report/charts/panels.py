"""Pictures over time: styles of lines, panels of lines or bands of modes, and their layout.

A series with many more records than a panel can show is drawn as a band from the smallest to the
largest value of each interval, with its mean. A series with slightly more is a line through these
values.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import cycle
from math import ceil, inf
from textwrap import fill
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.transforms import ScaledTranslation

from hydrosim.files.display_units import DisplayUnit
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
MAX_LEGEND_LETTERS, MAX_LEGEND_ENTRIES = (
    24,
    8,
)  # letters of a line of the legend; entries of a column of it
LETTERS_PER_INCH = 11.0  # of a title
MAX_LABEL_LETTERS = 20  # letters of a line beside an axis
BINS = 800  # of a line: about the number of pixels of a panel
DENSE = 10  # records in a bin from which on a band is drawn
BAND_COLUMNS = 200  # of bands of modes
MAX_LINES_PER_PANEL = 4  # lines in one panel
EQUAL_LINE_RTOL = 1e-6  # of the largest value: lines that differ less are drawn once
PLAIN_NUMBER_POWERS = (-3, 6)  # powers of ten between which numbers beside an axis are written out

Series = Mapping[str, np.ndarray]
"""Lines (nt,) by their names in the legend. Several lines under one name (n, nt) are drawn as a
band from the smallest to the largest. A line without a name is not in the legend."""


class TimeWindow(NamedTuple):
    """Time interval of a picture [s]."""

    start: float = -inf
    end: float = inf

    def record_slice(self, time: np.ndarray) -> slice:
        """Indices of the records in the interval."""
        return slice(
            int(np.searchsorted(time, self.start)), int(np.searchsorted(time, self.end, "right"))
        )


class Panel(NamedTuple):
    """A panel: a function that draws on an axis, and the height of that axis [inch]."""

    draw: Callable[[Axes, TimeWindow], None]
    height: float = PANEL_HEIGHT_INCH


def lines(
    time: np.ndarray,
    label: str,
    shown: DisplayUnit,
    series: Series,
    order: Sequence[str] = (),
) -> Panel:
    """A panel of lines. Equal lines are drawn once, with all their names. Styles follow the
    ``order`` of all possible names. The prefix of the unit suits the ``largest`` value; default:
    that of these lines."""
    drawn = _scale_lines(shown.factor, series, styles(order))
    return Panel(partial(_plot_lines, time, axis_label(label, shown.unit), drawn))


def separate_panels(
    time: np.ndarray, label: str, shown: DisplayUnit, series: Series
) -> Iterator[Panel]:
    """A panel for each line, because they would hide each other. Lines of similar size have one
    range of values."""
    for line in _scale_lines(shown.factor, series):
        yield Panel(partial(_plot_named, time, axis_label(label, shown.unit), line))


def mode_strips(time: np.ndarray, modes: Series) -> Panel:
    """A band for each contact point, whose height is divided like the time in each mode."""
    return Panel(
        partial(_plot_bands, time, modes), max(PANEL_HEIGHT_INCH, BAND_HEIGHT_INCH * len(modes))
    )


def axis_label(text: str, unit: str) -> str:
    """What stands beside an axis: a text, and the unit in brackets where there is one."""
    return f"{text} [{unit}]" if unit else text


def wrap_title(title: str, width: float) -> str:
    """Title in lines that fit a picture of this ``width`` [inch]."""
    return "\n".join(fill(line, int(LETTERS_PER_INCH * width)) for line in title.splitlines())


def peak(series: Series) -> float:
    """Largest magnitude in the lines."""
    peaks = (float(np.abs(np.nan_to_num(values)).max(initial=0.0)) for values in series.values())
    return max(peaks, default=0.0)


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


def merge_equal_lines(series: Series) -> list[tuple[list[str], np.ndarray]]:
    """Lines, with equal ones merged under all their names."""
    least = EQUAL_LINE_RTOL * peak(series)
    groups: list[tuple[list[str], np.ndarray]] = []
    for name, values in series.items():
        for names, first in groups:
            near = values.shape == first.shape
            if near and np.allclose(values, first, rtol=0.0, atol=least, equal_nan=True):
                names.append(name)
                break
        else:
            groups.append(([name], values))
    return groups


class _Line(NamedTuple):
    """A line of a panel."""

    name: str
    values: np.ndarray
    style: Style


def _size(count: int) -> int:
    return ceil(count / BINS)


def _scale_lines(
    factor: float, series: Series, look: Mapping[str, Style] | None = None
) -> list[_Line]:
    """The unit with a prefix that suits the largest value, and the lines in that unit, with equal
    ones merged. Metres and degrees have no prefix."""
    styles = look or {}
    return [
        _Line(_joined_names(names), factor * values, styles.get(names[0], STYLES[k % len(STYLES)]))
        for k, (names, values) in enumerate(merge_equal_lines(series))
    ]


def _joined_names(names: list[str]) -> str:
    """ "barge 1, barge 2" or "barge 1 and 2 more"."""
    return ", ".join(names) if len(names) < 3 else f"{names[0]} and {len(names) - 1} more"


def _plot_lines(
    time: np.ndarray, label: str, drawn: Sequence[_Line], axis: Axes, window: TimeWindow
) -> None:
    inside = window.record_slice(time)
    for line in drawn:
        _plot_line(axis, time[inside], line.values[..., inside], line)
    axis.set_ylabel(label if len(label) < MAX_LABEL_LETTERS else fill(label, MAX_LABEL_LETTERS))
    axis.ticklabel_format(axis="y", scilimits=PLAIN_NUMBER_POWERS)
    if any(line.name for line in drawn):
        _add_legend(axis)


def _plot_named(time: np.ndarray, label: str, line: _Line, axis: Axes, window: TimeWindow) -> None:
    """Draw a line with its name in the panel."""
    _plot_lines(time, label, [_Line("", line.values, STYLES[0])], axis, window)
    axis.margins(y=0.25)  # room for the name
    paper = {"facecolor": "white", "alpha": 0.7, "edgecolor": "none", "pad": 1.0}
    look: dict[str, Any] = {"ha": "left", "va": "top", "fontsize": "small", "bbox": paper}
    axis.text(0.01, 0.97, line.name, transform=axis.transAxes, **look)


def _plot_line(axis: Axes, time: np.ndarray, values: np.ndarray, line: _Line) -> None:
    """Draw a line, or a band with its mean if there are more records than a line can show."""
    look: dict[str, Any] = {
        "color": line.style.colour,
        "linestyle": line.style.dash,
        "linewidth": 0.9,
        "label": fill(line.name, MAX_LEGEND_LETTERS),
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
    axis.fill_between(at, low, high, color=line.style.colour, alpha=0.35, linewidth=0.0)
    axis.plot(at, mean, **look)


def _plot_bands(time: np.ndarray, modes: Series, axis: Axes, window: TimeWindow) -> None:
    inside = window.record_slice(time)
    time = time[inside]
    edges = np.unique(np.linspace(0, time.size - 1, BAND_COLUMNS + 1).astype(int))
    for row, values in enumerate(modes.values()):
        base = np.full(edges.size - 1, -0.4 - row)
        for mode, (name, colour) in MODES.items():
            there = (values[inside][:-1] == mode).astype(float)
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


class ShadedPhase(NamedTuple):
    """An interval of time [s] with a name."""

    name: str
    start: float
    end: float


class PictureFrame(NamedTuple):
    """Common properties of the panels of a picture: title, remarks under it, time interval, shaded
    phases, and number of columns."""

    title: str = ""
    remarks: Sequence[str] = ()
    window: TimeWindow = TimeWindow()
    phases: Sequence[ShadedPhase] = ()
    columns: int = 1


def picture(panels: Sequence[Panel], frame: PictureFrame | str) -> Figure:
    """Draw the panels below each other, or row by row, over one time axis."""
    frame = PictureFrame(frame) if isinstance(frame, str) else frame
    rows = -(-len(panels) // frame.columns)
    heights = [panel.height for panel in panels[:: frame.columns]]
    figure = Figure((PICTURE_WIDTH_INCH, sum(heights) + 0.8), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    ratios = {"height_ratios": heights}
    grid = figure.subplots(rows, frame.columns, sharex=True, squeeze=False, gridspec_kw=ratios)
    axes = list(grid.ravel()[: len(panels)])
    for spare in grid.ravel()[len(panels) :]:
        spare.remove()
    for axis, panel in zip(axes, panels, strict=True):
        panel.draw(axis, frame.window)
        _style_axis(axis, frame)
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
    figure.suptitle(wrap_title(frame.title, PICTURE_WIDTH_INCH))
    return figure


def _style_axis(axis: Axes, frame: PictureFrame) -> None:
    axis.margins(x=0.0)
    axis.grid(alpha=0.3)
    axis.set_axisbelow(True)
    axis.spines[["top", "right"]].set_visible(False)
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
