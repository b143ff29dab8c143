"""Changes of a database after reading: fewer frequencies, symmetry, accepted findings.

The attribute ``changed`` describes each change, so that results and written files state it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from hydrosim.database.checks import ACCEPTED_ATTRIBUTE, accepted_findings, unknown_name_message
from hydrosim.database.database import HydroDatabase, Real, of_frequencies
from hydrosim.database.transfer import MATRICES
from hydrosim.dofs import MIRROR_SIGN
from hydrosim.errors import InputError
from hydrosim.scene import Changes, Without

CHANGED_ATTRIBUTE = "changed"  # attribute: changes as text
BODIES_APART = "bodies_apart"  # attribute: "yes" if bodies have no hydrodynamic interaction

_WITHOUT = {
    Without.DRIFT: ("mean_drift", "mean_drift_held", "drift_imbalance"),
    Without.QTF: ("qtf_frequency", "qtf_heading", "qtf_difference", "qtf_sum"),
}


def apply_changes(db: HydroDatabase, changes: Changes) -> HydroDatabase:
    """Database with the ``changes``. Raises `InputError` if they do not fit it."""
    if changes.frequencies is not None:
        db = _cut_frequencies(db, *changes.frequencies)
    for part in changes.without:
        db = _drop_part(db, part)
    if changes.bodies_apart:
        db = _uncouple_bodies(db)
    if changes.symmetrise:
        db = _symmetric(db)
    said = [*filter(None, [db.attributes.get(CHANGED_ATTRIBUTE)]), *_change_words(changes)]
    more = {CHANGED_ATTRIBUTE: "; ".join(said)} if said else {}
    if changes.accept:
        more[ACCEPTED_ATTRIBUTE] = ", ".join(
            [*accepted_findings(db), *map(_check_finding_name, changes.accept)]
        )
    return replace(db, attributes={**db.attributes, **more})


def _change_words(changes: Changes) -> Iterator[str]:
    if changes.frequencies is not None:
        yield "only frequencies {:g} to {:g} rad/s".format(*changes.frequencies)
    for part in changes.without:
        yield f"without {part}"
    if changes.bodies_apart:
        yield "bodies apart"
    if changes.symmetrise:
        yield "symmetrised"


def _check_finding_name(name: str) -> str:
    """The name of a finding."""
    if wrong := unknown_name_message(name):
        raise InputError(f"hydrodynamics.accept: {wrong}.")
    return name


def _cut_frequencies(db: HydroDatabase, lowest: float, highest: float) -> HydroDatabase:
    keep = (db.frequency >= lowest) & (db.frequency <= highest)
    if np.count_nonzero(keep) < 2:
        raise InputError(
            f"hydrodynamics.frequencies: found {lowest:g} to {highest:g} rad/s, in which"
            f" {db.source} has {np.count_nonzero(keep)} frequencies; expected at least two, of"
            f" {db.frequency[0]:g} to {db.frequency[-1]:g} rad/s."
        )
    return of_frequencies(db, keep)


def _drop_part(db: HydroDatabase, part: Without) -> HydroDatabase:
    if part == Without.LOADS:
        return without_loads(db)
    nothing: dict[str, Any] = dict.fromkeys(_WITHOUT[part])
    return replace(db, **nothing)


def without_loads(db: HydroDatabase) -> HydroDatabase:
    """Database without headings, and so without wave loads."""
    for part in (Without.DRIFT, Without.QTF):
        db = _drop_part(db, part)
    none = np.zeros((db.frequency.size, 0, 6 * db.bodies), dtype=complex)
    return replace(db, heading=np.zeros(0), excitation=none, froude_krylov=None)


def _uncouple_bodies(db: HydroDatabase) -> HydroDatabase:
    """Database without the blocks of the matrices that couple bodies."""
    body = np.arange(6 * db.bodies) // 6
    own = (body[:, None] == body).astype(float)
    attributes = {**db.attributes, BODIES_APART: "yes"}
    return replace(db, **_matrices(db, own), attributes=attributes)


def _symmetric(db: HydroDatabase) -> HydroDatabase:
    """Database with symmetric matrices. If bodies are symmetric, entries that couple symmetric with
    antisymmetric motions are zero."""
    halves = replace(
        db,
        **{
            name: (value + np.swapaxes(value, -1, -2)) / 2
            for name in MATRICES
            if (value := getattr(db, name)) is not None
        },
    )
    if not db.port_starboard_symmetric:
        return halves
    sign = np.tile(MIRROR_SIGN, db.bodies)
    return replace(halves, **_matrices(halves, (np.outer(sign, sign) > 0).astype(float)))


def _matrices(db: HydroDatabase, weight: Real) -> dict[str, Any]:
    values = {name: getattr(db, name) for name in MATRICES}
    return {name: value * weight for name, value in values.items() if value is not None}
