"""Seeds until an interval is narrow enough: figures that are known in place of runs."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from command_line import files
from scenes import CASES

from hydrosim.errors import InputError
from hydrosim.files.outputs import Output, as_output
from hydrosim.results.dataset import write_run
from hydrosim.study.many_runs import run_until
from hydrosim.study.sweep import ParameterStudy, load_study, read_study

TEXT = f"""
case: {CASES}/base.yaml
duration: 10 s
parameters: {{environment.waves.peak_period: [6 s, 8 s]}}
seeds: 1-4
until: {{figure: crawl, wide: 0.5 m, most: 100}}
figures: {{crawl: {{channel: position.barge.surge, statistic: end}}}}
"""


def known(study: ParameterStudy, path: Path) -> xr.Dataset:
    """Normal figures, of the standard deviation 1 m at 8 s and of 0.5 m at 6 s."""
    seed = [scene.environment.waves[0].seed for scene in study.scenes]
    period = study.labels["environment_waves_peak_period"]
    values = [
        np.random.default_rng(s).normal(0.0, 1.0 if t == 8.0 else 0.5)
        for s, t in zip(seed, period.values, strict=True)
    ]
    runs = xr.Dataset({"crawl": ("run", values, {"units": "m"})}, attrs={"design": study.design})
    return runs.assign_coords({"seed": ("run", seed), "environment_waves_peak_period": period})


@pytest.mark.parametrize(("wide", "seeds"), [("0.5 m", 64), ("1 mm", 100), ("100 m", 4)])
def test_rounds_double_until_it_is_enough(tmp_path: Path, wide: str, seeds: int) -> None:
    """Student's 90 % interval of n normal values is 2 x 1.67 / sqrt(n) wide: 0.42 m of 64, 0.6 m of
    32, +- 13 %."""
    path = tmp_path / "study.yaml"
    path.write_text(TEXT.replace("0.5 m", wide))
    output = Output(tmp_path / "runs.nc", "sweep", path)
    firsts = []

    def numbered(part: ParameterStudy, file: Path) -> xr.Dataset:
        firsts.append(part.first)
        return known(part, file)

    said = run_until(load_study(path), numbered, output)
    assert firsts == [0, *(n for n in (8, 16, 32, 64, 128) if n < 2 * seeds)]
    assert said.startswith(f"{seeds} seeds: ")
    assert said.endswith(" m, not 0.001 m as asked for" if wide == "1 mm" else " m")
    with xr.open_dataset(tmp_path / "runs.nc") as runs:
        assert runs.sizes["run"] == 2 * seeds
        assert sorted({*runs.seed.values.tolist()}) == list(range(1, seeds + 1))
        assert json.loads(runs.attrs["design"])["figures"] == ["crawl"]


def test_rounds_that_are_there_are_taken_up(tmp_path: Path) -> None:
    """Killed as it makes the third round, it goes on with that one, to the same result."""
    path, made = tmp_path / "study.yaml", list[int]()
    path.write_text(TEXT)
    study = load_study(path)

    def whole(part: ParameterStudy, file: Path) -> xr.Dataset:
        made.append(len(part.scenes))
        write_run(
            known(part, file).assign(status=("run", ["complete"] * len(part.scenes))),
            as_output(file, "sweep"),
        )
        return xr.open_dataset(file)

    def killed(part: ParameterStudy, file: Path) -> xr.Dataset:
        if len(made) == 2:
            raise KeyboardInterrupt
        return whole(part, file)

    first, second = (Output(tmp_path / name, "sweep", path) for name in ("a.nc", "b.nc"))
    said = run_until(study, whole, first)
    made.clear()
    with pytest.raises(KeyboardInterrupt):
        run_until(study, killed, second)
    with pytest.raises(InputError, match=r"b.nc.rounds: holds rounds of a study.*--resume"):
        run_until(study, whole, second)
    other = tmp_path / "other.yaml"
    other.write_text(TEXT.replace("10 s", "12 s"))
    with pytest.raises(InputError, match="these have changed since the runs in"):
        run_until(load_study(other), whole, second, resume=True)
    lock = tmp_path / "b.nc.rounds" / f".hydrosim-2-{16 * 'a'}.nc.lock"
    lock.write_text("123@elsewhere\n")  # of a process that was killed
    assert run_until(study, whole, second, resume=True) == said
    assert made == [8, 8, 16, 32, 64]
    with xr.open_dataset(tmp_path / "a.nc") as one, xr.open_dataset(tmp_path / "b.nc") as two:
        assert one.identical(two.assign_attrs(history=one.history))
    assert not (tmp_path / "b.nc.rounds").exists()


def test_a_figure_that_is_not_there(tmp_path: Path) -> None:
    path = tmp_path / "study.yaml"
    path.write_text(TEXT.replace("figure: crawl", "figure: crawls"))
    with pytest.raises(InputError, match=r"until.*found crawls; expected one of: crawl"):
        read_study(path)


@pytest.mark.parametrize(
    ("found", "message"),
    [
        ("wide: 0 m", r'until.wide: found "0 m"; expected a width.*above 0'),
        ("wide: -0.1 m", r'until.wide: found "-0.1 m"; expected a width.*above 0'),
        ("wide: 0", r"until.wide: found 0; expected a width.*above 0"),
        ("most: 3", r"until.most: found 3 and 4 seeds; expected as many as these, or more"),
    ],
)
def test_what_cannot_be_enough_is_refused(tmp_path: Path, found: str, message: str) -> None:
    path = tmp_path / "study.yaml"
    path.write_text(TEXT.replace("wide: 0.5 m" if "wide" in found else "most: 100", found))
    with pytest.raises(InputError, match=message):
        read_study(path)


@pytest.mark.parametrize(
    "name", ["2019.nc", "0-0123456789abcdef.nc", "1-0123456789abcdef.nc.partial"]
)
@pytest.mark.parametrize("resume", [False, True])
def test_rounds_of_others_stay(tmp_path: Path, name: str, resume: bool) -> None:
    """In a folder of that name, and behind a link of that name."""
    path, archive, rounds = (tmp_path / name for name in ("study.yaml", "archive", "w.nc.rounds"))
    path.write_text(TEXT)
    study = load_study(path)
    archive.mkdir()
    if name.endswith("partial"):
        (archive / name).mkdir()
        (archive / name / "a").touch()
    else:
        xr.Dataset({"a": 1.0}).to_netcdf(archive / name)
    output = Output(tmp_path / "w.nc", "sweep", path, overwrite=not resume)
    rounds.symlink_to(archive)
    with pytest.raises(InputError, match=r"w\.nc\.rounds: is a link.*Move it away"):
        run_until(study, known, output, resume)
    rounds.unlink()
    archive.rename(rounds)
    before = files(rounds)
    with pytest.raises(InputError, match=rf"{name}: is not a file of this program.*Move it away"):
        run_until(study, known, output, resume)
    assert before == files(rounds) != {}
