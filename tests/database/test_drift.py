"""Drift of a fixed vertical cylinder in deep water: its waves are known (MacCamy and Fuchs 1954),
so the far-field formulae can be held against the pressure on its wall."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import h1vp, hankel1, jv, jvp

from hydrosim.database.build import drift

RHO, G, RADIUS = 1025.0, 9.81, 10.0
HEADINGS = np.radians([0.0, 30.0, 90.0, 200.0])
ORDERS = np.arange(-30, 31)


def kochin(w: float, place: tuple[float, float]) -> np.ndarray:
    """Of the cylinder at ``place``, (headings, directions). Scattered waves of the elevation

        -sum_n J'_n / H'_n exp(i n (t - b)) sqrt(2 / (pi k r)) exp(i (k r - pi/4))

    have, with Capytaine's Green function, 2 pi k H(t) times i w / g in the place of the sum.
    """
    k = w**2 / G
    ratio = jvp(ORDERS, k * RADIUS) / h1vp(ORDERS, k * RADIUS)
    turn = drift.DIRECTIONS - HEADINGS[:, None]
    waves = np.exp(1j * turn[..., None] * ORDERS) @ ratio
    return (
        -G
        / (2 * np.pi * k * w)
        * waves
        * np.exp(1j * k * (_to(place, HEADINGS)[:, None] - _to(place, drift.DIRECTIONS)))
    )


def _to(place, direction):
    return place[0] * np.cos(direction) + place[1] * np.sin(direction)


def wall_force(w: float) -> float:
    """Mean force along the waves by the pressure on the wall, integrated over depth by hand:

    -rho g / 4 int |eta|^2 n dl + rho / 4 int |grad phi|^2 n dS
    """
    k, t = w**2 / G, np.arange(720) * 2 * np.pi / 720
    ka = k * RADIUS
    radial = jv(ORDERS, ka) - jvp(ORDERS, ka) / h1vp(ORDERS, ka) * hankel1(ORDERS, ka)
    terms = 1j**ORDERS * radial * np.exp(1j * t[:, None] * ORDERS)
    eta, slope = terms.sum(axis=1), (1j * ORDERS * terms).sum(axis=1)
    speeds = (np.abs(slope) ** 2 / RADIUS**2 + k**2 * np.abs(eta) ** 2) / k**2
    per_length = RHO * G * (speeds / 8 - np.abs(eta) ** 2 / 4)
    return float(np.sum(per_length * np.cos(t)) * RADIUS * t[1])


def computed(w: float, place: tuple[float, float]) -> drift.Drift:
    return drift.mean_drift(kochin(w, place), w, HEADINGS, RHO, G)


@pytest.mark.parametrize("w", [0.4, 0.8, 1.4])
def test_far_field_is_the_pressure_on_the_wall(w):
    """Both are exact, so they agree to rounding; so does the energy."""
    result = computed(w, (0.0, 0.0))
    force = wall_force(w)
    np.testing.assert_allclose(result.force[:, 0], force * np.cos(HEADINGS), atol=1e-9 * force)
    np.testing.assert_allclose(result.force[:, 1], force * np.sin(HEADINGS), atol=1e-9 * force)
    np.testing.assert_allclose(result.imbalance, 0.0, atol=1e-9)
    assert not result.force[:, 2:5].any()


@pytest.mark.parametrize("w", [0.4, 0.8, 1.4])
def test_yaw_moment_is_the_force_times_its_arm(w):
    """A cylinder feels no moment about its own axis."""
    x, y = 35.0, -20.0
    force = computed(w, (x, y)).force
    arm = x * force[:, 1] - y * force[:, 0]
    np.testing.assert_allclose(force[:, 5], arm, atol=1e-9 * np.abs(arm).max())


def test_short_waves_are_reflected():
    """Towards 2/3 rho g R, all waves being thrown back (Havelock 1940); 3.5 per cent is left."""
    force = computed(2.2, (0.0, 0.0)).force[0, 0]
    assert force == pytest.approx(RHO * G * RADIUS * 2 / 3, rel=0.05)
