"""Means of forces that change between records: by impulses, and told."""

import re

import numpy as np
import pytest
import xarray as xr
from reading import number, row, texts
from scenes import in_contact

import hydrosim as hs
from hydrosim.dofs import DOFS
from hydrosim.report.sentences.statistics import figures, statistics_nodes, statistics_of
from hydrosim.statistics.figures import ScalarResult, figure_of
from hydrosim.statistics.statistics import statistics

CHANNEL = "force_line.barge.surge"
TIME = np.arange(0.0, 400.0, 0.5)
SURGE = 50.0 * np.sin(0.7 * TIME)


def run_of(recorded: np.ndarray, impulse: np.ndarray) -> xr.Dataset:
    """A run with a force in surge, and its impulse."""
    dims = ("time", "body", "dof")
    force = np.zeros((TIME.size, 1, 6))
    force[:, 0, 0] = recorded
    integral = np.zeros((TIME.size, 1, 1, 6))
    integral[:, 0, 0, 0] = impulse
    return xr.Dataset(
        {
            "position": (dims, np.zeros_like(force)),
            "wave_elevation": ("time", SURGE),
            "force_line": (dims, force, {"dof_units": ", ".join(3 * ["N"] + 3 * ["N m"])}),
            "impulse": (("time", "force", "body", "dof"), integral),
        },
        coords={"time": TIME, "body": ["barge"], "dof": list(DOFS), "force": ["line"]},
        attrs={"title": "known", "wave_ramp": 0.0},
    )


def mean_of(found: xr.Dataset, statistic: str = "mean", channel: str = CHANNEL) -> float:
    return float(found.named.sel(channel=channel, statistic=statistic))


def test_a_force_that_chatters_has_the_mean_of_its_impulse() -> None:
    """Of 100 N and 0 N by turns every 0.25 s, records each 0.5 s see 100 N alone; 50 N is true."""
    impulse = 50.0 * TIME + 50.0 / 0.7 * (1.0 - np.cos(0.7 * TIME))
    run = run_of(100.0 + SURGE, impulse)
    found = statistics(run, channels=[CHANNEL])
    whole = (impulse[-1] - impulse[0]) / TIME[-1]
    assert mean_of(found) == pytest.approx(whole, abs=0.2)
    assert mean_of(found, "first_mean") == pytest.approx(50.0, abs=2.0)
    assert float(found.named_recorded_mean.sel(channel=CHANNEL)) == pytest.approx(100.0, abs=0.5)
    said = list(figures(found))
    moments = row(said, "channel", "mean", of=[CHANNEL])
    assert number(moments["mean"], "N") == mean_of(found)
    told = re.match(
        rf"warning: {CHANNEL}: this mean is by impulses; the mean of the records is (\S+) kN\.",
        texts(said)[0],
    )
    assert told is not None
    assert float(told[1]) == pytest.approx(0.1, abs=0.5e-3)
    assert "use a smaller solver.step" in texts(said)[0]
    figure = figure_of(run, ScalarResult("push", CHANNEL, "mean"))
    assert float(figure) == pytest.approx(whole, abs=0.2)
    assert figure.attrs["units"] == "N"


def test_a_smooth_force_has_the_mean_of_its_records() -> None:
    run = run_of(100.0 + SURGE, 100.0 * TIME + 50.0 / 0.7 * (1.0 - np.cos(0.7 * TIME)))
    found = statistics(run, channels=[CHANNEL])
    assert mean_of(found) == (100.0 + SURGE).mean()
    assert "named_recorded_mean" not in found
    assert "impulses" not in "\n".join(texts(figures(found)))


def test_knocks_between_records_count() -> None:
    """Of one run recorded every 5 s the mean contact forces are those that records every 0.05 s
    have, group and points alike."""
    scene = in_contact(90.0, step=0.05).with_output(impulses=True)
    fine = hs.simulate(scene.with_output(step=0.05))
    coarse = hs.simulate(scene.with_output(step=5.0))
    name = "force_interface.barge.heave"
    found = statistics(coarse, channels=[name])
    values = fine.force_interface.sel(body="barge", dof="heave").values
    expected = np.trapezoid(values, fine.time.values) / 90.0
    mean = mean_of(found, channel=name)
    assert mean == pytest.approx(expected, rel=1e-3)
    assert abs(found.named_recorded_mean.item() / expected - 1.0) > 0.02
    normal = fine.fender_normal_force.transpose("time", "fender").values
    expected = np.trapezoid(normal, fine.time.values, axis=0) / 90.0
    still = coarse.assign_attrs(wave_ramp=0.0)
    page = texts(statistics_nodes(still, statistics_of(still)))
    assert any("this mean is by impulses" in line for line in page)
    each = found.fender_force.sel(statistic="mean").values
    np.testing.assert_allclose(each, expected, rtol=2e-3)
