"""Pictures of runs: what is drawn, with which labels, and what is refused."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from hydrosim.dofs import DOFS
from hydrosim.errors import InputError
from hydrosim.files.display_units import as_attribute
from hydrosim.files.document_nodes import Chart, ChartLine
from hydrosim.report.charts import pictures
from hydrosim.report.charts.panels import (
    PictureFrame,
    TimeWindow,
    picture,
    thin_records,
)
from hydrosim.report.charts.pictures import Format, View, draw
from hydrosim.report.charts.pictures import figure as figure_of
from hydrosim.report.run_charts import shaded_phases
from hydrosim.results.channels import group_by_size
from hydrosim.simulation import open_run

TIME = np.linspace(0.0, 60.0, 121)
UNITS = tuple(f"[{unit}]" for unit in ("m", "deg", "kN", "MJ"))
DETAILS = ("overview", "motions", "fender_forces", "contact", "energies")


def run_of(bodies: int = 1, fenders: int = 0, waves: bool = True, nt: int = 121) -> xr.Dataset:
    """The dataset of a run as `hydrosim.results.output` describes it; motions are plain sines."""
    time = np.linspace(0.0, 60.0, nt)
    swing = np.sin(time)
    position = np.zeros((nt, bodies, 6))
    position[:, :, 0] = 2.0 * swing[:, None] * np.arange(1, bodies + 1)
    position[:, :, 4] = np.radians(3.0) * swing[:, None]
    data = {
        "position": (("time", "body", "dof"), position),
        "wave_elevation": ("time", swing if waves else np.zeros(nt)),
        "energy_kinetic": ("time", 4e6 * swing**2),
        "energy_stored_mooring": ("time", 3e6 * swing**2),
        "energy_work_wave_first_order": ("time", 5e6 * time),
        "energy_dissipated_radiation": ("time", np.zeros(nt)),
        "energy_residual": ("time", 1e-3 * time),
    }
    names = [f"barge {b}" for b in range(1, bodies + 1)]
    coordinates = {"time": time, "body": names, "dof": list(DOFS), "axis": ["x", "y", "z"]}
    if fenders:
        data.update(contact_of(time, fenders))
        coordinates["fender"] = [f"deck {i}" for i in range(1, fenders + 1)]
    return xr.Dataset(data, coordinates, {"title": "A run"})


def contact_of(time: np.ndarray, fenders: int) -> dict[str, tuple[tuple[str, ...], np.ndarray]]:
    """Fenders that are open, stick and slip for a third of the time each, and go along x."""
    each = np.repeat(np.sin(time)[:, None], fenders, axis=1) * np.arange(1, fenders + 1)
    along_x = np.zeros((*each.shape, 3))
    along_x[:, :, 0] = 2e7 * each
    mode = np.repeat((time // (time[-1] / 3.0 + 1e-9)).astype(np.int8)[:, None], fenders, axis=1)
    point = ("time", "fender")
    return {
        "fender_compression": (point, 0.1 * each),
        "fender_normal_force": (point, 4e7 * np.abs(each)),
        "fender_mode": (point, mode),
        "fender_friction": ((*point, "axis"), along_x),
        "fender_node": ((*point, "axis"), 1e-7 * along_x + [20.0, -20.0, 3.6]),
        "fender_slip_distance": (point, np.abs(each)),
        "fender_dissipated": (point, 1e5 * np.abs(each)),
    }


def figures(run: xr.Dataset) -> dict[str, Figure]:
    """The figure of each picture of a run that has panels."""
    return {name: figure_of(run, name) for name in DETAILS if getattr(pictures, name)(run)}


def chart_of(lines: dict[str, np.ndarray], unit: str = "N", modes: bool = False) -> Chart:
    """A chart of a force or of modes."""
    return Chart("Force", "force", unit, {n: ChartLine(y) for n, y in lines.items()}, modes=modes)


def labels(figure: Figure) -> list[str]:
    return [axis.get_ylabel() for axis in figure.axes]


def legend(figure: Figure, panel: int) -> list[str]:
    return [text.get_text() for text in figure.axes[panel].get_legend().get_texts()]


@pytest.mark.parametrize(
    ("run", "expected"),
    [
        (run_of(), ["", "_energies", "_motions"]),
        (run_of(fenders=4), ["", "_contact", "_energies", "_forces", "_motions"]),
        (run_of(bodies=2, fenders=1, nt=2), ["", "_contact", "_energies", "_forces", "_motions"]),
        (run_of(waves=False), ["", "_energies", "_motions"]),
    ],
    ids=["no fender", "four fenders", "two bodies, two records", "no waves"],
)
@pytest.mark.slow
def test_pictures_are_written_there(run: xr.Dataset, expected: list[str], tmp_path: Path) -> None:
    folder = tmp_path / "new" / "folder"
    written = draw(run, folder, "case")
    assert sorted(written) == sorted(folder.iterdir())
    assert sorted(p.name for p in written) == sorted(f"case{suffix}.png" for suffix in expected)
    assert all(p.read_bytes().startswith(b"\x89PNG") for p in written)


@pytest.mark.parametrize("fenders", [0, 3])
@pytest.mark.parametrize("bodies", [1, 2])
def test_every_panel_of_lines_has_a_label_with_its_unit(bodies: int, fenders: int) -> None:
    for name, figure in figures(run_of(bodies, fenders)).items():
        for axis in figure.axes:
            if axis.get_lines():
                assert axis.get_ylabel().endswith(UNITS)
        assert figure.axes[-1].get_xlabel() == "time [s]", name


def test_only_what_moves_is_drawn() -> None:
    drawn = figures(run_of())
    assert labels(drawn["motions"]) == ["surge [m]", "pitch [deg]", "wave elevation [m]"]
    assert labels(drawn["overview"]) == ["surge [m]", "pitch [deg]", "wave elevation [m]"]
    assert labels(figures(run_of(waves=False))["motions"]) == ["surge [m]", "pitch [deg]"]


def test_a_run_at_rest_shows_all_degrees_of_freedom() -> None:
    rest = run_of(waves=False)
    rest["position"] *= 0.0
    assert [label.split()[0] for label in labels(figures(rest)["motions"])] == list(DOFS)


def test_bodies_have_a_line_each_and_alike_lines_share_one() -> None:
    drawn = figures(run_of(bodies=2))["motions"]
    assert legend(drawn, 0) == ["barge 1", "barge 2"]
    assert legend(drawn, 1) == ["barge 1, barge 2"]


def test_friction_has_panels_only_along_the_axes_where_it_acts() -> None:
    assert labels(figures(run_of(fenders=1))["fender_forces"]) == [
        "normal force [kN]",
        "friction x [kN]",
    ]


def test_the_crawl_starts_with_the_first_contact_and_keeps_still_while_open() -> None:
    run = run_of(fenders=1)
    run["fender_mode"][:] = np.where((TIME > 20.0) & (TIME < 30.0), 2, 0)[:, None]
    crawl = next(a for a in figures(run)["contact"].axes if a.get_ylabel() == "crawl x [m]")
    time, values = crawl.get_lines()[0].get_data()
    assert np.isnan(values[time <= 20.0]).all()
    assert values[-1] == pytest.approx(2.0 * np.sin(29.5))


def test_bands_share_their_height_as_the_modes_share_the_time() -> None:
    modes = np.repeat([0, 1, 2, 1], 40)
    chart = chart_of({"deck 1": modes}, modes=True)
    figure = picture([chart], PictureFrame(np.arange(160.0)))
    assert legend(figure, 0) == ["slip", "stick", "open"]
    steps = (patch.get_data() for patch in figure.axes[0].patches)
    area = {
        name: np.sum((top - base) * np.diff(edges)) / (0.8 * 159.0)
        for name, (top, edges, base) in zip(["slip", "stick", "open"], steps, strict=True)
    }
    # one record in 159 may fall to either side of a border
    assert area == pytest.approx({"slip": 0.25, "stick": 0.5, "open": 0.25}, abs=1 / 159)


def test_thinning_keeps_the_ends_and_every_crest() -> None:
    time = np.linspace(0.0, 1000.0, 100_001)
    values = np.sin(time) * time
    t, v = thin_records(time, values)
    assert t.size < 2000
    assert (t[0], t[-1]) == (time[0], time[-1])
    assert np.all(np.diff(t) > 0.0)
    assert (v.min(), v.max()) == (values.min(), values.max())
    assert np.array_equal(v, np.sin(t) * t)


@pytest.mark.parametrize(
    ("writes", "expected"),
    [
        ({}, {"surge [m]": 2.0, "pitch [deg]": 3.0, "normal force [kN]": 80e3}),
        ({}, {"kinetic energy [MJ]": 4.0}),
        ({"m": "mm", "rad": "rad"}, {"surge [mm]": 2e3, "pitch [rad]": np.radians(3.0)}),
        ({"N": "tonne_force"}, {"normal force [tf]": 8e7 / 9810.0}),
        ({"N": "N"}, {"normal force [N]": 8e7}),
    ],
)
def test_the_unit_is_the_one_that_the_case_writes(
    writes: dict[str, str], expected: dict[str, float]
) -> None:
    run = run_of(fenders=2).assign_attrs(as_attribute(writes))
    axes = [axis for figure in figures(run).values() for axis in figure.axes]
    for label, largest in expected.items():
        drawn = [axis.get_lines() for axis in axes if axis.get_ylabel() == label]
        found = max(np.max(line.get_ydata()) for each in drawn for line in each)
        assert found == pytest.approx(largest, rel=1e-2)  # the records miss the crest by 0.3 %


def test_the_same_unit_is_drawn_whatever_the_size() -> None:
    for size in (0.0, 40.0, 4e7):
        figure = picture([chart_of({"": size * np.sin(TIME)})], PictureFrame(TIME))
        assert labels(figure) == ["force [kN]"]


@pytest.mark.parametrize("differ", [0.0, 1.0], ids=["alike", "different"])
def test_thirty_lines_leave_the_panel_its_room(differ: float) -> None:
    many = {f"contact point {i}": TIME + differ * i for i in range(30)}
    figure = picture([chart_of(many)], PictureFrame(TIME))
    figure.canvas.draw()
    place = figure.axes[0].get_position()
    assert place.width > 0.3
    assert place.height > 0.4


def test_the_title_says_when_a_run_is_not_complete() -> None:
    run = run_of().assign_attrs(status="interrupted")
    assert figure_of(run).get_suptitle() == "A run (interrupted)"


def test_long_runs_are_bands_with_their_mean_and_say_so() -> None:
    """A sine of 12.566 s and amplitude 1: the band is from -1 to 1, the mean about 0."""
    time = np.linspace(0.0, 40_000.0, 160_001)
    figure = picture([chart_of({"": np.sin(0.5 * time)}, "m")], PictureFrame(time))
    (band,) = figure.axes[0].collections
    ends = band.get_paths()[0].get_extents()
    assert (ends.y0, ends.y1) == pytest.approx((-1.0, 1.0), abs=1e-3)
    assert np.abs(figure.axes[0].get_lines()[0].get_ydata()[:-1]).max() < 0.1
    run = run_of(nt=30_001).assign_attrs(
        case_resolved="environment: {waves: [{spectrum: jonswap}]}"
    )
    remarks = figure_of(run).axes[0].get_title("left")
    assert remarks.startswith("jonswap; bands: smallest to largest of each 0.076 s")


def test_of_many_lines_each_group_has_one() -> None:
    """From the least to the largest of four contacts, whose forces are as 1 to 4; and the mean."""
    run = run_of(fenders=8)
    groups = ("fender", np.repeat(["legs", "deck"], 4))
    run = run.assign_coords(fender_group=groups)
    axis = next(a for a in figures(run)["overview"].axes if "normal force" in a.get_ylabel())
    assert [text.get_text() for text in axis.get_legend().get_texts()] == [
        "legs, 4 contacts",
        "deck, 4 contacts",
    ]
    ends = axis.collections[0].get_paths()[0].get_extents()
    mean = axis.get_lines()[0].get_ydata()
    swing = np.abs(np.sin(TIME)).max()
    assert (ends.y0, ends.y1) == pytest.approx((0.0, 160e3 * swing))
    assert mean.max() == pytest.approx(100e3 * swing)


def test_contacts_have_their_normal_force_and_friction_beside_each_other() -> None:
    axes = figures(run_of(fenders=3))["fender_forces"].axes
    assert [axis.get_ylabel() for axis in axes] == ["normal force [kN]", "friction x [kN]"] * 3
    assert len({axis.get_ylim() for axis in axes[::2]}) == 1
    assert [axis.texts[0].get_text() for axis in axes[::2]] == ["deck 1", "deck 2", "deck 3"]


def test_a_part_of_the_time_is_drawn_as_the_whole_has_it() -> None:
    """The crawl counts from the start of the run, not of the part."""
    run = run_of(fenders=1)
    for name in ("motions", "contact"):
        part = figure_of(run, name, TimeWindow(30.0, 40.0))
        for drawn, whole in zip(part.axes, figure_of(run, name).axes, strict=True):
            for one, other in zip(drawn.get_lines(), whole.get_lines(), strict=True):
                inside = (TIME >= 30.0) & (TIME <= 40.0)
                assert np.array_equal(one.get_xdata(), TIME[inside])
                assert np.array_equal(one.get_ydata(), other.get_ydata()[inside])


def test_phases_are_those_of_the_group_that_begins_free() -> None:
    phase = np.zeros((121, 2), int)
    phase[:, 0] = 2  # in contact from the start
    phase[20:, 1], phase[100:, 1] = 1, 3
    names = ["legs", "deck"]
    run = run_of().assign_coords(contact_group=names)
    run["contact_phase"] = (("time", "contact_group"), phase)
    found, words = shaded_phases(run)
    assert words == "phases of deck: moored to 10 s, initial contact to 50 s, then stuck"
    assert found == [("moored", 0.0, 10.0), ("initial contact", 10.0, 50.0), ("stuck", 50.0, 60.0)]
    assert figure_of(run).axes[0].get_title("left") == (
        "phases of deck: moored to 10 s, initial contact to 50 s, then stuck"
    )


def test_contacts_that_do_not_end_stuck_have_no_phases() -> None:
    """Those of a quay, and one that begins closed."""
    phase = np.zeros((121, 2), int)
    phase[:, 0] = 3
    phase[20:, 1] = 2
    run = run_of().assign_coords(contact_group=["keel", "quay"])
    run["contact_phase"] = (("time", "contact_group"), phase)
    assert shaded_phases(run) == ([], "")


def test_lines_have_tensions_one_each_and_capacities() -> None:
    run = run_with_tensions([1e5, 2e5])
    run = run.assign_coords(spring_capacity=("spring", [np.nan, 5e5]))
    axes = figure_of(run, "tensions").axes
    assert [axis.get_ylabel() for axis in axes] == ["tension [kN]", "tension [kN]", "utilisation"]
    assert np.array_equal(axes[2].get_lines()[0].get_ydata(), run.spring_tension[:, 1] / 5e5)


@pytest.mark.parametrize(
    ("form", "start"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")]
)
def test_channels_by_name_in_a_format(form: str, start: bytes, tmp_path: Path) -> None:
    run, names = run_of(bodies=2), ["position.barge 1.surge", "position.barge 1.pitch"]
    run.position.attrs["dof_units"] = "m, m, m, rad, rad, rad"
    view = View(TimeWindow(10.0, 20.0), names, Format(form))
    (path,) = draw(run, tmp_path, "case", view=view)
    assert path.name == f"case_channels.{form}"
    assert path.read_bytes().startswith(start)
    axes = picture(pictures.channels(run, names), PictureFrame(TIME)).axes
    assert [axis.get_ylabel() for axis in axes] == ["position [m]", "position [deg]"]
    assert draw(run, tmp_path, "case", view=view) == [path]  # it is known as an earlier one


def test_a_time_without_records_is_refused(tmp_path: Path) -> None:
    said = "found 70 to 80 s, with fewer than two recorded times of the run; .* part of 0 to 60 s"
    with pytest.raises(InputError, match=said):
        draw(run_of(), tmp_path, "case", view=View(TimeWindow(70.0, 80.0)))


def test_open_run_reads_what_output_writes(tmp_path: Path) -> None:
    path = tmp_path / "run.nc"
    run_of(fenders=2).to_netcdf(path)
    assert open_run(path).identical(run_of(fenders=2))


def test_open_run_refuses_what_is_not_a_run(tmp_path: Path) -> None:
    text, other, short = (tmp_path / name for name in ("text.nc", "other.nc", "short.nc"))
    text.write_text("not netCDF")
    xr.Dataset({"added_mass": ("frequency", np.ones(3))}).to_netcdf(other)
    run_of().isel(time=slice(1)).to_netcdf(short)
    for path, reason in {
        tmp_path / "missing.nc": "no such file",
        tmp_path: "is a directory",
        text: "cannot be read as netCDF",
        other: "is netCDF without position",
        short: "fewer than two recorded times",
    }.items():
        with pytest.raises(InputError, match=reason) as error:
            open_run(path)
        assert str(path) in str(error.value)
        assert "expected the result of `hydrosim run`" in str(error.value)


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="the folder cannot be made"):
        draw(run_of(), tmp_path / "file" / "folder", "case")


def run_with_tensions(sizes: list[float]) -> xr.Dataset:
    run = run_of().assign_coords(spring=[f"line {k}" for k in range(len(sizes))])
    tension = np.outer(2.0 + np.sin(TIME), sizes)
    return run.assign(spring_tension=(("time", "spring"), tension))


def test_small_tensions_have_an_axis_of_their_own() -> None:
    """40 kN beside 1.8 MN would be a line at zero; 1.5 MN shares the axis of 1.8 MN, as does
    400 kN."""
    run = run_with_tensions([4e4, 1.8e6, 1.5e6])
    small, large, other = figure_of(run, "tensions").axes
    assert small.get_ylim()[1] < 200.0
    assert large.get_ylim() == other.get_ylim()
    together = figure_of(run).axes[-2:]
    counts = [len(axis.get_lines()) for axis in together]
    assert counts == [2, 1]
    assert together[1].get_ylim()[1] < 200.0
    axes = figure_of(run_with_tensions([4e5, 1.8e6, 1.5e6]), "tensions").axes
    assert len({axis.get_ylim() for axis in axes}) == 1


def test_groups_of_similar_size() -> None:
    each = {"a": np.array([1.0]), "b": np.array([-100.0]), "zero": np.zeros(1), "c": np.array([30])}
    assert [list(group) for group in group_by_size(each)] == [["b", "c"], ["a", "zero"]]
    assert group_by_size({}) == []


def test_a_long_title_wraps() -> None:
    run = run_of().assign_attrs(title="a long title of a case " * 10)
    figure = figure_of(run)
    box = figure._suptitle.get_window_extent(figure.canvas.get_renderer())
    assert 0.0 <= box.x0
    assert box.x1 <= figure.bbox.width
