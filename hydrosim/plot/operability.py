"""The picture of limits: significant height over peak period, with the criterion that governs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from hydrosim.outputs import Output, save_picture
from hydrosim.plot.styles import COLOURS

MARKS = "osD^vP*X"
SIZE = (7.5, 3.6)  # inches of a panel


def draw_limits(found: xr.Dataset, output: Path | Output) -> None:
    """A panel for each stage, a line with its interval for each heading and swell, and at each
    point the mark of the criterion that governs there."""
    stages = [str(stage) for stage in found.stage.values]
    figure = Figure((SIZE[0], SIZE[1] * len(stages) + 0.4), dpi=100, layout="constrained")
    FigureCanvasAgg(figure)
    names = sorted({str(name) for name in found.governing.values.ravel() if name})
    axes = figure.subplots(len(stages), 1, squeeze=False, sharex=True)[:, 0]
    for axis, stage in zip(axes, stages, strict=True):
        _panel(axis, found.sel(stage=stage), names)
        axis.set_title(stage if len(stages) > 1 else "", loc="left", fontsize="medium")
    axes[-1].set_xlabel("peak period [s]")
    share = f"{found.attrs['probability']:.3g} of the seas hold all criteria"
    figure.suptitle(f"{found.attrs['title']}: limits up to which {share}")
    save_picture(figure, output)


def _panel(axis: Axes, found: xr.Dataset, names: list[str]) -> None:
    lines = [(swell, heading) for swell in found.swell.values for heading in found.heading.values]
    for k, (swell, heading) in enumerate(lines):
        at, colour = found.sel(swell=swell, heading=heading), COLOURS[k % len(COLOURS)]
        period, limit = at.peak_period.values, at.limit.values
        top = np.minimum(at.high.values, found.attrs["highest"]) if found.attrs["runs"] else limit
        label = f"waves to {np.degrees(float(heading)):g}°"
        label += "" if swell == "none" else f", swell {swell}"
        axis.fill_between(period, at.low.values, top, color=colour, alpha=0.15)
        axis.plot(period, limit, color=colour, label=label)
        for name in names:
            of = at.governing.values == name
            axis.plot(period[of], limit[of], MARKS[names.index(name) % len(MARKS)], color=colour)
    for name in names:
        mark = MARKS[names.index(name) % len(MARKS)]
        axis.plot([], [], mark, color="0.3", label=f"governed by {name}")
    axis.set_ylabel("significant height [m]")
    axis.set_ylim(bottom=0.0)
    axis.grid(alpha=0.3)
    axis.spines[["top", "right"]].set_visible(False)
    axis.legend(frameon=False, fontsize="small")
