"""The picture of a linear analysis: RAOs over frequency, a line for each heading."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydrosim.outputs import Output, save_picture

TURNS = ("roll", "pitch", "yaw")
STILL = 1e-6  # of the largest motion: it has no phase


def draw_response(found: xr.Dataset, output: Path | Output) -> None:
    """Amplitudes and phases of all motions that waves excite, those of all bodies together."""
    dofs = [str(d) for d in found.dof.values if np.any(found.rao_amplitude.sel(dof=d) > 0.0)]
    rows = max(len(dofs), 1)
    height = 2.2 * rows + 0.8
    figure = Figure(figsize=(11.0, height))
    figure.subplots_adjust(0.07, 0.45 / height, 0.99, 1.0 - 0.7 / height, 0.15, 0.25)
    axes = figure.subplots(rows, 2, squeeze=False, sharex=True)
    for dof, (size, phase) in zip(dofs, axes, strict=False):
        for body in found.body.values:
            _draw_motion(found.sel(body=body, dof=dof), dof, size, phase)
        _dress(dof, size, phase)
    for axis in axes[-1]:
        axis.set_xlabel("frequency [rad/s]")
    if dofs:
        axes[0, 0].legend(frameon=False, fontsize="small")
    figure.suptitle(f"{found.title}: response to waves of unit amplitude")
    save_picture(figure, output, dpi=100)


def _draw_motion(at: xr.Dataset, dof: str, size: Axes, phase: Axes) -> None:
    """A line of one body for each heading."""
    for heading in at.heading.values:
        rao = at.sel(heading=heading)
        label = f"{at.body.values}, waves to {np.degrees(heading):.0f}°"
        amplitude = np.degrees(rao.rao_amplitude) if dof in TURNS else rao.rao_amplitude
        size.plot(at.frequency, amplitude, label=label, linewidth=1.2)
        moves = rao.rao_amplitude > STILL * float(at.rao_amplitude.max())
        phase.plot(at.frequency, np.degrees(rao.rao_phase.where(moves)), ".", markersize=2.5)


def _dress(dof: str, size: Axes, phase: Axes) -> None:
    size.set_ylabel(f"{dof} [{'deg/m' if dof in TURNS else 'm/m'}]")
    phase.set_ylabel("phase [deg]")
    phase.set_yticks([-180, -90, 0, 90, 180])
    for axis in (size, phase):
        axis.grid(alpha=0.3)
        axis.spines[["top", "right"]].set_visible(False)
