"""The base case at K2 = 5.6e7 N/m with larger waves, a larger wave force in surge, or a box hull.

While the fenders stick, the thesis sees up to 0.20 m/s there. Its hull is lost, and so is the wave
force on it. The box is 260 x 52 x 13 m: ``hydro_db/box.nc``, 2.6 times as large by Froude's law.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

import hydrosim as hs
from benchmarks.report import ROOT
from cases.reverse_float_over.thesis.runs import BASE, CASES, FRICTION, SEED, Settings, base_figures
from hydrosim.dofs import DOFS
from hydrosim.scene import ChangedDatabase, Scene

TABLE = "Velocity while stuck at K2 = 5.6e7 N/m: wave force and hull"

DATABASES = ROOT / "hydro_db"
SOFTER: Settings = {f"{FRICTION}.stiffness": 5.6e7, f"{FRICTION}.damping": 3.3e7 * 0.1**0.5}
HEIGHT = 1.5  # m, of the base case
LARGER = 2.6
BOX: Settings = {
    "bodies.barge.mass": 1025.0 * LARGER**3 * 100.0 * 20.0 * 5.0,
    "bodies.barge.radii_of_gyration": [LARGER * radius for radius in (7.0, 26.0, 26.0)],
}


@dataclass(frozen=True)
class Variant:
    """Significant height of the waves and force in surge as multiples of the base case's, and
    whether the hull is a box."""

    waves: float = 1.0
    surge: float = 1.0
    box: bool = False


CHANGES = {
    "base case": Variant(),
    "waves times 1.5": Variant(waves=1.5),
    "waves times 2": Variant(waves=2.0),
    "surge force times 1.5": Variant(surge=1.5),
    "surge force times 2": Variant(surge=2.0),
    "box hull": Variant(box=True),
}
VARIANTS: dict[str, Settings] = {name: vars(variant) for name, variant in CHANGES.items()}


def figures(variant: str, seed: int) -> dict[str, float]:
    """Figures of one run, and the deviation of the wave force in surge after 600 s [kN]."""
    run = hs.simulate(_scene(CHANGES[variant], seed))
    force = run.force_wave_first_order.isel(body=0).sel(dof="surge", time=slice(600.0, None))
    return {**base_figures(run), "wave_force_deviation": float(force.std()) / 1e3}


def _scene(variant: Variant, seed: int) -> Scene:
    settings = {
        **SOFTER,
        SEED: seed,
        "environment.waves.significant_height": HEIGHT * variant.waves,
        "output.impulses": True,
        **(BOX if variant.box else {}),
    }
    scene = hs.load_case(CASES / BASE, settings).scene()
    (barge,) = scene.bodies
    database = _box() if variant.box else _barge(variant.surge)
    return replace(scene, bodies=(replace(barge, hydrodynamics=database),))


@cache
def _barge(factor: float) -> ChangedDatabase:
    """H-851 with its first-order wave force in surge times ``factor``. Its damping then does
    not follow from its loads, which the check of databases would refuse."""
    database = hs.load_database(DATABASES / "h851.nc")
    of_dof = np.ones(6)
    of_dof[DOFS.index("surge")] = factor
    changed = replace(database, excitation=database.excitation * of_dof, froude_krylov=None)
    return ChangedDatabase(source=changed, accept=("damping against loads",))


@cache
def _box() -> hs.HydroDatabase:
    """The box in the size of the barge, by Froude's law: times are as the root of lengths, loads in
    a motion or rotation as their third or fourth power, each per amplitude."""
    small = hs.load_database(DATABASES / "box.nc")
    arm = np.where(np.arange(6) < 3, 1.0, LARGER)
    arms = np.outer(arm, arm)
    inertia = LARGER**3 * arms
    rate = LARGER**-0.5
    load = LARGER**2 * arm
    changes: dict[str, Any] = {
        "frequency": small.frequency * rate,
        "added_mass": small.added_mass * inertia,
        "radiation_damping": small.radiation_damping * inertia * rate,
        "added_mass_zero": _times(small.added_mass_zero, inertia),
        "added_mass_infinite": _times(small.added_mass_infinite, inertia),
        "excitation": small.excitation * load,
        "froude_krylov": None,
        "mean_drift": _times(small.mean_drift, load / LARGER),
        "mean_drift_held": _times(small.mean_drift_held, load / LARGER),
        "hydrostatic_stiffness": _times(small.hydrostatic_stiffness, inertia / LARGER),
        "inertia_matrix": _times(small.inertia_matrix, inertia),
        "volume": _times(small.volume, LARGER**3),
        "reference_point": small.reference_point * LARGER,
        "centre_of_buoyancy": _times(small.centre_of_buoyancy, LARGER),
        "centre_of_gravity": _times(small.centre_of_gravity, LARGER),
    }
    return replace(small, source="box of 260 x 52 x 13 m", **changes)


def _times(values: Any, factor: Any) -> Any:
    return None if values is None else values * factor
