"""Catenaries on bodies: against independent equations, energy, invariance, restarts, events."""

from collections.abc import Sequence
from dataclasses import replace
from math import asinh, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scenes import (
    ROOT,
    assert_continues,
    block,
    catenary_of,
    mooring,
    moving,
    observed_orders,
    scene,
    turned_scene,
    with_step,
)
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.optimize import fsolve

import hydrosim as hs
from hydrosim.dofs import about_z
from hydrosim.elements import Catenary, Drive, Harmonic, Table
from hydrosim.elements.line.kind import drag_points, linearise_random
from hydrosim.errors import InputError
from hydrosim.linear.linearise import linearise
from hydrosim.linear.modes import natural_modes
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Active, Environment, Kinematics, Method, Scene, Start, When

DEPTH = 50.0
WATER = Environment(water_depth=DEPTH)
AFLOAT = mooring(heave=4e5, roll=4e7, pitch=4e7)


def line(
    point: Sequence[float],
    anchor: Sequence[float],
    length: Sequence[float],
    weight: Sequence[float],
    stiffness: Sequence[float],
    hung: Sequence[float] | None = None,
    friction: float | None = 0.0,
    **more: Any,
) -> Catenary:
    """A catenary from the block, without drag."""
    columns = (length, weight, stiffness, hung or 0.0)
    return catenary_of("block", point, anchor, *columns, friction=friction, **more)


def lines(friction: float = 0.0) -> dict[str, Catenary]:
    """Three lines, the first of two segments with a clump between them."""
    two = ((58.0, 56.0), (1200.0, 800.0), (3e7, 2e7), (2e4, 0.0), friction)
    one = ((100.0,), (1e3,), (4e7,), (0.0,), friction)
    return {
        "ahead": line((10.0, 1.0, -2.0), (110.0, 0.0, -DEPTH), *two),
        "astern": line((-10.0, 1.0, -2.0), (-100.0, 20.0, -DEPTH), *one),
        "abeam": line((0.0, -5.0, -2.0), (0.0, -90.0, -DEPTH), *one),
    }


def moored(
    friction: float = 0.0, step: float = 0.1, duration: float = 10.0, **solver: Any
) -> Scene:
    """The block on three lines, thrown so that touch-downs pass the clump and the anchors."""
    speed = moving(surge=1.5, sway=0.5, heave=1.0, pitch=0.02)
    thrown = block(4e5, position=moving(heave=-5.0), velocity=speed)
    forces = {"afloat": AFLOAT, **lines(friction)}
    found = scene(thrown, forces, duration, 0.2, method=Method.RK4, step=step, **solver)
    return replace(found, environment=WATER)


def test_tension_converges_at_the_order_of_the_method_through_kinks() -> None:
    """Touch-downs pass a clump and anchors, and friction of the bed is exhausted and comes back."""
    steps = [0.1, 0.05, 0.02]
    for friction in (0.0, 0.6):
        exact = hs.simulate(moored(friction, 0.0025)).line_tension.values
        runs = [hs.simulate(moored(friction, step)) for step in steps]
        errors = np.array([np.abs(run.line_tension.values - exact).max() for run in runs])
        grounded = runs[-1].line_grounded
        assert (grounded.min("time") == 0.0).all()
        assert (grounded.max("time") > 10.0).all()
        assert runs[-1].attrs["solver_steps"] == round(10.0 / steps[-1])  # no kink cuts a step
        assert observed_orders(steps, errors).min() > 3.6
        assert errors[-1] < 1e-5 * exact.max()


def test_ledger_of_a_free_body_on_lines() -> None:
    """Without friction the lines have a potential; with it their work is their loss."""
    for friction in (0.0, 0.6):
        run = hs.simulate(moored(friction, 0.005))
        turned_over = float(run.energy_kinetic.max())
        assert np.abs(run.energy_residual).max() < 1e-9 * turned_over
        loss = np.abs(run.energy_dissipated_astern.values).max()
        stored = bool(run.energy_stored_astern.any())
        assert stored == (friction == 0.0)
        assert (loss == 0.0) == (friction == 0.0)


def jonkman(H: float, V: float, L: float, w: float, EA: float, CB: float) -> tuple[float, float]:
    """Span and height of an elastic line that lies on the bed (Jonkman 2007, eqs. 2-37, 2-38)."""
    LB = L - V / w
    x = LB + H / w * asinh(V / H) + H * L / EA
    if CB > 0.0:
        x += CB * w / (2 * EA) * (-LB * LB + (LB - H / (CB * w)) * max(LB - H / (CB * w), 0.0))
    return x, H / w * (sqrt(1.0 + (V / H) ** 2) - 1.0) + V * V / (2.0 * EA * w)


def solve_jonkman(
    span: float, height: float, *pars: Any, xtol: float = 1e-13
) -> tuple[float, float]:
    """H and V at the end of a line; ``pars`` are those of `jonkman`, and a guess."""
    *line_pars, guess = pars
    found = fsolve(lambda p: np.subtract(jonkman(*p, *line_pars), (span, height)), guess, xtol=xtol)
    return found[0], found[1]


def test_motion_against_independent_equations(validated) -> None:
    """A body in surge, heave and pitch on two lines, integrated by DOP853 with its own lines."""
    ends = {"ahead": ((10.0, 0.0, -2.0), 110.0), "astern": ((-10.0, 0.0, -1.0), -105.0)}
    L, w, EA, CB = 118.0, 1000.0, 4e7, 0.4
    forces = {}
    for name, (point, anchor) in ends.items():
        forces[name] = line(point, (anchor, 0.0, -DEPTH), (L,), (w,), (EA,), friction=CB)
    start = [1.0, 0.0, 0.0, 0.8, 0.3, 0.03]
    at = {"position": moving(surge=1.0), "velocity": moving(surge=0.8, heave=0.3, pitch=0.03)}
    body = block(4e5, ("surge", "heave", "pitch"), **at)
    hold = mooring(heave=4e5, pitch=4e7)
    whole = scene(body, {"hold": hold, **forces}, 10.0, 0.5, step=0.005, method=Method.RK4)
    run = hs.simulate(replace(whole, environment=WATER))
    guess = dict.fromkeys(ends, (4e4, 6e4))

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        x, z, a = y[:3]
        force = np.array([0.0, -4e5 * z, -4e7 * a])
        for name, ((px, _y, pz), anchor) in ends.items():
            rx, rz = px * np.cos(a) + pz * np.sin(a), -px * np.sin(a) + pz * np.cos(a)
            span, height = abs(anchor - x - rx), DEPTH + z + rz
            H, V = solve_jonkman(span, height, L, w, EA, CB, guess[name])
            guess[name] = (H, V)
            F = np.array([np.sign(anchor) * H, -V])
            force += [*F, rz * F[0] - rx * F[1]]
        return np.array([*y[3:], *(force / [4e5, 4e5, 4 * 4e5])])

    found = solve_ivp(rates, (0.0, 10.0), start, "DOP853", run.time.values, rtol=1e-11, atol=1e-12)
    mine = run.position.values[:, 0][:, [0, 2, 4]]
    error = np.abs(mine - found.y[:3].T).max()
    claim = "body on two catenaries with friction of the bed, in m and rad"
    validated(Kind.INDEPENDENT, claim, "DOP853", error, 1e-8, Feature.CATENARIES)


def test_a_restart_is_the_same_to_the_bit() -> None:
    case = moored(0.6, 0.1).with_output(states=True)
    names = ("position", "velocity", "line_tension", "line_grounded", "energy_dissipated_astern")
    assert_continues(case, hs.simulate(case), (5.0,), *names)


def test_lines_on_the_earth_turn_with_the_scene() -> None:
    here, R = moored(0.6, 0.1, 2.0), about_z(2.0)
    one, other = hs.simulate(here), hs.simulate(turned_scene(here, 2.0))
    assert np.abs(other.line_tension / one.line_tension - 1.0).max() < 1e-10
    moved = one.position.values[:, 0, :3] @ R.T
    assert np.abs(other.position.values[:, 0, :3] - moved).max() < 1e-10


def test_rest_is_where_a_root_finder_finds_it() -> None:
    """Surge and heave at which two lines of unequal length balance, from Jonkman's equations."""
    L = {"ahead": 118.0, "astern": 120.0}
    forces = {
        name: line((s * 10.0, 0.0, -2.0), (s * 110.0, 0.0, -DEPTH), (L[name],), (1e3,), (4e7,))
        for name, s in (("ahead", 1.0), ("astern", -1.0))
    }
    body = block(4e5, ("surge", "heave"))
    hold = mooring(heave=4e5)
    case = scene(body, {"hold": hold, **forces}, 0.1, 0.1)
    run = hs.simulate(replace(case, environment=WATER, at_rest=True))

    def off(u: np.ndarray) -> list[float]:
        x, z, H, V1, V2 = u * [1.0, 1.0, 1e4, 1e4, 1e4]
        V, height = np.array([V1, V2]), DEPTH - 2.0 + z
        tops = zip((H, H), (V1, V2), L.values(), strict=True)
        ends = [jonkman(*top, 1e3, 4e7, 0.0) for top in tops]
        spans = np.subtract(ends, [(100.0 - x, height), (100.0 + x, height)])
        return [*spans.ravel(), (V.sum() + 4e5 * z) / 1e4]

    x, z, H, V1, _ = fsolve(off, [0.0, -0.3, 4.0, 6.0, 6.0], xtol=1e-14)
    position = run.position.values[0, 0]
    assert position[[0, 2]] == pytest.approx([x, z], abs=1e-9)
    assert float(run.line_horizontal[0, 0]) == pytest.approx(1e4 * H, rel=1e-9)
    assert float(run.line_tension[0, 0]) == pytest.approx(1e4 * np.hypot(H, V1), rel=1e-9)


def between(duration: float, **changes: object) -> Scene:
    """Two blocks on one line that hangs between them."""
    apart = block(3e5, position=moving(surge=0.5), velocity=moving(surge=-0.6, sway=0.3))
    other = block(2e5, name="carrier", location=(60.0, 0.0), velocity=moving(sway=-0.4, yaw=0.01))
    pieces = ((30.0, 26.0), (300.0, 500.0), (2e7, 2e7), (5e3, 0.0))
    ends = {"friction": None, "anchor_body": "carrier", **changes}
    tow = line((5.0, 0.0, 1.0), (-5.0, 0.0, 2.0), *pieces, **ends)
    return scene((apart, other), {"tow": tow}, duration, 0.2, step=0.005, method=Method.RK4)


def test_two_bodies_on_one_line() -> None:
    """Momentum changes by the line's weight alone, and energy is conserved."""
    run = hs.simulate(between(6.0))
    mass = np.array([3e5, 2e5])
    momentum = np.einsum("b,tbi->ti", mass, run.velocity.values[:, :, :3])
    weight = 30.0 * 300.0 + 26.0 * 500.0 + 5e3
    expected = momentum[0] + np.outer(run.time.values, [0.0, 0.0, -weight])
    assert np.abs(momentum - expected).max() < 1e-8 * np.abs(momentum).max()
    assert np.abs(run.energy_residual).max() < 1e-9 * float(run.energy_kinetic.max())


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("CB", [0.0, 0.5])
def test_a_fairlead_on_a_circle(sense: float, CB: float, validated) -> None:
    """Two drives lead the fairlead once round a circle of 5 m in the plane of the line. Their
    forces are those of Jonkman's equations, and so is their work, by a quadrature. With friction of
    the bed a closed way takes work, of either sign by direction, and else none."""
    L, w, EA, radius, turn, mass = 850.0, 1200.0, 6e8, 5.0, 60.0, 1e4
    moor = line((0.0, 0.0, 0.0), (780.0, 0.0, -200.0), (L,), (w,), (EA,), friction=CB)
    rate = 2.0 * np.pi / turn
    along = Drive("block", dof="surge", offset=Harmonic(radius, turn, phase=np.pi / 2))
    up = Drive("block", dof="heave", offset=Harmonic(sense * radius, turn))
    forces = {"along": along, "up": up, "bow": moor}
    case = scene(block(mass, ("surge", "heave")), forces, turn, 0.15, method=Method.RK4)
    run = hs.simulate(replace(case, environment=Environment(water_depth=200.0)))
    pulls = []
    guess = (5e5, 3e5)
    path = radius * np.exp(1j * rate * run.time.values)  # x, and z in the sense
    for place in path:
        x, z = place.real, sense * place.imag
        guess = solve_jonkman(780.0 - x, 200.0 + z, L, w, EA, CB, guess, xtol=1e-11)
        pulls.append(guess)
    H, V = np.array(pulls).T
    along = [-mass * rate**2 * path.real - H, sense * -mass * rate**2 * path.imag + V]
    forces_along = np.array(along)
    found = run.drive_force.values.T
    error = np.abs(found - forces_along).max() / np.ptp(forces_along, axis=1).max()
    claim, against = "force of a fairlead that is led on a circle", "Jonkman's equations"
    features = (Feature.CATENARIES, Feature.DRIVES)
    validated(Kind.CLOSED_FORM, claim, against, error, 1e-6, *features)
    speed = 1j * rate * path
    power = -H * speed.real + V * sense * speed.imag
    work = CubicSpline(run.time.values, power).antiderivative()(run.time.values)
    booked = run.energy_work_along.values + run.energy_work_up.values
    error = np.abs(booked - work).max() / np.ptp(work)
    claim = "work of a fairlead that is led on a circle"
    against = "quadrature of Jonkman's equations"
    validated(Kind.CLOSED_FORM, claim, against, error, 1e-5, *features)
    assert abs(booked[-1]) > 300.0 if CB > 0.0 else abs(booked[-1]) < 1e-5 * np.ptp(work)
    assert float(run.energy_dissipated_bow[-1]) == pytest.approx(booked[-1], rel=1e-6, abs=1.0)


def test_a_line_that_is_paid_out() -> None:
    """The work of the pay-out closes the ledger, and the tension is that of the length."""
    paid = Table(np.array([0.0, 2.0, 5.0]), np.array([30.0, 30.0, 36.0]))
    run = hs.simulate(between(6.0, paid=paid))
    assert np.abs(run.energy_residual).max() < 1e-8 * float(run.energy_kinetic.max())
    length = np.interp(run.time.values[-1], paid.time, paid.value)
    still = between(0.2)
    tow = still.forces["tow"]
    bodies = [
        replace(body, position=tuple(run.position.values[-1, b]), velocity=(0.0,) * 6)
        for b, body in enumerate(still.bodies)
    ]
    paid_out = replace(tow.segments[0], length=length)
    tow = replace(tow, segments=(paid_out, *tow.segments[1:]))
    there = hs.simulate(replace(still, bodies=tuple(bodies), forces={"tow": tow}))
    tension = float(run.line_tension[-1, 0])
    assert float(there.line_tension[0, 0]) == pytest.approx(tension, rel=1e-9)


def test_a_line_parts_at_its_tension() -> None:
    """The time does not depend on the step, and the energy that it held is lost."""
    whole = between(6.0)
    tensions = hs.simulate(with_step(whole, 0.002)).line_tension.values[:, 0]
    limit = 0.6 * tensions.max()
    ends = Active(until=When(channel="line_tension.tow", above=limit))
    times = []
    for step in (0.01, 0.005, 0.0025):
        case = with_step(whole, step)
        case = replace(case, forces={"tow": replace(case.forces["tow"], active=ends)})
        run = hs.simulate(case)
        weight = -np.diff(run.velocity.values[:, :, 2] @ [3e5, 2e5])
        times.append(float(weight.sum()) / (30.0 * 300.0 + 26.0 * 500.0 + 5e3))
        assert np.abs(run.energy_residual).max() < 1e-8 * float(run.energy_kinetic.max())
    assert 0.5 < times[-1] < 5.5
    assert times == pytest.approx([times[-1]] * 3, abs=1e-7)
    assert abs(times[1] - times[2]) < 1e-9


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"anchor": (110.0, 0.0, -60.0)}, "below the seabed"),
        ({"segments": [hs.Segment(60.0, 1e3, 4e7)]}, "stretch"),
    ],
)
def test_lines_that_cannot_be_are_refused(changes: dict[str, object], said: str) -> None:
    moor = line((10.0, 0.0, -2.0), (110.0, 0.0, -DEPTH), (118.0,), (1e3,), (4e7,))
    case = scene(block(4e5), {"bow": replace(moor, **changes)}, 1.0, 0.1)
    with pytest.raises(InputError, match=said):
        hs.compile_scene(replace(case, environment=WATER))
    with pytest.raises(InputError, match="infinite"):
        hs.compile_scene(scene(block(4e5), {"bow": moor}, 1.0, 0.1))


def test_small_angles_have_their_power() -> None:
    case = with_step(moored(0.0, 0.01, 2.0), 0.01, kinematics=Kinematics.LINEAR)
    run = hs.simulate(case)
    assert np.abs(run.energy_residual).max() < 1e-8 * float(run.energy_kinetic.max())


def test_natural_period_of_a_moored_body() -> None:
    """That of a stiffness by differences of Jonkman's pull, of both lines."""
    L, w, EA, mass = 118.0, 1e3, 4e7, 4e5
    forces = {
        name: line((s * 10.0, 0.0, -2.0), (s * 110.0, 0.0, -DEPTH), (L,), (w,), (EA,))
        for name, s in (("ahead", 1.0), ("astern", -1.0))
    }
    case = replace(scene(block(mass, ("surge",)), forces, 1.0, 0.1), environment=WATER)

    def pull(x: float) -> float:
        return float(solve_jonkman(x, DEPTH - 2.0, L, w, EA, 0.0, (4e4, 6e4), xtol=1e-14)[0])

    stiffness = 2.0 * (pull(100.01) - pull(99.99)) / 0.02
    modes = natural_modes(linearise(*hs.compile_scene(case)))
    period = 2.0 * np.pi * np.sqrt(mass / stiffness)
    assert modes[0].natural_period == pytest.approx(period, rel=1e-6)


SEA = f"""
title: Sphere on two lines with drag
duration: 90 s
environment:
  water_depth: infinite
  water_density: 1000 kg/m^3
  waves: {{spectrum: regular, amplitude: 0.5 m, period: 6 s, heading: 0 deg, ramp: 30 s}}
bodies:
  ball:
    hydrodynamics: {ROOT}/hydro_db/sphere.nc
    mass: 261.8e3 kg
    centre_of_gravity: [0 m, 0 m, -2 m]
    radii_of_gyration: [2.54 m, 2.54 m, 3.16 m]
    dofs: [surge, heave]
forces:
  ahead: &line
    type: catenary
    body: ball
    point: [0 m, 0 m, -1 m]
    anchor: [60 m, 0 m, -40 m]
    segments:
      - length: 75 m
        weight: 300 N/m
        stiffness: 30 MN
        drag: {{coefficient: 2.4, diameter: 0.1 m}}
  astern: {{<<: *line, anchor: [-60 m, 0 m, -40 m]}}
initial: at_rest
solver: {{method: rk4, step: 0.1 s}}
output: {{step: 0.1 s}}
"""


def test_drag_is_the_fixed_point_that_the_run_has(tmp_path: Path) -> None:
    """8/(3 pi) a 1/2 rho C D L/4 with the run's own amplitude a; a run that continues keeps it."""
    path = tmp_path / "ball.yaml"
    path.write_text(SEA)
    run = hs.simulate(path)
    late = run.sel(time=slice(66.0, 90.0))
    tension, H = late.line_tension.mean("time").values, late.line_horizontal.mean("time").values
    for i, side in enumerate((1.0, -1.0)):
        along = np.array([side * H[i], 0.0, -np.sqrt(tension[i] ** 2 - H[i] ** 2)]) / tension[i]
        velocity = late.velocity.values[:, 0, :3]
        across = velocity - np.outer(velocity @ along, along)
        amplitude = np.sqrt(2.0 * across.var(axis=0).sum())
        c = 8.0 / (3.0 * np.pi) * amplitude * 0.5 * 1000.0 * 2.4 * 0.1 * 75.0 / 4.0
        assert float(run.line_damping[i]) == pytest.approx(c, rel=5e-3)
    scene_of = hs.load_case(path).scene()
    calm = replace(scene_of, environment=replace(scene_of.environment, waves=()))
    rest = hs.simulate(replace(calm, at_rest=False, duration=1.0, initial=Start(run)))
    assert np.array_equal(rest.line_damping, run.line_damping)
    assert not hs.simulate(replace(calm, duration=1.0)).line_damping.any()


def test_tension_with_drag_converges_at_the_order_of_the_method(tmp_path: Path) -> None:
    path = tmp_path / "ball.yaml"
    path.write_text(SEA)
    short = {"duration": "40 s", "output.step": "0.2 s"}
    steps = (0.2, 0.1, 0.05, 0.0125)
    cases = [hs.load_case(path, {**short, "solver.step": f"{h} s"}) for h in steps]
    *found, exact = (hs.simulate(case).line_tension.values for case in cases)
    errors = [np.abs(tension - exact).max() for tension in found]
    assert errors[0] < 1e-3 * np.ptp(exact)
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx([4.0, 4.0], abs=0.15)


def test_linearised_drag_in_closed_form() -> None:
    """sqrt(8/pi) sigma along one direction, and 3/2 sqrt(pi/2) sigma for two equal ones; a current
    U alone gives 2 U and U, and means as by random numbers with both."""
    one, two = np.diag([0.0, 0.0, 0.49]), np.diag([0.0, 0.49, 0.49])
    still, flow = np.zeros(3), np.array([0.0, 0.3, 0.4])
    assert linearise_random(one, still).damping == pytest.approx(0.7 * np.sqrt(8.0 / np.pi))
    assert linearise_random(two, still).damping == pytest.approx(1.05 * np.sqrt(np.pi / 2.0))
    assert linearise_random(0.0 * one, flow) == (1.0, 0.5)
    g = 0.7 * np.random.default_rng(1).normal(size=(2, 1_000_000))
    w = g + flow[1:, None]
    size = np.hypot(*w)
    drag = linearise_random(two, flow)
    assert drag.damping == pytest.approx((size * (w * g).sum(axis=0)).mean() / 0.98, rel=5e-3)
    assert drag.drift == pytest.approx((size * (flow[1:] @ w)).mean() / 0.25, rel=5e-3)
    places = drag_points(np.array([30.0, 70.0, 20.0]), 100.0)
    moments = [float(places.phi**k @ places.length) for k in range(4)]
    assert moments == pytest.approx([100.0, 50.0, 100.0 / 3.0, 25.0])
