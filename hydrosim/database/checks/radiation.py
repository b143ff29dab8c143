"""Checks of added mass and radiation damping against symmetry, energy and causality."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from hydrosim.database.checks.finding import Check, LeftOut, RelativeErrors
from hydrosim.database.checks.scales import added_mass_scale, damping_scale
from hydrosim.database.checks.use import CheckSubject
from hydrosim.database.database import HydroDatabase, Real, require_array
from hydrosim.dofs import MIRROR_SIGN
from hydrosim.radiation.retardation import (
    OGILVIE_BAND,
    infinite_added_mass,
    retardation_function,
)

_MAX_RETARDATION_STEPS = 400  # of a retardation function, at most
_LOWEST_FRACTION = 0.05
"""Of the highest frequency: below it added mass is not compared with the damping."""
_STEP_TIMES_FREQUENCY = 0.4  # time step of that function, times the highest frequency


ADDED_MASS_UNITS, DAMPING_UNITS = ("kg", ""), ("kg", "/s")
_RADIATION_AXES = ("frequency", "dof", "motion")


def _of_pairs(error: Real, scale: Real, unit: tuple[str, str]) -> RelativeErrors:
    """Errors (nw, n, n) or (n, n) of a matrix, relative to the ``scale`` (n,) of its rows."""
    relative = np.abs(error) / np.outer(scale, scale)
    return RelativeErrors(relative, _RADIATION_AXES[-relative.ndim :], error, unit)


def _added_mass_asymmetry(db: HydroDatabase) -> RelativeErrors:
    A = db.added_mass
    return _of_pairs(A - A.transpose(0, 2, 1), added_mass_scale(db), ADDED_MASS_UNITS)


def _damping_asymmetry(db: HydroDatabase) -> RelativeErrors:
    B = db.radiation_damping
    return _of_pairs(B - B.transpose(0, 2, 1), damping_scale(db), DAMPING_UNITS)


def _mirror(db: HydroDatabase) -> RelativeErrors:
    """Errors: coupling of symmetric with antisymmetric motions."""
    if not db.port_starboard_symmetric:
        raise LeftOut("the bodies are not symmetric about y = 0")
    sign = np.tile(MIRROR_SIGN, db.bodies)
    reversed_ = np.outer(sign, sign) < 0
    mass = _of_pairs(db.added_mass * reversed_, added_mass_scale(db), ADDED_MASS_UNITS)
    damping = _of_pairs(db.radiation_damping * reversed_, damping_scale(db), DAMPING_UNITS)
    return max(mass, damping, key=lambda errors: errors.relative.max())


def _negative_damping(db: HydroDatabase) -> RelativeErrors:
    scale = damping_scale(db)
    scaled = db.radiation_damping / np.outer(scale, scale)
    lowest = np.linalg.eigvalsh((scaled + scaled.transpose(0, 2, 1)) / 2)[:, 0]
    return RelativeErrors(np.maximum(0.0, -lowest), ("frequency",))


def _causality(db: HydroDatabase) -> RelativeErrors:
    """Errors at frequencies that are resolved and that the assumed tail of the damping hardly
    affects. In finite depth, heave added mass varies as log w below them."""
    scale = added_mass_scale(db)
    _, left = _ogilvie(db)
    share = db.frequency / db.frequency[-1]
    inner = (share >= _LOWEST_FRACTION) & (share <= OGILVIE_BAND)
    left = np.where(inner[:, None, None], left, np.nan)
    return _of_pairs(left, scale, ADDED_MASS_UNITS)


def _infinite(db: HydroDatabase) -> RelativeErrors:
    gap = require_array(db, "added_mass_infinite") - _ogilvie(db)[0]
    return _of_pairs(gap, added_mass_scale(db), ADDED_MASS_UNITS)


def _zero(db: HydroDatabase) -> RelativeErrors:
    """Errors in finite depth of surge, sway and yaw only, because the others grow as -log w for w
    -> 0."""
    gap = require_array(db, "added_mass_zero") - db.added_mass[0]
    dofs = np.arange(6 * db.bodies) % 6
    level = (dofs < 2) | (dofs == 5) | np.isinf(db.water_depth)
    return _of_pairs(
        np.where(np.outer(level, level), gap, np.nan), added_mass_scale(db), ADDED_MASS_UNITS
    )


@lru_cache(maxsize=1)
def _ogilvie(db: HydroDatabase) -> tuple[Real, Real]:
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
        _mirror,
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
        _causality,
        0.1,
        "largest difference of A(w) from that by the damping (Ogilvie 1964), relative to the"
        " diagonal; compute higher or denser frequencies, or look for frequencies not in rad/s,"
        " or a factor w or rho in one of the two",
        of=frozenset({CheckSubject.RADIATION}),
    ),
    Check(
        "added mass at infinite frequency",
        _infinite,
        0.1,
        "largest difference from the value that A(w) and the damping give by Ogilvie's (1964)"
        " relation, relative to the diagonal; hydrosim uses the latter",
        needs=("added_mass_infinite",),
        of=frozenset({CheckSubject.SPARE}),
    ),
    Check(
        "added mass at zero frequency",
        _zero,
        0.1,
        "largest difference from the lowest frequency, relative to the diagonal; start at a lower"
        " frequency, or look for a factor rho",
        needs=("added_mass_zero",),
        of=frozenset({CheckSubject.SPARE}),
    ),
)
