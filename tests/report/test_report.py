"""The page of a report: its numbers, its texts, its size, and what it is refused for."""

from functools import partial
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import xarray as xr
from command_line import Command, refusal
from recorded_runs import made_run
from report_pages import HOSTILE, Page, chart, data_of, hostile_run

from hydrosim.files.document import Document
from hydrosim.report import document as run_report
from hydrosim.report.document import RUN_SECTIONS, run_document
from hydrosim.report.page import MAX_PAGE_BYTES, html, without_folders
from hydrosim.report.sentences import statistics
from hydrosim.results.dataset import write_run


@pytest.fixture
def report(hydrosim: Command) -> Command:
    """`hydrosim report` in an empty folder."""
    return partial(hydrosim, "report")


def page_of(run: xr.Dataset) -> str:
    return html(run_document(run), "hydrosim 0: report of [run.nc]")


def test_every_section_is_there_and_linked() -> None:
    page = Page(page_of(made_run()))
    ids = [of["id"] for tag, of in page.elements if tag == "section" and "id" in of]
    drawn = [name for name in RUN_SECTIONS if name != "arrangement"]  # no case that could be drawn
    assert ids == drawn
    links = [of["href"] for tag, of in page.elements if tag == "a"]
    assert links == [f"#{name}" for name in ids]
    assert "This run does not assess how motions, crawl and extremes change" in page.texts["p"]


@pytest.mark.parametrize(
    ("waves", "said"),
    [
        ("{spectrum: jonswap, significant_height: 1, peak_period: 8, seed: 4}", True),
        ("{spectrum: regular, amplitude: 1, period: 8}", False),
        ("{spectrum: none}", False),
    ],
)
def test_a_run_in_random_waves_says_that_it_is_one_sea(waves: str, said: bool) -> None:
    """And what to do about it. Regular waves have no other draw."""
    case = f"bodies: {{}}\nforces: {{}}\nenvironment:\n  waves:\n  - {waves}\n"
    run = made_run().assign_attrs(case_resolved=case, seeds=[4])
    text = Page(page_of(run)).texts["p"]
    assert ("one sea: one draw of random waves (seed 4)" in text) is said
    assert ("run a study with `seeds: 1-19` by `hydrosim study`" in text) is said


def test_statistics_and_scene_are_made_once(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[str] = []

    def counting(module: ModuleType, name: str) -> None:
        of = getattr(module, name)

        def counted(run: xr.Dataset) -> object:
            made.append(name)
            return of(run)

        monkeypatch.setattr(module, name, counted)

    counting(statistics, "statistics_of")
    counting(run_report, "scene_of")
    page = Page(page_of(made_run()))
    assert sorted(made) == ["scene_of", "statistics_of"]
    assert "Statistics" in page.texts["h2"]


def test_numbers_are_those_of_the_result() -> None:
    run, rng = made_run(), np.random.default_rng(5)
    data = data_of(page_of(run))
    assert data["stretch"] == 1
    for _ in range(20):
        k, dof = rng.integers(run.time.size), rng.choice(["surge", "sway", "heave"])
        shown = chart(data, "barge: displacement")[str(dof)][k]
        assert shown == np.float32(run.position.sel(dof=dof).isel(body=0, time=k))
    forces = chart(data, "Normal force of contacts")
    for i, name in enumerate(run.fender.values):
        np.testing.assert_array_equal(forces[name], run.fender_normal_force[:, i].astype("f4"))


def test_envelopes_hold_every_record() -> None:
    run = made_run(duration=1500.0)
    data = data_of(page_of(run))
    size = data["stretch"]
    assert size > 1
    low, high = chart(data, "barge: displacement")["heave"]
    heave = run.position.sel(dof="heave").values[:, 0].astype("f4")
    for k, (a, b) in enumerate(zip(low, high, strict=True)):
        part = heave[k * size : (k + 1) * size]
        assert (a, b) == (part.min(), part.max())
    assert f"of each {size} records" in Page(page_of(run)).texts["p"]


def test_values_in_tables_are_exact() -> None:
    run = made_run()
    page = Page(page_of(run))
    values = {float(str(of["value"])) for tag, of in page.elements if tag == "data"}
    assert float(run.position.sel(dof="heave").max()) in values
    mean = float(run.fender_normal_force.mean("time")[0])
    assert min(abs(value - mean) for value in values) < 1e-12 * mean  # sums in another order


def test_hostile_texts_are_texts() -> None:
    plain, text = Page(page_of(made_run(duration=60.0))), page_of(hostile_run())
    page = Page(text)
    for tag in ("script", "style", "img", "iframe", "link", "svg"):
        assert page.count(tag) == plain.count(tag)
    assert not any(key.startswith("on") for _, of in page.elements for key in of)
    assert HOSTILE in page.texts["h1"]
    assert "{{ 7 * 7 }}" in page.texts["td"]
    assert HOSTILE in page.texts["pre"].replace('\\"', '"').replace("\\\\", "\\").replace(
        "\\u2028\\u2029", "\u2028\u2029"
    )
    titles = [each["title"] for each in data_of(text)["charts"]]
    assert f"0 {HOSTILE}: displacement" in titles


def test_only_own_scripts_may_run() -> None:
    page = Page(page_of(made_run(duration=60.0)))
    policy = next(of for _, of in page.elements if "content" in of)
    assert policy["http-equiv"] == "Content-Security-Policy"
    content = str(policy["content"])
    assert content.startswith("default-src 'none'; script-src 'sha256-")
    assert "unsafe" not in content
    assert "http" not in content


def test_runs_that_failed_or_are_short_have_a_page() -> None:
    failed = made_run(duration=60.0).assign_attrs(status="failed", status_message="It sank.")
    failed.position[100:] = np.nan
    failed.velocity[100:] = 1e300
    page = Page(page_of(failed))
    assert "The run is failed after 60 s: It sank." in page.texts["p"]
    assert "too few finite records for statistics" in page.texts["p"]
    for count in (0, 1, 2):
        page = Page(page_of(made_run(duration=60.0).isel(time=slice(count))))
        assert "too few finite records" in page.texts["p"]


def test_what_a_result_lacks_is_said() -> None:
    run = made_run(duration=60.0).drop_vars("velocity")
    run["fender_mode"].attrs.clear()
    assert "This result lacks what this version of hydrosim writes" in Page(page_of(run)).texts["p"]


def test_long_runs_with_much_in_them_fit() -> None:
    run = made_run(duration=600.0)
    count = 20001
    time = xr.DataArray(0.5 * np.arange(count), dims="time", attrs={"units": "s"})
    long = run.isel(time=np.arange(count) % run.time.size).assign_coords(time=time)
    more = {f"force_{k}": long.force_mooring for k in range(40)}
    assert len(page_of(long.assign(more))) < MAX_PAGE_BYTES


def test_the_command_writes_a_page(report: Command, tmp_path: Path) -> None:
    write_run(made_run(duration=60.0), tmp_path / "made.nc")
    result = report("made.nc")
    assert (result.code, result.out) == (0, "report made_report.html, 0.1 MB")
    text = (tmp_path / "made_report.html").read_text()
    assert "report of [made.nc]" in text
    assert report("made.nc").code == 0  # its own is replaced


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("none.nc", None, "there is no such file"),
        ("empty.nc", b"", "cannot be read as netCDF"),
        ("text.nc", b"title: a case\n", "cannot be read as netCDF"),
    ],
)
def test_what_is_no_result_is_refused(
    report: Command, tmp_path: Path, name: str, content: bytes | None, said: str
) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    assert said in refusal(report, tmp_path, name)


def test_foreign_files_and_inputs_as_outputs_are_refused(report: Command, tmp_path: Path) -> None:
    xr.Dataset({"depth": ("x", np.zeros(3))}).to_netcdf(tmp_path / "foreign.nc")
    assert "is netCDF without position" in refusal(report, tmp_path, "foreign.nc")
    needed = ("position", "wave_elevation", "energy_kinetic", "energy_residual")
    alike = xr.Dataset({name: ("x", np.zeros(3)) for name in needed})
    alike.to_netcdf(tmp_path / "alike.nc")
    assert "alike.nc: has no coordinate time, body, dof" in refusal(report, tmp_path, "alike.nc")
    write_run(made_run(duration=60.0), tmp_path / "made.html.nc")
    (tmp_path / "mine.html").write_text("a page of mine")
    for output in ("mine.html", "made.html.nc"):
        refusal(report, tmp_path, "made.html.nc", "-o", output)


FOLDERS = ("/home/Jane Doe/project/", "/tmp/a.b/", "C:\\Users\\Jane\\", "C:/Users/J D/")


def run_with_paths(folder: str) -> xr.Dataset:
    """A run whose warnings, case and start name files in a ``folder``."""
    return made_run(duration=60.0).assign_attrs(
        warnings=f"{folder}barge.nc: kernel truncation: found 0.777, expected at most 0.5.",
        case=f"title: a case\nbodies:\n  barge:\n    hydrodynamics: {folder}barge.nc\n",
        case_resolved=f"bodies:\n  barge:\n    hydrodynamics: {folder}barge.nc\nforces: {{}}\n",
        case_file=f"{folder}case.yaml",
        database_barge=f"{folder}barge.nc",
    )


@pytest.mark.parametrize("folder", FOLDERS)
def test_a_page_names_files_without_folders_and_no_tests(folder: str) -> None:
    page = Page(page_of(run_with_paths(folder)))
    text = "\n".join(page.texts.values())
    assert "hydrodynamics: barge.nc" in text
    assert "barge.nc: kernel truncation: found 0.777" in text
    for part in (folder, folder.split("/")[0] or "/home/", "Jane", "Users", "tests/", "pytest"):
        assert part not in text
    attributes = [str(value) for _, of in page.elements for value in of.values()]
    assert not [value for value in attributes if folder in value]


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("started from /data/x/base.nc at 3 m/s", "started from base.nc at 3 m/s"),
        ("(/data/x/a.nc) and '/data/y z/b.nc'", "(a.nc) and 'b.nc'"),
        ("kg m²/s, N/m, 1/2/3, and/or/not", "kg m²/s, N/m, 1/2/3, and/or/not"),
        ("https://example.org/a/b", "https://example.org/a/b"),
        ("cases/sphere/decay.yaml", "cases/sphere/decay.yaml"),
        ("</script><b/>//c", "</script><b/>//c"),
    ],
)
def test_folders_of_a_text(text: str, shown: str) -> None:
    assert without_folders(text) == shown


def test_results_come_first_and_commands_last() -> None:
    case = "bodies: {}\nforces: {}\nenvironment:\n  waves:\n  - {spectrum: jonswap, seed: 4}\n"
    run = made_run().assign_attrs(
        case_resolved=case,
        seeds=[4],
        warnings="one\ntwo",
        energy_residual_relative=1e-9,
        solver_method="rk4",
    )
    nodes = run_document(run).sections
    texts = {section.heading.name: str(Document("", section.nodes)) for section in nodes}
    assert list(texts)[1] == "results"
    assert list(texts)[-1] == "computation"
    first = texts["results"]
    assert "hydrosim study" not in first
    assert "energy balance" not in first
    assert '2 warnings are under "Assumptions and warnings"' in first
    last = texts["computation"]
    for words in ("hydrosim study", "hydrosim analyse --converge", "energy balance closes", "rk4"):
        assert words in last
    assert "Conclusion" not in page_of(run)


def test_a_doubtful_solution_is_among_the_results() -> None:
    run = made_run().assign_attrs(energy_residual_relative=0.1)
    results = run_document(run).sections[1]
    assert "The energy balance closes to 0.1" in str(Document("", results.nodes))


@pytest.mark.parametrize(
    ("dim", "more"),
    [
        ("spring", {"spring_mode": 1.0}),
        ("line", {"line_grounded": 9.0}),
        ("winch", {"winch_largest_tension": 5e5, "winch_length": 30.0}),
        ("compensator", {}),
    ],
)
def test_tensions_of_every_kind_of_line_are_in_a_report(dim: str, more: dict[str, float]) -> None:
    """Unasked: a table of means and largest values, and a chart."""
    run = made_run(duration=60.0).drop_dims("fender").assign_coords({dim: ["hawser"]})
    over = ("time", dim)
    tension = 4e5 + 1e5 * np.sin(run.time.values)[:, None]
    run[f"{dim}_tension"] = (over, tension)
    for name, value in more.items():
        run[name] = (over, np.full_like(tension, value))
    text = page_of(run)
    values = [float(str(of["value"])) for tag, of in Page(text).elements if tag == "data"]
    assert min(abs(value - tension.mean()) for value in values) < 1e-9 * tension.mean()
    charts = [each for each in data_of(text)["charts"] if each["title"].startswith("Tension of")]
    assert [each["names"] for each in charts] == [["hawser"]]


def test_small_tensions_have_a_chart_of_their_own() -> None:
    run = made_run(duration=60.0).assign_coords(line=["tugger", "bow", "stern"])
    tension = np.outer(2.0 + np.sin(run.time.values), [4e4, 1.8e6, 1.5e6])
    run = run.assign(line_tension=(("time", "line"), tension))
    charts = {each["title"]: each["names"] for each in data_of(page_of(run))["charts"]}
    title = "Tension of catenaries at the fairlead"
    assert charts[title] == ["bow", "stern"]
    assert charts[f"{title}: tugger"] == ["tugger"]


def test_wide_tables_scroll_inside_the_page() -> None:
    text = page_of(made_run(duration=60.0))
    page = Page(text)
    boxes = [of for tag, of in page.elements if tag == "div" and of.get("class") == "wide"]
    assert len(boxes) == page.count("table")
    assert ".wide { overflow-x: auto; }" in text
    assert "position: sticky; left: 0;" in text
