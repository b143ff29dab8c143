"""The devices of cases/lock_in: what its page states, on single seeds, and their balances."""

import importlib.util
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
import yaml
from markers import few

import hydrosim as hs
from hydrosim.compile.compile import compile_scene
from hydrosim.statistics.explain import explain_run

CASES = Path(__file__).parents[3] / "cases" / "lock_in"
SEEDS = few((1, 2), 1)
FILES = ("base", "pins", "clamp", "ratchet", "lines")
LOCKED = ("pins", "clamp", "ratchet")
CLOSED = 3
HEIGHT = 7.5  # m: the lock above the centre of gravity
STEP = 0.1  # s: of the records that Newton's law is tested on


@cache
def run_of(name: str, seed: int) -> xr.Dataset:
    return hs.simulate(hs.load_case(CASES / f"{name}.yaml", {"environment.waves.seed": seed}))


def surge(run: xr.Dataset) -> np.ndarray:
    return run.position.sel(dof="surge").values[:, 0]


def lock_place(run: xr.Dataset) -> np.ndarray:
    """Surge of the lock's point on deck."""
    pitch = run.position.sel(dof="pitch").values[:, 0]
    return surge(run) + HEIGHT * np.sin(pitch)


def yaml_of(path: Path) -> Any:
    return yaml.safe_load(path.read_text())


def closing(run: xr.Dataset) -> int:
    """Number of the first record with a closed lock."""
    return int(np.argmax(run.lock_mode.values[:, 0] == CLOSED))


@pytest.mark.parametrize("seed", SEEDS)
def test_the_order_of_the_alternatives(seed: int) -> None:
    """Pins and lines hold it; friction and a late clamp let it crawl, a ratchet let it go."""
    end = {name: surge(run_of(name, seed))[-1] for name in FILES}
    assert abs(end["lines"]) < 0.1
    assert abs(end["pins"]) < 0.15
    assert -1.9 < end["base"] < -0.8
    assert -1.9 < end["clamp"] < -0.7
    assert 0.8 < end["ratchet"] < 2.2


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", FILES)
def test_the_ledger_closes(name: str, seed: int) -> None:
    run = run_of(name, seed)
    exchanged = np.abs(run.energy_work_wave_first_order.values).max()
    assert np.abs(run.energy_residual.values).max() < 1e-4 * exchanged
    if name in LOCKED:
        assert run.energy_dissipated_joints.values[-1] == run.lock_loss.values[-1, 0] > 0.0


@pytest.mark.parametrize("seed", SEEDS)
def test_the_pin_closes_within_its_window_and_holds(seed: int) -> None:
    """Heave and pitch stay free; its axis has the small pitch of the closing."""
    run = run_of("pins", seed)
    k = closing(run)
    tilt = run.position.sel(dof="pitch").values[k, 0]
    heave = run.position.sel(dof="heave").values[:, 0]
    along = np.array([np.cos(tilt), -np.sin(tilt)])  # across the axis, in x and z
    pitch = run.position.sel(dof="pitch").values[:, 0]
    across = along @ [lock_place(run), heave + HEIGHT * np.cos(pitch)]
    assert abs(lock_place(run)[k]) < 0.1
    assert np.abs(across[k:] - across[k]).max() < 1e-3
    assert np.ptp(heave[k:]) > 0.3


@pytest.mark.parametrize("seed", SEEDS)
def test_impulse_and_loss_at_closing_are_those_of_the_effective_mass(seed: int) -> None:
    """p = m v and loss = m v^2 / 2 with m = 1 / (J M^-1 J^T), M of surge, heave and pitch."""
    run = run_of("pins", seed)
    model = compile_scene(hs.load_case(CASES / "pins.yaml").scene()).model
    mass, gyration = 1.56758e8, 67.6
    inertia = mass * np.diag([1.0, 1.0, gyration**2])
    moving = [0, 2, 4]
    M = inertia + model.added_mass[np.ix_(moving, moving)]
    impulse = run.lock_impulse.values[-1, 0, [0, 2]]
    size = float(np.hypot(*impulse))
    across, tilted = impulse / size
    J = np.array([across, tilted, HEIGHT * across])
    effective = 1.0 / (J @ np.linalg.solve(M, J))
    loss = run.lock_loss.values[-1, 0]
    assert loss == pytest.approx(0.5 * size**2 / effective, rel=1e-5)
    assert size / effective < 0.02 * (1.0 + 1e-3)  # m/s: the window


def test_the_load_of_the_pin_is_that_of_newtons_law() -> None:
    """(M + A) times the accelerations of finite differences, less all other forces in surge."""
    over = {"output.step": f"{STEP} s", "duration": "800 s"}
    case = hs.load_case(CASES / "pins.yaml", over)
    run = hs.simulate(case)
    A = compile_scene(case.scene()).model.added_mass[0]
    u = run.velocity.values[:, 0]
    rates = (8.0 * (u[3:-1] - u[1:-3]) - (u[4:] - u[:-4])) / (12.0 * STEP)
    names = [n for n in run.data_vars if str(n).startswith("force_") and n != "force_joints"]
    forces = sum(run[name].values[:, 0, 0] for name in names)
    closed = slice(closing(run) + 3, -3)
    needed = 1.56758e8 * rates[:, 0] + rates @ A - forces[2:-2]
    load = run.joint_force.values[2:-2, 0, 0]
    wrong = (needed - load)[closed]
    assert np.abs(load[closed]).max() > 3e6
    assert np.sqrt(np.mean(wrong**2)) < 0.01 * np.sqrt(np.mean(load[closed] ** 2))


@pytest.mark.parametrize("seed", SEEDS)
def test_the_ratchet_never_goes_back_beyond_its_last_tooth(seed: int) -> None:
    run = run_of("ratchet", seed)
    place = lock_place(run)
    begin = int(np.argmax(run.lock_mode.values[:, 0] > 0))
    farthest = np.maximum.accumulate(place[begin:])
    assert (farthest - place[begin:]).max() < 0.1 + 1e-3
    push = run.joint_force.values[:, 0, 0]
    assert push.min() >= -1e-6 * push.max()


@pytest.mark.parametrize("name", LOCKED)
def test_explain_books_the_lock(name: str) -> None:
    """Forces sum to the change of momentum, works to that of kinetic energy, closing included."""
    run = run_of(name, 1)
    found = explain_run(run)
    forces = found.mean_force.sel(dof="surge", force="joints")
    assert float(np.abs(forces).max()) > 1e4
    assert float(np.abs(found.unbalanced).max()) < 1e-3
    assert float(np.abs(found.work_missing).max()) < 10.0 * np.abs(run.energy_residual).max()
    loss = run.lock_loss.values[-1, 0]
    assert name == "clamp" or loss > 50.0 * float(np.abs(found.work_missing).max())


def test_a_ratchet_without_teeth_does_not_chatter() -> None:
    """Where its load ends, rounding decides whether its point goes back."""
    over = {"joints.lock.slide.pitch": "0 m", "duration": "800 s", "output.impulses": False}
    run = hs.simulate(hs.load_case(CASES / "ratchet.yaml", over))
    begin = int(np.argmax(run.lock_mode.values[:, 0] > 0))
    back = np.diff(lock_place(run)[begin:]).min()
    assert back > -2e-4  # m: its axis has the pitch of the barge when it becomes active
    modes = run.lock_mode.values[begin:, 0]
    assert np.count_nonzero(np.diff(modes)) > 20
    assert run.lock_loss.values[-1, 0] < 1.0  # J: it is held where it stands still


def test_the_study_has_the_devices_of_the_cases() -> None:
    study = yaml_of(CASES / "studies" / "devices.yaml")["studies"]["devices"]["parameters"]
    keys = study["device"]["keys"]
    for i, name in enumerate(FILES):
        case = yaml_of(CASES / f"{name}.yaml")
        assert keys["joints"][i] == case.get("joints", {})
        for line in ("port", "starboard"):
            assert keys[f"forces.{line}"][i] == case.get("forces", {}).get(line)


def test_tables_of_the_page_are_those_of_the_studies() -> None:
    spec = importlib.util.spec_from_file_location("page", CASES / "studies" / "page.py")
    page = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(page)
    text = page.PAGE.read_text()
    assert sorted(page.MARK.findall(text)) == sorted(page.TABLES)
    assert page.with_tables(text) == text
    changed = text.replace("(0.", "(9.", 1)
    assert changed != text
    assert page.with_tables(changed) == text
