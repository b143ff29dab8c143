"""Check of the damping against the wave loads.

The power that a moving body radiates in a direction determines its load in waves from that
direction (Haskind 1957; Newman 1977, Marine Hydrodynamics, 6.18). In any depth, for one body, or
for one of several while the others are held,

    B_ij = k / (8 pi rho g c_g) int_0^2pi X_i conj(X_j) d beta,   c_g = w/2k (1 + 2kh / sinh 2kh).

The relation does not depend on the time factor or on the origin of phases, but on every unit.
"""

from __future__ import annotations

import numpy as np

from hydrosim.database.checks.finding import Check, LeftOut, RelativeErrors
from hydrosim.database.checks.scales import LENGTH_POWERS, damping_scale, length, radius
from hydrosim.database.checks.use import CheckSubject
from hydrosim.database.database import PANELS_ATTRIBUTE, TURN_RAD, HydroDatabase, Real, all_headings
from hydrosim.waves.dispersion import wavenumber

_MAX_HEADING_GAP_RAD = np.radians(46.0)  # between headings: a larger gap does not close the circle
_DEEP_WATER_KH = 50.0  # k h from which on the water counts as deep
_LEVER_FRACTION = 0.03  # of V^(1/3): lever of loads misplaced by coarse panels


def _error(db: HydroDatabase) -> RelativeErrors:
    """Largest difference of B_ij from that by the loads, within each body, relative to the
    diagonal."""
    circle = all_headings(db)
    gaps = np.diff(circle.heading, append=circle.heading[0] + TURN_RAD)
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
    gap[:, _between_bodies(db)] = np.nan
    scale = _scale(db, seen)
    relative = np.abs(gap) / np.outer(scale, scale)
    return RelativeErrors(relative, ("frequency", "dof", "motion"), gap, ("kg", "/s"))


def _is_resolved(k: Real, radius: float, gap: float) -> np.ndarray:
    """Whether the trapezoidal rule over the headings is exact: |X|^2 has 2 k R waves in a turn."""
    seen = 2 * k * radius + 2 < TURN_RAD / gap
    if not seen.any():
        raise LeftOut("needs a lower frequency, or more headings")
    return seen


def _scale(db: HydroDatabase, seen: np.ndarray) -> Real:
    """Scale (n,) from the damping at those frequencies, or the noise if that is larger. The
    remainder of loads that should cancel is a small fraction of the body's largest load."""
    largest = np.abs(np.diagonal(db.radiation_damping[seen], axis1=1, axis2=2)).max(axis=0)
    own = np.maximum(np.sqrt(largest), 0.1 * damping_scale(db)).reshape(db.bodies, 6)
    lever = length(db)[:, None] ** LENGTH_POWERS
    noise = _LEVER_FRACTION * lever * (own / lever).max(axis=1, keepdims=True)
    return np.maximum(own, noise).ravel()


def _between_bodies(db: HydroDatabase) -> np.ndarray:
    """Mask (n, n) of pairs of two bodies, for which there is no such relation."""
    body = np.arange(6 * db.bodies) // 6
    return body[:, None] != body


def _wide_panels(db: HydroDatabase) -> str:
    """Cause that only a database of several bodies built from panels has."""
    if db.bodies < 2 or PANELS_ATTRIBUTE not in db.attributes:
        return ""
    return "; panels wider than the gap between two bodies are a cause: build it with smaller ones"


def _group_speed(db: HydroDatabase, k: Real) -> Real:
    kh = np.minimum(k * db.water_depth, _DEEP_WATER_KH)
    return db.frequency / (2 * k) * (1 + 2 * kh / np.sinh(2 * kh))


HASKIND = (
    Check(
        "damping against loads",
        _error,
        0.1,
        "difference from the damping that the loads of all headings give (Haskind 1957),"
        " relative to the diagonal; refine the panels, or look for factors of rho, g, w or 2,"
        " DOFs in another order or sign, rotated axes, or a wrong depth",
        refusal=0.5,
        of=frozenset({CheckSubject.RADIATION, CheckSubject.LOADS}),
        cause=_wide_panels,
    ),
)
