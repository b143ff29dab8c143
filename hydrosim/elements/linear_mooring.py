"""Linear mooring: a spring and damper at a body's centre of gravity, in all its DOFs.

    F = -S^-T (K q + C q')

q: displacements and angles from rest [m, rad], along the earth's axes and about the body's; q':
their rates; K: stiffness (6, 6), symmetric; C: damping (6, 6). Stored energy q^T K q / 2,
dissipation q'^T C q'. A natural period or a damping ratio applies along the body's axes at rest, so
that it turns with the scene.

Limits: the force is conjugate to the coordinates, so that it has a potential at any angle but does
not depend on the heading. There is no slack and no table.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.elements.kind import ElementKind, Layout, LinearResistance, axes_at_rest
from hydrosim.errors import InputError
from hydrosim.jit.kernels import kernel, root
from hydrosim.multibody.kinematics import wrench_of_coordinates
from hydrosim.multibody.mass import spring_energy, spring_force
from hydrosim.multibody.vectors import product
from hydrosim.scene import ForceElement
from hydrosim.scene.restraints import LinearMooring

TUNING = 100  # iterations, each of which removes most of the error
NOISE = 1e-14  # of the largest stiffness: rounding of a turn


MOORING = np.dtype(
    [("body", int), ("row", int), ("stiffness", float, (6, 6)), ("damping", float, (6, 6))]
)


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout) -> np.ndarray:
    """Constants (ne,) of `MOORING` of the moorings among ``elements``."""
    rows = []
    for name, element in elements.items():
        if isinstance(element, LinearMooring):
            body = layout.body[element.body]
            axes = axes_at_rest(layout.heading[body])
            tuned = _tuned_stiffness(name, element, body, layout)
            stiffness = element.stiffness + axes @ np.diag(tuned) @ axes.T
            damping = _damping_matrix(name, element, stiffness, body, layout)
            rows.append((body, layout.row[name], stiffness, damping))
    return np.array(rows, dtype=MOORING)


def _tuned_stiffness(name: str, element: LinearMooring, body: int, layout: Layout) -> np.ndarray:
    """Stiffness (6,) along the body's axes at rest for the requested natural periods, by
    fixed-point iteration."""
    wanted = np.zeros(6) if element.natural_period is None else element.natural_period
    omega = np.divide(2.0 * np.pi, wanted, out=np.zeros(6), where=wanted > 0.0)
    k = np.zeros(6)
    for _ in range(TUNING if np.any(omega) else 0):
        total, mass = layout.resonance(body, k)
        k = np.where(omega > 0.0, omega**2 * mass - (total - k), 0.0)
    for dof, period, dof_stiffness in zip(DOFS, wanted, k, strict=True):
        if dof_stiffness < 0.0:
            raise InputError(
                f"forces.{name}.natural_period: found {period:g} s in {dof}, longer than the period"
                " of the body on its hydrostatics alone; expected a shorter period, or none."
            )
    return k


def _damping_matrix(
    name: str, element: LinearMooring, stiffness: np.ndarray, body: int, layout: Layout
) -> np.ndarray:
    """Damping (6, 6) along the coordinates, like ``stiffness`` (6, 6)."""
    if element.damping is not None:
        return element.damping
    if element.damping_ratio is None:
        return np.zeros((6, 6))
    axes = axes_at_rest(layout.heading[body])
    axis_stiffness = np.maximum(np.diag(axes.T @ stiffness @ axes), 0.0)
    _check_ratios(name, element.damping_ratio, axis_stiffness)
    critical = 2.0 * np.sqrt(axis_stiffness * layout.resonance(body, axis_stiffness).mass)
    return np.asarray(axes @ np.diag(element.damping_ratio * critical) @ axes.T)


def _check_ratios(name: str, ratios: np.ndarray, stiffness: np.ndarray) -> None:
    """Raises InputError for a damping ratio in a DOF without ``stiffness`` (6,)."""
    nothing = NOISE * stiffness.max()
    for dof, ratio, k in zip(DOFS, ratios, stiffness, strict=True):
        if ratio and k <= nothing:
            raise InputError(
                f"forces.{name}.damping_ratio.{dof}: found a ratio where the mooring has no"
                f" stiffness along the body's {dof} at rest, so that there is no critical damping."
                " Add stiffness, or give damping instead."
            )


@kernel
def add_force(t, y, modes, motion, bodies, p, loads):
    """Add the force [N, N m] of every mooring to its row of ``wrench``, and the power [W] that it
    dissipates to ``rate``, in place."""
    for mooring in p:
        b = mooring.body
        row = mooring.row
        k = 6 * b
        u = motion.rate
        Q = spring_force(k, motion.coordinates, mooring.stiffness)
        f = product(mooring.damping, u, k)
        for i in range(6):
            loads.rate[row] += u[k + i] * f[i]
        Q = (Q[0] - f[0], Q[1] - f[1], Q[2] - f[2], Q[3] - f[3], Q[4] - f[4], Q[5] - f[5])
        wrench_of_coordinates(b, Q, bodies, motion, loads.wrench[row])


@root
def add_energy(t, y, modes, motion, bodies, p, stored):
    """Add the energy stored in every mooring to its row of ``stored``."""
    for mooring in p:
        k = 6 * mooring.body
        stored[mooring.row] += spring_energy(k, motion.coordinates, mooring.stiffness)


class LinearMooringKind(ElementKind):
    def resistances(self, p: np.ndarray) -> Iterator[LinearResistance]:
        """Damping of each mooring as a `LinearResistance`."""
        for mooring in p:
            yield LinearResistance(mooring["row"], mooring["body"], mooring["damping"], np.zeros(6))


LINEAR_MOORING_KIND = LinearMooringKind("linear_moorings", (LinearMooring,), compile_elements)
