"""The hydrodynamic database: frequency-domain coefficients of one or more floating bodies.

Frame: the database's own, origin on the still waterline, x forward, y to port, z up. Coefficients
refer to ``reference_point``. Phases refer to the wave elevation at the frame's origin and to the
time factor exp(+i w t). Headings are the directions that waves go to.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrosim.dofs import MIRROR_SIGN
from hydrosim.errors import InputError

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

TURN_RAD = 2 * np.pi
SAME_HEADING = 1e-9  # rad: closer headings are equal
PANELS_ATTRIBUTE = "panels"  # attribute of databases built from panels: their numbers, as JSON


@dataclass(frozen=True, eq=False, kw_only=True)
class HydroDatabase:
    """Coefficients in SI units and radians, n = 6 x number of bodies (nb), DOFs body by body.

    ``frequency`` (nw,) [rad/s] and ``heading`` (nh,) [rad] ascend. ``added_mass`` and
    ``radiation_damping`` (nw, n, n) give the force on the row's DOF by motion of the column's;
    ``added_mass_zero`` and ``added_mass_infinite`` (n, n) are their limits. ``excitation`` and its
    part ``froude_krylov`` (nw, nh, n) are loads per unit wave amplitude; ``mean_drift`` (nw, nh, n)
    is the mean second-order load per amplitude squared [N/m^2, N m/m^2] and ``drift_imbalance``
    (nw, nh) its relative energy error; ``mean_drift_held`` is that of bodies held at rest.
    ``hydrostatic_stiffness`` (n, n) includes gravity about ``centre_of_gravity``.
    ``inertia_matrix`` (n, n) is about ``reference_point``. Points are (nb, 3), ``volume`` is (nb,).
    An infinite ``water_depth`` is ``math.inf``.

    Quadratic transfer functions, on ascending frequencies of their own, ``qtf_frequency`` (nq,),
    and for pairs of headings ``qtf_heading`` (np, 2): ``qtf_difference`` and ``qtf_sum``
    (np, nq, nq, n), the loads of two waves of complex amplitudes a_1, a_2 at w_1 (first axis,
    first heading) and w_2 being

        F(t) = Re sum_1 sum_2 [ a_1 conj(a_2) T-_12 exp(i (w_1 - w_2) t)
                              + a_1 a_2 T+_12 exp(i (w_1 + w_2) t) ]

    over all ordered pairs, so that T-_21 = conj T-_12 where the headings swap too, T+_21 = T+_12,
    and the diagonal of T- is the mean drift.

    ``port_starboard_symmetric``: each body is symmetric about y = 0. ``attributes`` describe the
    hull and the program that computed it. Data that the file did not have are None; `require_array`
    returns them or raises. Raises `InputError` if a shape does not fit or a number is NaN.
    """

    source: str
    frequency: Real
    heading: Real
    added_mass: Real
    radiation_damping: Real
    excitation: Complex
    reference_point: Real
    water_depth: float
    water_density: float
    gravity: float
    port_starboard_symmetric: bool
    hydrostatic_stiffness: Real | None = None
    volume: Real | None = None
    centre_of_buoyancy: Real | None = None
    centre_of_gravity: Real | None = None
    added_mass_zero: Real | None = None
    added_mass_infinite: Real | None = None
    froude_krylov: Complex | None = None
    mean_drift: Real | None = None
    mean_drift_held: Real | None = None
    drift_imbalance: Real | None = None
    qtf_frequency: Real | None = None
    qtf_heading: Real | None = None
    qtf_difference: Complex | None = None
    qtf_sum: Complex | None = None
    inertia_matrix: Real | None = None
    attributes: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, expected in self._shapes().items():
            value = getattr(self, name)
            if value is None:
                continue
            if value.shape != expected:
                raise InputError(
                    f"{self.source}: {name} has shape {value.shape}, expected {expected} for"
                    f" {self.bodies} bodies, {self.frequency.size} frequencies and"
                    f" {self.heading.size} headings. Correct the file, or the recipe that made"
                    " it."
                )
            if not np.isfinite(value).all():
                raise InputError(
                    f"{self.source}: {name} has {np.count_nonzero(~np.isfinite(value))} values of"
                    f" {value.size} that are not numbers. The solver probably failed there:"
                    f" compute them again{self._remedy_for_gaps(name, value)}."
                )

        for name in ("water_depth", "water_density", "gravity"):
            if not getattr(self, name) > 0:
                raise InputError(
                    f"{self.source}: {name} is {getattr(self, name)}, expected a positive number."
                )

    def _remedy_for_gaps(self, name: str, value: Any) -> str:
        """How to leave out frequencies without numbers, if those with numbers are neighbours."""
        if name not in _BY_FREQUENCY[1:] or not np.isfinite(self.frequency).all():
            return ""
        bad = ~np.isfinite(value).reshape(self.frequency.size, -1).all(axis=1)
        return remedy_for_gaps(self.frequency, bad)

    def _shapes(self) -> dict[str, tuple[int, ...]]:
        bodies, n = self.bodies, 6 * self.bodies
        nw, nh = self.frequency.size, self.heading.size
        nq = 0 if self.qtf_frequency is None else self.qtf_frequency.size
        pairs = 0 if self.qtf_heading is None else len(self.qtf_heading)
        point, square, loads, pair = (bodies, 3), (n, n), (nw, nh, n), (pairs, nq, nq, n)
        return {
            "frequency": (nw,),
            "heading": (nh,),
            "added_mass": (nw, *square),
            "radiation_damping": (nw, *square),
            "added_mass_zero": square,
            "added_mass_infinite": square,
            "excitation": loads,
            "froude_krylov": loads,
            "mean_drift": loads,
            "mean_drift_held": loads,
            "qtf_frequency": (nq,),
            "qtf_heading": (pairs, 2),
            "qtf_difference": pair,
            "qtf_sum": pair,
            "drift_imbalance": (nw, nh),
            "hydrostatic_stiffness": square,
            "inertia_matrix": square,
            "volume": (bodies,),
            "centre_of_buoyancy": point,
            "centre_of_gravity": point,
            "reference_point": point,
        }

    @property
    def bodies(self) -> int:
        """Number of bodies."""
        return len(self.reference_point)

    @cached_property
    def checksum(self) -> str:
        """SHA-256 (hex) over all numbers: databases with the same checksum give the same
        results."""
        digest = hashlib.sha256()
        for item in fields(self):
            value = getattr(self, item.name)
            if isinstance(value, np.ndarray | float):
                array = np.ascontiguousarray(value)
                digest.update(f"{item.name} {array.shape} {array.dtype.str}".encode())
                digest.update(array.tobytes())
        digest.update(f"symmetric {self.port_starboard_symmetric}".encode())
        return digest.hexdigest()


def remedy_for_gaps(frequency: Real, bad: NDArray[np.bool_]) -> str:
    """How to leave out the ``bad`` rows of rising frequencies (nw,) [rad/s]: the longest range
    without them, or nothing if it has fewer than two."""
    edges = np.flatnonzero(np.diff(np.concatenate([[True], bad, [True]]).astype(int)))
    starts, ends = edges[::2], edges[1::2]
    if starts.size == 0 or (ends - starts).max() < 2:
        return ""
    longest = int(np.argmax(ends - starts))
    low, high = frequency[starts[longest]], frequency[ends[longest] - 1]
    return (
        f", or leave them out by `hydrodynamics: {{file: ..., frequencies: [{low:.6g} rad/s,"
        f" {high:.6g} rad/s]}}`, or --given"
    )


GIVEN_ARRAYS = {"volume", "centre_of_buoyancy", "centre_of_gravity"}
"""Optional arrays that a case may give under `hydrodynamics`."""


def require_array(db: HydroDatabase, name: str) -> Real:
    """An optional array. Raises `InputError` if this database does not have it."""
    value = getattr(db, name)
    if value is None:
        raise InputError(
            f"{db.source}: found no {name.replace('_', ' ')}; this computation uses it."
            f" {_missing_array_remedy(name)}"
        )
    return np.asarray(value)


def _missing_array_remedy(name: str) -> str:
    """Advice on how to give an optional array that a database lacks."""
    if name not in GIVEN_ARRAYS:
        return f"Use a database that holds the array {name} (`hydrosim db build` writes it)."
    return (
        f"Give it in the case, `hydrodynamics: {{file: ..., {name}: ...}}`, or store it in the"
        f" database: `hydrosim db convert FILE OUT.nc --given {name}=...`."
    )


def all_headings(db: HydroDatabase) -> HydroDatabase:
    """Database with the full circle of headings, ascending in [0, 2 pi).

    On a symmetric hull, loads of waves towards -b equal those towards b with sway, roll and yaw
    reversed. Missing headings are added by this rule, and so are pairs of headings of the quadratic
    transfer functions. Headings of a hull without symmetry are only brought into the range.
    """
    heading, rows, sign = _full_circle(db, db.heading[:, None])
    pair, pair_rows, pair_sign = _full_circle(
        db, np.empty((0, 2)) if db.qtf_heading is None else db.qtf_heading
    )

    def loads(value: Any) -> Any:
        return None if value is None else value[:, rows] * sign

    def transfer(value: Any) -> Any:
        return None if value is None else value[pair_rows] * pair_sign[:, None, None]

    return replace(
        db,
        heading=heading[:, 0],
        excitation=loads(db.excitation),
        froude_krylov=loads(db.froude_krylov),
        mean_drift=loads(db.mean_drift),
        mean_drift_held=loads(db.mean_drift_held),
        drift_imbalance=None if db.drift_imbalance is None else db.drift_imbalance[:, rows],
        qtf_heading=None if db.qtf_heading is None else pair,
        qtf_difference=transfer(db.qtf_difference),
        qtf_sum=transfer(db.qtf_sum),
    )


_BY_FREQUENCY = (
    "frequency",
    "added_mass",
    "radiation_damping",
    "excitation",
    "froude_krylov",
    "mean_drift",
    "mean_drift_held",
    "drift_imbalance",
)


def select_frequencies(db: HydroDatabase, keep: NDArray[np.bool_]) -> HydroDatabase:
    """Database with some of its frequencies (nw,). Quadratic transfer functions have their own
    frequencies and are unchanged."""
    values = {name: getattr(db, name) for name in _BY_FREQUENCY}
    return replace(db, **{name: v[keep] for name, v in values.items() if v is not None})


def _full_circle(db: HydroDatabase, angle: Real) -> tuple[Real, NDArray[np.intp], Real]:
    """Directions (m, k) of k waves each and of their images, each once in the first turn; indices
    of their rows in ``angle``; the signs (m, n) of their loads."""
    rows = np.arange(len(angle))
    mirrored = np.zeros(len(angle), dtype=bool)
    if db.port_starboard_symmetric:
        angle, rows = np.concatenate([angle, -angle]), np.tile(rows, 2)
        mirrored = np.concatenate([mirrored, ~mirrored])
    angle = np.mod(angle, TURN_RAD)
    angle[TURN_RAD - angle < SAME_HEADING] = 0.0
    keep = np.unique(_unit_directions(angle), axis=0, return_index=True)[1]
    sign = np.where(mirrored[keep, None], np.tile(MIRROR_SIGN, db.bodies), 1.0)
    return angle[keep], rows[keep], sign


def _unit_directions(angle: Real) -> NDArray[np.intp]:
    """Integers that increase with the angles, equal for equal directions."""
    order = np.argsort(angle, axis=None)
    numbers = np.empty(angle.size, dtype=np.intp)
    numbers[order] = np.cumsum(np.diff(angle.ravel()[order], prepend=-TURN_RAD) > SAME_HEADING)
    return numbers.reshape(angle.shape)
