"""Picture of a fit of decay tests: records, residuals, and damping against amplitude."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydrosim.decay.fit import DecayFit
from hydrosim.outputs import Output, save_picture

CURVE_POINTS = 60
DEGREES = 180.0 / np.pi


def draw_decay(fit: DecayFit, output: Path | Output) -> None:
    """Draw a column for each record, with residuals below, and the damping ratio over amplitude."""
    count = len(fit.decays)
    figure = Figure(figsize=(max(10.0, 5.0 * count), 8.0), layout="constrained")
    grid = figure.add_gridspec(3, count, height_ratios=(2.0, 1.0, 1.6))
    for k, decay in enumerate(fit.decays):
        above = figure.add_subplot(grid[0, k])
        below = figure.add_subplot(grid[1, k], sharex=above)
        above.plot(decay.time, DEGREES * decay.angle, ".", markersize=2.0, label="record")
        above.plot(decay.time, DEGREES * fit.modelled[k], linewidth=1.0, label="fit")
        above.set_title(decay.called, fontsize="small")
        residual = DEGREES * (decay.angle - fit.modelled[k])
        below.plot(decay.time, residual, linewidth=0.7, color="0.3")
        below.set_xlabel("time [s]")
        above.set_ylabel("roll [deg]")
        below.set_ylabel("residual [deg]")
        above.legend(frameon=False, fontsize="small")
        _dress(above)
        _dress(below)
    _draw_damping(fit, figure.add_subplot(grid[2, :]))
    save_picture(figure, output, dpi=100)


def _draw_damping(fit: DecayFit, axis: Axes) -> None:
    """Draw equivalent linear damping, with its 90 % band, up to the largest roll."""
    amplitudes = np.linspace(0.0, fit.size, CURVE_POINTS)
    value, low, high = 100.0 * np.array([fit.terms.damping_ratio(a) for a in amplitudes]).T
    axis.fill_between(DEGREES * amplitudes, low, high, alpha=0.25, label="90 %")
    axis.plot(DEGREES * amplitudes, value, label="p1, p2 and p3")
    axis.set_xlabel("amplitude of roll [deg]")
    axis.set_ylabel("damping ratio [%]")
    axis.set_ylim(bottom=min(0.0, float(low.min())))
    axis.legend(frameon=False, fontsize="small")
    _dress(axis)


def _dress(axis: Axes) -> None:
    axis.grid(alpha=0.3)
    axis.spines[["top", "right"]].set_visible(False)
