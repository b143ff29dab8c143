"""Force elements, one file each, and their sum.

An element is one file with

    a frozen dataclass            of `scene.ForceElement`, which says what it can do: its parts and
                                  their mirror images, its signals, whether it is linear
    compile_elements              all of them in a scene as constants, `Params` or an array
    add_force                     into its row of forces, and its work or dissipation
    add_energy                    if it stores any

and in `CATALOGUE` and the sums below one line each. A kind whose units have modes, which end at
events, says so with ``units``, and stands in `hydrosim.forces.events`; one that has states in y
says how many with ``state_count``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from hydrosim.forces import (
    applied_force,
    linear_damping,
    linear_mooring,
    quadratic_damping,
    spring,
    stream_load,
    trigger,
)
from hydrosim.forces.applied_force import AppliedForce
from hydrosim.forces.ballast import flows, tanks
from hydrosim.forces.contact import fender, guide
from hydrosim.forces.contact.coulomb import Coulomb
from hydrosim.forces.contact.fender import Contact, Fender, Normal
from hydrosim.forces.contact.friction_slope import FrictionSlope
from hydrosim.forces.contact.frictionless import Frictionless
from hydrosim.forces.contact.guide import Wall
from hydrosim.forces.contact.landing import Landing
from hydrosim.forces.contact.normal import NormalCurve, NormalLoop, PrescribedNormal
from hydrosim.forces.contact.plane import Plane
from hydrosim.forces.contact.stick_slip import LoadPowers, StickSlip
from hydrosim.forces.layout import Layout
from hydrosim.forces.linear_damping import LinearDamping
from hydrosim.forces.linear_mooring import LinearMooring
from hydrosim.forces.modes import COLUMNS
from hydrosim.forces.quadratic_damping import QuadraticDamping
from hydrosim.forces.signal import Harmonic, Recorded, Signal, Table, constant
from hydrosim.forces.spring import Spring
from hydrosim.forces.stream_load import CurrentLoad, StreamLoad, WindLoad
from hydrosim.jit.kernels import clear, kernel
from hydrosim.scene import ForceElement


class Elements(NamedTuple):
    """Constants of all elements of a scene, kind by kind."""

    linear_moorings: Any
    applied_forces: Any
    fenders: Any
    springs: Any
    linear_dampings: Any
    quadratic_dampings: Any
    stream_loads: Any
    tanks: Any
    guides: Any
    triggers: Any


CATALOGUE = Elements(
    linear_moorings=linear_mooring,
    applied_forces=applied_force,
    fenders=fender,
    springs=spring,
    linear_dampings=linear_damping,
    quadratic_dampings=quadratic_damping,
    stream_loads=stream_load,
    tanks=tanks,
    guides=guide,
    triggers=trigger,
)
"""The files of all kinds."""


@kernel
def add_elements(t, y, modes, motion, bodies, elements, wrench, rate, dy):
    """Forces of all elements, each into its row of ``wrench`` (rows, 6 nb); see the elements."""
    e = elements
    linear_mooring.add_force(t, y, modes, motion, bodies, e.linear_moorings, wrench, rate, dy)
    applied_force.add_force(t, y, modes, motion, bodies, e.applied_forces, wrench, rate, dy)
    fender.add_force(t, y, modes, motion, bodies, e.fenders, wrench, rate, dy)
    if e.springs.lines.size > 0:  # arguments alone would cost a few percent
        spring.add_force(t, y, modes, motion, bodies, e.springs, wrench, rate, dy)
    if e.linear_dampings.size > 0:
        linear_damping.add_force(t, y, modes, motion, bodies, e.linear_dampings, wrench, rate, dy)
    if e.quadratic_dampings.size > 0:
        quadratic_damping.add_force(
            t, y, modes, motion, bodies, e.quadratic_dampings, wrench, rate, dy
        )
    if e.stream_loads.each.size > 0:
        stream_load.add_force(t, y, modes, motion, bodies, e.stream_loads, wrench, rate, dy)
    if e.tanks.each.size > 0:
        flows.add_force(t, y, modes, motion, bodies, e.tanks, wrench, rate, dy)
    if e.guides.pins.size > 0:
        guide.add_force(t, y, modes, motion, bodies, e, wrench)
    if e.triggers.each.size > 0:
        trigger.silence(modes, e.triggers, wrench, rate)
        clear(dy[e.triggers.state : e.triggers.state + e.triggers.each.size])


@kernel
def add_element_energies(t, y, modes, motion, bodies, elements, stored):
    """Stored energies of all elements that store any, each into its row of ``stored`` (rows,)."""
    e = elements
    linear_mooring.add_energy(t, y, modes, motion, bodies, e.linear_moorings, stored)
    fender.add_energy(t, y, modes, motion, bodies, e.fenders, stored)
    spring.add_energy(t, y, modes, motion, bodies, e.springs, stored)
    if e.guides.pins.size > 0:
        guide.add_energy(modes, motion, bodies, e, stored)
    if e.triggers.each.size > 0:
        trigger.forget_stored(modes, e.triggers, stored)


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout, state: int) -> Elements:
    """Constants of all ``elements``; their states in y begin at ``state``."""
    each = Elements(*(kind.compile_elements(elements, layout) for kind in CATALOGUE))
    return placed(each, state)


def placed(elements: Elements, state: int) -> Elements:
    """The same with states in y from ``state`` on, kind by kind, and rows of modes alike."""
    found, mode = [], 0
    for kind, p in zip(CATALOGUE, elements, strict=True):
        count = len(kind.units(p)) if hasattr(kind, "units") else 0
        own = {"mode": mode} if hasattr(kind, "units") else {}
        if hasattr(kind, "state_count"):
            own["state"] = state
            state += _states(kind, p)
        found.append(p._replace(**own) if own else p)
        mode += count
    return Elements(*found)


def state_count(elements: Elements) -> int:
    """Number of states in y of all elements."""
    pairs = zip(CATALOGUE, elements, strict=True)
    return sum(_states(kind, p) for kind, p in pairs if hasattr(kind, "STATE_NAMES"))


def _states(kind: Any, p: Any) -> int:
    """Number of states of a kind: as many for each of its units, or what it says."""
    own = getattr(kind, "state_count", None)
    return int(own(p)) if own else len(kind.STATE_NAMES) * len(kind.units(p))


def dynamic_states(elements: Elements) -> np.ndarray:
    """Entries (m,) of y that are states of elements and act on others."""
    pairs = zip(CATALOGUE, elements, strict=True)
    each = [kind.dynamic_states(p) for kind, p in pairs if hasattr(kind, "dynamic_states")]
    return np.concatenate([np.zeros(0, np.int64), *each]).astype(np.int64)


def new_modes(elements: Elements) -> np.ndarray:
    """Modes (rows, 3) of the units of all elements, for `events.settle`."""
    pairs = zip(CATALOGUE, elements, strict=True)
    rows = sum(len(kind.units(p)) for kind, p in pairs if hasattr(kind, "units"))
    return np.zeros((rows, COLUMNS), dtype=np.int64)


def is_known(element: ForceElement) -> bool:
    """Whether a kind of the catalogue has this element."""
    homes = (vars(kind).values() for kind in CATALOGUE)
    classes = {x for home in homes for x in home if isinstance(x, type)} - {ForceElement}
    return any(issubclass(x, ForceElement) and isinstance(element, x) for x in classes)


def own_modes(kind: Any, p: Any, modes: np.ndarray) -> np.ndarray:
    """The rows of ``modes`` (..., rows, 3) of one kind with the constants ``p``."""
    return modes[..., p.mode : p.mode + len(kind.units(p)), :]


def without_friction(elements: Elements) -> Elements:
    """The same elements with contacts that slip freely."""
    return elements._replace(fenders=fender.without_friction(elements.fenders))


def signals_of(elements: Mapping[str, ForceElement]) -> Iterator[tuple[str, Signal]]:
    """All signals over time among ``elements``, each with the key of a case file where it is."""
    for name, element in elements.items():
        yield from ((f"forces.{name}.{key}", signal) for key, signal in element.signals())
