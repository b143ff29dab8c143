"""Statistics of records whose figures are known."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr

from hydrosim.dofs import DOFS
from hydrosim.results.phases import contact_phases
from hydrosim.results.statistics import FEWEST, largest, lines, statistics

TIME = np.arange(0.0, 2000.0, 0.5)


def record(**motions: np.ndarray) -> xr.Dataset:
    """A run with these motions and nothing else."""
    position = np.zeros((TIME.size, 1, 6))
    for dof, x in motions.items():
        position[:, 0, DOFS.index(dof)] = x
    return xr.Dataset(
        {
            "position": (("time", "body", "dof"), position),
            "wave_elevation": ("time", np.cos(TIME)),
        },
        coords={"time": TIME, "body": ["barge"], "dof": list(DOFS)},
        attrs={"title": "known"},
    )


def of(run: xr.Dataset, dof: str, **options: Any) -> dict[str, float]:
    found = statistics(run, **options).motion.sel(body="barge", dof=dof)
    return {str(name): float(found.sel(statistic=name)) for name in found.statistic.values}


def test_sine() -> None:
    """A hundred periods of 20 s about 3 m."""
    found = of(record(heave=3.0 + 2.0 * np.sin(2 * np.pi * TIME / 20.0)), "heave")
    assert found["mean"] == pytest.approx(3.0, abs=1e-12)
    assert found["std"] == pytest.approx(np.sqrt(2.0), rel=1e-12)
    assert found["significant"] == pytest.approx(4.0 * np.sqrt(2.0), rel=1e-12)
    assert found["period"] == pytest.approx(20.0, rel=1e-9)
    assert (found["smallest"], found["largest"]) == pytest.approx((1.0, 5.0))


def test_what_is_before_the_start_does_not_count() -> None:
    x = np.where(TIME < 500.0, 100.0, np.sin(TIME))
    found = of(record(surge=x), "surge", start=500.0)
    assert found["largest"] < 1.01
    assert of(record(surge=x), "surge")["largest"] == 100.0


def test_too_few_waves_have_no_extremes() -> None:
    x = np.sin(2 * np.pi * TIME / (2000.0 / (FEWEST - 1)))
    assert np.isnan(of(record(sway=x), "sway")["maximum"])
    assert np.isnan(of(record(), "sway")["period"])


def test_largest_of_a_known_distribution() -> None:
    """Of Weibull distributed maxima the largest lies in its interval as often as it says: 90 % of
    400 samples, within four standard errors, 6 %; and its median is close to Gumbel's."""
    random, count = np.random.default_rng(11), 300
    inside, centre = [], []
    for _ in range(400):
        maxima = 1.7 * random.weibull(2.0, count)
        middle, low, high = largest(maxima)
        inside.append(low <= (1.7 * random.weibull(2.0, count)).max() <= high)
        centre.append(middle)
    assert np.mean(inside) == pytest.approx(0.9, abs=0.06)
    # the fit's own scatter is 5 %; the mean of 400 is good to a hundredth
    assert np.mean(centre) == pytest.approx(1.7 * np.sqrt(np.log(count)), rel=0.02)


def test_narrow_band_has_rayleighs_extremes() -> None:
    """The most probable largest is std sqrt(2 ln N) (Longuet-Higgins 1952), within the scatter of a
    fit to a hundred waves, over 40 seeds."""
    ratio = []
    for seed in range(40):
        random = np.random.default_rng(seed)
        omega = 0.3 + 0.05 * random.random(300)
        phase = 2 * np.pi * random.random(300)
        x = np.cos(np.outer(TIME, omega) + phase).sum(axis=1)
        found = of(record(heave=x), "heave")
        waves = TIME[-1] / found["period"]
        ratio.append(found["maximum"] / (found["std"] * np.sqrt(2 * np.log(waves))))
    assert np.mean(ratio) == pytest.approx(1.0, abs=0.05)


def test_spectrum_holds_the_variance() -> None:
    random = np.random.default_rng(3)
    x = np.convolve(random.normal(size=TIME.size + 20), np.ones(21) / 21, mode="valid")
    found = statistics(record(pitch=x))
    step = float(np.diff(found.frequency.values[:2])[0])
    variance = float(found.motion_spectrum.sel(body="barge", dof="pitch").sum()) * step
    assert variance == pytest.approx(x.var(), rel=0.15)  # eight segments and a window


def test_crawl_by_phase() -> None:
    """A body that creeps 0.5 m while its fenders knock, and none after; the place at the ends of a
    phase is a mean over a minute."""
    place = np.interp(TIME, [600.0, 1000.0], [0.0, -0.5]) + 0.1 * np.sin(2 * np.pi * TIME / 8.0)
    modes = np.full((TIME.size, 1), 0, dtype=np.int8)
    modes[(TIME >= 600.0) & (TIME % 8.0 < 4.0), 0] = 2
    modes[TIME >= 1000.0] = 1
    run = record(surge=place).assign(
        fender_mode=(("time", "fender"), modes, {"flag_meanings": "open stick slip"}),
        fender_slip_distance=(("time", "fender"), np.cumsum(modes == 2, axis=0) * 0.01),
        contact_phase=("time", contact_phases(TIME, modes)),
    )
    run = run.assign_coords(fender=["interface"])
    found = statistics(run)
    crawl = found.phase_crawl.sel(body="barge", axis="x")
    assert float(crawl.sel(phase="moored")) == pytest.approx(0.0, abs=0.03)
    assert float(crawl.sel(phase="initial contact")) == pytest.approx(-0.5, abs=0.04)
    assert float(crawl.sel(phase="stuck")) == pytest.approx(0.0, abs=0.03)
    assert float(found.fender_share.sel(fender="interface").sum()) == pytest.approx(1.0)
    assert float(found.phase_duration.sum()) == pytest.approx(TIME[-1], rel=1e-3)
    text = list(lines(found))
    assert any(line.startswith("initial contact: ") for line in text)
