"""The notebooks as they are kept; the site, which CI builds, executes them."""

import json
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).parents[2] / "docs" / "notebooks").glob("*.ipynb"))


def test_there_are_three() -> None:
    assert [path.stem for path in NOTEBOOKS] == ["first_run", "own_vessel", "study"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_they_are_kept_without_outputs(path: Path) -> None:
    codes = [c for c in json.loads(path.read_text())["cells"] if c["cell_type"] == "code"]
    assert len(codes) > 4
    assert all(c["outputs"] == [] and c["execution_count"] is None for c in codes)
    assert not any(c["source"][0].startswith("!") for c in codes)  # it would fail unnoticed
