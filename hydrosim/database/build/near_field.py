"""First-order flow on a floating body's wetted surface, by Capytaine, in deep water.

Quantities for pressure integration to second order: water velocities at the hull's panels, wave
elevation relative to the hull along the waterline, motions and loads. All results have the time
factor exp(+i w t) and are per unit wave amplitude.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import capytaine as cpt
import joblib
import numpy as np
from capytaine.bem.airy_waves import airy_waves_potential, airy_waves_velocity, froude_krylov_force

from hydrosim.database.build import bem
from hydrosim.database.build.assemble import Floating
from hydrosim.database.build.drift import Complex, Real, Water
from hydrosim.files.cache import digest_of_sources

ROWS = 400  # points at a time, with 64 bytes for each panel of hull and lid


class Wetted(NamedTuple):
    """Wetted surface at rest, from the reference point. For panels: centres ``arm`` (n, 3);
    ``area`` (n, 6), which has outward normals and their moments times the area [m^2, m^3];
    ``sharp`` (n, 3, 3), see `_sharp`. For edges in the waterline: centres ``edge_arm`` (m, 3);
    ``edge`` (m, 6), which has normals and moments times the area wetted per rise of the water [m,
    m^2]."""

    arm: Real
    area: Real
    sharp: Real
    edge_arm: Real
    edge: Real


class Flow(NamedTuple):
    """Flow at one ``frequency`` [rad/s], for every heading. ``motion`` and first-order ``load``
    (headings, 6) are about the reference point; the load is that of fluid and weight together.
    ``velocity`` of the water is at the panels (headings, n, 3). ``rise`` is the elevation of the
    water relative to the hull's waterline (headings, m)."""

    frequency: float
    motion: Complex
    load: Complex
    velocity: Complex
    rise: Complex


class Part(NamedTuple):
    """One of several bodies: its index, its own wetted ``mesh``, and its ``centre`` (3,)."""

    number: int
    mesh: cpt.Mesh
    centre: Real

    @property
    def dofs(self) -> slice:
        """Indices of its degrees of freedom among those of all bodies."""
        return slice(6 * self.number, 6 * self.number + 6)


def whole(body: cpt.FloatingBody) -> Part:
    """A single body, about its centre of mass."""
    return Part(0, body.mesh.merged(), np.asarray(body.center_of_mass))


def parts_of(hull: bem.Hull) -> list[Part]:
    """The bodies of a hull."""
    if len(hull.centres) == 1:
        return [whole(hull.body)]
    mesh = hull.body.mesh.merged()
    owner = np.array(hull.owner)
    return [
        Part(number, mesh.extract_faces(np.flatnonzero(owner == number)), np.array(centre))
        for number, centre in enumerate(hull.centres)
    ]


def wetted_surface(part: Part) -> Wetted:
    """Panels and waterline of a body, from its centre."""
    mesh = part.mesh
    centre = part.centre
    edge_arm, edge_normal = _waterline(mesh)
    arm = mesh.faces_centers - centre
    edge_arm = edge_arm - centre
    area = mesh.faces_normals * mesh.faces_areas[:, None]
    edge = _with_moment(edge_arm, edge_normal)
    return Wetted(arm, _with_moment(arm, area), _sharp(mesh), edge_arm, edge)


def first_order(
    body: cpt.FloatingBody,
    floating: Floating | None,
    water: Water,
    frequency: float,
    headings: Real,
) -> Flow:
    """Flow at one ``frequency`` [rad/s] for ``headings`` [rad] around a body about its centre of
    mass. The body floats freely; without ``floating`` it is held at rest."""
    return first_order_of_each(body, [whole(body)], floating, water, frequency, headings)[0]


def first_order_of_each(
    body: cpt.FloatingBody,
    parts: Sequence[Part],
    floating: Floating | None,
    water: Water,
    frequency: float,
    headings: Real,
) -> list[Flow]:
    """Flow around each of the ``parts`` of a ``body``, in the waves of all.

    Along a panel, the velocity is the difference of the potential between its corners, which has a
    fraction of the error of the sources' own velocity. Normal to the panel, it is the hull's
    velocity.
    """
    given = {"body": body, "omega": frequency, "rho": water.density, "g": water.gravity}
    radiated = [
        bem.solver().solve(cpt.RadiationProblem(radiating_dof=d, **given)) for d in body.dofs
    ]
    fixed = [cpt.DiffractionProblem(wave_direction=b, **given) for b in headings]
    diffracted = [bem.solver().solve(problem) for problem in fixed]
    incident = bem.loads_of(body, (froude_krylov_force(problem) for problem in fixed))
    scattered = bem.loads_of(body, (result.forces for result in diffracted))
    excitation = np.conj(scattered + incident)
    motion, load = _response(floating, radiated, excitation)
    # Sources have Capytaine's time factor, so they need the conjugate motion.
    sources = np.conj(motion) @ [r.sources for r in radiated] + [r.sources for r in diffracted]
    flows = []
    for part in parts:
        wetted = wetted_surface(part)
        body_motion = motion[:, part.dofs]
        velocity = _velocity(part, wetted, fixed, sources, body_motion)
        rise = _rise(part, wetted, fixed, sources, body_motion)
        flows.append(Flow(frequency, body_motion, load[:, part.dofs], velocity, rise))
    return flows


def first_order_all(
    hull: bem.Hull,
    floating: Floating,
    water: Water,
    frequencies: Real,
    headings: Real,
    jobs: int,
    progress: bem.Progress,
) -> list[Flow]:
    """`first_order` at all ``frequencies`` [rad/s] around the freely floating ``hull``, by ``jobs``
    processes. Results are stored on the disk like those of `bem.solve_all`."""
    _ = hull.body
    task = joblib.delayed(_stored)
    calls = (task(hull, floating, water, float(w), headings) for w in frequencies)
    done = []
    for flow in bem.compute_all(calls, jobs):
        done.append(flow)
        progress(len(done), len(frequencies))
    return done


def displacement(motion: Complex, arm: Real) -> Complex:
    """Displacements (..., n, 3) of the points ``arm`` (n, 3) by ``motion`` (..., 6)."""
    return motion[..., None, :3] + np.cross(motion[..., None, 3:], arm)


def _stored(
    hull: bem.Hull, floating: Floating, water: Water, frequency: float, headings: Real
) -> Flow:
    solved = bem.solution_key(hull, water, frequency, headings)
    sources = digest_of_sources(Path(__file__).parent, "near_field.py")
    key = bem.key_of(solved, sources, floating.inertia, floating.stiffness)
    arrays = bem.remembered(
        key, lambda: first_order(hull.body, floating, water, frequency, headings)
    )
    return Flow(frequency, *arrays[1:])


def _response(
    floating: Floating | None,
    radiated: Sequence[cpt.LinearPotentialFlowResult],
    excitation: Complex,
) -> tuple[Complex, Complex]:
    """Motions and first-order loads of fluid and weight (headings, 6):
    (C - w^2 (M + A) + i w B) xi = X and F = X - (C - w^2 A + i w B) xi."""
    if floating is None:
        return np.zeros_like(excitation), excitation
    w = radiated[0].omega
    body = radiated[0].body
    added_mass = bem.loads_of(body, (result.added_masses for result in radiated)).T
    damping = bem.loads_of(body, (result.radiation_dampings for result in radiated)).T
    fluid = floating.stiffness - w**2 * added_mass + 1j * w * damping
    impedance = fluid - w**2 * floating.inertia
    motion = np.asarray(np.linalg.solve(impedance, excitation.T).T, dtype=np.complex128)
    return motion, excitation - motion @ fluid.T


def _velocity(
    part: Part,
    wetted: Wetted,
    fixed: Sequence[cpt.DiffractionProblem],
    sources: Complex,
    motion: Complex,
) -> Complex:
    """Velocity (headings, n, 3) at the panels."""
    problem = fixed[0]
    mesh = part.mesh
    incident = np.conj([airy_waves_velocity(mesh.faces_centers, wave) for wave in fixed])
    corner = np.conj(_potential(problem, sources, mesh.vertices))
    hull = 1j * problem.omega * displacement(motion, wetted.arm)
    normal = np.sum((hull - incident) * mesh.faces_normals, axis=-1)
    return incident + _gradient(mesh, corner, normal)


def _gradient(mesh: cpt.Mesh, corner: Complex, normal: Complex) -> Complex:
    """Gradients (headings, n, 3) at the panels of a potential (headings, corners of ``mesh``), from
    its differences along the diagonals and its ``normal`` derivatives (headings, n)."""
    place = mesh.vertices[mesh.faces]
    value = corner[:, mesh.faces]
    diagonals = [place[:, 2] - place[:, 0], place[:, 3] - place[:, 1]]
    slope = [value[..., 2] - value[..., 0], value[..., 3] - value[..., 1], normal]
    axes = np.stack([*diagonals, mesh.faces_normals], axis=1)
    return np.linalg.solve(axes, np.stack(slope, axis=-1)[..., None])[..., 0]


def _rise(
    part: Part,
    wetted: Wetted,
    fixed: Sequence[cpt.DiffractionProblem],
    sources: Complex,
    motion: Complex,
) -> Complex:
    """Elevation -i w phi / g relative to the hull's own waterline (headings, m)."""
    problem = fixed[0]
    edges = wetted.edge_arm + part.centre
    potential = np.array([airy_waves_potential(edges, wave) for wave in fixed])
    potential += _potential(problem, sources, edges)
    elevation = -1j * problem.omega / problem.g * np.conj(potential)
    return elevation - displacement(motion, wetted.edge_arm)[..., 2]


def _potential(problem: cpt.DiffractionProblem, sources: Complex, points: Real) -> Complex:
    """Potential (headings, m) at ``points`` (m, 3) by ``sources``, in Capytaine's time factor."""
    panels = problem.body.mesh_including_lid.merged()
    sea = {"free_surface": 0.0, "water_depth": np.inf, "wavenumber": problem.wavenumber}
    parts = (points[start : start + ROWS] for start in range(0, len(points), ROWS))
    build = bem.solver().engine.build_S_matrix
    return np.concatenate([build(part, panels, **sea) @ sources.T for part in parts]).T


def _sharp(mesh: cpt.Mesh) -> Real:
    """Factors (n, 3, 3) that convert the panels' mean velocities to the mean of their square.

    At an edge where the hull turns by an angle t, the potential is that of flow around a corner, c
    s^a at a distance s, a = pi / (pi + t). The mean square of its slope over a panel at the edge is
    a^2 / (2 a - 1) times the square of the mean slope, 4/3 at a right angle. The error of the
    integral then decreases as the panel's width to the power 2/3 instead of 1/3.
    """
    sharp = np.tile(np.eye(3), (mesh.nb_faces, 1, 1))
    panel, other, along = _neighbours(mesh)
    normal = mesh.faces_normals
    centre = mesh.faces_centers
    angle = np.arccos(np.clip(np.sum(normal[panel] * normal[other], axis=1), -1.0, 1.0))
    convex = np.sum((centre[other] - centre[panel]) * normal[panel], axis=1) < 0
    a = np.pi / (np.pi + np.where(convex, angle, -angle))
    across = np.cross(normal[panel], along)
    stretch = np.sqrt(a**2 / (2 * a - 1)) - 1
    for face, vector, more in zip(panel, across, stretch, strict=True):
        sharp[face] = sharp[face] @ (np.eye(3) + more * np.outer(vector, vector))
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
    """Centres (m, 3) of the panels' edges at z = 0, and their panels' normals (m, 3) times the
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
