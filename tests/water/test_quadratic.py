from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from known_qtf import FREQUENCY, difference, with_qtf

from hydrosim.database.readers.assembly import Pairs, quadratic
from hydrosim.errors import InputError
from hydrosim.water.components import WaveComponents
from hydrosim.water.second_order import difference_factors, has_separate_headings, sum_factors

W = np.array([0.41, 0.55, 0.83, 1.17])


def waves_to(heading: list[float], omega: np.ndarray = W) -> WaveComponents:
    nothing = np.zeros(omega.size)
    return WaveComponents(
        omega, nothing + 1.0, nothing, omega**2 / 9.81, np.array(heading), 0.0, 0.0
    )


def found(database: object, waves: WaveComponents) -> np.ndarray:
    return np.moveaxis(difference_factors(database, waves).pairs(), 0, -1)


def test_between_frequencies() -> None:
    """The error of cubic splines falls with the fourth power of the spacing at least."""
    waves = waves_to([0.0] * 4)
    exact = difference(W[:, None], W[None, :])

    def error(count: int) -> float:
        database = with_qtf([(0.0, 0.0)], np.linspace(0.3, 1.2, count))
        return float(np.abs(found(database, waves) - exact)[..., 0].max())

    assert error(19) / error(37) > 2**3.8


def test_nodes_are_exact_and_hermitian() -> None:
    waves = waves_to([0.0] * FREQUENCY.size, FREQUENCY)
    T = found(with_qtf([(0.0, 0.0)]), waves)
    np.testing.assert_allclose(
        T, difference(FREQUENCY[:, None], FREQUENCY[None, :]), atol=1e-9 * np.abs(T).max()
    )
    np.testing.assert_allclose(T, T.swapaxes(0, 1).conj(), atol=1e-12 * np.abs(T).max())


def test_pairs_of_headings_either_way_round() -> None:
    """Each pair may be there in one order only."""
    waves = waves_to([0.0, 0.5, 0.0, 0.5])
    b = waves.heading
    exact = np.array([[difference(W[i], W[j], b[i], b[j]) for j in range(4)] for i in range(4)])
    for pairs in ([(0.0, 0.0), (0.0, 0.5), (0.5, 0.5)], [(0.0, 0.0), (0.5, 0.0), (0.5, 0.5)]):
        database = with_qtf(pairs)
        assert not has_separate_headings(database, waves)
        np.testing.assert_allclose(found(database, waves), exact, atol=2e-4 * np.abs(exact).max())


def test_without_pairs_headings_do_not_interact() -> None:
    waves = waves_to([0.0, 0.5, 0.0, 0.5])
    database = with_qtf([(0.0, 0.0), (0.5, 0.5)])
    assert has_separate_headings(database, waves)
    T = found(database, waves)
    apart = waves.heading[:, None] != waves.heading
    assert np.all(T[apart] == 0.0)
    exact = difference(W[:, None], W[None, :])
    np.testing.assert_allclose(T[0, 2], exact[0, 2], atol=2e-4 * np.abs(exact).max())


def test_a_heading_between_those_of_the_database() -> None:
    """Trigonometric in the heading: exact for the one harmonic that these QTFs have."""
    nodes = [(b, b) for b in np.radians(np.arange(0.0, 360.0, 30.0))]
    T = found(with_qtf(nodes), waves_to([0.2] * 4))
    exact = difference(W[:, None], W[None, :], 0.2, 0.2)
    np.testing.assert_allclose(T, exact, atol=2e-4 * np.abs(exact).max())


def test_beyond_the_frequencies_newmans_approximation_goes_on() -> None:
    omega = np.array([1.0, 1.6, 1.9])
    T = found(with_qtf([(0.0, 0.0)]), waves_to([0.0] * 3, omega))
    D = difference(omega, omega).real
    np.testing.assert_allclose(np.diagonal(T.real).T, D, rtol=1e-6)
    end = difference(FREQUENCY[-1:], FREQUENCY[-1:]).real[0]
    expected = end + 0.5 * (D[1] - end + D[2] - end)
    np.testing.assert_allclose(T[1, 2], expected, rtol=1e-6)


@pytest.mark.parametrize("stored", ["upper", "lower"])
def test_triangles_of_a_file(tmp_path: Path, stored: str) -> None:
    """Rows with w_1 >= w_2, and their conjugates with w_1 <= w_2, are the same loads."""
    i, j = np.tril_indices(FREQUENCY.size)
    one, other = (i, j) if stored == "upper" else (j, i)
    omega = np.stack([FREQUENCY[one], FREQUENCY[other]], axis=1)
    value = difference(omega[:, 0], omega[:, 1])[:, 0]
    rows = Pairs(omega, np.zeros_like(omega), np.zeros(len(value), dtype=int), value)
    fields = quadratic(tmp_path, 6, rows, None)
    database = replace(with_qtf([(0.0, 0.0)]), **fields)
    exact = difference(W[:, None], W[None, :])[..., 0]
    T = found(database, waves_to([0.0] * 4))[..., 0]
    np.testing.assert_allclose(T, exact, atol=2e-4 * np.abs(exact).max())


def test_refusals() -> None:
    database = with_qtf([(0.0, 0.0), (0.5, 0.5)])
    with pytest.raises(InputError, match=r"box\.nc: has no qtf_sum.*sum_frequency"):
        sum_factors(replace(database, qtf_sum=None), waves_to([0.0] * 4))
    with pytest.raises(InputError, match=r"QTFs for waves to 0, 28.65 deg.*around 57.3 deg"):
        difference_factors(database, waves_to([1.0] * 4))
    headings = list(np.linspace(0.0, 0.5, 9))
    with pytest.raises(InputError, match="9 headings; expected at most 8"):
        difference_factors(database, waves_to(headings, np.linspace(0.4, 1.0, 9)))
