"""Reports of comparisons: of a run with a recording, and of two sets of runs."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from browser import COLOURS, opened, until
from command_line import command
from recorded_runs import made_run
from report_pages import HOSTILE, Page, chart, data_of

from hydrosim.compare import compare
from hydrosim.compare.dataset import studies_dataset, to_dataset
from hydrosim.compare.studies import compare_studies
from hydrosim.errors import InputError
from hydrosim.files.recordings import read_recording
from hydrosim.report.document import report_of
from hydrosim.report.page import html
from hydrosim.report.sentences.comparison import (
    COMPARISON_SECTIONS,
    comparison_document,
    studies_document,
)
from hydrosim.report.sentences.comparison import STUDY_COMPARISON_SECTIONS as OF_STUDIES

FILES = {"title": "A barge", "run": "ours.nc", "recording": "test.nc"}


def of_runs(folder: Path, said: dict[str, str] = FILES) -> xr.Dataset:
    """A run against itself 0.05 m further in surge, and with 1.1 times the normal force."""
    run, other = made_run(duration=320.0), made_run(duration=320.0)
    other.position.loc[{"dof": "surge"}] += 0.05
    other["fender_normal_force"] = 1.1 * other.fender_normal_force
    other.to_netcdf(folder / "test.nc")
    found = compare(run, read_recording(folder / "test.nc"))
    return to_dataset(found, said, {"position.barge.surge": 0.01, "position.barge.sway": 0.01})


def of_studies(paired: bool = True, said: dict[str, str] = FILES) -> xr.Dataset:
    """Twelve runs against the same with 0.5 m more crawl, and a channel that is chance."""
    random = np.random.default_rng(2)
    crawl, chance = random.normal(2.0, 0.1, (2, 12))
    seeds = {"seed": ("run", np.arange(12))} if paired else {}
    ours, theirs = (
        xr.Dataset(
            {
                "crawl": ("run", crawl + more + random.normal(0.0, 0.01, 12), {"units": "m"}),
                "tilt": ("run", chance + random.normal(0.0, 0.1, 12), {"units": "rad"}),
                "same": ("run", crawl),
            },
            seeds,
        )
        for more in (0.5, 0.0)
    )
    return studies_dataset(compare_studies(ours, theirs), said)


def test_a_run_and_a_recording_lie_over_one_another(tmp_path: Path) -> None:
    found = of_runs(tmp_path)
    page = html(comparison_document(found), "mark")
    said = Page(page).texts
    assert "ours.nc and test.nc" in said["h1"]
    assert "offset 0.05 m" in said["td"]
    assert "gain 1.1" in said["td"]
    assert "1 of 2 channels are out of tolerance" in said["p"]
    assert "position.barge.surge: " in said["p"]
    lines = chart(data_of(page), "position.barge.surge: offset 0.05 m")
    np.testing.assert_allclose(lines["recorded"] - lines["ours"], 0.05, atol=1e-6)
    apart = chart(data_of(page), "position.barge.surge: difference")
    np.testing.assert_allclose(apart["ours less recorded"], -0.05, atol=1e-6)


def test_figures_are_those_of_the_file(tmp_path: Path) -> None:
    found = of_runs(tmp_path)
    page = Page(html(comparison_document(found), "mark"))
    shown = [float(str(of["value"])) for tag, of in page.elements if tag == "data"]
    for one in (found.isel(channel=k) for k in range(found.sizes["channel"])):
        for name in ("rms", "peak", "mean", "drift"):
            assert float(one[name]) in shown, (str(one.channel.values), name)


@pytest.mark.parametrize("paired", [True, False])
def test_studies_say_what_is_more_than_chance(paired: bool) -> None:
    found = of_studies(paired)
    page = Page(html(studies_document(found), "mark"))
    assert f"1 of 3 channels differ by more than chance; {int(paired)} are equal" in page.texts["p"]
    assert ("Student's t" if paired else "Welch's t") in page.texts["p"]
    assert page.count("circle") == 24
    assert page.count("figure") == 1
    shown = [float(str(of["value"])) for tag, of in page.elements if tag == "data"]
    assert float(found.difference[0]) in shown
    assert float(found.difference[0]) == pytest.approx(0.5, abs=0.02)


def test_hostile_texts_are_texts(tmp_path: Path) -> None:
    said = dict.fromkeys(FILES, HOSTILE)
    runs, studies = of_runs(tmp_path, said), of_studies(said=said)
    names = [f"{k} {HOSTILE}" for k in range(runs.sizes["channel"])]
    runs = runs.assign_coords(channel=names).assign_attrs(unused=HOSTILE, compared=HOSTILE)
    for one in (comparison_document(runs), studies_document(studies)):
        page = Page(html(one, "mark"))
        assert (page.count("script"), page.count("img")) == (2, 0)
        assert HOSTILE in page.texts["h1"]


def test_files_of_other_kinds_are_refused_in_words(tmp_path: Path) -> None:
    xr.Dataset({"a": 1.0}).to_netcdf(tmp_path / "a.nc")
    (tmp_path / "b.nc").write_text("text")
    for name, why in (("a.nc", "is netCDF without"), ("b.nc", "cannot be read"), ("c.nc", "no su")):
        with pytest.raises(InputError, match=f"{why}.*`hydrosim run`, `study` or"):
            report_of(tmp_path / name)


def test_the_command_writes_what_report_reads(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    hydrosim = command(monkeypatch, capsys)
    monkeypatch.chdir(tmp_path)
    for name in ("ours.nc", "other.nc"):
        made_run(duration=60.0).to_netcdf(name)
        shared = {"status": ("run", ["complete"] * 4), "x": ("run", [1.0, 2.0, 4.0, 3.0])}
        xr.Dataset(shared, {"seed": ("run", range(4))}).to_netcdf(f"many_{name}")
    for one in ("ours", "many_ours"):
        other = one.replace("ours", "other")
        assert hydrosim("compare", f"{one}.nc", f"{other}.nc").code == 0
        assert hydrosim("report", f"{one}_compare.nc").code == 0
        assert f"{one}.nc and {other}.nc" in Path(f"{one}_compare_report.html").read_text()
        assert hydrosim("compare", f"{one}.nc", f"{other}.nc", "-o", f"{one}.nc").code == 2


@pytest.mark.browser
def test_pages_are_shown_without_complaint(tmp_path: Path) -> None:
    said = dict.fromkeys(FILES, HOSTILE)
    runs, studies = of_runs(tmp_path, said), of_studies(said=said)
    for document, parts in (
        (comparison_document(runs), COMPARISON_SECTIONS),
        (studies_document(studies), OF_STUDIES),
    ):
        path = tmp_path / "page.html"
        path.write_text(html(document, "mark"), "utf-8")
        with opened(path) as (page, console, asked):
            assert [console, asked] == [[], []]
            assert page.evaluate("window.hacked") is None
            ids = page.eval_on_selector_all("section", "all => all.map((one) => one.id)")
            assert ids == list(parts)
            for canvas in page.locator("details[open] > canvas[data-chart]").all()[:3]:
                assert until(page, lambda canvas=canvas: canvas.evaluate(COLOURS) > 8)
