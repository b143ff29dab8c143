"""Picture of retardation functions: one of each degree of freedom by itself, and couplings."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from hydrosim.database.database import Real
from hydrosim.database.kernels import Kernel
from hydrosim.outputs import Output, save_picture
from hydrosim.plot.database import COEFFICIENT_UNITS
from hydrosim.plot.panels import PLAIN_NUMBER_POWERS, axis_label, wrap_title

PANELS_PER_ROW, KERNEL_PANEL_WIDTH_INCH, KERNEL_PANEL_HEIGHT_INCH = (
    3,
    4.6,
    2.4,
)  # panels in a row; inches of each


def draw_kernels(title: str, time: Real, functions: Sequence[Kernel], output: Output) -> None:
    """A panel for each function."""
    rows = max(-(-len(functions) // PANELS_PER_ROW), 1)
    figure = Figure(
        (KERNEL_PANEL_WIDTH_INCH * PANELS_PER_ROW, KERNEL_PANEL_HEIGHT_INCH * rows + 0.6),
        layout="constrained",
    )
    FigureCanvasAgg(figure)
    axes = figure.subplots(rows, PANELS_PER_ROW, squeeze=False, sharex=True).ravel()
    for one, axis in zip(functions, axes, strict=False):
        unit, factor = COEFFICIENT_UNITS.display_unit(one.unit)
        axis.plot(time, factor * one.values, linewidth=1.0)
        axis.axhline(0.0, color="grey", linewidth=0.5)
        first, second = one.name.split(" ")
        axis.set_title(first if first == second else f"{first} by {second}", fontsize="medium")
        axis.set_ylabel(axis_label("K", unit))
        axis.ticklabel_format(axis="y", scilimits=PLAIN_NUMBER_POWERS)
    for axis in axes[len(functions) :]:
        axis.set_axis_off()
    for axis in axes[max(len(functions) - PANELS_PER_ROW, 0) : len(functions)]:
        axis.set_xlabel("time [s]")
        axis.tick_params(labelbottom=True)
    figure.suptitle(wrap_title(f"{title}: retardation functions", figure.get_figwidth()))
    save_picture(figure, output, dpi=100)
