"""Free coordinates of a scene: their velocities, their inertia, and difference steps."""

from __future__ import annotations

import numpy as np

from hydrosim.forces import in_gusts
from hydrosim.rigid.kinematics import acceleration_map, place_bodies
from hydrosim.stepping.blending import blend_draughts
from hydrosim.stepping.dynamics import Model, find_mass, new_work, update_contents
from hydrosim.streams.gusts import NO_GUSTS
from hydrosim.waves.build import wave_loads_model
from hydrosim.waves.displaced_loads import following_model

STEP = 1e-4  # of the central differences: m, rad and their rates
CALM = wave_loads_model((), (), 0.0, 1.0, 1.0)
NO_FOLLOWED_BODIES = following_model((), ())


def without_waves(model: Model) -> Model:
    """The model in calm water and in the mean wind."""
    elements = in_gusts(model.elements, NO_GUSTS)
    return model._replace(waves=CALM, following=NO_FOLLOWED_BODIES, elements=elements)


def inertia(model: Model, y: np.ndarray) -> np.ndarray:
    """Inertia (n, n) of the free coordinates, added mass included, in the state ``y`` with its slow
    draughts and tank contents."""
    work = new_work(model)
    n = model.bodies.active.size
    A = model.added_mass
    found = np.zeros((n, n))
    place_bodies(y[:n], y[n : 2 * n], model.bodies, work.motion)
    if model.family.body.size:
        blend_draughts(y[model.draught :], model.family, A, work.blend)
        A = work.blend.added_mass
    update_contents(y, model, work)
    find_mass(model, A, work)
    acceleration_map(model.bodies, work.motion, work.mass, found)
    return found
