"""How far are mooring lines in static balance from measured tensions, and how far is MoorDyn?

The fairlead of a chain of 33 m goes round on a vertical circle (Bergdahl et al. 2016): thirty pairs
of period and radius, in `measured.csv`. Compared is the largest tension of a turn: measured, of the
catenary, and of MoorDyn through the door (the extra ``moordyn``). Nothing is fitted. With --keep
the table and the picture are written into the page of the case.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.evidence import with_block
from benchmarks.report import Answer, Row, page_table
from hydrosim import load_case, moordyn, simulate

FOLDER = Path(__file__).parent
CASE = FOLDER / "circle.yaml"
PAGE = FOLDER / "README.md"
BEGIN, END = "<!-- table: python -m benchmarks --keep chain -->", "<!-- end of table -->"
PLACES_OF_TURN = 100
"""Places on the circle at which the catenary is asked."""
STEPS_OF_TURN = 400
"""Steps of the wheel while MoorDyn's chain hangs on it."""
TURNS, LAST_TURNS = 8, 4
"""Turns of MoorDyn's chain, and those at the end whose largest tensions are averaged: the start
with a speed is forgotten after three."""
FILE_POINT = "2 Coupled 0.0 0.0 0.5 "
"""MoorDyn's fairlead in the file: on top of a wheel of 0.2 m at z = 0.3 m."""
COLOURS = ("#0072B2", "#56B4E9", "#009E73", "#E69F00", "#D55E00")


class Comparison(NamedTuple):
    """Largest tensions of a turn [N] at a period [s] and a radius [m]."""

    period: float
    radius: float
    measured: float
    catenary: float
    moordyn: float

    def error_of_catenary(self) -> float:
        """Of the measured tension."""
        return self.catenary / self.measured - 1.0

    def error_of_moordyn(self) -> float:
        """Of the measured tension."""
        return self.moordyn / self.measured - 1.0


def answer() -> Answer:
    """The table and the picture."""
    found = [
        Comparison(period, radius, tension, static_maximum(radius), moordyn_maximum(period, radius))
        for period, radius, tension in measured_maxima()
    ]
    kept = {PAGE: with_block(PAGE.read_text("utf-8"), _page_table(found), BEGIN, END)}
    picture = _picture(found)
    tables = {"Largest tension at the fairlead": [_row(each) for each in found]}
    return Answer(tables, _remarks(found), picture, kept, FOLDER / "chain.png")


def measured_maxima() -> np.ndarray:
    """Period [s], radius [m] and measured largest tension [N], a row (3,) each."""
    return np.loadtxt(FOLDER / "measured.csv", delimiter=",", skiprows=3)


@cache
def static_maximum(radius: float) -> float:
    """Largest tension [N] of the catenary over the places of a turn, whatever the period."""
    period = 1.0
    settings = _settings(period, radius, 1, PLACES_OF_TURN)
    run = simulate(load_case(CASE, settings))
    return float(run.line_tension.max())


def moordyn_maximum(period: float, radius: float) -> float:
    """Mean over the last turns of the largest tension [N] of MoorDyn's chain on the wheel."""
    settings = _settings(period, radius, TURNS, STEPS_OF_TURN) | {"forces": None}
    with TemporaryDirectory() as folder:
        file = Path(folder, "moordyn.txt")
        file.write_text(_moordyn_input(radius))
        run = simulate(load_case(CASE, settings), forces={"chain": moordyn(file, "wheel")})
    pull = np.linalg.norm(run.force_chain.values[:, 0, :3], axis=1)
    turns = pull[: TURNS * STEPS_OF_TURN].reshape(TURNS, STEPS_OF_TURN)
    return float(turns[-LAST_TURNS:].max(axis=1).mean())


def _settings(period: float, radius: float, turns: int, steps: int) -> dict[str, object]:
    """Keys of the case for some turns, each in so many steps."""
    step = period / steps
    return {
        "forces.chain.point": [0.0, 0.0, radius],
        "joints.axle.initial.rate": 2.0 * np.pi / period,
        "duration": turns * period,
        "solver.step": step,
        "output.step": step,
    }


def _moordyn_input(radius: float) -> str:
    """MoorDyn's file with the fairlead on top of a wheel of this radius [m]."""
    text = (FOLDER / "moordyn.txt").read_text("utf-8")
    if FILE_POINT not in text:
        raise ValueError(f"moordyn.txt: expected the fairlead as {FILE_POINT!r}")
    return text.replace(FILE_POINT, f"2 Coupled 0.0 0.0 {0.3 + radius:.6g} ")


def _row(each: Comparison) -> Row:
    return {
        "period [s]": each.period,
        "radius [m]": each.radius,
        "measured [N]": each.measured,
        "static balance [N]": each.catenary,
        "MoorDyn [N]": each.moordyn,
    }


def _remarks(found: list[Comparison]) -> list[str]:
    """Errors over all, and those of the slowest and the fastest period."""
    dynamic = np.array([each.error_of_moordyn() for each in found])
    mean = np.abs(dynamic).mean()
    remarks = [f"MoorDyn: {mean:.1%} in the mean, {np.abs(dynamic).max():.1%} at most"]
    for period in sorted({each.period for each in found}):
        errors = [each.error_of_catenary() for each in found if each.period == period]
        remarks.append(f"static balance at {period:g} s: {min(errors):+.1%} to {max(errors):+.1%}")
    return remarks


def _page_table(found: list[Comparison]) -> str:
    """Periods as rows, radii as columns: the measured tension, both errors in per cent."""
    radii = sorted({each.radius for each in found})
    head = ("period", *(f"{radius:g} m" for radius in radii))
    rows = []
    for period in sorted({each.period for each in found}):
        row = [each for each in found if each.period == period]
        rows.append((f"{period:g} s", *(_cell(each) for each in row)))
    static = (f"{static_maximum(radius):.1f}" for radius in radii)
    return page_table(head, [("static balance [N], any period", *static), *rows])


def _cell(each: Comparison) -> str:
    static = 100.0 * each.error_of_catenary()
    dynamic = 100.0 * each.error_of_moordyn()
    return f"{each.measured:g} N: {static:+.0f} %, {dynamic:+.1f} %"


def _picture(found: list[Comparison]) -> Figure:
    """Tensions over the period on the left, errors on the right, a colour per radius."""
    figure = Figure((11.0, 4.6), dpi=100, layout="constrained")
    tensions, errors = figure.subplots(1, 2)
    radii = sorted({each.radius for each in found})
    for radius, colour in zip(radii, COLOURS, strict=True):
        _draw(tensions, errors, [each for each in found if each.radius == radius], colour)
    tensions.set(xlabel="period [s]", ylabel="largest tension [N]", ylim=(0.0, None))
    errors.set(xlabel="period [s]", ylabel="error, of the measured tension [%]")
    errors.axhline(0.0, color="0.5", linewidth=0.8)
    for axis in (tensions, errors):
        axis.grid(alpha=0.3)
        axis.spines[["top", "right"]].set_visible(False)
    tensions.plot([], [], "ok", label="measured")
    tensions.plot([], [], "--k", label="static balance")
    tensions.plot([], [], "-k", label="MoorDyn")
    tensions.legend(loc="lower left", ncols=2, fontsize="small", frameon=False)
    return figure


def _draw(tensions: Axes, errors: Axes, row: list[Comparison], colour: str) -> None:
    """One radius in both axes."""
    periods = [each.period for each in row]
    label = f"radius {row[0].radius:g} m"
    tensions.plot(periods, [each.measured for each in row], "o", color=colour, label=label)
    tensions.plot(periods, [each.catenary for each in row], "--", color=colour)
    tensions.plot(periods, [each.moordyn for each in row], "-", color=colour)
    errors.plot(periods, [100.0 * each.error_of_catenary() for each in row], "--", color=colour)
    errors.plot(periods, [100.0 * each.error_of_moordyn() for each in row], "-", color=colour)
