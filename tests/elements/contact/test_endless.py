"""Runs that cannot go on end, with a message: no search for an event goes on for ever."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import (
    FLOOR,
    block,
    central_force,
    mooring,
    moving,
    on_floor,
    scene,
    steady,
    table,
    with_step,
)

import hydrosim as hs
from hydrosim.dofs import DOFS
from hydrosim.elements import Harmonic, constant
from hydrosim.elements.contact.law import OPEN, SLIP, STICK
from hydrosim.scene import Environment, Method, Scene, Stream, Tolerance

CURVE = hs.NormalCurve(np.array([0.0, 0.03, 0.06, 0.09]), np.array([0.0, 2e6, 8.4e6, 2e7]))
PLANE = hs.Plane((-0.75, 13.0, 5.4), (-0.13, -0.99, 0.085))
POINT = np.array([[0.46, 2.5, -3.9]])
DEPTH = np.array([0.0, 0.1])
LOOP = hs.NormalLoop(DEPTH, np.array([0.0, 2e4]), DEPTH, np.array([0.0, 1.8e4]), 2e6)
HEADINGS = np.radians([0.0, 90.0, 180.0, 270.0])


@pytest.mark.parametrize("method", [Method.RK4, Method.DOPRI5])
def test_a_node_far_beyond_its_step_limit(method: Method) -> None:
    """K2 / C2 is 190 1/s, the step 0.05 s: what relaxes grows; steps that adapt come to the end."""
    law = hs.StickSlip(0.14, 0.12, stiffness=1.9e8, damping=1e6)
    surge = 4300.0 * np.cos(HEADINGS)
    wind = hs.WindLoad("block", (0.0, 0.0, 0.0), HEADINGS, surge, 0.0 * surge, 0.0 * surge)
    elements = {"fender": hs.Fender("block", POINT, PLANE, CURVE, law), "wind": wind}
    windy = scene(block(3.8e6, ["surge"]), elements, 52.0, 0.5, step=0.05, method=method)
    windy = replace(windy, environment=Environment(wind=Stream(18.0)))
    if method is Method.DOPRI5:
        assert hs.simulate(replace(windy, duration=10.0)).attrs["status"] == "complete"
        return
    ends = r"no longer finite|changes its mode endlessly|blows up"
    with pytest.raises(hs.SimulationError, match=ends):
        hs.simulate(windy)


def test_a_node_that_comes_to_stick_on_the_kinetic_cone_stays() -> None:
    """Static and kinetic friction alike, no dampers: where slip ends, the margin of stick is zero
    but for roundings. A block of 82 t on four points, pushed to and fro on a slope."""
    slope = hs.Plane((0.0, 0.0, 0.0), (0.056289, 0.0, 1.0))
    force = np.array([0.0, 642520.0, 4222800.0]) / 4
    curve = hs.NormalCurve(np.array([0.0, 0.065889, 0.19767]), force)
    corners = [(x, y, -1.4957) for x in (3.4438, -3.4438) for y in (1.8693, -1.8693)]
    law = hs.StickSlip(0.19361, 0.19361, 18103000.0 / 4, 0.0)
    legs = hs.Fender("block", np.array(corners), slope, curve, law)
    push = central_force(surge=Harmonic(88314.0, 4.7002))
    elements = {"weight": steady(heave=-803150.0), "legs": legs, "push": push}
    body = block(81871.0, ["surge", "heave"], centre_of_gravity=(0.0, 0.0, 1.4957))
    turned = replace(body, position=moving(yaw=0.95297))
    pushed = scene(turned, elements, 12.0, 0.1, method=Method.RK2, step=0.00025)
    assert hs.simulate(pushed).attrs["status"] == "complete"


def test_a_drawbar_without_length_is_no_reason_to_stop() -> None:
    """A bouncing, slipping block: as N goes through zero the node's drawbar turns ever faster."""
    law = hs.StickSlip(0.34, 0.2, 2e7, 0.0)
    elements = {
        "weight": steady(heave=-8e4),
        "foot": on_floor(4e6, law),
        "guide": mooring(surge=5e4, sway=8e4),
        "push": central_force(surge=Harmonic(2e4, 2.7)),
    }
    speed, height = moving(surge=-0.305, sway=-0.246), moving(heave=0.072)
    body = block(8e3, ["surge", "sway", "heave"], velocity=speed, position=height)
    tight = Tolerance(1e-10, 1e-10, 1e-10)
    bouncing = scene(body, elements, 20.0, 0.1, method=Method.DOPRI5, tolerance=tight, step=0.002)
    assert hs.simulate(bouncing).attrs["status"] == "complete"


def test_what_begins_to_slide_heads_for_where_it_is_pushed() -> None:
    """A block on a free one, rigid friction: at break-away the velocity left is rounding alone."""
    below = block(1966.0, ["surge", "sway", "yaw"], "below", position=moving(yaw=-2.244))
    above = block(4525.7, ["surge", "heave"], "above", centre_of_gravity=(0.0, 0.0, 1.0))
    deck = hs.Plane((0.0, 0.0, 0.3), (0.0, 0.0, 1.0), "below")
    curve = hs.NormalCurve(np.array([0.0, 0.031468, 0.094404]), np.array([0.0, 35518.0, 155350.0]))
    feet = [(0.534, 0.0, -0.3), (-0.534, 0.0, -0.3)]
    low = hs.Plane((0.0, 0.0, -0.0226), (0, 0, 1.0))
    elements = {
        "weight below": steady("below", heave=-19286.0),
        "weight above": steady("above", heave=-44397.0),
        "feet": on_floor(426845.0, hs.StickSlip(0.4, 0.4, 691400.0, 0.0), feet, low, "below"),
        "rough": hs.Fender(
            "above", np.array([(0.0, 0.0, -0.7)]), deck, curve, hs.Coulomb(0.181, 0.181)
        ),
        "push": central_force("below", surge=Harmonic(899.62, 4.0987)),
        "drag": central_force("above", surge=Harmonic(1736.4, 17.202)),
    }
    pair = [below, replace(above, position=moving(yaw=-2.244))]
    there = scene(pair, elements, 73.0, 0.5, method=Method.DOPRI5, step=0.01)
    assert hs.simulate(there).attrs["status"] == "complete"


def test_rigid_friction_that_just_begins_to_slip_comes_on() -> None:
    """A block under two forces of the size of its friction begins to slip, and stops, seventy times
    in half a minute: at once its slip heads where it is pushed to, however slow it is. An explicit
    method, and an implicit one that asks for derivatives, must find so without a chatter or steps
    by the ten thousand, and agree: both keep to 1e-6 m/s, and so to 3e-5 m and as much by
    velocities in each stretch of slip, of half a second."""
    normal, law = hs.PrescribedNormal(constant(1e4)), hs.Coulomb(0.3, 0.3)
    push = {"surge": Harmonic(3.2e3, 1.0), "sway": Harmonic(1.5e3, 1.4)}
    foot = hs.Fender("block", np.zeros((1, 3)), FLOOR, normal, law)
    elements = {"foot": foot, "push": central_force(**push)}
    body = block(1e3, ["surge", "sway"])
    whole = scene(body, elements, 30.0, 0.1, step=0.01)
    methods = (Method.DOPRI5, Method.ESDIRK4)
    runs = [hs.simulate(with_step(whole, 0.01, method=method)) for method in methods]
    assert all(run.attrs["solver_events"] > 50 for run in runs)
    ours, theirs = (run.position.values[:, 0, :2] for run in runs)
    assert np.ptp(ours, axis=0).min() > 5e-3
    np.testing.assert_allclose(ours, theirs, atol=3e-5)
    assert runs[1].attrs["solver_steps"] < 20_000


@pytest.mark.parametrize("normal", [LOOP, hs.NormalCurve(LOOP.compression, LOOP.force)])
def test_a_point_that_goes_over_the_edge_of_its_seat_does_not_come_back(normal):
    """The edge is located to a tolerance, at this speed from inside: by 1e-12 m the point is still
    over the seat, and pressed, when it is let go. Then it falls freely."""
    start = {"position": moving(heave=-0.04905), "velocity": moving(surge=2.1)}
    body = block(1e3, ("surge", "heave"), **start)
    seats = hs.Seats(np.zeros((1, 3)), extent=1.0)
    seat = hs.Landing("block", np.zeros((1, 3)), seats, normal, hs.Frictionless())
    forces = {"seat": seat, "weight": steady(heave=-9810.0)}
    run = hs.simulate(scene(body, forces, 0.7, 0.1, step=0.005))
    fall = 4.905 * np.maximum(run.time.values - 1.0 / 2.1, 0.0) ** 2
    np.testing.assert_allclose(run.position.values[:, 0, 2], -0.04905 - fall, atol=1e-9)
    assert run.attrs["solver_events"] < 5


def on_two_legs(ahead: float, behind: float, pitch: float, push: float, step: float) -> Scene:
    """A block on two legs with a loop each, and a push to and fro between them."""
    legs = np.array([[ahead, 0.0, 0.0], [behind, 0.0, 0.0]])
    elements = {
        "legs": hs.Landing("block", legs, hs.Seats(legs), LOOP, hs.Frictionless()),
        "weight": steady(heave=-9810.0),
        "push": hs.AppliedForce("block", (0.3, 0.0, 0.0), {"heave": Harmonic(push, 0.9)}),
    }
    body = block(1e3, ("heave", "pitch"), position=moving(heave=-0.02, pitch=pitch))
    return scene(body, elements, 10.0, 0.4, step=step, method=Method.RK4)


@pytest.mark.parametrize(
    ("legs", "pitch", "push", "step"),
    [((3.0, -1.5), 0.006, 8e3, 0.1), ((2.0, -2.0), 0.003, 8e3, 0.2)],
)
def test_legs_that_turn_at_one_time_do_not_end_the_lines_of_each_other(legs, pitch, push, step):
    """One leg turns while the stiff line of the other has just begun: that one goes on. Steps are
    far too large for the lines, which take a hundredth of a step."""
    run = hs.simulate(on_two_legs(*legs, pitch, push, step))
    assert run.attrs["status"] == "complete"
    assert np.abs(run.position.values).max() < 10.0


# Random scenes of contact: what must hold in all of them.

MASS, WEIGHT, DURATION = 1e4, 9.81e4, 3.0
FINENESS = 0.2  # of the step times the fastest rate in the scene
CLOSED = (
    6e-5  # of the ledger: RK4 loses (h w)^4 / 72, 2e-5 of the energy of the fastest oscillation
)
# per radian, and a contact has about three
FREE = (DOFS, ("surge", "heave"), ("surge", "sway", "heave"), ("surge", "heave", "pitch"))


def between(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_subnormal=False)


@st.composite
def stick_slips(draw: Any, stiffness: float) -> hs.StickSlip:
    """Light to heavy damping, with or without slip damping, static friction as kinetic or more."""
    static = draw(between(0.05, 1.0))
    kinetic = static * draw(st.sampled_from([1.0, 0.8, 0.5, 0.2]))
    K2 = stiffness * draw(between(0.3, 3.0))
    C2 = draw(st.sampled_from([0.0, 0.05, 0.3])) * np.sqrt(K2 * MASS)
    C3 = draw(st.sampled_from([0.0, 0.1, 0.5] if C2 else [0.3])) * np.sqrt(K2 * MASS)
    return hs.StickSlip(static, kinetic, K2, C2, C3)


def law_of(friction: hs.StickSlip, kind: int) -> hs.StickSlip | hs.FrictionSlope | hs.Frictionless:
    if kind == 0:
        return hs.Frictionless()
    if kind == 1:
        return hs.FrictionSlope(friction.kinetic, 0.5 * np.sqrt(friction.stiffness * MASS))
    return friction


@st.composite
def scenes(draw: Any) -> hs.Scene:
    """A block of one to four fenders on a slope, with or without a corner in its curve."""
    count, k = draw(st.integers(1, 4)), MASS * 10 ** draw(between(1.5, 3.0))
    friction = draw(stick_slips(k))
    steeper = draw(st.sampled_from([1.0, 3.0]))
    force = 0.05 * k / count * np.array([0.0, 1.0, 1.0 + steeper])
    damping = draw(st.sampled_from([0.0, 0.2])) * np.sqrt(k * MASS) / count
    curve = hs.NormalCurve(np.array([0.0, 0.05, 0.1]), force, damping)
    places = np.array(draw(st.lists(between(-1.5, 1.5), min_size=2 * count, max_size=2 * count)))
    points = np.column_stack([places.reshape(count, 2), np.full(count, -1.0)])
    slope = (draw(between(-0.2, 0.2)), draw(between(-0.2, 0.2)), 1.0)
    pushes = draw(st.lists(between(-0.8, 0.8), min_size=12, max_size=12))
    force = np.zeros((6, 6))
    force[:, :2], force[:, 2] = WEIGHT * np.reshape(pushes, (6, 2)), -WEIGHT
    velocity = draw(st.lists(between(-1.0, 1.0), min_size=6, max_size=6))
    dofs, height = draw(st.sampled_from(FREE)), draw(between(0.95, 1.5))
    launch = tuple(np.array(velocity) * [2, 2, 2, 0.3, 0.3, 0.3])
    body = block(MASS, dofs, centre_of_gravity=(0.0, 0.0, height), velocity=launch)
    law = law_of(friction, draw(st.integers(0, 3)))
    times = np.linspace(0.0, DURATION, 6)
    springs = hs.LinearMooring("block", MASS * np.diag([1.0, 1.0, 0.0, 40.0, 40.0, 10.0]))
    plane = hs.Plane((0.0, 0.0, 0.0), slope)
    fender = hs.Fender("block", points, plane, curve, _shared(law, count))
    push = central_force(**table(times, force))
    forces = {"push": push, "mooring": springs, "fender": fender}
    rate = np.sqrt(4.0 * max(steeper * k, friction.stiffness) / MASS)
    node = friction.stiffness / (friction.damping + friction.slip_damping)
    relaxing = friction.stiffness / friction.damping if friction.damping else 0.0
    step = FINENESS / max(rate, node, relaxing)
    every = max(round(0.02 / step), 1)
    steps = every * round(DURATION / (every * step))
    return scene(body, forces, steps * step, every * step, step=step)


def _shared(law: Any, count: int) -> Any:
    """The law of one of ``count`` points that have a total."""
    if isinstance(law, hs.StickSlip):
        parts = (law.stiffness / count, law.damping / count, law.slip_damping / count)
        return hs.StickSlip(law.static, law.kinetic, *parts)
    return hs.FrictionSlope(law.coefficient, law.slope / count) if law != hs.Frictionless() else law


@settings(max_examples=30, derandomize=True)
@given(scenes())
def test_what_holds_in_some_scenes_of_contact(scene: hs.Scene) -> None:
    check(scene)


@pytest.mark.slow
@settings(max_examples=200, derandomize=True)
@given(scenes())
def test_what_holds_in_every_scene_of_contact(scene: hs.Scene) -> None:
    check(scene)


def check(scene: hs.Scene) -> None:
    """What holds in a run of the scene."""
    run = hs.simulate(scene)
    assert run.status == "complete"
    assert all(np.isfinite(variable).all() for variable in run.data_vars.values())

    law = scene.forces["fender"].friction
    mode, N = run.fender_mode.values, run.fender_normal_force.values
    friction = run.fender_friction.values
    size = np.linalg.norm(friction, axis=2)
    tiny = 1e-9 * max(N.max(), 1.0)
    assert np.all(N >= -tiny)
    assert np.all(N[mode == OPEN] == 0.0)
    assert np.all(size[mode == OPEN] == 0.0)
    assert np.all(np.abs(friction @ _normal(scene)) <= tiny + 1e-12 * size.max())
    if isinstance(law, hs.StickSlip):
        assert np.all(size[mode == STICK] <= law.static * N[mode == STICK] + tiny)
        assert np.all(size[mode == SLIP] >= law.kinetic * N[mode == SLIP] - tiny)
    if isinstance(law, hs.FrictionSlope):
        assert np.all(size[mode == STICK] <= law.coefficient * N[mode == STICK] + tiny)
        np.testing.assert_allclose(size[mode == SLIP], law.coefficient * N[mode == SLIP], atol=tiny)

    slipped = run.fender_slip_distance.values
    assert np.all(np.diff(slipped, axis=0) >= -1e-15 * max(slipped.max(), 1.0))
    lost = run.fender_dissipated.values
    rounding = 1e-12 * max(lost.max(), 1.0)
    assert np.all(np.diff(lost, axis=0) >= -rounding)
    assert np.all(run.energy_dissipated_fender >= -rounding)
    assert run.energy_residual_relative <= CLOSED
    # a point has some events per oscillation (at most 18 per second were seen), not per step
    assert run.solver_events <= 40 * len(scene.forces["fender"].points) * DURATION


def _normal(scene: hs.Scene) -> np.ndarray:
    n = np.array(scene.forces["fender"].plane.normal)
    return n / np.linalg.norm(n)
