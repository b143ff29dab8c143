"""The linearised scene: natural periods, decay and responses of the H-851, and closed forms."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose
from scenes import hull, in_waves, motion, scene_of, with_body
from scipy import linalg
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

import hydrosim as hs
from hydrosim.dofs import DOFS
from hydrosim.elements.contact.law import STICK
from hydrosim.linear.linearise import Linear
from hydrosim.linear.modes import NaturalMode
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Body, Kinematics, RegularWave, Scene, Solver, WaveForces, WaveTrain

BANDS = {"surge": (129, 131), "heave": (10.5, 11.1), "roll": (11.8, 12.5), "pitch": (9.5, 10.2)}
PERIODS = (6.0, 8.0, 10.0, 12.0, 16.0)  # s; all of them divide FITTED
FITTED = 240.0  # s at the end of a run in a regular wave
MEASURED = ("surge", "heave", "pitch")


def linear_of(scene: Scene) -> Linear:
    return hs.linearise(*hs.compile_scene(scene))


def first_order(scene: Scene) -> Scene:
    return with_body(scene, wave_forces=WaveForces(first_order=True))


@pytest.fixture(scope="module")
def modes() -> dict[str, NaturalMode]:
    return {mode.dof: mode for mode in hs.natural_modes(linear_of(scene_of("free_floating")))}


class FrequencyDomain:
    """The equation of motion of the moored barge from the numbers in its database alone."""

    def __init__(self) -> None:
        db, scene = hull(), scene_of("free_floating")
        (body,), mooring = scene.bodies, scene.forces["mooring"]
        assert isinstance(mooring, hs.LinearMooring)
        assert mooring.damping_ratio is not None
        self.mass = linalg.block_diag(body.mass * np.eye(3), body.inertia)
        self.stiffness = db.hydrostatic_stiffness + mooring.stiffness
        self.added_mass = CubicSpline(db.frequency, db.added_mass)
        self.radiation_damping = CubicSpline(db.frequency, db.radiation_damping)
        self.excitation = CubicSpline(db.frequency, db.excitation[:, 0])
        self.mooring_damping = np.zeros((6, 6))
        for i in np.flatnonzero(mooring.damping_ratio):
            heavy = self._natural_mass(i)
            critical = 2 * np.sqrt(mooring.stiffness[i, i] * heavy)
            self.mooring_damping[i, i] = mooring.damping_ratio[i] * critical

    def _natural_mass(self, i: int) -> float:
        """m + a(w) of one DOF alone at its natural frequency."""

        def heavy(w: float) -> float:
            return self.mass[i, i] + self.added_mass(w)[i, i]

        w = brentq(lambda w: self.stiffness[i, i] - w**2 * heavy(w), 0.02, 2.2)
        return heavy(w)

    def response(self, w: float) -> np.ndarray:
        """Complex amplitudes of the motions in a wave of unit amplitude towards +x."""
        damping = self.radiation_damping(w) + self.mooring_damping
        inertia = self.mass + self.added_mass(w)
        D = self.stiffness - w**2 * inertia + 1j * w * damping
        return linalg.solve(D, self.excitation(w))

    def natural_periods(self) -> list[float]:
        """All w in the database's range with det(K - w^2 (M + A(w))) = 0, as periods [s]."""

        def gap(w: float, k: int) -> float:
            squares = linalg.eigh(self.stiffness, self.mass + self.added_mass(w), eigvals_only=True)
            return squares[k] - w**2

        scan, found = np.linspace(0.02, 2.2, 200), []
        for k in range(6):
            gaps = np.array([gap(w, k) for w in scan])
            for j in np.flatnonzero(gaps[:-1] * gaps[1:] < 0):
                found.append(2 * pi / brentq(gap, scan[j], scan[j + 1], args=(k,)))
        return sorted(found)


@pytest.mark.parametrize("dof", BANDS)
def test_natural_periods_of_the_barge(dof, modes, figure):
    low, high = BANDS[dof]
    figure(f"natural period {dof} [s]", modes[dof].natural_period)
    assert low <= modes[dof].natural_period <= high


def test_natural_periods_make_inertia_balance_stiffness(modes, validated):
    """Roots of the undamped equation; A_inf is within 1e-3 of A(w)'s. Yaw has no stiffness."""
    found = sorted(mode.natural_period for mode in modes.values())
    expected = FrequencyDomain().natural_periods()
    assert len(expected) == 5
    assert found[-1] == np.inf
    error = np.abs(np.divide(found[:-1], expected) - 1)
    claim = "natural periods of H-851 at its moorings"
    against = "roots of the undamped equation of motion"
    validated(Kind.INDEPENDENT, claim, against, error.max(), 2e-3, Feature.LINEAR)


@pytest.mark.parametrize(("dof", "offset"), [("surge", 1.0), ("roll", 0.02)])
def test_decay(dof: str, offset: float, modes: dict[str, NaturalMode], figure) -> None:
    """Periods from zero crossings and damping from the logarithmic decrement, once the other modes
    have died away; what is left of sway in roll scatters its decrement by some 0.3 %."""
    i = DOFS.index(dof)
    calm = with_body(in_waves(scene_of("free_floating")), position=tuple(offset * np.eye(6)[i]))
    run = hs.simulate(replace(calm, duration=800.0))
    x = CubicSpline(run.time, motion(run)[:, i])
    crossings, peaks = (f.roots(extrapolate=False) for f in (x, x.derivative()))
    crossings, peaks = crossings[crossings > 40.0], peaks[peaks > 40.0]
    assert len(crossings) > 8
    period = 2 * np.mean(np.diff(crossings))
    decrement = np.log(np.abs(x(peaks[0]) / x(peaks[-1]))) / (len(peaks) - 1)
    damping = decrement / np.hypot(pi, decrement)
    figure(f"damped period {dof} [s]", period)
    figure(f"damped period {dof}, error", period / modes[dof].damped_period - 1)
    figure(f"damping ratio {dof}", damping)
    figure(f"damping ratio {dof}, error", damping / modes[dof].damping_ratio - 1)
    assert period == pytest.approx(modes[dof].damped_period, rel=2e-3)
    assert damping == pytest.approx(modes[dof].damping_ratio, rel=1e-2)


@pytest.fixture(scope="module", params=[Kinematics.LINEAR, Kinematics.EXACT])
def steady(request: pytest.FixtureRequest) -> list[xr.Dataset]:
    """Runs in regular waves of 1 m towards +x, until their transients are gone: surge, the slowest,
    keeps exp(-0.0097 1/s 1300 s) = 3e-6 of what the ramp gave it.

    Exact kinematics make no difference here: surge, heave and pitch alone are a motion in a plane,
    where the rate of the angle is the angular velocity, and all loads are on the centre of gravity.
    """
    solver = Solver(step=0.1, kinematics=request.param)
    still = first_order(scene_of("free_floating"))
    scene = replace(still, duration=1300.0 + FITTED, solver=solver)
    waves = [WaveTrain(RegularWave(amplitude=1.0, period=T), ramp=200.0) for T in PERIODS]
    return [hs.simulate(in_waves(scene, train)) for train in waves]


def harmonic(run: xr.Dataset, period: float) -> np.ndarray:
    """Complex amplitudes (6,) of the motions at the period, over whole periods at the end."""
    late = run.sel(time=slice(float(run.time[-1]) - FITTED + 1e-3, None))
    angle = 2 * pi / period * late.time.values
    basis = np.column_stack([np.cos(angle), -np.sin(angle), np.ones(angle.size)])
    real, imaginary, _ = np.linalg.lstsq(basis, motion(late), rcond=None)[0]
    return real + 1j * imaginary


def largest_errors(found: np.ndarray, expected: np.ndarray) -> np.ndarray:
    """Largest |difference| of each motion over the largest amplitude of that motion."""
    columns = [DOFS.index(dof) for dof in MEASURED]
    error, size = np.abs(found - expected)[:, columns], np.abs(expected)[:, columns]
    return error.max(axis=0) / size.max(axis=0)


def test_regular_waves_give_the_linear_response(steady: list[xr.Dataset], figure) -> None:
    """Amplitude and phase, with the same X(w): only the time integration is between them."""
    linear = linear_of(first_order(in_waves(scene_of("free_floating"))))
    load = CubicSpline(hull().frequency, hull().excitation[:, 0])
    found = np.array([harmonic(run, T) for run, T in zip(steady, PERIODS, strict=True)])
    expected = np.array([linear.response(2 * pi / T, load(2 * pi / T)) for T in PERIODS])
    errors = largest_errors(found, expected)
    for dof, error in zip(MEASURED, errors, strict=True):
        figure(f"{dof}, error of the RAO over its maximum", error)
    assert (errors < 1e-3).all()


def test_regular_waves_give_the_databases_response(steady, figure):
    """Against A(w), B(w), X(w) interpolated here; the fit of the radiation is within 1e-3."""
    domain = FrequencyDomain()
    found = np.array([harmonic(run, T) for run, T in zip(steady, PERIODS, strict=True)])
    expected = np.array([domain.response(2 * pi / T) for T in PERIODS])
    errors = largest_errors(found, expected)
    for dof, error in zip(MEASURED, errors, strict=True):
        figure(f"{dof}, error of the RAO over its maximum", error)
    assert (errors < 5e-3).all()


def test_following_waves_do_not_move_the_barge_sideways(steady: list[xr.Dataset]) -> None:
    sideways = ["sway", "roll", "yaw"]
    assert max(float(np.abs(run.position.sel(dof=sideways)).max()) for run in steady) < 1e-12


def test_dynamic_stiffness_of_springs_and_dampers() -> None:
    """K + i w C - w^2 M of a dry body; central differences of a linear system are exact."""
    random = np.random.default_rng(5).standard_normal
    K, C = (matrix @ matrix.T for matrix in random((2, 6, 6)))
    body = Body("block", mass=3.0, inertia=np.diag([2.0, 5.0, 4.0]))
    spring = hs.LinearMooring("block", stiffness=K, damping=C)
    solver = Solver(kinematics=Kinematics.LINEAR)
    scene = Scene("block", 1.0, (body,), forces={"spring": spring}, solver=solver)
    M = np.diag([3.0, 3.0, 3.0, 2.0, 5.0, 4.0])
    linear = linear_of(scene)
    for w in (0.1, 1.0, 7.0):
        D = K + 1j * w * C - w**2 * M
        assert_allclose(linear.dynamic_stiffness(w), D, atol=1e-9 * np.abs(D).max())


def test_stuck_fenders_add_their_springs_and_dampers() -> None:
    """In stick a point adds K2 + i w C2 along the plane and the slope of its curve across it."""
    base = scene_of("base")
    fender = base.forces["interface"]
    solver = Solver(step=0.1, kinematics=Kinematics.LINEAR)
    model, state = hs.compile_scene(replace(base, solver=solver))
    stuck = state.modes.copy()
    stuck[:, 0] = STICK
    free, held = hs.linearise(model, state), hs.linearise(model, state, stuck)
    w = 0.7
    tangential = fender.friction.stiffness + 1j * w * fender.friction.damping
    local = np.diag([tangential, tangential, fender.normal.force[1] / fender.normal.compression[1]])
    expected = np.zeros((6, 6), dtype=complex)
    for x, y, z in fender.points:
        at_point = np.array([[1, 0, 0, 0, z, -y], [0, 1, 0, -z, 0, x], [0, 0, 1, y, -x, 0]])
        expected += at_point.T @ local @ at_point
    added = held.dynamic_stiffness(w) - free.dynamic_stiffness(w)
    assert_allclose(added, expected, atol=1e-6 * np.abs(expected).max())
