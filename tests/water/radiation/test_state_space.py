"""State-space models of retardation functions: accuracy, stability, passivity, grouping."""

import h5py
import numpy as np
import pytest
import xarray as xr
from closed_forms import DECAY, FREQUENCY, kernel, transfer
from scipy.linalg import expm
from validation_data import unpacked

from hydrosim.water.radiation import FitReport, KernelReport, Retardation, StateSpace, retardation
from hydrosim.water.radiation.passivity import make_passive
from hydrosim.water.radiation.rational import Emphasis, find_modes
from hydrosim.water.radiation.retardation import relative_size, transfer_function
from hydrosim.water.radiation.state_space import (
    coupled_groups,
    find_target,
    fit_group,
    make_reciprocal,
)

NO_REPORT = KernelReport(0.0, 0.0, 0.0, 0.0, np.zeros((0, 0)))


def memory_of(K: np.ndarray, time: np.ndarray) -> Retardation:
    return Retardation(time, K, np.zeros(K.shape[1:]), NO_REPORT)


def coupled_kernel(time: np.ndarray) -> np.ndarray:
    """K (nt, 2, 2) with four known poles, of very different units."""
    a = np.array([1.0, 300.0])
    b = np.array([0.4, -200.0])
    first = np.exp(-0.3 * time) * np.cos(0.9 * time)
    second = np.exp(-0.5 * time) * np.cos(0.4 * time)
    return np.outer(a, a) * first[:, None, None] + np.outer(b, b) * second[:, None, None]


def example() -> StateSpace:
    rng = np.random.default_rng(1)
    return StateSpace(
        dofs=np.array([0, 4]),
        decay=np.array([-0.5, -0.2, -0.3]),
        frequency=np.array([0.0, 0.7, 1.3]),
        B=rng.standard_normal((5, 2)),
        C=rng.standard_normal((2, 5)),
        report=FitReport(1e-3, 0.0, 0.0, 0.0, 0.0),
    )


def test_modes_are_the_real_form():
    model = example()
    w, time = np.array([0.0, 0.4, 2.0]), np.array([0.0, 0.5, 7.0])
    by_matrix = [model.C @ np.linalg.solve(1j * x * np.eye(5) - model.matrix, model.B) for x in w]
    assert model.modes.transfer_function(1j * w) == pytest.approx(np.array(by_matrix), abs=1e-12)
    by_matrix = [model.C @ expm(model.matrix * t) @ model.B for t in time]
    assert model.modes.impulse_response(time) == pytest.approx(np.array(by_matrix), abs=1e-12)


def test_a_sum_of_exponentials_is_recovered():
    time = np.linspace(0.0, 60.0, 6001)
    model = fit_group(memory_of(coupled_kernel(time), time), np.array([0, 1]), 2.5, 1e-4)
    # the table is linear between its times: 1e-5 of K; the order is exact
    assert model.B.shape == (4, 2)
    order = np.argsort(model.frequency)
    assert model.frequency[order] == pytest.approx([0.4, 0.9], abs=1e-3)
    assert model.decay[order] == pytest.approx([-0.5, -0.3], abs=1e-3)
    error = np.abs(model.modes.impulse_response(time) - coupled_kernel(time))
    assert np.max(error / np.outer([1.0, 300.0], [1.0, 300.0])) < 1e-3
    assert model.report.frequency_error < 1e-4
    assert model.report.time_error < 1e-3


def test_closed_form_transfer_function():
    time = np.linspace(0.0, 60.0, 3001)
    model = fit_group(memory_of(kernel(time), time), np.array([0]), 3.0)
    w = np.linspace(0.0, 3.0, 50)
    largest = np.abs(transfer(w)).max()
    assert np.abs(model.modes.transfer_function(1j * w) - transfer(w)).max() < 1.2e-3 * largest
    assert model.decay == pytest.approx([-DECAY], rel=1e-2)
    assert model.frequency == pytest.approx([FREQUENCY], rel=1e-2)


def least_damping(model: StateSpace, band: float) -> float:
    """Smallest over largest eigenvalue of Re K^(i w) at 20 000 frequencies up to 1000 times the
    band, couplings scaled by the diagonal."""
    w = np.append(np.linspace(0.0, 5.0 * band, 16001), np.geomspace(5.0, 1000.0, 4000) * band)
    K = model.modes.transfer_function(1j * w).real
    scale = np.sqrt(np.abs(np.diagonal(K, axis1=1, axis2=2)).max(axis=0))
    eigenvalues = np.linalg.eigvalsh(K / np.outer(scale, scale))
    return float(eigenvalues.min() / eigenvalues.max())


def test_kernel_that_feeds_energy_in_is_made_passive():
    """Re K^ of exp(-a t) sin(b t) changes sign at w^2 = a^2 + b^2, down to -1/5 of its maximum: no
    passive model is nearer than that, and the nearest in the mean square is not much farther."""
    time = np.linspace(0.0, 60.0, 3001)
    late = np.exp(-0.5 * time) * np.sin(0.5 * time)
    model = fit_group(memory_of(late[:, None, None], time), np.array([0]), 3.0)
    w = np.linspace(0.0, 30.0, 20000)
    exact = 0.5 / ((1j * w + 0.5) ** 2 + 0.25)
    target = find_target(memory_of(late[:, None, None], time), np.array([0]), 3.0)
    counted = target.emphasis.at(w) * exact.real / np.abs(exact).max()
    assert target.gain == pytest.approx(-counted[w <= 3.0].min(), rel=0.02)
    A, B, C = (
        np.array([[-0.5, 0.5], [-0.5, -0.5]]),
        np.array([[0.0], [1.0]]),
        np.array([[1.0, 0.0]]),
    )
    changed, before, after = make_passive(
        make_reciprocal(find_modes(A, B, C)), 3.0, Emphasis(1.0, 1.0)
    )
    weighted = (1.0 + (w / 3.0) ** 2) * exact.real
    assert before == pytest.approx(weighted.min() / np.abs(exact.real).max(), rel=0.02)
    assert after >= -1e-7
    assert 0.2 < np.abs(changed.transfer_function(1j * w)[:, 0, 0] - exact).max() < 0.6
    assert least_damping(model, 3.0) >= -1e-7
    off = np.abs(
        model.modes.transfer_function(1j * w)[:, 0, 0] - 0.5 / ((1j * w + 0.5) ** 2 + 0.25)
    )
    assert 0.2 < off.max() < 0.6


@pytest.mark.slow
def test_two_bodies_12_by_12_reciprocal_and_passive():
    """A passive kernel between all DOFs of two bodies, sums of a a^T exp(-p t) cos(w t) with B(w)
    positive, is recovered; with a coupling made too large it is not passive and is mended."""
    rng, time = np.random.default_rng(2), np.linspace(0.0, 60.0, 1201)
    K = np.zeros((time.size, 12, 12))
    units = np.tile([1.0, 1.0, 1.0, 50.0, 50.0, 50.0], 2)
    for decay, w in ((0.3, 0.7), (0.5, 1.1), (0.4, 0.4)):
        a = rng.standard_normal((12, 12)) * units
        wave = np.exp(-decay * time) * np.cos(w * time)
        K += np.multiply.outer(wave, a.T @ a)
    (dofs,) = coupled_groups(K)
    good = fit_group(memory_of(K, time), dofs, 3.0)
    assert good.report.frequency_error < 1e-3
    K[:, :6, 6:] *= 2.0
    K[:, 6:, :6] *= 2.0
    bad = fit_group(memory_of(K, time), dofs, 3.0)
    assert bad.report.passivity_before < -1e-3
    for model in (good, bad):
        assert least_damping(model, 3.0) >= -1e-7
        found = model.modes.impulse_response(time)
        assert np.abs(found - found.transpose(0, 2, 1)).max() < 1e-12 * np.abs(found).max()
    w = np.linspace(0.0, 3.0, 100)
    exact = transfer_function(time, K, w)
    off = bad.modes.transfer_function(1j * w) - exact
    assert relative_size(off, exact) < 1.0


def test_groups_are_what_is_coupled_and_radiates():
    K = np.zeros((2, 12, 12))
    np.fill_diagonal(K[0], [4.0, 4.0, 4.0, 9.0, 9.0, 1e-14] * 2)
    K[0, 0, 4] = K[0, 4, 0] = 1.0
    K[0, 1, 3] = 0.5  # one direction is enough
    K[0, 2, 4] = 1e-6  # rounding
    K[1, 6, 2] = -0.1  # between bodies, at another lag
    groups = {tuple(int(d) for d in group) for group in coupled_groups(K)}
    assert groups == {(0, 4), (1, 3), (2, 6), (7,), (8,), (9,), (10,)}
    assert coupled_groups(np.zeros((2, 6, 6))) == []


def h851() -> tuple[np.ndarray, Retardation]:
    with xr.open_dataset(unpacked("h851_independent.nc")) as data:
        w, A, B = (data[k].values for k in ("omega", "added_mass", "radiation_damping"))
    return w, retardation(w, A, B, length=80.0, step=0.1)


def test_h851_within_tolerance_stable_and_passive():
    w, memory = h851()
    groups = coupled_groups(memory.kernel)
    assert [list(g) for g in groups] == [[0, 2, 4], [1, 3, 5]]
    for dofs in groups:
        model = fit_group(memory, dofs, w[-1], 8e-4)
        assert model.report.frequency_error <= 1e-3
        assert model.report.time_error < 0.01
        assert model.report.passivity_margin >= -1e-7
        assert least_damping(model, w[-1]) >= -1e-7
        assert np.all(model.decay < 0.0)
        assert model.B.shape[0] < 70
        K = model.modes.impulse_response(memory.time)
        assert np.abs(K - K.transpose(0, 2, 1)).max() < 1e-9 * np.abs(K).max()  # reciprocity


def test_sphere_heave():
    with h5py.File(unpacked("sphere/sphere.h5")) as file:
        w = file["simulation_parameters/w"][:].ravel()
        coefficients = file["body1/hydro_coeffs"]
        A = coefficients["added_mass/all"][:].transpose(2, 0, 1)
        B = coefficients["radiation_damping/all"][:].transpose(2, 0, 1) * w[:, None, None]
    memory = retardation(w, A, B, length=30.0, step=0.02)
    assert [list(g) for g in coupled_groups(memory.kernel)] == [[0, 4], [1, 3], [2]]
    model = fit_group(memory, np.array([2]), w[-1])
    assert model.order <= 12
    found = model.modes.transfer_function(1j * w)[:, 0, 0]
    # B falls to -0.4 % of its largest at the end of the band, which no passive model follows; 0.1 %
    # by which a spacing of 0.05 rad/s blurs B
    assert B[:, 2, 2].min() == pytest.approx(-4e-3 * B[:, 2, 2].max(), rel=0.1)
    assert np.abs(found.real - B[:, 2, 2]).max() < 6e-3 * B[:, 2, 2].max()
    assert least_damping(model, w[-1]) >= -1e-7
