"""Phases of contact histories that are written by hand."""

import numpy as np
import pytest
import xarray as xr

from hydrosim.elements.contact.law import OPEN, SLIP, STICK
from hydrosim.report.sentences.explanation import reported_spans
from hydrosim.results.phases import (
    MIN_STICKING_SHARE,
    WINDOW,
    Phase,
    contact_phases,
    group_phases,
    is_operation,
)


def history(*pieces: tuple[float, int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Times every 0.5 s and modes of two fenders, for pieces of so many seconds each."""
    modes = np.concatenate([np.tile(modes, (round(2 * s), 1)) for s, *modes in pieces])
    return 0.5 * np.arange(len(modes)), modes


def begins(time: np.ndarray, phase: np.ndarray) -> dict[Phase, float]:
    return {Phase(k): time[int(np.argmax(phase == k))] for k in np.unique(phase)}


def test_all_phases() -> None:
    time, modes = history(
        (100.0, OPEN, OPEN),
        (50.0, SLIP, OPEN),
        (50.0, OPEN, OPEN),
        (60.0, SLIP, SLIP),
        (200.0, STICK, STICK),
    )
    found = begins(time, contact_phases(time, modes))
    assert found[Phase.MOORED] == 0.0
    assert found[Phase.INITIAL_CONTACT] == 100.0
    assert found[Phase.COMPRESSED] == 200.0
    # the first window with enough stick begins when at most a fifth of it slips
    assert abs(found[Phase.STUCK] - (260.0 - (1.0 - MIN_STICKING_SHARE) * WINDOW)) <= 0.5


def test_a_run_that_ends_early_lacks_the_last_phases() -> None:
    time, modes = history((100.0, OPEN, OPEN), (300.0, STICK, STICK), (1.0, OPEN, OPEN))
    assert set(begins(time, contact_phases(time, modes))) == {Phase.MOORED, Phase.INITIAL_CONTACT}
    time, modes = history((100.0, OPEN, OPEN), (200.0, SLIP, STICK))
    assert set(begins(time, contact_phases(time, modes))) == {Phase.MOORED, Phase.COMPRESSED}


def test_no_contact_and_no_fenders() -> None:
    time, modes = history((100.0, OPEN, OPEN))
    assert not contact_phases(time, modes).any()
    assert not contact_phases(time, modes[:, :0]).any()
    assert contact_phases(time[:1], modes[:1]).size == 1


def test_slip_ends_being_stuck() -> None:
    time, modes = history((10.0, OPEN, OPEN), (300.0, STICK, STICK), (90.0, SLIP, SLIP))
    assert Phase.STUCK not in begins(time, contact_phases(time, modes))


def test_a_fender_that_is_always_in_contact_hides_no_operation() -> None:
    """A ship alongside, pressed on for ever; the interface goes through all phases."""
    time, modes = history((100.0, OPEN, SLIP), (60.0, SLIP, SLIP), (200.0, STICK, SLIP))
    each = group_phases(time, modes, ["interface", "alongside"])
    assert each.shape == (time.size, 2)
    assert set(begins(time, each[:, 0])) == {Phase.MOORED, Phase.COMPRESSED, Phase.STUCK}
    assert begins(time, each[:, 0])[Phase.COMPRESSED] == 100.0
    assert set(begins(time, each[:, 1])) == {Phase.COMPRESSED}
    assert set(begins(time, contact_phases(time, modes))) == {Phase.COMPRESSED}


def test_contacts_of_one_element_are_one_group() -> None:
    time, modes = history((50.0, OPEN, SLIP), (50.0, SLIP, SLIP))
    (each,) = group_phases(time, modes, ["interface", "interface"]).T
    np.testing.assert_array_equal(each, contact_phases(time, modes))


@pytest.mark.parametrize(
    ("phases", "told"),
    [([0, 1, 2, 3], True), ([0, 3], True), ([0, 1, 2], False), ([2, 3], False), ([0], False)],
)
def test_an_operation_begins_without_contact_and_ends_stuck(phases: list[int], told: bool) -> None:
    assert is_operation(np.array(phases, dtype=np.int8)) is told


def test_an_explanation_tells_phases_of_operations_alone() -> None:
    """Of the group "legs", which ends stuck, and not of the group "quay", which does not."""
    ends = {"whole run": 9.0, "in contact": 9.0}
    ends |= {"legs: moored": 3.0, "legs: stuck": 9.0, "legs: in contact": 9.0}
    ends |= {"quay: moored": 3.0, "quay: compressed": 9.0, "quay: stuck": np.nan}
    found = xr.Dataset({"span_end": ("span", [*ends.values()])}, {"span": [*ends]})
    assert reported_spans(found) == [name for name in ends if not name.startswith("quay")]
