"""Stick-slip whose stiffness and damping go with the normal force.

Nothing here knows the kernels' formulas: work is integrated from what the run records, and the
independent integration states the traction S itself, S' = K2 v + S min(K2', 0) / K2.
"""

import numpy as np
import pytest
import scenes
from scipy.integrate import solve_ivp

import hydrosim as hs
from hydrosim.elements import Harmonic
from hydrosim.errors import InputError

OPEN, STICK, SLIP = range(3)
LOAD, SWING, K, C2 = 1e3, 900.0, 2e3, 20.0
E = 1e-3  # of x without load


def driven(law: hs.StickSlip, lag: float, step: float = 0.01, grip: float = 1.0) -> hs.Scene:
    """A block whose shear and normal force swing with a lag between them."""
    push = scenes.central_force(surge=Harmonic(grip * 100.0, 2.0))
    normal = hs.PrescribedNormal(Harmonic(SWING, 2.0, mean=LOAD, phase=lag))
    only_surge = np.diag([1.0, 0, 0, 0, 0, 0])
    spring = hs.LinearMooring("block", 50.0 * only_surge, 5.0 * only_surge)
    forces = {"push": push, "spring": spring, "fender": scenes.foot(normal, law)}
    return scenes.scene(scenes.block(1.0, ("surge",)), forces, 12.0, 0.1, step=step)


def held(power: float) -> hs.StickSlip:
    """Never slips."""
    return hs.StickSlip(50.0, 50.0, K, 0.0, 1.0, hs.LoadPowers(LOAD, power))


@pytest.mark.parametrize("power", [1 / 3, 0.5, 1.0])
@pytest.mark.parametrize("lag", [0.0, 1.0, 2.0, 3.5, 5.0])
def test_a_loop_in_shear_and_load_never_makes_energy(power, lag, figure):
    """Over any closed loop of shear and normal force the spring takes work, S v, and gives none;
    a spring with S = K2(N) u, not incremental, would give some at one lag or its opposite."""
    run = hs.simulate(driven(held(power), lag, step=0.0025))
    assert np.all(run.fender_mode.values == STICK)
    lost, stored = run.fender_dissipated.values[:, 0], run["energy_stored_fender"].values
    assert np.all(np.diff(lost) >= 0.0)
    assert np.all(stored >= 0.0)
    figure("lost in 12 s [J]", lost[-1])
    assert run.attrs["energy_residual_relative"] < 1e-6
    taken = lost + stored - stored[0]
    period = 20  # records
    assert np.all(taken[period:] >= taken[:-period] - 1e-9)


@pytest.mark.parametrize("power", [1 / 3, 0.5, 1.0])
def test_against_an_independent_integration(power: float, figure) -> None:
    lag, w = 1.0, np.pi

    def rates(t: float, y: np.ndarray) -> list[float]:
        x, v, S = y
        N = LOAD + SWING * np.sin(w * t + lag)
        dN = SWING * w * np.cos(w * t + lag)
        share, change = E + (1 - E) * N / LOAD, (1 - E) * dN / LOAD
        dS = K * share**power * v + S * power * min(change, 0.0) / share
        return [v, 100.0 * np.sin(w * t) - 50.0 * x - 5.0 * v - S, dS]

    times = np.linspace(0.0, 12.0, 121)
    turns = [(np.pi * (k + 0.5) - lag) / w for k in range(14)]
    y, t, exact = np.zeros(3), 0.0, [np.zeros((1, 3))]
    for stop in [*(x for x in turns if 0.0 < x < 12.0), 12.0]:
        inside = times[(times > t) & (times <= stop)]
        at = np.unique(np.append(inside, stop))
        piece = solve_ivp(rates, (t, stop), y, "DOP853", t_eval=at, rtol=1e-12, atol=1e-13).y.T
        exact.append(piece[: inside.size])
        y, t = piece[-1], stop
    whole = np.concatenate(exact)
    steps = np.array([0.005, 0.0025])
    runs = [hs.simulate(scenes.with_step(driven(held(power), lag), step)) for step in steps]
    error = np.array([np.abs(scenes.surge(run) - whole[:, 0]).max() for run in runs])
    figure("order", scenes.observed_orders(steps, error)[0])
    figure("error over the range", error[-1] / np.ptp(whole[:, 0]))
    assert error[-1] <= 1e-6 * np.ptp(whole[:, 0])
    assert scenes.observed_orders(steps, error)[0] > 3.7
    friction = runs[-1].fender_friction.values[:, 0, 0]
    assert np.abs(friction + whole[:, 2]).max() <= 1e-5 * np.ptp(whole[:, 2])


LAWS = {
    "with damping": hs.StickSlip(0.3, 0.2, K, C2, 5.0, hs.LoadPowers(LOAD, 0.5, 0.25, 0.0)),
    "damping as the stiffness": hs.StickSlip(0.3, 0.2, K, C2, 0.0, hs.LoadPowers(LOAD, 1.0, 1.0)),
}


@pytest.mark.parametrize("name", LAWS)
def test_slip_and_lift_off(name: str, figure) -> None:
    """A pushed block that bounces: ledger, bound of traction, growing dissipation."""
    law = LAWS[name]
    body = scenes.block(1.0, ("surge", "heave"), position=scenes.moving(heave=0.01))
    curve = scenes.straight_curve(4e3)
    push = {"surge": Harmonic(5.0, 1.7), "heave": Harmonic(14.0, 1.1, mean=-9.81)}
    fender = scenes.foot(curve, law)
    forces = {"push": scenes.central_force(**push), "fender": fender}
    steps = (0.01, 0.005, 0.0025)
    runs = [hs.simulate(scenes.scene(body, forces, 8.0, 0.02, step=step)) for step in steps]
    fine = runs[-1]
    assert len({*np.unique(fine.fender_mode.values)} - {OPEN}) >= 1
    assert np.any(fine.fender_mode.values == OPEN)
    residual = [run.attrs["energy_residual_relative"] for run in runs]
    figure("residual", residual[-1])
    figure("residual at 0.01", residual[0])
    figure("residual at 0.005", residual[1])
    assert residual[-1] < 1e-5
    N = fine.fender_normal_force.values[:, 0]
    friction = np.abs(fine.fender_friction.values[:, 0, 0])
    stick = fine.fender_mode.values[:, 0] == STICK
    assert np.all(friction[stick] <= 0.3 * N[stick] * (1 + 1e-9) + 1e-9)
    assert np.all(np.diff(fine.fender_dissipated.values[:, 0]) >= -1e-9)


def test_without_powers_it_is_the_same_law() -> None:
    plain = hs.StickSlip(0.3, 0.2, K, C2, 5.0)
    powers = hs.StickSlip(0.3, 0.2, K, C2, 5.0, hs.LoadPowers(LOAD, 0.0))
    runs = [hs.simulate(driven(law, 1.0, grip=4.0)) for law in (plain, powers)]
    assert {*np.unique(runs[0].fender_mode.values)} == {STICK, SLIP}
    # the load's turning points are events of one only: pieces differ, within the method's error
    assert np.abs(scenes.surge(runs[0]) - scenes.surge(runs[1])).max() < 1e-6 * np.ptp(
        scenes.surge(runs[0])
    )


def test_rate_free_friction_with_powers_is_refused() -> None:
    with pytest.raises(InputError, match=r"StickSlip: found load without damping and slip_damping"):
        hs.StickSlip(0.3, 0.2, K, 0.0, 0.0, hs.LoadPowers(LOAD, 0.5))
