"""`hydrosim calibrate` from the command line, and a case that names the same recording."""

from functools import partial
from pathlib import Path

import numpy as np
import pytest
import yaml
from command_line import Command, refusal, succeeds

import hydrosim as hs

PERIOD, LINEAR = 12.0, 0.06
CASE = """
title: Roll
duration: 10
environment: {water_depth: infinite}
bodies: {block: {mass: 2000 kg, radii_of_gyration: [2, 2, 2], centre_of_gravity: [0, 0, 0]}}
forces:
  bilges: {type: viscous_roll, body: block, decay: {file: decay.csv}}
"""


@pytest.fixture
def calibrate(hydrosim: Command) -> Command:
    """The command in a folder with a recorded decay, of linear damping in closed form."""
    time = np.arange(0.0, 100.0, 0.1)
    w = np.sqrt((2.0 * np.pi / PERIOD) ** 2 - 0.25 * LINEAR**2)
    roll = np.exp(-0.5 * LINEAR * time) * np.cos(w * time)
    roll += 0.01 * np.random.default_rng(1).normal(size=time.size)
    rows = np.transpose([time, 10.0 * roll])
    np.savetxt("decay.csv", rows, "%.6f", ",", header="time [s],roll [deg]", comments="")
    return partial(hydrosim, "calibrate")


def test_a_decay_is_told_drawn_and_written_as_keys(calibrate: Command) -> None:
    printed = succeeds(calibrate, "decay.csv", "-o", "keys.yaml", "--body", "block")
    assert "The records do not tell p2, p3 from zero" in printed
    assert "natural period [s]" in printed
    assert Path("keys.png").stat().st_size > 1e4
    keys = yaml.safe_load(Path("keys.yaml").read_text())["forces"]["roll_damping"]
    assert keys["type"] == "viscous_roll"
    assert keys["body"] == "block"
    assert float(keys["period"].split()[0]) == pytest.approx(PERIOD, rel=1e-3)
    p1, p2, p3 = (float(keys[key].split()[0]) for key in ("p1", "p2", "p3"))
    w, amplitude = 2.0 * np.pi / PERIOD, np.radians(5.0)
    total = p1 + 8.0 / (3.0 * np.pi) * p2 * w * amplitude + 0.75 * p3 * (w * amplitude) ** 2
    assert total == pytest.approx(LINEAR, rel=0.02)


def test_without_a_file_keys_are_printed(calibrate: Command) -> None:
    printed = succeeds(calibrate, "decay.csv", "decay.csv")
    assert "type: viscous_roll body: barge p1:" in printed
    assert Path("decay_fit.png").exists()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["other.csv"], "other.csv: there is no such file; expected a recording"),
        (["decay.csv", "--column", "pitch"], "found no column"),
        (["decay.csv", "--unit", "m"], "--unit: found 'm'; expected deg or rad"),
        (["decay.csv", "--to", "10"], "expected at least 2 periods"),
        (["decay.csv", "-o", "keys.txt"], "expected a name that ends in .yaml"),
    ],
)
def test_mistakes_are_told(calibrate: Command, arguments: list[str], said: str) -> None:
    assert said in refusal(calibrate, Path(), *arguments)


def test_a_case_fits_the_recording_that_it_names(calibrate: Command) -> None:
    Path("case.yaml").write_text(CASE)
    (bilges,) = hs.load_case("case.yaml").scene().forces.values()
    succeeds(calibrate, "decay.csv", "-o", "keys.yaml")
    keys = yaml.safe_load(Path("keys.yaml").read_text())["forces"]["roll_damping"]
    for key in ("p1", "p2", "p3", "period"):
        assert getattr(bilges, key) == pytest.approx(float(keys[key].split()[0]), rel=1e-5)
    resolved = hs.load_case("case.yaml").scene().source["case_resolved"]
    element = yaml.safe_load(resolved)["forces"]["bilges"]
    assert "decay" not in element
    assert element["p1"] == pytest.approx(bilges.p1)
    Path("again.yaml").write_text(resolved)
    assert hs.load_case("again.yaml").scene().forces["bilges"] == bilges


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ("decay: {file: none.csv}", "none.csv.*no such file|does not exist"),
        ("decay: {file: decay.csv, column: pitch}", "forces.bilges.decay.*found no column"),
        ("p1: 0.1, linear: 1e6", "found p1 and linear; expected one of: p1 p2 p3; decay"),
        ("p1: -0.1", "p1.*found -0.1"),
        ("linear: 1e6, includes_waves: true", "includes_waves with linear"),
        ("includes_waves: true", "found none; expected one of"),
        ("ikeda: {length: 90 m, beam: 27 m}", "ikeda: found no key .draught"),
    ],
)
def test_mistakes_in_a_case_are_told(calibrate: Command, keys: str, said: str) -> None:
    Path("case.yaml").write_text(CASE.replace("decay: {file: decay.csv}", keys))
    with pytest.raises(hs.InputError, match=said):
        hs.load_case("case.yaml").scene()
