"""Checks of the loads in the longest waves, for which limits are known.

In waves much longer than a body, the surface about it is a plane. It rises by eta and slopes by
grad eta, and gravity is tilted with it. The water accelerates by a = -(g eta_x, g eta_y, w^2 eta).
With C about the reference point, and gravity acting there, too,

    X = C (0, 0, eta, eta_y, -eta_x, 0) + rho V (a_x, a_y, 0, 0, 0, 0) + A (a, 0, 0, 0)

to first order in the wavenumber k. The terms are hydrostatics, the pressure of the wave (Froude and
Krylov), and the water that the body diverts (G.I. Taylor's theorem; Newman 1977, Marine
Hydrodynamics, 6.16). The checks use the longest wave and, because coarse panels hide moments there,
a shorter one.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hydrosim.database import database
from hydrosim.database.checks import finding
from hydrosim.database.checks.finding import length as sides
from hydrosim.water.spectra import wavenumber

_COUPLED_INERTIA_FRACTION = 0.3
"""Fraction by which the inertia of the water may reduce the heave load."""
_WAVENUMBER_RATIO_RANGE = (0.01, 100.0)  # range of the effect of a wrong depth on the wavenumber
_TINY = 1e-300
_MAX_LONG_WAVE_KL = 0.1  # k V^(1/3) up to which the limits hold within about a per cent
_INERTIA_FRACTION = 0.05
"""Fraction by which the inertia of the water may reduce the heave load there."""
_LEVER_FRACTION = 5e-3  # of V^(1/3): displacement of the heave load by coarse panels
_HORIZONTAL_FRACTION = 1e-4  # fraction of the heave load that coarse panels make horizontal


def _static_row(db: database.HydroDatabase) -> int:
    """Index of the highest frequency at which the limits still hold and the heave load is
    static."""
    k = wavenumber(db.frequency, db.water_depth, db.gravity)
    mass = finding.displaced_mass(db) + finding.diagonal(db.added_mass)[:, 2::6]
    stiffness = finding.diagonal(database.require_array(db, "hydrostatic_stiffness"))[2::6]
    still = (db.frequency[:, None] ** 2 * mass < _INERTIA_FRACTION * stiffness).all(axis=1)
    return int(np.flatnonzero(still & (k * sides(db).max() <= _MAX_LONG_WAVE_KL)).max(initial=0))


class _Wave(NamedTuple):
    """A long wave at the bodies' reference points, per amplitude."""

    towards: database.Real  # (nh, 2)
    elevation: database.Complex  # (nh, nb)
    slope: database.Complex  # (nh, nb, 2)
    acceleration: database.Complex  # (nh, nb, 6)


def _long_wave(db: database.HydroDatabase, steeper: float = 1.0) -> _Wave:
    """Long wave for the depth, or for another depth that makes it ``steeper``."""
    k = steeper * finding.first_wavenumber(db)
    towards = np.stack([np.cos(db.heading), np.sin(db.heading)], axis=1)
    elevation = np.exp(-1j * k * (towards @ db.reference_point[:, :2].T))
    slope = -1j * k * elevation[..., None] * towards[:, None, :]
    acceleration = np.zeros((db.heading.size, db.bodies, 6), dtype=complex)
    acceleration[..., :2] = -db.gravity * slope
    acceleration[..., 2] = -(db.frequency[0] ** 2) * elevation
    return _Wave(towards, elevation, slope, acceleration)


def _loads_in_long_wave(db: database.HydroDatabase) -> database.Complex:
    """Hydrostatic load (nh, nb, 6)."""
    return db.excitation[0].reshape(db.heading.size, db.bodies, 6)


def _loads_at_bodies(db: database.HydroDatabase) -> database.Complex:
    """Loads with the phases of the elevation at the centres of buoyancy."""
    places = db.reference_point if db.centre_of_buoyancy is None else db.centre_of_buoyancy
    towards = _long_wave(db).towards
    return (
        _loads_in_long_wave(db)
        * np.exp(1j * finding.first_wavenumber(db) * (towards @ places[:, :2].T))[..., None]
    )


def _pressure_load(db: database.HydroDatabase, wave: _Wave) -> database.Complex:
    """Horizontal load (nh, nb, 2) of the undisturbed wave."""
    return finding.displaced_mass(db)[:, None] * wave.acceleration[..., :2]


def _diverted_load(db: database.HydroDatabase, wave: _Wave) -> database.Complex:
    """Load (nh, nb, 6) of the water that the bodies divert."""
    flat = wave.acceleration.reshape(db.heading.size, -1)
    return (flat @ db.added_mass[0].T).reshape(wave.acceleration.shape)


def _errors_of_dofs(
    db: database.HydroDatabase, values: database.Real, *dofs: int, size: database.Real | None = None
) -> finding.RelativeErrors:
    """Errors (nh, nb) or (nh, nb, len(dofs)) of those degrees of freedom of each body at the first
    frequency, and the absolute ``size`` of the latter."""

    def to_all_dofs(numbers: database.Real) -> database.Real:
        out = np.full((1, db.heading.size, db.bodies, 6), np.nan)
        out[0, ..., list(dofs)] = np.moveaxis(np.atleast_3d(numbers), -1, 0)
        return out.reshape(1, db.heading.size, -1)

    sizes = None if size is None else to_all_dofs(size)
    return finding.RelativeErrors(
        to_all_dofs(values), ("frequency", "heading", "dof"), sizes, ("N", "/m")
    )


def _horizontal_phase(db: database.HydroDatabase) -> finding.RelativeErrors:
    loads = _loads_at_bodies(db)
    drive = np.einsum("hbi,hi->hb", loads[..., :2], _long_wave(db).towards)
    clear = np.abs(drive) > _HORIZONTAL_FRACTION * np.abs(loads[..., 2])
    return _errors_of_dofs(db, np.where(clear, _phase_degrees(drive / 1j), np.nan), 0, 1)


def _heave_ratio(db: database.HydroDatabase) -> database.Complex:
    """Ratio X3 / C33 (nh, nb), NaN for bodies that are not at the surface."""
    stiffness = finding.diagonal(database.require_array(db, "hydrostatic_stiffness"))[2::6]
    floats = stiffness > 0
    return np.where(floats, _loads_at_bodies(db)[..., 2] / np.where(floats, stiffness, 1.0), np.nan)


def _heave_phase(db: database.HydroDatabase) -> finding.RelativeErrors:
    return _errors_of_dofs(db, _phase_degrees(_heave_ratio(db)), 2)


def _heave_size(db: database.HydroDatabase) -> finding.RelativeErrors:
    return _errors_of_dofs(db, _ratio_decades(_heave_ratio(db)), 2)


def _horizontal_size(db: database.HydroDatabase) -> finding.RelativeErrors:
    return _errors_of_dofs(db, _ratio_decades(_horizontal_ratio(db)), 0, 1)


def _horizontal_ratio(db: database.HydroDatabase) -> database.Complex:
    """Load along the waves (nh, nb), relative to its limit."""
    wave = _long_wave(db)
    expected = _pressure_load(db, wave) + _diverted_load(db, wave)[..., :2]
    load = np.einsum("hbi,hi->hb", _loads_in_long_wave(db)[..., :2], wave.towards)
    along = np.einsum("hbi,hi->hb", expected, wave.towards)
    return load / np.where(along == 0, _TINY, along)


def _wave_of_loads(db: database.HydroDatabase) -> _Wave:
    """Long wave as steep as the horizontal loads imply; a wrong depth is reported only once, by
    their size."""
    steeper = np.clip(np.median(np.abs(_horizontal_ratio(db))), *_WAVENUMBER_RATIO_RANGE)
    return _long_wave(db, float(steeper))


def _moment_errors(db: database.HydroDatabase) -> finding.RelativeErrors:
    """Errors in the longest wave, and in a shorter one with the phases of the heave load."""
    row = _static_row(db)
    shorter = database.select_frequencies(db, np.arange(db.frequency.size) == row)
    longest, other = _moments_in(db), _moments_in(_with_heave_in_phase(shorter))
    relative, size = (np.full((row + 1, *longest.relative.shape[1:]), np.nan) for _ in range(2))
    for k, errors in ((row, other), (0, longest)):
        relative[k], size[k] = errors.relative[0], np.asarray(errors.size)[0]
    return longest._replace(relative=relative, size=size)


def _with_heave_in_phase(db: database.HydroDatabase) -> database.HydroDatabase:
    """Database with phases for which the heave load is in phase with the elevation at the
    bodies."""
    heave = _loads_in_long_wave(db)[..., 2] * _long_wave(db).elevation.conj()
    turn = np.exp(-1j * np.angle(heave))
    return replace(db, excitation=db.excitation * np.repeat(turn, 6, axis=1))


def _moments_in(db: database.HydroDatabase) -> finding.RelativeErrors:
    """Error of the roll and pitch moments, relative to the sum of the sizes of their parts, or to
    the heave load times the lever of coarse panels."""
    wave = _wave_of_loads(db)
    static, diverted = _static_load(db, wave)[..., 3:5], _diverted_load(db, wave)[..., 3:5]
    error = np.abs(_loads_in_long_wave(db)[..., 3:5] - static - diverted)
    parts = (np.abs(static) + np.abs(diverted)).max(axis=0)
    slope = np.abs(wave.slope).max(axis=(0, 2))
    least = 0.1 * finding.displaced_mass(db) * db.gravity * slope * sides(db)
    noise = _LEVER_FRACTION * np.abs(_loads_in_long_wave(db)[..., 2]).max(axis=0) * sides(db)
    scale = np.maximum(parts, np.maximum(least, noise)[:, None])
    return _errors_of_dofs(db, error / scale, 3, 4, size=error)


def _static_load(db: database.HydroDatabase, wave: _Wave) -> database.Complex:
    """Load (nh, nb, 6) of the tilted water at rest, about the reference points."""
    weight = db.water_density * db.gravity * database.require_array(db, "volume")
    lever = weight * (database.require_array(db, "centre_of_gravity") - db.reference_point)[:, 2]
    stiffness = database.require_array(db, "hydrostatic_stiffness").reshape(
        db.bodies, 6, db.bodies, 6
    )
    loads = np.zeros((db.heading.size, db.bodies, 6), dtype=complex)
    for body in range(db.bodies):
        about = stiffness[body, :, body] + np.diag([0.0, 0.0, 0.0, lever[body], lever[body], 0.0])
        motion = np.zeros((db.heading.size, 6), dtype=complex)
        motion[:, 2] = wave.elevation[:, body]
        motion[:, 3], motion[:, 4] = wave.slope[:, body, 1], -wave.slope[:, body, 0]
        loads[:, body] = motion @ about.T
    return loads


def _froude_krylov(db: database.HydroDatabase) -> finding.RelativeErrors:
    """Largest error of the Froude-Krylov loads, horizontal along the waves and vertical."""
    wave = _wave_of_loads(db)
    given = database.require_array(db, "froude_krylov")[0].reshape(db.heading.size, db.bodies, 6)
    horizontal = np.einsum("hbi,hi->hb", given[..., :2] - _pressure_load(db, wave), wave.towards)
    expected = np.einsum("hbi,hi->hb", _pressure_load(db, wave), wave.towards)
    stiffness = finding.diagonal(database.require_array(db, "hydrostatic_stiffness"))[2::6]
    floats = stiffness > 0
    ratio = given[..., 2] / np.where(floats, stiffness, 1.0)
    along, heave = np.abs(horizontal / expected), np.abs(ratio - wave.elevation)
    heave = np.where(floats, heave, np.nan)
    return _errors_of_dofs(db, np.stack([along, along, heave], axis=-1), 0, 1, 2)


def _heave_is_static(db: database.HydroDatabase) -> bool:
    """Whether, in addition, the inertia of the water reduces the heave load only little."""
    if db.hydrostatic_stiffness is None:
        return False
    mass = finding.displaced_mass(db) + finding.diagonal(db.added_mass)[0, 2::6]
    stiffness = np.abs(finding.diagonal(db.hydrostatic_stiffness)[2::6])
    load = np.maximum(stiffness, np.abs(_loads_in_long_wave(db)[..., 2]).max(axis=0))
    return finding.reaches_long_waves(db) and bool(
        (db.frequency[0] ** 2 * mass < _COUPLED_INERTIA_FRACTION * load).all()
    )


def _phase_degrees(load: database.Complex) -> database.Real:
    return np.asarray(np.degrees(np.abs(np.angle(load))))


def _ratio_decades(ratio: database.Complex) -> database.Real:
    return np.asarray(np.abs(np.log10(np.maximum(np.abs(ratio), _TINY))))


_PHASE = (
    "degrees from the limit for exp(+i w t); start at a lower frequency, or look for exp(-i w t)"
    " (conjugate the loads), headings that waves come from (add 180 degrees) or another origin"
    " of the phases"
)

LONG_WAVES = (
    finding.Check(
        "phase of the horizontal load in long waves",
        _horizontal_phase,
        30.0,
        _PHASE,
        refusal=60.0,
        proves=finding.reaches_long_waves,
        of=frozenset({finding.CheckSubject.LOADS}),
    ),
    finding.Check(
        "phase of the heave load in long waves",
        _heave_phase,
        30.0,
        _PHASE,
        refusal=60.0,
        needs=("hydrostatic_stiffness",),
        proves=_heave_is_static,
        of=frozenset({finding.CheckSubject.LOADS}),
    ),
    finding.Check(
        "size of the heave load in long waves",
        _heave_size,
        0.1,
        "decimal logarithm of |X3| / C33; start at a lower frequency, or look for a factor such"
        " as rho g, or wave height used for amplitude",
        refusal=0.25,
        needs=("hydrostatic_stiffness",),
        proves=_heave_is_static,
        of=frozenset({finding.CheckSubject.LOADS, finding.CheckSubject.STIFFNESS}),
    ),
    finding.Check(
        "size of the horizontal load in long waves",
        _horizontal_size,
        0.1,
        "decimal logarithm of |X1| / (g k (rho V + A11)), along the waves at the lowest"
        " frequency; start at a lower frequency, or look for a wrong water depth (it determines"
        " k), volume, density or factor rho",
        needs=("volume",),
        of=frozenset({finding.CheckSubject.LOADS}),
    ),
    finding.Check(
        "roll and pitch moments in long waves",
        _moment_errors,
        0.1,
        "difference from the load by the stiffness on a sloping surface, relative to the"
        " moments; start at a lower frequency, or look for a stiffness without gravity, a wrong"
        " centre, exchanged roll and pitch, or pitch positive bow up",
        refusal=0.5,
        needs=("hydrostatic_stiffness", "volume", "centre_of_gravity"),
        proves=finding.reaches_long_waves,
        of=frozenset({finding.CheckSubject.LOADS, finding.CheckSubject.STIFFNESS}),
    ),
    finding.Check(
        "Froude-Krylov loads in long waves",
        _froude_krylov,
        0.1,
        "largest relative error from i rho g k V along the waves and from C33;"
        " start at a lower frequency, or look for rho g, the sign of i or a wrong depth",
        refusal=0.5,
        needs=("froude_krylov", "hydrostatic_stiffness", "volume"),
        proves=finding.reaches_long_waves,
        of=frozenset({finding.CheckSubject.SPARE}),
    ),
)
