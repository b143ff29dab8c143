"""Step limits: stability functions of the methods, and scenes that diverge where it is said."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import pi, sqrt
from typing import Any

import numpy as np
import pytest
from markers import few
from scenes import CASES, central_force, hull, in_waves, scene_of, straight_curve, with_body

import hydrosim as hs
from hydrosim import load_case
from hydrosim.compile.compiled import Compiled
from hydrosim.dofs import DOFS
from hydrosim.elements import Table, constant
from hydrosim.elements.contact.law import OPEN, SLIP
from hydrosim.integrate import methods
from hydrosim.integrate.methods import DOPRI5, ESDIRK4, HEUN, RK2, RK4
from hydrosim.linear.stability import GROWTH, REACH, Combination, ray_limits
from hydrosim.run.step_limits import scene_combinations, scene_step_limits
from hydrosim.scene import Body, ConvolutionRadiation, LinearScenes, Method, Scene, Solver, Unstable
from tests.generators import stable_steps

DISTURBED = 1e-9  # m/s: far below mu N / b, where a friction slope lets go


@pytest.mark.parametrize(
    ("method", "angle", "limit"),
    [(RK2, pi, 2.0), (HEUN, pi, 2.0), (RK4, pi, 2.7853), (RK4, pi / 2, 2 * sqrt(2))],
)
def test_limits_on_the_axes(method: methods.IntegrationMethod, angle: float, limit: float) -> None:
    """Closed forms (Hairer & Wanner 1996, IV.2); growth of a thousandth per period may pass."""
    assert ray_limits(method, np.array([angle]))[0] == pytest.approx(limit, abs=0.01)


def test_limit_of_dopri5_on_the_real_axis() -> None:
    """|R| = 1 of its stability polynomial, 1 + z + ... + z^5/120 + z^6/600."""
    z = ray_limits(DOPRI5, np.array([pi]))[0]
    growth = np.polyval([1 / 600, 1 / 120, 1 / 24, 1 / 6, 1 / 2, 1, 1], -z)
    assert abs(growth) == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("method", [RK2, HEUN, RK4, DOPRI5, ESDIRK4])
def test_limit_is_the_first_place_of_the_whole_ray(method: methods.IntegrationMethod) -> None:
    r, angles = np.linspace(0.0, REACH, 8001)[1:], np.linspace(0.5 * pi, pi, 23)
    growth = np.abs(method.stability(np.multiply.outer(np.exp(1j * angles), r)))
    unstable = growth > 1.0 + GROWTH * r / (2 * np.pi)
    first = np.where(unstable.any(axis=1), r[unstable.argmax(axis=1)], np.inf)
    np.testing.assert_array_equal(ray_limits(method, angles), first)
    np.testing.assert_array_equal(ray_limits(method, -angles[::-1]), first[::-1])


def test_growing_motion_sets_no_limit() -> None:
    assert ray_limits(RK4, np.array([0.3]))[0] == np.inf


def dashpot(step: float, method: Method) -> Scene:
    """A mass of 2 kg on a damper of 50 N s/m: eigenvalue -25 1/s."""
    damper = hs.LinearMooring("block", np.zeros((6, 6)), damping=50.0 * np.eye(6))
    body = Body("block", 2.0, np.eye(3), dofs=("surge",), velocity=(1.0, 0, 0, 0, 0, 0))
    solver = Solver(method=method, step=step, linear=LinearScenes.STEP)
    forces = {"damper": damper}
    return Scene("dashpot", 40.0, (body,), forces=forces, solver=solver, output={"step": step})


@pytest.mark.parametrize(("method", "z"), [(Method.RK2, 2.0), (Method.RK4, 2.7853)])
def test_a_run_diverges_where_the_limit_says(method: Method, z: float) -> None:
    """2 % below the limit the velocity dies out, 2 % above it grows until the run is ended."""
    scene = dashpot(0.01, method)
    limit = scene_step_limits(hs.compile_scene(scene))[0].step
    assert limit == pytest.approx(z / 25.0, rel=3e-3)
    run = hs.simulate(dashpot(0.98 * limit, method))
    assert np.abs(run.velocity.values[-1, 0, 0]) < 0.1
    with pytest.raises(hs.SimulationError, match="the solution blows up") as ended:
        hs.simulate(dashpot(1.02 * limit, method))
    assert np.abs(ended.value.dataset.velocity.values[-1, 0, 0]) > 2.0


def test_the_thesis_numerical_oscillation() -> None:
    """Four slopes of 1e9 N s/m on the barge: the step of 0.1 s is at 2.47 of rk2's 2, in surge."""
    base = scene_of("base")
    fender = base.forces["interface"]
    assert isinstance(fender, hs.Fender)
    slope = replace(fender, friction=hs.FrictionSlope(0.2, 1e9))
    solver = Solver(method=Method.RK2, step=0.1, unstable=Unstable.ERROR)
    scene = replace(base, forces={**base.forces, "interface": slope}, solver=solver)
    limit = scene_step_limits(hs.compile_scene(scene))[0]
    assert abs(limit.eigenvalue) * 0.1 == pytest.approx(2.47, abs=0.01)
    assert limit.step * abs(limit.eigenvalue) == pytest.approx(2.0, abs=0.01)
    assert limit.what == "surge of barge"
    with pytest.raises(hs.InputError, match=r"solver\.step 0\.1 s: largest stable step 0\.081\d s"):
        hs.simulate(scene)


def test_an_open_node_limits_the_base_case() -> None:
    """K2 / C2 = 5.6e8 / 3.3e7 1/s: 2.7853 / 16.97 = 0.164 s."""
    scene = scene_of("base")
    limit = scene_step_limits(hs.compile_scene(scene))[0]
    assert limit.step == pytest.approx(2.7853 * 3.3e7 / 5.6e8, rel=3e-3)
    assert limit.what.startswith("the contact node of interface")


def moving_block(
    mass: float, speed: float, law: hs.FrictionSlope | hs.StickSlip, press: hs.PrescribedNormal
) -> Scene:
    """A block that moves along, and one point of contact under a prescribed force."""
    plane = hs.Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    fender = hs.Fender("block", np.zeros((1, 3)), plane, press, law)
    body = Body("block", mass, np.eye(3), dofs=("surge",), velocity=(speed, 0, 0, 0, 0, 0))
    return Scene("block", 30.0, (body,), forces={"fender": fender}, output={"step": 0.1})


def stuck_block(slope: float) -> Scene:
    """Surge alone, with a friction slope that does not let it go."""
    always = hs.PrescribedNormal(constant(1e9))
    return moving_block(1.62e8, DISTURBED, hs.FrictionSlope(0.2, slope), always)


def stuck_barge(slope: float) -> Scene:
    """The barge in calm water at rest, 0.5 m into the thesis' fenders, with radiation."""
    base, lift, k = scene_of("base"), 1.5, 33026e3
    fender = base.forces["interface"]
    assert isinstance(fender, hs.Fender)
    curve = straight_curve(k)
    law = hs.FrictionSlope(0.2, slope)
    load = lift * hull().hydrostatic_stiffness[:, 2] + 4 * k * 0.5 * (np.arange(6) == 2)
    signals = {dof: constant(f) for dof, f in zip(DOFS, load, strict=True)}
    table = central_force("barge", **signals)
    start = {"position": (0, 0, lift, 0, 0, 0), "velocity": (DISTURBED, 0, 0, 0, 0, 0)}
    interface = replace(fender, normal=curve, friction=law)
    whole = replace(with_body(in_waves(base), **start), duration=30.0).with_output(step=0.1)
    return replace(whole, forces={"lift": table, "interface": interface})


def sliding_block(law: hs.StickSlip, opened: bool, step: float) -> Scene:
    """The node stretches until it slips, at 2 s, or contact opens, at 3 s; then 300 steps."""
    force = np.array([1e4, 0.0 if opened else 1e4])
    press = hs.PrescribedNormal(Table(np.array([2.0, 3.0]), force))
    solver = Solver(step=step)
    scene = moving_block(1e15, 1.0, law, press)
    return replace(scene, duration=3.0 + 300 * step, solver=solver).with_output(step=step)


def slope_at_limit(scene: Callable[[float], Scene]) -> float:
    """The slope [N s/m] for which the printed limit is the step."""
    slope = 1e9
    for _ in range(4):
        found = scene(slope)
        (limit, *_) = scene_step_limits(hs.compile_scene(found))
        slope *= limit.step / found.solver.step
    assert limit.what.startswith("surge")
    assert limit.contact == "all contacts sticking"
    return slope


def threshold(grows: Callable[[float], bool]) -> float:
    """Where between 0.8 and 1.2 of what is predicted a disturbance begins to grow."""
    low, high = 0.8, 1.2
    assert not grows(low)
    assert grows(high)
    while high - low > 0.005:
        middle = (low + high) / 2
        low, high = (low, middle) if grows(middle) else (middle, high)
    return (low + high) / 2


@pytest.mark.parametrize("method", [Method.RK2, Method.HEUN, Method.RK4])
@pytest.mark.parametrize("stuck", few([stuck_block, stuck_barge], 1))
def test_a_friction_slope_is_unstable_where_the_limit_says(stuck, method, figure):
    """Surge velocity after 300 steps of 0.1 s in stick, against that at the start. On the negative
    real axis R > 0 for these methods: velocity grows without a change of sign. Rays are looked at
    every 0.005, a part of 400 of rk2's limit; the bisection ends at 0.005."""

    def scene(slope: float) -> Scene:
        return replace(stuck(slope), solver=Solver(method=method, step=0.1))

    def grows(factor: float) -> bool:
        run = hs.simulate(scene(factor * predicted))
        return abs(float(run.velocity[-1, 0, 0])) > DISTURBED

    predicted = slope_at_limit(scene)
    found = threshold(grows)
    figure("predicted slope [N s/m]", predicted)
    figure("observed over predicted slope", found)
    assert found == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("mode", [OPEN, SLIP])
def test_a_contact_node_is_unstable_where_the_limit_says(mode: int, figure) -> None:
    """The node relaxes at K2 / C2 while open and at K2 / (C2 + C3) in slip: two laws of which the
    first and the second limits the step (C2 = 0 leaves no relaxation while open). In slip the
    instability soon ends the mode: what should slip on sticks and slips from step to step."""
    law = hs.StickSlip(0.2, 0.1, 1e3, *((50.0, 5e3) if mode == OPEN else (0.0, 50.0)))
    steady = 0.0 if mode == OPEN else (law.kinetic * 1e4 + law.slip_damping * 1.0) / law.stiffness
    scene = partial(sliding_block, law, mode == OPEN)
    (predicted, *_) = scene_step_limits(hs.compile_scene(scene(0.1)))
    assert predicted.what == "the contact node of fender 1"

    def grows(factor: float) -> bool:
        try:
            run = hs.simulate(scene(factor * predicted.step))
        except hs.SimulationError:  # it blows up
            return True
        if (run.fender_mode.values[-100:] != mode).any():
            return True
        stretch = run.position.values[:, 0, 0] - run.fender_node.values[:, 0, 0]
        early, late = np.abs(stretch[[-100, -1]] - steady)
        return bool(late > max(early, 1e-9))  # m: roundings of 40 m of way

    found = threshold(grows)
    figure("predicted step [s]", predicted.step)
    figure("observed over predicted step", found)
    assert predicted.step == pytest.approx(2.7853 * 50.0 / 1e3, rel=3e-3)
    assert found == pytest.approx(1.0, abs=0.01)


def test_every_thing_that_is_unstable_is_told() -> None:
    """The thesis' fender on steel: with rk2 at 0.1 s surge and sway grow by the friction slope,
    heave and roll on the stiffness of steel with hardly any damping (|R| - 1 = (w h)^4 / 8)."""
    scene = load_case(CASES.parent / "numerical_oscillation" / "base.yaml").scene()
    limits = scene_step_limits(hs.compile_scene(scene))
    dofs = ("heave", "surge", "sway", "roll")
    assert [limit.what for limit in limits] == [f"{dof} of barge" for dof in dofs]
    assert [limit.step for limit in limits] == sorted(limit.step for limit in limits)
    heave, surge = limits[:2]
    assert abs(surge.eigenvalue) * 0.1 == pytest.approx(2.47, abs=0.01)
    steel = 4 * (1e9 - 33026e3) / 1.0 + 132105e3  # N/m
    mass = steel / abs(heave.eigenvalue) ** 2
    assert mass == pytest.approx(scene.bodies[0].mass + hull().added_mass[-1, 2, 2], rel=0.03)
    fine = replace(scene, solver=replace(scene.solver, step=0.01))
    (only,) = scene_step_limits(hs.compile_scene(fine))
    assert only.step > 0.01


def limit_of(**more: Any) -> float:
    """Largest stable step of the base case with more, or other, elements."""
    base = scene_of("base")
    scene = replace(base, forces={**base.forces, **more})
    return scene_step_limits(hs.compile_scene(scene, in_plane=True))[0].step


def test_no_element_changes_what_limits_another() -> None:
    """Points at other heights, and a bumper that nothing touches: each is pressed by itself."""
    fender, alone = scene_of("base").forces["interface"], limit_of()
    assert isinstance(fender, hs.Fender)
    points = fender.points.copy()
    points[points[:, 0] > 0.0, 2] -= 0.3
    soft = straight_curve(1e7)
    ahead = hs.Plane((95.0, 0.0, 0.0), (-1.0, 0.0, 0.0))
    bumper = hs.Fender("barge", np.array([[90.0, 0.0, 0.0]]), ahead, soft, hs.Frictionless())
    assert limit_of(interface=replace(fender, points=points)) == pytest.approx(alone, rel=1e-3)
    assert limit_of(bumper=bumper) == pytest.approx(alone, rel=1e-3)


def test_a_block_that_slips_on_a_block_is_as_stiff_as_one_that_sticks() -> None:
    """Two free blocks of 2 and 4 t with a friction slope b = 6e4 N s/m between them: its rate is
    b (1 / m1 + 1 / m2) = 45 1/s where it sticks, mu N / b of that over the speed aside in slip."""
    law = hs.FrictionSlope(0.4, 6e4)
    curve = straight_curve(1e5)
    deck = hs.Plane((0.0, 0.0, 0.5), (0.0, 0.0, 1.0), "below")
    bodies = [
        Body(name, mass, mass * np.eye(3), dofs=("surge", "sway"), centre_of_gravity=(0, 0, z))
        for name, mass, z in (("below", 4e3, 0.0), ("above", 2e3, 1.0))
    ]
    foot = hs.Fender("above", np.array([[0.0, 0.0, -0.5]]), deck, curve, law)
    blocks = Scene("", 1.0, tuple(bodies), forces={"foot": foot}, solver=Solver(step=0.01))
    limits = scene_step_limits(hs.compile_scene(blocks))
    assert limits[0].step == pytest.approx(2.7853 / 45.0, rel=0.01)


def feet(*places: tuple[float, float]) -> Compiled:
    """A free block of 2 t on equal feet of steel at these places below it, with friction."""
    law = hs.StickSlip(0.2, 0.1, stiffness=1e5, damping=1e3)
    curve = straight_curve(1e5, damping=1e2)
    points = np.array([(x, y, -0.5) for x, y in places])
    floor = hs.Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    body = Body("block", 2e3, np.diag([2e3, 3e3, 4e3]), centre_of_gravity=(0, 0, 1.0))
    forces = {"feet": hs.Fender("block", points, floor, curve, law)}
    return hs.compile_scene(Scene("", 1.0, (body,), forces=forces, solver=Solver(step=1e-4)))


def test_of_equal_contacts_those_farthest_out_are_looked_at_alone() -> None:
    """The farther out, the more a foot moves: 100 need no more looks than their corners."""
    grid = [(x, y) for x in np.linspace(-3.0, 3.0, 10) for y in np.linspace(-1.0, 2.0, 10)]
    many, corners = feet(*grid), feet(grid[0], grid[9], grid[-10], grid[-1])
    found = scene_combinations(many, each_alone=True)
    assert len(found) <= 3 + 2 * 3
    each = fastest_alone(scene_combinations(corners, each_alone=True))
    assert fastest_alone(found) == pytest.approx(each, rel=1e-9)


def fastest_alone(found: list[Combination]) -> float:
    """Largest rate [1/s] of the combinations with one contact alone."""
    return max(float(np.abs(x.values).max()) for x in found if "alone" in x.contact)


# The limit said before a run is where runs diverge: a few scenes of `benchmarks.step_limits`.


@pytest.mark.parametrize("convolved", [False, True])
@pytest.mark.parametrize("seed", few([0, 16], 1))
@pytest.mark.slow
def test_runs_diverge_where_it_is_said(seed: int, convolved: bool) -> None:
    """Limits of a contact node and of a friction slope: 5 % below none diverges, above one does."""
    scene = stable_steps.random_scene(seed)
    if convolved:
        scene = stable_steps.with_radiation(scene, ConvolutionRadiation())
    step = stable_steps.predicted(scene)
    placed = [stable_steps.put(scene, place) for place in stable_steps.PLACES]
    assert not any(stable_steps.diverges(each, 0.95 * step) for each in placed)
    assert any(stable_steps.diverges(each, 1.05 * step) for each in placed)
    assert not stable_steps.refused(scene)


@pytest.mark.parametrize("speed", [-0.1, -0.05, 0.0, 0.1])
def test_rigid_slip_limits_no_step_at_any_speed(speed: float) -> None:
    """Neither where the start cancels the speed at which slip is linearised."""
    setting = {"bodies.block.initial.velocity.surge": speed}
    path = CASES.parent / "friction_block" / "exact.yaml"
    compiled = hs.compile_scene(load_case(path, setting).scene())
    assert all(limit.step == np.inf for limit in scene_step_limits(compiled))
