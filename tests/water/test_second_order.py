from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from known_qtf import FREQUENCY, difference, total, with_qtf

from hydrosim.errors import InputError
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Environment, Jonswap, SecondOrder, WaveForces, WaveTrain
from hydrosim.water.body import WaveBody
from hydrosim.water.build import second_order
from hydrosim.water.components import WaveComponents, components
from hydrosim.water.loads import SpectralLines
from hydrosim.water.second_order import (
    MOST_WAVES,
    Factors,
    difference_factors,
    difference_loads,
    newman,
    newman_square_root,
    sum_factors,
    sum_loads,
)

SEA = WaveTrain(Jonswap(3.0, 9.0), repeat_period=200.0)
TIMES = np.array([0.0, 13.7, 96.2, 181.0])
ARRAYS = ("omega", "amplitude", "phase", "wavenumber", "heading")


def given(omega: list[float], amplitude: list[float], phase: list[float]) -> WaveComponents:
    """Waves to 0 rad off any grid."""
    w = np.array(omega)
    nothing = np.zeros(w.size)
    return WaveComponents(w, np.array(amplitude), np.array(phase), w**2 / 9.81, nothing, 0.0, 0.0)


def in_time(lines: SpectralLines, times: np.ndarray) -> np.ndarray:
    return (np.exp(1j * np.outer(times, lines.omega)) @ lines.amplitude).real


def diagonal(omega: np.ndarray) -> np.ndarray:
    """Drift (nw, 6) for waves to 0 rad, constant above the database's 2.2 rad/s."""
    inside = np.minimum(omega, 2.2)
    return difference(inside, inside).real


def double_sum(
    waves: WaveComponents, transfer: np.ndarray, times: np.ndarray, sign: float
) -> np.ndarray:
    """Re sum_ij a_i a_j* T_ij e^(i (w_i - w_j) t), or with sums: (nt, n) from T (nw, nw, n)."""
    loads = []
    for t in times:
        a = waves.amplitudes_at(0.0, 0.0) * np.exp(1j * waves.omega * t)
        other = a if sign > 0 else a.conj()
        loads.append(np.einsum("i,j,ijn->n", a, other, transfer).real)
    return np.array(loads)


def two_waves(
    waves: WaveComponents, load: complex, one: float, other: float, times: np.ndarray
) -> np.ndarray:
    """Closed form of two waves' slow load, T_12 = ``load`` and T_11, T_22 = ``one``, ``other``."""
    a, b = waves.amplitude
    angle = (waves.omega[0] - waves.omega[1]) * times + waves.phase[0] - waves.phase[1]
    return a**2 * one + b**2 * other + 2 * a * b * np.abs(load) * np.cos(angle + np.angle(load))


@pytest.mark.parametrize("order", [[0, 1], [1, 0]])
def test_bichromatic_waves_in_closed_form(order: list[int], validated: Callable[..., None]) -> None:
    """The phase of T_12 belongs to the wave named first, whichever is the longer one."""
    w = FREQUENCY[[10, 4]][order]
    waves = given(list(w), [1.2, 0.7], [0.4, 2.0])
    factors = difference_factors(with_qtf([(0.0, 0.0)]), waves)
    found = in_time(difference_loads(waves, waves.amplitudes_at(0.0, 0.0), factors), TIMES)
    T = difference(w[:, None], w[None, :])
    for dof in (0, 2, 4):
        one, other = T[0, 0, dof].real, T[1, 1, dof].real
        expected = two_waves(waves, T[0, 1, dof], one, other, TIMES)
        np.testing.assert_allclose(found[:, dof], expected, rtol=1e-10)
        error = np.abs(found[:, dof] - expected).max() / np.abs(expected).max()
        claim = "slow load of two waves from a QTF"
        validated(Kind.CLOSED_FORM, claim, "sum of three cosines", error, 1e-10, Feature.QTF)


def test_double_sum_over_a_sea_to_two_headings(validated: Callable[..., None]) -> None:
    """By Fourier transforms and pair by pair."""
    trains = (SEA, replace(SEA, heading=np.pi))
    each = [components(train, Environment(), stream) for stream, train in enumerate(trains)]
    arrays = (np.concatenate([getattr(sea, name) for sea in each]) for name in ARRAYS)
    waves = WaveComponents(*arrays, ramp=0.0, spacing=each[0].spacing)
    pairs = [(0.0, 0.0), (0.0, np.pi), (np.pi, np.pi)]
    elevation = waves.amplitudes_at(0.0, 0.0)
    for factors, sign, loads in (
        (difference_factors(with_qtf(pairs), waves), -1.0, difference_loads),
        (sum_factors(with_qtf(pairs), waves), 1.0, sum_loads),
    ):
        transfer = np.moveaxis(factors.pairs(), 0, -1)
        expected = double_sum(waves, transfer, TIMES, sign)
        found = in_time(loads(waves, elevation, factors), TIMES)
        error = np.abs(found - expected).max() / np.abs(expected).max()
        feature = Feature.QTF if sign < 0.0 else Feature.SUM
        claim = f"{feature}, a sea to two headings"
        validated(Kind.INDEPENDENT, claim, "double sum, pair by pair", error, 1e-10, feature)


def test_same_waves_on_and_off_a_grid() -> None:
    on = replace(components(SEA, Environment()), ramp=0.0)
    keep = slice(20, 50)
    on = replace(on, **{name: getattr(on, name)[keep] for name in ARRAYS})
    off = replace(on, spacing=0.0)
    database = with_qtf([(0.0, 0.0)])
    elevation = on.amplitudes_at(0.0, 0.0)
    for factors, loads in (
        (difference_factors(database, on), difference_loads),
        (sum_factors(database, on), sum_loads),
    ):
        one, other = (in_time(loads(waves, elevation, factors), TIMES) for waves in (on, off))
        np.testing.assert_allclose(one, other, atol=1e-10 * np.abs(other).max())


def test_sum_frequencies_in_closed_form() -> None:
    w = FREQUENCY[[10, 4]]
    waves = given(list(w), [1.2, 0.7], [0.4, 2.0])
    factors = sum_factors(with_qtf([(0.0, 0.0)]), waves)
    found = in_time(sum_loads(waves, waves.amplitudes_at(0.0, 0.0), factors), TIMES)[:, 2]
    expected = np.zeros(TIMES.size)
    for i, j, times in ((0, 0, 1), (1, 1, 1), (0, 1, 2)):
        T = total(w[i : i + 1], w[j : j + 1])[0, 2]
        angle = (w[i] + w[j]) * TIMES + waves.phase[i] + waves.phase[j] + np.angle(T)
        expected += times * waves.amplitude[i] * waves.amplitude[j] * np.abs(T) * np.cos(angle)
    np.testing.assert_allclose(found, expected, rtol=1e-10)


def test_mean_is_that_of_the_drift() -> None:
    """The mean of the slow load is sum D a^2, beyond the QTF's frequencies, too."""
    waves = components(SEA, Environment())
    assert waves.omega.max() > FREQUENCY[-1]
    database = with_qtf([(0.0, 0.0)])
    factors = difference_factors(database, waves)
    lines = difference_loads(waves, waves.amplitudes_at(0.0, 0.0), factors)
    expected = waves.amplitude**2 @ diagonal(waves.omega)
    # the error of the QTF's splines, 0.05 rad/s apart
    np.testing.assert_allclose(lines.amplitude[0].real, expected, rtol=1e-6, atol=1e-9)


def test_qtf_that_is_newmans() -> None:
    """Splines reproduce sums, so that both approximations are the same to rounding."""
    database = with_qtf([(0.0, 0.0)])
    D = difference(FREQUENCY, FREQUENCY).real
    core = 0.5 * (D[:, None] + D[None, :]) + 0j
    database = replace(database, qtf_difference=core[None])
    waves = components(SEA, Environment())
    elevation = waves.amplitudes_at(0.0, 0.0)
    by_qtf = difference_loads(waves, elevation, difference_factors(database, waves))
    by_drift = difference_loads(waves, elevation, newman(diagonal(waves.omega)))
    scale = np.abs(by_drift.amplitude).max(axis=0) + 1e-300
    assert np.all(np.abs(by_qtf.amplitude - by_drift.amplitude) < 1e-9 * scale)


def test_square_root_form_is_its_double_sum() -> None:
    waves = components(SEA, Environment())
    drift = np.stack([waves.omega - 0.7, np.cos(3 * waves.omega)], axis=1)
    i, j = drift[:, None], drift[None, :]
    same = np.sign(i) == np.sign(j)
    transfer = np.where(same, np.sign(i) * np.sqrt(np.abs(i * j)), 0.0)
    expected = double_sum(waves, transfer, TIMES, -1.0)
    lines = difference_loads(waves, waves.amplitudes_at(0.0, 0.0), newman_square_root(drift))
    np.testing.assert_allclose(in_time(lines, TIMES), expected, atol=1e-10 * np.abs(expected).max())


def test_both_forms_of_newman_agree_where_the_drift_is_constant() -> None:
    waves = components(SEA, Environment())
    drift = np.full((waves.omega.size, 1), -4.0)
    plain, root = (
        difference_loads(waves, waves.amplitudes_at(0.0, 0.0), form(drift)).amplitude
        for form in (newman, newman_square_root)
    )
    np.testing.assert_allclose(root, plain, atol=1e-12 * np.abs(plain).max())


def test_mean_is_counted_once() -> None:
    """Each approximation has the same mean load, none adds another's."""
    waves = components(SEA, Environment())
    database = with_qtf([(0.0, 0.0)])
    means = []
    for chosen in list(SecondOrder)[1:]:
        body = WaveBody(database, (0.0, 0.0), WaveForces(True, chosen), 0, np.ones(6, dtype=bool))
        means.append(
            sum(x.amplitude[x.omega == 0.0].sum(axis=0) for x in second_order(waves, [body]))
        )
    for mean in means[1:]:
        # the error of the QTF's splines, 0.05 rad/s apart
        np.testing.assert_allclose(mean, means[0], rtol=1e-6, atol=1e-9)


def test_too_many_pairs_are_refused() -> None:
    count = MOST_WAVES + 1
    waves = given(list(np.linspace(0.4, 1.0, count)), [0.1] * count, [0.0] * count)
    factors = Factors(np.ones((1, count)), np.ones((1, 1, 1)))
    with pytest.raises(InputError, match=rf"{count} given waves.*at most {MOST_WAVES}"):
        difference_loads(waves, waves.amplitudes_at(0.0, 0.0), factors)
