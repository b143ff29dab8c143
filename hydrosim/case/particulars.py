"""Estimates for a barge from its main particulars, to begin a case with.

The hull counts as a box of the same beam, draught and displacement: its length is the block
coefficient times the length of the hull. Axes: x forward, y to port, z up.

    displacement  V = Cb L B T                    KB = T / 2
    BM = B^2 / (12 T),  BML = (Cb L)^2 / (12 T)   GM = KB + BM - KG
    heave k = rho g V / T,  roll k = rho g V GM,  pitch k = rho g V GML

Added mass, for the first estimate of periods alone. Beside the water line the hull and its image
are one body (J.N. Newman, Marine Hydrodynamics, 1977, section 4.13 and table 4.3):

    heave  half of a plate of the beam,  rho pi B^2 / 8 a metre
    roll   half of a turning plate,      rho pi B^4 / 256 a metre
    sway   half of a rectangle 2 T high and B wide, C rho pi T^2 / 2 a metre, C of DNV-RP-C205,
           table D-1
    pitch, yaw  those of heave and sway, by strips

Surge and all ratios of damping are about those of the two barges in ``hydro_db``, at their own
frequencies. Against these databases, added mass is 0.56 to 1.41 times that of panels, and natural
periods are off by a fifth at most.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, log, pi, sqrt

import numpy as np

from hydrosim.dofs import DOFS

SURGE = 0.08
"""Added mass in surge over the mass: 0.06 of H-851, 0.10 of the box of 100 x 20 x 5 m."""
DAMPING_RATIOS = {"heave": 0.14, "roll": 0.03, "pitch": 0.15}
"""Damping over the critical one. Radiation alone gives roll 0.01 to 0.03."""
RADII = 0.35, 0.25, 0.26
"""Radii of gyration: in roll over the beam, in pitch and yaw over the length; usual of barges."""
SIDES = 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0
"""Side across the flow over the side along it."""
RECTANGLE_ADDED_MASS = 2.23, 1.98, 1.70, 1.51, 1.36, 1.21, 1.14
"""Added mass of rectangles with these ``SIDES``, over that of a plate."""


@dataclass(frozen=True)
class Particulars:
    """Main particulars [m]; ``block`` is the block coefficient, ``kg`` the height of the centre of
    gravity above the keel. Density [kg/m^3] and gravity [m/s^2] are those of sea water."""

    length: float
    beam: float
    draught: float
    block: float
    kg: float
    density: float = 1025.0
    gravity: float = 9.81

    @property
    def mass(self) -> float:
        """Displaced mass [kg]."""
        return self.density * self.box_length * self.beam * self.draught

    @property
    def box_length(self) -> float:
        """Length of the box with this displacement [m]."""
        return self.block * self.length

    @property
    def radii(self) -> tuple[float, float, float]:
        """Radii of gyration in roll, pitch and yaw [m]. No moment of inertia is above the sum of
        the others, so a slender hull has that of pitch in yaw."""
        roll = RADII[0] * self.beam
        pitch = RADII[1] * self.length
        yaw = RADII[2] * self.length
        return roll, pitch, yaw if yaw < hypot(roll, pitch) else pitch

    @property
    def metacentric_height(self) -> float:
        """Transverse GM [m]."""
        return self._metacentric_height(self.beam)

    @property
    def longitudinal_metacentric_height(self) -> float:
        """Longitudinal GM [m]."""
        return self._metacentric_height(self.box_length)

    def _metacentric_height(self, side: float) -> float:
        return self.draught / 2 + side**2 / (12 * self.draught) - self.kg

    def stiffness(self) -> dict[str, float]:
        """Hydrostatic stiffness about the centre of gravity [N/m, N m/rad]."""
        weight = self.mass * self.gravity
        return {
            "heave": weight / self.draught,
            "roll": weight * self.metacentric_height,
            "pitch": weight * self.longitudinal_metacentric_height,
        }

    def inertia(self) -> dict[str, float]:
        """Mass and moments of inertia [kg, kg m^2] by direction."""
        turning = [self.mass * radius**2 for radius in self.radii]
        return dict(zip(DOFS, [self.mass] * 3 + turning, strict=True))

    def added_mass(self) -> dict[str, float]:
        """Estimates of added mass [kg, kg m^2] by direction."""
        heave = self.density * pi * self.beam**2 / 8
        roll = self.density * pi * self.beam**4 / 256
        sway = self._rectangle() * self.density * pi * self.draught**2 / 2
        strips = self.box_length**3 / 12
        return {
            "surge": SURGE * self.mass,
            "sway": sway * self.box_length,
            "heave": heave * self.box_length,
            "roll": roll * self.box_length,
            "pitch": heave * strips,
            "yaw": sway * strips,
        }

    def _rectangle(self) -> float:
        """Coefficient of a rectangle of twice the draught by the beam, in flow across."""
        sides = [log(side) for side in SIDES]
        return float(np.interp(log(2 * self.draught / self.beam), sides, RECTANGLE_ADDED_MASS))

    def damping(self) -> dict[str, float]:
        """Estimates of damping [N s/m, N m s/rad] of what has a stiffness."""
        stiffness, moving = self.stiffness(), self._moving()
        return {
            dof: 2 * ratio * sqrt(stiffness[dof] * moving[dof])
            for dof, ratio in DAMPING_RATIOS.items()
        }

    def periods(self) -> dict[str, float]:
        """Natural periods [s] in heave, roll and pitch, without moorings."""
        moving = self._moving()
        return {dof: 2 * pi * sqrt(moving[dof] / k) for dof, k in self.stiffness().items()}

    def _moving(self) -> dict[str, float]:
        """Inertia with added mass."""
        added = self.added_mass()
        return {dof: inertia + added[dof] for dof, inertia in self.inertia().items()}
