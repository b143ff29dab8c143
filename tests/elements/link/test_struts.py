"""Struts, torsion springs and power take-offs: closed forms, balances, large rotations."""

from dataclasses import replace
from math import pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scenes import (
    Acting,
    assert_continues,
    block,
    central_force,
    momenta,
    moving,
    observed_orders,
    scene,
    steady,
    surge,
    turned_scene,
    with_motions,
)
from scipy.interpolate import CubicHermiteSpline
from scipy.spatial.transform import Rotation

import hydrosim as hs
from hydrosim.elements import Bushing, Harmonic, Strut, TorsionSpring
from hydrosim.errors import SimulationError
from hydrosim.integrate.dynamics import new_work, rhs
from hydrosim.linear.linearise import linearise
from hydrosim.linear.modes import natural_modes
from hydrosim.report.evidence import Feature, Kind
from hydrosim.results.channels import channel_series
from hydrosim.run.step_limits import scene_step_limits
from hydrosim.scene import ForceElement, Kinematics, Method, Symmetry, Weight

ORIGIN = (0.0, 0.0, 0.0)
NONE = np.zeros(0)
STRAIGHT = np.array([0.0, 1.0])
M, K = 1e3, 4e4
OMEGA = sqrt(K / M)
TIGHT = hs.Tolerance(1e-13, 1e-13, 1e-14)


def strut(stiffness: float = K, **changes: Any) -> Strut:
    """Along the x axis to an anchor 10 m from the centre of gravity at rest."""
    given = {"point": ORIGIN, "anchor": (10.0, 0.0, 0.0), "stiffness": stiffness}
    return Strut("block", **{**given, **changes})


def torsion(stiffness: float, axis: tuple[float, ...] = (0.0, 0.0, 1.0), **changes: Any):
    return TorsionSpring("block", axis, stiffness=stiffness, **changes)


def along(x: float, v: float, link: ForceElement, duration: float = 5.0, **solver: Any) -> hs.Scene:
    body = block(M, ("surge",), position=moving(surge=x), velocity=moving(surge=v))
    return scene(body, {"link": link}, duration, 0.05, **{"step": 0.01, **solver})


def assert_order(
    figure, steps: tuple[float, ...], found: list[np.ndarray], exact: np.ndarray
) -> float:
    """Errors at these steps fall with an order of 3.8 at least; the last one, of the range."""
    errors = np.array([np.abs(x - exact).max() for x in found]) / np.ptp(exact)
    order = observed_orders(steps, errors).mean()
    figure("order", order)
    assert order >= 3.8
    return errors[-1]


STEPS = (0.0125, 0.00625, 0.003125)


def test_a_mass_on_a_strut_swings_to_both_sides(figure, validated):
    """x = x0 cos(w t): the strut pushes for half of the period; order 4."""
    runs = [hs.simulate(along(1.5, 0.0, strut(), step=h)) for h in STEPS]
    exact = 1.5 * np.cos(OMEGA * runs[0].time.values)
    error = assert_order(figure, STEPS, [surge(run) for run in runs], exact)
    claim = "mass on a strut that pushes and pulls, of its range"
    validated(Kind.CLOSED_FORM, claim, "cosine", error, 1e-7, Feature.STRUTS)
    force = runs[-1].strut_force.values[:, 0]
    np.testing.assert_allclose(force, -K * surge(runs[-1]), atol=1e-9 * K)
    assert force.min() < -1.4 * K
    assert force.max() > 1.4 * K
    assert float(runs[-1].strut_length[0, 0]) == pytest.approx(8.5)
    assert runs[-1].energy_residual_relative < 1e-7


def bilinear(t: np.ndarray, x0: float, pull: float, push: float) -> np.ndarray:
    """x of a mass that starts at rest in compression, x0 > 0: half periods of both stiffnesses."""
    fast, slow = sqrt(push / M), sqrt(pull / M)
    period = pi / fast + pi / slow
    s = np.mod(t + 0.5 * pi / fast, period)  # since it went into compression
    out = -x0 * fast / slow * np.sin(slow * (s - pi / fast))
    return np.where(s < pi / fast, x0 * np.sin(fast * s), out)


BENT = {"stiffness": None, "curve": hs.StrutCurve((-1.0, 0.0, 1.0), (-9e4, 0.0, 1e4))}


def test_order_four_through_the_corner_of_a_curve(figure, validated):
    """Nine times as stiff in compression: half periods in closed form. The corner is an event."""
    link = replace(strut(), **BENT)
    runs = [hs.simulate(along(0.7, 0.0, link, 6.0, step=h)) for h in STEPS]
    exact = bilinear(runs[0].time.values, 0.7, 1e4, 9e4)
    error = assert_order(figure, STEPS, [surge(run) for run in runs], exact)
    claim = "mass on a strut that is stiffer in compression, of its range"
    validated(Kind.CLOSED_FORM, claim, "half periods", error, 1e-7, Feature.STRUTS)
    assert all(run.solver_events >= 6 for run in runs)
    assert runs[-1].energy_residual_relative < 1e-6
    blind = hs.simulate(along(0.7, 0.0, link, 6.0, step=0.003125, events=False))
    assert np.abs(surge(blind) - exact).max() > 100 * error * np.ptp(exact)


@pytest.mark.parametrize("dof", ["roll", "yaw"])
def test_a_torsion_pendulum_swings_by_several_turns(dof, figure, validated):
    """phi0 cos(w t), phi0 of 1.5 turns: linear at any angle; a restart goes on to the bit."""
    axis = 3 + ("roll", "pitch", "yaw").index(dof)
    inertia = np.diag([2e3, 3e3, 4e3])
    k, amplitude = 8e3, 3.0 * pi
    omega = sqrt(k / inertia[axis - 3, axis - 3])
    body = block(M, (dof,), inertia=inertia, velocity=moving(**{dof: amplitude * omega}))
    spring = torsion(k, tuple(np.eye(3)[axis - 3]))
    scenes = [scene(body, {"spring": spring}, 8.0, 0.1, step=h) for h in (0.02, 0.01)]
    scenes = [whole.with_output(states=True) for whole in scenes]
    runs = [hs.simulate(whole) for whole in scenes]
    exact = amplitude * np.sin(omega * runs[0].time.values)
    angles = [run.torsion_angle.values[:, 0] for run in runs]
    error = assert_order(figure, (0.02, 0.01), angles, exact)
    claim = "torsion pendulum over three turns, of its range"
    validated(Kind.CLOSED_FORM, claim, "sine", error, 1e-7, Feature.STRUTS)
    np.testing.assert_allclose(runs[-1].torsion_moment[:, 0], k * exact, atol=1e-6 * k * amplitude)
    np.testing.assert_allclose(runs[-1].position[:, 0, axis], exact, atol=1e-5)
    assert runs[-1].energy_residual_relative < 1e-6
    assert_continues(scenes[-1], runs[-1], (1.0, 2.3), "position", "torsion_angle")


def load_on(element: ForceElement, turns: list[Rotation], shift: np.ndarray) -> tuple[Any, float]:
    """Wrench (2, 6) on two bodies with these rotations, the first one shifted, and the energy."""
    places = zip(("block", "other"), turns, (shift, np.zeros(3)), strict=True)
    angles = [(name, (*at, *turn.as_euler("ZYX")[::-1])) for name, turn, at in places]
    bodies = [block(1e3, name=name, position=position) for name, position in angles]
    model, state = hs.compile_scene(scene(bodies, {"it": element}, 1.0, 0.1))
    work, dy = new_work(model), np.zeros(model.size)
    rhs(0.0, state.y, state.modes, state.history, model, work, dy)
    stored = hs.simulate(scene(bodies, {"it": element}, 1e-4, 1e-4)).energy_stored_it
    return work.wrench[4].reshape(2, 6).copy(), float(stored[0])


def twist_of(turns: list[Rotation], axis: np.ndarray) -> float:
    """Swing-twist by quaternions, apart from hydrosim."""
    x, y, z, w = (turns[1].inv() * turns[0]).as_quat()
    return float(2.0 * np.arctan2(np.dot([x, y, z], axis), w))


def wrapped(angle: float) -> float:
    return float((angle + pi) % (2 * pi) - pi)


def test_the_twist_is_that_of_quaternions_and_its_moment_the_gradient(figure) -> None:
    """Twelve pairs of rotations: moments against differences of k phi^2 / 2 by quaternions."""
    random = np.random.default_rng(3)
    axis = np.array([0.3, -0.5, 0.8])
    axis /= np.linalg.norm(axis)
    k, eps, worst = 7e3, 1e-5, 0.0
    spring = torsion(k, tuple(2.0 * axis), to="other")
    for _ in range(12):
        turns = [Rotation.from_rotvec(random.uniform(-1.5, 1.5, 3)) for _ in range(2)]
        wrench, stored = load_on(spring, turns, np.zeros(3))
        angle = wrapped(twist_of(turns, axis))
        assert stored == pytest.approx(0.5 * k * angle**2, rel=1e-9)

        def energy(body: int, turn: np.ndarray, turns: list[Rotation] = turns) -> float:
            moved = [*turns]
            moved[body] = Rotation.from_rotvec(turn) * moved[body]
            return 0.5 * k * wrapped(twist_of(moved, axis)) ** 2

        for body in (0, 1):
            sides = [(energy(body, eps * e), energy(body, -eps * e)) for e in np.eye(3)]
            gradient = [(up - down) / (2 * eps) for up, down in sides]
            scale = np.abs(gradient).max()
            worst = max(worst, float(np.abs(wrench[body, 3:] + gradient).max() / scale))
    figure("worst", worst)
    assert worst < 1e-7


def pair(*, joined: dict[str, ForceElement], **changes: Any) -> hs.Scene:
    left = block(2e3, location=(-3.0, 0.0), velocity=(-0.5, 0.2, 0.1, 0.9, -0.6, 0.4))
    right = block(5e3, name="other", location=(2.0, 1.0), velocity=(0.2, 0.0, -0.1, -0.5, 0.4, 0.3))
    solver = {"method": Method.DOPRI5, "tolerance": TIGHT, "step": 0.01}
    return replace(scene((left, right), joined, 4.0, 0.1, **solver), **changes)


FEATURES = {"strut": Feature.STRUTS, "torsion spring": Feature.STRUTS, "bushing": Feature.BUSHINGS}
BETWEEN = {"anchor": (-0.7, -0.5, 0.8), "anchor_body": "other", "length": 4.0}
SOFT = np.diag([3e3, 5e3, 4e3, 2e3, 3e3, 1e3])
JOINED: dict[str, dict[str, ForceElement]] = {
    "strut": {"it": strut(2e3, point=(0.5, 0.6, -0.4), **BETWEEN)},
    "torsion spring": {"it": torsion(9e3, (0.3, 0.4, 0.5), to="other", neutral=0.2)},
    "bushing": {"it": Bushing("block", (2.5, 0.5, 0.0), SOFT, np.zeros((6, 6)), "other")},
}


@pytest.mark.parametrize("name", JOINED)
def test_a_free_pair_keeps_its_momenta_and_its_energy(name, figure, validated):
    """Two bodies that tumble by large angles, joined by nothing else."""
    whole = pair(joined=JOINED[name])
    run = hs.simulate(whole)
    linear, angular = momenta(run, whole.bodies)
    lost = [np.abs(p - p[0]).max() / np.abs(p).max() for p in (linear, angular)]
    figure("linear", lost[0])
    figure("angular", lost[1])
    figure("energy", run.energy_residual_relative)
    assert np.abs(run.force_it).max() > 1e2
    claim = f"momenta of two free bodies joined by a {name}, relative"
    validated(Kind.CLOSED_FORM, claim, "constant", max(lost), 1e-12, FEATURES[name])
    total = (run.energy_kinetic + run.energy_stored_it).values
    assert np.ptp(total) <= 1e-12 * float(total.max())


def test_a_turned_scene_moves_as_it_did(figure) -> None:
    """All three between the bodies, damped, and to the earth; the whole turned about z."""
    tied, twisted = (replace(JOINED[k]["it"], damping=3e2) for k in ("strut", "torsion spring"))
    soft = replace(JOINED["bushing"]["it"], damping=np.diag([2e2] * 6))
    held, twist = strut(1e3, anchor=(-7.0, 3.0, 1.0)), torsion(1e3, (0.0, 0.6, 0.8))
    forces = {"a": tied, "b": twisted, "c": soft, "earth": held, "twist": twist}
    forces["post"] = replace(soft, to=None)
    here = pair(joined=forces)
    turn = Rotation.from_euler("z", 1.1).as_matrix()
    expected, found = hs.simulate(here), hs.simulate(turned_scene(here, 1.1))
    place = expected.position.values[:, :, :3] @ turn.T
    difference = np.abs(found.position.values[:, :, :3] - place).max() / np.ptp(place)
    figure("difference", difference)
    assert difference < 1e-9
    np.testing.assert_allclose(found.position[:, :, 3:], expected.position[:, :, 3:], atol=1e-9)
    for name in ("strut_force", "torsion_moment", "bushing_load", "bushing_displacement"):
        size = float(np.abs(expected[name]).max())
        np.testing.assert_allclose(found[name], expected[name], atol=1e-9 * size)


C, FORCE, PERIOD = 3e3, 5e3, 4.0


def absorbing(rotary: bool) -> tuple[hs.Scene, float]:
    """A driven oscillator that starts on its steady motion, and its amplitude squared."""
    w = 2 * pi / PERIOD
    amplitude = FORCE / complex(K - w * w * M, w * C)
    x, v = amplitude.imag, (1j * w * amplitude).imag  # of Im(X exp(i w t))
    dof, slot = ("yaw", 5) if rotary else ("surge", 0)
    at = {"position": tuple(np.eye(6)[slot] * x), "velocity": tuple(np.eye(6)[slot] * v)}
    body = block(M, (dof,), inertia=np.diag([M, M, M]), **at)
    link = (
        torsion(K, damping=C, type="rotary_power_take_off")
        if rotary
        else strut(damping=C, type="power_take_off")
    )
    push = central_force(**{dof: Harmonic(FORCE, PERIOD)})
    driven = scene(body, {"pto": link, "push": push}, 10 * PERIOD, 0.05, step=0.01)
    return driven, abs(amplitude) ** 2


@pytest.mark.parametrize("rotary", [False, True])
def test_mean_power_of_a_power_take_off(rotary, figure, validated):
    """c w^2 a^2 / 2 of the steady motion, as energy over ten periods and as mean of the record."""
    driven, squared = absorbing(rotary)
    run = hs.simulate(driven)
    expected = 0.5 * C * (2 * pi / PERIOD) ** 2 * squared
    power = run.pto_power.sel(pto="pto").values
    energy = float(run.energy_dissipated_pto[-1] - run.energy_dissipated_pto[0])
    found = energy / (10 * PERIOD)
    error = abs(found / expected - 1.0)
    figure("error", error)
    claim = "mean power of a power take-off, relative"
    validated(Kind.CLOSED_FORM, claim, "c w^2 a^2 / 2", error, 1e-7, Feature.STRUTS)
    assert power[:-1].mean() == pytest.approx(expected, rel=1e-6)
    assert power.min() >= 0.0
    assert float(run.energy_work_push[-1]) == pytest.approx(energy, rel=1e-6)


def test_quadratic_damping_decays_as_its_first_integral_says(figure) -> None:
    """(1 + b x1) exp(-b x1) = (1 - b x2) exp(b x2) with b = 2 d / m for successive extremes."""
    d = 600.0
    damped = along(1.0, 0.0, strut(quadratic_damping=d), 4.0, step=0.005)
    run = hs.simulate(damped.with_output(step=0.01))
    motion = CubicHermiteSpline(run.time.values, surge(run), run.velocity.values[:, 0, 0])
    ends = motion.derivative().roots(extrapolate=False)
    extremes = np.abs(motion(ends[ends > 0.01]))
    b = 2 * d / M
    left = (1 + b * extremes[:-1]) * np.exp(-b * extremes[:-1])
    right = (1 - b * extremes[1:]) * np.exp(b * extremes[1:])
    assert extremes.size > 5
    figure("error", np.abs(left - right).max())
    np.testing.assert_allclose(left, right, rtol=1e-6)
    assert run.energy_residual_relative < 1e-7


@pytest.mark.parametrize("length", [9.0, 10.0, 11.0])
def test_the_stiffness_of_a_strut_in_the_linear_analysis(length: float) -> None:
    """k along the line, T/L across it (a strut that pushes makes it negative)."""
    body = block(M, ("surge", "sway"))
    held = scene(body, {"it": strut(length=length)}, 1.0, 0.1)
    linear = linearise(*hs.compile_scene(held))
    T = K * (10.0 - length)
    stiffness = -M * linear.jacobian[2:4, :2]
    np.testing.assert_allclose(stiffness, np.diag([K, T / 10.0]), atol=1e-5 * K)


def test_a_power_take_off_without_stiffness_in_the_linear_analysis() -> None:
    """Damping c and nothing else; a body that only it holds has a free mode, and a step limit."""
    body = block(M, ("surge", "yaw"))
    forces = {"pto": strut(0.0, damping=C, type="power_take_off"), "turn": torsion(0.0, damping=C)}
    compiled = hs.compile_scene(scene(body, forces, 1.0, 0.1))
    linear = linearise(*compiled)
    np.testing.assert_allclose(linear.jacobian[2:, :2], 0.0, atol=1e-9)
    assert linear.jacobian[2, 2] == pytest.approx(-C / M, rel=1e-9)
    assert {mode.natural_period for mode in natural_modes(linear)} == {np.inf}
    (limit, *_) = scene_step_limits(compiled)
    assert limit.step == pytest.approx(2.7853 * M / C, rel=3e-3)


def test_step_limits_are_those_of_the_steepest_piece() -> None:
    """RK4's 2 sqrt(2) over sqrt(k/m) of the stiff end, though the strut starts on the soft one."""
    curve = np.array([-1.0, -0.5, 0.0]), np.array([-1e5, -1e3, 0.0])
    link = replace(strut(), stiffness=None, curve=hs.StrutCurve(*curve))
    compiled = hs.compile_scene(along(-0.5, 0.0, link))
    (limit, *_) = scene_step_limits(compiled)
    assert limit.step == pytest.approx(2 * sqrt(2) / sqrt((1e5 - 1e3) / 0.5 / M), rel=2e-3)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_weight_stands_on_a_strut_or_hangs_on_it(side: float) -> None:
    """At rest it has sunk by m g / k, whether the strut is below it or above."""
    body = block(M, ("heave",), weight=Weight.CARRIED)
    link = strut(anchor=(0.0, 0.0, 10.0 * side))
    run = hs.simulate(replace(scene(body, {"it": link}, 2.0, 0.1, step=0.01), at_rest=True))
    np.testing.assert_allclose(run.position[:, 0, 2], -M * 9.81 / K, rtol=1e-9)
    np.testing.assert_allclose(run.strut_force[:, 0], side * M * 9.81, rtol=1e-9)


def test_links_that_act_for_a_time() -> None:
    """Begun and let go stretched: energies booked, no event and no load while absent."""
    brief = hs.Active(hs.When(0.4), hs.When(1.5))
    offset, force = np.array([-1.0, 0.2, 1.0]), np.array([-8e3, 0.0, 9e3])
    curve = hs.StrutCurve(offset, force)
    corner = replace(strut(), stiffness=None, curve=curve, active=brief)
    body = block(M, ("surge", "yaw"), velocity=moving(surge=-1.0, yaw=0.5))
    forces = {"strut": corner, "spring": torsion(8e3, active=brief)}
    run = hs.simulate(scene(body, forces, 3.0, 0.05, step=0.01))
    t = run.time.values
    on = (t > 0.4 + 1e-9) & (t < 1.5 - 1e-9)
    off = (t < 0.4 - 1e-9) | (t > 1.5 + 1e-9)
    assert not run.strut_force.values[off].any()
    assert np.abs(run.torsion_moment.values[on]).min() > 0.0
    assert run.link_mode.flag_meanings == "acting absent"
    assert run.energy_residual_relative < 1e-8
    speeds = run.velocity.values[:, 0, [0, 5]]
    np.testing.assert_array_equal(speeds[t < 0.4], np.tile(speeds[0], ((t < 0.4).sum(), 1)))
    np.testing.assert_allclose(speeds[t > 1.5], np.tile(speeds[-1], ((t > 1.5).sum(), 1)))


def test_ends_that_meet_are_refused_or_end_the_run() -> None:
    with pytest.raises(hs.InputError, match=r"forces\.link: its ends meet .* at the start"):
        hs.compile_scene(along(10.0, 0.0, strut()))
    shot = along(0.0, 20.0, strut(0.0, damping=1.0), 3.0)
    with pytest.raises(SimulationError, match=r"at t = 0\.5 s the force of link is lost: its ends"):
        hs.simulate(shot)


def test_a_swing_to_the_opposite_ends_the_run() -> None:
    body = block(M, ("roll",), velocity=moving(roll=1.0))
    spring = torsion(0.0, (0.0, 1.0, 0.0), damping=1e-6)
    with pytest.raises(SimulationError, match=r"the force of spring is lost: its axis has swung"):
        hs.simulate(scene(body, {"spring": spring}, 5.0, 0.1, step=0.05))


def test_small_angles_keep_the_balance() -> None:
    """Lever arms at rest: what both do is what they give up."""
    whole = pair(joined={"a": JOINED["strut"]["it"], "b": JOINED["torsion spring"]["it"]})
    solver = replace(whole.solver, kinematics=Kinematics.LINEAR)
    run = hs.simulate(replace(whole, solver=solver))
    total = (run.energy_kinetic + run.energy_stored_a + run.energy_stored_b).values
    assert np.ptp(total) <= 1e-11 * float(total.max())
    angle = run.position.values[:, 0, 3:] - run.position.values[:, 1, 3:]
    axis = np.array([0.3, 0.4, 0.5]) / sqrt(0.5)
    np.testing.assert_allclose(run.torsion_angle[:, 0], angle @ axis, atol=1e-12)


def test_a_restart_goes_on_to_the_bit(tmp_path: Path) -> None:
    """Through files, from any time, on either piece of a curve."""
    whole = along(0.7, 0.0, strut(damping=1e2, **BENT), 3.0).with_output(states=True)
    run = hs.simulate(whole)
    assert {0, 1} == {*run.link_segment.values[:, 0].tolist()}
    names = ("position", "velocity", "strut_force", "link_mode", "force_link")
    assert_continues(whole, run, run.time.values[4:-1:12], *names, file=tmp_path / "run.nc")


def test_the_record_says_what_it_holds() -> None:
    driven, _ = absorbing(False)
    forces = {**driven.forces, "twist": torsion(1.0), "strut": strut(capacity=1e4)}
    run = hs.simulate(replace(driven, forces=forces, duration=1.0))
    dims = {"link": ["pto", "twist", "strut"], "strut": ["pto", "strut"], "pto": ["pto"]}
    assert {dim: [*run[dim].values] for dim in dims} == dims
    assert [*run.torsion_spring.values] == ["twist"]
    units = {"strut_force": "N", "strut_length": "m", "torsion_moment": "N m", "pto_power": "W"}
    assert {name: run[name].units for name in units} == units
    assert all(v.long_name and v.frame for v in run.data_vars.values())
    used, _ = channel_series(run, "utilisation.strut")
    np.testing.assert_allclose(used, np.abs(run.strut_force.sel(strut="strut")) / 1e4)
    assert "link" not in hs.simulate(scene(block(1.0), {"push": steady(surge=1.0)}, 1.0, 0.5)).dims


def test_links_on_a_hinged_body(figure, validated) -> None:
    """To 120 deg on both sides: a sine; then damped and on a strut too: the ledger closes."""
    inertia = np.diag([2e3, 3e3, 4e3])
    k, rate = 4e4, 5.0
    hinge = hs.Hinge("block", None, (0.0, 0.0, -2.0), axis=(0.0, 1.0, 0.0))
    turning = with_motions(hinge, Acting(velocity=rate))
    body = block(M, inertia=inertia)
    spring = torsion(k, (0.0, 1.0, 0.0))
    whole = replace(scene(body, {"spring": spring}, 4.0, 0.1, step=0.005), joints={"it": turning})
    run = hs.simulate(whole)
    omega = sqrt(k / (3e3 + M * 2.0**2))
    exact = rate / omega * np.sin(omega * run.time.values)
    assert np.ptp(exact) > np.radians(200.0)
    error = np.abs(run.torsion_angle.values[:, 0] - exact).max() / np.ptp(exact)
    claim = "flap on a hinge with a torsion spring, of its range"
    validated(Kind.CLOSED_FORM, claim, "sine", error, 1e-8, Feature.STRUTS)
    held = strut(anchor=(3.0, 0.5, -1.0), damping=3e2)
    both = {"spring": replace(spring, damping=2e3, type="rotary_power_take_off"), "held": held}
    run = hs.simulate(replace(whole, forces=both))
    figure("residual", run.energy_residual_relative)
    assert run.energy_residual_relative < 1e-7
    assert run.pto_power.max() > 1e3


def test_mirror_images() -> None:
    """Pairs of struts, springs about the plane's axes, a bushing in it; none crooked or alone."""
    body = block(M, inertia=np.diag([2e3, 3e3, 4e3]), velocity=moving(heave=1.0, pitch=0.3))
    sides = {
        f"strut_{y:g}": strut(point=(1.0, y, 0.5), anchor=(9.0, 4.0 * y, 2.0)) for y in (1.0, -1.0)
    }
    axes = {"roll": (-1.0, 0.0, 0.0), "pitch": (0.0, 1.0, 0.0)}
    turns = {name: torsion(9e3, axis, damping=10.0) for name, axis in axes.items()}
    soft = Bushing("block", (0.5, 0.0, 1.0), np.diag([1e4] * 6), np.diag([1e3] * 6))
    whole = scene(body, {**sides, **turns, "soft": soft}, 2.0, 0.1, step=0.01)
    compiled = hs.compile_scene(whole, in_plane=True)
    assert compiled.notes.symmetry.startswith("in the plane y = 0 m")
    unfolded = replace(whole, solver=replace(whole.solver, symmetry=Symmetry.IGNORE))
    plane, full = hs.simulate(whole), hs.simulate(unfolded)
    np.testing.assert_allclose(plane.position, full.position, atol=1e-12)
    coupled = np.eye(6) * 1e4
    coupled[0, 1] = coupled[1, 0] = 3e3
    for name, lopsided in {
        "strut_1": replace(sides["strut_1"], damping=1.0),
        "roll": replace(turns["roll"], axis=(1.0, 0.2, 0.0)),
        "soft": replace(soft, stiffness=coupled),
    }.items():
        other = replace(whole, forces=whole.forces | {name: lopsided})
        said = hs.compile_scene(other, in_plane=True).notes.symmetry
        assert said.startswith("in all degrees of freedom")
        assert name in said
