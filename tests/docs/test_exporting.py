"""What the page on exporting reads, as it is written there."""

import re
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "exporting.md"
TEXT = "# base.nc\ntime,speed.barge\ns,m/s\n0.5,0.30000000000000004\n"


@pytest.mark.filterwarnings("error")
def test_a_table_is_read_without_a_warning(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("base.csv").write_text(TEXT)
    pandas = pytest.importorskip("pandas")
    found = re.search(r"motions = (pd\.read_csv\(.*?\))$", PAGE.read_text(), re.S | re.M)
    assert found
    motions = eval(found[1], {"pd": pandas})
    assert motions[("speed.barge", "m/s")].loc[0.5] == pytest.approx(0.3, rel=1e-15)
