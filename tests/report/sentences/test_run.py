"""Words of a run: verdicts, and the place where waves act on a body."""

import pytest
import xarray as xr
from reading import texts

from hydrosim.report.sentences.run import radiation_verdict
from hydrosim.report.sentences.sections import assumptions
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
