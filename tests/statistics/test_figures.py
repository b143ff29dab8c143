"""Figures of a run: statistics of its channels, of all times and of a phase."""

import numpy as np
import pytest
import xarray as xr

from hydrosim.errors import InputError
from hydrosim.statistics.figures import ScalarResult, figure_of

TIME = np.arange(6.0)
X = np.array([0.0, 1.0, -3.0, 2.0, 4.0, -1.0])


@pytest.fixture
def run() -> xr.Dataset:
    position = np.zeros((6, 1, 1))
    position[:, 0, 0] = X
    return xr.Dataset(
        {
            "position": (("time", "body", "dof"), position, {"units": "m or rad"}),
            "contact_phase": (("time", "contact_group"), np.array([[0, 0, 1, 1, 1, 2]]).T),
        },
        {"time": TIME, "body": ["barge"], "dof": ["surge"], "contact_group": ["interface"]},
    )


@pytest.mark.parametrize(
    ("statistic", "phase", "expected"),
    [
        ("end", None, -1.0),
        ("end_absolute", None, 1.0),
        ("change", "initial contact", 7.0),
        ("change_absolute", None, 1.0),
        ("largest_absolute", "initial contact", 4.0),
        ("mean", None, 0.5),
        ("smallest", "moored", 0.0),
        ("std", "moored", 0.5),
        ("largest", "stuck", np.nan),
    ],
)
def test_figures(run: xr.Dataset, statistic: str, phase: str | None, expected: float) -> None:
    found = figure_of(run, ScalarResult("a", "position.barge.surge", statistic, phase))
    assert float(found) == pytest.approx(expected, nan_ok=True)
    assert found.attrs["units"] == "m"


def test_crawl_counts_from_where_a_run_begins_and_the_end_from_the_place_at_rest(
    run: xr.Dataset,
) -> None:
    """A body that begins 3 m off, and ends 4 m off to the other side, has crawled 7 m."""
    moved = run.assign(position=run.position - 3.0 + 6.0 * (run.time == 0.0))
    moved.position.attrs["units"] = "m"
    channel = "position.barge.surge"
    assert float(figure_of(moved, ScalarResult("a", channel, "end_absolute"))) == 4.0
    assert float(figure_of(moved, ScalarResult("a", channel, "change_absolute"))) == 7.0
    assert float(figure_of(moved, ScalarResult("a", channel, "change"))) == -7.0
    assert (
        str(ScalarResult("a", channel, "change_absolute"))
        == f"magnitude of the change of {channel}"
    )


def test_times_before_the_start_are_left_out(run: xr.Dataset) -> None:
    assert (
        float(figure_of(run, ScalarResult("a", "position.barge.surge", "mean", None, 4.0))) == 1.5
    )


def test_phases_need_contacts(run: xr.Dataset) -> None:
    figure = ScalarResult("a", "position.barge.surge", "end", "moored")
    with pytest.raises(InputError, match="found phase moored; expected a run with contacts"):
        figure_of(run.drop_vars("contact_phase"), figure)


@pytest.mark.parametrize(
    ("channel", "statistic", "bounded"),
    [
        ("position.barge.surge", "largest", False),
        ("position.barge.surge", "largest_absolute", True),
        ("position.barge.surge", "std", True),
        ("fender_normal_force.pad", "smallest", True),
        ("fender_normal_force.pad", "change", False),
    ],
)
def test_what_cannot_be_negative_says_so(
    run: xr.Dataset, channel: str, statistic: str, bounded: bool
) -> None:
    more = run.assign_coords(fender=["pad"]).assign(
        fender_normal_force=(("time", "fender"), np.abs(X)[:, None], {"units": "N"})
    )
    found = figure_of(more, ScalarResult("a", channel, statistic))
    assert ("lowest" in found.attrs) is bounded
