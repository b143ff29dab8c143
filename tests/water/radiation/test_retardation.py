"""Retardation functions and A_inf against closed forms, scipy quadrature and other programs."""

import sys
from itertools import pairwise

import h5py
import numpy as np
import pytest
import xarray as xr
from closed_forms import INFINITE, added_mass, kernel, transfer
from scipy.integrate import quad
from validation_data import unpacked

from hydrosim.errors import InputError
from hydrosim.report.evidence import Feature, Kind
from hydrosim.water.radiation.retardation import (
    find_radiating,
    fourier_integral,
    infinite_added_mass,
    memory_length,
    relative_size,
    retardation,
    retardation_function,
    smallest_eigenvalue,
    tail_exponent,
    transfer_function,
)

# the package has a function of this name
module = sys.modules["hydrosim.water.radiation.retardation"]


def band(step: float, end: float) -> np.ndarray:
    return step * np.arange(1, round(end / step) + 1)


def test_fourier_integral_is_exact_for_piecewise_linear_functions():
    x, f = np.array([0.0, 0.3, 1.0, 2.5]), np.array([1.0, -2.0, 0.5, 3.0])
    y = np.array([0.0, 1e-9, 1e-3, 0.7, 40.0])
    for value, yi in zip(fourier_integral(x, f, y), y, strict=True):
        for part, wave in ((value.real, np.cos), (value.imag, np.sin)):
            exact = sum(
                quad(lambda u, w=wave, k=yi: np.interp(u, x, f) * w(k * u), a, b, epsabs=1e-13)[0]
                for a, b in pairwise(x)
            )
            assert part == pytest.approx(exact, abs=1e-12)


@pytest.mark.parametrize(
    ("asked", "found"), [(None, 78.5), (40.0, 40.0), (78.5, 78.5), (100.0, 78.5)]
)
def test_no_memory_is_longer_than_frequencies_resolve(asked: float | None, found: float) -> None:
    assert memory_length(band(0.04, 2.48), asked, 0.1) == pytest.approx(found)


def test_close_frequencies_resolve_a_long_memory() -> None:
    fine = np.union1d(band(0.05, 2.6), 1.2 + band(0.01, 0.2))
    assert memory_length(fine, 160.0, 0.1) == 160.0
    assert memory_length(fine, None, 0.1) == 100.0
    assert memory_length(band(0.1, 0.1), None, 0.1) == 100.0


def test_retardation_function_converges_with_the_square_of_the_spacing():
    time = np.linspace(0.0, 15.0, 76)
    errors = []
    for step in (0.08, 0.04, 0.02):
        w = band(step, 40.0)
        errors.append(np.abs(retardation_function(w, transfer(w).real, time) - kernel(time)).max())
        # B linear between frequencies is K times sinc^2(step t / 2): K(0) = 1, t^2 K < 6 here
        assert errors[-1] < 6.5 * step**2 / 12.0
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.15)


@pytest.mark.parametrize("q", [1.3, 2.0, 3.7, 8.0])
def test_power_law_tail(q):
    end = 2.0
    w = band(0.1, end)
    B = np.where(w < 0.8 * end, w * 1.6 ** (-q - 1), w**-q)
    expected_exponent = tail_exponent(w, B[:, None, None])[0, 0]
    assert expected_exponent == pytest.approx(q, rel=1e-12)
    x, f = np.append(0.0, w), np.append(0.0, B)
    for t in (0.0, 0.05, 1.0, 30.0):
        inside = quad(
            lambda u, t=t: np.interp(u, x, f) * np.cos(u * t), 0.0, end, points=x, limit=400
        )
        if t == 0.0:
            beyond = end ** (1.0 - q) / (q - 1.0)
        else:
            beyond = quad(lambda u: u**-q, end, np.inf, weight="cos", wvar=t, limlst=300)[0]
        found = retardation_function(w, B[:, None, None], np.array([t]))[0, 0, 0]
        assert found == pytest.approx(2.0 / np.pi * (inside[0] + beyond), abs=2e-7)


def test_entries_without_a_sound_tail_get_the_steepest():
    w = band(0.1, 4.0)
    rising, slow, crossing = w, w**-0.5, np.cos(np.pi * w / 4.0 * 0.55)
    for B in (rising, slow, crossing, 0.0 * w):
        assert tail_exponent(w, B[:, None, None])[0, 0] == 12.0


def test_coupling_never_outlives_the_damping_it_couples():
    w = band(0.1, 4.0)
    B = np.empty((w.size, 2, 2))
    B[:, 0, 0], B[:, 1, 1], B[:, 0, 1], B[:, 1, 0] = w**-2.0, w**-4.0, w**-1.4, w**-3.5
    q = tail_exponent(w, B)
    assert q[0, 1] == pytest.approx(3.0)
    assert q[1, 0] == pytest.approx(3.5)


def test_ogilvie_gives_added_mass_at_infinite_frequency():
    w, errors = band(0.05, 4.0), []
    for step in (0.2, 0.1):
        time = np.arange(0.0, 80.0, step)
        mean, residual = infinite_added_mass(w, added_mass(w), time, kernel(time))
        errors.append(abs(mean[0, 0] - INFINITE))
        assert np.abs(residual).max() < 3.0 * step**2  # K linear in time: second order
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


def test_transfer_function_is_the_transform_of_the_kernel():
    time = np.arange(0.0, 80.0, 0.02)
    w = np.array([0.0, 0.1, 0.8, 3.0])
    # linear interpolation: step^2 / 12 of int |K''|
    assert transfer_function(time, kernel(time), w) == pytest.approx(transfer(w), abs=1e-4)


@pytest.mark.slow
def test_report_of_consistent_data_and_what_it_flags():
    w = band(0.02, 12.0)
    A, B = added_mass(w), transfer(w).real
    good = retardation(w, A, B, length=40.0, step=0.02)
    assert good.report.ogilvie_residual < 1e-3
    assert good.report.end_ratio < 1e-4
    assert good.report.smallest_eigenvalue >= 0.0
    assert good.report.band_ratio == pytest.approx(B[-1, 0, 0] / B.max())
    assert good.added_mass_infinite[0, 0] == pytest.approx(INFINITE, abs=1e-3)

    wrong = A.copy()
    wrong[100] += 0.2
    report = retardation(w, wrong, B, length=40.0, step=0.02).report
    assert report.ogilvie_residual == pytest.approx(0.2 / np.abs(wrong).max(), rel=0.02)
    assert retardation(w, A, B, length=4.0, step=0.02).report.end_ratio > 0.1


def test_negative_damping_is_flagged_even_where_the_diagonal_is_positive():
    B = np.array([[[1.0, 1.5], [1.5, 1.0]], [[2.0, 0.0], [0.0, 2.0]]])
    # scaled by the largest diagonal, 2: eigenvalues (1 -+ 1.5) / 2 and 1
    assert smallest_eigenvalue(B) == pytest.approx(-0.25 / 1.25)


def test_rounding_is_not_radiation():
    B = np.zeros((1, 12, 12))
    np.fill_diagonal(B[0], [1, 1, 1, 5, 5, 1e-12, 1e-13, 0, 0, 0, 1e-15, 0])
    assert list(find_radiating(B)) == [0, 1, 2, 3, 4, 6, 10]
    assert find_radiating(np.zeros((1, 6, 6))).size == 0


def test_wrong_data_are_refused_with_their_place():
    w, B = np.array([0.5, 1.0, 1.5]), np.ones((3, 2, 2))
    time = np.array([0.0, 1.0])
    with pytest.raises(InputError, match=r"3 frequencies .* shape \(2, 2, 2\)"):
        retardation_function(w, B[:2], time)
    with pytest.raises(InputError, match="increasing"):
        retardation_function(w[::-1], B, time)
    B[1, 0, 1] = np.nan
    with pytest.raises(InputError, match=r"entry \(0, 1\) at 1 rad/s is nan"):
        retardation_function(w, B, time)


def test_h851_kernel_and_added_mass():
    with xr.open_dataset(unpacked("h851_independent.nc")) as data:
        w, A, B = (data[k].values for k in ("omega", "added_mass", "radiation_damping"))
        A_inf = data.added_mass_inf.values
    found = retardation(w, A, B, length=80.0, step=0.1)
    # those who made the data found 0.3 %, and 0.6 % to the solver's own A_inf in surge
    assert found.report.ogilvie_residual < 0.005
    assert found.report.end_ratio < 1e-3
    assert relative_size(found.added_mass_infinite - A_inf, A) < 0.008


def test_sphere_kernel_equals_that_of_bemio(validated):
    with h5py.File(unpacked("sphere/sphere.h5")) as file:
        w = file["simulation_parameters/w"][:].ravel()
        coefficients = file["body1/hydro_coeffs"]
        A = coefficients["added_mass/all"][:].transpose(2, 0, 1)
        B = coefficients["radiation_damping/all"][:].transpose(2, 0, 1) * w[:, None, None]
        A_inf = coefficients["added_mass/inf_freq"][:]
        irf = coefficients["radiation_damping/impulse_response_fun"]
        time, K = irf["t"][:].ravel(), irf["K"][:].transpose(2, 0, 1)
    found = retardation(w, A, B, length=40.0, step=0.02)
    assert found.added_mass_infinite[2, 2] == pytest.approx(A_inf[2, 2], rel=2e-3)
    ours = retardation_function(w, B, time)
    error = np.abs(ours - K)[:, 2, 2].max() / np.abs(K[:, 2, 2]).max()
    claim = "retardation function of the sphere in heave, of the largest"
    validated(Kind.PROGRAM, claim, "BEMIO", error, 0.01, Feature.RADIATION)


def test_what_is_kept_of_a_database_is_the_same_and_spares_the_kernel(tmp_path, monkeypatch):
    """A_inf and the report come from the cache; K is computed if it is asked for, and only then."""
    monkeypatch.setenv("HYDROSIM_CACHE_DIR", str(tmp_path))
    w = band(0.1, 6.0)
    A, B = added_mass(w), transfer(w).real
    plain = retardation(w, A, B, length=40.0)
    made = retardation(w, A, B, length=40.0, checksum="a")
    asked = []
    transform = module.retardation_function
    monkeypatch.setattr(
        module, "retardation_function", lambda *given: asked.append(given) or transform(*given)
    )
    cached = retardation(w, A, B, length=40.0, checksum="a")
    for one in (made, cached):
        np.testing.assert_array_equal(one.added_mass_infinite, plain.added_mass_infinite)
        np.testing.assert_array_equal(one.time, plain.time)
        assert str(one.report) == str(plain.report)
        np.testing.assert_array_equal(one.report.tail_exponent, plain.report.tail_exponent)
        np.testing.assert_array_equal(one.kernel, plain.kernel)
    assert not asked
    for other in ({"checksum": "b"}, {"length": 30.0}, {"step": 0.2}):
        retardation(w, A, B, **{"length": 40.0, "checksum": "a", **other})
    assert len(asked) == 3
