"""Viscous roll damping of bodies: from decay tests, or of sharp barges after Ikeda.

Roll damping of a barge with sharp corners, after Ikeda.

Eddies at the corners (Ikeda, Fujiwara and Katayama 1993, ISOPE; in ITTC 7.5-02-07-04.5) take, at a
roll amplitude R0 and frequency w, the equivalent linear damping

    B_E = (2/pi) rho L d^4 (H0^2 + 1 - OG/d) (H0^2 + (1 - OG/d)^2) R0 w,   H0 = B / (2 d).

L, B, d: length, beam, draught; OG: depth of the centre of gravity below the water, negative above
it. The quadratic damping B2 = 3 pi B_E / (8 w R0) takes the same energy per cycle.

Friction in a laminar boundary layer (Kato 1957; Ikeda, Himeno and Tanaka 1978), for a block
coefficient of 1, is linear:

    B_F = 0.787 rho S r^2 sqrt(w nu),   S = L (1.7 d + B),   r = (1.032 S / L - 2 OG) / pi.

Limits: a box with sharp corners all along L, no bilge keels, no skegs, no speed. Corners of a
radius shed weaker eddies. Ends are not corrected for. In a turbulent layer friction is larger, but
then it is a small part of all damping. `check_form` has the range of forms.

Viscous roll damping of a body, from a decay test or by Ikeda's formula.

    M = -(B1 p + B2 |p| p + B3 p^3) e,   p = e . omega

e: longitudinal axis of the body through its centre of gravity; omega: angular velocity; p: roll
rate. With small angles, e is the x axis at rest.

A decay test gives p1, p2, p3 of its equation of motion (Himeno 1981, eq. 2.4; ITTC 7.5-02-07-04.5,
section 3)

    phi'' + p1 phi' + p2 |phi'| phi' + p3 phi'^3 + w_n^2 phi = 0.

The body rolls in a natural mode with an inertia m and a damping b by radiated waves, per unit of
roll (`compile.roll_mode`): I44 + A44 and B44 at w_n, but for the slope of the added mass, if
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

from collections.abc import Iterator, Mapping
from math import pi, sqrt

import numpy as np

from hydrosim.elements import kind, linear_mooring
from hydrosim.errors import InputError
from hydrosim.jit.kernels import kernel, root
from hydrosim.scene import ForceElement
from hydrosim.scene.damping import ROLL_DOF, SharpBarge, ViscousRoll

WATER_VISCOSITY = 1.19e-6  # m^2/s: kinematic viscosity of sea water at 15 deg C (ITTC 7.5-02-01-03)
SLENDEREST, FULLEST = 1.0, 8.0  # H0: beams of 2 to 16 draughts
MAX_AXIS_DEPTH, MIN_AXIS_DEPTH = 1.0, -4.0  # OG/d: from the bottom to four draughts above the water


def eddy_damping(barge: SharpBarge, density: float, depth: float) -> float:
    """Quadratic damping B2 [N m s^2/rad^2] with the centre of gravity at a ``depth`` [m]."""
    d = barge.draught
    H0 = barge.beam / (2.0 * d)
    lever = 1.0 - depth / d
    form = (H0**2 + lever) * (H0**2 + lever**2)
    return 0.75 * density * barge.length * d**4 * form


def friction_damping(barge: SharpBarge, density: float, depth: float, omega: float) -> float:
    """Linear damping B_F [N m s/rad] at a frequency ``omega`` [rad/s]."""
    girth = 1.7 * barge.draught + barge.beam
    arm = (1.032 * girth - 2.0 * depth) / pi
    viscosity = barge.viscosity or WATER_VISCOSITY
    return 0.787 * density * barge.length * girth * arm**2 * sqrt(omega * viscosity)


def check_form(barge: SharpBarge, key: str, depth: float) -> None:
    """Raises InputError if the form is far from that of a barge: H0 from 1 to 8, OG/d from -4
    to 1, a length of at least a beam."""
    H0 = barge.beam / (2.0 * barge.draught)
    if not SLENDEREST <= H0 <= FULLEST:
        raise InputError(
            f"{key}.beam: found {barge.beam:g} m at a draught of {barge.draught:g} m, a ratio of"
            f" {2.0 * H0:.3g}; expected {2.0 * SLENDEREST:g} to {2.0 * FULLEST:g}, the range of"
            " barges. Use p1, p2, p3 of a decay test."
        )
    if not MIN_AXIS_DEPTH <= depth / barge.draught <= MAX_AXIS_DEPTH:
        raise InputError(
            f"{key}.draught: found {barge.draught:g} m with the centre of gravity {-depth:g} m"
            f" above the water, {-depth / barge.draught:.3g} draughts; expected"
            f" {-MAX_AXIS_DEPTH:g} to {-MIN_AXIS_DEPTH:g}. Use p1, p2, p3 of a decay test."
        )
    if barge.length < barge.beam:
        raise InputError(
            f"{key}.length: found {barge.length:g} m and a beam of {barge.beam:g} m; expected at"
            " least the beam, because the formula is that of a section. Is the beam the length?"
        )


EDDIES = 8.0 / (3.0 * pi)  # of B2 |p| p, per largest rate, in equivalent linear damping
GAUSSIAN = sqrt(8.0 / pi)  # E|p|^3 / (sigma E p^2) of a Gaussian rate p


ROLLING = np.dtype(
    [
        *(("body", int), ("row", int), ("linear", float), ("quadratic", float), ("cubic", float)),
        *(("measured", float), ("waves", float), ("mass", float), ("frequency", float)),
    ]
)
"""Constants of an element: B1, B2, B3; the ``measured`` damping p1 m, its part by radiated
``waves`` b, and m [kg m^2] at the natural ``frequency`` [rad/s]."""


def compile_elements(elements: Mapping[str, ForceElement], layout: kind.Layout) -> np.ndarray:
    """Constants (ne,) of `ROLLING` of the roll dampings among ``elements``."""
    moorings = linear_mooring.compile_elements(elements, layout)
    rows = []
    for name, e in elements.items():
        if isinstance(e, ViscousRoll):
            body = layout.body[e.body]
            moored = moorings["stiffness"][moorings["body"] == body].sum(axis=0)
            axes = kind.axes_at_rest(layout.heading[body])
            mode = layout.roll_mode(body, axes.T @ moored @ axes)
            rows.append((body, layout.row[name], *_roll_damping(name, e, mode, layout)))
    return np.array(rows, dtype=ROLLING)


def _roll_damping(
    name: str, element: ViscousRoll, mode: kind.RollMode, layout: kind.Layout
) -> tuple[float, ...]:
    """Fields of `ROLLING` after body and row."""
    measured = (element.p1 or 0.0) * mode.mass
    waves = 0.0 if element.includes_waves is False else mode.damping
    linear = (element.linear or 0.0) + max(measured - waves, 0.0)
    quadratic = (element.quadratic or 0.0) + (element.p2 or 0.0) * mode.mass
    cubic = (element.cubic or 0.0) + (element.p3 or 0.0) * mode.mass
    barge = element.ikeda
    if barge is not None:
        depth = -float(layout.origin[layout.body[element.body]][2])
        density = layout.water_density
        check_form(barge, f"forces.{name}.ikeda", depth)
        linear += friction_damping(barge, density, depth, mode.frequency)
        quadratic += eddy_damping(barge, density, depth)
    return linear, quadratic, cubic, measured, waves, mode.mass, mode.frequency


def linearise_damping(p: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """The same elements, linear: with the damping that takes the same mean power of Gaussian roll
    rates of these standard ``deviation`` (ne,) [rad/s].

    B = B1 + sqrt(8/pi) s B2 + 3 s^2 B3 (Borgman 1969; Himeno 1981, section 2.4).
    """
    linear = p.copy()
    linear["linear"] += GAUSSIAN * deviation * p["quadratic"] + 3.0 * deviation**2 * p["cubic"]
    linear["quadratic"] = 0.0
    linear["cubic"] = 0.0
    return linear


@root
def add_force(t, y, modes, motion, bodies, p, loads):
    """Add the moment [N m] of every element to its row of ``wrench``, and the power [W] that it
    dissipates to ``rate``, in place."""
    for e in p:
        loads.rate[e.row] += _resist_roll(e, motion, bodies, loads.wrench[e.row])


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


class ViscousRollKind(kind.ElementKind):
    def resistances(self, p: np.ndarray) -> Iterator[kind.LinearResistance]:
        """Linear damping of each element as a `LinearResistance`."""
        for e in p:
            damping = np.zeros((6, 6))
            damping[ROLL_DOF, ROLL_DOF] = e["linear"]
            yield kind.LinearResistance(e["row"], e["body"], damping, np.zeros(6))


VISCOUS_ROLL_KIND = ViscousRollKind("viscous_rolls", (ViscousRoll,), compile_elements)
