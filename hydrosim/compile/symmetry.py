"""Symmetric scenes: what is not its own mirror image, and motions in surge, heave and pitch only.

A scene is symmetric if hulls, masses, force elements, waves, streams and the state at the start are
symmetric about the vertical plane y = const through its bodies. Then no load leads out of that
plane: sway, roll and yaw are zero. `in_plane` removes these coordinates before the run, as if the
scene had been written without them.

Matrices and wave loads count as symmetric if the entries that lead out of the plane are below
`SYMMETRY_RTOL` (1e-6) of the others. Only waves to 0 or 180 deg are symmetric. A random sea with
waves to both sides is not, because each of its waves differs.

Limits: the symmetric motion may be unstable. So sway, roll and yaw are kept if they are not stable
at the start (a capsizing hull, a tanker that fishtails). A later loss of stability, for example by
a contact, is not noticed. Motions without a restoring force may count as unstable, because rounding
makes them grow.

Force elements and joints that are not their own mirror image in a vertical plane along x.

An element that acts on all coordinates of a body is its own image if it does not couple surge,
heave and pitch with sway, roll and yaw. Elements that act at points need an image among the
elements: each point of a fender, each spring, applied force and stream load, on the other side or
in the plane. Points with rigid friction must be in the plane. Beside it, the shares of their load
depend on the motions out of the plane.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy import linalg

from hydrosim import scene as scenes
from hydrosim.compile.hydrodynamic_groups import HydrodynamicGroup, each_alone, each_database
from hydrosim.compile.hydrostatics import asymmetric_hulls
from hydrosim.compile.start import first_state
from hydrosim.dofs import DOFS, LATERAL, MIRROR_SIGN, SYMMETRY_RTOL
from hydrosim.elements import is_mirrored
from hydrosim.integrate.names import Coordinate, coordinates
from hydrosim.linear.linearise import STEP, differentiate, find_components
from hydrosim.scene.joint import Ball, Fixed, JointMotion, MotionKind, Rod, Universal
from hydrosim.scene.scene import tree_joints
from hydrosim.tanks.mirror import without_image as without_image_in
from hydrosim.water.components import WaveComponents
from hydrosim.water.radiation.history import AFTER, VELOCITY
from hydrosim.water.second_order import difference_factors, sum_factors
from hydrosim.water.transfer import excitation_at, mean_drift_at

if TYPE_CHECKING:
    from hydrosim.compile.compiled import Compiled, Notes
    from hydrosim.database import HydroDatabase
    from hydrosim.integrate.dynamics import Model
    from hydrosim.integrate.state import State

MIRROR = np.diag([1.0, -1.0, 1.0])
AXES = {Fixed: 0, Ball: 0, Universal: 2, Rod: 0}
"""Number of axes that matter, for joints that do not have one."""
COUPLES = f"couples {', '.join(x for x in DOFS if x not in LATERAL)} with {', '.join(LATERAL)}"


def couples(matrices: np.ndarray, lateral: np.ndarray) -> bool:
    """Whether any of the ``matrices`` (..., m, m) couples ``lateral`` coordinates (m,) with the
    others by more than `SYMMETRY_RTOL` times the geometric mean of their diagonals (the largest of
    all matrices)."""
    size = np.abs(matrices).reshape(-1, lateral.size, lateral.size).max(axis=0)
    scale = np.sqrt(np.diag(size))
    coupled = size > SYMMETRY_RTOL * np.outer(scale, scale)
    return bool(np.any(coupled & (lateral[:, None] != lateral)))


def without_image(elements: Mapping[str, scenes.ForceElement], y: float) -> Iterator[str]:
    """Messages on force elements that are not symmetric about the plane at ``y`` [m]."""
    for name, element in elements.items():
        if any(couples(matrix, MIRROR_SIGN < 0.0) for matrix in element.couplings()):
            yield f"{name} {COUPLES}"
        if reason := element.asymmetry():
            yield f"{name} {reason}"
    yield from (
        f"{name} has no mirror image" for name in dict.fromkeys(_unpaired_elements(elements, y))
    )


def joints_without_image(joints: Mapping[str, scenes.Joint], y: float) -> Iterator[str]:
    """Messages on joints that are not symmetric about the plane through their bodies, at ``y``
    [m]."""
    shapes = {name: _shape(joint, y) for name, joint in joints.items()}
    for name, shape in shapes.items():
        if not any(_is_equal(shape.image(), other) for other in shapes.values()):
            yield f"{name} has no mirror image"


@dataclass(frozen=True, eq=False)
class _Shape:
    """What a joint holds: its axes (m, 3, 3) as a a^T, because their sense does not matter, and
    the ``arrow`` (3,) along which a ratchet goes, or (turning) about which it turns; of a rod, its
    other end."""

    between: str
    times: _Times
    point: np.ndarray
    axes: np.ndarray
    arrow: np.ndarray
    turning: bool

    def image(self) -> _Shape:
        """Its mirror image: a turn about an axis in the plane becomes its opposite."""
        sign = -1.0 if self.turning else 1.0
        axes = MIRROR @ self.axes @ MIRROR
        return replace(self, point=MIRROR @ self.point, axes=axes, arrow=sign * MIRROR @ self.arrow)


class _Times(NamedTuple):
    """When a joint holds, and its teeth."""

    active: scenes.Active | None
    window: scenes.JointWindow | None
    pitch: float
    breaks_at: float | None
    length: float | None


def _shape(joint: scenes.Joint, y: float) -> _Shape:
    axes = joint.axes()
    lines = [np.outer(axes[k], axes[k]) for k in range(AXES.get(type(joint), 1))]
    pawl = joint.pawl
    return _Shape(
        f"{joint.type} {joint.body} {joint.to}",
        _Times(
            joint.active,
            joint.window,
            pawl.pitch if pawl else 0.0,
            joint.breaks_at,
            joint.length if isinstance(joint, Rod) else None,
        ),
        np.array(joint.point, dtype=float),
        np.array(lines).reshape(-1, 3, 3),
        _arrow(joint, y),
        pawl is not None and pawl.turns,
    )


def _arrow(joint: scenes.Joint, y: float) -> np.ndarray:
    """Direction of a ratchet, or the other end of a rod from the plane."""
    if joint.pawl is not None:
        return joint.axes()[0]
    if not isinstance(joint, Rod):
        return np.zeros(3)
    return np.array(joint.to_point) - (0.0, y if joint.to is None else 0.0, 0.0)


def _unpaired_elements(elements: Mapping[str, scenes.ForceElement], y: float) -> Iterator[str]:
    """Names of the elements with parts that have no image. One part has at most one image."""
    parts = [
        (name, part) for name, element in elements.items() for part in element.mirrored_parts(y)
    ]
    left = [part for _, part in parts]
    for name, part in parts:
        image = part.mirror_image()
        partner = next((k for k, other in enumerate(left) if _is_equal(image, other)), None)
        if partner is None:
            yield name
        else:
            del left[partner]


def _is_equal(first: object, second: object) -> bool:
    """Whether parts of elements are equal entry by entry: numbers within `SYMMETRY_RTOL` of the
    largest number of their array."""
    if type(first) is type(second) and is_dataclass(first):
        return all(
            _is_equal(getattr(first, f.name), getattr(second, f.name)) for f in fields(first)
        )
    if isinstance(first, Mapping) and isinstance(second, Mapping):
        return first.keys() == second.keys() and all(
            _is_equal(first[key], second[key]) for key in first
        )
    if isinstance(first, tuple) and isinstance(second, tuple) and any(map(is_dataclass, first)):
        return len(first) == len(second) and all(map(_is_equal, first, second))
    if first is None or second is None:
        return first is second
    if is_dataclass(first) or isinstance(first, str | _Times):
        return first == second
    a, b = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    if a.shape != b.shape:
        return False
    infinite = np.isinf(a) | np.isinf(b)
    if not np.array_equal(a[infinite], b[infinite]):
        return False
    a, b = a[~infinite], b[~infinite]
    return bool(np.all(np.abs(a - b) <= SYMMETRY_RTOL * np.abs(a).max(initial=0.0)))


IN_PLANE_ATOL = 1e-9  # m, rad and per second: a smaller state counts as in the plane
GROWTH = 1e-4  # 1/s: slower growth is rounding, not instability
ASIDE = MIRROR_SIGN < 0.0  # which of the six coordinates lead out of the plane


def in_plane(calm: Compiled, sea: Sequence[WaveComponents]) -> tuple[scenes.Scene | None, Notes]:
    """Scene without sway, roll and yaw if it is symmetric, also in the ``sea`` drawn from its
    waves, else None. The notes give the reason."""
    scene = calm.scene
    free = coordinates(scene)
    zero = tuple(coordinate.name for coordinate in free if _leads_aside([coordinate]))
    if not 0 < len(zero) < len(free):
        return None, calm.notes
    ignored = scene.solver.symmetry == scenes.Symmetry.IGNORE
    reasons = ["as solver.symmetry asks"] if ignored else list(_asymmetries(calm, sea))
    reasons = reasons or list(_joints_in_pairs(scene))
    moving = calm.derived.layout.moving()
    aside = {entry.name: _leads_aside(entry.coordinates) for entry in moving}
    reasons = reasons or list(_at_start(calm, aside))
    if reasons:
        text = f"in all degrees of freedom: {'; '.join(reasons)}"
        return None, replace(calm.notes, symmetry=text)
    plane = _without_lateral(scene, {name for name in aside if aside[name]})
    text = f"in the plane y = {_plane(scene.bodies[0]):g} m, its plane of symmetry"
    return plane, replace(calm.notes, symmetry=text, zero=zero)


def wave_asymmetries(
    scene: scenes.Scene, groups: Sequence[HydrodynamicGroup], sea: Sequence[WaveComponents]
) -> Iterator[str]:
    """Reasons why waves of the scene load its bodies out of their plane; empty if they do not."""
    alone = each_alone(groups)
    loaded = [b for b in scene.bodies if b.name in alone and b.wave_forces.has_loads]
    headings = np.concatenate([np.zeros(0), *(waves.heading for waves in sea)])
    headings = np.unique(headings if loaded else np.zeros(0))
    aside = np.degrees(headings[np.abs(np.sin(headings)) > SYMMETRY_RTOL])
    if aside.size:
        yield f"waves to {aside[0]:g} deg" + (" and others" if aside.size > 1 else "")
    elif headings.size:
        wanted = {body.name: body.wave_forces for body in loaded}
        for group in each_database(groups):
            for name, db in group.alone.items():
                if name in wanted:
                    yield from _wave_loads_aside(db, wanted[name], headings)


def plane_of(scene: scenes.Scene) -> float:
    """y of the vertical plane of the first body."""
    return _plane(scene.bodies[0])


def not_mirrored(calm: Compiled, headings: np.ndarray) -> list[str]:
    """Why a scene in waves to -b is not the mirror image of that in waves to b, in words, for some
    of the ``headings`` b [rad]; nothing if it is for all of them."""
    asymmetries = list(_asymmetries(calm, ()))
    aside = {entry.name: _leads_aside(entry.coordinates) for entry in calm.derived.layout.moving()}
    state = calm.state
    leads = np.array([*aside.values()])
    if np.any(np.abs(state.y[: leads.size][leads]) > IN_PLANE_ATOL):
        asymmetries.append("the state at the start")
    elif not _is_mirrored_state(calm.model, state):
        asymmetries.append("the contacts at the start")
    for group in each_database(calm.wet):
        for name, db in group.alone.items():
            if _load_differs(db, headings):
                asymmetries.append(f"first-order loads or mean drift on {name} ({db.source})")
    return asymmetries


def _load_differs(db: HydroDatabase, headings: np.ndarray) -> bool:
    """Whether waves to both sides load a hull otherwise than as mirror images."""
    there, back = (_probe(db.frequency, sign * headings) for sign in (1.0, -1.0))
    tables: dict[Any, Any] = {excitation_at: db.excitation, mean_drift_at: db.mean_drift}
    for loads_at, table in tables.items():
        if table is None:
            continue
        load_there, load_back = (loads_at(db, wave.heading, wave.omega) for wave in (there, back))
        largest = np.abs(np.asarray(table)).reshape(-1, 2, 3).max(axis=(0, 2)).repeat(3)
        if np.any(np.abs(load_there - MIRROR_SIGN * load_back) > SYMMETRY_RTOL * largest):
            return True
    return False


def _asymmetries(calm: Compiled, sea: Sequence[WaveComponents]) -> Iterator[str]:
    """Parts of a scene that are not symmetric, without its state at the start."""
    scene = calm.scene
    y = _plane(scene.bodies[0])
    rotations = ASIDE[3:]
    for body in scene.bodies:
        if abs(_plane(body) - y) > IN_PLANE_ATOL:
            yield f"{body.name} is beside {scene.bodies[0].name}"
        if body.heading != 0.0:
            yield f"{body.name} has a heading of {np.degrees(body.heading):g} deg at rest"
        if couples(np.asarray(body.inertia), rotations):
            yield f"the products of inertia of {body.name}"
        if alone := without_image_in(body):
            yield f"{', '.join(alone)} of {body.name} have no mirror image"
    yield from without_image(scene.forces, y)
    yield from _joints_aside(scene, y)
    water = scene.environment
    for name, stream in (("current", water.current), ("wind", water.wind)):
        if abs(stream.top_speed * np.sin(stream.direction)) > SYMMETRY_RTOL * stream.top_speed:
            yield f"{name} to {np.degrees(stream.direction):g} deg"
    for b in asymmetric_hulls(calm.model.hulls, calm.model.bodies):
        yield f"the hull of {scene.bodies[b].name}"
    for group in each_database(calm.wet):
        yield from _couplings(group)
    yield from wave_asymmetries(scene, calm.wet, sea)


def _joints_aside(scene: scenes.Scene, y: float) -> Iterator[str]:
    """Joints whose motions leave the plane at ``y``, and constraints that have no mirror image."""
    bodies = {body.name: body for body in scene.bodies}
    joints = tree_joints(scene)
    for name, joint in joints.items():
        beside = abs(_plane(bodies[joint.body]) + joint.point[1] - y) > IN_PLANE_ATOL
        if beside or not all(_is_in_plane(motion, joint) for motion in joint.motions):
            yield f"the joint {name}"
    others = {name: joint for name, joint in scene.joints.items() if name not in joints}
    yield from joints_without_image(others, y)


def _joints_in_pairs(scene: scenes.Scene) -> Iterator[str]:
    """Constraints whose mirror image is another one: in the plane one of them would carry the load
    of both."""
    joints = tree_joints(scene)
    for name, joint in scene.joints.items():
        shape = _shape(joint, _plane(scene.bodies[0]))
        if name not in joints and not _is_equal(shape.image(), shape):
            yield f"{name} shares its load with its mirror image"


def _is_in_plane(motion: JointMotion, joint: scenes.Joint) -> bool:
    """Whether a motion of a joint stays in a plane of constant y."""
    across = abs(joint.axes()[motion.axis, 1])
    slides = motion.kind == MotionKind.SLIDE
    return (
        motion.kind != MotionKind.SWIVEL and abs(across - (0.0 if slides else 1.0)) < IN_PLANE_ATOL
    )


def _plane(body: scenes.Body) -> float:
    """y of the vertical plane through the centre of gravity at rest."""
    return body.location[1] + body.centre_of_gravity[1]


def _couplings(group: HydrodynamicGroup) -> Iterator[str]:
    """Coefficients of a database that couple motions in the plane with motions out of it."""
    db = group.database
    aside = np.tile(ASIDE, len(group.bodies))
    for name in ("added_mass", "radiation_damping", "hydrostatic_stiffness"):
        matrices = getattr(db, name)
        if matrices is not None and couples(matrices, aside):
            yield f"{name.replace('_', ' ')} of {db.source} {COUPLES}"


def _wave_loads_aside(
    db: HydroDatabase, wanted: scenes.WaveForces, headings: np.ndarray
) -> Iterator[str]:
    """Loads of waves along the plane that lead out of it."""
    waves = _probe(db.frequency, headings)
    second = wanted.second_order
    if wanted.first_order:
        load = excitation_at(db, waves.heading, waves.omega)
        yield from _load_aside("first-order loads", load, db.excitation, db)
    if second not in (scenes.SecondOrder.NONE, scenes.SecondOrder.QTF):
        load = mean_drift_at(db, waves.heading, waves.omega)
        yield from _load_aside("mean drift", load, db.mean_drift, db)
    if second == scenes.SecondOrder.QTF or wanted.sum_frequency:
        few = _probe(np.asarray(db.qtf_frequency), headings)
        if second == scenes.SecondOrder.QTF:
            load = difference_factors(db, few).pairs().T
            yield from _load_aside("difference-frequency loads", load, db.qtf_difference, db)
        if wanted.sum_frequency:
            load = sum_factors(db, few).pairs().T
            yield from _load_aside("sum-frequency loads", load, db.qtf_sum, db)


def _probe(frequency: np.ndarray, headings: np.ndarray) -> WaveComponents:
    """Waves of unit height at all frequencies, in all headings."""
    omega = np.tile(frequency, headings.size)
    heading = np.repeat(headings, frequency.size)
    ones = np.ones(omega.size)
    zero = np.zeros(omega.size)
    return WaveComponents(omega, ones, zero, zero, heading, 0.0, 0.0)


def _load_aside(
    what: str, loads: np.ndarray, table: np.ndarray | None, db: HydroDatabase
) -> Iterator[str]:
    """Test whether loads (..., 6) in sway, roll or yaw exceed `SYMMETRY_RTOL` of the largest force
    or moment in the ``table`` (..., 6) of all headings."""
    largest = np.abs(np.asarray(table)).reshape(-1, 2, 3).max(axis=(0, 2))
    size = np.abs(loads).reshape(-1, 6).max(axis=0)
    far = [
        dof
        for dof in LATERAL
        if size[DOFS.index(dof)] > SYMMETRY_RTOL * largest[DOFS.index(dof) // 3]
    ]
    if far:
        yield f"{what} of {db.source} in {', '.join(far)}"


def _at_start(calm: Compiled, aside: Mapping[str, bool]) -> Iterator[str]:
    """Coordinates that lead out of the plane in the state at the start. ``aside`` says which of the
    first states in y do."""
    model = calm.model
    state = calm.state
    leads = np.array([*aside.values()])
    size = np.abs(state.y[: leads.size])
    still = np.where(
        np.arange(leads.size) < model.radiation, IN_PLANE_ATOL, IN_PLANE_ATOL * size.max()
    )
    off = [name for name, is_off in zip(aside, leads & (size > still), strict=True) if is_off]
    if off:
        yield f"{off[0]} at the start" + (" and others" if len(off) > 1 else "")
    elif np.any(model.bodies.locked.reshape(-1, 6)[:, ASIDE]):
        yield f"{', '.join(LATERAL)} of a body are locked out of the plane"
    elif _remembers(state):
        yield "the motions before the start"
    elif not _is_mirrored_state(model, state):
        yield "the contacts at the start"
    elif _growth(calm, leads) > GROWTH:
        yield f"{', '.join(LATERAL)} are not stable"


def _remembers(state: State) -> bool:
    """Whether a convolution remembers velocities out of the plane."""
    past = state.history.grid[AFTER].T
    last = state.history.node[:, VELOCITY]
    return any(np.any(np.abs(v.reshape(-1, 6)[:, ASIDE]) > IN_PLANE_ATOL) for v in (past, last))


def _is_mirrored_state(model: Model, state: State) -> bool:
    """Whether the states and modes of all elements are their own mirror image."""
    return is_mirrored(model, state.y, state.modes)


def _growth(calm: Compiled, aside: np.ndarray) -> float:
    """Fastest growth of motions out of the plane about a start from rest [1/s]."""
    state = calm.state if calm.scene.initial is None else first_state(calm.scene, calm.model)
    J = differentiate(calm.model, state, calm.begin, STEP, np.flatnonzero(aside))
    blocks = (J[np.ix_(component, component)] for component in find_components(J))
    return max(float(linalg.eigvals(block).real.max()) for block in blocks)


def _leads_aside(coordinates: Sequence[Coordinate]) -> bool:
    """Whether none of the coordinates stays in the plane."""
    return all(coordinate.dof in LATERAL for coordinate in coordinates)


def _without_lateral(scene: scenes.Scene, aside: Collection[str]) -> scenes.Scene:
    """Scene without coordinates that lead out of the plane, starting without those states."""
    bodies = tuple(
        replace(body, dofs=tuple(dof for dof in body.dofs if dof not in LATERAL))
        for body in scene.bodies
    )
    start = scene.initial
    if start is None or isinstance(start.run, Path | str):
        return replace(scene, bodies=bodies)
    remaining = {
        name: [x for x in start.run[name].values if x not in aside]
        for name in ("state", "memory_dof")
        if name in start.run.dims
    }
    return replace(scene, bodies=bodies, initial=replace(start, run=start.run.sel(remaining)))
