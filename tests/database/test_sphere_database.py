"""The sphere in hydro_db: closed forms, another program's coefficients, and its cases."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from validation_data import unpacked

from hydrosim.case import load_case
from hydrosim.database import HydroDatabase, load
from hydrosim.report.evidence import Feature, Kind

ROOT = Path(__file__).parents[2]
RADIUS, DENSITY, GRAVITY = 5.0, 1000.0, 9.81
SURGE, HEAVE, PITCH = 0, 2, 4


@pytest.fixture(scope="module")
def sphere() -> HydroDatabase:
    return load(ROOT / "hydro_db" / "sphere.nc")


@pytest.fixture(scope="module")
def wamit() -> HydroDatabase:
    with pytest.warns(UserWarning, match="size of the horizontal load"):
        return load(unpacked("sphere/sphere.h5"))


def test_hydrostatics(sphere: HydroDatabase) -> None:
    """GM of a sphere is the depth of its centre of gravity, which lies under the centre."""
    volume = 2 / 3 * np.pi * RADIUS**3
    weight = DENSITY * GRAVITY * volume
    expected = [DENSITY * GRAVITY * np.pi * RADIUS**2, 2.0 * weight, 2.0 * weight]
    assert_allclose(np.diag(sphere.hydrostatic_stiffness)[2:5], expected, rtol=1e-12)
    assert sphere.volume[0] == pytest.approx(volume, rel=1e-12)
    assert volume * DENSITY == pytest.approx(261.8e3, rel=1e-4)


def test_added_mass_of_very_short_waves(sphere: HydroDatabase) -> None:
    """In heave that of half a sphere in endless water, half the displaced mass; 0.5 per cent is the
    panels'."""
    half = DENSITY * sphere.volume[0] / 2
    assert sphere.added_mass_infinite[HEAVE, HEAVE] == pytest.approx(half, rel=6e-3)


def test_pressures_have_no_moment_about_the_centre(sphere: HydroDatabase) -> None:
    """They point there, so pitch about the centre of gravity is 2 m of surge; 1 per cent is the
    panels'."""
    for name in ("added_mass", "radiation_damping"):
        surge, pitch = (getattr(sphere, name)[:, SURGE, dof] for dof in (SURGE, PITCH))
        assert np.abs(pitch - 2.0 * surge).max() < 0.02 * np.abs(surge).max()


@pytest.mark.parametrize("dof", [SURGE, HEAVE])
@pytest.mark.parametrize("name", ["added_mass", "radiation_damping"])
def test_radiation_is_that_of_wamit(
    sphere: HydroDatabase, wamit: HydroDatabase, name: str, dof: int, validated: Callable[..., None]
) -> None:
    """Of the largest, at all frequencies from 0.4 rad/s: WAMIT's water is 200 m deep."""
    ours, theirs = (at_same(sphere, db, getattr(db, name))[:, dof, dof] for db in (sphere, wamit))
    error = np.abs(ours - theirs).max() / np.abs(theirs).max()
    claim = "sphere in hydro_db, added mass and damping in surge and heave, of the largest"
    validated(Kind.PROGRAM, claim, "WAMIT", error, 0.006, Feature.HULLS)


@pytest.mark.parametrize("dof", [SURGE, HEAVE])
def test_loads_are_those_of_wamit(
    sphere: HydroDatabase, wamit: HydroDatabase, dof: int, validated: Callable[..., None]
) -> None:
    """In magnitude and phase."""
    ours, theirs = (at_same(sphere, db, db.excitation)[:, 0, dof] for db in (sphere, wamit))
    error = np.abs(ours - theirs).max() / np.abs(theirs).max()
    claim = "sphere in hydro_db, loads in surge and heave, of the largest"
    validated(Kind.PROGRAM, claim, "WAMIT", error, 0.009, Feature.HULLS)


def at_same(sphere: HydroDatabase, db: HydroDatabase, values: np.ndarray) -> np.ndarray:
    """Those of ``values`` that belong to the sphere's frequencies from 0.4 rad/s on."""
    wanted = sphere.frequency[sphere.frequency > 0.39]
    rows = [int(np.abs(db.frequency - w).argmin()) for w in wanted]
    assert np.abs(db.frequency[rows] - wanted).max() < 1e-4
    return values[rows]


def test_every_direction_is_the_same(sphere: HydroDatabase) -> None:
    """Heave loads of all headings, and surge loads as the cosine of the heading."""
    load_of = sphere.excitation[:, :, [SURGE, HEAVE]]
    scale = np.abs(load_of).max(axis=(0, 1))
    turned = load_of[:, :1] * np.stack([np.cos(sphere.heading), np.ones(7)], axis=1)
    assert (np.abs(load_of - turned) / scale).max() < 0.005


def test_the_cases_are_of_this_sphere(sphere: HydroDatabase) -> None:
    paths = sorted((ROOT / "cases" / "sphere").glob("*.yaml"))
    assert len(paths) == 3
    for path in paths:
        scene = load_case(path).scene()
        (body,) = scene.bodies
        assert isinstance(body.hydrodynamics, Path)
        assert body.hydrodynamics.resolve() == ROOT / "hydro_db" / "sphere.nc"
        assert tuple(sphere.centre_of_gravity[0]) == body.centre_of_gravity
        assert sphere.water_density == scene.environment.water_density
