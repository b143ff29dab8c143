"""Mass that varies: against closed forms, DOP853, and the balances of momentum and energy."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose
from scenes import block, moving, observed_orders, scene, steady, surge
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import hydrosim as hs
from hydrosim.elements import LinearMooring
from hydrosim.errors import InputError
from hydrosim.linear.linearise import inertia
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Box, FreeSurface, Method, TankTable, Weight
from hydrosim.tanks.shapes import pieces
from hydrosim.tanks.surface import SURFACE_MOMENT
from hydrosim.tanks.surface import quantities_at as held_at

MASS, DENSITY = 2e4, 1000.0
LEFT = hs.Tank("left", Box((-3.0, -1.5, -0.5), (-1.0, 1.0, 2.0), 0.9), 2.0, DENSITY)
RIGHT = hs.Tank("right", Box((1.5, -0.5, -2.0), (4.0, 2.0, 0.5)), 0.4, DENSITY)
HELD = steady(heave=0.0)  # what could carry a weight that is none


def loaded(*pumps: hs.Pump, tanks: Sequence[hs.Tank] = (LEFT, RIGHT), **changes: Any) -> hs.Body:
    """A block with tanks, which carries its weight."""
    body = block(MASS, weight=Weight.CARRIED, tanks=tuple(tanks), pumps=pumps)
    return replace(body, **changes)


def weightless(body: hs.Body, duration: float, every: float, **solver: Any) -> hs.Scene:
    """It alone in space."""
    nowhere = scene(body, {"nothing": HELD}, duration, every, **solver)
    return replace(nowhere, environment=hs.Environment(gravity=1e-30))


def volumes(run: xr.Dataset, body: hs.Body) -> dict[str, np.ndarray]:
    """Volumes (nt,) of its tanks, by name, from the states."""
    states = run.state_value
    return {
        tank.name: states.sel(state=f"volume of {tank.name} of {body.name}").values
        for tank in body.tanks
        if f"volume of {tank.name} of {body.name}" in states.state
    }


def of_box(tank: hs.Tank, volume: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mass (n,), first moment (n, 3) and second moments (n, 3, 3) about the origin, by a rule of
    Gauss in each direction."""
    x, w = np.polynomial.legendre.leggauss(3)
    low, high = np.array(tank.shape.low), np.array(tank.shape.high)
    area = tank.shape.permeability * np.prod(high[:2] - low[:2])
    mass, first, second = DENSITY * volume, [], []
    for v, m in zip(volume, mass, strict=True):
        top = np.array([*high[:2], low[2] + v / area])
        axes = [0.5 * (a + b) + 0.5 * (b - a) * x for a, b in zip(low, top, strict=True)]
        points = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
        weights = m / 8.0 * np.einsum("i,j,k->ijk", w, w, w).ravel()
        first.append(weights @ points)
        second.append(np.einsum("n,ni,nj->ij", weights, points, points))
    return mass, np.array(first), np.array(second)


def whole(run: xr.Dataset, body: hs.Body) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mass (nt,), first moment (nt, 3) and inertia (nt, 3, 3) about the origin, body axes, of body
    and contents, from the volumes."""
    nt = run.sizes["time"]
    mass, first = np.full(nt, body.mass), np.zeros((nt, 3))
    inertia = np.tile(body.inertia, (nt, 1, 1))
    for tank in body.tanks:
        v = volumes(run, body).get(tank.name)
        if v is not None:
            for sign, at in ((1.0, v), (-1.0, np.full(nt, v[0]))):
                m, s, second = of_box(tank, at)
                mass, first = mass + sign * m, first + sign * s
                trace = np.trace(second, axis1=1, axis2=2)[:, None, None]
                inertia = inertia + sign * (trace * np.eye(3) - second)
    return mass, first, inertia


def turns(run: xr.Dataset) -> np.ndarray:
    """R (nt, 3, 3)."""
    angles = run.position.values[:, 0, 3:]
    return Rotation.from_euler("ZYX", angles[:, ::-1]).as_matrix()


def momentum(run: xr.Dataset, body: hs.Body, between: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Linear momentum (nt, 3) and angular momentum (nt, 3) about the earth's origin of body and
    contents, with a flow ``between`` [kg/s] the first and the second tank straight from surface to
    surface."""
    R, v = turns(run), run.velocity.values[:, 0]
    mass, first, inertia = whole(run, body)
    first, omega = np.einsum("nij,nj->ni", R, first), v[:, 3:]
    inertia = R @ inertia @ R.transpose(0, 2, 1)
    linear = mass[:, None] * v[:, :3] + np.cross(omega, first)
    angular = np.cross(first, v[:, :3]) + np.einsum("nij,nj->ni", inertia, omega)
    if between:
        a, b = (surface(tank, volumes(run, body)[tank.name]) for tank in body.tanks)
        a, b = (np.einsum("nij,nj->ni", R, x) for x in (a, b))
        linear, angular = linear + between * (b - a), angular + between * np.cross(a, b)
    place = run.reference_position.values[0] + run.position.values[:, 0, :3]
    return linear, angular + np.cross(place, linear)


def surface(tank: hs.Tank, volume: np.ndarray) -> np.ndarray:
    """Centroid (n, 3) of the surface of a box."""
    low, high = np.array(tank.shape.low), np.array(tank.shape.high)
    area = tank.shape.permeability * np.prod(high[:2] - low[:2])
    middle = np.broadcast_to(0.5 * (low + high)[:2], (volume.size, 2))
    return np.column_stack([middle, low[2] + volume / area])


def test_a_body_on_a_spring_that_loses_mass_moves_as_dop853_has_it(
    validated: Callable[..., None],
) -> None:
    """(m - q t) x'' = -k x: what leaves has the body's velocity. rk4 at 4 ms."""
    q, k = 60.0, 3e4
    out = hs.Pump("out", q, "left", None, start=0.0, stop=150.0)
    body = loaded(out, dofs=("surge",), position=moving(surge=1.0))
    spring = {"line": LinearMooring("block", k * np.diag([1.0, 0, 0, 0, 0, 0]))}
    run = hs.simulate(scene(body, spring, 150.0, 0.5, step=4e-3))

    def rates(t: float, y: np.ndarray) -> list[float]:
        return [y[1], -k * y[0] / (MASS - q * t)]

    exact = solve_ivp(
        rates, (0, 150), [1.0, 0.0], "DOP853", run.time.values, rtol=1e-12, atol=1e-13
    )
    error = np.abs(surge(run) - exact.y[0]).max()
    claim = "body on a spring that pumps out water, of its start"
    features = (Feature.TANKS, Feature.PUMPS)
    validated(Kind.INDEPENDENT, claim, "DOP853", error, 1e-8, *features)
    assert np.abs(run.energy_residual).max() <= 1e-8 * run.energy_kinetic.max()


@pytest.mark.parametrize("method", Method)
def test_what_leaves_at_the_velocity_of_the_body_gives_no_thrust(method: Method) -> None:
    out = hs.Pump("out", 80.0, "left", None, start=3.0, stop=40.0)
    body = loaded(out, dofs=("surge", "sway"), velocity=moving(surge=2.0, sway=-0.5))
    run = hs.simulate(weightless(body, 50.0, 1.0, method=method))
    assert_allclose(run.velocity[:, 0, :2], np.tile([2.0, -0.5], (51, 1)), rtol=1e-12)


@pytest.mark.parametrize("method", Method)
def test_water_taken_in_from_rest_keeps_the_momentum(method: Method) -> None:
    """m v is constant: heun, rk4 and dopri5 have it to rounding, rk2 to h^2 (1.8e-12 at 1 ms),
    esdirk4 to what its equations are solved to."""
    fill = hs.Pump("fill", 100.0, None, "right", start=2.0, stop=40.0)
    body = loaded(fill, dofs=("surge",), velocity=moving(surge=2.0))
    step = 1e-3 if method == Method.RK2 else 0.1
    still = weightless(body, 50.0, 1.0, method=method, step=step)
    run = hs.simulate(still.with_output(states=True))
    mass, _, _ = whole(run, body)
    error = {Method.RK2: 4e-12, Method.ESDIRK4: 3e-12}.get(method, 1e-12)
    assert_allclose(mass * run.velocity.values[:, 0, 0], 2.0 * MASS, rtol=error)
    assert mass[-1] == pytest.approx(MASS + 3800.0, rel=1e-12)


def test_water_taken_in_keeps_momentum_of_a_spinning_body_in_a_current() -> None:
    """Linear and angular momentum change by what the water brings with it, of the current."""
    fill = hs.Pump("fill", 100.0, None, "right")
    body = loaded(fill, velocity=moving(surge=2.0, roll=0.2, pitch=-0.1, yaw=0.3))
    still = weightless(body, 20.0, 0.5, step=0.01).with_output(states=True)
    run = hs.simulate(still)
    linear, angular = momentum(run, body)
    assert_allclose(linear, np.tile(linear[0], (41, 1)), atol=1e-10 * np.abs(linear).max())
    assert_allclose(angular, np.tile(angular[0], (41, 1)), atol=1e-9 * np.abs(angular).max())
    current = replace(still, environment=replace(still.environment, current=hs.Stream(0.7)))
    linear, _ = momentum(hs.simulate(current), body)
    brought = 100.0 * 0.7 * run.time.values
    assert_allclose(linear[:, 0] - linear[0, 0], brought, atol=1e-10 * np.abs(linear).max())


def test_a_spinning_body_that_pumps_between_its_tanks_keeps_its_momentum() -> None:
    """Through the start and the end of the flow, where velocities jump; and the common centre of
    mass goes straight on. rk4 at 2.5 ms."""
    pump = hs.Pump("across", 300.0, "left", "right", start=2.0, stop=14.0)
    body = loaded(pump, velocity=moving(surge=0.3, sway=0.1, roll=0.4, pitch=-0.2, yaw=0.5))
    still = weightless(body, 20.0, 0.5, step=2.5e-3)
    run = hs.simulate(still.with_output(states=True))
    flowing = (run.time.values > 2.0) & (run.time.values <= 14.0)
    at_rest, on_the_way = momentum(run, body), momentum(run, body, 300.0)
    for still_then, then in zip(at_rest, on_the_way, strict=True):
        found = np.where(flowing[:, None], then, still_then)
        assert_allclose(found, np.tile(found[0], (41, 1)), atol=1e-10 * np.abs(found).max())
    mass, first, _ = whole(run, body)
    place = run.position.values[:, 0, :3] + np.einsum("nij,nj->ni", turns(run), first) / mass[0]
    straight = place[0] + run.time.values[:, None] * at_rest[0][0] / mass[0]
    assert_allclose(place, straight, atol=1e-10 * 20.0)
    assert np.abs(first[-1]).max() > 1e3


@pytest.mark.parametrize("kinematics", hs.scene.Kinematics)
def test_the_ledger_of_an_open_system_closes_at_the_order_of_the_method(
    kinematics: hs.scene.Kinematics,
) -> None:
    """Out, in and between, with free surfaces, on springs, in all six degrees of freedom."""
    pumps = (
        hs.Pump("out", 40.0, "left", None, start=0.7, stop=6.1),
        hs.Pump("in", 60.0, None, "right", start=1.3, stop=7.7),
        hs.Pump("across", 90.0, "left", "right", start=2.2, stop=8.9),
    )
    stiffness = np.diag([3e4, 2e4, 2e5, 4e5, 5e5, 6e5])
    start = {"position": moving(surge=0.3, roll=0.1), "velocity": moving(heave=-0.2, pitch=0.1)}
    body = loaded(*pumps, **start)
    steps = [0.05, 0.025, 0.0125]
    hung = scene(body, {"line": LinearMooring("block", stiffness)}, 10.0, 0.1)
    residuals = []
    for step in steps:
        solver = replace(hung.solver, step=step, kinematics=kinematics)
        run = hs.simulate(replace(hung, solver=solver))
        residuals.append(float(np.abs(run.energy_residual).max()))
    if kinematics == hs.scene.Kinematics.EXACT:
        assert np.all(observed_orders(steps, np.array(residuals)) > 3.7)
        assert residuals[-1] <= 1e-6 * float(run.energy_kinetic.max())
    assert np.abs(run.energy_work_ballast[-1]) > 1e2


def test_the_matrix_of_box_tanks_is_exact() -> None:
    """6 x 6 about the origin, at rest, against a rule of Gauss that is exact for it."""
    pump = hs.Pump("across", 300.0, "left", "right", start=2.0, stop=14.0)
    body = loaded(pump)
    compiled = hs.compile_scene(weightless(body, 20.0, 0.5))
    y, p = compiled.state.y.copy(), compiled.model.tanks
    y[p.state : p.state + 2] = found = np.array([5.0, 7.5])
    expected = np.zeros((6, 6))
    mass, first, second = MASS, np.zeros(3), np.zeros((3, 3))
    for tank, v, v0 in zip(body.tanks, found, p.each["first_volume"], strict=True):
        for sign, at in ((1.0, v), (-1.0, v0)):
            m, s, two = of_box(tank, np.array([at]))
            mass, first, second = mass + sign * m[0], first + sign * s[0], second + sign * two[0]
    cross = np.cross(np.eye(3), first)
    expected[:3, :3], expected[3:, 3:] = mass * np.eye(3), body.inertia
    expected[3:, 3:] += np.trace(second) * np.eye(3) - second
    expected[:3, 3:], expected[3:, :3] = cross.T, cross
    assert_allclose(inertia(compiled.model, y), expected, rtol=1e-13, atol=1e-9)


def test_a_plan_of_levels_is_followed() -> None:
    """Levels at the points of the plan, straight in between for a box."""
    plan = hs.Plan(np.array([1.0, 5.0, 9.0]), np.array([2.0, 0.5, 1.5]))
    body = loaded(tanks=(replace(LEFT, plan=plan), RIGHT), dofs=("surge",))
    run = hs.simulate(weightless(body, 10.0, 0.5).with_output(states=True))
    area = 0.9 * 2.0 * 2.5
    level = np.interp(run.time, plan.time, plan.level)
    assert_allclose(volumes(run, body)["left"], area * level, atol=1e-9)


def test_pumps_start_and_stop_at_levels_and_when_a_tank_is_empty() -> None:
    """The second starts when the first tank is below 1 m; the first runs until it is empty."""
    pumps = (
        hs.Pump("out", 500.0, "left", None, start=1.0),
        hs.Pump(
            "in",
            400.0,
            None,
            "right",
            start=hs.scene.LevelReached("left", below=1.0),
            stop=hs.scene.LevelReached("right", above=1.2),
        ),
    )
    body = loaded(*pumps, dofs=("surge",))
    run = hs.simulate(weightless(body, 30.0, 0.5, step=0.1).with_output(states=True))
    t, area = run.time.values, 0.9 * 2.0 * 2.5
    left = np.clip(area * 2.0 - 0.5 * np.maximum(t - 1.0, 0.0), 0.0, None)
    begun = 1.0 + area * 1.0 / 0.5
    right = np.clip(6.25 * 0.4 + 0.4 * np.maximum(t - begun, 0.0), None, 6.25 * 1.2)
    assert_allclose(volumes(run, body)["left"], left, atol=1e-9)
    assert_allclose(volumes(run, body)["right"], right, atol=1e-9)


def test_frozen_surfaces_do_not_turn_the_body() -> None:
    """The free surface takes rho g i from the stiffness in roll, a frozen one nothing."""
    from hydrosim.linear.linearise import linearise

    found = {}
    for surface_of in FreeSurface:
        tanks = (replace(LEFT, free_surface=surface_of), RIGHT)
        body = loaded(hs.Pump("out", 1.0, "left", None, start=90.0), tanks=tanks, dofs=("roll",))
        stiffness = np.diag([0, 0, 0, 9e5, 0, 0])
        still = scene(body, {"line": LinearMooring("block", stiffness)}, 10.0, 0.1)
        compiled = hs.compile_scene(still)
        linear = linearise(compiled.model, compiled.state)
        found[surface_of] = -linear.jacobian[1, 0] * linear.inertia[0, 0]
    loss = found[FreeSurface.FROZEN] - found[FreeSurface.QUASI_STATIC]
    assert loss == pytest.approx(DENSITY * 9.81 * 0.9 * 2.0 * 2.5**3 / 12.0, rel=1e-6)


def test_an_empty_and_a_full_tank_have_no_free_surface() -> None:
    """What it takes from the stiffness in roll: rho g i, smoothly less in the last hundredth."""
    own = pieces(LEFT.shape, np.zeros(3))
    full, i = 11.25, 0.9 * 2.0 * 2.5**3 / 12.0
    parts = np.array([0.0, 0.005, 0.01, 0.5, 0.99, 0.995, 1.0])
    found = [held_at(own, part * full)[SURFACE_MOMENT + 2] / i for part in parts]
    assert_allclose(found, [0.0, 0.5, 1.0, 1.0, 1.0, 0.5, 0.0], atol=1e-12)
    for edge in (0.01 * full, 0.99 * full):
        before, after = (held_at(own, edge + x)[SURFACE_MOMENT + 2] for x in (-1e-6, 1e-6))
        assert after == pytest.approx(before, abs=1e-9)


def test_the_ledger_closes_while_a_tank_runs_empty_under_a_body_that_heels() -> None:
    body = loaded(hs.Pump("out", 200.0, "left", None), tanks=(replace(LEFT, level=0.1), RIGHT))
    stiffness = np.diag([3e4, 2e4, 2e6, 4e5, 5e5, 6e5])
    body = replace(body, position=moving(roll=0.2), velocity=moving(pitch=0.1))
    residuals = []
    for step in (0.02, 0.01):
        hung = scene(body, {"line": LinearMooring("block", stiffness)}, 4.0, 0.1, step=step)
        run = hs.simulate(hung)
        residuals.append(float(np.abs(run.energy_residual).max() / run.energy_kinetic.max()))
    assert residuals[1] <= 1e-5
    assert residuals[1] <= residuals[0] / 6.0


def test_a_restart_in_the_midst_of_pumping_is_the_same_run_to_the_bit() -> None:
    """Across the start of one pump, the end of another, and a level that is waited for."""
    pumps = (
        hs.Pump("out", 40.0, "left", None, start=0.7, stop=6.1),
        hs.Pump("across", 90.0, "left", "right", start=2.2, stop=8.9),
        hs.Pump("in", 60.0, None, "right", hs.scene.LevelReached("left", below=1.9), 9.3),
    )
    body = loaded(*pumps, velocity=moving(heave=-0.2, pitch=0.1, yaw=0.1))
    line = {"line": LinearMooring("block", np.diag([3e4, 2e4, 2e5, 4e5, 5e5, 6e5]))}
    full = scene(body, line, 12.0, 0.5, step=0.05).with_output(states=True)
    run = hs.simulate(full)
    for time in (0.5, 3.0, 6.0):
        start = hs.scene.Start(run, time)
        again = hs.simulate(replace(full, duration=12.0 - time, initial=start))
        for name in ("position", "velocity", "tank_level", "pump_rate", "energy_kinetic"):
            later = run[name].sel(time=slice(time, None)).values
            assert np.array_equal(again[name].values, later), (time, name)
    assert_allclose(
        run.tank_level[:, 0].values[-1], 2.0 - (40 * 5.4 + 90 * 6.7) / 4500.0, rtol=1e-12
    )


def test_a_lightship_heavier_than_what_the_hull_displaces_is_refused() -> None:
    from scenes import scene_of, with_body

    tank = hs.Tank("wing", Box((-20.0, -20.0, -12.0), (20.0, 20.0, 0.0)), 1.0)
    heavy = with_body(scene_of("free_floating"), mass=1.7e8, tanks=(tank,), weight=Weight.CARRIED)
    with pytest.raises(InputError, match=r"barge\.lightship: found 1\.684e\+08 kg without"):
        hs.compile_scene(heavy)


def test_a_tank_that_only_weighs_repeats_the_base_case() -> None:
    """A frozen table tank at the centre of gravity that empties with the ramp's weight, at constant
    mass: the base case, to 1e-9 of its motions."""
    from scenes import motion, scene_of, with_body

    base = replace(scene_of("base"), duration=700.0)
    forces, ramp = dict(base.forces), base.forces["deballast"]
    del forces["deballast"]
    lift = ramp.force["heave"]
    body, d = base.bodies[0], 1025.0
    volume = np.array([0.0, 2e4, 4e4])
    table = TankTable(
        volume / 2e3,
        volume,
        np.tile(body.centre_of_gravity, (3, 1)),
        np.tile([1e5, 0.0, 1e5], (3, 1)),
    )
    held = 3.5e4 - lift.value / (9.81 * d)
    tank = hs.Tank("ramp", table, 17.5, d, FreeSurface.FROZEN, hs.Plan(lift.time, held / 2e3))
    displaced = float(body.hydrodynamics.water_density * body.hydrodynamics.volume[0])
    loaded_base = with_body(
        replace(base, forces=forces),
        tanks=(tank,),
        weight=Weight.CARRIED,
        constant_inertia=True,
        mass=displaced,
    )
    runs = [hs.simulate(each) for each in (with_body(base, mass=displaced), loaded_base)]
    there, here = (motion(run) for run in runs)
    assert np.abs(here - there).max() <= 1e-9 * np.abs(there).max()
    assert runs[1].attrs["solver_events"] >= runs[0].attrs["solver_events"]


def test_of_two_mirrored_tanks_one_is_pumped_and_there_is_no_symmetry() -> None:
    port = hs.Tank("port", Box((-1.0, 0.5, -1.0), (1.0, 1.5, 1.0)), 1.0, DENSITY)
    starboard = replace(port, name="starboard", shape=Box((-1.0, -1.5, -1.0), (1.0, -0.5, 1.0)))
    pumps = [hs.Pump(f"out {name}", 10.0, name, None, stop=5.0) for name in ("port", "starboard")]
    line = {"line": LinearMooring("block", np.diag([1e4, 1e4, 1e5, 1e5, 1e5, 1e5]))}
    inertia = MASS * np.diag([3.0, 4.0, 6.0])
    for some, symmetric in ((pumps[:1], False), (pumps, True)):
        body = loaded(*some, tanks=(port, starboard), inertia=inertia)
        run = hs.simulate(scene(body, line, 8.0, 0.5, step=0.05))
        assert bool(run.attrs.get("zero_by_symmetry")) == symmetric
        assert (np.abs(run.position[:, 0, 3]).max() > 1e-4) != symmetric
