"""Free coordinates of bodies and joints: what each is, and how bodies move with them.

The coordinates of bodies come first, then those of joints (`Bodies.active`).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hydrosim.rigid.kinematics import Bodies, Motion, new_motion, place_bodies
from hydrosim.rigid.tree import BALL, SLIDE


def own_coordinates(bodies: Bodies) -> np.ndarray:
    """Indices among 6 nb of the free coordinates of bodies, without those of joints."""
    return bodies.active[: bodies.active.size - bodies.tree.coordinates]


def are_lengths(bodies: Bodies) -> np.ndarray:
    """True (n,) for coordinates in metres, false for angles."""
    moves = bodies.tree.moves
    found = np.concatenate(
        [own_coordinates(bodies) % 6 < 3, np.zeros(bodies.tree.coordinates, bool)]
    )
    found[moves["coordinate"][moves["kind"] == SLIDE]] = True
    return found


def coordinate_owners(bodies: Bodies) -> np.ndarray:
    """Body (n,) that each coordinate moves: of a joint, the one that it carries."""
    found = np.concatenate([own_coordinates(bodies) // 6, np.zeros(bodies.tree.coordinates, int)])
    for branch in bodies.tree.branches:
        for move in bodies.tree.moves[branch["first"] : branch["last"]]:
            found[move["coordinate"] :][: 3 if move["kind"] == BALL else 1] = branch["child"]
    return found


def coordinate_groups(bodies: Bodies) -> np.ndarray:
    """Number (n,) of the group of each coordinate: the three positions or the three angles of a
    body, or the motions of a joint of one kind and body."""
    kinds = 2 * (bodies.each.size + coordinate_owners(bodies)) + ~are_lengths(bodies)
    own = own_coordinates(bodies) // 3
    return np.concatenate([own, kinds[own.size :]])


def slopes_at_rest(bodies: Bodies) -> np.ndarray:
    """Displacements (6 nb, n) of all bodies per coordinate, at rest and for small angles."""
    if bodies.tree.branches.size:
        return bodies.tree.slopes
    found = np.zeros((6 * bodies.each.size, bodies.active.size))
    found[bodies.active, np.arange(bodies.active.size)] = 1.0
    return found


def moving_dofs(bodies: Bodies) -> np.ndarray:
    """DOFs among 6 nb that can move, rising."""
    return np.flatnonzero(slopes_at_rest(bodies).any(axis=1))


def positions_at(bodies: Bodies, q: np.ndarray) -> np.ndarray:
    """Displacements (nb, 6) of all bodies at the coordinates ``q`` (n,)."""
    motion = new_motion(bodies)
    place_bodies(q, np.zeros_like(q), bodies, motion)
    return motion.coordinates.reshape(-1, 6)


def slopes_at(bodies: Bodies, q: np.ndarray) -> np.ndarray:
    """S (6 nb, n) at ``q`` (n,): velocities of all bodies per rate of each coordinate."""
    return _per_rate(bodies, q, lambda motion: motion.velocity)


def coordinate_map(bodies: Bodies, q: np.ndarray) -> np.ndarray:
    """Rates (6 nb, n) of the displacements of all bodies per rate of each coordinate, at ``q``
    (n,)."""
    return _per_rate(bodies, q, lambda motion: motion.rate)


def _per_rate(
    bodies: Bodies, q: np.ndarray, measured: Callable[[Motion], np.ndarray]
) -> np.ndarray:
    """What is ``measured`` (6 nb,) of the motion at ``q`` (n,), per rate of each coordinate."""
    motion = new_motion(bodies)
    columns = []
    for rates in np.eye(q.size):
        place_bodies(q, rates, bodies, motion)
        columns.append(measured(motion).copy())
    return np.reshape(columns, (q.size, -1)).T
