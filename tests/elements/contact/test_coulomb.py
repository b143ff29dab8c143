"""Rigid friction: closed forms of a block, Den Hartog's oscillator, points that are held.

Tolerances: rk4 in pieces without kinks; events are located to 1e-10 of their margin's range.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import pytest
import scenes
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import hydrosim as hs
from hydrosim.elements import Harmonic, Table
from hydrosim.errors import InputError
from hydrosim.report.evidence import Feature, Kind

STICK, SLIP = 1, 2
MASS, GRIP, PERIOD = 1e8, 2e5, 100.0
ROUGH = hs.Coulomb(1e3, 1e3)  # as good as a hinge


def pressed(law: hs.Coulomb, force: float) -> hs.Fender:
    """The block's origin, pressed on the floor by a constant force."""
    normal = hs.PrescribedNormal(Table(np.array([0.0]), np.array([force])))
    return scenes.foot(normal, law)


def pushed(mean: float, amplitude: float, duration: float = 1000.0, step: float = 0.1) -> hs.Scene:
    """The block of chapter 4 of the thesis, on friction of 2e5 N."""
    push = scenes.central_force(surge=Harmonic(amplitude, PERIOD, mean))
    forces = {"push": push, "fender": pressed(hs.Coulomb(0.2, 0.2), GRIP / 0.2)}
    return scenes.scene(scenes.block(MASS, ("surge",)), forces, duration, 10 * step, step=step)


@dataclass(frozen=True)
class Piece:
    """Motion from ``start`` on: at rest at ``place``, or slipping to the side ``sign``."""

    start: float
    place: float
    sign: float

    def speed(self, t: np.ndarray | float, amplitude: float) -> np.ndarray:
        w, t0 = 2 * np.pi / PERIOD, self.start
        swing = amplitude / w * (np.cos(w * t0) - np.cos(w * np.asarray(t)))
        return np.abs(self.sign) * (swing - self.sign * GRIP * (np.asarray(t) - t0)) / MASS

    def position(self, t: np.ndarray | float, amplitude: float) -> np.ndarray:
        w, t0, past = 2 * np.pi / PERIOD, self.start, np.asarray(t) - self.start
        sines = np.sin(w * np.asarray(t)) - np.sin(w * t0)
        swing = amplitude / w * (np.cos(w * t0) * past - sines / w)
        return self.place + np.abs(self.sign) * (swing - self.sign * GRIP * past**2 / 2) / MASS


def closed_form(amplitude: float, duration: float) -> Iterator[Piece]:
    """Pieces under amplitude * sin: rest until the push exceeds the friction, slip until v = 0."""
    w = 2 * np.pi / PERIOD
    piece = Piece(0.0, 0.0, 0.0)
    while piece.start < duration:
        yield piece
        if piece.sign == 0.0:
            phase = np.arcsin(GRIP / amplitude)
            leaving = [(k * np.pi + phase) / w for k in range(200)]
            t = next(x for x in leaving if x > piece.start)
            side = np.sign(np.sin(w * t))
        else:
            grid = piece.start + np.linspace(1e-3, PERIOD, 4000)
            speed = piece.speed(grid, amplitude)
            k = int(np.argmax(speed * piece.sign < 0.0))
            t = brentq(lambda x, p=piece: p.speed(x, amplitude), grid[k - 1], grid[k], xtol=1e-13)
            push = amplitude * np.sin(w * t)
            side = np.sign(push) if abs(push) > GRIP else 0.0
        piece = Piece(t, float(piece.position(t, amplitude)), float(side))


@pytest.mark.parametrize("amplitude", [4e5, 2.2e5])
def test_block_of_the_thesis(amplitude, figure, validated):
    run = hs.simulate(pushed(0.0, amplitude))
    time, pieces = run.time.values, list(closed_form(amplitude, 1000.0))
    of = np.searchsorted([p.start for p in pieces], time, side="right") - 1
    exact = np.array([pieces[i].position(t, amplitude) for i, t in zip(of, time, strict=True)])
    error = np.abs(scenes.surge(run) - exact).max()
    figure("position error [m]", error)
    claim = "block under dry friction, 1000 s, over its range"
    part = error / np.ptp(exact)
    validated(Kind.CLOSED_FORM, claim, "parabolas and sines", part, 1e-9, Feature.COULOMB)
    assert error <= 1e-9
    assert run.attrs["energy_residual_relative"] < 1e-9
    rests = sum(p.sign == 0.0 for p in pieces)
    assert rests == 1 if amplitude == 4e5 else rests > 5  # turns at once, or rests in between


def test_no_creep(figure, validated) -> None:
    """Others creep by 3.6e-6 m (MuJoCo, tuned) to 7e-4 m (Drake) in an hour of this."""
    run = hs.simulate(pushed(1e5, 5e4, duration=3600.0))
    creep = np.abs(scenes.surge(run)).max()
    figure("creep [m]", creep)
    claim = "block held by friction for an hour, creep [m]"
    validated(Kind.CLOSED_FORM, claim, "0", creep, 0.0, Feature.COULOMB)
    assert np.all(run.fender_mode.values == STICK)
    friction = run.fender_friction.values[:, 0, 0]
    push = 1e5 + 5e4 * np.sin(2 * np.pi * run.time.values / PERIOD)
    np.testing.assert_allclose(friction, -push, rtol=1e-12)


def den_hartog(ratio: float, friction: float) -> tuple[float, float]:
    """Amplitude over the static deflection, and the phase of the force at the turning point, of a
    forced oscillator with dry friction, ``friction`` over the force's amplitude, that never stops
    (Den Hartog 1931)."""
    V = 1.0 / (1.0 - ratio**2)
    U = np.sin(np.pi / ratio) / (ratio * (1.0 + np.cos(np.pi / ratio)))
    amplitude = np.sqrt(V**2 - (friction * U) ** 2)
    return amplitude, np.arctan2(-friction * U / V, amplitude / V)


def oscillator(ratio: float, friction: float, phase: float, start: float, cycles: int) -> hs.Scene:
    """Mass 1, stiffness 1, force cos(ratio t + phase), recorded at every half period."""
    half = np.pi / ratio
    swing = {"surge": Harmonic(1.0, 2 * half, phase=phase + np.pi / 2)}
    forces = {
        "push": scenes.central_force(**swing),
        "spring": scenes.mooring(surge=1.0),
        "fender": pressed(hs.Coulomb(1.0, 1.0), friction),
    }
    body = scenes.block(1.0, ("surge",), position=scenes.moving(surge=start))
    steps = int(np.ceil(half / min(0.02, half / 40)))
    return scenes.scene(body, forces, 2 * cycles * half, half, step=half / steps)


@pytest.mark.parametrize("ratio", [0.3, 0.45, 0.6, 0.8, 0.9, 1.1, 1.25, 1.5, 2.0, 2.5, 3.0])
def test_den_hartog(ratio: float, figure, validated) -> None:
    """From the turning point of the steady motion; the next ones are half periods away."""
    friction = {0.3: 0.02, 0.45: 0.1}.get(ratio, 0.2)
    amplitude, phase = den_hartog(ratio, friction)
    run = hs.simulate(oscillator(ratio, friction, phase, amplitude, cycles=40))
    turning = scenes.surge(run) * np.where(np.arange(run.time.size) % 2, -1.0, 1.0)
    error = np.abs(turning / amplitude - 1.0).max()
    figure(f"amplitude at {ratio:g}", error)
    claim = "oscillator with dry friction, amplitude at 11 frequencies"
    validated(Kind.CLOSED_FORM, claim, "Den Hartog 1931", error, 1e-6, Feature.COULOMB)
    assert np.all(run.fender_mode.values[1:-1] != 0)


def stops(ratio: float, friction: float, cycles: int) -> tuple[np.ndarray, float]:
    """Places at half periods, and the number of stops in the last ``cycles``, by DOP853."""
    f, x, v, t, sign, count = friction, 0.0, 0.0, 0.0, 0.0, 0
    half = np.pi / ratio
    end, places = 2 * cycles * half, [0.0]

    def push(t: float) -> float:
        return float(np.cos(ratio * t + np.pi / 2))

    while t < end - 1e-12:
        if sign == 0.0:
            grid = np.arange(t, end + half, 1e-3)
            over = np.abs(np.cos(ratio * grid + np.pi / 2) - x) - f

            def over_by(t: float, x: float = x) -> float:
                return abs(push(t) - x) - f

            k = int(np.argmax(over > 0.0)) if (over > 0.0).any() else grid.size - 1
            after = t if k == 0 else brentq(over_by, grid[k - 1], grid[k])
            new, dense = after, lambda s, x=x: x * np.ones_like(s)
            sign_next = float(np.sign(push(after) - x))
            if k and grid[k] > end:
                new = end
        else:

            def rates(t: float, y: np.ndarray, sign: float = sign) -> list[float]:
                return [y[1], push(t) - y[0] - sign * f]

            def turned(t: float, y: np.ndarray, sign: float = sign) -> float:
                return sign * y[1]

            turned.terminal, turned.direction = True, -1
            settings = {"dense_output": True, "events": turned, "rtol": 1e-12, "atol": 1e-14}
            piece = solve_ivp(rates, (t, end), [x, v], "DOP853", **settings)
            new, dense = piece.t[-1], lambda s, p=piece: p.sol(s)[0]
            x, v = piece.y[0, -1], 0.0
            held = abs(push(new) - x) <= f
            sign_next = 0.0 if held else float(np.sign(push(new) - x))
            count += held and piece.status == 1  # not where the run ends
        inside = half * np.arange(len(places), 2 * cycles + 1)
        passed = inside[inside <= new + 1e-12]
        places += list(dense(passed)) if passed.size else []
        t, sign = new, sign_next
    return np.array(places), count


@pytest.mark.parametrize(
    ("ratio", "friction"), [(0.15, 0.3), (0.2, 0.3), (0.25, 0.5), (0.4, 0.7), (0.7, 0.8)]
)
def test_stops_per_cycle(ratio: float, friction: float, figure) -> None:
    """Slow or sticky: the motion stops, once or several times in every half cycle."""
    places, count = stops(ratio, friction, cycles=6)
    whole = oscillator(ratio, friction, np.pi / 2, 0.0, cycles=6)
    run = hs.simulate(whole)
    error = np.abs(scenes.surge(run) - places).max()
    figure(f"places at {ratio:g}", error)
    assert error <= 1e-6 * np.ptp(places)
    fine = hs.simulate(whole.with_output(step=whole.solver.step))
    mode = fine.fender_mode.values[:, 0]
    figure(f"stops at {ratio:g}", count)
    assert np.count_nonzero((mode[1:] == STICK) & (mode[:-1] == SLIP)) == count


def test_a_block_thrown_along_the_floor_stops_straight(figure) -> None:
    g, mu, v = 9.81, 0.3, np.array([3.0, 4.0])
    forces = {"weight": scenes.steady(heave=-g), "fender": scenes.on_floor(1e3, hs.Coulomb(mu, mu))}
    start = {
        "position": scenes.moving(heave=-g / 1e3),
        "velocity": scenes.moving(surge=v[0], sway=v[1]),
    }
    body = scenes.block(1.0, ("surge", "sway", "heave"), **start)
    run = hs.simulate(scenes.scene(body, forces, 3.0, 0.1, step=0.05))
    way = v * np.hypot(*v) / (2 * mu * g)
    error = np.abs(run.position.values[-1, 0, :2] - way).max()
    figure("where it stops [m]", error)
    assert error < 1e-9
    assert run.fender_slip_distance.values[-1, 0] == pytest.approx(np.hypot(*way), abs=1e-9)
    assert run.fender_dissipated.values[-1, 0] == pytest.approx(0.5 * 25.0, abs=1e-8)
    assert run.fender_mode.values[-1, 0] == STICK
    assert np.all(run.velocity.values[-1, 0, :2] == 0.0)


ARM, STIFFNESS, G = 1.0, 400.0, 9.81


def rocking(duration: float, step: float) -> hs.Scene:
    """A body on one rough point below its centre of gravity, tilted."""
    start = scenes.moving(surge=ARM * np.sin(0.1), heave=ARM * np.cos(0.1) - G / 400, pitch=0.1)
    body = scenes.block(1.0, ("surge", "heave", "pitch"), position=start)
    forces = {
        "weight": scenes.steady(heave=-G),
        "spring": scenes.mooring(pitch=30.0),
        "fender": scenes.on_floor(STIFFNESS, ROUGH, points=[[0.0, 0.0, -ARM]]),
    }
    return scenes.scene(body, forces, duration, 0.1, step=step)


def test_a_held_point_is_a_hinge(figure) -> None:
    """Against Lagrange's equations of height z and pitch, with x = arm sin(pitch)."""
    inertia = scenes.INERTIA[1, 1]

    def rates(t: float, y: np.ndarray) -> list[float]:
        z, a, dz, da = y
        N = STIFFNESS * (ARM * np.cos(a) - z)
        turn = N * ARM * np.sin(a) - 30.0 * a + ARM**2 * np.sin(a) * np.cos(a) * da**2
        return [dz, da, N - G, turn / (inertia + ARM**2 * np.cos(a) ** 2)]

    times = np.linspace(0.0, 5.0, 51)
    start = [ARM * np.cos(0.1) - G / 400, 0.1, 0.0, 0.0]
    exact = solve_ivp(rates, (0, 5), start, "DOP853", t_eval=times, rtol=1e-12, atol=1e-13).y
    x = ARM * np.sin(exact[1])
    steps = np.array([0.05, 0.025, 0.0125])
    found = scenes.errors(rocking(5.0, 0.05), steps, x)
    figure("order", scenes.observed_orders(steps, found)[-1])
    assert scenes.observed_orders(steps, found)[-1] > 3.7
    run = hs.simulate(rocking(5.0, 0.0125))
    assert found[-1] < 1e-6 * np.ptp(x)
    assert np.abs(run.position.values[:, 0, 4] - exact[1]).max() < 1e-6
    # the reaction is what accelerates the centre of gravity, from the same equations
    slope = np.array([rates(0.0, y)[3] for y in exact.T])
    wanted = ARM * (np.cos(exact[1]) * slope - np.sin(exact[1]) * exact[3] ** 2)
    assert np.abs(run.fender_friction.values[:, 0, 0] - wanted).max() < 1e-4 * np.ptp(wanted)
    assert run.attrs["energy_residual_relative"] < 1e-7


def test_a_free_body_on_a_rough_point_keeps_it_and_its_energy(figure) -> None:
    """All six DOFs, three dimensions: the point stays, the energy stays."""
    position, velocity = scenes.moving(pitch=0.3, roll=-0.2), scenes.moving(heave=-0.5, yaw=0.2)
    body = scenes.block(1.0, position=position, velocity=velocity)
    arm = [0.05, -0.03, 0.2]
    plane = hs.Plane((0, 0, 0.15), (0, 0, 1))
    fender = scenes.on_floor(200.0, ROUGH, points=[arm], plane=plane)
    spring, weight = scenes.mooring(roll=3.0, pitch=3.0, yaw=3.0), scenes.steady(heave=-G)
    forces = {"spring": spring, "weight": weight, "fender": fender}
    runs = [hs.simulate(scenes.scene(body, forces, 4.0, 0.1, step=h)) for h in (0.01, 0.005)]
    assert {*np.unique(runs[1].fender_mode.values)} >= {STICK}
    residual = [run.attrs["energy_residual_relative"] for run in runs]
    figure("residual", residual[1])
    assert residual[1] < 1e-6
    held = runs[1].fender_mode.values[:, 0] == STICK
    node = runs[1].fender_node.values[:, 0, :2]
    moved = np.abs(np.diff(node, axis=0))[held[1:] & held[:-1]]
    figure("creep of the point [m]", moved.max())
    assert moved.max() < 1e-7


def test_two_bodies_stick_together(figure) -> None:
    """A block on a cart that is pushed: one body while it holds, momentum always."""
    cart = scenes.block(3.0, ("surge",), name="cart")
    body = scenes.block(1.0, ("surge", "heave"), position=scenes.moving(heave=-0.1))
    push = scenes.central_force("cart", surge=Harmonic(6.0, 5.0, phase=np.pi / 2))
    top = hs.Plane((0, 0, 0), (0, 0, 1), body="cart")
    fender = scenes.on_floor(100.0, hs.Coulomb(0.4, 0.4), plane=top)
    forces = {"push": push, "weight": scenes.steady(heave=-10.0), "fender": fender}
    run = hs.simulate(scenes.scene((body, cart), forces, 10.0, 0.1, step=0.05))
    w, t = 2 * np.pi / 5.0, run.time.values
    assert np.all(run.fender_mode.values == STICK)
    exact = 6.0 / 4.0 / w**2 * (1.0 - np.cos(w * t))
    figure("as one body [m]", np.abs(run.position.values[:, :, 0] - exact[:, None]).max())
    assert np.abs(run.position.values[:, :, 0] - exact[:, None]).max() < 2e-7  # Simpson
    assert np.all(run.velocity.values[:, 0, 0] == run.velocity.values[:, 1, 0])
    loose = {**forces, "fender": replace(fender, friction=hs.Coulomb(0.12, 0.08))}
    run = hs.simulate(scenes.scene((body, cart), loose, 10.0, 0.1, step=0.05))
    assert {*np.unique(run.fender_mode.values)} == {STICK, SLIP}
    momentum = run.velocity.values[:, 0, 0] + 3.0 * run.velocity.values[:, 1, 0]
    assert np.abs(momentum - 6.0 / w * np.sin(w * t)).max() < 1e-6
    assert run.attrs["energy_residual_relative"] < 1e-6


def test_friction_on_what_cannot_slide_does_nothing() -> None:
    """A block that bounces straight up and down: as without friction, and it opens as often."""
    body = scenes.block(1.0, ("heave",), position=scenes.moving(heave=0.1))
    ends = []
    for law in (hs.Coulomb(0.4, 0.3), hs.Frictionless()):
        forces = {"weight": scenes.steady(heave=-9.81), "fender": scenes.on_floor(1e3, law)}
        run = hs.simulate(scenes.scene(body, forces, 3.0, 0.01, step=0.005))
        ends.append(scenes.heave(run))
        assert np.count_nonzero(np.diff(run.fender_mode.values[:, 0] != 0)) > 10
    assert ends[0] == pytest.approx(ends[1], abs=1e-10)


def test_what_does_not_fit_is_refused() -> None:
    corners = [[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]
    forces = {"fender": scenes.on_floor(1e3, hs.Coulomb(0.2, 0.1), points=corners)}
    with pytest.raises(InputError, match="stick_slip") as refused:
        hs.simulate(scenes.scene(scenes.block(1.0), forces, 1.0, 0.1))
    assert "forces.fender: rigid friction holds 4 directions at 2 points" in str(refused.value)
    wall = hs.Plane((5.0, 0.0, 0.0), (-1.0, 0.0, 0.0))
    one_each = {
        "floor": scenes.on_floor(1e3, hs.Coulomb(0.2, 0.1), points=corners[:1]),
        "wall": scenes.on_floor(1e3, hs.Coulomb(0.2, 0.1), points=[[1.0, 0.0, 1.0]], plane=wall),
    }
    run = hs.simulate(
        scenes.scene(scenes.block(1.0, velocity=scenes.moving(heave=-0.1)), one_each, 1.0, 0.1)
    )
    assert np.isfinite(scenes.heave(run)).all()
