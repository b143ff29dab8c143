"""A body and the contents of its tanks together: mass, centre of gravity, inertia, free
surfaces."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.scene import Body, FreeSurface, Tank
from hydrosim.tanks.contents import changing_tanks
from hydrosim.tanks.pieces import FIRST_MOMENT, PAIRS, SECOND_MOMENT, SURFACE_MOMENT, quantities_at
from hydrosim.tanks.shapes import pieces, volume_at


class Loading(NamedTuple):
    """``mass`` [kg], ``centre`` of gravity (3,) [m], ``inertia`` (3, 3) about it [kg m^2], and
    ``surface`` (3,) [kg m^2], density times second moments xx, xy, yy of the free surfaces."""

    mass: float
    centre: np.ndarray
    inertia: np.ndarray
    surface: np.ndarray

    @property
    def matrix(self) -> np.ndarray:
        """6 x 6 matrix about the origin of the frame in which the centre is given."""
        cross = np.cross(np.eye(3), self.mass * self.centre)
        turning = self.inertia + self.mass * _moments_of_inertia(np.outer(self.centre, self.centre))
        return np.block([[self.mass * np.eye(3), cross.T], [cross, turning]])


def loaded_body(
    mass: float,
    centre: Iterable[float],
    inertia: np.ndarray,
    contents: Iterable[tuple[Tank, float]],
    sign: float = 1.0,
) -> Loading:
    """A body with the ``contents``, tanks and their volumes [m^3], added (or subtracted if ``sign``
    is -1); all in one frame."""
    c = np.array([*centre], dtype=float)
    first, second, surface = mass * c, mass * np.outer(c, c), np.zeros(3)
    for tank, volume in contents:
        held = sign * tank.density * quantities_at(pieces(tank.shape, np.zeros(3)), volume)
        mass += sign * tank.density * volume
        first += held[FIRST_MOMENT : FIRST_MOMENT + 3]
        second += symmetric_matrix(held[SECOND_MOMENT : SECOND_MOMENT + 6])
        if tank.surface == FreeSurface.QUASI_STATIC:
            surface += held[SURFACE_MOMENT:]
    C = first / mass
    about = inertia + _moments_of_inertia(second - mass * np.outer(C, C))
    return Loading(float(mass), C, about, surface)


def body_without(body: Body, contents: Iterable[tuple[Tank, float]]) -> Loading:
    """A body without the contents of some of its tanks at the start."""
    return loaded_body(body.mass, body.centre_of_gravity, body.inertia, contents, -1.0)


def least_moment(body: Body, inertia: np.ndarray) -> float:
    """The least moment [kg m^2] of an ``inertia`` (3, 3) about the free axes of rotation; infinite
    if the body may not turn."""
    turns = [i for i in range(3) if DOFS[3 + i] in body.dofs]
    return float(np.linalg.eigvalsh(inertia[np.ix_(turns, turns)])[0]) if turns else np.inf


def at_start(tanks: Iterable[Tank]) -> list[tuple[Tank, float]]:
    """Tanks with their contents at the start."""
    return [(tank, volume_at(tank.shape, tank.level)) for tank in tanks]


def contents_at(
    bodies: Sequence[Body], moved: Iterable[float]
) -> Iterator[tuple[int, Tank, float]]:
    """All tanks by the number of their body, with their volumes [m^3]; ``moved`` are the volumes in
    tanks that change."""
    volumes = iter(moved)
    for b, body in enumerate(bodies):
        every = changing_tanks(body)
        for tank, volume in at_start(body.tanks):
            yield b, tank, float(next(volumes)) if tank in every else volume


def symmetric_matrix(six: np.ndarray) -> np.ndarray:
    """Matrix (3, 3) from xx, yy, zz, xy, xz, yz."""
    full = np.zeros((3, 3))
    for (i, j), value in zip(PAIRS, six, strict=True):
        full[i, j] = full[j, i] = value
    return full


def _moments_of_inertia(P: np.ndarray) -> np.ndarray:
    """tr P - P: moments of inertia of second moments."""
    return np.trace(P) * np.eye(3) - P
