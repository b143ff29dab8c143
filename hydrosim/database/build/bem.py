"""Linear potential flow around bodies, by Capytaine; its results on disk; its worker processes.

Capytaine's time factor is exp(-i w t). Only this module conjugates loads, to exp(+i w t). The
Kochin functions are unchanged, for `drift`.

Worker processes that end when their parent process ends.

Like those of `hydrosim.study.executors`, they hold one end of a pipe, and the parent holds
the other. It closes however the parent ends. A thread watches it, because workers are in long calls
then.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cache, cached_property
from io import BytesIO
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from threading import Thread
from typing import Any, NamedTuple

import capytaine as cpt
import joblib
import numpy as np
from capytaine.bem.airy_waves import froude_krylov_force
from capytaine.post_pro import compute_kochin

import hydrosim
from hydrosim.database.build import green
from hydrosim.database.build.drift import DIRECTIONS, Complex, Real, Water
from hydrosim.dofs import DOFS
from hydrosim.files.cache import digest_of_sources, store, stored

# Results of long computations, stored under a hash of all their inputs.


def key_of(*parts: str | bytes | float | np.ndarray) -> str:
    """Hash (hex) of numbers and texts; it changes with any bit of them."""
    digest = hashlib.sha256()
    for part in parts:
        if isinstance(part, np.ndarray):
            digest.update(f"{part.shape}{part.dtype.str}".encode())
            part = np.ascontiguousarray(part).tobytes()
        data = part if isinstance(part, bytes) else repr(part).encode()
        digest.update(f"{len(data)}:".encode() + data)
    return digest.hexdigest()


def entry_name(key: str) -> str:
    """Name in the cache of what is stored under ``key``."""
    return f"potential-flow/{key[:32]}.npz"


def remembered(key: str, compute: Callable[[], Iterable[Any]]) -> list[np.ndarray]:
    """Arrays stored under ``key``; if there are none, they are computed and stored.

    A file is complete or absent, so the program may be interrupted at any time.
    """
    name = entry_name(key)
    stored_bytes = stored(name)
    if stored_bytes is not None:
        with np.load(BytesIO(stored_bytes), allow_pickle=False) as file:
            return [file[name] for name in file.files]
    arrays, content = [np.asarray(array) for array in compute()], BytesIO()
    np.savez(content, *arrays)
    store(name, content.getvalue())
    return arrays


WATCHED_END, HELD_END = Pipe(duplex=False)
"""Reading end that workers watch, and writing end that this process holds open."""


def compute_all(calls: Iterable[Any], jobs: int) -> Iterator[Any]:
    """Results of delayed ``calls`` in order, by ``jobs`` processes."""
    watch = {"initializer": _end_with, "initargs": (WATCHED_END,)} if jobs != 1 else {}
    return iter(joblib.Parallel(n_jobs=jobs, return_as="generator", **watch)(calls))


def _end_with(parent: Connection) -> None:
    """End this process as soon as the other end of a pipe is closed."""
    Thread(target=_wait_and_end, args=(parent,), daemon=True).start()


def _wait_and_end(parent: Connection) -> None:
    parent.poll(None)
    os._exit(1)


PACKAGE = Path(hydrosim.__file__).parent
SOLVERS = "database/build/bem.py", "database/build/green.py", "water/bed_reflection.py"
Progress = Callable[[int, int], None]  # receives the number of completed frequencies and the total
Point = tuple[float, float, float]


@dataclass(frozen=True)
class Hull:
    """Panels (n, 4, 3) of the wetted hulls with normals into the water, and of the lids on the
    waterplanes inside them. Lids remove irregular frequencies; without them their array is (0, 4,
    3). If ``symmetric``, only panels at y >= 0 are given. The last corner of a triangle is doubled.

    Moments of each body are about its own point of ``centres`` [m]. ``owner`` is the body of each
    panel of the whole, with the mirror image last; it is optional for one body. If ``direct``,
    pressures come from the integral equation for the potential. Otherwise, they come from sources
    on the panels, which always give the far field.
    """

    panels: Real
    lid: Real
    symmetric: bool
    centres: tuple[Point, ...]
    direct: bool = False
    owner: tuple[int, ...] = ()

    @cached_property
    def body(self) -> cpt.FloatingBody:
        """Capytaine's body, which represents all bodies."""
        mesh = self._mesh(self.panels)
        return cpt.FloatingBody(
            mesh=mesh,
            lid_mesh=self._mesh(self.lid) if len(self.lid) else None,
            dofs=self._motions(mesh.faces_centers),
            center_of_mass=self.centres[0],
        )

    def _mesh(self, panels: Real) -> cpt.Mesh | cpt.ReflectionSymmetricMesh:
        mesh = mesh_of(panels)
        return cpt.ReflectionSymmetricMesh(half=mesh, plane="xOz") if self.symmetric else mesh

    def _motions(self, points: Real) -> dict[str, Real]:
        """Motions (panels, 3) of each DOF, body by body, while the other bodies are held."""
        owner = np.array(self.owner or np.zeros(len(points)))
        motions = {}
        for number, centre in enumerate(self.centres):
            is_owned = (owner == number)[:, None]
            for dof, along in zip(DOFS[:3], np.eye(3), strict=True):
                motions[f"{number} {dof}"] = is_owned * along
            for dof, about in zip(DOFS[3:], np.eye(3), strict=True):
                motions[f"{number} {dof}"] = is_owned * np.cross(about, points - np.array(centre))
        return motions


def mesh_of(panels: Real) -> cpt.Mesh:
    """Capytaine's mesh of the panels (n, 4, 3)."""
    triangle = (panels[:, 2] == panels[:, 3]).all(axis=1)
    faces = [p[:3] if three else p for p, three in zip(panels.tolist(), triangle, strict=True)]
    return cpt.Mesh.from_list_of_faces(faces)


class Solution(NamedTuple):
    """Results at one frequency [rad/s] in SI, n = 6 x number of bodies: added mass and damping (n,
    n); loads per unit wave amplitude (headings, n); Kochin functions of unit motions (n,
    directions) and of the diffracted waves of unit amplitude (headings, directions)."""

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

    Each solution is stored on the disk at once, so an interrupted computation can continue.
    """
    _ = hull.body  # sent to the processes with the hull, because making it takes a second
    calls = (joblib.delayed(_stored)(hull, water, float(w), headings) for w in frequencies)
    done = []
    for solution in compute_all(calls, jobs):
        done.append(solution)
        progress(len(done), len(frequencies))
    return done


def solve(hull: Hull, water: Water, frequency: float, headings: Real) -> Solution:
    """Radiation and diffraction at one ``frequency`` [rad/s] for ``headings`` [rad]."""
    given = _given(hull, water, frequency)
    used = solver(water.is_deep)
    moving = [cpt.RadiationProblem(radiating_dof=d, **given) for d in hull.body.dofs]
    fixed = [cpt.DiffractionProblem(wave_direction=b, **given) for b in headings]
    radiated = _solved(used, moving)
    diffracted = _solved(used, fixed)
    far = kochin([*radiated, *diffracted])
    if hull.direct:
        used = solver(water.is_deep, direct=True)
        radiated = _solved(used, moving)
        diffracted = _solved(used, fixed)
    incident = froude_krylov(hull, water, frequency, headings)
    scattered = loads_of(hull.body, (result.forces for result in diffracted))
    return Solution(
        frequency,
        loads_of(hull.body, (result.added_masses for result in radiated)).T,
        loads_of(hull.body, (result.radiation_dampings for result in radiated)).T,
        np.conj(scattered) + incident,
        incident,
        far[: len(moving)],
        far[len(moving) :],
    )


def kochin(results: Sequence[cpt.LinearPotentialFlowResult]) -> Complex:
    """Kochin functions (results, directions) of results of one body and frequency. They are
    computed together, because the waves that they share take most of the time."""
    together = copy(results[0])
    together.sources = np.array([result.sources for result in results]).T
    return np.ascontiguousarray(compute_kochin(together, DIRECTIONS).T)


def _solved(used: cpt.BEMSolver, problems: Iterable[Any]) -> list[Any]:
    return [used.solve(problem) for problem in problems]


def froude_krylov(hull: Hull, water: Water, frequency: float, headings: Real) -> Complex:
    """Loads (headings, n) of the undisturbed waves per unit amplitude."""
    given = _given(hull, water, frequency)
    waves = (cpt.DiffractionProblem(wave_direction=b, **given) for b in headings)
    return np.conj(loads_of(hull.body, (froude_krylov_force(problem) for problem in waves)))


def limit_added_mass(hull: Hull, water: Water, frequency: float) -> Real:
    """Added mass (n, n) at ``frequency`` infinity or, in deep water only, 0."""

    def compute() -> list[Real]:
        given = _given(hull, water, frequency)
        used = solver(water.is_deep, hull.direct)
        moving = (cpt.RadiationProblem(radiating_dof=d, **given) for d in hull.body.dofs)
        return [
            loads_of(hull.body, (solution.added_masses for solution in _solved(used, moving))).T
        ]

    return remembered(solution_key(hull, water, frequency, np.empty(0)), compute)[0]


def _stored(hull: Hull, water: Water, frequency: float, headings: Real) -> Solution:
    key = solution_key(hull, water, frequency, headings)
    _, *arrays = remembered(key, lambda: solve(hull, water, frequency, headings))
    return Solution(frequency, *arrays)


def solution_key(hull: Hull, water: Water, frequency: float, headings: Real) -> str:
    """Hash of all data that `solve` and `limit_added_mass` depend on, including the program."""
    shape = hull.panels, hull.lid, hull.symmetric, np.array(hull.centres), hull.direct
    numbers = water.density, water.gravity, water.depth, frequency, headings, DIRECTIONS
    return key_of(cpt.__version__, _sources(), *shape, np.array(hull.owner), *numbers)


def _sources() -> str:
    """Version of the program's own part of a solution."""
    return digest_of_sources(PACKAGE, *SOLVERS)


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
    # Capytaine warns of panels over 1/8 wavelength; their error is measured.
    cpt.set_logging("ERROR")
    given = {} if deep else {"green_function": green.FiniteDepth()}
    return cpt.BEMSolver(method="direct" if direct else "indirect", **given)


def loads_of(body: cpt.FloatingBody, loads: Iterable[dict[str, complex]]) -> np.ndarray:
    """The loads (m, n) in the order of the body's degrees of freedom."""
    load_rows = [[load[dof] for dof in body.dofs] for load in loads]
    return np.array(load_rows).reshape(-1, len(body.dofs))
