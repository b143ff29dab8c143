"""`hydrosim compare`, `hydrosim export --recording`: exit codes, messages, what is written."""

import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from command_line import Command, refusal, succeeds
from recorded_runs import made_run, position, sea, write_csv
from text_tables import rows

RUN = made_run()
TIME = RUN.time.values


@pytest.fixture
def hydrosim(hydrosim: Command) -> Command:
    """Runs the command with these arguments where a run is, on a wide terminal."""
    RUN.to_netcdf("run.nc")
    return hydrosim


def test_a_run_and_its_own_recording(hydrosim: Command) -> None:
    """Written with all digits, read back bit by bit: nothing is left between them."""
    said = succeeds(hydrosim, "export", "run.nc", "--recording", "-o", "run.txt")
    assert "run.txt, 23 channels" in said
    said = succeeds(hydrosim, "compare", "run.nc", "run.txt", "--tolerance", "1e-15")
    assert "recorded in" not in said  # columns are called and measured as the channels
    assert "from 0 s to 600 s, at 3001 times" in said
    assert "times at the same times" in said
    assert "ok 0 of 23 channels are out of tolerance." in said
    residuals = xr.load_dataset("run_compare.nc")
    assert not residuals.residual.any()
    assert residuals.sizes["channel"] == 23
    assert all("print precision" in str(verdict) for verdict in residuals.verdict.values)
    assert Path("run_compare.png").read_bytes().startswith(b"\x89PNG")


def test_recording_of_some_channels(hydrosim: Command) -> None:
    some = ("--channels", "position.*.pitch, wave*", "--step", "1", "--digits", "6")
    assert hydrosim("export", "run.nc", "--recording", "-o", "some.txt", *some).code == 0
    lines = Path("some.txt").read_text().splitlines()
    assert lines[2].split() == ["time", "position.barge.pitch", "wave_elevation"]
    assert len(lines) == 4 + 601
    assert "equal to print precision" in hydrosim("compare", "run.nc", "some.txt").out


def test_planted_differences(hydrosim: Command) -> None:
    """Each is named; with a tolerance those beyond it are told, and the exit code is 1."""
    columns = {
        "time [s]": TIME,
        "surge [m]": position(RUN, "surge") + 0.05,
        "sway [m]": 1.02 * position(RUN, "sway"),
        "heave [m]": 0.8 * sea(TIME - 0.3, 12),
        "roll [rad]": np.degrees(position(RUN, "roll")),
        "pitch [rad]": -position(RUN, "pitch"),
        "wave [m]": made_run(seed=2).wave_elevation.values,
        "strain": TIME,
    }
    path = write_csv(Path("test.csv"), columns)
    said = succeeds(hydrosim, "compare", "run.nc", path, "-o", "found.nc")
    assert "Not compared (no guess: say in a mapping what they are): strain." in said
    verdicts = xr.load_dataset("found.nc").verdict
    for channel, verdict in {
        "position.barge.surge": "offset 0.05 m",
        "position.barge.sway": "gain 1.02",
        "position.barge.heave": "late by 0.300 s",
        "position.barge.roll": "degrees for radians",
        "position.barge.pitch": "sign swapped",
        "wave_elevation": "another realisation (same spectrum, no correlation): another seed?",
    }.items():
        assert str(verdicts.sel(channel=channel).values) == verdict
        assert verdict[:11] in said
    few = ("--channels", "*.surge,*.sway", "--tolerance", "0.1")
    judged = hydrosim("compare", "run.nc", path, *few, "--tolerance", "*.surge=0.2")
    assert (judged.code, "0 of 2 channels" in judged.out) == (0, True)
    strict = hydrosim("compare", "run.nc", path, *few, "--tolerance", "*.sway=0.01")
    assert (strict.code, "2 of 2 channels" in strict.out) == (1, True)
    assert re.search(r"failed position\.barge\.sway: [\d.]+, tolerance 0\.01", strict.out)


def test_mapping(hydrosim: Command) -> None:
    Path("map.yaml").write_text(
        "time: {offset: -10 s}\nchannels: {position.barge.heave: {column: 3, sign: -1, unit: mm}}\n"
    )
    columns = {"t": TIME + 10.0, "x": TIME, "y": -1e3 * position(RUN, "heave")}
    write_csv(Path("test.csv"), columns)
    options = ("-m", "map.yaml", "--tolerance", "1e-6")
    said = succeeds(hydrosim, "compare", "run.nc", "test.csv", *options)
    assert "channel column unit recorded in" in said
    assert "position.barge.heave y m mm" in said
    assert "Not compared (not in the mapping): x." in said


def test_shift_and_part_of_the_time(hydrosim: Command) -> None:
    write_csv(Path("test.csv"), {"time": TIME + 5.0, "heave [m]": position(RUN, "heave")})
    options = ("--shift", "--from", "100 s", "--to", "6.6666666666666667 min", "--bands", "0.3,2")
    again = ("compare", "run.nc", "test.csv", *options, "--tolerance", "0.001", "--verbose")
    said = succeeds(hydrosim, *again[:-1])
    assert "added to the recorded times -5.000 s (estimated)" in said
    assert "slow is below 0.3 rad/s" in hydrosim(*again).out
    time = xr.load_dataset("run_compare.nc").time
    assert 100.0 <= time[0] < 100.3
    assert 399.7 < time[-1] <= 400.0


GOOD = "time [s],heave [m]\n" + "\n".join(f"{t},0.1" for t in range(20))
BAD = {
    "ragged": (GOOD.replace("3,0.1", "3,0.1,7", 1), ["test.csv:5", "found 3 values; expected 2"]),
    "nan": (GOOD.replace("3,0.1", "3,nan", 1), ["test.csv:5", 'found nan in "heave [m]"']),
    "duplicate": (GOOD.replace("4,0.1", "3,0.1", 1), ["test.csv:6", "found time 3 s after 3 s"]),
    "gap": (
        GOOD + "\n60,0.1",
        ["test.csv:22", "found no recorded times between 19 s and 60 s", "1 s apart", "--from"],
    ),
    "unit": (GOOD.replace("[s]", "[kg]"), ["test.csv", '"kg" is another kind of quantity', "time"]),
    "empty": ("", ["test.csv", "found no numbers"]),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_recordings_are_refused(hydrosim: Command, tmp_path: Path, name: str) -> None:
    """One message with file and line, exit code 2, nothing written."""
    text, words = BAD[name]
    Path("test.csv").write_text(text)
    said = refusal(hydrosim, tmp_path, "compare", "run.nc", "test.csv")
    assert said.startswith("error ")
    for word in words:
        assert word in said


def test_a_recording_of_another_time_is_refused(hydrosim: Command, tmp_path: Path) -> None:
    write_csv(Path("test.csv"), {"time": TIME + 900.0, "heave [m]": TIME})
    said = refusal(hydrosim, tmp_path, "compare", "run.nc", "test.csv")
    assert "recorded times from 900 s to 1500 s, and a run from 0 s to 600 s" in said


@pytest.mark.parametrize(
    ("options", "message"),
    rows("""
    --tolerance 1 | --tolerance: not possible with one.nc, a file of many runs
    -m map.yaml --to 9 | --mapping, --to: not possible with one.nc, a file of many runs
    --channels position.* | --channels: not possible with one.nc, a file of many runs
    --shift --bands 0.2,2 | --shift, --bands: not possible with one.nc, a file of many runs
    --exact --from 0 | --from: not possible with --exact, which compares all variables
    --ignore seed | --ignore: found no --exact; expected both
    """),
)
def test_an_option_that_would_do_nothing_is_refused(
    hydrosim: Command, tmp_path: Path, options: str, message: str
) -> None:
    """Two files of the same four runs, which compare without them."""
    values = np.random.default_rng(2).normal(size=4)
    runs = xr.Dataset({"crawl": ("run", values), "status": ("run", ["complete"] * 4)})
    for name in ("one.nc", "other.nc"):
        runs.to_netcdf(name)
    said = refusal(hydrosim, tmp_path, "compare", "one.nc", "other.nc", *options.split())
    assert message in said
    said = succeeds(hydrosim, "compare", "one.nc", "other.nc", "-o", "found.nc", "--overwrite")
    assert "0 of 1 channels differ by more than chance" in said


@pytest.mark.parametrize(
    ("arguments", "message"),
    rows("""
    compare none.nc test.csv | none.nc: there is no such file; expected the result
    compare run.nc none.csv | none.csv: there is no such file; expected a recorded
    compare run.nc test.csv -m none.yaml | none.yaml: found no such file; expected
    compare run.nc test.csv --tolerance x=-1 | --tolerance: found '-1'
    compare run.nc test.csv --tolerance x=1 | --tolerance: found x; expected
    compare run.nc test.csv --from 60s --to 10s | \
      --to: found 10 s; expected a time after --from, which is 60 s.
    plot run.nc --from 200 --to 100 | \
      --to: found 100 s; expected a time after --from, which is 200 s.
    compare run.nc test.csv --bands 2,1 | --bands: found '2,1'; expected two
    compare run.nc test.csv -o none/x.nc | --output: there is no folder none
    compare run.nc test.csv -o run.nc | run.nc is an input
    compare run.nc test.csv -o x.png | expected a name that ends in .nc
    export run.nc --recording -o run.nc | run.nc is an input
    export run.nc --recording -o x.txt --channels pos | --channels: found pos; expec
    export run.nc --recording -o x.txt --step 0 | --step: found 0 s; expected a positive
    """),
)
def test_bad_arguments_are_refused(
    hydrosim: Command, tmp_path: Path, arguments: str, message: str
) -> None:
    Path("test.csv").write_text(GOOD)
    assert message in refusal(hydrosim, tmp_path, *arguments.split())
