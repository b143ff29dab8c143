"""The cases with lines and winches at rest, against figures by hand.

Pretensions and stiffness of chains, heel under a load that a wire carries, wind that chains hold.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.optimize import brentq, root

import hydrosim as hs

CASES = Path(__file__).parents[2] / "cases"
G = 9.81
CALM = {"environment.waves": None, "duration": "1 s", "output.step": "1 s"}


def calm(name: str, changes: dict[str, Any] | None = None) -> xr.Dataset:
    """First second of a case without waves."""
    return hs.simulate(hs.load_case(CASES / name, CALM | (changes or {})))


def chain_at(x: float, z: float, length: float, diameter: float) -> tuple[float, float]:
    """Horizontal and vertical pull [N] of studless chain that lies on the bed (Jonkman 2007)."""
    w = 19.9e3 * diameter**2 * G * (1.0 - 1025.0 / 7850.0)
    EA = 85.4e9 * diameter**2

    def vertical(H: float) -> float:
        def fall(V: float) -> float:
            return H / w * (np.hypot(1.0, V / H) - 1.0) + V**2 / (2.0 * EA * w) - z

        return brentq(fall, 1.0, 1e8, xtol=1e-6)

    def reach(H: float) -> float:
        V = vertical(H)
        return length - V / w + H / w * np.arcsinh(V / H) + H * length / EA - x

    H = brentq(reach, 1e4, 3e6, xtol=1e-6)
    return H, vertical(H)


def anchors(name: str, lines: list[str]) -> np.ndarray:
    forces = hs.load_case(CASES / name).scene().forces
    return np.array([forces[line].anchor for line in lines])  # type: ignore[attr-defined]


STILL = {"environment.wind": None, "environment.current": None, "initial": None}
STILL |= {"forces.wind": None, "forces.current": None}
EIGHT = [f"line_{k}" for k in range(1, 9)]


def pulls_by_hand(surge: float) -> np.ndarray:
    """Pull (8, 3) [N] of the chains on the turret, which is ``surge`` [m] from its place."""
    found = []
    for x, y, _ in anchors("turret_tanker/storm.yaml", EIGHT):
        reach = np.hypot(x - surge, y)
        H, V = chain_at(reach, 86.0, 700.0, 0.1)
        found.append([H * (x - surge) / reach, H * y / reach, -V])
    return np.array(found)


@pytest.mark.parametrize("surge", [0.0, 4.0])
def test_chains_of_the_turret_pull_as_catenaries_by_hand(surge: float) -> None:
    place = {"bodies.tanker.initial": {"position": {"surge": surge}}}
    run = calm("turret_tanker/storm.yaml", STILL | place)
    force = np.array([run[f"force_{line}"].values[0, 0, :3] for line in EIGHT])
    by_hand = pulls_by_hand(surge)
    np.testing.assert_allclose(force, by_hand, rtol=1e-9, atol=1.0)
    tension = np.linalg.norm(by_hand, axis=1)
    np.testing.assert_allclose(run.line_tension.values[0], tension, rtol=1e-9)
    if surge == 0.0:  # what the page says
        assert tension == pytest.approx(np.full(8, 0.85e6), rel=0.01)


def test_surge_of_the_tanker_has_the_period_by_hand() -> None:
    """Of mass, added mass in long waves and the slope of eight catenaries."""
    from hydrosim.database import load

    db = load(CASES.parent / "hydro_db" / "tanker.nc")
    mass = 122293e3 + float(db.added_mass[0, 0, 0])
    force = [pulls_by_hand(x)[:, 0].sum() for x in (0.1, -0.1)]
    period = 2.0 * np.pi * np.sqrt(mass / ((force[1] - force[0]) / 0.2))
    assert period == pytest.approx(128.0, rel=0.02)  # by `hydrosim check`
    free = {"dofs": ["surge"], "initial": {"position": {"surge": "0.5 m"}}}
    changes = {f"bodies.tanker.{key}": value for key, value in free.items()}
    changes |= STILL | {"duration": "108 s", "output.step": "0.2 s"}
    run = calm("turret_tanker/storm.yaml", changes)
    surge = run.position.values[:, 0, 0]
    falls, rises = (int(np.flatnonzero(np.diff(np.sign(surge)) == way)[0]) for way in (-2, 2))
    assert 2.0 * float(run.time[rises] - run.time[falls]) == pytest.approx(period, rel=0.02)


def test_barge_heels_under_the_load_as_by_hand() -> None:
    """The load hangs plumb from the tip of the crane, 20 m forward, 16 m aside and 32 m above the
    centre of gravity of the barge."""
    run = calm("lift_over_the_side/no_tuggers.yaml")
    weight = 100e3 * G
    assert run.winch_tension.values[0, 0] == pytest.approx(weight, rel=1e-6)
    rho_g = 1025.0 * G
    L, B, T = 100.0, 20.0, 5.0
    GM = np.array([B**2 / 12.0 / T, L**2 / 12.0 / T]) - T / 2.0
    C = rho_g * L * B * T * GM

    def balance(heel: np.ndarray) -> np.ndarray:
        roll, pitch = heel
        cr, sr, cp, sp = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch)
        tip = np.array([20.0 * cp + sp * (16.0 * sr + 32.0 * cr), 16.0 * cr - 32.0 * sr])
        return np.array([-C[0] * roll - weight * tip[1], -C[1] * pitch + weight * tip[0]])

    expected = root(balance, [-0.04, 0.001], tol=1e-14).x
    found = run.position.sel(body="barge").values[0, 3:5]
    assert found == pytest.approx(expected, rel=2e-3)  # rotations turn the restoring moment


def test_tuggers_keep_their_tension_within_dead_band_and_friction() -> None:
    """30 kN, 10 % of dead band and 5 % of friction, once the drums have followed the load."""
    changes = {"duration": "10 s", "output.step": "0.1 s"}
    run = calm("lift_over_the_side/over_the_side.yaml", changes)
    tuggers = run.winch_tension.values[run.time.values > 2.0, 1:]
    assert tuggers.min() > 30e3 * 0.85 * (1.0 - 1e-6)
    assert tuggers.max() < 30e3 * 1.15 * (1.0 + 1e-6)
    assert np.ptp(tuggers) > 1e3  # they are not at one bound


def test_chains_of_the_barge_hold_the_wind_on_both_hulls() -> None:
    """10 m/s on coefficients of 150 and 51 N s^2/m^2 across."""
    run = calm("tender_alongside/alongside.yaml", {"environment.current.speed": 0.0})
    chains = sum(run[f"force_chain_{k}"].sel(body="barge").values[0] for k in range(1, 5))
    assert run.force_tender_wind.sel(body="tender").values[0, 1] == pytest.approx(5100.0, rel=1e-3)
    assert chains[1] == pytest.approx(-20.1e3, rel=2e-3)  # yawed a little
    between = ("bow_breast", "stern_breast", "fore_spring", "aft_spring", "fenders")
    held = sum(run[f"force_{name}"].sel(body="tender").values[0] for name in between)
    assert held[1] == pytest.approx(-5100.0, rel=2e-3)


def test_wires_of_the_lock_have_the_pretension_of_the_page() -> None:
    """1 MN in 79.81 m of wire over a chord of 80.006 m, with the sag of a parabola."""
    run = hs.simulate(
        hs.load_case(CASES / "lock_in" / "catenaries.yaml", CALM | {"output.impulses": False})
    )
    chord = np.hypot(80.0, 1.0)
    T = 1e6
    sagged = chord + (410.0**2 * chord**3) / (24.0 * T**2)
    assert 79.81 * (1.0 + T / 4e8) == pytest.approx(sagged, abs=2e-3)
    assert run.line_tension.values[0] == pytest.approx(np.full(4, T), rel=0.01)
