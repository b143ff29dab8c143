"""Recipe of ``h851.nc``: the hydrodynamic database of a launch barge like H-851 in deep water.

    pip install .[bem]
    python hydro_db/h851.py              (--jobs 2: two processes of 0.6 GB each)

**Hull.** Length, beam and draught are H-851's, and so is the bow, narrowed to 42 m over 100 m in
about 2010. The rest is a substitute for lines that are not public, with plane faces: the beam is
full over 51.23 m from the stern, which gives the heave stiffness of 132 105 kN/m that the founding
thesis implies, and tapers from there to the bow; both ends are vertical to 2.4 m below the
waterline, so that this stiffness holds when the barge is lifted by as much, and rake to the keel
over 19 m, which makes mass plus added mass in surge 1.68e8 kg. Centre of gravity and radii of
gyration are assumed: KG is half the depth of 15 m, the radii are usual for barges.

**Fore and aft** the hull is not symmetric. A symmetric hull would halve a computation of minutes
and lose the bow, which explains why the heave stiffness is 80 per cent of the full rectangle's.

**Panels.** 2,368 on the hull and 912 on the lid, small where the flow turns round a corner: at the
bilge and at both edges of the rakes. A uniform mesh loses its accuracy there, above all in surge.
Against 5,140 panels, added mass, damping and loads change by less than 1 per cent of their largest
values up to 0.9 rad/s. The lid covers the whole waterplane, since with one half as fine the
irregular frequencies are back at 2.0 rad/s.

**Frame.** x forward from the centre of buoyancy, y to port, z up from the waterline.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path

import capytaine
import numpy as np

from hydrosim.database.build.assemble import Floating, assemble, asymmetry
from hydrosim.database.build.barge import (
    Barge,
    Resolution,
    half_hull,
    half_lid,
    hydrostatics,
    mirrored,
)
from hydrosim.database.build.bem import Solution, Water, floating_body, limit_added_mass, solve_all
from hydrosim.database.build.picture import draw
from hydrosim.database.netcdf import write

HEAVE_STIFFNESS = 132_105e3  # N/m, what the full beam's length is solved for
KG = 7.5  # m, assumed
RADII = (22.05, 67.6, 68.9)  # m, assumed: 0.35 beam, 0.26 and 0.265 length

WATER = Water()
FREQUENCIES = np.arange(1, 111) / 50
HEADINGS = np.radians(np.arange(0, 181, 15))


def hull() -> Barge:
    """The barge, its full beam as long as the heave stiffness asks for."""
    length, beam, bow_beam, bow_length = 260.0, 63.0, 42.0, 100.0
    area = HEAVE_STIFFNESS / (WATER.density * WATER.gravity)
    taper = (beam + bow_beam) / 2
    stern = (area - bow_beam * bow_length - taper * (length - bow_length)) / (beam - taper)
    return Barge(
        length=length,
        beam=beam,
        draught=12.4,
        bow_beam=bow_beam,
        bow_length=bow_length,
        stern_length=stern,
        wall_depth=2.4,
        rake_length=19.0,
    )


def floating(barge: Barge) -> Floating:
    """Mass and stiffness of the barge with its centre of gravity over its centre of buoyancy."""
    integrals = hydrostatics(barge)
    centre = np.array([0.0, 0.0, KG - barge.draught])
    buoyancy = integrals.centre_of_buoyancy * [0, 0, 1]
    mass = WATER.density * integrals.volume
    return Floating(
        centre_of_gravity=centre,
        centre_of_buoyancy=buoyancy,
        volume=integrals.volume,
        inertia=np.diag([mass] * 3 + [mass * radius**2 for radius in RADII]),
        stiffness=integrals.stiffness(centre[2], WATER.density, WATER.gravity),
    )


def main() -> None:
    """Compute and write the database and its picture."""
    parser = argparse.ArgumentParser(description="Compute hydro_db/h851.nc.")
    parser.add_argument("--jobs", type=int, default=1, help="number of processes")
    parser.add_argument("--output", type=Path, default=Path(__file__).with_suffix(".nc"))
    given = parser.parse_args()
    barge, mesh = hull(), Resolution()
    body = floating(barge)
    shift = [-hydrostatics(barge).centre_of_buoyancy[0], 0.0, 0.0]
    panels, lid = half_hull(barge, mesh) + shift, half_lid(barge, mesh) + shift
    wetted = floating_body(panels, lid, body.centre_of_gravity)
    limits = limit_added_mass(wetted, WATER, 0.0), limit_added_mass(wetted, WATER, np.inf)
    solutions = solve_all(wetted, WATER, FREQUENCIES, HEADINGS, given.jobs)
    attributes = _attributes(barge, 2 * len(panels), 2 * len(lid), solutions)
    db = assemble(body, WATER, HEADINGS, solutions, limits, attributes)
    write(db, given.output)
    draw(db, mirrored(panels), given.output.with_suffix(".png"))


def _attributes(
    barge: Barge, hull_panels: int, lid_panels: int, solutions: list[Solution]
) -> dict[str, str]:
    raw = {
        "added_mass": asymmetry(np.array([s.added_mass for s in solutions])).max(),
        "radiation_damping": asymmetry(np.array([s.damping for s in solutions])).max(),
    }
    return {
        "title": "Launch barge like H-851, draught 12.4 m, deep water",
        "hull": json.dumps(asdict(barge)),
        "panels": json.dumps({"hull": hull_panels, "lid": lid_panels}),
        "assumed": json.dumps({"KG": KG, "radii_of_gyration": RADII}),
        "solver": f"Capytaine {capytaine.__version__}, indirect method, lid at z = 0",
        "mean_drift_of": "the barge floating free, without viscous damping; Maruo's far field",
        "raw_asymmetry": json.dumps(raw),
        "recipe": "hydro_db/h851.py",
        "licence": "Apache-2.0",
    }


if __name__ == "__main__":
    main()
