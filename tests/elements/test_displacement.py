"""Buoyancy of closed hulls: closed forms of a box, sections of H-851, the potential's gradient, and
runs of bodies that nothing but their hull carries."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scenes import moving, scene, steady, with_step

import hydrosim as hs
from hydrosim.compile.compile import compile_scene
from hydrosim.compile.hydrostatics import at_rest
from hydrosim.database import load
from hydrosim.database.build.barge import box
from hydrosim.database.build.recipe import barge_with_deck, hull_of_recipe
from hydrosim.dofs import DOFS
from hydrosim.elements.hydrostatics import add_displacement, add_displacement_energy
from hydrosim.elements.kind import HYDROSTATIC
from hydrosim.errors import InputError, SimulationError
from hydrosim.integrate.dynamics import Model
from hydrosim.linear.linearise import linearise
from hydrosim.multibody.kinematics import new_motion, place_bodies
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Body, Hull, Kinematics, Scene, Weight

DATABASES = Path(__file__).parents[2] / "hydro_db"
LENGTH, BEAM, DEPTH, DRAUGHT, KG = 260.0, 63.0, 15.0, 12.4, 7.5
RHO_G = 1025.0 * 9.81
BOX = Hull(barge_with_deck(box(LENGTH, BEAM, DRAUGHT), DEPTH))
H851 = hull_of_recipe(DATABASES / "h851.yaml", depth=DEPTH)
ARMS = [1.0, 1.0, 1.0, BEAM, LENGTH, 1.0]
MASS = 1025.0 * LENGTH * BEAM * DRAUGHT


def afloat(hull: Hull, mass: float = MASS, **changes: object) -> Body:
    """A body of H-851's size with this hull, and no water but what it displaces."""
    inertia = mass * np.diag([22.0, 67.0, 69.0]) ** 2
    centre = (0.0, 0.0, KG - DRAUGHT)
    body = Body("barge", mass, inertia, hydrostatics=hull, centre_of_gravity=centre)
    return replace(body, **changes)


def model_of(body: Body) -> Model:
    return compile_scene(scene(body, {}, 1.0, 0.1)).model


def buoyancy(model: Model, q: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
    """Wrench (6,), energy and rate map E of the only body at coordinates ``q`` (6,)."""
    motion, wrench, stored = new_motion(model.bodies), np.zeros((4, 6)), np.zeros(4)
    place_bodies(q, np.zeros(6), model.bodies, motion)
    add_displacement(motion, model.bodies, model.hulls, wrench)
    add_displacement_energy(motion, model.bodies, model.hulls, stored)
    return wrench[HYDROSTATIC], stored[HYDROSTATIC], motion.rate_map[0]


def section(breadth: float, bottom: float, q: np.ndarray) -> tuple[float, np.ndarray]:
    """Area under water, and its centre from the centre of gravity (y, z) in earth axes, of a
    rectangle at height ``q[2]`` of that centre over its place at rest, heeled by ``q[3]``: by
    cutting the polygon at the water and summing the cross products of its edges."""
    y, low, high = breadth / 2.0, bottom - KG, DEPTH - KG
    corners = np.array([[-y, low], [y, low], [y, high], [-y, high]])
    c, s = np.cos(q[3]), np.sin(q[3])
    points = corners @ np.array([[c, s], [-s, c]])
    level = -(KG - DRAUGHT + q[2])
    kept: list[np.ndarray] = []
    for a, b in zip(points, np.roll(points, -1, axis=0), strict=True):
        if a[1] < level:
            kept.append(a)
        if (a[1] < level) != (b[1] < level):
            kept.append(a + (b - a) * (level - a[1]) / (b[1] - a[1]))
    if not kept:
        return 0.0, np.zeros(2)
    p = np.array(kept)
    n = np.roll(p, -1, axis=0)
    twice = p[:, 0] * n[:, 1] - n[:, 0] * p[:, 1]
    area = twice.sum() / 2.0
    return area, ((p + n) * twice[:, None]).sum(axis=0) / (6.0 * area)


def attitudes(seed: int, count: int) -> np.ndarray:
    """Draughts of 4 to 14 m, heel to 15 deg, and all surge, sway and yaw; on even keel."""
    draw = np.random.default_rng(seed)
    q = draw.uniform(-1.0, 1.0, (count, 6)) * [50.0, 50.0, 5.0, np.radians(15.0), 0.0, np.pi]
    q[:, 2] += DRAUGHT - 9.0
    return q


def test_a_box_has_the_closed_form_while_its_deck_is_dry_and_its_bilge_wet() -> None:
    """F = A (n_3 D - z)^2 / (2 n_3) + (n_1^2 I_xx + n_2^2 I_yy) / (2 n_3) of a vertical prism, D
    being the depth of its keel below the centre of gravity."""
    model, V_0 = model_of(afloat(BOX)), LENGTH * BEAM * DRAUGHT
    A, I_xx, I_yy = LENGTH * BEAM, BEAM * LENGTH**3 / 12.0, LENGTH * BEAM**3 / 12.0
    found = 0
    for q in attitudes(1, 400):
        q[4] = q[3] / 20.0
        phi, theta, z = q[3], q[4], KG - DRAUGHT + q[2]
        n = np.array([-np.sin(theta), np.cos(theta) * np.sin(phi), np.cos(theta) * np.cos(phi)])
        edges = (abs(n[0]) * LENGTH + abs(n[1]) * BEAM) / 2.0 / n[2]
        if not (KG - edges + -z / n[2] > 0.0 and -z / n[2] + edges < DEPTH - KG):
            continue
        found += 1
        wrench, stored, _ = buoyancy(model, q)
        energy = (A * (n[2] * KG - z) ** 2 + n[0] ** 2 * I_xx + n[1] ** 2 * I_yy) / (2.0 * n[2])
        assert_allclose(stored, RHO_G * (energy + V_0 * q[2]), rtol=1e-9)
        lift = RHO_G * (A * (KG - z / n[2]) - V_0)
        assert_allclose(wrench[2], lift, rtol=0, atol=1e-9 * RHO_G * V_0)
        by_n = [n[0] * I_xx, n[1] * I_yy, A * KG * (n[2] * KG - z)]
        by_n[2] -= energy
        arm = np.cross([0.0, 0.0, 1.0], rotation(q[3:]) @ (np.array(by_n) / n[2]))
        assert_allclose(wrench[3:] / RHO_G, arm, rtol=0, atol=1e-9 * V_0 * BEAM)
    assert found > 50


def rotation(angles: np.ndarray) -> np.ndarray:
    """Rz Ry Rx."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_euler("ZYX", angles[::-1]).as_matrix()


def test_a_box_has_the_sections_of_its_polygon_beyond(validated) -> None:
    model, V_0, worst = model_of(afloat(BOX)), LENGTH * BEAM * DRAUGHT, 0.0
    for q in attitudes(2, 200):
        wrench, _, _ = buoyancy(model, q)
        area, (y, _) = section(BEAM, 0.0, q)
        V, moment = LENGTH * area, LENGTH * area * y
        turned = rotation(np.array([0.0, 0.0, q[5]])).T @ wrench[3:] / RHO_G
        off = [wrench[2] / RHO_G - (V - V_0), (turned[0] - moment) / BEAM, turned[1] / BEAM]
        worst = max(worst, float(np.abs(off).max()) / V_0)
    claim = "buoyancy of a box at draughts of 4 to 14 m, heel to 15 deg"
    validated(Kind.CLOSED_FORM, claim, "areas of its polygons", worst, 1e-9, Feature.HULL)


def test_h851_has_the_sections_of_its_lines() -> None:
    """Strips of 0.13 m: the midpoint rule is right to the square of that over the hull's length."""
    model = model_of(afloat(H851))
    hull = barge_of_recipe()
    dx = hull.length / 2000
    x = (np.arange(2000) + 0.5) * dx
    V_0, off = at_rest(afloat(H851), H851, hs.scene.Environment())[0].volume, []
    for q in attitudes(3, 12):
        wrench, _, _ = buoyancy(model, q)
        outline = zip(hull.half_breadth(x), hull.bottom(x), strict=True)
        strips = [section(2.0 * b, z + DRAUGHT, q) for b, z in outline]
        areas = np.array([area for area, _ in strips])
        moment = dx * sum(area * centre[0] for area, centre in strips)
        turned = rotation(np.array([0.0, 0.0, q[5]])).T @ wrench[3:] / RHO_G
        off += [wrench[2] / RHO_G - (dx * areas.sum() - V_0), (turned[0] - moment) / BEAM]
    assert np.abs(off).max() < 1e-6 * V_0


def barge_of_recipe():
    from hydrosim.database.build.recipe import load_recipe

    recipe = load_recipe(DATABASES / "h851.yaml")
    return recipe.data.hull.shape(recipe.data.water)


@pytest.mark.parametrize("hull", [BOX, H851])
def test_the_force_is_the_gradient_of_the_potential(hull: Hull) -> None:
    """By differences of order 4: their own error is (1e-3 of the depth)^4 beside rounding."""
    model, weight = model_of(afloat(hull)), RHO_G * LENGTH * BEAM * DRAUGHT
    for q in attitudes(4, 30):
        q[4] = q[3] / 8.0
        wrench, _, E = buoyancy(model, q)
        own = np.concatenate([wrench[:3], E.T @ wrench[3:]])
        for k, step in enumerate(np.diag([0.02, 0.02, 0.02, 1e-3, 3e-4, 1e-3])):
            e = [buoyancy(model, q + n * step)[1] for n in (-2, -1, 1, 2)]
            slope = (e[0] - 8.0 * e[1] + 8.0 * e[2] - e[3]) / (12.0 * step[k])
            assert abs(own[k] + slope) < 1e-8 * weight * ARMS[k]


def test_there_is_no_horizontal_force_and_no_dependence_on_yaw() -> None:
    model = model_of(afloat(H851))
    for q in attitudes(5, 20):
        q[4] = q[3] / 10.0
        wrench, stored, _ = buoyancy(model, q)
        assert_array_equal(wrench[[0, 1, 5]], 0.0)
        turned, same, _ = buoyancy(model, q * [0.0, 0.0, 1.0, 1.0, 1.0, 0.0])
        assert same == stored
        assert turned[2] == wrench[2]
        assert_allclose(np.hypot(*turned[3:5]), np.hypot(*wrench[3:5]), rtol=1e-12)


def test_it_is_the_matrix_of_the_database_about_the_place_at_rest() -> None:
    db, body = load(DATABASES / "h851.nc"), afloat(H851)
    matrix = at_rest(body, H851, hs.scene.Environment())[1]
    assert_allclose(matrix, db.hydrostatic_stiffness, rtol=0, atol=1e-12 * matrix.max())
    compiled = compile_scene(scene(body, {}, 1.0, 0.1))
    linear = linearise(compiled.model, compiled.state, step=1e-4)
    found = -linear.inertia @ linear.jacobian[6:12, :6]
    scale = np.sqrt(np.outer(*2 * [np.diag(matrix) + np.array([1.0, 1.0, 0.0, 0.0, 0.0, 1.0])]))
    assert np.abs((found - matrix) / scale)[2:5, 2:5].max() < 1e-6


def swinging(hull: Hull) -> Scene:
    """A body that swings in heave, roll and pitch, its bilges and its deck where they are."""
    start = moving(heave=0.5, roll=0.05, pitch=0.004, yaw=0.7)
    return scene(afloat(hull, position=start), {}, 30.0, 0.5)


def test_the_ledger_closes_at_the_order_of_the_method(figure) -> None:
    left = []
    for step in (0.25, 0.125, 0.0625):
        run = hs.simulate(with_step(swinging(H851), step))
        left.append(float(np.abs(run.energy_residual.values).max()))
    orders = np.log2(np.array(left[:-1]) / left[1:])
    figure("order of the ledger", orders[-1])
    assert orders.min() > 3.8
    assert abs(run.position.sel(dof="surge")).max() < 1e-9


@pytest.mark.parametrize("pulled", [False, True])
def test_a_body_that_does_not_weigh_what_it_displaces(pulled: bool) -> None:
    """At 80 % of its weight it rises by 20 % of its draught and rolls as it floats there."""
    draught = DRAUGHT if pulled else 0.8 * DRAUGHT
    start = moving(heave=DRAUGHT - draught)
    body = afloat(BOX, 0.8 * MASS, weight=Weight.CARRIED, position=start)
    pull = {"pull": steady("barge", heave=-0.2 * MASS * 9.81)} if pulled else {}
    compiled = compile_scene(scene(body, pull, 1.0, 0.1))
    linear = linearise(compiled.model, compiled.state)
    stiffness = -linear.inertia @ linear.jacobian[6:12, :6]
    lever = BEAM**2 / (12.0 * draught) + draught / 2.0 - KG
    exact = RHO_G * LENGTH * BEAM * draught * lever
    assert_allclose(stiffness[3, 3], exact, rtol=1e-6)
    assert_allclose(stiffness[2, 2], RHO_G * LENGTH * BEAM, rtol=1e-6)
    run = hs.simulate(scene(body, pull, 5.0, 0.5))
    assert abs(run.position.sel(dof="heave") - start[2]).max() < 1e-9


def test_a_hull_that_is_not_its_own_mirror_image_is_seen() -> None:
    corners = np.where(BOX.corners[..., 1:2] > 0.0, [1.0, 1.02, 1.0], 1.0) * BOX.corners
    level = moving(heave=0.3)
    for hull, zero in ((BOX, True), (Hull(corners), False)):
        still = scene(afloat(hull, position=level), {}, 1.0, 0.1)
        notes = compile_scene(still, in_plane=True).notes
        assert bool(notes.zero) == zero
        assert ("the hull of barge" in notes.symmetry) != zero


def test_parcels_of_triangles_are_what_their_triangles_are() -> None:
    """H-851 as it is and with 64 times as many triangles, in one and in many parcels."""
    coarse, few = model_of(afloat(H851)), H851.corners
    for _ in range(3):
        m = (few + np.roll(few, -1, axis=1)) / 2.0
        parts = [np.stack([few[:, i], m[:, i], m[:, i - 1]], axis=1) for i in range(3)]
        few = np.concatenate([*parts, m])
    fine = model_of(afloat(Hull(few)))
    assert len(fine.hulls.solids.begin) > 100 > len(coarse.hulls.solids.begin)
    for q in attitudes(6, 30):
        q[4] = q[3] / 8.0
        (one, stored, _), (other, same, _) = (buoyancy(model, q) for model in (coarse, fine))
        assert_allclose(other, one, rtol=0, atol=1e-12 * RHO_G * LENGTH * BEAM * DRAUGHT * BEAM)
        assert_allclose(same, stored, rtol=1e-11)


def test_a_hull_that_capsizes_ends_the_run_with_a_message() -> None:
    high = afloat(BOX, centre_of_gravity=(0.0, 0.0, 60.0), position=moving(roll=0.1))
    with pytest.raises(SimulationError, match="is beyond 85 deg, or the heel of its hull"):
        hs.simulate(scene(high, {}, 100.0, 0.5))


def test_small_angles_are_refused() -> None:
    with pytest.raises(InputError, match=r"bodies.hydrostatics: kinematics: linear"):
        hs.simulate(scene(afloat(BOX), {}, 1.0, 0.5, kinematics=Kinematics.LINEAR))
    assert len(DOFS) == 6
