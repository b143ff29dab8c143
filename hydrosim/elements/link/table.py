"""The links of a scene in one table: forces, energies, events and records, whatever their law.

A link has a coordinate (`hydrosim.elements.link.coordinate`) and a law of the load along it
(`hydrosim.elements.link.laws`). Its row of modes holds whether it acts, the piece of its law that
it is on, and the half turns of a twist.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import nan

import numpy as np

from hydrosim.elements.contact import curves
from hydrosim.elements.kind import Layout
from hydrosim.elements.link import laws
from hydrosim.elements.link.coordinate import (
    HALF_TURNS,
    add_load,
    coordinate_fields,
    find_kinematics,
    leaves_half_turn,
)
from hydrosim.elements.link.law import (
    LINK,
    LINK_OUTPUTS,
    LOAD_OUTPUT,
    OFFSET_OUTPUT,
    PLACE_OUTPUT,
    POWER_OUTPUT,
)
from hydrosim.elements.link.laws import LAWS, TENSION, LinkConstants
from hydrosim.elements.signal import compile_signals
from hydrosim.errors import InputError
from hydrosim.jit.kernels import clear, kernel, root
from hydrosim.modes import MARGINS, MODE, NO_INDEX, RISING_MARGIN, SEGMENT, UNDEFINED
from hydrosim.scene import ForceElement
from hydrosim.scene.links import Compensator, Link, Spring

SPRINGS, COMPENSATORS, OTHERS = range(3)
"""Families of links, each with a kind of its own."""


def order_links(elements: Mapping[str, ForceElement]) -> dict[str, Link]:
    """The links among ``elements`` by name, in their order in the table: springs, compensators,
    others."""
    links = {name: e for name, e in elements.items() if isinstance(e, Link)}
    return dict(sorted(links.items(), key=lambda named: _family(named[1])))


def _family(link: Link) -> int:
    if isinstance(link, Spring):
        return SPRINGS
    return COMPENSATORS if isinstance(link, Compensator) else OTHERS


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout) -> LinkConstants:
    """Constants of the links among ``elements``. Raises InputError for a coordinate that is not
    there."""
    links = order_links(elements)
    signals, pieces = compile_signals([s for e in links.values() for _, s in e.signals()])
    compiled_signals = iter(signals)
    table = np.zeros(len(links), dtype=LINK)
    segments = [np.zeros(0, dtype=curves.SEGMENT)]
    constants: dict[np.dtype, list[np.void]] = {dtype: [] for dtype in laws.CONSTANTS.values()}
    state = 0
    first = 0
    for link, (name, e) in zip(table, links.items(), strict=True):
        law, declared = LAWS[type(e)]
        curve = declared.curve(e)
        try:
            coordinate = coordinate_fields(e, layout)
        except InputError as error:
            raise InputError(f"forces.{name}.{error}") from None
        for field, value in {**coordinate, **declared.law_fields(e, curve)}.items():
            link[field] = value
        if link["varies"]:
            link["signal"] = next(compiled_signals)
        link["element"], link["law"] = [*LAWS].index(type(e)), law
        link["row"], link["inactive"] = layout.row[name], declared.inactive_mode
        link["family"], link["pulls_only"] = _family(e), declared.pulls_only
        link["state"], link["states"] = state, len(declared.state_names)
        state += len(declared.state_names)
        law_constants = declared.constants(e)
        link["constants"] = NO_INDEX
        if law_constants.size:
            link["constants"] = len(constants[law_constants.dtype])
            constants[law_constants.dtype].extend(law_constants)
        if curve.size:
            for field in ("first", "last", "idle", "stiff"):
                link[field] += first
        segments.append(curve)
        first += curve.size
    by_law = {
        field: np.array(constants[dtype], dtype=dtype) for field, dtype in laws.CONSTANTS.items()
    }
    return LinkConstants(
        table, np.concatenate(segments), pieces, **by_law, state=0, mode=0, losses=0
    )


def output_shapes(p: LinkConstants) -> dict[str, tuple[int, int]]:
    """Shapes of the output of `write_outputs`, by the unit of kinds, in their order."""
    first = np.searchsorted(p.links["family"], [SPRINGS, COMPENSATORS, OTHERS, OTHERS + 1])
    springs, compensators, others = np.diff(first).tolist()
    return {
        "spring": (springs, LINK_OUTPUTS),
        "compensator": (compensators, LINK_OUTPUTS),
        "link": (others, LINK_OUTPUTS),
    }


@root
def add_force(t, y, modes, motion, bodies, p, loads):
    """Add the force [N, N m] of every link to its row of ``wrench``, and the power [W] that it
    dissipates to ``rate``, in place. Where a link has no direction its load is not a number, so
    that the run ends."""
    for i in range(p.links.size):
        link = p.links[i]
        mode = modes[p.mode + i]
        clear(loads.dy[p.state + link.state : p.state + link.state + link.states])
        if mode[MODE] == link.inactive or (link.law == TENSION and mode[SEGMENT] == link.first):
            continue
        s = find_kinematics(link, mode, t, y, motion, bodies, p)
        T, dissipated = laws.find_loads(link, mode, s, y, p)
        if mode[MODE] == UNDEFINED:
            T = nan
        loads.rate[link.row] += dissipated + T * s.speed
        add_load(link, T, s, motion, bodies, loads.wrench[link.row])
        laws.set_state_rates(link, mode, s, y, p, loads.dy)


@root
def add_energy(t, y, modes, motion, bodies, p, stored):
    """Add the energy stored in every link to its row of ``stored``."""
    for i in range(p.links.size):
        link = p.links[i]
        mode = modes[p.mode + i]
        if mode[MODE] != link.inactive and mode[MODE] != UNDEFINED:
            s = find_kinematics(link, mode, t, y, motion, bodies, p)
            stored[link.row] += laws.stored_energy(link, mode, s, y, p)


@root
def write_outputs(t, y, modes, motion, bodies, p, out):
    """Write rows of `LINK_OUTPUTS` of all links to ``out``: load, place, offset, dissipated
    power."""
    for i in range(p.links.size):
        row = out[LINK_OUTPUTS * i : LINK_OUTPUTS * (i + 1)]
        mode = modes[p.mode + i]
        s = find_kinematics(p.links[i], mode, t, y, motion, bodies, p)
        row[PLACE_OUTPUT] = s.place
        row[OFFSET_OUTPUT] = s.x
        row[LOAD_OUTPUT] = row[POWER_OUTPUT] = 0.0
        if mode[MODE] != p.links[i].inactive:
            row[LOAD_OUTPUT], row[POWER_OUTPUT] = laws.find_loads(p.links[i], mode, s, y, p)
            if mode[MODE] == UNDEFINED:
                row[LOAD_OUTPUT] = nan


@kernel
def find_load(i, t, y, modes, motion, bodies, p):
    """Load of link ``i``."""
    mode = modes[p.mode + i]
    if mode[MODE] == p.links[i].inactive:
        return 0.0
    s = find_kinematics(p.links[i], mode, t, y, motion, bodies, p)
    return laws.find_loads(p.links[i], mode, s, y, p)[0]


@kernel
def find_place(i, t, y, modes, motion, bodies, p):
    """Length, twist or place of link ``i``."""
    return find_kinematics(p.links[i], modes[p.mode + i], t, y, motion, bodies, p).place


@root
def find_margins(t, y, modes, motion, bodies, p, out):
    """Margins of all links into ``out`` (4 to a row of modes): those of their laws, and the room
    before a coordinate loses its direction, or a twist leaves its half turn."""
    for i in range(p.links.size):
        link = p.links[i]
        mode = modes[p.mode + i]
        margins = out[MARGINS * (p.mode + i) : MARGINS * (p.mode + i + 1)]
        for k in range(MARGINS):
            margins[k] = 1.0
        if mode[MODE] == link.inactive or mode[MODE] == UNDEFINED:
            continue
        s = find_kinematics(link, mode, t, y, motion, bodies, p)
        laws.find_margins(link, mode, s, y, p, margins)
        if not link.pulls_only:
            margins[RISING_MARGIN] = s.room


@root
def transition(i, which, t, y, modes, motion, bodies, p):
    """Switch link ``i`` to its next mode, after margin ``which`` has reached zero."""
    link = p.links[i]
    mode = modes[p.mode + i]
    s = find_kinematics(link, mode, t, y, motion, bodies, p)
    if which != RISING_MARGIN:
        laws.transition(link, which, mode, s, y, p)
    elif leaves_half_turn(link, s):
        mode[HALF_TURNS] += 1 if s.turned > 0.0 else -1
    else:
        mode[MODE] = UNDEFINED


@root
def set_initial_modes(t, y, modes, motion, bodies, p):
    """Modes of all links for a start."""
    for i in range(p.links.size):
        activate(i, t, y, modes, motion, bodies, p)


@kernel
def activate(i, t, y, modes, motion, bodies, p):
    """Mode of link ``i`` when it becomes active. Its twist is then within half a turn."""
    link = p.links[i]
    mode = modes[p.mode + i]
    mode[MODE] = 0
    mode[HALF_TURNS] = 0
    s = find_kinematics(link, mode, t, y, motion, bodies, p)
    laws.set_initial_mode(link, mode, s, y, p)
    if not link.pulls_only and s.room <= 0.0:
        if leaves_half_turn(link, s):
            mode[HALF_TURNS] = 1 if s.turned > 0.0 else -1
        else:
            mode[MODE] = UNDEFINED


@kernel
def deactivate(i, modes, p):
    """Deactivate link ``i``."""
    modes[p.mode + i, MODE] = p.links[i].inactive
    modes[p.mode + i, SEGMENT] = p.links[i].first


@kernel
def guard_dependencies(i, p):
    """Range of the states that margins of link ``i`` depend on."""
    k = p.state + p.links[i].state
    return k, k + p.links[i].states
