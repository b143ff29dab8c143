"""Draws base.png: the numerical oscillation at 0.1 s, and how it goes away.

python cases/numerical_oscillation/picture.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from hydrosim import load_case, simulate
from hydrosim.case import Case

HERE = Path(__file__).parent
RUNS = {  # name: case, settings, colour
    "rk2, 0.1 s": ("base", {}, "#D55E00"),
    "rk4, 0.1 s": ("base", {"solver.method": "rk4"}, "#56B4E9"),
    "rk2, 0.01 s": ("fine_step", {}, "#000000"),
}
STAGES = {"floating": (0, 1000), "lifted 1.5 m": (2000, 3000), "steel to steel": (4000, 5000)}
CLOSE_UP = (4700.0, 4720.0)  # s


def run(case: str, settings: dict[str, object]) -> xr.Dataset:
    """A run recorded every 0.1 s."""
    loaded: Case = load_case(HERE / f"{case}.yaml", {"output.step": "0.1 s", **settings})
    return simulate(loaded)


def lines(run: xr.Dataset) -> dict[str, np.ndarray]:
    """What is drawn, by its label."""
    barge = run.sel(body="barge")
    velocity, force = barge.velocity, barge.force_interface
    return {
        "heave\nvelocity [m/s]": velocity.sel(dof="heave").values,
        "roll [deg]": np.degrees(barge.position.sel(dof="roll").values),
        "surge\nvelocity [mm/s]": 1e3 * velocity.sel(dof="surge").values,
        "friction\nin surge [MN]": 1e-6 * force.sel(dof="surge").values,
    }


def picture(runs: dict[str, xr.Dataset]) -> Figure:
    """The whole runs on the left, a close-up of the last stage on the right."""
    drawn = {name: lines(run) for name, run in runs.items()}
    labels = next(iter(drawn.values()))
    figure = Figure((11.0, 7.0), dpi=100, layout="constrained")
    axes = figure.subplots(len(labels), 2, sharex="col", width_ratios=(3, 2))
    for row, label in zip(axes, labels, strict=True):
        for axis, span in zip(row, ((0.0, np.inf), CLOSE_UP), strict=True):
            for name, run in runs.items():
                time = run.time.values
                inside = (time >= span[0]) & (time <= span[1])
                values, colour = drawn[name][label][inside], RUNS[name][2]
                axis.plot(time[inside], values, color=colour, linewidth=0.9, label=name)
            axis.margins(x=0.0)
            axis.grid(alpha=0.3)
            axis.spines[["top", "right"]].set_visible(False)
        row[0].set_ylabel(label)
    for stage, (start, end) in STAGES.items():
        for axis in axes[:, 0]:
            axis.axvspan(start, end, color="0.93", zorder=0)
        top = axes[0, 0].get_xaxis_transform()
        axes[0, 0].text((start + end) / 2, 1.03, stage, ha="center", transform=top)
    axes[0, 1].set_title("steel to steel, close up", fontsize="medium")
    axes[-1, 1].set_xticks(np.arange(CLOSE_UP[0], CLOSE_UP[1] + 1.0, 5.0))
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    for axis in axes[-1]:
        axis.set_xlabel("time [s]")
    return figure


if __name__ == "__main__":
    found = {name: run(case, settings) for name, (case, settings, _) in RUNS.items()}
    picture(found).savefig(HERE / "base.png")
