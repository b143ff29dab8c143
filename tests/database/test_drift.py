"""Drift of a fixed vertical cylinder that stands on the sea bed: its waves are known (MacCamy and
Fuchs 1954), so the far-field formulae can be held against the pressure on its wall."""

import numpy as np
import pytest
from scipy.special import h1vp, hankel1, jv, jvp

from hydrosim.database.build import drift
from hydrosim.database.build.drift import Water
from hydrosim.report.evidence import Feature, Kind

RHO, G, RADIUS = 1025.0, 9.81, 10.0
HEADINGS = np.radians([0.0, 30.0, 90.0, 200.0])
ORDERS = np.arange(-30, 31)


def kochin(w: float, place: tuple[float, float], water: Water) -> np.ndarray:
    """Of the cylinder at ``place``, (headings, directions). Scattered waves of the elevation

        -sum_n J'_n / H'_n exp(i n (t - b)) sqrt(2 / (pi k r)) exp(i (k r - pi/4))

    have, with Capytaine's Green function, i pi k^2 H(t) / (w n) in the place of the sum, n being
    the ratio of group to phase velocity; in deep water, 2 pi k H(t) times i w / g.
    """
    k = water.wavenumber(w)
    ratio = jvp(ORDERS, k * RADIUS) / h1vp(ORDERS, k * RADIUS)
    turn = drift.DIRECTIONS - HEADINGS[:, None]
    waves = np.exp(1j * turn[..., None] * ORDERS) @ ratio
    return (
        -w
        * group_ratio(k, water.depth)
        / (np.pi * k**2)
        * waves
        * np.exp(1j * k * (_to(place, HEADINGS)[:, None] - _to(place, drift.DIRECTIONS)))
    )


def group_ratio(k: float, depth: float) -> float:
    return 0.5 if np.isinf(depth) else 0.5 + k * depth / np.sinh(2 * k * depth)


def _to(place, direction):
    return place[0] * np.cos(direction) + place[1] * np.sin(direction)


def fading(k: float, depth: float) -> tuple[float, float]:
    """Integrals over the depth of Z^2 and (Z'/k)^2, Z = cosh k(z + h) / cosh kh."""
    if np.isinf(depth):
        return 1 / (2 * k), 1 / (2 * k)
    wave, flat = np.sinh(2 * k * depth) / (4 * k), depth / 2
    return (wave + flat) / np.cosh(k * depth) ** 2, (wave - flat) / np.cosh(k * depth) ** 2


def wall_force(w: float, water: Water) -> float:
    """Mean force along the waves by the pressure on the wall, integrated over depth by hand:

    -rho g / 4 int |eta|^2 n dl + rho / 4 int |grad phi|^2 n dS
    """
    k, t = water.wavenumber(w), np.arange(720) * 2 * np.pi / 720
    ka = k * RADIUS
    radial = jv(ORDERS, ka) - jvp(ORDERS, ka) / h1vp(ORDERS, ka) * hankel1(ORDERS, ka)
    terms = 1j**ORDERS * radial * np.exp(1j * t[:, None] * ORDERS)
    eta, slope = terms.sum(axis=1), (1j * ORDERS * terms).sum(axis=1)
    along, upward = fading(k, water.depth)
    speeds = along * np.abs(slope) ** 2 / RADIUS**2 + upward * k**2 * np.abs(eta) ** 2
    per_length = RHO / 4 * ((G / w) ** 2 * speeds - G * np.abs(eta) ** 2)
    return float(np.sum(per_length * np.cos(t)) * RADIUS * t[1])


def computed(w: float, place: tuple[float, float], water: Water) -> drift.MeanDrift:
    return drift.mean_drift(kochin(w, place, water), w, HEADINGS, water)


@pytest.mark.parametrize("depth", [np.inf, 50.0, 12.0])
@pytest.mark.parametrize("w", [0.4, 0.8, 1.4])
def test_far_field_is_the_pressure_on_the_wall(w, depth, validated):
    """Both are exact, so they agree to rounding; so does the energy."""
    water = Water(RHO, G, depth)
    result, force = computed(w, (0.0, 0.0), water), wall_force(w, water)
    error = np.abs(result.force[:, 0] - force * np.cos(HEADINGS)).max() / force
    claim, against = "mean drift of a standing cylinder", "MacCamy and Fuchs 1954"
    validated(Kind.CLOSED_FORM, claim, against, error, 1e-9, Feature.RECIPES)
    np.testing.assert_allclose(result.force[:, 1], force * np.sin(HEADINGS), atol=1e-9 * force)
    np.testing.assert_allclose(result.imbalance, 0.0, atol=1e-9)
    assert not result.force[:, 2:5].any()


@pytest.mark.parametrize("depth", [np.inf, 50.0, 12.0])
@pytest.mark.parametrize("w", [0.4, 0.8, 1.4])
def test_yaw_moment_is_the_force_times_its_arm(w, depth):
    """A cylinder feels no moment about its own axis."""
    place = x, y = 35.0, -20.0
    water = Water(RHO, G, depth)
    waves = kochin(w, place, water)
    force = drift.mean_drift(waves, w, HEADINGS, water).force
    arm = x * force[:, 1] - y * force[:, 0]
    np.testing.assert_allclose(force[:, 5], arm, atol=1e-9 * np.abs(arm).max())
    own = drift.mean_drift(waves, w, HEADINGS, water, place).force
    np.testing.assert_allclose(own[:, 5], 0.0, atol=1e-9 * np.abs(arm).max())
    np.testing.assert_allclose(own[:, :2], force[:, :2], rtol=1e-9, atol=1e-9 * force.max())


def test_short_waves_are_reflected():
    """Towards 2/3 rho g R, all waves being thrown back (Havelock 1940); 3.5 per cent is left."""
    force = computed(2.2, (0.0, 0.0), Water(RHO, G)).force[0, 0]
    assert force == pytest.approx(RHO * G * RADIUS * 2 / 3, rel=0.05)
