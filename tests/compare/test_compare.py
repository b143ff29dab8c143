"""Planted differences are named for what they are; times, units, points; figures by hand."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose
from reading import texts
from recorded_runs import SIZE, made_run, position, sea, write_csv

from hydrosim.compare import Comparison, MappingFile, compare
from hydrosim.compare.align import precision_of
from hydrosim.compare.comparison import CONFUSED_UNITS, UNIT_GAIN_TOLERANCE, exceeded_tolerances
from hydrosim.compare.dataset import to_dataset
from hydrosim.dofs import DOFS
from hydrosim.errors import InputError
from hydrosim.files.recordings import read_recording
from hydrosim.files.units import factor
from hydrosim.report.sentences.comparison import comparison_tables

RUN = made_run()
TIME = RUN.time.values
Against = Callable[..., Comparison]


@pytest.fixture
def against(tmp_path: Path) -> Against:
    """Compares the run with columns beside its times, or the times in a column called time."""

    def against(columns: dict[str, np.ndarray], channels: object = None, **options) -> Comparison:
        options.update(options.pop("how", {}))
        times = {} if "time" in columns else {"time": TIME}
        path = write_csv(tmp_path / "data.csv", times | columns, options.pop("fmt", "%.9e"))
        mapping = None
        if channels is not None or "time" in options:
            given = {"time": options.pop("time", {}), "channels": channels}
            mapping = MappingFile.model_validate(given)
        return compare(options.pop("run", RUN), read_recording(path), mapping, **options)

    return against


def moved(dof: str, lag: float) -> np.ndarray:
    """The motion of the barge some seconds earlier, exactly."""
    return SIZE[dof] * sea(TIME - lag, 10 + DOFS.index(dof))


HEAVE, PITCH = position(RUN, "heave"), position(RUN, "pitch")
NOISE = np.random.default_rng(5).normal(size=TIME.size)
PLANTED = {
    "gain": ("heave [m]", 1.02 * HEAVE, "gain 1.02"),
    "lag": ("heave [m]", moved("heave", 0.3), "late by 0.300 s"),
    "early": ("heave [m]", moved("heave", -0.3), "early by 0.300 s"),
    "offset": ("heave [m]", HEAVE + 0.05, "offset 0.05 m"),
    "angle": ("pitch [rad]", PITCH + np.radians(0.5), "offset 0.5 deg"),
    "sign": ("pitch [rad]", -PITCH, "sign swapped"),
    "degrees": ("pitch [rad]", np.degrees(PITCH), "degrees for radians"),
    "radians": ("pitch [deg]", PITCH, "radians for degrees"),
    "millimetres": ("heave [m]", 1e3 * HEAVE, "mm for m"),
    "kilonewtons": ("fender 1 [N]", RUN.fender_normal_force.values[:, 0] / 1e3, "kN for N"),
    "tonnes": ("fender 1 [N]", RUN.fender_normal_force.values[:, 0] / 9810, "tonne-force for N"),
    "two": ("heave [m]", 1.02 * moved("heave", 0.05), "gain 1.02, late by 0.050 s"),
    "three": (
        "pitch [rad]",
        -np.degrees(moved("pitch", 0.3)),
        "sign swapped, degrees for radians, late by 0.300 s",
    ),
    "seed": (
        "wave [m]",
        made_run(seed=2).wave_elevation.values,
        "another realisation (same spectrum, no correlation): another seed?",
    ),
    "steeper": ("wave [m]", 3.0 * made_run(seed=2).wave_elevation.values, "different (correlation"),
    "noise": (
        "heave [m]",
        HEAVE + 0.2 * np.std(HEAVE) * NOISE,
        "differs by 19.5 % of the std, mostly fast",
    ),
    "drift": ("heave [m]", HEAVE + 0.2 * np.sin(0.02 * TIME), "mostly slow"),
    "still": ("heave [m]", np.zeros(TIME.size), "constant in the recording"),
    "nothing": ("heave [m]", HEAVE * (1.0 + 2e-4), "equal within 0.02 % of the std"),
}


@pytest.mark.parametrize("name", PLANTED)
def test_planted_differences_are_named(against: Against, name: str) -> None:
    column, values, verdict = PLANTED[name]
    (result,) = against({column: values}).results.values()
    assert verdict in result.verdict
    if name not in ("drift", "steeper"):
        assert result.verdict == verdict


@pytest.mark.parametrize("unit", CONFUSED_UNITS)
def test_units_that_are_taken_for_ours(unit: str) -> None:
    """All of them are units, of the same kind, and more than the tolerance of a gain apart."""
    sizes = sorted(
        factor(other, unit) ** sign for other in CONFUSED_UNITS[unit] for sign in (1, -1)
    )
    assert min(np.diff(np.log([*sizes, 1e12]))) > 2 * UNIT_GAIN_TOLERANCE
    assert min(np.abs(np.log(sizes))) > 2 * UNIT_GAIN_TOLERANCE


def test_pairs_of_causes_are_not_seen_in_each_other(against: Against) -> None:
    """A gain on a motion with a mean is no offset, and an offset on one that drifts is no gain."""
    (gain,) = against(
        {"x": 1.02 * RUN.fender_compression.values[:, 0]}, {"fender_compression.interface 1": "x"}
    ).results.values()
    assert gain.verdict == "gain 1.02"


@pytest.mark.parametrize("mapped", [True, False])
@pytest.mark.parametrize(
    ("gain", "offset", "noise", "verdict"),
    [
        (1.05, 0.0, 0.0, "gain 1.05"),
        (0.97, 0.0, 0.1, "gain 0.97"),
        (1.0, 5e4, 0.0, "offset 5e+04 N"),
        (1.0, 5e4, 0.1, "offset 5e+04 N"),
        (1.05, -2e5, 0.0, "gain 1.05, offset -2e+05 N"),
    ],
)
def test_a_gain_on_a_tension_with_a_large_mean(
    against: Against, mapped: bool, gain: float, offset: float, noise: float, verdict: str
) -> None:
    """A pretension of 1 MN and waves of 10 kN; noise is in tenths of what the gain adds."""
    tension = 1e6 + 1e4 * sea(TIME, 3)
    run = RUN.assign(fender_normal_force=RUN.fender_normal_force.copy(deep=True))
    run.fender_normal_force[:, 0] = tension
    scatter = noise * abs(gain - 1.0 or 0.03) * 1e4 * NOISE
    recorded = gain * tension + offset + scatter
    channel = f"fender_normal_force.{run.fender.values[0]}"
    columns, channels = (
        ({"TEN-1": recorded}, {channel: "TEN-1"}) if mapped else ({channel: recorded}, None)
    )
    (result,) = against(columns, channels, run=run).results.values()
    said = [part for part in result.verdict.split(", ") if "left" not in part]
    assert ", ".join(said) == verdict


@pytest.mark.parametrize("digits", [4, 6, 12])
def test_print_precision(against: Against, digits: int) -> None:
    """Half a unit of the last digit of the largest value, whatever the numbers are printed as."""
    columns = {"heave [m]": HEAVE, "pitch [rad]": PITCH, "wave [m]": RUN.wave_elevation.values}
    found = against(columns, fmt=f"%.{digits - 1}e")
    assert len(found.results) == 3
    for result in found.results.values():
        assert result.verdict.startswith("equal to print precision")
        largest = np.abs(result.pair.recorded).max()
        half = 0.5 * 10.0 ** (np.floor(np.log10(largest)) - digits + 1)
        assert result.pair.precision == pytest.approx(half, rel=1e-6)
        assert 0.5 * half < result.figures.peak <= 1.001 * half


def test_precision_of_fixed_decimals() -> None:
    printed = np.round(RUN.wave_elevation.values, 3)
    assert precision_of(printed) == pytest.approx(5e-4)
    assert precision_of(RUN.wave_elevation.values) < 1e-15
    assert precision_of(np.full(20, 12.0)) < 1e-14


@pytest.mark.parametrize("size", [0.1, 0.4])
def test_other_waves_on_a_like_drift_are_said_of_waves_alone(against: Against, size: float) -> None:
    """A slow motion that is the same, with waves of another seed on it: a correlation of
    1 / (1 + size^2) of the whole, and none of the waves."""
    slow = np.sqrt(2.0) * np.sin(2 * np.pi * TIME / 120.0)
    wave, other = (size * sea(TIME, seed) / np.std(sea(TIME, seed)) for seed in (3, 4))
    run = RUN.copy(deep=True)
    run.position.loc[{"dof": "surge"}] = (slow + wave)[:, None]
    (result,) = against({"surge [m]": slow + other}, run=run).results.values()
    assert result.fit.correlation == pytest.approx(1.0 / (1.0 + size**2), abs=0.03)
    assert result.verdict.startswith("differs by")
    share = 100.0 * size / np.sqrt(1.0 + size**2)
    said = re.search(r"; its waves, (\S+) % of the std, are another realisation$", result.verdict)
    assert said is not None
    assert float(said[1]) == pytest.approx(share, rel=0.1)


class TestTimes:
    def test_finer_recording_is_interpolated(self, against: Against) -> None:
        """At the run's times: a cubic spline through steps of h = 0.07 s misses a wave of
        1 rad/s by (w h)^4 / 384."""
        fine = 0.07 * np.arange(8000)
        found = against({"time": fine, "heave [m]": SIZE["heave"] * sea(fine, 12)})
        (result,) = found.results.values()
        assert found.overlap.method == "at the times of the run, the recording by cubic splines"
        assert found.overlap.time[-1] == pytest.approx(559.8)
        assert result.figures.relative < 1e-6

    def test_coarser_recording_is_met(self, against: Against) -> None:
        coarse = 10.05 + 0.5 * np.arange(1100)
        found = against({"time": coarse, "heave [m]": SIZE["heave"] * sea(coarse, 12)})
        (result,) = found.results.values()
        assert found.overlap.method == "at the recorded times, the run by cubic splines"
        assert_allclose(found.overlap.time, coarse)
        assert result.figures.relative < 1e-4

    def test_units_and_offset(self, against: Against) -> None:
        columns = {"time": (TIME + 100.0) / 60.0, "z": HEAVE}
        time = {"unit": "min", "offset": -100.0}
        (result,) = against(columns, {"position.barge.heave": "z"}, time=time).results.values()
        assert result.figures.rms < 1e-6  # the minutes have 10 digits

    @pytest.mark.parametrize("how", [{"shift": True}, {"time": {"shift": True}}])
    def test_shift_is_estimated(self, against: Against, how: dict) -> None:
        """Beyond what is looked for as lag of a channel."""
        columns = {"time": TIME + 72.3, "heave": HEAVE, "pitch": PITCH}
        channels = {"position.barge.heave": "heave", "position.barge.pitch": "pitch"}
        found = against(columns, channels, how=how)
        assert found.shift == pytest.approx(-72.3, abs=1e-3)
        assert all(result.figures.relative < 1e-3 for result in found.results.values())

    def test_no_shift_is_told(self, against: Against) -> None:
        found = against({"heave": NOISE}, {"position.barge.heave": "heave"}, shift=True)
        assert np.isnan(found.shift)

    def test_part_of_the_time(self, against: Against) -> None:
        wrong = np.where(TIME < 200.0, 7.0, HEAVE)
        (result,) = against({"heave [m]": wrong}, between=(200.0, 500.0)).results.values()
        assert result.verdict.startswith("equal to print precision")


def test_units_sign_and_offset(against: Against) -> None:
    columns = {"z": 4.0 - 100.0 * HEAVE}
    place = {"column": "z", "unit": "cm", "sign": -1, "offset": "4 cm"}
    (result,) = against(columns, {"position.barge.heave": place}).results.values()
    assert result.verdict.startswith("equal to print precision")


def test_motion_of_another_point(against: Against) -> None:
    """Where a point goes, by three rotations one after the other, and how fast, by differences."""
    point = np.array([80.0, 5.0, 7.5])
    roll, pitch, yaw = (position(RUN, dof) for dof in DOFS[3:])
    x, y, z = point[:, None] * np.ones(TIME.size)
    y, z = np.cos(roll) * y - np.sin(roll) * z, np.sin(roll) * y + np.cos(roll) * z
    x, z = np.cos(pitch) * x + np.sin(pitch) * z, -np.sin(pitch) * x + np.cos(pitch) * z
    x, y = np.cos(yaw) * x - np.sin(yaw) * y, np.sin(yaw) * x + np.cos(yaw) * y
    columns = {
        "surge": position(RUN, "surge") + x - point[0],
        "sway": position(RUN, "sway") + y - point[1],
        "heave": position(RUN, "heave") + z - point[2],
        "roll": roll,
    }
    places = {f"position.barge.{name}": {"column": name, "point": list(point)} for name in columns}
    found = against(columns, places)
    for result in found.results.values():
        assert result.verdict.startswith("equal to print precision")
    still = against(columns, {"position.barge.heave": "heave"}).results["position.barge.heave"]
    assert still.figures.relative > 0.5


def test_velocity_of_another_point(against: Against) -> None:
    """omega x r of a small rotation: the run's velocities are rates of its angles, which differ
    from the angular velocity by products of angles of 0.03."""
    arm, rate = 50.0, RUN.velocity.sel(body="barge", dof="pitch").values
    columns = {"w": RUN.velocity.sel(body="barge", dof="heave").values - arm * rate}
    place = {"column": "w", "point": [arm, 0.0, 0.0]}
    (result,) = against(columns, {"velocity.barge.heave": place}).results.values()
    assert result.figures.relative < 0.05


class TestFigures:
    def test_of_a_known_difference(self, against: Against) -> None:
        """Ours minus recorded is 0.1 + a spike: mean, rms and peak by hand; drift of a ramp."""
        wrong = HEAVE - 0.1
        wrong[1000] -= 2.0
        figures = against({"heave [m]": wrong}).results["position.barge.heave"].figures
        n = TIME.size
        assert figures.peak == pytest.approx(2.1)
        assert figures.peak_time == pytest.approx(TIME[1000])
        assert figures.mean == pytest.approx(0.1 + 2.0 / n, abs=1e-8)
        assert figures.rms == pytest.approx(np.sqrt(0.01 + (2.1**2 - 0.01) / n), rel=1e-6)
        assert figures.relative == pytest.approx(figures.rms / np.std(wrong), rel=1e-6)

    def test_drift(self, against: Against) -> None:
        """A ramp of 1 m in all rises by 0.9 m from the first tenth to the last."""
        ramp = TIME / TIME[-1]
        figures = against({"heave [m]": HEAVE - ramp}).results["position.barge.heave"].figures
        assert figures.drift == pytest.approx(0.9, abs=1e-3)

    def test_bands(self, against: Against) -> None:
        more = HEAVE + 0.1 * np.sin(5.0 * TIME)
        figures = against({"heave [m]": more}).results["position.barge.heave"].figures
        assert_allclose(figures.band_rms, [0.0, 0.0, 0.1 / np.sqrt(2)], atol=2e-3)
        assert figures.band_ours[1] == pytest.approx(figures.band_recorded[1], rel=0.01)

    def test_contact(self, against: Against) -> None:
        """First contact is where the made force begins, 20 s later in the recording."""
        force = RUN.fender_normal_force.values[:, 0]
        later = np.where(TIME < TIME[np.argmax(force > 1e4)] + 20.0, 0.0, force)
        contact = (
            against({"fender 1 [N]": later}).results["fender_normal_force.interface 1"].contact
        )
        assert contact is not None
        touching = force > 1e-3 * force.max()
        assert contact.first_ours == pytest.approx(TIME[np.argmax(touching)])
        assert contact.first_recorded >= contact.first_ours + 19.0
        assert contact.share_ours == pytest.approx(np.mean(touching))
        assert contact.share_recorded < contact.share_ours


def test_tolerances(against: Against) -> None:
    """Over the std; absolute for what is constant; the last that fits holds."""
    columns = {"heave": 1.02 * HEAVE, "pitch": PITCH, "x": np.full(TIME.size, 1.1e6)}
    names = {
        "position.barge.heave": "heave",
        "position.barge.pitch": "pitch",
        "energy_kinetic": "x",
    }
    found = against(columns, names)
    assert exceeded_tolerances(found, {"*": 0.025, "energy_kinetic": 1.1e5}) == {}
    assert exceeded_tolerances(found, {"*": 0.01}) == {
        "position.barge.heave": 0.01,
        "energy_kinetic": 0.01,
    }
    assert exceeded_tolerances(found, {"*": 0.01, "position.*": 0.03, "energy_kinetic": 9e4}) == {
        "energy_kinetic": 9e4
    }
    with pytest.raises(InputError, match=r"^tolerance: found position\.barge\.heeve; expected"):
        exceeded_tolerances(found, {"position.barge.heeve": 0.1})


def test_dataset(against: Against, tmp_path: Path) -> None:
    found = against({"heave [m]": HEAVE + 0.05, "fender 1 [kN]": NOISE})
    to_dataset(found, {"run": "run.nc"}).to_netcdf(tmp_path / "found.nc")
    read = xr.load_dataset(tmp_path / "found.nc").sel(channel="position.barge.heave")
    assert_allclose(read.residual, -0.05, atol=1e-8)
    assert_allclose(read.ours - read.recorded, read.residual, atol=1e-15)
    assert (str(read.units.values), str(read.verdict.values)) == ("m", "offset 0.05 m")
    assert read.attrs["run"] == "run.nc"


def test_channels_are_counted_by_their_differences(against: Against) -> None:
    """Gains of 1.02 and 1.0002 on motions without a mean: 2 % and 0.02 % of the std."""
    heave, pitch = HEAVE - HEAVE.mean(), PITCH
    found = against({"heave [m]": HEAVE + 0.02 * heave, "pitch [rad]": (1.0 + 2e-4) * pitch})
    (text,) = (
        text
        for text in texts(comparison_tables(to_dataset(found, {"run": "run.nc"})).nodes)
        if "rms difference" in text
    )
    assert "std of the recording: 1 below 0.1 %, 1 from 1 to 10 % (2 in all)." in text


def test_zero_and_unused_are_listed(against: Against) -> None:
    zero = np.zeros(TIME.size)
    found = against({"heave [m]": HEAVE, "lift heave": zero, "who": zero})
    assert found.zero == ["force_lift.barge.heave"]
    assert found.unused == ["who"]
    assert found.guessed


HOLED = np.where(TIME == TIME[700], np.nan, HEAVE)
STOPPED = np.where(np.arange(TIME.size) < 10, TIME, TIME + 30.0)
TWICE = np.where(np.arange(TIME.size) == 50, TIME[49], TIME)
PLACE = {"position.barge.heave": "heave"}


def mapped(**keys: object) -> dict[str, object]:
    """A mapping of heave to its column, with more keys."""
    return {"channels": {"position.barge.heave": {"column": "heave", **keys}}}


NO_POINT = {"wave_elevation": {"column": "heave", "point": [1.0, 0.0, 0.0]}}
BAD = {  # columns beside heave, what else is asked for, and the message
    "nan": ({"heave": HOLED}, {}, r'data\.csv:702: found nan in "heave"; expected finite'),
    "gap": (
        {"time": STOPPED},
        {},
        r"data\.csv:12: found no recorded times between 1\.8 s and 32 s;",
    ),
    "gap's size": ({"time": STOPPED}, {}, r"expected times about 0\.2 s apart"),
    "duplicate": (
        {"time": TWICE},
        {},
        r"data\.csv:52: found time 9\.8 s after 9\.8 s; expected it",
    ),
    "apart": ({"time": TIME + 1e3}, {}, "from 1000 s to 1600 s, and a run from 0 s to 600 s;"),
    "overlap": (
        {"time": TIME + 1e3},
        {},
        "an overlap with at least 10 times of each; give the off",
    ),
    "asked": ({}, {"between": (700.0, 800.0)}, r"requested: 700 s to 800 s.*with --from and --to"),
    "kind": (
        {},
        mapped(unit="kN"),
        r'"kN" is another kind of quantity; expected a unit of the kin',
    ),
    "place": (
        {},
        mapped(unit="kN"),
        r'for position\.barge\.heave from the column "heave"; give th',
    ),
    "offset": ({}, mapped(offset="2 deg"), r'"deg" is another kind of quantity; expected a unit'),
    "time": ({}, {"time": {"unit": "m"}}, r'"m" is another kind.*expected s'),
    "column": ({}, {"channels": {"wave_elevation": "heeve"}}, r'found no column "heeve"'),
    "channel": (
        {},
        {"channels": {"position.barge.heeve": "heave"}},
        r'channels\.position\.barge\.heeve: .*no selection from position "heeve".*mean "heave"',
    ),
    "point": ({}, {"channels": NO_POINT}, "found a point for wave_elevation; expected one for pos"),
    "only": ({}, {"only": ["wave*"]}, r"channels: found wave\*; expected"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_recordings(against: Against, name: str) -> None:
    """One message: file and line, what was found, what was expected."""
    columns, options, message = BAD[name]
    with pytest.raises(InputError, match=message) as caught:
        against({"heave": HEAVE} | columns, **{"channels": PLACE, **options})
    assert "\n" not in str(caught.value)


def test_columns_of_which_none_is_a_channel(against: Against) -> None:
    with pytest.raises(InputError, match=r"no column that matches a channel.*among time, who"):
        against({"who": HEAVE})


def test_what_is_not_compared_may_be_wrong(against: Against) -> None:
    """Numbers missing in other columns, or outside of the times, do no harm."""
    columns = {"heave": np.where(TIME < 100.0, np.nan, HEAVE), "other": HOLED}
    (result,) = against(columns, PLACE, between=(100.0, 600.0)).results.values()
    assert result.verdict.startswith("equal to print precision")
