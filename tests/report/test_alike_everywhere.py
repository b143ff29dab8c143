"""Numbers on the terminal, on a page, in a table and beside the axes of a picture are the numbers
of the result, in the units that the case wrote."""

import csv
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from command_line import command
from matplotlib.figure import Figure
from recorded_runs import made_run

from hydrosim.dofs import DOFS
from hydrosim.files.display_units import as_attribute
from hydrosim.report.charts.pictures import figure as picture_of
from hydrosim.report.document import run_document as report_of
from hydrosim.report.page import html
from hydrosim.report.sentences.run import run_document
from hydrosim.results.dataset import read_run, write_run

Shown = tuple[str, float]
"""A unit, and the SI of one of it. Both are written here a second time."""
CASES: list[tuple[dict[str, str], dict[str, Shown]]] = [
    (
        {"N": "tonne_force", "m": "mm", "rad": "deg"},
        {"N": ("tf", 9810.0), "m": ("mm", 1e-3), "rad": ("deg", np.pi / 180.0)},
    ),
    ({"N": "kN", "m": "m"}, {"N": ("kN", 1e3), "m": ("m", 1.0), "rad": ("deg", np.pi / 180.0)}),
    ({"N": "MN", "rad": "rad"}, {"N": ("MN", 1e6), "m": ("m", 1.0), "rad": ("rad", 1.0)}),
]
IN_CELL = re.compile(r"<(?:th|td)[^>]*>(?:<data[^>]*>)?([^<]*)")


@pytest.fixture(params=CASES, ids=["tf, mm, deg", "kN, m", "MN, rad"])
def asked(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> tuple[xr.Dataset, Mapping[str, Shown]]:
    """A run, read from its file, and the units that its case wrote."""
    monkeypatch.chdir(tmp_path)
    writes, shown = request.param
    run = made_run().assign_attrs(as_attribute(writes))
    run["fender_slip_distance"] = (("time", "fender"), np.abs(run.fender_compression.values))
    write_run(run, Path("run.nc"))
    return read_run(Path("run.nc")), shown


def unit_of(dof: str) -> str:
    return "m" if dof in DOFS[:3] else "rad"


def positions(run: xr.Dataset) -> Iterator[tuple[str, np.ndarray]]:
    """The name and the values of each motion in SI."""
    for dof in DOFS:
        yield dof, run.position.sel(body="barge", dof=dof).values


def agrees(text: str, si: float, of: Shown) -> None:
    """The number in a text is that in SI, but for its last digit."""
    number = text.replace(",", "").replace("−", "-")
    half = 0.5 * 10.0 ** -len(number.partition(".")[2])
    assert abs(float(number) - si / of[1]) <= half * (1.0 + 1e-9)


def test_the_terminal(asked: tuple[xr.Dataset, Mapping[str, Shown]]) -> None:
    run, shown = asked
    lines = str(run_document(run)).splitlines()
    for dof, x in positions(run):
        unit = shown[unit_of(dof)]
        start = f"barge {dof} [{unit[0]}]"
        (line,) = [each for each in lines if each.startswith(start)]
        texts = line.removeprefix(start).split()
        figures = (x.mean(), x.std(), x.min(), x.max(), x[-1])
        for text, figure in zip(texts, figures, strict=True):
            agrees(text, float(figure), unit)


def test_a_page(asked: tuple[xr.Dataset, Mapping[str, Shown]]) -> None:
    """Standard deviations and ends of motions, and largest forces, in its tables."""
    run, shown = asked
    page = html(report_of(run), "hydrosim 0: report of [run.nc]")
    rows = [IN_CELL.findall(row) for row in re.findall(r"<tr>(.*?)</tr>", page, re.DOTALL)]
    heads = {"motion": slice(1, 6), "channel": slice(5, 7)}
    read_back = 0
    for dof, x in positions(run):
        unit = shown[unit_of(dof)]
        ends = [float(x.min()), float(x.max())]
        expected = {"motion": [x.mean(), x.std(), *ends, x[-1]], "channel": ends}
        name = f"barge {dof} [{unit[0]}]"
        for head, cells in with_heads(rows):
            if cells[0] == name and head in heads and len(cells) >= 6:
                for text, figure in zip(cells[heads[head]], expected[head], strict=True):
                    agrees(text, float(figure), unit)
                    read_back += 1
    assert read_back == 6 * (5 + 2)


def with_heads(rows: list[list[str]]) -> Iterator[tuple[str, list[str]]]:
    """Rows with the first cell of the head of their table, those that give a mean."""
    head = ""
    for cells in rows:
        if "mean" in cells:
            head = cells[0]
        elif not cells[0].startswith("barge"):
            head = ""
        if head and cells[0] != head:
            yield head, cells


def test_a_table(
    asked: tuple[xr.Dataset, Mapping[str, Shown]],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    run, shown = asked
    export = command(monkeypatch, capsys, "export")
    assert export("run.nc", "-o", "run.csv").code == 0
    with Path("run.csv").open(newline="", encoding="utf-8") as file:
        _, names, units, *rows = csv.reader(file)
    column = names.index
    forces = [(f"interface {k}", run.fender_normal_force.values[:, k - 1]) for k in (1, 2)]
    each = [(f"position.barge.{dof}", unit_of(dof), x) for dof, x in positions(run)]
    each += [(f"fender_normal_force.{name}", "N", x) for name, x in forces]
    for name, unit, x in each:
        assert units[column(name)] == shown[unit][0]
        for k in (0, 700, 3000):
            read_back = float(rows[k][column(name)])
            assert read_back == pytest.approx(x[k] / shown[unit][1], rel=1e-14)


def lines_at(figure: Figure, label: str) -> np.ndarray:
    """Smallest and largest value drawn on axes of a label."""
    axes = [axis for axis in figure.axes if axis.get_ylabel() == label]
    assert axes, f"{label}: {[axis.get_ylabel() for axis in figure.axes]}"
    drawn = [np.asarray(line.get_ydata(), float) for axis in axes for line in axis.get_lines()]
    return np.array([min(np.nanmin(y) for y in drawn), max(np.nanmax(y) for y in drawn)])


def test_a_picture(asked: tuple[xr.Dataset, Mapping[str, Shown]]) -> None:
    """Lines go through the smallest and largest values, in the unit of the label."""
    run, shown = asked
    motions = picture_of(run, "motions")
    for dof, x in positions(run):
        unit, one = shown[unit_of(dof)]
        found = lines_at(motions, f"{dof} [{unit}]")
        np.testing.assert_allclose(found, [x.min() / one, x.max() / one], rtol=1e-12)
    unit, one = shown["N"]
    force = run.fender_normal_force.values
    found = lines_at(
        picture_of(run.drop_dims("fender").assign(spring_of(force)), "tensions"),
        f"tension [{unit}]",
    )
    np.testing.assert_allclose(found, [force.min() / one, force.max() / one], rtol=1e-12)


def spring_of(force: np.ndarray) -> dict[str, tuple[tuple[str, str], np.ndarray]]:
    """Tensions of two lines (nt, 2)."""
    return {"spring_tension": (("time", "spring"), force), "spring": (("spring",), ["a", "b"])}  # type: ignore[dict-item]
