"""Breaking loads on the page of moorings are those of its formula."""

import re
from pathlib import Path

PAGE = Path(__file__).parents[2] / "docs" / "moorings.md"
ROW = re.compile(r"^\| (R\d\w?) \| ([\d.]+) \| (\d+) kN \| (\d+) kN \| (\d+) kN \|$", re.MULTILINE)
DIAMETERS = (50, 76, 100)  # mm
FACTORS = {"R3": 0.0223, "R3S": 0.0249, "R4": 0.0274, "R4S": 0.0304, "R5": 0.0320}
"""Of breaking loads of grades of chain (IACS UR W22, table 5)."""


def test_breaking_loads() -> None:
    rows = {row[0]: row[1:] for row in ROW.findall(PAGE.read_text("utf-8"))}
    assert {grade: float(row[0]) for grade, row in rows.items()} == FACTORS
    for row in rows.values():
        loads = [float(row[0]) * d**2 * (44.0 - 0.08 * d) for d in DIAMETERS]
        assert [int(load) for load in row[1:]] == [round(load) for load in loads]
