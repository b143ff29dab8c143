"""The picture of a linear analysis: RAOs over frequency, a line for each heading."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

TURNS = ("roll", "pitch", "yaw")
STILL = 1e-6  # of the largest motion: it has no phase


def draw_response(found: xr.Dataset, path: Path) -> None:
    """Amplitudes and phases of all motions that waves excite, body by body."""
    excited = [
        (str(body), str(dof))
        for body in found.body.values
        for dof in found.dof.values
        if float(found.rao_amplitude.sel(body=body, dof=dof).max()) > 0.0
    ]
    rows = max(len(excited), 1)
    figure = Figure(figsize=(11.0, 2.2 * rows + 0.8), layout="constrained")
    axes = figure.subplots(rows, 2, squeeze=False, sharex=True)
    for (body, dof), (size, phase) in zip(excited, axes, strict=False):
        _draw_motion(found.sel(body=body, dof=dof), dof, size, phase)
        size.set_title(f"{body}: {dof}" if found.body.size > 1 else dof, fontsize="medium")
    for axis in axes[-1]:
        axis.set_xlabel("frequency [rad/s]")
    axes[0, 0].legend(frameon=False, fontsize="small")
    figure.suptitle(f"{found.title}: response to waves of unit amplitude")
    figure.savefig(path, dpi=100)


def _draw_motion(at: xr.Dataset, dof: str, size: Axes, phase: Axes) -> None:
    scale, unit = (180.0 / np.pi, "deg/m") if dof in TURNS else (1.0, "m/m")
    for heading in at.heading.values:
        rao = at.sel(heading=heading)
        label = f"waves to {np.degrees(heading):.0f}°"
        size.plot(at.frequency, scale * rao.rao_amplitude, label=label, linewidth=1.2)
        moves = rao.rao_amplitude > STILL * float(at.rao_amplitude.max())
        phase.plot(at.frequency, np.degrees(rao.rao_phase.where(moves)), ".", markersize=2.5)
    size.set_ylabel(f"amplitude [{unit}]")
    phase.set_ylabel("phase [deg]")
    phase.set_yticks([-180, -90, 0, 90, 180])
    for axis in (size, phase):
        axis.grid(alpha=0.3)
        axis.spines[["top", "right"]].set_visible(False)
