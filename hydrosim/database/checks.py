"""Checks of a hydrodynamic database against what physics demands of any floating body.

Each finding is one figure, zero at best, with a limit above which to look closer and, where only a
wrong sign, unit or convention can be the cause, a refusal above which the database is not used.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrosim.database.database import HydroDatabase, Real, needed

# A DOF with less added mass or damping than this share of the body's own scale is noise.
_NOISE = 1e-4
_TAIL_FROM = 0.85  # the decay of the damping is taken from this share of the highest frequency up
_LONG_WAVE = 0.3  # k V^(1/3) below which the limits of long waves must show


@dataclass(frozen=True)
class Finding:
    """Outcome of one check: ``figure`` is to stay below ``limit``; above ``refusal`` the database
    is unusable. ``advice`` says what the figure is and what to do."""

    name: str
    figure: float
    limit: float
    advice: str
    refusal: float = np.inf

    @property
    def passed(self) -> bool:
        """True up to the limit."""
        return self.figure <= self.limit

    @property
    def refused(self) -> bool:
        """True above the refusal."""
        return self.figure > self.refusal


def check(db: HydroDatabase) -> list[Finding]:
    """All findings about ``db``; only those about frequencies and headings if they are refused,
    because no other figure means anything then."""
    ranges = [_frequencies(db), _headings(db)]
    if any(finding.refused for finding in ranges):
        return ranges
    return [
        *ranges,
        _symmetry("symmetry of added mass", db.added_mass, _added_mass_scale(db)),
        _symmetry("symmetry of radiation damping", db.radiation_damping, _damping_scale(db)),
        _positive_damping(db),
        _kernel_truncation(db),
        _waterplane(db),
        _weight(db),
        *_long_waves(db),
    ]


def _frequencies(db: HydroDatabase) -> Finding:
    steps = np.diff(db.frequency, prepend=0.0)
    return Finding(
        "frequencies",
        float(np.count_nonzero(steps <= 0)),
        0.0,
        "number of frequencies that are not above zero and the one before; sort them, in rad/s",
        refusal=0.0,
    )


def _headings(db: HydroDatabase) -> Finding:
    wrong = np.count_nonzero(np.diff(db.heading) <= 0)
    wrong += np.count_nonzero(np.abs(db.heading) > 2 * np.pi + 1e-9)
    return Finding(
        "headings",
        float(wrong),
        0.0,
        "number of headings that do not ascend or lie beyond a full turn; sort them, in rad",
        refusal=0.0,
    )


def _symmetry(name: str, matrix: Real, scale: Real) -> Finding:
    skew = np.abs(matrix - matrix.transpose(0, 2, 1)) / np.outer(scale, scale)
    return Finding(
        name,
        float(skew.max()),
        0.02,
        "largest |M_ij - M_ji| / sqrt(M_ii M_jj), zero in theory; refine the panels, or look for"
        " mixed units or DOFs in another order",
        refusal=0.1,
    )


def _positive_damping(db: HydroDatabase) -> Finding:
    scale = _damping_scale(db)
    scaled = db.radiation_damping / np.outer(scale, scale)
    lowest = np.linalg.eigvalsh((scaled + scaled.transpose(0, 2, 1)) / 2).min()
    return Finding(
        "positive damping",
        float(max(0.0, -lowest)),
        0.005,
        "most negative eigenvalue of the damping matrix of all bodies, relative to its largest"
        " diagonal; negative damping makes waves out of nothing: look for irregular frequencies,"
        " coarse panels or a wrong sign",
        refusal=0.05,
    )


def _kernel_truncation(db: HydroDatabase) -> Finding:
    """Share of K(0) = 2/pi int B dw above the last frequency, with B ~ w^-q continued from the end
    of the range; one where q <= 1."""
    w, diagonal = db.frequency, _diagonal(db.radiation_damping)
    live = diagonal.max(axis=0) > _damping_floor(db)
    last = diagonal[-1, live]
    earlier = np.array([np.interp(_TAIL_FROM * w[-1], w, row) for row in diagonal[:, live].T])
    middle = (diagonal[1:, live] + diagonal[:-1, live]) / 2
    inside = np.diff(w) @ middle
    decay = np.log(np.maximum(earlier, 1e-300) / np.maximum(last, 1e-300)) / -np.log(_TAIL_FROM)
    tail = last * w[-1] / np.maximum(decay - 1.0, 1e-9)
    share = np.where(last > 0, tail / np.maximum(inside + tail, 1e-300), 0.0)
    return Finding(
        "kernel truncation",
        float(share.max(initial=0.0)),
        0.5,
        "largest share of a retardation function at time zero that comes from above the highest"
        " frequency, where hydrosim continues the damping by a power law; compute higher"
        " frequencies",
    )


def _waterplane(db: HydroDatabase) -> Finding:
    heave = _diagonal(needed(db, "hydrostatic_stiffness"))[2::6]
    # Zero is possible, for a body under water; any negative value raises the figure above those.
    return Finding(
        "heave stiffness",
        float(np.count_nonzero(heave <= 0)),
        0.0,
        "number of bodies without a positive heave stiffness; fine for a body under water, else the"
        " stiffness is missing or its sign is wrong",
        refusal=float(np.count_nonzero(heave == 0)),
    )


def _weight(db: HydroDatabase) -> Finding:
    """Mass against displaced mass."""
    if db.inertia_matrix is None:
        return Finding("weight", 0.0, 0.01, "the database has no inertia matrix")
    mass = _diagonal(db.inertia_matrix)[0::6]
    return Finding(
        "weight",
        float(np.abs(mass / _displaced_mass(db) - 1).max()),
        0.01,
        "relative difference of mass and displaced mass; fine if moorings carry the rest, else"
        " volume, density or mass is wrong",
    )


def _long_waves(db: HydroDatabase) -> list[Finding]:
    """In waves much longer than a body its heave load is C33 times the elevation, and the
    horizontal load along the waves leads the elevation at the body by 90 degrees."""
    k = _wavenumber(db)
    compact = k * np.cbrt(needed(db, "volume").max()) < _LONG_WAVE
    along = np.stack([np.cos(db.heading), np.sin(db.heading)])
    load = db.excitation[0].reshape(db.heading.size, db.bodies, 6)
    load = load * np.exp(1j * k * (along.T @ needed(db, "centre_of_buoyancy")[:, :2].T))[..., None]
    drive = load[..., 0] * along[0, :, None] + load[..., 1] * along[1, :, None]
    stiffness = _diagonal(needed(db, "hydrostatic_stiffness"))[2::6]
    ratio = load[:, stiffness > 0, 2] / stiffness[stiffness > 0]
    size = np.abs(np.log10(np.maximum(np.abs(ratio), 1e-300))).max(initial=0.0)
    return [
        _phase("phase of the horizontal load in long waves", drive / 1j, compact),
        _phase("phase of the heave load in long waves", ratio, compact),
        Finding(
            "size of the heave load in long waves",
            float(size),
            0.1,
            "decimal logarithm of |X3| / C33 at the lowest frequency; start at a lower frequency,"
            " or look for a factor such as rho g or a wave height for an amplitude",
            refusal=0.25 if compact else np.inf,
        ),
    ]


def _phase(name: str, load: np.ndarray, compact: bool) -> Finding:
    error = np.degrees(np.abs(np.angle(load))).max(initial=0.0)
    return Finding(
        name,
        float(error),
        30.0,
        "degrees from the limit for exp(+i w t), at the lowest frequency and the worst heading;"
        " start at a lower frequency, or look for exp(-i w t) (conjugate the loads), headings"
        " where waves come from (add 180 degrees) or another origin of the phases",
        refusal=60.0 if compact else np.inf,
    )


def _wavenumber(db: HydroDatabase) -> float:
    """Of the lowest frequency, by Eckart's (1952) form, within 5 per cent at any depth."""
    deep = db.frequency[0] ** 2 / db.gravity
    return float(deep / np.sqrt(np.tanh(deep * db.water_depth)))


def _displaced_mass(db: HydroDatabase) -> Real:
    return db.water_density * needed(db, "volume")


def _inertia_scale(db: HydroDatabase) -> Real:
    """(n,): displaced mass, times V^(2/3) for rotations."""
    length = np.cbrt(needed(db, "volume"))[:, None]
    return (_displaced_mass(db)[:, None] * length ** np.array([0, 0, 0, 2, 2, 2])).ravel()


def _added_mass_scale(db: HydroDatabase) -> Real:
    """Square root of the largest diagonal (n,), or of the level of noise if that is larger."""
    largest = np.abs(_diagonal(db.added_mass)).max(axis=0)
    return np.sqrt(np.maximum(largest, _NOISE * _inertia_scale(db)))


def _damping_scale(db: HydroDatabase) -> Real:
    largest = np.abs(_diagonal(db.radiation_damping)).max(axis=0)
    return np.sqrt(np.maximum(largest, _damping_floor(db)))


def _damping_floor(db: HydroDatabase) -> Real:
    rate = np.sqrt(db.gravity / np.repeat(np.cbrt(needed(db, "volume")), 6))
    return _NOISE * _inertia_scale(db) * rate


def _diagonal(matrix: Real) -> Real:
    return np.diagonal(matrix, axis1=-2, axis2=-1)
