"""Layout of a picture: title and remarks, one time axis, shaded phases."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.transforms import ScaledTranslation

from hydrosim.plot.panels import Panel, TimeWindow, wrap_title
from hydrosim.plot.styles import SHADE
from hydrosim.results.similar_sizes import MIN_SHARE_OF_AXIS

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
        _dress(axis, frame)
    _level(axes)
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


def _dress(axis: Axes, frame: PictureFrame) -> None:
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


def _level(axes: Sequence[Axes]) -> None:
    """Give panels with the same label and of similar size the same range of values."""
    for label in {axis.get_ylabel() for axis in axes} - {""}:
        left = sorted((a for a in axes if a.get_ylabel() == label), key=_reach, reverse=True)
        while left:
            least = MIN_SHARE_OF_AXIS * _reach(left[0])
            alike = [axis for axis in left if _reach(axis) >= least]
            left = left[len(alike) :]
            ends = np.array([axis.get_ylim() for axis in alike])
            for axis in alike:
                axis.set_ylim(ends.min(), ends.max())


def _reach(axis: Axes) -> float:
    """Largest magnitude within the range of values of a panel."""
    return float(np.abs(axis.get_ylim()).max())
