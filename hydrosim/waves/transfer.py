"""Transfer functions of a database at the frequencies and the heading of a wave train.

Both ways by cubic splines over real and imaginary parts, exact at the nodes. In frequency, 0.02
rad/s apart, the error on a 260 m barge is below 0.02 % of the largest load up to 1 rad/s. In
heading, 15 deg apart, the error halfway between is 0.5 % of the load at 0.6 rad/s (waves of 171 m),
5 % at 0.8 rad/s (96 m), and above 15 % from 1 rad/s on (62 m): there the phase at the barge's ends
turns by more than half a circle from one heading to the next, and only more headings help.
Modulus and phase would do worse, because between two headings the modulus of a long hull's load
passes through zero and the phase jumps.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from scipy.interpolate import CubicSpline

from hydrosim.errors import InputError

_TURN = 2.0 * np.pi
_WIDEST_GAP = np.radians(45.0) + 1e-6  # [rad] between two headings to interpolate from
_NODE = 1e-9  # [rad] closer than this to a heading of the database is that heading
_END = 1.0 + 1e-9  # a regular wave at the highest frequency, despite rounding, is inside
_NOISE = 1e-12  # of the largest force or moment: below it a transfer function is zero


class TransferFunctions(Protocol):
    """What this module reads of a database: loads per wave amplitude, for exp(+i w t).

    ``source`` names it in messages. ``frequency`` (nw,) [rad/s] ascends; ``heading`` (nh,) [rad]
    are distinct directions, mirror images included. ``excitation`` (nw, nh, n) is complex, forces
    [N/m] and moments [N m/m] by turns of three; ``mean_drift`` (nw, nh, n) [N/m^2, N m/m^2].
    """

    @property
    def source(self) -> str: ...
    @property
    def frequency(self) -> np.ndarray: ...
    @property
    def heading(self) -> np.ndarray: ...
    @property
    def excitation(self) -> np.ndarray: ...
    @property
    def mean_drift(self) -> np.ndarray | None: ...


def excitation_at(database: TransferFunctions, heading: float, omega: np.ndarray) -> np.ndarray:
    """First-order transfer functions (omega.size, n) at one heading [rad].

    Zero above the highest frequency of the database; below the lowest one the value there. Raises
    InputError if the database has no headings around this one.
    """
    low, high = database.frequency[[0, -1]]
    nodes = _at_heading(database, database.excitation, heading)
    values = CubicSpline(database.frequency, nodes)(np.clip(omega, low, high))
    return np.where((omega <= high * _END)[:, None], values, 0.0)


def mean_drift_at(database: TransferFunctions, heading: float, omega: np.ndarray) -> np.ndarray:
    """Mean drift transfer functions (omega.size, n) at one heading [rad].

    Above the highest frequency of the database the value there, since all waves that are short
    are reflected alike; from the lowest one linearly to zero at zero frequency. Raises InputError
    if the database has no mean drift, or no headings around this one.
    """
    if database.mean_drift is None:
        raise InputError(
            f"{database.source}: second-order wave forces need mean drift, and this database has"
            " none; set wave_forces.second_order of the body to none, or add mean_drift to the"
            " database"
        )
    low, high = database.frequency[[0, -1]]
    nodes = _at_heading(database, database.mean_drift, heading)
    values = CubicSpline(database.frequency, nodes)(np.clip(omega, low, high))
    fade = np.where(omega < low, omega / (low or 1.0), 1.0)
    return values * fade[:, None]


def _at_heading(database: TransferFunctions, values: np.ndarray, heading: float) -> np.ndarray:
    """``values`` (nw, nh, n) at one heading, (nw, n); what is solver noise becomes zero."""
    at_heading = _interpolated(database, values, heading)
    largest = np.abs(values).max(axis=(0, 1)).reshape(-1, 3).max(axis=1)
    loaded = np.abs(at_heading).max(axis=0) > _NOISE * np.repeat(largest, 3)
    return np.where(loaded, at_heading, 0.0)


def _interpolated(database: TransferFunctions, values: np.ndarray, heading: float) -> np.ndarray:
    """``values`` (nw, nh, n) at one heading, (nw, n), by a cubic spline over the headings."""
    order, angle = _round_the_circle(database.heading)
    x = np.mod(heading - database.heading[order[0]], _TURN)
    from_node = np.abs(np.mod(x - angle + np.pi, _TURN) - np.pi)
    if from_node.min() < _NODE:
        return values[:, order[from_node.argmin()]]
    gap = np.diff(angle, append=_TURN)
    if gap[np.searchsorted(angle, x) - 1] > _WIDEST_GAP:
        raise InputError(_not_covered(database, heading))
    if gap[-1] > _WIDEST_GAP:
        return CubicSpline(angle, values[:, order], axis=1)(x)
    order, angle = np.append(order, order[0]), np.append(angle, _TURN)
    return CubicSpline(angle, values[:, order], axis=1, bc_type="periodic")(x)


def _round_the_circle(headings: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Order (nh,) of the headings from the one after the widest gap, and their angles from it."""
    order = np.argsort(np.mod(headings, _TURN))
    angle = np.mod(headings[order], _TURN)
    start = int(np.argmax(np.diff(angle, prepend=angle[-1] - _TURN)))
    order = np.roll(order, -start)
    return order, np.mod(headings[order] - headings[order[0]], _TURN)


def _not_covered(database: TransferFunctions, heading: float) -> str:
    low, high = np.degrees([database.heading.min(), database.heading.max()])
    return (
        f"{database.source}: wave heading {np.degrees(heading):g} deg is not covered, the headings"
        f" are {low:g} to {high:g} deg; change environment.waves.heading, or compute the database"
        f" for headings around it, at most {np.degrees(_WIDEST_GAP):.0f} deg apart"
    )
