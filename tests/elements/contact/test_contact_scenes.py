"""Contact beyond one axis: ties, reversals, two bodies, turned scenes, the stiff base case."""

from dataclasses import replace

import numpy as np
import pytest
from in_plane import HEAVY, Driven, integrate_in_plane
from markers import few
from numpy.testing import assert_allclose
from one_axis import Block, integrate
from scenes import (
    FLOOR,
    INERTIA,
    Law,
    block,
    central_force,
    errors,
    heave,
    momenta,
    mooring,
    moving,
    observed_orders,
    on_floor,
    scene,
    steady,
    straight_curve,
    surge,
    table,
    with_step,
)
from scipy.spatial.transform import Rotation

import hydrosim as hs
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Kinematics, Scene

STEEL = hs.StickSlip(0.3, 0.2, 2e6, 4e4, 1e4)
LAWS: dict[str, Law] = {
    "stick-slip": STEEL,
    "friction slope": hs.FrictionSlope(0.2, 1e5),
    "frictionless": hs.Frictionless(),
}
KNEES = hs.NormalCurve(np.array([0.0, 0.1, 0.2]), np.array([0.0, 1e5, 4e5]))
SQUARE = np.array([[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [-1.0, -1.0, 0.0]])


def shared(curve: hs.NormalCurve, count: int) -> hs.NormalCurve:
    return replace(curve, force=curve.force / count, damping=curve.damping / count)


def falling(points: np.ndarray, law: Law, damping: float = 0.0) -> Scene:
    """A block that falls on its fenders, all at once."""
    curve = shared(replace(KNEES, damping=damping), len(points))
    fender = hs.Fender("block", points, FLOOR, curve, law)
    forces = {"weight": steady(heave=-9.81e4), "fender": fender}
    return scene(block(1e4, position=moving(heave=0.5)), forces, 5.0, 0.1, step=0.005)


@pytest.mark.parametrize("law", LAWS)
def test_fenders_that_touch_at_once_act_as_one(law):
    """Ties: as many events as a single fender has, no rotation, the same motion."""
    one = hs.simulate(falling(np.zeros((1, 3)), LAWS[law]))
    for count in (2, 4):
        points = SQUARE[[0, 3]] if count == 2 else SQUARE
        many = hs.simulate(falling(points, LAWS[law]))
        assert many.solver_events == one.solver_events > 10
        assert_allclose(heave(many), heave(one), atol=1e-9)
        assert_allclose(many.position.values[:, 0, 3:], 0.0, atol=1e-12)
        modes = many.fender_mode.values
        assert np.array_equal(modes, np.repeat(modes[:, :1], count, axis=1))


def test_ledger_closes_through_impacts_on_a_damped_fender(figure):
    """A damped fender lets go while it is still compressed; what it holds then is lost."""
    scenes = [with_step(falling(np.zeros((1, 3)), STEEL, damping=3e4), h) for h in (0.002, 0.001)]
    residuals = [hs.simulate(s).energy_residual_relative for s in scenes]
    figure("energy residual", residuals[-1])
    assert residuals[-1] <= 1e-6
    assert residuals[-1] <= residuals[0] / 8  # order 3 at least


def swinging(law: Law, press: float) -> Block:
    """A block on a spring, pressed so lightly that it sticks for a moment only where it turns."""
    loads = (np.array([0.0, 2.5]), np.zeros(2), np.full(2, -press))
    start = {"spring": (4e6, 0.0), "start": (0.0, 1.0, -press / 1e8, 0.0)}
    return Block(1e6, straight_curve(1e8), law, *loads, **start, duration=2.5)


REVERSALS = {
    "stick-slip": swinging(hs.StickSlip(0.2, 0.1, 1e7, 1e6, 1e5), 1e4),
    "stick-slip without damping": swinging(hs.StickSlip(0.2, 0.1, 1e7, 0.0, 3e6), 1e5),
    "friction slope": swinging(hs.FrictionSlope(0.2, 1e7), 1e5),
}


def test_what_a_fender_holds_that_is_left_at_the_start_is_lost_later() -> None:
    """Compressed by 3 cm and leaving at 2 m/s, its damper would pull: it is open, and the energy of
    its curve, k d^2 / 2, is lost bit by bit until that is free."""
    curve = straight_curve(1e6, damping=2e4)
    foot = hs.Fender("block", np.array([[0.0, 0.0, 0.0]]), FLOOR, curve, hs.Frictionless())
    body = block(1e4, ["heave"], position=moving(heave=-0.03), velocity=moving(heave=2.0))
    run = hs.simulate(scene(body, {"foot": foot, "weight": steady(heave=-9.81e4)}, 0.2, 0.005))
    lost = run.fender_dissipated.values[:, 0]
    assert lost[0] == 0.0
    assert np.all(np.diff(lost) >= 0.0)
    assert_allclose(lost[-1], 0.5 * 1e6 * 0.03**2, rtol=1e-9)


@pytest.mark.parametrize("name", REVERSALS)
def test_stick_is_found_however_short_it_is(name, figure):
    """Stick of milliseconds where slip turns round: a step must not jump over it, or the order is
    lost. The number of events does not depend on the step. Nodes that relax in less than ten steps
    are stepped finer, which is a jump in error: so steps are on one side of that."""
    swing, times = REVERSALS[name], 0.1 * np.arange(26)
    exact = integrate(swing, times, resolution=1e-3)
    steps = (0.05, 0.025, 0.0125) if name == "stick-slip" else (0.02, 0.01, 0.005)
    runs = [hs.simulate(swing.scene(step)) for step in steps]
    size = np.array([np.abs(surge(run) - exact.states[:, 0]).max() for run in runs])
    figure("events", exact.events.size)
    figure("error", size[-1])
    figure("order", observed_orders(steps, size)[-1])
    assert [run.solver_events for run in runs] == [exact.events.size] * len(steps)
    assert exact.events.size >= 4
    assert np.all(observed_orders(steps, size) >= 3.5)


def test_swings_shorten_by_twice_the_friction_over_the_stiffness(validated):
    """The rigid limit of the law, a node two hundred times as stiff as the spring: a mass with dry
    friction loses 2 mu N / K in every half swing, but for the first quarter's half of it (Den
    Hartog 1931)."""
    law, N = hs.StickSlip(0.1, 0.1, 8e8, 1e6), 2e4
    long = replace(swinging(law, N), time=np.array([0.0, 12.0]), duration=12.0)
    x = np.abs(surge(hs.simulate(long.scene(0.002, output_step=0.01))))
    peaks = x[1:-1][(x[1:-1] > x[:-2]) & (x[1:-1] >= x[2:])]
    loss = 2 * law.kinetic * N / 4e6
    expected = np.sqrt(1e6 / 4e6) - loss * (np.arange(peaks.size) + 0.5)
    # stretching the node takes mu N / K2, 2.5e-6 m, and records 0.01 s apart may miss a peak by
    # a (w 0.005)^2 / 2, 2.5e-5 m; the loss in all half swings is 7e-3 m
    assert peaks.size == 8
    error = float(np.abs(peaks - expected).max())
    claim = "swings that shorten by 2 μN/K each, of 0.5 m [m]"
    validated(Kind.CLOSED_FORM, claim, "Den Hartog 1931", error, 6e-5, Feature.STICK_SLIP)


def test_friction_does_not_know_the_axes():
    """A straight slide at 36.9 deg is that along x."""

    def slide(direction: np.ndarray) -> np.ndarray:
        rough = hs.StickSlip(0.2, 0.1, 1e7, 1e6, 1e5)
        springs, fender = mooring(surge=4e6, sway=4e6), on_floor(1e9, rough)
        forces = {"weight": steady(heave=-1e6), "springs": springs, "fender": fender}
        v = 2.0 * direction
        start = {"position": moving(heave=-1e-3), "velocity": moving(surge=v[0], sway=v[1])}
        body = block(1e6, ("surge", "sway", "heave"), **start)
        run = hs.simulate(scene(body, forces, 10.0, 0.1, step=0.01))
        return run.position.values[:, 0, :2]

    along, oblique = slide(np.array([1.0, 0.0])), slide(np.array([0.8, 0.6]))
    assert_allclose(oblique, np.outer(along[:, 0], [0.8, 0.6]), atol=1e-9)


def test_a_point_driven_in_a_circle(figure):
    """The node follows a circle of radius r behind the point's R, at an angle, with

        i (mu_k N + (C2 + C3) w r) exp(-i a) = K2 (R - r exp(-i a)) + i w C2 R

    and the loss is mu_k N times its path, C2 and C3 apart. The body is so heavy that friction does
    not change its motion."""
    N, R, w, m, law = 1e5, 2.0, 0.7, 1e13, hs.StickSlip(0.3, 0.2, 5e5, 2e5, 3e4)
    c = law.damping + law.slip_damping
    a = law.stiffness**2 + (c * w) ** 2
    b = law.kinetic * N * c * w
    rest = (law.kinetic * N) ** 2 - (law.stiffness**2 + (law.damping * w) ** 2) * R**2
    r = (-b + np.sqrt(b * b - a * rest)) / a
    turn = 1j * (law.kinetic * N + c * w * r) + law.stiffness * r
    lag = np.angle(turn / ((law.stiffness + 1j * w * law.damping) * R))
    stretch = abs(R - r * np.exp(1j * lag))
    losses = {
        "fender_dissipated_damping": law.damping * (w * stretch) ** 2,
        "fender_dissipated_slip_damping": law.slip_damping * (w * r) ** 2,
    }
    loss = law.kinetic * N * w * r + sum(losses.values())

    springs = mooring(surge=m * w * w, sway=m * w * w)
    forces = {"springs": springs, "weight": steady(heave=-N), "fender": on_floor(1e7, law)}
    start = {"position": moving(surge=R, heave=-N / 1e7), "velocity": moving(sway=w * R)}
    body = block(m, ("surge", "sway", "heave"), **start)
    run = hs.simulate(scene(body, forces, 20.0, 1.0, step=0.01))
    late = run.isel(time=slice(15, None), fender=0)
    node = np.linalg.norm(late.fender_node.values[:, :2], axis=1)
    seconds = float(late.time[-1] - late.time[0])
    slid = float(late.fender_slip_distance[-1] - late.fender_slip_distance[0])
    lost = float(late.fender_dissipated[-1] - late.fender_dissipated[0])
    figure("radius of the node", r)
    figure("error of the loss", lost / (loss * seconds) - 1)
    assert_allclose(node, r, rtol=1e-6)
    assert slid == pytest.approx(w * r * seconds, rel=1e-6)
    assert lost == pytest.approx(loss * seconds, rel=1e-6)
    for name, rate in losses.items():
        assert float(late[name][-1] - late[name][0]) == pytest.approx(rate * seconds, rel=1e-6)


PLANAR = hs.StickSlip(0.3, 0.2, 5e5, 2e5, 3e4)
UNDAMPED, SLIDING = replace(PLANAR, slip_damping=0.0), replace(PLANAR, damping=0, slip_damping=1e5)
FIGURES = {
    "circle": Driven(PLANAR, 1e5, (2.0, 2.0), (0.7, 0.7), (0.0, np.pi / 2)),
    "circle in stick and slip": Driven(PLANAR, 1e6, (1.0, 1.0), (0.7, 0.7), (0.0, np.pi / 2)),
    "Lissajous 1:2": Driven(PLANAR, 1e5, (1.0, 0.6), (0.7, 1.4), (0.0, 0.3)),
    "Lissajous 3:2, a line at times": Driven(PLANAR, 2e5, (1.0, 0.8), (1.5, 1.0), (0.0, 0.0)),
    "Lissajous 1:3, C2 alone": Driven(UNDAMPED, 1e5, (0.8, 0.5), (0.5, 1.5), (0.4, 1.0)),
    "Lissajous 2:3, C3 alone": Driven(SLIDING, 1e5, (0.8, 0.8), (1.0, 1.5), (0.2, 1.0)),
}


@pytest.mark.parametrize("name", few(FIGURES, 3))
def test_a_driven_point_against_an_independent_integration(name, figure, validated):
    """The node, its path and the losses, C2 and C3 apart: in all mu_k N times the path and the two.
    Traction is within mu_s N in stick, and mu_k N + C3 |v2| in slip."""
    driven = FIGURES[name]
    run = hs.simulate(driven.scene(0.01)).isel(fender=0)
    exact = integrate_in_plane(driven, run.time.values)
    law, N, mode = driven.law, driven.normal, run.fender_mode.values
    stretch, (path, damped, slip_damped) = exact.states[:, :2], exact.states[:, 2:].T
    figure("events", len(exact.events))
    figure("error of the path", float(run.fender_slip_distance[-1]) / path[-1] - 1)
    assert run.solver_events == len(exact.events)
    apart = np.abs(run.time.values[:, None] - [*exact.events, np.inf]).min(axis=1) > 1e-6
    assert np.array_equal(mode[apart], exact.modes_at(run.time.values)[apart])
    node = driven.place(run.time.values) - stretch
    error = np.abs(run.fender_node.values[:, :2] - node).max() / max(driven.size)
    claim = "contact node that is driven along figures in a plane, of their size"
    against = "its own equation, by scipy"
    validated(Kind.INDEPENDENT, claim, against, error, 1e-7, Feature.STICK_SLIP)
    losses = {
        "slip_distance": path,
        "dissipated_damping": damped,
        "dissipated_slip_damping": slip_damped,
        "dissipated": law.kinetic * N * path + damped + slip_damped,
    }
    for what, expected in losses.items():
        assert_allclose(run[f"fender_{what}"], expected, atol=1e-6 * expected[-1], err_msg=what)
    size = np.linalg.norm(run.fender_friction.values, axis=1)
    T = np.array([driven.traction(t, s) for t, s in zip(run.time.values, stretch, strict=True)])
    c = law.damping + law.slip_damping
    speed = (np.linalg.norm(T, axis=1) - law.kinetic * N) / c
    slip = law.kinetic * N + law.slip_damping * speed
    assert np.all(size[mode == 1] <= law.static * N * (1 + 1e-9))
    assert_allclose(size[mode == 2], slip[mode == 2], rtol=1e-6)


@pytest.mark.parametrize("mass", [1e6, HEAVY])
@pytest.mark.parametrize("name", FIGURES)
def test_a_driven_point_turns_with_its_scene(name, mass):
    """Heavy, so that only the node is free, and so light that friction carries the body along."""
    here, there = (hs.simulate(FIGURES[name].scene(0.01, turn, mass)) for turn in (0.0, 0.7))
    R = Rotation.from_euler("z", 0.7).as_matrix()
    assert np.array_equal(here.fender_mode, there.fender_mode)
    for variable in ("position", "velocity", "fender_node", "fender_friction"):
        a, b = here[variable].values[:, 0, :3] @ R.T, there[variable].values[:, 0, :3]
        assert_allclose(b, a, atol=1e-10 * np.abs(a).max(), err_msg=variable)


def collision(law: Law) -> Scene:
    """Two bodies in free flight, one against the deck of the other; nothing else acts."""
    points = np.array([[0.4, 0.2, -1.0], [-0.3, -0.4, -1.0]])
    deck = hs.Plane((0.0, 0.0, 1.0), (0.1, 0.05, 1.0), body="carrier")
    forces = {"fender": hs.Fender("block", points, deck, replace(KNEES, damping=2e3), law)}
    start = {"centre_of_gravity": (0.1, -0.2, 2.4), "velocity": (1.5, 0.6, -1.5, 0.1, -0.2, 0.3)}
    above = block(1e4, **start)
    below = block(3e4, name="carrier", velocity=(-0.2, 0.1, 0.3, -0.1, 0.1, -0.15))
    return scene([above, below], forces, 2.0, 0.1, step=0.005)


@pytest.mark.parametrize("law", LAWS)
def test_two_bodies_keep_their_momentum(law, figure):
    """Momentum to rounding; angular momentum, not linear in the state, at the method's order."""
    drifts = []
    for step in (0.01, 0.005):  # the node relaxes in less than ten of either
        whole = with_step(collision(LAWS[law]), step)
        run = hs.simulate(whole)
        linear, angular = momenta(run, whole.bodies)
        assert_allclose(linear, linear[[0]] * np.ones((len(linear), 1)), atol=1e-7)
        drifts.append(np.abs(angular - angular[0]).max() / np.abs(angular[0]).max())
    figure("drift of angular momentum", drifts[-1])
    assert np.abs(run.force_fender).max() > 1e4
    assert run.solver_events >= 4
    assert drifts[-1] <= 1e-8
    assert drifts[-1] <= drifts[0] / 8


TURN = Rotation.from_euler("z", 0.7).as_matrix()
SHIFT = np.array([30.0, -20.0, 0.0])
PUSH = np.array([[3e4, 1e4, -1e5, 0, 2e4, 1e4], [-4e4, 2e4, -8e4, 1e4, 0, -2e4]])


def tumbling(turn: np.ndarray, shift: np.ndarray, law: Law) -> Scene:
    """A block that is pushed over a sloping floor, as it is or turned and moved."""
    both = np.kron(np.eye(2), turn)
    K = np.diag([5e3, 2e4, 0.0])
    push = table([0.0, 3.0], PUSH @ both.T)
    points = (SQUARE * [1.5, 1.0, 0.0] - [0.0, 0.0, 1.0]) @ turn.T
    floor = hs.Plane(tuple(shift), tuple(turn @ [0.05, -0.1, 1.0]))
    forces = {
        "push": hs.AppliedForce("block", tuple(turn @ [0.2, 0.1, 0.0]), push),
        "mooring": hs.LinearMooring("block", np.kron(np.diag([1.0, 0.0]), turn @ K @ turn.T)),
        "fender": hs.Fender("block", points, floor, shared(replace(KNEES, damping=2e4), 4), law),
    }
    v, omega = turn @ [0.8, -0.3, 0.0], turn @ [0.1, -0.1, 0.2]
    inertia, place = 1e4 * turn @ INERTIA @ turn.T, tuple(shift[:2])
    at = {"location": place, "centre_of_gravity": (0.0, 0.0, 1.1), "velocity": (*v, *omega)}
    body = block(1e4, inertia=inertia, **at)
    return scene(body, forces, 4.0, 0.1, step=0.01)


@pytest.mark.parametrize("law", LAWS)
def test_a_run_turns_with_its_scene(law):
    """Events are located to 1e-10, which impacts multiply: 1e-6; 1e-11 for forces at an instant."""
    here = hs.simulate(tumbling(np.eye(3), np.zeros(3), LAWS[law]))
    there = hs.simulate(tumbling(TURN, SHIFT, LAWS[law]))
    assert there.solver_events == here.solver_events >= 10
    for name in ("position", "velocity", "force_fender"):
        a, b = here[name].values[:, 0, :3] @ TURN.T, there[name].values[:, 0, :3]
        assert_allclose(b, a, atol=1e-6 * np.abs(a).max())
    assert np.array_equal(here.fender_mode, there.fender_mode)
    dissipated = here.fender_dissipated.values
    assert_allclose(there.fender_dissipated.values, dissipated, atol=1e-6 * dissipated.max())


def test_linear_kinematics_of_contact_is_the_limit_of_small_motions(figure):
    """Scaled by e it moves by e times the same in linear kinematics, and to e^2 in exact ones."""

    def run(size: float, kinematics: Kinematics) -> np.ndarray:
        whole = tumbling(np.eye(3), np.zeros(3), STEEL)
        fender = whole.forces["fender"]
        straight = straight_curve(1e6)
        points = fender.points - 0.1 * np.eye(3)[2]
        forces = {
            **whole.forces,
            "push": replace(whole.forces["push"], force=table([0.0, 3.0], size * PUSH)),
            "fender": replace(fender, plane=FLOOR, normal=straight, points=points),
            "springs": mooring(roll=1e6, pitch=1e6, yaw=1e5),
        }
        (body,) = whole.bodies
        body = replace(body, velocity=tuple(size * np.array(body.velocity)))
        small = replace(whole, bodies=(body,), forces=forces)
        result = hs.simulate(with_step(small, 0.002, kinematics=kinematics))
        assert result.solver_events > 4
        return result.position.values[:, 0]

    large, small = run(1e-3, Kinematics.LINEAR), run(5e-4, Kinematics.LINEAR)
    assert_allclose(large, 2 * small, atol=1e-12)
    sizes = ((1e-3, large), (5e-4, small))
    differences = [np.abs(run(size, Kinematics.EXACT) - linear).max() for size, linear in sizes]
    order = float(np.log2(differences[0] / differences[1]))
    figure("order in the size of the motion", order)
    assert order == pytest.approx(2.0, abs=0.2)


def pressed_barge(**law: float) -> Scene:
    """Four fenders as stiff as the reverse float-over's, pressed while swell pushes and heaves."""
    rng, t = np.random.default_rng(1), np.arange(0.0, 200.5, 0.5)
    force, periods = np.zeros((t.size, 6)), rng.uniform(6, 12, 8)
    for w, a, p in zip(2 * np.pi / periods, *rng.uniform(0.5, 6, (2, 8)), strict=True):
        force[:, 0] += 6e5 * a * np.cos(w * t + p)
        force[:, 2] += 2e6 * a * np.cos(w * t + p + 1.0)
        force[:, 4] += 2e7 * a * np.cos(w * t + p + 2.0)
    force[:, 2] += np.interp(t, [0.0, 200.0], [1.25e8, 1.8e8])
    m = 1.7e8
    springs = np.diag([392.4e3, 0.0, 1.32e8, 0.0, 5e11, 0.0])
    friction = {"stiffness": 1.4e8, "damping": 8.25e6, "slip_damping": 2.5e5} | law
    corners = np.array([[x, y, 7.5] for x in (20, -20) for y in (20, -20)], dtype=float)
    topside = hs.Plane((0.0, 0.0, 3.6), (0.0, 0.0, -1.0))
    curve = straight_curve(9.81e7)
    steel = hs.StickSlip(static=0.2, kinetic=0.1, **friction)
    forces = {
        "waves and lift": central_force(**table(t, force)),
        "mooring": hs.LinearMooring("block", springs, 0.05 * springs),
        "fender": hs.Fender("block", corners, topside, curve, steel),
    }
    at = {"centre_of_gravity": (0.0, 0.0, -4.9), "position": moving(heave=0.93)}
    inertia = m * np.diag([22.0**2, 67.6**2, 68.9**2])
    start = block(m, ("surge", "heave", "pitch"), inertia=inertia, **at)
    return scene(start, forces, 200.0, 0.5, step=0.1)


BARGES = {
    "K2 1.4e8, C2 8.25e6, C3 2.5e5": {},
    "no C3": {"slip_damping": 0.0},
    "ten times softer": {"stiffness": 1.4e7, "damping": 8.25e5},
    "C3 of 2.5e7": {"slip_damping": 2.5e7},
}


@pytest.mark.parametrize("name", few(BARGES, 1))
def test_stiff_fenders_of_the_base_case(name, figure):
    """Order 4 down from 0.1 s with the same events at every step; far from it without events."""
    barge = pressed_barge(**BARGES[name])
    fine = hs.simulate(with_step(barge, 0.005))
    span, steps = np.ptp(surge(fine)), (0.1, 0.05, 0.025)
    size = errors(barge, steps, surge(fine)) / span
    crude = errors(barge, steps[-1:], surge(fine), events=False) / span
    coarse = hs.simulate(barge)
    figure("events", fine.solver_events)
    figure("error at 0.1 s", size[0])
    figure("error at 0.025 s", size[-1])
    figure("error at 0.025 s without events", crude[0])
    figure("order", observed_orders(steps, size)[-1])
    assert coarse.solver_events == fine.solver_events >= 20
    assert np.array_equal(coarse.fender_mode, fine.fender_mode)
    assert observed_orders(steps, size)[-1] >= 3.5
    assert crude[0] > 50 * size[-1]
