"""Checks of the mean drift and of quadratic transfer functions."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hydrosim.database import database
from hydrosim.database.checks import finding

_SHORT_WAVE = 2.0  # k V^(1/3) above which the drift is near its limit for short waves


def _drift_along_waves(db: database.HydroDatabase) -> database.Real:
    """Mean drift force (nw, nh) of all bodies along the waves."""
    drift = (
        database.require_array(db, "mean_drift")
        .reshape(*db.excitation.shape[:2], db.bodies, 6)
        .sum(axis=2)
    )
    return drift[..., 0] * np.cos(db.heading) + drift[..., 1] * np.sin(db.heading)


def _maruo_drift(db: database.HydroDatabase) -> finding.RelativeErrors:
    """Maruo's (1960) formula gives the force along the waves as an integral of |H(theta)|^2 (1 -
    cos(theta - beta)), which is never negative."""
    along = _drift_along_waves(db)
    against = np.maximum(0.0, -along)
    relative = against / max(np.abs(along).max(), np.finfo(float).tiny)
    return finding.RelativeErrors(relative, ("frequency", "heading"), against, ("N/m²", ""))


def _drift_size(db: database.HydroDatabase) -> finding.RelativeErrors:
    """A wall of width b reflects short waves, with a force of rho g b / 2. The force over all
    headings is compared with that for the bodies' size."""
    if db.frequency[-1] ** 2 / db.gravity * finding.length(db).min() < _SHORT_WAVE:
        raise finding.LeftOut("needs a higher frequency")
    wall = 0.5 * db.water_density * db.gravity * finding.length(db).sum()
    return finding.single_error(
        abs(np.log10(max(np.abs(_drift_along_waves(db)[-1]).mean() / wall, 1e-300)))
    )


def _symmetry_errors(db: database.HydroDatabase) -> finding.RelativeErrors:
    qtf = database.require_array(db, "qtf_difference")
    apart = [
        _transfer_errors(db, p, qtf[p], qtf[q].conj().swapaxes(0, 1))
        for p, q in _opposite_pairs(db)
    ]
    return max(apart, key=_worst_error)


def _sum_symmetry(db: database.HydroDatabase) -> finding.RelativeErrors:
    qtf = database.require_array(db, "qtf_sum")
    return max(
        (_transfer_errors(db, p, qtf[p], qtf[q].swapaxes(0, 1)) for p, q in _opposite_pairs(db)),
        key=_worst_error,
    )


def _opposite_pairs(db: database.HydroDatabase) -> list[tuple[int, int]]:
    """Pairs of headings, and the positions of the same pairs in reverse order."""
    headings = database.require_array(db, "qtf_heading")
    same = _is_same_heading(headings[:, None, :], headings[None, :, ::-1]).all(axis=-1)
    pairs = [(int(p), int(q)) for p, q in np.argwhere(same)]
    if not pairs:
        raise finding.LeftOut("no pair of headings occurs in both orders")
    return pairs


def _diagonal(db: database.HydroDatabase) -> finding.RelativeErrors:
    """Largest difference of the diagonal from the mean drift at the same heading, for DOFs that
    have both."""
    errors = list(_diagonal_errors(db))
    if not errors:
        raise finding.LeftOut("the mean drift has none of the headings of the QTF")
    return max(errors, key=_worst_error)


def _diagonal_errors(db: database.HydroDatabase) -> Iterator[finding.RelativeErrors]:
    frequency, drift = (
        database.require_array(db, "qtf_frequency"),
        database.require_array(db, "mean_drift"),
    )
    in_range = (frequency >= db.frequency[0]) & (frequency <= db.frequency[-1])
    for (first, second), qtf in zip(
        database.require_array(db, "qtf_heading"), _qtf_values(db), strict=True
    ):
        at = np.flatnonzero(_is_same_heading(db.heading, first))
        if not _is_same_heading(first, second) or at.size == 0 or not in_range.any():
            continue
        diagonal_values = np.diagonal(qtf, axis1=0, axis2=1).T[in_range]
        for dof in np.flatnonzero(
            np.abs(diagonal_values).max(axis=0) * np.abs(drift).max(axis=(0, 1))
        ):
            there = np.interp(frequency[in_range], db.frequency, drift[:, at[0], dof])
            gap = np.abs(diagonal_values[:, dof] - there)
            of_dofs = np.full((gap.size, drift.shape[-1]), np.nan)
            of_dofs[:, dof] = gap / np.abs(drift[..., dof]).max()
            yield _largest_errors(of_dofs, frequency[in_range], first)


def _qtf_values(db: database.HydroDatabase) -> database.Complex:
    return np.asarray(db.qtf_difference)


def _transfer_errors(
    db: database.HydroDatabase, pair: int, a: database.Complex, b: database.Complex
) -> finding.RelativeErrors:
    """Errors between two transfer functions (nq, nq, n) of a pair of headings."""
    gap = np.abs(a - b).max(axis=1) / max(np.abs(a).max(), np.finfo(float).tiny)
    return _largest_errors(
        gap,
        database.require_array(db, "qtf_frequency"),
        database.require_array(db, "qtf_heading")[pair][0],
    )


def _largest_errors(
    relative: database.Real, frequency: database.Real, heading: float
) -> finding.RelativeErrors:
    """Largest of errors (nq, n) for each degree of freedom, and its position."""
    row = np.nanargmax(np.nanmax(relative, axis=1))
    where = f"at {frequency[row]:.4g} rad/s, heading {np.degrees(heading):.4g} deg"
    return finding.RelativeErrors(relative[row], ("dof",), where=where)


def _worst_error(errors: finding.RelativeErrors) -> float:
    return float(np.nanmax(errors.relative))


def _is_same_heading(a: database.Real | float, b: database.Real | float) -> np.ndarray:
    return (
        np.abs(
            (np.asarray(a) - b + database.TURN_RAD / 2) % database.TURN_RAD - database.TURN_RAD / 2
        )
        < database.SAME_HEADING
    )


_SYMMETRY = (
    "look for halves of the matrix that were filled in with or without a conjugate by mistake"
)

SECOND_ORDER = (
    finding.Check(
        "drift along the waves",
        _maruo_drift,
        0.05,
        "largest mean drift against the waves, relative to the largest along them; impossible"
        " without current and damping: look for a wrong sign, or headings that waves come from",
        refusal=0.3,
        needs=("mean_drift",),
        of=frozenset({finding.CheckSubject.DRIFT}),
    ),
    finding.Check(
        "size of the drift",
        _drift_size,
        0.7,
        "decimal logarithm of the mean drift in the shortest waves over rho g V^(1/3) / 2; look"
        " for a factor such as rho g, or wave heights used for amplitudes",
        refusal=1.5,
        needs=("mean_drift",),
        of=frozenset({finding.CheckSubject.DRIFT}),
    ),
    finding.Check(
        "QTF is Hermitian",
        _symmetry_errors,
        1e-3,
        f"largest |T-_12 - conj T-_21|, relative to the largest; {_SYMMETRY}",
        refusal=0.1,
        needs=("qtf_difference", "qtf_heading"),
        of=frozenset({finding.CheckSubject.DIFFERENCE}),
    ),
    finding.Check(
        "sum QTF is symmetric",
        _sum_symmetry,
        1e-3,
        f"largest |T+_12 - T+_21|, relative to the largest; {_SYMMETRY}",
        refusal=0.1,
        needs=("qtf_sum", "qtf_heading"),
        of=frozenset({finding.CheckSubject.SUM}),
    ),
    finding.Check(
        "QTF against mean drift",
        _diagonal,
        0.15,
        "largest difference of the QTF's diagonal from the mean drift, relative to the largest;"
        " use more frequencies or finer panels, or look for a factor such as 2 or rho g",
        refusal=1.0,
        needs=("qtf_difference", "qtf_frequency", "qtf_heading", "mean_drift"),
        of=frozenset({finding.CheckSubject.DIFFERENCE}),
    ),
)
