"""Free surfaces that meet bottom and top of a tank: against polyhedra that are cut and measured by
Qhull, the potential's gradient, and the ledger of energy."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scenes import block, moving, observed_orders, scene, steady
from scipy.optimize import brentq
from scipy.spatial import ConvexHull

import hydrosim as hs
from hydrosim.elements import LinearMooring
from hydrosim.elements.hydrostatics import add_weight, add_weight_energy
from hydrosim.errors import SimulationError
from hydrosim.integrate.dynamics import Model, Work, new_work, update_contents
from hydrosim.linear.linearise import nonlinearities
from hydrosim.multibody.kinematics import place_bodies
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Box, Kinematics, Plan, Pump, Tank, TankMesh, TankShape, TankTable, Weight
from hydrosim.tanks.shapes import capacity, triangles, volume_at
from hydrosim.tanks.surface import level_surfaces

MASS, DENSITY, G = 1.6e8, 1025.0, 9.81
BOX = Box((-50.0, -27.0, -12.0), (50.0, 27.0, 2.0))
WIDE = Box((-3.0, -4.0, -0.5), (-1.0, 4.0, 2.0))
LEVELS = np.linspace(0.0, 14.0, 8)
TABLE = TankTable(
    LEVELS,
    50.0 * LEVELS,
    np.stack([3.0 + 0.0 * LEVELS, 2.0 + 0.0 * LEVELS, 0.5 * LEVELS - 12.0], axis=1),
    np.tile([400.0, 60.0, 120.0], (8, 1)),
)
"""A tank of upright walls, askew to its body."""
ATTITUDES = [*product(np.radians([0.0, 1e-4, 0.3, 5.0, 15.0]), np.radians([0.0, 1e-4, 0.3, 5.0]))]


def convex(count: int) -> TankMesh:
    """A tank of many corners on an ellipsoid, off the axes of its body."""
    points = np.random.default_rng(4).normal(size=(count, 3))
    points *= [40.0, 20.0, 7.0] / np.linalg.norm(points, axis=1)[:, None]
    return TankMesh(_outward(points + np.array([30.0, -10.0, -5.0])))


def _outward(points: np.ndarray) -> np.ndarray:
    corners = points[ConvexHull(points).simplices]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = np.sum(normal * (corners.mean(axis=1) - points.mean(axis=0)), axis=1) < 0.0
    corners[inward] = corners[inward, ::-1]
    return corners


class Cutting:
    """A convex tank that is cut by planes, and measured by Qhull and tetrahedra."""

    def __init__(self, shape: TankShape) -> None:
        every = triangles(shape).reshape(-1, 3)
        self.points = np.unique(every.round(12), axis=0)
        sides = ConvexHull(self.points).simplices
        self.edges = np.unique(np.sort(sides[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)), axis=0)

    def below(self, n: np.ndarray, height: float) -> tuple[float, np.ndarray]:
        """Volume and first moment (3,) of the part below a plane."""
        d = self.points @ n - height
        a, b = self.edges[(d[self.edges] < 0.0).sum(axis=1) == 1].T
        cut = self.points[a] + (self.points[b] - self.points[a]) * (d[a] / (d[a] - d[b]))[:, None]
        kept = np.concatenate([self.points[d <= 0.0], cut])
        if len(kept) < 4 or np.linalg.matrix_rank(kept - kept[0], tol=1e-9) < 3:
            return 0.0, np.zeros(3)
        middle = kept.mean(axis=0)
        found = ConvexHull(kept - middle)
        a, b, c = (found.points[found.simplices[:, k]] for k in range(3))
        parts = np.abs(np.sum(a * np.cross(b, c), axis=1)) / 6.0
        return parts.sum(), parts @ (a + b + c) / 4.0 + parts.sum() * middle

    def filled(self, n: np.ndarray, volume: float) -> tuple[float, np.ndarray]:
        """Height of the plane below which this volume is, and its first moment (3,)."""
        ends = self.points @ n
        height = brentq(
            lambda h: self.below(n, h)[0] - volume, ends.min(), ends.max(), xtol=1e-13, rtol=1e-14
        )
        return height, self.below(n, height)[1]


def holding(shape: TankShape, level: float, **solver: object) -> tuple[Model, Work]:
    """A body with one tank, and room for its contents."""
    tank = Tank("mid", shape, level, DENSITY)
    body = block(MASS, weight=Weight.CARRIED, tanks=(tank,))
    model = hs.compile_scene(scene(body, {"push": steady(heave=1.0)}, 1.0, 1.0, **solver)).model
    return model, new_work(model)


def held(model: Model, work: Work, heel: float, trim: float) -> tuple[float, np.ndarray]:
    """Height of the surface, and what it shifts moments by (3,) [m^4], at an attitude."""
    q = np.array([0.0, 0.0, 0.0, heel, trim, 0.4])
    place_bodies(q, np.zeros(6), model.bodies, work.motion)
    args = work.motion, model.bodies, model.tanks, model.liquids, work.contents
    level_surfaces(np.zeros(model.size), *args)
    return float(work.contents.height[0]), work.contents.shift[0] / DENSITY


def level_and_cut(shape: TankShape, levels: list[float]) -> Iterator[tuple[np.ndarray, ...]]:
    """Heights and shifts as found and as Qhull has them, at all levels and attitudes."""
    cutting = Cutting(shape)
    for level in levels:
        model, work = holding(shape, level)
        volume = volume_at(shape, level)
        _, upright = cutting.filled(np.array([0.0, 0.0, 1.0]), volume)
        for heel, trim in ATTITUDES:
            height, shift = held(model, work, heel, trim)
            there, moment = cutting.filled(work.motion.rotation[0, 2].copy(), volume)
            yield np.array([height, *shift]), np.array([there, *(moment - upright)])


def test_a_box_holds_what_an_exact_cut_does(validated: Callable[..., None]) -> None:
    """100 x 54 x 14 m, nearly empty to nearly full: to 1e-9 of the largest shift at its level."""
    for level in (0.2, 0.5, 1.0, 7.0, 13.0, 13.5, 13.85):
        found, exact = map(np.array, zip(*level_and_cut(BOX, [level]), strict=True))
        assert_allclose(found[:, 0], exact[:, 0], atol=1e-10)
        error = np.abs(found - exact)[:, 1:].max() / np.abs(exact[:, 1:]).max()
        claim = "shift of the water in a heeled box tank, nearly empty to nearly full"
        validated(Kind.INDEPENDENT, claim, "cut of the box", error, 1e-9, Feature.TANKS)


def test_upright_walls_would_be_wrong_by_what_was_seen() -> None:
    """At 5 deg, moments of rho g i tan(5 deg) are 4.9, 2.3, 1.4, 2.3 and 6.3 times the exact ones
    at these levels; for the lever, the shift up counts too."""
    heel = np.radians(5.0)
    for level, factor in ((0.2, 4.9), (0.5, 2.3), (1.0, 1.4), (13.5, 2.3), (13.85, 6.3)):
        _, (_, y, _) = held(*holding(BOX, level), heel, 0.0)
        assert -(100.0 * 54.0**3 / 12.0 * np.tan(heel)) / y == pytest.approx(factor, rel=0.05)


def test_a_mesh_holds_what_an_exact_cut_does() -> None:
    """An ellipsoid of 200 corners, and a box of twelve triangles."""
    shape = convex(200)
    full = np.ptp(shape.corners[..., 2])
    for level in (0.02 * full, 0.3 * full, 0.97 * full):
        found, exact = map(np.array, zip(*level_and_cut(shape, [level]), strict=True))
        # the level to which a mesh is filled at the start is by its cubics; from there on it is cut
        assert_allclose(found[:, 0], exact[:, 0], atol=1e-9)
        shifts = np.abs((found - found[0]) - (exact - exact[0]))[:, 1:]
        assert shifts.max() <= 1e-6 * np.abs(exact[:, 1:]).max()
    box = TankMesh(triangles(BOX))
    for heel, trim in ATTITUDES:
        there, here = (held(*holding(each, 0.5), heel, trim) for each in (BOX, box))
        assert here[0] == pytest.approx(there[0], abs=1e-10)
        assert_allclose(here[1], there[1], atol=1e-9 * 540.0 * 50.0)


@pytest.mark.parametrize("level", [0.0, 1e-9, 0.2, 0.5, 7.0, 13.85, 14.0])
@pytest.mark.parametrize(
    "shape", [BOX, TankMesh(triangles(BOX), 0.9), TABLE], ids=["box", "mesh", "table"]
)
def test_the_force_is_what_the_potential_loses(shape: TankShape, level: float) -> None:
    """F v = -dU/dt by central differences of fourth order at heel and trim, along any motion."""
    model, work = holding(shape, level)
    rng = np.random.default_rng(8)
    for _ in range(5):
        q = np.array([*rng.normal(size=3), *rng.uniform(-0.3, 0.3, 3)])
        u = rng.normal(size=6)

        def stored(q: np.ndarray, u: np.ndarray = u) -> float:
            y = np.zeros(model.size)
            out = np.zeros(model.rows)
            place_bodies(q, u, model.bodies, work.motion)
            update_contents(y, model, work)
            add_weight_energy(work.motion, model.bodies, model.weights, work.contents, out)
            return float(out.sum())

        h = 5e-5
        near, far = (stored(q + k * h * u) - stored(q - k * h * u) for k in (1.0, 2.0))
        loss = -(8.0 * near - far) / (12.0 * h)
        stored(q)
        wrench = np.zeros((model.rows, 6))
        add_weight(work.motion, model.bodies, model.weights, work.contents, wrench)
        power = wrench.sum(axis=0) @ work.motion.velocity
        assert power == pytest.approx(loss, rel=1e-9, abs=1e-9 * MASS * G)
        assert abs(wrench[-1, 5]) <= 1e-9 * MASS * G  # nothing turns it about the vertical


def test_a_tank_that_changes_holds_what_one_does_that_stays() -> None:
    """The same level, by a plan that has not begun; also in the frame of a body off the origin."""
    found = []
    for plan in (None, Plan(np.array([5.0, 6.0]), np.array([0.3, 0.2]))):
        tank = Tank("wing", Box((1.0, 2.0, 0.0), (4.0, 9.0, 3.0)), 0.3, DENSITY, plan=plan)
        body = block(2e5, weight=Weight.CARRIED, tanks=(tank,), centre_of_gravity=(0.5, 0.2, 1.0))
        body = replace(body, position=moving(roll=0.3, pitch=-0.2))
        line = {"line": LinearMooring("block", np.diag([1e5, 1e5, 1e6, 3e6, 3e6, 3e6]))}
        found.append(hs.simulate(scene(body, line, 4.0, 0.5, step=0.01)))
    still, changing = (run.position.values for run in found)
    assert_allclose(changing, still, atol=1e-10 * np.abs(still).max())


ORDERS = {
    "bottom": (0.1, Pump("out", 200.0, "left", None), {"roll": 0.2, "pitch": 0.12}),
    "edge": (0.03, Pump("out", 30.0, "left", None), {"roll": 0.3}),
    "level": (0.03, Pump("out", 30.0, "left", None), {}),
    "top": (2.47, Pump("in", 30.0, None, "left"), {"roll": -0.3, "pitch": 0.1}),
}


@pytest.mark.parametrize("case", ORDERS)
def test_the_ledger_closes_at_the_order_of_rk4_to_the_last_drop(case: str) -> None:
    """While the last per cent is pumped out, or in, of a tank under a body that swings."""
    level, pump, start = ORDERS[case]
    left = Tank("left", Box((-3.0, -1.5, -0.5), (-1.0, 1.0, 2.0), 0.9), level, 1000.0)
    stiffness = np.diag([3e4, 2e4, 2e6, 4e5, 5e5, 6e5])
    body = block(2e4, weight=Weight.CARRIED, tanks=(left,), pumps=(pump,))
    body = replace(body, position=moving(**start), velocity=moving(roll=0.05, pitch=0.02))
    steps = [0.05, 0.025, 0.0125, 0.00625]
    residuals = []
    for step in steps:
        run = hs.simulate(
            scene(body, {"line": LinearMooring("block", stiffness)}, 12.0, 0.2, step=step)
        )
        residuals.append(float(np.abs(run.energy_residual).max() / run.energy_kinetic.max()))
    full = run.tank_level[-1, 0] > 1.0
    assert float(run.tank_level[-1, 0]) == pytest.approx(2.5 if full else 0.0, abs=1e-9)
    assert np.all(observed_orders(steps, np.array(residuals)) > 3.9)


@pytest.mark.parametrize(("level", "roll"), [(2.2, 0.4), (1.2, 0.9)], ids=["top", "both ends"])
def test_order_is_kept_where_surfaces_pass_edges_that_are_parallel_to_them(
    level: float, roll: float
) -> None:
    """Of a body that only rolls, where moments have one continuous derivative: steps that do not
    end there give mean orders of 3.5 and 2.8."""
    tank = Tank("big", WIDE, level, 400.0)
    body = block(2e4, weight=Weight.CARRIED, tanks=(tank,), dofs=("roll",))
    body = replace(body, position=moving(roll=roll), inertia=np.diag([3e5, 3e5, 5e5]))
    line = {"line": LinearMooring("block", np.diag([3e4, 2e4, 2e6, 4e5, 5e5, 6e5]))}
    residuals = []
    for step in (0.05, 0.00625):
        run = hs.simulate(scene(body, line, 10.0, 0.2, step=step))
        residuals.append(float(np.abs(run.energy_residual).max()))
    assert np.log2(residuals[0] / residuals[1]) / 3.0 > 3.6


def test_a_scene_with_a_free_surface_is_not_linear() -> None:
    body = block(MASS, weight=Weight.CARRIED, tanks=(Tank("mid", BOX, 0.5, DENSITY),))
    for dofs, expected in ((["roll"], True), (["heave", "yaw"], False)):
        still = scene(replace(body, dofs=dofs), {"push": steady(heave=1.0)}, 1.0, 1.0)
        found = [*nonlinearities(still, hs.compile_scene(still).model)]
        assert ("free surfaces in the tanks of block" in found) == expected


def test_linear_kinematics_keep_moments_that_go_with_the_angles() -> None:
    model, _ = holding(BOX, 0.5, kinematics=Kinematics.LINEAR)
    assert model.liquids.each.size == 0
    assert model.bodies.each["surface"][0, 2] == pytest.approx(DENSITY * 100.0 * 54.0**3 / 12.0)


def test_a_body_with_a_tank_that_turns_over_is_stopped() -> None:
    body = block(MASS, weight=Weight.CARRIED, tanks=(Tank("mid", BOX, 7.0, DENSITY),))
    body = replace(body, velocity=moving(roll=1.0))
    with pytest.raises(SimulationError, match="85 deg"):
        hs.simulate(scene(body, {"push": steady(heave=MASS * G)}, 3.0, 0.1, step=0.01))


def test_a_tank_to_the_brim_and_an_empty_one_shift_nothing() -> None:
    for level in (0.0, 14.0):
        model, work = holding(BOX, level)
        for heel, trim in ATTITUDES:
            _, shift = held(model, work, heel, trim)
            assert np.abs(shift).max() <= 1e-9 * capacity(BOX)
