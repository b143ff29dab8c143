"""Writes the tables of README.md from those of the studies, and draws lock_in.png.

python cases/lock_in/studies/page.py, after hydrosim study of the five files
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.figure import Figure

import hydrosim as hs

HERE = Path(__file__).parent
PAGE = HERE.parent / "README.md"
MARK = re.compile(r"<!-- lock-in: (\w+) -->\n.*?<!-- end -->", re.S)
CASES = {
    "friction alone": "base",
    "pin": "pins",
    "clamp": "clamp",
    "ratchet": "ratchet",
    "lines": "lines",
}
HOLDS = {"friction alone": "the fenders, friction alone", "lines": "both lines"}
ZERO = 1e-6  # of all units of `LABELS`
COLOURS = ("black", "#0072B2", "#56B4E9", "#E69F00", "#009E73")
LABELS = {
    "crawl": "surge at the end [m]",
    "crawl_absolute": "distance from the place at rest [m]",
    "in_contact": "surge in contact [m]",
    "largest_surge": "largest surge [m]",
    "closed": "pins that close",
    "lock_load": "largest load of the lock [MN]",
    "lock_mean": "mean load of the lock [MN]",
    "closing_impulse": "sum of closing impulses [MN s]",
    "loss": "energy lost in closing [MJ]",
    "line_tension": "largest tension of a line [MN]",
    "line_compression": "largest compression of a line [MN]",
    "tension": "largest tension of a line [MN]",
    "least": "smallest tension of a line [MN]",
    "compression": "largest compression of a line [MN]",
    "interface": "largest fender force in surge [MN]",
    "fender_normal": "largest normal force of a fender [MN]",
    "stick": "share of stick in contact",
}


def table(name: str) -> pd.DataFrame:
    """The table of a study: a row for each figure of each value."""
    return pd.read_csv(HERE / f"{name}.csv", comment="#")


def texts(rows: pd.DataFrame) -> dict[str, str]:
    """Mean and 90 % interval of each figure, in the units of `LABELS`."""
    return {row.figure: _text(row) for row in rows.itertuples()}


def _text(row: tuple) -> str:
    if not row.runs:
        return "-"
    unit = str(row.unit)
    scale = 1e-6 if unit == "N" else 1e-3 if unit.startswith("kN") else 1.0
    values = [scale * x for x in (row.mean, row.mean_low, row.mean_high)]
    if abs(values[0]) < ZERO:
        return "0"
    wide = values[2] - values[1]
    digits = 2 if wide == 0.0 else max(2, int(np.ceil(-np.log10(wide))))
    mean, low, high = (f"{x:.{digits}f}" for x in values)
    return mean if wide == 0.0 else f"{mean} ({low} to {high})"


def page_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def devices() -> str:
    """The five devices beside each other."""
    rows = table("devices")
    columns = [texts(rows[rows.device == device]) for device in CASES]
    lines = [[LABELS[name], *(column[name] for column in columns)] for name in rows.figure.unique()]
    return page_table(["", *CASES], lines)


def choices(name: str) -> str:
    """The values of a study of one device below each other."""
    rows = table(name)
    figures = list(rows.figure.unique())
    lines = [[label, *(texts(part)[figure] for figure in figures)] for label, part in _values(rows)]
    return page_table(["", *(LABELS[figure] for figure in figures)], lines)


def _values(rows: pd.DataFrame) -> Iterator[tuple[str, pd.DataFrame]]:
    """The rows of each value, with its name."""
    keys = list(rows.columns[1 : rows.columns.get_loc("figure")])
    named = rows[keys].apply(_name, axis=1)
    for label in named.unique():
        yield label, rows[named == label]


def _name(values: pd.Series) -> str:
    """What is varied, and its value."""
    given = values.dropna()
    key, _, unit = given.index[0].partition(" [")
    return f"{key.rpartition('.')[2]} {given.iloc[0]} {unit.rstrip(']')}".strip()


TABLES = {
    name: lambda name=name: choices(name) for name in ("pin", "ratchet", "lines", "catenaries")
}
TABLES["devices"] = devices


def with_tables(text: str) -> str:
    """The text of the page with its tables made anew."""
    return MARK.sub(
        lambda found: f"<!-- lock-in: {found[1]} -->\n{TABLES[found[1]]()}\n<!-- end -->", text
    )


def load_of(run: xr.Dataset) -> np.ndarray:
    """What the device bears in surge [MN]; of friction alone, the fenders."""
    if "joint_force" in run:
        return 1e-6 * run.joint_force.sel(dof="surge").values[:, 0]
    if "strut_force" in run:
        return 1e-6 * run.strut_force.values.sum(axis=1)
    return 1e-6 * run.force_interface.sel(dof="surge").values[:, 0]


def draw(runs: dict[str, xr.Dataset]) -> Figure:
    """Surge, and loads of the devices, over time."""
    figure = Figure(figsize=(10, 11), layout="constrained")
    axes = figure.subplots(1 + len(runs), 1, sharex=True, height_ratios=[3, *[1] * len(runs)])
    for (name, run), colour, below in zip(runs.items(), COLOURS, axes[1:], strict=True):
        surge = run.position.sel(dof="surge").values[:, 0]
        axes[0].plot(run.time, surge, color=colour, label=name, lw=1.2)
        below.plot(run.time, load_of(run), color=colour, lw=0.5)
        below.set(ylabel="[MN]", ylim=(-10, 10))
        below.set_title(
            f"force of {HOLDS.get(name, f'the {name}')} in surge", fontsize=9, loc="left"
        )
    axes[0].set(ylabel="surge [m]")
    axes[0].legend(ncols=len(runs), frameon=False)
    axes[-1].set(xlabel="time [s]", xlim=(400, 2000))
    for each in axes:
        each.grid(alpha=0.3)
        each.spines[["top", "right"]].set_visible(False)
    return figure


def main() -> None:
    """Tables of the page, and its picture."""
    PAGE.write_text(with_tables(PAGE.read_text()))
    runs = {
        name: hs.simulate(hs.load_case(HERE.parent / f"{case}.yaml"))
        for name, case in CASES.items()
    }
    draw(runs).savefig(HERE.parent / "lock_in.png", dpi=90)


if __name__ == "__main__":
    main()
