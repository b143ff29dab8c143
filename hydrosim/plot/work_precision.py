"""Work-precision picture of a convergence study."""

from __future__ import annotations

from pathlib import Path

import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from hydrosim.outputs import Output, save_picture
from hydrosim.plot.panels import axis_label, wrap_title
from hydrosim.plot.styles import STYLES
from hydrosim.presentation.units import units_of


def draw_work_precision(study: xr.Dataset, output: Path | Output) -> None:
    """Draw the error of the motion against run time and against evaluations, a line per method."""
    length = units_of(study.attrs).display_unit("m")
    figure = Figure(figsize=(10, 4.5), dpi=100, layout="constrained")
    FigureCanvasAgg(figure)
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
    figure.axes[0].set_ylabel(axis_label("largest error of a place", length.unit))
    figure.axes[1].legend()
    figure.suptitle(wrap_title(study.attrs["title"], figure.get_figwidth()))
    save_picture(figure, output)
