"""Pictures of studies show the means that the tables have."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from hydrosim.errors import InputError
from hydrosim.files.display_units import as_attribute
from hydrosim.files.document_layout import value_text
from hydrosim.files.outputs import Output
from hydrosim.report.charts.studies import ValueNames, draw_study, page
from hydrosim.statistics import effects


def runs_of(design: str, values: dict[str, list[object]], y: list[float]) -> xr.Dataset:
    """Runs of one plan with the parameters a and b."""
    plan = {"design": design, "samples": len(y) // 4, "parameters": {"a": ["a"], "b": ["b"]}}
    if "b" not in values:
        del plan["parameters"]["b"]  # type: ignore[attr-defined]
    runs = xr.Dataset({"y": ("run", y, {"units": "m"})}, attrs={"title": "known"})
    runs.attrs["design"] = json.dumps({"plans": {"": plan}, "figures": ["y"], "limits": {}})
    return runs.assign_coords({name: ("run", x) for name, x in values.items()})


def test_a_band_goes_through_the_means() -> None:
    runs = runs_of("grid", {"a": [1.0, 1.0, 1000.0, 1000.0]}, [1.0, 3.0, 5.0, 5.0])
    (axis,) = page(effects.plans(runs)[0]).axes
    x, y = axis.containers[0].lines[0].get_data()  # type: ignore[attr-defined]
    assert list(x) == [1.0, 1000.0]
    assert list(y) == [2.0, 5.0]
    assert axis.get_xscale() == "log"


def test_parameters_and_figures_are_drawn_as_the_case_writes_them() -> None:
    """2 and 4 deg, 1 and 3 mm; rad and m in the file."""
    runs = runs_of("grid", {"a": [0.0349065850, 0.0698131701]}, [0.001, 0.003])
    runs["a"].attrs["units"] = "rad"
    runs = runs.assign_attrs(as_attribute({"m": "mm"}))
    (axis,) = page(effects.plans(runs)[0]).axes
    x, y = axis.containers[0].lines[0].get_data()  # type: ignore[attr-defined]
    assert list(x) == pytest.approx([2.0, 4.0], rel=1e-8)
    assert list(y) == pytest.approx([1.0, 3.0], rel=1e-12)
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("a [deg]", "y [mm]")


def test_many_figures_stand_beside_each_other() -> None:
    runs = runs_of("grid", {"a": [1.0, 1.0, 2.0, 2.0]}, [1.0, 3.0, 5.0, 5.0])
    names = ["y", *(f"y_{k}" for k in range(8))]
    runs = runs.assign(dict.fromkeys(names, runs.y))
    design = json.loads(runs.attrs["design"]) | {"figures": names}
    figure = page(effects.plans(runs.assign_attrs(design=json.dumps(design)))[0])
    assert [axis.get_ylabel() for axis in figure.axes[:2]] == ["y [m]", "y 0 [m]"]
    width, height = figure.get_size_inches()
    assert width > height
    assert len(figure.legends) == 1


def test_values_of_many_decades_have_ticks_of_their_own() -> None:
    runs = runs_of("grid", {"a": [0.0, 1e3, 1e7]}, [1.0, 3.0, 5.0])
    figure = page(effects.plans(runs)[0])
    figure.canvas.draw()
    assert [tick.get_text() for tick in figure.axes[0].get_xticklabels()] == [
        "0",
        "1000",
        "10,000,000",
    ]


def test_a_figure_without_any_value_says_so() -> None:
    runs = runs_of("grid", {"a": [1.0, 2.0]}, [np.nan, np.nan])
    (axis,) = page(effects.plans(runs)[0]).axes
    assert [text.get_text() for text in axis.texts] == ["no run has a value"]


def test_a_heat_map_writes_the_means() -> None:
    runs = runs_of("grid", {"a": [1.0, 1.0, 2.0, 2.0], "b": [5.0, 6.0, 5.0, 6.0]}, [1, 2, 3, 4])
    axis = page(effects.plans(runs)[0]).axes[0]
    assert np.array(axis.images[0].get_array()).tolist() == [[1, 3], [2, 4]]
    assert sorted(text.get_text() for text in axis.texts) == ["1", "2", "3", "4"]


def test_the_widest_bar_of_a_tornado_is_on_top() -> None:
    values = {"a": [1.0, 0.0, 2.0, 1.0], "b": [5.0, 5.0, 5.0, 9.0], "varied": ["", "a", "a", "b"]}
    runs = runs_of("one_at_a_time", values, [10.0, 8.0, 13.0, 11.0])
    (axis,) = page(effects.plans(runs)[0]).axes
    assert [label.get_text() for label in axis.get_yticklabels()] == ["b", "a"]
    assert [(bar.get_x(), bar.get_width()) for bar in axis.patches] == [(10.0, 1.0), (8.0, 5.0)]


def test_a_parameter_of_which_no_run_has_a_value_is_still_named() -> None:
    values = {"a": [1.0, 0.0, 2.0, 1.0], "b": [5.0, 5.0, 5.0, 9.0], "varied": ["", "a", "a", "b"]}
    runs = runs_of("one_at_a_time", values, [10.0, 8.0, 13.0, np.nan])
    (axis,) = page(effects.plans(runs)[0]).axes
    assert [label.get_text() for label in axis.get_yticklabels()] == ["b", "a"]
    assert axis.texts[0].get_text() == " no run has a value"


def test_seeds_alone_are_points_about_their_mean() -> None:
    runs = runs_of("grid", {"seed": [3, 4, 5]}, [1.0, 2.0, 6.0])
    del (design := json.loads(runs.attrs["design"]))["plans"][""]["parameters"]["a"]
    runs.attrs["design"] = json.dumps(design)
    (axis,) = page(effects.plans(runs)[0]).axes
    assert axis.lines[0].get_ydata()[0] == 3.0  # type: ignore[index]
    assert axis.lines[1].get_xydata().tolist() == [[3.0, 1.0], [4.0, 2.0], [5.0, 6.0]]  # type: ignore[attr-defined]
    assert axis.get_xlabel() == "seed"


def test_numbers_of_a_heat_map_stand_out_and_what_is_missing_is_said() -> None:
    values = {"a": [1.0, 1.0, 2.0, 2.0], "b": [5.0, 6.0, 5.0, 6.0]}
    axis = page(effects.plans(runs_of("grid", values, [1, 2, 3, np.nan]))[0]).axes[0]
    colours = {text.get_text(): text.get_color() for text in axis.texts}
    assert colours == {"1": "white", "2": "white", "3": "black", "no value": "black"}


@pytest.mark.parametrize(("design", "panels"), [("sobol", 2), ("sobol_indices", 1)])
def test_samples_and_indices(tmp_path: Path, design: str, panels: int) -> None:
    random = np.random.default_rng(1)
    a, b = random.random((2, 64))
    runs = runs_of(design, {"a": list(a), "b": list(b)}, list(a + 0.1 * b))
    assert len(page(effects.plans(runs)[0]).axes) == panels
    (path,) = draw_study(runs, Output(tmp_path / "runs.nc", "picture", tmp_path / "runs.nc"))
    assert path == tmp_path / "runs.png"


def test_nothing_to_draw(tmp_path: Path) -> None:
    runs = runs_of("grid", {"a": [1.0]}, [1.0]).drop_vars("y")
    with pytest.raises(InputError, match="no figures to draw"):
        draw_study(runs, Output(tmp_path / "runs.nc", "picture", tmp_path / "runs.nc"))


SEAS = [json.dumps([{"spectrum": "jonswap", "peak_period": period}]) for period in (6, 12, 8)]


def key_of(figure: Figure) -> list[str]:
    """What the letters of a picture mean, without breaks of lines."""
    texts = (text.get_text() for legend in figure.legends for text in legend.get_texts())
    return [text.replace("\n", " ") for text in texts if ": " in text]


def test_lists_are_letters_with_a_key_and_no_line_joins_them() -> None:
    values = {"a": [SEAS[0], SEAS[0], SEAS[1], SEAS[1], SEAS[2], SEAS[2]]}
    figure = page(effects.plans(runs_of("grid", values, [1, 3, 6, 8, 2, 4]))[0])
    (axis,) = figure.axes
    assert [label.get_text() for label in axis.get_xticklabels()] == ["A", "B", "C"]
    assert key_of(figure) == [
        "A: spectrum jonswap, peak_period 6",
        "B: spectrum jonswap, peak_period 12",
        "C: spectrum jonswap, peak_period 8",
    ]
    means = axis.containers[1].lines[0]  # type: ignore[attr-defined]
    assert means.get_linestyle() == "None"
    assert list(means.get_ydata()) == [2.0, 7.0, 3.0]
    assert len(axis.patches) == 3  # bars of 90 % of the seeds
    assert len(axis.collections) == 1  # bars of errors, and no band between values


def test_short_words_stand_beside_the_axis_as_they_are() -> None:
    figure = page(effects.plans(runs_of("grid", {"a": ["chain", "rope"]}, [1.0, 3.0]))[0])
    assert [label.get_text() for label in figure.axes[0].get_xticklabels()] == ["chain", "rope"]
    assert key_of(figure) == []


def test_a_line_joins_numbers() -> None:
    (axis,) = page(effects.plans(runs_of("grid", {"a": [1.0, 2.0]}, [1.0, 3.0]))[0]).axes
    assert axis.containers[0].lines[0].get_linestyle() == "-"  # type: ignore[attr-defined]


def test_letters_are_the_same_in_all_panels_and_on_both_axes() -> None:
    values = {"a": [SEAS[0], SEAS[1]] * 2, "b": [SEAS[2]] * 2 + [SEAS[0]] * 2}
    figure = page(effects.plans(runs_of("grid", values, [1, 2, 3, 4]))[0])
    axis = figure.axes[0]
    assert [label.get_text() for label in axis.get_xticklabels()] == ["A", "B"]
    assert [label.get_text() for label in axis.get_yticklabels()] == ["C", "A"]
    assert len(key_of(figure)) == 3


def test_the_ends_of_a_tornado_are_letters_where_they_are_long() -> None:
    values = {"a": SEAS, "varied": ["", "a", "a"]}
    figure = page(effects.plans(runs_of("one_at_a_time", values, [1.0, 2.0, 3.0]))[0])
    assert [text.get_text().strip() for text in figure.axes[0].texts] == ["A", "B"]
    assert key_of(figure)[0] == "A: spectrum jonswap, peak_period 12"


def test_a_long_title_is_within_the_picture() -> None:
    runs = runs_of("grid", {"a": [1.0, 2.0]}, [1.0, 3.0])
    figure = page(effects.plans(runs.assign_attrs(title="a long title of a study " * 8))[0])
    assert figure._suptitle is not None
    box = figure._suptitle.get_window_extent(figure.canvas.get_renderer())  # type: ignore[attr-defined]
    assert 0.0 <= box.x0
    assert box.x1 <= figure.bbox.width


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (2.0, "2"),
        ("true", "true"),
        ("[]", "none"),
        ("[1, 2.5]", "1; 2.5"),
        ('[["1 m", 2], ["3 m", 4]]', "1 m, 2; 3 m, 4"),
        ('{"a": [1, "x"]}', "a 1; x"),
        ("{not a table}", "{not a table}"),
    ],
)
def test_values_in_words(value: object, text: str) -> None:
    assert value_text(value) == text


def test_letters_go_on_after_z() -> None:
    names = ValueNames().names_of([f"a value of many letters, {k}" for k in range(28)])
    assert [names[0], names[25], names[26], names[27]] == ["A", "Z", "AA", "AB"]
