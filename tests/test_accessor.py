"""What runs and cases show of themselves in Python, and what they can be asked."""

import os
import tomllib
from functools import partial
from html.parser import HTMLParser
from importlib import import_module
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
import xarray as xr
from command_line import printed

import hydrosim as hs
from hydrosim.files.document_nodes import Table

HOSTILE = """</td><script>alert('a&b')</script>"""
CASE = f"""
title: "{HOSTILE}"
duration: 2 s
bodies:
  block:
    mass: 1 tonne
    centre_of_gravity: [0 m, 0 m, 0 m]
    radii_of_gyration: [1 m, 1 m, 1 m]
    initial: {{velocity: [1 m/s, 0 m/s, 0 m/s, 0 deg/s, 0 deg/s, 0 deg/s]}}
    points: {{bow: [1 m, 0 m, 0 m]}}
"""


class Elements(HTMLParser):
    """The elements of a page, and its text."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags, self.text = set[str](), ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.tags.add(tag)

    def handle_data(self, data: str) -> None:
        self.text += data


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> hs.Case:
    path = tmp_path_factory.mktemp("case") / "block.yaml"
    path.write_text(CASE)
    return hs.load_case(path)


def test_texts_of_a_case_are_shown_as_they_are(case: hs.Case) -> None:
    run = hs.simulate(case).assign_attrs(warnings=HOSTILE)
    for shown in (case, run.hydrosim):
        page = Elements(shown._repr_html_())
        assert page.tags <= {"h3", "p", "br", "table", "thead", "tbody", "tr", "th", "td"}
        assert HOSTILE in page.text


def test_a_path_serves_for_a_case_and_for_a_run(case: hs.Case, tmp_path: Path) -> None:
    """As a text and as a path, with the result of the case that was read before."""
    first = hs.simulate(case)
    first.to_netcdf(tmp_path / "run.nc")
    for form in (str, Path):
        assert hs.simulate(form(case.path)).position.equals(first.position)
        assert str(hs.check(form(case.path))) == str(hs.check(case))
        assert hs.open_run(form(tmp_path / "run.nc")).position.equals(first.position)
    many = hs.simulate_many([str(case.path)], variables=["position"])
    assert many.position.isel(run=0, drop=True).values == pytest.approx(first.position.values)
    with pytest.raises(hs.InputError, match=r"nowhere\.yaml"):
        hs.simulate("nowhere.yaml")
    with pytest.raises(hs.InputError, match="expected several cases"):
        hs.simulate_many("nowhere.yaml")


def test_a_heading_is_shown_where_a_body_has_one(case: hs.Case, tmp_path: Path) -> None:
    assert "heading" not in case._repr_html_()
    turned = hs.load_case(case.path, ["bodies.block.heading=30 deg"])._repr_html_()
    assert "<td>block, heading [deg]</td><td>30</td>" in turned


def test_a_case_says_what_it_is_in_one_line(case: hs.Case) -> None:
    assert repr(case).endswith(f"block.yaml: {HOSTILE}, 2 s; bodies: block; forces: >")


def test_channels_of_a_run_have_units(case: hs.Case) -> None:
    """What is known of it: one metre a second, for two seconds."""
    run = hs.simulate(case).hydrosim
    speed = run.channel("speed.block")
    assert (speed.dims, speed.attrs["units"]) == (("time",), "m/s")
    assert speed.values == pytest.approx(np.ones(speed.size))
    assert {"position.block.surge", "speed.block"} < set(run.channels())
    bow = run.channel("point_velocity.bow of block.x")
    assert bow.values == pytest.approx(1.0)
    with pytest.raises(hs.InputError, match=r"speed\.blok"):
        run.channel("speed.blok")


def test_print_shows_the_summary_and_repr_one_line(case: hs.Case) -> None:
    run = hs.simulate(case).hydrosim
    assert str(run) == str(run.summary())
    assert "The run is complete" in str(run)
    assert repr(run) == f"<run: {HOSTILE}, complete>"


def test_a_part_of_a_run_is_told_as_a_part(case: hs.Case) -> None:
    """Cut off at either end. Energy and solver are of the whole run, and are left out."""
    run = hs.simulate(case)
    whole = run.hydrosim.summary()
    assert "The energy balance" in str(whole)
    assert any(isinstance(node, Table) and node.head[0] == "solver" for node in whole.nodes)
    assert str(run.isel(time=slice(None)).hydrosim) == str(whole)
    for some in (slice(0, 2), slice(1, None), slice(0, 0)):
        part = run.isel(time=some)
        text = str(part.hydrosim)
        assert f"a part of a run (complete): {part.time.size} records" in text
        assert "The run is complete" not in text
        assert repr(part.hydrosim) == f"<part of a run: {HOSTILE}, complete>"
        assert "The energy balance" not in text
        nodes = part.hydrosim.summary().nodes
        assert not any(isinstance(node, Table) and node.head[0] == "solver" for node in nodes)


def test_many_runs_are_told_as_a_study(case: hs.Case) -> None:
    runs = hs.simulate_many([case, case])
    assert "All 2 runs are complete." in str(runs.hydrosim)
    assert repr(runs.hydrosim).startswith("<2 runs: ")
    assert "All 2 runs are complete." in runs.hydrosim._repr_html_()
    for ask in (runs.hydrosim.channels, runs.hydrosim.statistics, runs.hydrosim.picture):
        with pytest.raises(hs.InputError, match="found 2 runs; expected one run"):
            ask()
    with pytest.raises(hs.InputError, match="run more seeds"):
        runs.hydrosim.extremes_over_seeds()
    with pytest.raises(hs.InputError, match="expected many runs"):
        hs.simulate(case).hydrosim.extremes_over_seeds()


def test_a_dataset_that_is_no_run_is_refused(tmp_path: Path) -> None:
    foreign = xr.Dataset({"a": ("x", [1.0, 2.0])}).hydrosim
    export = partial(foreign.export, tmp_path / "a.csv")
    for ask in (foreign.channels, foreign.extremes, foreign.explain, foreign.picture, export):
        with pytest.raises(hs.InputError, match="found a dataset without time, body, dof"):
            ask()


def test_decay_takes_one_recording_and_asks_for_one(tmp_path: Path) -> None:
    with pytest.raises(hs.InputError, match=r"none\.csv: there is no such file"):
        hs.decay(str(tmp_path / "none.csv"))
    with pytest.raises(hs.InputError, match="records: found none; expected recordings"):
        hs.decay([])


def test_a_study_is_no_run(case: hs.Case, tmp_path: Path) -> None:
    hs.simulate_many([case, case]).to_netcdf(tmp_path / "study.nc")
    with pytest.raises(hs.InputError, match=r"holds 2 runs, a study that xarray\.open"):
        hs.open_run(tmp_path / "study.nc")


def test_statistics_take_patterns_of_channels(case: hs.Case) -> None:
    run = hs.simulate(case).hydrosim
    assert run.statistics(0.5, ["spe*"]).equals(run.statistics(0.5, ["speed.block"]))
    with pytest.raises(hs.InputError, match=r"channels: found sped\.\*; expected"):
        run.statistics(0.5, ["sped.*"])


def test_a_run_draws_and_reports_itself(case: hs.Case, tmp_path: Path) -> None:
    run = hs.simulate(case).hydrosim
    assert len(run.picture("motions").axes) == 1
    with pytest.raises(hs.InputError, match="expected one of overview, motions, energies"):
        run.picture("contact")
    assert run.report(tmp_path / "page.html").stat().st_size > 10_000
    assert float(run.statistics(0.5).start) == 0.5
    assert run.statistics(0.5, "speed.block").equals(run.statistics(0.5, ["speed.block"]))
    for start in (1e6, float("nan"), "soon"):
        with pytest.raises(
            hs.InputError, match="expected a time in seconds well before the end of the run at 2 s"
        ):
            run.statistics(start)


def test_pictures_are_drawn_on_axes_of_others(case: hs.Case) -> None:
    plot = hs.simulate(case).hydrosim.plot
    assert {"overview", "motions", "energies"} < set(dir(plot))
    assert plot.motions().axes[0].lines
    figure, axis = plt.subplots()
    assert plot.motions(ax=axis) is figure
    assert axis.lines
    with pytest.raises(hs.InputError, match="found 2 axes; expected 1"):
        plot.motions(ax=plt.subplots(2)[1])
    (axis,) = plot.channels("speed.*").axes
    assert "speed" in axis.get_ylabel()
    assert plot.channels("speed.block", ax=figure.axes[0]) is figure
    with pytest.raises(AttributeError, match="no picture 'motion'"):
        plot.motion()
    plt.close("all")


def test_a_run_does_what_commands_do(case: hs.Case, tmp_path: Path) -> None:
    """Each method gives the text of its command, and the numbers."""
    case = hs.load_case(case.path, {"output.step": 0.1})
    run = hs.simulate(case, output=tmp_path / "run.nc")
    extremes = run.hydrosim.extremes(start="0.5 s", channels="speed.*")
    assert extremes.dataset.equals(run.hydrosim.statistics(0.5, "speed.*"))
    assert repr(extremes).startswith(HOSTILE)
    run.hydrosim.export(tmp_path / "run.csv", channels=["speed.block"])
    assert "speed.block" in (tmp_path / "run.csv").read_text()
    comparison = run.hydrosim.compare(tmp_path / "run.nc", tolerance=1e-9)
    assert not comparison.failed
    assert "identical" in repr(hs.compare(tmp_path / "run.nc", tmp_path / "run.nc", exact=True))
    again = tmp_path / "again.yaml"
    again.write_text(run.hydrosim.case())
    assert hs.simulate(again).position.equals(run.position)
    with pytest.raises(hs.InputError, match="found a run without impulse"):
        run.hydrosim.explain()
    with pytest.raises(hs.InputError, match="start: found 3 s; expected a time well before"):
        run.hydrosim.extremes(start=3.0)


ENGINE = """
import sys
import hydrosim as hs
assert "xarray" not in sys.modules
import xarray as xr
by_name = xr.open_dataset("run.nc", engine="hydrosim")
plain = xr.open_dataset("run.nc")
print(repr(by_name.hydrosim), repr(plain.hydrosim), by_name.time.dtype)
"""


def test_every_file_that_xarray_opens_has_the_methods(case: hs.Case, tmp_path: Path) -> None:
    """By an entry point of the package, that is stated here as an installation states it."""
    hs.simulate(case, output=tmp_path / "run.nc")
    points = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())
    (engine,) = points["project"]["entry-points"]["xarray.backends"].items()
    stated = tmp_path / "stated-0.dist-info"
    stated.mkdir()
    (stated / "METADATA").write_text("Metadata-Version: 2.1\nName: stated\nVersion: 0\n")
    (stated / "entry_points.txt").write_text("[xarray.backends]\n{} = {}\n".format(*engine))
    path = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    told = printed(ENGINE, folder=tmp_path, PYTHONPATH=path).split("> ")
    assert [text.startswith("<run") for text in told] == [True, True, False]
    assert told[-1].strip() == "float64"


def test_commands_that_are_folders_too_can_be_called() -> None:
    """`hs.study` is a function, also where `hydrosim.study` was imported."""
    assert callable(import_module("hydrosim.study"))
    with pytest.raises(hs.InputError, match=r"nowhere\.yaml"):
        hs.study("nowhere.yaml")
    with pytest.raises(hs.InputError, match=r"nowhere\.nc: there is no such file"):
        hs.compare("nowhere.nc", "nowhere.csv")


def test_results_are_frames_of_pandas(case: hs.Case) -> None:
    """Of channels over time, of statistics, and of many runs."""
    run = hs.simulate(case)
    frame = run.hydrosim.to_dataframe("speed.*, position.block.surge")
    assert frame.columns.tolist() == ["position.block.surge", "speed.block"]
    assert frame.attrs["units"] == {"position.block.surge": "m", "speed.block": "m/s"}
    np.testing.assert_array_equal(frame["speed.block"], run.hydrosim.channel("speed.block"))
    table = run.hydrosim.extremes().to_dataframe()
    assert table.loc["position.block.surge", "largest"] == pytest.approx(2.0)
    labels = pd.DataFrame({"name": ["slow", "fast"], "speed": [1.0, 2.0]})
    start = "bodies.block.initial.velocity"
    cases = [
        hs.load_case(case.path, {start: [speed, 0, 0, 0, 0, 0], "duration": 10.0})
        for speed in labels.speed
    ]
    figures = {"way": {"channel": "position.block.surge", "statistic": "change"}}
    runs = hs.simulate_many(
        cases, labels=labels, figures=figures, channels="speed.*", start="0.5 s"
    )
    table = runs.hydrosim.to_dataframe(statistics="mean,largest")
    assert {table.attrs["units"][name] for name in ("way", "position.block.surge mean")} == {"m"}
    assert table[["name", "speed"]].equals(labels.rename_axis("run"))
    assert table.way.tolist() == pytest.approx([9.5, 19.0])
    assert table["position.block.surge largest"].tolist() == pytest.approx([10.0, 20.0])
    assert "speed.block mean" not in table  # it does not change
    assert runs.hydrosim.extremes().to_dataframe().index.tolist() == [0, 1]
    with pytest.raises(hs.InputError, match="found 'max'; expected some of mean, std"):
        runs.hydrosim.to_dataframe(statistics="max")


def test_channels_of_many_runs_are_along_both(case: hs.Case) -> None:
    runs = hs.simulate_many([case, case])
    surge = runs.hydrosim.channel("position.block.surge")
    assert (surge.dims, surge.attrs["units"]) == (("run", "time"), "m")
    assert surge.equals(runs.position.sel(body="block", dof="surge").drop_vars(surge_labels(runs)))
    with pytest.raises(hs.InputError, match=r"these runs keep position over time.*variables"):
        runs.hydrosim.channel("speed.block")


def surge_labels(runs: xr.Dataset) -> list[str]:
    """Coordinates that one channel has not."""
    return [name for name, of in runs.coords.items() if of.dims in (("body",), ("dof",))]


def test_figures_by_name_are_checked(case: hs.Case) -> None:
    figures = {"way": {"channel": "position.block.surge", "statistic": "max"}}
    with pytest.raises(hs.InputError, match=r'^figures.way.statistic: found "max".*"largest"'):
        hs.simulate_many([case], figures=figures)


def test_runs_that_xarray_joined_are_refused_in_words(case: hs.Case) -> None:
    run = hs.simulate(case)
    joined = xr.concat([run, run], pd.Index([1.0, 2.0], name="damping"))
    with pytest.raises(hs.InputError, match=r"joined along damping; .* runs\.isel\(damping=0\)"):
        joined.hydrosim.summary()
    with pytest.raises(hs.InputError, match="joined along damping"):
        joined.hydrosim.channel("speed.block")


def test_whole_numbers_of_a_table_are_whole(case: hs.Case) -> None:
    """A row of a frame makes floats of them."""
    sea = {"spectrum": "jonswap", "significant_height": 1, "peak_period": 8, "heading": 0}
    settings = {"environment.waves": {**sea, "seed": 1}, "environment.waves.seed": 7.0}
    assert hs.load_case(case.path, settings).scene().environment.seeds == [7]


def test_pictures_that_are_not_there_are_answered_by_those_that_are(case: hs.Case) -> None:
    with pytest.raises(AttributeError, match=r"no picture 'energy'; it has contact, energies"):
        hs.simulate(case).hydrosim.plot.energy()
