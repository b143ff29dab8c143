"""Contact points: points of a body against planes, with a normal curve and a friction law each.

    F = N n + f,   on the plane's body the opposite at the same place

N: normal force along the plane's normal n (`normal`); f: friction in the plane (`laws`); both
depend on compression, velocity and stretch (`geometry`). Every point has a mode (open, stick, slip)
and a segment of its curve. Load-dependent stick-slip also knows whether the load rises. They change
only at events (`transitions`). A fender has points against one plane, which may end at edges. A
`landing` has a seat for each point and a memory of its loading (`NormalLoop`).

States per point: stretch s (2,), or heading for slip without a node; slip distance. Further the
energy lost in friction, including stored energy that is lost when contact ends. Its parts lost in
C2 and in C3 of a contact node are states, too.

Stored energy: normal curve and stretch. Dissipation: normal damping and friction. A prescribed
normal force stores nothing; its work on the body counts as dissipation.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from hydrosim.dofs import MIRROR_SIGN, SYMMETRY_RTOL
from hydrosim.elements.contact import coulomb, curves, geometry, group, laws
from hydrosim.elements.contact.curves import NO_CURVE
from hydrosim.elements.contact.curves import SEGMENT as PIECE
from hydrosim.elements.contact.law import OPEN, PASSED, STICK, NormalLoad
from hydrosim.elements.contact.laws import COULOMB, FORGETFUL, LAW
from hydrosim.elements.signal import (
    NOTHING,
    SIGNAL,
    compile_signals,
    rate,
    time_of_largest,
    value,
)
from hydrosim.errors import InputError
from hydrosim.jit.kernels import clear, kernel, root
from hydrosim.modes import MODE, NO_INDEX, RISING, SEGMENT
from hydrosim.scene import ForceElement
from hydrosim.scene.contacts import Contact, Frictionless, NormalLoop, PrescribedNormal
from hydrosim.scene.plane import Plane

if TYPE_CHECKING:
    from hydrosim.elements.kind import Layout

CONTACT_STATE_NAMES = (  # of each point
    *("stretch 1", "stretch 2", "slip distance"),
    *("friction loss", "damping loss", "slip damping loss", "settled"),
)
CONTACT_STATES = len(CONTACT_STATE_NAMES)
SLIP_DISTANCE, DISSIPATED, DAMPED, SLIP_DAMPED, SETTLED = range(2, CONTACT_STATES)
FELT_STATES = 2  # first states of a point, which others depend on: its stretch
# see `write_outputs`
COMPRESSION = 0
NORMAL_FORCE = 1
FRICTION_FORCE = 2
NODE = 5
ENERGY_LOST = 8
CONTACT_OUTPUTS = 9
PRESCRIBED_CONTACT_FRACTION = 1e-12  # of the largest prescribed normal force


def check_contact(name: str, contact: Contact) -> None:
    """Check the loop of a contact and the edges of its planes. Raises InputError."""
    try:
        if isinstance(contact.normal, NormalLoop):
            curves.check(contact.normal)
        for plane in contact.planes():
            geometry.plane_edges(plane)
    except InputError as error:
        raise InputError(f"forces.{name}.{error}") from None


CONTACT_POINT = np.dtype(
    [
        *(("body", int), ("row", int), ("place", float, 3)),
        *geometry.PLANE,
        *(("first", int), ("last", int), ("steepest", float)),
        *(("normal_damping", float), ("prescribed", bool), ("least", float), ("signal", SIGNAL)),
        *LAW,
        *(("reach", float), ("lag", float)),
        *curves.LOOP,
        *(("edge", int), ("edges", int), ("extent", float), ("group", int)),
        ("saturates", bool),
    ]
)
"""Constants of a contact point: its position on its body, its plane and its friction law. Its
normal force has the pieces ``first`` to ``last`` of a curve, or a signal. ``reach`` [m] is the
stretch of its node under a usual load; ``lag`` [s] is set by explicit methods. Further the
unloading curve, its plane's ``edges`` from ``edge`` on and its ``extent`` about its point, and its
``group`` among groups with memory. A friction slope ``saturates`` at every evaluation if no event
ends its branch."""


class ContactConstants(NamedTuple):
    """``points`` (n,) of `CONTACT_POINT`, the ``segments`` of their curves, the ``pieces`` of their
    signals, the ``edges`` (m, 3) of their planes; the first of their states in y, and of their rows
    of modes. States of the ``remembering`` points (`loop`) follow those of all points; states of
    the ``groups`` (`group`) follow these."""

    points: np.ndarray
    segments: np.ndarray
    pieces: np.ndarray
    edges: np.ndarray
    remembering: int
    groups: np.ndarray
    state: int
    mode: int


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout) -> ContactConstants:
    """Constants of all contact points among ``elements``, in their order."""
    fenders = {name: e for name, e in elements.items() if isinstance(e, Contact)}
    normals = [e.normal for e in fenders.values()]
    signals, pieces = compile_signals([n.force for n in normals if isinstance(n, PrescribedNormal)])
    rows = []
    segments = [np.zeros(0, dtype=PIECE)]
    following = iter(signals)
    ends = [np.zeros((0, 3))]
    remembering = 0
    names = []
    for name, e in fenders.items():
        signal = (False, 0.0, NOTHING)
        if isinstance(e.normal, PrescribedNormal):
            signal = _prescribed_normal(next(following), pieces)
        first = sum(map(len, segments))
        segments.append(
            curves.normal_segments(NO_CURVE if isinstance(e.normal, PrescribedNormal) else e.normal)
        )
        curve_ = curves.loading_fields(e.normal, first, segments[-1])
        law = laws.constants(e.friction)
        usual = (
            laws.break_away_stretch(e.friction, _usual_load(e, signal, pieces, layout)),
            layout.step,
        )
        place = (layout.body[e.body], layout.row[name])
        keeps = e.remembers or isinstance(e.normal, NormalLoop)
        for point, plane in zip(e.points, e.planes(), strict=True):
            sides = geometry.plane_edges(plane)
            back = curves.unloading_fields(
                e.normal, first, segments[-1], remembering if keeps else NO_INDEX
            )
            end = (sum(map(len, ends)), len(sides), e.reach())
            law_fields = (*curve_, *signal, *law, *usual, *back, *end)
            point_fields = (
                *place,
                point,
                *_plane_fields(plane, layout),
                *law_fields,
                NO_INDEX,
                not layout.events,
            )
            rows.append(point_fields)
            names.append(e.group or name)
            ends.append(sides)
            remembering += keeps
    points = np.array(rows, dtype=CONTACT_POINT)
    all_ends = np.concatenate(ends)
    states = CONTACT_STATES * len(points) + curves.LOOP_STATES * remembering
    groups = group.compile_groups(fenders, layout.carried, states)
    for g, index in enumerate(groups["index"]):
        points["group"][np.array(names) == [*dict.fromkeys(names)][index]] = g
    return ContactConstants(
        points, np.concatenate(segments), pieces, all_ends, remembering, groups, 0, 0
    )


def _prescribed_normal(signal: np.void, pieces: np.ndarray) -> tuple[bool, float, np.void]:
    """True if the normal force is prescribed; the least force that counts as contact; the
    signal."""
    return (
        True,
        PRESCRIBED_CONTACT_FRACTION * abs(value(time_of_largest(signal, pieces), signal, pieces)),
        signal,
    )


def _usual_load(
    fender: Contact, signal: tuple[bool, float, np.void], pieces: np.ndarray, layout: Layout
) -> float:
    """Typical normal force [N] on a point: the largest prescribed one, else the weight of a body
    or, if smaller, the force at the end of the curve."""
    _, least, _ = signal
    if isinstance(fender.normal, PrescribedNormal):
        return least / PRESCRIBED_CONTACT_FRACTION
    between = [fender.body, *(name for _, name in fender.connected_bodies() if name)]
    weights = [layout.weight[layout.body[name]] for name in between]
    return min(*weights, float(fender.normal.force[-1]))


def _plane_fields(plane: Plane, layout: Layout) -> tuple[Any, ...]:
    n = np.array(plane.normal, dtype=float)
    n /= np.linalg.norm(n)
    body = layout.body[plane.body] if plane.body else geometry.EARTH
    return (body, plane.point, n, *geometry.tangents(n))


def points_with_memory(p: ContactConstants) -> np.ndarray:
    """Indices (r,) of the points with a memory of their loading: each has states for it."""
    return np.flatnonzero(p.points["memory"] != NO_INDEX)


def memory_states(p: ContactConstants, y: np.ndarray) -> np.ndarray:
    """The memory (..., r, loop.LOOP_STATES) of ``r`` points, from y (..., ny)."""
    memory = y[..., memory_range(p)]
    return memory.reshape(*y.shape[:-1], p.remembering, curves.LOOP_STATES)


def memory_range(p: ContactConstants) -> slice:
    """The places of all memories in y."""
    first = p.state + CONTACT_STATES * p.points.size
    return slice(first, first + curves.LOOP_STATES * p.remembering)


def without_friction(p: ContactConstants) -> ContactConstants:
    """The same contact points without friction."""
    points = p.points.copy()
    none = laws.constants(Frictionless())
    for (name, _), constant in zip(LAW, none, strict=True):
        points[name] = constant
    return p._replace(points=points)


def dynamic_states(p: ContactConstants) -> np.ndarray:
    """Entries (m,) of y that other states depend on: the stretches of nodes."""
    first = p.state + CONTACT_STATES * np.flatnonzero(p.points["node"])
    return np.sort(np.concatenate([first, first + 1]))


def clear_unused_states(p: ContactConstants, y: np.ndarray) -> None:
    """Clear the states in y that have no meaning for their points' law."""
    for i in np.flatnonzero(np.isin(p.points["law"], FORGETFUL)):
        y[p.state + CONTACT_STATES * i :][:2] = 0.0


def is_mirrored(p: ContactConstants, y: np.ndarray, modes: np.ndarray) -> bool:
    """True if each contact point's image has the same stretch, mode and line of its loop."""
    points = p.points
    n = p.points.size
    s = y[p.state :][: CONTACT_STATES * n].reshape(-1, CONTACT_STATES)[:, :2, None]
    stretch = s[:, 0] * points["tangent1"] + s[:, 1] * points["tangent2"]
    here = np.stack([points["place"], points["plane_normal"], stretch], axis=1)
    mode = modes[p.mode :][:n, MODE]
    whose = np.stack([points["body"], points["plane_body"], mode], 1)
    apart = np.abs((here * MIRROR_SIGN[:3])[:, None] - here).max(axis=3)
    close = apart <= SYMMETRY_RTOL * np.abs(here).max(axis=(0, 2), initial=0.0)
    start = np.zeros(n)
    start[points_with_memory(p)] = memory_states(p, y)[:, curves.BRANCH_START]
    alike = np.abs(start[:, None] - start) <= SYMMETRY_RTOL * np.abs(start).max(initial=0.0)
    images = close.all(axis=2) & np.all(whose[:, None] == whose, axis=2) & alike
    return bool(np.all(images.any(axis=1)))


@kernel
def add_force(t, y, modes, motion, bodies, p, loads):
    """Add the force of every point to its row of ``wrench``, and dissipation along the normal to
    ``rate``. Rates of stretch, slip distance and energy lost in friction go to ``dy``. Reactions of
    rigid friction are left out: see `add_reactions`. The memory of points changes at events
    only."""
    first = p.state + CONTACT_STATES * p.points.size
    count = curves.LOOP_STATES * p.remembering + group.GROUP_STATES * p.groups.size
    clear(loads.dy[first : first + count])
    for i in range(p.points.size):
        point = p.points[i]
        mode = modes[p.mode + i, MODE]
        k = p.state + CONTACT_STATES * i
        x = y[k : k + CONTACT_STATES]
        dx = loads.dy[k : k + CONTACT_STATES]
        if mode == OPEN and (not point.node or x[0] == x[1] == 0.0):
            clear(dx)
            continue
        if mode == OPEN:
            _relax_node((x[0], x[1]), point, dx)
            continue
        c = geometry.contact_kinematics(point, bodies, motion)
        load = normal_load_of(i, t, y, modes, c, p)
        f = laws.friction(mode, load, c.velocity, (x[0], x[1]), point)
        dx[0], dx[1] = f.stretch_rate
        dx[SLIP_DISTANCE] = f.slip_speed
        dx[DISSIPATED] = f.dissipation
        dx[DAMPED] = f.damped
        dx[SLIP_DAMPED] = f.slip_damped
        dx[SETTLED] = 0.0
        lost = load.N if point.prescribed else point.normal_damping * c.rate
        loads.rate[point.row] += lost * c.rate
        geometry.add_contact_wrench(point, c, load.N, f.force, loads.wrench[point.row])
        group.add_load(load.N, loads.dy, point, p)


@kernel
def _relax_node(s, point, dx):
    """Rates of an open point with the stretch ``s``, at any distance."""
    f = laws.open_node_friction(NormalLoad(0.0, 0.0, 0.0, False), s, point)
    clear(dx)
    dx[0], dx[1] = f.stretch_rate
    dx[DISSIPATED] = f.dissipation
    dx[DAMPED] = f.damped


@kernel
def normal_load_of(i, t, y, modes, contact, p):
    """Normal force of point ``i``, zero when open. It is not cut at zero, so that it is smooth
    across the event that ends the contact."""
    mode = modes[p.mode + i]
    point = p.points[i]
    if mode[MODE] == OPEN:
        return NormalLoad(0.0, 0.0, 0.0, False)
    start = y[memory_start(point, p) + curves.BRANCH_START] if mode[SEGMENT] == point.line else 0.0
    return normal_load(t, point, p.segments[mode[SEGMENT]], start, mode[RISING], contact, p)


@kernel
def memory_start(point, p):
    """First entry in y of a point's memory; the point must have one."""
    return p.state + CONTACT_STATES * p.points.size + curves.LOOP_STATES * point.memory


@kernel
def normal_load(t, point, piece, start, rising, contact, p):
    """Normal force of a point in contact: prescribed, or from a piece of its curve that begins at
    ``start``."""
    if point.prescribed:
        N = value(t, point.signal, p.pieces)
        return NormalLoad(N, N, rate(t, point.signal, p.pieces), rising != 0)
    damping = point.normal_damping
    elastic = curves.curve_force(piece, contact.compression - start)
    return NormalLoad(
        elastic + damping * contact.rate, elastic, piece.slope * contact.rate, rising != 0
    )


@kernel
def add_constraints(modes, motion, bodies, p, wrench, constraints, holds):
    """Add to ``constraints`` that points in stick under Coulomb's law do not slide, and note in
    ``holds`` which rows belong to which point. ``wrench`` (6 nb,) is scratch."""
    for i in range(p.points.size):
        point = p.points[i]
        if point.law == COULOMB and modes[p.mode + i, MODE] == STICK:
            contact = geometry.contact_kinematics(point, bodies, motion)
            coulomb.add_constraints(i, point, contact, bodies, motion, wrench, constraints, holds)


@kernel
def add_reactions(modes, motion, bodies, p, constraints, holds, wrench):
    """Add reactions of the held points to their rows of ``wrench``."""
    coulomb.collect_reactions(constraints, holds)
    for i in range(p.points.size if constraints.number[0] > 0 else 0):
        point = p.points[i]
        f = (holds.reaction[i, 0], holds.reaction[i, 1])
        if point.law == COULOMB and modes[p.mode + i, MODE] == STICK:
            geometry.add_contact_wrench(
                point, geometry.contact_kinematics(point, bodies, motion), 0.0, f, wrench[point.row]
            )


@kernel
def stored_along_normal(i, t, y, modes, contact, p):
    """Recoverable energy in the normal curve of point ``i`` in contact."""
    point = p.points[i]
    x = contact.compression
    if point.line != NO_INDEX:
        return curves.recoverable_energy(
            normal_load_of(i, t, y, modes, contact, p).elastic, x, point, p.segments
        )
    return curves.stored_energy(p.segments[modes[p.mode + i, SEGMENT]], x)


@kernel
def lost_in_loop(i, y, modes, contact, p):
    """Energy that the loop of point ``i`` has dissipated."""
    point = p.points[i]
    mode = modes[p.mode + i]
    lost = y[memory_start(point, p) + curves.LOOP_LOSS]
    if mode[MODE] != OPEN:
        lost += curves.branch_loss(mode[SEGMENT], contact.compression, point, p.segments)
    return lost


@kernel
def residual_energy(i, modes, contact, p):
    """Energy in the normal curve of point ``i``, open, whose damper pulled it off the plane before
    the curve was unloaded. It is booked as lost, and not yet dissipated."""
    point = p.points[i]
    mode = modes[p.mode + i]
    if point.prescribed or contact.compression <= 0.0 or mode[RISING] >= PASSED:
        return 0.0
    segment = curves.find_segment(point.first, point.last, p.segments, contact.compression)
    return curves.stored_energy(p.segments[segment], contact.compression)


@kernel
def node_energy(i, t, y, modes, contact, p):
    """Energy in the stretched node of point ``i``."""
    k = p.state + CONTACT_STATES * i
    point = p.points[i]
    if not point.node:
        return 0.0
    load = normal_load_of(i, t, y, modes, contact, p)
    s = (y[k], y[k + 1])
    return laws.stored_energy(modes[p.mode + i, MODE], load, contact.velocity, s, point)


@root
def add_energy(t, y, modes, motion, bodies, p, stored):
    """Add energy in normal curves and stretched nodes to each fender's row of ``stored``."""
    for i in range(p.points.size):
        contact = geometry.contact_kinematics(p.points[i], bodies, motion)
        row = p.points[i].row
        stored[row] += node_energy(i, t, y, modes, contact, p)
        if modes[p.mode + i, MODE] != OPEN:
            stored[row] += stored_along_normal(i, t, y, modes, contact, p)
        else:
            stored[row] += residual_energy(i, modes, contact, p)


@root
def write_outputs(t, y, modes, motion, bodies, p, reactions, out):
    """Write rows of `CONTACT_OUTPUTS` of all points to ``out``: compression, N, friction (3) in the
    earth frame, node (3), energy lost in friction. Compression is zero or negative where a plane
    does not act."""
    for i in range(p.points.size):
        point = p.points[i]
        mode = modes[p.mode + i, MODE]
        k = p.state + CONTACT_STATES * i
        x = y[k : k + CONTACT_STATES]
        row = out[CONTACT_OUTPUTS * i : CONTACT_OUTPUTS * (i + 1)]
        c = geometry.contact_kinematics(point, bodies, motion)
        s = (x[0], x[1])
        load = normal_load_of(i, t, y, modes, c, p)
        f = laws.friction(mode, load, c.velocity, s, point).force
        if point.law == COULOMB and mode == STICK:
            f = (reactions[i, 0], reactions[i, 1])
        row[ENERGY_LOST] = x[DISSIPATED] - laws.recoverable_loss(mode, load, c.velocity, s, point)
        if mode == OPEN:
            row[ENERGY_LOST] -= residual_energy(i, modes, c, p)
        if point.memory != NO_INDEX:
            row[ENERGY_LOST] += lost_in_loop(i, y, modes, c, p)
        s = laws.node_stretch(mode, load, c.velocity, s, point)
        acts = mode != OPEN or modes[p.mode + i, RISING] < PASSED
        row[COMPRESSION] = c.compression if acts else min(c.compression, 0.0)
        row[NORMAL_FORCE] = load.N
        for j in range(3):
            t1 = c.tangent1[j]
            t2 = c.tangent2[j]
            n = c.normal[j]
            row[FRICTION_FORCE + j] = f[0] * t1 + f[1] * t2
            row[NODE + j] = c.place[j] + c.compression * n - s[0] * t1 - s[1] * t2


@kernel
def guard_dependencies(i, part, p):
    """Ranges of the states that margins of point ``i`` depend on, ``part`` by part."""
    if part == 0:
        k = p.state + CONTACT_STATES * i
        return k, k + FELT_STATES
    if p.points[i].memory == NO_INDEX:
        return 0, 0
    k = memory_start(p.points[i], p) + curves.BRANCH_START
    return k, k + 1
