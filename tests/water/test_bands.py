"""Waves in bands: against the sum over all of them, and against sums written out."""

from dataclasses import replace
from math import radians

import numpy as np
import pytest
from known_box import Box, box_at
from scenes import SEA, in_waves, motion, scene_of, with_body

import hydrosim as hs
from hydrosim.dofs import loads_about_z
from hydrosim.scene import Place, SecondOrder, Symmetry
from hydrosim.water.body import WaveBody
from hydrosim.water.components import sea
from hydrosim.water.displaced_loads import FollowingLoads, following_model
from hydrosim.water.narrow_bands import bands_model
from hydrosim.water.slow_path_loads import (
    BLOCK_BEGIN,
    BLOCK_POSITION,
    BLOCK_RATE,
    STATES_PER_FOLLOWED_BODY,
    new_block,
    slow_loads,
)
from hydrosim.water.transfer import excitation_at, mean_drift_at

SWELL = hs.WaveTrain(hs.Jonswap(2.0, 12.0), heading=radians(30.0), ramp=40.0, repeat_period=3600.0)
ACROSS = replace(SWELL, heading=radians(-110.0), seed=4)
OTHER = hs.WaveTrain(hs.Jonswap(1.0, 9.0), heading=radians(80.0), ramp=20.0, repeat_period=3000.0)
SEAS = {"a train": (SWELL,), "two trains": (SWELL, ACROSS), "two seas": (SWELL, OTHER)}
LOADS = (
    (True, SecondOrder.NONE),
    (True, SecondOrder.NEWMAN),
    (True, SecondOrder.MEAN_DRIFT),
    (False, SecondOrder.NEWMAN),
)
YAWS = np.radians([0.0, 1.0, 7.3, 8.0, 24.0, 91.0, -179.9])


def box() -> Box:
    """A box whose frequencies end within the sea, below and above."""
    return box_at(np.linspace(0.44, 0.95, 35), np.arange(0.0, 360.0, 7.5))


def body(order: SecondOrder, **loads: object) -> WaveBody:
    wanted = hs.WaveForces(second_order=order, headings=Place.SLOW, position=Place.MEAN)
    free = np.array([True, True, True, True, False, True])
    changed = replace(wanted, **loads)  # type: ignore[arg-type]
    return WaveBody(box(), (30.0, -12.0), changed, 0, free, heading=0.3)


def loads_along(model: FollowingLoads, begin: float, yaw: float, rate: float) -> np.ndarray:
    """Loads of both orders (rows, 2, 6) in the block from ``begin`` on, at rest but for the yaw."""
    return loads_on_path(model, begin, (0.0, 0.0, yaw), np.array([0.0, 0.0, rate]))


def loads_on_path(
    model: FollowingLoads, begin: float, at: tuple[float, ...], rate: np.ndarray
) -> np.ndarray:
    """Loads of both orders (rows, 2, 6) in the block from ``begin`` on, ``at`` x, y and yaw."""
    y = np.zeros(STATES_PER_FOLLOWED_BODY)
    y[BLOCK_POSITION : BLOCK_POSITION + 3] = at
    y[BLOCK_RATE : BLOCK_RATE + 3] = rate
    y[BLOCK_BEGIN] = begin
    block = new_block(model)
    slow_loads(begin, y, model, block, np.zeros(6), np.zeros(6))
    return block.rows[0].copy()


@pytest.mark.parametrize("name", SEAS)
@pytest.mark.parametrize("order", [SecondOrder.NEWMAN, SecondOrder.MEAN_DRIFT])
def test_bands_of_a_body_that_drifts_are_the_sum_over_waves(name: str, order: SecondOrder) -> None:
    """Drift to 200 m and to 3 km, at speeds up to 1.5 m/s in all directions, at any yaw: within
    1e-6 of the range of the sum over waves, which is written out in `slow`."""
    at = body(order, position=Place.SLOW)
    model = following_model(sea(hs.Environment(waves=SEAS[name])), [at], 2.0)
    assert model.bands.omega.size > 0
    assert model.gathered.omega.size > 0
    waves = model._replace(bands=bands_model([[]]))
    found, expected = [], []
    for far in (0.0, 200.0, 3000.0):
        for begin, yaw, to in ((0.0, 0.0, 0.0), (18.0, 0.3, 2.0), (903.0, -2.5, 4.4)):
            where = (far * np.cos(to), far * np.sin(to), yaw)
            for speed in (0.0, 0.4, 1.5):
                rate = np.array([speed * np.cos(1.0 - to), speed * np.sin(1.0 - to), 0.01 * speed])
                found.append(loads_on_path(model, begin, where, rate))
                expected.append(loads_on_path(waves, begin, where, rate))
    size = np.ptp(expected, axis=(0, 1))
    missed = np.abs(np.subtract(found, expected)).max(axis=(0, 1))
    assert np.all(size[0, :3] > 0.0)
    assert np.all(size[1, [0, 1, 5]] > 0.0)
    assert np.all(missed <= 1e-6 * size)


@pytest.mark.parametrize("position", [Place.SLOW, Place.MEAN])
def test_a_block_knows_nothing_of_those_before(position: Place) -> None:
    """Amplitudes at nodes, loads at headings and rows that are kept from other blocks change no bit
    of the loads of a block."""
    at = body(SecondOrder.NEWMAN, position=position)
    model = following_model(sea(hs.Environment(waves=SEAS["two trains"])), [at], 2.0)
    states = np.zeros((10, STATES_PER_FOLLOWED_BODY))
    states[:, BLOCK_POSITION] = [0.0, 3.0, 30.0, 31.0, 3.0, 0.0, 800.0, 0.0, 0.0, 0.0]
    states[:, BLOCK_POSITION + 2] = [0.0, 0.002, 0.01, -0.03, 0.0, 3.1, -3.1, 0.0, 0.0, 0.0]
    states[:, BLOCK_RATE + 2] = [0.0, 1e-3, 1e-3, -0.2, 0.0, 0.02, 0.0, 0.0, 0.0, 0.0]
    states[:, BLOCK_BEGIN] = [0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 100.0, 102.0, 104.0, 105.1]
    used = new_block(model)
    for y in states:
        fresh = new_block(model)
        for block in (used, fresh):
            slow_loads(y[BLOCK_BEGIN], y, model, block, np.zeros(6), np.zeros(6))
        np.testing.assert_array_equal(used.rows, fresh.rows)


@pytest.mark.parametrize("name", SEAS)
@pytest.mark.parametrize(("first", "order"), LOADS)
def test_bands_are_the_sum_over_all_waves(name: str, first: bool, order: SecondOrder) -> None:
    """At any yaw and rate, in the ramp and after it, across the end of the repeat period."""
    at = body(order, first_order=first)
    model = following_model(sea(hs.Environment(waves=SEAS[name])), [at], 2.0)
    assert 0 < 2 * model.bands.omega.size <= model.omega.size
    waves = model._replace(bands=bands_model([[]]))
    found, expected = [], []
    for yaw in YAWS:
        for begin, rate in ((0.0, 0.0), (18.0, 0.004), (2100.0, -0.01), (3598.0, 0.02)):
            found.append(loads_along(model, begin, yaw, rate))
            expected.append(loads_along(waves, begin, yaw, rate))
    size = np.ptp(expected, axis=(0, 1))
    assert np.all(np.abs(np.subtract(found, expected)).max(axis=(0, 1)) <= 1e-9 * size)
    assert np.all((size[0, :3] > 0.0) == first)
    assert np.all((size[1, [0, 1, 5]] > 0.0) == (order != SecondOrder.NONE))


def test_bands_are_the_sums_of_the_theory() -> None:
    """Re sum X a exp(iwt) and sum_ij a_i a_j (D_i + D_j) / 2 cos(...), written out with what the
    database gives at the yaw. Between headings X is within 1e-5."""
    at = body(SecondOrder.NEWMAN)
    (waves,) = sea(hs.Environment(waves=(replace(SWELL, ramp=0.0),)))
    model = following_model((waves,), [at], 2.0)
    database = at.database
    assert database is not None
    assert model.bands.omega.size > 0
    elevation = waves.amplitudes_at(*at.place())
    for yaw in YAWS:
        rows = loads_along(model, 640.0, yaw, 0.0)
        heading = at.heading + yaw
        X = excitation_at(database, waves.heading - heading, waves.omega)
        D = mean_drift_at(database, waves.heading - heading, waves.omega)
        first = round(640.0 / model.row_step - 0.5) - 2
        for r in (2, len(rows) - 3):
            t = (first + r) * model.row_step
            a = elevation * np.exp(1j * waves.omega * t)
            loads = np.array([(a @ X).real, (a.sum().conj() * a).real @ D])
            expected = loads_about_z(loads, heading) * at.active
            for order, within in ((0, 1e-5), (1, 1e-9)):
                missed = np.abs(rows[r, order] - expected[order]).max()
                assert missed <= within * np.abs(expected[order]).max()


@pytest.mark.parametrize(
    "changed",
    [
        {"position": Place.INSTANTANEOUS},
        {"headings": Place.INSTANTANEOUS},
        {"second_order": SecondOrder.NEWMAN_SQUARE_ROOT},
    ],
)
def test_loads_that_are_no_sums_over_bands_have_none(changed: dict[str, object]) -> None:
    model = following_model(
        sea(hs.Environment(waves=(SWELL,))), [body(SecondOrder.NEWMAN, **changed)]
    )
    assert model.bands.omega.size == 0


def test_seas_that_are_not_of_many_waves_of_few_headings_have_none() -> None:
    """Short crests, waves off the grid, few waves; and a body that turns about another point."""
    tone = hs.WaveTrain(hs.RegularWave(0.8, 9.0), heading=0.2)
    few = replace(SWELL, repeat_period=400.0)
    for waves in ((replace(SWELL, spreading=5.0),), (SWELL, tone), (few,)):
        model = following_model(sea(hs.Environment(waves=waves)), [body(SecondOrder.NEWMAN)])
        assert model.bands.omega.size == 0
    directions = tuple(replace(SWELL, heading=0.1 * n, seed=n) for n in range(9))
    model = following_model(sea(hs.Environment(waves=directions)), [body(SecondOrder.NEWMAN)])
    assert model.bands.omega.size == 0
    aside = replace(body(SecondOrder.NEWMAN), centre=(4.0, 1.0))
    assert following_model(sea(hs.Environment(waves=(SWELL,))), [aside]).bands.omega.size == 0


def test_frequencies_with_a_gap_make_no_bands() -> None:
    """One cell is ten times as wide as the others, so that its envelopes would be as fine."""
    w = np.concatenate([np.linspace(0.3, 0.6, 31), np.linspace(0.7, 1.2, 51)])
    at = replace(body(SecondOrder.NEWMAN), database=box_at(w, np.arange(0.0, 360.0, 7.5)))
    assert following_model(sea(hs.Environment(waves=(SWELL,))), [at]).bands.omega.size == 0


def test_a_body_that_keeps_its_heading_has_the_loads_there() -> None:
    """Block after block, rows are left for the next one: within the error of rows of those of a
    body that yaws by more than is left out."""
    model = following_model(sea(hs.Environment(waves=SEAS["two seas"])), [body(SecondOrder.NEWMAN)])
    turning = model._replace(steady=1e-30 * np.ones(1))
    assert 1e-13 < model.steady[0] < 1e-10
    block = new_block(model)
    y = np.zeros(STATES_PER_FOLLOWED_BODY)
    y[BLOCK_POSITION + 2] = 0.3
    y[BLOCK_RATE + 2] = 0.2 * model.steady[0]
    found, expected = [], []
    for begin in (0.0, 2.0, 4.0, 5.3, 7.3, 7.3 + 2.0 / 7.0, 900.0, 898.0):
        y[BLOCK_BEGIN] = begin
        slow_loads(begin, y, model, block, np.zeros(6), np.zeros(6))
        assert block.steady_first[0] == block.first[0]
        found.append(block.rows[0].copy())
        expected.append(loads_along(turning, begin, 0.3, y[BLOCK_RATE + 2]))
    size = np.ptp(expected, axis=(0, 1))
    assert np.all(np.abs(np.subtract(found, expected)).max(axis=(0, 1)) <= 1e-6 * size)


def yawing(duration: float) -> hs.Scene:
    """A moored barge that waves turn, from a yaw on."""
    base = in_waves(
        scene_of("free_floating"),
        hs.WaveTrain(SEA, heading=radians(60.0), ramp=10.0, repeat_period=10800.0),
    )
    loads = hs.WaveForces(second_order=SecondOrder.NEWMAN, headings=Place.SLOW, position=Place.MEAN)
    moved = with_body(base, wave_forces=loads, velocity=(0.0, 0.0, 0.0, 0.0, 0.0, 0.005))
    solver = hs.Solver(step=0.1, symmetry=Symmetry.IGNORE)
    return replace(moved, forces={}, duration=duration, solver=solver).with_output(
        step=2.0, states=True
    )


def test_a_run_in_bands_restarts_to_the_bit() -> None:
    """From the midst of a longer run and from the end of a shorter one."""
    whole = hs.simulate(yawing(40.0))
    assert np.ptp(motion(whole)[:, 5]) > radians(5.0)
    for before in (whole, hs.simulate(yawing(22.0))):
        after = hs.simulate(replace(yawing(18.0), initial=hs.Start(before, 22.0)))
        np.testing.assert_array_equal(motion(after), motion(whole)[11:])
