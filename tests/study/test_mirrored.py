"""Limits to the other side of symmetric scenes; stages as criteria; tables of alpha factors that
begin above the limits; what the picture shows."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from scenes import CASES

from hydrosim.report.charts.studies import draw_limit_chart
from hydrosim.report.sentences.limits import distinct_lines, limit_chart, limits_tables
from hydrosim.scene import Scene
from hydrosim.statistics.figures import ScalarResult
from hydrosim.statistics.results import MotionCauseResult, StageResult
from hydrosim.statistics.weather import image_of, without_images
from hydrosim.study.operability import Trials, limits_of, load_limits
from hydrosim.study.seas import Swell, add_mirrored_limits
from hydrosim.study.weather import assess_weather, read_weather

REMOVAL = CASES.parent / "topside_removal" / "removal.yaml"
SWAY = "{channel: position.barge.sway, statistic: largest_absolute, limit: 0.5 m}"
FREE = f"""
case: free.yaml
duration: 1860 s
criteria:
  aside: {SWAY}
operability:
  heights: {{from: 0.2 m, to: 3 m, apart: 0.1 m}}
  peak_periods: [8 s, 12 s]
  headings: [%s]
"""


def limits(folder: Path, headings: str, more: str = "") -> xr.Dataset:
    """Of the barge that floats free, from response spectra."""
    (folder / "free.yaml").write_text(
        f"extends: {CASES}/free_floating.yaml\n"
        "bodies: {barge: {wave_forces: {first_order: true, second_order: none}}}\n"
        "solver: {kinematics: linear}\n"
    )
    path = folder / "limits.yaml"
    path.write_text(FREE % headings + more)
    study = load_limits(path)
    found = limits_of(study, 1)
    return assess_weather(found, read_weather(folder, study.wanted))


def test_limits_to_the_other_side_are_those_that_are_computed_there(tmp_path: Path) -> None:
    """The image of 60 deg is what a study of 300 deg finds, to the last digit."""
    found = limits(tmp_path, "0 deg, 60 deg")
    assert np.degrees(found.heading.values).round(9).tolist() == [0.0, 60.0, 300.0]
    (tmp_path / "there").mkdir()
    there = limits(tmp_path / "there", "300 deg")
    computed = there.limit.sel(heading=there.heading[-1])
    assert np.array_equal(found.limit.isel(heading=2), computed)
    assert np.isfinite(computed).all()
    assert "symmetric about the x axis" in found.attrs["mirror"]
    assert without_images(found).sizes["heading"] == 2
    assert image_of(float(found.heading[1]), found) == float(found.heading[2])
    text = str(limits_tables(found))
    assert "to 60 and 300 deg" in " ".join(text.split())


def known(headings: Sequence[float]) -> xr.Dataset:
    """Limits of two peak periods, by heading [rad]."""
    over = ("stage", "swell", "heading", "peak_period")
    size = (1, 1, len(headings), 2)
    limit = np.arange(2.0 * len(headings)).reshape(size) / 4.0 + 0.5
    data = {name: (over, limit.copy()) for name in ("limit", "low", "high")}
    data |= {name: (over, np.ones(size, int)) for name in ("inferred", "otherwise")}
    data["runs"] = (over[1:], np.ones(size[1:], int))
    data["governing"] = (over, np.full(size, "a"))
    coords = {"stage": ["all"], "swell": ["none"], "heading": headings, "peak_period": [6.0, 8.0]}
    attributes = {"lowest": 0.5, "highest": 9.0, "apart": 0.5, "runs": 8, "probability": 0.9}
    return xr.Dataset(data, coords, attributes)


@pytest.fixture(scope="module")
def removal() -> Scene:
    from hydrosim.case.load import load_case

    return load_case(REMOVAL).scene()


@pytest.mark.parametrize(
    ("asked", "swells", "mirrored"),
    [
        (StageResult("a", "recontact_force", "legs"), [None], True),
        (ScalarResult("a", "position.barge.roll", "largest_absolute"), [None], True),
        (ScalarResult("a", "position.barge.surge", "largest"), [None], True),
        (ScalarResult("a", "position.barge.roll", "largest"), [None], False),
        (ScalarResult("a", "fender_normal_force.interface 1", "largest"), [None], False),
        (MotionCauseResult("a", "displacement", direction="sway", body="barge"), [None], False),
        (StageResult("a", "recontacts", "legs"), [None, Swell(1.0, 14.0, np.pi)], True),
        (StageResult("a", "recontacts", "legs"), [None, Swell(1.0, 14.0, 1.0)], False),
    ],
)
def test_what_tells_the_sides_apart_is_not_mirrored(
    removal: Scene, asked: ScalarResult, swells: list[Swell | None], mirrored: bool
) -> None:
    found = add_mirrored_limits(known([0.0, 1.0]), removal, [asked], swells)
    assert found.sizes["heading"] == (3 if mirrored else 2)
    assert ("not mirrored" in found.attrs["mirror"]) != mirrored
    if mirrored:
        assert found.limit.values[0, 0, 2].tolist() == found.limit.values[0, 0, 1].tolist()
        assert int(found.runs.sum()) == 4


def test_a_scene_that_is_not_its_own_image_is_not_mirrored(removal: Scene) -> None:
    barge, topside = removal.bodies
    products = np.zeros((3, 3))
    products[0, 1] = products[1, 0] = 1e9
    lopsided = replace(barge, inertia=barge.inertia + products)
    scene = replace(removal, bodies=(lopsided, topside))
    asked = StageResult("a", "recontact_force", "legs")
    found = add_mirrored_limits(known([0.0, 1.0]), scene, [asked], [None])
    assert found.sizes["heading"] == 2
    assert "products of inertia of barge" in found.attrs["mirror"]


def test_headings_on_both_sides_need_no_image(removal: Scene) -> None:
    asked = StageResult("a", "recontact_force", "legs")
    for headings in ([0.0], [0.0, np.pi], [-1.0, 0.0, 1.0], [1.0, 2.0 * np.pi - 1.0]):
        found = add_mirrored_limits(known(headings), removal, [asked], [None])
        assert found.identical(known(headings))


HINDCAST = """
  hindcast: hindcast.csv
  bearing: 0 deg
  operation:
    planned: 1 hour
    alpha: {source: a table, planned: [12 hour], heights: [%s m, 9 m], factors: [[0.5, 0.5]]}
"""


@pytest.mark.parametrize(("first", "below"), [(0.1, 0.0), (5.0, 1.0)])
def test_a_table_of_factors_above_the_limits_is_what_is_blamed(
    tmp_path: Path, first: float, below: float
) -> None:
    """Waves from all sides between headings 45 deg apart: nothing lacks a heading."""
    rows = [f"{k}, 0.1, 10, {15 * k}" for k in range(24)]
    text = "\n".join(["time [h], hs, tp, direction [deg]", *rows])
    (tmp_path / "hindcast.csv").write_text(text)
    headings = ", ".join(f"{45 * k} deg" for k in range(5))
    found = limits(tmp_path, headings, HINDCAST % first)
    assert float(found.hindcast_outside) == 0.0
    assert float(found.get("hindcast_below_alpha", 0.0)) == pytest.approx(below)
    said = " ".join(str(limits_tables(found)).split())
    assert ("The alpha table begins at 5 m" in said) == bool(below)
    assert ("below the alpha table" in said) == bool(below)
    assert "Add peak periods" not in said


LATE = f"""
case: {REMOVAL}
seeds: 1-29
criteria:
  impact: {{result: recontact_force, group: legs, limit: 5 MN}}
  off: {{result: time, stage: separated, group: legs, limit: 1 hour}}
  clear: {{result: end_clearance, group: legs, limit: 10 cm}}
  slow: {{channel: speed.barge, statistic: largest, limit: 1 mm/s, side: at least}}
operability:
  heights: {{from: 0.5 m, to: 2 m, apart: 0.5 m}}
  peak_periods: [8 s]
"""


def test_stages_are_criteria(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No impact holds its limit; a stage that never comes does not; clearance is a least one."""
    path = tmp_path / "limits.yaml"
    path.write_text(LATE)
    study = load_limits(path)
    assert study.least == (False, False, True, True)
    assert [study.units[name] for name in ("impact", "off", "clear")] == ["N", "s", "m"]
    never = np.nan
    values = np.array([[never, never, 0.2, 0.1], [6e6, 3e3, 0.0, 0.0], [4e6, 4e3, 0.2, 0.1]])
    held = study.limits_hold(values, np.array([True, True, True]))
    assert held.tolist() == [
        [True, False, True, True],
        [False, True, False, False],
        [True, False, True, True],
    ]

    def found(self: Trials, scenes: Sequence[Scene]) -> tuple[np.ndarray, np.ndarray]:
        heights = np.array([s.environment.waves[0].spectrum.significant_height for s in scenes])
        self.count += len(scenes)
        each = [4e6 * heights, 0.0 * heights, 1.0 + heights, heights]
        return np.stack(each, axis=1), np.ones(len(scenes), bool)

    monkeypatch.setattr(Trials, "values", found)
    result = limits_of(study, 1).squeeze()
    assert float(result.limit) == 1.0
    assert str(result.governing.values) == "impact"
    assert "clear: end clearance of legs at least 0.1 m" in result.attrs["criteria"]


def test_the_picture_has_no_limit_where_there_is_none() -> None:
    """Lines end there, a mark is at the first or the last height; what coincides is one line."""
    found = known([0.0, 1.0, 2.0]).sel(stage="all")
    found.limit[0, 2] = found.limit[0, 1]
    for name in ("low", "high"):
        found[name].values[:] = found.limit.values
    found.limit[0, 0, 0] = 0.0
    found.limit[0, 0, 1] = 9.0
    names = [name for name, _ in distinct_lines(found)]
    assert names == ["to 0 deg", "to 57.2958 deg; to 114.592 deg"]
    figure = Figure()
    FigureCanvasAgg(figure)
    axis = figure.subplots()
    draw_limit_chart(axis, limit_chart(found), ["a"])
    drawn = [np.asarray(line.get_ydata(), float) for line in axis.lines]
    assert min(np.nanmin(y) for y in drawn if y.size and np.isfinite(y).any()) == 0.5
    below, above = ([line for line in axis.lines if line.get_marker() == mark] for mark in "v^")
    assert [float(y) for line in below for y in line.get_ydata()] == [0.5]
    assert [float(y) for line in above for y in line.get_ydata()] == [9.0]
