from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from known_box import Box, box_at, froude_krylov

from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Environment, Jonswap, Place, RegularWave, WaveForces, WaveTrain
from hydrosim.water.body import WaveBody
from hydrosim.water.build import wave_loads_model
from hydrosim.water.components import sea
from hydrosim.water.displaced_loads import following_loads, following_model, new_sums
from hydrosim.water.loads import wave_loads

SWELL = WaveTrain(Jonswap(2.0, 16.0, 3.3), heading=np.radians(30), ramp=30.0, repeat_period=900.0)
TONE = WaveTrain(RegularWave(0.8, 14.0, phase=0.4), heading=np.radians(-70))
WATER = Environment(waves=(SWELL, TONE))
TIMES = np.array([3.0, 47.3, 200.0])


def body(box: Box, position: Place, headings: Place, **changes: object) -> WaveBody:
    wanted = WaveForces(position=position, headings=headings)
    at = WaveBody(box, (30.0, -12.0), wanted, 0, np.ones(6, dtype=bool), (4.0, 1.0))
    return replace(at, **changes)


def following(at: WaveBody, moved: np.ndarray, water: Environment = WATER) -> np.ndarray:
    """Loads (nt, 6) on a body moved by (6,)."""
    model, found = following_model(sea(water), [at]), np.zeros((TIMES.size, 6))
    for t, load in zip(TIMES, found, strict=True):
        following_loads(t, moved, model, new_sums(model), load, np.zeros(12))
    return found


def at_rest(at: WaveBody, water: Environment = WATER) -> np.ndarray:
    """Loads (nt, 6) from the tables."""
    still = replace(at, wave_forces=WaveForces())
    model, found = wave_loads_model(sea(water), [still], 0.0, 0.1, 200.0), np.zeros((TIMES.size, 6))
    for t, load in zip(TIMES, found, strict=True):
        wave_loads(t, model, load, np.zeros(6))
    return found


@pytest.mark.parametrize("position", [Place.MEAN, Place.INSTANTANEOUS])
@pytest.mark.parametrize("headings", [Place.MEAN, Place.INSTANTANEOUS])
def test_at_rest_it_is_the_table(box: Box, position: Place, headings: Place) -> None:
    at = body(box, position, headings)
    asked = Place.INSTANTANEOUS in (position, headings)
    expected = at_rest(at) if asked else np.zeros((3, 6))
    found = following(at, np.zeros(6))
    np.testing.assert_allclose(found, expected, atol=1e-11 * np.abs(at_rest(at)).max())
    assert (wave_loads_model(sea(WATER), [at], 0.0, 0.1, 200.0).first_dof.size == 0) == asked


def test_a_body_that_has_moved_is_a_body_elsewhere(box: Box) -> None:
    moved = np.array([11.0, -25.0, 1.0, 0.1, 0.05, 0.3])
    at = body(box, Place.INSTANTANEOUS, Place.MEAN)
    elsewhere = at_rest(replace(at, location=(41.0, -37.0)))
    np.testing.assert_allclose(
        following(at, moved), elsewhere, atol=1e-11 * np.abs(elsewhere).max()
    )
    still = following(body(box, Place.MEAN, Place.INSTANTANEOUS), np.append(moved[:5], 0.0))
    np.testing.assert_allclose(still, at_rest(at), atol=1e-11 * np.abs(elsewhere).max())


@pytest.mark.parametrize("yaw", [0.2, -1.1, 3.0, 7.0])
def test_a_body_that_has_turned_sees_waves_from_elsewhere(
    yaw: float, validated: Callable[..., None]
) -> None:
    """In axes that turn with it, with the centre of gravity where it was: Froude-Krylov loads on a
    box in closed form. Frequencies are nodes of the table; the error is that of the headings'
    polynomials (1e-6 of the largest at 0.6 rad/s and below), and 1e-4 of Lagrange's."""
    tone = WaveTrain(RegularWave(0.8, 2 * np.pi / 0.4, phase=0.4), heading=np.radians(-70))
    box = box_at(np.arange(1, 40) * 0.02, np.arange(0.0, 360.0, 15.0))
    at = body(box, Place.INSTANTANEOUS, Place.INSTANTANEOUS)
    found = following(at, np.array([0, 0, 0, 0, 0, yaw]), Environment(waves=(tone,)))

    k, b = 0.4**2 / 9.81, np.radians(-70)
    load = froude_krylov(np.array([0.4]), np.array([b - yaw]))[0, 0, :3]
    # the box's loads are per elevation at its frame's origin; the centre of gravity is off it
    place = np.array([34.0, -11.0])
    arm = np.array([4.0 * np.cos(yaw) - np.sin(yaw), 4.0 * np.sin(yaw) + np.cos(yaw)])
    angle = 0.4 * TIMES + 0.4 - k * ((place - arm) @ [np.cos(b), np.sin(b)])
    turned = 0.8 * np.real(load * np.exp(1j * angle)[:, None])
    expected = np.stack(
        [
            turned[:, 0] * np.cos(yaw) - turned[:, 1] * np.sin(yaw),
            turned[:, 0] * np.sin(yaw) + turned[:, 1] * np.cos(yaw),
            turned[:, 2],
        ],
        axis=1,
    )
    error = np.abs(found[:, :3] - expected).max() / np.abs(load).max()
    claim, against = "loads on a box that has turned", "Froude-Krylov loads of a box"
    validated(Kind.CLOSED_FORM, claim, against, error, 1e-4, Feature.FOLLOWING)


def test_locked_degrees_of_freedom_have_no_load(box: Box) -> None:
    active = np.array([True, False, True, True, True, False])
    at = body(box, Place.INSTANTANEOUS, Place.INSTANTANEOUS, active=active)
    found = following(at, np.array([1.0, 0, 0, 0, 0, 0.1]))
    assert np.all(found[:, ~active] == 0.0)
    assert np.all(found[:, [0, 2]] != 0.0)


def test_second_of_two_bodies(box: Box) -> None:
    one = body(box, Place.MEAN, Place.MEAN)
    other = body(box, Place.INSTANTANEOUS, Place.INSTANTANEOUS, offset=6)
    moved = np.concatenate([np.full(6, 9.0), [3.0, -2.0, 0.0, 0.0, 0.0, 0.2]])
    model, load = following_model(sea(WATER), [one, other]), np.zeros(12)
    following_loads(TIMES[1], moved, model, new_sums(model), load, np.zeros(12))
    np.testing.assert_array_equal(load[:6], 0.0)
    np.testing.assert_array_equal(load[6:], following(replace(other, offset=0), moved[6:])[1])


def test_equal_databases_have_one_table(box: Box) -> None:
    """Loads of two bodies are those of each alone; the table is stored once, unless they differ."""
    first = body(box, Place.INSTANTANEOUS, Place.INSTANTANEOUS)
    equal = replace(box, excitation=box.excitation.copy())
    larger = replace(box, excitation=2.0 * box.excitation)
    one = following_model(sea(WATER), [first])
    for other, factor, tables in ((equal, 1.0, 1), (larger, 2.0, 2)):
        second = replace(first, database=other, offset=6)
        model = following_model(sea(WATER), [first, second])
        assert model.load.size == tables * one.load.size
        moved = np.tile([11.0, -25.0, 1.0, 0.1, 0.05, 0.3], 2)
        found = np.zeros(12)
        following_loads(TIMES[2], moved, model, new_sums(model), found, np.zeros(12))
        alone = following(first, moved[:6])[2]
        np.testing.assert_array_equal(found[:6], alone)
        np.testing.assert_allclose(found[6:], factor * alone, rtol=1e-12)
