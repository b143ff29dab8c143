"""Landings: loops of loading and unloading, what is lost in them, where a weight may rest."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from modes_apart import Event, integrate
from scenes import (
    assert_continues,
    block,
    central_force,
    heave,
    mooring,
    moving,
    observed_orders,
    scene,
    steady,
    straight_curve,
    with_step,
)
from scipy.linalg import expm

import hydrosim as hs
from hydrosim.elements import Harmonic
from hydrosim.elements.contact import curves, fender
from hydrosim.elements.contact.law import OPEN
from hydrosim.errors import InputError
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Active, ForceElement, Method, Scene, Symmetry, When

X, LOADING, UNLOADING = np.array([0.0, 0.1, 0.2]), (0.0, 2e4, 6e4), (0.0, 5e3, 6e4)
LOOP = hs.NormalLoop(X, np.array(LOADING), X, np.array(UNLOADING), 2e6)
MASS, WEIGHT = 1e3, 9810.0


def leg(normal: hs.NormalCurve | hs.NormalLoop = LOOP, **changes: Any) -> hs.Landing:
    seats = {key: changes.pop(key) for key in ("axis", "body", "extent") if key in changes}
    points, on = (changes.pop(key, np.zeros((1, 3))) for key in ("points", "seats"))
    landing = hs.Landing("block", points, hs.Seats(on, **seats), normal, hs.Frictionless())
    return replace(landing, **changes)


def dropped(duration: float = 3.0, step: float = 0.005, **forces: ForceElement) -> Scene:
    """A block that falls on a landing from 0.3 m."""
    body = block(MASS, ("heave",), position=moving(heave=0.3))
    forces = {"leg": leg(), "weight": steady(heave=-WEIGHT), **forces}
    return scene(body, forces, duration, 0.05, step=step)


PIECES = {  # of the curve: a place, the force there, the slope; they go on beyond their ends
    "open": (0.0, 0.0, 0.0),
    "load 1": (0.0, 0.0, 2e5),
    "load 2": (0.1, 2e4, 4e5),
    "back 1": (0.0, 0.0, 5e4),
    "back 2": (0.1, 5e3, 5.5e5),
}


def fall_exactly(times: np.ndarray) -> tuple[np.ndarray, int]:
    """Heave of the dropped mass at ``times``, piece by piece, and the number of events."""

    def N(x: float, mode: tuple[str, float]) -> float:
        at, force, slope = (mode[1], 0.0, 2e6) if mode[0] == "between" else PIECES[mode[0]]
        return force + slope * (x - at)

    def rates(t: float, z: np.ndarray, mode: tuple[str, float]) -> list[float]:
        return [z[1], (N(-z[0], mode) - WEIGHT) / MASS]

    def ends(mode: tuple[str, float]) -> list[Event]:
        piece, start = mode

        def turn(t: float, z: np.ndarray) -> tuple[str, float]:
            z[1] = 0.0
            return "between", -z[0] - N(-z[0], mode) / 2e6

        def to(place: float, piece: str, way: float) -> Event:
            return (lambda t, z, *_: way * (place + z[0])), (piece, 0.0)

        def meet(side: str, way: float) -> Event:
            """Where the stiff line meets a branch."""
            lines = [PIECES[f"{side} {k}"] for k in (1, 2)]
            low, high = ((2e6 * start + f - k * at) / (2e6 - k) for at, f, k in lines)
            return to(low, f"{side} 1", way) if low < 0.1 else to(high, f"{side} 2", way)

        deepest, highest = (lambda t, z, *_: -z[1], turn), (lambda t, z, *_: z[1], turn)
        return {
            "open": [to(0.0, "load 1", 1.0)],
            "load 1": [to(0.1, "load 2", 1.0), deepest],
            "load 2": [deepest],
            "back 2": [to(0.1, "back 1", -1.0), highest],
            "back 1": [to(0.0, "open", -1.0), highest],
            "between": [meet("load", 1.0), meet("back", -1.0)],
        }[piece]

    found = integrate(rates, ends, ("open", 0.0), [0.3, 0.0], times, atol=1e-15)
    return found.states[:, 0], len(found.events)


def test_a_mass_on_a_landing_is_that_of_dop853_at_order_4(validated):
    times = np.arange(0.0, 3.0001, 0.05)
    expected, events = fall_exactly(times)
    steps = np.array([0.01, 0.005, 0.0025])
    runs = [hs.simulate(with_step(dropped(), step)) for step in steps]
    errors = np.array([np.abs(heave(run) - expected).max() for run in runs])
    assert np.all(observed_orders(steps, errors) > 3.8)
    assert {run.attrs["solver_events"] for run in runs} == {events}
    fine = hs.simulate(with_step(dropped(), 5e-4))
    error = np.abs(heave(fine) - expected).max()
    claim = "mass that falls on a landing with a loop, 3 s [m]"
    validated(Kind.INDEPENDENT, claim, "DOP853, piece by piece", error, 1e-9, Feature.LANDINGS)
    assert fine.attrs["energy_residual_relative"] < 1e-9


@pytest.mark.parametrize("method", [Method.RK2, Method.HEUN, Method.DOPRI5, Method.ESDIRK4])
def test_every_method_finds_the_same(method):
    times = np.arange(0.0, 3.0001, 0.05)
    expected, _ = fall_exactly(times)
    run = hs.simulate(with_step(dropped(), 1e-3, method=method))
    assert np.abs(heave(run) - expected).max() < (1e-4 if "rk2 heun".find(method) >= 0 else 1e-6)


def test_the_loss_is_the_area_of_the_loop():
    """One fall to the turning point and back: between loading and unloading, by the corners."""
    run = hs.simulate(dropped(0.6, 1e-3))
    deepest = run.fender_compression.values.max()
    lost = run.fender_dissipated.values[-1, 0]
    fall = WEIGHT * 0.3 + WEIGHT * -heave(run)
    assert run.fender_mode.values[-1, 0] == OPEN
    assert lost > 0.3 * fall.max()
    top = float(-solve_top(run))
    assert top == pytest.approx(deepest, rel=1e-2)
    assert lost == pytest.approx(area(top), rel=1e-9)  # the place where it turns is the method's
    turned = 0.1 + (run.fender_largest_force.values[-1, 0] - 2e4) / 4e5
    assert lost == pytest.approx(area(turned), rel=1e-12)


@pytest.mark.parametrize("top", [0.12, 0.145, 0.165])
def test_a_quasi_static_loop_loses_its_area(top):
    """Pressed to ``top`` and let go, by the law alone: the area between the branches is booked."""
    point, segments = point_of(LOOP)
    f, line, back = (0, 1), point.line, (point.last + 1, point.back)
    at = curves.find_segment(*f, segments, top)
    N = curves.curve_force(segments[at], top)
    start = curves.reload_start(N, top, point, segments)
    lost = curves.branch_loss(at, top, point, segments) - curves.branch_loss(
        0, 0.0, point, segments
    )
    low, high = curves.reload_ends(start, point, segments)
    assert high == pytest.approx(top, rel=1e-14)
    unloading = curves.curve_force(segments[curves.find_segment(*back, segments, low)], low)
    assert segments[line].slope * (low - start) == pytest.approx(unloading, rel=1e-12)
    assert lost == pytest.approx(area(top), rel=1e-12)
    # a second loop inside the first: back on the line, to f again, on to another top
    higher = top + 0.03
    k = curves.find_segment(*f, segments, higher)
    again = curves.branch_loss(k, higher, point, segments) - curves.branch_loss(
        at, top, point, segments
    )
    assert lost + again == pytest.approx(area(higher), rel=1e-12)


def point_of(normal: hs.NormalLoop) -> tuple[np.record, np.recarray]:
    """A contact point with this curve, and its pieces, as kernels see them."""
    elements = hs.compile_scene(dropped(leg=leg(normal))).model.elements.fenders
    points, segments = (a.view(np.recarray) for a in (elements.points, elements.segments))
    return points[0], segments


def solve_top(run: object) -> float:
    """The lowest point, where the fall is what the loading branch has taken, by Newton's method."""
    x = 0.1
    for _ in range(50):
        taken = 1e3 + 2e4 * (x - 0.1) + 2e5 * (x - 0.1) ** 2
        x -= (taken - WEIGHT * (0.3 + x)) / (2e4 + 4e5 * (x - 0.1) - WEIGHT)
    return -x


def area(top: float) -> float:
    """Of the loop that turns at ``top``, in its second piece, by the shoelace formula."""
    high = 2e4 + 4e5 * (top - 0.1)
    start = top - high / 2e6
    low = (2e6 * start + 5e3 - 5.5e5 * 0.1) / (2e6 - 5.5e5)
    corners = [(0, 0), (0.1, 2e4), (top, high), (low, 2e6 * (low - start)), (0.1, 5e3)]
    x, N = np.array(corners).T
    return 0.5 * abs(float(x @ np.roll(N, -1) - N @ np.roll(x, -1)))


LAWS = {
    "none": hs.Frictionless(),
    "stick-slip": hs.StickSlip(0.3, 0.2, 1e6, 2e3),
    "rate-free": hs.StickSlip(0.3, 0.2, 1e6, 0.0),
    "coulomb": hs.Coulomb(0.3, 0.2),
    "slope": hs.FrictionSlope(0.25, 1e5),
}


@pytest.mark.parametrize("law", LAWS)
def test_every_law_of_friction_acts_on_a_landing_and_the_ledger_closes(law):
    """A block that comes down obliquely, bounces, slides and comes to rest."""
    body = block(MASS, ("surge", "heave"), position=moving(heave=0.1), velocity=moving(surge=0.5))
    forces = {"leg": leg(friction=LAWS[law]), "weight": steady(heave=-WEIGHT)}
    rough = scene(body, forces, 4.0, 0.02, step=1e-3)
    run = hs.simulate(rough)
    assert run.attrs["energy_residual_relative"] < 1e-6
    assert np.all(np.diff(run.fender_dissipated.values[:, 0]) > -1e-9)
    moved = run.position.values[-1, 0, 0]
    assert moved > 0.0
    if law != "none":
        place = run.position.values[:, 0, 0]  # without dampers a node rings about where it sticks
        assert abs(place[-50:].mean() - place[-100:-50].mean()) < 2e-3
        force, N = run.fender_friction.values[:, 0, 0], run.fender_normal_force.values[:, 0]
        assert np.all(np.abs(force) <= (0.3 * N + 2e3) * (1 + 1e-9))


@pytest.mark.parametrize("law", LAWS)
def test_a_horizontal_landing_is_a_vertical_one_that_is_turned(law):
    """About y by a quarter turn: what was up is ahead, what was ahead is down."""
    dofs = ("surge", "heave")
    up = block(MASS, dofs, position=moving(heave=0.1), velocity=moving(surge=0.5))
    ahead = block(MASS, dofs, position=moving(surge=0.1), velocity=moving(heave=-0.5))
    legs = leg(friction=LAWS[law]), leg(friction=LAWS[law], axis=(1.0, 0.0, 0.0))
    pulls = steady(heave=-WEIGHT), steady(surge=-WEIGHT)
    runs = []
    for body, foot, pull in zip((up, ahead), legs, pulls, strict=True):
        runs.append(hs.simulate(scene(body, {"leg": foot, "pull": pull}, 1.0, 0.02, step=1e-3)))
    vertical, horizontal = (run.position.values[:, 0] for run in runs)
    assert horizontal[:, 0] == pytest.approx(vertical[:, 2], abs=1e-9)
    assert -horizontal[:, 2] == pytest.approx(vertical[:, 0], abs=1e-9)
    assert runs[0].fender_dissipated.values[-1, 0] > 1.0
    assert runs[0].solver_events == runs[1].solver_events


def test_an_impact_oscillator_is_that_of_the_matrix_exponential_over_100_impacts(validated):
    """A damped oscillator that is driven against an elastic landing: period one, stable; each piece
    is linear and known, and so are the times of its events, by Newton's method."""
    m, k, c, kc, F, w, gap = 1e3, 4e4, 400.0, 4e6, 4e3, 7.5, 0.02
    force = {"heave": Harmonic(-F, 2 * np.pi / w, phase=0.5 * np.pi)}
    seat = np.array([[0.0, 0.0, -gap]])
    forces = {
        "leg": leg(straight_curve(kc), seats=seat),
        "spring": hs.LinearMooring("block", k * np.eye(6), c * np.eye(6)),
        "drive": central_force(**force),
    }
    period = 2 * np.pi / w
    duration = 101 * period
    driven = scene(block(m, ("heave",)), forces, duration, period / 20, step=period / 2000)
    run = hs.simulate(driven)
    closings = run.fender_closings.values[-1, 0]
    assert closings >= 100

    # z = (x, x', cos wt, sin wt, 1): each piece is z' = A z
    def matrix(stiff: float) -> np.ndarray:
        A = np.zeros((5, 5))
        A[0, 1] = 1.0
        A[1] = [-(k + stiff) / m, -c / m, -F / m, 0.0, -stiff * gap / m]
        A[2, 3], A[3, 2] = -w, w
        return A

    open_, closed = matrix(0.0), matrix(kc)
    z, t, times = np.array([0.0, 0.0, 1.0, 0.0, 1.0]), 0.0, run.time.values
    expected, hits, k_out, touching = np.zeros(times.size), 0, 0, False
    dt = period / 400
    while k_out < times.size:
        A = closed if touching else open_
        after = expm(A * dt) @ z
        inside = (after[0] + gap < 0) != touching
        h = dt
        if inside:
            h = dt * (z[0] + gap) / (z[0] - after[0])
            for _ in range(30):
                at = expm(A * h) @ z
                h -= (at[0] + gap) / at[1]
        while k_out < times.size and times[k_out] <= t + h + 1e-12:
            expected[k_out] = (expm(A * (times[k_out] - t)) @ z)[0]
            k_out += 1
        z, t = expm(A * h) @ z, t + h
        if inside:
            touching, hits = not touching, hits + 1
    assert (hits + 1) // 2 == closings
    late = expected[-400:].reshape(-1, 20)  # periodic, stable: e^-14 of the transient is left
    assert np.ptp(late, axis=0).max() < 1e-5 * np.ptp(late)
    error = np.abs(heave(run) - expected).max()
    claim = "oscillator that strikes a landing 100 times [m]"
    against = "matrix exponentials between impacts"
    validated(Kind.CLOSED_FORM, claim, against, error, 1e-9, Feature.LANDINGS)


def pushed(amplitude: float, **changes: object) -> Scene:
    """A block that rests on a landing under its weight and is pushed up and down."""
    force = {"heave": Harmonic(amplitude, 2.0)}
    forces = {
        "leg": leg(),
        "weight": steady(heave=-WEIGHT),
        "push": central_force(**force),
        "damping": hs.LinearDamping("block", 5e3 * np.eye(6)),
    }
    body = block(MASS, ("heave",), position=moving(heave=-WEIGHT / 2e5))
    return scene(body, forces, 60.0, 0.05, step=0.005, **changes)


def test_a_weight_at_rest_makes_no_events():
    run = hs.simulate(pushed(0.0))
    assert run.attrs["solver_events"] == 0
    assert np.ptp(heave(run)) < 1e-13
    assert run.fender_normal_force.values == pytest.approx(WEIGHT, rel=1e-10)


def test_a_weight_on_a_landing_in_waves_smaller_than_the_loop_makes_no_events_for_long():
    """The first push down finds how far; from then on every place is on the stiff line."""
    run = hs.simulate(pushed(2e3))
    early = hs.simulate(replace(pushed(2e3), duration=4.0))
    assert run.attrs["solver_events"] == early.attrs["solver_events"] <= 4
    late = run.sel(time=slice(40.0, None))
    force, x = late.fender_normal_force.values[:, 0], late.fender_compression.values[:, 0]
    slope, _ = np.polyfit(x, force, 1)
    assert slope == pytest.approx(2e6, rel=1e-6)
    assert np.ptp(late.fender_dissipated.values) == 0.0


def test_a_restart_in_the_midst_of_a_loop_is_the_run_to_the_bit(tmp_path):
    whole = dropped(2.0).with_output(states=True)
    names = ("position", "fender_normal_force", "fender_dissipated", "fender_closings")
    pressed, between, flying, later = 0.35, 0.4, 1.0, 1.3
    assert_continues(whole, hs.simulate(whole), (pressed, between, flying, later), *names)


def two_legs(y: tuple[float, float], **position: float) -> Scene:
    """A body that may roll, on a leg at each side."""
    dofs, inertia = ("sway", "heave", "roll"), MASS * np.eye(3)
    body = block(MASS, dofs, inertia=inertia, position=moving(**position))
    places = np.array([[0.0, y[0], 0.0], [0.0, y[1], 0.0]])
    sway = mooring(sway=1e4, roll=1e4)
    legs = leg(points=places, seats=places)
    forces = {"legs": legs, "weight": steady(heave=-WEIGHT), "sway": sway}
    return scene(body, forces, 2.0, 0.05, step=0.005)


def test_symmetry_sees_legs_and_what_they_remember():
    """It comes down in its plane as in all degrees of freedom, unless one leg starts deeper."""
    scenes = two_legs((2.0, -2.0), heave=0.1), two_legs((2.0, -1.9), heave=0.1)
    fell, beside = (hs.simulate(scene) for scene in scenes)
    free = hs.simulate(with_step(scenes[0], 0.005, symmetry=Symmetry.IGNORE))
    assert "zero_by_symmetry" in fell.attrs
    assert "zero_by_symmetry" not in beside.attrs
    assert np.abs(fell.position.values - free.position.values).max() < 1e-12
    model, state = hs.compile_scene(two_legs((2.0, -2.0), heave=-0.05))
    fenders = model.elements.fenders
    assert fender.is_mirrored(fenders, state.y, state.modes)
    fender.memory_states(fenders, state.y)[0, curves.BRANCH_START] += 1e-3
    assert not fender.is_mirrored(fenders, state.y, state.modes)


DECK = ((-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0))


def on_deck(law: object, edge: tuple[tuple[float, ...], ...] = DECK) -> hs.Fender:
    curve = straight_curve(1e6)
    plane = hs.Plane((0, 0, 0), (0, 0, 1), None, edge)
    return hs.Fender("block", np.zeros((1, 3)), plane, curve, law)


def sliding(step: float = 0.001, **velocity: float) -> Scene:
    """A block that slides over a deck to its edge, pressed by its weight, and falls."""
    foot = on_deck(hs.StickSlip(0.1, 0.05, 1e6, 2e3))
    forces = {"deck": foot, "weight": steady(heave=-WEIGHT)}
    start = moving(heave=-WEIGHT / 1e6)
    body = block(MASS, ("surge", "sway", "heave"), position=start, velocity=moving(**velocity))
    return scene(body, forces, 1.6, 0.02, step=step)


def test_a_block_leaves_a_deck_at_its_edge_and_what_was_stored_is_booked():
    run = hs.simulate(sliding(surge=1.5, sway=0.4))
    speed, g = np.hypot(1.5, 0.4), 9.81
    path = speed / 1.5  # the edge is where x = 1
    left = run.time.values[np.flatnonzero(run.fender_mode.values[:, 0] == OPEN)[0]]
    slow = 0.05 * g
    reached = (speed - np.sqrt(speed**2 - 2 * slow * path)) / slow
    assert left == pytest.approx(reached, abs=0.03)
    assert run.attrs["energy_residual_relative"] < 1e-6
    stored = 0.5 * WEIGHT**2 / 1e6
    lost = run.fender_dissipated.values[:, 0]
    over = int(np.flatnonzero(run.fender_mode.values[:, 0] == OPEN)[0])
    assert lost[over] - lost[over - 1] > stored
    assert run.fender_normal_force.values[over:].max() == 0.0  # it stays out, past the deck


def test_what_comes_up_beside_a_deck_does_not_touch_it():
    """Thrown up from below, beside the edge, in over it and down: it lands."""
    start = {"position": moving(surge=1.5, heave=-0.5), "velocity": moving(surge=-0.8, heave=5.0)}
    body = block(MASS, ("surge", "heave"), **start)
    below = sliding()
    up = hs.simulate(replace(below, bodies=(body,)))
    first = int(np.flatnonzero(up.fender_mode.values[:, 0] != OPEN)[0])
    assert up.time.values[first] == pytest.approx(0.9, abs=0.03)  # h + 5 t - g t^2 / 2 = 0, falling
    assert up.attrs["energy_residual_relative"] < 1e-5
    under = replace(body, velocity=moving(surge=-0.8, heave=0.0))
    passed = hs.simulate(replace(below, bodies=(under,)))
    assert passed.fender_normal_force.values.max() == 0.0


@pytest.mark.parametrize(
    ("element", "found"),
    [
        (leg(replace(LOOP, unloading_force=np.array([0.0, 2.1e4, 6e4]))), "at most that;"),
        (leg(replace(LOOP, stiffness=4e5)), "found 400000 N/m, and slopes up to 550000"),
        (on_deck(hs.Frictionless(), (*DECK, (-0.5, 0.0, 0.0))), "no convex polygon"),
    ],
)
def test_what_is_no_loop_and_no_polygon_is_refused(element, found):
    with pytest.raises(InputError, match=found):
        hs.simulate(dropped(leg=element))


def beside(off: float, fall: float = 0.6, **changes: object) -> Scene:
    """A block that falls past a seat, ``off`` [m] beside it, on a second one 1 m below."""
    body = block(MASS, ("surge", "heave"), position=moving(surge=off, heave=0.3))
    floor = leg(seats=np.array([[0.0, 0.0, -fall]]), extent=1e3)
    forces = {"leg": leg(**changes), "floor": floor, "weight": steady(heave=-WEIGHT)}
    return scene(body, forces, 2.0, 0.02, step=0.005)


@pytest.mark.parametrize(
    ("off", "changes", "carried"),
    [
        (1.9, {}, True),
        (3.0, {}, False),
        (-12.0, {}, False),
        (3.0, {"extent": 3.5}, True),
        (0.4, {"extent": 0.3}, False),
    ],
)
def test_a_seat_carries_as_far_as_it_reaches(off, changes, carried):
    run = hs.simulate(beside(off, **changes))
    pressed = run.fender_normal_force.sel(fender="leg 1")
    assert (float(pressed.max()) > WEIGHT) == carried
    told = f"was below its seat and {abs(off):.3g} m beside it"
    assert (told in str(run.attrs.get("warnings", ""))) == (not carried)
    assert carried or float(run.fender_compression.sel(fender="leg 1").max()) == 0.0


def test_a_block_that_begins_to_touch_its_seat_is_not_beside_it() -> None:
    """It starts at the very place of contact."""
    body = block(MASS, ("heave",), velocity=moving(heave=1.0))
    run = hs.simulate(scene(body, {"leg": leg(), "weight": steady(heave=-WEIGHT)}, 2.0, 0.02))
    assert float(run.fender_normal_force.max()) > WEIGHT
    assert "beside it" not in str(run.attrs.get("warnings", ""))


def test_a_block_beside_a_seat_falls_as_if_there_were_none() -> None:
    """0.3 + 0.6 m of free fall."""
    run = hs.simulate(beside(3.0))
    falling = run.sel(time=slice(0.0, np.sqrt(2.0 * 0.9 / 9.81)))
    assert heave(falling) == pytest.approx(0.3 - 4.905 * falling.time.values**2, abs=1e-9)


def test_a_block_that_slides_off_its_seat_falls_at_its_edge() -> None:
    """Without friction it goes on at its speed: 1 m at 2 m/s, from the start at the middle."""
    start = {"position": moving(heave=-WEIGHT / 2e5), "velocity": moving(surge=2.0)}
    body = block(MASS, ("surge", "heave"), **start)
    curve = straight_curve(2e5)
    forces = {"leg": leg(curve, extent=1.0), "weight": steady(heave=-WEIGHT)}
    run = hs.simulate(scene(body, forces, 1.0, 0.01, step=0.005))
    t = run.time.values
    fall = np.where(t > 0.5, 4.905 * (t - 0.5) ** 2, 0.0)
    assert heave(run) == pytest.approx(-WEIGHT / 2e5 - fall, abs=1e-7)


def test_the_seat_of_a_body_goes_with_it() -> None:
    """Seats and points 5 m off in the earth frame, and over each other on the bodies."""
    below = block(10 * MASS, (), "below", position=moving(surge=5.0))
    above = block(MASS, ("heave",), position=moving(surge=5.0, heave=0.3))
    both = {"leg": leg(body="below"), "weight": steady(heave=-WEIGHT)}
    run = hs.simulate(replace(scene(above, both, 2.0, 0.05, step=0.005), bodies=(above, below)))
    assert float(run.fender_normal_force.max()) > WEIGHT


def test_nothing_is_compressed_before_a_contact_is_active() -> None:
    """A block held 0.1 m deep in a seat that acts from 1 s on."""
    late = replace(leg(), active=Active(start=When(1.0)))
    body = block(MASS, ("heave",), position=moving(heave=-0.1), velocity=moving(heave=-1e-3))
    run = hs.simulate(scene(body, {"leg": late}, 1.5, 0.1, step=0.005))
    deep = run.fender_compression.isel(fender=0)
    assert np.all(deep.sel(time=slice(0.0, 0.9)) == 0.0)
    assert np.allclose(deep[11:], -heave(run)[11:], rtol=0.0, atol=1e-12)
