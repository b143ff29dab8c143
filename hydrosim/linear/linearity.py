"""Test whether a scene is linear: its moving states obey z' = J z + G f(t) with constant J and G.

Small-angle kinematics are linear. Exact kinematics are linear if no body turns about more than one
axis: E is the unit vector along it, the inertia about it is constant, and the gyroscopic moment is
perpendicular to it. If a body with hydrodynamics turns with exact kinematics, its hydrodynamics
turn with it, and the scene is not linear.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hydrosim.forces import Recorded, joints_are_linear, signals_of
from hydrosim.forces.layout import BODY_ROWS, constraint_names
from hydrosim.rigid.free import moving_dofs
from hydrosim.rigid.tree import NO_BODY, SLIDE
from hydrosim.scene import Scene, Turns
from hydrosim.stepping.dynamics import Model

ANGLES = range(3, 6)
INCLINING = range(3, 5)  # roll and pitch


def nonlinearities(scene: Scene, model: Model) -> Iterator[str]:
    """Reasons why a scene is not linear, or is not propagated."""
    if model.impulse < model.size:
        yield "output.impulses needs integrals over time steps"
    if model.convolution.row.size:
        yield "radiation by convolution"
    for b in model.following.body:
        yield f"waves follow {scene.bodies[b].name}"
    for b in model.tanks.rests["body"]:
        yield f"the contents of the tanks of {scene.bodies[b].name} change"
    for b in sorted({*model.liquids.each["body"].tolist()}):
        if any(i in _free_angles(b, model) for i in INCLINING):
            yield f"free surfaces in the tanks of {scene.bodies[b].name}"
    for b in model.hulls.body:
        yield f"buoyancy of the hull of {scene.bodies[b].name}"
    for key, signal in signals_of(scene.forces):
        if isinstance(signal, Recorded):
            yield f"{key} is a record"
    for branch in model.bodies.tree.branches if model.bodies.exact else ():
        if not _is_straight(branch, model):
            yield f"exact rotations of {scene.bodies[branch['child']].name} on its joint"
    for b, body in enumerate(scene.bodies):
        free = _free_angles(b, model)
        locked = [i for i in ANGLES if i not in free and body.position[i] != 0.0]
        turned = locked or body.heading != 0.0
        if model.bodies.exact and (len(free) > 1 or (free and turned)):
            yield f"exact rotations of {body.name}"
        elif b in model.headings.turning and (model.bodies.active.size > 1 or _stream(model)):
            yield f"hydrodynamics turn with {body.name}"
    yield from _elements(scene, model)
    for name in constraint_names(scene):
        if not scene.joints[name].lasts:
            yield f"{name} is not always closed"
        elif model.bodies.exact:
            yield f"exact rotations of the joint {name}"
    if not joints_are_linear(model):
        yield "stops or friction in joints"


def _is_straight(branch: np.void, model: Model) -> bool:
    """True for a joint to the earth that slides."""
    moves = model.bodies.tree.moves[branch["first"] : branch["last"]]
    return branch["parent"] == NO_BODY and bool(np.all(moves["kind"] == SLIDE))


def _stream(model: Model) -> bool:
    return bool(np.any(model.headings.current))


def _elements(scene: Scene, model: Model) -> Iterator[str]:
    """Reasons that elements give."""
    index = {body.name: b for b, body in enumerate(scene.bodies)}
    exact = model.bodies.exact
    for row, (name, element) in enumerate(scene.forces.items(), len(BODY_ROWS)):
        free = _free_angles(index[element.body], model)
        reason = element.nonlinearity(name, Turns(free, exact, model.elements, row))
        if element.active is not None:
            reason = f"{name} is not always active"
        if reason is not None:
            yield reason


def _free_angles(body: int, model: Model) -> list[int]:
    moving = moving_dofs(model.bodies)
    return [i for i in ANGLES if 6 * body + i in moving]
