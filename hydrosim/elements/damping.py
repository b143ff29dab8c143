"""Damping of a body beyond radiation: linear, and with the squared velocity.

Linear damping of a body, in its own axes: damping beyond radiation, in a linear form.

    F = -C u,   u = R^T (v - U),  R^T omega

v, omega: velocity of the centre of gravity and angular velocity; U: the current, for damping that
is relative to it, else 0; C: damping (6, 6). With small angles R is the identity: the effect of
turning on a damping force is of second order.

With `damping_ratio` r, C_ii = 2 r sqrt(k (m + a(w_n))). The DOF by itself then decays with r of
critical damping in addition. Here k is the stiffness of hydrostatics and of the body's linear
moorings; m + a(w_n) is mass and added mass at the natural frequency w_n of both. Couplings and
other elements do not count.

Booked as dissipation, v^T C u in sum; negative while a current drives the body. Limits: damping in
proportion to the velocity is a fit to one amplitude (Himeno 1981, for roll); see
`QuadraticDamping`.

Quadratic damping of a body, in its own axes: drag and eddies, where flow separates.

    F_i = -sum_j D_ij |u_j| u_j,   u = R^T (v - U),  R^T omega

v, omega: velocity of the centre of gravity and angular velocity; U: the current; D: coefficients
(6, 6), such as 1/2 rho C_D A on the diagonal.

In one DOF with m x'' + D |x'| x' + k x = 0 two successive extremes obey (1 + b x1) exp(-b x1) = (1
- b x2) exp(b x2), b = 2 D / m. (This is the first integral of the equation; Lamb 1923, Dynamics,
has it.) So small swings lose (4/3) D x1^2 / m.

Booked as dissipation, |u_j| u_j D_jj v_j in sum; negative while a current drives the body. Limits:
each DOF by itself (for cross-flow between surge and sway see `stream_load`); no memory of the flow;
coefficients do not depend on amplitude.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.elements import linear_mooring
from hydrosim.elements.kind import ElementKind, Layout, LinearResistance, axes_at_rest
from hydrosim.elements.pair import add_resistance, current_on, relative_velocity
from hydrosim.errors import InputError
from hydrosim.jit.kernels import kernel, root
from hydrosim.multibody.vectors import product
from hydrosim.scene import ForceElement
from hydrosim.scene.damping import LinearDamping, QuadraticDamping

LINEAR_DAMPING = np.dtype(
    [("body", int), ("row", int), ("damping", float, (6, 6)), ("stream", float, 2)]
)


def compile_linear_dampings(elements: Mapping[str, ForceElement], layout: Layout) -> np.ndarray:
    """Constants (ne,) of `LINEAR_DAMPING` of the linear dampings among ``elements``."""
    rows = []
    for name, e in elements.items():
        if isinstance(e, LinearDamping):
            stream = current_on(e.body, layout) if e.relative_to_current else (0.0, 0.0)
            damping = _damping_matrix(name, e, elements, layout)
            rows.append((layout.body[e.body], layout.row[name], damping, stream))
    return np.array(rows, dtype=LINEAR_DAMPING)


def _damping_matrix(
    name: str, element: LinearDamping, elements: Mapping[str, ForceElement], layout: Layout
) -> np.ndarray:
    """Damping (6, 6)."""
    if element.damping is not None:
        return element.damping
    if element.damping_ratio is None:
        return np.zeros((6, 6))
    body = layout.body[element.body]
    moorings = linear_mooring.compile_elements(elements, layout)
    moored = moorings["stiffness"][moorings["body"] == body].sum(axis=0)
    axes = axes_at_rest(layout.heading[body])
    resonance = layout.resonance(body, np.diag(axes.T @ moored @ axes))
    for dof, ratio, stiffness in zip(DOFS, element.damping_ratio, resonance.stiffness, strict=True):
        if ratio and not stiffness > 0.0:
            raise InputError(
                f"forces.{name}.damping_ratio.{dof}: found a ratio where hydrostatics and linear"
                f" moorings of {element.body} have no stiffness, so that there is no critical"
                " damping. Add stiffness, or give damping instead; in roll and pitch, check the"
                " height of the centre of gravity."
            )
    critical = 2.0 * np.sqrt(np.maximum(resonance.stiffness, 0.0) * resonance.mass)
    return np.diag(element.damping_ratio * critical)


@root
def add_linear_damping(t, y, modes, motion, bodies, p, loads):
    """Add the force [N, N m] of every element to its row of ``wrench``, and the power [W] that it
    dissipates to ``rate``, in place."""
    for e in p:
        if bodies.exact:
            u = relative_velocity(e.body, e.stream, motion)
            loads.rate[e.row] += add_resistance(e.body, e.damping, u, motion, loads.wrench[e.row])
        else:
            loads.rate[e.row] += _add_resistance(e, motion.velocity, loads.wrench[e.row])


@kernel
def _add_resistance(e, v, wrench):
    """Add -C (v - U) to ``wrench`` (6 nb,) in the axes at rest; returns the power taken from the
    body."""
    k = 6 * e.body
    lost = 0.0
    C = e.damping
    U = e.stream
    f = product(C, v, k)
    for i in range(6):
        resistance = f[i] - C[i, 0] * U[0] - C[i, 1] * U[1]
        wrench[k + i] -= resistance
        lost += v[k + i] * resistance
    return lost


class LinearDampingKind(ElementKind):
    def resistances(self, p: np.ndarray) -> Iterator[LinearResistance]:
        """Damping of each element as a `LinearResistance`."""
        for e in p:
            yield LinearResistance(
                e["row"], e["body"], e["damping"], e["damping"][:, :2] @ e["stream"]
            )


LINEAR_DAMPING_KIND = LinearDampingKind(
    "linear_dampings", (LinearDamping,), compile_linear_dampings
)


QUADRATIC_DAMPING = np.dtype(
    [("body", int), ("row", int), ("damping", float, (6, 6)), ("stream", float, 2)]
)


def compile_quadratic_dampings(elements: Mapping[str, ForceElement], layout: Layout) -> np.ndarray:
    """Constants (ne,) of `QUADRATIC_DAMPING` of the quadratic dampings among ``elements``."""
    rows = [
        (layout.body[e.body], layout.row[name], e.damping, current_on(e.body, layout))
        for name, e in elements.items()
        if isinstance(e, QuadraticDamping)
    ]
    return np.array(rows, dtype=QUADRATIC_DAMPING)


@root
def add_quadratic_damping(t, y, modes, motion, bodies, p, loads):
    """Add the force [N, N m] of every element to its row of ``wrench``, and the power [W] that it
    dissipates to ``rate``, in place."""
    for e in p:
        u = relative_velocity(e.body, e.stream, motion)
        squares = (
            abs(u[0]) * u[0],
            abs(u[1]) * u[1],
            abs(u[2]) * u[2],
            abs(u[3]) * u[3],
            abs(u[4]) * u[4],
            abs(u[5]) * u[5],
        )
        loads.rate[e.row] += add_resistance(e.body, e.damping, squares, motion, loads.wrench[e.row])


QUADRATIC_DAMPING_KIND = ElementKind(
    "quadratic_dampings", (QuadraticDamping,), compile_quadratic_dampings
)
