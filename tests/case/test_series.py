"""Recorded series: what is read from text and from runs, and what is said of bad ones."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import text_tables
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal

from hydrosim import elements
from hydrosim.case import Case
from hydrosim.errors import InputError

Load = Callable[..., Case]
TIME, FX, FY = [0.0, 1.0, 2.5, 3.0, 60.0], [1.0, -2.0, 3.5, 4e3, 5.0], [0.5, 0.25, 0.0, -1.0, 2.0]


def case(push: str) -> str:
    return (
        "title: t\nduration: 60 s\nbodies:\n  block: {mass: 2, dofs: [surge]}\nforces:\n"
        f"  push: {{type: applied_force, body: block, force: {{{push}}}}}\n"
    )


def surge(file: str = "data.csv", column: str = "Fx", more: str = "") -> str:
    return case(f"surge: {{file: {file}, column: {column}{more}}}")


def record(load: Load, text: str, dof: str = "surge") -> elements.Recorded:
    signal = load(text).scene().forces["push"].force[dof]
    assert isinstance(signal, elements.Recorded)
    return signal


def rows(separator: str) -> str:
    return "\n".join(separator.join(map(str, row)) for row in zip(TIME, FX, FY, strict=True))


TEXTS = {
    "names": f"time,Fx,Fy\n{rows(',')}\n",
    "quoted names, blanks, remarks": f'# a test\n"time [s]", "Fx" , "Fy"\n\n{rows(", ")}\n#end',
    "names in the last remark": f"# model test 3, wave 7\n# t Fx Fy\n{rows('   ')}",
    "tabs": f"Model test\nTime (s)\tFx\tFy\n{rows(chr(9))}",
    "semicolons, windows": f"\ufefft;Fx;Fy\n{rows(';')}".replace("\n", "\r\n"),
    "the time in another column": "Fx Fy t\n"
    + "\n".join(f"{x} {y} {t}" for t, x, y in zip(TIME, FX, FY, strict=True)),
}


@pytest.mark.parametrize("name", TEXTS)
def test_text(load: Load, tmp_path: Path, name: str) -> None:
    (tmp_path / "data.csv").write_bytes(TEXTS[name].encode())
    signal = record(load, surge())
    assert_array_equal(signal.time, TIME)
    assert_array_equal(signal.value, FX)


def test_columns_by_number_are_added(load: Load, tmp_path: Path) -> None:
    (tmp_path / "data.csv").write_text(rows(" "))
    signal = record(load, surge(column="[2, 3]", more=", factor: -2 kN"))
    assert_allclose(signal.value, -2e3 * np.add(FX, FY), rtol=1e-15)


@pytest.mark.parametrize(
    ("factor", "size"),
    [("3", 3.0), ("1e3", 1e3), ("98.1 kN/m", 98.1e3), ("2 tonne_force/m", 19620)],
)
def test_factors(load: Load, tmp_path: Path, factor: str, size: float) -> None:
    (tmp_path / "data.csv").write_text(TEXTS["names"])
    signal = record(load, surge(more=f", factor: {factor}"))
    assert_allclose(signal.value, size * np.array(FX), rtol=1e-14)


BAD_TEXT = r"""
  0 1\n1 2\n2 3 4\n3 4 | 2 | data.csv:3: found 3 values; expected 2, as in line 1
  t,Fx\n0,1\n1,x\n | Fx | data.csv:3: found "x"; expected a number
  t;Fx\n0,5;1,5\n1;2\n | Fx | \
    data.csv:2: found "0,5"; expected a number; ";" separates columns here; write "0.5"
  t,Fx\n0,1\n1,\n | Fx | data.csv:3: found ""; expected a number
  t;Fx\n0;1,5\n | Fx | data.csv:2: found
  t,Fx\nnan,1\n1,2\n | Fx | data.csv:2: found nan; expected finite numbers
  t,Fx\n0,1\n#\n1,inf\n | Fx | data.csv:4: found inf; expected finite numbers
  t,Fx\n0,1\n2,1\n1,1\n | Fx | data.csv:4: found time 1 s after 2 s; expected it to rise
  t,Fx\n0,1\n1,1\n1,1\n | Fx | data.csv:4: found time 1 s after 1 s
  t,Fx\n0,1\n1,1\n2,1\n | Fx | data.csv: found 3 times; expected 4 or more
  t,F_x\n0,1\n1,2\n | Fx | found no column "Fx"; expected one of: t, F_x; did you mean "F_x"
  t,Fx,Fx\n0,1,2\n1,2,3\n | Fx | found more than one column "Fx"; call it by its number
  0 1\n1 2\n | Fx | found no names of columns, and so no "Fx"; call it by its number
  0 1\n1 2\n | 3 | data.csv: found no column 3; expected a number from 1 to 2
  0 1\n1 2\n | 0 | data.csv: found no column 0; expected a number from 1 to 2
  t,Fx\n0,1\n1,-1e308\n2,1e308\n9,1\n | Fx | 3: found -1e+308; expected 1e+20 or less
  time [ms],Fx\n0,1\n1,2\n | Fx | found "time [ms]"; expected the time in s; convert it
  a heading alone\n | 2 | data.csv: found no numbers; expected lines of numbers
  | 2 | data.csv: found no numbers; expected lines of numbers
"""


@pytest.mark.parametrize(("text", "column", "found"), text_tables.rows(BAD_TEXT))
def test_bad_text(load: Load, tmp_path: Path, text: str, column: str, found: str) -> None:
    """One line: case file, key, data file and its line, what is there, what should be."""
    (tmp_path / "data.csv").write_text(text)
    ready = load(surge(column=column))
    with pytest.raises(InputError) as caught:
        ready.scene()
    message = str(caught.value).replace(f"{tmp_path}/", "")
    assert re.match(r"case\.yaml:\d+: forces\.push\.force\.surge: data\.csv", message)
    assert found in message
    assert "\n" not in message


def test_a_factor_that_makes_too_much(load: Load, tmp_path: Path) -> None:
    (tmp_path / "data.csv").write_text("t,Fx\n0,1\n1,2e16\n2,3\n9,4\n")
    with pytest.raises(InputError, match=r"found 2e\+22 N in record 2; expected 1e\+20 or less"):
        load(surge(more=", factor: 1e6")).scene()


def test_bytes_that_are_no_text(load: Load, tmp_path: Path) -> None:
    (tmp_path / "data.csv").write_bytes(b"\x89PNG\r\n\xff\xfe")
    with pytest.raises(InputError, match=r"data\.csv:1: found bytes that are no text"):
        load(surge()).scene()


def test_a_record_that_is_too_short_for_the_run(load: Load, tmp_path: Path) -> None:
    from hydrosim import compile_scene

    (tmp_path / "data.csv").write_text(TEXTS["names"])
    scene = load(surge(), ["duration=61 s"]).scene()
    with pytest.raises(InputError, match=r"force\.surge: found a record from 0 s to 60 s;.*61 s"):
        compile_scene(scene)


@pytest.fixture
def run(tmp_path: Path) -> xr.Dataset:
    """A file as a run writes it."""
    rng, dofs = np.random.default_rng(2), ["surge", "sway", "heave", "roll", "pitch", "yaw"]
    over_dof, units = ("time", "body", "dof"), {"units": "N or N m"}
    run = xr.Dataset(
        {
            "force_mooring": (over_dof, rng.normal(size=(5, 2, 6)), units),
            "fender_compression": (("time", "fender"), rng.normal(size=(5, 2)), {"units": "m"}),
            "wave_elevation": ("time", rng.normal(size=5), {"units": "m"}),
            "reference_position": (("body",), np.zeros(2), {"units": "m"}),
        },
        coords={"time": ("time", TIME, {"units": "s"}), "body": ["barge", "deck"], "dof": dofs}
        | {"fender": ["interface 1", "interface 2"]},
    )
    run.to_netcdf(tmp_path / "run.nc")
    return run


def test_columns_of_a_run(load: Load, run: xr.Dataset) -> None:
    names = "[force_mooring.deck.surge, force_mooring.surge.barge]"
    signal = record(load, surge("run.nc", names))
    assert_array_equal(signal.time, TIME)
    expected = run.force_mooring.sel(dof="surge").sum("body")
    assert_allclose(signal.value, expected, rtol=1e-14)
    pressed = record(load, surge("run.nc", "fender_compression.interface 2", ", factor: 2 kN/m"))
    assert_allclose(pressed.value, 2e3 * run.fender_compression[:, 1], rtol=1e-14)


def test_moments_of_a_run(load: Load, run: xr.Dataset) -> None:
    text = case("pitch: {file: run.nc, column: force_mooring.deck.pitch}")
    signal = record(
        load, text.replace("surge]", "surge, pitch], inertia: [[1,0,0],[0,1,0],[0,0,1]]"), "pitch"
    )
    assert_allclose(signal.value, run.force_mooring.sel(body="deck", dof="pitch"), rtol=1e-15)


BAD_COLUMNS = """
  force_moring.deck.surge | found no variable over time "force_moring"; expected one of
  reference_position.deck | found no variable over time "reference_position"
  force_mooring.dack.surge | no selection from force_mooring "dack"; expected one of: barge
  force_mooring.surge | for every body; expected one, as in "force_mooring.surge.barge"
  wave_elevation | found a column in m; expected N; give a factor, such as "98100 kN/m"
  force_mooring.deck.pitch | found a column in N m; expected N
  wave_elevation, factor: 3 kN | found a column in m and a factor in kN; expected N
  [wave_elevation, force_mooring.deck.surge] | found columns in m and N; expected one unit
"""


@pytest.mark.parametrize(("column", "found"), text_tables.rows(BAD_COLUMNS))
def test_bad_columns_of_a_run(load: Load, run: xr.Dataset, column: str, found: str) -> None:
    with pytest.raises(InputError) as caught:
        load(surge("run.nc", column)).scene()
    assert re.search(r"case\.yaml:\d+: forces\.push\.force\.surge: ", str(caught.value))
    assert found in str(caught.value)


def test_numbers_missing_in_a_run(load: Load, run: xr.Dataset, tmp_path: Path) -> None:
    run.force_mooring[3, 0, 0] = np.nan
    run.to_netcdf(tmp_path / "holes.nc")
    with pytest.raises(InputError, match=r"holes\.nc: found nan in record 4; expected finite"):
        load(surge("holes.nc", "force_mooring.barge.surge")).scene()


@pytest.mark.parametrize("content", [b"\x89HDF broken", b"CDF\x01"])
def test_broken_netcdf(load: Load, tmp_path: Path, content: bytes) -> None:
    (tmp_path / "run.nc").write_bytes(content)
    with pytest.raises(InputError, match=r"run\.nc: cannot be read as netCDF"):
        load(surge("run.nc")).scene()
