"""The programs on the page about coupling one's own code run, one after another as they stand."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import hydrosim as hs
from hydrosim.compare.dataset import differences

ROOT = Path(__file__).parents[2]
SHORT = 15.0  # s, of the 1200 s of the case


def programs() -> list[str]:
    page = (ROOT / "docs" / "door.md").read_text()
    found = re.findall(r"^```python\n(.*?)^```$", page, re.M | re.S)
    assert len(found) == 6
    return found


def test_the_programs_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    load = hs.load_case
    short = replace(load(ROOT / "cases/reverse_float_over/base.yaml").scene(), duration=SHORT)
    monkeypatch.setattr(
        hs,
        "load_case",
        lambda path, settings=None: load(ROOT / path, settings) if settings else short,
        raising=False,
    )
    names: dict[str, object] = {}
    results = []
    for program in programs():
        exec(program, names)
        results.append(names["run"])
    braked, wound, latched, _, rubbed, stepped = results
    assert np.abs(braked.force_brake.sel(body="barge", dof="surge")).max() > 0.0
    assert wound.external_calls[-1] == wound.solver_steps + 1
    assert latched.external_calls[-1] == latched.solver_steps + 1
    assert names["events"][0] == pytest.approx(100.0 / 12.0, abs=1e-9)  # push = mu N
    assert rubbed.energy_work_friction[-1] < 0.0
    assert differences(stepped, hs.simulate(short)) == []
