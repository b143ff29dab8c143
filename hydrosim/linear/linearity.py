"""Is a scene linear? Then its moving states obey z' = J z + G f(t) with constant J and G.

Small-angle kinematics are linear, and so are exact ones where no body turns about more than one
axis: E is the unit vector along it, the inertia about it does not change, and the gyroscopic moment
is across it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hydrosim.forces import (
    LINEAR_DAMPING,
    AppliedForce,
    LinearDamping,
    LinearMooring,
    Recorded,
    signals_of,
)
from hydrosim.scene import LinearScenes, Scene
from hydrosim.stepping.dynamics import Model

LINEAR = (LinearMooring, LinearDamping, AppliedForce)
"""Elements that are linear, the last two on conditions."""
ANGLES = range(3, 6)


def propagated(scene: Scene, model: Model) -> bool:
    """Whether a run of the scene is propagated exactly, not stepped."""
    asked = scene.solver.linear == LinearScenes.EXACT
    return asked and next(nonlinearities(scene, model), None) is None


def solution(scene: Scene, model: Model) -> str:
    """How the motions of a scene are found, in words."""
    if scene.solver.linear == LinearScenes.STEP:
        return "stepped: asked for by solver.linear"
    reasons = "; ".join(nonlinearities(scene, model))
    return f"stepped, not linear: {reasons}" if reasons else "propagated exactly: linear"


def nonlinearities(scene: Scene, model: Model) -> Iterator[str]:
    """What is not linear in a scene, or not propagated for other reasons."""
    if model.convolution.row.size:
        yield "radiation by convolution"
    for b in model.following.body:
        yield f"waves follow {scene.bodies[b].name}"
    for key, signal in signals_of(scene.forces):
        if isinstance(signal, Recorded):
            yield f"{key} is a record"
    for b, body in enumerate(scene.bodies):
        free = _free_angles(b, model)
        locked = [i for i in ANGLES if i not in free and body.position[i] != 0.0]
        if model.bodies.exact and (len(free) > 1 or (free and locked)):
            yield f"exact rotations of {body.name}"
    yield from _elements(scene, model)


def _elements(scene: Scene, model: Model) -> Iterator[str]:
    index = {body.name: b for b, body in enumerate(scene.bodies)}
    for name, e in scene.forces.items():
        free = _free_angles(index[e.body], model)
        if not isinstance(e, LINEAR):
            yield name
        elif isinstance(e, AppliedForce):
            if free and (e.body_fixed or (model.bodies.exact and any(e.point))):
                yield f"{name} turns with {e.body}"
        elif isinstance(e, LinearDamping) and model.bodies.exact:
            row = model.rows - len(scene.forces) + list(scene.forces).index(name)
            if any(_turns(row, angle, model) for angle in free):
                yield f"{name} turns with {e.body}"


def _free_angles(body: int, model: Model) -> list[int]:
    return [i for i in ANGLES if 6 * body + i in model.bodies.active]


def _turns(row: int, angle: int, model: Model) -> bool:
    """Whether the damping of a row depends on how far its body has turned about an axis."""
    from scipy.spatial.transform import Rotation  # slow to load, and few scenes need it

    damping = next(e["damping"] for e in model.elements[LINEAR_DAMPING] if e["row"] == row)
    axis = np.eye(3)[angle - ANGLES.start]
    R = np.kron(np.eye(2), Rotation.from_rotvec(axis).as_matrix())
    return not np.allclose(R @ damping @ R.T, damping, rtol=0.0, atol=1e-12 * np.abs(damping).max())
