"""Limits of operation: of a linear scene against its response spectrum, integrated here, and
against many runs; what is refused; the command with a scatter diagram and a hindcast."""

import re
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from command_line import Command, command, refusal
from scenes import CASES
from text_tables import rows

from hydrosim.analysis.seakeeping import LinearRequest, linear_analysis
from hydrosim.compare.dataset import differences
from hydrosim.report.evidence import Feature, Kind
from hydrosim.results.runs_file import Journal, RunOutcome
from hydrosim.scene import Scene
from hydrosim.study import executors
from hydrosim.study.operability import Trials, limits_of, load_limits

SPHERE = CASES.parent / "sphere" / "irregular.yaml"
HEAVE = "{channel: position.sphere.heave, statistic: largest_absolute, limit: 1 m}"
LINEAR = f"""
case: {SPHERE}
duration: 1860 s
criteria:
  heave: {HEAVE}
operability:
  heights: {{from: 0.1 m, to: 3 m, apart: 0.1 m}}
  peak_periods: [6 s, 9 s]
"""


def study(folder: Path, text: str) -> Path:
    path = folder / "limits.yaml"
    path.write_text(text)
    return path


def heave_only(folder: Path) -> Path:
    """The sphere in heave alone: linear."""
    path = folder / "heave.yaml"
    path.write_text(f"extends: {SPHERE}\nbodies: {{sphere: {{dofs: [heave]}}}}\nforces: null\n")
    return path


def jonswap(omega: np.ndarray, height: float, period: float) -> np.ndarray:
    """One-sided density over rad/s, scaled to the height by quadrature."""
    peak = 2.0 * np.pi / period
    sigma = np.where(omega <= peak, 0.07, 0.09)
    gamma = 3.3 ** np.exp(-0.5 * ((omega / peak - 1.0) / sigma) ** 2)
    shape = omega**-5 * np.exp(-1.25 * (peak / omega) ** 4) * gamma
    return shape * height**2 / 16.0 / np.trapezoid(shape, omega)


def test_the_limit_of_a_linear_scene_is_that_of_its_spectrum(
    tmp_path: Path, validated: Callable[..., None]
) -> None:
    """From the RAOs of `linear_analysis` and a spectrum written out here: with
    the probability p none of the groups comes in which n waves exceed u = 1 / s on either side
    (Vanmarcke), and none is there at the beginning. Random
    seas end where 0.1 % of the energy is above, which is worth 0.05 % of s."""
    path = study(tmp_path, LINEAR.replace(str(SPHERE), str(heave_only(tmp_path))))
    found = limits_of(load_limits(path), 2)
    assert found.attrs["method"] == "by response spectra"
    assert found.attrs["case_file"] == str(tmp_path / "heave.yaml")
    assert "dofs: [heave]" in found.attrs["case_resolved"]
    omega = np.linspace(0.25, 6.0, 2000)
    raos = linear_analysis(load_limits(path).scene, LinearRequest(frequencies=tuple(omega)))
    rao = raos.rao_amplitude.sel(body="sphere", dof="heave").values[0]
    for period in (6.0, 9.0):
        response = jonswap(omega, 1.0, period) * rao**2
        m0, m1, m2 = (np.trapezoid(omega**n * response, omega) for n in range(3))
        n = 2.0 * 1800.0 * np.sqrt(m2 / m0) / (2.0 * np.pi)
        broadness = np.sqrt(1.0 - m1**2 / (m0 * m2))
        u = np.linspace(2.0, 6.0, 40001)
        begins = 1.0 - np.exp(-0.5 * u**2)
        together = 1.0 - np.exp(-np.sqrt(0.5 * np.pi) * broadness * u)
        inside = begins * np.exp(-n * np.exp(-0.5 * u**2) * together / begins)
        expected = 1.0 / (np.interp(0.9, inside, u) * np.sqrt(m0))
        limit = float(found.limit.sel(stage="all", peak_period=period).squeeze())
        error = abs(limit / expected - 1.0)
        claim, against = "limiting height of a linear scene", "Vanmarcke, from its spectrum"
        validated(Kind.INDEPENDENT, claim, against, error, 0.01, Feature.LIMITS)


STAGED = f"""
case: {CASES}/base.yaml
duration: 10 s
seeds: 1-40
criteria:
  crawl: {{channel: position.barge.surge, statistic: end_absolute, limit: 1 m}}
  early: {{channel: position.barge.surge, statistic: largest, limit: 1 m, phase: initial contact}}
  late: {{channel: position.barge.surge, statistic: smallest, limit: -1 m, phase: compressed}}
operability:
  heights: {{from: 0.1 m, to: 2 m, apart: 0.1 m}}
  peak_periods: [8 s]
"""


def test_limits_by_stage_and_what_governs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures that are known: each seed crawls (0.6 + 0.01 seed) m for each metre of height; early
    motions are twice that, late ones a quarter of it. 4 of 40 may fail: seed 36 is the last that
    must hold, 0.96 m. What never comes to a phase has nothing to hold there."""

    def known(self: Trials, scenes: Sequence[Scene]) -> tuple[np.ndarray, np.ndarray]:
        (trains,) = zip(*(scene.environment.waves for scene in scenes), strict=True)
        crawl = np.array([(0.6 + 0.01 * w.seed) * w.spectrum.significant_height for w in trains])
        late = np.where(np.array([w.seed for w in trains]) == 7, np.nan, -0.25 * crawl)
        self.count += len(scenes)
        return np.stack([crawl, 2.0 * crawl, late], axis=1), np.ones(len(scenes), bool)

    monkeypatch.setattr(Trials, "values", known)
    found = limits_of(load_limits(study(tmp_path, STAGED)), 2).squeeze()
    assert found.stage.values.tolist() == ["all", "initial contact", "compressed"]
    assert found.limit.values == pytest.approx([0.5, 0.5, 2.0])
    assert found.governing.values.tolist() == ["early", "early", ""]
    assert float(found.low[0]) <= 0.5 < float(found.high[0])
    assert int(found.runs) == found.attrs["runs"] < 0.5 * found.attrs["runs_of_all"]
    assert found.attrs["method"].startswith("by runs: ")


@pytest.mark.parametrize(
    ("size", "words"),
    [
        (0.0, "2 m in any sea state: the criteria hold at all heights. Raise the last height"),
        (1e3, "in any sea state: the criteria fail at the first height. Begin with a lower height"),
        (0.9, ""),
    ],
)
def test_no_limit_within_the_range_is_said_with_what_to_change(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    size: float,
    words: str,
) -> None:
    """The result is written all the same, with where each limit would be."""

    def known(self: Trials, scenes: Sequence[Scene]) -> tuple[np.ndarray, np.ndarray]:
        heights = [scene.environment.waves[0].spectrum.significant_height for scene in scenes]
        self.count += len(scenes)
        return size * np.tile(heights, (3, 1)).T, np.ones(len(scenes), bool)

    monkeypatch.setattr(Trials, "values", known)
    monkeypatch.chdir(tmp_path)
    result = command(monkeypatch, capsys, "operability")(study(tmp_path, STAGED))
    assert result.code == (2 if words else 0), result.err
    assert words in result.err
    assert Path("limits_operability.nc").exists()


WEATHER = """
  scatter: scatter.csv
  hindcast: hindcast.csv
  operation:
    planned: 3 hour
    alpha:
      source: table 4-1, 2011
      planned: [12 hour]
      heights: [0.1 m, 2 m, 4 m]
      factors: [[0.5, 0.5, 0.5]]
"""


def test_the_command_with_weather(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    path = study(tmp_path, LINEAR.replace(str(SPHERE), str(heave_only(tmp_path))) + WEATHER)
    Path("scatter.csv").write_text("hs, 6, 9, 20\n0.1, 5, 3, 1\n9, 1, 0, 0\n")
    rows = [f"{3600 * k}, {0.1 if 10 <= k < 20 else 5}, 7" for k in range(40)]
    Path("hindcast.csv").write_text("\n".join(["time, hs, tp", *rows]))
    result = command(monkeypatch, capsys, "operability")(path)
    assert result.code == 0, result.err
    said = " ".join(result.out.split())
    assert (
        "Of the scatter diagram 80 % is workable. 10 % is outside peak periods of 6 to 9 s and"
        " counts as not workable." in said
    )
    assert "Alpha factors by table 4-1, 2011" in said
    assert "6 0.5 9 0.5 Hindcast" in said
    assert "Windows of 6 h" in said
    assert re.search(r"year\s+25\s+10 ", said)
    assert Path("limits_operability.png").exists()
    with xr.open_dataset("limits_operability.nc") as found:
        assert found.limit.attrs["units"] == "m"
        assert found.attrs["method"] == "by response spectra"
        assert found.attrs["probability"] == 0.9
        assert float(found.hindcast_workable.sel(season="year")) == pytest.approx(0.25)
        assert float(found.waiting.sel(season="year", quantile=0.5)) == np.inf


REFUSED = r"""
  limit: 1 m | limit: 1 kg | found "1 kg" | a limit in m
  sphere.heave | sphere.hive | heave: found position.sphere.hive
  from: 0.1 m | from: 4 m | heights above zero that rise
  apart: 0.1 m | apart: 0.1 mm | 1,000 or fewer
  [6 s, 9 s] | [9 s, 6 s] | peak_periods 9, 6 | values that rise
  [6 s, 9 s] | [6 s, 9 s]\n  headings: [0 deg, 45 deg, -45 deg] | \
    found headings 0, 45, -45 deg; expected values that rise
  [6 s, 9 s] | [] | \
    limits.yaml:8: operability.peak_periods: found an empty list; expected one or more
  {from: 0.1 m, to: 3 m, apart: 0.1 m} | {} | \
    limits.yaml:7: operability.heights: found no key "from"; expected a length in m
  from: | form: | heights.form: found an unknown key; expected one of: from, to
  operability: | operabilty: | unknown key | operability
  [6 s, 9 s] | [6 s]\n  hindcast: none.csv | operation: {planned: 24 hour}
  [6 s, 9 s] | [6 s]\n  scatter: none.csv | none.csv | no such file
  operability: | parameters: {solver.step: [0.1]}\noperability: | a file for each
"""


@pytest.mark.parametrize("row", rows(REFUSED), ids=lambda row: row[1])
def test_studies_of_limits_that_are_refused(
    hydrosim: Command, tmp_path: Path, row: tuple[str, ...]
) -> None:
    right, wrong, *words = row
    path = study(tmp_path, LINEAR.replace(right, wrong))
    said = refusal(hydrosim, tmp_path, "operability", path)
    assert all(word in said for word in words), said


@pytest.mark.slow
def test_a_search_that_is_interrupted_goes_on_to_the_same_limits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Told how to go on, and not begun anew unless that is asked for; runs that are there stay."""
    monkeypatch.chdir(tmp_path)
    study(tmp_path, STAGED)
    operability = command(monkeypatch, capsys, "operability", "limits.yaml", "--workers", "2")
    operability("-o", "whole.nc")
    once = Journal.add
    runs: list[int] = []

    def interrupted(self: Journal, run: int, outcome: RunOutcome) -> None:
        once(self, run, outcome)
        runs.append(run)
        if len(runs) == 11:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(Journal, "add", interrupted)
        ended = operability("-o", "part.nc")
    assert ended.code == 130
    assert "completed work is kept; --resume continues" in ended.err
    assert not Path("part.nc").exists()
    assert "--resume goes on" in operability("-o", "part.nc").err
    made: list[dict[str, object]] = []
    run_once = executors.run_compiled
    monkeypatch.setattr(
        executors, "run_compiled", lambda *a, **of: made.append(of) or run_once(*a, **of)
    )
    operability("-o", "part.nc", "--resume")
    found, whole = (xr.load_dataset(name) for name in ("part.nc", "whole.nc"))
    assert differences(found, whole) == []
    assert len(made) == found.attrs["runs"] - len(runs)
    assert 11 <= len(runs) < 40
    assert not any(of["estimates"] for of in made)  # nobody is shown what they would say
    assert not Path("part.nc.partial").exists()
