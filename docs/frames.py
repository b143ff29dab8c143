"""Draws `docs/frames.svg`: frames, signs and headings. ``python docs/frames.py [FILE]``"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Arc, Circle, Polygon

EARTH, BODY, DATABASE, WAVES = "#222222", "#0072b2", "#c04000", "#007a5a"
HULL = "#dddddd"
Point = tuple[float, float]


def arrow(ax: Axes, start: Point, end: Point, colour: str, width: float = 1.6) -> None:
    """An arrow between two points."""
    style = {"arrowstyle": "-|>", "color": colour, "lw": width, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", end, start, arrowprops=style)


def axes_at(
    ax: Axes, origin: Point, length: float, names: tuple[str, str], colour: str, turn: float
) -> None:
    """Two axes at a right angle, turned by ``turn`` [deg], with their names."""
    for angle, name in zip((turn, turn + 90.0), names, strict=True):
        way = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
        arrow(ax, origin, tuple(origin + length * way), colour)
        ax.text(*(origin + (length + 3.5) * way), name, color=colour, ha="center", va="center")
    ax.add_patch(Circle(origin, 0.9, color=colour))


def turn_arrow(ax: Axes, centre: Point, radius: float, start: float, end: float) -> None:
    """An arc from ``start`` to ``end`` [deg] with a head, clockwise if ``end`` is the smaller."""
    low, high = min(start, end), max(start, end)
    ax.add_patch(Arc(centre, 2 * radius, 2 * radius, theta1=low, theta2=high, color=BODY, lw=1.4))
    angles = np.radians((end - 8.0 * np.sign(end - start), end))
    before, last = (np.array(centre) + radius * np.array([np.cos(a), np.sin(a)]) for a in angles)
    arrow(ax, tuple(before), tuple(last), BODY, 1.4)


def draw_side(ax: Axes) -> None:
    """Earth, database and body frame from the side."""
    ax.set_title("From the starboard side (y points away)", loc="left")
    ax.plot((0, 130), (40, 40), color="#56b4e9")
    ax.add_patch(Polygon([(40, 58), (118, 58), (112, 22), (40, 22)], fc=HULL, ec="#666666"))
    axes_at(ax, (8, 40), 20, ("x", "z"), EARTH, 0.0)
    ax.text(2, 30, "earth frame:\nz = 0 is\nstill water", color=EARTH, va="top")
    axes_at(ax, (52, 40), 11, ("", ""), DATABASE, 0.0)
    ax.text(42, 19, "frame of the database: origin on\nstill water", color=DATABASE, va="top")
    axes_at(ax, (80, 47), 20, ("x", "z"), BODY, 0.0)
    ax.text(70, 75, "body frame: origin in the\ncentre of gravity", color=BODY)
    turn_arrow(ax, (80, 47), 9, 230, -50)
    ax.text(69, 35, "pitch > 0:\nbow down", color=BODY, va="top", fontsize=8)


def draw_stern(ax: Axes) -> None:
    """Signs of roll, from astern."""
    ax.set_title("From astern (x points away)", loc="left")
    ax.plot((0, 70), (40, 40), color="#56b4e9")
    ax.add_patch(Polygon([(14, 58), (56, 58), (56, 22), (14, 22)], fc=HULL, ec="#666666"))
    arrow(ax, (35, 47), (13, 47), BODY)
    ax.text(9, 47, "y", color=BODY, ha="center", va="center")
    arrow(ax, (35, 47), (35, 68), BODY)
    ax.text(35, 72, "z", color=BODY, ha="center", va="center")
    ax.add_patch(Circle((35, 47), 0.9, color=BODY))
    turn_arrow(ax, (35, 47), 9, 230, -50)
    ax.text(24, 36, "roll > 0:\nport side up", color=BODY, va="top", fontsize=8)


def draw_above(ax: Axes) -> None:
    """Headings, yaw and signs from above."""
    ax.set_title("From above (z points to you)", loc="left")
    axes_at(ax, (10, 12), 20, ("x", "y"), EARTH, 0.0)
    turn = np.radians(20.0)
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    outline = np.array([(-30, -9), (20, -9), (32, 0), (20, 9), (-30, 9)]) @ rotation.T
    ax.add_patch(Polygon(np.add(outline, (62, 45)), fc=HULL, ec="#666666"))
    axes_at(ax, (62, 45), 24, ("x", "y"), BODY, 20.0)
    ax.plot((62, 104), (45, 45), ls="--", lw=0.8, color="#888888")
    turn_arrow(ax, (62, 45), 37, 0, 20)
    ax.text(101, 51, "heading,\nyaw > 0", color=BODY, fontsize=8)
    for angle, text in ((0, "0 deg"), (90, "90 deg"), (180, "180 deg"), (270, "-90 deg")):
        way = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
        centre = np.array((153.0, 45.0))
        arrow(ax, tuple(centre + 6 * way), tuple(centre + 24 * way), WAVES, 2.0)
        ax.text(*(centre + 33 * way), text, color=WAVES, ha="center", va="center", fontsize=8)
    ax.text(153, 86, "waves, wind, current\ngo to their heading", color=WAVES, ha="center")


def draw_metocean(ax: Axes) -> None:
    """A wave in a compass."""
    ax.set_title("A wave in metocean data", loc="left")
    centre = np.array((32.0, 45.0))
    for angle, name in ((90, "N"), (0, "E"), (270, "S"), (180, "W")):
        way = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
        ax.text(*(centre + 29 * way), name, ha="center", va="center")
        ax.plot(*zip(centre + 22 * way, centre + 25 * way, strict=True), color=EARTH)
    ax.add_patch(Circle(tuple(centre), 25, fill=False, ec=EARTH))
    arrow(ax, (9, 45), (30, 45), WAVES, 2.0)
    ax.text(
        66,
        62,
        "comes from the west:\ndirection 270 deg.\n\n"
        "+x to the north:\nheading -90 deg here.\n\n+x to the east:\nheading 0 deg here.",
        color=WAVES,
        va="top",
    )


def draw() -> plt.Figure:
    """All four views."""
    mpl.rcParams.update(
        {"svg.hashsalt": "frames", "svg.fonttype": "none", "font.size": 9, "axes.titlesize": 10}
    )
    figure, views = plt.subplots(
        2, 2, figsize=(8.2, 5.7), gridspec_kw={"width_ratios": (1.62, 1.0)}, layout="tight"
    )
    for ax, view, width in zip(
        views.flat,
        (draw_side, draw_stern, draw_above, draw_metocean),
        (130, 70, 190, 118),
        strict=True,
    ):
        ax.set(xlim=(0, width), ylim=(0, 92), aspect="equal")
        ax.axis("off")
        view(ax)
    return figure


if __name__ == "__main__":
    path = sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_suffix(".svg")
    draw().savefig(path, metadata={"Date": None} if str(path).endswith("svg") else None, dpi=100)
