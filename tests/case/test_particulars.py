"""Estimates from main particulars: closed forms of a box, and databases of two barges."""

from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest

from hydrosim.case.load import DAMPING_RATIOS, Particulars
from hydrosim.database.database import HydroDatabase
from hydrosim.database.load import load
from hydrosim.dofs import DOFS

HYDRO_DB = Path(__file__).parents[2] / "hydro_db"
BOX = Particulars(length=100.0, beam=20.0, draught=5.0, block=1.0, kg=5.0)
H851 = Particulars(length=260.0, beam=63.0, draught=12.4, block=156758e3 / 208.1880e6, kg=7.5)


def test_a_box_has_its_closed_forms() -> None:
    assert BOX.mass == pytest.approx(1025.0 * 10_000.0)
    assert BOX.metacentric_height == pytest.approx(2.5 + 20 / 3 - 5.0)
    assert BOX.longitudinal_metacentric_height == pytest.approx(2.5 + 10_000 / 60 - 5.0)
    heave = BOX.density * 9.81 * 100.0 * 20.0
    moving = BOX.mass + 1025.0 * 100.0 * pi / 2 * 10.0**2
    assert BOX.periods()["heave"] == pytest.approx(2 * pi * sqrt(moving / heave))
    stiffness = BOX.stiffness()
    assert stiffness["heave"] == pytest.approx(heave)
    assert stiffness["roll"] == pytest.approx(BOX.mass * 9.81 * 25 / 6)


def test_a_block_coefficient_shortens_the_box() -> None:
    full = Particulars(100.0, 20.0, 5.0, 0.9, 5.0)
    assert full.mass == pytest.approx(0.9 * BOX.mass)
    assert full.metacentric_height == pytest.approx(BOX.metacentric_height)


def test_radii_are_those_of_a_body() -> None:
    """No principal moment is above the sum of the others: 0.26 L would be, of slender hulls."""
    assert Particulars(100.0, 30.0, 5.0, 1.0, 5.0).radii == pytest.approx((10.5, 25.0, 26.0))
    assert BOX.radii == pytest.approx((7.0, 25.0, 25.0))


def test_hydrostatics_are_those_of_the_database_of_the_box() -> None:
    db = load(HYDRO_DB / "box.nc")
    assert db.volume is not None
    assert db.hydrostatic_stiffness is not None
    assert BOX.mass == pytest.approx(db.water_density * db.volume[0], rel=1e-6)
    found = dict(zip(DOFS, np.diag(db.hydrostatic_stiffness), strict=True))
    for dof, stiffness in BOX.stiffness().items():
        assert stiffness == pytest.approx(found[dof], rel=1e-4), dof


@pytest.mark.parametrize(("barge", "name"), [(BOX, "box.nc"), (H851, "h851.nc")])
def test_estimates_are_near_to_databases(barge: Particulars, name: str) -> None:
    """Periods within a fifth of those with added mass by panels, added mass within 0.5 to 1.5."""
    db = load(HYDRO_DB / name)
    inertia, stiffness = barge.inertia(), barge.stiffness()
    for dof, own in barge.added_mass().items():
        moored = inertia[dof] * (2 * pi / 100.0) ** 2
        k = stiffness.get(dof, moored)
        frequency, panels = _resonance(db, DOFS.index(dof), inertia[dof], k)
        assert 0.5 < own / panels < 1.5, dof
        if dof in DAMPING_RATIOS:
            assert barge.periods()[dof] == pytest.approx(2 * pi / frequency, rel=0.2), dof


def _resonance(db: HydroDatabase, k: int, inertia: float, stiffness: float) -> tuple[float, float]:
    """Frequency [rad/s] at which inertia and stiffness are in balance, and the added mass there."""
    added = db.added_mass[:, k, k]
    off = np.abs(db.frequency * np.sqrt((inertia + added) / stiffness) - 1.0)
    nearest = int(off.argmin())
    return float(db.frequency[nearest]), float(added[nearest])
