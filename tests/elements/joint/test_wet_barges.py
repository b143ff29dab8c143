"""Two hinged barges in regular waves against the frequency domain with the constraint."""

from math import pi
from pathlib import Path

import numpy as np
import pytest
from hinged_barges import HINGE_DAMPING, Barges, allowed_motions, constraints

import hydrosim as hs
from hydrosim.analysis.seakeeping import LinearRequest, linear_analysis
from hydrosim.compile.compile import Radiation
from hydrosim.report.evidence import Feature, Kind

CASES = Path(__file__).parents[3] / "cases" / "hinged_barges"
NAMES = ["fore", "aft"]
SMALL = 0.01  # m: amplitude of waves without effects of second order
IN_PLANE = [0, 2, 4, 6, 8, 10]


@pytest.fixture(scope="module")
def barges() -> Barges:
    return Barges()


def scene_of(**settings: object) -> hs.Scene:
    """The case in a regular wave, with other settings: keys have __ for dots."""
    changes = {key.replace("__", "."): value for key, value in settings.items()}
    return hs.load_case(CASES / "regular.yaml", changes).scene()


def test_coordinates_and_multipliers_agree(barges):
    assert np.abs(constraints() @ allowed_motions()).max() < 1e-12
    for row in range(0, barges.frequency.size, 9):
        one = barges.by_coordinates(row, 2, barges.added_mass)
        other, _ = barges.by_multipliers(row, 2, barges.added_mass)
        np.testing.assert_allclose(other, one, atol=1e-11 * np.abs(one).max())


def test_linear_analysis_against_the_frequency_domain(barges, validated):
    """All motions, in waves from all sides, with added mass and damping of the database."""
    rows = range(6, barges.frequency.size, 6)
    columns = range(0, barges.heading.size, 2)
    keys = {"headings": barges.heading[list(columns)], "frequencies": barges.frequency[list(rows)]}
    keys = {key: tuple(values) for key, values in keys.items()}
    wanted = LinearRequest(**keys, radiation=Radiation.DATABASE)
    found = linear_analysis(scene_of(), wanted)
    phased = found.rao_amplitude * np.exp(1j * found.rao_phase)
    raos = phased.sel(body=NAMES).transpose("heading", "frequency", "body", "dof")
    errors = []
    for i, column in enumerate(columns):
        for j, row in enumerate(rows):
            expected = barges.by_coordinates(row, column, barges.added_mass)
            error = np.abs(raos.values[i, j].ravel() - expected).max()
            errors.append(error / np.abs(expected).max())
    claim, against = "hinged barges, RAOs, of the largest", "frequency domain with the constraint"
    features = (Feature.JOINTS, Feature.COUPLED)
    validated(Kind.INDEPENDENT, claim, against, max(errors), 1e-9, *features)


@pytest.mark.parametrize("kinematics", ["linear", "exact"])
@pytest.mark.parametrize("wanted", [0.6, 0.9, 1.2])
def test_regular_waves_against_the_frequency_domain(barges, validated, figure, kinematics, wanted):
    """Amplitudes and phases of surge, heave and pitch of both, of the largest, with pitch times
    half of a barge's length. Damping is that of the database, with the added mass that it implies.
    The added mass of the database itself has errors of its panels, which show in the motions."""
    row = int(np.argmin(np.abs(barges.frequency - wanted)))
    found = harmonic(barges.frequency[row], kinematics)
    lever = np.tile([1.0, 1.0, 1.0, 20.0, 20.0, 20.0], 2)[IN_PLANE]
    errors = []
    for added_mass in (barges.causal_added_mass, barges.added_mass):
        expected = barges.by_coordinates(row, 0, added_mass)[IN_PLANE]
        error = np.abs((found - expected) * lever).max()
        errors.append(error / np.abs(expected * lever).max())
    figure("with the added mass of the database", errors[1])
    assert errors[1] < 2e-3
    claim = "hinged barges in a regular wave, motions of the largest"
    against = "frequency domain with the constraint"
    features = (Feature.JOINTS, Feature.COUPLED, Feature.RADIATION)
    validated(Kind.INDEPENDENT, claim, against, errors[0], 1e-3, *features)


def harmonic(w: float, kinematics: str) -> np.ndarray:
    """Complex amplitudes (6,) of `IN_PLANE` per wave amplitude, over the last twenty periods."""
    period = 2.0 * pi / w
    wave = {"environment__waves__amplitude": SMALL, "environment__waves__period": period}
    duration = 400.0 + 20.0 * period
    scene = scene_of(**wave, solver__kinematics=kinematics, duration=duration)
    run = hs.simulate(scene)
    late = run.sel(time=slice(run.time.values[-1] - 20.0 * period, None))
    t = late.time.values
    waves = np.stack([np.cos(w * t), -np.sin(w * t), np.ones(t.size)], axis=1)
    motions = late.position.sel(body=NAMES).values.reshape(t.size, 12)[:, IN_PLANE]
    real, imaginary, _ = np.linalg.lstsq(waves, motions, rcond=None)[0]
    return (real + 1j * imaginary) / SMALL


@pytest.mark.parametrize("symmetry", ["use", "ignore"])
def test_damping_of_the_joint_is_a_power_take_off_about_it(symmetry):
    """Also where symmetry leaves out four coordinates and the hinge gets another number."""
    same = {"duration": 30.0, "environment__waves__ramp": 5.0, "solver__symmetry": symmetry}
    one = hs.simulate(scene_of(**same))
    damped = {"forces__power_take_off": None, "joints__hinge__damping": HINGE_DAMPING}
    other = hs.simulate(scene_of(**same, **damped))
    size = np.ptp(one.position.values, axis=0).max()
    assert np.abs(other.position.values - one.position.values).max() < 1e-9 * size
