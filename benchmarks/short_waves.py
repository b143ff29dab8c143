"""How right are loads and motions of H-851 in a sea of 5 s, between headings too?

Against panels two thirds as large along the hull and on the lid, in all 1.7 times as many, solved
for the very headings, at seven frequencies from 0.9 to 2.0 rad/s.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from benchmarks.report import ROOT, Answer, Row
from hydrosim.database import HydroDatabase, all_headings, load, require_array
from hydrosim.database.build.afloat import hulls_afloat
from hydrosim.database.build.bem import solve_all
from hydrosim.database.build.build import ignore_progress
from hydrosim.database.build.recipe import Recipe, load_recipe
from hydrosim.database.build.water import Water
from hydrosim.dofs import DOFS
from hydrosim.scene import Jonswap
from hydrosim.waves.spectra import density
from hydrosim.waves.transfer import excitation_at

HEADINGS = (0.0, 22.5, 23.5, 45.0)  # deg; 23.5 is between headings of the database
FREQUENCIES = np.array([0.9, 1.1, 1.2, 1.3, 1.4, 1.6, 2.0])
SEA = Jonswap(1.0, 5.0)
SAID = "error of the deviation / missed, per cent of it"
FINER = (
    "hull.panels={along: [15, 15, 42, 30, 15], across: 8, down: 10, wall_across: 10, wall_down: 4,"
    " lid_along: [20, 48, 42], lid_across: 14}",
    f"frequencies={FREQUENCIES.tolist()}",
    "headings=[{}]".format(", ".join(f"{degrees} deg" for degrees in HEADINGS)),
    *("qtf=null", "extrapolate=null", "drift=[]"),
)


class Response(NamedTuple):
    """Loads (headings, frequencies, 6), added mass and damping (frequencies, 6, 6)."""

    loads: np.ndarray
    added_mass: np.ndarray
    damping: np.ndarray


def answer() -> Answer:
    """Errors of standard deviations, and what is missed of the loads and motions themselves."""
    folder = ROOT / "hydro_db"
    db = all_headings(load(folder / "h851.nc"))
    ours, theirs = shipped(db), finer(load_recipe(folder / "h851.yaml", FINER))
    return Answer(
        {
            f"loads: {SAID}": list(_rows(ours.loads, theirs.loads)),
            f"motions: {SAID}": list(_rows(motions(db, ours), motions(db, theirs))),
        },
        [],
    )


def shipped(db: HydroDatabase) -> Response:
    """What a run takes from the database."""
    each = (np.full(FREQUENCIES.size, np.radians(degrees)) for degrees in HEADINGS)
    loads = np.array([excitation_at(db, heading, FREQUENCIES) for heading in each])
    rows = [int(np.argmin(np.abs(db.frequency - w))) for w in FREQUENCIES]
    return Response(loads, db.added_mass[rows], db.radiation_damping[rows])


def finer(recipe: Recipe) -> Response:
    """The same of more panels, for the very headings."""
    solved = solve_all(
        hulls_afloat(recipe).hull, Water(), FREQUENCIES, recipe.headings, 1, ignore_progress
    )
    loads = np.array([solution.excitation for solution in solved]).swapaxes(0, 1)
    A, B = (np.array([getattr(s, name) for s in solved]) for name in ("added_mass", "damping"))
    return Response(loads, A, B)


def motions(db: HydroDatabase, response: Response) -> np.ndarray:
    """Motions (headings, frequencies, 6) of the barge floating free."""
    M, C = require_array(db, "inertia_matrix"), require_array(db, "hydrostatic_stiffness")
    w = FREQUENCIES[:, None, None]
    impedance = C - w**2 * (M + response.added_mass) + 1j * w * response.damping
    return np.linalg.solve(impedance, response.loads[..., None])[..., 0]


def _rows(ours: np.ndarray, finer: np.ndarray) -> Iterator[Row]:
    energy = density(SEA, FREQUENCIES)[:, None]

    def deviation(values: np.ndarray) -> np.ndarray:
        return np.sqrt(np.sum(energy * np.abs(values) ** 2, axis=0))

    for degrees, one, other in zip(HEADINGS, ours, finer, strict=True):
        size = deviation(other)
        row: Row = {"heading [deg]": degrees}
        for j, dof in enumerate(DOFS):
            if size[j] > 1e-6 * size[j - j % 3 : j - j % 3 + 3].max():
                changed, missed = (
                    deviation(one)[j] / size[j] - 1,
                    deviation(one - other)[j] / size[j],
                )
                row[dof] = f"{100 * changed:+.1f} / {100 * missed:.1f}"
            else:
                row[dof] = ""
        yield row
