"""Databases to test with: made up for the bookkeeping, the barge's for the physics."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hydrosim.database import HydroDatabase, load

ROOT = Path(__file__).parents[2]
H851 = ROOT / "hydro_db" / "h851.nc"


@pytest.fixture(scope="session")
def barge() -> HydroDatabase:
    return load(H851)


@pytest.fixture(scope="session")
def made_up() -> Callable[..., HydroDatabase]:
    """Random numbers in the right shapes; keywords replace any of them."""

    def make(bodies: int = 1, **given: Any) -> HydroDatabase:
        random = np.random.default_rng(7).standard_normal
        n, nw, nh = 6 * bodies, 4, 3
        loads = random((nw, nh, n, 2)).view(complex)[..., 0]
        db = HydroDatabase(
            source="made up",
            frequency=np.linspace(0.2, 1.4, nw),
            heading=np.linspace(0.0, np.pi, nh),
            added_mass=random((nw, n, n)),
            radiation_damping=random((nw, n, n)),
            excitation=loads,
            hydrostatic_stiffness=random((n, n)),
            volume=np.full(bodies, 100.0),
            centre_of_buoyancy=random((bodies, 3)),
            centre_of_gravity=random((bodies, 3)),
            reference_point=random((bodies, 3)),
            water_depth=np.inf,
            water_density=1025.0,
            gravity=9.81,
            port_starboard_symmetric=True,
            added_mass_zero=random((n, n)),
            added_mass_infinite=random((n, n)),
            froude_krylov=loads / 2,
            mean_drift=random((nw, nh, n)),
            mean_drift_held=random((nw, nh, n)),
            qtf_frequency=np.linspace(0.3, 1.0, 5),
            qtf_heading=np.array([[0.0, 0.0], [0.0, 0.5]]),
            qtf_difference=random((2, 5, 5, n, 2)).view(complex)[..., 0],
            qtf_sum=random((2, 5, 5, n, 2)).view(complex)[..., 0],
            drift_imbalance=random((nw, nh)),
            inertia_matrix=random((n, n)),
            attributes={"title": "Nobody's hull"},
        )
        return replace(db, **given)

    return make
