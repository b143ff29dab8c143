"""Linear potential flow round one hull with port-starboard symmetry, by Capytaine, in deep water.

Capytaine's time factor is exp(-i w t); loads are conjugated here, to exp(+i w t), and nowhere else.
The Kochin functions stay as they are, for `drift`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import capytaine as cpt
import joblib
import numpy as np
from capytaine.bem.airy_waves import froude_krylov_force
from capytaine.post_pro import compute_kochin
from rich.progress import track

from hydrosim.database.build.drift import DIRECTIONS, Complex, Real

DOFS = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")


@dataclass(frozen=True)
class Water:
    """Deep water: density [kg/m^3] and gravity [m/s^2]."""

    density: float = 1025.0
    gravity: float = 9.81


class Solution(NamedTuple):
    """One frequency [rad/s] in SI: added mass and damping (6, 6), loads per unit wave amplitude
    (headings, 6), Kochin functions of unit motions (6, directions) and of the diffracted waves of
    unit amplitude (headings, directions)."""

    frequency: float
    added_mass: Real
    damping: Real
    excitation: Complex
    froude_krylov: Complex
    kochin_radiation: Complex
    kochin_diffraction: Complex


def floating_body(half: np.ndarray, lid: np.ndarray, centre: Sequence[float]) -> cpt.FloatingBody:
    """Body of the panels at y >= 0 (n, 4, 3) and their mirror images; moments about ``centre``.

    The lid is the waterplane inside the hull, which removes the irregular frequencies.
    """
    return cpt.FloatingBody(
        mesh=_symmetric_mesh(half),
        lid_mesh=_symmetric_mesh(lid),
        dofs=cpt.rigid_body_dofs(rotation_center=centre),
        center_of_mass=centre,
    )


def solve_all(
    body: cpt.FloatingBody, water: Water, frequencies: Real, headings: Real, jobs: int
) -> list[Solution]:
    """Solutions at all ``frequencies`` [rad/s], by ``jobs`` processes, with a progress bar."""
    calls = (joblib.delayed(solve)(body, water, float(w), headings) for w in frequencies)
    results = joblib.Parallel(n_jobs=jobs, return_as="generator")(calls)
    return list(track(results, description="Frequencies", total=len(frequencies)))


def solve(body: cpt.FloatingBody, water: Water, frequency: float, headings: Real) -> Solution:
    """Radiation and diffraction at one ``frequency`` [rad/s] for ``headings`` [rad]."""
    given = {"body": body, "omega": frequency, "rho": water.density, "g": water.gravity}
    radiated = [_solver().solve(cpt.RadiationProblem(radiating_dof=d, **given)) for d in DOFS]
    fixed = [cpt.DiffractionProblem(wave_direction=b, **given) for b in headings]
    diffracted = [_solver().solve(problem) for problem in fixed]
    incident = _by_dof(froude_krylov_force(problem) for problem in fixed)
    return Solution(
        frequency,
        _by_dof(result.added_masses for result in radiated).T,
        _by_dof(result.radiation_dampings for result in radiated).T,
        np.conj(_by_dof(result.forces for result in diffracted) + incident),
        np.conj(incident),
        np.array([compute_kochin(result, DIRECTIONS) for result in radiated]),
        np.array([compute_kochin(result, DIRECTIONS) for result in diffracted]),
    )


def limit_added_mass(body: cpt.FloatingBody, water: Water, frequency: float) -> Real:
    """Added mass (6, 6) at ``frequency`` 0 or infinity."""
    given = {"body": body, "omega": frequency, "rho": water.density, "g": water.gravity}
    moving = [cpt.RadiationProblem(radiating_dof=d, **given) for d in DOFS]
    return _by_dof(_solver().solve(problem).added_masses for problem in moving).T


@cache
def _solver() -> cpt.BEMSolver:
    cpt.set_logging("ERROR")  # It warns of panels over 1/8 wavelength; their error is measured.
    return cpt.BEMSolver()


def _symmetric_mesh(half: np.ndarray) -> cpt.ReflectionSymmetricMesh:
    return cpt.ReflectionSymmetricMesh(half=cpt.Mesh.from_list_of_faces(half.tolist()), plane="xOz")


def _by_dof(loads: Iterable[dict]) -> np.ndarray:
    return np.array([[load[dof] for dof in DOFS] for load in loads])
