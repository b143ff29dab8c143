"""Checks of added mass and damping against symmetry, energy, causality and wave loads.

Check of the damping against the wave loads.

The power that a moving body radiates in a direction determines its load in waves from that
direction (Haskind 1957; Newman 1977, Marine Hydrodynamics, 6.18). In any depth, for one body, or
for one of several while the others are held,

    B_ij = k / (8 pi rho g c_g) int_0^2pi X_i conj(X_j) d beta,   c_g = w/2k (1 + 2kh / sinh 2kh).

The relation does not depend on the time factor or on the origin of phases, but on every unit.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from hydrosim.database import database
from hydrosim.database.checks.finding import (
    LENGTH_POWERS,
    Check,
    CheckSubject,
    LeftOut,
    RelativeErrors,
    added_mass_scale,
    damping_scale,
    length,
    radius,
)
from hydrosim.dofs import MIRROR_SIGN
from hydrosim.water.radiation.retardation import (
    OGILVIE_BAND,
    infinite_added_mass,
    retardation_function,
)
from hydrosim.water.spectra import wavenumber

_MAX_RETARDATION_STEPS = 400  # of a retardation function, at most
_LOWEST_FRACTION = 0.05
"""Of the highest frequency: below it added mass is not compared with the damping."""
_STEP_TIMES_FREQUENCY = 0.4  # time step of that function, times the highest frequency


ADDED_MASS_UNITS, DAMPING_UNITS = ("kg", ""), ("kg", "/s")
_RADIATION_AXES = ("frequency", "dof", "motion")


def _errors_of_pairs(
    error: database.Real, scale: database.Real, unit: tuple[str, str]
) -> RelativeErrors:
    """Errors (nw, n, n) or (n, n) of a matrix, relative to the ``scale`` (n,) of its rows."""
    relative = np.abs(error) / np.outer(scale, scale)
    return RelativeErrors(relative, _RADIATION_AXES[-relative.ndim :], error, unit)


def _added_mass_asymmetry(db: database.HydroDatabase) -> RelativeErrors:
    A = db.added_mass
    return _errors_of_pairs(A - A.transpose(0, 2, 1), added_mass_scale(db), ADDED_MASS_UNITS)


def _damping_asymmetry(db: database.HydroDatabase) -> RelativeErrors:
    B = db.radiation_damping
    return _errors_of_pairs(B - B.transpose(0, 2, 1), damping_scale(db), DAMPING_UNITS)


def _symmetry_errors(db: database.HydroDatabase) -> RelativeErrors:
    """Errors: coupling of symmetric with antisymmetric motions."""
    if not db.port_starboard_symmetric:
        raise LeftOut("the bodies are not symmetric about y = 0")
    sign = np.tile(MIRROR_SIGN, db.bodies)
    reversed_ = np.outer(sign, sign) < 0
    mass = _errors_of_pairs(db.added_mass * reversed_, added_mass_scale(db), ADDED_MASS_UNITS)
    damping = _errors_of_pairs(db.radiation_damping * reversed_, damping_scale(db), DAMPING_UNITS)
    return max(mass, damping, key=lambda errors: errors.relative.max())


def _negative_damping(db: database.HydroDatabase) -> RelativeErrors:
    scale = damping_scale(db)
    scaled = db.radiation_damping / np.outer(scale, scale)
    lowest = np.linalg.eigvalsh((scaled + scaled.transpose(0, 2, 1)) / 2)[:, 0]
    return RelativeErrors(np.maximum(0.0, -lowest), ("frequency",))


def _causality_errors(db: database.HydroDatabase) -> RelativeErrors:
    """Errors at frequencies that are resolved and that the assumed tail of the damping hardly
    affects. In finite depth, heave added mass varies as log w below them."""
    scale = added_mass_scale(db)
    _, left = _ogilvie_integrals(db)
    share = db.frequency / db.frequency[-1]
    inner = (share >= _LOWEST_FRACTION) & (share <= OGILVIE_BAND)
    left = np.where(inner[:, None, None], left, np.nan)
    return _errors_of_pairs(left, scale, ADDED_MASS_UNITS)


def _infinite_frequency_errors(db: database.HydroDatabase) -> RelativeErrors:
    gap = database.require_array(db, "added_mass_infinite") - _ogilvie_integrals(db)[0]
    return _errors_of_pairs(gap, added_mass_scale(db), ADDED_MASS_UNITS)


def _zero_frequency_errors(db: database.HydroDatabase) -> RelativeErrors:
    """Errors in finite depth of surge, sway and yaw only, because the others grow as -log w for w
    -> 0."""
    gap = database.require_array(db, "added_mass_zero") - db.added_mass[0]
    dofs = np.arange(6 * db.bodies) % 6
    level = (dofs < 2) | (dofs == 5) | np.isinf(db.water_depth)
    return _errors_of_pairs(
        np.where(np.outer(level, level), gap, np.nan), added_mass_scale(db), ADDED_MASS_UNITS
    )


@lru_cache(maxsize=1)
def _ogilvie_integrals(db: database.HydroDatabase) -> tuple[database.Real, database.Real]:
    """A_inf (n, n) from the damping, and the remainder of A(w) (nw, n, n), by a retardation
    function as long and as fine as the frequencies allow."""
    w = db.frequency
    if w.size < 4:
        raise LeftOut(f"needs 4 frequencies, the database has {w.size}")
    step = _STEP_TIMES_FREQUENCY / w[-1]
    time = np.arange(0.0, min(np.pi / np.diff(w).max(), _MAX_RETARDATION_STEPS * step), step)
    kernel = retardation_function(w, db.radiation_damping, time)
    return infinite_added_mass(w, db.added_mass, time, kernel)


RADIATION = (
    Check(
        "symmetry of added mass",
        _added_mass_asymmetry,
        0.02,
        "largest |M_ij - M_ji| / sqrt(M_ii M_jj), zero in theory; refine the panels, or look for"
        " mixed units or DOFs in another order",
        refusal=0.1,
        of=frozenset({CheckSubject.RADIATION}),
    ),
    Check(
        "symmetry of radiation damping",
        _damping_asymmetry,
        0.02,
        "largest |M_ij - M_ji| / sqrt(M_ii M_jj), zero in theory; refine the panels, or look for"
        " mixed units or DOFs in another order",
        refusal=0.1,
        of=frozenset({CheckSubject.RADIATION}),
    ),
    Check(
        "port and starboard",
        _symmetry_errors,
        0.02,
        "largest coupling of surge, heave or pitch with sway, roll or yaw, zero for a hull that"
        " is symmetric about y = 0; look for DOFs in another order or rotated axes",
        refusal=0.1,
        of=frozenset({CheckSubject.RADIATION}),
    ),
    Check(
        "positive damping",
        _negative_damping,
        0.005,
        "most negative eigenvalue of the damping matrix of all bodies, relative to its largest"
        " diagonal; negative damping would create energy: look for irregular frequencies, coarse"
        " panels or a wrong sign",
        refusal=0.3,
        of_all=True,
        of=frozenset({CheckSubject.RADIATION}),
    ),
    Check(
        "added mass against damping",
        _causality_errors,
        0.1,
        "largest difference of A(w) from that by the damping (Ogilvie 1964), relative to the"
        " diagonal; compute higher or denser frequencies, or look for frequencies not in rad/s,"
        " or a factor w or rho in one of the two",
        of=frozenset({CheckSubject.RADIATION}),
    ),
    Check(
        "added mass at infinite frequency",
        _infinite_frequency_errors,
        0.1,
        "largest difference from the value that A(w) and the damping give by Ogilvie's (1964)"
        " relation, relative to the diagonal; hydrosim uses the latter",
        needs=("added_mass_infinite",),
        of=frozenset({CheckSubject.SPARE}),
    ),
    Check(
        "added mass at zero frequency",
        _zero_frequency_errors,
        0.1,
        "largest difference from the lowest frequency, relative to the diagonal; start at a lower"
        " frequency, or look for a factor rho",
        needs=("added_mass_zero",),
        of=frozenset({CheckSubject.SPARE}),
    ),
)


_MAX_HEADING_GAP_RAD = np.radians(46.0)  # between headings: a larger gap does not close the circle
_DEEP_WATER_KH = 50.0  # k h from which on the water counts as deep
_LEVER_FRACTION = 0.03  # of V^(1/3): lever of loads misplaced by coarse panels


def _haskind_errors(db: database.HydroDatabase) -> RelativeErrors:
    """Largest difference of B_ij from that by the loads, within each body, relative to the
    diagonal."""
    circle = database.all_headings(db)
    gaps = np.diff(circle.heading, append=circle.heading[0] + database.TURN_RAD)
    if gaps.max() > _MAX_HEADING_GAP_RAD:
        raise LeftOut(
            "needs headings all around, at most 45 deg apart; the widest gap is"
            f" {np.degrees(gaps.max()):.0f} deg"
        )
    k = wavenumber(db.frequency, db.water_depth, db.gravity)
    seen = _is_resolved(k, radius(db).max(), gaps.max())
    weight = (gaps + np.roll(gaps, 1)) / 2
    loads = circle.excitation[seen]
    integral = np.einsum("h,whi,whj->wij", weight, loads, loads.conj(), optimize=True)
    density = 8 * np.pi * db.water_density * db.gravity * _group_speed(db, k)
    gap = np.full(db.radiation_damping.shape, np.nan)
    gap[seen] = (k / density)[seen, None, None] * integral.real - db.radiation_damping[seen]
    gap[:, _pairs_between_bodies(db)] = np.nan
    scale = _error_scale(db, seen)
    relative = np.abs(gap) / np.outer(scale, scale)
    return RelativeErrors(relative, ("frequency", "dof", "motion"), gap, ("kg", "/s"))


def _is_resolved(k: database.Real, radius: float, gap: float) -> np.ndarray:
    """Whether the trapezoidal rule over the headings is exact: |X|^2 has 2 k R waves in a turn."""
    seen = 2 * k * radius + 2 < database.TURN_RAD / gap
    if not seen.any():
        raise LeftOut("needs a lower frequency, or more headings")
    return seen


def _error_scale(db: database.HydroDatabase, seen: np.ndarray) -> database.Real:
    """Scale (n,) from the damping at those frequencies, or the noise if that is larger. The
    remainder of loads that should cancel is a small fraction of the body's largest load."""
    largest = np.abs(np.diagonal(db.radiation_damping[seen], axis1=1, axis2=2)).max(axis=0)
    scales = np.maximum(np.sqrt(largest), 0.1 * damping_scale(db)).reshape(db.bodies, 6)
    lever = length(db)[:, None] ** LENGTH_POWERS
    noise = _LEVER_FRACTION * lever * (scales / lever).max(axis=1, keepdims=True)
    return np.maximum(scales, noise).ravel()


def _pairs_between_bodies(db: database.HydroDatabase) -> np.ndarray:
    """Mask (n, n) of pairs of two bodies, for which there is no such relation."""
    body = np.arange(6 * db.bodies) // 6
    return body[:, None] != body


def _wide_panels(db: database.HydroDatabase) -> str:
    """Cause that only a database of several bodies built from panels has."""
    if db.bodies < 2 or database.PANELS_ATTRIBUTE not in db.attributes:
        return ""
    return "; panels wider than the gap between two bodies are a cause: build it with smaller ones"


def _group_speed(db: database.HydroDatabase, k: database.Real) -> database.Real:
    kh = np.minimum(k * db.water_depth, _DEEP_WATER_KH)
    return db.frequency / (2 * k) * (1 + 2 * kh / np.sinh(2 * kh))


HASKIND = (
    Check(
        "damping against loads",
        _haskind_errors,
        0.1,
        "difference from the damping that the loads of all headings give (Haskind 1957),"
        " relative to the diagonal; refine the panels, or look for factors of rho, g, w or 2,"
        " DOFs in another order or sign, rotated axes, or a wrong depth",
        refusal=0.5,
        of=frozenset({CheckSubject.RADIATION, CheckSubject.LOADS}),
        cause=_wide_panels,
    ),
)
