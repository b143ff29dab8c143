"""Criteria of a study: the worst run, how many runs meet a limit, at which value it is exceeded."""

import csv
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from hydrosim.files.document_nodes import Outcome, Table, Value, Verdict
from hydrosim.report.page import html
from hydrosim.report.sentences.study import study_document, study_tables
from hydrosim.statistics import effects
from hydrosim.statistics.figures import judge_plan, judge_study
from hydrosim.statistics.over_seeds import as_csv
from hydrosim.study.many_runs import run_study
from hydrosim.study.sweep import load_study

FAR = {"limit": 2.0, "source": "Drawing 7", "at_least": False, "never_is_late": False}
CLEAR = {"limit": 0.5, "source": "", "at_least": True, "never_is_late": False}
LATE = {"limit": 100.0, "source": "", "at_least": False, "never_is_late": True}


def study(criteria: dict[str, Any], values: dict[str, list[float]], failed: int = 0) -> xr.Dataset:
    """Runs at two values of slip, of which the last ones failed."""
    count = len(next(iter(values.values())))
    plan = {"design": "grid", "samples": None, "parameters": {"slip": ["slip"]}}
    known = {"plans": {"": plan}, "figures": [*values], "criteria": criteria}
    done = count - failed
    return xr.Dataset(
        {
            "status": ("run", ["complete"] * done + ["failed"] * failed),
            "status_message": ("run", [""] * done + ["blows up"] * failed),
            **{
                name: ("run", np.array(each), {"units": "m", "long_name": f"{name} it goes"})
                for name, each in values.items()
            },
        },
        {
            "slip": ("run", np.repeat([1.0, 2.0], count // 2), {"units": "m/s"}),
            "seed": ("run", np.tile(np.arange(1, count // 2 + 1), 2)),
        },
        {"title": "t", "design": json.dumps(known)},
    )


def verdicts(runs: xr.Dataset) -> list[Verdict]:
    return [node for node in study_tables(runs).nodes if isinstance(node, Verdict)]


def test_the_worst_run_its_seed_and_its_value_of_the_parameter_are_named() -> None:
    runs = study({"far": FAR}, {"far": [1.0, 1.5, 1.9, 2.0, 2.4, 2.1]})
    (judged,) = judge_study(effects.plans(runs))
    assert (judged.worst.value, judged.seed, judged.values) == (2.4, "2", {"slip": 2.0})
    assert judged.worst.margin == pytest.approx(-0.4)
    assert (judged.met, judged.runs) == (4, 6)  # a value at the limit meets it
    each = list(judge_plan(effects.plans(runs)[0]))
    assert [(of.values["slip"], of.met, of.is_met) for of in each] == [
        (1.0, 3, True),
        (2.0, 1, False),
    ]
    first, second = verdicts(runs)[:2]
    assert (first.outcome, list(first.parts)) == (Outcome.BAD, ["0", "1"])
    said = str(study_tables(runs))
    assert "far it goes is 2.4 m in the worst run (slip 2 m/s, seed 2)" in said
    assert "allowed is at most 2 m. 4 of 6 runs meet it." in said
    assert Value(2.4, "m") in second.parts


def test_a_limit_from_below_is_judged_by_the_smallest_value() -> None:
    runs = study({"clear": CLEAR}, {"clear": [0.9, 0.6, 0.7, 0.51]})
    (judged,) = judge_study(effects.plans(runs))
    assert judged.is_met
    assert judged.worst.value == 0.51
    assert judged.worst.margin == pytest.approx(0.01)
    assert verdicts(runs)[0].outcome is Outcome.GOOD


def test_what_never_comes_keeps_a_limit_but_is_later_than_any() -> None:
    """A phase that is not reached has nothing to exceed; a stage that is not reached is late."""
    nan = np.nan
    runs = study({"far": FAR, "time": LATE}, {"far": [1.0, nan, nan, 1.2], "time": [9, nan, 9, 9]})
    far, time = judge_study(effects.plans(runs))
    assert far.is_met
    assert (far.met, far.without) == (4, 2)
    assert not time.is_met
    assert (time.met, time.runs, time.without) == (3, 4, 0)
    said = " ".join(str(study_tables(runs)).split())
    assert "2 of 4 runs never come to far" in said
    assert "time it goes is never in the worst run" in said


def test_runs_that_failed_are_not_judged_and_are_told() -> None:
    values = {"far": [1.0, 1.0, 1.0, np.nan]}
    runs = study({"far": FAR}, values, failed=1)
    (judged,) = judge_study(effects.plans(runs))
    assert (judged.met, judged.runs, judged.without) == (3, 3, 0)
    assert "in the 3 runs of 4 that are complete" in str(study_tables(runs))
    none = study({"far": FAR}, {"far": [np.nan] * 4}, failed=4)
    assert verdicts(none)[0].outcome is Outcome.BAD
    assert "far has no value: no run is complete" in str(study_tables(none))


def test_met_criteria_with_failed_runs_are_a_warning_not_a_pass() -> None:
    runs = study({"far": FAR}, {"far": [1.0, 1.0, 1.0, np.nan]}, failed=1)
    assert verdicts(runs)[0].outcome is Outcome.WARNING


def test_terminal_page_and_table_say_the_same() -> None:
    runs = study({"far": FAR, "clear": CLEAR}, {"far": [1, 1, 3, 1], "clear": [1, 1, 1, 1]})
    tables = [node for node in study_tables(runs).nodes if isinstance(node, Table)]
    register = next(table for table in tables if table.title == "Criteria")
    assert [row[5] for row in register.rows] == ["NOT MET", "met"]
    assert [row[-1] for row in register.rows] == ["Drawing 7", ""]
    page = html(study_document(runs), "mark")
    assert "1 of 2 criteria are met in all 4 runs" in page.replace("<b>", "").replace("</b>", "")
    rows = list(csv.DictReader(io.StringIO(as_csv(runs))))
    found = {(row["slip [m/s]"], row["figure"]): row for row in rows}
    exceeded = found["2", "far"]
    assert (exceeded["met"], exceeded["runs_met"], exceeded["source"]) == ("no", "1", "Drawing 7")
    assert [float(exceeded[key]) for key in ("worst", "limit", "margin")] == [3.0, 2.0, -1.0]
    assert found["1", "far"]["met"] == "yes"
    assert float(found["1", "clear"]["margin"]) == 0.5


def test_figures_without_limits_are_not_judged() -> None:
    runs = study({}, {"far": [1.0, 2.0]})
    assert judge_study(effects.plans(runs)) == []
    assert "criteria" not in str(study_tables(runs))
    assert [row["met"] for row in csv.DictReader(io.StringIO(as_csv(runs)))] == ["", ""]


def test_a_study_file_is_judged_by_its_own_limits(tmp_path: Path) -> None:
    """A block on a spring without damping swings as far as it began: 0.2 m and 0.5 m."""
    (tmp_path / "case.yaml").write_text(
        "title: A block on a spring\n"
        "duration: 10 s\n"
        "bodies:\n"
        "  block: {mass: 2 kg, dofs: [surge], initial: {position: [0, 0, 0, 0, 0, 0]}}\n"
        "forces:\n"
        "  spring: {type: linear_mooring, body: block, stiffness: {surge: 5 N/m}}\n"
    )
    path = tmp_path / "study.yaml"
    path.write_text(
        "case: case.yaml\n"
        "parameters: {bodies.block.initial.position.0: [200 mm, 500 mm]}\n"
        "criteria:\n"
        "  far: {channel: position.block.surge, statistic: largest, limit: 400 mm, source: D7}\n"
        "  near: {channel: position.block.surge, statistic: smallest, limit: -300 mm}\n"
        "  most: {channel: position.block.surge, statistic: std, limit: 0.1 m, side: at least}\n"
    )
    runs = run_study(load_study(path), tmp_path / "runs.nc")
    far, near, most = judge_study(effects.plans(runs))
    assert (far.worst.value, far.worst.source) == (pytest.approx(0.5, abs=1e-3), "D7")
    assert near.worst.margin == pytest.approx(-0.2, abs=1e-3)
    assert (far.met, near.met, most.met) == (1, 1, 2)
    assert most.worst.margin == pytest.approx(0.2 / 2**0.5 - 0.1, abs=0.01)


def test_a_study_takes_over_the_criteria_of_its_case(tmp_path: Path) -> None:
    """Under their names, unless the study has a limit of its own of that name."""
    (tmp_path / "case.yaml").write_text(
        "title: A block on a spring\n"
        "duration: 10 s\n"
        "bodies:\n"
        "  block: {mass: 2 kg, dofs: [surge], initial: {position: [0.3, 0, 0, 0, 0, 0]}}\n"
        "forces:\n"
        "  spring: {type: linear_mooring, body: block, stiffness: {surge: 5 N/m}}\n"
        "criteria:\n"
        "  how_far: {channel: position.block.surge, statistic: largest, limit: 0.2, source: D7}\n"
        "  near: {channel: position.block.surge, statistic: smallest, limit: -0.4}\n"
    )
    path = tmp_path / "study.yaml"
    path.write_text(
        "case: case.yaml\n"
        "parameters: {forces.spring.stiffness.surge: [5, 10]}\n"
        "criteria: {near: {channel: position.block.surge, statistic: smallest, limit: -0.1}}\n"
    )
    runs = run_study(load_study(path), tmp_path / "runs.nc")
    judged = {of.worst.name: of for of in judge_study(effects.plans(runs))}
    assert {name: of.worst.limit for name, of in judged.items()} == {"how_far": 0.2, "near": -0.1}
    assert judged["how_far"].worst.value == pytest.approx(0.3, abs=1e-3)
    assert judged["how_far"].worst.source == "D7"
    assert not judged["near"].is_met
