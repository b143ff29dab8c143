"""Waves along a slow path: against sums over the waves where the body is, and in runs."""

from collections.abc import Callable
from dataclasses import replace
from math import radians

import numpy as np
import pytest
from known_box import Box
from scenes import SEA, hull, in_waves, motion, scene_of, steady, with_body

import hydrosim as hs
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import ConvolutionRadiation, Place, SecondOrder, Symmetry
from hydrosim.water.body import WaveBody
from hydrosim.water.components import sea
from hydrosim.water.displaced_loads import (
    chosen_places,
    following_loads,
    following_model,
    new_sums,
    slow_bodies,
)
from hydrosim.water.slow_path_loads import (
    BLOCK_BEGIN,
    BLOCK_POSITION,
    BLOCK_RATE,
    begin_block,
    first_states,
    new_block,
    slow_loads,
)

LONG = hs.Jonswap(2.0, 16.0, 3.3)
SWELL = hs.WaveTrain(LONG, heading=radians(30), ramp=30.0, repeat_period=900.0)
TONE = hs.WaveTrain(hs.RegularWave(0.8, 14.0, phase=0.4), heading=radians(-70))
SHORT = hs.WaveTrain(hs.Jonswap(1.0, 11.0), heading=radians(100), repeat_period=900.0, spreading=5)
WATER = hs.Environment(waves=(SWELL, TONE, SHORT))
TRACKED = [0, 1, 5]


def body(box: Box, place: Place) -> WaveBody:
    wanted = hs.WaveForces(position=place, headings=place)
    every = np.ones(6, dtype=bool)
    return WaveBody(box, (30.0, -12.0), wanted, 0, every, (4.0, 1.0), heading=0.3)


@pytest.mark.parametrize("rate", [(0.0, 0.0, 0.0), (0.7, -0.4, 0.004)])
def test_on_its_path_the_loads_are_those_where_it_is(
    box: Box, rate: tuple[float, float, float], validated: Callable[..., None]
) -> None:
    """A body that drifts and turns steadily, against the sum over all waves at its place at every
    time. Rows are within 1e-6 of the sea's deviation; a straight line between transfer functions
    at the ends of a block of 2 s is off by (psi' T k L / 2)^2 / 8, 4e-5 of the largest."""
    v = np.zeros(6)
    v[TRACKED] = rate
    slow = following_model(sea(WATER), [body(box, Place.SLOW)], 2.0)
    there = following_model(sea(WATER), [body(box, Place.INSTANTANEOUS)], 2.0)
    block, sums = new_block(slow), new_sums(there)
    size, missed = 0.0, 0.0
    for begin in (0.0, 48.0, 700.0):
        q = np.array([20.0, -35.0, 0.0, 0.0, 0.0, 0.4]) + v * begin
        y = first_states(slow, q, v, begin)
        for t in begin + np.array([0.0, 0.05, 0.61, 1.3, 2.0]):
            found, expected = np.zeros((2, 6))
            slow_loads(t, y, slow, block, found, np.zeros(6))
            following_loads(t, q + v * (t - begin), there, sums, expected, np.zeros(12))
            size = max(size, np.abs(expected[:3]).max())
            missed = max(missed, np.abs(found - expected)[:3].max())
    assert missed < (2e-4 if any(rate) else 2e-5) * size
    claim = "loads on a body that drifts and turns, of the largest"
    against = "sum over all waves, at its place"
    validated(Kind.SELF, claim, against, missed / size, 2e-4, Feature.FOLLOWING)


def test_a_filter_follows_a_drift_without_a_lag(box: Box) -> None:
    """z_k of q = v t is v (t - k / c), so 3 z_2 - 2 z_3 is q and its rate v."""
    model = following_model(sea(WATER), [body(box, Place.SLOW)], 2.0)
    v = np.array([0.3, -0.2, 0.0, 0.0, 0.0, 0.01])
    y = first_states(model, 50.0 * v, v, 0.0)
    begin_block(50.0, y, model)
    np.testing.assert_allclose(
        y[BLOCK_POSITION : BLOCK_POSITION + 3], 50.0 * v[TRACKED], rtol=1e-12
    )
    np.testing.assert_allclose(y[BLOCK_RATE : BLOCK_RATE + 3], v[TRACKED], rtol=1e-12)
    assert y[BLOCK_BEGIN] == 50.0


def test_the_rate_of_a_path_is_that_of_its_position(box: Box) -> None:
    """z_k of q = a t^2 / 2 is a (t^2 / 2 - k t / c + k (k + 1) / (2 c^2)): 3 z_2 - 2 z_3 is
    q - 3 a / c^2, and its rate a t."""
    model = following_model(sea(WATER), [body(box, Place.SLOW)], 2.0)
    a, c, k, t = np.array([0.02, -0.01, 1e-3]), model.cut[0], np.arange(1, 4), 90.0
    y = first_states(model, np.zeros(6), np.zeros(6), 0.0)
    y[:9] = np.outer(a, t**2 / 2 - k * t / c + k * (k + 1) / (2 * c**2)).ravel()
    begin_block(t, y, model)
    place, rate = y[BLOCK_POSITION : BLOCK_POSITION + 3], y[BLOCK_RATE : BLOCK_RATE + 3]
    np.testing.assert_allclose(place, a * (t**2 / 2 - 3 / c**2), rtol=1e-12)
    np.testing.assert_allclose(rate, a * t, rtol=1e-12)


def drifting(duration: float = 60.0, place: Place = Place.SLOW) -> hs.Scene:
    """The free barge that spins in an oblique sea with drift forces."""
    base = in_waves(scene_of("free_floating"), hs.WaveTrain(SEA, heading=radians(60.0), ramp=10.0))
    loads = hs.WaveForces(second_order=SecondOrder.NEWMAN, headings=place, position=place)
    moved = with_body(base, wave_forces=loads, velocity=(0.8, 0.3, 0.0, 0.0, 0.0, 0.005))
    solver = hs.Solver(step=0.1, symmetry=Symmetry.IGNORE)
    return replace(moved, forces={}, duration=duration, solver=solver).with_output(step=2.0)


def test_a_run_is_of_order_four_and_restarts_to_the_bit() -> None:
    """Loads are a function of time and state: halving the step shows the integrator's order, and a
    run that starts from the middle of another goes on as that one did."""
    scene = drifting().with_output(states=True)
    fine, half, whole = (
        motion(hs.simulate(replace(scene, solver=replace(scene.solver, step=step))))
        for step in (0.05, 0.1, 0.2)
    )
    for some in (slice(0, 3), slice(3, 6)):  # what moves, what turns
        errors = [np.abs(q - fine)[:, some].max() for q in (whole, half)]
        assert np.log2(errors[0] / errors[1]) > 3.8
    before = hs.simulate(scene)
    after = hs.simulate(replace(scene, initial=hs.Start(before, 22.0), duration=38.0))
    np.testing.assert_array_equal(motion(after), motion(before)[11:])


def test_a_convolution_restarts_to_the_bit_where_a_path_begins() -> None:
    """The acceleration that is remembered there is that of the new path, in both runs: to the bit
    from the end of a run, to rounding from the midst of it."""
    scene = with_body(drifting(30.0), radiation=ConvolutionRadiation(length=20.0))
    whole = hs.simulate(scene.with_output(states=True))
    before = hs.simulate(replace(scene, duration=22.0))
    after = hs.simulate(replace(scene, initial=hs.Start(before, 22.0), duration=8.0))
    np.testing.assert_array_equal(motion(after), motion(whole)[11:])
    after = hs.simulate(replace(scene, initial=hs.Start(whole, 22.0), duration=8.0))
    np.testing.assert_allclose(motion(after), motion(whole)[11:], rtol=1e-11, atol=1e-13)


def test_a_spinning_body_turns_with_its_scene() -> None:
    """The whole scene by 123 deg: the slow loads know of no direction of their own."""
    scene, by = drifting(30.0), radians(123.0)
    c, s = np.cos(by), np.sin(by)
    (first,) = scene.bodies
    v = first.velocity
    turned = with_body(
        in_waves(scene, replace(scene.environment.waves[0], heading=radians(60.0) + by)),
        heading=by,
        velocity=(c * v[0] - s * v[1], s * v[0] + c * v[1], *v[2:]),
    )
    q, there = motion(hs.simulate(scene)), motion(hs.simulate(turned))
    x, y = there[:, 0].copy(), there[:, 1].copy()
    there[:, 0], there[:, 1] = c * x + s * y, c * y - s * x
    assert np.all(np.abs(there - q).max(axis=0) < 1e-9 * np.ptp(q, axis=0))


@pytest.mark.parametrize("yaw", [25.0, 90.0, 170.0])
@pytest.mark.parametrize("order", [SecondOrder.MEAN_DRIFT, SecondOrder.NEWMAN])
def test_second_order_loads_at_a_yaw_are_those_of_a_scene_built_at_that_heading(
    order: SecondOrder, yaw: float
) -> None:
    """A free barge that begins there, at whatever yaw from the heading that its case gives."""
    loads = hs.WaveForces(second_order=order)
    base = in_waves(scene_of("free_floating"), hs.WaveTrain(SEA, heading=radians(60.0)))
    base = replace(with_body(base, wave_forces=loads), forces={}, duration=0.2)
    there = with_body(base, position=(15.0, -9.0, 0.0, 0.0, 0.0, radians(yaw)))
    built = with_body(base, location=(15.0, -9.0), heading=radians(yaw))
    found, expected = (
        hs.simulate(scene).force_wave_second_order.values[0, 0] for scene in (there, built)
    )
    for some in (slice(0, 3), slice(3, 6)):
        size = np.abs(expected[some]).max()
        np.testing.assert_allclose(found[some], expected[some], rtol=0.0, atol=1e-9 * size)


def test_by_itself_it_is_chosen_for_bodies_that_may_leave() -> None:
    """A mooring holds surge and sway, not yaw; without a push nothing drifts; small angles and calm
    water know of no slow place."""

    def places(scene: hs.Scene) -> tuple[Place, Place]:
        chosen = chosen_places(scene, scene.bodies[0])
        return chosen.position, chosen.headings

    moored = in_waves(scene_of("free_floating"), hs.WaveTrain(SEA, heading=0.5))
    moored = with_body(moored, wave_forces=hs.WaveForces())
    drift = hs.WaveForces(second_order=SecondOrder.NEWMAN)
    assert places(moored) == (Place.MEAN, Place.MEAN)
    pushed = with_body(moored, wave_forces=drift)
    assert places(pushed) == (Place.MEAN, Place.SLOW)
    assert places(with_body(moored, position=(0, 0, 0, 0, 0, 0.1))) == (Place.MEAN, Place.SLOW)
    free = replace(pushed, forces={})
    assert places(free) == (Place.SLOW, Place.SLOW)
    towed = replace(free, forces={"tug": steady("barge", surge=1e5)})
    assert places(with_body(towed, wave_forces=hs.WaveForces())) == (Place.SLOW, Place.SLOW)
    calm = replace(free, environment=hs.Environment())
    assert not slow_bodies(calm, {"barge": chosen_places(calm, calm.bodies[0])})
    streaming = replace(moored.environment, current=hs.Stream(0.5, 0.1))
    assert places(replace(moored, environment=streaming)) == (Place.MEAN, Place.SLOW)
    assert hull().heading.size >= 12


def test_slow_and_instantaneous_do_not_mix() -> None:
    scene = drifting()
    asked = hs.WaveForces(position=Place.SLOW, headings=Place.INSTANTANEOUS)
    with pytest.raises(hs.InputError, match="expected slow or instantaneous for both"):
        hs.simulate(with_body(scene, wave_forces=asked))


def test_waves_meet_a_body_where_it_is_locked() -> None:
    """Held at a yaw of 0.4 rad and 25 m off, a barge feels what one feels whose rest that is."""
    loads = hs.WaveForces(second_order=SecondOrder.NEWMAN)
    base = in_waves(scene_of("free_floating"), hs.WaveTrain(SEA, heading=radians(60.0)))
    base = replace(with_body(base, wave_forces=loads, dofs=("heave",)), forces={}, duration=20.0)
    locked = hs.simulate(with_body(base, position=(25.0, 0.0, 0.0, 0.0, 0.0, 0.4)))
    there = hs.simulate(with_body(base, location=(25.0, 0.0), heading=0.4))
    for order in ("first", "second"):
        found, expected = (run[f"force_wave_{order}_order"].values for run in (locked, there))
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())
    assert not np.any(found[..., [0, 1, 3, 4, 5]])
    assert (
        "yaw locked, not in the state; forces in these directions exclude waves"
        in locked.attrs["skipped"]
    )
    heave = [motion(run)[:, 2] for run in (locked, there)]
    np.testing.assert_allclose(heave[0], heave[1], rtol=0.0, atol=1e-9)


def test_a_run_that_goes_on_is_met_by_waves_as_before() -> None:
    """Waves follow a box that begins away from rest and drifts; so they do when the run goes on
    from its state, whatever the start of the bodies is in the new case."""
    start = (3.0, 1.0, 0.0, 0.0, 0.0, 0.5)
    case = in_waves(scene_of("free_floating"), hs.WaveTrain(hs.Jonswap(1.5, 9.0), heading=0.7))
    case = replace(case, forces={}, duration=24.0).with_output(states=True)
    whole = with_body(case, position=start)
    run = hs.simulate(whole)
    assert run.attrs["waves_meet_barge"] == "slow slow"
    for began in (start, (0.0,) * 6):
        again = replace(
            with_body(whole, position=began), duration=12.0, initial=hs.Start(run, 12.0)
        )
        assert np.array_equal(hs.simulate(again).position[-1], run.position[-1])
