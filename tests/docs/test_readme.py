"""The case in the README runs, as it stands there."""

import re
from pathlib import Path

import numpy as np

import hydrosim as hs

ROOT = Path(__file__).parents[2]


def test_the_first_case(tmp_path: Path) -> None:
    """Decay: what is shifted at the start moves, and less and less."""
    found = re.search(r"^```yaml\n(.*?)^```$", (ROOT / "README.md").read_text(), re.M | re.S)
    assert found is not None
    case = tmp_path / "first.yaml"
    case.write_text(found[1].replace("hydro_db/", f"{ROOT / 'hydro_db'}/"))
    run = hs.simulate(hs.load_case(case))
    assert run.attrs["status"] == "complete"
    heave = run.position.sel(dof="heave").values[:, 0]
    assert 0.0 < np.ptp(heave[len(heave) // 2 :]) < 0.2 * np.ptp(heave)
    assert "warnings" not in run.attrs, run.attrs["warnings"]
