"""Winches and lengths over time: closed forms, and drums integrated apart from hydrosim."""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, pi, sin, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scenes
from modes_apart import Event, ModalMotion, integrate
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import hydrosim as hs
from hydrosim.elements import Harmonic, Spring, Table, Winch
from hydrosim.elements.line.drum import (
    DRUM_INACTIVE,
    EMPTY,
    FAST_IN,
    FAST_OUT,
    FULL,
    SLIPPING_IN,
    SLIPPING_OUT,
    STUCK,
)
from hydrosim.report.evidence import Feature, Kind

ORIGIN = (0.0, 0.0, 0.0)
STRAIGHT = np.array([0.0, 1.0])
MASS = 1e5  # kg
SET = 9.81e6  # N: 1000 t
SPAN = 60.0  # m


def test_hoist_at_constant_speed_in_closed_form() -> None:
    """Heaved in at v from 1 s on: its lag behind the drum is v/w sin w(t - 1)."""
    k, v = 4e6, 0.5
    w = sqrt(k / MASS)
    length = Table(np.array([1.0, 5.0]), np.array([30.0, 30.0 - 4.0 * v]))
    line = Spring(
        "block", ORIGIN, (0.0, 0.0, 30.0), length, curve=hs.TensionCurve(STRAIGHT, k * STRAIGHT)
    )
    run = hs.simulate(
        scenes.scene(scenes.block(MASS, ("heave",)), {"line": line}, 4.0, 0.1, step=0.0025)
    )
    t = np.maximum(run.time.values - 1.0, 0.0)
    slack = np.pi / w  # until then it pulls
    taut = t <= slack
    expected = v * (t - np.sin(w * t) / w)
    found = run.position.values[:, 0, 2]
    np.testing.assert_allclose(found[taut], expected[taut], atol=1e-9)
    assert taut.sum() > 3
    energy = 0.5 * MASS * (2.0 * v) ** 2
    assert float(run.energy_kinetic[-1]) == pytest.approx(energy, rel=1e-8)
    assert float(run.energy_dissipated_line[-1]) == pytest.approx(-energy, rel=1e-8)


def test_hoist_on_a_wire_is_that_of_an_independent_integration() -> None:
    """A smooth length over time, strain on the changing length, with damping."""
    EA, c, weight = 5e8, 0.02, 9.81 * MASS
    l00 = 30.0 / (1.0 + weight / EA)
    length = Harmonic(-2.0, 40.0, l00)
    w = 2.0 * pi / 40.0
    winch = Winch("block", ORIGIN, (0.0, 0.0, 30.0), EA, length, damping=c)
    forces = {"hoist": winch, "weight": scenes.steady(heave=-weight)}
    run = hs.simulate(scenes.scene(scenes.block(MASS, ("heave",)), forces, 10.0, 0.1, step=0.002))

    def rates(t: float, y: np.ndarray) -> list[float]:
        l0, speed = l00 - 2.0 * sin(w * t), -2.0 * w * cos(w * t)
        distance, rate = 30.0 - y[0], -y[1]
        strain = distance / l0 - 1.0
        T = EA * (strain + c * (rate / l0 - distance * speed / l0**2))
        return [y[1], T / MASS - 9.81, T * speed]

    settings: dict[str, Any] = {"rtol": 1e-13, "atol": 1e-13, "max_step": 0.02}
    apart = solve_ivp(rates, (0, 10), [0, 0, 0], "DOP853", run.time.values, **settings)
    np.testing.assert_allclose(run.position.values[:, 0, 2], apart.y[0], atol=1e-9)
    np.testing.assert_allclose(run.winch_work.values[:, 0], apart.y[2], rtol=1e-8, atol=1.0)
    assert run.energy_residual_relative <= 1e-9


@dataclass(frozen=True)
class Drum:
    """A mass on the x axis between a force that swings about the set tension and a winch."""

    damping: float = 0.0
    speed: float = 1.0
    dead_band: float = 0.0
    ends: tuple[float, float] = (5.0, 200.0)
    swing: float = 6e6
    duration: float = 15.0
    friction: tuple[float, float] = (0.3, 0.1)
    EA: float = 4e8
    mass: float = 1e6

    @property
    def start(self) -> float:
        """Length off the drum at which the set tension acts."""
        return SPAN / (1.0 + SET / self.EA)

    def scene(self, step: float, **solver: Any) -> hs.Scene:
        control = {"tension": SET, "speed": self.speed, "dead_band": self.dead_band}
        drum = {"friction": hs.DrumFriction(*self.friction), "drum": hs.Drum(*self.ends)}
        ends = ("block", ORIGIN, (-SPAN, 0.0, 0.0))
        winch = Winch(*ends, self.EA, **control, **drum, damping=self.damping)
        push = scenes.central_force(surge=Harmonic(self.swing, 7.0, SET))
        body = scenes.block(self.mass, ("surge",))
        forces = {"winch": winch, "push": push}
        return scenes.scene(body, forces, self.duration, 0.1, step=step, **solver)

    def pull(self, y: np.ndarray, mode: str) -> tuple[float, float]:
        """Tension and speed of pay-out in a mode."""
        distance, rate, l0 = SPAN + y[0], y[1], y[2]
        still = self.EA * (distance / l0 - 1.0 + self.damping * rate / l0)
        by_speed = -self.EA * self.damping * distance / l0**2
        if mode in ("out", "in"):
            bound = self.high if mode == "out" else self.low
            if self.damping:
                return bound, (bound - still) / by_speed
            return bound, l0 * rate / distance
        s = {"fast out": self.speed, "fast in": -self.speed}.get(mode, 0.0)
        return still + by_speed * s, s

    @property
    def low(self) -> float:
        return SET * (1.0 - self.dead_band - self.friction[0])

    @property
    def high(self) -> float:
        return SET * (1.0 + self.dead_band + self.friction[1])

    def rates(self, t: float, y: np.ndarray, mode: str) -> list[float]:
        """y' of (x, x', l0, work, friction)."""
        T, s = self.pull(y, mode)
        lost = SET * (self.friction[1] * s if s > 0.0 else -self.friction[0] * s)
        force = SET + self.swing * sin(2.0 * pi / 7.0 * t)
        return [y[1], (force - T) / self.mass, s, T * s - lost, lost]

    def ends_of(self, mode: str) -> list[Event]:
        """What ends a mode."""
        turning = {"out": 1.0, "fast out": 1.0, "in": -1.0, "fast in": -1.0}
        found: list[Event] = []
        if mode in ("stuck", "full"):
            found.append((lambda t, y, m: self.high - self.pull(y, m)[0], self.begins("out")))
        if mode in ("stuck", "empty"):
            found.append((lambda t, y, m: self.pull(y, m)[0] - self.low, self.begins("in")))
        if mode in ("out", "in"):
            way = turning[mode]
            found.append((lambda t, y, m: way * self.pull(y, m)[1], "stuck"))
            fast = f"fast {mode}"
            room: Event = (lambda t, y, m: self.speed - way * self.pull(y, m)[1], fast)
            found.append(room)
        if mode == "fast out":
            found.append((lambda t, y, m: self.pull(y, m)[0] - self.high, self.back("out")))
        if mode == "fast in":
            found.append((lambda t, y, m: self.low - self.pull(y, m)[0], self.back("in")))
        if turning.get(mode) == 1.0:
            found.append((lambda t, y, m: self.ends[1] - y[2], "empty"))
        if turning.get(mode) == -1.0:
            found.append((lambda t, y, m: y[2] - self.ends[0], "full"))
        return found

    def begins(self, side: str) -> Callable[[float, np.ndarray], str]:
        """The mode of a drum that begins to turn."""
        return lambda t, y: side if abs(self.pull(y, side)[1]) < self.speed else f"fast {side}"

    def back(self, side: str) -> Callable[[float, np.ndarray], str]:
        """The mode of a fast drum that is back on its bound."""
        way = 1.0 if side == "out" else -1.0
        return lambda t, y: side if way * self.pull(y, side)[1] > 0.0 else "stuck"

    def integrate(self, times: np.ndarray) -> ModalMotion:
        first = [0.0, 0.0, self.start, 0.0, 0.0]
        return integrate(self.rates, self.ends_of, "stuck", first, times)


NAMES = {"stuck": STUCK, "out": SLIPPING_OUT, "in": SLIPPING_IN, "fast out": FAST_OUT}
NAMES |= {"fast in": FAST_IN, "empty": EMPTY, "full": FULL}
DRUMS = {
    "elastic wire": (Drum(), 0.0125),
    "damped wire": (Drum(damping=0.03), 0.004),
    "narrow drum": (Drum(ends=(58.2, 58.9), swing=4e6), 0.0125),
    "dead band, slow drum": (Drum(dead_band=0.05, speed=0.25), 0.0125),
}


@pytest.mark.parametrize("name", DRUMS)
def test_a_slipping_drum_is_that_of_an_independent_integration(name, figure, validated):
    """Place, length off the drum, work and friction, through stick, slip, the largest speed and the
    ends of the drum: to 1e-9 of their ranges at the smallest step, at order 4."""
    drum, step = DRUMS[name]
    steps = (step, step / 2.0, step / 4.0)
    runs = [hs.simulate(drum.scene(h)) for h in steps]
    exact, modes, _ = drum.integrate(runs[0].time.values)
    parts = [(r.winch_length, r.winch_work, r.winch_friction_loss) for r in runs]
    own = [
        np.stack([scenes.surge(r), *(x[:, 0] for x in p)], 1)
        for r, p in zip(runs, parts, strict=True)
    ]
    ranges = np.ptp(exact[:, [0, 2, 3, 4]], axis=0)
    errors = np.array([np.abs((x - exact[:, [0, 2, 3, 4]]) / ranges).max() for x in own])
    figure("order", scenes.observed_orders(steps, errors)[-1])
    claim = "mass on a winch whose drum sticks, slips and meets its ends, of the ranges"
    validated(Kind.INDEPENDENT, claim, "DOP853 by events", errors[-1], 1e-9, Feature.WINCHES)
    assert scenes.observed_orders(steps, errors)[-1] >= 3.7
    assert [run.solver_events for run in runs] == [len(modes) - 1] * 3
    assert {NAMES[m] for m in modes} >= {*np.unique(runs[-1].winch_mode)}
    assert np.abs(runs[-1].energy_residual).max() <= 1e-9 * np.abs(exact[:, 3:]).max()


def test_the_drum_slips_between_700_and_1100_tonnes() -> None:
    """The manual's 1000 t, friction 0.3 in, 0.1 out: work T0 l0', loss f T0 |l0'|, of the wire."""
    run = hs.simulate(Drum(speed=1e4, duration=7.0).scene(0.0125))
    mode = run.winch_mode.values[:, 0]
    tension = run.winch_tension.values[:, 0] / 9810.0
    assert np.unique(tension[mode == SLIPPING_OUT]).tolist() == [pytest.approx(1100.0, rel=1e-14)]
    assert np.unique(tension[mode == SLIPPING_IN]).tolist() == [pytest.approx(700.0, rel=1e-14)]
    assert np.all((tension[mode == STUCK] > 700.0) & (tension[mode == STUCK] < 1100.0))
    out = np.flatnonzero(mode == SLIPPING_OUT)[:3]
    way = float(run.winch_length[out[-1], 0] - run.winch_length[out[0], 0])
    work = float(run.winch_work[out[-1], 0] - run.winch_work[out[0], 0])
    lost = float(run.winch_friction_loss[out[-1], 0] - run.winch_friction_loss[out[0], 0])
    assert work == pytest.approx(SET * way, rel=1e-9)
    assert lost == pytest.approx(0.1 * SET * way, rel=1e-9)


def test_a_drum_with_an_acceleration_comes_to_rest_in_its_band() -> None:
    """A push of 1.5 T0 that stays: the drum speeds up at a, and pays out at its largest speed."""
    control = {"tension": SET, "speed": 0.5, "dead_band": 0.1, "acceleration": 0.2}
    drum = {"drum": hs.Drum(5.0, 200.0), "damping": 0.05}
    winch = Winch("block", ORIGIN, (-SPAN, 0.0, 0.0), 4e8, **control, **drum)
    forces = {"winch": winch, "push": scenes.central_force(surge=STEP_UP)}
    run = hs.simulate(scenes.scene(scenes.block(1e5, ("surge",)), forces, 10.0, 0.05, step=0.0025))
    speed = run.winch_speed.values[:, 0]
    assert speed.max() == pytest.approx(0.5, rel=1e-12)
    assert np.abs(np.diff(speed)).max() <= 0.2 * 0.05 * (1.0 + 1e-9)
    assert run.winch_mode.values[-1, 0] == STUCK
    assert run.energy_residual_relative <= 1e-6


STEP_UP = Table(np.array([0.0, 0.5, 3.0, 3.5]), SET * np.array([1.0, 1.15, 1.15, 1.0]))


def test_a_snap_is_that_of_the_energy() -> None:
    """A mass that runs into a slack wire at v is stopped by v sqrt(k m) [closed form]."""
    EA, v = 4e7, 1.5
    winch = Winch("block", ORIGIN, (-SPAN, 0.0, 0.0), EA, Table(np.zeros(1), np.full(1, 61.0)))
    body = scenes.block(MASS, ("surge",), velocity=scenes.moving(surge=v))
    run = hs.simulate(scenes.scene(body, {"winch": winch}, 3.0, 0.1, step=0.0005))
    assert float(run.winch_snap_speed[-1, 0]) == pytest.approx(v, rel=1e-12)
    largest = float(run.winch_largest_tension[-1, 0])
    assert largest == pytest.approx(v * sqrt(EA / 61.0 * MASS), rel=1e-6)
    assert run.energy_residual_relative <= 1e-9


def test_a_wire_that_breaks_is_located() -> None:
    """Heaved in at constant speed, a line parts at 60 % of its largest tension; from then on the
    mass keeps the speed v (1 - cos wt) that it had, which tells the moment to 1e-10 s."""
    k, v = 4e6, 0.5
    w = sqrt(k / MASS)
    end = v * sqrt(k * MASS) * 0.6
    length = Table(np.array([0.0, 50.0]), np.array([30.0, 30.0 - 50.0 * v]))
    active = hs.Active(until=hs.When(0.0, "spring_tension.line", above=end))
    curve = (STRAIGHT, k * STRAIGHT)
    line = Spring(
        "block", ORIGIN, (0.0, 0.0, 30.0), length, curve=hs.TensionCurve(*curve), active=active
    )
    run = hs.simulate(
        scenes.scene(scenes.block(MASS, ("heave",)), {"line": line}, 1.0, 0.1, step=0.001)
    )
    exact = np.arcsin(0.6) / w
    speed = float(run.velocity[-1, 0, 2])
    found = brentq(lambda t: v * (1.0 - cos(w * t)) - speed, 0.0, 0.5 * pi / w, xtol=1e-15)
    assert found == pytest.approx(exact, abs=1e-10)
    assert float(run.spring_tension[-1, 0]) == 0.0


def test_the_wire_of_a_winch_breaks_at_its_tension() -> None:
    """A mass that runs into a wire at v: the wire parts at 60 % of v sqrt(k m), and the mass keeps
    v cos(wt), which tells the moment to 1e-10 s."""
    EA, v = 4e7, 1.5
    w = sqrt(EA / SPAN / MASS)
    until = hs.When(0.0, "winch_tension.winch", above=0.6 * v * w * MASS)
    length = Table(np.zeros(1), np.full(1, SPAN))
    wire = Winch(*("block", ORIGIN, (-SPAN, 0.0, 0.0), EA, length), active=hs.Active(until=until))
    body = scenes.block(MASS, ("surge",), velocity=scenes.moving(surge=v))
    run = hs.simulate(scenes.scene(body, {"winch": wire}, 1.0, 0.1, step=0.002))
    found = np.arccos(float(run.velocity[-1, 0, 0]) / v) / w
    assert found == pytest.approx(np.arcsin(0.6) / w, abs=1e-10)
    assert int(run.winch_mode[-1, 0]) == DRUM_INACTIVE
    assert run.energy_residual_relative <= 1e-9


def test_a_restart_goes_on_to_the_bit(tmp_path: Path) -> None:
    """From stuck, slipping and fast drums, through files."""
    whole = Drum(damping=0.03, duration=8.0).scene(0.0125).with_output(states=True)
    run = hs.simulate(whole)
    mode = run.winch_mode.values[:, 0]
    at = [np.flatnonzero(mode[:-1] == one)[-1] for one in (STUCK, SLIPPING_OUT, FAST_OUT, FAST_IN)]
    scenes.assert_continues(whole, run, run.time.values[at], "winch_mode", file=tmp_path / "run.nc")


def in_the_plane(angle: float) -> hs.Scene:
    """A free block between two winches, mirror images of each other at ``angle`` 0, and turned."""
    turn = np.array([[cos(angle), -sin(angle), 0], [sin(angle), cos(angle), 0], [0, 0, 1]])
    friction = hs.DrumFriction(0.1, 0.1)
    control = {"tension": 1e5, "speed": 0.5, "friction": friction, "drum": hs.Drum(5.0, 60.0)}
    winches = {}
    for name, y in (("port", 1.0), ("starboard", -1.0)):
        ends = (tuple(turn @ (0.0, y, 0.0)), tuple(turn @ (-30.0, 8.0 * y, 0.5)))
        winches[name] = Winch("block", *ends, 5e6, **control)
    swing = zip(("surge", "sway"), 1e5 * turn[:2, 0], strict=True)
    pull = {dof: Harmonic(f, 6.0, 1.8e5 * f / 1e5) for dof, f in swing}

    inertia = turn @ np.diag([4e4, 6e4, 8e4]) @ turn.T
    body = scenes.block(2e4, inertia=inertia, velocity=(*(turn @ (0.3, 0.0, 0.0)), 0.0, 0.0, 0.0))
    forces = {**winches, "pull": scenes.central_force(**pull)}
    return scenes.scene(body, forces, 6.0, 0.1, step=0.01)


def test_a_turned_scene_moves_as_it_did_and_a_mirrored_one_in_its_plane() -> None:
    here, there = hs.simulate(in_the_plane(0.0)), hs.simulate(in_the_plane(1.1))
    turn = np.array([[cos(1.1), -sin(1.1), 0], [sin(1.1), cos(1.1), 0], [0, 0, 1]])
    place = here.position.values[:, 0, :3] @ turn.T
    np.testing.assert_allclose(there.position.values[:, 0, :3], place, atol=1e-10)
    assert np.abs(here.position.values[:, 0, [1, 3, 5]]).max() <= 1e-12
    np.testing.assert_allclose(here.winch_length[:, 0], here.winch_length[:, 1], atol=1e-12)
    assert {STUCK, SLIPPING_OUT, FAST_IN} <= {*np.unique(here.winch_mode)}
