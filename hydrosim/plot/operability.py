"""Picture of limits: significant height over peak period, with the governing criterion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from hydrosim.outputs import Output, save_picture
from hydrosim.plot.panels import wrap_title
from hydrosim.plot.styles import COLOURS
from hydrosim.wording.limits import distinct_lines, side_of

MARKS = "osD^vP*X"
STYLES = ("-", (0, (6, 2)), (0, (2, 2)), (0, (6, 2, 1, 2)))
"""Of lines after each other, so that one under another is seen."""
NO_LIMIT = {"below": "v", "above": "^"}
"""Marks of seas whose limit is on a side of the heights."""
ATTRIBUTES = {"below": "lowest", "above": "highest"}
LIMIT_ENDS = ("limit", "low", "high")
OPERABILITY_PANEL_INCH = (7.5, 3.6)  # inches of a panel


def draw_limits(found: xr.Dataset, output: Path | Output) -> None:
    """Draw a panel for each stage, with a line and its interval for each heading and swell. The
    marker at each point shows the criterion that governs there."""
    stages = [str(stage) for stage in found.stage.values]
    figure = Figure(
        (OPERABILITY_PANEL_INCH[0], OPERABILITY_PANEL_INCH[1] * len(stages) + 0.4),
        dpi=100,
        layout="constrained",
    )
    FigureCanvasAgg(figure)
    names = sorted({str(name) for name in found.governing.values.ravel() if name})
    axes = figure.subplots(len(stages), 1, squeeze=False, sharex=True)[:, 0]
    for axis, stage in zip(axes, stages, strict=True):
        _panel(axis, found.sel(stage=stage), names)
        axis.set_title(stage if len(stages) > 1 else "", loc="left", fontsize="medium")
    axes[-1].set_xlabel("peak period [s]")
    share = f"{found.attrs['probability']:.3g} of the seas meet all criteria"
    figure.suptitle(
        wrap_title(f"{found.attrs['title']}: limits up to which {share}", figure.get_figwidth())
    )
    save_picture(figure, output)


def _panel(axis: Axes, found: xr.Dataset, names: list[str]) -> None:
    """Limits over the peak period. A sea without a limit within the heights has no point on a line
    but a mark at the first or the last height; lines that are the same are drawn once."""
    sides: set[str] = set()
    lines = distinct_lines(found)
    for k, (label, at) in enumerate(lines):
        colour = COLOURS[k % len(COLOURS)]
        period = at.peak_period.values
        side = np.array([side_of(float(limit), found) for limit in at.limit.values])
        limit, low, high = (np.where(side == "", at[name].values, np.nan) for name in LIMIT_ENDS)
        top = np.minimum(high, found.attrs["highest"]) if found.attrs["runs"] else limit
        axis.fill_between(period, low, top, color=colour, alpha=0.15)
        style = STYLES[k % len(STYLES)]
        axis.plot(period, limit, color=colour, linestyle=style, label=f"waves {label}")
        for name in names:
            of = at.governing.values == name
            axis.plot(period[of], limit[of], MARKS[names.index(name) % len(MARKS)], color=colour)
        size = 6.0 + 3.0 * (len(lines) - k)
        for which, mark in NO_LIMIT.items():
            of = side == which
            sides |= {which} if of.any() else set()
            place = np.full(of.sum(), found.attrs[ATTRIBUTES[which]])
            axis.plot(period[of], place, mark, color=colour, fillstyle="none", markersize=size)
    for name in names:
        mark = MARKS[names.index(name) % len(MARKS)]
        axis.plot([], [], mark, color="0.3", label=f"governed by {name}")
    for which in sorted(sides):
        label = f"no limit: {which} the heights"
        axis.plot([], [], NO_LIMIT[which], color="0.3", fillstyle="none", label=label)
    axis.set_ylabel("significant height [m]")
    axis.set_ylim(bottom=0.0)
    axis.grid(alpha=0.3)
    axis.spines[["top", "right"]].set_visible(False)
    axis.legend(frameon=False, fontsize="small")
