"""MoorDyn through the door, against MoorDyn driven alone."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scenes import block, central_force, moving, scene

import hydrosim as hs
from hydrosim.elements import Harmonic
from hydrosim.results.dataset import write_run

moordyn = pytest.importorskip("moordyn")
pytestmark = pytest.mark.extras

DEPTH = 100.0
FAIRLEADS = {2: (-20.0, 5.0, -10.0), 4: (20.0, -5.0, -10.0)}
LINES = """MoorDyn input
two chains
---- LINE TYPES
Name Diam MassDen EA BA/-zeta EI Cd Ca CdAx CaAx
(-) (m) (kg/m) (N) (N-s/-) (N-m^2) (-) (-) (-) (-)
chain 0.252 390.0 1.674e9 -0.8 0.0 1.0 1.0 0.0 0.0
---- POINTS
ID Type X Y Z Mass Volume CdA Ca
(#) (-) (m) (m) (m) (kg) (m^3) (m^2) (-)
1 Fixed -320.0 5.0 -100.0 0 0 0 0
2 Coupled -20.0 5.0 -10.0 0 0 0 0
3 Fixed 320.0 -5.0 -100.0 0 0 0 0
4 Coupled 20.0 -5.0 -10.0 0 0 0 0
---- LINES
ID LineType AttachA AttachB UnstrLen NumSegs Outputs
(#) (name) (#) (#) (m) (-) (-)
1 chain 1 2 330.0 10 -
2 chain 3 4 330.0 10 -
---- OPTIONS
0.005 dtM
3.0e6 kBot
3.0e5 cBot
100 WtrDpth
2.0 dtIC
60.0 TmaxIC
0.001 threshIC
1 disableOutTime
---- OUTPUTS
FairTen1
---- end
"""
HEAVY = 1e15  # kg: the lines do not move it
STEP, END, PERIOD = 0.05, 5.0, 10.0  # s
SWING = 0.5  # m
OWN_STEP = 0.005  # s, dtM


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "lines.txt"
    path.write_text(LINES)
    return path


def heavy(forces: dict[str, Any]) -> hs.Scene:
    return scene(block(HEAVY, ("surge",), name="barge"), forces, END, STEP)


def alone(file: Path, surge: Callable[[float], float]) -> np.ndarray:
    """Forces (nt, 6) on both fairleads in MoorDyn's own run along a given path, step by step."""
    system = moordyn.Create(str(file))
    rest = np.array(list(FAIRLEADS.values()))

    def at(t: float) -> np.ndarray:
        return (rest + np.array([surge(t), 0.0, 0.0])).ravel()

    moordyn.Init(system, at(0.0).tolist(), np.zeros(6).tolist())
    points = [moordyn.GetPoint(system, number) for number in FAIRLEADS]
    forces = [np.concatenate([moordyn.GetPointForce(point) for point in points])]
    each = round(STEP / OWN_STEP)
    for n in range(each * round(END / STEP)):
        t = n * OWN_STEP
        speed = (at(t + OWN_STEP) - at(t)) / OWN_STEP
        found = moordyn.Step(system, at(t).tolist(), speed.tolist(), t, OWN_STEP)
        if (n + 1) % each == 0:
            forces.append(found)
    moordyn.Close(system)
    return np.array(forces)


def wrenches(forces: np.ndarray, surge: Callable[[float], float]) -> np.ndarray:
    """Wrenches (nt, 6) about the centre of gravity: at rest at the origin, without rotation."""
    arms = np.array(list(FAIRLEADS.values()))
    each = forces.reshape(-1, 2, 3)
    return np.hstack([each.sum(axis=1), np.cross(arms, each).sum(axis=1)])


PATHS: dict[str, Callable[[float], float]] = {
    "at rest": lambda t: 0.0,
    "forced": lambda t: SWING * (1.0 - np.cos(2.0 * np.pi * t / PERIOD)),
}


@pytest.mark.parametrize("name", PATHS)
def test_chains_are_those_of_moordyns_own_run(name, file, figure):
    """On a heavy body that stays, or is swung: MoorDyn's force at the output time is held."""
    omega = 2.0 * np.pi / PERIOD
    drive = Harmonic(HEAVY * SWING * omega**2, PERIOD, phase=np.pi / 2.0)
    forces = {"drive": central_force("barge", surge=drive)}
    whole = heavy({} if name == "at rest" else forces)
    run = hs.simulate(whole, forces={"lines": hs.moordyn(file, "barge", "held")})
    expected = wrenches(alone(file, PATHS[name]), PATHS[name])
    found = run.force_lines.values[:, 0]
    apart = float(np.abs(found - expected).max() / np.abs(expected[:, :3]).max())
    figure(f"{name}: difference of forces, relative", apart)
    assert apart < 1e-6
    assert name == "at rest" or np.ptp(expected[:, 0]) > 1e4


def test_the_coupling_has_the_stated_orders(file, figure):
    """From rest, as a start with a speed would be a blow that the first step holds."""
    file.write_text(LINES.replace("0.005 dtM", "0.0025 dtM"))
    push = central_force("barge", surge=Harmonic(5e7, 8.0))

    def path(step: float, coupling: str) -> np.ndarray:
        light = scene(block(1e8, ("surge",), name="barge"), {"push": push}, 1.6, 0.1, step=step)
        run = hs.simulate(light, forces={"lines": hs.moordyn(file, "barge", coupling)})
        return np.asarray(run.position[:, 0, 0])

    exact = path(0.0025, "extrapolated")
    for coupling, order in (("held", 1), ("extrapolated", 2)):
        coarse, fine = (np.abs(path(step, coupling) - exact).max() for step in (0.02, 0.01))
        figure(f"order, {coupling}", float(np.log2(coarse / fine)))
        assert np.log2(coarse / fine) == pytest.approx(order, abs=0.2)


def test_a_run_with_moordyn_goes_on_to_the_bit(file: Path, tmp_path: Path) -> None:
    barge = block(1e7, ("surge",), "barge", velocity=moving(surge=0.5))
    light = replace(heavy({}), bodies=(barge,))
    whole = hs.simulate(light, forces={"lines": hs.moordyn(file, "barge")})
    before = hs.simulate(replace(light, duration=2.0), forces={"lines": hs.moordyn(file, "barge")})
    write_run(before, tmp_path / "before.nc")
    rest = replace(light, duration=END - 2.0, initial=hs.Start(tmp_path / "before.nc"))
    after = hs.simulate(rest, forces={"lines": hs.moordyn(file, "barge")})
    expected = whole.sel(time=slice(2.0 - 1e-9, None))
    np.testing.assert_array_equal(after.position, expected.position)
    np.testing.assert_array_equal(after.force_lines, expected.force_lines)


def test_several_bodies_share_one_mooring(file: Path) -> None:
    """The chains on two bodies load each as they load one body that has both."""
    bodies = [block(HEAVY, ("surge",), name=name) for name in ("barge", "tender")]
    both = hs.moordyn(file, {2: "barge", 4: "tender"}, "held")
    run = hs.simulate(replace(heavy({}), bodies=tuple(bodies)), forces={"lines": both})
    one = hs.simulate(heavy({}), forces={"lines": hs.moordyn(file, "barge", "held")})
    total = run.force_lines.sum("body")
    np.testing.assert_allclose(total, one.force_lines[:, 0], rtol=0.0, atol=0.1)
    assert abs(float(run.force_lines[-1, 1, 0])) > 1e5


def test_what_cannot_be_is_refused(file: Path, tmp_path: Path) -> None:
    with pytest.raises(hs.InputError, match="expected held or extrapolated"):
        hs.moordyn(file, "barge", "stage")
    with pytest.raises(hs.InputError, match="there is no file"):
        hs.moordyn(tmp_path / "none.txt", "barge")
    with pytest.raises(hs.InputError, match=r"expected one for each coupled point"):
        hs.moordyn(file, {2: "barge"})
    used = hs.moordyn(file, "barge")
    hs.simulate(heavy({}), forces={"lines": used})
    with pytest.raises(hs.SimulationError, match=r"make a new hydrosim.moordyn for each run"):
        hs.simulate(heavy({}), forces={"lines": used})
