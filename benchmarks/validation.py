"""How far is hydrosim from closed forms and from other programs, and how far are others?

Runs the tests that are marked ``validation`` and puts what they measured in one table.
"""

from __future__ import annotations

from typing import Any

import pytest

from benchmarks.report import ROOT, Answer, Row


class Collector:
    """What the tests note with the fixture `validated`, the largest error of each case."""

    def __init__(self) -> None:
        self.rows: dict[tuple[str, str], tuple[float, str]] = {}

    def pytest_runtest_logreport(self, report: Any) -> None:
        """Of every test that ran."""
        for name, value in report.user_properties if report.when == "call" else ():
            if name == "validation":
                case, reference, error, others = value
                known = self.rows.get((case, reference), (-1.0, ""))
                self.rows[case, reference] = max(known, (error, others))


def answer() -> Answer:
    """The table; a test that fails is said."""
    collector = Collector()
    code = pytest.main(["-q", "-m", "validation", str(ROOT / "tests")], plugins=[collector])
    rows: list[Row] = [
        {"case": case, "reference": reference, "error": error, "others": others}
        for (case, reference), (error, others) in sorted(collector.rows.items())
    ]
    return Answer({"Relative errors": rows}, ["some tests failed."] if code else [])
