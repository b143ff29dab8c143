"""Studies: all combinations of parameters and seeds; a run of a study is the run of its case."""

import re
import signal
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from command_line import Command, command, refusal, succeeds
from scenes import CASES
from text_tables import rows

import hydrosim as hs
from hydrosim.compare.dataset import differences
from hydrosim.files.display_units import Units
from hydrosim.files.interrupts import ENDING_SIGNALS
from hydrosim.statistics.effects import PlanRuns
from hydrosim.study import executors
from hydrosim.study.sweep import load_study

HEIGHT, STATIC = "environment.waves.significant_height", "forces.interface.friction.static"


def named(key: str) -> str:
    """The coordinate of a key."""
    return key.replace(".", "_")


def study(folder: Path, text: str, case: str = "base") -> Path:
    """A study file about one of the reverse float-over cases, 10 s long."""
    path = folder / "study.yaml"
    path.write_text(f"case: {CASES}/{case}.yaml\nduration: 10 s\n{text}\n")
    return path


@pytest.fixture
def sweep(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    return command(monkeypatch, capsys, "sweep")


def test_all_combinations_with_the_seeds_of_one_after_each_other(tmp_path: Path) -> None:
    text = f"parameters: {{{HEIGHT}: [1 m, 2 m], {STATIC}: [0.2, 0.4]}}\nseeds: 3-4"
    found = load_study(study(tmp_path, text))
    assert found.labels[named(HEIGHT)].values.tolist() == [1.0] * 4 + [2.0] * 4
    assert found.labels[named(HEIGHT)].attrs["units"] == "m"
    assert found.labels[named(STATIC)].values.tolist() == [0.2, 0.2, 0.4, 0.4] * 2
    trains = [scene.environment.waves[0] for scene in found.scenes]
    assert [train.seed for train in trains] == [3, 4] * 4
    assert [train.spectrum.significant_height for train in trains] == [1.0] * 4 + [2.0] * 4  # type: ignore[union-attr]
    assert {scene.duration for scene in found.scenes} == {10.0}


@pytest.mark.parametrize(
    ("seeds", "expected"), [("7", [7]), ("[1, 5, 9]", [1, 5, 9]), ("0 - 2", [0, 1, 2])]
)
def test_seeds_are_a_number_list_or_span(tmp_path: Path, seeds: str, expected: list[int]) -> None:
    found = load_study(study(tmp_path, f"seeds: {seeds}"))
    assert [scene.environment.waves[0].seed for scene in found.scenes] == expected
    assert found.labels == {}


def test_a_run_of_a_study_is_that_of_its_case(tmp_path: Path, sweep: Command) -> None:
    text = f"parameters: {{{HEIGHT}: [1, 2]}}\nseeds: 1-2\noutput: {{step: 1 s}}"
    output = ("-o", tmp_path / "runs.nc", "--workers", 2)
    printed = succeeds(sweep, study(tmp_path, text), *output)
    assert "All 4 runs are complete." in printed
    assert "barge surge" in printed
    settings = {"duration": 10, "output.step": 1, HEIGHT: 2, "environment.waves.seed": 1}
    single = hs.simulate(hs.load_case(CASES / "base.yaml", settings))
    with xr.open_dataset(tmp_path / "runs.nc") as runs:
        assert runs[named(HEIGHT)].values.tolist() == [1, 1, 2, 2]
        assert runs.seed.values.tolist() == [1, 2, 1, 2]
        assert np.array_equal(runs.position[2], single.position)


def test_failures_are_told_and_the_exit_code_says_so(tmp_path: Path, sweep: Command) -> None:
    """Of the steps, one is above the stable limit, and the case has that refused."""
    text = "parameters: {solver.step: [0.1, 0.25]}"
    result = sweep(study(tmp_path, text), "-o", tmp_path / "runs.nc")
    assert result.code == 3
    assert "1 of 2 runs are complete. Figures are of these." in result.out
    assert "failed: solver.step 0.25 s: largest stable step" in result.out
    assert "(run 1)" in result.out


INVALID = """
  seeds: 9-1 | study.yaml:3: seeds | found "9-1" | write "1-9"
  seeds: [1, 1] | study.yaml:3: seeds | each once
  seeds: [-1] | study.yaml:3: seeds.0 | found -1 | not negative
  parameters: {solver.step: []} | parameters | one value or more
  parameters: {solver.stop: [1]} | solver.stop | did you mean "step"
  parameters: {HEIGHT: [1 kg]} | significant_height | 1 kg
  parameters: {solver.step: {from: 1 s, to: 2 s}} | a list of values | design grid
  design: sobol; samples: 3; parameters: {solver.step: {from: 1, to: 2}} | power of two
  design: sobol; samples: 4; parameters: {solver.step: [1, 2]} | {from: .., to: ..}
  design: sobol; samples: 4; parameters: {HEIGHT: {from: 2, to: 1}} | \
    HEIGHT: found from 2 to 1 | rises
  parameters: {a: {keys: {solver.step: [1, 2], duration: [1, 2, 3]}}} | \
    found 2, 3 values | as many for each key
  seeds: 1-100000; parameters: {HEIGHT: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]} | \
    1,100,000 runs | 1,000,000 or fewer | days
  figures: {a: {channel: wave_elevation, statistic: median}} | median | mean
  figures: {a b: {channel: wave_elevation, statistic: mean}} | digits and _
  criteria: {a: {channel: wave_elevation, statistic: mean}} | no key "limit"
  parameters: {HEIGHT: [1 m, 100 cm]} | study.yaml:3: parameters: found HEIGHT 1.0 twice | once
  parameters: {solver.stp: [1]} | study.yaml:3: solver.stp=1:
  figures: {status: {channel: wave_elevation, statistic: mean}} | \
    study.yaml:3: figures.status | not taken
  parameters: {a/b: {keys: {solver.step: [0.1, 0.05]}}} | study.yaml:3: parameters.a/b | without /
  parameters: {wind: {keys: {}}} | \
    study.yaml:3: parameters.wind.keys: found an empty mapping; expected one or more
  seed: 1 | study.yaml:3: seed | unknown key | did you mean "seeds"
  figures: {a: {result: recontact}} | study.yaml:3 | figures.a | recontact_force
  figures: {a: {result: time, group: legs}} | study.yaml:3 | the result time without stage
  figures: {a: {result: time, stage: stuck}} | \
    study.yaml:3 | one of: first contact, 25% transferred
  figures: {a: {result: duration, stage: open}} | study.yaml:3 | stage and until
  figures: {a: {result: recontacts, force: legs}} | \
    study.yaml:3 | force of the result recontacts | only: group
  figures: {a: {result: moved, mode: rolling}} | study.yaml:3 | open
"""
"""Lines of a study file, with a semicolon between them, and words of the message."""


@pytest.mark.parametrize("row", rows(INVALID.replace("HEIGHT", HEIGHT)), ids=lambda row: row[0])
def test_a_study_that_is_invalid_is_refused_with_line(tmp_path: Path, row: tuple[str, ...]) -> None:
    text, *words = row
    with pytest.raises(hs.InputError) as caught:
        load_study(study(tmp_path, text.replace("; ", "\n")))
    assert all(word in str(caught.value) for word in words), caught.value


@pytest.mark.parametrize(
    ("channel", "word"),
    [
        ("position.barge.surg", "position.barge.surge"),
        ("speed.tug", "speed.barge"),
        ("clearance.deck", "clearances"),
    ],
)
def test_a_channel_that_is_not_there_is_refused_before_the_runs(
    tmp_path: Path, sweep: Command, channel: str, word: str
) -> None:
    path = study(tmp_path, f"figures: {{a: {{channel: {channel}, statistic: end}}}}")
    said = refusal(sweep, tmp_path, path, "-o", tmp_path / "runs.nc")
    assert word in said
    assert "study.yaml:3: a: found" in said


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("until: {figure: a, wide: 1 kN}\nfigures: {a: {%s}}", 'until.wide: found "1 kN"'),
        ("criteria: {a: {%s, limit: 1 kN}}", 'criteria.a.limit: found "1 kN"'),
        ("output: {start: 11 s}\nfigures: {a: {%s}}", "output: found start 11 s"),
    ],
)
def test_a_bound_of_another_kind_and_a_late_start_are_refused_before_the_runs(
    tmp_path: Path, sweep: Command, text: str, words: str
) -> None:
    asked = text.replace("%s", "channel: position.barge.surge, statistic: end")
    path = study(tmp_path, f"seeds: 1-2\n{asked}")
    assert f"study.yaml:4: {words}" in refusal(sweep, tmp_path, path, "-o", tmp_path / "runs.nc")


@pytest.mark.parametrize("until", ["", "until: {figure: a, wide: 100 m}\n"])
def test_figures_are_drawn_over_seeds_alone(
    tmp_path: Path, sweep: Command, monkeypatch: pytest.MonkeyPatch, until: str
) -> None:
    monkeypatch.chdir(tmp_path)
    text = "figures: {a: {channel: position.barge.surge, statistic: end}}"
    path = study(tmp_path, f"seeds: 1-2\n{until}{text}")
    printed = succeeds(sweep, path, "-o", "runs.nc", "--plot")
    assert Path("runs.png").exists()
    row = r"figure mean \[m\] 90 % interval \[m\] .* runs ─+ a -?0\.\d+ .* 2 table"
    assert re.search(row, printed)


@pytest.mark.parametrize("until", ["", "until: {figure: a, wide: 1 m}\n"])
def test_a_study_of_which_every_run_is_refused_stops_at_once(
    tmp_path: Path, sweep: Command, until: str
) -> None:
    """The step is above the stable limit, and the case has that refused: told once."""
    asked = "figures: {a: {channel: position.barge.surge, statistic: end}}"
    text = f"seeds: 1-2\n{until}parameters: {{{STATIC}: [0.2, 0.4], solver.step: [0.25]}}\n{asked}"
    path = study(tmp_path, text)
    said = refusal(sweep, tmp_path, path, "-o", tmp_path / "runs.nc")
    assert said.count("largest stable step") == 1
    assert "All 4 runs are refused before the first step." in said


def test_one_at_a_time_makes_the_case_once(tmp_path: Path) -> None:
    """Though it is among the values of both parameters; it has the name of its value."""
    kinetic = "forces.interface.friction.kinetic"
    linked = f"pair: {{keys: {{{STATIC}: [0.2, 0.3]}}, called: [low, high]}}"
    text = f"design: one_at_a_time\nparameters: {{{kinetic}: [0.05, 0.1], {linked}}}\nseeds: 1-2"
    found = load_study(study(tmp_path, text))
    assert found.labels["varied"].values.tolist()[::2] == ["", kinetic, "pair"]
    assert found.labels[named(kinetic)].values.tolist()[::2] == [0.1, 0.05, 0.1]
    assert found.labels["pair"].values.tolist()[::2] == ["low", "", "high"]
    assert len(found.scenes) == 6


RESULTS = """
seeds: 1-2
output: {step: 1 s, variables: [], channels: [speed.barge]}
figures:
  push: {result: mean_force, force: interface}
  apart: {result: time_share, mode: open}
parameters:
  forces.interface.friction.kinetic: [0.05, 0.1]
"""


def test_why_bodies_move_is_asked_for_by_name(tmp_path: Path, sweep: Command) -> None:
    """Impulses are recorded for it without being asked for; all figures are in one table."""
    printed = succeeds(sweep, study(tmp_path, RESULTS), "-o", tmp_path / "runs.nc")
    assert "All figures" in printed
    assert "fender_kinetic: a value for each run" in printed
    with xr.open_dataset(tmp_path / "runs.nc") as runs:
        force = runs.mean_force.sel(span="whole run", force="interface", dof="surge", body="barge")
        assert np.array_equal(runs.push, force)
        assert np.isfinite(runs.push).all()
        assert runs.fender_kinetic.values[:, 0].tolist() == [0.05, 0.05, 0.1, 0.1]
        assert runs.channel.values.tolist() == ["speed.barge"]


@pytest.mark.slow
def test_a_study_until_that_is_interrupted_as_a_round_ends_is_not_gone_on_with(
    tmp_path: Path, sweep: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All runs of the round are complete, and nothing in its result shows the interrupt."""
    monkeypatch.chdir(tmp_path)
    asked = "figures: {a: {channel: position.barge.surge, statistic: end}}"
    path = study(tmp_path, f"seeds: 1\nuntil: {{figure: a, wide: 1e-9 m, most: 4}}\n{asked}")
    before = {number: signal.getsignal(number) for number in ENDING_SIGNALS}
    signal.signal(signal.SIGINT, signal.default_int_handler)  # it may be ignored
    with monkeypatch.context() as patch:
        patch.setattr(executors, "_collect_garbage", lambda: signal.raise_signal(signal.SIGINT))
        ended = sweep(path, "-o", tmp_path / "runs.nc")
    for number, handler in before.items():
        signal.signal(number, handler)
    assert ended.code == 130
    assert "--resume continues" in ended.err
    assert len([*(tmp_path / "runs.nc.rounds").glob("*.nc")]) == 1
    assert sweep(path, "-o", tmp_path / "runs.nc", "--resume").code == 0
    assert sweep(path, "-o", tmp_path / "whole.nc").code == 0
    found, whole = (xr.load_dataset(tmp_path / name) for name in ("runs.nc", "whole.nc"))
    assert differences(found, whole) == []


LINKED = """
figures: {crawl: {channel: position.barge.surge, statistic: end}}
seeds: 1-2
output: {step: 1 s, variables: []}
studies:
  one: {parameters: {environment.waves.peak_period: [7 s, 8 s]}}
  two:
    parameters:
      pair:
        keys:
          forces.interface.friction.static: [0.7, 0.2]
          forces.interface.friction.kinetic: [0.4, 0.1]
        called: [high, low]
"""


def test_several_studies_of_one_file_with_tables_and_pictures(
    tmp_path: Path, sweep: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Values that a study does not vary are those of the case; all can be made again from the
    file of the runs."""
    monkeypatch.chdir(tmp_path)
    printed = succeeds(sweep, study(tmp_path, LINKED), "-o", "runs.nc", "--plot")
    with xr.open_dataset("runs.nc") as runs:
        assert runs.study.values.tolist() == ["one"] * 4 + ["two"] * 4
        assert runs.environment_waves_peak_period.values.tolist() == [7, 7, 8, 8] + [8] * 4
        assert runs.environment_waves_peak_period.attrs["units"] == "s"
        assert runs[named(STATIC)].values.tolist() == [0.2] * 4 + [0.7, 0.7, 0.2, 0.2]
        assert runs.pair.values.tolist() == [""] * 4 + ["high", "high", "low", "low"]
        assert runs.crawl.attrs["units"] == "m"
        end = runs.end_position.sel(body="barge", dof="surge")
        assert np.array_equal(runs.crawl, end)
    assert Path("runs_one.png").exists()
    assert Path("runs_two.png").exists()
    table = Path("runs.csv").read_text().splitlines()
    assert len(table) == 2 + 4
    assert table[2].startswith("one,7,,crawl,m,2,")
    assert "crawl low" in printed


def test_seeds_need_waves(tmp_path: Path) -> None:
    path = study(tmp_path, "seeds: 1-2\nparameters: {environment.waves: [null]}")
    said = r"study\.yaml:\d+: seeds: the case .* has neither waves nor gusts"
    with pytest.raises(hs.InputError, match=said):
        load_study(path)


PERIOD = "environment.waves.peak_period"


def test_waves_out_of_reach_are_said_once_before_the_runs(tmp_path: Path, sweep: Command) -> None:
    """Whatever their seeds; those that are refused fail, and with ``accept`` none does."""
    text = f"parameters: {{{PERIOD}: [2.5 s, 8 s], {HEIGHT}: [0.1 m]}}\nseeds: 1-2"
    output = "-o", tmp_path / "runs.nc"
    result = sweep(study(tmp_path, text), *output)
    assert result.code == 3
    assert result.err.count("in 2 of 4 runs found ") == 1
    assert "2 of 4 runs are complete" in result.out
    every = text.replace("[2.5 s, 8 s]", "[2.5 s]")
    path = study(tmp_path, every)
    assert "in 2 of 2 runs found " in refusal(sweep, tmp_path, path, *output)
    accept = every.replace("}", ", accept: [[range]]}")
    accepted = sweep(study(tmp_path, accept), "-o", tmp_path / "accepted.nc")
    assert accepted.code == 0
    assert "no first-order loads there" in accepted.err


BUOY = """\
title: A buoy on a spring
duration: 10 s
environment:
  waves: {spectrum: white_noise, significant_height: 1 m, lowest_frequency: 0.5 rad/s,
          highest_frequency: 2 rad/s}
bodies:
  buoy: {mass: 2 kg, dofs: [surge, yaw], radii_of_gyration: [1 m, 1 m, 1 m],
         initial: {velocity: [0, 0, 0, 0, 0, 1 deg/s]}}
forces:
  spring: {type: linear_mooring, body: buoy, stiffness: {surge: 5 N/m}}
"""


def test_a_frequency_of_waves_is_read_in_radians_per_second_and_a_turn_in_degrees(
    tmp_path: Path,
) -> None:
    """Also in a case that writes angles in degrees; in Hz in the study, too."""
    (tmp_path / "case.yaml").write_text(BUOY)
    key, path = "environment.waves.lowest_frequency", tmp_path / "study.yaml"
    path.write_text(f"case: case.yaml\nparameters: {{{key}: [0.1 Hz, 0.2 Hz]}}\n")
    lowest = load_study(path).labels[named(key)]
    np.testing.assert_allclose(lowest.values, 2.0 * np.pi * np.array([0.1, 0.2]))
    assert (lowest.attrs["units"], lowest.attrs["cyclic"]) == ("rad/s", 1)
    runs = xr.Dataset(coords={"lowest": lowest, "rate": ("run", [0.1, 0.2], {"units": "rad/s"})})
    plan = PlanRuns("", "grid", {}, [], None, runs)
    degrees = Units({"rad": "deg"})
    assert degrees.display_unit(plan.unit("lowest")) == ("rad/s", 1.0)
    assert degrees.display_unit(plan.unit("rate")).unit == "deg/s"
