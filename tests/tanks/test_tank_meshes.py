"""Tanks of closed meshes: against boxes, and against closed forms of a wedge and a sphere."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scenes import block, moving, scene
from scipy.spatial import ConvexHull

import hydrosim as hs
from hydrosim.elements import LinearMooring
from hydrosim.errors import InputError
from hydrosim.scene import Box, Pump, Tank, TankMesh, Weight, When
from hydrosim.tanks.mirror import image_indices
from hydrosim.tanks.shapes import capacity, height, pieces, pieces_of_mesh, volume_at
from hydrosim.tanks.surface import SURFACE_MOMENT, quantities_at

ORIGIN = np.array([0.3, -0.2, 0.7])
BOX = Box((-3.0, -1.5, -0.5), (-1.0, 1.0, 2.0), 0.9)


def hull(points: np.ndarray, permeability: float = 1.0) -> TankMesh:
    """The mesh of a convex hull, normals outward."""
    corners = points[ConvexHull(points).simplices]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = np.sum(normal * (corners.mean(axis=1) - points.mean(axis=0)), axis=1) < 0.0
    corners[inward] = corners[inward, ::-1]
    return TankMesh(corners, permeability)


def corners_of(box: Box) -> np.ndarray:
    return np.stack(np.meshgrid(*zip(box.low, box.high, strict=True)), -1).reshape(-1, 3)


def held(mesh: TankMesh | Box, volume: np.ndarray, origin: np.ndarray = ORIGIN) -> np.ndarray:
    """All quantities (n, 13) at volumes (n,), of a mesh without the ends of its surface."""
    own = pieces_of_mesh(mesh, origin) if isinstance(mesh, TankMesh) else pieces(mesh, origin)
    return np.array([quantities_at(own, v) for v in volume])


def test_a_box_that_is_a_mesh_is_the_box() -> None:
    """Walls are upright: cubics over V are exact."""
    mesh = hull(corners_of(BOX), BOX.permeability)
    volume, (there, here) = np.linspace(0.0, capacity(BOX), 401), (BOX, mesh)
    tables = [pieces(shape, ORIGIN) for shape in (there, here)]
    boxed, found = ([quantities_at(table, v) for v in volume] for table in tables)
    assert_allclose(found, boxed, rtol=1e-12, atol=1e-12 * 11.25)
    assert capacity(mesh) == pytest.approx(capacity(BOX), rel=1e-13)
    assert volume_at(mesh, 0.7) == pytest.approx(volume_at(BOX, 0.7), rel=1e-13)
    assert height(mesh) == height(BOX)


def test_two_boxes_on_each_other_are_a_mesh_with_a_step() -> None:
    """4 x 3 m up to 1 m, then 2 x 3 m to the side: slopes jump at the step, and both
    sides are exact."""
    low, high = Box((0.0, 0.0, 0.0), (4.0, 3.0, 1.0)), Box((0.0, 0.0, 1.0), (2.0, 3.0, 3.0))
    parts = [hull(corners_of(box)).corners for box in (low, high)]
    step = [p[~(np.ptp(p[..., 2], axis=1) == 0.0) | (p[:, 0, 2] != 1.0)] for p in parts]
    edge, lid = np.array([[2.0, 0, 1], [4, 0, 1], [4, 3, 1], [2, 3, 1]]), [[0, 1, 2], [0, 2, 3]]
    mesh = TankMesh(np.concatenate([*step, edge[lid]]))
    below, above = np.linspace(0.2, 11.8, 7), np.linspace(0.2, 11.8, 7)
    assert_allclose(held(mesh, below), held(low, below), atol=1e-11)
    full = held(low, np.array([12.0]))[0]
    full[SURFACE_MOMENT:] = 0.0
    assert_allclose(held(mesh, 12.0 + above), full + held(high, above), atol=1e-10)


@pytest.mark.parametrize("level", [0.05, 0.3, 0.777, 2.0, 3.9])
def test_a_wedge_has_its_closed_form(level: float) -> None:
    """|y| < z < 4 m, 10 m long: V = 10 h^2; at the ends of pieces exact, cubics in between."""
    wedge = hull(
        np.array([[x, y, z] for x in (0, 10) for y, z in ((0, 0), (-4, 4), (4, 4))], float)
    )
    h, L, volume = level, 10.0, 10.0 * level**2
    first = [L / 2 * volume, 0.0, 2 * L * h**3 / 3]
    second = [L * L / 3 * volume, L * h**4 / 6, L * h**4 / 2, 0.0, L / 2 * first[2], 0.0]
    surface = [2 * h * L**3 / 12, 0.0, L * (2 * h) ** 3 / 12]
    found = held(wedge, np.array([volume]), np.zeros(3))[0]
    # cubics over the pieces next to the edge, of 1/4096 of the height and up
    assert_allclose(found, [*first, *second, h, *surface], rtol=1e-4 * (0.05 / h), atol=1e-10)
    assert volume_at(wedge, h) == pytest.approx(volume, rel=2e-4 * (0.05 / h))


def test_a_sphere_comes_to_its_closed_form_with_the_square_of_its_panels() -> None:
    radius, h = 3.0, 2.0
    V, r2 = np.pi * h * h * (radius - h / 3), radius**2 - (h - radius) ** 2
    exact = [V, -np.pi * r2**2 / 4, np.pi * r2**2 / 4]
    errors = []
    for n in (8, 16, 32):
        polar, around = np.meshgrid(np.linspace(0, np.pi, n + 1), np.pi * np.arange(2 * n) / n)
        z, r = radius * np.cos(polar), radius * np.sin(polar)
        sphere = hull(np.stack([r * np.cos(around), r * np.sin(around), z], -1).reshape(-1, 3))
        volume = volume_at(sphere, h)
        found = held(sphere, np.array([volume]), np.zeros(3))[0]
        errors.append(np.abs(np.array([volume, *found[[2, SURFACE_MOMENT]]]) / exact - 1.0))
    ratios = np.array(errors[:-1]) / errors[1:]
    assert np.all(ratios[-1] > 3.3)
    assert np.all(errors[-1] < 1e-2)


def test_a_body_pumped_between_meshes_moves_as_one_between_boxes() -> None:
    right = Box((1.5, -0.5, -2.0), (4.0, 2.0, 0.5))
    stiffness = np.diag([3e4, 2e4, 2e5, 4e5, 5e5, 6e5])
    found = []
    for shape in (lambda box: box, lambda box: hull(corners_of(box), box.permeability)):
        tanks = Tank("left", shape(BOX), 2.0, 1000.0), Tank("right", shape(right), 0.4, 1000.0)
        pumps = Pump("across", 90.0, "left", "right", 1.2, 8.9), Pump("out", 40.0, "left", None)
        body = block(2e4, weight=Weight.CARRIED, tanks=tanks, pumps=pumps)
        body = replace(body, position=moving(surge=0.3, roll=0.1))
        hung = scene(body, {"line": LinearMooring("block", stiffness)}, 10.0, 0.5, step=0.05)
        found.append(hs.simulate(hung))
    for name in ("position", "velocity", "tank_level", "energy_work_weight"):
        there, here = (run[name].values for run in found)
        assert_allclose(here, there, atol=1e-12 * np.abs(there).max())


def test_the_mirror_image_of_a_mesh_is_found_whatever_its_triangles() -> None:
    port, starboard = (
        hull(corners_of(Box((-1.0, y, -1.0), (1.0, y + 1.0, 1.0)))) for y in (0.5, -1.5)
    )
    turned = replace(starboard, corners=np.roll(starboard.corners, 1, axis=1))
    longer = hull(corners_of(Box((-1.0, -1.5, -1.0), (1.1, -0.5, 1.0))))
    for other, expected in ((starboard, [1, 0]), (turned, [1, 0]), (longer, [None, None])):
        tanks = Tank("port", port, 1.0), Tank("starboard", other, 1.0)
        assert image_indices(block(2e4, weight=Weight.CARRIED, tanks=tanks))[0] == expected


def test_the_mirror_image_of_a_pump_waits_for_the_image_of_its_tank() -> None:
    port, starboard = Box((-1, 0.5, -1), (1, 1.5, 1)), Box((-1, -1.5, -1), (1, -0.5, 1))
    tanks = Tank("port", port, 1.0), Tank("starboard", starboard, 1.0)
    port_pump, other, wrong = (
        Pump(f"pump {k}", 1.0, of, None, When(channel=f"tank_level.{by} of block", below=0.5))
        for k, (of, by) in enumerate((("port",) * 2, ("starboard",) * 2, ("starboard", "port")))
    )
    for pumps, expected in (((port_pump, other), [1, 0]), ((port_pump, wrong), [None, None])):
        body = block(2e4, weight=Weight.CARRIED, tanks=tanks, pumps=pumps)
        assert image_indices(body)[1] == expected


def test_rooms_above_each_other_are_refused() -> None:
    low, high = (hull(corners_of(Box((0, 0, z), (1, 1, z + 1)))).corners for z in (0.0, 2.0))
    with pytest.raises(InputError, match=r"no room 1 m above the bottom.*separate tanks"):
        pieces(TankMesh(np.concatenate([low, high])), np.zeros(3))
