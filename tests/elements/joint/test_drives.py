"""Prescribed motion: what it costs, what it moves, and where it may not be."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import pairwise
from math import cos, pi, sin
from typing import Any

import numpy as np
import pytest
import xarray as xr
from jointed import G, apart, by_rk4, carried, completed, joint, moved, places, scene
from scenes import Acting, JointFriction, assert_continues, observed_orders, with_motions
from scipy.interpolate import CubicSpline, PchipInterpolator
from scipy.optimize import brentq
from solutions import solved

import hydrosim as hs
from hydrosim.compare.dataset import differences
from hydrosim.database.build.barge import box
from hydrosim.database.build.recipe import barge_with_deck
from hydrosim.elements import Drive, Harmonic, Recorded, SmoothTable, Table
from hydrosim.elements.signal import compile_signals, corners
from hydrosim.errors import InputError
from hydrosim.files.outputs import Output
from hydrosim.report.evidence import Feature, Kind
from hydrosim.run import course
from hydrosim.run.checkpoint import Checkpoint
from hydrosim.scene import Hull, Kinematics, Method, Question, Weight

X, Y, Z = np.eye(3).tolist()
BOX = barge_with_deck(box(2.0, 1.0, 0.5), 1.0)
WITHIN = 1e-9
EDGE = 1e-13  # s: beside a knot, on the side of its piece
CART, BOB, ARM, ABOUT = 40.0, 3.0, 2.5, 9.0  # kg, kg, m, kg m^2
SHAKE = Harmonic(0.6, 3.1, 0.2, 0.4)
DURATION = 10.0
TIME = np.linspace(0.0, DURATION, 101)


def motion(signal: Harmonic, t: Any) -> tuple[Any, Any, Any]:
    """A sine with its first and second derivative."""
    w = 2.0 * pi / signal.period
    phase = w * t + signal.phase
    swing = signal.amplitude * np.sin(phase)
    speed = w * signal.amplitude * np.cos(phase)
    return signal.mean + swing, speed, -w * w * swing


def cart_and_rod(
    signal: Any = SHAKE, drive: Mapping[str, Any] | None = None, **solver: Any
) -> hs.Scene:
    """A rod that hangs from a cart, which a drive moves along x."""
    cart = carried("cart", CART, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), dofs=("surge",))
    rod = carried("rod", BOB, (ABOUT, ABOUT, 0.4), (0.0, 0.0, -ARM))
    pin = joint("hinge", "rod", "cart", moved(0.3, -0.2), point=(0.0, 0.0, ARM), axis=Y)
    push = Drive(**{"body": "cart", "dof": "surge", "offset": signal, **(drive or {})})
    return scene([cart, rod], {"pin": pin}, DURATION, {"shake": push}, **solver)


def swing(of: Callable[[float], tuple[Any, Any, Any]], knots: Any = (0.0, DURATION)) -> np.ndarray:
    """Angle and rate of the rod by Lagrange's equations in it alone, and the work of the drive (3,
    nt), solved from knot to knot, between which the motion is smooth:

    (I + m l^2) a'' = -m g l sin a + m l s'' cos a,    x = s - l sin a
    F = (M + m) s'' - m l (a'' cos a - a'^2 sin a)
    """
    whole = ABOUT + BOB * ARM**2

    def equations(t: float, y: np.ndarray) -> list[float]:
        a, da, _ = y
        _, ds, dds = of(min(max(t, piece[0] + EDGE), piece[1] - EDGE))
        dda = BOB * ARM * (dds * cos(a) - G * sin(a)) / whole
        force = (CART + BOB) * dds - BOB * ARM * (dda * cos(a) - da * da * sin(a))
        return [da, dda, force * ds]

    last = np.array([0.3, -0.2, 0.0])
    found = [last[:, None]]
    piece = (0.0, DURATION)
    for a, b in pairwise(knots):
        piece = (a, b)
        inside = TIME[(TIME > a + 1e-9) & (TIME <= b + 1e-9)]
        times = np.unique([a, *inside, b])
        each = solved(equations, last, times)
        last = each[:, -1]
        found.append(each[:, np.searchsorted(times, inside - 1e-9)])
    return np.concatenate(found, axis=1)


def test_a_pendulum_with_a_driven_pivot(validated) -> None:
    run = completed(cart_and_rod())
    angle, _, work = swing(lambda t: motion(SHAKE, t))
    at, speed, _ = motion(SHAKE, TIME)
    exact = np.stack([at - ARM * np.sin(angle), 0.0 * at, -ARM * np.cos(angle)], axis=1)
    error = apart(places(run, "rod"), exact)
    claim, against = "pendulum with a driven pivot, 10 s", "Lagrange's equations by DOP853"
    validated(Kind.INDEPENDENT, claim, against, error, WITHIN, Feature.DRIVES)
    found = run.sel(body="cart", dof="surge")
    np.testing.assert_allclose(found.position, at, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(found.velocity, speed, rtol=0.0, atol=1e-14)
    booked = run.energy_work_shake.values
    assert np.abs(booked - work).max() < WITHIN * np.ptp(work)
    assert run.attrs["energy_residual_relative"] < WITHIN


def test_the_force_of_a_drive_is_that_of_newton() -> None:
    """A block on a spring and a damper, whose force and work are known at every time."""
    stiffness, damping, mass = 400.0, 30.0, 12.0
    block = carried("block", mass, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), dofs=("surge",))
    unit = np.zeros((6, 6))
    unit[0, 0] = 1.0
    held = hs.LinearMooring("block", stiffness * unit, damping * unit)
    forces = {"held": held, "shake": Drive("block", dof="surge", offset=SHAKE)}
    run = completed(by_rk4(scene([block], {}, DURATION, forces), 0.05))
    q, u, a = motion(SHAKE, TIME)
    force = mass * a + damping * u + stiffness * q
    np.testing.assert_allclose(run.drive_force[:, 0], force, rtol=0.0, atol=1e-9 * np.ptp(force))
    shared = run.force_shake.sel(body="block", dof="surge")
    np.testing.assert_array_equal(shared, run.drive_force[:, 0])
    assert [*run.drive.values] == ["shake surge"]


def residual(run: xr.Dataset) -> float:
    return float(np.abs(run.energy_residual.values).max())


def test_a_drive_keeps_the_ledger_to_the_order_of_the_method(figure) -> None:
    """Of rk4 by its step; of dopri5 with tolerances that cut no step of the output's length."""
    loose = {"method": Method.DOPRI5, "tolerance": hs.Tolerance(1e3, 1e3, 1e3)}
    for name, steps, order in (("rk4", (0.1, 0.05, 0.025), 3.8), ("dopri5", (0.2, 0.1, 0.05), 4.7)):
        gaps = []
        for h in steps:
            adaptive = cart_and_rod(**loose, step=h).with_output(step=h)
            run = completed(by_rk4(cart_and_rod(), h) if name == "rk4" else adaptive)
            gaps.append(residual(run))
            assert name == "rk4" or run.attrs["solver_steps"] == round(DURATION / h)
        orders = observed_orders(steps, np.array(gaps))
        figure(name, orders.min())
        assert orders.min() > order


KNOTS = np.array([0.0, 1.237, 2.9, 4.11, 7.777, 10.0])
VALUES = np.array([0.0, 0.0, 0.8, 0.8, -0.5, -0.5])


def test_a_table_is_smooth_and_its_corners_cost_no_order(figure) -> None:
    """The acceleration jumps at points of the table, which are not on the grid of steps."""
    curve = PchipInterpolator(KNOTS, VALUES)
    signal = SmoothTable(KNOTS, VALUES)
    angle, _, _ = swing(lambda t: tuple(curve(t, order) for order in range(3)), KNOTS)
    at = curve(TIME)
    exact = np.stack([at - ARM * np.sin(angle), 0.0 * at, -ARM * np.cos(angle)], axis=1)
    run = completed(cart_and_rod(signal))
    assert apart(places(run, "rod"), exact) < 1e-8
    found = run.sel(body="cart", dof="surge")
    np.testing.assert_allclose(found.position, at, rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(found.velocity, curve(TIME, 1), rtol=0.0, atol=1e-13)
    assert found.position.min() >= VALUES.min()
    assert found.position.max() <= VALUES.max()
    steps = (0.1, 0.05, 0.025)
    runs = [completed(by_rk4(cart_and_rod(signal), h)) for h in steps]
    orders = observed_orders(steps, np.array([apart(places(run, "rod"), exact) for run in runs]))
    figure("order", orders.min())
    assert orders.min() > 3.5


def test_a_record_is_followed_by_its_spline() -> None:
    time = np.linspace(0.0, DURATION, 201)
    value = 0.4 * np.sin(1.3 * time) + 0.1 * np.cos(2.9 * time)
    run = completed(cart_and_rod(Recorded(time, value)))
    spline = CubicSpline(time, value)
    angle, _, work = swing(lambda t: tuple(spline(t, order) for order in range(3)), time)
    found = run.sel(body="cart", dof="surge")
    np.testing.assert_allclose(found.position, spline(TIME), rtol=0.0, atol=1e-13)
    exact = spline(TIME) - ARM * np.sin(angle)
    assert apart(places(run, "rod")[:, 0], exact) < WITHIN
    assert np.abs(run.energy_work_shake.values - work).max() < WITHIN * np.ptp(work)


def crane(drive: Drive, **changes: Any) -> hs.Scene:
    """A boom on a slewing joint with a load on a ball at its end."""
    boom = carried("boom", 50.0, (20.0, 60.0, 60.0), (3.0, 0.0, 0.0))
    load = carried("load", 8.0, (2.0, 2.0, 1.0), (6.0, 0.0, -4.0))
    slew = joint("hinge", "boom", None, point=(-3.0, 0.0, 0.0), axis=Z)
    joints = {"slew": slew, "hook": joint("ball", "load", "boom", point=(0.0, 0.0, 4.0))}
    return scene([boom, load], joints, DURATION, {"turn": drive}, **changes)


def test_a_driven_joint_does_the_work_that_its_load_takes() -> None:
    """The moment of the drive turns all angular momentum about its axis."""
    turn = Harmonic(0.5, 6.0)
    run = completed(crane(Drive(joint="slew", motion="angle", angle=turn)))
    q, u, _ = motion(turn, TIME)
    slew = run.sel(joint_motion="slew angle")
    np.testing.assert_allclose(slew.joint_position, q, rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(slew.joint_velocity, u, rtol=0.0, atol=1e-13)
    assert run.attrs["energy_residual_relative"] < WITHIN
    power = run.drive_force[:, 0] * u
    work = CubicSpline(TIME, power).integrate(0.0, DURATION)
    assert run.energy_work_turn[-1] == pytest.approx(work, rel=1e-3)
    with_moment = run.force_turn.sel(body="boom", dof="yaw")
    np.testing.assert_allclose(with_moment, run.drive_force[:, 0], rtol=1e-12, atol=1e-9)


@pytest.mark.parametrize("kinematics", Kinematics)
def test_any_angle_of_a_body_can_be_driven(kinematics: Kinematics) -> None:
    """Off the rest position, where rates of angles are no angular velocities."""
    start = {"position": (0.0, 0.0, 0.0, 0.0, 0.4, 0.3)} if kinematics == "exact" else {}
    block = carried("block", 12.0, (5.0, 9.0, 7.0), (0.0, 0.0, 0.0), **start)
    stiff = np.diag([80.0, 90.0, 120.0, 40.0, 60.0, 50.0])
    stiff[3, 4] = stiff[4, 3] = 15.0
    held = hs.LinearMooring("block", stiff, 0.02 * stiff)
    forces = {"held": held, "shake": Drive("block", dof="roll", angle=SHAKE)}
    still = replace(block, weight=Weight.BALANCED)
    run = completed(scene([still], {}, DURATION, forces, kinematics=kinematics))
    q, _, _ = motion(SHAKE, TIME)
    np.testing.assert_allclose(run.position.sel(dof="roll")[:, 0], q, rtol=0.0, atol=1e-13)
    assert run.attrs["energy_residual_relative"] < WITHIN
    assert np.ptp(run.position.sel(dof="pitch").values) > 1e-3 or kinematics == "linear"


def test_a_run_goes_on_to_the_bit() -> None:
    """From a record in the middle, at a corner of the table, and between two."""
    for signal in (SHAKE, SmoothTable(KNOTS, VALUES), SmoothTable(TIME[::10], TIME[::10] ** 0.5)):
        whole = by_rk4(cart_and_rod(signal), 0.05).with_output(states=True)
        names = ("position", "velocity", "drive_force", "energy_work_shake")
        assert_continues(whole, completed(whole), (3.0, 5.1), *names)


def test_a_driven_motion_is_held_in_the_linear_analysis() -> None:
    """The rod swings about its pin, as if the cart were fixed."""
    compiled = hs.compile_scene(cart_and_rod(Harmonic(0.6, 3.1)))
    modes = hs.natural_modes(hs.linearise(compiled.model, compiled.state))
    natural = [2.0 * pi / m.natural_period for m in modes if m.natural_period]
    assert len(natural) == 1
    exact = np.sqrt(BOB * G * ARM / (ABOUT + BOB * ARM**2))
    assert natural[0] == pytest.approx(exact, rel=0.1)  # about the start, at 0.3 rad


def refused(whole: hs.Scene) -> str:
    with pytest.raises(InputError) as found:
        hs.compile_scene(whole)
    return str(found.value)


def test_lists_make_the_same_signals_as_arrays() -> None:
    for form in (SmoothTable, Recorded, Table):
        given = form([0, 4, 8, 11], [0, 1, 2, 1])  # type: ignore[arg-type]
        same = form(np.array([0.0, 4.0, 8.0, 11.0]), np.array([0.0, 1.0, 2.0, 1.0]))
        for ours, expected in zip(compile_signals([given]), compile_signals([same]), strict=True):
            assert ours.tobytes() == expected.tobytes()
        assert corners(given).tolist() == corners(same).tolist()
    hs.compile_scene(cart_and_rod(SmoothTable([0.0, 11.0], [0.0, 0.0])))  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"^SmoothTable: found times \(2,\) and values \(3,\); e"):
        SmoothTable(np.arange(2.0), np.arange(3.0))


@pytest.mark.parametrize(
    ("dof", "amplitude", "hull", "refuses"),
    [
        *(("pitch", 80.0, False, False), ("pitch", 86.0, False, True)),
        *(("roll", 80.0, True, False), ("roll", 86.0, True, True), ("roll", 86.0, False, False)),
    ],
)
def test_angles_that_are_none_or_leave_the_water_are_refused_before_the_run(
    dof: str, amplitude: float, hull: bool, refuses: bool
) -> None:
    """A pitch that has no angle, and a roll that takes a hull out of its water."""
    wet = {"hydrostatics": Hull(BOX)} if hull else {"weight": Weight.BALANCED}
    block = carried("block", 12.0, (5.0, 9.0, 7.0), (0.0,) * 3, **wet)
    turn = {"turn": Drive("block", dof=dof, angle=Harmonic(np.radians(amplitude), 8.0))}
    whole = replace(scene([block], {}, 8.0, turn), accept=tuple(Question) if hull else ())
    if refuses:
        expected = f"forces.turn.angle: found a {dof} of up to 86 deg; expected less than 85 deg"
        assert expected in refused(whole)
    else:
        hs.compile_scene(whole)


def test_a_driven_hull_that_capsizes_names_its_drive() -> None:
    """A hinge to the earth turns it, beside another body that stays upright."""
    block = carried("block", 12.0, (5.0, 9.0, 7.0), (0.0,) * 3)
    still = replace(block, name="still", location=(50.0, 0.0))
    hulls = [replace(each, hydrostatics=Hull(BOX)) for each in (still, block)]
    pin = hs.Hinge("block", axis=(0.0, 1.0, 0.0))
    turn = Drive(joint="pin", motion="angle", angle=Harmonic(np.radians(95.0), 8.0))
    whole = replace(scene(hulls, {"pin": pin}, 8.0, {"turn": turn}), accept=tuple(Question))
    with pytest.raises(hs.SimulationError, match=r"heel of its hull.*moved by forces\.turn"):
        hs.simulate(whole)


def along(name: str) -> dict[str, Any]:
    """Keys of a drive of the surge of a joint."""
    return {"body": None, "dof": None, "joint": name, "motion": "surge"}


def test_mistakes_are_told() -> None:
    short = SmoothTable(np.array([0.0, 5.0]), np.array([0.0, 1.0]))
    record = Recorded(np.arange(6.0), np.arange(6.0))
    hook = Drive(joint="hook", motion="rotation_x", angle=SHAKE)
    boom = Drive("boom", dof="surge", offset=SHAKE)
    whole = cart_and_rod()
    (cart, rod), away = whole.bodies, (1.0, 0, 0, 0, 0, 0)
    again = {**whole.forces, "again": Drive("cart", dof="surge", offset=SHAKE)}
    stuck = Acting(friction=JointFriction(1.0, 1.0))
    pin = with_motions(whole.joints["pin"], stuck)
    turn = {"turn": Drive(joint="pin", motion="angle", angle=SHAKE)}
    place = "an initial position of 1 m in surge of cart, which this drive starts with 0.4336"
    for text, wrong in {
        "is locked by bodies.cart.dofs": cart_and_rod(drive={"dof": "sway"}),
        "forces.shake.dof: found lift": cart_and_rod(drive={"dof": "lift"}),
        "from 0 s to 5 s; expected one of the whole run, from 0 s to 10 s": cart_and_rod(short),
        "forces.shake.offset: found a record from 0 s to 5 s": cart_and_rod(record),
        "forces.shake.offset: found straight lines": cart_and_rod(Table(KNOTS, VALUES)),
        "shake.motion: found surge; expected a motion of pin": cart_and_rod(drive=along("pin")),
        "which the joint slew carries": crane(boom),
        "turns of a ball follow no angle": crane(hook),
        "forces.again: shake drives surge of cart already": replace(whole, forces=again),
        place: replace(whole, bodies=(replace(cart, position=away), rod)),
        "initial velocity of 1 m/s": replace(whole, bodies=(replace(cart, velocity=away), rod)),
        "found friction in joints.pin": replace(whole, joints={"pin": pin}, forces=turn),
    }.items():
        assert text in refused(wrong)
    with pytest.raises(InputError, match=r"shake\.joint: found pit; expected a joint of the"):
        cart_and_rod(drive=along("pit"))
    with pytest.raises(InputError, match="found times that do not rise"):
        SmoothTable(np.array([0.0, 6.0, 5.0, 11.0]), np.arange(4.0))


def test_a_run_to_start_from_must_end_where_the_drive_begins() -> None:
    whole = cart_and_rod().with_output(states=True)
    run = completed(whole)
    start = hs.Start(run, 5.0)
    other = cart_and_rod(Harmonic(0.6, 3.2, 0.2, 0.4))
    text = refused(replace(other, initial=start, duration=5.0))
    assert "forces.shake: at 5 s it has the position" in text


def closed(whole: hs.Scene, name: str, kind: str, *times: float, **keys: Any) -> hs.Scene:
    """The scene with a joint of the cart to the earth that acts between these ``times`` [s]."""
    active = hs.Active(*map(hs.When, times)) if times else None
    stop = replace(joint(kind, "cart", **keys), active=active)
    return replace(whole, joints={**whole.joints, name: stop})


@pytest.mark.parametrize(("signal", "at"), [(SHAKE, 2.0), (Harmonic(0.6, 4.0), 1.0)])
def test_a_joint_that_closes_against_a_drive_ends_the_run(signal: Harmonic, at: float) -> None:
    """It would stop what the drive moves; also where it turns: the acceleration is not zero."""
    with pytest.raises(hs.SimulationError, match=r"joints\.stop .* drive moves"):
        hs.simulate(closed(cart_and_rod(signal), "stop", "fixed", at))


@pytest.mark.parametrize("method", [Method.RK4, Method.DOPRI5])
def test_work_and_impulse_of_a_drive_when_a_joint_closes(method, validated):
    """A lock joins a block at rest to a driven cart: the drive gives the block its momentum m v.

    Its work is m v^2, of which the impact loses one half; then it moves both.
    """
    mass, at = 7.0, 2.0
    dry = {"weight": Weight.BALANCED, "dofs": ("surge",)}
    cart = carried("cart", CART, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), **dry)
    block = carried("block", mass, (1.0, 1.0, 1.0), (3.0, 0.0, 0.0), **dry)
    lock = replace(joint("fixed", "block", "cart"), active=hs.Active(hs.When(at)))
    push = Drive("cart", dof="surge", offset=SHAKE)
    whole = scene([cart, block], {"lock": lock}, DURATION, {"shake": push})
    whole = replace(whole, solver=replace(whole.solver, method=method, step=0.02))
    run = completed(whole.with_output(impulses=True))
    _, u, a = motion(SHAKE, TIME)
    _, struck, _ = motion(SHAKE, at)
    joined = TIME > at + 1e-9
    _, begun, _ = motion(SHAKE, 0.0)
    work = 0.5 * CART * (u**2 - begun**2) + joined * 0.5 * mass * (u**2 + struck**2)
    claim, against = "drive with a lock that closes against it, work", "momentum and energy"
    error = np.abs(run.energy_work_shake.values - work).max() / np.ptp(work)
    validated(Kind.CLOSED_FORM, claim, against, error, 1e-6, Feature.DRIVES)
    force = (CART + joined * mass) * a
    np.testing.assert_allclose(run.drive_force[:, 0], force, rtol=0.0, atol=1e-9 * np.ptp(force))
    lost = run.lock_loss.values[:, 0]
    np.testing.assert_allclose(lost, joined * 0.5 * mass * struck**2, rtol=1e-9, atol=1e-9)
    impulse = run.lock_impulse.sel(lock="lock", dof="surge").values
    np.testing.assert_allclose(impulse[joined], mass * struck, rtol=1e-9)
    given = run.impulse.sel(force="shake", body="cart", dof="surge").values
    momentum = (CART + joined * mass) * u - CART * begun
    np.testing.assert_allclose(given, momentum, rtol=0.0, atol=1e-6 * np.ptp(momentum))
    followed = run.velocity.sel(body="block", dof="surge").values
    np.testing.assert_allclose(followed, joined * u, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("signal", [SHAKE, SmoothTable(KNOTS, VALUES)])
def test_an_interrupted_run_resumes_to_the_bit(signal, tmp_path, monkeypatch):
    """In the middle of a drive, and of a piece of its table."""
    monkeypatch.setattr(course, "CHUNK_CPU_TIME_S", 0.0)
    whole = cart_and_rod(signal)

    def stop(time: float, _: int) -> None:
        if time >= 0.53 * DURATION:
            raise KeyboardInterrupt

    place = Output(tmp_path / "x.nc.checkpoint", "checkpoint", tmp_path / "x.yaml")
    said: list[str] = []
    begun = hs.simulate(whole, stop, Checkpoint(place, 0.0, True, said.append))
    assert begun.attrs["status"] == "interrupted"
    resumed = hs.simulate(whole, None, Checkpoint(place, 0.0, True, said.append))
    assert "the run continues from" in said[-1]
    assert differences(completed(whole), resumed) == []


def slide_on_a_table(grip: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Place, speed and acceleration (nt,) of a block that friction accelerates by ``grip`` [m/s^2]
    at most, on a table that moves by `SHAKE`: at rest on it, or at a constant acceleration."""

    def table(t: float) -> Any:
        return motion(SHAKE, t)

    place, speed, pull = (np.array(x) for x in table(TIME))
    t = aside = 0.0
    while True:
        look = t + np.arange(1, 20_000) * 1e-3
        over = look[np.abs(table(look)[2]) > grip]
        if not over.size or over[0] > DURATION:
            return place, speed, pull
        begin = brentq(lambda x: abs(table(x)[2]) - grip, over[0] - 1e-3, over[0])
        x0, v0, push = table(begin)
        side = np.sign(push)

        def slip(x: float, begin: float = begin, v0: float = v0, side: float = side) -> float:
            return float(v0 + side * grip * (x - begin) - table(x)[1])

        look = begin + np.arange(2, 20_000) * 1e-3
        end = look[np.sign(slip(begin + 1e-3)) * np.array([slip(x) for x in look]) < 0.0][0]
        t = brentq(slip, end - 1e-3, end)
        assert abs(table(t)[2]) < grip  # it comes to rest on the table
        free = (begin < TIME) & (t > TIME)
        after = TIME[free] - begin
        place[free] = x0 + aside + v0 * after + 0.5 * side * grip * after**2
        speed[free] = v0 + side * grip * after
        pull[free] = side * grip
        went = x0 + v0 * (t - begin) + 0.5 * side * grip * (t - begin) ** 2
        aside += went - table(t)[0]
        place[t <= TIME] = motion(SHAKE, TIME[t <= TIME])[0] + aside


def test_a_block_slides_on_a_driven_table(validated) -> None:
    """Rigid dry friction between a driven table and a block, which holds, slips and holds again."""
    mass, pressed, grip = 7.0, 35.0, 1.8
    dry = {"weight": Weight.BALANCED}
    table = carried("table", CART, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), dofs=("surge",), **dry)
    start, speed, _ = motion(SHAKE, 0.0)
    begun = {"position": (start, 0, 0, 0, 0, 0), "velocity": (speed, 0, 0, 0, 0, 0)}
    free = {"dofs": ("surge", "sway"), **begun, **dry}
    block = carried("block", mass, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), **free)
    normal = hs.PrescribedNormal(Table(np.array([0.0]), np.array([pressed])))
    top = hs.Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), body="table")
    mu = mass * grip / pressed
    pad = hs.Fender("block", np.zeros((1, 3)), top, normal, hs.Coulomb(mu, mu))
    forces = {"shake": Drive("table", dof="surge", offset=SHAKE), "pad": pad}
    run = completed(scene([table, block], {}, DURATION, forces))
    place, speed, pull = slide_on_a_table(grip)
    assert np.ptp(place - motion(SHAKE, TIME)[0]) > 0.05
    found = run.position.sel(body="block", dof="surge").values
    error = np.abs(found - place).max() / np.ptp(place)
    claim, against = "block on a driven table with rigid dry friction", "parabolas between events"
    validated(Kind.CLOSED_FORM, claim, against, error, 1e-6, Feature.DRIVES, Feature.COULOMB)
    force = CART * motion(SHAKE, TIME)[2] + mass * pull
    np.testing.assert_allclose(run.drive_force[:, 0], force, rtol=0.0, atol=1e-5 * np.ptp(force))
    assert run.attrs["energy_residual_relative"] < 1e-9


def four_bar(signal: Any, **changes: Any) -> hs.Scene:
    """A parallelogram of two cranks and a coupler, whose first crank is driven."""
    long, apart_by = 2.0, 5.0
    first = carried("first", 3.0, (1.0, 1.0, 1.0), (0.0, 0.0, 0.5 * long))
    second = carried("second", 3.0, (1.0, 1.0, 1.0), (apart_by, 0.0, 0.5 * long))
    coupler = carried("coupler", 9.0, (1.0, 20.0, 20.0), (0.5 * apart_by, 0.0, long))
    foot, head = (0.0, 0.0, -0.5 * long), (0.0, 0.0, 0.5 * long)
    joints = {
        "a": joint("hinge", "first", None, point=foot, axis=Y),
        "b": joint("hinge", "second", None, *changes.pop("second", ()), point=foot, axis=Y),
        "c": joint("hinge", "coupler", "first", point=(-0.5 * apart_by, 0.0, 0.0), axis=Y),
        "d": joint("ball", "second", "coupler", point=head),
    }
    crank = Drive(joint="a", motion="angle", angle=signal)
    return scene([first, second, coupler], joints, DURATION, {"crank": crank}, **changes)


def test_a_driven_four_bar_begins_with_a_sine() -> None:
    """Its followers start with the velocities that its joints need: the coupler does not turn."""
    turn = Harmonic(0.7, 6.0)
    run = completed(four_bar(turn))
    q, u, a = motion(turn, TIME)
    long, both, coupler = 2.0, 2.0 * (1.0 + 3.0 * 1.0**2), 9.0
    for name in ("a angle", "b angle"):
        angle = run.sel(joint_motion=name)
        np.testing.assert_allclose(angle.joint_position, q, rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(angle.joint_velocity, u, rtol=0.0, atol=1e-9)
    inertia = both + coupler * long**2
    weight = (2.0 * 3.0 * 0.5 * long + coupler * long) * G
    moment = inertia * a - weight * np.sin(q)
    np.testing.assert_allclose(run.drive_force[:, 0], moment, rtol=0.0, atol=1e-7 * np.ptp(moment))


def test_velocities_that_part_a_driven_linkage_are_refused() -> None:
    turn = Harmonic(0.7, 6.0)
    _, u, _ = motion(turn, 0.0)
    with pytest.raises(InputError, match="the initial velocities part"):
        hs.compile_scene(four_bar(turn, second=[moved(0.0, 2.0 * u)]))


@pytest.mark.parametrize(("back", "ends"), [(False, False), (True, True)])
def test_a_ratchet_may_be_closed_under_a_drive_from_the_start(back: bool, ends: bool) -> None:
    """The drive rests until 2 s; then it goes the way of the ratchet, or back."""
    way = -1.0 if back else 1.0
    signal = SmoothTable(np.array([0.0, 2.0, 4.0, DURATION]), way * np.array([0.0, 0.0, 0.6, 0.6]))
    held = closed(
        cart_and_rod(signal, step=0.05), "pawl", "ratchet", axis=X, slide=hs.SlidingPawl()
    )
    if not ends:
        found = completed(held).sel(body="cart", dof="surge").position
        assert found[-1] == pytest.approx(0.6, abs=1e-12)
        return
    with pytest.raises(hs.SimulationError, match=r"t = 2\.[01]\d* s joints\.pawl .* drive moves"):
        hs.simulate(held)


RESTS = SmoothTable(
    np.array([0.0, 2.0, 4.0, 5.0, 7.0, 10.0]), np.array([0.0, 0.0, 0.6, 0.6, 1.2, 0.0])
)
"""It stands still until 2 s and from 4 s to 5 s, moves on, and goes back from 7 s on."""


@pytest.mark.parametrize("type_", ["fixed", "ball"])
@pytest.mark.parametrize("until", [1.5, 2.5])
def test_a_drive_may_rest_in_a_closed_joint_and_not_leave_it(type_: str, until: float) -> None:
    """Its rows depend on that of the drive, so that no force would show it."""
    held = closed(cart_and_rod(RESTS, step=0.05), "hold", type_, 1.0, until)
    if until < 2.0:
        found = completed(held).sel(body="cart", dof="surge").position
        exact = PchipInterpolator(RESTS.time, RESTS.value)(TIME)
        np.testing.assert_allclose(found, exact, rtol=0.0, atol=1e-13)
        return
    with pytest.raises(hs.SimulationError, match=r"t = 2\.[01]\d* s joints\.hold .* drive moves"):
        hs.simulate(held)


def test_a_ratchet_lets_a_drive_go_its_way_alone() -> None:
    """It holds while the drive rests, lets it go on, and ends the run when it goes back."""
    whole = cart_and_rod(RESTS, step=0.05)
    held = closed(whole, "pawl", "ratchet", 1.0, axis=X, slide=hs.SlidingPawl())
    run = completed(replace(held, duration=7.0))
    mode = run.lock_mode.values[:, 0]
    assert [mode[TIME.searchsorted(t)] for t in (1.5, 3.0, 6.0)] == [3, 2, 2]
    with pytest.raises(hs.SimulationError, match=r"t = 7\.[01]\d* s joints\.pawl .* drive moves"):
        hs.simulate(held)
