"""Pages about a database: its panels and main coefficients; its QTFs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from hydrosim.database import HydroDatabase, require_array
from hydrosim.dofs import DOFS
from hydrosim.files.outputs import Output, save_picture

TRANSLATIONS, ROTATIONS = (0, 1, 2), (3, 4, 5)
QTF_DOFS = (0, 1, 2, 5)  # surge, sway, heave, yaw


def draw(db: HydroDatabase, panels: np.ndarray, output: Path | Output) -> None:
    """Write the picture of ``db`` and its hull ``panels`` (n, 4, 3)."""
    figure = Figure(figsize=(12, 15), layout="constrained")
    grid = figure.add_gridspec(5, 2, height_ratios=[1, 0.35, 1, 1, 1])
    _draw_panels(figure.add_subplot(grid[0, :]), panels, (0, 1), "bottom")
    _draw_panels(figure.add_subplot(grid[1, :]), panels, (0, 2), "side")
    axes = [[figure.add_subplot(grid[row, column]) for column in (0, 1)] for row in (2, 3, 4)]
    for column, dofs in enumerate((TRANSLATIONS, ROTATIONS)):
        _draw_matrix(axes[0][column], db, db.added_mass, dofs, "added mass", "kg")
        _draw_matrix(axes[1][column], db, db.radiation_damping, dofs, "radiation damping", "kg/s")
    _draw_excitation(axes[2][0], db)
    _draw_drift(axes[2][1], db)
    for axis in (axis for row in axes for axis in row):
        axis.set(xlabel="wave frequency [rad/s]", xlim=(0, db.frequency[-1]))
        axis.grid(alpha=0.3)
        axis.legend(fontsize="small")
    axes[2][1].legend(fontsize="small", loc="center right", bbox_to_anchor=(1, 0.6))  # in between
    figure.suptitle(db.attributes["title"])
    save_picture(figure, output, dpi=100)


def draw_qtf(db: HydroDatabase, output: Path | Output) -> None:
    """Draw the magnitudes of the difference-frequency QTFs over both frequencies, for each DOF at
    the heading at which it is largest."""
    figure = Figure(figsize=(11, 9.5), layout="constrained")
    largest = np.abs(require_array(db, "qtf_difference")).max(axis=(1, 2)).argmax(axis=0)
    for axis, dof in zip(figure.subplots(2, 2).flat, QTF_DOFS, strict=True):
        _draw_transfer(axis, db, int(largest[dof]), dof)
    figure.suptitle(f"{db.attributes['title']}: difference-frequency QTFs")
    save_picture(figure, output, dpi=100)


def _draw_transfer(axis: Axes, db: HydroDatabase, pair: int, dof: int) -> None:
    w = require_array(db, "qtf_frequency")
    size = np.abs(require_array(db, "qtf_difference")[pair, :, :, dof]) / 1e3
    shades = axis.pcolormesh(w, w, size.T, shading="nearest", rasterized=True)
    unit = "kN m/m²" if dof in ROTATIONS else "kN/m²"
    axis.figure.colorbar(shades, ax=axis, label=f"|T| [{unit}]")
    axis.set(xlabel="$w_1$ [rad/s]", ylabel="$w_2$ [rad/s]", aspect="equal")
    degrees = np.degrees(require_array(db, "qtf_heading")[pair, 0])
    axis.set_title(f"{DOFS[dof]}, waves to {degrees:.0f}°", fontsize="medium")


def _draw_panels(axis: Axes, panels: np.ndarray, plane: tuple[int, int], name: str) -> None:
    """Draw the panels, seen along the third axis."""
    across, up = plane
    shape = PolyCollection(list(panels[:, :, plane]), facecolor="lightsteelblue", edgecolor="black")
    shape.set_linewidth(0.3)
    axis.add_collection(shape)
    axis.autoscale_view()
    axis.set_aspect("equal")
    axis.set(xlabel=f"{'xyz'[across]} [m]", ylabel=f"{'xyz'[up]} [m]")
    axis.set_title(f"{name} of the wetted hull", fontsize="medium")


def _draw_matrix(
    axis: Axes, db: HydroDatabase, matrices: np.ndarray, dofs: tuple[int, ...], name: str, unit: str
) -> None:
    """Draw diagonals over three decades, with a power of ten in the unit that suits the largest."""
    values = matrices[:, dofs, dofs]
    power = 3 * int(np.log10(values.max()) // 3)
    for dof, line in zip(dofs, values.T, strict=True):
        axis.plot(db.frequency, line / 10.0**power, label=DOFS[dof])
    unit = unit.replace("kg", "kg m²") if dofs == ROTATIONS else unit
    axis.set_ylabel(f"{name} [10$^{{{power}}}$ {unit}]")
    axis.set_yscale("log")
    axis.set_ylim(bottom=values.max() / 10.0**power / 1e3)


def _draw_excitation(axis: Axes, db: HydroDatabase) -> None:
    for dof, degrees in ((0, 0), (2, 0), (0, 180), (1, 90), (2, 90)):
        load = np.abs(db.excitation[:, _nearest(db, degrees), dof])
        axis.plot(db.frequency, load / 1e6, label=f"{DOFS[dof]}, waves to {degrees}°")
    axis.set(ylabel="excitation [MN/m]", ylim=(0, None))


def _draw_drift(axis: Axes, db: HydroDatabase) -> None:
    """Draw the drift of the free body as full lines, of the held body as dashed lines."""
    for name, drift, style in (("free", db.mean_drift, "-"), ("held", db.mean_drift_held, "--")):
        axis.set_prop_cycle(None)  # the same colours again
        for dof, degrees in ((0, 0), (0, 180), (1, 90)) if drift is not None else ():
            load = np.asarray(drift)[:, _nearest(db, degrees), dof]
            axis.plot(
                db.frequency, load / 1e3, style, label=f"{name}: {DOFS[dof]}, waves to {degrees}°"
            )
    axis.set_ylabel("mean drift [kN/m²]")


def _nearest(db: HydroDatabase, degrees: float) -> int:
    return int(np.argmin(np.abs(np.degrees(db.heading) - degrees)))
