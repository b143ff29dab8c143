"""Tables laid out: where units stand, decimals that line up, what has no number."""

import math

import pytest

from hydrosim.files.display_units import DEFAULT, Units
from hydrosim.files.document_layout import RenderedTable, decimals_of, render_table, text_of
from hydrosim.files.document_nodes import Between, Cell, Sentence, Table, Value

INF, NAN = math.inf, math.nan


def laid(head: list[str], *rows: list[Cell], units: Units = DEFAULT) -> RenderedTable:
    return render_table(Table(head, rows), units)


def texts(of: RenderedTable) -> list[list[str]]:
    return [[cell.text for cell in row] for row in of.rows]


@pytest.mark.parametrize(
    ("part", "text"),
    [
        (Value(1234.5, "N"), "1.234 kN"),
        (Value(0.0, "N"), "0 kN"),
        (Value(NAN, "N"), "–"),
        (Value(INF, "N"), "–"),
        (Value(0.125, "share", 3), "12.5 %"),
        (Value(2.0), "2"),
        (Value(123456.0, "m"), "123,500 m"),
        (Between(1.0, 2.5, "m"), "1 to 2.5 m"),
        (Between(-INF, 2.5, "m"), "2.5 or less m"),
        (Between(1.0, INF, "m"), "1 or more m"),
        (Between(-INF, INF, "m"), "–"),
        (Between(NAN, NAN, "m"), "–"),
        ("{} of users", "{} of users"),
        (Sentence("100 % {}"), "100 % {}"),
        (Sentence("{} at {}", ["{0.__class__}", Value(2.0, "s")]), "{0.__class__} at 2 s"),
    ],
)
def test_texts(part: Cell, text: str) -> None:
    assert text_of(part, DEFAULT) == text


def test_a_unit_that_all_rows_have_stands_in_the_head() -> None:
    found = laid(["line", "tension"], ["a", Value(1e6, "N")], ["b", Value(1234.0, "N")])
    assert found.head == ["line", "tension [kN]"]
    assert texts(found) == [["a", "1,000.0"], ["b", "1.2"]]
    assert [row[1].number for row in found.rows] == [1e6, 1234.0]


def test_a_unit_of_a_row_stands_beside_its_name() -> None:
    found = laid(
        ["motion", "mean", "period"],
        ["surge", Value(1.5, "m"), Value(8.0, "s")],
        ["pitch", Value(math.pi / 180.0, "rad"), Value(9.5, "s")],
    )
    assert found.head == ["motion", "mean", "period [s]"]
    assert texts(found) == [["surge [m]", "1.5", "8.0"], ["pitch [deg]", "1", "9.5"]]


def test_cells_of_a_row_with_several_units_keep_their_own() -> None:
    found = laid(
        ["", "a", "b"],
        ["one", Value(1.5, "m"), Value(2.0, "N")],
        ["two", Value(1.5, "s"), Value(2.0, "kg")],
    )
    assert found.head == ["", "a", "b"]
    assert texts(found) == [["one", "1.5 m", "0.002 kN"], ["two", "1.5 s", "0.002 t"]]


def test_an_interval_goes_with_its_mean() -> None:
    """Both in the unit that the head names; words among them stay as they are."""
    mean = Sentence("{} ({})", [Value(2e3, "N"), Between(1.5e3, 2.5e3, "N")])
    found = laid(["", "force"], ["a", mean], ["b", Value(100.25e3, "N")], ["c", "none"])
    assert found.head == ["", "force [kN]"]
    assert texts(found) == [["a", "2.0 (1.5 to 2.5)"], ["b", "100.2"], ["c", "none"]]


def test_two_units_of_all_rows_stand_in_the_head_together() -> None:
    cells = [
        Sentence("{}, {}", [Value(x, "m/m"), Value(0.5 * math.pi, "rad", 3)]) for x in (1, 2.5)
    ]
    found = laid(["period", "heave"], *([Value(8.0, "s"), cell] for cell in cells))
    assert found.head == ["period [s]", "heave [m/m, deg]"]
    assert texts(found) == [["8", "1.0, 90"], ["8", "2.5, 90"]]


def test_a_sentence_with_words_keeps_its_unit() -> None:
    found = laid(["", "height"], ["a", Sentence("below {}", [Value(1.0, "m")])], ["b", Value(2.0)])
    assert texts(found)[0] == ["a", "below 1 m"]


def test_what_is_not_finite_is_no_number() -> None:
    found = laid(
        ["", "interval [90 %]"],
        ["a", Between(1.0, INF, "m")],
        ["b", Between(-INF, 22.25, "m")],
        ["c", Between(NAN, NAN, "m")],
    )
    assert [row[1] for row in texts(found)] == ["1.00 or more", "22.25 or less", "–"]
    alone = laid(["", "x"], ["a", Value(NAN, "m")], ["b", Value(INF, "m")])
    assert alone.head == ["", "x [m]"]
    assert [row[1] for row in texts(alone)] == ["–", "–"]


def test_rows_may_be_shorter_than_the_head() -> None:
    found = laid(["a", "b", "c"], ["x"], ["y", Value(1.5, "m"), Value(2.0, "m")])
    assert texts(found) == [["x", "", ""], ["y", "1.5", "2"]]
    assert laid(["a"]).rows == []


@pytest.mark.parametrize(
    ("numbers", "digits", "decimals"),
    [
        ([], 4, 0),
        ([0.0, NAN], 4, 0),
        ([3.0, -12.0], 4, 0),
        ([1.5], 4, 1),  # no zeros at the end
        ([1.5, 2.1256], 4, 3),
        ([1234.5], 4, 0),
        ([1234.5, 1.26], 4, 1),  # two digits of the smallest
        ([1234.5, 1e-3], 4, 0),  # little beside the largest
        ([0.00012345], 4, 6),
        ([2e9], 4, 0),
    ],
)
def test_decimals(numbers: list[float], digits: int, decimals: int) -> None:
    assert decimals_of(numbers, digits) == decimals


def test_numbers_too_small_or_large_for_decimals_are_powers_of_ten() -> None:
    found = laid(["", "x"], ["a", Value(1.5)], ["b", Value(2e-9)], ["c", Value(0.0)])
    assert [row[1] for row in texts(found)] == ["1.5", "2.0e-09", "0"]
    assert texts(laid(["", "x"], ["a", Value(2.5e9)]))[0][1] == "2.5e+09"
