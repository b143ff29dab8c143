"""Second-order loads by pressures on the hull: difference-frequency QTFs, mean drift of each body.

Time factor exp(+i w t), convention of `HydroDatabase`. For two first-order quantities u and v,
u_1 per unit wave amplitude at w_1, the product u v varies slowly as

    Re sum_1 sum_2 a_1 conj(a_2) (u_1 conj(v_2) + v_1 conj(u_2)) / 4 exp(i (w_1 - w_2) t)

so that its transfer function is the Hermitian part of u_1 conj(v_2) / 2.

Mean drift of each of several bodies, in the waves of all of them.

The far field gives the drift of all bodies together. The pressure on each hull gives the drift of
that hull: the diagonal of `quadratic`, which converges slowly with the panels. So the forces
come from the pressures. Their difference from the far field in surge and sway is shared among the
bodies in proportion to their forces. Heave and moments come from the pressures.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import joblib
import numpy as np
import scipy

from hydrosim.database import HydroDatabase, all_headings, require_array
from hydrosim.database.build import bem, near_field
from hydrosim.database.build.assemble import LATERAL, Floating, floating_waves
from hydrosim.database.build.drift import Complex, Drifting, Real, Water, mean_drift
from hydrosim.errors import InputError

FAR_FIELD = np.array([True, True, False, False, False, True])
RATIO_LIMITS = 0.5, 2.0  # limits of the ratio of far to near field
SMALL_DIAGONAL_FRACTION = 0.25  # of the largest diagonal: below it the ratio is not used
TURN_RAD = 2 * np.pi


def difference_qtf(
    db: HydroDatabase,
    wetted: near_field.Wetted,
    flows: Sequence[near_field.Flow],
    headings: Real,
    crossing: bool = False,
) -> tuple[Real, Complex]:
    """Pairs of headings (np, 2) [rad] and T- (np, nq, nq, 6) [N/m^2, N m/m^2] about the reference
    point, at the frequencies (nq) and ``headings`` (nh,) of ``flows``. Each heading is paired with
    itself or, with ``crossing``, with every heading.

    T- is `quadratic`, brought to the far field's diagonal by `correct_to_diagonals`, plus
    `second_order_potential`. ``db`` is the body's own database, with the mean drift of the same
    body, floating or held. Raises `InputError` if it lacks a heading or a frequency.
    """
    water = Water(db.water_density, db.gravity)
    count = range(len(headings))
    chosen = [(a, b) for a in count for b in count if crossing or a == b]
    pairs = headings[np.array(chosen)]
    frequency = np.array([flow.frequency for flow in flows])
    near = np.array([_diagonal(quadratic(water, wetted, flows, a, a)) for a in count])
    far = np.where(FAR_FIELD, _drift(db, frequency, headings), near)
    transfer = np.array(
        [
            correct_to_diagonals(quadratic(water, wetted, flows, a, b), near[[a, b]], far[[a, b]])
            + second_order_potential(db, frequency, headings[a], headings[b])
            for a, b in chosen
        ]
    )
    along = np.isclose(np.sin(pairs), 0.0, atol=1e-9).all(axis=1)
    forbidden = db.port_starboard_symmetric & along[:, None, None, None] & LATERAL
    return pairs, np.where(forbidden, 0.0, transfer)


def mean_load(water: Water, wetted: near_field.Wetted, flow: near_field.Flow) -> Real:
    """Mean load (headings, 6) of regular waves per amplitude squared, from the pressures."""
    count = range(len(flow.motion))
    return np.array([_diagonal(quadratic(water, wetted, [flow], a, a))[0] for a in count])


def quadratic(
    water: Water,
    wetted: near_field.Wetted,
    flows: Sequence[near_field.Flow],
    first: int,
    second: int,
) -> Complex:
    """T- (nq, nq, 6) from products of first-order quantities, for the headings with these two
    indices.

    n is the outward normal, s the rise of the water relative to the hull's waterline, X the
    displacement, A the rotation and F the first-order force of fluid and weight. Then it follows
    from

        -rho g / 2 int s^2 n / sqrt(1 - n_z^2) dl + rho / 2 int |grad phi|^2 n dS
        + rho int (X . grad phi_t) n dS + A x F

    (Pinkster 1980, Low frequency second order wave exciting forces on floating structures) and the
    hydrostatic load by second-order rotation, see `_second_order_rotation_load`. Moments are about
    the moving reference point: the arm is crossed with n, and F is the moment.
    """
    forward = _products(water, wetted, flows, first, second)
    back = forward if first == second else _products(water, wetted, flows, second, first)
    return (forward + _mirror(back)) / 2


def second_order_potential(
    db: HydroDatabase, frequency: Real, first: float, second: float
) -> Complex:
    """T- (nq, nq, 6) from the second-order potential of the incident waves, for two headings [rad].
    It is diffracted like a first-order wave of the same length (Pinkster 1980).

    Waves with w_1 > w_2 and wave vectors k_1, k_2 at an angle b force the potential

        P = -i dw w_1 w_2 (1 + cos b) / (2 (g |K| - dw^2)),  dw = w_1 - w_2,  K = k_1 - k_2

    per a_1 conj(a_2) (Longuet-Higgins 1962 in deep water). Scaled to it, the excitation X at
    w' = sqrt(g |K|) in the direction of K gives P dw / (i g) X: for one heading,
    -(w_1 / 2) (dw / g) X.
    """
    w_1, w_2 = frequency[:, None], frequency[None, :]
    sign = np.where(w_1 < w_2, -1.0, 1.0)
    x = sign * (w_1**2 * np.cos(first) - w_2**2 * np.cos(second))
    y = sign * (w_1**2 * np.sin(first) - w_2**2 * np.sin(second))
    slow = (w_1 - w_2) ** 2
    squared = np.where(slow > 0, np.hypot(x, y), 0.0)  # g |K|
    free = np.where(slow > 0, squared - slow, 1.0)
    ratio = -slow * w_1 * w_2 * (1 + np.cos(first - second)) / (2 * db.gravity * free)
    X = _excitation(db, np.sqrt(squared), np.arctan2(y, x))
    return ratio[..., None] * np.where(sign[..., None] < 0, np.conj(X), X)


def correct_to_diagonals(transfer: Complex, near: Real, far: Real) -> Complex:
    """``transfer`` (nq, nq, 6) between two headings, corrected to the better diagonals ``far`` (2,
    nq, 6). ``near`` (2, nq, 6) are the diagonals that the same pressures give for either heading:

        T_12 sqrt(r_1 r_2) + (e_1 + e_2) / 2
        r = (far near + s^2) / (near^2 + s^2),  e = far - r near

    with s a quarter of the largest value of near. r is the ratio of both diagonals where they are
    large. It is one where they pass through zero, because they tell nothing about other pairs
    there. It is limited to 1/2 to 2. The result is Hermitian, and for equal headings its diagonal
    is far. Two different headings have no common diagonal, so e is left out.
    """
    small = np.square(SMALL_DIAGONAL_FRACTION * np.abs(near).max(axis=1, keepdims=True))
    with np.errstate(invalid="ignore"):
        ratio = (far * near + small) / (near**2 + small)
    scale = np.clip(np.nan_to_num(ratio, nan=1.0), *RATIO_LIMITS)
    result = transfer * np.sqrt(scale[0][:, None] * scale[1])
    if np.array_equal(near[0], near[1]):
        rest = far[0] - scale[0] * near[0]
        result = result + (rest[:, None] + rest) / 2
    return result


def _products(
    water: Water,
    wetted: near_field.Wetted,
    flows: Sequence[near_field.Flow],
    first: int,
    second: int,
) -> Complex:
    """Terms of `quadratic` before the Hermitian part is taken."""
    density, weight = water.density, water.density * water.gravity
    w = np.array([flow.frequency for flow in flows])
    first_flow, second_flow = _heading(flows, first), _heading(flows, second)
    moved = near_field.displacement(first_flow.motion, wetted.arm)
    twice = _integral(
        -weight / 2 * wetted.edge, first_flow.rise[..., None], second_flow.rise[..., None]
    )
    squared = [
        np.einsum("qnk,nkl->qnl", flow.velocity, wetted.sharp) for flow in (first_flow, second_flow)
    ]
    twice += _integral(density / 2 * wetted.area, *squared)
    acceleration = np.conj(1j * w[:, None])
    twice += acceleration * _integral(density * wetted.area, moved, second_flow.velocity)
    turn, load = first_flow.motion[:, None, 3:], np.conj(second_flow.load)
    twice += np.concatenate([np.cross(turn, load[:, :3]), np.cross(turn, load[:, 3:])], axis=-1)
    return (
        twice
        + _second_order_rotation_load(
            weight, wetted, first_flow.motion[:, 3:], second_flow.motion[:, 3:]
        )
    ) / 2


def _second_order_rotation_load(
    weight: float, wetted: near_field.Wetted, first_value: Complex, second_value: Complex
) -> Complex:
    """Hydrostatic load (nq, nq, 6) by the second order of rotation vectors (nq, 3).

    A point at (x, y, z) from the reference point rises by A_z (A_x x + A_y y) / 2
    - (A_x^2 + A_y^2) z / 2. Its pressure over the hull is a force that the first-order buoyancy
    turning with the body balances but for the waterplane's part (Lee 1995, WAMIT theory manual,
    section 4.1, with the rotation vector in the place of Euler's angles).
    """
    pressed = weight * wetted.arm.T @ wetted.area
    pressed -= pressed[0, 0] * np.eye(3, 6)  # rho g V: the volume is int x n_x dS
    a, b = first_value[:, None], np.conj(second_value)
    upwards = -a[..., 0] * b[:, 0] - a[..., 1] * b[:, 1]
    slope = np.stack([a[..., 0] * b[:, 2], a[..., 1] * b[:, 2], upwards], axis=-1)
    return slope @ pressed / 2


def _integral(weight: Real, first_value: Complex, second_value: Complex) -> Complex:
    """Sums (nq, nq, 6) of ``weight`` (n, 6) times one . conj(two), each (nq, n, components)."""
    rows, columns = len(first_value), np.conj(second_value).reshape(len(second_value), -1).T
    parts = [(first_value * column[:, None]).reshape(rows, -1) @ columns for column in weight.T]
    return np.stack(parts, axis=-1)


def _heading(flows: Sequence[near_field.Flow], index: int) -> near_field.Flow:
    """The flows at one heading, frequencies first."""
    return near_field.Flow(
        frequency=0.0,
        motion=np.array([flow.motion[index] for flow in flows]),
        load=np.array([flow.load[index] for flow in flows]),
        velocity=np.array([flow.velocity[index] for flow in flows]),
        rise=np.array([flow.rise[index] for flow in flows]),
    )


def _mirror(transfer: Complex) -> Complex:
    return np.conj(np.swapaxes(transfer, 0, 1))


def _diagonal(transfer: Complex) -> Real:
    return np.real(np.einsum("iic->ic", transfer))


def _drift(db: HydroDatabase, frequency: Real, headings: Real) -> Real:
    """Mean drift (nh, nq, 6), linear between the database's frequencies."""
    _check_range(db, frequency)
    rows = [int(np.argmin(np.abs(db.heading - heading))) for heading in headings]
    if not np.allclose(db.heading[rows], headings):
        raise InputError(
            f"{db.source}: has mean drift for the headings {np.degrees(db.heading)} deg; expected"
            f" it for all headings of the QTF, {np.degrees(headings)} deg. Compute it for these."
        )
    drift = require_array(db, "mean_drift")[:, rows].reshape(len(db.frequency), -1)
    values = np.array([np.interp(frequency, db.frequency, column) for column in drift.T])
    return np.swapaxes(values.reshape(len(rows), 6, -1), 1, 2)


def _excitation(db: HydroDatabase, frequency: Real, direction: Real) -> Complex:
    """Excitation (..., 6) by splines over the frequencies, starting from a static rise of the
    water, and linear between the headings."""
    _check_range(db, frequency[frequency > db.frequency[0]])
    full = all_headings(db)
    static = np.broadcast_to(
        require_array(db, "hydrostatic_stiffness")[:, 2], full.excitation.shape[1:]
    )
    knots = np.concatenate([[0.0], full.frequency])
    X = scipy.interpolate.CubicSpline(knots, np.concatenate([static[None], full.excitation]))(
        frequency
    )
    start, count = full.heading[0], len(full.heading)
    turned = start + np.mod(direction - start, TURN_RAD)
    place = np.interp(turned, [*full.heading, start + TURN_RAD], np.arange(count + 1))
    left = np.floor(place).astype(int)
    share = (place - left)[..., None]
    return (
        _loads_at_heading(X, left % count) * (1 - share)
        + _loads_at_heading(X, (left + 1) % count) * share
    )


def _loads_at_heading(loads: Complex, heading: np.ndarray) -> Complex:
    return np.take_along_axis(loads, heading[..., None, None], axis=-2)[..., 0, :]


def _check_range(db: HydroDatabase, frequency: Real) -> None:
    low, high = db.frequency[[0, -1]]
    if frequency.size and not (low <= frequency.min() and frequency.max() <= high):
        raise InputError(
            f"{db.source}: covers {low:g} to {high:g} rad/s; expected {frequency.min():g} to"
            f" {frequency.max():g} rad/s for its QTF. Compute the database for more frequencies,"
            " or the QTF for fewer."
        )


def drift_of_each(
    hull: bem.Hull,
    body: Floating,
    water: Water,
    solutions: Iterable[bem.Solution],
    headings: Real,
    kinds: Iterable[Drifting],
    jobs: int,
    progress: bem.Progress,
) -> dict[Drifting, Real]:
    """Mean drift per amplitude squared (frequencies, headings, n) of the free and of the held
    bodies, by ``jobs`` processes, in deep water. Results are stored on the disk by frequency."""
    _ = hull.body
    solutions, drifts = list(solutions), {}
    for kind in kinds:
        floating = body if kind is Drifting.FREE else None
        task = joblib.delayed(_stored_drifts)
        calls = (task(hull, floating, water, s.frequency, headings) for s in solutions)
        near = []
        for drift in bem.compute_all(calls, jobs):
            near.append(drift)
            progress(len(near), len(solutions))
        far = np.array([_far_field_drifts(body, kind, s, headings, water) for s in solutions])
        drifts[kind] = brought_to(np.array(near), far)
    return drifts


def brought_to(near: Real, far: Real) -> Real:
    """Drift ``near`` (..., n) of the bodies, corrected so that surge and sway add up to those of
    all bodies, ``far`` (..., 6)."""
    loads = near.reshape(*near.shape[:-1], -1, 6)
    size = np.abs(loads) + np.finfo(float).tiny
    missing = far[..., None, :] - loads.sum(axis=-2, keepdims=True)
    shared = missing * size / size.sum(axis=-2, keepdims=True)
    told = np.array([True, True, False, False, False, False])
    return np.where(told, loads + shared, loads).reshape(near.shape)


def _far_field_drifts(
    body: Floating, kind: Drifting, s: bem.Solution, headings: Real, water: Water
) -> Real:
    """Drift (headings, 6) of all bodies together."""
    free = kind is Drifting.FREE
    waves = (
        floating_waves(body, s, s.added_mass, s.damping, s.excitation)
        if free
        else s.kochin_diffraction
    )
    return mean_drift(waves, s.frequency, headings, water).force


def _stored_drifts(
    hull: bem.Hull, floating: Floating | None, water: Water, frequency: float, headings: Real
) -> Real:
    held = (np.empty(0),) if floating is None else (floating.inertia, floating.stiffness)
    key = bem.key_of("drift of each", bem.solution_key(hull, water, frequency, headings), *held)
    return bem.remembered(
        key, lambda: [_near_field_drifts(hull, floating, water, frequency, headings)]
    )[0]


def _near_field_drifts(
    hull: bem.Hull, floating: Floating | None, water: Water, frequency: float, headings: Real
) -> Real:
    """Drift (headings, n) of each body from the pressures on its hull."""
    parts = near_field.parts_of(hull)
    flows = near_field.first_order_of_each(hull.body, parts, floating, water, frequency, headings)
    pairs = zip(parts, flows, strict=True)
    loads = [mean_load(water, near_field.wetted_surface(part), flow) for part, flow in pairs]
    return np.concatenate(loads, axis=1)
