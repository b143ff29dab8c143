"""Picture of retardation functions: one of each degree of freedom by itself, and couplings."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from hydrosim.database.database import Real
from hydrosim.database.kernels import Kernel
from hydrosim.outputs import Output, save_picture
from hydrosim.plot.database import COEFFICIENTS
from hydrosim.plot.panels import DIGITS, labelled, wrapped

COLUMNS, WIDTH, HEIGHT = 3, 4.6, 2.4  # panels in a row; inches of each


def draw_kernels(title: str, time: Real, functions: Sequence[Kernel], output: Output) -> None:
    """A panel for each function."""
    rows = max(-(-len(functions) // COLUMNS), 1)
    figure = Figure((WIDTH * COLUMNS, HEIGHT * rows + 0.6), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(rows, COLUMNS, squeeze=False, sharex=True).ravel()
    for one, axis in zip(functions, axes, strict=False):
        unit, factor = COEFFICIENTS.display_unit(one.unit)
        axis.plot(time, factor * one.values, linewidth=1.0)
        axis.axhline(0.0, color="grey", linewidth=0.5)
        first, second = one.name.split(" ")
        axis.set_title(first if first == second else f"{first} by {second}", fontsize="medium")
        axis.set_ylabel(labelled("K", unit))
        axis.ticklabel_format(axis="y", scilimits=DIGITS)
    for axis in axes[len(functions) :]:
        axis.set_axis_off()
    for axis in axes[max(len(functions) - COLUMNS, 0) : len(functions)]:
        axis.set_xlabel("time [s]")
        axis.tick_params(labelbottom=True)
    figure.suptitle(wrapped(f"{title}: retardation functions", figure.get_figwidth()))
    save_picture(figure, output, dpi=100)
