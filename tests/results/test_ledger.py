"""The ledger as a guard: what rk4 loses by its own formula, what hides and what does not."""

import itertools
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scenes import block, moving, scene

import hydrosim as hs
from hydrosim.elements import AppliedForce, Harmonic, LinearMooring
from hydrosim.errors import SimulationError
from hydrosim.integrate.record import unpack_channels
from hydrosim.results.ledger import MAX_RESIDUAL_FRACTION, check_balance, worst_energy_gap
from hydrosim.run import course, failure
from hydrosim.scene import Method, Scene

MASS, OMEGA = 2e4, 1.5


def oscillator(step: float, steps: int, every: int = 1, force: float = 0.0) -> Scene:
    """A block on a spring, 1 m from rest or, under a force at its own frequency, at rest."""
    body = block(MASS, ("surge",), position=moving(surge=0.0 if force else 1.0))
    spring = LinearMooring("block", np.diag([MASS * OMEGA**2, 0, 0, 0, 0, 0]))
    forces = {"spring": spring}
    if force:
        push = Harmonic(force, 2.0 * np.pi / OMEGA)
        forces["push"] = AppliedForce("block", (0.0, 0.0, 0.0), {"surge": push})  # type: ignore
    return scene(body, forces, steps * step, every * step, step=step)


def energy_factor(z: float) -> float:
    """|R(i z)|^2 of rk4, whose stability function is the exponential series to order 4."""
    return abs(1 + 1j * z - z**2 / 2 - 1j * z**3 / 6 + z**4 / 24) ** 2


@pytest.mark.parametrize("z", [0.3, 0.6, 1.0])
def test_what_is_missing_is_what_rk4_loses(z: float) -> None:
    steps = 400
    run = hs.simulate(oscillator(z / OMEGA, steps))
    held = 0.5 * MASS * OMEGA**2
    left = held * energy_factor(z) ** np.arange(steps + 1)
    np.testing.assert_allclose(run.energy_residual, left - held, atol=1e-9 * held)
    exchanged = np.abs(np.diff(run.energy_kinetic)).sum() + float(run.energy_kinetic.max())
    assert worst_energy_gap(run).relative >= (held - left[-1]) / exchanged * (1.0 - 1e-7)
    assert ("energy balance is open" in str(run.attrs.get("warnings"))) == (z > 0.3)


def ledger(kinetic: np.ndarray, residual: np.ndarray, **more: np.ndarray) -> xr.Dataset:
    """A run that has only energies."""
    energies = {"energy_kinetic": kinetic, "energy_residual": residual, **more}
    data = {name: ("time", np.asarray(e, float)) for name, e in energies.items()}
    time = np.arange(kinetic.size, dtype=float)
    return xr.Dataset(data, {"time": time}, {"solver_method": "rk4"})


def swings(size: np.ndarray) -> np.ndarray:
    """Kinetic energies that go up and down by ``size``."""
    return size * (np.arange(size.size) % 2)


def test_a_great_impact_hides_nothing_that_comes_after_it() -> None:
    size = np.where(np.arange(1601) < 10, 1e8, 1.0)
    residual = np.where(np.arange(1601) > 1500, 1.0, 0.0)
    found = worst_energy_gap(ledger(swings(size), residual))
    assert found.begin <= 1501 <= found.end + 1
    assert found.relative == pytest.approx(1.0 / 101.0, rel=0.05)


def test_what_a_slow_load_lifts_is_no_exchange() -> None:
    still, held = np.ones(801), np.linspace(0.0, 1e9, 801)
    residual = 1e-3 * np.arange(801)
    extra = {"energy_stored_hydrostatic": held, "energy_work_lift": held}
    apart = worst_energy_gap(ledger(swings(still), residual)).relative
    rounding = 1e-11 * 1e9
    assert worst_energy_gap(ledger(swings(still), residual, **extra)).relative == pytest.approx(
        apart - rounding / 800.0, rel=0.2
    )


def test_roundings_and_quiet_stretches_are_no_gap() -> None:
    size = np.where(np.arange(1601) < 1000, 1.0, 1e-8)
    residual = np.where(np.arange(1601) > 1500, 1e-9, 0.0)
    assert worst_energy_gap(ledger(swings(size), residual)).relative < MAX_RESIDUAL_FRACTION
    big = {"energy_stored_it": np.full(1601, 1e6)}
    assert worst_energy_gap(ledger(swings(size), 0.9e-5 * (size < 1.0), **big)).relative == 0.0


def guarded(run: xr.Dataset, mass: float = 0.0) -> xr.Dataset:
    check_balance(run := run.copy(), mass)
    return run


def test_what_hardly_moves_is_no_gap() -> None:
    """10 s inside a ramp: a thousandth of what is exchanged is missing, and that is nothing."""
    run = ledger(swings(1e-6 * np.ones(801)), 1e-6 * np.arange(801) * 1e-3)
    assert "warnings" in guarded(run).attrs
    assert "warnings" not in guarded(run, mass=1e6).attrs


@pytest.mark.parametrize("method", Method)
def test_the_remedy_is_what_the_method_goes_by(method: Method) -> None:
    run = ledger(swings(np.ones(801)), np.arange(801.0)).assign_attrs(solver_method=str(method))
    key = "solver.tolerance" if method.adapts else "solver.step"
    assert f"Try a smaller {key}" in guarded(run).attrs["warnings"]


def test_friction_that_gives_is_said() -> None:
    lost = np.minimum(np.arange(801.0), 500.0)
    run = ledger(swings(np.ones(801)), np.zeros(801))
    run["fender_dissipated"] = (("time", "fender"), lost[:, None])
    run = run.assign_coords(fender=["bumper 1"])
    assert "warnings" not in guarded(run).attrs
    run["fender_dissipated"] = (("time", "fender"), (lost - 5.0 * (lost == 500.0))[:, None])
    assert "friction of bumper 1 adds energy, 4 J until 500 s" in guarded(run).attrs["warnings"]


def test_a_run_that_blows_up_ends_where_it_begins() -> None:
    z = 3.0  # beyond rk4's limit, 2.83
    with pytest.raises(SimulationError, match=r"solution blows up: .* surge of body block") as e:
        hs.simulate(oscillator(z / OMEGA, 1000))
    held, least = 0.5 * MASS * OMEGA**2, 1e-3 * MASS
    energy = held * energy_factor(z) ** np.arange(100)
    first = int(np.argmax(energy > 10.0 * held + least))
    run = e.value.dataset
    assert run.attrs["status"] == "failed"
    assert run.time.size == first + 1
    assert run.time[-1] == pytest.approx(first * z / OMEGA)


def test_a_run_is_looked_at_once_however_often_recorded(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The processor's time must not depend on other processes: clocks on the wall that run fast
    make no more looks, and no look goes over earlier records."""
    seen, looks = 0, 0

    def counted(*args: Any) -> dict[str, np.ndarray]:
        nonlocal seen, looks
        values = unpack_channels(*args)
        seen += len(values["time"])
        looks += 1
        return values

    wall = itertools.count(0.0, 10.0)
    monkeypatch.setattr(course, "running_time", lambda: next(wall))
    monkeypatch.setattr(failure, "unpack_channels", counted)
    run = hs.simulate(oscillator(0.05, 4000))
    assert looks < 40
    assert seen <= run.time.size + looks


def test_resonance_is_no_blow_up() -> None:
    run = hs.simulate(oscillator(0.05, 4000, 10, force=1e3))
    assert run.attrs["status"] == "complete"
    assert float(run.energy_kinetic.max()) > 1e3 * float(run.energy_kinetic[5])
    assert "warnings" not in run.attrs
