"""Viscous roll damping of a body, from a decay test or by Ikeda's formula.

    M = -(B1 p + B2 |p| p + B3 p^3) e,   p = e . omega

e: longitudinal axis of the body through its centre of gravity; omega: angular velocity; p: roll
rate. With small angles, e is the x axis at rest.

A decay test gives p1, p2, p3 of its equation of motion (Himeno 1981, eq. 2.4; ITTC 7.5-02-07-04.5,
section 3)

    phi'' + p1 phi' + p2 |phi'| phi' + p3 phi'^3 + w_n^2 phi = 0.

The body rolls in a natural mode with an inertia m and a damping b by radiated waves, per unit of
roll (`compiling.roll_mode`): I44 + A44 and B44 at w_n, but for the slope of the added mass, if
nothing couples to roll. Then

    B1 = p1 m - b,   B2 = p2 m,   B3 = p3 m.

The measured p1 includes the damping b by radiated waves, which the database has already. Taking it
off keeps the total as measured. `includes_waves` false means that p1 has no such part: B1 = p1 m.
B1 is never below zero, because an element that drives the body could make it unstable; the total is
then larger than measured, and a question says so.

Booked as dissipation, B1 p^2 + B2 |p|^3 + B3 p^4. Limits: |p| p has a jump in its second derivative
where the roll turns, so methods of order above 3 lose it there, by the size of B2; no memory of the
flow; no forward speed; p_k are constants within the amplitudes of the test.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import pi, sqrt

import numpy as np

from hydrosim.errors import InputError
from hydrosim.forces import linear_mooring
from hydrosim.forces.damping.ikeda import SharpBarge
from hydrosim.forces.kind import ElementKind
from hydrosim.forces.layout import Layout, LinearResistance, RollMode, axes_at_rest
from hydrosim.jit.kernels import kernel, root
from hydrosim.scene import ForceElement, Turns

ROLL_DOF = 3
EDDIES = 8.0 / (3.0 * pi)  # of B2 |p| p, per largest rate, in equivalent linear damping
GAUSSIAN = sqrt(8.0 / pi)  # E|p|^3 / (sigma E p^2) of a Gaussian rate p


@dataclass(frozen=True)
class ViscousRoll(ForceElement):
    """Coefficients ``p1`` [1/s], ``p2`` [1/rad], ``p3`` [s/rad^2] of a decay test, or ``linear``
    [N m s/rad], ``quadratic`` [N m s^2/rad^2], ``cubic`` [N m s^3/rad^3], or the form of a
    ``barge``; all add up. ``period`` [s] is the natural period of the test, for comparison."""

    p1: float = 0.0
    p2: float = 0.0
    p3: float = 0.0
    linear: float = 0.0
    quadratic: float = 0.0
    cubic: float = 0.0
    includes_waves: bool = True
    period: float | None = None
    barge: SharpBarge | None = None

    def check(self, name: str) -> None:
        for key in ("p1", "p2", "p3", "linear", "quadratic", "cubic"):
            value = getattr(self, key)
            if not value >= 0.0:
                raise InputError(
                    f"forces.{name}.{key}: found {value:g}; expected 0 or more, because negative"
                    " damping drives the roll."
                )

    def supports_weight(self) -> bool:
        return False

    def couplings(self) -> Iterator[np.ndarray]:
        """Roll damping by itself couples nothing."""
        yield from ()

    def mirrored_parts(self, y: float) -> Sequence[ForceElement]:
        return ()

    def nonlinearity(self, name: str, turns: Turns) -> str | None:
        """Only damping in proportion to the rate is linear, about an axis that does not turn."""
        if self.p2 or self.p3 or self.quadratic or self.cubic or self.barge:
            return name
        changes = turns.exact and any(angle != ROLL_DOF for angle in turns.free)
        return f"{name} turns with {self.body}" if changes else None


ROLLING = np.dtype(
    [
        *(("body", int), ("row", int), ("linear", float), ("quadratic", float), ("cubic", float)),
        *(("measured", float), ("waves", float), ("mass", float), ("frequency", float)),
    ]
)
"""Constants of an element: B1, B2, B3; the ``measured`` damping p1 m, its part by radiated
``waves`` b, and m [kg m^2] at the natural ``frequency`` [rad/s]."""


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout) -> np.ndarray:
    """Constants (ne,) of `ROLLING` of the roll dampings among ``elements``."""
    moorings = linear_mooring.compile_elements(elements, layout)
    rows = []
    for name, e in elements.items():
        if isinstance(e, ViscousRoll):
            body = layout.body[e.body]
            moored = moorings["stiffness"][moorings["body"] == body].sum(axis=0)
            axes = axes_at_rest(layout.heading[body])
            mode = layout.roll_mode(body, axes.T @ moored @ axes)
            rows.append((body, layout.row[name], *_damping(name, e, mode, layout)))
    return np.array(rows, dtype=ROLLING)


def _damping(name: str, element: ViscousRoll, mode: RollMode, layout: Layout) -> tuple[float, ...]:
    """Fields of `ROLLING` after body and row."""
    measured = element.p1 * mode.mass
    waves = mode.damping if element.includes_waves else 0.0
    linear = element.linear + max(measured - waves, 0.0)
    quadratic = element.quadratic + element.p2 * mode.mass
    cubic = element.cubic + element.p3 * mode.mass
    if element.barge is not None:
        depth = -float(layout.origin[layout.body[element.body]][2])
        density = layout.water_density
        element.barge.check_form(f"forces.{name}.ikeda", depth)
        linear += element.barge.friction_damping(density, depth, mode.frequency)
        quadratic += element.barge.eddy_damping(density, depth)
    return linear, quadratic, cubic, measured, waves, mode.mass, mode.frequency


def linearise_damping(p: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """The same elements, linear: with the damping that takes the same mean power of Gaussian roll
    rates of these standard ``deviation`` (ne,) [rad/s].

    B = B1 + sqrt(8/pi) s B2 + 3 s^2 B3 (Borgman 1969; Himeno 1981, section 2.4).
    """
    found = p.copy()
    found["linear"] += GAUSSIAN * deviation * p["quadratic"] + 3.0 * deviation**2 * p["cubic"]
    found["quadratic"] = 0.0
    found["cubic"] = 0.0
    return found


@root
def add_force(t, y, modes, motion, bodies, p, wrench, rate, dy):
    """Add the moment [N m] of every element to its row of ``wrench``, and the power [W] that it
    dissipates to ``rate``, in place."""
    for e in p:
        rate[e.row] += _resist_roll(e, motion, bodies, wrench[e.row])


@kernel
def _resist_roll(e, motion, bodies, wrench):
    """Add the moment to ``wrench`` (6 nb,); returns the power taken from the body."""
    k = 6 * e.body + 3
    R = motion.rotation[e.body]
    axis = (R[0, 0], R[1, 0], R[2, 0]) if bodies.exact else (1.0, 0.0, 0.0)
    omega = motion.velocity
    p = axis[0] * omega[k] + axis[1] * omega[k + 1] + axis[2] * omega[k + 2]
    moment = (e.linear + e.quadratic * abs(p) + e.cubic * p * p) * p
    for i in range(3):
        wrench[k + i] -= moment * axis[i]
    return moment * p


class ViscousRollKind(ElementKind):
    def resistances(self, p: np.ndarray) -> Iterator[LinearResistance]:
        """Linear damping of each element as a `LinearResistance`."""
        for e in p:
            damping = np.zeros((6, 6))
            damping[ROLL_DOF, ROLL_DOF] = e["linear"]
            yield LinearResistance(e["row"], e["body"], damping, np.zeros(6))


VISCOUS_ROLL_KIND = ViscousRollKind("viscous_rolls", (ViscousRoll,), compile_elements)
