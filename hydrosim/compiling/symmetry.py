"""Scenes that are their own mirror image: surge, heave and pitch are all that moves.

Where hulls, masses, force elements, waves and streams of a scene are symmetric about the vertical
plane y = const through its bodies, and its state at the start is, no load leads out of that plane
ever: sway, roll and yaw are zero. `planar` takes them out of a scene before it is run, as if it had
been written without them.

Matrices and wave loads count as symmetric where what leads out of the plane is below `SMALL` (1e-6)
of what stays in it. Only waves along the plane are symmetric, to 0 or 180 deg: of a sea with waves
to both sides each is another one.

Limits: the symmetric motion may be one that the least push would end. So a scene is left as it is
where sway, roll and yaw are not stable at its start (a capsizing hull, a tanker that fishtails);
what loses its stability later, as by a contact, is not noticed. Motions that nothing pulls back may
count as unstable, for rounding makes them grow.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr
from scipy import linalg

from hydrosim.compiling.mirror import COUPLES, LATERAL, SMALL, couples, without_image
from hydrosim.compiling.model import check_scene, compile_calm
from hydrosim.compiling.notes import Notes
from hydrosim.compiling.restart import begin, check_fit, resume
from hydrosim.compiling.wet import WetGroup, each_alone, wet_groups
from hydrosim.database import HydroDatabase
from hydrosim.dofs import DOFS, MIRROR_SIGN
from hydrosim.forces import FENDER
from hydrosim.forces.contact.fender import STATES
from hydrosim.forces.contact.modes import MODE
from hydrosim.linear.linearise import linearise
from hydrosim.results.names import coordinate_names, moving_names
from hydrosim.scene import Body, Scene, SecondOrder, Symmetry, WaveForces
from hydrosim.stepping.dynamics import Model
from hydrosim.stepping.stepper import State
from hydrosim.waves import Components, sea
from hydrosim.waves.quadratic import difference_factors, sum_factors
from hydrosim.waves.transfer import excitation_at, mean_drift_at

NEAR = 1e-9  # m, rad and per second: a state so far out of the plane is in it
GROWTH = 1e-4  # 1/s: slower than this is no instability but rounding
ASIDE = MIRROR_SIGN < 0.0  # which of the six coordinates lead out of the plane


def planar(scene: Scene, notes: Notes) -> Scene:
    """An `opened` scene without sway, roll and yaw if it is symmetric; else as it is.

    Fills `Notes.symmetry`, `Notes.zero` and, where it must look at them, the databases of
    ``notes``. Raises InputError as `compile_scene` does.
    """
    check_scene(scene)
    names = coordinate_names(scene)
    zero = tuple(name for name in names if _leads_aside([name]))
    if not 0 < len(zero) < len(names):
        return scene
    ignored = scene.solver.symmetry == Symmetry.IGNORE
    reasons = ["asked for by solver.symmetry"] if ignored else list(_asymmetries(scene, notes))
    if not reasons:
        model, fresh = compile_calm(replace(scene, initial=None), notes)
        aside = {name: _leads_aside(of) for name, of in moving_names(scene, model).items()}
        reasons = list(_at_start(scene, model, fresh, aside))
    if reasons:
        notes.symmetry = f"in all degrees of freedom: {'; '.join(reasons)}"
        return scene
    notes.symmetry = f"in the plane y = {_plane(scene.bodies[0]):g} m, which it is symmetric about"
    notes.zero = zero
    return _in_plane(scene, {name for name in aside if aside[name]})


def wave_asymmetries(scene: Scene, groups: Sequence[WetGroup]) -> Iterator[str]:
    """Why waves of the scene load its bodies out of their plane; nothing if they do not."""
    alone = each_alone(groups)
    loaded = [b for b in scene.bodies if b.name in alone and _wave_loads(b.wave_forces)]
    headings = np.concatenate([np.zeros(0), *(w.heading for w in sea(scene.environment))])
    headings = np.unique(headings if loaded else np.zeros(0))
    aside = np.degrees(headings[np.abs(np.sin(headings)) > SMALL])
    if aside.size:
        yield f"waves to {aside[0]:g} deg" + (" and others" if aside.size > 1 else "")
    elif headings.size:
        for body in loaded:
            yield from _wave_loads_aside(alone[body.name], body.wave_forces, headings)


def _asymmetries(scene: Scene, notes: Notes) -> Iterator[str]:
    """What is not symmetric in a scene, but for its state at the start."""
    y, rotations = _plane(scene.bodies[0]), ASIDE[3:]
    for body in scene.bodies:
        if abs(_plane(body) - y) > NEAR:
            yield f"{body.name} is beside {scene.bodies[0].name}"
        if couples(np.asarray(body.inertia), rotations):
            yield f"the products of inertia of {body.name}"
    yield from without_image(scene.forces, y)
    water = scene.environment
    for name, stream in (("current", water.current), ("wind", water.wind)):
        if abs(stream.speed * np.sin(stream.heading)) > SMALL * abs(stream.speed):
            yield f"{name} to {np.degrees(stream.heading):g} deg"
    notes.wet = notes.wet or wet_groups(scene)
    for group in notes.wet:
        yield from _couplings(group)
    yield from wave_asymmetries(scene, notes.wet)


def _plane(body: Body) -> float:
    """y of the vertical plane through the centre of gravity at rest."""
    return body.location[1] + body.centre_of_gravity[1]


def _couplings(group: WetGroup) -> Iterator[str]:
    """Coefficients of a database that couple motions in the plane with those out of it."""
    db, aside = group.database, np.tile(ASIDE, len(group.bodies))
    for name in ("added_mass", "radiation_damping", "hydrostatic_stiffness"):
        matrices = getattr(db, name)
        if matrices is not None and couples(matrices, aside):
            yield f"{name.replace('_', ' ')} of {db.source} {COUPLES}"


def _wave_loads(wanted: WaveForces) -> bool:
    return wanted.first_order or wanted.second_order != SecondOrder.NONE or wanted.sum_frequency


def _wave_loads_aside(db: HydroDatabase, wanted: WaveForces, headings: np.ndarray) -> Iterator[str]:
    """Which loads of waves along the plane lead out of it."""
    waves, second = _probe(db.frequency, headings), wanted.second_order
    if wanted.first_order:
        found = excitation_at(db, waves.heading, waves.omega)
        yield from _load_aside("first-order loads", found, db.excitation, db)
    if second not in (SecondOrder.NONE, SecondOrder.QTF):
        found = mean_drift_at(db, waves.heading, waves.omega)
        yield from _load_aside("mean drift", found, db.mean_drift, db)
    if second == SecondOrder.QTF or wanted.sum_frequency:
        few = _probe(np.asarray(db.qtf_frequency), headings)
        if second == SecondOrder.QTF:
            found = difference_factors(db, few).pairs().T
            yield from _load_aside("difference-frequency loads", found, db.qtf_difference, db)
        if wanted.sum_frequency:
            found = sum_factors(db, few).pairs().T
            yield from _load_aside("sum-frequency loads", found, db.qtf_sum, db)


def _probe(frequency: np.ndarray, headings: np.ndarray) -> Components:
    """Waves of unit height of all frequencies in all headings."""
    omega, heading = np.tile(frequency, headings.size), np.repeat(headings, frequency.size)
    one, zero = np.ones(omega.size), np.zeros(omega.size)
    return Components(omega, one, zero, zero, heading, 0.0, 0.0)


def _load_aside(
    what: str, loads: np.ndarray, table: np.ndarray | None, db: HydroDatabase
) -> Iterator[str]:
    """Loads (..., 6) of which some in sway, roll or yaw are more than `SMALL` of the largest force
    or moment in the ``table`` (..., 6) of all headings."""
    largest = np.abs(np.asarray(table)).reshape(-1, 2, 3).max(axis=(0, 2))
    size = np.abs(loads).reshape(-1, 6).max(axis=0)
    far = [dof for dof in LATERAL if size[DOFS.index(dof)] > SMALL * largest[DOFS.index(dof) // 3]]
    if far:
        yield f"{what} of {db.source} in {', '.join(far)}"


def _at_start(scene: Scene, model: Model, fresh: State, aside: Mapping[str, bool]) -> Iterator[str]:
    """What leads out of the plane in the state that a scene starts from, ``fresh`` if from no other
    run; ``aside`` says of the first states in y whether they do."""
    state, leads = fresh, np.array([*aside.values()])
    if scene.initial is not None:
        check_fit(scene, model)
        state = resume(scene, model, fresh)
    size = np.abs(state.y[: leads.size])
    still = np.where(np.arange(leads.size) < model.radiation, NEAR, NEAR * size.max())
    off = [name for name, is_off in zip(aside, leads & (size > still), strict=True) if is_off]
    if off:
        yield f"{off[0]} at the start" + (" and others" if len(off) > 1 else "")
    elif np.any(model.bodies.locked.reshape(-1, 6)[:, ASIDE]):
        yield f"{', '.join(LATERAL)} of a body are locked out of the plane"
    elif _remembers(state):
        yield "the motions before the start"
    elif not _mirrored_contacts(model, state):
        yield "the contacts at the start"
    elif _growth(scene, model, fresh, leads) > GROWTH:
        yield f"{', '.join(LATERAL)} are not stable"


def _remembers(state: State) -> bool:
    """Whether a convolution remembers velocities out of the plane."""
    velocity = state.history.velocity[: state.history.pushed[0]]
    return bool(np.any(np.abs(velocity.reshape(-1, 6)[:, ASIDE]) > NEAR))


def _mirrored_contacts(model: Model, state: State) -> bool:
    """Whether each contact point's image is stretched as it is, and in the same mode."""
    p = model.elements[FENDER]
    points, ends = p.points, p.state + STATES * p.points.size
    s = state.y[p.state : ends].reshape(-1, STATES)[:, :2, None]
    stretch = s[:, 0] * points["tangent1"] + s[:, 1] * points["tangent2"]
    here = np.stack([points["place"], points["plane_normal"], stretch], axis=1)
    whose = np.stack([points["body"], points["plane_body"], state.modes[: points.size, MODE]], 1)
    apart = np.abs((here * MIRROR_SIGN[:3])[:, None] - here).max(axis=3)
    close = apart <= SMALL * np.abs(here).max(axis=(0, 2), initial=0.0)
    images = close.all(axis=2) & np.all(whose[:, None] == whose, axis=2)
    return bool(np.all(images.any(axis=1)))


def _growth(scene: Scene, model: Model, state: State, aside: np.ndarray) -> float:
    """The fastest growth of motions out of the plane about the start [1/s]."""
    J = linearise(model, state, time=begin(scene)).jacobian
    return float(linalg.eigvals(J[: aside.size, : aside.size][np.ix_(aside, aside)]).real.max())


def _leads_aside(coordinates: Sequence[str]) -> bool:
    """Whether none of the coordinates, "sway of barge", stays in the plane."""
    return all(name.split()[0] in LATERAL for name in coordinates)


def _in_plane(scene: Scene, aside: Collection[str]) -> Scene:
    """The scene without coordinates that lead out of the plane, starting without those states."""
    bodies = tuple(
        replace(body, dofs=tuple(dof for dof in body.dofs if dof not in LATERAL))
        for body in scene.bodies
    )
    start = scene.initial
    if start is None or not isinstance(start.run, xr.Dataset):
        return replace(scene, bodies=bodies)
    kept = {
        name: [x for x in start.run[name].values if x not in aside]
        for name in ("state", "memory_dof")
        if name in start.run.dims
    }
    return replace(scene, bodies=bodies, initial=replace(start, run=start.run.sel(kept)))
