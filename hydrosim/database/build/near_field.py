"""First-order flow at a floating body's wetted surface, by Capytaine, in deep water.

What pressure integration needs to second order: velocities of the water at the hull's panels,
wave elevation relative to the hull along the waterline, motions and loads. All results have the
time factor exp(+i w t) and are per unit wave amplitude.
"""

from __future__ import annotations

from typing import NamedTuple

import capytaine as cpt
import joblib
import numpy as np
from capytaine.bem.airy_waves import airy_waves_potential, airy_waves_velocity, froude_krylov_force
from rich.progress import track

from hydrosim.database.build.assemble import Floating
from hydrosim.database.build.bem import DOFS, Water, _by_dof, _solver
from hydrosim.database.build.drift import Complex, Real

ROWS = 400  # points at a time, of 64 bytes for each panel of hull and lid


class Wetted(NamedTuple):
    """The wetted surface at rest. Panels: place ``arm`` (n, 3) from the reference point and
    ``area`` (n, 6), the outward normal and its moment, times the panel's area [m^2, m^3]; ``sharp``
    (n, 3, 3), by which the velocity is multiplied for its square, see `_sharp`. Edges in
    the waterline: ``edge_arm`` (m, 3) and ``edge`` (m, 6), the same with the edge's length over
    the sine of the hull's slope, which is the area wetted per rise of the water [m, m^2]."""

    arm: Real
    area: Real
    sharp: Real
    edge_arm: Real
    edge: Real


class Flow(NamedTuple):
    """At one ``frequency`` [rad/s], for every heading: ``motion`` and first-order ``load``
    (headings, 6) about the reference point, fluid and weight together; ``velocity`` of the water
    at the panels (headings, n, 3); elevation ``rise`` of the water over the hull's own waterline
    (headings, m)."""

    frequency: float
    motion: Complex
    load: Complex
    velocity: Complex
    rise: Complex


def wetted_surface(body: cpt.FloatingBody) -> Wetted:
    """Panels and waterline of ``body``, from its centre of mass."""
    mesh = body.mesh.merged()
    centre = np.asarray(body.center_of_mass)
    edge_arm, edge_normal = _waterline(mesh)
    arm, edge_arm = mesh.faces_centers - centre, edge_arm - centre
    area = mesh.faces_normals * mesh.faces_areas[:, None]
    edge = _with_moment(edge_arm, edge_normal)
    return Wetted(arm, _with_moment(arm, area), _sharp(mesh), edge_arm, edge)


def first_order(
    body: cpt.FloatingBody, floating: Floating | None, water: Water, frequency: float, headings: Real
) -> Flow:
    """Flow at one ``frequency`` [rad/s] for ``headings`` [rad] round a body that floats freely, or
    is held at rest where ``floating`` is None; its moments are about its centre of mass.

    The flow due to the sources s on the panels is grad phi = sum K s + n s / 2 at the hull, and the
    elevation is -i w phi / g. Motions obey (C - w^2 (M + A) + i w B) xi = X.
    """
    given = {"body": body, "omega": frequency, "rho": water.density, "g": water.gravity}
    radiated = [_solver().solve(cpt.RadiationProblem(radiating_dof=d, **given)) for d in DOFS]
    fixed = [cpt.DiffractionProblem(wave_direction=b, **given) for b in headings]
    diffracted = [_solver().solve(problem) for problem in fixed]
    incident = _by_dof(froude_krylov_force(problem) for problem in fixed)
    load = np.conj(_by_dof(result.forces for result in diffracted) + incident)
    restoring = np.zeros((6, 6), dtype=complex)
    motion = np.zeros_like(load)
    if floating is not None:
        added = _by_dof(result.added_masses for result in radiated).T
        damping = _by_dof(result.radiation_dampings for result in radiated).T
        restoring = floating.stiffness - frequency**2 * added + 1j * frequency * damping
        impedance = restoring - frequency**2 * floating.inertia
        motion = np.linalg.solve(impedance, load.T).T
    # Radiated potentials are those of unit displacement and, with the sources of the diffracted
    # ones, of Capytaine's time factor: so the sum is made there and conjugated at its end.
    sources = np.conj(motion) @ [r.sources for r in radiated] + [r.sources for r in diffracted]
    wetted = wetted_surface(body)
    mesh, edges = body.mesh.merged(), wetted.edge_arm + body.center_of_mass
    speed = np.conj([airy_waves_velocity(mesh.faces_centers, problem) for problem in fixed])
    at_edges = np.array([airy_waves_potential(edges, problem) for problem in fixed])
    at_edges += _potential(body, fixed[0].wavenumber, sources, edges)
    at_corners = _potential(body, fixed[0].wavenumber, sources, mesh.vertices)
    elevation = np.conj(1j * frequency / water.gravity * at_edges)
    moved = displacement(motion, wetted.arm)
    own = np.sum((1j*frequency*moved-speed)*mesh.faces_normals, axis=-1)
    return Flow(
        frequency,
        motion,
        load - motion @ restoring.T,
        speed + _gradient(mesh, np.conj(at_corners), own),
        elevation - displacement(motion, wetted.edge_arm)[..., 2],
    )


def first_order_all(
    body: cpt.FloatingBody,
    floating: Floating | None,
    water: Water,
    frequencies: Real,
    headings: Real,
    jobs: int,
) -> list[Flow]:
    """`first_order` at all ``frequencies`` [rad/s], by ``jobs`` processes, with a progress bar."""
    one = joblib.delayed(first_order)
    calls = (one(body, floating, water, float(w), headings) for w in frequencies)
    results = joblib.Parallel(n_jobs=jobs, return_as="generator")(calls)
    return list(track(results, description="Near field", total=len(frequencies)))


def displacement(motion: Complex, arm: Real) -> Complex:
    """Displacements (..., n, 3) of the points ``arm`` (n, 3) by ``motion`` (..., 6)."""
    return motion[..., None, :3] + np.cross(motion[..., None, 3:], arm)


def _gradient(mesh: cpt.Mesh, corner: Complex, normal: Complex) -> Complex:
    """Gradients (headings, n, 3) at the panels of a potential (headings, corners of ``mesh``) by
    its differences along the diagonals, and its ``normal`` derivatives (headings, n)."""
    place, value = mesh.vertices[mesh.faces], corner[:, mesh.faces]
    axes = np.stack(
        [place[:, 2] - place[:, 0], place[:, 3] - place[:, 1], mesh.faces_normals], axis=1
    )
    slope = [value[..., 2] - value[..., 0], value[..., 3] - value[..., 1], normal]
    return np.linalg.solve(axes, np.stack(slope, axis=-1)[..., None])[..., 0]


def _potential(
    body: cpt.FloatingBody, wavenumber: float, sources: Complex, points: Real
) -> Complex:
    """Potential (headings, m) at ``points`` (m, 3) by ``sources``."""
    panels = body.mesh_including_lid.merged()
    sea = {"free_surface": 0.0, "water_depth": np.inf, "wavenumber": wavenumber}
    parts = (points[start : start + ROWS] for start in range(0, len(points), ROWS))
    build = _solver().engine.build_S_matrix
    return np.concatenate([build(part, panels, **sea) @ sources.T for part in parts]).T


def _sharp(mesh: cpt.Mesh) -> Real:
    """Factors (n, 3, 3) of the panels' mean velocities, for the mean of the square at corners.

    At an edge where the hull turns by t, the potential is that of a flow round a corner, c s^a at a
    distance s from it, a = pi / (pi + t). The mean square of its slope over a panel at the edge
    is a^2 / (2 a - 1) times the square of its mean slope: 4/3 at a right angle, and the error
    falls with the panel's width to the power 2/3, without the factor 1/3 only.
    """
    sharp = np.tile(np.eye(3), (mesh.nb_faces, 1, 1))
    panel, other, along = _neighbours(mesh)
    normal, centre = mesh.faces_normals, mesh.faces_centers
    angle = np.arccos(np.clip(np.sum(normal[panel] * normal[other], axis=1), -1.0, 1.0))
    convex = np.sum((centre[other] - centre[panel]) * normal[panel], axis=1) < 0
    a = np.pi / (np.pi + np.where(convex, angle, -angle))
    across = np.cross(normal[panel], along)
    stretch = np.sqrt(a**2 / (2 * a - 1)) - 1
    for one, vector, more in zip(panel, across, stretch, strict=True):
        sharp[one] = sharp[one] @ (np.eye(3) + more * np.outer(vector, vector))
    return sharp


def _neighbours(mesh: cpt.Mesh) -> tuple[np.ndarray, np.ndarray, Real]:
    """Panels and their neighbours across an edge, both ways, and the edges' directions (m, 3)."""
    corners = mesh.vertices[mesh.faces]
    step = (np.roll(corners, -1, axis=1) - corners).reshape(-1, 3)
    length = np.linalg.norm(step, axis=1)
    grain = 1e-6 * np.sqrt(mesh.faces_areas.mean())
    middle = np.rint((corners + np.roll(corners, -1, axis=1)).reshape(-1, 3) / 2 / grain)
    order = np.lexsort(middle.T)
    order = order[length[order] > grain]
    shared = (middle[order[:-1]] == middle[order[1:]]).all(axis=1)
    pair = np.concatenate([order[:-1][shared], order[1:][shared]])
    back = np.concatenate([order[1:][shared], order[:-1][shared]])
    return pair // 4, back // 4, step[pair] / length[pair, None]


def _waterline(mesh: cpt.Mesh) -> tuple[Real, Real]:
    """Middles (m, 3) of the panels' edges at z = 0 and their panels' normals (m, 3) times the
    edge's length over sqrt(1 - n_z^2)."""
    corners = mesh.vertices[mesh.faces]
    nexts = np.roll(corners, -1, axis=1)
    size = np.sqrt(mesh.faces_areas)[:, None]
    level = np.maximum(np.abs(corners[..., 2]), np.abs(nexts[..., 2])) < 1e-6 * size
    length = np.linalg.norm(nexts - corners, axis=2)
    panel, side = np.nonzero(level & (length > 1e-6 * size))
    normal = mesh.faces_normals[panel]
    weight = length[panel, side] / np.sqrt(1 - normal[:, 2] ** 2)
    return (corners + nexts)[panel, side] / 2, normal * weight[:, None]


def _with_moment(arm: Real, force: Real) -> Real:
    return np.concatenate([force, np.cross(arm, force)], axis=1)
