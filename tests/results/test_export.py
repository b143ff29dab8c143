"""Files for other programs, read back by other readers than our own; CF by the checker of IOOS."""

import csv
import json
from functools import partial
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr
from command_line import Command, refusal, succeeds
from numpy.testing import assert_allclose, assert_array_equal
from recorded_runs import made_run
from text_tables import rows

from hydrosim.compare.export import (
    MAX_MATLAB_NAME_LETTERS,
    ExportColumn,
    escape_formula,
    identifiers,
)
from hydrosim.errors import InputError
from hydrosim.files.display_units import as_attribute
from hydrosim.files.series import read_series
from hydrosim.files.text import Source, escape_unprintable
from hydrosim.results.channels import channel_series
from hydrosim.results.dataset import write_run
from hydrosim.scene.signal import RecordedColumns, read_record

SUFFIXES = (".nc", ".csv", ".mat", pytest.param(".parquet", marks=pytest.mark.extras))
HOSTILE = '=HYPERLINK("http://a.b";"c")'


@pytest.fixture
def export(hydrosim: Command) -> Command:
    """`hydrosim export` in a folder with a run."""
    write_run(awkward_run(), Path("run.nc"))
    return partial(hydrosim, "export")


def awkward_run() -> xr.Dataset:
    """A run with numbers that few digits do not tell, one that is missing, and names that
    spreadsheets run and other programs do not take."""
    run = made_run(duration=20.0)
    run.fender_mode.attrs["flag_meanings"] = "open stick slip"
    odd = np.array([0.1 + 0.2, 1e-310, -1.7976931348623157e304, np.pi, -0.0, np.nan])
    run.fender_compression.values[:6, 0] = odd
    return run.assign_coords(fender=[HOSTILE, "-2+3"])


def read_csv(path: Path) -> tuple[list[str], list[str], np.ndarray]:
    """Names, units and numbers, by Python's reader."""
    with path.open(newline="", encoding="utf-8") as file:
        mark, names, units, *rows = csv.reader(file)
    assert mark[0].startswith("# hydrosim")
    return names, units, np.array(rows, dtype=float)


def same(found: np.ndarray, expected: np.ndarray) -> None:
    """Equal to the bit; the sign of zero, too."""
    assert np.ravel(found).astype(float).tobytes() == np.ravel(expected).astype(float).tobytes()


def of_run(name: str) -> np.ndarray:
    """A channel or mode of the run, straight from its file."""
    with netCDF4.Dataset("run.nc") as file:
        file.set_auto_mask(False)
        kind, _, label = name.partition(".")
        if kind == "position":
            return file[kind][:, 0, list(file["dof"][:]).index(label.partition(".")[2])]
        return file[kind][:, list(file["fender"][:]).index(label)] if label else file[kind][:]


NAMES = (
    "time",
    "wave_elevation",
    "position.barge.pitch",
    f"fender_compression.{HOSTILE}",
    "fender_mode.-2+3",
)


READ = {None: "kN", "tonne_force": "tf"}
"""The unit of forces that a case writes, and the one that people read."""


def shown_of(name: str, writes: dict[str, str]) -> np.ndarray:
    """A channel of the run, in the unit that it is read in, straight from its file."""
    factors = {"position.barge.pitch": 180.0 / np.pi, f"fender_compression.{HOSTILE}": 1.0}
    if "m" in writes:
        factors[f"fender_compression.{HOSTILE}"] = 1e3
        factors["wave_elevation"] = 1e3
    factor = factors.get(name, 1.0)
    return of_run(name) if factor == 1.0 else factor * of_run(name)


@pytest.mark.parametrize("writes", [{}, {"m": "mm", "N": "tonne_force"}])
def test_csv_has_units_as_written_and_no_cell_is_a_formula(
    export: Command, writes: dict[str, str]
) -> None:
    write_run(awkward_run().assign_attrs(as_attribute(writes)), Path("run.nc"))
    assert export("run.nc", "-o", "run.csv").code == 0
    names, units, rows = read_csv(Path("run.csv"))
    for name in NAMES:
        same(rows[:, names.index(name)], shown_of(name, writes))
    length = writes.get("m", "m")
    force = READ[writes.get("N")]
    assert units[names.index("position.barge.pitch")] == "deg"
    assert units[names.index("position.barge.surge")] == length
    assert units[names.index("velocity.barge.yaw")] == "deg/s"
    assert units[names.index("force_mooring.barge.yaw")] == f"{force} {length}"
    force_read = rows[:, names.index("force_mooring.barge.surge")]
    newton = 9810.0 if force == "tf" else 1000.0
    with netCDF4.Dataset("run.nc") as file:
        assert_allclose(force_read, file["force_mooring"][:, 0, 0] / newton, rtol=1e-15)
    assert "" not in units


def test_csv_in_si_reads_back_exact(export: Command) -> None:
    assert export("run.nc", "-o", "run.csv", "--units", "si").code == 0
    names, units, rows = read_csv(Path("run.csv"))
    for name in NAMES:
        same(rows[:, names.index(name)], of_run(name))
    assert units[names.index("position.barge.pitch")] == "rad"
    assert units[names.index("force_mooring.barge.yaw")] == "N m"


@pytest.mark.parametrize(
    "text", ["=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "\r=1", " =1", "a;=1", "a,+1", "a\n@x", "＝1"]
)
def test_what_spreadsheets_run_is_text(text: str) -> None:
    """No cell, whatever parts the cells, begins with one of the signs that OWASP lists."""
    for cells in (escape_formula(text).split(part) for part in (",", ";", "\t", "\n", "\r")):
        assert not any(cell.strip().startswith(tuple("=+-@＝")) for cell in cells)
    assert escape_formula(text).replace("'", "") == escape_unprintable(text)


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("line\x1b[31m 1", "line\\u001b[31m 1"),
        ("two\nlines", "two\\u000alines"),
        ("zero\u200bwidth", "zero\\u200bwidth"),
        ("Größe 1", "Größe 1"),
    ],
)
def test_names_steer_no_terminal_and_end_no_line(name: str, shown: str) -> None:
    assert escape_formula(name) == shown


def test_names_that_are_harmless_stay() -> None:
    for text in ("position.barge.surge", "N m", "m/s^2", "interface 1", "a - b", "1e-3"):
        assert escape_formula(text) == text


def test_a_csv_drives_another_case(export: Command) -> None:
    export("run.nc", "-o", "run.csv", "--channels", "position.*")
    found = read_series(Source(Path("run.csv")), ["position.barge.heave"])
    same(found.time, of_run("time"))
    same(found.value, of_run("position.barge.heave"))


def test_units_of_a_csv_are_understood_where_it_drives_another_case(export: Command) -> None:
    export("run.nc", "-o", "run.csv", "--channels", "force_mooring.*")
    form = RecordedColumns(file="run.csv", column="force_mooring.barge.surge")
    found = read_record(form, "forces.wind", Path("case.yaml"), "N")
    with netCDF4.Dataset("run.nc") as file:
        assert_allclose(found.value, file["force_mooring"][:, 0, 0], rtol=1e-15)
    with pytest.raises(InputError, match="found a column in kN; expected m"):
        read_record(form, "forces.wind", Path("case.yaml"), "m")


def test_matlab_reads_back_exact(export: Command) -> None:
    from scipy.io import loadmat

    assert export("run.nc", "-o", "run.mat").code == 0
    found = loadmat("run.mat")
    assert found["time"].shape == (101, 1)
    told = {
        str(row[1][0]): [str(np.ravel(x)[0]) if x.size else "" for x in row]
        for row in found["channels"]
    }
    same(found["time"], of_run("time"))
    for name in NAMES[1:]:
        same(found[told[name][0]], shown_of(name, {}))
    assert told["position.barge.pitch"][2] == "deg"
    assert told["fender_mode.-2+3"][4] == "open stick slip"
    assert str(found["run"]["status"][0, 0][0]) == "complete"


@pytest.mark.extras
def test_parquet_reads_back_exact(export: Command) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    assert export("run.nc", "-o", "run.parquet").code == 0
    found = parquet.read_table("run.parquet")
    for name in NAMES:
        same(found[name].to_numpy(), shown_of(name, {}))
    said = json.loads(found.schema.metadata[b"channels"])
    assert said["position.barge.pitch"]["units"] == "deg"
    assert said["fender_mode.-2+3"]["flag_meanings"] == "open stick slip"
    assert said.keys() == {*found.column_names}


def test_cf_reads_back_exact(export: Command) -> None:
    assert export("run.nc", "-o", "cf.nc", "--date", "2026-05-31T06:00+02:00").code == 0
    found = xr.load_dataset("cf.nc")
    by_name = {v.attrs.get("channel"): v for v in found.data_vars.values()}
    for name in NAMES[1:]:
        same(by_name[name].values, of_run(name))
    assert found.time.values[5] == np.datetime64("2026-05-31T04:00:01")
    same(found.elapsed_time.values, of_run("time"))
    assert by_name["fender_mode.-2+3"].attrs["flag_meanings"] == "open stick slip"


@pytest.mark.extras
def test_cf_passes_the_checker(export: Command) -> None:
    """Not one error of the IOOS checker for CF 1.11, nor a warning."""
    runner = pytest.importorskip("compliance_checker.runner")
    export("run.nc", "-o", "cf.nc")
    suite = runner.CheckSuite()
    suite.load_all_available_checkers()
    scores = suite.run_all(suite.load_dataset("cf.nc"), ["cf:1.11"])
    groups, errors = scores["cf:1.11"]
    assert (errors, len(groups) > 20) == ({}, True)
    whole = {True: (1, 1), False: (0, 1)}
    points = [(group, whole.get(group.value, group.value)) for group in groups]
    assert [group.msgs for group, (got, most) in points if got < most] == []


def test_pint_knows_every_unit(export: Command) -> None:
    import pint

    export("run.nc", "-o", "run.csv")
    known = pint.UnitRegistry()
    for unit in {*read_csv(Path("run.csv"))[1]}:
        known.parse_units(unit)


def test_a_window_and_channels_that_follow(export: Command) -> None:
    chosen = ("--channels", "speed.*, position.barge.heave", "--from", "0.1 min", "--to", "10")
    assert "2 channels at 21 times, 6 to 10 s" in export("run.nc", "-o", "run.csv", *chosen).out
    names, _, rows = read_csv(Path("run.csv"))
    assert names == ["time", "position.barge.heave", "speed.barge"]
    inside = slice(30, 51)
    same(rows[:, 1], of_run("position.barge.heave")[inside])
    assert_array_equal(rows[:, 2], channel_series(awkward_run(), "speed.barge")[0][inside])


REFUSED = """
  run.nc -o run.xlsx | expected a name that ends in .nc, .csv, .mat, .parquet
  run.nc -o run.nc | run.nc is an input and would be overwritten
  run.nc -o nowhere/run.csv | there is no folder nowhere
  none.nc -o a.csv | none.nc:
  text.nc -o a.csv | text.nc: cannot be read as netCDF
  foreign.nc -o a.csv | foreign.nc: is netCDF without position
  runs.nc -o a.csv | runs.nc: holds 3 runs; expected the result of one
  back.nc -o a.csv | back.nc: time: found 0 s after 0.2 s; expected times that rise
  empty.nc -o a.csv | the run has records for no time
  run.nc -o a.csv --from 1h | found 3600 to inf s, but the run has records for 0 to 20 s
  run.nc -o a.csv --to 3kg | --to:
  run.nc -o a.csv --channels positoin.* | --channels: found positoin.*
  run.nc -o a.csv --date 2026-01-01 | --date: only .nc has dates
  run.nc -o a.nc --date 31.5.2026 | --date: found '31.5.2026'; expected
"""


@pytest.mark.parametrize(("arguments", "said"), rows(REFUSED))
def test_what_cannot_be_is_said(export: Command, arguments: str, said: str) -> None:
    run = awkward_run()
    Path("text.nc").write_text("no netCDF")
    xr.Dataset({"x": ("time", np.zeros(3))}).to_netcdf("foreign.nc")
    xr.Dataset({"status": ("run", ["complete"] * 3)}).to_netcdf("runs.nc")
    run.isel(time=[0, 1, 0]).to_netcdf("back.nc")
    run.isel(time=slice(0)).to_netcdf("empty.nc")
    assert said in refusal(export, Path(), *arguments.split())


def test_without_pyarrow_it_is_said(export: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hydrosim.compare.export.find_spec", lambda name: None)
    said = refusal(export, Path(), "run.nc", "-o", "run.parquet")
    assert "pip install 'hydrosim[export]'" in said


def test_a_failed_run_is_exported_and_said(export: Command) -> None:
    attributes = {"status": "failed", "status_message": "at 3 s the barge capsized"}
    write_run(awkward_run().assign_attrs(attributes), Path("failed.nc"))
    said = succeeds(export, "failed.nc", "-o", "failed.csv")
    assert "warning the run is failed: at 3 s the barge capsized" in said


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_it_is_made_again_and_nothing_else_is_replaced(export: Command, suffix: str) -> None:
    """Also with so many columns that the heading and the metadata are long."""
    if suffix == ".parquet":
        pytest.importorskip("pyarrow")
    run = awkward_run().isel(fender=np.zeros(100, int))
    write_run(run.assign_coords(fender=[f"point {k}" for k in range(100)]), Path("many.nc"))
    for _ in range(2):
        assert export("many.nc", "-o", f"a{suffix}").code == 0
    said = refusal(export, Path(), "run.nc", "-o", f"a{suffix}")
    assert "is the export of [many.nc]" in said
    assert export("run.nc", "-o", f"a{suffix}", "--overwrite").code == 0


def test_names_of_variables_are_short_and_apart() -> None:
    names = ["a.b c", "a.b_c", "x" * 90 + "1", "x" * 90 + "2", "1.a", "time", "=", ""]
    columns = [ExportColumn(name, "m", "", np.zeros(1)) for name in names]
    found = [name for name, _ in identifiers(columns, MAX_MATLAB_NAME_LETTERS, "time")]
    assert found[:2] == ["a_b_c", "a_b_c_2"]
    assert len({*found, "time"}) == len(names) + 1
    assert all(name.isidentifier() and name[0].isalpha() for name in found)
    assert max(map(len, found)) <= MAX_MATLAB_NAME_LETTERS
