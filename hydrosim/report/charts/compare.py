"""Picture of a comparison: run and recording together, their difference, and a close-up at the
largest difference."""

from __future__ import annotations

from pathlib import Path
from textwrap import shorten

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from hydrosim.compare.comparison import ChannelResult, Comparison
from hydrosim.files.display_units import DEFAULT, DisplayUnit, Units
from hydrosim.files.outputs import Output, save_picture
from hydrosim.report.charts.panels import (
    COLOURS,
    DPI,
    PLAIN_NUMBER_POWERS,
    axis_label,
    thin_records,
    wrap_title,
)

CHANNELS = 8  # in a picture
COMPARISON_WIDTH_INCH, CHANNEL_HEIGHT_INCH = (
    11.0,
    2.3,
)  # inches of the picture, and of a channel in it
MIN_CLOSE_UP_TIMES, CLOSE_UP_FRACTION = (
    120,
    0.04,
)  # times in a close-up, at least, and its fraction of all times


def draw_comparison(
    comparison: Comparison, title: str, output: Path | Output, units: Units = DEFAULT
) -> None:
    """Write the picture of the channels. If there are more than `CHANNELS`, it shows those with the
    largest difference."""
    furthest = sorted(comparison.results, key=lambda name: -comparison.results[name].error)[
        :CHANNELS
    ]
    shown = [result for name, result in comparison.results.items() if name in furthest]
    more = len(comparison.results) - len(shown)
    figure = Figure(
        (COMPARISON_WIDTH_INCH, CHANNEL_HEIGHT_INCH * len(shown) + 0.8),
        dpi=DPI,
        layout="constrained",
    )
    FigureCanvasAgg(figure)
    figure.suptitle(
        wrap_title(
            f"{title}; {more} channels with smaller differences are not drawn" if more else title,
            figure.get_figwidth(),
        )
    )
    ratios = {"width_ratios": [3, 1], "height_ratios": [2, 1] * len(shown)}
    axes = figure.subplots(2 * len(shown), 2, gridspec_kw=ratios)
    for row, result in enumerate(shown):
        over, under = axes[2 * row], axes[2 * row + 1]
        read = units.display_unit(result.pair.unit)
        _draw_channel(over[0], under[0], comparison.overlap.time, result, read)
        _close(over[1], under[1], comparison.overlap.time, result, read.factor)
    for axis in axes[-1]:
        axis.set_xlabel("time [s]")
    figure.align_ylabels(axes[:, 0])
    lines, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(lines, labels, loc="outside upper right", ncols=2, frameon=False)
    save_picture(figure, output)


def _draw_channel(
    over: Axes, under: Axes, time: np.ndarray, result: ChannelResult, shown: DisplayUnit
) -> None:
    name = result.pair.channel.replace("_", " ").replace(".", ", ")
    _draw(over, under, time, result, shown.factor)
    over.set_title(shorten(f"{name}: {result.verdict}", 110), loc="left", fontsize="medium")
    over.set_ylabel(f"[{shown.unit}]" if shown.unit else "")
    under.set_ylabel(axis_label("difference\n", shown.unit))


def _close(over: Axes, under: Axes, time: np.ndarray, result: ChannelResult, factor: float) -> None:
    count = max(MIN_CLOSE_UP_TIMES, int(CLOSE_UP_FRACTION * time.size))
    first = int(np.searchsorted(time, result.figures.peak_time)) - count // 2
    first = max(min(first, time.size - count), 0)
    _draw(over, under, time, result, factor, slice(first, first + count))
    over.set_title("where it is largest", loc="left", fontsize="small")


def _draw(
    over: Axes,
    under: Axes,
    time: np.ndarray,
    result: ChannelResult,
    factor: float,
    part: slice = slice(None),
) -> None:
    """Draw both series above, and their difference below."""
    ours = factor * result.pair.ours[part]
    recorded = factor * result.pair.recorded[part]
    for name, values, dash in (("ours", ours, "-"), ("recorded", recorded, "--")):
        colour = COLOURS[name == "recorded"]
        over.plot(*thin_records(time[part], values), dash, color=colour, linewidth=0.9, label=name)
    under.plot(*thin_records(time[part], ours - recorded), color="0.3", linewidth=0.8)
    over.tick_params(labelbottom=False)
    for axis in (over, under):
        axis.margins(x=0.0)
        axis.grid(alpha=0.3)
        axis.spines[["top", "right"]].set_visible(False)
        axis.ticklabel_format(axis="y", scilimits=PLAIN_NUMBER_POWERS, useOffset=False)
