"""`hydrosim db`: what it prints, exit codes, one clear message, and what is written."""

import resource
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import Command, command, files, refusal, succeeds

from hydrosim.cli.db import TimeLeft
from hydrosim.database import HydroDatabase, netcdf
from hydrosim.database.checks import CHECKS
from hydrosim.database.load import WRITERS, read
from hydrosim.errors import InputError
from hydrosim.interface import database as building

ROOT = Path(__file__).parents[2]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory, with the barge's database."""
    shutil.copy(ROOT / "hydro_db" / "h851.nc", tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    return tmp_path


@pytest.fixture
def db(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Command:
    """Runs `hydrosim db` with these arguments, in this process, as the installed script does."""
    return command(monkeypatch, capsys, "db")


def planted(**changes: Callable[[Any], Any] | None) -> HydroDatabase:
    """Writes faulty.nc: the barge's database with functions of its arrays, or without them."""
    barge = read("h851.nc")
    values = {
        name: None if change is None else change(getattr(barge, name))
        for name, change in changes.items()
    }
    faulty = replace(barge, **values)
    netcdf.write(faulty, Path("faulty.nc"))
    return faulty


def differences(a: HydroDatabase, b: HydroDatabase) -> set[str]:
    names = {item.name for item in fields(a)} - {"source", "attributes"}
    return {name for name in names if not np.array_equal(getattr(a, name), getattr(b, name))}


class TestInfo:
    def test_says_what_is_there_and_what_is_not(self, db: Command) -> None:
        result = db("info", "h851.nc")
        assert (result.code, result.err) == (0, "")
        for words in (
            "Launch barge like H-851",
            "hydrosim netCDF",
            "deep water, 1025 kg/m³",
            "125, from 0.02 to 2.5 rad/s; periods 2.51 to 314 s",
            "73, from 0 to 180 deg",
            "transverse 18.82, longitudinal 484.9 m",
            "31, from 0.3 to 1.62 rad/s; 4 pairs of headings",
            "lacks qtf sum",
        ):
            assert words in result.out

    def test_of_a_file_that_lacks_much(self, db: Command) -> None:
        planted(volume=None, hydrostatic_stiffness=None, mean_drift=None)
        said = succeeds(db, "info", "faulty.nc")
        assert "lacks hydrostatic stiffness, volume, mean drift" in said


class TestCheck:
    def test_names_every_check_and_passes_the_barge(self, db: Command, folder: Path) -> None:
        before = files(folder)
        result = db("check", "h851.nc", "--strict")
        assert (result.code, result.err) == (0, "")
        assert all(check.name in result.out for check in CHECKS)
        assert "look closer" not in result.out
        assert "sum QTF is symmetric: the database has no qtf sum" in result.out
        assert files(folder) == before

    def test_a_doubt_fails_if_strict(self, db: Command) -> None:
        planted(inertia_matrix=lambda M: 1.05 * M)
        for strict, code in (((), 0), (("--strict",), 1)):
            result = db("check", "faulty.nc", *strict)
            assert result.code == code
            assert "look closer" in result.out
            assert "weight: relative difference of mass and displaced mass" in result.out

    def test_what_is_refused_fails(self, db: Command) -> None:
        planted(excitation=np.conj)
        result = db("check", "faulty.nc")
        assert result.code == 2
        assert "refused" in result.out
        assert "look for exp(-i w t) (conjugate the loads)" in result.out

    @pytest.mark.parametrize("suffix", ["png", pytest.param("svg", marks=pytest.mark.slow)])
    def test_draws(self, db: Command, folder: Path, suffix: str) -> None:
        assert db("check", "h851.nc", "-o", f"h851.{suffix}").code == 0
        picture = Path(f"h851.{suffix}").read_bytes()
        assert picture.startswith(b"\x89PNG" if suffix == "png" else b"<?xml")
        assert set(files(folder)) == {"h851.nc", f"h851.{suffix}"}

    def test_draws_what_lacks_much(self, db: Command) -> None:
        planted(mean_drift=None, excitation=lambda X: 0 * X, hydrostatic_stiffness=None)
        db("check", "faulty.nc", "-o", "faulty.png")
        assert Path("faulty.png").is_file()

    @pytest.mark.parametrize("output", ["h851.nc", "picture", "nowhere/h851.png", "."])
    def test_bad_pictures_are_refused(self, db: Command, folder: Path, output: str) -> None:
        said = refusal(db, folder, "check", "h851.nc", "-o", output)
        assert said.startswith("error --output: ")


def given(*settings: str) -> list[str]:
    """An option --given for each setting."""
    return [part for setting in settings for part in ("--given", setting)]


class TestConvert:
    def test_bit_for_bit(self, db: Command) -> None:
        result = db("convert", "h851.nc", "other.nc")
        assert (result.code, result.out, result.err) == (0, "result other.nc", "")
        assert read("other.nc").checksum == read("h851.nc").checksum

    def test_what_the_file_lacks_is_given(self, db: Command) -> None:
        planted(volume=None, centre_of_gravity=None)
        known = given("volume=152935121.57827717 L", "centre_of_gravity=[0, 0 m, -490 cm]")
        succeeds(db, "convert", "faulty.nc", "other.nc", *known)
        written, barge = read("other.nc"), read("h851.nc")
        assert differences(written, barge) <= {"volume", "centre_of_gravity"}
        np.testing.assert_allclose(written.volume, barge.volume, rtol=1e-12)
        np.testing.assert_allclose(written.centre_of_gravity, barge.centre_of_gravity, rtol=1e-12)

    def test_the_file_is_believed(self, db: Command) -> None:
        said = succeeds(db, "convert", "h851.nc", "other.nc", *given("density=1 tonne/m^3"))
        assert "warning h851.nc has its own water density; the option is ignored" in said
        assert read("other.nc").water_density == 1025.0

    def test_doubts_are_told(self, db: Command) -> None:
        planted(inertia_matrix=lambda M: 1.05 * M)
        said = succeeds(db, "convert", "faulty.nc", "other.nc")
        assert "warning faulty.nc: weight: found 0.05" in said

    def test_what_nobody_said_is_told(self, db: Command) -> None:
        known = given("density=1025", "gravity=9.81", "depth=infinite")
        assert db("convert", "h851.nc", "there.1").code == 0
        result = db("convert", "there.1", "other.nc", *known)
        assert "assumed: reference points at the origin, first column period" in result.out
        place = given("reference_point=[0, 0, -4.9 m]", "frequency_column=period")
        result = db("convert", "there.1", "another.nc", *known, *place)
        assert "assumed" not in result.out

    def test_what_cannot_be_right_is_not_written(self, db: Command, folder: Path) -> None:
        planted(excitation=np.conj)
        said = refusal(db, folder, "convert", "faulty.nc", "other.nc")
        assert "phase of the horizontal load" in said

    @pytest.mark.parametrize("out", ["h851.nc", "./h851.nc", "link.nc"])
    def test_never_over_its_input(self, db: Command, folder: Path, out: str) -> None:
        Path("link.nc").symlink_to("h851.nc")
        said = refusal(db, folder, "convert", "h851.nc", out)
        assert "is an input and would be overwritten" in said or "is a link" in said

    def test_bemio_and_back(self, db: Command) -> None:
        """All that the format has a place for, to rounding."""
        assert db("convert", "h851.nc", "there.h5").code == 0
        assert db("convert", "there.h5", "back.nc").code == 0
        back, barge = read("back.nc"), read("h851.nc")
        for name in ("frequency", "heading", "added_mass", "radiation_damping", "excitation"):
            there = getattr(barge, name)
            np.testing.assert_allclose(
                getattr(back, name), there, rtol=1e-12, atol=1e-12 * np.abs(there).max()
            )
        assert back.water_depth == np.inf

    def test_wamit_and_back(self, db: Command, folder: Path) -> None:
        """Of which the files do not say the depth, the density and where the bodies are."""
        succeeds(db, "convert", "h851.nc", "some.nc", *given("frequencies=[0.3, 0.8 rad/s]"))
        succeeds(db, "convert", "some.nc", "there.1")
        assert {"there.1", "there.3", "there.hst", "there.mmx"} <= set(files(folder))
        known = given("density=1025", "gravity=9.81", "depth=infinite", "length=1")
        place = given("reference_point=[0, 0, -4.9]", "symmetric=true")
        for name in ("there", "there.3"):  # any name of the set
            assert db("check", name, *known, *place).code == 0
            assert db("convert", name, "back.nc", "--overwrite", *known, *place).code == 0
            back, barge = read("back.nc"), read("some.nc")
            for array in ("added_mass", "radiation_damping", "excitation"):
                there = getattr(barge, array)
                np.testing.assert_allclose(
                    getattr(back, array), there, rtol=1e-12, atol=1e-12 * np.abs(there).max()
                )
        refusal(db, folder, "convert", "there.1", "there.1", *known, *place)

    def test_a_writer_that_fails_leaves_nothing(
        self, db: Command, folder: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def write(db: HydroDatabase, path: Path) -> None:
            path.write_text("half of it")
            raise InputError("this format has no room for it")

        monkeypatch.setitem(WRITERS, ".half", write)
        Path("other.half").write_text("of last year")
        refusal(db, folder, "convert", "h851.nc", "other.half")

    @pytest.mark.parametrize(
        ("arguments", "words"),
        [
            (("other.yaml",), ["other.yaml", "suffix .yaml", "expected one of .nc, .h5, .1"]),
            (("other",), ["suffix (none)"]),
            (("nowhere/other.nc",), ["no folder nowhere"]),
            (("other.nc", "--given", "density=3 m"), ["density", '"3 m"', "expected a density"]),
            (("other.nc", "--given", "length=0"), ["--given length", "above 0"]),
            (("other.nc", "--given", "gravity=much"), ["--given gravity", '"much"']),
            (("other.nc", "--given", "volume=[1 m^3, 2]"), ["volume", "2 numbers", "expected 1"]),
            (("other.nc", "--given", "centre_of_gravity=1 m"), ["centre_of_gravity", "list"]),
            (("other.nc", "--given", "densty=1025"), ["--given densty", "density"]),
            (("other.nc", "--given", "file=x.nc"), ["--given file", "argument"]),
            (("other.nc", "--given", "density"), ["--given density", "KEY=VALUE"]),
        ],
    )
    def test_bad_arguments_are_refused(
        self, db: Command, folder: Path, arguments: tuple[str, ...], words: list[str]
    ) -> None:
        planted(volume=None)
        said = refusal(db, folder, "convert", "faulty.nc", *arguments)
        assert said.startswith("error ")
        assert all(word in said for word in words)


def truncated(share: float) -> Callable[[bytes], bytes]:
    return lambda content: content[: int(share * len(content))]


def overwritten(content: bytes) -> bytes:
    junk = np.random.default_rng(1).bytes(len(content) // 2)
    return content[: len(content) // 4] + junk + content[len(content) * 3 // 4 :]


BAD: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda content: b"",
    "text": lambda content: b"frequency 0.1 0.2\n",
    "noise": lambda content: np.random.default_rng(1).bytes(5000),
    "head of a netCDF and noise": lambda content: content[:8] + b"\x07" * 5000,
    "overwritten": overwritten,
    **{f"first {share:.0%}": truncated(share) for share in (0.01, 0.3, 0.7, 0.99)},
}


@pytest.mark.parametrize("command", [("info",), ("check",), ("convert", "other.nc")])
@pytest.mark.parametrize("kind", BAD)
def test_bad_files_are_refused(
    db: Command, folder: Path, command: tuple[str, ...], kind: str
) -> None:
    """One message that names the file, on the terminal's error stream; nothing is written."""
    Path("bad.nc").write_bytes(BAD[kind](Path("h851.nc").read_bytes()))
    said = refusal(db, folder, command[0], "bad.nc", *command[1:])
    assert said.startswith("error bad.nc: ")
    assert "expected" in said


@pytest.mark.parametrize("command", ["info", "check"])
@pytest.mark.parametrize("name", ["nowhere.nc", "."])
def test_no_file_is_refused(db: Command, folder: Path, command: str, name: str) -> None:
    assert refusal(db, folder, command, name).startswith(f"error {name}: ")


def test_a_full_disk_below_a_bemio_file(folder: Path) -> None:
    """Files can have 20 kB. HDF5's library brought the process down, with lines of its own."""
    command = [sys.executable, "-m", "hydrosim", "db", "convert", "h851.nc", "h851.h5"]
    limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))  # noqa: E731
    done = subprocess.run(command, capture_output=True, text=True, preexec_fn=limit, check=False)
    assert (done.returncode, done.stdout) == (3, "")
    (line,) = done.stderr.splitlines()
    assert line.startswith("error h851.h5: cannot be written (File too large; ")
    assert {path.name for path in folder.iterdir()} == {"h851.nc"}


def test_help_names_the_commands(db: Command) -> None:
    said = succeeds(db, "--help")
    assert all(command in said for command in ("info", "check", "convert"))


class TestKernel:
    def test_the_table_gives_the_damping_back(self, db: Command, folder: Path) -> None:
        """B(w) = int K cos(w t) dt, to what the table's end and step leave out."""
        result = db("kernel", "h851.nc", "--until", "150", "--every", "0.05")
        assert (result.code, result.err) == (0, "")
        assert "h851_kernel.csv, h851_kernel.png" in result.out
        assert (folder / "h851_kernel.png").stat().st_size > 10_000
        lines = (folder / "h851_kernel.csv").read_text().splitlines()
        names = lines[3].split(",")
        assert "surge sway" not in names  # zero by symmetry
        time, *columns = np.loadtxt(lines[5:], delimiter=",").T
        K, barge = columns[names.index("heave heave") - 1], read("h851.nc")
        B = np.interp([0.5, 0.8], barge.frequency, barge.radiation_damping[:, 2, 2])
        found = [np.trapezoid(K * np.cos(w * time), time) for w in (0.5, 0.8)]
        assert found == pytest.approx(B, rel=0.01)

    def test_a_table_out_of_proportion_is_refused(self, db: Command, folder: Path) -> None:
        said = refusal(db, folder, "kernel", "h851.nc", "--until", "1e6", "--every", "1e-6")
        assert "expected 2 to 1000000 steps" in said


class TestChanges:
    def test_are_made_and_said(self, db: Command) -> None:
        changes = given("frequencies=[0, 2 rad/s]", "without=[drift, qtf]", "symmetrise=true")
        accepted = given("accept=[positive damping]")
        succeeds(db, "convert", "h851.nc", "less.nc", *changes, *accepted)
        less = read("less.nc")
        assert less.frequency[-1] == pytest.approx(2.0)
        assert less.mean_drift is None
        assert less.qtf_difference is None
        said = "only frequencies 0 to 2 rad/s; without drift; without qtf; symmetrised"
        assert less.attributes["changed"] == said
        assert less.attributes["accepted"] == "positive damping"

    @pytest.mark.parametrize(
        ("setting", "message"),
        [
            ("frequencies=[2, 1]", "expected the lower one first"),
            ("frequencies=[0, 3 m]", "--given frequencies=[0, 3 m]: frequencies.1: found"),
            ("without=[heave]", "without.0: found"),
            ("accept=[everything]", 'accept: found "everything"; expected one of frequencies'),
        ],
    )
    def test_what_is_no_change_is_named(
        self, db: Command, folder: Path, setting: str, message: str
    ) -> None:
        assert message in refusal(db, folder, "convert", "h851.nc", "less.nc", *given(setting))

    def test_a_set_without_loads_goes_from_format_to_format(self, db: Command) -> None:
        assert db("convert", "h851.nc", "bare.nc", "--given", "without=[loads]").code == 0
        assert db("convert", "bare.nc", "bare.1").code == 0
        assert not Path("bare.3").exists()
        assert read("bare.1").heading.size == 0
        assert "none, no wave loads" in db("info", "bare.nc").out
        assert db("check", "bare.nc", "-o", "bare.png").code == 0
        refused = db("convert", "bare.nc", "bare.h5")
        assert (refused.code, "has no wave loads" in refused.err) == (2, True)


def test_all_modules_that_are_absent_are_named_at_once(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(building, "find_spec", lambda name: None)
    recipe = tmp_path / "recipe.yaml"
    recipe.touch()
    with pytest.raises(InputError, match="found no module capytaine and no joblib; expected"):
        building.build_database(recipe)


def test_time_left_is_expected_first_and_then_measured() -> None:
    """Stored frequencies come within no time, and say nothing of the pace."""
    now = [100.0]
    left = TimeLeft(lambda: now[0])
    left.expected = 60.0
    assert left.update(0, 13) == 60.0
    for done in (1, 2, 3):  # stored
        now[0] += 0.001
        assert left.update(done, 13) == 60.0
    now[0] += 4.0
    assert left.update(4, 13) == pytest.approx(36.0)
    now[0] += 2.0
    assert left.update(5, 13) == pytest.approx(24.0)
    assert left.update(13, 13) == 0.0
