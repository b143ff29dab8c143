"""Catenaries on bodies: against independent equations, energy, invariance, restarts, events."""

from __future__ import annotations

from dataclasses import replace
from math import asinh, sqrt

import numpy as np
import pytest
from dry_scenes import block, moving, observed_orders, scene, with_step
from moored_block import AFLOAT, DEPTH, line, lines, moored
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

import hydrosim as hs
from hydrosim.errors import InputError
from hydrosim.forces import LinearMooring, Table
from hydrosim.scene import Active, Environment, Kinematics, Method, Scene, Start, When

WATER = Environment(water_depth=DEPTH)


def test_tension_converges_at_the_order_of_the_method_through_kinks() -> None:
    """Touch-downs pass a clump and anchors, and friction of the bed is exhausted and comes back."""
    steps = [0.1, 0.05, 0.02]
    for friction in (0.0, 0.6):
        exact = hs.simulate(moored(friction, 0.0025)).line_tension.values
        runs = [hs.simulate(moored(friction, step)) for step in steps]
        errors = np.array([np.abs(run.line_tension.values - exact).max() for run in runs])
        assert runs[-1].attrs["solver_events"] >= 4
        assert observed_orders(steps, errors).min() > 3.6
        assert errors[-1] < 1e-5 * exact.max()


def test_ledger_of_a_free_body_on_lines() -> None:
    """Without friction the lines have a potential; with it their work is their loss."""
    for friction in (0.0, 0.6):
        run = hs.simulate(moored(friction, 0.005))
        turned_over = float(run.energy_kinetic.max())
        assert np.abs(run.energy_residual).max() < 1e-9 * turned_over
        loss = np.abs(run.energy_dissipated_astern.values).max()
        assert loss == 0.0 if friction == 0.0 else loss > 1e3
        assert ("energy_stored_astern" in run) and (friction == 0.0) == bool(
            run.energy_stored_astern.any()
        )


def jonkman(H: float, V: float, L: float, w: float, EA: float, CB: float) -> tuple[float, float]:
    """Span and height of an elastic line that lies on the bed (Jonkman 2007, eqs. 2-37, 2-38)."""
    LB = L - V / w
    x = LB + H / w * asinh(V / H) + H * L / EA
    if CB > 0.0:
        x += CB * w / (2 * EA) * (-LB * LB + (LB - H / (CB * w)) * max(LB - H / (CB * w), 0.0))
    return x, H / w * (sqrt(1.0 + (V / H) ** 2) - 1.0) + V * V / (2.0 * EA * w)


def test_motion_against_independent_equations() -> None:
    """A body in surge, heave and pitch on two lines, integrated by DOP853 with its own lines."""
    ends = {"ahead": ((10.0, 0.0, -2.0), 110.0), "astern": ((-10.0, 0.0, -1.0), -105.0)}
    L, w, EA, CB = 118.0, 1000.0, 4e7, 0.4
    forces = {
        name: line(point, (anchor, 0.0, -DEPTH), (L,), (w,), (EA,), friction=CB)
        for name, (point, anchor) in ends.items()
    }
    body = block(
        4e5,
        ("surge", "heave", "pitch"),
        position=moving(surge=1.0),
        velocity=moving(surge=0.8, heave=0.3, pitch=0.03),
    )
    hold = LinearMooring("block", np.diag([0.0, 0.0, 4e5, 0.0, 4e7, 0.0]))
    run = hs.simulate(
        replace(
            scene(body, {"hold": hold, **forces}, 10.0, 0.5, step=0.005, method=Method.RK4),
            environment=WATER,
        )
    )
    guess = dict.fromkeys(ends, (40000.0, 60000.0))

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        x, z, a = y[:3]
        force = np.array([0.0, -4e5 * z, -4e7 * a])
        for name, ((px, _y, pz), anchor) in ends.items():
            rx, rz = px * np.cos(a) + pz * np.sin(a), -px * np.sin(a) + pz * np.cos(a)
            span, height = abs(anchor - x - rx), DEPTH + z + rz
            H, V = fsolve(
                lambda p, s=span, h=height: np.subtract(jonkman(*p, L, w, EA, CB), (s, h)),
                guess[name],
                xtol=1e-13,
            )
            guess[name] = (H, V)
            F = np.array([np.sign(anchor) * H, -V])
            force += [*F, rz * F[0] - rx * F[1]]
        return np.array([*y[3:], *(force / [4e5, 4e5, 4 * 4e5])])

    start = [1.0, 0.0, 0.0, 0.8, 0.3, 0.03]
    found = solve_ivp(rates, (0.0, 10.0), start, "DOP853", run.time.values, rtol=1e-11, atol=1e-12)
    mine = run.position.values[:, 0][:, [0, 2, 4]]
    assert np.abs(mine - found.y[:3].T).max() < 1e-8


def test_a_restart_is_the_same_to_the_bit() -> None:
    case = moored(0.6, 0.1)
    whole = hs.simulate(case)
    half = hs.simulate(replace(case, duration=5.0))
    rest = hs.simulate(replace(case, duration=5.0, initial=Start(half)))
    later = whole.sel(time=rest.time.values)
    for name in (
        "position",
        "velocity",
        "line_tension",
        "line_grounded",
        "energy_dissipated_astern",
    ):
        assert np.array_equal(rest[name].values, later[name].values), name


def test_lines_on_the_earth_turn_with_the_scene() -> None:
    angle = 2.0
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    here = moored(0.6, 0.1, 2.0)
    (body,) = here.bodies
    velocity = (*(R @ body.velocity[:3]), *(R @ body.velocity[3:]))
    turned = {
        name: replace(each, anchor=tuple(R @ each.anchor)) for name, each in lines(0.6).items()
    }
    there = replace(
        here,
        bodies=(replace(body, heading=angle, velocity=velocity),),
        forces={"afloat": AFLOAT, **turned},
    )
    one, other = hs.simulate(here), hs.simulate(there)
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
    hold = LinearMooring("block", np.diag([0.0, 0.0, 4e5, 0.0, 0.0, 0.0]))
    case = scene(body, {"hold": hold, **forces}, 0.1, 0.1)
    run = hs.simulate(replace(case, environment=WATER, at_rest=True))

    def off(u: np.ndarray) -> list[float]:
        x, z, H, V1, V2 = u * [1.0, 1.0, 1e4, 1e4, 1e4]
        ahead = jonkman(H, V1, L["ahead"], 1e3, 4e7, 0.0)
        astern = jonkman(H, V2, L["astern"], 1e3, 4e7, 0.0)
        height = DEPTH - 2.0 + z
        return [
            ahead[0] - (100.0 - x),
            ahead[1] - height,
            astern[0] - (100.0 + x),
            astern[1] - height,
            (V1 + V2 + 4e5 * z) / 1e4,
        ]

    x, z, H, V1, _ = fsolve(off, [0.0, -0.3, 4.0, 6.0, 6.0], xtol=1e-14)
    position = run.position.values[0, 0]
    assert position[[0, 2]] == pytest.approx([x, z], abs=1e-9)
    assert float(run.line_horizontal[0, 0]) == pytest.approx(1e4 * H, rel=1e-9)
    assert float(run.line_tension[0, 0]) == pytest.approx(1e4 * np.hypot(H, V1), rel=1e-9)


def between(duration: float, **changes: object) -> Scene:
    """Two blocks on one line that hangs between them."""
    apart = block(3e5, position=moving(surge=0.5), velocity=moving(surge=-0.6, sway=0.3))
    other = block(2e5, name="carrier", location=(60.0, 0.0), velocity=moving(sway=-0.4, yaw=0.01))
    tow = line(
        (5.0, 0.0, 1.0),
        (-5.0, 0.0, 2.0),
        (30.0, 26.0),
        (300.0, 500.0),
        (2e7, 2e7),
        (5e3, 0.0),
        friction=None,
        anchor_body="carrier",
        **changes,
    )
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


def test_a_closed_way_over_a_bed_with_friction_takes_work() -> None:
    """A circle of 5 m about 400 m of span: net work of a few kJ, which the line books."""
    t = np.linspace(0.0, 60.0, 241)
    body = block(1e6, ("yaw",), velocity=moving(yaw=2.0 * np.pi / 60.0), inertia=1e9 * np.eye(3))
    moor = line((5.0, 0.0, 0.0), (780.0, 0.0, -200.0), (850.0,), (1200.0,), (6e8,), friction=0.5)
    case = scene(body, {"bow": moor}, 60.0, 1.0, step=0.25, method=Method.RK4)
    run = hs.simulate(replace(case, environment=Environment(water_depth=200.0)))
    lost = float(run.energy_dissipated_bow[-1])
    kinetic = run.energy_kinetic.values
    assert t.size and abs(lost) > 500.0
    assert kinetic[0] - kinetic[-1] == pytest.approx(lost, abs=1e-6 * kinetic[0])


def test_a_line_that_is_paid_out() -> None:
    """The work of the pay-out closes the ledger, and the tension is that of the length."""
    paid = Table(np.array([0.0, 2.0, 5.0]), np.array([30.0, 30.0, 36.0]))
    run = hs.simulate(between(6.0, paid=paid, paying=0))
    assert np.abs(run.energy_residual).max() < 1e-8 * float(run.energy_kinetic.max())
    length = np.interp(run.time.values[-1], paid.time, paid.value)
    still = between(0.2)
    tow = still.forces["tow"]
    bodies = tuple(
        replace(body, position=tuple(run.position.values[-1, b]), velocity=(0.0,) * 6)
        for b, body in enumerate(still.bodies)
    )
    tow = replace(tow, length=np.array([length, 26.0]))
    there = hs.simulate(replace(still, bodies=bodies, forces={"tow": tow}))
    assert float(there.line_tension[0, 0]) == pytest.approx(
        float(run.line_tension[-1, 0]), rel=1e-9
    )


def test_a_line_parts_at_its_tension() -> None:
    """The time is located to 1e-10 s, and the energy that it held is lost."""
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
        ({"length": np.array([60.0])}, "stretch"),
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
