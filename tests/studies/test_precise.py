"""Seeds until an interval is narrow enough: figures that are known in place of runs."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from moored_barge import CASES

from hydrosim.errors import InputError
from hydrosim.outputs import Output
from hydrosim.studies.precise import run_until
from hydrosim.studies.sweep import Study, load_study, read_study

TEXT = f"""
case: {CASES}/base.yaml
duration: 10 s
parameters: {{environment.waves.peak_period: [6 s, 8 s]}}
seeds: 1-4
until: {{figure: crawl, wide: 0.5 m, most: 100}}
figures: {{crawl: {{channel: position.barge.surge, statistic: end}}}}
"""


def known(study: Study, path: Path) -> xr.Dataset:
    """Normal figures, of the standard deviation 1 m at 8 s and of 0.5 m at 6 s."""
    seed = [scene.environment.waves[0].seed for scene in study.scenes]
    period = study.labels["environment.waves.peak_period"]
    values = [
        np.random.default_rng(s).normal(0.0, 1.0 if t == 8.0 else 0.5)
        for s, t in zip(seed, period.values, strict=True)
    ]
    runs = xr.Dataset({"crawl": ("run", values)}, attrs={"design": study.design})
    return runs.assign_coords({"seed": ("run", seed), "environment.waves.peak_period": period})


@pytest.mark.parametrize(("wide", "seeds"), [("0.5 m", 64), ("1 mm", 100), ("100 m", 4)])
def test_rounds_double_until_it_is_enough(tmp_path: Path, wide: str, seeds: int) -> None:
    """Student's 90 % interval of n normal values is 2 x 1.67 / sqrt(n) wide: 0.42 m of 64, 0.6 m of
    32, +- 13 %."""
    path = tmp_path / "study.yaml"
    path.write_text(TEXT.replace("0.5 m", wide))
    data = read_study(path)
    assert data.until is not None
    assert data.seeds is not None
    output = Output(tmp_path / "runs.nc", "sweep", path)
    said = run_until(load_study(path), data.seeds, data.until, known, output)
    assert said.startswith(f"{seeds} seeds: ")
    assert ("as asked for" in said) == (wide == "1 mm")
    with xr.open_dataset(tmp_path / "runs.nc") as runs:
        assert runs.sizes["run"] == 2 * seeds
        assert sorted({*runs.seed.values.tolist()}) == list(range(1, seeds + 1))
        assert json.loads(runs.attrs["design"])["figures"] == ["crawl"]


def test_a_figure_that_is_not_there(tmp_path: Path) -> None:
    path = tmp_path / "study.yaml"
    path.write_text(TEXT.replace("figure: crawl", "figure: crawls"))
    with pytest.raises(InputError, match=r"until.*found crawls; expected one of: crawl"):
        read_study(path)
