"""Scratch for constraints that hold bodies: which unit owns a row, and the reactions."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.modes import NO_INDEX


class Holds(NamedTuple):
    """Scratch for each of r constraints, and the reactions of units.

    A row belongs to a contact ``point`` (r,) and acts in the ``direction`` (r, 2) in its plane. Or
    it is row ``bit`` (r,) of a joint ``lock`` (r,), acts on its body by the ``axis`` (r, 6) of
    force and moment at the joint, and is not met by its ``residual`` (r,) [m or 1]; its ``size``
    (r,) is about J M^-1 J^T of bodies without joints. Or it holds a ``motion`` (r,) of a joint. The
    first rows belong to drives, if there are any: ``driven`` (drives, 3) are the position, speed
    and acceleration of each, and ``piece`` (drives,) the piece of its signal in the present step.
    ``reaction`` (points + locks + motions + drives, 2) are the reactions on each point's body, of
    ratchets, of stuck motions and of drives; ``joint`` (locks, 6) are force and moment of each
    joint on its body. ``conjugate`` (6,) is a force by coordinate of a body.
    """

    point: np.ndarray
    direction: np.ndarray
    lock: np.ndarray
    bit: np.ndarray
    axis: np.ndarray
    residual: np.ndarray
    size: np.ndarray
    motion: np.ndarray
    reaction: np.ndarray
    joint: np.ndarray
    driven: np.ndarray
    piece: np.ndarray
    conjugate: np.ndarray


def new_holds(reactions: int, rows: int, joints: int, drives: int) -> Holds:
    """Scratch for this number of ``reactions`` of points and locks, of ``rows`` of constraints, of
    ``joints`` that are constraints, and of ``drives``."""
    none = np.full(rows, NO_INDEX)
    return Holds(
        none,
        np.zeros((rows, 2)),
        none.copy(),
        np.zeros(rows, dtype=np.int64),
        np.zeros((rows, 6)),
        np.zeros(rows),
        np.zeros(rows),
        none.copy(),
        np.zeros((reactions, 2)),
        np.zeros((joints, 6)),
        np.zeros((drives, 3)),
        np.full(drives, NO_INDEX),
        np.zeros(6),
    )
