"""How far are motions off by what is done to the memory of the radiated waves?

Every database of `hydro_db`, moored in an oblique JONSWAP sea for 2000 s, with the radiation that
is the default, against a convolution over the same memory from a table four times as fine; and what
a memory half as long again changes. Beside what is found stands what the program says beforehand.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import xarray as xr

import hydrosim as hs
from benchmarks.report import ROOT, Answer, Row
from hydrosim.database import HydroDatabase, load, require_array
from hydrosim.dofs import DOFS
from hydrosim.forces import LinearMooring
from hydrosim.scene import (
    AutomaticRadiation,
    Body,
    ConvolutionRadiation,
    Environment,
    Jonswap,
    LinearScenes,
    Radiation,
    Scene,
    SecondOrder,
    Solver,
    WaveForces,
    WaveTrain,
)
from hydrosim.scene.radiation import LENGTH

FOLDER = ROOT / "hydro_db"
DURATION, STEP, HEADING = 2000.0, 0.05, np.radians(30.0)
DEFAULT = AutomaticRadiation()
FINE = ConvolutionRadiation(step=DEFAULT.step / 4.0)
LONGER = ConvolutionRadiation(1.5 * LENGTH, DEFAULT.step)
SMALL = 0.02  # of the largest motion of its kind: what moves less is compared with that


class Moored(NamedTuple):
    """A database in a sea: natural period of its moorings [s], height [m] and period [s] of the
    sea, and the radii of gyration [m]."""

    period: float
    sea: Jonswap
    radii: tuple[float, float, float]


MOORED = {
    "h851": Moored(130.0, Jonswap(1.5, 8.0), (22.05, 67.6, 68.9)),
    "h851_50m": Moored(130.0, Jonswap(1.5, 10.0), (22.05, 67.6, 68.9)),
    "box": Moored(60.0, Jonswap(1.0, 7.0), (8.0, 15.0, 15.0)),
    "sphere": Moored(30.0, Jonswap(1.0, 5.0), (2.0, 2.0, 2.0)),
    "two_barges": Moored(30.0, Jonswap(1.0, 9.0), (4.0, 11.0, 11.0)),
}


def answer() -> Answer:
    """One row per database."""
    return Answer({"Motions over 2000 s, differences over the range": [*_rows()]})


def _rows() -> Iterator[Row]:
    for name in MOORED:
        run, fine, longer = (hs.simulate(scene(name, of)) for of in (DEFAULT, FINE, LONGER))
        yield {
            "database": name,
            "model": run.attrs[f"radiation_{run.body.values[0]}"],
            "largest difference": difference(run, fine),
            "in": where(run, fine),
            "longer memory": difference(longer, fine),
            "longer in": where(longer, fine),
            "said": run.attrs["radiation_errors"],
        }


def scene(name: str, radiation: Radiation) -> Scene:
    """The bodies of a database, moored in its sea."""
    db, moored = load(FOLDER / f"{name}.nc"), MOORED[name]
    bodies = tuple(_body(k, db, moored, radiation) for k in range(db.bodies))
    train = WaveTrain(moored.sea, HEADING, ramp=200.0)
    return Scene(
        name,
        DURATION,
        bodies,
        Environment(db.water_depth, db.water_density, db.gravity, (train,)),
        {f"lines {body.name}": _lines(body, moored) for body in bodies},
        Solver(step=STEP, linear=LinearScenes.STEP),
    )


def _body(k: int, db: HydroDatabase, moored: Moored, radiation: Radiation) -> Body:
    mass = db.water_density * float(require_array(db, "volume")[k])
    centre = require_array(db, "centre_of_gravity")[k]
    drift = SecondOrder.NONE if db.mean_drift is None else SecondOrder.NEWMAN
    return Body(
        f"body{k + 1}",
        mass,
        mass * np.diag(np.square(moored.radii)),
        db,
        tuple(map(float, centre)),
        database_body=k + 1,
        radiation=radiation,
        wave_forces=WaveForces(second_order=drift),
    )


def _lines(body: Body, moored: Moored) -> LinearMooring:
    """Springs in surge, sway and yaw with the period that they would give the mass alone, and a
    fifth of critical damping."""
    inertia = np.array([body.mass, body.mass, 0.0, 0.0, 0.0, body.inertia[2, 2]])
    stiffness = inertia * (2.0 * np.pi / moored.period) ** 2
    return LinearMooring(
        body.name, stiffness=np.diag(stiffness), damping=np.diag(0.4 * np.sqrt(inertia * stiffness))
    )


def off(one: xr.Dataset, other: xr.Dataset) -> np.ndarray:
    """Largest difference (nb, 6) of each motion over its range in ``other``, or over `SMALL` of the
    range of the largest of its kind where that is more."""
    range_ = np.ptp(other.position.values, axis=0)
    kinds = range_.reshape(-1, 2, 3)
    least = SMALL * kinds.max(axis=(0, 2))[None, :, None]
    size = np.maximum(kinds, least).reshape(range_.shape)
    return np.asarray(np.abs(one.position.values - other.position.values).max(axis=0) / size)


def difference(one: xr.Dataset, other: xr.Dataset) -> float:
    """The largest of `off`."""
    return float(off(one, other).max())


def where(one: xr.Dataset, other: xr.Dataset) -> str:
    """Which motion that is."""
    body, dof = divmod(int(off(one, other).argmax()), 6)
    return f"{DOFS[dof]} of {one.body.values[body]}"
