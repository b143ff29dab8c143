from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hydrosim.database import all_headings
from hydrosim.errors import InputError

HALF_CIRCLE = np.radians([0.0, 45.0, 90.0, 135.0, 180.0])
CIRCLE = np.radians(np.arange(0.0, 360.0, 45.0))


def froude_krylov(headings: np.ndarray, k: float = 0.05) -> np.ndarray:
    """Loads (nh, 6) of a wave exp(-i k (x cos b + y sin b)) exp(k z) on the faces of a wedge-shaped
    box that is symmetric about y = 0 but not fore and aft: pressure summed over points on them."""
    s = (np.arange(20) + 0.5) / 20
    x, z = (a.ravel() for a in np.meshgrid(-30 + 60 * s, -5 * s))
    half = 10 - x / 6
    loads = np.zeros((len(headings), 6), dtype=complex)
    for side in (1.0, -1.0):
        point = np.stack([x, side * half, z], axis=1)
        normal = np.tile([1 / 6, side, 0.0], (x.size, 1))
        weights = np.hstack([normal, np.cross(point, normal)])
        for i, b in enumerate(headings):
            phase = np.exp(k * z - 1j * k * (point[:, 0] * np.cos(b) + point[:, 1] * np.sin(b)))
            loads[i] += phase @ weights
    return loads


def test_full_circle_is_what_a_symmetric_hull_feels(made_up):
    loads = np.tile(froude_krylov(HALF_CIRCLE), (4, 1, 1))
    db = made_up(
        heading=HALF_CIRCLE,
        excitation=loads,
        mean_drift=loads.real,
        froude_krylov=None,
        drift_imbalance=np.tile(np.cos(HALF_CIRCLE), (4, 1)),
    )
    full = all_headings(db)
    expected = froude_krylov(CIRCLE)
    np.testing.assert_allclose(full.heading, CIRCLE, atol=1e-15)
    np.testing.assert_allclose(full.excitation[2], expected, atol=1e-12 * abs(expected).max())
    np.testing.assert_allclose(full.mean_drift[2], expected.real, atol=1e-12 * abs(expected).max())
    np.testing.assert_allclose(full.drift_imbalance[0], np.cos(CIRCLE), atol=1e-15)
    assert full.froude_krylov is None


def test_headings_from_minus_to_plus_180_are_brought_into_one_turn(made_up):
    heading = np.radians([-180.0, -90.0, 0.0, 90.0, 180.0])
    loads = np.tile(froude_krylov(heading), (4, 1, 1))
    db = made_up(
        heading=heading,
        excitation=loads,
        mean_drift=None,
        froude_krylov=loads,
        drift_imbalance=None,
    )
    for symmetric in (True, False):
        full = all_headings(replace(db, port_starboard_symmetric=symmetric))
        np.testing.assert_allclose(full.heading, np.radians([0.0, 90.0, 180.0, 270.0]))
        np.testing.assert_allclose(full.froude_krylov[0], froude_krylov(full.heading), atol=1e-9)


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
