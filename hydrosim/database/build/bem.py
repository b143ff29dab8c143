"""Linear potential flow round one hull, by Capytaine.

Capytaine's time factor is exp(-i w t); loads are conjugated here, to exp(+i w t), and nowhere else.
The Kochin functions stay as they are, for `drift`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any, NamedTuple

import capytaine as cpt
import joblib
import numpy as np
from capytaine.bem.airy_waves import froude_krylov_force
from capytaine.post_pro import compute_kochin

from hydrosim.database.build import green
from hydrosim.database.build.drift import DIRECTIONS, Complex, Real
from hydrosim.database.build.store import key_of, remembered
from hydrosim.database.build.water import Water

Progress = Callable[[int, int], None]  # told how many frequencies are done, and of how many
DOFS = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")


@dataclass(frozen=True)
class Hull:
    """Panels (n, 4, 3) of the wetted hull, normals into the water, and of the lid on the waterplane
    inside it, which removes the irregular frequencies, or none (0, 4, 3). If ``symmetric``, of
    those at y >= 0 only. A triangle has its last corner twice. Moments are about ``centre`` [m].
    If ``direct``, pressures are by the integral equation for the potential; otherwise, and the far
    field always, by that for sources on the panels.
    """

    panels: Real
    lid: Real
    symmetric: bool
    centre: tuple[float, float, float]
    direct: bool = False

    @cached_property
    def body(self) -> cpt.FloatingBody:
        """Capytaine's body."""
        return cpt.FloatingBody(
            mesh=self._mesh(self.panels),
            lid_mesh=self._mesh(self.lid) if len(self.lid) else None,
            dofs=cpt.rigid_body_dofs(rotation_center=self.centre),
            center_of_mass=self.centre,
        )

    def _mesh(self, panels: Real) -> cpt.Mesh | cpt.ReflectionSymmetricMesh:
        mesh = mesh_of(panels)
        return cpt.ReflectionSymmetricMesh(half=mesh, plane="xOz") if self.symmetric else mesh


def mesh_of(panels: Real) -> cpt.Mesh:
    """Capytaine's mesh of the panels (n, 4, 3)."""
    triangle = (panels[:, 2] == panels[:, 3]).all(axis=1)
    faces = [p[:3] if three else p for p, three in zip(panels.tolist(), triangle, strict=True)]
    return cpt.Mesh.from_list_of_faces(faces)


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


def solve_all(
    hull: Hull, water: Water, frequencies: Real, headings: Real, jobs: int, progress: Progress
) -> list[Solution]:
    """Solutions at all ``frequencies`` [rad/s] for ``headings`` [rad], by ``jobs`` processes.

    Each is kept on disk once it is there, so that the work can be interrupted and taken up again.
    """
    _ = hull.body  # goes to the processes with the hull, since making it takes a second
    calls = (joblib.delayed(_stored)(hull, water, float(w), headings) for w in frequencies)
    done = []
    for solution in joblib.Parallel(n_jobs=jobs, return_as="generator")(calls):
        done.append(solution)
        progress(len(done), len(frequencies))
    return done


def solve(hull: Hull, water: Water, frequency: float, headings: Real) -> Solution:
    """Radiation and diffraction at one ``frequency`` [rad/s] for ``headings`` [rad]."""
    given, used = _given(hull, water, frequency), solver(water.is_deep)
    moving = [cpt.RadiationProblem(radiating_dof=d, **given) for d in DOFS]
    fixed = [cpt.DiffractionProblem(wave_direction=b, **given) for b in headings]
    radiated, diffracted = _solved(used, moving), _solved(used, fixed)
    far = radiated, diffracted
    if hull.direct:
        used = solver(water.is_deep, direct=True)
        radiated, diffracted = _solved(used, moving), _solved(used, fixed)
    incident = froude_krylov(hull, water, frequency, headings)
    return Solution(
        frequency,
        by_dof(result.added_masses for result in radiated).T,
        by_dof(result.radiation_dampings for result in radiated).T,
        np.conj(by_dof(result.forces for result in diffracted)) + incident,
        incident,
        *(np.array([compute_kochin(result, DIRECTIONS) for result in each]) for each in far),
    )


def _solved(used: cpt.BEMSolver, problems: Iterable[Any]) -> list[Any]:
    return [used.solve(problem) for problem in problems]


def froude_krylov(hull: Hull, water: Water, frequency: float, headings: Real) -> Complex:
    """Loads (headings, 6) of the undisturbed waves per unit amplitude."""
    given = _given(hull, water, frequency)
    waves = (cpt.DiffractionProblem(wave_direction=b, **given) for b in headings)
    return np.conj(by_dof(froude_krylov_force(problem) for problem in waves))


def limit_added_mass(hull: Hull, water: Water, frequency: float) -> Real:
    """Added mass (6, 6) at ``frequency`` infinity or, in deep water only, 0."""

    def compute() -> list[Real]:
        given, used = _given(hull, water, frequency), solver(water.is_deep, hull.direct)
        moving = (cpt.RadiationProblem(radiating_dof=d, **given) for d in DOFS)
        return [by_dof(result.added_masses for result in _solved(used, moving)).T]

    return remembered(solution_key(hull, water, frequency, np.empty(0)), compute)[0]


def _stored(hull: Hull, water: Water, frequency: float, headings: Real) -> Solution:
    key = solution_key(hull, water, frequency, headings)
    _, *arrays = remembered(key, lambda: solve(hull, water, frequency, headings))
    return Solution(frequency, *arrays)


def solution_key(hull: Hull, water: Water, frequency: float, headings: Real) -> str:
    """Hash of all that `solve` and `limit_added_mass` depend on, the program included."""
    shape = hull.panels, hull.lid, hull.symmetric, np.array(hull.centre), hull.direct
    numbers = water.density, water.gravity, water.depth, frequency, headings, DIRECTIONS
    return key_of(cpt.__version__, *_sources(), *shape, *numbers)


@cache
def _sources() -> tuple[bytes, ...]:
    """The program's own part in a solution."""
    return Path(__file__).read_bytes(), Path(green.__file__).read_bytes()


def _given(hull: Hull, water: Water, frequency: float) -> dict[str, Any]:
    return {
        "body": hull.body,
        "omega": frequency,
        "rho": water.density,
        "g": water.gravity,
        "water_depth": water.depth,
    }


@cache
def solver(deep: bool = True, direct: bool = False) -> cpt.BEMSolver:
    """Capytaine's solver, made once."""
    cpt.set_logging("ERROR")  # It warns of panels over 1/8 wavelength; their error is measured.
    given = {} if deep else {"green_function": green.FiniteDepth()}
    return cpt.BEMSolver(method="direct" if direct else "indirect", **given)


def by_dof(loads: Iterable[dict]) -> np.ndarray:
    """The loads (n, 6) in the order of the degrees of freedom."""
    return np.array([[load[dof] for dof in DOFS] for load in loads])
