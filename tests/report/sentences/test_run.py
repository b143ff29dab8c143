"""Words of a run: verdicts, and the place where waves act on a body."""

import numpy as np
import pytest
import xarray as xr
from reading import texts
from recorded_runs import made_run

from hydrosim.elements.kind import Topic
from hydrosim.files.document_nodes import Table, Value
from hydrosim.report.sentences.run import FIGURES, radiation_verdict, result_tables
from hydrosim.report.sentences.sections import assumptions
from hydrosim.results.variables import VARIABLES
from hydrosim.scene import Place


@pytest.mark.parametrize(
    ("error", "outcome", "size"), [(10.0, "warning", "1,000 %"), (2e-3, "good", "0.2 %")]
)
def test_errors_of_radiation_are_percentages_beside_their_limit(
    error: float, outcome: str, size: str
) -> None:
    (text,) = texts([radiation_verdict(error)])
    assert text.startswith(f"{outcome}: ")
    assert text.endswith(f" at most {size}; the limit is 1 %.")


@pytest.mark.parametrize(
    ("stored", "said"),
    [
        ("slow slow", "at its slowly varying position and its slowly varying heading"),
        ("mean instantaneous", "at its position at rest and its momentary heading"),
        ("somewhere", "somewhere"),
    ],
)
def test_the_place_in_the_waves_is_said_in_words(stored: str, said: str) -> None:
    run = xr.Dataset(coords={"body": ["tanker"]}, attrs={"waves_meet_tanker": stored})
    assert assumptions(run).rows == [("Where waves act on tanker", said)]


def test_every_place_has_words() -> None:
    assert len({place.describe("position") for place in Place}) == len(Place)


def test_summaries_and_charts_of_variables_can_be_made() -> None:
    """Figures and variables that a summary names are there, and a chart has a place."""
    columns = [column for variable in VARIABLES.values() for column in variable.summary]
    assert {column.figure for column in columns} <= {*FIGURES}
    assert {column.variable for column in columns} <= {"", *VARIABLES}
    for variable in VARIABLES.values():
        title, quantity, rank = variable.chart
        assert bool(title) == bool(quantity)
        assert not title or rank < Topic.END


def test_a_summary_has_the_columns_that_variables_declare() -> None:
    """Of units in the order of topics; the largest tension of a winch is that of all steps."""
    tension = np.full((3001, 1), 2e3)
    tension[0] = 0.0
    units = {"units": "N"}
    run = made_run().assign(
        fender_slip_distance=(("time", "fender"), np.zeros((3001, 2)), {"units": "m"}),
        external_calls=(("time", "external"), np.full((3001, 1), 1234567.0), {"units": "1"}),
        winch_tension=(("time", "winch"), tension, units),
        winch_largest_tension=(("time", "winch"), tension + 1e3, units),
        winch_length=(("time", "winch"), np.ones((3001, 1)), {"units": "m"}),
    )
    run = run.assign_coords(winch=["hoist"], external=["thruster"])
    *_, winch, external = (node for node in result_tables(run) if isinstance(node, Table))
    assert winch.head == ("winch", *WINCH_HEAD)
    name, start, mean, largest, slack, *_ = winch.rows[0]
    assert (name, start, largest) == ("hoist", Value(0.0, "N"), Value(3e3, "N"))
    assert mean == Value(pytest.approx(2e3 * 3000 / 3001), "N")
    assert slack == Value(1 / 3001, "share", 2)
    assert external == Table(("external force", "calls"), [["thruster", "1234567"]])


WINCH_HEAD = ("tension at the start", "mean", "largest", "slack", "shortest", "longest")
