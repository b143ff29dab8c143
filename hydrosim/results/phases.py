"""Phases of an operation that begins free and ends held by friction, from the contact history.

Contacts of one element form a group. Each group has its own phases, so a fender that is always in
contact hides no operation at another element.

    moored           until the first contact of any fender of the group
    initial contact  until there is always a fender in contact
    compressed       until the fenders stick nearly all the time
    stuck            to the end

A body sticks nearly all the time from where on every stretch of `WINDOW` has at least
`MIN_STICKING_SHARE` of its fenders' time in stick. A run that ends before a phase does not have it.

Phases are computed for every group. They are reported only for groups that go through such an
operation: they begin without contact and end stuck. Fenders of a quay and pairs of fenders do not.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from enum import IntEnum

import numpy as np

from hydrosim.forces.contact.modes import OPEN, STICK

WINDOW = 100.0  # s
MIN_STICKING_SHARE = 0.8


class Phase(IntEnum):
    """Phases in the order of time."""

    MOORED = 0
    INITIAL_CONTACT = 1
    COMPRESSED = 2
    STUCK = 3


def is_operation(phases: Iterable[int]) -> bool:
    """Whether a group of contacts with these ``phases`` begins without contact and ends stuck for
    good."""
    return {Phase.MOORED, Phase.STUCK} <= {*phases}


def contact_phases(time: np.ndarray, modes: np.ndarray) -> np.ndarray:
    """Phase (nt,) at each ``time`` (nt,) [s], evenly spaced, for contact ``modes`` (nt, nf)."""
    phase = np.full(time.size, Phase.MOORED, dtype=np.int8)
    if time.size < 2 or modes.shape[1] == 0:
        return phase
    touching = np.any(modes != OPEN, axis=1)
    first = int(touching.argmax()) if touching.any() else time.size
    closed = _last_index(np.all(modes == OPEN, axis=1)) + 1
    stuck = max(closed, _sticks_from(time, modes))
    phase[first:] = Phase.INITIAL_CONTACT
    phase[max(first, closed) :] = Phase.COMPRESSED
    phase[max(first, stuck) :] = Phase.STUCK
    return phase


def group_phases(time: np.ndarray, modes: np.ndarray, groups: Sequence[str]) -> np.ndarray:
    """Phases (nt, ng) of each group of contacts, in the order of their names, from contact
    ``modes`` (nt, nf). ``groups`` (nf,) are the groups of the contacts."""
    names = np.array(groups)
    each = [contact_phases(time, modes[:, names == name]) for name in dict.fromkeys(groups)]
    return np.stack(each, axis=1)


def _last_index(condition: np.ndarray) -> int:
    """Index of the last true entry, -1 if there is none."""
    return int(condition.size - 1 - condition[::-1].argmax()) if condition.any() else -1


def _sticks_from(time: np.ndarray, modes: np.ndarray) -> int:
    """Index from which on all windows have enough stick."""
    share = np.mean(modes == STICK, axis=1)
    width = max(round(WINDOW / (time[1] - time[0])), 1)
    if share.size < width:
        return share.size
    mean = np.convolve(share, np.full(width, 1.0 / width), mode="valid")
    found = _last_index(mean < MIN_STICKING_SHARE) + 1
    return found if found < mean.size else share.size
