"""Constants of bodies and of the joints between them, from a scene."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hydrosim.compiling.hydrostatics.tanks import steady_surface
from hydrosim.compiling.joints.trees import tree_of
from hydrosim.dofs import DOFS, about_z
from hydrosim.rigid.free import slopes_at
from hydrosim.rigid.kinematics import BODY, Bodies
from hydrosim.scene import Kinematics, Scene
from hydrosim.scene.trees import arrangement

DISPLACEMENT_RTOL = 1e-9  # of a displacement per coordinate: smaller ones are rounding
SAMPLED_CONFIGURATIONS = 3  # at which joints are looked at, besides rest


def bodies_of(scene: Scene) -> Bodies:
    """Constants of all bodies of a scene and of their joints."""
    carried = arrangement(scene).children
    own = np.array(
        [
            6 * i + DOFS.index(dof)
            for i, body in enumerate(scene.bodies)
            for dof in sorted(body.dofs, key=DOFS.index)
            if body.name not in carried
        ],
        dtype=np.int64,
    )
    each = [
        (
            b.mass,
            b.inertia,
            about_z(b.heading) @ b.centre_of_gravity + (*b.location, 0.0),
            b.heading,
            steady_surface(b, scene),
        )
        for b in scene.bodies
    ]
    constants = np.array(each, dtype=BODY)
    tree = tree_of(scene, own, constants["origin"])
    return Bodies(
        each=constants,
        active=np.concatenate([own, 6 * len(each) + np.arange(tree.coordinates)]),
        locked=np.concatenate([b.position for b in scene.bodies]).astype(float),
        exact=scene.solver.kinematics == Kinematics.EXACT,
        tree=tree,
    )


def with_dofs_of_joints(scene: Scene) -> Scene:
    """Scene in which bodies that joints carry have the degrees of freedom that their joints leave.
    Waves, memory and questions leave out the others."""
    carried = arrangement(scene).children
    if not carried:
        return scene
    bodies = bodies_of(scene)
    draw = np.random.default_rng(1)
    n = bodies.active.size
    places = [np.zeros(n), *(draw.uniform(-1.0, 1.0, n) for _ in range(SAMPLED_CONFIGURATIONS))]
    size = np.max([np.abs(slopes_at(bodies, q)).max(axis=1, initial=0.0) for q in places], axis=0)
    moves = size.reshape(-1, 6) > DISPLACEMENT_RTOL
    each = [
        replace(body, dofs=tuple(np.array(DOFS)[own])) if body.name in carried else body
        for body, own in zip(scene.bodies, moves, strict=True)
    ]
    return replace(scene, bodies=tuple(each))
