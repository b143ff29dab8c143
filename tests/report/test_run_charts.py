"""A chart of a run is the same on a page and in a picture: lines, units and colours."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from recorded_runs import made_run
from report_pages import chart, data_of

from hydrosim.dofs import DOFS
from hydrosim.elements.kind import Topic
from hydrosim.files.display_units import as_attribute, units_of
from hydrosim.files.document import Document
from hydrosim.files.document_nodes import Chart, ChartLine
from hydrosim.report import run_charts
from hydrosim.report.charts.panels import STYLES, PictureFrame, picture
from hydrosim.report.document import run_document
from hydrosim.report.page import html


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    """A short run of one body on contacts, of a case that writes tonnes of force."""
    return made_run(duration=60.0).assign_attrs(as_attribute({"N": "tonne_force"}))


def test_every_chart_of_the_overview_is_open_on_the_page(run: xr.Dataset) -> None:
    drawn = data_of(html(run_document(run), "mark"))["charts"]
    titles = [each["title"] for each in drawn]
    overview = run_charts.charts_about(run, Topic.MOTIONS, Topic.CLEARANCES)
    assert len(overview) > 3
    assert [title for title in titles if title in {each.title for each in overview}] == [
        each.title for each in overview
    ]


def test_a_picture_has_the_lines_of_the_page(run: xr.Dataset) -> None:
    data = data_of(html(run_document(run), "mark"))
    units = units_of(run.attrs)
    for each in run_charts.charts_named(run, ("motions", "wave_elevation", "crawl")):
        (axis,) = picture([each], PictureFrame(run.time.values, units)).axes
        shown = units.display_unit(each.unit)
        assert axis.get_ylabel().endswith(f"[{shown.unit}]")
        on_page = chart(data, each.title)
        for line, name in zip(axis.get_lines(), on_page, strict=False):
            known = np.isfinite(on_page[name])
            ends = shown.factor * np.array([on_page[name][known].min(), on_page[name][known].max()])
            values = np.asarray(line.get_ydata(), float)
            assert [np.nanmin(values), np.nanmax(values)] == pytest.approx(ends, rel=1e-6)


def test_a_degree_of_freedom_keeps_its_colour_where_others_are_at_rest(run: xr.Dataset) -> None:
    still = run.copy(deep=True)
    still.position.loc[{"dof": "surge"}] = 0.0
    (displacement, *_) = run_charts.motion_charts(still)
    assert list(displacement.lines) == ["sway", "heave"]
    assert displacement.styles == [1, 2]
    (axis,) = picture([displacement], PictureFrame(run.time.values)).axes
    colours = [STYLES[k].colour for k in (1, 2)]
    assert [line.get_color() for line in axis.get_lines()] == colours


def test_charts_are_turned_to_a_chart_of_each_line() -> None:
    lines = {"surge": ChartLine(np.ones(3)), "sway": ChartLine(np.zeros(3))}
    charts = [Chart(body, "displacement", "m", lines, body) for body in ("fore", "aft")]
    surge, sway = run_charts.chart_by_line(charts)
    assert (surge.quantity, list(surge.lines), sway.peak) == ("surge", ["fore", "aft"], 0.0)
    assert [each.subject for each in run_charts.chart_each_line(charts[0])] == ["surge", "sway"]


def test_small_loads_have_a_chart_of_their_own_in_the_same_colours(run: xr.Dataset) -> None:
    tension = np.outer(np.ones(run.time.size), [1e6, 1e3])
    run = run.assign_coords(spring=["bow", "tug"]).assign(
        spring_tension=(("time", "spring"), tension)
    )
    large, small = run_charts.charts_named(run, ["spring_tension"])
    assert (list(large.lines), list(small.lines)) == (["bow"], ["tug"])
    assert (large.styles, small.styles) == ([0], [1])


def test_the_page_has_the_phases_of_pictures(run: xr.Dataset) -> None:
    phase = np.zeros((run.time.size, 1), int)
    phase[200:] = 3
    run = run.assign_coords(contact_group=["deck"])
    run["contact_phase"] = (("time", "contact_group"), phase)
    shaded, words = run_charts.shaded_phases(run)
    charts = [*run_charts.motion_charts(run)]
    document = Document("Phases", charts, time=run.time.values, phases=shaded)
    assert data_of(html(document, "mark"))["phases"] == [list(each) for each in shaded]
    assert words == "phases of deck: moored to 40 s, then stuck"
    assert [each.name for each in shaded] == ["moored", "stuck"]


def test_a_run_at_rest_has_all_its_motions(run: xr.Dataset) -> None:
    rest = run.assign(position=0.0 * run.position)
    names = [name for each in run_charts.motion_charts(rest) for name in each.lines]
    assert names == list(DOFS)
