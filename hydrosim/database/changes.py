"""Changes of a database after reading: other centres, fewer frequencies, symmetry, findings.

The attribute ``changed`` describes each change, so that results and written files state it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hydrosim.database import database
from hydrosim.database.checks import ACCEPTED_ATTRIBUTE, accepted_findings, unknown_name_message
from hydrosim.dofs import MIRROR_SIGN
from hydrosim.errors import InputError
from hydrosim.scene import Changes, Without

# Other centres of gravity, and one body of several.

MATRIX_VARIABLES = (
    "added_mass",
    "radiation_damping",
    "added_mass_zero",
    "added_mass_infinite",
    "hydrostatic_stiffness",
    "inertia_matrix",
)
LOAD_NAMES = (
    "excitation",
    "froude_krylov",
    "mean_drift",
    "mean_drift_held",
    "qtf_difference",
    "qtf_sum",
)
BODY_POINTS = ("reference_point", "centre_of_gravity", "centre_of_buoyancy")


def move_reference(
    db: database.HydroDatabase, centre_of_gravity: ArrayLike
) -> database.HydroDatabase:
    """Database with its coefficients about new centres of gravity (nb, 3), database frame.

    The velocity of the reference points is v_ref = T v for the velocity v of the new ones. Equal
    power then gives loads T^T X and matrices T^T A T (Newman 1977, Marine Hydrodynamics, chapter
    4). Phases still refer to the elevation at the frame's origin.

    The stiffness transforms in the same way, because it is the second derivative of an energy that
    is stationary at rest. With weight equal to buoyancy, a centre of gravity that rises by dz also
    reduces roll and pitch stiffness by rho g V dz (GM falls by dz; Newman 1977, chapter 6). A
    sideways shift of the centre of gravity must be balanced by other means, because the body stays
    at rest in the position of the database.

    ``inertia_matrix`` is dropped when a centre of gravity moves, because it belongs to another
    distribution of mass. Returns ``db`` itself if nothing moves.
    """
    new = np.reshape(np.asarray(centre_of_gravity, dtype=float), (db.bodies, 3))
    old = database.require_array(db, "centre_of_gravity")
    if np.array_equal(new, db.reference_point) and np.array_equal(new, old):
        return db
    T = velocity_transfer(db.reference_point - new)
    stiffness = T.T @ database.require_array(db, "hydrostatic_stiffness") @ T
    weight = db.water_density * db.gravity * database.require_array(db, "volume")
    for body, loss in enumerate(weight * (new - old)[:, 2]):
        for dof in (6 * body + 3, 6 * body + 4):
            stiffness[dof, dof] -= loss
    same_mass = np.array_equal(new, old)
    return replace(
        db,
        reference_point=new,
        centre_of_gravity=new,
        hydrostatic_stiffness=stiffness,
        added_mass=T.T @ db.added_mass @ T,
        radiation_damping=T.T @ db.radiation_damping @ T,
        added_mass_zero=_transform_matrix(db.added_mass_zero, T),
        added_mass_infinite=_transform_matrix(db.added_mass_infinite, T),
        inertia_matrix=_transform_matrix(db.inertia_matrix, T) if same_mass else None,
        excitation=db.excitation @ T,
        froude_krylov=_transform_loads(db.froude_krylov, T),
        mean_drift=_transform_loads(db.mean_drift, T),
        mean_drift_held=_transform_loads(db.mean_drift_held, T),
        qtf_difference=_transform_loads(db.qtf_difference, T),
        qtf_sum=_transform_loads(db.qtf_sum, T),
    )


def body_of(db: database.HydroDatabase, index: int) -> database.HydroDatabase:
    """Database of one body of several, counted from 0, while the others are held.

    ``drift_imbalance`` is dropped, because it belongs to all bodies. Returns ``db`` itself if it
    has only one body.
    """
    if db.bodies == 1:
        return db
    row, dofs = slice(index, index + 1), slice(6 * index, 6 * index + 6)

    def part(value: Any, *axes: slice) -> Any:
        return None if value is None else value[(..., *axes)]

    return replace(
        db,
        **{name: part(getattr(db, name), dofs, dofs) for name in MATRIX_VARIABLES},
        **{name: part(getattr(db, name), dofs) for name in LOAD_NAMES},
        **{name: part(getattr(db, name), row, slice(None)) for name in BODY_POINTS},
        volume=part(db.volume, row),
        drift_imbalance=None,
    )


def velocity_transfer(offset: database.Real) -> database.Real:
    """Matrix T (n, n): the velocity at points ``offset`` (nb, 3) from the centres is T times
    theirs."""
    T = np.eye(6 * len(offset))
    for body, (x, y, z) in enumerate(offset):
        rows = slice(6 * body, 6 * body + 3)
        columns = slice(6 * body + 3, 6 * body + 6)
        T[rows, columns] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    return T


def _transform_matrix(value: database.Real | None, T: database.Real) -> database.Real | None:
    return None if value is None else T.T @ value @ T


def _transform_loads(value: database.Real | database.Complex | None, T: database.Real) -> Any:
    return None if value is None else value @ T


CHANGED_ATTRIBUTE = "changed"  # attribute: changes as text
BODIES_APART = "bodies_apart"  # attribute: "yes" if bodies have no hydrodynamic interaction

_WITHOUT = {
    Without.DRIFT: ("mean_drift", "mean_drift_held", "drift_imbalance"),
    Without.QTF: ("qtf_frequency", "qtf_heading", "qtf_difference", "qtf_sum"),
}


def apply_changes(db: database.HydroDatabase, changes: Changes) -> database.HydroDatabase:
    """Database with the ``changes``. Raises `InputError` if they do not fit it."""
    if changes.frequencies is not None:
        db = _cut_frequencies(db, *changes.frequencies)
    for part in changes.without:
        db = _drop_part(db, part)
    if changes.bodies_apart:
        db = _uncouple_bodies(db)
    if changes.symmetrise:
        db = _make_symmetric(db)
    changes_text = [*filter(None, [db.attributes.get(CHANGED_ATTRIBUTE)]), *_change_words(changes)]
    more = {CHANGED_ATTRIBUTE: "; ".join(changes_text)} if changes_text else {}
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


def _cut_frequencies(
    db: database.HydroDatabase, lowest: float, highest: float
) -> database.HydroDatabase:
    keep = (db.frequency >= lowest) & (db.frequency <= highest)
    if np.count_nonzero(keep) < 2:
        raise InputError(
            f"hydrodynamics.frequencies: found {lowest:g} to {highest:g} rad/s, in which"
            f" {db.source} has {np.count_nonzero(keep)} frequencies; expected at least two, of"
            f" {db.frequency[0]:g} to {db.frequency[-1]:g} rad/s."
        )
    return database.select_frequencies(db, keep)


def _drop_part(db: database.HydroDatabase, part: Without) -> database.HydroDatabase:
    if part == Without.LOADS:
        return without_loads(db)
    nothing: dict[str, Any] = dict.fromkeys(_WITHOUT[part])
    return replace(db, **nothing)


def without_loads(db: database.HydroDatabase) -> database.HydroDatabase:
    """Database without headings, and so without wave loads."""
    for part in (Without.DRIFT, Without.QTF):
        db = _drop_part(db, part)
    none = np.zeros((db.frequency.size, 0, 6 * db.bodies), dtype=complex)
    return replace(db, heading=np.zeros(0), excitation=none, froude_krylov=None)


def _uncouple_bodies(db: database.HydroDatabase) -> database.HydroDatabase:
    """Database without the blocks of the matrices that couple bodies."""
    body = np.arange(6 * db.bodies) // 6
    same_body = (body[:, None] == body).astype(float)
    attributes = {**db.attributes, BODIES_APART: "yes"}
    return replace(db, **_transformed_matrices(db, same_body), attributes=attributes)


def _make_symmetric(db: database.HydroDatabase) -> database.HydroDatabase:
    """Database with symmetric matrices. If bodies are symmetric, entries that couple symmetric with
    antisymmetric motions are zero."""
    halves = replace(
        db,
        **{
            name: (value + np.swapaxes(value, -1, -2)) / 2
            for name in MATRIX_VARIABLES
            if (value := getattr(db, name)) is not None
        },
    )
    if not db.port_starboard_symmetric:
        return halves
    sign = np.tile(MIRROR_SIGN, db.bodies)
    return replace(
        halves, **_transformed_matrices(halves, (np.outer(sign, sign) > 0).astype(float))
    )


def _transformed_matrices(db: database.HydroDatabase, weight: database.Real) -> dict[str, Any]:
    values = {name: getattr(db, name) for name in MATRIX_VARIABLES}
    return {name: value * weight for name, value in values.items() if value is not None}
