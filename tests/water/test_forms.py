"""Second-order loads of waves on a body that has turned and moved: against those of a body whose
rest that place is, and against double sums over all pairs of waves."""

from dataclasses import replace
from functools import lru_cache
from math import radians

import numpy as np
import pytest
from known_box import Box, box_at

import hydrosim as hs
from hydrosim.dofs import about_z, loads_about_z
from hydrosim.scene import GivenComponents, Place, SecondOrder
from hydrosim.water.body import WaveBody
from hydrosim.water.build import wave_loads_model
from hydrosim.water.components import WaveComponents, sea
from hydrosim.water.displaced_loads import following_loads, following_model, new_sums
from hydrosim.water.loads import wave_loads
from hydrosim.water.slow_path_loads import first_states, new_block, slow_loads

SWELL = hs.WaveTrain(hs.Jonswap(2.0, 14.0), heading=radians(30.0), ramp=30.0, repeat_period=600.0)
ACROSS = replace(SWELL, heading=radians(-110.0), seed=4)
SPREAD = replace(SWELL, spreading=6.0)
TONE = hs.WaveTrain(hs.RegularWave(0.8, 9.0, phase=0.4), heading=radians(-70.0))
PAIR = GivenComponents(
    np.array([0.51, 0.677]), np.array([0.7, 0.4]), np.array([0.2, 1.9]), np.array([0.3, 0.3])
)
SEAS = {
    "long crests": (SWELL,),
    "two trains and a wave": (SWELL, ACROSS, TONE),
    "short crests": (SPREAD,),
    "given waves": (hs.WaveTrain(PAIR),),
}
TIMES = np.array([10.0, 62.0, 318.0])  # stages of the tables, and begins of blocks
KINDS = [kind for kind in SecondOrder if kind != SecondOrder.NONE]


def transfer(w1: np.ndarray, w2: np.ndarray, b1: np.ndarray, b2: np.ndarray) -> np.ndarray:
    """T- (..., 6) of four harmonics of the headings, T-_21 = conj T-_12."""
    phase = np.exp(1j * ((w1 - w2) * (3.0 + np.cos(b1 + b2)) + 0.4 * np.sin(b1 - b2)))
    size = 1e5 * (0.3 + w1 * w2) * phase
    load = np.zeros((*np.shape(size), 6), dtype=complex)
    load[..., 0] = size * (np.cos(b1) + np.cos(b2))
    load[..., 1] = size * (np.sin(b1) + np.sin(b2)) * (1.0 + 0.3 * np.cos(b1 - b2))
    load[..., 3] = size * np.sin(b1 + b2)
    load[..., 5] = 30.0 * size * (np.sin(2.0 * b1) + np.sin(2.0 * b2))
    return load


def total(w1: np.ndarray, w2: np.ndarray, b1: np.ndarray, b2: np.ndarray) -> np.ndarray:
    """T+ (..., 6), T+_21 = T+_12."""
    size = 3e4 * (w1 + w2) * np.exp(1j * (w1 * w2 + np.cos(b1 - b2)))
    load = np.zeros((*np.shape(size), 6), dtype=complex)
    load[..., 1] = size * (np.sin(b1) + np.sin(b2))
    load[..., 2] = size
    return load


@lru_cache
def hull(every: float, pairs: bool) -> Box:
    """The box with QTFs of headings ``every`` so many degrees: of all pairs, or with themselves."""
    box = box_at(np.arange(3, 75) * 0.03, np.arange(0.0, 360.0, 7.5))
    heading = np.radians(np.arange(0.0, 360.0, every))
    one, other = (x.ravel() for x in np.meshgrid(heading, heading, indexing="ij"))
    chosen = one <= other if pairs else one == other
    w = np.linspace(0.3, 0.9, 9)
    grid = (w[None, :, None], w[None, None, :], one[chosen, None, None], other[chosen, None, None])
    nodes = np.stack([one[chosen], other[chosen]], axis=1)
    return replace(
        box,
        qtf_frequency=w,
        qtf_heading=nodes,
        qtf_difference=transfer(*np.broadcast_arrays(*grid)),
        qtf_sum=total(*np.broadcast_arrays(*grid)),
    )


def body(box: Box, kind: SecondOrder, both: bool = False, place: Place = Place.SLOW) -> WaveBody:
    wanted = hs.WaveForces(True, kind, both, headings=place, position=place)
    every = np.ones(6, dtype=bool)
    return WaveBody(box, (30.0, -12.0), wanted, 0, every, (4.0, 1.0), heading=0.3)


def at_rest(at: WaveBody, seas: tuple[WaveComponents, ...]) -> np.ndarray:
    """Second-order loads (nt, 6) on a body that stays where it is, from the tables."""
    mean = replace(at.wave_forces, headings=Place.MEAN, position=Place.MEAN)
    model = wave_loads_model(seas, [replace(at, wave_forces=mean)], 0.0, 0.1, 400.0)
    found = np.zeros((TIMES.size, 6))
    for t, load in zip(TIMES, found, strict=True):
        wave_loads(t, model, np.zeros(6), load)
    return found


def slow(at: WaveBody, seas: tuple[WaveComponents, ...], q: np.ndarray) -> np.ndarray:
    """The same on a body whose slow place is q (6,)."""
    model = following_model(seas, [at], 2.0)
    block = new_block(model)
    found = np.zeros((TIMES.size, 6))
    for t, load in zip(TIMES, found, strict=True):
        y = first_states(model, q, np.zeros(6), t)
        slow_loads(t, y, model, block, np.zeros(6), load)
    return found


def instantaneous(at: WaveBody, seas: tuple[WaveComponents, ...], q: np.ndarray) -> np.ndarray:
    """The same on a body that is at q (6,)."""
    asked = replace(at.wave_forces, headings=Place.INSTANTANEOUS, position=Place.INSTANTANEOUS)
    model = following_model(seas, [replace(at, wave_forces=asked)])
    sums = new_sums(model)
    found = np.zeros((TIMES.size, 6))
    for t, load in zip(TIMES, found, strict=True):
        following_loads(t, q, model, sums, np.zeros(6), load)
    return found


def assert_alike(found: np.ndarray, expected: np.ndarray, within: float) -> None:
    """Forces and moments are within so much of the largest of each, a moment being no less than
    the forces on an arm of a metre."""
    for some in (slice(0, 3), slice(0, 6)):
        size = np.abs(expected[:, some]).max()
        np.testing.assert_allclose(found[:, some], expected[:, some], atol=within * size, rtol=0.0)


@pytest.mark.parametrize("name", SEAS)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("yaw", [25.0, 90.0, 170.0, -33.7])
def test_a_body_that_has_turned_is_one_built_so(name: str, kind: SecondOrder, yaw: float) -> None:
    """At any yaw and place, in every sea, on its slow path and where it is. Where drift passes
    through zero, geometric means do as the root of what is interpolated."""
    seas = sea(hs.Environment(waves=SEAS[name]))
    q = np.array([20.0, -35.0, 0.0, 0.0, 0.0, radians(yaw)])
    at = body(hull(30.0, True), kind)
    expected = at_rest(at.moved_by(q), seas)
    within = 1e-7 if kind == SecondOrder.NEWMAN_SQUARE_ROOT else 1e-9
    assert_alike(slow(at, seas, q), expected, within)
    assert_alike(instantaneous(at, seas, q), expected, within)


@pytest.mark.parametrize("name", SEAS)
@pytest.mark.parametrize("pairs", [True, False])
@pytest.mark.parametrize("every", [30.0, 40.0])
def test_difference_and_sum_frequencies_together(name: str, pairs: bool, every: float) -> None:
    """QTFs of all pairs of headings and of each with itself, an even and an odd number of them."""
    if name == "short crests" and not pairs:
        pytest.skip("refused: no pairs of its headings")
    seas = sea(hs.Environment(waves=SEAS[name]))
    q = np.array([20.0, -35.0, 0.0, 0.0, 0.0, 1.1])
    at = body(hull(every, pairs), SecondOrder.QTF, both=True)
    assert_alike(slow(at, seas, q), at_rest(at.moved_by(q), seas), 1e-9)


@pytest.mark.parametrize("kind", [SecondOrder.NEWMAN, SecondOrder.QTF])
def test_against_a_double_sum_over_all_pairs_of_waves(kind: SecondOrder) -> None:
    """T written out in closed form, wave by wave, where the body is. The error is that of splines
    and harmonics through the nodes of the database."""
    (waves,) = sea(hs.Environment(waves=(replace(SWELL, ramp=0.0), replace(ACROSS, ramp=0.0))))
    kept = (waves.omega > 0.35) & (waves.omega < 0.85) & (waves.amplitude > 0.0)
    of = {name: getattr(waves, name)[kept] for name in ("omega", "amplitude", "phase", "heading")}
    waves = replace(waves, **of, wavenumber=waves.wavenumber[kept])
    q = np.array([20.0, -35.0, 0.0, 0.0, 0.0, radians(25.0)])
    at = body(fine(), kind, both=kind == SecondOrder.QTF)
    found = slow(at, (waves,), q)

    heading = at.heading + q[5]
    centre = np.array([30.0, -12.0, 0.0]) + about_z(at.heading) @ [4.0, 1.0, 0.0] + [*q[:2], 0.0]
    frame = centre - about_z(heading) @ [4.0, 1.0, 0.0]
    b = waves.heading
    along = waves.wavenumber * (frame[0] * np.cos(b) + frame[1] * np.sin(b))
    pairs = (waves.omega[:, None], waves.omega, b[:, None] - heading, b - heading)
    D = transfer(waves.omega, waves.omega, b - heading, b - heading).real
    T = transfer(*pairs) if kind == SecondOrder.QTF else 0.5 * (D[:, None] + D)
    for t, load in zip(TIMES, found, strict=True):
        a = waves.amplitude * np.exp(1j * (waves.omega * t + waves.phase - along))
        expected = np.einsum("i,j,ijn->n", a, a.conj(), T).real
        if kind == SecondOrder.QTF:
            expected += np.einsum("i,j,ijn->n", a, a, total(*pairs)).real
        expected = loads_about_z(expected, heading)
        assert_alike(load[None], expected[None], 1e-5)


@lru_cache
def fine() -> Box:
    """The box with fine QTFs, whose diagonal is its drift."""
    w = np.linspace(0.3, 0.9, 31)
    heading = np.radians(np.arange(0.0, 360.0, 15.0))
    box = box_at(w, np.degrees(heading))
    one, other = (x.ravel() for x in np.meshgrid(heading, heading, indexing="ij"))
    grid = np.broadcast_arrays(
        w[None, :, None], w[None, None, :], one[:, None, None], other[:, None, None]
    )
    drift = transfer(*np.broadcast_arrays(w[:, None], w[:, None], heading, heading)).real
    return replace(
        box,
        mean_drift=drift,
        qtf_frequency=w,
        qtf_heading=np.stack([one, other], axis=1),
        qtf_difference=transfer(*grid),
        qtf_sum=total(*grid),
    )


@pytest.mark.parametrize("kind", KINDS)
def test_the_whole_turned(kind: SecondOrder) -> None:
    """Body, its place and waves turned by any angle about the origin: the loads turn with them."""
    by = radians(77.7)
    q = np.array([20.0, -35.0, 0.0, 0.0, 0.0, 0.6])
    at = body(hull(30.0, True), kind, both=True)
    seas = sea(hs.Environment(waves=SEAS["two trains and a wave"]))
    expected = loads_about_z(slow(at, seas, q), by)
    R = about_z(by)
    turned = tuple(replace(waves, heading=waves.heading + by) for waves in seas)
    there = replace(at, heading=at.heading + by, location=tuple((R @ [30.0, -12.0, 0.0])[:2]))
    assert_alike(slow(there, turned, np.array([*(R @ q[:3]), 0.0, 0.0, 0.6])), expected, 1e-9)


def test_locked_degrees_of_freedom_have_no_load() -> None:
    active = np.array([True, False, True, True, True, False])
    at = replace(body(hull(30.0, True), SecondOrder.NEWMAN), active=active)
    found = slow(at, sea(hs.Environment(waves=(SWELL,))), np.zeros(6))
    assert np.all(found[:, ~active] == 0.0)
    assert np.all(found[:, 0] != 0.0)


def test_qtfs_of_few_headings_stay_those_at_rest() -> None:
    """There is nothing to take for another heading; first-order loads follow all the same."""
    few = hull(30.0, False)
    few = replace(
        few,
        qtf_heading=few.qtf_heading[:2],
        qtf_difference=few.qtf_difference[:2],
        qtf_sum=few.qtf_sum[:2],
    )
    at = replace(body(few, SecondOrder.QTF), heading=radians(25.0))
    seas = sea(hs.Environment(waves=(SWELL,)))
    model = wave_loads_model(seas, [at], 0.0, 0.1, 400.0)
    assert model.second_dof.size > 0
    assert model.first_dof.size == 0
    assert not np.any(slow(at, seas, np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.4])))
