"""The command line: exit codes, one clear message, and what is written."""

import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from command_line import Command, command, files, refusal, succeeds
from scenes import CASES, ROOT, hull

import hydrosim as hs
from hydrosim.cli.terminal import ProgressLines
from hydrosim.database.netcdf import write as write_database

SHORT = ("--set", "duration=20 s")
NATURAL_PERIODS = {
    "surge": (129, 131),
    "heave": (10.5, 11.1),
    "roll": (11.8, 12.5),
    "pitch": (9.5, 10.2),
}
STIFF = "{type: linear_mooring, body: barge, stiffness: {heave: 1e12 N/m}}"
COARSE = "solver={method: rk2, step: 0.5 s, linear: step}"
UNSTABLE = ("--set", f"forces.rod={STIFF}", "--set", COARSE)


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the cases with their database; its folder of cases is the working directory."""
    cases = tmp_path / "cases" / "reverse_float_over"
    shutil.copytree(CASES, cases)
    (tmp_path / "hydro_db").mkdir()
    shutil.copy(ROOT / "hydro_db" / "h851.nc", tmp_path / "hydro_db")
    monkeypatch.chdir(cases)
    return tmp_path


@pytest.fixture
def hydrosim(
    project: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Command:
    """Runs the command with these arguments, in this process, as the installed script does."""
    return command(monkeypatch, capsys)


class TestRun:
    def test_writes_the_run_and_sums_it_up(self, hydrosim: Command) -> None:
        said = succeeds(hydrosim, "run", "base.yaml", "-o", "run.nc", *SHORT)
        title = "Reverse float-over, base case ok The run is complete: 20 s simulated."
        assert said.startswith(title)
        for word in ("motion mean std smallest largest at the end", "barge surge [m]", "run.nc"):
            assert word in said
        assert "solver" not in said
        details = hydrosim("run", "base.yaml", "-o", "run.nc", *SHORT, "--verbose").out
        assert "evaluations of the equation of motion" in details
        written = hs.open_run("run.nc")
        expected = hs.simulate(hs.load_case("base.yaml", ["duration=20 s"]))
        xr.testing.assert_equal(written, expected)
        assert not list(Path().glob("*.partial"))

    def test_starts_from_the_state_of_another_run(self, hydrosim: Command) -> None:
        assert hydrosim("run", "base.yaml", "-o", "whole.nc", *SHORT).code == 0
        first = ("--set", "duration=12 s", "--set", "output.states=true")
        assert hydrosim("run", "base.yaml", "-o", "first.nc", *first).code == 0
        start = ("--set", "initial={run: first.nc, time: 8 s}", "--set", "duration=12 s")
        said = succeeds(hydrosim, "run", "base.yaml", "-o", "second.nc", *start)
        for word in ("complete: 12 s simulated, started from", "first.nc at 8 s."):
            assert word in said
        second, whole = xr.load_dataset("second.nc"), xr.load_dataset("whole.nc")
        xr.testing.assert_equal(second.position, whole.position.sel(time=slice(8.0, 20.0)))

    def test_names_the_result_after_the_case(self, hydrosim: Command) -> None:
        """And its picture, if one is asked for."""
        assert hydrosim("run", "free_floating.yaml", *SHORT).code == 0
        assert {"free_floating.nc"} == {path.name for path in Path().glob("free_floating.[np]*")}
        assert hydrosim("run", "free_floating.yaml", "--plot", *SHORT).code == 0
        assert Path("free_floating.png").is_file()

    def test_a_failed_simulation_is_written_all_the_same(self, hydrosim: Command) -> None:
        result = hydrosim("run", "free_floating.yaml", "-o", "run.nc", *UNSTABLE)
        assert result.code == 3
        assert result.err.startswith("case Reverse float-over, free-floating barge: 1 body, ")
        assert " by rk2 " in result.err
        assert " error at t = " in result.err
        for word in ("barge", "rod", "smaller solver.step"):
            assert word in result.err
        part = xr.load_dataset("run.nc")
        assert part.attrs["status"] == "failed"
        assert " ".join(part.attrs["status_message"].split()) in result.err
        assert part.sizes["time"] > 0

    def test_check_ends_with_1_where_a_verdict_failed(self, hydrosim: Command) -> None:
        good = hydrosim("check", "free_floating.yaml")
        assert (good.code, "failed" in good.out) == (0, False)
        bad = hydrosim("check", "free_floating.yaml", *UNSTABLE)
        assert bad.code == 1
        assert "failed The step of 0.5 s is UNSTABLE" in bad.out

    @pytest.mark.parametrize("step", [0.2, 0.4])
    def test_a_step_above_the_limit_is_refused(
        self, hydrosim: Command, project: Path, step: float
    ) -> None:
        """The message says what is unstable and what to choose; both of it is then taken. Nothing
        excites the nodes of open contacts here. So a run that is asked to warn alone measures that
        its error is small, and does not warn."""
        settings = (*SHORT, "--set", "output.step=0.8 s", "--set", f"solver.step={step} s")
        said = refusal(hydrosim, project, "run", "base.yaml", "-o", "run.nc", *settings)
        for word in (f"solver.step {step:g} s: largest stable step 0.164 s", "the contact node"):
            assert word in said
        advice = re.search(r"Choose solver\.step: ([\d.]+) s or less, .*\.$", said)
        assert advice
        assert "solver.method: dopri5" in advice[0]
        assert "solver.unstable: warn" in advice[0]
        for chosen in (f"step={advice[1]} s", "method=dopri5", "unstable=warn"):
            run = ("run", "base.yaml", "-o", "run.nc", *settings, "--set", f"solver.{chosen}")
            said = succeeds(hydrosim, *run)
            assert f"warning solver.step {step:g} s: largest stable step 0.164 s" not in said
            assert "Errors of motions are" in said

    def test_an_interrupt_leaves_what_was_computed(
        self, hydrosim: Command, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def report(self: ProgressLines, done: float, *_: Any) -> None:
            if done > 1.0:  # a chunk has at most 100 times the steps of the one before
                raise KeyboardInterrupt

        monkeypatch.setattr(ProgressLines, "report", report)
        result = hydrosim("run", "base.yaml", "-o", "run.nc", "--set", "duration=300 s")
        assert result.code == 130
        assert "interrupted" in result.out
        part = xr.load_dataset("run.nc")
        assert part.attrs["status"] == "interrupted"
        assert 1.0 <= part.time[-1] < 300.0
        assert np.isfinite(part.position).all()

    def test_an_interrupt_before_the_first_step(
        self, hydrosim: Command, project: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """While kernels are loaded or compiled there is nothing yet that could be written."""

        def load(*arguments: object) -> None:
            raise KeyboardInterrupt

        monkeypatch.setattr("hydrosim.run.course.advance_until", load)
        before = files(project)
        result = hydrosim("run", "base.yaml", "-o", "run.nc")
        assert (result.code, result.out) == (130, "")
        assert "Traceback" not in result.err
        assert files(project) == before

    @pytest.mark.parametrize("command", ["run", "check"])
    def test_brackets_in_a_title_are_not_markup(self, hydrosim: Command, command: str) -> None:
        title = ("--set", 'title="a [red] or [/b]"')
        assert "a [red] or [/b]" in succeeds(hydrosim, command, "base.yaml", *SHORT, *title)


class TestCheck:
    def test_prints_periods_and_what_is_skipped(self, hydrosim: Command, project: Path) -> None:
        before = files(project)
        said = succeeds(hydrosim, "check", "free_floating.yaml")
        assert "natural period [s]" in said
        assert "h851.nc" not in said
        details = hydrosim("check", "free_floating.yaml", "--verbose").out
        for word in ("natural period [s]", "h851.nc", "states for surge, heave, pitch"):
            assert word in details
        for dof, (low, high) in NATURAL_PERIODS.items():
            period = re.search(rf"{dof}\W+([\d.]+)", said)
            assert period
            assert low <= float(period[1]) <= high
        assert files(project) == before

    def test_says_what_is_locked(self, hydrosim: Command) -> None:
        dofs = ("--set", "bodies.barge.dofs=[surge, heave, pitch]")
        said = succeeds(hydrosim, "check", "base.yaml", *dofs, "--verbose")
        locked = "sway, roll, yaw locked, not in the state; forces in these directions exclude"
        assert locked in said

    @pytest.mark.parametrize("radiation", ["state_space", "convolution"])
    def test_says_where_a_run_starts(self, hydrosim: Command, radiation: str) -> None:
        case = ("base.yaml", "--set", f"bodies.barge.radiation={radiation}")
        assert hydrosim("run", *case, "-o", "run.nc", *SHORT).code == 0
        start = ("--set", "initial.run=run.nc")
        said = succeeds(hydrosim, "check", *case, *start, "--verbose")
        for word in ("initial run: ", "run.nc initial time: 20", "natural period [s]"):
            assert word in said
        lacking = hydrosim("check", *case, *start, "--set", "bodies.barge.dofs=[surge]")
        assert lacking.code == 2
        assert "this scene lacks heave of barge" in lacking.err


class TestPlot:
    @pytest.fixture
    def run(self, hydrosim: Command) -> Path:
        assert hydrosim("run", "base.yaml", "-o", "run.nc", *SHORT).code == 0
        return Path("run.nc")

    def test_draws_what_it_announces(self, hydrosim: Command, run: Path) -> None:
        said = succeeds(hydrosim, "plot", run, "-o", "pictures")
        pictures = sorted(Path("pictures").iterdir())
        assert Path("pictures/run.png") in pictures
        for picture in pictures:
            assert picture.read_bytes().startswith(b"\x89PNG")
            assert str(picture) in said

    @pytest.mark.parametrize(
        ("output", "said"),
        [
            ("base.yaml", "base.yaml: is a file; expected a folder"),
            ("new.svg", "found new.svg; expected a folder"),
        ],
    )
    def test_refuses_a_file_as_folder(
        self, hydrosim: Command, project: Path, run: Path, output: str, said: str
    ) -> None:
        assert said in refusal(hydrosim, project, "plot", run, "-o", output)

    @pytest.mark.parametrize("name", ["nowhere.nc", "base.yaml", "../../hydro_db/h851.nc", "."])
    def test_refuses_what_is_not_a_run(self, hydrosim: Command, project: Path, name: str) -> None:
        said = refusal(hydrosim, project, "plot", name)
        assert name in said
        assert "expected the result of" in said


BAD: dict[str, tuple[str, Sequence[str]]] = {
    "bodies.barge.hydrodynamics=nowhere.nc": ("nowhere.nc", ["no such file", "hydrodynamics"]),
    "bodies.barge.hydrodynamics=base.yaml": ("base.yaml", ["no known format", "hydrosim netCDF"]),
    "bodies.barge.mass=-1 kg": ("bodies.barge.mass", ["-1", "expected"]),
    "bodies.barge.mass=nan": ("bodies.barge.mass", ["nan", "expected"]),
    "bodies.barge.mass=1.5 m": ("bodies.barge.mass", ["1.5 m", "expected a mass"]),
    "environment.waves.peak_period=8 m": ("environment.waves.peak_period", ["8 m", "expected"]),
    "environment.water_depth=30 m": ("environment.water_depth", ["30", "inf"]),
    "solver.stepp=0.1 s": ("solver.stepp", ["unknown key", "step"]),
    "solver.step=0 s": ("solver.step", ["0 s", "expected"]),
    "solver.method=rk5": ("solver.method", ["rk5", "rk4"]),
    "duration=0 s": ("duration", ["0 s", "expected"]),
    "initial.run=nowhere.nc": ("initial.run", ["no such file", "expected the result of"]),
    "initial={run: base.yaml, time: 5 m}": ("initial.time", ["5 m", "expected a time"]),
    "initial={run: base.yaml, time: 9000 s}": ("repeat_period", ["10800", "11000", "end of the"]),
    "duration=4 hour": ("repeat_period", ["10800", "14400"]),
    "forces.deballast.time=[0 s, 500 s, 400 s]": ("forces.deballast.time", ["400", "expected"]),
    "forces.mooring.body=ship": ("forces.mooring.body", ["ship", "barge"]),
    "duration": ("--set", ["KEY=VALUE"]),
}


@pytest.mark.parametrize("setting", BAD)
def test_bad_settings_are_refused(hydrosim: Command, project: Path, setting: str) -> None:
    """One message, on the terminal's error stream, that names the key, what was found and what
    was expected; nothing is written."""
    key, words = BAD[setting]
    said = refusal(hydrosim, project, "run", "base.yaml", "-o", "run.nc", "--set", setting)
    before_it = said.partition("error ")[0]
    assert not before_it or before_it.startswith(("case ", "compiling kernels"))
    assert said.count("error ") == 1
    for word in (key, *words):
        assert word in said


@pytest.mark.slow
def test_headings_that_the_database_lacks_are_refused(hydrosim: Command, project: Path) -> None:
    """A hull without symmetry, computed for waves from astern to abeam only."""
    db = hull()
    some = db.heading < 0.5 * np.pi + 1e-9
    half = replace(
        db,
        heading=db.heading[some],
        excitation=db.excitation[:, some],
        froude_krylov=None,
        mean_drift=db.mean_drift[:, some],
        mean_drift_held=None,
        drift_imbalance=None,
        port_starboard_symmetric=False,
    )
    write_database(half, project / "hydro_db" / "half.nc")
    settings = ("--set", "bodies.barge.hydrodynamics=../../hydro_db/half.nc", *SHORT)
    from_ahead = ("--set", "environment.waves.heading=180 deg")
    said = refusal(hydrosim, project, "run", "base.yaml", *settings, *from_ahead)
    for word in ("half.nc", "heading 180 deg", "0 to 90 deg", "environment.waves.heading"):
        assert word in said
    assert hydrosim("run", "base.yaml", *settings).code == 0


def test_numbers_missing_in_the_database_are_refused(hydrosim: Command, project: Path) -> None:
    db = hull()
    holed = db.added_mass.copy()
    holed[3, 0, 0] = np.nan
    object.__setattr__(flawed := replace(db), "added_mass", holed)
    write_database(flawed, project / "hydro_db" / "h851.nc")
    said = refusal(hydrosim, project, "run", "base.yaml", "-o", "run.nc")
    assert "h851.nc: added_mass has 1 values" in said


@pytest.mark.parametrize(
    ("output", "words"),
    [
        (".", ["--output", "is a directory"]),
        ("nowhere/run.nc", ["--output", "no folder nowhere"]),
        ("base.yaml", ["--output", "base.yaml", "case file"]),
    ],
)
def test_bad_outputs_are_refused(
    hydrosim: Command, project: Path, output: str, words: Sequence[str]
) -> None:
    said = refusal(hydrosim, project, "run", "base.yaml", "-o", output)
    assert all(word in said for word in words)


@pytest.mark.parametrize("case", ["nowhere.yaml", ".", "README.md", "../../hydro_db/h851.nc"])
@pytest.mark.parametrize("command", ["run", "check"])
def test_what_is_no_case_is_refused(
    hydrosim: Command, project: Path, command: str, case: str
) -> None:
    assert case in refusal(hydrosim, project, command, case)


@pytest.mark.parametrize("arguments", [("sail",), ("run",), ("run", "base.yaml", "--fast")])
def test_wrong_usage(hydrosim: Command, arguments: Sequence[str]) -> None:
    result = hydrosim(*arguments)
    assert result.code == 2
    assert "Usage" in result.err


def test_help_names_the_commands(hydrosim: Command) -> None:
    said = succeeds(hydrosim, "--help")
    assert all(command in said for command in ("run", "check", "plot"))


def test_in_a_process_of_its_own(project: Path) -> None:
    """The exit code reaches the shell, and a message is all that people see of an error."""
    code = "from hydrosim.__main__ import main; main()"
    command = [sys.executable, "-c", code, "run", "base.yaml", "--set", "duration=0 s"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("error ")
    assert not Path("base.nc").exists()


def caused_by(error: Exception, cause: Exception) -> Exception:
    error.__context__ = cause
    return error


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (MemoryError("Unable to allocate 3 GiB"), "Unable to allocate 3 GiB"),
        (MemoryError(), "no memory is left"),
        (ImportError("a.so: failed to map segment from shared object"), "a.so: failed to map"),
        (OSError(12, "Cannot allocate memory"), "[Errno 12] Cannot allocate"),
        (caused_by(OSError("not found"), OSError("b.so: failed to map segment")), "b.so: failed"),
        (SystemError("error return without exception set"), "error return"),
    ],
)
def test_lack_of_memory_is_told(
    error: Exception, said: str, hydrosim: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever libraries make of it: no traceback, and it is not the input that is wrong."""

    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr("hydrosim.__main__.app", fail)
    result = hydrosim("run", "base.yaml")
    assert result.code == 3
    assert f"error: not enough memory ({said}" in result.err
    assert "raise the limit" in result.err


@pytest.mark.skipif(sys.platform == "win32", reason="has no such limit")
def test_a_limit_under_which_libraries_hang_is_told(
    hydrosim: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    import resource

    monkeypatch.setattr(resource, "getrlimit", lambda _: (400_000_000, resource.RLIM_INFINITY))
    result = hydrosim("check", "base.yaml")
    assert result.code == 3
    assert "error: not enough memory (the limit is 400 MB; 900 are needed)" in result.err
    assert result.out == ""


def test_other_errors_are_not_taken_for_lack_of_memory(
    hydrosim: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise caused_by(ImportError("no such module"), KeyError("key"))

    monkeypatch.setattr("hydrosim.__main__.app", fail)
    with pytest.raises(ImportError, match="no such module"):
        hydrosim("run", "base.yaml")
