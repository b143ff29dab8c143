from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hydrosim.database import all_headings, move_reference
from hydrosim.database.changes import velocity_transfer

LENGTH, BEAM, DRAUGHT = 100.0, 20.0, 5.0
RHO, G = 1025.0, 9.81
VOLUME = LENGTH * BEAM * DRAUGHT

vectors = st.lists(st.floats(-50, 50), min_size=3, max_size=3).map(np.array)


def box_stiffness(x: float, y: float, z: float) -> np.ndarray:
    """Stiffness of a floating box about a point (x, y), its centre of gravity at height z."""
    lever = VOLUME * (-DRAUGHT / 2 - z)
    area = LENGTH * BEAM
    C = np.zeros((6, 6))
    C[2, 2] = area
    C[2, 3] = C[3, 2] = -area * y
    C[2, 4] = C[4, 2] = area * x
    C[3, 3] = LENGTH * BEAM**3 / 12 + area * y**2 + lever
    C[4, 4] = BEAM * LENGTH**3 / 12 + area * x**2 + lever
    C[3, 4] = C[4, 3] = -area * x * y
    return RHO * G * C


@pytest.fixture(scope="module")
def box(made_up):
    centre = np.array([[0.0, 0.0, -1.0]])
    return made_up(
        hydrostatic_stiffness=box_stiffness(0.0, 0.0, -1.0),
        volume=np.array([VOLUME]),
        centre_of_gravity=centre,
        reference_point=centre,
        water_density=RHO,
        gravity=G,
    )


def test_nothing_to_move_is_the_same_object(box):
    assert move_reference(box, (0.0, 0.0, -1.0)) is box


@given(x=st.floats(-40, 40), y=st.floats(-9, 9), z=st.floats(-4, 6))
@settings(max_examples=30)
def test_stiffness_of_a_box(box, x, y, z):
    """Metacentric heights and couplings of a box (any textbook of naval architecture)."""
    moved = move_reference(box, (x, y, z)).hydrostatic_stiffness
    expected = box_stiffness(x, y, z)
    np.testing.assert_allclose(moved, expected, rtol=1e-12, atol=1e-12 * expected.max())


@given(new=vectors, v=vectors, omega=vectors)
@settings(max_examples=30)
def test_kinetic_energy_of_the_water_stays(box, new, v, omega):
    """The same motion of the body, said by the velocity of another of its points."""
    moved = move_reference(box, new)
    at_new = np.concatenate([v, omega])
    at_old = np.concatenate([v + np.cross(omega, box.reference_point[0] - new), omega])
    for name in ("added_mass", "radiation_damping"):
        before, after = getattr(box, name), getattr(moved, name)
        scale = np.abs(before).max() * (at_old @ at_old)
        np.testing.assert_allclose(
            at_new @ after @ at_new, at_old @ before @ at_old, rtol=1e-9, atol=1e-12 * scale
        )


def test_added_mass_of_a_sphere_off_its_centre(made_up):
    """A sphere's added mass is m/2 for every direction, as of a particle: (4/3) pi r^3 rho / 2."""
    m, (x, y, z) = 2.0, (3.0, -2.0, 5.0)
    centre = np.array([[x, y, z]])
    db = made_up(
        added_mass_infinite=np.diag([m, m, m, 0.0, 0.0, 0.0]),
        centre_of_gravity=centre,
        reference_point=centre,
    )
    moved = move_reference(db, (0.0, 0.0, 0.0)).added_mass_infinite
    inertia = m * np.array(
        [
            [y * y + z * z, -x * y, -x * z],
            [-x * y, x * x + z * z, -y * z],
            [-x * z, -y * z, x * x + y * y],
        ]
    )
    np.testing.assert_allclose(moved[3:, 3:], inertia)
    np.testing.assert_allclose(moved[0, 3:], m * np.array([0.0, z, -y]))
    np.testing.assert_allclose(moved, moved.T)


def test_loads_keep_their_force_and_gain_its_moment(box):
    moved = move_reference(box, (4.0, -3.0, 2.0))
    arm = box.reference_point[0] - [4.0, -3.0, 2.0]
    for name in ("excitation", "froude_krylov", "mean_drift"):
        before, after = getattr(box, name), getattr(moved, name)
        np.testing.assert_allclose(after[..., :3], before[..., :3])
        moment = before[..., 3:] + np.cross(arm, before[..., :3])
        np.testing.assert_allclose(after[..., 3:], moment)


def test_there_and_back(box):
    back = move_reference(move_reference(box, (4.0, -3.0, 2.0)), box.centre_of_gravity)
    for name in ("added_mass", "excitation", "mean_drift", "added_mass_zero"):
        np.testing.assert_allclose(getattr(back, name), getattr(box, name), atol=1e-11)
    stiffness = box.hydrostatic_stiffness
    np.testing.assert_allclose(back.hydrostatic_stiffness, stiffness, atol=1e-12 * stiffness.max())


def test_each_body_has_its_own_centre(made_up):
    db = made_up(2)
    new = np.add(db.reference_point, [[0, 0, 0], [1, 2, 3]])
    moved = move_reference(db, new)
    T = velocity_transfer(db.reference_point - new)
    np.testing.assert_array_equal(T[:6, :6], np.eye(6))
    np.testing.assert_array_equal(T[:6, 6:], 0.0)
    np.testing.assert_allclose(moved.added_mass[:, :6, :6], db.added_mass[:, :6, :6])
    np.testing.assert_allclose(moved.added_mass[:, :6, 6:], db.added_mass[:, :6, 6:] @ T[6:, 6:])


def test_inertia_belongs_to_its_distribution_of_mass(made_up):
    """About another point the mass is the same; with another centre of gravity it is another."""
    mass = 5.0
    db = made_up(
        centre_of_gravity=np.zeros((1, 3)),
        reference_point=np.array([[0.0, 0.0, 2.0]]),
        inertia_matrix=velocity_transfer(np.array([[0.0, 0.0, -2.0]])).T
        @ np.diag([mass, mass, mass, 1.0, 2.0, 3.0])
        @ velocity_transfer(np.array([[0.0, 0.0, -2.0]])),
    )
    about_centre = move_reference(db, (0.0, 0.0, 0.0))
    np.testing.assert_allclose(
        about_centre.inertia_matrix, np.diag([mass, mass, mass, 1.0, 2.0, 3.0]), atol=1e-12
    )
    assert move_reference(db, (0.0, 0.0, 1.0)).inertia_matrix is None


def test_moving_and_mirroring_commute(box):
    """For points in the plane of symmetry."""
    box = replace(box, heading=np.radians([0.0, 70.0, 180.0]))
    a = all_headings(move_reference(box, (7.0, 0.0, 3.0)))
    b = move_reference(all_headings(box), (7.0, 0.0, 3.0))
    np.testing.assert_allclose(a.excitation, b.excitation)
    np.testing.assert_allclose(a.mean_drift, b.mean_drift)
