"""What commands say of their progress where there is no terminal. No test waits: time is given."""

from collections.abc import Callable
from itertools import islice, pairwise

import pytest

from hydrosim.cli.terminal import FIRST_LINE_S, MAX_PAUSE_S, ProgressLines, pauses, progress


def ends_after(count: int) -> Callable[[float], bool]:
    """A wait that is over at once, and in which the work ends the last time."""
    waited: list[float] = []

    def wait(pause: float) -> bool:
        waited.append(pause)
        return len(waited) > count

    return wait


def test_what_ends_before_the_first_line_is_due_says_nothing() -> None:
    said: list[str] = []
    ProgressLines("simulating").tell(ends_after(0), said.append)
    assert said == []


def test_lines_say_what_is_done_and_how_far_it_is() -> None:
    said: list[str] = []
    lines = ProgressLines("simulating", "s")
    lines.report(35.0, 100.0, "250 steps/s")
    lines.tell(ends_after(2), said.append)
    assert len(said) == 2
    assert said[0].startswith("simulating: 35 %, 35 of 100 s, 250 steps/s (")


@pytest.mark.parametrize(
    ("far", "line"),
    [
        ((), "linear analysis (14 s so far)"),
        ((0.0, 0.0, "rk4 at 0.1"), "linear analysis: rk4 at 0.1 (14 s so far)"),
        ((3.0, 12.0), "linear analysis: 25 %, 3 of 12 (14 s so far)"),
        ((13.0, 12.0), "linear analysis: 100 %, 13 of 12 (14 s so far)"),
    ],
)
def test_what_is_not_known_is_left_out(far: tuple[float, float, str], line: str) -> None:
    lines = ProgressLines("linear analysis")
    lines.report(*far)
    assert lines.line(14.2) == line


def test_intervals_grow_from_two_seconds_to_a_minute() -> None:
    found = list(islice(pauses(), 8))
    assert found[0] == FIRST_LINE_S == 2.0
    assert all(b >= a for a, b in pairwise(found))
    assert found[-1] == MAX_PAUSE_S == 60.0


def test_a_reader_that_went_away_ends_the_lines_alone() -> None:
    def closed(_: str) -> None:
        raise BrokenPipeError

    ProgressLines("simulating").tell(ends_after(5), closed)


def test_without_a_terminal_work_of_no_time_leaves_both_streams_empty(
    capfd: pytest.CaptureFixture[str],
) -> None:
    with progress("drawing") as report:
        report(1.0, 2.0)
    assert capfd.readouterr() == ("", "")


def test_an_error_of_the_work_is_the_error_of_the_command() -> None:
    with pytest.raises(ZeroDivisionError), progress("drawing"):
        _ = 1 / 0
