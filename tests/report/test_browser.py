"""Pages of reports in a real browser: nothing of a case runs, nothing is loaded, all is drawn."""

from pathlib import Path

import pytest
import xarray as xr
from browser import COLOURS, opened, until
from recorded_runs import made_run
from report_pages import HOSTILE, hostile_run

from hydrosim.report.document import RUN_SECTIONS, run_document
from hydrosim.report.page import html

pytestmark = pytest.mark.browser


def written(folder: Path, run: xr.Dataset) -> Path:
    path = folder / "page.html"
    path.write_text(html(run_document(run), "hydrosim 0: report of [run.nc]"), "utf-8")
    return path


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_report_is_drawn_without_a_network(tmp_path: Path, scheme: str) -> None:
    with opened(written(tmp_path, made_run()), color_scheme=scheme) as (page, said, asked):
        assert (said, asked) == ([], [])
        ids = page.eval_on_selector_all("section", "all => all.map((one) => one.id)")
        # there is no case that could be drawn
        drawn = [name for name in RUN_SECTIONS if name != "arrangement"]
        assert ids == ["", *drawn]
        charts = page.locator("details[open] > canvas[data-chart]").all()
        assert len(charts) >= 4
        for chart in charts:
            assert until(page, lambda chart=chart: chart.evaluate(COLOURS) > 8)


def test_charts_follow_keys_and_legends(tmp_path: Path) -> None:
    with opened(written(tmp_path, made_run())) as (page, said, _):
        canvas = page.locator("canvas[data-chart]").first
        canvas.focus()
        legend = page.locator(".chart .legend").first
        for key, read in (("ArrowRight", "at 306 s"), ("+", ""), ("ArrowRight", "at 309 s")):
            canvas.press(key)
            assert until(page, lambda read=read: read in legend.inner_text())
        assert " to " not in legend.inner_text()  # every record is drawn
        assert " m" in legend.inner_text()
        canvas.press("0")
        page.locator(".chart .legend button").first.click()
        assert page.locator(".chart .legend button").first.get_attribute("aria-pressed") == "false"
        assert until(page, lambda: canvas.evaluate(COLOURS) > 8)
        assert said == []


def test_a_telephone_shows_all_without_scrolling_aside(tmp_path: Path) -> None:
    small = {"width": 390, "height": 800}
    with opened(written(tmp_path, made_run()), viewport=small) as (page, *_):
        assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_hostile_texts_do_not_run(tmp_path: Path) -> None:
    with opened(written(tmp_path, hostile_run())) as (page, said, asked):
        for summary in page.locator("summary").all():
            summary.click()
        assert page.evaluate("window.hacked") is None
        assert (said, asked) == ([], [])
        assert page.locator("h1").text_content() == HOSTILE
        assert page.title().startswith("</script>")
