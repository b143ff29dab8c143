"""Joints that are constraints, at the start of a run: whether they close, agree and are regular."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy import linalg

from hydrosim.compile.drives import drives_of, motion_at
from hydrosim.dofs import about_z
from hydrosim.elements import driven_coordinates
from hydrosim.elements.joint import locks
from hydrosim.elements.joint.locks import CLOSED, NO_RATCHET
from hydrosim.elements.kind import constraint_names
from hydrosim.errors import InputError
from hydrosim.integrate.constraint_projection import choose_rows
from hydrosim.integrate.dynamics import Model, new_work
from hydrosim.linear.linearise import inertia, nullspace_of
from hydrosim.modes import MODE, NO_INDEX, SEGMENT
from hydrosim.multibody.constraints import ROW_ROUNDING
from hydrosim.multibody.kinematics import place_bodies
from hydrosim.multibody.tree import fill_rates
from hydrosim.scene.joint import Rod

if TYPE_CHECKING:
    from hydrosim.integrate.state import State
    from hydrosim.scene import Body, Scene

CLOSURE_ATOL = 1e-6  # m, rad and per second: rounding of the input, which the start removes
ASIDE = 1e-3  # of a metre and a radian: how far a linkage is moved to test whether it is regular
RANK_RTOL = 1e-7  # of the largest singular value: smaller ones are zero
MIN_ROD_LENGTH_M = 1e-9  # m: a shorter rod has no direction
TRIES = 30  # Newton's iterations back to the constraints
TAKING_PART = 0.1  # of a joint's constraints in the combination that vanishes


class Rows(NamedTuple):
    """All constraints of closed joints: J (r, n), the ``residual`` (r,) [m or rad]; the ``lock`` of
    each, and whether it ``slides``, (r,); the ``size`` (r,) as in `elements.joint.rows.Holds`."""

    J: np.ndarray
    residual: np.ndarray
    lock: np.ndarray
    slides: np.ndarray
    size: np.ndarray


def check_joints(scene: Scene) -> Iterator[str]:
    """Problems of joints of a scene that a case file cannot contain."""
    names = [body.name for body in scene.bodies]
    for name, joint in scene.joints.items():
        for key, body in (("body", joint.body), ("to", joint.to)):
            if body is not None and body not in names:
                yield f"joints.{name}.{key}: found {body}, which is no body of the scene"
        if joint.body == joint.to:
            yield f"joints.{name}.to: found {joint.to} on both sides; expected another body"
        if isinstance(joint, Rod) and {joint.body, joint.to} <= {*names, None}:
            yield from _check_rod(scene, name, joint)


def _check_rod(scene: Scene, name: str, joint: Rod) -> Iterator[str]:
    """Problems of the length of a rod."""
    bodies = {body.name: body for body in scene.bodies}
    ends = [_place_at_rest(bodies.get(str(b)), p) for b, p in _ends_of(joint)]
    apart = float(np.linalg.norm(ends[0] - ends[1]))
    if apart <= MIN_ROD_LENGTH_M:
        yield (
            f"joints.{name}.to_point: found both ends of the rod at one place, with all bodies at"
            " rest; expected two places. For one place use a ball"
        )


def _ends_of(joint: Rod) -> tuple[tuple[str | None, tuple[float, ...]], ...]:
    return (joint.body, joint.point), (joint.to, joint.to_point)


def _place_at_rest(body: Body | None, point: tuple[float, ...]) -> np.ndarray:
    """Place (3,) in the earth frame of a point of a body at rest, or of the earth."""
    if body is None:
        return np.asarray(point, float)
    turn = about_z(body.heading)
    centre = turn @ np.asarray(body.centre_of_gravity, float) + (*body.location, 0.0)
    return np.asarray(centre + turn @ np.asarray(point, float))


def check_closed(scene: Scene, model: Model, state: State) -> None:
    """Raises InputError if joints that hold at the start do not close, if velocities part them, or
    if a loop is singular."""
    if not locks.any_closed(state.modes, model.elements.locks):
        return
    rows = _all_rows(model, state.y, state.modes)
    _check_gaps(scene, model, rows)
    _check_drives(scene, model, state, rows)
    _check_velocities(scene, model, state, rows)
    _check_rods(scene, model, state)
    _check_regular(scene, model, state, rows)


def start_followers(model: Model, state: State) -> None:
    """Give what drives move through closed joints the velocities that the joints need, with the
    least kinetic energy. Velocities of the scene that agree with the drives stay as they are."""
    driven = driven_coordinates(model.elements)
    if not driven.size or not locks.any_closed(state.modes, model.elements.locks):
        return
    n = model.bodies.active.size
    rates = state.y[n : 2 * n]
    rows = _all_rows(model, state.y, state.modes)
    size = 1.0 + np.abs(rows.J) @ np.abs(rates)
    if np.all(np.abs(rows.J @ rates) <= CLOSURE_ATOL * size):
        return
    free = np.setdiff1d(np.arange(n), driven)
    below = linalg.cholesky(inertia(model, state.y)[np.ix_(free, free)], lower=True)
    scaled = linalg.solve_triangular(below, rows.J[:, free].T, lower=True).T
    wanted = -rows.J[:, driven] @ rates[driven]
    pushed = np.linalg.lstsq(scaled, wanted, rcond=RANK_RTOL)[0]
    rates[free] += linalg.solve_triangular(below.T, pushed)


def describe_dropped(scene: Scene, model: Model, state: State) -> Iterator[str]:
    """Constraints that others hold already, joint by joint."""
    p = model.elements.locks
    names = constraint_names(scene)
    for i, (name, lock) in enumerate(zip(names, p.each, strict=True)):
        mode = state.modes[p.mode + i]
        kept_rows = int(mode[SEGMENT]).bit_count()
        if mode[MODE] == CLOSED and kept_rows < lock["count"]:
            yield (
                f"joints.{name}: other joints or locked directions hold"
                f" {lock['count'] - kept_rows} of its {lock['count']} constraints already."
                " joint_force shows one of several possible shares of them. Let a joint leave more"
                " free (ball, cylindrical), or use a bushing."
            )


def bodies_move_freely(model: Model) -> bool:
    """Whether all bodies that no joint carries move in six directions."""
    tree = model.bodies.tree
    free_dofs = model.bodies.active.size - tree.coordinates
    return free_dofs == 6 * (model.bodies.each.size - tree.branches.size)


def singular_joints(scene: Scene, model: Model, state: State) -> str:
    """Names of the closed joints whose constraints depend on each other most."""
    rows = _all_rows(model, state.y, state.modes)
    J = _unit_rows(model, state.y, rows)
    part = np.abs(linalg.svd(J)[0][:, min(J.shape) - 1])
    taking = dict.fromkeys(rows.lock[part > TAKING_PART * part.max()].tolist())
    return ", ".join(constraint_names(scene)[i] for i in taking)


def driven_joints(scene: Scene, model: Model, state: State) -> str:
    """Names of the closed joints that drives move apart, with their keys."""
    rows = _all_rows(model, state.y, state.modes)
    n = model.bodies.active.size
    rates = np.abs(rows.J @ state.y[n : 2 * n])
    parted = np.maximum(rates, np.abs(rows.residual))
    taking = dict.fromkeys(rows.lock[parted > TAKING_PART * parted.max()].tolist())
    return ", ".join(f"joints.{constraint_names(scene)[i]}" for i in taking)


def _all_rows(model: Model, y: np.ndarray, modes: np.ndarray) -> Rows:
    """All rows of closed joints in a state, those that depend on others included."""
    p = model.elements.locks
    n = model.bodies.active.size
    work = new_work(model)
    every = modes.copy()
    every[p.mode : p.mode + p.each.size, SEGMENT] = (1 << p.each["count"]) - 1
    place_bodies(y[:n], y[n : 2 * n], model.bodies, work.motion)
    locks.add_constraints(
        y, every, work.motion, model.bodies, p, work.total, work.constraints, work.holds
    )
    count = int(work.constraints.number[0])
    lock = work.holds.lock[:count]
    second = p.each["second"][lock, work.holds.bit[:count]]
    return Rows(
        work.constraints.J[:count].copy(),
        work.holds.residual[:count].copy(),
        lock,
        second == NO_INDEX,
        work.holds.size[:count].copy(),
    )


def _unit_rows(model: Model, y: np.ndarray, rows: Rows) -> np.ndarray:
    """Rows J of unit length in coordinates scaled by the roots of their inertias; zero for rows
    that are rounding."""
    scaled = rows.J / np.sqrt(np.diag(inertia(model, y)))
    length = np.linalg.norm(scaled, axis=1)
    moves = length**2 > ROW_ROUNDING * rows.size
    return np.asarray(scaled * (moves / np.where(moves, length, 1.0))[:, None])


def _check_gaps(scene: Scene, model: Model, rows: Rows) -> None:
    for i, name in enumerate(constraint_names(scene)):
        residual = rows.residual * (rows.lock == i)
        gap = float(np.linalg.norm(residual[rows.slides]))
        sine = min(float(np.linalg.norm(residual[~rows.slides])), 1.0)
        turn = float(np.degrees(np.arcsin(sine)))
        if max(gap, np.radians(turn)) > CLOSURE_ATOL:
            raise InputError(
                f"joints.{name}: does not close at the start: {gap:.3g} m and {turn:.3g} deg are"
                f" missing between {_joint_sides_text(scene, name)}; expected less"
                f" than {CLOSURE_ATOL:g} m"
                " and rad. Joints are closed with all bodies at rest: change the starts"
                " (initial.position of bodies, initial of joints) together, or leave them"
                f" out.{_start_of_drives(scene)}"
            )


def _check_drives(scene: Scene, model: Model, state: State, rows: Rows) -> None:
    """Refuse drives of motions that closed joints hold."""
    driven = driven_coordinates(model.elements)
    if not driven.size:
        return
    pawl = model.elements.locks.each["ratchet"][rows.lock] != NO_RATCHET
    scaled = _unit_rows(model, state.y, rows)[~pawl]  # a ratchet lets a drive go its way
    moves = np.eye(scaled.shape[1])[driven]
    held = _row_rank(scaled)
    if _row_rank(np.vstack([scaled, moves])) == held + driven.size:
        return
    alone = [_row_rank(np.vstack([scaled, [move]])) == held for move in moves]
    names = [name for i, name in enumerate(drives_of(scene)) if alone[i] or not any(alone)]
    joints = dict.fromkeys(constraint_names(scene)[i] for i in rows.lock)
    raise InputError(
        f"forces.{names[0]}: found drives ({', '.join(names)}) of motions that the joints"
        f" {', '.join(joints)} hold, or let move only together; expected each motion to be held or"
        " driven once. Drive one of them, or let the joints leave more free."
    )


def _check_rods(scene: Scene, model: Model, state: State) -> None:
    """Refuse rods whose distance is held without them, so that their force is not determined."""
    p = model.elements.locks
    for i, (name, lock) in enumerate(zip(constraint_names(scene), p.each, strict=True)):
        mode = state.modes[p.mode + i]
        if lock["rod"] and mode[MODE] == CLOSED and mode[SEGMENT] == 0:
            raise InputError(
                f"joints.{name}: found a rod of a distance that locked directions, drives, or other"
                " joints and rods hold without it, so that its force is not determined; expected a"
                " distance that can change. Remove it, or use a strut."
            )


def _check_velocities(scene: Scene, model: Model, state: State, rows: Rows) -> None:
    p = model.elements.locks
    n = model.bodies.active.size
    rates = rows.J @ state.y[n : 2 * n]
    size = np.abs(rows.J) @ np.abs(state.y[n : 2 * n])
    pawl = p.each["ratchet"][rows.lock] != NO_RATCHET
    apart = (np.abs(rates) > CLOSURE_ATOL * (1.0 + size)) & ~pawl
    if apart.any():
        worst = int(np.argmax(np.abs(rates) * apart))
        name = constraint_names(scene)[rows.lock[worst]]
        unit = "m/s" if rows.slides[worst] else "rad/s"
        raise InputError(
            f"joints.{name}: holds at the start, and the initial velocities part"
            f" {_joint_sides_text(scene, name)} by {abs(rates[worst]):.3g} {unit};"
            " expected velocities that"
            " the joint allows (initial.velocity of bodies, rate or speed of joints). A joint that"
            " is to stop them needs active: {from: ...} after the start."
        )


def _start_of_drives(scene: Scene) -> str:
    """Remedy where drives move the start of a scene; empty without any."""
    moving = [
        name
        for name, drive in drives_of(scene).items()
        if abs(motion_at(drive, 0.0)[0]) > CLOSURE_ATOL
    ]
    if not moving:
        return ""
    return (
        f" Drives move the start ({', '.join(moving)}): begin them at zero, or give the other"
        " bodies the same start."
    )


def _check_regular(scene: Scene, model: Model, state: State, rows: Rows) -> None:
    """Refuse a loop in a place where its constraints depend on each other, and beside which they do
    not."""
    here = _row_rank(_unit_rows(model, state.y, rows))
    M = inertia(model, state.y)
    basis = nullspace_of(rows.J, M).basis
    basis = basis / np.maximum(np.abs(basis).max(axis=0, initial=1e-300), 1e-300)
    draw = np.random.default_rng(1)
    for _ in range(2 if basis.size else 0):
        y = state.y.copy()
        _move_coordinates(y, ASIDE * basis @ draw.uniform(-1.0, 1.0, basis.shape[1]), model)
        if not _return_to_constraints(model, y, state.modes):
            continue
        beside = _row_rank(_unit_rows(model, y, _all_rows(model, y, state.modes)))
        if beside > here:
            raise InputError(
                f"joints.{singular_joints(scene, model, state)}: at the start these joints are in a"
                " place where they do not determine their forces, as a four-bar linkage in a"
                " straight line; expected another place. Change initial.position of their bodies."
            )


def _row_rank(J: np.ndarray) -> int:
    return int(np.linalg.matrix_rank(J, tol=RANK_RTOL * np.linalg.norm(J, 2)))


def _return_to_constraints(model: Model, y: np.ndarray, modes: np.ndarray) -> bool:
    """Bring places in ``y`` back to the constraints by least squares; false if that fails."""
    root = np.sqrt(np.diag(inertia(model, y)))
    for _ in range(TRIES):
        rows = _all_rows(model, y, modes)
        if np.abs(rows.residual).max() < 1e-12:
            return True
        back = -np.linalg.lstsq(rows.J / root, rows.residual, rcond=RANK_RTOL)[0] / root
        _move_coordinates(y, back, model)
    return False


def _move_coordinates(y: np.ndarray, change: np.ndarray, model: Model) -> None:
    """Change the places in ``y`` by rates (n,) over one second."""
    shift = change.copy()
    fill_rates(y[: change.size], change, model.bodies, shift)
    y[: change.size] += shift


def _joint_sides_text(scene: Scene, name: str) -> str:
    joint = scene.joints[name]
    return f"{joint.body} and {joint.to or 'the earth'}"


def keep_independent_rows(model: Model, state: State) -> None:
    """Mark in ``state.modes`` the constraints of closed joints that do not depend on others."""
    if locks.any_closed(state.modes, model.elements.locks):
        choose_rows(state.y, state.modes, model, new_work(model))
