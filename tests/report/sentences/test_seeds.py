"""Most probable extremes and P90 over seeds of every channel, and all figures in one table."""

import csv
import json
from typing import Any

import numpy as np
import pytest
import xarray as xr

from hydrosim.dofs import DOFS
from hydrosim.files.document_nodes import Between, Sentence, Table, Value
from hydrosim.report.sentences.statistics import extreme_nodes
from hydrosim.report.sentences.study import results_table
from hydrosim.statistics import effects
from hydrosim.statistics.gumbel import fit_maxima
from hydrosim.statistics.over_seeds import (
    EXTREME_COLUMNS,
    MIN_RUNS,
    as_csv,
    ends_of_channels,
    ends_of_figures,
    extremes_over_seeds,
)
from hydrosim.statistics.statistics import EXTREME_SIDES, STATISTIC_NAMES

SEEDS = 40
MODE, SCALE = 5e6, 4e5  # N: Gumbel's law
rng = np.random.default_rng(3)
LARGEST = np.sort(MODE - SCALE * np.log(-np.log((np.arange(SEEDS) + 0.5) / SEEDS)))
rng.shuffle(LARGEST)


def figures(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Statistics (run, statistic) of which two are known."""
    found = np.ones((low.size, len(STATISTIC_NAMES)))
    found[:, STATISTIC_NAMES.index("smallest")] = low
    found[:, STATISTIC_NAMES.index("largest")] = high
    return found


def runs_of(values: np.ndarray, count: int = SEEDS) -> xr.Dataset:
    """Runs of seeds alone with a fender, a line, a channel that was asked for, one over time."""
    plan = {"design": "grid", "samples": None, "parameters": {}}
    zero = np.zeros(count)
    motion = np.zeros((count, 1, 6, len(STATISTIC_NAMES)))
    of = figures(zero, values)[:, None]
    channel = figures(-values / 1e6, values / 1e6)[:, None]
    over_time = np.stack([zero, values / 1e7, zero - 1.0], axis=1)
    data: dict[str, Any] = {
        "motion": (("run", "body", "dof", "statistic"), motion),
        "fender_force": (("run", "fender", "statistic"), of),
        "named": (("run", "channel", "statistic"), channel),
        "unit": ("channel", ["m/s"]),
        "gap": (("run", "time"), over_time, {"units": "m"}),
        "push": ("run", values, {"units": "N", "side": "largest", "long_name": "push"}),
        "crawl": ("run", values / 1e6, {"units": "m", "long_name": "crawl"}),
    }
    coords = {
        "body": ["barge"],
        "dof": list(DOFS),
        "fender": ["pad"],
        "channel": ["speed.barge"],
        "time": [0.0, 1.0, 2.0],
        "seed": ("run", np.arange(count)),
    }
    known = {"plans": {"": plan}, "figures": ["push", "crawl"], "limits": {}}
    coords["statistic"] = list(STATISTIC_NAMES)
    return xr.Dataset(data, coords, {"design": json.dumps(known), "start": 1.0})


def tables(runs: xr.Dataset) -> list[Table]:
    (plan,) = effects.plans(runs)
    return [node for node in extreme_nodes(plan) if isinstance(node, Table)]


def test_the_most_probable_largest_and_p90_are_those_of_the_law() -> None:
    """Of values at the quantiles of Gumbel's law, within what 40 of them know of it: the mode, and
    the value below which 90 % of runs are."""
    of_figure, rare, of_channel, _ = tables(runs_of(LARGEST))
    (row,) = of_figure.rows
    assert row[:3] == ["all", "push", "largest"]
    probable, interval, another = row[3:]
    (row,) = rare.rows
    assert row[:3] == ["all", "push", "largest"]
    p90, interval_p90, by = row[3:]
    assert isinstance(probable, Value)
    assert isinstance(p90, Value)
    assert probable.number == pytest.approx(MODE, abs=0.1 * SCALE)
    assert p90.number == pytest.approx(MODE - SCALE * np.log(-np.log(0.9)), abs=0.3 * SCALE)
    assert probable.unit == "N"
    for ends, value in ((interval, MODE), (interval_p90, p90.number)):
        assert isinstance(ends, Between)
        assert ends.low < value < ends.high
    assert isinstance(another, Between)
    assert by == "Gumbel's law"
    names = [(str(r[1]), str(r[2])) for r in of_channel.rows]
    assert ("fender force pad", "largest") in names
    assert ("fender force pad", "smallest") not in names  # all zero
    assert ("speed.barge", "smallest") in names
    assert ("gap", "largest") in names
    assert of_channel.detail


def test_a_force_that_only_pushes_has_no_extreme_that_pulls() -> None:
    """Of most runs without a contact, by order, and never below zero."""
    values = np.where(np.arange(12) < 9, 0.0, LARGEST[:12])
    of_figure, _, *of_channels_ = tables(runs_of(values, 12))
    own = [r for table in of_channels_ for r in table.rows if r[1] == "fender force pad"]
    between = [cell for row in own for cell in row if isinstance(cell, Between)]
    row = own[-1]
    assert min(cell.low for cell in between) >= 0.0
    assert "order of the runs" in str(row[-1])
    assert len(of_figure.rows) == 1


def test_extremes_in_python_and_in_the_table_are_those_that_are_printed() -> None:
    runs = runs_of(LARGEST)
    of_figure, rare, *_ = tables(runs)
    probable, interval, another = of_figure.rows[0][3:]
    p90, interval_p90, _ = rare.rows[0][3:]
    assert isinstance(probable, Value)
    assert isinstance(p90, Value)
    assert isinstance(interval, Between)
    assert isinstance(another, Between)
    assert isinstance(interval_p90, Between)
    found = extremes_over_seeds(runs)
    push = found.isel(extreme=found.channel.values.tolist().index("push"))
    told = [str(push[name].values) for name in ("side", "unit", "by")]
    assert told == ["largest", "N", "Gumbel's law"]
    numbers = {
        "most_probable": probable.number,
        "most_probable_low": interval.low,
        "most_probable_high": interval.high,
        "another_low": another.low,
        "another_high": another.high,
        "p90": p90.number,
        "p90_low": interval_p90.low,
        "p90_high": interval_p90.high,
        "runs": SEEDS,
    }
    assert {name: float(push[name]) for name in numbers} == numbers
    lines = {line["figure"]: line for line in csv.DictReader(as_csv(runs).splitlines())}
    line = lines["push"]
    assert line["unit"] == "kN"
    for name in EXTREME_COLUMNS[:-1]:
        assert float(line[name]) == pytest.approx(numbers[name] / 1e3, rel=1e-5)
    assert line["by"] == "Gumbel's law"
    assert [lines["crawl"][name] for name in EXTREME_COLUMNS] == [""] * len(EXTREME_COLUMNS)


def test_p90_of_the_smallest_is_what_runs_do_not_fall_below() -> None:
    """The mirror image of the largest, of a channel that may be negative."""
    runs = runs_of(LARGEST).assign_coords(channel=["velocity.barge.surge"])
    found = extremes_over_seeds(runs)
    speed = found.isel(extreme=found.channel.values == "velocity.barge.surge")
    low, high = (float(speed.p90[speed.side.values == side][0]) for side in EXTREME_SIDES)
    assert low == pytest.approx(-high)
    _, rare, *_ = tables(runs_of(LARGEST))
    assert "do not fall below" in rare.title


def test_channels_over_time_begin_where_statistics_do() -> None:
    """The start leaves out the zero of the first record: from there the smallest is -1."""
    found = {ends.name: ends for ends in ends_of_channels(runs_of(LARGEST))}
    gap = found["gap"]
    assert gap.low is not None
    assert gap.high is not None
    assert gap.low.tolist() == [-1.0] * SEEDS
    assert gap.high.tolist() == (LARGEST / 1e7).tolist()
    assert gap.unit == "m"


def test_figures_that_are_no_extreme_have_none() -> None:
    assert [each.name for each in ends_of_figures(runs_of(LARGEST), ["push", "crawl"])] == ["push"]


def test_few_seeds_say_how_many_it_takes() -> None:
    (plan,) = effects.plans(runs_of(LARGEST[: MIN_RUNS - 1], MIN_RUNS - 1))
    (node,) = extreme_nodes(plan)
    assert isinstance(node, Sentence)
    assert list(node.parts) == [str(MIN_RUNS)]


def test_runs_that_lack_a_channel_are_left_out() -> None:
    runs = runs_of(LARGEST)
    runs["fender_force"] = runs.fender_force.where(runs.seed >= 10)
    found = {ends.name: ends for ends in ends_of_channels(runs)}
    high = found["fender force pad"].high
    assert high is not None
    assert high.tolist() == LARGEST[10:].tolist()
    assert fit_maxima(high).windows == SEEDS - 10


def test_one_table_has_a_row_for_each_value_and_the_means_of_all_figures() -> None:
    plans = {
        name: {"design": "grid", "samples": None, "parameters": {"a": ["a"]}}
        for name in ("one", "two")
    }
    runs = xr.Dataset(
        {
            "x": ("run", [1.0, 3.0, 5.0, 5.0, 7.0, np.nan, 2.0, 4.0], {"units": "m"}),
            "y": ("run", np.arange(8.0), {"units": "N"}),
        },
        {
            "study": ("run", ["one"] * 4 + ["two"] * 4),
            "a": ("run", [0.1, 0.1, 0.2, 0.2, 0.3, 0.3, 0.1, 0.1]),
        },
        {"design": json.dumps({"plans": plans, "figures": ["x", "y"], "limits": {}})},
    )
    table = next(iter(results_table(effects.plans(runs))))
    assert isinstance(table, Table)
    assert list(table.head) == ["study", "value", "x", "±", "y", "±", "runs"]
    assert [row[0] for row in table.rows] == ["one", "one", "two", "two"]
    means = [row[2].number for row in table.rows if isinstance(row[2], Value)]
    assert means == [2.0, 5.0, 7.0, 3.0]
    half = effects.seed_spread(np.array([1.0, 3.0]))
    assert isinstance(table.rows[0][3], Value)
    assert table.rows[0][3].number == half.high - half.mean
    assert table.rows[2][3] == ""  # one run has no interval
