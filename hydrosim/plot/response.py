"""Picture of a linear analysis: RAOs over frequency, with a line for each heading."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydrosim.documents.digits import digits_of
from hydrosim.outputs import Output, save_picture
from hydrosim.plot.panels import axis_label, wrap_title
from hydrosim.presentation.units import DisplayUnit, Units, unit_of_dof, units_of

NEGLIGIBLE_RESPONSE_RATIO = 1e-6  # of the largest motion: it has no phase


def draw_response(found: xr.Dataset, output: Path | Output) -> None:
    """Draw amplitudes and phases of all motions that waves excite, with all bodies together."""
    units = units_of(found.attrs)
    dofs = [str(d) for d in found.dof.values if np.any(found.rao_amplitude.sel(dof=d) > 0.0)]
    rows = max(len(dofs), 1)
    height = 2.2 * rows + 0.8
    figure = Figure(figsize=(11.0, height))
    figure.subplots_adjust(0.07, 0.45 / height, 0.99, 1.0 - 0.7 / height, 0.15, 0.25)
    axes = figure.subplots(rows, 2, squeeze=False, sharex=True)
    for dof, (size, phase) in zip(dofs, axes, strict=False):
        amplitude = units.display_unit(f"{unit_of_dof(dof)}/m")
        for body in found.body.values:
            _draw_motion(found.sel(body=body, dof=dof), amplitude, units, size, phase)
        size.set_ylabel(axis_label(dof, amplitude.unit))
        _dress(units, size, phase)
    for axis in axes[-1]:
        axis.set_xlabel("frequency [rad/s]")
    if dofs:
        axes[0, 0].legend(frameon=False, fontsize="small")
    figure.suptitle(
        wrap_title(f"{found.title}: response to waves of unit amplitude", figure.get_figwidth())
    )
    save_picture(figure, output, dpi=100)


def _draw_motion(
    at: xr.Dataset, amplitude: DisplayUnit, units: Units, size: Axes, phase: Axes
) -> None:
    """Draw a line of one body for each heading."""
    angle = units.display_unit("rad")
    for heading in at.heading.values:
        rao = at.sel(heading=heading)
        label = f"{at.body.values}, waves to {digits_of(angle.factor * heading)} {angle.unit}"
        size.plot(at.frequency, amplitude.factor * rao.rao_amplitude, label=label, linewidth=1.2)
        moves = rao.rao_amplitude > NEGLIGIBLE_RESPONSE_RATIO * float(at.rao_amplitude.max())
        phase.plot(at.frequency, angle.factor * rao.rao_phase.where(moves), ".", markersize=2.5)


def _dress(units: Units, size: Axes, phase: Axes) -> None:
    angle = units.display_unit("rad")
    phase.set_ylabel(axis_label("phase", angle.unit))
    phase.set_yticks(angle.factor * np.pi * np.array([-1.0, -0.5, 0.0, 0.5, 1.0]))
    for axis in (size, phase):
        axis.grid(alpha=0.3)
        axis.spines[["top", "right"]].set_visible(False)
