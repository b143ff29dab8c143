"""Recipe of ``h851_qtf.nc``: the database ``h851.nc`` with difference-frequency QTFs.

    pip install .[bem]
    hydrosim db build hydro_db/h851.yaml (where h851.nc is not there yet)
    python hydro_db/h851_qtf.py          (--jobs 2: two processes of 1 GB each)

Hull, panels, mass and water are those of ``h851.yaml``. Frequencies are 0.3 to 1.3 rad/s, close
together where the barge rolls and pitches in resonance; every one is also a frequency of the
database, so that the diagonal in surge, sway and yaw is its mean drift.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydrosim.database import HydroDatabase, load, needed
from hydrosim.database.build.build import afloat, floating
from hydrosim.database.build.near_field import Flow, Wetted, first_order_all, wetted_surface
from hydrosim.database.build.qtf import difference_qtf
from hydrosim.database.build.recipe import load_recipe
from hydrosim.database.build.water import Water
from hydrosim.database.netcdf import write
from hydrosim.scene import DOFS

FREQUENCIES = np.concatenate(
    [np.arange(15, 20, 2) / 50, np.arange(20, 36) / 50, np.arange(37, 66, 2) / 50]
)
HEADINGS = np.radians([0.0, 45.0, 90.0, 180.0])
SHOWN = ((0, 0), (1, 0), (2, 1), (1, 5))  # headings and DOFs of the picture


def flows(recipe: Path, frequencies: np.ndarray, jobs: int) -> tuple[Wetted, list[Flow]]:
    """First-order flow round the barge, floating free."""
    given = load_recipe(recipe)
    floats, data = afloat(given), given.data.water
    water = Water(data.density, data.gravity, data.depth)
    body = floating(given, floats.integrals, water)
    found = first_order_all(floats.hull.body, body, water, frequencies, HEADINGS, jobs)
    return wetted_surface(floats.hull.body), found


def with_qtf(db: HydroDatabase, wetted: Wetted, found: list[Flow]) -> HydroDatabase:
    """The database with the QTFs of these flows."""
    pairs, transfer = difference_qtf(db, wetted, found, HEADINGS)
    method = {
        "method": "near field, Pinkster's second-order potential; surge, sway, yaw scaled to the"
        " far field's diagonal",
        "panels": len(wetted.arm),
    }
    return replace(
        db,
        qtf_frequency=np.array([flow.frequency for flow in found]),
        qtf_heading=pairs,
        qtf_difference=transfer,
        attributes={**db.attributes, "qtf": json.dumps(method)},
    )


def draw(db: HydroDatabase, path: Path) -> None:
    """Magnitudes over both frequencies."""
    figure = Figure(figsize=(11, 9), layout="constrained")
    axes = figure.subplots(2, 2)
    for axis, (heading, dof) in zip(axes.flat, SHOWN, strict=True):
        _draw_one(axis, db, heading, dof)
    figure.suptitle(f"{db.attributes['title']}: difference-frequency QTF")
    figure.savefig(path, dpi=100)


def _draw_one(axis: Axes, db: HydroDatabase, heading: int, dof: int) -> None:
    w = needed(db, "qtf_frequency")
    size = np.abs(needed(db, "qtf_difference")[heading, :, :, dof]) / 1e3
    shades = axis.contourf(w, w, size.T, levels=24, cmap="viridis")
    unit = "kN m/m²" if dof > 2 else "kN/m²"
    axis.figure.colorbar(shades, ax=axis, label=f"|T| [{unit}]")
    degrees = np.degrees(needed(db, "qtf_heading")[heading, 0])
    axis.set(xlabel="$w_1$ [rad/s]", ylabel="$w_2$ [rad/s]", aspect="equal")
    axis.set_title(f"{DOFS[dof]}, waves to {degrees:.0f}°", fontsize="medium")


def main() -> None:
    """Compute and write the database and its picture."""
    parser = argparse.ArgumentParser(description="Compute hydro_db/h851_qtf.nc.")
    parser.add_argument("--jobs", type=int, default=1, help="number of processes")
    parser.add_argument("--output", type=Path, default=Path(__file__).with_suffix(".nc"))
    given = parser.parse_args()
    db = load(Path(__file__).with_name("h851.nc"))
    db = with_qtf(db, *flows(Path(__file__).with_name("h851.yaml"), FREQUENCIES, given.jobs))
    write(db, given.output)
    draw(db, given.output.with_suffix(".png"))


if __name__ == "__main__":
    main()
