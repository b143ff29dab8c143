"""How right are decays of H-851 at a draught between those of its databases?

At 11.3 m, by the databases of 12.4 and 10.2 m, against the one that was computed at 11.3 m.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import xarray as xr

import hydrosim as hs
from benchmarks.report import ROOT, Answer, Row
from hydrosim.database.build.closed import hull_of_recipe
from hydrosim.dofs import DOFS
from hydrosim.scene import AtDraught, Body, Family, Scene, Solver, Weight

FILES = {12.4: "h851", 11.3: "h851_11m3", 10.2: "h851_10m2"}
KG, VOLUME, DENSITY = 7.5, 138483.41724, 1025.0
STARTS = {"heave": 0.1, "roll": 0.02, "pitch": 0.005}


def answer() -> Answer:
    """Largest differences, and the periods of both."""
    rows = list(_rows())
    return Answer(
        {"decay at 11.3 m by databases of 12.4 and 10.2 m, against one of 11.3 m": rows}, []
    )


def _rows() -> Iterator[Row]:
    folder = ROOT / "hydro_db"
    family = Family(tuple(AtDraught(d, folder / f"{FILES[d]}.nc") for d in (12.4, 10.2)))
    for dof, start in STARTS.items():
        own = _decay(folder / "h851_11m3.nc", 11.3, dof, start)
        both = _decay(family, 12.4, dof, start)
        yield {
            "motion": dof,
            "largest difference, per cent of the start": float(
                100.0 * np.abs(both - own).max() / start
            ),
            "period by 11.3 m [s]": _period(own),
            "period by the family [s]": _period(both),
        }


def _decay(source: object, draught: float, dof: str, start: float) -> xr.DataArray:
    """A motion (nt,) from where the barge of 11.3 m floats, which is at rest in a frame for
    ``draught``."""
    hull = hull_of_recipe(ROOT / "hydro_db" / f"{FILES[draught]}.yaml", depth=15.0)
    mass = DENSITY * VOLUME
    rest = np.array([0.0, 0.0, draught - 11.3, 0.0, 0.0, 0.0])
    offset = start * np.eye(6)[DOFS.index(dof)]
    x = hs.database.load(ROOT / "hydro_db" / "h851_11m3.nc").centre_of_buoyancy[0, 0]
    body = Body(
        "barge",
        mass,
        mass * np.diag([22.05, 67.6, 68.9]) ** 2,
        hydrodynamics=source,
        hydrostatics=hull,
        centre_of_gravity=(x, 0.0, KG - draught),
        weight=Weight.CARRIED,
        position=tuple(rest + offset),
    )
    scene = Scene("decay", 60.0, (body,), solver=Solver(step=0.1), output_step=0.1)
    run = hs.simulate(replace(scene))
    return run.position.sel(body="barge", dof=dof) - rest[DOFS.index(dof)]


def _period(motion: xr.DataArray) -> float:
    """Twice the mean time between the first crossings of zero."""
    x, t = motion.values, motion.time.values
    k = np.flatnonzero(x[:-1] * x[1:] < 0.0)[:5]
    zeros = t[k] - x[k] * (t[k + 1] - t[k]) / (x[k + 1] - x[k])
    return float(2.0 * np.diff(zeros).mean())
