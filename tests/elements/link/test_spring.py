"""Springs between two points: closed forms, and motions integrated apart from hydrosim."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scenes
import xarray as xr
from modes_apart import Event, integrate
from scipy.spatial.transform import Rotation

import hydrosim as hs
from hydrosim.elements import Coulomb, Signal, Spring, StickSlip, Table
from hydrosim.errors import InputError
from hydrosim.report.evidence import Feature, Kind
from hydrosim.run.step_limits import scene_combinations, scene_step_limits
from hydrosim.scene import Body, Kinematics, Method, Scene, Start

EXACT = 1e-7  # of the range of the motion, at the smallest step
ORIGIN = (0.0, 0.0, 0.0)
STRAIGHT = np.array([0.0, 1.0])


def line(
    anchor: tuple[float, ...], length: float | Signal, stiffness: float, **changes: Any
) -> Spring:
    """A straight line from the centre of gravity of the block."""
    spring = Spring("block", ORIGIN, anchor, length, stiffness)
    return replace(spring, **changes)


def first_instant(bodies: Body | tuple[Body, ...], spring: Spring, **solver: Any) -> xr.Dataset:
    return hs.simulate(scenes.scene(bodies, {"line": spring}, 1e-3, 1e-3, **solver)).isel(time=0)


def test_force_and_moment_at_a_known_place() -> None:
    """A body turned by 90 deg about z: its point (2, 0, 1) is at (1, 4, 4) when its centre is at
    (1, 2, 3). The anchor at (4, 0, 16) is 13 m away, 3 m more than the length: with 5 kN/m and
    the end going at 0.1 m/s away from the anchor, 15 kN and 0.1 of 2 kN s/m."""
    away = -np.array([3.0, -4.0, 12.0]) / 13.0
    velocity = (*(0.1 * away), 0.0, 0.0, 0.0)
    body = scenes.block(1e3, position=(1.0, 2.0, 3.0, 0.0, 0.0, pi / 2), velocity=velocity)
    spring = line((4.0, 0.0, 16.0), 10.0, 5e3, point=(2.0, 0.0, 1.0), damping=2e3)
    run = first_instant(body, spring)
    force = -15.2e3 * away
    expected = [*force, *np.cross([0.0, 2.0, 1.0], force)]
    np.testing.assert_allclose(run.force_line[0], expected, rtol=1e-12)
    assert float(run.spring_tension[0]) == pytest.approx(15.2e3, rel=1e-14)
    assert float(run.spring_length[0]) == pytest.approx(13.0, rel=1e-14)
    assert int(run.spring_mode[0]) == 1
    assert float(run.energy_stored_line) == pytest.approx(5e3 * 3.0**2 / 2, rel=1e-12)


@pytest.mark.parametrize(
    ("distance", "tension"),
    [(9.0, 0.0), (10.4, 0.0), (10.75, 50.0), (11.0, 100.0), (12.0, 700.0), (15.0, 2500.0)],
)
def test_tension_is_that_of_the_table(distance: float, tension: float) -> None:
    """Slack before the first point, straight between the points, the last slope beyond."""
    table = np.array([0.5, 1.0, 1.5]), np.array([0.0, 100.0, 400.0])
    spring = Spring("block", ORIGIN, (0.0, 0.0, distance), 10.0, curve=hs.TensionCurve(*table))
    run = first_instant(scenes.block(1e3), spring)
    assert float(run.spring_tension[0]) == pytest.approx(tension, rel=1e-12)
    assert int(run.spring_mode[0]) == (1 if tension else 0)


def test_a_damper_alone_never_pushes() -> None:
    """T = f + c x' where that is positive, and nothing otherwise, stretched as it may be."""
    for speed, tension in ((1.0, 0.0), (0.2, 300.0), (-1.0, 1500.0)):
        body = scenes.block(1e3, velocity=scenes.moving(heave=speed))
        run = first_instant(body, line((0.0, 0.0, 10.5), 10.0, 1e3, damping=1e3))
        assert float(run.spring_tension[0]) == pytest.approx(tension, abs=1e-9)
        assert float(run.energy_stored_line) == pytest.approx(125.0, rel=1e-12)


def test_a_damper_feels_the_pay_out() -> None:
    """T = f + c (l' - L0'): the end comes 0.2 m/s nearer, and the line is hauled in at 0.1 m/s.
    What the line stores and dissipates over 2 s is what it takes from the body and the drum."""
    length = Table(np.array([0.0, 10.0]), np.array([10.0, 9.0]))
    body = scenes.block(1e3, ("heave",), velocity=scenes.moving(heave=0.2))
    spring = line((0.0, 0.0, 10.5), length, 1e3, damping=1e3)
    run = hs.simulate(scenes.scene(body, {"line": spring}, 2.0, 0.01))
    tension = 1e3 * 0.5 - 1e3 * (0.2 - 0.1)
    assert float(run.spring_tension[0, 0]) == pytest.approx(tension, rel=1e-12)
    assert run.energy_residual_relative < 1e-9


@dataclass(frozen=True)
class Lines:
    """A mass on the x axis under a steady ``force``, between lines to anchors at ``anchor`` (n,),
    of one ``length``, one table and one ``damping``, integrated line by line."""

    mass: float
    force: float
    anchor: tuple[float, ...]
    length: float
    extension: np.ndarray
    tension: np.ndarray
    damping: float
    start: tuple[float, float]
    duration: float = 10.0

    def scene(self, step: float, **solver: Any) -> Scene:
        x, v = self.start
        table = (self.length, None, hs.TensionCurve(self.extension, self.tension), self.damping)
        places = enumerate(self.anchor)
        springs = {f"line_{i}": Spring("block", ORIGIN, (a, 0.0, 0.0), *table) for i, a in places}
        body = scenes.block(
            self.mass, ("surge",), position=scenes.moving(surge=x), velocity=scenes.moving(surge=v)
        )
        forces = {"push": scenes.steady(surge=self.force), **springs}
        return scenes.scene(body, forces, self.duration, 0.1, step=step, **solver)

    def stretch(self, i: int, y: np.ndarray) -> tuple[float, float]:
        """Extension of a line and its rate."""
        side = np.sign(self.anchor[i] - y[0])
        return abs(self.anchor[i] - y[0]) - self.length, -side * y[1]

    def damped(self, i: int, piece: int, y: np.ndarray) -> float:
        """f + c x' on a piece of the table, not cut."""
        x, f = self.extension, self.tension
        slope = (f[piece] - f[piece - 1]) / (x[piece] - x[piece - 1])
        stretch, rate = self.stretch(i, y)
        return float(f[piece - 1] + slope * (stretch - x[piece - 1]) + self.damping * rate)

    def rates(self, t: float, y: np.ndarray, modes: tuple[tuple[int, bool], ...]) -> np.ndarray:
        """y' of (x, x'); a mode is the piece, 0 if slack, and whether the damper is cut off."""
        pull = [
            np.sign(self.anchor[i] - y[0]) * self.damped(i, piece, y) if piece and not cut else 0.0
            for i, (piece, cut) in enumerate(modes)
        ]
        return np.array([y[1], (self.force + sum(pull)) / self.mass])

    def ends(self, modes: tuple[tuple[int, bool], ...]) -> list[Event]:
        """Every line's next corner up and down, and its damper cut off or not; snapping taut a line
        pulls, slack it has no damper."""
        found: list[Event] = []
        corners = self.extension

        def watch(i: int, after: tuple[int, bool], function: Callable[[np.ndarray], float]) -> None:
            new = (*modes[:i], after, *modes[i + 1 :])
            found.append((lambda t, y, _: function(y), new))

        for i, (piece, cut) in enumerate(modes):
            if piece < corners.size - 1:
                after = piece + 1, cut and piece > 0
                watch(i, after, lambda y, i=i, k=piece: corners[k] - self.stretch(i, y)[0])
            if piece > 0:
                after = piece - 1, cut and piece > 1
                watch(i, after, lambda y, i=i, k=piece: self.stretch(i, y)[0] - corners[k - 1])
            if piece > 0 and self.damping:
                way = -1.0 if cut else 1.0
                watch(i, (piece, not cut), lambda y, i=i, k=piece, w=way: w * self.damped(i, k, y))
        return found

    def integrate(self, times: np.ndarray) -> tuple[np.ndarray, int]:
        """States (nt, 2) at ``times``, and the number of events."""
        places = [self.stretch(i, np.array(self.start))[0] for i in range(len(self.anchor))]
        modes = tuple((int(np.searchsorted(self.extension[:-1], x)), False) for x in places)
        settings = {"rtol": 1e-12, "atol": 1e-14, "max_step": 0.02}
        motion = integrate(self.rates, self.ends, modes, self.start, times, **settings)
        return motion.states, len(motion.events)


LINES = {
    "bilinear with slack": Lines(
        *(1e4, 0.0, (12.0, -12.0), 12.3, STRAIGHT, 8e4 * STRAIGHT, 0.0), start=(0.0, 2.0)
    ),
    "damped, snapping taut": Lines(
        *(1e4, -1.5e4, (10.0,), 10.0, STRAIGHT, 8e4 * STRAIGHT, 4e3), start=(1.0, 0.0)
    ),
    "table with corners": Lines(
        *(1e4, -3e4, (10.0,), 9.5),
        *(np.array([0.0, 0.4, 0.9, 1.2]), np.array([0.0, 1e4, 5e4, 2e5]), 0.0),
        start=(1.0, 0.0),
    ),
    "table with corners, damped": Lines(
        *(1e4, 0.0, (12.0, -12.0), 11.8),
        *(np.array([0.0, 0.3, 0.6]), np.array([0.0, 1e4, 6e4]), 8e2),
        start=(0.0, 3.0),
    ),
}
STEPS = (0.02, 0.01, 0.005)


@pytest.mark.parametrize("name", LINES)
def test_motion_is_that_of_an_independent_integration(name, figure, validated):
    """To 1e-7 of its range, at order 4, with as many events; the ledger closes at order 4 too."""
    lines = LINES[name]
    runs = [hs.simulate(lines.scene(step)) for step in STEPS]
    states, events = lines.integrate(runs[0].time.values)
    span = np.ptp(states[:, 0])
    errors = np.array([np.abs(scenes.surge(run) - states[:, 0]).max() / span for run in runs])
    residuals = np.array([run.energy_residual_relative for run in runs])
    figure("order", scenes.observed_orders(STEPS, errors).mean())
    figure("order of the ledger", scenes.observed_orders(STEPS, residuals).mean())
    claim = "block on lines that go slack and taut, of its range"
    against = "DOP853 by events"
    validated(Kind.INDEPENDENT, claim, against, errors[-1], EXACT, Feature.SPRINGS)
    assert scenes.observed_orders(STEPS, errors).mean() >= 3.7
    assert residuals[-1] <= EXACT
    assert scenes.observed_orders(STEPS, residuals).mean() >= 3.7
    assert [run.solver_events for run in runs] == [events] * len(runs)
    assert events >= 6  # that there is something to hit
    assert {0, 1} == set(np.unique(runs[0].spring_mode))


def test_without_events_the_order_is_lost() -> None:
    lines, steps = LINES["damped, snapping taut"], (0.02, 0.005)
    runs = [hs.simulate(lines.scene(step, events=False)) for step in steps]
    exact = lines.integrate(runs[0].time.values)[0][:, 0]
    errors = np.array([np.abs(scenes.surge(run) - exact).max() for run in runs])
    assert scenes.observed_orders(steps, errors)[0] <= 2.2
    assert errors[-1] >= 100 * EXACT * np.ptp(exact)


@pytest.mark.parametrize("method", [Method.DOPRI5, Method.ESDIRK4])
def test_other_methods_go_through_the_same_events(method: Method) -> None:
    lines = LINES["table with corners, damped"]
    run = hs.simulate(lines.scene(0.005, method=method))
    states, events = lines.integrate(run.time.values)
    assert run.solver_events == events
    np.testing.assert_allclose(scenes.surge(run), states[:, 0], atol=1e-4 * np.ptp(states[:, 0]))


def test_an_elastic_pendulum(figure) -> None:
    """A body on a line in three dimensions as DOP853 has it; the line goes slack on the way."""
    m, g, k, L = 1e3, 9.81, 4e4, 10.0
    steps = (0.005, 0.0025, 0.00125)
    start, speed = np.array([6.0, 0.0, 8.5]), np.array([0.0, 1.0, 0.0])
    top = np.array([0.0, 0.0, 16.0])
    at = {"position": (*start, 0, 0, 0), "velocity": (*speed, 0, 0, 0)}
    body = scenes.block(m, ("surge", "sway", "heave"), **at)
    forces = {"weight": scenes.steady(heave=-m * g), "line": line(tuple(top), L, k)}
    runs = [hs.simulate(scenes.scene(body, forces, 10.0, 0.1, step=h)) for h in steps]

    def rates(t: float, y: np.ndarray, taut: bool) -> np.ndarray:
        d = top - y[:3]
        length = np.linalg.norm(d)
        pull = (k * (length - L) / length if taut else 0.0) * d
        return np.concatenate([y[3:], pull / m + [0.0, 0.0, -g]])

    def end(t: float, y: np.ndarray, taut: bool) -> float:
        return (np.linalg.norm(top - y[:3]) - L) * (1 if taut else -1)

    taut, launch = bool(np.linalg.norm(top - start) > L), [*start, *speed]
    ends, times = lambda taut: [(end, not taut)], runs[0].time.values
    motion = integrate(rates, ends, taut, launch, times, max_step=0.02)
    exact, events = motion.states[:, :3], len(motion.events)
    found = [run.position.values[:, 0, :3] for run in runs]
    errors = np.array([np.abs(x - exact).max() / np.ptp(exact) for x in found])
    figure("order", scenes.observed_orders(steps, errors).mean())
    figure("error", errors[-1])
    assert errors[-1] <= EXACT
    assert scenes.observed_orders(steps, errors).mean() >= 3.7
    assert events >= 2
    assert all(run.solver_events == events for run in runs)


def two_bodies(step: float, **changes: Any) -> Scene:
    """Two free bodies that fly apart on a line between corners of them, and turn each other."""
    left = scenes.block(2e3, location=(-3.0, 0.0), velocity=(-1.0, 0.2, 0.1, 0.3, -0.2, 0.1))
    right = scenes.block(
        5e3, name="other", location=(4.0, 1.0), velocity=(0.5, 0.0, -0.2, 0.0, 0.1, -0.2)
    )
    curve = np.array([0.0, 0.3, 0.8]), np.array([0.0, 2e3, 2e4])
    ends = ("block", (0.5, 0.6, -0.4), (-0.7, -0.5, 0.8))
    spring = Spring(*ends, 6.0, curve=hs.TensionCurve(*curve), anchor_body="other")
    return replace(scenes.scene((left, right), {"line": spring}, 10.0, 0.1, step=step), **changes)


def test_two_bodies_keep_their_momentum(figure) -> None:
    """Momentum is kept; angular momentum and energy but for an error of order 4."""
    drifts, losses, steps = [], [], (0.02, 0.01)
    for step in steps:
        whole = two_bodies(step)
        run = hs.simulate(whole)
        linear, angular = scenes.momenta(run, whole.bodies)
        assert np.abs(linear - linear[0]).max() <= 1e-9 * np.abs(linear).max()
        drifts.append(np.abs(angular - angular[0]).max() / np.abs(angular).max())
        losses.append(run.energy_residual_relative)
    figure("angular momentum lost", drifts[-1])
    figure("energy lost", losses[-1])
    assert run.solver_events >= 4
    assert drifts[-1] <= 1e-7
    assert losses[-1] <= 1e-7
    assert scenes.observed_orders(steps, np.array(drifts))[0] >= 3.5
    assert scenes.observed_orders(steps, np.array(losses))[0] >= 3.5


def test_energy_with_small_angles() -> None:
    """Lever arms at rest, and a line that follows its ends: what it does is what it gives up."""
    small = two_bodies(0.01)
    small = scenes.with_step(small, 0.01, kinematics=Kinematics.LINEAR)
    run = hs.simulate(small)
    assert run.spring_tension.max() > 1e3
    assert run.energy_residual_relative <= 1e-7


def turned(body: Body, angle: float, turn: np.ndarray) -> Body:
    """A body without initial offsets in a scene turned by ``angle`` about z."""
    velocity = (*(turn @ body.velocity[:3]), *(turn @ body.velocity[3:]))
    location = tuple((turn @ [*body.location, 0.0])[:2])
    return replace(body, location=location, position=scenes.moving(yaw=angle), velocity=velocity)


def test_a_turned_scene_moves_as_it_did(figure) -> None:
    """Bodies, anchors and points turned about z: motion and wrenches turn, through five events."""
    angle = 1.1
    turn = Rotation.from_euler("z", angle).as_matrix()
    here = two_bodies(0.01)
    earth = Spring(
        "other",
        (0.2, 0.1, 0.3),
        (-5.0, 2.0, 3.0),
        9.5,
        curve=hs.TensionCurve(STRAIGHT, 3000.0 * STRAIGHT),
        damping=200.0,
    )
    here = replace(here, forces={**here.forces, "earth": earth})
    springs = {**here.forces, "earth": replace(earth, anchor=tuple(turn @ earth.anchor))}
    bodies = tuple(turned(b, angle, turn) for b in here.bodies)
    there = replace(here, bodies=bodies, forces=springs)
    found, expected = hs.simulate(there), hs.simulate(here)
    place = np.einsum("ij,tbj->tbi", turn, expected.position.values[:, :, :3])
    difference = np.abs(found.position.values[:, :, :3] - place).max() / np.ptp(place)
    figure("difference", float(difference))
    assert found.solver_events == expected.solver_events >= 5
    assert difference <= 1e-10
    angles = expected.position.values[:, :, 3:] + [0.0, 0.0, angle]
    np.testing.assert_allclose(found.position[:, :, 3:], angles, atol=1e-10)
    tension = expected.spring_tension.values
    np.testing.assert_allclose(found.spring_tension, tension, atol=1e-8 * tension.max())


@pytest.mark.parametrize("name", ["damped, snapping taut", "table with corners, damped"])
def test_a_restart_goes_on_to_the_bit(name: str, tmp_path: Path) -> None:
    """From any output time, through files: slack, taut, with the damper cut off or not."""
    whole = LINES[name].scene(0.05).with_output(states=True)
    run = hs.simulate(whole)
    assert ((run.spring_mode == 0) & (run.spring_segment.values > 0)).any()
    names = ("position", "velocity", "spring_tension", "spring_mode", "force_line_0")
    scenes.assert_continues(whole, run, run.time.values[:-1:7], *names, file=tmp_path / "run.nc")


def test_lines_may_be_other_ones_after_a_restart() -> None:
    """Fewer pieces, another length, another name: modes that cannot be are found anew."""
    lines = LINES["table with corners"]
    before = hs.simulate(replace(lines.scene(0.01), duration=1.2))
    assert before.spring_segment[-1, 0] == 3
    again = replace(lines.scene(0.01), duration=0.5, initial=Start(before))
    same, old = hs.simulate(again), again.forces["line_0"]
    others = (replace(old, stiffness=8e4, curve=None), replace(old, length=11.0))
    for other in others:
        forces = {**again.forces, "line_0": other}
        named = {"push": again.forces["push"], "another": other}
        kept, new = (hs.simulate(replace(again, forces=f)) for f in (forces, named))
        np.testing.assert_array_equal(kept.position, new.position)
        assert not np.array_equal(kept.position, same.position)
        assert kept.energy_residual_relative <= 1e-5


def on_a_floor(law: StickSlip | Coulomb, height: float, **lines: Spring) -> Scene:
    """A block on two points that is thrown on a floor from a ``height``."""
    start = {"position": scenes.moving(heave=height), "velocity": scenes.moving(surge=2.0)}
    body = scenes.block(1e4, ("surge", "heave"), **start)
    floor = scenes.on_floor(2e7, law, points=((0.5, 0.0, 0.0), (-0.5, 0.2, 0.0)))
    forces = {"weight": scenes.steady(heave=-1e5), **lines, "floor": floor}
    return scenes.scene(body, forces, 3.0, 0.1, step=0.005)


STEEL = StickSlip(0.3, 0.2, 2e6, 4e4, 1e4)
STERN = line((-9.6, 0.0, 0.5), 10.0, 3e5)


def test_lines_and_fenders_keep_their_own_modes(figure) -> None:
    """A line that stays slack changes no digit of what a block does on a floor; one that stops the
    block is taut for a while, in which the fenders slip and stick, and the ledger closes; a run
    with both goes on to the bit after a restart."""
    far = line((50.0, 0.0, 0.0), 100.0, 1e6, damping=1e4)
    without, slack = (hs.simulate(on_a_floor(STEEL, 0.02, **lines)) for lines in ({}, {"far": far}))
    for name in ("position", "fender_mode", "fender_friction", "fender_segment"):
        np.testing.assert_array_equal(slack[name], without[name])
    assert slack.solver_events == without.solver_events >= 5
    both = on_a_floor(STEEL, 0.02, far=far, stern=STERN).with_output(states=True)
    run = hs.simulate(both)
    figure("residual", run.energy_residual_relative)
    assert run.energy_residual_relative <= 5e-6
    assert {0, 1} == set(np.unique(run.spring_mode.sel(spring="stern")))
    assert set(np.unique(run.fender_mode)) == {0, 1, 2}
    names = ("position", "fender_mode", "spring_mode", "spring_tension")
    scenes.assert_continues(both, run, (0.4, 0.7), *names)


def test_rigid_friction_holds_a_block_on_a_line() -> None:
    """The line stops and returns the block, which rests where friction exceeds the tension."""
    thrown = on_a_floor(Coulomb(0.3, 0.2), -0.005, stern=STERN)
    floor = replace(thrown.forces["floor"], points=np.zeros((1, 3)))
    run = hs.simulate(replace(thrown, forces={**thrown.forces, "floor": floor}))
    assert run.fender_mode[-1, 0] == 1
    assert run.velocity[-1, 0, 0] == 0.0
    assert run.spring_tension.max() > 3e4
    assert run.energy_residual_relative <= 1e-5


def on_steps(step: float, **springs: Spring) -> Scene:
    body = scenes.block(1e4, ("surge",), name="block")
    return scenes.scene(body, springs, 1.0, step, method=Method.RK4)


def test_step_limits_are_those_of_slack_and_of_the_steepest_piece() -> None:
    """2 sqrt(2) over sqrt(k/m) of the last piece; 2.785 over the larger root of a strong damper."""
    corners, tension = np.array([0.0, 1.0, 2.0]), np.array([0.0, 1e3, 1e6])
    steep = replace(
        line((10.0, 0, 0), 12.0, 1.0), stiffness=None, curve=hs.TensionCurve(corners, tension)
    )
    limited = on_steps(0.01, line=steep)
    (limit,) = scene_step_limits(hs.compile_scene(limited))
    k = (1e6 - 1e3) / 1e4
    assert limit.step == pytest.approx(2 * sqrt(2) / sqrt(k), rel=2e-3)
    assert (limit.what, limit.contact) == ("surge of block", "no contact, springs taut")
    c = 4e5 / 1e4
    limited = on_steps(0.01, line=replace(steep, damping=4e5))
    (limit,) = scene_step_limits(hs.compile_scene(limited))
    assert limit.step == pytest.approx(2.7853 / (c / 2 + sqrt(c * c / 4 - k)), rel=3e-3)


def test_a_step_limit_names_the_spring_if_asked() -> None:
    """Two lines that hold two bodies: each one alone has the limit of its own body."""
    bodies = (scenes.block(1e4, ("surge",)), scenes.block(1e4, ("surge",), name="tug"))
    hard = line((10.0, 0, 0), 5.0, 1e6, body="tug")
    lines = {"soft": line((10.0, 0, 0), 12.0, 1e4), "hard": hard}
    held = scenes.scene(bodies, lines, 1.0, 0.5, step=0.5)
    whole = hs.compile_scene(held)
    limits = scene_step_limits(whole, scene_combinations(whole, each_alone=True))
    assert limits[0].what == "surge of tug"
    assert limits[0].contact in ("no contact, springs taut", "no contact, hard alone taut")


def test_the_record_says_what_it_holds() -> None:
    run = hs.simulate(two_bodies(0.02, duration=1.0))
    assert list(run.spring.values) == ["line"]
    assert run.spring_tension.dims == run.spring_length.dims == ("time", "spring")
    assert (run.spring_tension.units, run.spring_length.units) == ("N", "m")
    assert run.spring_mode.flag_meanings == "slack taut absent"
    assert all(v.long_name and v.frame for v in run.data_vars.values())
    places = run.position.values[:, :, :3] + run.reference_position.values
    turns = [Rotation.from_euler("ZYX", run.position.values[:, b, :2:-1]) for b in (0, 1)]
    ends = (0.5, 0.6, -0.4), (-0.7, -0.5, 0.8)
    a, b = (places[:, i] + turns[i].apply(ends[i]) for i in (0, 1))
    np.testing.assert_allclose(run.spring_length[:, 0], np.linalg.norm(a - b, axis=1), rtol=1e-12)
    other = hs.simulate(scenes.scene(scenes.block(1.0), {}, 1.0, 0.5))
    assert "spring" not in other.dims


def test_ends_at_one_place_are_refused() -> None:
    body = scenes.block(1e3, position=scenes.moving(surge=2.0))
    spring = line((1.0, 1.0, 1.0), 10.0, 1e3, point=(-1.0, 1.0, 1.0))
    with pytest.raises(hs.InputError, match=r"forces\.line: its point and its anchor are at the"):
        hs.compile_scene(scenes.scene(body, {"line": spring}, 1.0, 0.1))
    astray = replace(spring, anchor_body="ghost")
    said = r"forces\.line\.anchor_body: found ghost, which is no body of the scene"
    with pytest.raises(hs.InputError, match=said):
        hs.compile_scene(scenes.scene(body, {"line": astray}, 1.0, 0.1))


def test_a_line_does_not_part_before_the_start() -> None:
    with pytest.raises(InputError, match=r"breaks_at.*found time -5 s; expected a time of the run"):
        hs.Spring("block", (0, 0, 0), (1, 0, 0), 0.5, 1e3, breaks_at={"time": "-5 s"})
