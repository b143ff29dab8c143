"""How right are loads and motions of H-851 in a sea of 5 s, between headings too?

Against panels half as large along the hull and on the lid, in all 2.2 times as many, solved for the
very headings; at frequencies that hold 99 per cent of the loads.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from benchmarks.report import ROOT, Answer, Row
from hydrosim.database import HydroDatabase, all_headings, load, needed
from hydrosim.database.build.build import build
from hydrosim.database.build.recipe import load_recipe
from hydrosim.dofs import DOFS
from hydrosim.scene import Jonswap
from hydrosim.waves.spectra import density
from hydrosim.waves.transfer import excitation_at

HEADINGS = (0.0, 22.5, 23.5, 45.0)  # deg; 23.5 is between headings of the database
FREQUENCIES = np.arange(8, 25, 2) / 10
SEA = Jonswap(1.0, 5.0)
FINER = (
    "hull.panels={along: [15, 15, 42, 30, 15], across: 8, down: 10, wall_across: 10, wall_down: 4,"
    " lid_along: [20, 48, 42], lid_across: 14}",
    f"frequencies={FREQUENCIES.tolist()}",
    "headings=[{}]".format(", ".join(f"{degrees} deg" for degrees in HEADINGS)),
    *("qtf=null", "extrapolate=null", "drift=[]"),
)


def answer() -> Answer:
    """Errors of standard deviations, and what is missed of the loads and motions themselves."""
    folder = ROOT / "hydro_db"
    finer = build(load_recipe(folder / "h851.yaml", FINER))
    shipped = all_headings(load(folder / "h851.nc"))
    tables = {}
    for what, of in (("loads", loads), ("motions", motions)):
        tables[f"{what}: error of the deviation / missed, per cent of it"] = list(
            _rows(of(shipped), of(finer))
        )
    return Answer(tables, [])


def loads(db: HydroDatabase) -> np.ndarray:
    """First-order loads (headings, frequencies, 6)."""
    each = (np.full(FREQUENCIES.size, np.radians(degrees)) for degrees in HEADINGS)
    return np.array([excitation_at(db, heading, FREQUENCIES) for heading in each])


def motions(db: HydroDatabase) -> np.ndarray:
    """Motions (headings, frequencies, 6) of the barge floating free."""
    found = loads(db)
    rows = [int(np.argmin(np.abs(db.frequency - w))) for w in FREQUENCIES]
    M, C = needed(db, "inertia_matrix"), needed(db, "hydrostatic_stiffness")
    for i, (row, w) in enumerate(zip(rows, FREQUENCIES, strict=True)):
        impedance = C - w**2 * (M + db.added_mass[row]) + 1j * w * db.radiation_damping[row]
        found[:, i] = np.linalg.solve(impedance, found[:, i].T).T
    return found


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
