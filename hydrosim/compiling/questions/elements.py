"""Questions about force elements: friction and damping."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hydrosim.compiling.questions.doubt import About, Doubt
from hydrosim.dofs import DOFS
from hydrosim.forces.contact.coulomb import Coulomb
from hydrosim.forces.contact.fender import Contact
from hydrosim.forces.contact.friction_slope import FrictionSlope
from hydrosim.forces.contact.stick_slip import StickSlip
from hydrosim.forces.linear_damping import LinearDamping
from hydrosim.forces.linear_mooring import LinearMooring

ROUGHEST = 1.0


def friction(about: About) -> Iterator[Doubt]:
    """Coefficients above 1."""
    for name, fender in about.scene.forces.items():
        law = fender.friction if isinstance(fender, Contact) else None
        largest = 0.0
        if isinstance(law, FrictionSlope):
            largest = law.coefficient
        elif isinstance(law, StickSlip | Coulomb):
            largest = law.static
        if largest > ROUGHEST:
            usual = "usual is 0.05 to 0.8: steel on steel 0.1 to 0.7, rubber up to 1"
            advice = "Is it a percentage?"
            yield Doubt(f"forces.{name}.friction", f"a coefficient of {largest:g}", usual, advice)


def damping(about: About) -> Iterator[Doubt]:
    """Damping ratios above critical."""
    for name, element in about.scene.forces.items():
        if not isinstance(element, LinearMooring | LinearDamping) or element.damping_ratio is None:
            continue
        for dof, ratio in zip(DOFS, np.asarray(element.damping_ratio), strict=True):
            if ratio > 1.0:
                usual = "usual is 0.01 to 0.3 of critical"
                advice = f'Is it a percentage? Then it is "{ratio:g} %".'
                yield Doubt(f"forces.{name}.damping_ratio.{dof}", f"{ratio:g}", usual, advice)
