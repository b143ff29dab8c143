from dataclasses import replace

import numpy as np
import pytest

from hydrosim.database import all_headings
from hydrosim.errors import InputError

HALF_CIRCLE = np.radians([0.0, 45.0, 90.0, 135.0, 180.0])
CIRCLE = np.radians(np.arange(0.0, 360.0, 45.0))


def wedge() -> tuple[np.ndarray, np.ndarray]:
    """Points (m, 3) on the sides of a wedge-shaped box that is symmetric about y = 0 but not fore
    and aft, and what a pressure of one there gives in loads (m, 6)."""
    s = (np.arange(20) + 0.5) / 20
    x, z = (a.ravel() for a in np.meshgrid(-30 + 60 * s, -5 * s))
    half = 10 - x / 6
    point = np.concatenate([np.stack([x, side * half, z], axis=1) for side in (1.0, -1.0)])
    normal = np.stack([np.full(2 * x.size, 1 / 6), np.repeat([1.0, -1.0], x.size)], axis=1)
    normal = np.hstack([normal, np.zeros((2 * x.size, 1))])
    return point, np.hstack([normal, np.cross(point, normal)])


def wave(point: np.ndarray, k: float, heading: float) -> np.ndarray:
    """exp(-i k (x cos b + y sin b)) exp(k z)."""
    along = point[:, 0] * np.cos(heading) + point[:, 1] * np.sin(heading)
    return np.exp(k * point[:, 2] - 1j * k * along)


def froude_krylov(headings: np.ndarray, k: float = 0.05) -> np.ndarray:
    """Loads (nh, 6) of a wave's pressure summed over points of the wedge."""
    point, loads = wedge()
    return np.array([wave(point, k, b) @ loads for b in headings])


def pressure_of_pairs(headings: np.ndarray, k: np.ndarray) -> np.ndarray:
    """Loads (np, nq, nq, 6) of the product of two waves' pressures on the wedge, that of the
    second conjugate."""
    point, loads = wedge()
    waves = {b: np.array([wave(point, one, b) for one in k]) for b in np.unique(headings)}
    return np.array(
        [np.einsum("ip,jp,pd->ijd", waves[b], waves[c].conj(), loads) for b, c in headings]
    )


def test_full_circle_is_what_a_symmetric_hull_feels(made_up):
    loads = np.tile(froude_krylov(HALF_CIRCLE), (4, 1, 1))
    db = made_up(
        heading=HALF_CIRCLE,
        excitation=loads,
        mean_drift=loads.real,
        mean_drift_held=2 * loads.real,
        froude_krylov=None,
        drift_imbalance=np.tile(np.cos(HALF_CIRCLE), (4, 1)),
    )
    full = all_headings(db)
    expected = froude_krylov(CIRCLE)
    np.testing.assert_allclose(full.heading, CIRCLE, atol=1e-15)
    np.testing.assert_allclose(full.excitation[2], expected, atol=1e-12 * abs(expected).max())
    np.testing.assert_allclose(full.mean_drift[2], expected.real, atol=1e-12 * abs(expected).max())
    np.testing.assert_array_equal(full.mean_drift_held, 2 * full.mean_drift)
    np.testing.assert_allclose(full.drift_imbalance[0], np.cos(CIRCLE), atol=1e-15)
    assert full.froude_krylov is None


def test_headings_from_minus_to_plus_180_are_brought_into_one_turn(made_up):
    heading = np.radians([-180.0, -90.0, 0.0, 90.0, 180.0])
    loads = np.tile(froude_krylov(heading), (4, 1, 1))
    db = made_up(
        heading=heading,
        excitation=loads,
        mean_drift=None,
        mean_drift_held=None,
        froude_krylov=loads,
        drift_imbalance=None,
    )
    for symmetric in (True, False):
        full = all_headings(replace(db, port_starboard_symmetric=symmetric))
        np.testing.assert_allclose(full.heading, np.radians([0.0, 90.0, 180.0, 270.0]))
        np.testing.assert_allclose(full.froude_krylov[0], froude_krylov(full.heading), atol=1e-9)


def test_pairs_of_headings_get_their_images(made_up):
    k = np.array([0.02, 0.05, 0.11])
    pairs = np.radians([[0.0, 0.0], [0.0, 45.0], [45.0, 90.0], [-45.0, 45.0], [180.0, 180.0]])
    transfer = pressure_of_pairs(pairs, k)
    db = made_up(qtf_frequency=k, qtf_heading=pairs, qtf_difference=transfer, qtf_sum=None)
    full = all_headings(db)
    expected = np.radians(
        [[0, 0], [0, 45], [0, 315], [45, 90], [45, 315], [180, 180], [315, 45], [315, 270]]
    )
    np.testing.assert_allclose(full.qtf_heading, expected, atol=1e-12)
    np.testing.assert_allclose(
        full.qtf_difference, pressure_of_pairs(expected, k), atol=1e-12 * abs(transfer).max()
    )
    assert full.qtf_sum is None
    one_sided = all_headings(replace(db, port_starboard_symmetric=False))
    assert len(one_sided.qtf_heading) == len(pairs)


def test_several_bodies_are_mirrored_each(made_up):
    db = made_up(2, heading=np.radians([0.0, 60.0, 180.0]))
    full = all_headings(db)
    assert full.heading.size == 4
    sign = np.array([1, -1, 1, -1, 1, -1] * 2)
    np.testing.assert_array_equal(full.excitation[:, 3], db.excitation[:, 1] * sign)


def test_checksum_follows_the_numbers_only(made_up):
    db = made_up()
    assert made_up().checksum == db.checksum
    assert replace(db, source="elsewhere", attributes={}).checksum == db.checksum
    assert replace(db, gravity=9.80665).checksum != db.checksum
    assert replace(db, mean_drift=None).checksum != db.checksum
    nudged = db.added_mass.copy()
    nudged[1, 2, 3] = np.nextafter(nudged[1, 2, 3], np.inf)
    assert replace(db, added_mass=nudged).checksum != db.checksum


@pytest.mark.parametrize("name", ["added_mass", "excitation", "mean_drift", "centre_of_gravity"])
def test_wrong_shape_is_refused(made_up, name):
    value = getattr(made_up(), name)
    with pytest.raises(InputError, match=f"{name} has shape .* expected"):
        made_up(**{name: value[..., :-1]})


@pytest.mark.parametrize("name", ["radiation_damping", "excitation", "heading"])
def test_nan_is_refused(made_up, name):
    value = getattr(made_up(), name).copy()
    value[-1] = np.nan
    with pytest.raises(InputError, match=f"{name} has .* not numbers"):
        made_up(**{name: value})


@pytest.mark.parametrize("name", ["water_depth", "water_density", "gravity"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan])
def test_water_that_cannot_be_is_refused(made_up, name, value):
    with pytest.raises(InputError, match=f"{name} is {value}, expected a positive number"):
        made_up(**{name: value})
