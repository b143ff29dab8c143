"""Draws base.png: the three cases.

python cases/sphere/picture.py
"""

from __future__ import annotations

from pathlib import Path

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydrosim import load_case, simulate

HERE = Path(__file__).parent
BLUE, ORANGE = "#0072B2", "#E69F00"


def run(case: str) -> xr.Dataset:
    """A run recorded every 0.1 s."""
    return simulate(load_case(HERE / f"{case}.yaml", {"output.step": "0.1 s"})).sel(body="sphere")


def draw(axis: Axes, found: xr.Dataset, dofs: tuple[str, ...], span: tuple[float, float]) -> None:
    """Motions over time, and the waves if there are any."""
    inside = found.sel(time=slice(*span))
    if abs(inside.wave_elevation).max() > 0.0:
        axis.plot(inside.time, inside.wave_elevation, color="0.75", linewidth=0.9, label="waves")
    for dof, colour in zip(dofs, (BLUE, ORANGE), strict=False):
        line = inside.position.sel(dof=dof)
        axis.plot(inside.time, line, color=colour, linewidth=1.1, label=dof)
    axis.margins(x=0.0, y=0.15)
    axis.grid(alpha=0.3)
    axis.spines[["top", "right"]].set_visible(False)
    axis.set_title(found.attrs["title"], fontsize="medium", loc="left")
    axis.set(xlabel="time [s]", ylabel="[m]")
    axis.legend(loc="upper right", ncols=3, fontsize="small", frameon=False)


def main() -> None:
    """Decay and regular waves side by side, the irregular sea below."""
    figure = Figure((11.0, 6.5), dpi=100, layout="constrained")
    grid = figure.add_gridspec(2, 2)
    draw(figure.add_subplot(grid[0, 0]), run("decay"), ("heave",), (0.0, 40.0))
    draw(figure.add_subplot(grid[0, 1]), run("regular"), ("heave",), (360.0, 400.0))
    draw(figure.add_subplot(grid[1, :]), run("irregular"), ("heave", "surge"), (0.0, 300.0))
    figure.savefig(HERE / "base.png")


if __name__ == "__main__":
    main()
