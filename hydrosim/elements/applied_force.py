"""Applied force: signals over time on a point of a body, earth-fixed or body-fixed.

    F = f(t)  or  R f(t),   M = m(t) + arm x F  (m turned as F is)

f, m: force and moment, a signal for each DOF that has one; arm: from the centre of gravity to the
point. Work is F v. A deballasting ramp is an earth-fixed force; fixed to the body it would push
sideways through pitch and roll.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, NamedTuple

import numpy as np

from hydrosim.dofs import DOFS, LATERAL, mirrored_vector
from hydrosim.elements.kind import ElementKind, Layout
from hydrosim.elements.signal import SIGNAL, compile_signals, value
from hydrosim.jit.kernels import kernel
from hydrosim.multibody.kinematics import add_wrench, attachment, point_velocity
from hydrosim.multibody.vectors import add, cross, dot, matvec, vector
from hydrosim.scene import ForceElement, Turns
from hydrosim.scene.signal import Signal, scale_signal


@dataclass(frozen=True)
class AppliedForce(ForceElement):
    """A given force and moment on a body. ``force`` has a signal over time [N, N m] for the name of
    each DOF; it acts at ``point`` [m] of the body frame. ``body_fixed``: its axes turn with the
    body."""

    supplies: ClassVar[bool] = True
    point: tuple[float, ...]
    force: Mapping[str, Signal]
    body_fixed: bool = False

    def signals(self) -> Iterator[tuple[str, Signal]]:
        yield from ((f"force.{dof}", signal) for dof, signal in self.force.items())

    def mirror_image(self) -> ForceElement:
        force = {
            dof: scale_signal(signal, -1.0) if dof in LATERAL else signal
            for dof, signal in self.force.items()
        }
        return replace(self, point=mirrored_vector(self.point), force=force)

    def nonlinearity(self, name: str, turns: Turns) -> str | None:
        moves = self.body_fixed or (turns.exact and any(self.point))
        return f"{name} turns with {self.body}" if turns.free and moves else None


APPLIED = np.dtype(
    [
        *(("body", int), ("row", int), ("point", float, 3), ("body_fixed", bool)),
        *(("first", int), ("last", int)),
    ]
)
FORCE_PART = np.dtype([("dof", int), ("signal", SIGNAL)])


class AppliedForceConstants(NamedTuple):
    """``each`` (ne,) of `APPLIED`; each acts along the ``parts`` (np,) of `FORCE_PART` with
    ``first`` <= i < ``last``; ``pieces`` belong to their signals."""

    each: np.ndarray
    parts: np.ndarray
    pieces: np.ndarray


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout) -> AppliedForceConstants:
    """Constants of the applied forces among ``elements``."""
    applied = {name: e for name, e in elements.items() if isinstance(e, AppliedForce)}
    rows = []
    last = 0
    for name, e in applied.items():
        first = last
        last = last + len(e.force)
        place = (layout.body[e.body], layout.row[name], e.point, e.body_fixed)
        rows.append((*place, first, last))
    parts = np.zeros(last, dtype=FORCE_PART)
    parts["dof"] = [DOFS.index(dof) for e in applied.values() for dof in e.force]
    signals = [signal for e in applied.values() for signal in e.force.values()]
    parts["signal"], pieces = compile_signals(signals)
    return AppliedForceConstants(np.array(rows, dtype=APPLIED), parts, pieces)


@kernel
def add_force(t, y, modes, motion, bodies, p, loads):
    """Add every applied force [N, N m] to its row of ``wrench``, and its power [W] to ``rate``, in
    place."""
    for e in p.each:
        b = e.body
        row = e.row
        force, moment = total_force(t, e.first, e.last, p)
        if e.body_fixed:
            force = matvec(motion.rotation[b], force)
            moment = matvec(motion.rotation[b], moment)
        _, arm = attachment(b, vector(e.point, 0), bodies, motion)
        add_wrench(b, force, add(moment, cross(arm, force)), loads.wrench[row])
        omega = vector(motion.velocity, 6 * b + 3)
        loads.rate[row] += dot(force, point_velocity(b, arm, motion)) + dot(moment, omega)


@kernel
def total_force(t, first, last, p):
    """Force and moment at ``t`` of the parts with ``first`` <= i < ``last``."""
    force = (0.0, 0.0, 0.0)
    moment = (0.0, 0.0, 0.0)
    for k in range(first, last):
        part = p.parts[k]
        f = value(t, part.signal, p.pieces)
        force = add(force, add_force_along_axis(part.dof, f))
        moment = add(moment, add_force_along_axis(part.dof - 3, f))
    return force, moment


@kernel
def add_force_along_axis(axis, size):
    """Vector of this size along an axis; zero if there is no such axis."""
    return (
        size if axis == 0 else 0.0,
        size if axis == 1 else 0.0,
        size if axis == 2 else 0.0,
    )


@kernel
def add_energy(t, y, modes, motion, bodies, p, stored):
    """An applied force stores nothing."""


APPLIED_FORCE_KIND = ElementKind("applied_forces", (AppliedForce,), compile_elements)
