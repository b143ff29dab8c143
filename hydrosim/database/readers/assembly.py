"""From tables of another program's file to a `HydroDatabase`, with QTFs: for several readers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from enum import Enum
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrosim.database.database import Complex, HydroDatabase, Real
from hydrosim.errors import InputError

# Exact inverse conversion, symmetry, choice of the mean drift.

_ODD = 1e-2  # coupling relative to the diagonals by panels that are not exactly symmetric
_MOMENTUM = [0, 1, 5]  # surge, sway, yaw


def bitwise_inverse(forward: Callable[[Real], Real], guess: Real, wanted: Real) -> Real:
    """Numbers close to ``guess`` that ``forward`` maps to ``wanted`` to the bit, if a neighbour of
    the guess does; else the guess. So a quotient times its divisor is the original number."""
    result = np.array(guess, dtype=float)
    for neighbour in (np.nextafter(guess, np.inf), np.nextafter(guess, -np.inf), guess):
        result = np.where(forward(neighbour) == wanted, neighbour, result)
    return result


def invertible_quotient(value: Real, factor: Real | float) -> Real:
    """``value`` / ``factor``, chosen so that its product with the factor is ``value`` again if
    possible."""
    return bitwise_inverse(lambda x: x * factor, value / factor, value)


def are_bodies_symmetric(added_mass: Real, heading: Real, excitation: Complex) -> bool:
    """Whether each body is symmetric about y = 0, as far as the coefficients show. Then surge,
    heave and pitch do not couple with sway, roll and yaw, and waves along x excite only the
    former."""
    even = np.arange(added_mass.shape[-1]) % 2 == 0
    diagonal = np.abs(np.diagonal(added_mass, axis1=1, axis2=2)).max(axis=0)
    rotation = np.arange(even.size) % 6 > 2
    floor = np.where(rotation, diagonal[rotation].max(), diagonal[~rotation].max()) * 1e-6
    scale = np.sqrt(np.maximum(diagonal, floor))
    coupling = np.abs(added_mass).max(axis=0) / np.outer(scale, scale)
    along = excitation[:, np.abs(np.sin(heading)) < 1e-6]
    load = np.abs(along).max(axis=(0, 1), initial=0.0) / scale
    return bool(
        coupling[even][:, ~even].max() < _ODD
        and coupling[~even][:, even].max() < _ODD
        and load[~even].max() <= _ODD * load[even].max()
    )


def preferred_drift(
    momentum: Real | None, control_surface: Real | None, pressure: Real | None, bodies: int
) -> tuple[Real | None, str]:
    """Mean drift (nw, nh, n) from up to three methods, and a remark on it.

    Surge, sway and yaw come from the conservation of momentum, the most accurate method. It gives
    only the sum for several bodies, and is then not used. The others come from the control surface,
    else from the pressure, else they are zero.
    """
    full, name = control_surface, "over a control surface"
    if full is None:
        full, name = pressure, "by pressure integration"
    if momentum is None or (bodies > 1 and full is not None):
        return full, "" if full is None else name
    if bodies > 1:
        return None, "by momentum conservation only, which holds for all bodies together: left out"
    drift = np.zeros_like(momentum) if full is None else full.copy()
    drift[..., _MOMENTUM] = momentum[..., _MOMENTUM]
    rest = "unknown and zero" if full is None else name
    return drift, f"surge, sway, yaw by momentum conservation; heave, roll, pitch {rest}"


# Loads in the mirror image in x = 0: surge, pitch and yaw change sign.
_FORE_AFT_SIGN = np.array([-1.0, 1.0, 1.0, 1.0, -1.0, -1.0])
_FASTEST = 1e4  # rad/s: waves shorter than a micrometre; larger numbers come from a damaged file
_HEADING_TOLERANCE = 1e-6  # rad: headings beyond a quarter of a turn by less are within it
_BY_FREQUENCY = ("added_mass", "radiation_damping")
_BY_WAVE = ("excitation", "froude_krylov", "mean_drift")


class Abscissa(Enum):
    """Quantity by which a program identifies waves."""

    RADIANS_PER_SECOND = "rad/s"
    HERTZ = "Hz"
    PERIOD = "s"


def frequencies(path: Path, values: ArrayLike, abscissa: Abscissa) -> Real:
    """Angular frequencies [rad/s] from ``values``; a period of zero is an infinite frequency."""
    value = np.asarray(values, dtype=float)
    if abscissa is Abscissa.PERIOD:
        with np.errstate(divide="ignore", over="ignore"):
            omega = np.where(value == 0, np.inf, 2 * np.pi / value)
    else:
        omega = value * (2 * np.pi if abscissa is Abscissa.HERTZ else 1.0)
    infinite = np.isinf(omega) & ((value == 0) | np.isinf(value))
    wrong = ~((omega >= 0) & ((omega < _FASTEST) | infinite))
    if wrong.any():
        raise InputError(
            f"{path}: found a wave frequency or period of {value[wrong][0]:g} {abscissa.value};"
            " expected a value for sea waves. Check the units in the file."
        )
    return omega


def at_origin(
    loads: Complex, omega: Real, heading: Real, point: ArrayLike, depth: float, gravity: float
) -> Complex:
    """Loads (nw, nh, n) per elevation at the frame's origin, from those per elevation at ``point``
    (x, y)."""
    return loads * elevation(omega[:, None], heading, point, depth, gravity)[..., None]


def elevation(
    omega: Real, heading: Real, point: ArrayLike, depth: float, gravity: float
) -> Complex:
    """exp(-i k (x cos b + y sin b)) at ``point``, of waves with unit elevation at the origin."""
    x, y = np.asarray(point, dtype=float)[:2]
    along = x * np.cos(heading) + y * np.sin(heading)
    if not along.any() or not (depth > 0 and gravity > 0):  # absent from every database
        return np.ones(np.broadcast_shapes(omega.shape, heading.shape), dtype=complex)
    from hydrosim.water.spectra import wavenumber  # imports numba, which few files need

    with np.errstate(all="ignore"):  # implausible depths give loads that the database refuses
        k = wavenumber(np.where(np.isfinite(omega), omega, 0.0), depth, gravity)
        return np.asarray(np.exp(-1j * k * along))


def with_fore_aft_headings(heading: Real, loads: Any) -> tuple[Real, Any]:
    """Headings 0 to 180 degrees, and their loads, of a hull that is symmetric about x = 0, from
    headings of the first quadrant. Headings beyond the quadrant are left as they are."""
    if (np.abs(heading - np.pi / 4) > np.pi / 4 + _HEADING_TOLERANCE).any():
        return heading, loads
    new = heading < np.pi / 2 - _HEADING_TOLERANCE
    mirrored = np.pi - heading[new][::-1]
    images = loads[:, new][:, ::-1] * _FORE_AFT_SIGN
    return np.concatenate([heading, mirrored]), np.concatenate([loads, images], axis=1)


def assemble(
    path: Path,
    omega: Real,
    heading: Real,
    symmetric: bool | None,
    used: tuple[float, float] | None = None,
    **fields: Any,
) -> HydroDatabase:
    """Database with frequencies and headings in ascending order, and with the matrices at zero and
    infinite frequency separated. Frequencies outside those that are ``used``, see `Given`, are left
    out if they have no numbers. If ``symmetric`` is not given, port-starboard symmetry is
    determined from the coefficients. Other fields are passed on unchanged."""
    omega, fields = drop_unused_frequencies(omega, fields, used)
    rows, columns = np.argsort(omega, kind="stable"), np.argsort(heading, kind="stable")
    rows = rows[np.isfinite(omega[rows]) & (omega[rows] > 0)]
    if rows.size == 0:
        raise InputError(
            f"{path}: found no frequency that is finite and above zero; expected at least one."
            " Export added mass and damping at wave frequencies too."
        )
    limits = {"added_mass_zero": omega == 0, "added_mass_infinite": np.isinf(omega)}
    for name, where in limits.items():
        if where.any():
            fields.setdefault(name, fields["added_mass"][where][0])
    for name in _BY_FREQUENCY:
        fields[name] = fields[name][rows]
    for name in _BY_WAVE:
        if fields.get(name) is not None:
            fields[name] = fields[name][rows][:, columns]
    db = HydroDatabase(
        source=str(path),
        frequency=omega[rows],
        heading=heading[columns],
        port_starboard_symmetric=bool(symmetric),
        **fields,
    )
    if symmetric is not None:
        return db
    with np.errstate(all="ignore"):  # without added mass
        seen = are_bodies_symmetric(db.added_mass, db.heading, db.excitation)
    return replace(db, port_starboard_symmetric=seen)


def drop_unused_frequencies(
    omega: Real, fields: Mapping[str, Any], used: tuple[float, float] | None
) -> tuple[Real, dict[str, Any]]:
    """Frequencies (nw,) and fields without the rows outside the ``used`` frequencies that have no
    numbers. Zero and infinite frequency stay: they need no loads and no damping."""
    given = {
        name: np.asarray(fields[name])
        for name in (*_BY_FREQUENCY, *_BY_WAVE)
        if fields.get(name) is not None and len(fields[name]) == omega.size
    }
    if used is None:
        return omega, dict(fields)
    outside = ((omega < used[0]) | (omega > used[1])) & (omega > 0) & np.isfinite(omega)
    finite = [np.isfinite(value).reshape(omega.size, -1).all(axis=1) for value in given.values()]
    keep = ~outside | np.all(finite, axis=0)
    if np.count_nonzero(keep) < 2:  # too few frequencies: the message is about them
        return omega, dict(fields)
    return omega[keep], {**fields, **{name: value[keep] for name, value in given.items()}}


def points(
    path: Path, name: str, given: Sequence[float] | None, file: ArrayLike | None, bodies: int
) -> Real | None:
    """Points (nb, 3) of the file, else those that the user gives; None if there are neither."""
    value = given if file is None else file
    if value is None:
        return None
    array = np.asarray(value, dtype=float)
    if array.size != 3 * bodies:
        raise InputError(
            f"{path}: {name} has {array.size} coordinates, expected {3 * bodies} for {bodies}"
            " bodies. Give x, y and z of each body."
        )
    return array.reshape(bodies, 3)


def volumes(path: Path, given: Sequence[float] | None, file: ArrayLike | None) -> Real | None:
    """Volumes (nb,) of the file, else those that the user gives."""
    value = given if file is None else file
    return None if value is None else np.atleast_1d(np.asarray(value, dtype=float))


def require_number(path: Path, name: str, given: float | None, file: float | None = None) -> float:
    """A number of the file, or one that the user gives. Raises `InputError` if there is neither."""
    value = given if file is None else file
    if value is None:
        raise InputError(
            f"{path}: found no {name} in this file; expected it. Give it in the case, such as"
            f" `hydrodynamics: {{file: ..., density: 1025 kg/m^3}}`, or with an option of"
            " `hydrosim db convert`."
        )
    return float(value)


def block_diagonal(blocks: ArrayLike) -> Real:
    """Matrix (6 nb, 6 nb) with the blocks (nb, 6, 6) of each body and zeros elsewhere."""
    stack = np.asarray(blocks, dtype=float)
    bodies = len(stack)
    out = np.zeros((bodies, 6, bodies, 6))
    out[np.arange(bodies), :, np.arange(bodies), :] = stack
    return out.reshape(6 * bodies, 6 * bodies)


def polar(amplitude: ArrayLike, lag: ArrayLike) -> NDArray[np.complex128]:
    """Complex amplitudes for exp(+i w t) of a load that lags the wave by ``lag`` [rad]."""
    return np.asarray(amplitude) * np.exp(-1j * np.asarray(lag))


# Quadratic transfer functions from rows of pairs of waves; files often have half of the pairs.


class Pairs(NamedTuple):
    """Rows of two waves each: ``omega`` and ``heading`` (m, 2), ``dof`` (m,) counted from zero over
    all bodies, and the load ``value`` (m,)."""

    omega: Real
    heading: Real
    dof: NDArray[np.intp]
    value: Complex

    def at_origin(self, point: Real, depth: float, gravity: float, difference: bool) -> Pairs:
        """Loads per elevations at the frame's origin, from those per elevations at ``point``."""
        waves = elevation(self.omega, self.heading, point, depth, gravity)
        second = waves[:, 1].conj() if difference else waves[:, 1]
        return self._replace(value=self.value * waves[:, 0] * second)


def quadratic(
    path: Path, dofs: int, difference: Pairs | None, total: Pairs | None
) -> dict[str, Any]:
    """Fields of the database. Missing rows follow from T-_21 = conj T-_12 and T+_21 = T+_12. Raises
    `InputError` if both orders are missing, or if the two files have different waves."""
    present = [pairs for pairs in (difference, total) if pairs is not None]
    if not present:
        return {}
    frequency, heading = np.unique(present[0].omega), np.unique(present[0].heading, axis=0)
    for other in present[1:]:
        if not _is_equal(np.unique(other.omega), frequency) or not _is_equal(
            np.unique(other.heading, axis=0), heading
        ):
            raise InputError(
                f"{path}: difference- and sum-frequency transfer functions have other waves,"
                " expected the same pairs. Export both for the same waves."
            )
    return {
        "qtf_frequency": frequency,
        "qtf_heading": heading,
        "qtf_difference": _fill_pairs(path, dofs, frequency, heading, difference, np.conj),
        "qtf_sum": _fill_pairs(path, dofs, frequency, heading, total, np.array),
    }


def _is_equal(a: Real, b: Real) -> bool:
    return a.shape == b.shape and bool((a == b).all())


def _fill_pairs(
    path: Path, dofs: int, frequency: Real, heading: Real, pairs: Pairs | None, swapped: Any
) -> Complex | None:
    """Array (np, nq, nq, n); ``swapped`` converts a value to that of the waves in reverse order."""
    if pairs is None:
        return None
    kinds, nq = np.unique(pairs.dof), frequency.size
    least = len(heading) * nq * (nq + 1) // 2 * kinds.size
    if len(pairs.value) < least:  # before memory is reserved for them
        raise _incomplete_error(path, f"{len(pairs.value)} rows", f"at least {least}")
    lookup = {tuple(pair): number for number, pair in enumerate(heading)}
    first = np.array([lookup[tuple(pair)] for pair in pairs.heading])
    second = np.array([lookup.get(tuple(pair[::-1]), -1) for pair in pairs.heading])
    i, j = np.searchsorted(frequency, pairs.omega).T
    out = np.full((len(heading), nq, nq, dofs), np.nan, dtype=complex)
    is_given = second >= 0
    out[second[is_given], j[is_given], i[is_given], pairs.dof[is_given]] = swapped(
        pairs.value[is_given]
    )
    out[first, i, j, pairs.dof] = pairs.value
    out[..., np.setdiff1d(np.arange(dofs), kinds)] = 0.0
    missing = np.count_nonzero(np.isnan(out))
    if missing:
        raise _incomplete_error(path, f"{out.size - missing} values", f"{out.size}")
    return out


def _incomplete_error(path: Path, text: str, expected: str) -> InputError:
    return InputError(
        f"{path}: found {text} of quadratic transfer functions, expected {expected} for all pairs"
        " of its frequencies, at least those with w_1 >= w_2. Export all pairs, or none."
    )
