"""Force elements, one file each, and their sum.

A new element is one file with the functions of its neighbours (a frozen dataclass, `Params`,
`compile_elements`, `add_force`, and `add_energy` if it stores any) and two adjacent lines here: in
the catalogue, and its call in the sum (with the same index).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from hydrosim.forces import (
    applied_force,
    linear_damping,
    linear_mooring,
    quadratic_damping,
    spring,
    stream_load,
)
from hydrosim.forces.applied_force import AppliedForce
from hydrosim.forces.contact import fender, transitions
from hydrosim.forces.contact.coulomb import Coulomb
from hydrosim.forces.contact.fender import Fender, Plane
from hydrosim.forces.contact.friction_slope import FrictionSlope
from hydrosim.forces.contact.frictionless import Frictionless
from hydrosim.forces.contact.modes import COLUMNS
from hydrosim.forces.contact.normal import NormalCurve, PrescribedNormal
from hydrosim.forces.contact.stick_slip import LoadPowers, StickSlip
from hydrosim.forces.layout import Layout
from hydrosim.forces.linear_damping import LinearDamping
from hydrosim.forces.linear_mooring import LinearMooring
from hydrosim.forces.quadratic_damping import QuadraticDamping
from hydrosim.forces.signal import Harmonic, Recorded, Signal, Table, constant
from hydrosim.forces.spring import Spring
from hydrosim.forces.stream_load import CurrentLoad, StreamLoad, WindLoad
from hydrosim.jit.kernels import kernel, root
from hydrosim.scene import ForceElement

CATALOGUE = (
    linear_mooring,
    applied_force,
    fender,
    spring,
    linear_damping,
    quadratic_damping,
    stream_load,
)
FENDER, SPRING = CATALOGUE.index(fender), CATALOGUE.index(spring)
LINEAR_MOORING, LINEAR_DAMPING = CATALOGUE.index(linear_mooring), CATALOGUE.index(linear_damping)
APPLIED = CATALOGUE.index(applied_force)


@kernel
def add_elements(t, y, modes, motion, bodies, elements, wrench, rate, dy):
    """Forces of all elements, each into its row of ``wrench`` (rows, 6 nb); see the elements."""
    linear_mooring.add_force(t, y, modes, motion, bodies, elements[0], wrench, rate, dy)
    applied_force.add_force(t, y, modes, motion, bodies, elements[1], wrench, rate, dy)
    fender.add_force(t, y, modes, motion, bodies, elements[2], wrench, rate, dy)
    if elements[3].lines.size > 0:  # arguments alone would cost a few percent
        spring.add_force(t, y, modes, motion, bodies, elements[3], wrench, rate, dy)
    if elements[4].size > 0:
        linear_damping.add_force(t, y, modes, motion, bodies, elements[4], wrench, rate, dy)
    if elements[5].size > 0:
        quadratic_damping.add_force(t, y, modes, motion, bodies, elements[5], wrench, rate, dy)
    if elements[6].each.size > 0:
        stream_load.add_force(t, y, modes, motion, bodies, elements[6], wrench, rate, dy)


@kernel
def add_element_energies(t, y, modes, motion, bodies, elements, stored):
    """Stored energies of all elements that store any, each into its row of ``stored`` (rows,)."""
    linear_mooring.add_energy(t, y, modes, motion, bodies, elements[0], stored)
    applied_force.add_energy(t, y, modes, motion, bodies, elements[1], stored)
    fender.add_energy(t, y, modes, motion, bodies, elements[2], stored)
    spring.add_energy(t, y, modes, motion, bodies, elements[3], stored)


def signals_of(elements: Mapping[str, ForceElement]) -> Iterator[tuple[str, Signal]]:
    """All signals over time among ``elements``, each with the key of a case file where it is."""
    for name, e in elements.items():
        if isinstance(e, AppliedForce):
            yield from ((f"forces.{name}.force.{dof}", signal) for dof, signal in e.force.items())
        elif isinstance(e, Fender) and isinstance(e.normal, PrescribedNormal):
            yield f"forces.{name}.normal.prescribed", e.normal.force


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout) -> tuple[Any, ...]:
    """Constants of all elements, one `Params` per kind in the order of the catalogue."""
    return tuple(kind.compile_elements(elements, layout) for kind in CATALOGUE)


def without_friction(elements: tuple[Any, ...]) -> tuple[Any, ...]:
    """The same elements with contacts that slip freely."""
    return (*elements[:FENDER], fender.without_friction(elements[FENDER]), *elements[FENDER + 1 :])


def new_modes(elements: tuple[Any, ...]) -> np.ndarray:
    """Modes (nf + ns, 3) of all contact points and springs, for `settle`."""
    rows = elements[FENDER].points.size + elements[SPRING].lines.size
    return np.zeros((rows, COLUMNS), dtype=np.int64)


@root
def settle(t, y, modes, motion, bodies, elements):
    """Fill ``modes`` for a start from ``y``."""
    transitions.settle(t, y, modes, motion, bodies, elements[FENDER])
    spring.settle(modes, motion, bodies, elements[SPRING])
