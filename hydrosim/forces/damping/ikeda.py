"""Roll damping of a barge with sharp corners, after Ikeda.

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
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt

from hydrosim.errors import InputError

WATER_VISCOSITY = 1.19e-6  # m^2/s: kinematic viscosity of sea water at 15 deg C (ITTC 7.5-02-01-03)
SLENDEREST, FULLEST = 1.0, 8.0  # H0: beams of 2 to 16 draughts
MAX_AXIS_DEPTH, MIN_AXIS_DEPTH = 1.0, -4.0  # OG/d: from the bottom to four draughts above the water


@dataclass(frozen=True)
class SharpBarge:
    """Box with sharp corners: ``length``, ``beam``, ``draught`` [m], and the kinematic
    ``viscosity`` of the water [m^2/s]."""

    length: float
    beam: float
    draught: float
    viscosity: float = WATER_VISCOSITY

    def eddy_damping(self, density: float, depth: float) -> float:
        """Quadratic damping B2 [N m s^2/rad^2] with the centre of gravity at a ``depth`` [m]."""
        d = self.draught
        H0 = self.beam / (2.0 * d)
        lever = 1.0 - depth / d
        form = (H0**2 + lever) * (H0**2 + lever**2)
        return 0.75 * density * self.length * d**4 * form

    def friction_damping(self, density: float, depth: float, omega: float) -> float:
        """Linear damping B_F [N m s/rad] at a frequency ``omega`` [rad/s]."""
        girth = 1.7 * self.draught + self.beam
        arm = (1.032 * girth - 2.0 * depth) / pi
        return 0.787 * density * self.length * girth * arm**2 * sqrt(omega * self.viscosity)

    def check_form(self, key: str, depth: float) -> None:
        """Raises InputError if the form is far from that of a barge: H0 from 1 to 8, OG/d from -4
        to 1, a length of at least a beam."""
        H0 = self.beam / (2.0 * self.draught)
        if not SLENDEREST <= H0 <= FULLEST:
            raise InputError(
                f"{key}.beam: found {self.beam:g} m at a draught of {self.draught:g} m, a ratio of"
                f" {2.0 * H0:.3g}; expected {2.0 * SLENDEREST:g} to {2.0 * FULLEST:g}, the range of"
                " barges. Use p1, p2, p3 of a decay test."
            )
        if not MIN_AXIS_DEPTH <= depth / self.draught <= MAX_AXIS_DEPTH:
            raise InputError(
                f"{key}.draught: found {self.draught:g} m with the centre of gravity {-depth:g} m"
                f" above the water, {-depth / self.draught:.3g} draughts; expected"
                f" {-MAX_AXIS_DEPTH:g} to {-MIN_AXIS_DEPTH:g}. Use p1, p2, p3 of a decay test."
            )
        if self.length < self.beam:
            raise InputError(
                f"{key}.length: found {self.length:g} m and a beam of {self.beam:g} m; expected at"
                " least the beam, because the formula is that of a section. Is the beam the length?"
            )
