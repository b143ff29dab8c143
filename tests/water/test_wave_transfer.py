from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from known_box import Box, box_at, froude_krylov, smooth_drift
from validation_data import unpacked

from hydrosim.errors import InputError
from hydrosim.water.transfer import excitation_at, mean_drift_at


def every(omega: np.ndarray, heading: float) -> np.ndarray:
    """Waves of all these frequencies to one heading."""
    return np.full(omega.size, heading)


MIRROR = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])


def test_exact_at_the_nodes(box: Box) -> None:
    for node, heading in enumerate(box.heading):
        for turn in (-2 * np.pi, 0.0, 2 * np.pi):
            load = excitation_at(box, every(box.frequency, heading + turn), box.frequency)
            atol = 1e-12 * np.abs(box.excitation).max()  # what is taken as solver noise
            np.testing.assert_allclose(load, box.excitation[:, node], rtol=1e-13, atol=atol)


def test_error_between_frequencies_falls_with_the_fourth_power(box: Box) -> None:
    omega, heading = np.linspace(0.2, 1.0, 401), 0.0
    exact = froude_krylov(omega, np.array([heading]))[:, 0]

    def error(spacing: float) -> np.ndarray:
        table = box_at(np.arange(1, round(2.2 / spacing) + 1) * spacing, np.array([0.0]))
        return np.abs(excitation_at(table, every(omega, heading), omega) - exact).max(axis=0)[
            [0, 2]
        ]

    coarse, fine = error(0.04), error(0.02)
    assert np.all(coarse / fine > 2**3.5)
    assert np.all(fine < 5e-4 * np.abs(exact).max(axis=0)[[0, 2]])


def test_frequencies_of_a_real_hull() -> None:
    """Every second frequency of a solved barge predicts those between, up to 1 rad/s, to 0.3 % of
    the largest load; with all of them the error of a cubic spline is a sixteenth of that."""
    with xr.open_dataset(unpacked("h851_independent.nc")) as data:
        omega, heading = data["omega"].values, np.radians(data["heading"].values)
        load = data["excitation_re"].values - 1j * data["excitation_im"].values
    half = Box(omega[::2], heading, load[::2], None, "every second frequency")
    low = omega <= 1.0
    for j in (0, 3, 6, 12):
        error = excitation_at(half, every(omega[low], heading[j]), omega[low]) - load[low, j]
        assert np.all(np.abs(error) < 3e-3 * np.abs(load).max(axis=(0, 1)))


@pytest.mark.parametrize(
    ("spacing", "omega", "limit"),
    [(15.0, 0.6, 5e-6), (15.0, 0.8, 3e-3), (15.0, 0.9, 2e-2), (7.5, 1.0, 2e-6), (7.5, 1.2, 2e-3)],
)
def test_between_headings(spacing: float, omega: float, limit: float) -> None:
    """Largest error halfway between evenly spaced headings, of the largest at that
    frequency: the figures that
    the module states. Harmonics of the heading above 180 deg / spacing are lost, and those of the
    box's loads fade above k L / 2, which is 5, 8.5, 11, 13 and 19 here."""
    table = box_at(np.array([0.5 * omega, omega]), np.arange(0.0, 360.0, spacing))
    halfway = table.heading + np.radians(0.5 * spacing)
    exact = froude_krylov(np.array([omega]), halfway)[0, :, :3]
    found = excitation_at(table, halfway, np.full(halfway.size, omega))[:, :3]
    error = np.abs(found - exact).max(axis=0) / np.abs(table.excitation[1, :, :3]).max(axis=0)
    assert np.all(error < limit)


def test_uneven_headings_by_splines() -> None:
    """Without the heading 45 deg the rest is not evenly spaced: an error of 6 % near the gap and
    below 1 % elsewhere, at k L / 2 = 5."""
    degrees = np.setdiff1d(np.arange(0.0, 360.0, 15.0), [45.0])
    table, omega = box_at(np.array([0.3, 0.6]), degrees), np.full(2, 0.6)
    heading = np.radians([45.0, 187.5])
    exact = froude_krylov(omega[:1], heading)[0, :, 2]
    error = np.abs(excitation_at(table, heading, omega)[:, 2] - exact)
    assert np.all(error < np.array([0.06, 0.01]) * np.abs(table.excitation[1, :, 2]).max())


def test_one_heading_is_one_of_many(box: Box) -> None:
    """Waves to one heading and the same waves among others have the same loads."""
    omega, heading = np.array([0.3, 0.55, 0.81]), np.array([0.4, 0.4, 2.0])
    together = excitation_at(box, heading, omega)
    for i in range(3):
        alone = excitation_at(box, heading[i : i + 1], omega[i : i + 1])
        np.testing.assert_allclose(together[i : i + 1], alone, rtol=1e-12, atol=1e-9)


def test_mirrored_headings_give_mirrored_loads(box: Box) -> None:
    omega = np.linspace(0.01, 2.5, 100)
    for heading in np.radians([0.0, 10.0, 15.0, 100.0, 172.0]):
        for at in (excitation_at, mean_drift_at):
            port, starboard = (
                at(box, every(omega, turned), omega) for turned in (heading, -heading)
            )
            atol = 1e-12 * np.abs(port).max()
            np.testing.assert_allclose(starboard, port * MIRROR, atol=atol)


def test_what_is_zero_by_symmetry_is_exactly_zero(box: Box) -> None:
    noisy = replace(
        box, excitation=box.excitation + 1e-15 * np.abs(box.excitation).max(), source="noisy"
    )
    np.testing.assert_array_equal(
        excitation_at(noisy, every(box.frequency, 0.0), box.frequency)[:, 1], 0.0
    )
    np.testing.assert_array_equal(
        mean_drift_at(box, every(box.frequency, np.pi), box.frequency)[:, [1, 5]], 0.0
    )
    assert np.all(excitation_at(noisy, every(box.frequency, 0.3), box.frequency)[:, 1] != 0.0)


def test_a_missing_drift_is_refused_with_the_key_of_a_recipe(box: Box) -> None:
    bare = replace(box, mean_drift=None)
    with pytest.raises(InputError, match=r"found no mean drift; expected .*drift: \[free\]"):
        mean_drift_at(bare, every(box.frequency, 0.0), box.frequency)


def test_outside_the_frequencies(box: Box) -> None:
    omega, heading = np.array([0.005, 0.02, 2.2, 2.2001, 5.0]), np.radians(30)
    exact = froude_krylov(omega, np.array([heading]))[:, 0]
    load = excitation_at(box, every(omega, heading), omega)
    np.testing.assert_array_equal(load[0], load[1])
    np.testing.assert_allclose(load[1:3], exact[1:3], rtol=1e-12)
    np.testing.assert_array_equal(load[3:], 0.0)
    drift = mean_drift_at(box, every(omega, heading), omega)
    np.testing.assert_allclose(drift[0], drift[1] / 4, rtol=1e-14)
    np.testing.assert_array_equal(drift[3:], drift[[2, 2]])
    np.testing.assert_allclose(drift[1:3], smooth_drift(omega, np.array([heading]))[1:3, 0])


def test_part_of_the_circle_is_enough_within_it() -> None:
    part = box_at(np.arange(0.1, 0.65, 0.1), np.array([345.0, 15.0, 0.0, 30.0]))
    exact = froude_krylov(part.frequency, np.radians([5.0]))[:, 0]
    found = excitation_at(part, every(part.frequency, np.radians(5.0)), part.frequency)
    np.testing.assert_allclose(found[:, 0], exact[:, 0], rtol=0.01)
    excitation_at(part, every(part.frequency, np.radians(-15.0)), part.frequency)


@pytest.mark.parametrize(
    ("degrees", "asked", "range_named"),
    [
        ([0.0, 45.0, 90.0, 135.0, 180.0], -10.0, "0 to 180 deg"),
        ([0.0], 1.0, "0 to 0 deg"),
        ([0.0, 90.0, 180.0, 270.0], 45.0, "0 to 270 deg"),
        ([350.0, 0.0, 10.0], 11.0, "0 to 350 deg"),
    ],
)
def test_heading_outside_is_refused(degrees: list[float], asked: float, range_named: str) -> None:
    table = box_at(np.array([0.5, 1.0]), np.array(degrees))
    with pytest.raises(InputError) as raised:
        excitation_at(table, every(table.frequency, np.radians(asked)), table.frequency)
    message = str(raised.value)
    for part in ("box.nc", f"{asked:g} deg", range_named, "environment.waves.heading"):
        assert part in message


def test_absent_drift_is_refused(box: Box) -> None:
    with pytest.raises(InputError, match=r"box\.nc.*second_order"):
        mean_drift_at(replace(box, mean_drift=None), every(box.frequency, 0.0), box.frequency)
