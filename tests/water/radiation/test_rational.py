"""Vector fitting and balanced truncation against systems that are known."""

import numpy as np
import pytest
from scipy.linalg import solve_continuous_lyapunov
from scipy.special import roots_legendre

from hydrosim.water.radiation.rational import (
    Emphasis,
    balance,
    find_modes,
    partial_fractions,
    pole_blocks,
    vector_fit,
)

POLES = np.array([-0.8, -2.0, -0.1 + 0.5j, -0.3 + 1.1j])
W = np.linspace(0.0, 4.0, 120)


def exact_system() -> tuple[np.ndarray, np.ndarray]:
    """Transfer function of a 2 x 2 system with these poles, and its residues (6, 2, 2)."""
    residues = np.random.default_rng(3).standard_normal((6, 2, 2))
    residues += residues.transpose(0, 2, 1)
    return np.tensordot(partial_fractions(1j * W, POLES), residues, 1), residues


def test_real_blocks_are_the_partial_fractions():
    A, b = pole_blocks(POLES)
    expected = [np.linalg.solve(1j * w * np.eye(6) - A, b) for w in W]
    assert partial_fractions(1j * W, POLES) == pytest.approx(np.array(expected), abs=1e-12)


def test_vector_fitting_recovers_a_rational_function_exactly():
    values, _ = exact_system()
    poles, found = vector_fit(1j * W, values.reshape(-1, 4), 6)
    assert np.sort_complex(poles) == pytest.approx(np.sort_complex(POLES), abs=1e-9)
    fitted = partial_fractions(1j * W, poles) @ found
    assert fitted == pytest.approx(values.reshape(-1, 4), abs=1e-9)


def test_weights_move_the_error_to_where_they_are_small():
    s = 1j * np.linspace(0.0, 6.0, 200)
    values = ((1.0 - np.exp(-3.0 * (s + 0.4))) / (s + 0.4))[:, None]
    weight = np.where(s.imag < 1.0, 30.0, 1.0)
    slow, fast = s.imag < 1.0, s.imag >= 1.0
    errors = []
    for poles, residues in (vector_fit(s, values, 8), vector_fit(s, values, 8, weight)):
        errors.append(np.abs(partial_fractions(s, poles) @ residues - values)[:, 0])
    assert errors[1][slow].max() < 0.3 * errors[0][slow].max()
    assert errors[1][fast].max() > errors[0][fast].max()


def test_all_states_have_the_transfer_function_with_and_without_emphasis():
    values, residues = exact_system()
    for emphasis in (Emphasis(1.0, 1.0), Emphasis(1.0)):
        system = find_modes(*balance(POLES, residues, emphasis))
        assert system.transfer_function(1j * W) == pytest.approx(values, abs=1e-9)
        assert np.linalg.norm(system.b, axis=1) == pytest.approx(np.linalg.norm(system.c, axis=0))


def gramian(A: np.ndarray, B: np.ndarray, emphasis: Emphasis) -> np.ndarray:
    """1 / pi int_0^inf |W|^2 Re (i w - A)^-1 B B^T (i w - A)^-H dw, by Gauss and Legendre in
    w = tan(angle)."""
    x, weight = roots_legendre(4000)
    angle = 0.25 * np.pi * (x + 1.0)
    w, dw = np.tan(angle), 0.25 * np.pi * weight / np.cos(angle) ** 2
    R = np.linalg.solve(1j * w[:, None, None] * np.eye(len(A)) - A, B.astype(complex))
    size = emphasis.at(w) ** 2 * dw / np.pi
    return np.einsum("k,kim,kjm->ij", size, R, R.conj()).real


@pytest.mark.parametrize("ratio", [1.0, 10.0])
def test_balanced_states_are_as_controllable_as_observable(ratio):
    _, residues = exact_system()
    emphasis = Emphasis(0.7, ratio)
    A, B, C = balance(POLES, residues, emphasis)
    controllable, observable = gramian(A, B, emphasis), gramian(A.T, C.T, emphasis)
    hankel = np.diag(controllable)
    assert np.all(np.diff(hankel) <= 1e-12)
    assert controllable == pytest.approx(np.diag(hankel), abs=1e-6 * hankel[0])
    assert observable == pytest.approx(np.diag(hankel), abs=1e-6 * hankel[0])
    assert emphasis.gramian(A, B) == pytest.approx(controllable, abs=1e-6 * hankel[0])


def test_truncation_is_stable_and_within_the_bound_of_the_dropped_hankel_values():
    values, residues = exact_system()
    A, B, C = balance(POLES, residues, Emphasis(1.0, 1.0))
    hankel = np.diag(solve_continuous_lyapunov(A, -B @ B.T))
    for k in range(1, len(A)):
        reduced = find_modes(A[:k, :k], B[:k], C[:, :k])
        error = np.linalg.norm(reduced.transfer_function(1j * W) - values, 2, axis=(1, 2))
        assert error.max() <= 2.0 * hankel[k:].sum() * (1.0 + 1e-6)  # Enns 1984, Glover 1984
        assert np.all(reduced.poles.real < 0.0)


def test_truncation_of_a_reciprocal_system_is_reciprocal():
    _, residues = exact_system()
    A, B, C = balance(POLES, residues, Emphasis(1.0))
    for k in range(1, len(A)):
        K = find_modes(A[:k, :k], B[:k], C[:, :k]).transfer_function(1j * W)
        assert np.swapaxes(K, 1, 2) == pytest.approx(K, abs=1e-12 * np.abs(K).max())


def test_fit_of_a_function_that_is_not_rational_is_stable_and_improves_with_the_order():
    s = 1j * np.linspace(0.0, 6.0, 200)
    values = (1.0 - np.exp(-3.0 * (s + 0.4)))[:, None] / (
        s[:, None] + 0.4
    )  # K = exp(-0.4 t), t < 3
    errors = []
    for order in (4, 8, 12):
        poles, residues = vector_fit(s, values, order)
        assert np.all(poles.real < 0.0)
        errors.append(np.abs(partial_fractions(s, poles) @ residues - values).max())
    assert errors[2] < 0.2 * errors[1] < 0.04 * errors[0]
