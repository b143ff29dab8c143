"""What is held in the linear analysis, against systems that are written down by hand.

Rigid friction that is never broken states the constraints: of a body against earth, or of two
bodies, as a joint would.
"""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
import scenes
from numpy.testing import assert_allclose
from scipy import linalg
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation
from test_linear import FrequencyDomain, first_order, harmonic

import hydrosim as hs
from hydrosim.analysis.response import responder
from hydrosim.analysis.seakeeping import LinearRequest, linear_analysis
from hydrosim.compile.compile import Radiation
from hydrosim.elements import Harmonic, Table
from hydrosim.errors import InputError, SimulationError
from hydrosim.integrate.exponential import extend_nodes
from hydrosim.linear import equilibrium as places
from hydrosim.linear.equilibrium import Contacts, equilibrium
from hydrosim.linear.linearise import Linear, nullspace_of
from hydrosim.linear.modes import find_admittances
from hydrosim.linear.propagate import linear_equation, loads_at_rest, motions
from hydrosim.run.step_limits import scene_combinations, scene_step_limits
from hydrosim.scene import Body, Kinematics, RegularWave, Scene, Solver, WaveTrain, Weight
from hydrosim.water.components import WaveComponents

ROUGH = hs.Coulomb(1e6, 1e6)  # as good as a joint
G = 9.81
MASS, ARM = 3.0, 2.0
TURNING = MASS * scenes.INERTIA[0, 0]


def gripped(
    place: tuple[float, ...],
    normal: tuple[float, float, float],
    body: str = "block",
    plane_body: str | None = None,
    force: float = 50.0,
    on_plane: tuple[float, ...] | None = None,
) -> hs.Fender:
    """A point that is pressed by a constant force, and does not move along its plane."""
    pressing = hs.PrescribedNormal(Table(np.array([0.0]), np.array([force])))
    plane = hs.Plane(on_plane or place, normal, body=plane_body)
    return hs.Fender(body, np.array([place]), plane, pressing, ROUGH)


def pendulum(arm: float = ARM, **changes: object) -> Scene:
    """A body that hangs from a point at a wall, or stands on one, held there by friction alone."""
    body = scenes.block(MASS, ("sway", "heave", "roll"), weight=Weight.CARRIED)
    forces = {"wall": gripped((0.0, 0.0, arm), (1.0, 0.0, 0.0))}
    return replace(scenes.scene(body, forces, 20.0, 0.01), **changes)


def linear_of(scene: Scene) -> Linear:
    return hs.linearise(*hs.compile_scene(scene))


# reactions that carry load: the whole stiffness of a pendulum is geometric


def test_a_pendulum_swings_on_its_reaction(figure) -> None:
    (mode,) = hs.natural_modes(linear_of(pendulum()))
    by_hand = 2 * pi * np.sqrt((TURNING + MASS * ARM**2) / (MASS * G * ARM))
    figure("period over closed form - 1", mode.natural_period / by_hand - 1)
    assert mode.natural_period == pytest.approx(by_hand, rel=1e-7)
    assert mode.damped_period == pytest.approx(by_hand, rel=1e-7)
    assert_allclose(mode.shape / mode.shape[2], [ARM, 0.0, 1.0], atol=1e-9)


def test_a_pendulum_that_stands_falls() -> None:
    (mode,) = hs.natural_modes(linear_of(pendulum(-ARM)))
    by_hand = np.sqrt(MASS * G * ARM / (TURNING + MASS * ARM**2))
    assert mode.kind == "unstable"
    assert mode.eigenvalue.real == pytest.approx(by_hand, rel=1e-7)


def test_response_and_reaction_of_a_pendulum() -> None:
    linear, w, load = linear_of(pendulum()), 1.3, np.array([1.0, 2.0, -0.7])
    allowed = np.array([ARM, 0.0, 1.0])
    angle = allowed @ load / (MASS * G * ARM - w**2 * (TURNING + MASS * ARM**2))
    q = linear.response(w, load)
    assert_allclose(q, allowed * angle, rtol=1e-7, atol=1e-12)
    # Newton's law along y and z: m a = load + reaction
    newton = [-(w**2) * MASS * q[0] - load[0], -load[1]]
    assert_allclose(linear.reaction(w, load), newton, rtol=1e-6)


def test_a_loaded_point_in_space_against_own_derivatives(figure) -> None:
    """All six coordinates on one arm: M and derivatives of wrenches, with own rotations."""
    arm, n = np.array([0.4, -0.3, 1.7]), np.array([1.0, 0.0, 0.0])
    force, tangents = 35.0, np.eye(3)[1:]
    K = np.diag([40.0, 20.0, 30.0, 200.0, 150.0, 100.0])
    reactions = np.array([12.0, 20.0])
    held = np.array([np.concatenate([t, np.cross(arm, t)]) for t in tangents])
    weight = np.array([0.0, 0.0, -MASS * G, 0.0, 0.0, 0.0])
    applied = -(held.T @ reactions + np.concatenate([n, np.cross(arm, n)]) * force + weight)

    def wrench(q: np.ndarray) -> np.ndarray:
        turned = Rotation.from_euler("ZYX", q[:2:-1]).apply(arm)
        pushes = reactions @ tangents + force * n
        at_point = np.concatenate([pushes, np.cross(turned, pushes)])
        return applied + at_point + weight - K @ q

    steps = 1e-5 * np.eye(6)
    stiffness = -np.transpose([wrench(s) - wrench(-s) for s in steps]) / 2e-5
    M = linalg.block_diag(MASS * np.eye(3), MASS * scenes.INERTIA)
    N = linalg.null_space(held)
    squares = linalg.eigvals(N.T @ stiffness @ N, N.T @ M @ N)
    dofs = ("surge", "sway", "heave", "roll", "pitch", "yaw")
    signals = dict(zip(dofs, applied, strict=True))
    wall = gripped(tuple(arm), (1.0, 0.0, 0.0), force=force)
    forces = {
        "wall": wall,
        "mooring": hs.LinearMooring("block", K),
        "loads": scenes.steady(**signals),
    }
    body = scenes.block(MASS, weight=Weight.CARRIED)
    found = linear_of(scenes.scene(body, forces, 1.0, 0.1))
    modes = hs.natural_modes(found)
    assert len(modes) == 4
    periods = np.sort([mode.natural_period for mode in modes])
    by_hand = np.sort(2 * pi / np.sqrt(squares.real))
    figure("periods, relative", np.abs(periods / by_hand - 1).max())
    assert_allclose(periods, by_hand, rtol=1e-6)
    without = linalg.eigvals(N.T @ K @ N, N.T @ M @ N)
    assert np.abs(2 * pi / np.sqrt(np.sort(without.real)[::-1]) / by_hand - 1).max() > 0.01


# two bodies that are one


def joined(kinematics: Kinematics = Kinematics.LINEAR) -> tuple[Scene, np.ndarray, np.ndarray]:
    """Two bodies on springs, held together by three points on planes; K and M (12, 12)."""
    random = np.random.default_rng(3).standard_normal
    K = [x @ x.T + 5.0 * np.eye(6) for x in random((2, 6, 6))]
    inertias = [2.0 * scenes.INERTIA, 5.0 * scenes.INERTIA]
    bodies = (Body("one", 2.0, inertias[0]), Body("other", 5.0, inertias[1], location=(3.0, 1.0)))
    forces = {"a": hs.LinearMooring("one", K[0]), "b": hs.LinearMooring("other", K[1])}
    points = ((1.0, 0.0, 0.5), (1.0, 1.0, 0.0), (2.0, 0.5, 1.0))
    for k, (place, normal) in enumerate(zip(points, np.eye(3).tolist(), strict=True)):
        there = tuple(np.subtract(place, (3.0, 1.0, 0.0)))
        normal = tuple(normal)
        forces[f"grip {k}"] = gripped(place, normal, "one", "other", 1e-3, there)

    both = scenes.scene(bodies, forces, 10.0, 0.05, kinematics=kinematics)
    M = linalg.block_diag(2.0 * np.eye(3), inertias[0], 5.0 * np.eye(3), inertias[1])
    return both, linalg.block_diag(*K), M


def as_one() -> np.ndarray:
    """Motions (12, 6) of both bodies of `joined` by those of the first."""
    x, y, z = 3.0, 1.0, 0.0
    turned = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    return np.vstack([np.eye(6), np.block([[np.eye(3), turned], [np.zeros((3, 3)), np.eye(3)]])])


@pytest.mark.parametrize("kinematics", Kinematics)
def test_two_bodies_that_are_held_together(kinematics: Kinematics, figure) -> None:
    both, K, M = joined(kinematics)
    N, modes = as_one(), hs.natural_modes(linear_of(both))
    squares = linalg.eigvalsh(N.T @ K @ N, N.T @ M @ N)
    found = np.sort([2 * pi / mode.natural_period for mode in modes]) ** 2
    figure("w^2 of one body, relative", np.abs(found / squares - 1).max())
    assert_allclose(found, squares, rtol=1e-6)
    for mode in modes:
        assert_allclose(N @ mode.shape[:6], mode.shape, atol=1e-7)


def test_forced_motion_of_two_bodies_that_are_held_together() -> None:
    """With all reactions: they and the loads make both bodies move as they do."""
    both, K, M = joined()
    linear, N, w = linear_of(both), as_one(), 0.8
    load = np.random.default_rng(1).standard_normal(12)
    q = N @ linalg.solve(N.T @ (K - w**2 * M) @ N, N.T @ load)
    assert_allclose(linear.response(w, load), q, atol=1e-6 * np.abs(q).max())
    reaction = linear.constraints.T @ linear.reaction(w, load)
    assert_allclose(reaction, (K - w**2 * M) @ q - load, atol=1e-5 * np.abs(load).max())
    assert np.abs(linear.constraints @ N).max() < 1e-12


def test_eigenvalues_are_those_of_what_can_move() -> None:
    both, K, M = joined()
    linear, N = linear_of(both), as_one()
    w = np.sqrt(linalg.eigvalsh(N.T @ K @ N, N.T @ M @ N))
    found = linear.eigenvalues()
    assert found.size == 12
    assert_allclose(np.sort(found.imag), np.sort([*w, *-w]), rtol=1e-6)
    values, left, right = linear.eigenvectors()
    for k, value in enumerate(values):
        assert_allclose(linear.jacobian @ right[:, k], value * right[:, k], atol=1e-6)
        assert np.vdot(left[:, k], right[:, k]) != 0.0


def test_propagation_of_what_is_held(figure) -> None:
    """Two bodies as one, pushed by a harmonic force from rest: sums of sines of its own modes."""
    both, K, M = joined()
    w, load = 1.7, np.zeros(12)
    load[:3] = 1.0, -2.0, 0.5
    names = ("surge", "sway", "heave")
    push = {dof: Harmonic(load[i], 2 * pi / w) for i, dof in enumerate(names)}
    forces = {**both.forces, "push": scenes.central_force("one", **push)}
    model, state = hs.compile_scene(replace(both, forces=forces))
    equation, N = linear_equation(model, state), as_one()
    assert_allclose(equation.G[12:24], N @ linalg.solve(N.T @ M @ N, N.T), atol=1e-9)
    t, parts = np.linspace(0.0, 10.0, 51), 5
    loads = loads_at_rest(t, parts, equation.rows, model, state)
    f = extend_nodes(np.einsum("krn->kn", loads) + equation.rest)
    of = equation.response(t[1], parts)
    states = np.vstack([each[1:] for _, each in motions(np.zeros(24), f, of, 1)])
    squares, shapes = linalg.eigh(N.T @ K @ N, N.T @ M @ N)
    own = np.sqrt(squares)
    each = [(np.sin(w * t) - w / x * np.sin(x * t)) / (x**2 - w**2) for x in own]
    exact = np.transpose(each) * (shapes.T @ N.T @ load) @ (N @ shapes).T
    error = np.abs(states[:, :12] - exact[1:]).max()
    figure("propagated motion less closed form [m]", error)
    assert error < 1e-11 * np.abs(exact).max()
    assert np.abs(states[:, 12:] @ np.linalg.pinv(N).T @ N.T - states[:, 12:]).max() < 1e-9


# what a run does


def test_a_run_swings_as_the_linear_pendulum(figure) -> None:
    """Small swings, three periods long: the square of 1e-4 rad is left out."""
    start = pendulum()
    (body,) = start.bodies
    w = 2 * pi / hs.natural_modes(linear_of(start))[0].natural_period
    rate = 1e-4
    moved = replace(body, velocity=scenes.moving(roll=rate, sway=rate * ARM))
    run = hs.simulate(replace(start, bodies=(moved,)))
    exact = rate / w * np.sin(w * run.time.values)
    error = np.abs(run.position.sel(dof="roll").values[:, 0] - exact).max()
    figure("roll of a run less that of the linear pendulum, relative", error / (rate / w))
    assert error < 1e-6 * rate / w
    assert (run.fender_mode == 1).all()


def test_a_run_shows_the_reaction_of_the_linear_pendulum(figure) -> None:
    """Below resonance, steady: friction is the weight plus the linear amplitude."""
    w, size = 1.1, 1e-3
    push = scenes.central_force(sway=Harmonic(size, 2 * pi / w))
    still = pendulum()
    (body,) = still.bodies
    linear = linear_of(still)
    q, reaction = (of(w, np.array([size, 0.0, 0.0])) for of in (linear.response, linear.reaction))
    start = scenes.moving(**dict(zip(("sway", "heave", "roll"), w * q.real, strict=True)))
    forces = {**still.forces, "push": push}
    run = hs.simulate(replace(still, bodies=(replace(body, velocity=start),), forces=forces))
    friction = run.fender_friction.values[:, 0]
    along = friction[:, np.ptp(friction, axis=0).argmax()]
    error = np.abs(along - reaction[0].real * np.sin(w * run.time.values)).max()
    figure("reaction of a run less the linear one, relative", error / abs(reaction[0]))
    assert error < 1e-6 * abs(reaction[0])


def standing(step: float, damping: float = 0.0) -> Scene:
    """A body on a stiff floor, held at its point there."""
    body = scenes.block(2.0, ("surge", "heave", "pitch"))
    plane = hs.Plane((0, 0, -1.1), (0, 0, 1))
    floor = scenes.on_floor(400.0, ROUGH, points=[(0.5, 0.0, -1.0)], plane=plane)
    mooring = hs.LinearMooring("block", np.diag([0, 0, 0, 0, 30.0, 0]))
    forces = {"floor": floor, "hold": mooring, "weight": scenes.steady(heave=-40.0)}
    at = replace(body, position=scenes.moving(heave=-0.2))
    return scenes.scene(at, forces, 300 * step, step, step=step, kinematics=Kinematics.LINEAR)


def test_the_step_limit_of_what_is_held(figure) -> None:
    """A stiff normal spring on an arm: by hand, and by runs a little below and above."""
    M = np.diag([2.0, 2.0, 2.0 * scenes.INERTIA[1, 1]])
    normal = np.array([0.0, 1.0, -0.5])  # heave of the point
    K = 400.0 * np.outer(normal, normal) + np.diag([0.0, 0.0, 30.0])
    N = linalg.null_space(np.array([[1.0, 0.0, -1.0]]))  # surge of the point
    fastest = float(np.sqrt(linalg.eigvalsh(N.T @ K @ N, N.T @ M @ N).max()))
    compiled = hs.compile_scene(standing(0.1))
    stuck = [x for x in scene_combinations(compiled) if x.contact == "all contacts sticking"]
    assert np.abs(stuck[0].values).max() == pytest.approx(fastest, rel=1e-6)
    assert stuck[0].values.size == 4
    limits = scene_step_limits(compiled, stuck)
    limit = min(x.step for x in limits if x.contact == "all contacts sticking")
    figure("omega h at the limit", limit * fastest)
    assert limit * fastest == pytest.approx(2 * np.sqrt(2), rel=2e-3)

    def swing(factor: float) -> float:
        """How much a small motion has grown in 300 steps."""
        still = standing(factor * limit)
        rest = held_place(standing(0.1))
        body = replace(still.bodies[0], position=rest, velocity=scenes.moving(heave=1e-6))
        run = hs.simulate(replace(still, bodies=(body,)))
        assert (run.fender_mode == 1).all()
        return float(np.abs(run.velocity.values[-50:, 0, 2]).max()) / 1e-6

    assert swing(0.98) < 1.0
    with pytest.raises(SimulationError, match="blows up"):
        swing(1.02)


def held_place(scene: Scene) -> tuple[float, ...]:
    """Where the body rests with its point held at the surge of 0: w = 40 N on a spring."""
    normal = np.array([0.0, 1.0, -0.5])
    K = 400.0 * np.outer(normal, normal) + np.diag([0.0, 0.0, 30.0])
    N = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 0.0]])  # surge = pitch, heave
    load = np.array([0.0, -40.0, 0.0]) + 400.0 * -0.1 * normal
    surge, heave, pitch = N @ linalg.solve(N.T @ K @ N, N.T @ load)
    return scenes.moving(surge=surge, heave=heave, pitch=pitch)


# the place at rest


def hung(**force: float) -> Scene:
    """A pendulum that a steady force and a mooring pull aside."""
    still = pendulum()
    mooring = hs.LinearMooring("block", np.diag([0, 4.0, 3.0, 5.0, 0, 0]))
    return replace(
        still, forces={**still.forces, "pull": scenes.steady(**force), "mooring": mooring}
    )


def test_rest_of_what_is_held_against_a_minimum(monkeypatch, figure):
    """All energy is least where the point is held, as if by a joint: by SLSQP."""
    monkeypatch.setattr(places, "without_friction", lambda elements: elements)
    pull = {"sway": 21.0, "heave": 6.0}
    model, state = hs.compile_scene(hung(**pull))
    rest = equilibrium(model, state, 0.0, MASS * G)

    def energy(q: np.ndarray) -> float:
        springs = 0.5 * (4.0 * q[0] ** 2 + 3.0 * q[1] ** 2 + 5.0 * q[2] ** 2)
        return springs + MASS * G * q[1] - 21.0 * q[0] - 6.0 * q[1]

    def point(q: np.ndarray) -> np.ndarray:
        return np.array([q[0] - ARM * np.sin(q[2]), q[1] + ARM * (np.cos(q[2]) - 1.0)])

    held, options = {"type": "eq", "fun": point}, {"ftol": 1e-15, "maxiter": 500}
    least = minimize(energy, np.zeros(3), constraints=held, options=options)
    found = rest.state.y[:3]
    figure("place at rest less the minimum [m, rad]", np.abs(found - least.x).max())
    assert np.abs(found[2]) > 0.3
    assert_allclose(found, least.x, atol=1e-6)
    assert np.abs(point(found)).max() < 1e-10
    assert rest.residual < 1e-9
    assert_allclose(rest.drift, 0.0, atol=1e-6)


def test_rest_stays_where_nothing_pulls(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two bodies as one, and no stiffness along surge: it stays there, under a load that drifts."""
    monkeypatch.setattr(places, "without_friction", lambda elements: elements)
    both, _, _ = joined()
    springs = np.diag([0.0, 3.0, 2.0, 9.0, 8.0, 7.0])
    forces = {
        **both.forces,
        "a": hs.LinearMooring("one", springs),
        "b": hs.LinearMooring("other", springs),
        "pull": scenes.steady("one", surge=0.5, heave=1.0),
    }
    model, state = hs.compile_scene(replace(both, forces=forces))
    rest = equilibrium(model, state, 0.0, 7.0 * G)
    N = as_one()
    q = rest.state.y[:12]
    assert_allclose(N @ q[:6], q, atol=1e-9)
    K = N.T @ linalg.block_diag(springs, springs) @ N
    inertia = np.zeros(12)  # both are towed, without a turn, and yaw has a stiffness
    inertia[[0, 6]] = np.array([2.0, 5.0]) * 0.5 / 7.0
    load = N.T @ (np.array([0.5, 0, 1.0, *np.zeros(9)]) - inertia)
    assert_allclose((K @ q[:6])[1:], load[1:], atol=1e-7)
    assert abs(inertia @ q) < 1e-9
    assert_allclose(rest.drift, inertia, atol=1e-7)


# in water


def held_barge(force: float = 50.0) -> Scene:
    """The moored barge, a point of its deck held along the horizontal."""
    free, place, up = scenes.scene_of("free_floating"), (30.0, 0.0, 10.0), (0.0, 0.0, 1.0)
    grip = replace(gripped(place, up, "barge", force=force), plane=scenes.FLOOR)
    return replace(scenes.in_waves(free), forces={**free.forces, "grip": grip})


HELD_POINT = np.array([[1.0, 0, 0, 0, 10.0, 0], [0, 1.0, 0, -10.0, 0, 30.0]])


@pytest.mark.parametrize("w", [0.35, 0.6, 0.9])
def test_rao_and_reaction_of_a_held_barge(w: float, figure) -> None:
    """Against the equation of motion from the database with the constraint beside it."""
    by_hand = FrequencyDomain()
    grid = scenes.hull().frequency
    w = float(grid[np.abs(grid - w).argmin()])
    damping = by_hand.radiation_damping(w) + by_hand.mooring_damping
    inertia = by_hand.mass + by_hand.added_mass(w)
    D = by_hand.stiffness - w**2 * inertia + 1j * w * damping
    N, load = linalg.null_space(HELD_POINT), by_hand.excitation(w)
    expected = N @ linalg.solve(N.T @ D @ N, N.T @ load)
    force = linalg.lstsq(HELD_POINT.T, D @ expected - load)[0]
    about = responder(held_barge(), radiation=Radiation.DATABASE, contacts=Contacts.STUCK)
    waves = WaveComponents(*(np.array([x]) for x in (w, 1.0, 0.0, w**2 / G, 0.0)), 0.0, 0.0)
    q, reaction = about.motions(waves)[0], about.reactions(waves)[0]
    figure(f"{w:.2f} rad/s: motions", np.abs(q - expected).max() / np.abs(expected).max())
    assert_allclose(HELD_POINT @ q, 0.0, atol=1e-9)
    assert_allclose(q, expected, atol=1e-7 * np.abs(expected).max())
    assert_allclose(reaction, force, atol=1e-6 * np.abs(force).max())


def test_a_run_in_a_regular_wave_is_the_response_of_what_is_held(figure) -> None:
    """Small, so that what turns does so little, with the same radiation model on both sides."""
    period, height = 10.0, 0.01
    train = WaveTrain(RegularWave(amplitude=height, period=period), ramp=100.0)
    solver = Solver(step=0.1)
    small = first_order(scenes.in_waves(held_barge(), train))
    run = hs.simulate(replace(small, duration=700.0, solver=solver))
    assert (run.fender_mode == 1).all()
    linear = linear_of(first_order(held_barge()))
    w = 2 * pi / period
    load = height * CubicSpline(scenes.hull().frequency, scenes.hull().excitation[:, 0])(w)
    found, expected = harmonic(run, period), linear.response(w, load)
    error = np.abs(found - expected)[[0, 2, 4]] / np.abs(expected)[[0, 2, 4]]
    figure("surge, heave, pitch of a run less the response, relative", error.max())
    assert error.max() < 1e-5
    late = run.isel(fender=0).sel(time=slice(460.0, None))
    waves = np.exp(1j * w * late.time.values)
    sides = np.column_stack([waves.real, -waves.imag, np.ones(waves.size)])
    parts = np.linalg.lstsq(sides, late.fender_friction.values, rcond=None)[0]
    friction = parts[0] + 1j * parts[1]
    assert_allclose(np.abs(friction).max(), np.abs(linear.reaction(w, load)).max(), rtol=1e-4)


def test_waves_that_let_a_rigid_grip_slip_are_told() -> None:
    """The reaction in small waves is below mu N, that in waves a thousand times as high is not."""
    still = held_barge(1e6)
    grip = replace(still.forces["grip"], friction=hs.Coulomb(0.5, 0.4))
    for height, slips in ((0.01, False), (10.0, True)):
        train = WaveTrain(replace(scenes.SEA, significant_height=height))
        held = scenes.in_waves(replace(still, forces={**still.forces, "grip": grip}), train)
        remarks = linear_analysis(held, LinearRequest()).remarks
        assert ("grip 1 would slip" in remarks) == slips
        assert "no motion along the plane" in remarks


def test_natural_periods_of_a_held_barge() -> None:
    """Those of the reduced system from the database, each with the added mass of its frequency."""
    by_hand, N = FrequencyDomain(), linalg.null_space(HELD_POINT)
    about = responder(held_barge(), radiation=Radiation.DATABASE, contacts=Contacts.STUCK)
    modes = about.natural_modes()
    assert len(modes) == 4
    for mode in modes:
        w = 2 * pi / mode.natural_period
        M = N.T @ (by_hand.mass + by_hand.added_mass(w)) @ N
        squares = linalg.eigvalsh(N.T @ by_hand.stiffness @ N, M)
        assert np.abs(np.sqrt(squares) / w - 1).min() < 2e-3


def test_what_a_change_of_radiation_does_to_what_is_held() -> None:
    """The norm of (N^T Z N)^-1 N^T dZ N with N orthonormal over the roots of inertias."""
    both, K, M = joined()
    s = np.array([0.05 + 0.7j])
    dZ = np.diag(np.arange(1.0, 13.0))[None] * (1 + 0.2j)
    root = np.sqrt(np.diag(M))
    N = linalg.orth(root[:, None] * as_one()) / root[:, None]
    by_hand = linalg.solve(N.T @ (s[0] * M + K / s[0]) @ N, N.T @ dZ[0] @ N)
    (admittance,) = find_admittances(s, [np.eye(12)], [np.zeros((1, 12, 12))], linear_of(both))
    change = admittance.largest_change(np.array([0.7]), dZ)
    assert change.size == pytest.approx(np.linalg.norm(by_hand, 2), rel=1e-6)


def test_a_change_of_radiation_moves_nothing_that_is_held() -> None:
    """One of two bodies that nothing couples is held in all that it could do."""
    bodies = [scenes.block(2.0, ("surge",), name) for name in ("free", "held")]
    grip = gripped((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), "held", force=1.0)
    linear = linear_of(scenes.scene(bodies, {"grip": grip}, 1.0, 0.1))
    dofs, none = [np.arange(6), np.arange(6, 12)], np.zeros((1, 6, 6))
    slopes = [np.asarray(own[:, None] == linear.active, dtype=float) for own in dofs]
    found = find_admittances(np.array([1j]), slopes, [none, none], linear)
    sizes = [each.largest_change(np.ones(1), np.ones((1, 6, 6))).size for each in found]
    assert sizes == pytest.approx([0.5, 0.0])


# what is told, and what is refused


def test_where_motion_remains_rigid_friction_is_linear() -> None:
    body, law = scenes.block(2.0, ("surge", "heave")), hs.Coulomb(0.5, 0.4)
    forces = {"weight": scenes.steady(heave=-100.0), "floor": scenes.on_floor(1e3, law)}
    found = linear_analysis(scenes.scene(body, forces, 1.0, 0.1), LinearRequest())
    assert list(found["mode"].values) == ["block heave"]
    assert float(found.natural_period[0]) == pytest.approx(2 * pi / np.sqrt(500.0), rel=1e-6)
    assert "floor 1 hold by friction: no motion along the plane" in found.remarks


def test_where_none_remains_it_is_refused() -> None:
    forces = {"floor": gripped((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), force=1.0)}
    with pytest.raises(InputError, match="holds floor 1 at rest, so that nothing can move"):
        linear_analysis(
            scenes.scene(scenes.block(2.0, ("surge", "sway")), forces, 1.0, 0.1), LinearRequest()
        )


def test_what_holds_more_once_it_has_moved_is_refused() -> None:
    """A point on the axis of roll holds no roll, but does a little beside it."""
    place = (0.0, 1.0, 0.0)
    forces = {"wall": gripped(place, (0.0, 0.0, 1.0), force=1e-3)}
    linear = linear_of(scenes.scene(scenes.block(2.0, ("surge", "roll")), forces, 1.0, 0.1))
    with pytest.raises(InputError, match="dependent directions, or directions that change with"):
        linear.dynamic_stiffness(1.0)


def test_rows_that_hold_the_same_are_refused() -> None:
    rows = np.array([[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    nullspace = nullspace_of(rows, np.eye(3))
    linear = Linear(np.eye(6), np.arange(6), np.arange(3), nullspace, np.zeros((2, 6)))
    assert linear.freedom.basis.shape == (3, 2)
    assert not nullspace_of(rows[:1], np.eye(3)).has_dependent_rows
    with pytest.raises(InputError, match="rigid friction or joints are not defined"):
        linear.dynamic_stiffness(1.0)


def test_a_row_through_the_door_reaches_everything() -> None:
    """One point more, and each part of the linear analysis has one motion less."""
    forces = {"k": hs.LinearMooring("block", np.eye(6))}
    free = scenes.scene(scenes.block(2.0, ("surge", "heave")), forces, 1.0, 0.1)

    grip = gripped((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), force=1.0)
    held = replace(free, forces={**free.forces, "grip": grip})
    for each, count in ((free, 2), (held, 1)):
        compiled = hs.compile_scene(each)
        linear = hs.linearise(*compiled)
        assert len(hs.natural_modes(linear)) == count
        assert linear.eigenvalues().size == 2 * count
        assert np.linalg.matrix_rank(linear_equation(*compiled).G) == count
        sticking = scene_combinations(compiled)[1 if each is held else 0]
        assert sticking.values.size == 2 * count
