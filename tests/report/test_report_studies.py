"""Reports of studies and of limits of operation."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from browser import opened
from reading import ends, number, rows, tables
from report_pages import HOSTILE, Page

from hydrosim.report.page import html, ticks
from hydrosim.report.sentences.limits import limits_document
from hydrosim.report.sentences.study import study_document
from hydrosim.results.dataset import ResultKind, kind_of
from hydrosim.results.ledger import RELATIVE


def study(values: int = 3, seeds: int = 4, text: str = "plain") -> xr.Dataset:
    """A study of one parameter: crawl is 10 times that, +-1 over seeds; the last run failed."""
    count = values * seeds
    value = np.repeat(np.arange(values, dtype=float), seeds)
    off = np.where(np.arange(count) % 2, 1.0, -1.0)
    plan = {"design": "grid", "samples": None, "parameters": {"slip": ["slip"]}}
    crawl = 10.0 * value + off
    crawl[-1] = np.nan
    return xr.Dataset(
        {
            "status": ("run", ["complete"] * (count - 1) + ["failed"]),
            "status_message": ("run", [""] * (count - 1) + [text]),
            "warnings": ("run", [text] * count),
            "crawl": ("run", crawl, {"units": "m"}),
            "energy_residual_relative": ("run", np.full(count, 1e-7)),
        },
        {"slip": ("run", value, {"units": "N s/m"}), "seed": ("run", np.arange(count) % seeds)},
        {"title": text, "design": json.dumps({"plans": {"": plan}, "figures": ["crawl"]})},
    )


def limits(text: str = "heave") -> xr.Dataset:
    over = ("stage", "swell", "heading", "peak_period")
    limit = np.array([0.8, 0.9]).reshape(1, 1, 1, 2)
    return xr.Dataset(
        {
            "limit": (over, limit),
            "low": (over, limit - 0.1),
            "high": (over, np.array([0.9, np.inf]).reshape(1, 1, 1, 2)),
            "governing": (over, np.array([text, ""]).reshape(1, 1, 1, 2)),
        },
        {"stage": ["all"], "swell": ["none"], "heading": [0.5], "peak_period": [6.0, 9.0]},
        {"title": text, "criteria": text, "probability": 0.9, "seeds": 10, "runs": 40}
        | {"lowest": 0.5, "highest": 3.0, "apart": 0.1},
    )


def test_a_study_shows_means_with_their_intervals() -> None:
    page = Page(html(study_document(study()), "mark"))
    values = [float(str(of["value"])) for tag, of in page.elements if tag == "data"]
    assert {0.0, 10.0}.issubset(values)
    assert page.count("circle") == 3
    assert "failed: plain (run 11)" in page.texts["li"]
    assert "plain (12 of 12 runs)" in page.texts["p"]
    assert "crawl at 1: 10" not in page.texts["title"]
    assert "crawl: 10 (" in page.texts["title"]
    assert "90 % interval" in page.texts["th"]


def test_points_stand_where_their_numbers_are() -> None:
    page = Page(html(study_document(study()), "mark"))
    circles = [of for tag, of in page.elements if tag == "circle"]
    x, y = (np.array([float(str(of[key])) for of in circles]) for key in ("cx", "cy"))
    np.testing.assert_allclose(np.diff(x, 2), 0.0, atol=0.02)  # slip is 0, 1, 2
    third = np.mean([1.0, -1.0, -1.0])  # of the runs that are complete
    assert (y[2] - y[1]) / (y[1] - y[0]) == pytest.approx((10.0 + third) / 10.0, abs=1e-3)


def test_many_runs_fit() -> None:
    assert len(html(study_document(study(10, 100)), "mark")) < 300_000


def test_hostile_texts_are_texts() -> None:
    for one in (study_document(study(text=HOSTILE)), limits_document(limits(HOSTILE))):
        page = Page(html(one, "mark"))
        assert page.count("script") == 2
        assert page.count("img") == 0
        assert HOSTILE in page.texts["h1"]


def test_limits_are_shown_with_what_they_are_worth_in_the_weather() -> None:
    season = {"season": ["year", "May"]}
    found = limits().assign(
        scatter_workable=0.8,
        scatter_outside=0.1,
        hindcast_outside=0.05,
        **{
            f"hindcast_{name}": ("season", [0.3, 0.6])
            for name in ("workable", "startable", "never")
        },
        waiting=(("season", "quantile"), [[3600.0, np.inf], [0.0, 7200.0]], {"window": 21600.0}),
    )
    found = found.assign_coords(season)
    page = Page(html(limits_document(found), "mark"))
    assert "80 % is workable" in page.texts["p"]
    assert "10 % is outside peak periods of 6 to 9 s" in page.texts["p"]
    assert "5 % of the time has no limit" in page.texts["p"]
    assert "Windows of 6 h" in page.texts["caption"]
    assert "yearMay" in page.texts["th"]
    nodes = limits_document(found).nodes
    year, may = rows(nodes, "season")
    assert number(year["workable"], "share") == 0.3
    assert number(may["workable"], "share") == 0.6
    assert number(year["waiting P50"], "h") == 1.0
    assert year["P90"] == "beyond the record"
    assert number(may["P90"], "h") == 2.0


def test_limits_are_shown_with_what_governs() -> None:
    assert kind_of(limits()) == ResultKind.OPERABILITY
    assert kind_of(study()) != ResultKind.OPERABILITY
    page = Page(html(limits_document(limits()), "mark"))
    assert page.count("circle") == 2
    first, last = rows(limits_document(limits()).nodes, "stage")
    assert ends(first["interval"], "m") == pytest.approx((0.7, 0.9))
    assert ends(last["interval"], "m") == pytest.approx((0.8, np.inf))
    assert (first["governed by"], last["governed by"]) == ("heave", "")
    assert "0.8 or more" in page.texts["td"]
    assert "governed by heave" in page.texts["title"]


def test_limits_show_their_case() -> None:
    case = "bodies: {barge: {mass: 1000.0, heading: 0.0, dofs: [heave]}}"
    document = limits_document(limits().assign_attrs(case_resolved=case))
    (bodies,) = tables(document.nodes, "body")
    assert bodies.rows[0][0] == "barge, mass"
    assert "body [t] " in " ".join(str(document).split())
    assert "barge, mass 1 " in " ".join(str(document).split())
    assert "does not hold its case" in Page(html(limits_document(limits()), "mark")).texts["p"]


def test_limits_by_spectra_have_no_seeds_and_no_intervals() -> None:
    sampled = Page(html(limits_document(limits().assign_attrs(runs=40)), "mark"))
    assert "seeds" in sampled.texts["th"]
    page = Page(html(limits_document(limits().assign_attrs(runs=0)), "mark"))
    assert "seeds" not in page.texts["th"]
    assert "none, without runs" in page.texts["td"]
    assert "0.700 to 0.900" not in page.texts["td"]


def test_a_study_without_a_plan_says_so() -> None:
    bare = study().drop_attrs()
    assert "does not say its plan" in Page(html(study_document(bare), "mark")).texts["p"]


def test_runs_without_a_plan_and_without_seeds_tell_their_errors() -> None:
    """Those of `simulate_many`, of unlike scenes: there is no one seed of each."""
    bare = study().drop_attrs().drop_vars("seed", errors="ignore")
    measured = bare.assign({RELATIVE: ("run", np.full(bare.sizes["run"], 1e-3))})
    page = Page(html(study_document(measured), "mark"))
    assert "error of motions, of their range" in page.texts["th"]


def test_ticks_are_round() -> None:
    np.testing.assert_allclose(ticks(0.7, 3.1), [1.0, 1.5, 2.0, 2.5, 3.0])


@pytest.mark.browser
def test_pages_of_studies_are_shown_without_complaint(tmp_path: Path) -> None:
    for document in (study_document(study(text=HOSTILE)), limits_document(limits(HOSTILE))):
        path = tmp_path / "page.html"
        path.write_text(html(document, "mark"), "utf-8")
        with opened(path) as (page, said, asked):
            assert [said, asked] == [[], []]
            assert page.evaluate("window.hacked") is None
            assert page.locator("svg circle").first.is_visible()
