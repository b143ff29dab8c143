"""Workability and waiting: a hindcast whose windows are known, the table of alpha factors that is
printed in DNV-OS-H101, tables and netCDF as wavespectra writes them."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from text_tables import rows

from hydrosim.errors import InputError
from hydrosim.files.text import Source
from hydrosim.statistics.weather import (
    AlphaFactors,
    Hindcast,
    LimitCurve,
    LimitSurface,
    ScatterDiagram,
    waiting,
    windows,
    workability,
)
from hydrosim.study.weather import read_hindcast, read_scatter

HOUR = 3600.0


def calm_from(*spans: tuple[int, int], hours: int = 100) -> Hindcast:
    """States of an hour each, 1 m high within the spans [h] and 3 m outside."""
    time = np.arange(hours)
    calm = np.any([(time >= a) & (time < b) for a, b in spans], axis=0)
    return Hindcast(HOUR * time, None, np.where(calm, 1.0, 3.0), np.full(hours, 8.0))


def test_windows_and_waiting_times_of_a_hindcast_that_is_known() -> None:
    """Calm from 10 to 20 h, 30 to 33 h and 60 to 90 h; for twelve hours begin at 60 to 78 h. Of
    100 h, 60 wait down to nothing, 18 nothing, 22 for ever: half of them wait no more than
    32 h (18 + 32), and 90 % never come to begin."""
    hindcast = calm_from((10, 20), (30, 33), (60, 90))
    held = hindcast.height < 2.0
    assert windows(hindcast, held, 12 * HOUR).tolist() == [[60 * HOUR, 90 * HOUR]]
    found = waiting(hindcast, held, 12 * HOUR)
    assert found.median == pytest.approx(32 * HOUR, rel=1e-14)
    assert found.p90 == np.inf
    assert (found.none, found.workable, found.startable) == pytest.approx((0.22, 0.43, 0.18))


def test_waiting_for_shorter_windows() -> None:
    """Three hours: begin at 10 to 17, 30 exactly, 60 to 87 h: gaps of 10, 13 and 30 h, 34 h at
    once, 13 h for ever. With w above 13 h 34 + 10 + 13 + w = 80 gives the 80 % quantile, 23 h."""
    hindcast = calm_from((10, 20), (30, 33), (60, 90))
    found = waiting(hindcast, hindcast.height < 2.0, 3 * HOUR)
    assert found.startable == pytest.approx(0.34)
    assert found.none == pytest.approx(0.13)
    assert found.median == pytest.approx((50 - 34) / 3 * HOUR)
    random = np.random.default_rng(1).uniform(0.0, 100.0, 200_000)
    begins = [(10.0, 17.0), (30.0, 30.0), (60.0, 87.0)]
    waits = [min((max(a - t, 0.0) for a, b in begins if t <= b), default=np.inf) for t in random]
    assert found.median / HOUR == pytest.approx(np.quantile(waits, 0.5), abs=0.1)


def test_waiting_in_parts_of_a_record_is_as_if_one_asked_at_every_moment() -> None:
    """Twelve random spells of weather; moments by the minute in two spans: their mean error is half
    a minute."""
    random = np.random.default_rng(7)
    time = HOUR * np.append(0.0, np.cumsum(random.integers(1, 40, 24)))
    held = np.arange(time.size) % 3 > 0
    hindcast = Hindcast(time, None, np.ones(time.size), np.ones(time.size))
    spans = np.array([[5.5 * HOUR, 60.25 * HOUR], [100.0 * HOUR, time[-1] - 3.0 * HOUR]])
    found = waiting(hindcast, held, 6 * HOUR, spans)
    moments = np.concatenate([np.arange(a + 30.0, b, 60.0) for a, b in spans])
    ends = [(a, b - 6 * HOUR) for a, b in windows(hindcast, held, 6 * HOUR)]
    waits = [min((max(a - t, 0.0) for a, b in ends if t <= b), default=np.inf) for t in moments]
    for value, share in ((found.median, 0.5), (found.p90, 0.9)):
        assert value == pytest.approx(np.quantile(waits, share), abs=60.0)
    assert found.none == pytest.approx(np.mean(np.isinf(waits)), abs=1e-3)
    assert found.startable == pytest.approx(np.mean(np.array(waits) == 0.0), abs=1e-3)
    of = np.searchsorted(time, moments, "right") - 1
    assert found.workable == pytest.approx(held[of].mean(), abs=1e-3)


def test_months_of_all_years_add_up_to_the_record() -> None:
    """From 20 November 2019 on for 800 days, two Novembers, Decembers and Januaries in whole; the
    February of 2020 has 29 days, that of 2022 is only begun."""
    time = 86400.0 * np.arange(801)
    date = np.datetime64("2019-11-20", "ms")
    months = dict(Hindcast(time, date, time, time).months())
    assert sorted(months) == list(range(1, 13))
    days = {month: np.ptp(spans, axis=1).sum() / 86400.0 for month, spans in months.items()}
    assert sum(days.values()) == pytest.approx(801)
    assert (days[1], days[4], days[11]) == pytest.approx((90, 60, 11 + 30 + 30))
    february = [29, 28, 801 - (11 + 31 + 366 + 365 + 31)]
    assert days[2] == pytest.approx(sum(max(each, 0) for each in february))
    assert list(Hindcast(time, None, time, time).months()) == []


def test_limits_by_heading() -> None:
    """Straight lines along a turn, also over its end; none between headings that are far apart or
    at other peak periods."""
    heading = np.radians([0.0, 30.0, 60.0, 330.0])
    height = np.array([[3.0, 2.0], [2.0, 1.0], [1.0, 0.5], [2.5, 1.5]])
    surface = LimitSurface(heading, np.array([6.0, 10.0]), height)
    asked = np.radians([0.0, 15.0, -345.0, -15.0, 345.0, 60.0, 61.0, 200.0, 330.0 - 1e-12, 15.0])
    period = np.array([6.0, 6.0, 8.0, 6.0, 10.0, 8.0, 6.0, 6.0, 6.0, 11.0])
    expected = [3.0, 2.5, 2.0, 2.75, 1.75, 0.75, np.nan, np.nan, 2.5, np.nan]
    assert surface.limit_at(asked, period) == pytest.approx(expected, nan_ok=True)
    alone = LimitSurface(heading[1:2], surface.period, height[1:2])
    assert alone.limit_at(asked[:1] + heading[1], period[:1]) == pytest.approx([2.0])
    assert np.isnan(alone.limit_at(asked[:1], period[:1])).all()


def test_workability_of_a_scatter_diagram() -> None:
    """By hand: the limit is 2 m at 6 s, 1.5 m at 8 s, 1 m at 10 s; nothing is known of 14 s."""
    curve = LimitCurve(np.array([6.0, 10.0]), np.array([2.0, 1.0]))
    count = np.array([[10, 20, 5, 5], [10, 10, 10, 0], [10, 10, 10, 0.0]])
    scatter = ScatterDiagram(np.array([0.75, 1.25, 1.75]), np.array([6.0, 8.0, 10.0, 14.0]), count)
    workable, unknown = workability(scatter, curve)
    assert workable == pytest.approx((10 + 20 + 5 + 10 + 10 + 10) / 100)
    assert unknown == pytest.approx(0.05)


DNV = AlphaFactors(
    "table 4-1 of DNV-OS-H101",
    HOUR * np.array([12.0, 24, 36, 48, 72]),
    np.array([1.0, 2, 4, 6]),
    np.array(
        [
            [0.65, 0.76, 0.79, 0.80],
            [0.63, 0.73, 0.76, 0.78],
            [0.62, 0.71, 0.73, 0.76],
            [0.60, 0.68, 0.71, 0.74],
            [0.55, 0.63, 0.68, 0.72],
        ]
    ),
)


def test_alpha_factors_are_those_of_the_table() -> None:
    """All 20 of them, lines between the heights, the next longer time between the times."""
    for planned, row in zip(DNV.planned, DNV.factors, strict=True):
        assert np.array_equal(DNV.factor(planned, DNV.heights), row)
    assert DNV.factor(6 * HOUR, np.array([1.5, 3.0, 9.0])) == pytest.approx([0.705, 0.775, 0.80])
    assert DNV.factor(13 * HOUR, np.array([2.0])) == pytest.approx([0.73])
    assert np.isnan(DNV.factor(6 * HOUR, np.array([0.9])))
    with pytest.raises(InputError, match="found 73 h; expected at most 72 h"):
        DNV.factor(73 * HOUR, np.array([2.0]))


def test_tables(tmp_path: Path) -> None:
    path = tmp_path / "scatter.csv"
    path.write_text("hs, 6, 8\n0.5, 3, 4\n1.5, 1, 2\n")
    scatter = read_scatter(Source(path))
    assert scatter.period.tolist() == [6, 8]
    assert scatter.count.tolist() == [[3, 4], [1, 2]]
    path.write_text("Hs [cm], 6, 8\n50, 3, 4\n150, 1, 2\n")
    assert read_scatter(Source(path)).height.tolist() == pytest.approx([0.5, 1.5])
    path.write_text("time [h], Tp, Hs [cm]\n0, 8, 100\n3, 9, 150\n")
    hindcast = read_hindcast(Source(path))
    assert hindcast.time.tolist() == [0, 10800]
    assert hindcast.height.tolist() == pytest.approx([1.0, 1.5])
    assert hindcast.ends.tolist() == [10800, 21600]
    assert hindcast.date is hindcast.coming is None


def test_a_table_with_dates_and_directions(tmp_path: Path) -> None:
    path = tmp_path / "hindcast.csv"
    records = "2020-02-28T21:00Z, 1, 8, 350\n2020-02-29 00:00, 2, 9, 10\n"
    path.write_text("time, hs, tp, mwd [deg]\n" + records)
    hindcast = read_hindcast(Source(path))
    assert hindcast.time.tolist() == [0, 3 * 3600]
    assert hindcast.date == np.datetime64("2020-02-28T21:00")
    assert hindcast.coming == pytest.approx(np.radians([350, 10]))
    path.write_text("time, hs, tp, dir\n" + records)
    assert read_hindcast(Source(path)).coming == pytest.approx(np.radians([350, 10]))


def test_spectra_as_wavespectra_has_them(tmp_path: Path) -> None:
    """A constant density from 0.1 to 0.2 Hz with a peak: Hs = 4 sqrt(integral), by trapezes."""
    freq, direction = np.linspace(0.05, 0.25, 21), np.arange(0.0, 360.0, 30.0)
    over_freq = np.where((freq > 0.099) & (freq < 0.201), 2.0, 0.0)
    over_freq[np.isclose(freq, 0.15)] = 3.0
    efth = np.ones((2, 1, 1)) * over_freq[None, :, None] / 360.0 * np.ones((2, 21, 12))
    time = np.array(["2020-01-01T00", "2020-01-01T01"], dtype="datetime64[ns]")
    of = ("time", "freq", "dir")
    data = xr.Dataset({"efth": (of, efth)}, {"time": time, "freq": freq, "dir": direction})
    data.to_netcdf(tmp_path / "spectra.nc")
    found = read_hindcast(Source(tmp_path / "spectra.nc"))
    assert found.time.tolist() == [0, 3600]
    area = 2.0 * 0.1 + 0.01 * (2.0 + 1.0)
    assert found.height == pytest.approx(2 * [4.0 * np.sqrt(area)], rel=1e-12)
    assert found.period == pytest.approx(2 * [1.0 / 0.15])
    xr.Dataset({"hs": ("time", [1.0, 2.0]), "tp": ("time", [7.0, 8.0])}, {"time": time}).to_netcdf(
        tmp_path / "stats.nc"
    )
    assert read_hindcast(Source(tmp_path / "stats.nc")).height.tolist() == [1, 2]


def test_directions_in_netcdf(tmp_path: Path) -> None:
    """The mean of the energy's direction; directions that waves go to are turned."""
    freq, direction = np.linspace(0.05, 0.25, 5), np.arange(0.0, 360.0, 30.0)
    spread = np.maximum(np.cos(np.radians(direction - 330.0)), 0.0) ** 4
    efth = np.ones((2, 5, 1)) * spread
    time = np.array(["2020-01-01T00", "2020-01-01T01"], dtype="datetime64[ns]")
    at = {"time": time, "freq": freq, "dir": direction}
    path = tmp_path / "hindcast.nc"
    xr.Dataset({"efth": (("time", "freq", "dir"), efth)}, at).to_netcdf(path)
    found = read_hindcast(Source(path))
    assert np.mod(found.coming, 2 * np.pi) == pytest.approx(np.radians([330.0, 330.0]))
    assert found.date == np.datetime64("2020-01-01")
    closed = np.append(direction, 360.0)
    round_again = np.concatenate([efth, efth[..., :1]], axis=-1)
    name = {"standard_name": "sea_surface_wave_to_direction", "units": "degree"}
    at = {"time": time, "freq": freq, "dir": ("dir", closed, name)}
    path = tmp_path / "closed.nc"
    xr.Dataset({"efth": (("time", "freq", "dir"), round_again)}, at).to_netcdf(path)
    going_to = read_hindcast(Source(path))
    assert np.mod(going_to.coming, 2 * np.pi) == pytest.approx(np.radians([150.0, 150.0]))
    assert going_to.height == pytest.approx(found.height, rel=1e-12)
    states = {"hs": ("time", [1.0, 2.0]), "tp": ("time", [7.0, 8.0])}
    name = {"standard_name": "sea_surface_wave_to_direction", "units": "degrees"}
    going = {"mdir": ("time", [10.0, 20.0], name)}
    other = tmp_path / "going.nc"
    xr.Dataset({**states, **going}, {"time": time}).to_netcdf(other)
    assert read_hindcast(Source(other)).coming == pytest.approx(np.radians([190.0, 200.0]))


def test_units_and_calendars_of_netcdf(tmp_path: Path) -> None:
    """Hours without a date, centimetres, a calendar of 365 days, a time axis of another name."""
    path = tmp_path / "hindcast.nc"
    height = ("time", [100.0, 200.0], {"units": "cm"})
    period = ("time", [7.0, 8.0], {"units": "s"})
    data = xr.Dataset({"hs": height, "tp": period}, {"time": ("time", [0, 3], {"units": "hours"})})
    data.to_netcdf(path)
    found = read_hindcast(Source(path))
    assert found.time.tolist() == [0, 3 * 3600]
    assert found.date is None
    assert found.height.tolist() == pytest.approx([1.0, 2.0])
    year = {"units": "days since 2001-01-01", "calendar": "noleap"}
    data.assign_coords(time=("time", [0, 1], year)).to_netcdf(tmp_path / "noleap.nc")
    other = read_hindcast(Source(tmp_path / "noleap.nc"))
    assert (other.time.tolist(), other.date) == ([0, 86400], None)
    data.rename(time="valid_time").to_netcdf(tmp_path / "valid.nc")
    wrong = data.assign(hs=("time", [1.0, 2.0], {"units": "banana"}))
    wrong.to_netcdf(tmp_path / "wrong.nc")
    with pytest.raises(InputError, match="expected m"):
        read_hindcast(Source(tmp_path / "wrong.nc"))


def test_spectra_over_a_part_of_the_circle_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "spectra.nc"
    at = {"time": [0.0, 1.0], "freq": [0.3, 0.2, 0.1], "dir": [0.0, 90.0, 180.0]}
    xr.Dataset({"efth": (tuple(at), np.ones((2, 3, 3)))}, at).to_netcdf(path)
    with pytest.raises(InputError, match="3 directions that are not evenly all around"):
        read_hindcast(Source(path))
    at["dir"] = [10.0, 130.0, 250.0]
    whole = tmp_path / "whole.nc"
    xr.Dataset({"efth": (tuple(at), np.ones((2, 3, 3)))}, at).to_netcdf(whole)
    assert read_hindcast(Source(whole)).height == pytest.approx(4.0 * np.sqrt(0.2 * 360.0))


WRONG_TABLES = r"""
  hindcast | a, b\n1, 2\n3, 4\n | expected time, hs and tp
  hindcast | time, hs, tp\n0, 1, 8\n0, 1, 8\n | :3: found time 0 s after 0 s; expected it to rise
  hindcast | time [m], hs, tp\n0, 1, 8\n1, 1, 8\n | expected it in s
  hindcast | time, hs, tp\n0, -1, 8\n1, 1, 8\n | :2: found a height of -1 in record 1
  hindcast | time, hs, tp\n2020-13-01, 1, 8\n | :2: found "2020-13-01"; expected a number, or a date
  hindcast | time, hs, tp\n2020-01-01, 1, 8\n01/02/20, 1, 8\n | or a date such as 2020-01-31T12:00
  hindcast | time, hs, tp\n0, 1, 8\n2020-01-01, 1, 8\n | :3: found a date in some lines
  hindcast | time, hs, tp, dir\n0, 1, 8, 9\n1, 1, 8, -999\n | :3: found a direction of -999 deg in
  hindcast | time, hs, tp, dir\nTWENTY | found 20 values of dir up to 5.7 and no unit.*dir \[rad\]
  hindcast | 01.02.2020 00:00, 1, 6\n | the time .s., or a date
  hindcast | time, hs, tp, dir [m]\n0, 1, 8, 9\n1, 1, 8, 9\n | expected it in deg
  scatter | hs, 6, 8\n-0.5, 3, 4\n1.5, 1, 2\n | found heights -0.5, 1.5; expected each once
  scatter | hs, 6, 6\n0.5, 3, 4\n1.5, 1, 2\n | found peak periods 6, 6; expected each once
  scatter | hs [s], 6, 8\n0.5, 3, 4\n | found hs .s.; expected it in m
  scatter | hs, 6, 8\n | expected lines of numbers, the first of them a significant height
  scatter | hs, 6, 8\n50, 3, 4\n150, 1, 2\n | heights up to 150 m; expected at most 30 m
  scatter | hs, 6, 8\n0.5, 1, 2\n1, -3, 4\n | :3: found counts that are negative
  scatter | hs, 6, 8\n0.5, 1, 2\n1, inf, 4\n | :3: found inf; expected finite
"""


@pytest.mark.parametrize(("kind", "text", "said"), rows(WRONG_TABLES))
def test_tables_that_are_none(tmp_path: Path, kind: str, text: str, said: str) -> None:
    twenty = "".join(f"{k}, 1, 8, {0.3 * k}\n" for k in range(20))
    path = tmp_path / f"{kind}.csv"
    path.write_text(text.replace("TWENTY", twenty))
    with pytest.raises(InputError, match=said):
        {"hindcast": read_hindcast, "scatter": read_scatter}[kind](Source(path))


def test_an_open_limit_makes_no_sea_beside_it_workable() -> None:
    """Limits at the largest height tried, 3 or 6 m, say the same of what lies beside them."""
    heading = np.radians([0.0, 45.0, 90.0])
    period = np.array([6.0, 8.0])
    for top in (3.0, 6.0):
        height = np.array([[top, top], [0.6, top], [top, 1.0]])
        surface = LimitSurface(heading, period, height, height >= top)
        sea = np.radians([0.0, 30.0, 45.0, 22.5, 0.0])
        found = surface.limit_at(sea, np.array([6.0, 6.0, 8.0, 8.0, 7.0]))
        np.testing.assert_allclose(found, [top, 0.6, top, top, top])
        curve = LimitCurve(period, np.array([top, 1.0]), np.array([True, False]))
        np.testing.assert_allclose(curve.limit_at(np.array([6.0, 6.5, 8.0])), [top, 1.0, 1.0])


def test_limits_that_are_known_are_interpolated_as_before() -> None:
    period = np.array([6.0, 8.0, 9.0])
    height = np.array([1.0, 2.0, 4.0])
    found = LimitCurve(period, height).limit_at(np.array([5.0, 6.0, 7.0, 8.5, 9.0, 9.1]))
    np.testing.assert_allclose(found, [np.nan, 1.0, 1.5, 3.0, 4.0, np.nan])
