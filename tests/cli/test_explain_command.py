"""`hydrosim explain` on the terminal."""

import re
from functools import partial
from pathlib import Path

import pytest
import xarray as xr
from command_line import Command, refusal, succeeds
from recorded_runs import made_run
from scenes import block, moving, on_floor, scene, steady

import hydrosim as hs
from hydrosim.elements import AppliedForce, Harmonic, StickSlip
from hydrosim.results.dataset import write_run
from hydrosim.scene import Scene

MASS, WEIGHT = 1e5, 9.81e5
LAW = StickSlip(0.3, 0.2, stiffness=2e7, damping=4e5, slip_damping=4e4)


def shaken(period: float, impulses: bool = True) -> Scene:
    """A block on the floor that is shaken until it slips."""
    body = block(MASS, ("surge", "heave"), position=moving(heave=-WEIGHT / 1e7))
    forces = {
        "floor": on_floor(1e7, LAW),
        "weight": steady(heave=-WEIGHT),
        "shake": AppliedForce("block", (0.0, 0.0, 0.0), {"surge": Harmonic(4e5, period)}),
    }
    return scene(body, forces, 10.0, 0.1, step=0.02).with_output(impulses=impulses)


@pytest.fixture
def explain(hydrosim: Command) -> Command:
    """`hydrosim explain` in an empty folder."""
    return partial(hydrosim, "explain")


def test_a_run(explain: Command, tmp_path: Path) -> None:
    """Tables of it, a file and a picture."""
    path = tmp_path / "shaken.nc"
    write_run(hs.simulate(shaken(3.0)), path)
    printed = succeeds(explain, path)
    assert "block in surge" in printed
    assert "mean friction of floor in surge" in printed
    assert "Impulses of all forces" not in printed
    assert "nan" not in printed
    details = explain(path, "--verbose")
    assert "Impulses of all forces add up to the change of momentum" in details.out
    with xr.open_dataset(tmp_path / "shaken_explained.nc") as found:
        assert found.mean_force.attrs["dof_units"] == "N, N, N, N m, N m, N m"
        assert not any(" or " in x.attrs.get("units", "") for x in found.values())
        assert all(found[name].attrs["long_name"] for name in found.data_vars)
    assert (tmp_path / "shaken_explained.png").stat().st_size > 10_000


def test_many_runs(explain: Command, tmp_path: Path) -> None:
    """Means of them with intervals."""
    path = tmp_path / "runs.nc"
    with hs.simulate_many([shaken(period) for period in (2.5, 3.0, 3.5)], path, workers=1):
        pass
    printed = succeeds(explain, path)
    assert re.search(r"displacement \[m\] -?[\d.]+ \(-?[\d.]+ to -?[\d.]+\)", printed)
    assert "nan" not in printed
    assert explain(path, "--from", 5, "--overwrite").code == 2


def test_many_runs_without_contacts(explain: Command, tmp_path: Path) -> None:
    """Mean forces alone: 10, 20 and 30 kN, half of whose interval is t(2) s / sqrt(3) = 2.92 x 10 /
    sqrt(3); F t^2 / 2 M is 10 m of 20 kN."""
    body = block(MASS, ("surge",))
    pushes = [
        scene(body, {"push": steady(surge=x)}, 10.0, 0.1).with_output(impulses=True)
        for x in (1e4, 2e4, 3e4)
    ]
    path = tmp_path / "pushed.nc"
    with hs.simulate_many(pushes, path, workers=1):
        pass
    printed = succeeds(explain, path)
    assert "mean force, push [kN] 20.00 (3.14 to 36.86)" in printed
    assert "displacement [m] 10.00 (" in printed
    assert "friction" not in printed
    assert (tmp_path / "pushed_explained.png").stat().st_size > 5_000
    assert explain(path, "--direction", "heave").code == 0


def test_what_cannot_be_explained(explain: Command, tmp_path: Path) -> None:
    """Each is refused with one message that says what it lacks."""
    bare, runs, text = (tmp_path / name for name in ("bare.nc", "runs.nc", "study.yaml"))
    write_run(made_run(), bare)
    with hs.simulate_many([shaken(3.0, impulses=False)], runs, workers=1):
        pass
    text.write_text("case: base.yaml")
    for path, said in (
        (bare, "bare.nc: found a run without impulse, work, momentum; expected a run with output:"),
        (runs, "runs.nc: found runs without impulses; expected a run with output:"),
        (text, "study.yaml: cannot be read as netCDF"),
        (tmp_path / "none.nc", "none.nc: "),
    ):
        assert said in refusal(explain, tmp_path, path)
    path = tmp_path / "shaken.nc"
    write_run(hs.simulate(shaken(3.0)), path)
    for option, value in (("--direction", "pitch"), ("--body", "ship"), ("--from", 20)):
        assert "found" in refusal(explain, tmp_path, path, option, value)
