"""A chain whose fairlead goes round on a circle, against measured tensions (`cases/chain`).

Static balance has no period: it is near the measurement where the chain moves slowly, and must fall
short of it where it moves fast. MoorDyn's chain moves. Nothing is fitted.
"""

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest

import hydrosim as hs
from cases.chain.comparison import CASE, FOLDER, measured_maxima, moordyn_maximum, static_maximum
from hydrosim.elements.line.hang import pieces_of_segments
from hydrosim.report.evidence import Feature, Kind

EXPERIMENT = "Bergdahl et al. 2016, measured at 5 radii"
SLOWEST, FASTEST = 3.5, 1.25  # s
AT_REST = 22.91724165  # N, MoorPy 1.3.0 with friction of the bed
SOME = ((1.25, 0.075), (1.25, 0.2), (2.5, 0.1), (3.5, 0.075), (3.5, 0.2))
"""Periods [s] and radii [m]: the corners of the measurement, and a pair between them."""


@pytest.fixture(scope="module")
def errors() -> np.ndarray:
    """Errors of the static balance, of the measured tension: 6 periods x 5 radii."""
    found = [static_maximum(radius) / tension - 1.0 for _, radius, tension in measured_maxima()]
    return np.array(found).reshape(6, 5)


def measured_tension(period: float, radius: float) -> float:
    """Measured largest tension [N] at a period [s] and a radius [m]."""
    table = measured_maxima()
    (row,) = np.flatnonzero((table[:, 0] == period) & (table[:, 1] == radius))
    return float(table[row, 2])


def test_the_measurement_is_whole() -> None:
    """Six periods, five radii each; the tension rises with the radius and falls with the period."""
    periods, radii, tensions = measured_maxima().T.reshape(3, 6, 5)
    np.testing.assert_array_equal(periods[:, 0], [1.25, 1.5, 2.0, 2.5, 3.0, 3.5])
    np.testing.assert_array_equal(radii[0], [0.075, 0.1, 0.125, 0.15, 0.2])
    assert np.all(np.diff(tensions, axis=0) < 0.0)
    assert np.all(np.diff(tensions, axis=1) > 0.0)


@pytest.mark.parametrize(("period", "limit"), [(SLOWEST, 0.19), (FASTEST, 0.43)])
def test_static_balance_against_the_measured_tensions(
    errors: np.ndarray, period: float, limit: float, validated: Callable[..., None]
) -> None:
    row = errors[0] if period == FASTEST else errors[-1]
    claim = f"chain in static balance, fairlead on a circle in {period:g} s, largest tension"
    error = float(np.abs(row).max())
    validated(Kind.EXPERIMENT, claim, EXPERIMENT, error, limit, Feature.CATENARIES)


def test_the_shorter_the_period_the_more_static_balance_falls_short(
    errors: np.ndarray, figure: Callable[[str, float], None]
) -> None:
    """It is right within the scatter where chain and circle are slow and small."""
    assert np.all(np.diff(errors, axis=0) > 0.0)
    figure("error at 3.5 s and 0.075 m", errors[-1, 0])
    figure("smallest error at 1.25 s", np.abs(errors[0]).min())
    assert abs(errors[-1, 0]) < 0.035
    assert np.all(errors[0] < -0.3)


def test_the_chain_at_rest_is_that_of_moorpy() -> None:
    """On a wheel without a radius. The file for MoorDyn holds the same chain."""
    assert static_maximum(0.0) == pytest.approx(AT_REST, rel=1e-8)
    ours = hs.load_case(CASE).scene().forces["chain"]
    lines = {"type": "lines", "file": str(FOLDER / "moordyn.txt"), "body": "wheel"}
    theirs = hs.load_case(CASE, {"forces": {"mooring": lines}}).scene().forces["mooring_1"]
    assert_same_chain(ours, theirs)


def assert_same_chain(ours: Any, theirs: Any) -> None:
    """Two catenaries between the same ends, of the same pieces."""
    np.testing.assert_allclose(theirs.point, ours.point, atol=1e-12)
    np.testing.assert_allclose(theirs.anchor, ours.anchor, atol=1e-12)
    there, here = (pieces_of_segments(line.segments) for line in (theirs, ours))
    np.testing.assert_allclose(there["length"], here["length"])
    np.testing.assert_allclose(there["weight"], here["weight"], rtol=1e-4)
    np.testing.assert_allclose(there["stiffness"], here["stiffness"])
    assert theirs.friction == ours.friction


@pytest.mark.extras
@pytest.mark.slow
@pytest.mark.skipif(find_spec("moordyn") is None, reason="needs the extra moordyn")
def test_moordyn_through_the_door_against_the_measured_tensions(
    figure: Callable[[str, float], None],
) -> None:
    """Its chain has inertia and drag. One pair of the thirty at each corner, and one between."""
    found = []
    for period, radius in SOME:
        error = moordyn_maximum(period, radius) / measured_tension(period, radius) - 1.0
        figure(f"MoorDyn at {period:g} s and {radius:g} m", error)
        found.append(error)
    assert np.abs(found).max() < 0.085
    assert np.abs(found).mean() < 0.06
