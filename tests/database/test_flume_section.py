"""The database of the section in a wave flume, a plane flow, against what such flows must obey, and
against a long prism by Capytaine."""

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from hydrosim.database import HydroDatabase, load

FOLDER = Path(__file__).parents[2] / "hydro_db"
PLANE = (1, 2, 3)  # sway, heave, roll
BAND = (1.0, 10.0)  # rad/s


@pytest.fixture(scope="module")
def section() -> ModuleType:
    """The script that made the database."""
    spec = importlib.util.spec_from_file_location("flume_section", FOLDER / "flume_section.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def database() -> HydroDatabase:
    """The database as it is shipped."""
    return load(FOLDER / "flume_section.nc")


def test_the_script_makes_what_is_stored(section: ModuleType, database: HydroDatabase) -> None:
    row = int(np.flatnonzero(database.frequency == 7.0)[0])
    flow = section.solve(7.0)
    stored = database.excitation[row, 0, 1:4]
    np.testing.assert_allclose(stored, section.LENGTH * flow.excitation, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(
        database.added_mass[row][np.ix_(PLANE, PLANE)],
        section.LENGTH * flow.added_mass,
        rtol=1e-6,
        atol=1e-6,
    )


def test_damping_radiates_what_the_loads_say(section: ModuleType, database: HydroDatabase) -> None:
    """Haskind's relation in a plane: B_ij = Re(X_i X_j*) / (2 rho g c_g) per length, as half of the
    energy goes to each side."""
    inside = (database.frequency >= BAND[0]) & (database.frequency <= BAND[1])
    for row in np.flatnonzero(inside):
        frequency = float(database.frequency[row])
        k = section.wavenumber(frequency)
        speed = frequency / k * section.group_share(k)
        loads = database.excitation[row, 0, 1:4]
        flux = 2.0 * database.water_density * database.gravity * speed * section.LENGTH
        # sway and roll send one sign to both sides, heave the other: nothing couples them
        expected = np.real(np.outer(loads, loads.conj())) / flux
        expected[[0, 2], 1] = expected[1, [0, 2]] = 0.0
        damping = database.radiation_damping[row][np.ix_(PLANE, PLANE)]
        scale = np.sqrt(np.diag(database.radiation_damping.max(axis=0))[1:4])
        np.testing.assert_allclose(
            damping / np.outer(scale, scale), expected / np.outer(scale, scale), atol=0.02
        )


@pytest.mark.parametrize("frequency", [1.0, 4.0, 7.0, 10.0])
def test_waves_keep_their_energy(section: ModuleType, frequency: float) -> None:
    """Thrown back and passed, of the held section and of the one that floats free."""
    flow = section.solve(frequency)
    free = section.free_motion(flow, frequency)
    for motion, limit in ((np.zeros(3), 0.01), (free, 0.02)):
        moved = np.append(motion, 1.0)
        energy = abs(flow.behind @ moved) ** 2 + abs(1.0 + flow.ahead @ moved) ** 2
        assert energy == pytest.approx(1.0, abs=limit)


def test_long_waves_carry_the_section(section: ModuleType) -> None:
    """The heave load is the stiffness; heave damps as two waves of its flux, rho g B^2 / (2 c)."""
    flow = section.solve(0.01)
    assert abs(flow.excitation[1]) == pytest.approx(section.stiffness()[1, 1], rel=1e-3)
    speed = np.sqrt(section.GRAVITY * section.WATER_DEPTH)
    radiated = section.DENSITY * section.GRAVITY * section.BEAM**2 / (2.0 * speed)
    assert flow.damping[1, 1] == pytest.approx(radiated, rel=1e-3)


def test_hydrostatics_are_those_of_its_polygon(section: ModuleType) -> None:
    """Area and centre of buoyancy, by the shoelace formula on a fine outline."""
    y, z = section.outline().T
    cross = y * np.roll(z, -1) - np.roll(y, -1) * z
    area = abs(cross.sum()) / 2.0
    height = (cross * (z + np.roll(z, -1))).sum() / (6.0 * cross.sum() / 2.0)
    assert section.section_area() == pytest.approx(area, rel=2e-4)
    assert section.centre_of_buoyancy() == pytest.approx(height, rel=2e-4)


@pytest.mark.slow
def test_a_long_prism_is_near(section: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    """A prism of 8 m with a lid, per length, in three dimensions by Capytaine."""
    bem = pytest.importorskip("hydrosim.database.build.bem")
    from hydrosim.database.build.drift import Water

    frequency, length = 6.065, 8.0
    flow = section.solve(frequency)
    monkeypatch.setattr(section, "SIDE_ELEMENTS", 5)
    monkeypatch.setattr(section, "BILGE_ELEMENTS", 3)
    monkeypatch.setattr(section, "BOTTOM_ELEMENTS", 10)
    panels, lid = half_prism(section.outline(), length)
    hull = bem.Hull(panels, lid, True, ((0.0, 0.0, section.CENTRE_OF_GRAVITY),))
    water = Water(section.DENSITY, section.GRAVITY, section.WATER_DEPTH)
    found = bem.solve(hull, water, frequency, np.array([np.pi / 2]))
    ratio = found.excitation[0, 1:4] / length / flow.excitation
    np.testing.assert_allclose(ratio, 1.0, atol=0.03)
    damping = np.diag(found.damping)[1:4] / length
    np.testing.assert_allclose(damping, np.diag(flow.damping), rtol=0.03)
    heave = found.added_mass[2, 2] / length
    assert heave == pytest.approx(flow.added_mass[1, 1], rel=0.02)


def half_prism(outline: np.ndarray, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Panels (n, 4, 3) of the half prism at y >= 0 with its ends, and of its lid."""
    half = outline[outline[:, 0] > -1e-12]
    x = np.linspace(-length / 2, length / 2, 41)
    shell = patch(np.array([[(place, y, z) for y, z in half] for place in x]))
    wall = half[half[:, 0] > 0.14]
    ends = [
        patch(np.array([[(place, share * y, z) for y, z in wall] for share in (0.0, 0.5, 1.0)]))
        for place in x[[0, -1]]
    ]
    lid = patch(np.array([[(place, y, 0.0) for y in np.linspace(0.2, 0.0, 5)] for place in x]))
    return np.concatenate([shell, ends[0][:, ::-1], ends[1]])[:, ::-1], lid


def patch(net: np.ndarray) -> np.ndarray:
    """Panels (n, 4, 3) of a net of points (rows, points, 3)."""
    corners = [net[:-1, :-1], net[:-1, 1:], net[1:, 1:], net[1:, :-1]]
    return np.stack(corners, axis=2).reshape(-1, 4, 3)
