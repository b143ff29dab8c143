"""Recordings: what is read of each format, what is said of bad ones, and the round trip."""

from pathlib import Path

import damaged
import h5py
import numpy as np
import pytest
import scipy.io
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal
from recorded_runs import made_run

from hydrosim.errors import InputError
from hydrosim.files.recordings import Recording, read_recording, write_recording
from hydrosim.results.channels import default_channels

TIME = np.array([0.0, 0.5, 1.0, 1.5, 2.0])
HEAVE, FORCE = np.array([1.0, 0.5, -0.25, 0.125, 3.0]), np.array([1.0, 2.0, 3.0, 5.0, 8.0])
ROWS = list(zip(TIME, HEAVE, FORCE, strict=True))


def rows(separator: str = " ") -> str:
    return "\n".join(separator.join(map(str, row)) for row in ROWS)


def shown(recording: Recording) -> list[tuple[str, str | None]]:
    return [(column.name, column.unit) for column in recording.columns]


def assert_read(recording: Recording) -> None:
    time, heave, force = (column.value for column in recording.columns)
    assert_array_equal(time, TIME)
    assert_array_equal(heave, HEAVE)
    assert_array_equal(force, FORCE)


TEXTS = {
    "csv, units in brackets": (f"time [s],heave [m],Fx (kN)\n{rows(',')}", "s m kN"),
    "names with blanks, ruled": (
        f"  Wave #: 3\nomega (rad/s): 0.8\nTime (s)    Heave motion (m)  Force (InWave)\n"
        f"--------  ----------------  --------\n{rows('     ')}",
        "s m None",
    ),
    "row of units": (f"A test of 3\nTime   Heave  Fx\n s  m  kN\n{rows('   ')}", "s m kN"),
    "row of units in brackets": (
        f"# t heave F x\n# Time Z Mx\n# [sec] (m) [kNm]\n{rows()}",
        "s m kN*m",
    ),
    "tabs": (f"Time (s)\tHeave (Lin)\tF [tonne_force]\n{rows(chr(9))}", "s None tonne_force"),
    "no names": (rows(), "None None None"),
}


@pytest.mark.parametrize("name", TEXTS)
def test_text(tmp_path: Path, name: str) -> None:
    text, units = TEXTS[name]
    (tmp_path / "data.txt").write_text(text)
    recording = read_recording(tmp_path / "data.txt")
    assert_read(recording)
    assert [str(unit) for _, unit in shown(recording)] == units.split()
    assert recording.lines is not None
    assert recording.lines[-1] == len(text.splitlines())


def test_columns_are_called_by_name_or_number(tmp_path: Path) -> None:
    (tmp_path / "data.csv").write_text(TEXTS["csv, units in brackets"][0])
    recording = read_recording(tmp_path / "data.csv")
    for key in ("heave [m]", "heave", 2):
        assert_array_equal(recording.column(key).value, HEAVE)
    with pytest.raises(
        InputError, match=r'data\.csv: found no column "heeve"; expected one of: time \[s\], heave'
    ):
        recording.column("heeve")
    with pytest.raises(InputError, match=r"no column 4; expected a number from 1 to 3"):
        recording.column(4)


def test_matlab_5(tmp_path: Path) -> None:
    """Vectors in either direction, a struct, a matrix; what is not over time is left out."""
    path = tmp_path / "data.mat"
    motions = {"heave": HEAVE[None, :], "name": "test 3"}
    both = np.stack([HEAVE, FORCE], axis=1)
    content = {"t": TIME[:, None], "motions": motions, "both": both, "wave": np.arange(7.0)}
    scipy.io.savemat(path, content)
    recording = read_recording(path)
    assert [name for name, _ in shown(recording)] == ["t", "motions.heave", "both 1", "both 2"]
    assert recording.time_column().name == "t"
    assert_array_equal(recording.column("motions.heave").value, HEAVE)
    assert_array_equal(recording.column("both 2").value, FORCE)
    assert recording.left_out == ["wave"]


def test_matlab_73(tmp_path: Path) -> None:
    """HDF5 behind 512 bytes of text, arrays the other way round, structs as groups."""
    path = tmp_path / "data.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        file["t"], file["motions/heave"] = TIME[None, :], HEAVE[None, :]
        file["both"] = np.stack([HEAVE, FORCE])
        file["#refs#/a"] = TIME
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512)
    with path.open("r+b") as opened:
        opened.write(head)
    recording = read_recording(path)
    assert recording.form == "MATLAB 7.3"
    assert_array_equal(recording.column("motions.heave").value, HEAVE)
    assert_array_equal(recording.column("both 2").value, FORCE)
    assert len(recording.columns) == 4


def test_hdf5(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "data.h5", "w") as file:
        for name, values, unit in (
            ("time", TIME, "s"),
            ("z/heave", HEAVE, "m"),
            ("zz", FORCE, "kN"),
        ):
            file[name] = values
            file[name].attrs["units"] = unit
    recording = read_recording(tmp_path / "data.h5")
    assert_read(recording)
    assert shown(recording) == [("time", "s"), ("z.heave", "m"), ("zz", "kN")]


@pytest.mark.parametrize("form", ["NETCDF4", "NETCDF3_64BIT"])
def test_netcdf(tmp_path: Path, form: str) -> None:
    """A dimension called t, dates left as numbers, places without names numbered."""
    data = {
        "heave": ("t", HEAVE, {"units": "m"}),
        "force": (("t", "leg"), np.stack([FORCE, -FORCE], axis=1), {"units": "kN"}),
    }
    time = {"t": ("t", TIME, {"units": "seconds since 2020-01-01"})}
    xr.Dataset(data, time).to_netcdf(tmp_path / "data.nc", format=form)
    recording = read_recording(tmp_path / "data.nc")
    names = [("t", "s"), ("heave", "m"), ("force.1", "kN"), ("force.2", "kN")]
    assert shown(recording) == names
    assert_array_equal(recording.column("force.2").value, -FORCE)


def test_a_run_is_a_recording(tmp_path: Path) -> None:
    """Called as in series of a case file, in the units of translations or rotations; modes are
    not measured."""
    run = made_run(duration=20.0)
    run.to_netcdf(tmp_path / "run.nc")
    recording = read_recording(tmp_path / "run.nc")
    pitch = recording.column("position.barge.pitch")
    assert pitch.unit == "rad"
    assert_array_equal(pitch.value, run.position.sel(dof="pitch", body="barge"))
    assert recording.column("force_mooring.barge.pitch").unit == "N m"
    assert not any(column.name.startswith("fender_mode") for column in recording.columns)


BAD = {
    "ragged.txt": (
        b"t x\n0 1\n1 2 3\n",
        r"ragged\.txt:3: found 3 values; expected 2, as in line 2",
    ),
    "words.txt": (b"nothing\n", r"words\.txt: found no numbers; expected lines of numbers"),
    "bytes.txt": (b"\xff\xfe\x00", r"bytes\.txt:1: found bytes that are no text"),
    "broken.nc": (b"CDF\x01", r"broken\.nc: cannot be read as netCDF"),
    "broken.h5": (b"\x89HDF\r\n", r"broken\.h5: cannot be read as HDF5"),
    "broken.mat": (b"MATLAB 5.0 MAT-file".ljust(200), r"broken\.mat: cannot be read as MATLAB"),
    "broken73.mat": (b"MATLAB 7.3 MAT-file".ljust(200), r"broken73\.mat: cannot be read as MATLAB"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_files(tmp_path: Path, name: str) -> None:
    content, message = BAD[name]
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=message):
        read_recording(tmp_path / name)


def test_no_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.txt: there is no such file"):
        read_recording(tmp_path / "none.txt")
    with pytest.raises(InputError, match="is a directory"):
        read_recording(tmp_path)


def test_nothing_over_time(tmp_path: Path) -> None:
    scipy.io.savemat(tmp_path / "data.mat", {"name": "test"})
    with pytest.raises(InputError, match="found no numbers over time"):
        read_recording(tmp_path / "data.mat")
    xr.Dataset({"x": ("place", HEAVE)}).to_netcdf(tmp_path / "data.nc")
    with pytest.raises(InputError, match="found the dimensions place; expected time"):
        read_recording(tmp_path / "data.nc")


class TestWrite:
    def test_round_trip_is_exact(self, tmp_path: Path) -> None:
        run, path = made_run(), tmp_path / "run.txt"
        names = default_channels(run)
        write_recording(run, path, names)
        recording = read_recording(path)
        assert [name for name, _ in shown(recording)] == ["time", *names]
        assert_array_equal(recording.columns[0].value, run.time)
        assert_array_equal(
            recording.column("fender_normal_force.interface 2").value,
            run.fender_normal_force.sel(fender="interface 2"),
        )
        assert recording.column("force_mooring.barge.roll").unit == "N m"

    def test_layout(self, tmp_path: Path) -> None:
        """Two remarks, names, units, numbers: each column ends at the same place in every line."""
        run, path = made_run(duration=20.0), tmp_path / "run.txt"
        write_recording(run, path, ["wave_elevation", "fender_compression.interface 1"], digits=4)
        remark, more, *table = path.read_text().splitlines()
        assert remark == "# A made-up barge"
        assert "4 significant digits" in more
        assert table[0].split("  ")[-1] == "fender_compression.interface 1"
        assert table[1].split() == ["[s]", "[m]", "[m]"]
        first = [
            line.index(word) + len(word) for line, word in ((table[0], "time"), (table[1], "[s]"))
        ]
        assert first[0] == first[1] == table[2].index("e+00") + 4
        assert len({len(line) for line in table}) == 1

    def test_other_steps(self, tmp_path: Path) -> None:
        """At a multiple of the run's step the splines go through the run's own values."""
        run, path = made_run(duration=20.0, step=0.1), tmp_path / "run.txt"
        write_recording(run, path, ["wave_elevation"], step=0.5)
        time, wave = (column.value for column in read_recording(path).columns)
        assert_allclose(time, 0.5 * np.arange(41))
        assert_allclose(wave, run.wave_elevation[::5], rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("suffix", [".csv", ".mat", ".h5", ".nc"])
def test_damaged_files_are_refused_or_read(tmp_path: Path, suffix: str) -> None:
    """A message with the file's name, or what is left of the recording."""
    whole, columns = tmp_path / f"whole{suffix}", {"time": TIME, "heave": HEAVE, "force": FORCE}
    if suffix == ".csv":
        whole.write_text(TEXTS["csv, units in brackets"][0])
    elif suffix == ".mat":
        scipy.io.savemat(whole, columns)
    elif suffix == ".h5":
        with h5py.File(whole, "w") as file:
            for name, values in columns.items():
                file[name] = values
    else:
        made_run().to_netcdf(whole)
    content = whole.read_bytes()
    for seed in range(damaged.COUNT):
        path = tmp_path / f"part{seed}{suffix}"
        path.write_bytes(damaged.damaged(content, seed))
        message = damaged.message(read_recording, path)
        assert message is None or path.name in message, seed
        path.unlink()
