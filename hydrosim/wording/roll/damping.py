"""What roll dampings of a scene amount to."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi, radians
from typing import TYPE_CHECKING

from hydrosim.forces.damping.viscous_roll import EDDIES, VISCOUS_ROLL_KIND, ViscousRoll

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled

AMPLITUDE_DEG = 5.0  # deg


def describe_roll_damping(compiled: Compiled) -> Iterator[str]:
    """A line for each roll damping: its coefficients, the damping by waves that is taken off, and
    the damping ratio without waves at an amplitude of 5 deg."""
    elements = [(n, e) for n, e in compiled.scene.forces.items() if isinstance(e, ViscousRoll)]
    rolling = VISCOUS_ROLL_KIND.constants_in(compiled.model)
    for (name, element), found in zip(elements, rolling, strict=True):
        B1, B2, B3, mass, omega = (
            float(found[x]) for x in ("linear", "quadratic", "cubic", "mass", "frequency")
        )
        parts = [f"{name}: B1 {B1:.4g}, B2 {B2:.4g}, B3 {B3:.4g} N m s^n/rad^n"]
        if element.p1 or element.p2 or element.p3:
            waves = float(found["waves"])
            off = f"less {waves:.4g} by waves" if element.includes_waves else "waves not taken off"
            parts.append(f"p1 is {float(found['measured']):.4g} N m s/rad in all, {off}")
        if omega > 0.0:
            rate = omega * radians(AMPLITUDE_DEG)
            damping = B1 + EDDIES * B2 * rate + 0.75 * B3 * rate**2
            ratio = 50.0 * damping / (mass * omega)
            parts.append(
                f"{ratio:.3g} % of critical besides waves at {AMPLITUDE_DEG:g} deg and"
                f" {2.0 * pi / omega:.4g} s"
            )
        yield "; ".join(parts)
