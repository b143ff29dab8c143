"""Retardation functions K(t) from radiation damping, and added mass at infinite frequency.

K(t) = 2/pi int_0^inf B(w) cos(w t) dw. With K^(w) = int_0^inf K(t) exp(-i w t) dt, K^(w) = B(w) + i
w (A(w) - A_inf) (Cummins 1962; Ogilvie 1964). Matrices are (n, n), the row is the DOF of the force;
SI, rad/s, s.

Spectra of radiation with the memory cut at its end, and cut later. They give estimates of the
effect of a fit and of the cut on motions, without a run.

A run of T s does not distinguish frequencies closer than 1/T, and does not depend on later times.
So its motions are multiplied by exp(-t/T), with spectra at s = 1/T + i w.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from hydrosim.errors import InputError
from hydrosim.scene.hydrodynamics import LENGTH
from hydrosim.water.radiation.kept import Arrays, read_or_make
from hydrosim.water.radiation.threads import one_thread

TAIL_BAND = 0.15  # part of the band, at its end, on which the decay of B is fitted
TAIL_EXPONENTS = (1.2, 12.0)  # range of q in the tail B ~ w^-q
NO_RADIATION = 1e-9  # of the largest diagonal entry of the same kind: rounding
FINER = 8  # samples of K per step of its table
OGILVIE_BAND = 0.75  # part of the band, from its start, over which A_inf is averaged


@dataclass(frozen=True, eq=False)
class KernelReport:
    """Parts of the memory that the data, the frequency band and the length leave out.

    The ratios are the largest over the entries ij, each divided by the geometric mean of the
    largest |.| of the diagonal entries ii and jj. So forces and moments compare.
    """

    end_ratio: float  # |K| at the end of the table
    band_ratio: float  # |B| at the highest frequency: size of the extrapolated tail
    ogilvie_residual: float  # |A(w) - A_inf + 1/w int K sin(w t) dt|, over the band
    # of B(w), see `smallest_eigenvalue`; a negative value would create energy
    smallest_eigenvalue: float
    tail_exponent: np.ndarray  # (n, n), q of the tail

    def __str__(self) -> str:
        return (
            f"|K(T)|/max|K| {self.end_ratio:.1e}, B(w_max)/max B {self.band_ratio:.1e}, Ogilvie"
            f" residual {self.ogilvie_residual:.1e}, smallest eigenvalue of B"
            f" {self.smallest_eigenvalue:.1e}"
        )


@dataclass(frozen=True, eq=False)
class Retardation:
    """Radiation in the time domain: ``kernel`` is K (nt, n, n) at the lags ``time`` (nt,),
    ``added_mass_infinite`` A_inf (n, n)."""

    time: np.ndarray
    kernel: np.ndarray
    added_mass_infinite: np.ndarray
    report: KernelReport


def retardation(
    frequency: np.ndarray,
    added_mass: np.ndarray,
    damping: np.ndarray,
    *,
    length: float | None = None,
    step: float = 0.1,
    checksum: str | None = None,
) -> Retardation:
    """K up to ``length`` [s] and A_inf, from added mass and damping (nw, n, n) at ``frequency``.

    The default length is `memory_length`. A longer one is used as given; K then has echoes from the
    spacing of the frequencies.

    Radiation is reciprocal, so only the symmetric parts are used. The antisymmetric parts are panel
    errors, which a database's checks report.

    With the ``checksum`` of a database that has these coefficients, the result is stored in the
    cache folder.

    Raises `InputError` for data that cannot be transformed, see `retardation_function`.
    """
    _check(frequency, damping)
    _check(frequency, added_mass)
    added_mass, damping = (0.5 * (M + np.swapaxes(M, 1, 2)) for M in (added_mass, damping))
    if length is None:
        length = memory_length(frequency, None, step)
    time = np.linspace(0.0, length, round(length / step) + 1)
    make = partial(_retardation, frequency, added_mass, damping, time)
    if checksum is None:
        return make()
    settings = (checksum, time.size, float(length))
    return read_or_make(
        "memories", settings, make, _retardation_arrays, partial(_read_retardation, time)
    )


def memory_length(frequency: np.ndarray, length: float | None, step: float) -> float:
    """Length [s] of a table of K: the requested one, or `LENGTH`, but not more whole steps than the
    ``frequency`` (nw,) resolves, see `resolved_length`."""
    wanted = LENGTH if length is None else length
    resolved = resolved_length(frequency)
    if wanted <= resolved:
        return wanted
    steps = int(resolved / step * (1.0 + 1e-9))
    return max(steps, 2) * step


def resolved_length(frequency: np.ndarray) -> float:
    """Lag pi / dw [s] up to which values of B at ``frequency`` (nw,) determine K.

    Values dw apart make K periodic: after pi / dw the mirror image of the earlier part follows. A
    memory that includes some of it need not be passive. If the spacing varies there is no period,
    and dw is the smallest: frequencies are close where the memory is long.
    """
    steps = np.diff(frequency)
    return float(np.pi / steps.min()) if steps.size else np.inf


@one_thread
def _retardation(
    frequency: np.ndarray, added_mass: np.ndarray, damping: np.ndarray, time: np.ndarray
) -> Retardation:
    kernel = tabulate_retardation(frequency, damping, time)
    infinite, residual = infinite_added_mass(frequency, added_mass, time, kernel)
    active = find_radiating(damping)
    K, A, B, left = (
        matrices[:, active[:, None], active] for matrices in (kernel, added_mass, damping, residual)
    )
    report = KernelReport(
        end_ratio=relative_size(K[-1:], K),
        band_ratio=relative_size(B[-1:], B),
        ogilvie_residual=relative_size(left, A),
        smallest_eigenvalue=smallest_eigenvalue(B),
        tail_exponent=tail_exponent(frequency, damping),
    )
    return Retardation(time, kernel, infinite, report)


def _retardation_arrays(memory: Retardation) -> Arrays:
    *ratios, exponent = astuple(memory.report)
    return {
        "K": memory.kernel,
        "infinite": memory.added_mass_infinite,
        "ratios": np.array(ratios),
        "tail_exponent": exponent,
    }


def _read_retardation(time: np.ndarray, arrays: Arrays) -> Retardation:
    end, band, residual, eigenvalue = map(float, arrays["ratios"])
    report = KernelReport(end, band, residual, eigenvalue, arrays["tail_exponent"])
    return Retardation(time, arrays["K"], arrays["infinite"], report)


def tabulate_retardation(
    frequency: np.ndarray, damping: np.ndarray, time: np.ndarray
) -> np.ndarray:
    """Entries (nt, n, n) at the equally spaced ``time`` (nt,), such that linear interpolation
    between them acts on smooth motions like K. The error is of order 4 in the spacing, or 3 if K
    has a kink at t = 0.

    They are (1 - d^2 / 6) of the means of K over hat functions, d^2 being second differences. This
    conserves the area under K, which slow motions depend on, and which is zero but for the cut.
    Values of K themselves would be of order 2. They would miss most of the area near t = 0, where a
    K of B ~ w^-q has a cusp |t|^(q - 1).
    """
    fine = time[1] / FINER * np.arange(FINER * (time.size + 1) + 1)
    K = retardation_function(frequency, damping, fine)
    K = np.concatenate([K[2 * FINER : 0 : -1], K])  # K(-t) = K(t)
    j = np.arange(-FINER - 1, FINER + 2) / FINER
    hat = np.convolve(np.maximum(1.0 - np.abs(j), 0.0), [1 / 6, 4 / 6, 1 / 6], "valid") / FINER
    entries = np.zeros((time.size, *K.shape[1:]))
    for steps, part in ((0, -1 / 6), (1, 4 / 3), (2, -1 / 6)):
        for k, weight in enumerate(hat):
            start = steps * FINER + k
            entries += part * weight * K[start : start + FINER * time.size : FINER]
    return entries


def retardation_function(
    frequency: np.ndarray, damping: np.ndarray, time: np.ndarray
) -> np.ndarray:
    """K (nt, n, n) at ``time`` (nt,) from B (nw, n, n) at ``frequency`` (nw,).

    B is taken as linear between the frequencies, from B = 0 at w = 0, and as B(w_max) (w /
    w_max)^-q beyond them, with q by `tail_exponent`. Both parts are integrated exactly (the tail to
    1e-9 of its value at t = 0). The remaining errors come from the spacing of the database and the
    shape of the tail.

    Raises `InputError` if the shapes do not agree, if the frequencies are not finite, non-negative
    and increasing, or if B has a value that is not finite.
    """
    _check(frequency, damping)
    tail = _power_integral(frequency[-1] * time, tail_exponent(frequency, damping))
    if frequency[0] > 0.0:
        band = fourier_integral(
            np.append(0.0, frequency), np.append(np.zeros_like(damping[:1]), damping, axis=0), time
        )
    else:
        band = fourier_integral(frequency, damping, time)
    return 2.0 / np.pi * (band.real + frequency[-1] * damping[-1] * tail)


def tail_exponent(frequency: np.ndarray, damping: np.ndarray) -> np.ndarray:
    """(n, n) exponents q of B ~ w^-q, by least squares of log|B| on the last 15 % of the band.

    An entry that changes sign there, or falls slower than w^-1.2 (K(0) would depend on the guess
    alone), has no tail that the data support. It gets the steepest, w^-12, which closes the step at
    the band's end without adding much. Steeper fits are limited to 12 as well. Off the diagonal q
    is at least the mean of the two diagonal exponents. Otherwise a coupling would outlast the
    damping of the modes that it couples, and create energy.
    """
    end = frequency >= (1.0 - TAIL_BAND) * frequency[-1]
    B = damping[end]
    x = np.log(frequency[end])
    x = x - x.mean()
    least, steepest = TAIL_EXPONENTS
    one_sign = np.all(B * B[-1] > 0.0, axis=0) & (x.size > 1)
    y = np.log(np.where(one_sign, np.abs(B), 1.0))
    q = -np.tensordot(x, y, 1) / max(x @ x, np.finfo(float).tiny)
    q = np.where(q >= least, np.minimum(q, steepest), steepest)
    diagonal = np.diagonal(q)
    return np.maximum(q, 0.5 * (diagonal[:, None] + diagonal))


def infinite_added_mass(
    frequency: np.ndarray, added_mass: np.ndarray, time: np.ndarray, kernel: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """A_inf (n, n) = mean over w of A(w) + 1/w int K sin(w t) dt (Ogilvie 1964), K linear in time.

    The mean is over the lower three quarters of the band, where the guessed tail of B has little
    weight. The second result (nw, n, n) is the residual of the relation at each frequency of the
    whole band, zero for exact data. w = 0 gives no information; its residual is zero.
    """
    positive = frequency > 0.0
    w = frequency[positive]
    A_inf = added_mass[positive] - transfer_function(time, kernel, w).imag / w[:, None, None]
    mean = A_inf[w <= OGILVIE_BAND * w[-1]].mean(axis=0)
    residual = np.zeros_like(added_mass)
    residual[positive] = A_inf - mean
    return mean, residual


def transfer_function(time: np.ndarray, kernel: np.ndarray, frequency: np.ndarray) -> np.ndarray:
    """K^(w) = int K(t) exp(-i w t) dt, (nw, n, n), with K linear in time and zero after its end."""
    return fourier_integral(time, kernel, frequency).conj()


def smallest_eigenvalue(damping: np.ndarray) -> float:
    """Smallest over largest eigenvalue of the symmetric part of B(w), over all w.

    The matrices are scaled first, so that the largest |B_ii| is 1 for every DOF. A negative value
    means that motion at some frequency would gain energy from the waves that it radiates.
    """
    scale = diagonal_scale(damping)
    scaled = damping / (scale[:, None] * scale)
    eigenvalues = np.linalg.eigvalsh(0.5 * (scaled + np.swapaxes(scaled, -1, -2)))
    largest = np.abs(eigenvalues).max(initial=0.0)
    return float(eigenvalues.min() / largest) if largest > 0.0 else 0.0


def fourier_integral(x: np.ndarray, f: np.ndarray, y: np.ndarray) -> np.ndarray:
    """int f(x) exp(i x y) dx for f (nx, ...) linear between the x (nx,): (ny, ...), exact.

    On a piece of width h about x_m this is h exp(i x_m y) (f_m j0(z) + i df/2 j1(z)), z = h y / 2,
    with spherical Bessel functions. There is no cancellation at small z (equivalent to Filon 1928).
    """
    from scipy.special import spherical_jn  # slow to load, and dry scenes radiate nothing

    h = np.diff(x)
    wave = h * np.exp(1j * np.multiply.outer(y, 0.5 * (x[1:] + x[:-1])))
    z = 0.5 * np.multiply.outer(y, h)
    mean = 0.5 * (f[1:] + f[:-1])
    rise = 0.5 * np.diff(f, axis=0)
    even = np.tensordot(wave * spherical_jn(0, z), mean, 1)
    return even + 1j * np.tensordot(wave * spherical_jn(1, z), rise, 1)


def _power_integral(x: np.ndarray, q: np.ndarray) -> np.ndarray:
    """int_1^inf u^-q cos(x u) du for x (nx,) >= 0 and q (...) > 1: (nx, ...).

    Along u = 1 + i s the integrand decays without oscillating; the trapezoidal rule in y with
    s = exp(pi/2 sinh y) then converges exponentially (Takahasi and Mori 1974).
    """
    y, dy = np.linspace(-4.0, 5.0, 136, retstep=True)
    s = np.exp(0.5 * np.pi * np.sinh(y))
    ds = s * 0.5 * np.pi * np.cosh(y) * dy
    wave = 1j * np.exp(1j * x)[:, None] * np.exp(-np.multiply.outer(x, s)) * ds
    return np.tensordot(wave, np.exp(-np.multiply.outer(np.log1p(1j * s), q)), 1).real


def find_radiating(matrices: np.ndarray) -> np.ndarray:
    """The DOFs with radiation, ascending, from B or K (..., n, n), n = 6 per body.

    A DOF whose largest |M_ii| is below 1e-9 of the largest of its kind (translations or rotations
    of one body) has rounding errors only, such as yaw of a body of revolution.
    """
    largest = np.abs(np.diagonal(matrices, axis1=-2, axis2=-1)).max(axis=0)
    triples = np.arange(0, largest.size, 3)
    of_kind = np.repeat(np.maximum.reduceat(largest, triples), 3)[: largest.size]
    return np.flatnonzero(largest > NO_RADIATION * of_kind)


def diagonal_scale(matrices: np.ndarray) -> np.ndarray:
    """sqrt(max |M_ii|) per DOF (n,) of (..., n, n), 1 where the diagonal is zero throughout."""
    largest = np.abs(np.diagonal(matrices, axis1=-2, axis2=-1)).max(axis=0)
    return np.sqrt(np.where(largest > 0.0, largest, 1.0))


def relative_size(part: np.ndarray, whole: np.ndarray) -> float:
    """Largest |part_ij| / sqrt(max |whole_ii| max |whole_jj|), for (..., n, n)."""
    scale = diagonal_scale(whole)
    return float(np.max(np.abs(part) / (scale[:, None] * scale), initial=0.0))


def _check(frequency: np.ndarray, matrices: np.ndarray) -> None:
    if matrices.ndim != 3 or matrices.shape != (frequency.size, *matrices.shape[1:2] * 2):
        raise InputError(
            f"radiation: {frequency.size} frequencies with coefficients of shape {matrices.shape};"
            f" expected ({frequency.size}, n, n). Check what the database's reader returns."
        )
    if not np.all(np.isfinite(frequency)) or frequency[0] < 0 or np.any(np.diff(frequency) <= 0):
        raise InputError(
            "radiation: found the frequencies"
            f" {np.array2string(frequency, threshold=8)} rad/s; expected finite, increasing"
            " numbers, none negative. Sort them. Put added mass at w = 0 into added_mass_zero, and"
            " at infinity into added_mass_infinite."
        )
    bad = ~np.isfinite(matrices)
    if np.any(bad):
        k, i, j = np.argwhere(bad)[0]
        raise InputError(
            f"radiation: entry ({i}, {j}) at {frequency[k]:g} rad/s is {matrices[k, i, j]},"
            " expected a finite number. Solve that frequency again or leave it out of the database."
        )


LONGER = 1.5  # times the memory: the change by this extension is as large as the cut, if K decays
SLOWEST, COUNT = 0.01, 400  # rad/s, number of frequencies


class Spectra(NamedTuple):
    """``K`` (nw, n, n), K^(s) of a memory at s = 1/T + i ``w`` (nw,). ``cut`` (nw, n, n) is the
    change of K^ + s A_inf by a memory `LONGER` times as long."""

    w: np.ndarray
    K: np.ndarray
    cut: np.ndarray


def spectra(
    memory: Retardation,
    frequency: np.ndarray,
    added_mass: np.ndarray,
    damping: np.ndarray,
    checksum: str,
    duration: float,
) -> Spectra:
    """Spectra of ``memory`` for runs of a ``duration`` T [s], up to the highest of the database's
    ``frequency`` (nw,). For the coefficients see `retardation`. The result is stored in the cache
    folder by the ``checksum``, the memory and the duration."""
    settings = (checksum, memory.time.size, float(memory.time[-1]), duration)
    make = partial(_spectra, memory, frequency, added_mass, damping, 1.0 / duration)
    return read_or_make("spectra", settings, make, Spectra._asdict, _read_spectra)


@one_thread
def _spectra(
    memory: Retardation,
    frequency: np.ndarray,
    added_mass: np.ndarray,
    damping: np.ndarray,
    fading: float,
) -> Spectra:
    length, step = float(memory.time[-1]), float(memory.time[1])
    late = retardation(frequency, added_mass, damping, length=LONGER * length, step=step)
    w = np.geomspace(min(SLOWEST, frequency[0]) or SLOWEST, frequency[-1], COUNT)
    K, longer = (
        transfer_function(of.time, np.exp(-fading * of.time)[:, None, None] * of.kernel, w)
        for of in (memory, late)
    )
    more = late.added_mass_infinite - memory.added_mass_infinite
    return Spectra(w, K, longer - K + (fading + 1j * w[:, None, None]) * more)


def _read_spectra(arrays: Arrays) -> Spectra:
    return Spectra(*(arrays[name] for name in Spectra._fields))
