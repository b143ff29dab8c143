"""RAOs, spectra and extremes of the linear analysis against runs of the equation of motion."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from markers import few
from scenes import SEA, in_waves, motion, scene_of, with_body

import hydrosim as hs
from hydrosim.analysis.response import responder
from hydrosim.analysis.seakeeping import LinearRequest, linear_analysis
from hydrosim.compile.compile import Radiation
from hydrosim.dofs import DOFS
from hydrosim.linear.linearise import Linear
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import RegularWave, Scene, Solver, WaveForces, WaveTrain
from hydrosim.statistics.gaussian import find_excursions

Figure = Callable[[str, float], None]
PERIODS = (5.0, 6.0, 7.5, 8.0, 9.6, 10.0, 12.0, 15.0, 20.0, 24.0)  # s; all of them divide FITTED
FITTED = 240.0  # s at the end of a run
SEEDS = 50


def free() -> Scene:
    """The moored barge under first-order loads; yaw is held by a spring and damper, too."""
    case = scene_of("free_floating")
    mooring = case.forces["mooring"]
    stiffness, ratio = mooring.stiffness.copy(), mooring.damping_ratio.copy()
    stiffness[5, 5], ratio[5] = 3.9e9, 0.2
    held = replace(mooring, stiffness=stiffness, damping_ratio=ratio)
    scene = with_body(case, wave_forces=WaveForces(first_order=True))
    return replace(scene, forces={"mooring": held})


def harmonic(run: xr.Dataset, period: float) -> np.ndarray:
    """Complex amplitudes (6,) of the motions at the period, over whole periods at the end."""
    late = run.sel(time=slice(float(run.time[-1]) - FITTED + 1e-3, None))
    angle = 2 * np.pi / period * late.time.values
    basis = np.column_stack([np.cos(angle), -np.sin(angle), np.ones(angle.size)])
    real, imaginary, _ = np.linalg.lstsq(basis, motion(late), rcond=None)[0]
    return real + 1j * imaginary


@pytest.mark.parametrize("degrees", few([0.0, 45.0], 1))
def test_raos_are_those_of_long_runs(
    degrees: float, figure: Figure, validated: Callable[..., None]
) -> None:
    """In all motions that waves to this heading excite, over the largest RAO of the motion; the
    same radiation model in both. Waves of 0.1 m: what is not linear goes with their square."""
    scene, heading = free(), np.radians(degrees)
    omega = 2 * np.pi / np.array(PERIODS)
    expected = responder(scene).raos(heading, omega)
    found = []
    for period in PERIODS:
        train = WaveTrain(RegularWave(0.1, period), heading=heading, ramp=200.0)
        run = hs.simulate(replace(in_waves(scene, train), duration=1500.0))
        found.append(harmonic(run, period) / 0.1)
    excited = np.abs(expected).max(axis=0) > 0.0
    assert list(np.flatnonzero(excited)) == ([0, 2, 4] if degrees == 0.0 else list(range(6)))
    error = np.abs(np.array(found) - expected).max(axis=0)[excited]
    error = error / np.abs(expected).max(axis=0)[excited]
    for i, dof in enumerate(np.flatnonzero(excited)):
        figure(f"{DOFS[dof]}, waves to {degrees:g} deg: error over the largest RAO", error[i])
    claim = "RAOs of the linear analysis, waves to 0 and 45 deg, of the largest"
    validated(Kind.SELF, claim, "runs over 1500 s", error.max(), 1e-3, Feature.LINEAR)


def test_database_and_model_agree_as_the_fit_does() -> None:
    """The fit of the retardation functions is within 3e-4 of the largest. A resonance of damping
    ratio z makes that of the added mass and of the damping 1 / 2z times as much in the motion: of
    roll, 0.024, it is twice 6e-3."""
    scene, omega = free(), np.linspace(0.3, 1.4, 40)
    model, database = (
        responder(scene, radiation=radiation).raos(np.radians(45.0), omega)
        for radiation in Radiation
    )
    error = np.abs(model - database).max(axis=0) / np.abs(database).max(axis=0)
    assert np.all(error < np.where(np.arange(6) == 3, 3e-4 / 0.024, 1e-2))
    assert np.any(error > 0.0)


@pytest.mark.slow
def test_spectrum_is_the_average_of_many_runs(figure: Figure) -> None:
    """Variances of 50 seeds, each motion within four standard errors of the linear analysis."""
    scene = replace(free(), solver=Solver(step=0.2)).with_output(step=1.0)
    train = WaveTrain(SEA, heading=np.radians(45.0), ramp=100.0)
    wanted = LinearRequest()
    expected = linear_analysis(in_waves(scene, train), wanted).response_std.values[0]
    found = []
    for seed in range(1, SEEDS + 1):
        run = hs.simulate(replace(in_waves(scene, replace(train, seed=seed)), duration=1000.0))
        found.append(motion(run.sel(time=slice(400.0, None))).var(axis=0))
    mean, spread = np.mean(found, axis=0), np.std(found, axis=0, ddof=1) / np.sqrt(SEEDS)
    # a record of 600 s loses what is slower; of surge, sway and yaw that is up to a part of its
    # own standard error, which is added
    deviation = (mean - expected**2) / spread
    for dof, value in zip(DOFS, deviation, strict=True):
        figure(f"{dof}: deviation in standard errors", value)
    assert np.all(np.abs(deviation) < 4.0)


def test_analysis_as_a_dataset() -> None:
    """Sums over the spectrum; the largest value is that of the spectrum's bins, and below that of
    waves that know nothing of each other."""
    scene = in_waves(free(), WaveTrain(SEA))
    found = linear_analysis(scene, LinearRequest(headings=[0.0, np.pi / 2], frequencies=[0.5, 0.8]))
    assert dict(found.sizes)["heading"] == 2
    step = float(np.diff(found.sea_frequency)[0])
    variance = found.response_spectrum.sum("sea_frequency") * step
    np.testing.assert_allclose(variance, found.response_std**2, rtol=1e-9)
    heave = found.sel(body="barge", dof="heave")
    cycles = 10800.0 / float(heave.response_period)
    alone = float(heave.response_std) * np.sqrt(2 * np.log(cycles))
    density = heave.response_spectrum.values
    moments = [float(found.sea_frequency.values**n @ density) for n in range(3)]
    level = find_excursions(*moments, 10800.0).level(np.exp(-1.0))
    assert float(heave.response_maximum) < alone
    expected = float(heave.response_std) * level
    assert float(heave.response_maximum) == pytest.approx(expected, rel=1e-3)
    assert float(found.sel(body="barge", dof="sway").response_std) == 0.0
    modes = found.mode_shape.sel(body="barge")
    for k, name in enumerate(found.mode.values):
        assert float(modes[k].sel(dof=str(name).split()[1])) == pytest.approx(1.0)
    for name, variable in found.data_vars.items():
        if name == "mode_kind":
            continue
        each = variable.attrs.get("dof_units")  # of each degree of freedom, or one of all
        assert each.count(",") == variable.sizes["dof"] - 1 if each else variable.attrs["units"]


def decay(linear: Linear, exponents: np.ndarray, time: np.ndarray, k: int) -> np.ndarray:
    """Motion (nt,) of the k-th free coordinate from an offset of 1 in it, by the modes of a linear
    system, with these ``exponents`` in place of its own."""
    modes = np.linalg.eig(linear.jacobian).eigenvectors
    start = np.zeros(len(linear.states))
    start[k] = 1.0
    parts = modes[k] * np.linalg.solve(modes, start.astype(complex))
    return np.asarray((np.exp(np.outer(time, exponents)) @ parts).real)


@pytest.mark.parametrize("dof", ["heave", "roll", "pitch"])
def test_eigenperiods_are_those_of_decays(dof: str, figure: Figure) -> None:
    """A decay from an offset is that of the linear modes, those of the memory included, and no
    longer is if the period of its own mode is off by one part in a thousand."""
    scene = replace(in_waves(free()), duration=150.0).with_output(step=0.5)
    linear = responder(scene).linear
    mode = next(m for m in hs.natural_modes(linear) if m.dof == dof)
    size = 0.1 if dof == "heave" else 0.001
    offset = np.zeros(6)
    offset[mode.coordinate] = size
    run = hs.simulate(with_body(scene, position=tuple(offset)))
    found = motion(run)[:, mode.coordinate] / size
    own = np.linalg.eig(linear.jacobian).eigenvalues
    near = np.argsort(
        np.abs(np.abs(own.imag) - mode.eigenvalue.imag) + abs(own.real - mode.eigenvalue.real)
    )[:2]
    off = own.copy()
    off[near] *= 1.001
    k = list(linear.active).index(mode.coordinate)
    errors = [np.abs(found - decay(linear, each, run.time.values, k)).max() for each in (own, off)]
    figure(f"decay in {dof}, error", errors[0])
    figure(f"decay in {dof}, error with the mode off by 0.001", errors[1])
    assert errors[0] < 1e-5
    assert errors[1] > 10.0 * errors[0]
