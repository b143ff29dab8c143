"""Draws directions.png and coupling.png from the tables that the studies of these names wrote.

python cases/reverse_float_over/studies/pictures.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

HERE = Path(__file__).parent
BLUE, ORANGE, BLACK = "#0072B2", "#E69F00", "#000000"
CAUSES = {"held": BLUE, "longer": ORANGE, "pressed": "#009E73"}
CAUSED = {"held": "stick", "longer": "slip, for longer one way", "pressed": "slip, pressed harder"}
HEADING = "environment.waves.heading [deg]"
SEAS = {
    "period": ("environment.waves.peak_period [s]", "peak period [s], Hs 1.5 m"),
    "height": ("environment.waves.significant_height [m]", "significant height [m], Tp 8 s"),
}


def table(name: str) -> pd.DataFrame:
    """The table of a study: a row for each figure of each value."""
    return pd.read_csv(HERE / f"{name}.csv", comment="#")


def interval(rows: pd.DataFrame, figure: str) -> tuple[np.ndarray, np.ndarray]:
    """Means of a figure, and how far down and up their 90 % intervals go."""
    found = rows[rows.figure == figure]
    mean = found["mean"].to_numpy()
    low = mean - found["mean_low"].to_numpy()
    high = found["mean_high"].to_numpy() - mean
    return mean, np.array([low, high])


def degrees(rows: pd.DataFrame, key: str) -> np.ndarray:
    """Headings of the rows of the first figure [deg]."""
    values = rows[rows.figure == "surge"][key]
    return values.astype(str).str.removesuffix(" deg").astype(float).to_numpy()


def draw_places(axes: Axes, rows: pd.DataFrame, key: str, colour: str, label: str) -> None:
    """Where the barge ends in plan, for each heading."""
    surge, across = interval(rows, "surge")
    sway, along = interval(rows, "sway")
    axes.errorbar(
        surge, sway, xerr=across, yerr=along, fmt="o-", color=colour, capsize=2, lw=0.8, label=label
    )
    for x, y, heading in zip(surge, sway, degrees(rows, key), strict=True):
        axes.annotate(f"{heading:g}°", (x, y), (5, 5), textcoords="offset points", color=colour)


def draw_figures(axes: Axes, rows: pd.DataFrame, x: np.ndarray, figures: dict[str, str]) -> None:
    """Some figures over a parameter."""
    for (name, label), colour in zip(figures.items(), (BLUE, ORANGE, BLACK), strict=False):
        mean, around = interval(rows, name)
        axes.errorbar(x, mean, yerr=around, fmt="o-", color=colour, capsize=3, label=label)


def finish(axes: Axes, x: str, y: str, title: str) -> None:
    """Labels, grid and legend of figures over a parameter."""
    axes.axhline(0.0, color="grey", linewidth=0.8)
    axes.set_ylabel(y)
    axes.legend(fontsize=8, frameon=False)
    finish_row(axes, x, title)


def finish_row(axes: Axes, x: str, title: str) -> None:
    """Label, title and grid of figures by name."""
    axes.set_xlabel(x)
    axes.set_title(title, fontsize=10)
    axes.grid(alpha=0.3)
    axes.spines[["top", "right"]].set_visible(False)


def draw_directions() -> Figure:
    """Displacement by heading, what waves alone make friction, and displacement by sea."""
    found, faint = table("directions"), table("directions_faint")
    figure = Figure((11.0, 8.0), dpi=100, layout="constrained")
    plan, way, period, height = figure.subplots(2, 2).ravel()
    draw_places(
        plan, found[found.study == "direction"], HEADING, BLUE, "yaw free, as in the base case"
    )
    draw_places(plan, found[found.study == "direction_held"], "heading_held", ORANGE, "without yaw")
    finish(plan, "surge [m]", "sway [m]", "Displacement in 2000 s, by heading of the waves")
    draw_figures(
        way,
        faint,
        degrees(faint, "heading_faint"),
        {"goes_slipping_surge": "surge", "goes_slipping_sway": "sway"},
    )
    finish(
        way, "heading [deg]", "way while pressed [m]", "With a thousandth of the friction, no yaw"
    )
    for axes, (study, (key, label)) in zip((period, height), SEAS.items(), strict=True):
        rows = found[found.study == study]
        x = rows[rows.figure == "surge"][key].to_numpy()
        draw_figures(
            axes,
            rows,
            x,
            {
                "surge": "displacement",
                "goes_open_surge": "way while open",
                "goes_slipping_surge": "way while slipping",
            },
        )
        finish(axes, label, "surge [m]", "Waves along the barge")
    return figure


def draw_causes(axes: Axes, rows: pd.DataFrame, names: list[str], direction: str) -> None:
    """Mean friction by cause, a bar for each value."""
    ends = {-1: np.zeros(len(names)), 1: np.zeros(len(names))}
    for cause, colour in CAUSES.items():
        mean, _ = interval(rows, f"{cause}_{direction}")
        for side, end in ends.items():
            part = np.where(np.sign(mean) == side, mean, 0.0)
            label = CAUSED[cause] if side < 0 else None
            axes.barh(names, part, left=end, color=colour, label=label)
            end += part
    axes.invert_yaxis()


def draw_moves(axes: Axes, rows: pd.DataFrame, names: list[str], directions: list[str]) -> None:
    """Displacement, a point for each value."""
    height = np.arange(len(names))
    for place, (direction, colour) in enumerate(zip(directions, (BLUE, ORANGE), strict=False)):
        mean, around = interval(rows, direction)
        y = height + 0.25 * place
        axes.errorbar(mean, y, xerr=around, fmt="o", color=colour, capsize=3, label=direction)
    axes.axvline(0.0, color="grey", linewidth=0.8)
    axes.set_yticks(height, names)
    axes.invert_yaxis()


def draw_coupling() -> Figure:
    """Displacement and causes of friction: along the barge above, oblique below."""
    found = table("coupling")
    figure = Figure((11.0, 7.5), dpi=100, layout="constrained")
    rows_of_axes = figure.subplots(2, 2, height_ratios=(7, 5))
    titles = {"along": "waves along the barge", "oblique": "waves at 45 deg"}
    moving = {"along": ["surge"], "oblique": ["surge", "sway"]}
    for (study, title), (left, right) in zip(titles.items(), rows_of_axes, strict=True):
        rows = found[found.study == study]
        names = list(rows[rows.figure == "surge"][study])
        draw_moves(left, rows, names, moving[study])
        finish_row(left, "displacement in 2000 s [m]", title.capitalize())
        draw_causes(right, rows, names, "surge")
        finish_row(right, "mean friction in surge, in contact [kN]", f"Its causes, {title}")
    labels = [*left.get_legend_handles_labels(), *right.get_legend_handles_labels()]
    figure.legend(labels[0] + labels[2], labels[1] + labels[3], ncols=5, loc="outside lower center")
    return figure


if __name__ == "__main__":
    draw_directions().savefig(HERE / "directions.png")
    draw_coupling().savefig(HERE / "coupling.png")
