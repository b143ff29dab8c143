"""The waves of a case: every kind, its keys and files, and what it becomes in the scene."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal
from text_tables import rows

from hydrosim import scene
from hydrosim.case import Case
from hydrosim.errors import InputError
from hydrosim.water.spectra import energy

Load = Callable[..., Case]
PEAK = "significant_height: 1.5 m, peak_period: 8 s"
TURN = 2 * math.pi


def case(waves: str, water: str = "") -> str:
    return (
        "title: t\nduration: 60 s\nbodies:\n  block: {mass: 2, dofs: [surge]}\n"
        f"environment: {{{water}waves: {{{waves}}}}}\n"
    )


def train(load: Load, waves: str, water: str = "") -> scene.WaveTrain:
    (only,) = load(case(waves, water)).scene().environment.waves
    return only


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (f"spectrum: torsethaugen, {PEAK}", scene.Torsethaugen(1.5, 8.0, 9.8)),
        (f"spectrum: tma, {PEAK}", scene.Tma(1.5, 8.0, 30.0, 3.3, 9.8)),
        (f"spectrum: tma, {PEAK}, peak_enhancement: 2", scene.Tma(1.5, 8.0, 30.0, 2.0, 9.8)),
        (
            f"spectrum: ochi_hubble, peaks: [{{{PEAK}}}, {{{PEAK}, shape: 3}}]",
            scene.OchiHubble((scene.OchiHubblePeak(1.5, 8.0), scene.OchiHubblePeak(1.5, 8.0, 3.0))),
        ),
    ],
)
def test_formulas(load: Load, text: str, expected: scene.Spectrum) -> None:
    assert train(load, text, "water_depth: 30 m, gravity: 9.8, ").spectrum == expected


def test_white_noise_in_hertz_or_radians(load: Load) -> None:
    keys = "spectrum: white_noise, significant_height: 1 m, lowest_frequency: 0.1 Hz,"
    spectrum = train(load, f"{keys} highest_frequency: 1.5").spectrum
    assert isinstance(spectrum, scene.WhiteNoise)
    assert (spectrum.lowest_frequency, spectrum.highest_frequency) == (TURN * 0.1, 1.5)


def test_keys_of_random_seas(load: Load) -> None:
    keys = "amplitudes: rayleigh, spreading: 12, seed: 4, repeat_period: 1 hour, heading: 90 deg"
    sea = train(load, f"spectrum: jonswap, {PEAK}, {keys}")
    assert (sea.amplitudes, sea.spreading) == (scene.Amplitudes.RAYLEIGH, 12.0)
    assert (sea.seed, sea.repeat_period, sea.heading) == (4, 3600.0, math.pi / 2)
    plain = train(load, f"spectrum: jonswap, {PEAK}")
    assert (plain.amplitudes, plain.spreading) == (scene.Amplitudes.DETERMINISTIC, None)


def test_components(load: Load) -> None:
    sea = train(
        load,
        "spectrum: components, heading: 10 deg, components: [{amplitude: 50 cm, period: 8 s,"
        " phase: 90 deg}, {amplitude: 1, frequency: 0.2 Hz, heading: -10 deg},"
        " {amplitude: 2, frequency: 0.4 rad/s}]",
    ).spectrum
    assert isinstance(sea, scene.GivenComponents)
    assert_allclose(sea.omega, [TURN / 8, TURN / 5, 0.4], rtol=1e-15)
    assert_array_equal(sea.amplitude, [0.5, 1, 2])
    assert_allclose(sea.phase, [math.pi / 2, 0, 0], rtol=1e-15)
    assert_allclose(sea.heading, np.radians([10, -10, 10]), rtol=1e-15)


@pytest.mark.parametrize(
    "text",
    [
        "frequency [Hz],amplitude [cm],phase [deg],heading [deg]\n0.125,50,90,10\n0.2,100,0,-10\n",
        "period,heading,phase,amplitude\n8,0.17453292519943295,1.5707963267948966,0.5\n"
        "5,-0.17453292519943295,0,1\n",
        "# a sea\nFrequency [rad/s];Amplitude [m];Phase [deg];Heading [rad]\n"
        f"{TURN / 8};0.5;90;{TURN / 36}\n{TURN / 5};1;0;{-TURN / 36}\n",
    ],
)
def test_components_of_a_file_are_those_of_a_list(load: Load, tmp_path: Path, text: str) -> None:
    (tmp_path / "sea.csv").write_text(text)
    listed = train(
        load,
        "spectrum: components, components: [{amplitude: 50 cm, period: 8 s, phase: 90 deg,"
        " heading: 10 deg}, {amplitude: 1, period: 5 s, heading: -10 deg}]",
    ).spectrum
    read = train(load, "spectrum: components, components: {file: sea.csv}").spectrum
    for one, other in zip(vars(listed).values(), vars(read).values(), strict=True):
        assert_allclose(one, other, rtol=1e-14)


def test_as_many_components_as_programs_write_are_read(load: Load, tmp_path: Path) -> None:
    count = 14_520
    rows = np.column_stack([np.linspace(0.1, 3.0, count), np.full(count, 0.01), np.zeros(count)])
    names = "frequency [rad/s],amplitude [m],phase [rad]"
    np.savetxt(tmp_path / "sea.csv", rows, delimiter=",", header=names, comments="")
    loaded = load(case("spectrum: components, heading: 10 deg, components: {file: sea.csv}"))
    (sea,) = loaded.scene().environment.waves
    assert isinstance(sea.spectrum, scene.GivenComponents)
    assert_allclose(sea.spectrum.omega, rows[:, 0], rtol=1e-15)
    assert_allclose(sea.spectrum.heading, np.radians(10), rtol=1e-15)
    assert tmp_path / "sea.csv" in loaded.inputs()
    resolved = loaded.scene().source["case_resolved"]
    assert f"components: {{file: {tmp_path}/sea.csv}}" in resolved


def test_components_of_a_file_take_what_is_left_out_of_the_sea(load: Load, tmp_path: Path) -> None:
    (tmp_path / "sea.csv").write_text("period,amplitude\n8,0.5\n10,1\n")
    waves = "spectrum: components, heading: 10 deg, components: {file: sea.csv}"
    sea = train(load, waves).spectrum
    assert isinstance(sea, scene.GivenComponents)
    assert_allclose(sea.omega, [TURN / 8, TURN / 10], rtol=1e-15)
    assert_array_equal(sea.phase, [0.0, 0.0])
    assert_allclose(sea.heading, np.radians([10, 10]), rtol=1e-15)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("frequency,amplitude\n1,0.5\n2,-1\n", "sea.csv:3: amplitude: found -1"),
        ("frequency,amplitude\n0,0.5\n", "sea.csv:2: frequency: found 0"),
        ("frequency,amplitude\n1,nan\n", "sea.csv:2: amplitude: found nan"),
        ("frequency,amplitude\n1,1e9\n", "it must be 1e+07 or less in SI"),
        ("amplitude\n1\n", "found neither; expected either period or frequency"),
        ("frequency\n1\n", 'found no key "amplitude"'),
        ("frequency,period,amplitude\n1,2,3\n", "found period and frequency; expected either"),
        ("frequency,amplitude,steepness\n1,2,3\n", "steepness; expected the columns frequency"),
        ("frequency,amplitude,amplitude\n1,2,3\n", "each once"),
        ("1,2,3\n", "found no names of columns; expected the columns frequency"),
        ("frequency [kg],amplitude\n1,2\n", 'frequency: found "1 kg"'),
        ("frequency,amplitude,phase\n1,2,90\n", "and no unit: degrees or radians?"),
        ("frequency,amplitude\n", "found no numbers"),
        ("", "found no numbers"),
    ],
)
def test_bad_files_of_components(load: Load, tmp_path: Path, text: str, found: str) -> None:
    (tmp_path / "sea.csv").write_text(text)
    with pytest.raises(InputError) as caught:
        load(case("spectrum: components, components: {file: sea.csv}")).scene()
    message = str(caught.value)
    assert found in message
    assert f"environment.waves.components: {tmp_path}/sea.csv" in message


def test_table(load: Load, tmp_path: Path) -> None:
    lists = "frequency: [0.1 Hz, 0.2 Hz], density: [0, 3 m^2/Hz]"
    (tmp_path / "sea.csv").write_text("f,S\n0.05,0\n0.1,0\n0.2,3\n0.3,0\n")
    keys = "frequency_factor: 1 Hz, density_factor: 1 m^2/Hz"
    for text in (lists, f"file: sea.csv, {keys}", f"file: sea.csv, column: S, {keys}"):
        table = train(load, f"spectrum: table, {text}").spectrum
        assert isinstance(table, scene.SpectrumTable)
        at = np.searchsorted(table.frequency, TURN * np.array([0.1, 0.2]) - 1e-9)
        assert_allclose(table.frequency[at], TURN * np.array([0.1, 0.2]), rtol=1e-15)
        assert_allclose(table.density[at], [0, 3 / TURN], rtol=1e-15)
    plain = train(load, "spectrum: table, frequency: [0, 1], density: [2, 3 m^2*s/rad]").spectrum
    assert isinstance(plain, scene.SpectrumTable)
    assert_array_equal(plain.density, [2, 3])


def test_recorded(load: Load, tmp_path: Path) -> None:
    (tmp_path / "probe.csv").write_text("t,eta\n" + "".join(f"{i},{i % 3}\n" for i in range(61)))
    keys = "file: probe.csv, column: eta, factor: 1 cm, position: [3 m, -4 m]"
    sea = train(load, f"spectrum: recorded, {keys}, highest_frequency: 0.3 Hz, heading: 1").spectrum
    assert isinstance(sea, scene.RecordedElevation)
    assert_array_equal(sea.time, np.arange(61.0))
    assert_allclose(sea.elevation, 0.01 * (np.arange(61) % 3), rtol=1e-15)
    assert (sea.position, sea.highest_frequency) == ((3.0, -4.0), TURN * 0.3)


def test_a_recorded_sea_may_be_the_run_of_a_case(load: Load, tmp_path: Path) -> None:
    (tmp_path / "first.yaml").write_text(case("spectrum: none"))
    keys = "spectrum: recorded, file: first.nc, case: first.yaml, column: wave_elevation"
    (stage,) = load(case(keys)).stages()
    assert stage.file == tmp_path / "first.nc"


def wavespectra_file(path: Path, **changes: object) -> xr.DataArray:
    """A sea from 240 deg with a spread of 30 deg at 0.1 Hz, at two times, as wavespectra has it."""
    freq, bearing = np.array([0.05, 0.1, 0.15, 0.2]), np.arange(0.0, 360.0, 10.0)
    away = np.mod(bearing - 240 + 180, 360) - 180
    values = np.exp(-0.5 * (away / 30) ** 2) * np.array([[0.0], [2.0], [1.0], [0.0]])
    efth = xr.DataArray(
        np.stack([values, 3 * values]),
        dims=("time", "freq", "dir"),
        coords={"time": [0.0, 1.0], "freq": freq, "dir": bearing},
        attrs={"units": "m^{2}.s.degree^{-1}"},
    )
    efth.to_dataset(name="efth").to_netcdf(path)
    return efth


@pytest.mark.parametrize(("x_axis", "heading"), [("90 deg", 30.0), ("0 deg", -60.0)])
def test_wavespectra(load: Load, tmp_path: Path, x_axis: str, heading: float) -> None:
    efth = wavespectra_file(tmp_path / "sea.nc")
    keys = f"file: sea.nc, x_axis: {x_axis}, select: {{time: 1}}, amplitudes: rayleigh"
    sea = train(load, f"spectrum: directional_table, {keys}")
    table = sea.spectrum
    assert isinstance(table, scene.DirectionalTable)
    assert sea.amplitudes is scene.Amplitudes.RAYLEIGH
    # waves from 240 deg go to 60 deg by the compass: 30 deg to the left of east, if +x is east
    weight = table.density.sum(axis=0)
    mean = np.angle(np.sum(weight * np.exp(1j * table.heading)))
    assert math.degrees(mean) == pytest.approx(heading, abs=1e-9)
    assert_allclose(np.diff(table.heading), np.radians(10.0), rtol=1e-12)
    # m0 in the units of the file, by the trapezoidal rule that a table of straight lines has
    m0 = np.trapezoid(efth[1].sum("dir") * 10.0, efth.freq)
    assert energy(table) == pytest.approx(m0, rel=1e-12)


@pytest.mark.parametrize(
    ("attributes", "turned"),
    [
        ({}, 0.0),
        ({"standard_name": "sea_surface_wave_from_direction"}, 0.0),
        ({"standard_name": "sea_surface_wave_to_direction"}, 180.0),
        ({"long_name": "direction from which waves come, relative to north"}, 0.0),
        ({"long_name": "mean wave direction, towards"}, 180.0),
    ],
)
def test_directions_that_waves_go_to(
    load: Load, tmp_path: Path, attributes: dict[str, str], turned: float
) -> None:
    """What the file says of its directions, and a circle that is closed, change no energy."""
    efth = wavespectra_file(tmp_path / "sea.nc").isel(time=0, drop=True)
    closed = xr.concat([efth, efth.isel(dir=[0]).assign_coords(dir=[360.0])], "dir")
    closed["dir"].attrs.update(attributes)
    closed.to_dataset(name="efth").to_netcdf(tmp_path / "closed.nc")
    keys = "spectrum: directional_table, x_axis: 90 deg, file:"
    first = train(load, f"{keys} sea.nc, select: {{time: 0}}").spectrum
    again = train(load, f"{keys} closed.nc").spectrum
    assert isinstance(first, scene.DirectionalTable)
    assert isinstance(again, scene.DirectionalTable)
    assert energy(again) == pytest.approx(energy(first), rel=1e-12)
    means = [
        np.angle(np.sum(table.density.sum(axis=0) * np.exp(1j * table.heading)))
        for table in (first, again)
    ]
    away = np.mod(np.degrees(means[1] - means[0]) - turned + 180.0, 360.0) - 180.0
    assert away == pytest.approx(0.0, abs=1e-9)


def test_probes(load: Load) -> None:
    text = case("spectrum: none") + "output: {wave_probes: {bow: [70 m, 0], stern: [-7e1, 1 km]}}"
    assert load(text).scene().output.wave_probes == {"bow": (70.0, 0.0), "stern": (-70.0, 1000.0)}


REFUSED = """
  jonswap, PEAK, amplitudes: random | amplitudes: found "random"; expected
  jonswap, PEAK, spreading: 0 | spreading: found 0; expected a sharpness
  jonswap, PEAK, spreading: 10 deg | spreading: found "10 deg"
  ochi_hubble, peaks: [] | peaks: found nothing in it
  white_noise, significant_height: 1, lowest_frequency: 2, highest_frequency: 0.1 Hz | \
    waves: found a band from 2 to 0.628319 rad/s; expected lowest below highest
  components, components: [{amplitude: 1, period: 1, frequency: 1}] | \
    components.0: found period and frequency; expected either
  components, components: [{amplitude: 1, frequency: 1 1/s}] | \
    components.0.frequency: found "1 1/s"; expected a frequency in rad/s
  components, components: {file: none.csv} | file: found no such file at
  components, components: {fil: a.csv} | fil: found an unknown key; expected
  table, frequency: [1, 2] | found frequency; expected frequency and density
  table, frequency: [1], density: [1] | frequency: found 1 in the list
  table, frequency: [1, 2], density: [1, 2, 3] | \
    found 2 frequencies and 3 densities; expected a density for each frequency
  table, frequency: [2, 1], density: [1, 2] | frequency: found 1 after 2; expected values that rise
  table, frequency: [1, 2], density: [1, 2 m^2*s] | \
    density.1: found "2 m^2*s"; expected a spectral density in m^2*s/rad
  table, file: none.csv | waves.file: found no such file at
  table, file: bad.csv | bad.csv: found -1; expected frequencies and densities
  directional_table, file: none.nc, x_axis: 0 | file: found no such file at
  directional_table, file: sea.nc | found no key "x_axis"; expected an angle
  directional_table, file: sea.nc, x_axis: 0 | \
    sea.nc: found 2 of time; expected one; select: {time: 0} is the first
  directional_table, file: sea.nc, x_axis: 0, select: {time: 0, site: 1} | \
    found no dimension "site"; expected one of: time
  directional_table, file: bad.csv, x_axis: 0 | bad.csv: cannot be read as netCDF
  recorded, file: none.csv, column: 2 | waves.file: found no such file at
"""


@pytest.mark.parametrize(("spectrum", "found"), rows(REFUSED.replace("PEAK", PEAK)))
def test_refused(load: Load, tmp_path: Path, spectrum: str, found: str) -> None:
    (tmp_path / "bad.csv").write_text("0.1 1\n0.2 2\n0.3 -1\n0.4 0\n")
    wavespectra_file(tmp_path / "sea.nc")
    with pytest.raises(InputError) as caught:  # by the case, or by the file that it names
        load(case(f"spectrum: {spectrum}")).scene()
    assert found in str(caught.value)


BAD_SPECTRA: dict[str, Callable[[xr.DataArray], xr.DataArray]] = {
    "densities that are negative or missing": lambda efth: efth.where(efth.dir != 30),
    r"directions unequally far apart \(10, 40 deg\); expected equal steps": lambda efth: efth.isel(
        dir=[0, 1, 5]
    ),
    "one direction alone; expected equal steps": lambda efth: efth.isel(dir=[0]),
    "0 and 360 deg, one direction, with different densities; expected each": lambda efth: xr.concat(
        [efth, efth.isel(dir=[24]).assign_coords(dir=[360.0])], "dir"
    ),
    "no values of freq or dir; expected efth over": lambda efth: efth.drop_vars("dir"),
    "dir in rad; expected deg, as wavespectra has it": lambda efth: told(efth, "dir", units="rad"),
    "freq in rad/s; expected Hz, as wave": lambda efth: told(efth, "freq", units="rad/s"),
    'dir with long_name "to direction, from direction"; expected either from or to': (
        lambda efth: told(efth, "dir", long_name="to direction, from direction")
    ),
    "frequencies that do not rise": lambda efth: efth.isel(freq=slice(None, None, -1)),
    "frequencies that do not ri": lambda efth: efth.isel(freq=[0]),
    "efth in m2 s/rad; expected": lambda efth: efth.assign_attrs(units="m2 s/rad"),
    "the variables efth; expected efth over": lambda efth: efth.rename(freq="frequency"),
}


def told(efth: xr.DataArray, dim: str, **attributes: str) -> xr.DataArray:
    """With other attributes of a coordinate."""
    return efth.assign_coords({dim: efth[dim].assign_attrs(attributes)})


@pytest.mark.parametrize("found", BAD_SPECTRA)
def test_bad_spectra_over_direction(load: Load, tmp_path: Path, found: str) -> None:
    efth = wavespectra_file(tmp_path / "unused.nc")[0]
    BAD_SPECTRA[found](efth).to_dataset(name="efth").to_netcdf(tmp_path / "sea.nc")
    with pytest.raises(InputError, match=f"found {found}"):
        load(case("spectrum: directional_table, file: sea.nc, x_axis: 90 deg")).scene()
