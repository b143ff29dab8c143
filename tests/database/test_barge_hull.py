"""The parametric hull of hydro_db: closed forms against its panels and against hand counts."""

import numpy as np
import pytest

from hydrosim.database.build import barge

RHO_G = 1025.0 * 9.81


@pytest.fixture(scope="module")
def h851() -> barge.Barge:
    """Dimensions of the feasibility study, its 51.230 m rounded."""
    sides = {"length": 260.0, "beam": 63.0, "draught": 12.4, "bow_beam": 42.0}
    ends = {"bow_length": 100.0, "stern_length": 51.230, "wall_depth": 2.4, "rake_length": 19.0}
    return barge.Barge(**sides, **ends)


COARSE = barge.Resolution((3, 2, 4, 3, 3), 3, 2, 3, 2, (2, 3, 3), 3)


def area_vectors(panels: np.ndarray) -> np.ndarray:
    return np.cross(panels[:, 2] - panels[:, 0], panels[:, 3] - panels[:, 1]) / 2


def enclosed_volume(panels: np.ndarray) -> float:
    """Signed volume between the panels and the origin, by tetrahedra."""
    corners = [panels[:, [0, 1, 2]], panels[:, [0, 2, 3]]]
    return float(sum(np.linalg.det(triangles).sum() for triangles in corners) / 6)


def test_box_by_hand():
    box = barge.Barge(100.0, 20.0, 5.0, 20.0, 30.0, 40.0, 5.0, 10.0)
    result = barge.hydrostatics(box)
    assert result.volume == pytest.approx(100 * 20 * 5)
    assert result.area == pytest.approx(100 * 20)
    np.testing.assert_allclose(result.centre_of_buoyancy, [50.0, 0.0, -2.5], atol=1e-12)
    C = result.stiffness(-1.0, 1025.0, 9.81) / RHO_G
    expected = [0, 0, 2000, 100 * 20**3 / 12 - 1e4 * 1.5, 20 * 100**3 / 12 - 1e4 * 1.5, 0]
    np.testing.assert_allclose(C, np.diag(expected), atol=1e-9)


def test_rakes_and_taper_by_hand():
    """A box less two wedges under the ends; a waterplane of a rectangle, trapezium, rectangle."""
    raked = barge.Barge(100.0, 20.0, 5.0, 20.0, 30.0, 40.0, 1.0, 10.0)
    assert barge.hydrostatics(raked).volume == pytest.approx(100 * 20 * 5 - 20 * 10 * 4)
    tapered = barge.Barge(100.0, 20.0, 5.0, 10.0, 30.0, 40.0, 5.0, 10.0)
    area = 20 * 40 + 15 * 30 + 10 * 30
    first = 20 * 40 * 20 + (10 * 30 * 55 + 10 * 30 / 2 * 50) + 10 * 30 * 85
    result = barge.hydrostatics(tapered)
    assert result.area == pytest.approx(area)
    assert result.moment_x == pytest.approx(first)


def test_particulars_of_the_study(h851):
    """Figures of the feasibility study, to its digits."""
    result = barge.hydrostatics(h851)
    assert RHO_G * result.area == pytest.approx(132_105e3, rel=1e-5)
    assert result.volume == pytest.approx(152_935, rel=1e-5)
    assert result.centre_of_buoyancy[0] == pytest.approx(118.571, abs=1e-3)
    assert result.moment_x / result.area == pytest.approx(117.756, abs=1e-3)
    assert result.centre_of_buoyancy[2] + 12.4 == pytest.approx(6.387, abs=1e-3)
    C = result.stiffness(7.5 - 12.4, 1025.0, 9.81)
    weight = RHO_G * result.volume
    assert C[3, 3] / weight == pytest.approx(18.82, abs=0.01)
    assert C[4, 4] / weight == pytest.approx(484.8, abs=0.1)
    assert C[2, 4] == pytest.approx(1.076e8, rel=1e-3)


@pytest.mark.parametrize("mesh", [COARSE, barge.Resolution()])
def test_panels_close_the_hull_exactly(h851, mesh):
    """Plane faces with their corners on stations: no discretisation error, normals outward."""
    result = barge.hydrostatics(h851)
    hull = barge.with_mirror_image(barge.half_hull(h851, mesh))
    lid = barge.with_mirror_image(barge.half_lid(h851, mesh))
    assert enclosed_volume(hull) == pytest.approx(result.volume, rel=1e-12)
    up = np.array([0.0, 0.0, result.area])
    np.testing.assert_allclose(area_vectors(hull).sum(axis=0), -up, atol=1e-8)
    np.testing.assert_allclose(area_vectors(lid).sum(axis=0), -up, atol=1e-8)
    assert (np.linalg.norm(area_vectors(hull), axis=1) > 0).all()


def test_second_moments_converge_to_the_closed_form(h851):
    """Midpoint sums over the lid: second order in the panels' size."""

    def error(factor: int) -> float:
        mesh = barge.Resolution(lid_along=(2 * factor, 3 * factor, 3 * factor), lid_across=factor)
        lid = barge.with_mirror_image(barge.half_lid(h851, mesh))
        areas = -area_vectors(lid)[:, 2]
        return float(areas @ lid.mean(axis=1)[:, 1] ** 2 / result.second_yy - 1)

    result = barge.hydrostatics(h851)
    assert error(4) / error(8) == pytest.approx(4.0, rel=0.05)
    assert abs(error(32)) < 1e-3


def test_number_of_panels(h851):
    mesh = barge.Resolution()
    assert len(barge.with_mirror_image(barge.half_hull(h851, mesh))) == 2368
    assert len(barge.with_mirror_image(barge.half_lid(h851, mesh))) == 912
