"""Rope that creeps and breaks: slack, taut or broken.

    x = |a - p| - L0 - c,   T = k x while x > 0,   c' = T / eta

c: creep, a state; T is released for good when it reaches the load at which the rope breaks. What it
stores then is lost; creep loses T c'.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any, ClassVar, NamedTuple

import numpy as np

from hydrosim.elements.contact.geometry import EARTH
from hydrosim.elements.kind import (
    Columns,
    KindWithModeSets,
    Layout,
    ModeRows,
    ModeSet,
    StateBlocks,
    UnitRecord,
    Variable,
    rest_at_first,
)
from hydrosim.elements.pair import apply_tension, line_between
from hydrosim.jit.kernels import kernel, root
from hydrosim.modes import CONTACT_MARGIN, FRICTION_MARGIN, MARGINS, MODE
from hydrosim.multibody.vectors import scale, vector
from hydrosim.scene import ForceElement, Scene

SLACK, TAUT, BROKEN = range(3)
TENSION, CREEP, ROPE_OUTPUTS = range(3)
ROPE = np.dtype(
    [
        *(("body", int), ("row", int), ("point", float, 3), ("anchor", float, 3)),
        *(("length", float), ("k", float), ("eta", float), ("breaks_at", float)),
    ]
)


@dataclass(frozen=True)
class Rope(ForceElement):
    """From ``point`` of the body to ``anchor`` on the earth."""

    point: tuple[float, ...]
    anchor: tuple[float, ...]
    length: float
    stiffness: float
    creep: float = inf
    breaks_at: float = inf

    def restored_dofs(self) -> Collection[str]:
        return ("surge", "sway", "yaw")

    def unit_names(self, name: str) -> Sequence[str]:
        return [name]


class RopeConstants(NamedTuple):
    """``lines`` (n,) of `ROPE`; the first of their states, modes and integrals of losses."""

    lines: np.ndarray
    state: int
    mode: int
    losses: int


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout) -> RopeConstants:
    """Constants of the ropes among ``elements``."""
    rows = []
    for name, e in elements.items():
        if isinstance(e, Rope):
            ends = (layout.body[e.body], layout.row[name], e.point, e.anchor)
            rows.append((*ends, e.length, e.stiffness, e.creep, e.breaks_at))
    return RopeConstants(np.array(rows, dtype=ROPE), 0, 0, 0)


@kernel
def pull_of(i, y, modes, motion, bodies, p):
    """T of rope ``i`` if it were taut, and where its ends are."""
    line = p.lines[i]
    s = line_between(
        line.body, vector(line.point, 0), EARTH, vector(line.anchor, 0), bodies, motion
    )
    return line.k * (s.length - line.length - y[p.state + i]), s


@kernel
def add_force(t, y, modes, motion, bodies, p, loads):
    """Force of every rope, what creep loses, and the rates of creep."""
    for i in range(p.lines.size):
        line = p.lines[i]
        loads.dy[p.state + i] = 0.0
        if modes[p.mode + i, MODE] == TAUT:
            T, s = pull_of(i, y, modes, motion, bodies, p)
            loads.dy[p.state + i] = T / line.eta
            loads.rate[line.row] += T * T / line.eta
            force = scale(T, s.direction)
            apply_tension(line.body, EARTH, s.arm, s.other_arm, force, loads.wrench[line.row])


@kernel
def add_energy(t, y, modes, motion, bodies, p, stored):
    """T^2 / 2k of every rope that is taut."""
    for i in range(p.lines.size):
        if modes[p.mode + i, MODE] == TAUT:
            T, _ = pull_of(i, y, modes, motion, bodies, p)
            stored[p.lines[i].row] += 0.5 * T * T / p.lines[i].k


@kernel
def write_outputs(y, modes, motion, bodies, p, out):
    """Tension and creep of all ropes."""
    for i in range(p.lines.size):
        T, _ = pull_of(i, y, modes, motion, bodies, p)
        out[ROPE_OUTPUTS * i + TENSION] = T if modes[p.mode + i, MODE] == TAUT else 0.0
        out[ROPE_OUTPUTS * i + CREEP] = y[p.state + i]


@kernel
def find_margins(y, modes, motion, bodies, p, out):
    """Of a taut rope T, and what is left to the load at which it breaks; of a slack one -T."""
    for i in range(p.lines.size):
        m = MARGINS * (p.mode + i)
        for j in range(MARGINS):
            out[m + j] = 1.0
        T, _ = pull_of(i, y, modes, motion, bodies, p)
        if modes[p.mode + i, MODE] == TAUT:
            out[m + CONTACT_MARGIN] = T
            out[m + FRICTION_MARGIN] = p.lines[i].breaks_at - T
        elif modes[p.mode + i, MODE] == SLACK:
            out[m + CONTACT_MARGIN] = -T


@root
def transition(i, which, y, modes, motion, bodies, p):
    """Slack, taut, or broken for good."""
    mode = modes[p.mode + i]
    if which == FRICTION_MARGIN:
        T, _ = pull_of(i, y, modes, motion, bodies, p)
        y[p.losses + p.lines[i].row] += 0.5 * T * T / p.lines[i].k
        mode[MODE] = BROKEN
    else:
        mode[MODE] = SLACK if mode[MODE] == TAUT else TAUT


@root
def set_initial_modes(y, modes, motion, bodies, p):
    """Slack or taut at a start."""
    for i in range(p.lines.size):
        T, _ = pull_of(i, y, modes, motion, bodies, p)
        modes[p.mode + i, MODE] = TAUT if T > 0.0 else SLACK


class RopeKind(KindWithModeSets):
    unit = "rope"
    variables: ClassVar = {
        "rope_tension": Variable("tension", "N", "from the point to the anchor"),
        "rope_creep": Variable("creep", "m"),
        "rope_mode": Variable("slack, taut or broken", "1", flags="slack taut broken"),
    }

    def modes(self, p: RopeConstants) -> ModeRows:
        return ModeRows(p.lines.size)

    def states(self, p: RopeConstants, scene: Scene) -> Iterator[StateBlocks]:
        yield StateBlocks("rope", self.unit_names(scene), ("creep",))

    def coupled_states(self, p: RopeConstants) -> np.ndarray:
        return p.state + np.arange(p.lines.size)

    def mode_sets(self, p: RopeConstants) -> Sequence[ModeSet]:
        rest = np.zeros(p.lines.size, dtype=np.int64)
        every = [("slack", SLACK), ("taut", TAUT)] if p.lines.size else []
        return [ModeSet(f"ropes {text}", rest_at_first(rest, mode)) for text, mode in every]

    def record(self, p: RopeConstants, bodies: Any, kept: UnitRecord) -> Columns:
        each = ("time", "rope")
        return {
            "rope_tension": (each, kept.observed[:, :, TENSION]),
            "rope_creep": (each, kept.observed[:, :, CREEP]),
            "rope_mode": (each, kept.modes[:, :, MODE].astype(np.int8)),
        }


ROPE_KIND = RopeKind("ropes", (Rope,), compile_elements)
