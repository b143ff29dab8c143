"""Studies in stages: a block that is driven by the recorded mooring force of another."""

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from command_line import Command
from scenes import ROOT, SWINGING_BLOCK

import hydrosim as hs
from hydrosim.simulation import outdated_reason

FIRST = SWINGING_BLOCK.replace(", linear: step", "")
SECOND = """\
title: Driven block
duration: 20 s
bodies:
  block: {mass: 2 kg, dofs: [surge]}
forces:
  push:
    type: applied_force
    body: block
    force: {surge: {file: first.nc, case: first.yaml, column: force_spring.surge}}
solver: {step: 0.02 s}
output: {step: 0.1 s}
"""
THIRD = SECOND.replace("first", "second").replace("force_spring", "force_push")
RUNS = shutil.ignore_patterns("no_friction.nc")


@pytest.fixture
def cases(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name, text in {"first": FIRST, "second": SECOND, "third": THIRD}.items():
        (tmp_path / f"{name}.yaml").write_text(text)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def age(path: Path) -> int:
    return path.stat().st_mtime_ns


def test_one_command_makes_both(cases: Path, hydrosim: Command) -> None:
    """The first block swings as 0.3 cos(w t); the same force lets the second, which starts at rest
    in its middle, move by 0.3 (cos(w t) - 1): to the error of the spline at 0.1 s, w = 1.58/s."""
    code, _, err = hydrosim("run", "second.yaml")
    assert code == 0
    assert "first stage: first.nc does not exist: simulating first.yaml" in err
    assert {p.name for p in cases.glob("*.nc")} == {"first.nc", "second.nc"}
    assert not list(cases.glob("*.partial"))
    first, second = (hs.open_run(f"{name}.nc") for name in ("first", "second"))
    xr.testing.assert_equal(first, hs.simulate(hs.load_case("first.yaml")))
    exact = 0.3 * (np.cos(np.sqrt(2.5) * second.time.values) - 1.0)
    assert np.abs(second.position.values[:, 0, 0] - exact).max() < 2e-5
    assert "forces.push.force.surge: cubic spline through 201 values" in second.attrs["records"]


def test_what_is_there_is_not_made_again(cases: Path, hydrosim: Command) -> None:
    hydrosim("run", "second.yaml")
    made = age(cases / "first.nc")
    code, _, err = hydrosim("run", "second.yaml")
    assert (code, "first stage" in err, age(cases / "first.nc")) == (0, False, made)


def test_from_python_and_over_three_stages(cases: Path) -> None:
    run = hs.simulate(hs.load_case("third.yaml"))
    assert run.attrs["status"] == "complete"
    assert (cases / "first.nc").is_file()
    assert (cases / "second.nc").is_file()
    before = age(cases / "second.nc")
    (cases / "first.yaml").write_text(FIRST.replace("5 N/m", "6 N/m"))
    again = hs.simulate(hs.load_case("third.yaml"))
    assert age(cases / "second.nc") > before  # though its own case is the same
    assert not np.allclose(run.position, again.position)


def test_why_a_run_is_made_again(cases: Path) -> None:
    hs.simulate(hs.load_case("second.yaml"))

    def reason() -> str | None:
        (stage,) = hs.load_case("second.yaml").stages()
        return outdated_reason(stage)

    def marked(**attributes: str) -> str | None:
        run = xr.load_dataset("first.nc")
        run.assign_attrs(attributes).to_netcdf("other.nc")
        os.replace("other.nc", "first.nc")
        return reason()

    assert reason() is None
    assert "was made by hydrosim 0.0" in str(marked(program="hydrosim 0.0"))
    Path("first.yaml").write_text(FIRST + "# a remark\n")
    assert "was made from a different text of first.yaml" in str(reason())
    Path("first.yaml").write_text(FIRST)
    Path("first.nc").unlink()
    hs.simulate(hs.load_case("second.yaml"))
    assert "is the result of an incomplete run" in str(marked(status="interrupted"))
    Path("first.nc").write_text("no run")
    assert "is not the result of a run" in str(reason())


def test_check_simulates_nothing(cases: Path, hydrosim: Command) -> None:
    code, out, _ = hydrosim("check", "second.yaml")
    assert code == 0
    assert "first.nc does not exist; hydrosim run second.yaml simulates it" in out
    assert not list(cases.glob("*.nc"))
    hydrosim("run", "second.yaml")
    code, out, _ = hydrosim("check", "second.yaml")
    assert code == 0
    assert "forces.push.force.surge is a record" in out
    code, out, _ = hydrosim("check", "second.yaml", "--verbose")
    assert code == 0
    assert "Recorded forces.push.force.surge: cubic spline through 201 values" in " ".join(
        out.split()
    )


def test_a_first_stage_that_fails_writes_nothing(cases: Path, hydrosim: Command) -> None:
    turning = "radii_of_gyration: [1, 1, 1], dofs: [pitch], initial: {velocity: [0, 0, 0, 0, 1, 0]}"
    bodies = f"bodies:\n  block: {{mass: 2 kg, {turning}}}\n"
    (cases / "first.yaml").write_text(f"title: Turning\nduration: 20 s\n{bodies}")
    code, _, err = hydrosim("run", "second.yaml")
    assert code == 3
    assert "pitch of body block" in err
    assert not list(cases.glob("*.nc"))


def test_an_interrupt_in_the_first_stage(
    cases: Path, hydrosim: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> xr.Dataset:
        return xr.Dataset(attrs={"status": "interrupted"})

    monkeypatch.setattr("hydrosim.cli.run.simulate_with_progress", interrupted)
    assert hydrosim("run", "second.yaml")[0] == 130
    assert not list(cases.glob("*.nc"))


def test_cases_that_need_each_other(cases: Path, hydrosim: Command) -> None:
    (cases / "second.yaml").write_text(SECOND.replace("first", "third"))
    code, out, err = hydrosim("run", "third.yaml")
    assert (code, out) == (2, "")
    assert (
        "second.yaml: found a series from a run of third.yaml, which itself needs a run of" in err
    )
    assert not list(cases.glob("*.nc"))


def test_a_case_without_its_first_stage_has_no_scene(cases: Path) -> None:
    with pytest.raises(hs.InputError, match=r"first\.nc: found no such file; expected the run of"):
        hs.load_case("second.yaml").scene()


def test_the_one_dimensional_model_crawls_as_the_barge(
    tmp_path: Path, base_run: xr.Dataset, figure: Callable[[str, float], None]
) -> None:
    """The case as it is, from its own friction-free run. It leaves out pitch and heave of the run
    with friction: what it says of the crawl is to be held to a fifth, not to digits."""
    for folder in ("cases", "hydro_db"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=RUNS)
    run = hs.simulate(hs.load_case(tmp_path / "cases" / "one_dimensional" / "base.yaml"))
    assert (tmp_path / "cases" / "reverse_float_over" / "no_friction.nc").is_file()
    for time in (1000.0, 2000.0):
        here, there = (
            float(x.position.sel(time=time, body="barge", dof="surge")) for x in (run, base_run)
        )
        figure(f"surge at {time:g} s", here)
        figure("of the whole barge", there)
        assert here == pytest.approx(there, rel=0.2)
    moored = slice(200.0, 500.0)  # no contact yet: the same force on a heavier mass
    means = [x.position.sel(time=moored, dof="surge").mean().item() for x in (run, base_run)]
    assert means[0] == pytest.approx(means[1], rel=0.05)
