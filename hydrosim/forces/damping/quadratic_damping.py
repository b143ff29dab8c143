"""Quadratic damping of a body, in its own axes: drag and eddies, where flow separates.

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

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hydrosim.forces.kind import ElementKind
from hydrosim.forces.layout import Layout
from hydrosim.forces.relative import add_resistance, current_on, relative_velocity
from hydrosim.jit.kernels import root
from hydrosim.scene import ForceElement


@dataclass(frozen=True)
class QuadraticDamping(ForceElement):
    """``damping`` (6, 6) [N s^2/m^2 ... N m s^2/rad^2] about the centre of gravity."""

    damping: np.ndarray

    def supports_weight(self) -> bool:
        return False

    def dragging_streams(self) -> Collection[str]:
        return ("current",)

    def can_add_energy(self) -> bool:
        """A current drags the body along."""
        return True

    def couplings(self) -> Iterator[np.ndarray]:
        yield self.damping

    def mirrored_parts(self, y: float) -> Sequence[ForceElement]:
        return ()


QUADRATIC_DAMPING = np.dtype(
    [("body", int), ("row", int), ("damping", float, (6, 6)), ("stream", float, 2)]
)


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout) -> np.ndarray:
    """Constants (ne,) of `QUADRATIC_DAMPING` of the quadratic dampings among ``elements``."""
    rows = [
        (layout.body[e.body], layout.row[name], e.damping, current_on(e.body, layout))
        for name, e in elements.items()
        if isinstance(e, QuadraticDamping)
    ]
    return np.array(rows, dtype=QUADRATIC_DAMPING)


@root
def add_force(t, y, modes, motion, bodies, p, wrench, rate, dy):
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
        rate[e.row] += add_resistance(e.body, e.damping, squares, motion, wrench[e.row])


QUADRATIC_DAMPING_KIND = ElementKind("quadratic_dampings", (QuadraticDamping,), compile_elements)
