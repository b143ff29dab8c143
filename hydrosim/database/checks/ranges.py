"""Checks of frequencies and headings (order, range, spacing, outliers) and of hydrostatics."""

from __future__ import annotations

import numpy as np

from hydrosim.database import netcdf
from hydrosim.database.checks.finding import (
    Check,
    CheckSubject,
    LeftOut,
    RelativeErrors,
    damping_floor,
    damping_scale,
    diagonal,
    displaced_mass,
    load_floor,
    single_error,
)
from hydrosim.database.database import Complex, HydroDatabase, Real, require_array
from hydrosim.water.radiation.retardation import (
    TAIL_EXPONENTS,
    diagonal_scale,
    find_radiating,
    retardation_function,
)
from hydrosim.water.spectra import wavenumber

# the decay of the damping is fitted from this fraction of the highest frequency up
_TAIL_FROM = 0.85
_NEIGHBOURS = 4  # neighbouring frequencies on each side with which a spike is compared
_OUTLIER_RATIO = 8.0  # a spike exceeds this multiple of the median of its neighbours
_MEMORY_LAGS = 200  # at which the memory is tested


def _alteration_errors(db: HydroDatabase) -> RelativeErrors:
    if netcdf.NUMBERS_ATTRIBUTE not in db.attributes:
        raise LeftOut("the file has no checksum of hydrosim")
    return single_error(float(db.attributes[netcdf.NUMBERS_ATTRIBUTE] == netcdf.ALTERED))


def _frequency_errors(db: HydroDatabase) -> RelativeErrors:
    return single_error(float(np.count_nonzero(np.diff(db.frequency, prepend=0.0) <= 0)))


def _heading_errors(db: HydroDatabase) -> RelativeErrors:
    wrong = np.count_nonzero(np.diff(db.heading) <= 0)
    beyond = np.count_nonzero(np.abs(db.heading) > 2 * np.pi + 1e-9)
    return single_error(float(wrong + beyond))


def _kernel_truncation(db: HydroDatabase) -> RelativeErrors:
    """Fraction of K(0) = 2/pi int B dw above the last frequency, with B ~ w^-q continued from the
    end of the range. A damping that does not decrease there is continued with the slowest decay
    that a fit may have. So a small irregular remainder stays a small fraction."""
    w, damping = db.frequency, diagonal(db.radiation_damping)
    earlier = np.array([np.interp(_TAIL_FROM * w[-1], w, row) for row in damping.T])
    last, before = (np.maximum(np.abs(B), damping_floor(db)) for B in (damping[-1], earlier))
    q = np.clip(np.log(before / last) / -np.log(_TAIL_FROM), *TAIL_EXPONENTS)
    tail = np.abs(damping[-1]) * w[-1] / (q - 1.0)
    inside = np.diff(w) @ (np.abs(damping[1:]) + np.abs(damping[:-1])) / 2
    live = damping.max(axis=0) > damping_floor(db)
    return RelativeErrors(np.where(live, tail / np.maximum(inside + tail, 1e-300), 0.0), ("dof",))


def _memory_errors(db: HydroDatabase) -> RelativeErrors:
    """Frequencies dw apart resolve K(t) up to t = pi/dw. Its values from there to twice that,
    relative to its peak, are neglected memory, or an echo of the spacing."""
    _require_count(db, 4)
    resolved = np.pi / np.diff(db.frequency).max()
    time = np.concatenate([[0.0], np.linspace(resolved, 2 * resolved, _MEMORY_LAGS)])
    active = find_radiating(db.radiation_damping)
    damping = db.radiation_damping[:, active[:, None], active]
    kernel = retardation_function(db.frequency, damping, time)
    relative = np.full(db.radiation_damping.shape[1:], np.nan)
    scale = diagonal_scale(kernel)
    later = np.abs(kernel[1:]).max(axis=0) / np.outer(scale, scale)
    relative[np.ix_(active, active)] = later
    return RelativeErrors(relative, ("dof", "motion"))


def _spike_errors(db: HydroDatabase) -> RelativeErrors:
    """Largest outlier of the diagonals of A and B, relative to the largest damping of the DOF."""
    _require_count(db, 2 * _NEIGHBOURS)
    w = db.frequency[1:-1, None]
    scale = damping_scale(db) ** 2
    live = diagonal(db.radiation_damping).max(axis=0) > damping_floor(db)
    damping = _departure_from_neighbours(db.frequency, diagonal(db.radiation_damping))
    added = w * _departure_from_neighbours(db.frequency, diagonal(db.added_mass))
    spikes = [_outlier_sizes(np.abs(matrix / scale)) for matrix in (damping, added)]
    relative = np.full((db.frequency.size, live.size), np.nan)
    relative[1:-1] = np.where(live, np.maximum(*spikes), np.nan)
    return RelativeErrors(relative, ("frequency", "dof"), relative * scale, ("kg", "/s"))


def _smooth_loads(db: HydroDatabase) -> RelativeErrors:
    """Errors of splines through the loads between frequencies, relative to the root mean square of
    the loads. They are estimated as an eighth of the departure at each frequency from the cubic
    through two neighbours on either side, which are twice as far apart. On the shipped hulls
    without every second frequency the errors were 0.06 for estimates of 0.04 to 0.06, and 0.2 to
    0.3 for estimates of 0.1 to 0.14."""
    _require_count(db, 5)
    k = wavenumber(db.frequency, db.water_depth, db.gravity)[:, None, None]
    towards = np.stack([np.cos(db.heading), np.sin(db.heading)], axis=1)
    place = np.repeat(db.reference_point[:, :2], 6, axis=0)
    loads = db.excitation * np.exp(1j * k * (towards @ place.T))
    departure = np.sqrt(
        (np.abs(_departure_from_neighbours(db.frequency, loads, 2)) ** 2).mean(axis=1)
    )
    rough = np.pad(departure / 8.0, ((2, 2), (0, 0)))
    size = np.sqrt((np.abs(loads) ** 2).mean(axis=(0, 1)))
    relative = rough / np.maximum(size, load_floor(db))
    return RelativeErrors(relative, ("frequency", "dof"), rough, ("N", "/m"))


def _departure_from_neighbours(w: Real, values: Real | Complex, stride: int = 1) -> Real | Complex:
    """Differences (nw - 2 stride, ...) of values from Lagrange's polynomial through ``stride``
    neighbours on either side: a straight line for one, a cubic for two."""
    ends = [k for k in range(2 * stride + 1) if k != stride]
    at, *nodes = (w[k : w.size - 2 * stride + k] for k in (stride, *ends))
    differences = values[stride:-stride].copy()
    for k, node in zip(ends, nodes, strict=True):
        others = [x for x in nodes if x is not node]
        weight = np.prod([(at - x) / (node - x) for x in others], axis=0)
        differences -= (
            weight.reshape(-1, *[1] * (values.ndim - 1)) * values[k : w.size - 2 * stride + k]
        )
    return differences


def _outlier_sizes(departure: Real) -> Real:
    """Departures that are far above the median of their neighbours, zero elsewhere.

    The departure of a smooth curve changes little from one frequency to the next; a spike at one
    frequency raises three departures."""
    padded = np.pad(departure, ((_NEIGHBOURS, _NEIGHBOURS), (0, 0)), mode="reflect")
    around = np.lib.stride_tricks.sliding_window_view(padded, 2 * _NEIGHBOURS + 1, axis=0)
    usual = np.median(around, axis=-1)
    return np.where(departure > _OUTLIER_RATIO * usual, departure, 0.0)


def _require_count(db: HydroDatabase, count: int) -> None:
    if db.frequency.size < count:
        raise LeftOut(f"needs {count} frequencies, the database has {db.frequency.size}")


ORDER_CHECKS = (
    Check(
        "frequencies",
        _frequency_errors,
        0.0,
        "number of frequencies that are not above zero and the previous one; sort them, in rad/s",
        refusal=0.0,
        of=frozenset({CheckSubject.ORDER}),
    ),
    Check(
        "headings",
        _heading_errors,
        0.0,
        "number of headings that do not increase or lie beyond a full turn; sort them, in rad",
        refusal=0.0,
        of=frozenset({CheckSubject.ORDER}),
    ),
)

RANGES = (
    Check(
        "numbers as written",
        _alteration_errors,
        0.0,
        "1 if the numbers are not those that hydrosim wrote into the file; accept it if you"
        " changed them on purpose, else convert the original again",
        of=frozenset(CheckSubject),
    ),
    Check(
        "kernel truncation",
        _kernel_truncation,
        0.5,
        "largest fraction of a retardation function at time zero that comes from above the"
        " highest frequency, where hydrosim continues the damping by a power law; compute higher"
        " frequencies",
        of=frozenset({CheckSubject.RADIATION}),
    ),
    Check(
        "frequency spacing",
        _memory_errors,
        0.02,
        "remaining retardation functions, relative to their peak, after the time pi/dw that the"
        " widest step dw between frequencies resolves; compute frequencies in between",
        of=frozenset({CheckSubject.RADIATION}),
    ),
    Check(
        "irregular frequencies",
        _spike_errors,
        0.02,
        "largest spike in added mass or damping relative to the largest damping; remove"
        " irregular frequencies with a lid, or leave those frequencies out; acceptable if bodies"
        " trap a wave between them",
        of=frozenset({CheckSubject.RADIATION}),
    ),
    Check(
        "smooth loads",
        _smooth_loads,
        0.1,
        "largest error of the excitation between frequencies, estimated from its departure from"
        " the cubic through its neighbours; compute more frequencies, or look for phases of"
        " another origin or rows in another order",
        of=frozenset({CheckSubject.LOADS}),
    ),
)


# Hydrostatics: stiffness, volume and mass against each other.


def _errors_of_dofs(db: HydroDatabase, values: Real, *dofs: int) -> RelativeErrors:
    """``values`` (nb, len(dofs)) or (nb, 1) for those degrees of freedom of each body."""
    relative = np.full((db.bodies, 6), np.nan)
    relative[:, list(dofs)] = values
    return RelativeErrors(relative.ravel(), ("dof",))


def _heave_errors(db: HydroDatabase) -> RelativeErrors:
    heave_stiffness = diagonal(require_array(db, "hydrostatic_stiffness"))[2::6]
    return _errors_of_dofs(db, ((1 - np.sign(heave_stiffness)) / 2)[:, None], 2)


def _asymmetry_errors(db: HydroDatabase) -> RelativeErrors:
    stiffness = require_array(db, "hydrostatic_stiffness")
    scale = np.sqrt(np.maximum(np.abs(np.diag(stiffness)), 1e-300))
    dofs = np.arange(len(stiffness))
    stiff = (dofs % 6 > 1) & (dofs % 6 < 5)
    judged = np.outer(stiff, stiff) & (dofs[:, None] // 6 == dofs // 6)
    gap = np.where(judged, stiffness - stiffness.T, np.nan)
    return RelativeErrors(np.abs(gap) / np.outer(scale, scale), ("dof", "motion"), gap, ("N", "/m"))


def _metacentre_errors(db: HydroDatabase) -> RelativeErrors:
    """1 for each negative metacentric height."""
    stiffness = diagonal(require_array(db, "hydrostatic_stiffness")).reshape(-1, 6)
    return _errors_of_dofs(db, np.where(stiffness[:, 3:5] < 0, 1.0, 0.0), 3, 4)


def _waterplane_errors(db: HydroDatabase) -> RelativeErrors:
    """Heave, roll and pitch stiffness minus the levers of buoyancy and weight are rho g times the
    integrals of (1, x, y)(1, x, y) over the waterplane. The error is their distance from positive
    semi-definite, and below the polar moment A^2/2pi of a disc, the smallest possible."""
    rho_g = db.water_density * db.gravity
    lever = (require_array(db, "centre_of_buoyancy") - require_array(db, "centre_of_gravity"))[:, 2]
    stiffness = _blocks_per_body(require_array(db, "hydrostatic_stiffness"))[:, 2:5, 2:5].copy()
    for block, less in zip(stiffness, rho_g * require_array(db, "volume") * lever, strict=True):
        block[[1, 2], [1, 2]] -= less
    impossible = [[_impossible_moments(block / rho_g)] for block in stiffness]
    return _errors_of_dofs(db, np.array(impossible), 3, 4)


def _impossible_moments(moments: Real) -> float:
    """Errors of the moments (3, 3) of a plane area."""
    area = moments[0, 0]
    if area <= 0.0:
        return 0.0
    least = area**2 / (2 * np.pi)
    polar = moments[1, 1] + moments[2, 2] - (moments[0, 1] ** 2 + moments[0, 2] ** 2) / area
    size = np.sqrt(np.maximum(np.abs(np.diag(moments)), 1e-9 * least))
    scaled = moments / np.outer(size, size)
    return max(0.0, 1 - polar / least, -np.linalg.eigvalsh((scaled + scaled.T) / 2)[0])


def _weight_errors(db: HydroDatabase) -> RelativeErrors:
    mass = diagonal(require_array(db, "inertia_matrix"))[0::6]
    return RelativeErrors(np.abs(mass / displaced_mass(db) - 1), ("body",))


def _blocks_per_body(matrix: Real) -> Real:
    """Blocks (nb, 6, 6): each body's own part of (n, n)."""
    bodies = len(matrix) // 6
    return np.array([matrix[6 * b :, 6 * b :][:6, :6] for b in range(bodies)])


HYDROSTATICS = (
    Check(
        "heave stiffness",
        _heave_errors,
        0.0,
        "1 if a body has a negative heave stiffness, 1/2 if it has none; acceptable for a"
        " submerged body, else the stiffness is missing or its sign is wrong",
        refusal=0.5,
        needs=("hydrostatic_stiffness",),
        of=frozenset({CheckSubject.STIFFNESS}),
    ),
    Check(
        "symmetry of the stiffness",
        _asymmetry_errors,
        0.02,
        "largest |C_ij - C_ji| / sqrt(C_ii C_jj) in heave, roll and pitch, zero in theory; look"
        " for a wrong sign or an exchanged entry",
        needs=("hydrostatic_stiffness",),
        of=frozenset({CheckSubject.STIFFNESS}),
    ),
    Check(
        "metacentric heights",
        _metacentre_errors,
        0.0,
        "1 if a roll or pitch stiffness is negative; the body capsizes, or its centre of gravity"
        " or the sign is wrong",
        needs=("hydrostatic_stiffness",),
        of=frozenset({CheckSubject.STIFFNESS}),
    ),
    Check(
        "moments of the waterplane",
        _waterplane_errors,
        0.05,
        "distance of stiffness, volume and centres from those of any possible waterplane; look"
        " for wrong units, a stiffness without gravity, or centres in another frame",
        refusal=0.5,
        needs=("hydrostatic_stiffness", "volume", "centre_of_buoyancy", "centre_of_gravity"),
        of=frozenset({CheckSubject.STIFFNESS}),
    ),
    Check(
        "weight",
        _weight_errors,
        0.01,
        "relative difference of mass and displaced mass; acceptable if moorings carry the"
        " difference, else volume, density or mass is wrong",
        refusal=0.9,
        needs=("inertia_matrix", "volume"),
        of=frozenset({CheckSubject.SPARE}),
    ),
)
