"""Recipe of ``two_barges.nc``: two box barges side by side, solved together.

    pip install .[bem]
    python hydro_db/two_barges.py          (--jobs 2: two processes of 0.6 GB each)

Boxes of 40 x 10 x 3 m in deep water with a gap of 4 m, their centres of gravity at the waterline.
The frame is over the middle of the gap: the first body is to port, the second to starboard.

Between the barges the water resonates: up and down as a whole at 1.30 rad/s, with one wave along
the gap at 1.46 rad/s, and more. There the frequencies are close together. From 2.7 rad/s on, waves
across the gap (half of one is 4 m long at 2.77 rad/s) hardly get out under the hulls, and coarse
panels make the damping negative; the frequencies end before.

By Haskind's relation the loads X of waves also follow from the waves that the motions make far away
(Kochin functions H), and the damping B from either (Newman 1977, Marine Hydrodynamics, 6.18):

    X_i(b) = -4 pi i rho g / w H_i(b + pi),   B_ij = w^3 / (4 pi rho g^3) Re int X_i X_j* db.

With these panels the loads by both ways are some per cent apart, in roll more (a factor of 1.5 at
1 rad/s). Their mean is taken, which is nearer to what finer panels give than either; but in long
waves, where H in surge, sway and roll is a small difference, those of the pressures. The damping is
from these loads: symmetric and without negative eigenvalues, as energy demands. That from the
pressures has some of a few per cent of the largest in resonance.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import NamedTuple

import capytaine as cpt
import joblib
import numpy as np
from capytaine.bem.airy_waves import froude_krylov_force
from capytaine.post_pro import compute_kochin
from matplotlib.figure import Figure
from scipy.linalg import block_diag

from hydrosim.database import HydroDatabase
from hydrosim.database.build import barge
from hydrosim.database.build.bem import mesh_of
from hydrosim.database.build.water import Water
from hydrosim.database.netcdf import write
from hydrosim.dofs import DOFS

LENGTH, BEAM, DRAUGHT, GAP = 40.0, 10.0, 3.0, 4.0
PANEL = 1.25  # m, the largest
ASIDE = (GAP + BEAM) / 2
CENTRES = np.array([[0.0, ASIDE, 0.0], [0.0, -ASIDE, 0.0]])
RADII = np.array([3.5, 10.4, 10.4])  # of gyration: 0.35 beam, 0.26 length
HUNDREDTHS = [(5, 110, 5), (110, 120, 2), (120, 140, 1), (140, 170, 2), (170, 261, 5)]
FREQUENCIES = np.concatenate([np.arange(*steps) for steps in HUNDREDTHS]) / 100
SHARE = [0.3, 0.6], [0.0, 0.5]  # of the loads by Kochin functions, over the frequency
HEADINGS = np.radians(np.arange(0.0, 360.0, 10.0))
WATER = Water()


class Solution(NamedTuple):
    """One frequency: added mass and damping (12, 12), loads per unit amplitude (headings, 12)."""

    added_mass: np.ndarray
    damping: np.ndarray
    excitation: np.ndarray


@cache
def hulls() -> cpt.FloatingBody:
    """Both barges: the one to port, and its mirror image in y = 0."""
    shape = barge.box(LENGTH, BEAM, DRAUGHT)
    counts = barge.resolution(shape, PANEL)
    place = np.array([-LENGTH / 2, ASIDE, 0.0])
    mesh, lid = (
        cpt.ReflectionSymmetricMesh(half=mesh_of(barge.mirrored(half) + place), plane="xOz")
        for half in (barge.half_hull(shape, counts), barge.half_lid(shape, counts))
    )
    return cpt.FloatingBody(
        mesh=mesh, lid_mesh=lid, dofs=_motions(mesh.faces_centers), center_of_mass=(0.0, 0.0, 0.0)
    )


def _motions(points: np.ndarray) -> dict[str, np.ndarray]:
    """Motion (panels, 3) of each DOF of each barge, which leaves the other where it is."""
    found = {}
    for number, centre in enumerate(CENTRES, 1):
        own = (np.sign(points[:, 1]) == np.sign(centre[1]))[:, None]
        for axis in range(3):
            along = np.eye(3)[axis]
            found[f"{number} {DOFS[axis]}"] = own * along
            found[f"{number} {DOFS[3 + axis]}"] = own * np.cross(along, points - centre)
    return {f"{number} {dof}": found[f"{number} {dof}"] for number in (1, 2) for dof in DOFS}


def solve(frequency: float) -> Solution:
    """Radiation and diffraction; loads as for exp(+i w t)."""
    cpt.set_logging("ERROR")
    body, solver = hulls(), cpt.BEMSolver()
    given = {"body": body, "omega": frequency, "rho": WATER.density, "g": WATER.gravity}
    radiated = [solver.solve(cpt.RadiationProblem(radiating_dof=d, **given)) for d in body.dofs]
    waves = [cpt.DiffractionProblem(wave_direction=b, **given) for b in HEADINGS]
    loads = by_dof(solver.solve(wave).forces for wave in waves)
    loads = loads + by_dof(froude_krylov_force(wave) for wave in waves)
    far = np.array([compute_kochin(result, HEADINGS + np.pi) for result in radiated]).T
    share = np.interp(frequency, *SHARE)
    loads = (1 - share) * loads + share * haskind(frequency) * far
    flux = (loads.T @ loads.conj()).real * (2 * np.pi / HEADINGS.size)
    factor = frequency**3 / (4 * np.pi * WATER.density * WATER.gravity**3)
    return Solution(symmetric(_added(radiated)), factor * flux, np.conj(loads))


def haskind(frequency: float) -> complex:
    """Loads per Kochin function, both in Capytaine's normalisation, in deep water."""
    return -4j * np.pi * WATER.density * WATER.gravity / frequency


def infinite_added_mass() -> np.ndarray:
    """Added mass (12, 12) at infinite frequency."""
    given = {"body": hulls(), "omega": np.inf, "rho": WATER.density, "g": WATER.gravity}
    solver = cpt.BEMSolver()
    return symmetric(
        _added(solver.solve(cpt.RadiationProblem(radiating_dof=d, **given)) for d in hulls().dofs)
    )


def _added(radiated: Iterable[cpt.RadiationResult]) -> np.ndarray:
    return by_dof(result.added_masses for result in radiated).T


def by_dof(loads: Iterable[dict]) -> np.ndarray:
    """The loads (n, 12) in the order of the degrees of freedom."""
    return np.array([[load[dof] for dof in hulls().dofs] for load in loads])


def symmetric(matrix: np.ndarray) -> np.ndarray:
    """The symmetric part, which is all there is but for the solver's error."""
    return (matrix + matrix.T) / 2


def assemble(solutions: list[Solution], infinite: np.ndarray) -> HydroDatabase:
    """The database of both."""
    afloat = barge.hydrostatics(barge.box(LENGTH, BEAM, DRAUGHT))
    depth = afloat.centre_of_buoyancy[2]
    mass = WATER.density * afloat.volume
    inertia = np.diag([mass] * 3 + [*(mass * RADII**2)])
    stiffness = afloat.stiffness(0.0, WATER.density, WATER.gravity)
    return HydroDatabase(
        source="computed",
        frequency=FREQUENCIES,
        heading=HEADINGS,
        added_mass=np.array([s.added_mass for s in solutions]),
        radiation_damping=np.array([s.damping for s in solutions]),
        added_mass_infinite=infinite,
        excitation=np.array([s.excitation for s in solutions]),
        hydrostatic_stiffness=block_diag(stiffness, stiffness),
        inertia_matrix=block_diag(inertia, inertia),
        volume=np.full(2, afloat.volume),
        centre_of_buoyancy=CENTRES + np.array([0.0, 0.0, depth]),
        centre_of_gravity=CENTRES,
        reference_point=CENTRES,
        water_depth=WATER.depth,
        water_density=WATER.density,
        gravity=WATER.gravity,
        port_starboard_symmetric=False,
        attributes={
            "title": "Two box barges, 40 m x 10 m, draught 3 m, side by side with a gap of 4 m",
            "solver": f"Capytaine {cpt.__version__}, {hulls().mesh.nb_faces} panels",
            "assumed": "KG 3 m and the radii of gyration 3.5, 10.4 and 10.4 m",
            "licence": "Apache-2.0",
        },
    )


def draw(db: HydroDatabase, path: Path) -> None:
    """Heave and sway of the barge to port, by itself and by the other's motion."""
    figure = Figure(figsize=(11, 8), layout="constrained")
    kinds = {"added mass [t]": db.added_mass, "radiation damping [t/s]": db.radiation_damping}
    axes = figure.subplots(2, 2, sharex=True)
    for row, (label, matrices) in zip(axes, kinds.items(), strict=True):
        for axis, dof in zip(row, (1, 2), strict=True):
            for other, by in ((0, "its own motion"), (6, "the other's")):
                line = matrices[:, dof, dof + other] / 1e3
                axis.plot(db.frequency, line, ".-", label=f"{DOFS[dof]} by {by}")
            axis.set(ylabel=label, xlabel="wave frequency [rad/s]")
            axis.grid(alpha=0.3)
            axis.legend(fontsize="small")
    figure.suptitle(db.attributes["title"])
    figure.savefig(path, dpi=100)


def main() -> None:
    """Compute and write the database and its picture."""
    parser = argparse.ArgumentParser(description="Compute hydro_db/two_barges.nc.")
    parser.add_argument("--jobs", type=int, default=1, help="number of processes")
    parser.add_argument("--output", type=Path, default=Path(__file__).with_suffix(".nc"))
    given = parser.parse_args()
    calls = (joblib.delayed(solve)(float(w)) for w in FREQUENCIES)
    db = assemble(joblib.Parallel(n_jobs=given.jobs)(calls), infinite_added_mass())
    write(db, given.output)
    draw(db, given.output.with_suffix(".png"))


if __name__ == "__main__":
    main()
