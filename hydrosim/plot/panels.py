"""Panels: lines over time, bands of modes over time, and the picture that stacks them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import cycle
from math import floor, log10
from textwrap import fill
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.transforms import ScaledTranslation

WIDTH, HEIGHT, DPI = 10.0, 1.6, 100  # inches of a picture and of one of its panels; dots per inch
BAND = 0.35  # inches of a band
LABEL = 0.65  # inches from an axis to its label
NAMES, ENTRIES = 24, 8  # letters of a line of the legend; entries of a column of it
BINS = 800  # of a line: about as many as a panel has pixels
COLUMNS = 200  # of a band
APART = 4  # lines with a panel of their own
ALIKE = 1e-6  # of the largest value: lines that differ less are drawn once
PREFIXES = {0: "", 3: "k", 6: "M", 9: "G"}  # of the unit, by power of ten
# Okabe & Ito (2008): colours that the colour-blind can tell apart; after the last, dashed again.
COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#000000")
STYLES = [(colour, dash) for dash in ("-", "--", ":") for colour in COLOURS]
MODES = {2: ("slip", "#E69F00"), 1: ("stick", "#0072B2"), 0: ("open", "#DDDDDD")}  # bottom to top

Series = Mapping[str, np.ndarray]
"""Lines (nt,) by the names in the legend; one without a name is not in it."""


class Panel(NamedTuple):
    """What draws on an axis, and the height of that axis [inch]."""

    draw: Callable[[Axes], None]
    height: float = HEIGHT


def picture(panels: Sequence[Panel], title: str) -> Figure:
    """The panels above each other, over one time axis."""
    heights = [panel.height for panel in panels]
    figure = Figure((WIDTH, sum(heights) + 0.8), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    ratios = {"height_ratios": heights}
    axes = figure.subplots(len(panels), sharex=True, squeeze=False, gridspec_kw=ratios)[:, 0]
    for axis, panel in zip(axes, panels, strict=True):
        panel.draw(axis)
        axis.margins(x=0.0)
        axis.grid(alpha=0.3)
        axis.set_axisbelow(True)
        axis.spines[["top", "right"]].set_visible(False)
        aside = ScaledTranslation(-LABEL, 0.0, figure.dpi_scale_trans)
        axis.yaxis.set_label_coords(0.0, 0.5, axis.transAxes + aside)
    axes[-1].set_xlabel("time [s]")
    figure.suptitle(title)
    return figure


def lines(time: np.ndarray, label: str, unit: str, series: Series) -> Panel:
    """A panel of lines; lines that are alike are drawn once, with all their names."""
    unit, drawn = _scaled(unit, series)
    return Panel(partial(_plot_lines, time, f"{label} [{unit}]", drawn))


def apart(time: np.ndarray, label: str, unit: str, series: Series) -> Iterator[Panel]:
    """A panel for each line, as they would hide each other; one panel if they are too many."""
    unit, drawn = _scaled(unit, series)
    if len(drawn) > APART:
        yield Panel(partial(_plot_lines, time, f"{label} [{unit}]", drawn), 2 * HEIGHT)
        return
    for name, values in drawn.items():
        yield Panel(partial(_plot_lines, time, f"{label} [{unit}]", {name: values}))


def bands(time: np.ndarray, modes: Series) -> Panel:
    """A band for each contact point, its height shared by the modes as they share the time."""
    return Panel(partial(_plot_bands, time, modes), max(HEIGHT, BAND * len(modes)))


def peak(series: Series) -> float:
    """Largest magnitude in the lines."""
    return max(float(np.abs(np.nan_to_num(values)).max(initial=0.0)) for values in series.values())


def thinned(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The smallest and the largest value of each of `BINS` bins, in their order in time: a line
    through them looks like the line through all."""
    size = -(-time.size // BINS)
    if size <= 2:
        return time, values
    bins = np.pad(values, (0, -time.size % size), mode="edge").reshape(-1, size)
    extremes = np.array([bins.argmin(axis=1), bins.argmax(axis=1)])
    at = np.minimum(extremes + size * np.arange(len(bins)), time.size - 1)
    at = np.unique(np.append(at, [0, time.size - 1]))
    return time[at], values[at]


def _scaled(unit: str, series: Series) -> tuple[str, Series]:
    """The unit with a prefix that suits the largest value, and the lines in it, alike ones as one;
    metres and degrees have no prefix."""
    largest, power = peak(series), 0
    if unit in ("N", "J") and largest > 0.0:
        power = min(max(3 * floor(log10(largest) / 3), 0), 9)
    merged = {name: values / 10.0**power for name, values in _merged(series, largest).items()}
    return f"{PREFIXES[power]}{unit}", merged


def _merged(series: Series, largest: float) -> Series:
    """Lines that are alike under one name, "barge 1, barge 2" or "barge 1 and 2 alike"."""
    groups: list[tuple[list[str], np.ndarray]] = []
    for name, values in series.items():
        for names, first in groups:
            if np.allclose(values, first, rtol=0.0, atol=ALIKE * largest, equal_nan=True):
                names.append(name)
                break
        else:
            groups.append(([name], values))
    return {_joined(names): values for names, values in groups}


def _joined(names: list[str]) -> str:
    return ", ".join(names) if len(names) < 3 else f"{names[0]} and {len(names) - 1} alike"


def _plot_lines(time: np.ndarray, label: str, series: Series, axis: Axes) -> None:
    for (name, values), (colour, dash) in zip(series.items(), cycle(STYLES), strict=False):
        axis.plot(
            *thinned(time, values), dash, color=colour, linewidth=0.9, label=fill(name, NAMES)
        )
    axis.set_ylabel(label)
    axis.ticklabel_format(axis="y", scilimits=(-3, 4))
    if any(series):
        _legend(axis)


def _plot_bands(time: np.ndarray, modes: Series, axis: Axes) -> None:
    edges = np.unique(np.linspace(0, time.size - 1, COLUMNS + 1).astype(int))
    for row, values in enumerate(modes.values()):
        base = np.full(edges.size - 1, -0.4 - row)
        for mode, (name, colour) in MODES.items():
            spent = np.add.reduceat((values[:-1] == mode).astype(float), edges[:-1])
            top = base + 0.8 * spent / np.diff(edges)
            band = axis.stairs(top, time[edges], baseline=base, fill=True, color=colour)
            band.set_label(name if row == 0 else "")
            base = top
    axis.set_yticks(-np.arange(len(modes)), labels=list(modes))
    axis.set_ylim(0.5 - len(modes), 0.5)
    _legend(axis, "share of time in")


def _legend(axis: Axes, title: str = "") -> None:
    """Beside the panel, where it hides nothing."""
    columns = -(-len(axis.get_legend_handles_labels()[1]) // ENTRIES)
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
