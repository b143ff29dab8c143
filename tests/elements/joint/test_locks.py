"""Joints that close: plastic impulses, their losses, their times, and what they leave alone."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
import scenes
import xarray as xr
from jointed import FRAME
from jointed import rotations as told
from scenes import Acting, JointFriction, joint_of, with_motions
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import hydrosim as hs
from hydrosim.compile.compile import compile_scene
from hydrosim.dofs import about_z
from hydrosim.elements import Coulomb, Harmonic, LinearMooring, StickSlip
from hydrosim.report.sentences.sections import lines_of
from hydrosim.scene import (
    Active,
    Body,
    Clearance,
    Kinematics,
    LinearScenes,
    Method,
    Scene,
    Symmetry,
    When,
)

CLOSES = 0.5  # s
SECOND = {"axis": (1.0, 2.0, -0.5), "second_axis": (2.0, -1.0, 0.0)}
FREE_AXES: dict[str, tuple[tuple[int, ...], tuple[int, ...]]] = {
    # axes of free slides, and of free turns, among the three of the joint
    "fixed": ((), ()),
    "hinge": ((), (0,)),
    "ball": ((), (0, 1, 2)),
    "universal": ((), (0, 1)),
    "slider": ((0,), ()),
    "cylindrical": ((0,), (0,)),
    "planar": ((1, 2), (0,)),
    "guide": ((0,), (0, 1, 2)),
}
TYPES = [*FREE_AXES]


def closing(joint: hs.Joint, at: float = CLOSES) -> hs.Joint:
    return replace(joint, active=hs.Active(hs.When(at)))


def pair(**solver: object) -> hs.Scene:
    """Two blocks without symmetry that fly and tumble, and are off their places at rest."""
    a = scenes.block(
        2.0, name="a", velocity=scenes.moving(surge=1.0, heave=0.3, roll=0.4, yaw=-0.6)
    )
    a = replace(a, position=scenes.moving(sway=0.2, pitch=0.3, yaw=0.5))
    b = scenes.block(
        3.0, name="b", location=(1.5, 0.5), velocity=scenes.moving(sway=-0.7, pitch=0.5)
    )
    return scenes.scene([a, b], {}, 1.0, 0.1, **solver)


def rotations(run: xr.Dataset, k: int) -> list[np.ndarray]:
    q = run.position.values[k]
    return [Rotation.from_euler("ZYX", x[[5, 4, 3]]).as_matrix() for x in q]


def mass_matrix(bodies: Sequence[hs.Body], R: Sequence[np.ndarray]) -> np.ndarray:
    M = np.zeros((6 * len(bodies),) * 2)
    for b, body in enumerate(bodies):
        k = 6 * b
        M[k : k + 3, k : k + 3] = body.mass * np.eye(3)
        M[k + 3 : k + 6, k + 3 : k + 6] = R[b] @ body.inertia @ R[b].T
    return M


def held_rows(
    joint: hs.Joint, scene: hs.Scene, run: xr.Dataset, k: int, R: list[np.ndarray] | None = None
) -> np.ndarray:
    """Rows (m, 6 nb) of the relative velocities that a joint between body 0 and another stops."""
    R = R or rotations(run, k)
    place = run.position.values[k, :, :3] + run.reference_position.values
    arms = [R[0] @ np.array(joint.point)]
    slides, turns = FREE_AXES[joint.type]
    axes = (R[0] @ joint.axes().T).T
    if joint.to is not None:
        arms.append(place[0] + arms[0] - place[1])
    rows = []
    for i in range(3):
        for free, is_slide in ((slides, True), (turns, False)):
            if i in free:
                continue
            row = np.zeros(6 * len(scene.bodies))
            for b, arm in enumerate(arms):
                sign = 1.0 if b == 0 else -1.0
                first = axes[i] if is_slide else np.zeros(3)
                second = np.cross(arm, axes[i]) if is_slide else axes[i]
                row[6 * b : 6 * b + 3] = sign * first
                row[6 * b + 3 : 6 * b + 6] = sign * second
            rows.append(row)
    return np.array(rows)


def plastic(M: np.ndarray, J: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, float]:
    """Velocities v+ nearest to v by kinetic energy with J v+ = 0, and the energy lost."""
    _, sizes, V = np.linalg.svd(J)
    N = V[int((sizes > 1e-10 * sizes[0]).sum()) :].T
    after = N @ np.linalg.solve(N.T @ M @ N, N.T @ M @ v) if N.size else 0.0 * v
    return after, 0.5 * float(v @ M @ v - after @ M @ after)


def on_centre(impulse: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """Impulse (6,) at a lever ``arm``, about the centre of gravity."""
    return np.concatenate([impulse[:3], np.cross(arm, impulse[:3]) + impulse[3:]])


def strike(
    free: hs.Scene, **locks: hs.Joint
) -> tuple[xr.Dataset, list[np.ndarray], np.ndarray, np.ndarray, float]:
    """The run with locks that close, and by an independent model of the run without: rotations,
    held rows (m, 6 nb), changes of momentum (nb, 6) and the loss."""
    before = hs.simulate(free)
    closed = {name: closing(lock) for name, lock in locks.items()}
    run = hs.simulate(replace(free, joints={**free.joints, **closed}))
    k = int(np.searchsorted(before.time.values, CLOSES - 1e-9))  # recorded before they close
    R = [told(before, name)[k] for name in "ab"] if free.joints else rotations(before, k)
    M = mass_matrix(free.bodies, R)
    held = [*free.joints.values(), *locks.values()]
    J = np.vstack([held_rows(lock, free, before, k, R) for lock in held])
    v = before.velocity.values[k].ravel()
    after, lost = plastic(M, J, v)
    return run, R, J, (M @ (after - v)).reshape(-1, 6), lost


@pytest.mark.parametrize("to", ["b", None])
@pytest.mark.parametrize("type", TYPES)
def test_the_loss_is_the_kinetic_energy_before_less_that_after(type: str, to: str) -> None:
    """Of an independent model, 1e-12; impulse equal and opposite; what it stops stays stopped."""
    joint = joint_of(type, "a", to, point=(0.7, -0.2, 0.4), **SECOND)
    free = pair(step=0.05)
    run, R, J, push, lost = strike(free, pin=joint)
    assert lost > 0.01
    assert run.lock_loss.values[-1, 0] == pytest.approx(lost, rel=1e-12)
    assert run.energy_dissipated_joints.values[-1] == pytest.approx(lost, rel=1e-12)
    assert run.lock_rows.values[[0, -1], 0].tolist() == [0, len(J)]
    impulse = run.lock_impulse.values[-1, 0]
    assert push[0] == pytest.approx(on_centre(impulse, R[0] @ joint.point), abs=1e-12)
    if to is not None:
        assert push[1, :3] == pytest.approx(-impulse[:3], abs=1e-12)
    assert np.abs(run.energy_residual).max() < 1e-6 * lost
    end = len(run.time) - 1
    still = held_rows(joint, free, run, end)
    if type in ("fixed", "hinge", "ball"):
        assert np.abs(still[:3] @ run.velocity.values[end].ravel()).max() < 1e-12


@pytest.mark.parametrize("method", Method)
def test_two_masses_that_meet_in_closed_form(method: Method) -> None:
    a = scenes.block(2.0, ("surge",), "a", velocity=scenes.moving(surge=1.0))
    b = scenes.block(3.0, ("surge",), "b", velocity=scenes.moving(surge=-0.5))
    pin = closing(hs.Fixed("a", "b"), 0.4321)
    free = scenes.scene([a, b], {}, 1.0, 0.1, method=method)
    run = hs.simulate(replace(free, joints={"pin": pin}))
    reduced = 2.0 * 3.0 / 5.0
    assert run.velocity.values[-1, :, 0] == pytest.approx(0.1, abs=1e-12)
    assert run.lock_loss.values[-1, 0] == pytest.approx(0.5 * reduced * 1.5**2, rel=1e-12)
    assert run.lock_impulse.values[-1, 0, 0] == pytest.approx(-reduced * 1.5, rel=1e-12)
    gap = run.position.values[:, 0, 0] - run.position.values[:, 1, 0]
    assert gap[-1] == pytest.approx(1.5 * 0.4321, abs=1e-12)  # held where it closed
    assert np.abs(run.energy_residual).max() < 1e-12
    assert run.lock_mode.values[:, 0].tolist() == [0] * 5 + [3] * 6


HINGE = hs.Hinge("a", "b", (0.7, -0.2, 0.4), axis=(0.0, 0.0, 1.0))
BALL = hs.Ball("a", None, (0.1, 0.2, 0.3))


def test_several_locks_close_at_once() -> None:
    """Three, two of which hold the same motions."""
    run, _, _, momentum, lost = strike(pair(step=0.05), one=HINGE, same=HINGE, ball=BALL)
    assert run.lock_loss.values[-1].sum() == pytest.approx(lost, rel=1e-12)
    impulse = run.lock_impulse.values[-1, :, :3]
    assert impulse.sum(axis=0) == pytest.approx(momentum[0, :3], abs=1e-12)
    assert impulse[:2].sum(axis=0) == pytest.approx(-momentum[1, :3], abs=1e-12)
    assert run.lock_rows.values[-1].tolist() == [5, 0, 3]
    assert np.abs(run.energy_residual).max() < 1e-6 * lost


def hinged(hinge: hs.Joint, **launch: float) -> hs.Scene:
    """The pair at rest on a hinge that carries the first, launched with the second."""
    free = pair(step=0.05)
    a, b = (replace(body, position=scenes.moving(), points=FRAME) for body in free.bodies)
    bodies = (replace(a, velocity=scenes.moving()), replace(b, velocity=scenes.moving(**launch)))
    return replace(free, bodies=bodies, joints={"hinge": hinge})


def test_a_lock_beside_a_joint_takes_its_body_along() -> None:
    """Bodies that a hinge joins from the start are stopped by a ball at one of them."""
    free = hinged(HINGE, surge=1.0, sway=0.3, yaw=0.5)
    run, _, _, push, lost = strike(free, ball=BALL)
    assert run.lock_loss.values[-1, 0] == pytest.approx(lost, rel=1e-10)
    impulse = run.lock_impulse.values[-1, 0, :3]
    assert push[:, :3].sum(axis=0) == pytest.approx(impulse, abs=1e-10)
    assert np.abs(run.energy_residual).max() < 1e-6 * lost


def lifted(law: object) -> hs.Scene:
    """A block that rests on the floor with friction, and one that slides into it without."""
    still = scenes.block(3.0, ("surge", "heave"), "still")
    fast = scenes.block(
        2.0, ("surge",), "fast", velocity=scenes.moving(surge=1.0), location=(-1.0, 0.0)
    )
    floor = scenes.on_floor(3e4, law, body="still", points=[(0.0, 0.0, 0.0)])
    loads = {"floor": floor, "weight": scenes.steady("still", heave=-30.0)}
    found = scenes.scene([still, fast], loads, 1.0, 0.02, step=0.01, method=Method.RK4)
    pressed = replace(found.bodies[0], position=scenes.moving(heave=-1e-3))
    pin = hs.Fixed("fast", "still", active=hs.Active(hs.When(CLOSES)))
    return replace(found, bodies=(pressed, found.bodies[1]), joints={"pin": pin})


def test_a_rigid_fender_that_sticks_bears_no_impulse() -> None:
    """Its normal force is finite: both slide on, and friction of 0.3 N brakes them to rest."""
    run = hs.simulate(lifted(Coulomb(0.4, 0.3)))
    t = run.time.values
    after = t > CLOSES + 1e-9
    wanted = 0.4 - 0.3 * 30.0 / 5.0 * (t[after] - CLOSES)
    stops = CLOSES + 0.4 / 1.8
    wanted = np.where(t[after] < stops, wanted, 0.0)
    assert run.velocity.values[after, 0, 0] == pytest.approx(wanted, abs=1e-9)
    assert run.lock_loss.values[-1, 0] == pytest.approx(0.5 * 1.2, rel=1e-12)
    assert np.abs(run.energy_residual).max() < 1e-9


def test_a_stick_slip_fender_is_tested_again_after_the_impulse() -> None:
    """Its damper C2 exceeds static friction after the jump: it slips with both masses' impulse."""
    law = StickSlip(0.4, 0.3, 1e5, damping=500.0, slip_damping=0.0)
    assert 500.0 * 0.4 > 0.4 * 30.0  # N
    run = hs.simulate(scenes.with_step(lifted(law), 1e-3))
    t = run.time.values
    k = int(np.searchsorted(t, CLOSES - 1e-9))
    assert run.fender_mode.values[k, 0] != run.fender_mode.values[k + 1, 0]
    slips = run.velocity.values[k + 1, :, 0]
    assert slips == pytest.approx(0.4 - 0.3 * 30.0 / 5.0 * 0.02, abs=1e-3)
    assert run.lock_loss.values[-1, 0] == pytest.approx(0.5 * 1.2, rel=1e-9)
    assert np.abs(run.energy_residual).max() < 1e-4


def test_a_pin_that_never_closes_changes_no_byte() -> None:
    """Except what names it: the joint, its states and its row of forces."""
    base = replace(scenes.scene_of("base"), duration=20.0)
    body = base.bodies[0].name
    pin = hs.Fixed(body, None, active=hs.Active(hs.When(1e4)))
    alone = hs.simulate(base)
    run = hs.simulate(replace(base, joints={"pin": pin}))
    new = {*run.variables} - {*alone.variables}
    assert new == {
        *("joint", "joint_force", "lock", "lock_mode", "lock_rows", "lock_segment"),
        *("lock_impulse", "lock_loss", "force_joints", "energy_dissipated_joints"),
        "impulse_unit",
        *("trigger", "trigger_stage", "trigger_waits"),
    }
    by_state = ("state", "state_kind", "state_owner", "state_component", "state_value")
    for name in {*alone.variables} - {*by_state, "state_input"}:
        assert alone[name].values.tobytes() == run[name].values.tobytes(), name
    same = run.sel(state=alone.state.values)
    assert same.state_value.values.tobytes() == alone.state_value.values.tobytes()
    assert not run.joint_force.values.any()


def sprung(step: float, **window: float) -> hs.Scene:
    """Two masses on springs to the earth, that a pin joins where they pass slowly enough."""
    a = scenes.block(2.0, ("surge",), "a", position=scenes.moving(surge=0.6))
    b = scenes.block(3.0, ("surge",), "b", position=scenes.moving(surge=-0.4))
    forces = {}
    for name, k in (("a", 8.0), ("b", 27.0)):
        K = np.zeros((6, 6))
        K[0, 0] = k
        forces[name + "_spring"] = LinearMooring(name, K)
    pin = hs.Fixed("a", "b", window=hs.JointWindow(**window) if window else None)
    found = scenes.scene([a, b], forces, 4.0, 0.1, step=step, method=Method.RK4)
    return replace(found, joints={"pin": pin})


def reference_of_sprung(gap: float, speed: float, end: float) -> tuple[float, np.ndarray]:
    """Time of closing, and the state at the end, by DOP853 of independent equations."""
    tight = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}

    def apart(t: float, y: np.ndarray) -> list[float]:
        return [y[2], y[3], -4.0 * y[0], -9.0 * y[1]]

    def outside(t: float, y: np.ndarray) -> float:
        return max(abs(y[0] - y[1]) / gap, abs(y[2] - y[3]) / speed) - 1.0

    outside.terminal, outside.direction = True, -1.0
    start = [0.6, -0.4, 0.0, 0.0]
    way = solve_ivp(apart, (0.0, end), start, events=outside, max_step=1e-3, **tight)
    t, y = way.t[-1], way.y[:, -1]
    u = (2.0 * y[2] + 3.0 * y[3]) / 5.0

    def joined(t: float, z: np.ndarray) -> list[float]:
        pull = -8.0 * z[0] - 27.0 * z[1]
        return [z[2], z[3], pull / 5.0, pull / 5.0]

    rest = solve_ivp(joined, (t, end), [y[0], y[1], u, u], **tight)
    return float(t), rest.y[:, -1]


@pytest.mark.parametrize(("gap", "speed"), [(0.4, 1.0), (0.3, 10.0), (0.8, 0.5)])
def test_a_window_of_gap_and_speed_against_dop853(gap: float, speed: float) -> None:
    """Times of closing and motions after it, with the fourth order of rk4 through the lock."""
    when, wanted = reference_of_sprung(gap, speed, 4.0)
    errors = []
    for step in (0.01, 0.005, 0.0025):
        run = hs.simulate(sprung(step, gap=gap, speed=speed))
        found = [*run.position.values[-1, :, 0], *run.velocity.values[-1, :, 0]]
        errors.append(np.abs(np.array(found) - wanted).max())
    assert errors[-1] < 1e-9
    assert errors[0] / errors[-1] > 16.0**1.9
    # the impulse is at the time of closing: from the mean rate of the joint's own record
    spans = sprung(0.005, gap=gap, speed=speed).with_output(step=0.005)
    fine = hs.simulate(spans)
    k = int(np.argmax(fine.lock_mode.values[:, 0] == 3))
    assert fine.time.values[k - 1] < when <= fine.time.values[k] + 1e-9


def test_the_time_of_closing_against_dop853() -> None:
    """From the place at which the pin holds the masses: 1e-9 s."""
    gap, speed = 0.3, 10.0
    when, wanted = reference_of_sprung(gap, speed, 4.0)
    run = hs.simulate(sprung(0.005, gap=gap, speed=speed))
    held = run.position.values[-1, 0, 0] - run.position.values[-1, 1, 0]
    rate = 1.0  # m/s at least between the masses there
    assert abs(held - (wanted[0] - wanted[1])) < 1e-9 * rate
    assert 0.0 < when < 4.0


def test_a_run_continues_to_the_bit_across_a_closed_lock() -> None:
    joint = hs.Hinge("a", "b", (0.7, -0.2, 0.4), axis=(1.0, 2.0, -0.5))
    base = replace(pair(step=0.05), joints={"pin": closing(joint, 0.31)}).with_output(states=True)
    whole = hs.simulate(base)
    rest = hs.simulate(replace(base, duration=0.5, initial=hs.Start(whole, 0.5)))
    for name in ("position", "velocity", "joint_force", "lock_loss", "lock_impulse", "lock_mode"):
        assert np.array_equal(rest[name].values, whole[name].sel(time=rest.time.values).values)


def test_a_lock_lets_go_at_its_time() -> None:
    """Both masses then keep the common velocity; the spring of one pulls it alone."""
    base = sprung(0.01, gap=0.3)
    pin = replace(base.joints["pin"], active=hs.Active(None, hs.When(2.0)))
    run = hs.simulate(replace(base, joints={"pin": pin}))
    k = int(np.searchsorted(run.time.values, 2.0 - 1e-9))
    x, v = run.position.values[k, :, 0], run.velocity.values[k, :, 0]
    assert v[0] == pytest.approx(v[1], abs=1e-12)
    t = run.time.values[k:] - 2.0
    for b, w in ((0, 2.0), (1, 3.0)):
        wanted = x[b] * np.cos(w * t) + v[b] / w * np.sin(w * t)
        assert run.position.values[k:, b, 0] == pytest.approx(wanted, abs=1e-8)
    assert run.lock_mode.values[-1, 0] == 0


def wet(current: float, radiation: str) -> hs.Scene:
    """The free H-851 adrift in calm water or a current."""
    base = scenes.with_body(
        scenes.scene_of("base"), velocity=scenes.moving(surge=1.0, sway=0.4, yaw=0.03)
    )
    base = scenes.with_body(base, radiation=radiation)
    solver = hs.Solver(step=0.1, linear=LinearScenes.STEP, symmetry=Symmetry.IGNORE)
    water = hs.Environment(current=hs.Stream(current, 0.5))
    return replace(base, duration=40.0, environment=water, forces={}, solver=solver)


@pytest.mark.parametrize("radiation", ["none", "convolution"])
@pytest.mark.parametrize("current", [0.0, 0.8])
def test_water_is_stopped_too(current: float, radiation: str) -> None:
    """Added mass takes part, in a current too; the memory does not jump, and the ledger closes."""
    free = wet(current, radiation)
    name = free.bodies[0].name
    hinge = hs.Ball(name, None, (40.0, 5.0, 2.0))
    before = hs.simulate(replace(free, duration=20.0))
    run = hs.simulate(replace(free, joints={"pin": closing(hinge, 20.0)}))
    k = len(before.time) - 1
    (R,) = rotations(before, k)
    P = np.kron(np.eye(2), about_z(scenes.motion(before)[k, 5]))
    model = compile_scene(free).model
    M = mass_matrix(free.bodies, [R]) + P @ model.added_mass @ P.T
    v = before.velocity.values[k, 0]
    after, lost = plastic(M, held_rows(hinge, free, before, k), v)
    assert run.lock_loss.values[-1, 0] == pytest.approx(lost, rel=1e-10)
    push = M @ (after - v)
    found = on_centre(run.lock_impulse.values[-1, 0], R @ np.array(hinge.point))
    assert found == pytest.approx(push, abs=1e-12 * np.abs(push).max())
    assert run.energy_residual_relative < 1e-6


def test_a_lock_in_linear_kinematics() -> None:
    """Small angles: J is constant, no place jumps, and momentum along x is kept."""
    base = pair(step=0.05, kinematics=Kinematics.LINEAR)
    joint = closing(hs.Fixed("a", "b", (0.7, -0.2, 0.4)))
    run = hs.simulate(replace(base, joints={"pin": joint}))
    v = run.velocity.values
    masses = np.array([2.0, 3.0])
    kept = np.einsum("b,tbi->ti", masses, v[:, :, :3])
    assert np.abs(kept - kept[0]).max() < 1e-12
    assert v[-1, 0, 3:] == pytest.approx(v[-1, 1, 3:], abs=1e-12)
    assert np.abs(run.energy_residual).max() < 1e-9
    q = run.position.values
    assert np.abs(np.diff(q, axis=0)).max() < 0.2  # no jump


def test_a_clearance_closes_a_pin() -> None:
    """As soon as a named point is nearer than 0.3 m to another."""
    base = sprung(0.01)
    bodies = [replace(body, points={"eye": (0.0, 0.0, 0.0)}) for body in base.bodies]
    near = hs.Active(hs.When(channel="clearance.pin", below=0.3))
    pin = replace(base.joints["pin"], window=None, active=near)
    watched = {"pin": Clearance("eye of a", "eye of b")}
    run = hs.simulate(
        replace(base, bodies=bodies, joints={"pin": pin}).with_output(clearances=watched)
    )
    same = hs.simulate(sprung(0.01, gap=0.3))
    assert run.position.values == pytest.approx(same.position.values, abs=1e-9)
    assert run.clearance.values[-1, 0] == pytest.approx(0.3, abs=1e-9)


def test_a_joint_breaks_at_its_force() -> None:
    """A pin between a mass and the earth, pulled by 5 N/s, holds up to 3 N at 0.6 s."""
    ramp = scenes.table([0.0, 2.0], np.outer([0.0, 10.0], np.eye(6)[0]))
    pull = scenes.central_force("a", **ramp)
    pin = hs.Fixed("a", breaks_at=3.0)
    found = scenes.scene(
        [scenes.block(2.0, ("surge",), "a")], {"pull": pull}, 2.0, 0.1, method=Method.RK4
    )
    run = hs.simulate(replace(found, joints={"pin": pin}))
    t = np.maximum(run.time.values - 0.6, 0.0)
    wanted = 1.5 * t**2 / 2.0 + 2.5 * t**3 / 6.0
    assert run.position.values[:, 0, 0] == pytest.approx(wanted, abs=1e-9)
    held = run.time.values < 0.6 - 1e-9
    assert run.joint_force.values[held, 0, 0] == pytest.approx(-5.0 * run.time.values[held])
    assert not run.joint_force.values[~held][1:].any()
    assert run.energy_dissipated_joints.values[-1] < 1e-30


@pytest.mark.parametrize("method", [Method.RK4, Method.DOPRI5, Method.ESDIRK4])
def test_a_pin_takes_the_load_of_the_hinge_that_it_locks(method: Method) -> None:
    """Friction does not hold the moment; a pin that finds it slow bears all from then on."""
    held = Acting(friction=JointFriction(2.0, 1.5))
    hinge = joint_of("hinge", "a", None, held, axis=(0.0, 1.0, 0.0))
    late, slow = hs.Active(hs.When(2.0)), hs.JointWindow(gap=1.0, speed=0.01)
    pin = hs.Fixed("a", None, (1.0, 0.0, 0.0), active=late, window=slow)
    load = scenes.central_force("a", pitch=Harmonic(6.0, 1.0))
    found = scenes.scene(
        [scenes.block(2.0, name="a")], {"load": load}, 6.0, 0.1, method=method, step=0.02
    )
    run = hs.simulate(replace(found, joints={"hinge": hinge, "pin": pin}))
    closed = run.lock_mode.values[:, 0] == 3
    assert 20 <= closed.argmax() < 30
    assert run.attrs["solver_events"] < 20
    pitch = run.position.values[closed, 0, 4]
    assert np.ptp(pitch) < 1e-12
    applied = 6.0 * np.sin(2.0 * np.pi * run.time.values[closed])
    about = run.joint_force.sel(joint="pin").values[closed]
    moment = about[:, 4] - np.cos(pitch) * about[:, 2] - np.sin(pitch) * about[:, 0]
    assert moment == pytest.approx(-applied, abs=1e-9)
    assert run.joint_motion_force.values[closed, 0] == pytest.approx(0.0, abs=1e-12)


def test_a_lock_between_jointed_bodies() -> None:
    """Blocks on a hinge that a lock stops: the loss is an independent model's, momentum is kept."""
    start = Acting(velocity=1.2)
    hinge = with_motions(replace(HINGE, axis=(0.3, 0.0, 1.0)), start)
    stop = hs.Fixed("a", "b", (0.1, 0.2, 0.3))
    run, _, _, _, lost = strike(hinged(hinge, surge=1.0, yaw=0.5), stop=stop)
    assert lost > 0.1
    assert run.lock_loss.values[-1, 0] == pytest.approx(lost, rel=1e-10)

    assert run.lock_rows.values[-1, 0] == 1
    spin = run.velocity.values[-1, :, 3:]
    assert spin[0] == pytest.approx(spin[1], abs=1e-12)
    turned = [np.swapaxes(told(run, "b"), 1, 2)[i] @ told(run, "a")[i] for i in (-1, -2, -3)]
    assert np.abs(np.diff(turned, axis=0)).max() < 1e-12
    masses = np.array([2.0, 3.0])
    kept = np.einsum("b,tbi->ti", masses, run.velocity.values[:, :, :3])
    assert np.abs(kept - kept[0]).max() < 1e-6  # error of the steps
    assert np.abs(run.energy_residual).max() < 1e-5 * lost


def pushed_in_a_sleeve(guide: hs.Joint) -> xr.Dataset:
    """A block without symmetry on springs, pushed and turned; a point of it stays on an axis."""
    body = scenes.block(2.0, name="a")
    stiff = scenes.mooring("a", surge=8.0, sway=6.0, heave=9.0)
    push = scenes.steady("a", surge=3.0, sway=-2.0, heave=1.5, roll=0.4, pitch=-0.3, yaw=0.2)
    found = scenes.scene(
        [body], {"springs": stiff, "push": push}, 2.0, 0.1, step=0.005, method=Method.RK4
    )
    return hs.simulate(replace(found, joints={"guide": guide}))


def test_a_guide_is_the_same_as_coordinates_and_as_a_lock() -> None:
    """A point slides on an axis and turns all ways: as a tree it needs no constraint."""
    guide = hs.Guide("a", None, (0.2, -0.1, 0.3), axis=(0.3, 0.2, 1.0))
    tree = pushed_in_a_sleeve(guide)
    lock = pushed_in_a_sleeve(closing(guide, 0.0))
    assert "lock_mode" not in tree
    assert np.ptp(tree.position.values[:, 0], axis=0).min() > 0.01
    assert tree.position.values == pytest.approx(lock.position.values, abs=1e-8)
    assert tree.joint_force.values[1:] == pytest.approx(lock.joint_force.values[1:], abs=1e-6)


def test_a_window_does_not_count_a_slide_that_is_free() -> None:
    """Along its axis a guide may be anywhere, and as fast as it likes."""
    a = scenes.block(2.0, ("surge", "heave"), "a", position=scenes.moving(surge=0.5, heave=3.0))
    a = replace(a, velocity=scenes.moving(surge=-0.2, heave=2.0))
    pin = hs.Guide("a", None, axis=(0.0, 0.0, 1.0), window=hs.JointWindow(0.1, 0.3))
    run = hs.simulate(replace(scenes.scene([a], {}, 4.0, 0.1, step=0.05), joints={"pin": pin}))
    assert run.lock_mode.values[[0, -1], 0].tolist() == [1, 3]
    assert run.position.values[-1, 0, 0] == pytest.approx(0.1, abs=1e-9)
    assert run.velocity.values[-1, 0, 2] == pytest.approx(2.0, abs=1e-12)
    assert run.lock_loss.values[-1, 0] == pytest.approx(0.5 * 2.0 * 0.2**2, rel=1e-9)


def test_a_pin_that_never_closes_says_how_near_it_came() -> None:
    """The masses of `sprung` are at 0.6 cos 2t and -0.4 cos 3t, and pass, but never so slowly."""
    run = hs.simulate(sprung(0.01, gap=0.01, speed=1e-4))
    (text,) = [text for text in lines_of(run, "warnings") if "joints.pin" in text]
    t = run.time.values
    apart = 0.6 * np.cos(2.0 * t) + 0.4 * np.cos(3.0 * t)
    rate = np.gradient(apart, t)
    nearest = int(np.maximum(abs(apart) / 0.01, abs(rate) / 1e-4).argmin())
    assert f"at {t[nearest]:.4g} s" in text
    assert "the window has 0.01 m and 0.0001 m/s" in text


# Ratchets: they hold as soon as a motion would go back, and let go when their load turns.

MASS, STIFFNESS = 2.0, 8.0
CORNERS = np.array([0.0, 2.0, 4.0, 6.0, 8.0])
FORCE = np.array([0.0, 0.0, 10.0, -10.0, 12.0])
TIGHT = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}


def along(stiffness: float) -> hs.LinearMooring:
    K = np.zeros((6, 6))
    K[0, 0] = stiffness
    return hs.LinearMooring("cart", K)


def driven(pitch: float = 0.0, step: float = 0.05, **changes: object) -> Scene:
    """A cart on a spring, thrown forward and then pushed and pulled; a ratchet lets it go +x."""
    cart = scenes.block(MASS, ("surge",), "cart", velocity=scenes.moving(surge=1.0))
    six = np.column_stack([FORCE, *[0.0 * FORCE] * 5])
    push = scenes.central_force("cart", **scenes.table(CORNERS, six))
    loads = {"spring": along(STIFFNESS), "push": push}
    found = scenes.scene([cart], loads, 8.0, 0.1, step=step, method=Method.RK4)
    pawl = hs.Ratchet("cart", axis=(1.0, 0.0, 0.0), slide=hs.SlidingPawl(pitch))
    return replace(found, joints={"pawl": pawl}, **changes)


def force(t: float) -> float:
    return float(np.interp(t, CORNERS, FORCE))


def reference(end: float) -> tuple[list[float], np.ndarray]:
    """Times at which the cart is held and let go, and its place at the end; by DOP853."""

    def rhs(t: float, y: np.ndarray) -> list[float]:
        return [y[1], (force(t) - STIFFNESS * y[0]) / MASS]

    def back(t: float, y: np.ndarray) -> float:
        return y[1]

    back.terminal, back.direction = True, -1.0
    t, y = 0.0, np.array([0.0, 1.0])
    times: list[float] = []
    while t < end:
        corner = float(CORNERS[CORNERS > t + 1e-12][0])
        first = max(t, 1e-12)
        way = solve_ivp(rhs, (first, corner), y, events=back, **TIGHT)
        t, y = float(way.t[-1]), way.y[:, -1]
        if not way.t_events[0].size:
            continue
        times.append(t)
        y[1] = 0.0
        grid = np.linspace(t, end, 80001)
        pulls = np.array([force(s) for s in grid]) - STIFFNESS * y[0]
        later = np.flatnonzero(pulls > 1e-9)
        if not later.size:
            break
        i = int(later[0])
        held = STIFFNESS * float(y[0])
        t = brentq(lambda s, held=held: force(s) - held, grid[i - 1], grid[i], xtol=1e-14)
        times.append(t)
        y[1] = 1e-13  # on its way: the event of going back begins above zero
    return times, y


def test_a_ratchet_against_dop853() -> None:
    """Held where it stops, let go where the force exceeds the spring; fourth order, no loss."""
    times, wanted = reference(8.0)
    assert len(times) >= 3
    errors = []
    for step in (0.05, 0.025, 0.0125):
        run = hs.simulate(driven(step=step))
        errors.append(abs(run.position.values[-1, 0, 0] - wanted[0]))
    assert errors[-1] < 1e-8
    assert errors[0] / errors[-1] > 16.0**1.9
    x = run.position.values[:, 0, 0]
    assert np.diff(x).min() > -1e-12
    load = run.joint_force.values[:, 0, 0]
    assert load.min() > -1e-9  # it only pushes
    held = run.lock_mode.values[:, 0] == 3
    t = run.time.values
    pulls = np.array([STIFFNESS * p - force(s) for s, p in zip(t, x, strict=True)])
    assert load[held] == pytest.approx(pulls[held], abs=1e-9)
    assert not load[~held].any()
    assert run.energy_dissipated_joints.values[-1] < 1e-30
    assert np.abs(run.energy_residual).max() < 1e-7


def test_the_times_of_a_ratchet_against_dop853() -> None:
    """It stops at v = 0, a quarter of a period; it lets go at 2.8 s: 1e-9 s, from modes."""
    times, _ = reference(8.0)
    run = hs.simulate(driven(step=0.0125, output={"step": 0.0125}))
    closed = (run.lock_mode.values[:, 0] == 3).astype(int)
    changes = np.flatnonzero(np.diff(closed))
    for k, when in zip(changes, times, strict=False):
        assert run.time.values[k] <= when + 1e-9
        assert when <= run.time.values[k + 1] + 1e-9
    assert times[0] == pytest.approx(np.pi / 4.0, abs=1e-9)
    assert run.position.values[changes[0] + 1, 0, 0] == pytest.approx(0.5, abs=1e-9)


def test_teeth_catch_with_a_loss() -> None:
    """From 0.5 m the cart falls back on the tooth at 0.45 m: it loses what the spring has given."""
    base = driven(0.15, step=0.005)
    base = replace(base, duration=1.6, forces={"spring": along(STIFFNESS)})
    run = hs.simulate(base)
    assert run.position.values[-1, 0, 0] == pytest.approx(0.45, abs=1e-12)
    lost = 0.5 * STIFFNESS * (0.5**2 - 0.45**2)
    assert run.lock_loss.values[-1, 0] == pytest.approx(lost, rel=1e-7)
    assert np.abs(run.energy_residual).max() < 1e-8
    assert run.lock_impulse.values[-1, 0, 0] == pytest.approx(np.sqrt(2.0 * lost * MASS), rel=1e-7)


@pytest.mark.parametrize("kinematics", Kinematics)
@pytest.mark.parametrize("pitch", [0.0, 0.3])
def test_a_ratchet_about_an_axis(kinematics: Kinematics, pitch: float) -> None:
    """A flywheel on a spring that turns one way, to 0.5 rad or to the tooth before."""
    K = np.zeros((6, 6))
    K[5, 5] = 8.0
    wheel = Body("wheel", 1.0, np.diag([1.0, 1.5, 2.0]), velocity=scenes.moving(yaw=1.0))
    forces = {"spring": hs.LinearMooring("wheel", K)}
    solver = {"step": 0.01, "method": Method.RK4, "kinematics": kinematics}
    found = scenes.scene([wheel], forces, 2.0, 0.1, **solver)
    pawl = hs.Ratchet("wheel", axis=(0.0, 0.0, 1.0), turn=hs.TurningPawl(pitch))
    run = hs.simulate(replace(found, joints={"pawl": pawl}))
    wanted = 0.3 if pitch else 0.5
    assert run.position.values[-1, 0, 5] == pytest.approx(wanted, abs=1e-8)
    assert run.joint_force.values[-1, 0, 5] == pytest.approx(8.0 * wanted, abs=1e-6)
    lost = 0.5 * 8.0 * (0.25 - wanted**2)
    assert run.lock_loss.values[-1, 0] == pytest.approx(lost, abs=1e-6)


def test_a_ratchet_is_pushed_back_by_an_impact() -> None:
    """A cart that a pin stops from behind is thrown back: the ratchet takes the impulse."""
    cart = scenes.block(MASS, ("surge",), "cart", velocity=scenes.moving(surge=0.5))
    other = scenes.block(
        3.0, ("surge",), "other", velocity=scenes.moving(surge=-1.0), location=(3.0, 0.0)
    )
    pawl = hs.Ratchet("cart", axis=(1.0, 0.0, 0.0), slide=hs.SlidingPawl())
    pin = hs.Fixed("cart", "other", active=Active(When(0.55)))
    found = scenes.scene([cart, other], {}, 1.0, 0.1)
    run = hs.simulate(replace(found, joints={"pawl": pawl, "pin": pin}))
    assert np.abs(run.velocity.values[-1]).max() < 1e-12
    assert run.lock_loss.values[-1].sum() == pytest.approx(0.5 * (2 * 0.25 + 3.0), rel=1e-12)
    impulse = dict(zip(run.lock.values, run.lock_impulse.values[-1, :, 0], strict=True))
    assert impulse["pawl"] == pytest.approx(2.0, rel=1e-12)


def test_a_ratchet_continues_to_the_bit() -> None:
    base = driven(output={"step": 0.1, "states": True})
    whole = hs.simulate(base)
    rest = hs.simulate(replace(base, duration=4.0, initial=hs.scene.Start(whole, 4.0)))
    for name in ("position", "velocity", "joint_force", "lock_mode"):
        assert np.array_equal(rest[name].values, whole[name].sel(time=rest.time.values).values)


def test_the_axis_of_a_ratchet_without_teeth_stays_where_it_is() -> None:
    """On the earth, while the body turns by half a turn: it pushes along x, wherever it closes."""
    start = scenes.moving(surge=1.0, yaw=0.4)
    cart = scenes.block(MASS, ("surge", "sway", "yaw"), "cart", velocity=start)
    pushes = np.column_stack([FORCE, *[0.0 * FORCE] * 5])
    push = scenes.central_force("cart", **scenes.table(CORNERS, pushes))
    found = scenes.scene([cart], {"spring": along(STIFFNESS), "push": push}, 8.0, 0.1, step=0.05)
    pawl = hs.Ratchet("cart", axis=(1.0, 0.0, 0.0), slide=hs.SlidingPawl(0.0))
    run = hs.simulate(replace(found, joints={"pawl": pawl}))
    closings = np.flatnonzero(np.diff(run.lock_mode.values[:, 0]) > 0)
    assert closings.size == 2
    assert run.position.values[closings[1], 0, 5] > 1.0  # rad: it has turned since it closed first
    assert run.joint_force.values[:, 0, 0].max() > 1.0
    assert np.abs(run.joint_force.values[:, 0, 1]).max() < 1e-9
    alone = hs.simulate(driven())
    assert run.position.values[:, 0, 0] == pytest.approx(alone.position.values[:, 0, 0], abs=1e-6)
