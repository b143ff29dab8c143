"""`simulate`: the sea it makes, what it repeats, how it fails and how it is interrupted."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
import xarray as xr
from scenes import CASES, SEA, hull, in_contact, in_waves, motion, scene_of, steady, with_body
from scipy.integrate import quad
from scipy.interpolate import CubicSpline

import hydrosim as hs
from hydrosim.elements import LinearMooring
from hydrosim.scene import Method, Scene, Solver, WaveForces, WaveTrain

REPEAT = 10800.0  # s
LINE = 2 * pi / REPEAT  # rad/s


@pytest.fixture(scope="module")
def three_hours() -> xr.Dataset:
    """A whole repeat period without ramp, recorded above twice the highest frequency (4.2 rad/s).

    The barge moves in surge and heave only: the sea and its loads do not depend on the motion.
    """
    scene = with_body(
        in_waves(scene_of("free_floating"), WaveTrain(SEA, seed=3, repeat_period=REPEAT)),
        dofs=("surge", "heave"),
        radiation="none",
        wave_forces=WaveForces(first_order=True),
    )
    solver = Solver(method=Method.RK2, step=0.5)
    return hs.simulate(replace(scene, duration=REPEAT, solver=solver).with_output(step=0.5))


def lines(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [rad/s] and complex amplitudes of the components of one repeat period."""
    amplitude = 2 * np.fft.rfft(values[:-1]) / (values.size - 1)
    return LINE * np.arange(amplitude.size), amplitude


def jonswap(w: np.ndarray) -> np.ndarray:
    """Hasselmann et al. (1973), scaled by quadrature to the variance Hs^2 / 16; the tail beyond
    30 rad/s is w^-5."""
    peak = 2 * pi / SEA.peak_period

    def shape(w: np.ndarray) -> np.ndarray:
        width = np.where(w <= peak, 0.07, 0.09)
        enhancement = SEA.peak_enhancement ** np.exp(-(((w / peak - 1) / width) ** 2) / 2)
        return w**-5.0 * np.exp(-1.25 * (peak / w) ** 4) * enhancement

    parts = [(0.2 * peak, peak), (peak, 2 * peak), (2 * peak, 30.0)]
    variance = sum(quad(shape, *ends, epsabs=0.0, epsrel=1e-10)[0] for ends in parts)
    variance += 30.0**-4 / 4
    return SEA.significant_height**2 / 16 / variance * shape(w)


def test_the_elevation_has_the_jonswap_spectrum(three_hours: xr.Dataset) -> None:
    """Line by line, for the amplitudes are deterministic: |a|^2 / 2 = S dw, to the error of the
    quadrature here. Above the highest component is 0.1 % of the energy."""
    w, amplitude = lines(three_hours.wave_elevation.values)
    expected = jonswap(w[1:])
    found = np.abs(amplitude[1:]) ** 2 / 2 / LINE
    components = w[1:] < 4.1
    assert np.abs(found - expected)[components].max() < 1e-6 * expected.max()
    assert 4 * three_hours.wave_elevation.values[:-1].std() == pytest.approx(1.5, rel=1e-3)


@pytest.mark.parametrize("dof", ["surge", "heave"])
def test_first_order_loads_have_the_spectrum_of_the_transfer_function(
    three_hours: xr.Dataset, dof: str
) -> None:
    """F = X(w) eta line by line with its phase, hence |X|^2 S; nothing where the database ends."""
    db, i = hull(), ["surge", "sway", "heave"].index(dof)
    w, elevation = lines(three_hours.wave_elevation.values)
    _, load = lines(three_hours.force_wave_first_order.sel(body="barge", dof=dof).values)
    inside = (w >= db.frequency[0]) & (w <= db.frequency[-1])
    transfer = CubicSpline(db.frequency, db.excitation[:, 0, i])(w[inside])
    assert np.abs(load[inside] - transfer * elevation[inside]).max() < 1e-9 * np.abs(load).max()
    assert np.abs(load[w > db.frequency[-1]]).max() < 1e-9 * np.abs(load).max()
    density, expected = np.abs(load[inside]) ** 2 / 2 / LINE, np.abs(transfer) ** 2
    expected *= jonswap(w[inside])
    assert np.abs(density - expected).max() < 1e-6 * expected.max()


def in_sea(seed: int, duration: float = 60.0) -> Scene:
    train = WaveTrain(SEA, heading=np.radians(30.0), seed=seed)
    return replace(in_waves(scene_of("base"), train), duration=duration)


def test_the_same_seed_gives_the_same_bytes() -> None:
    first, second = (hs.simulate(in_sea(seed=7)) for _ in range(2))
    for name in first.variables:
        assert first[name].values.tobytes() == second[name].values.tobytes()


def test_another_seed_gives_another_sea() -> None:
    first, second = (hs.simulate(in_sea(seed)) for seed in (7, 8))
    correlation = np.corrcoef(first.wave_elevation, second.wave_elevation)[0, 1]
    assert abs(correlation) < 0.9
    assert (first.attrs["seeds"], second.attrs["seeds"]) == ([7], [8])


def test_the_sea_does_not_depend_on_the_duration() -> None:
    short, long = (hs.simulate(in_sea(7, duration)) for duration in (60.0, 120.0))
    start = long.sel(time=short.time)
    for name in ("wave_elevation", "position", "force_wave_second_order"):
        assert np.array_equal(short[name], start[name])


def test_what_is_recorded_does_not_change_the_run() -> None:
    rare, often = (
        hs.simulate(in_contact(60.0).with_output(step=step)).sel(time=slice(0, None, 1))
        for step in (2.0, 0.1)
    )
    assert np.array_equal(rare.position, often.position.sel(time=rare.time, method="nearest"))


def test_a_case_is_simulated_as_its_scene() -> None:
    """And by the package's name for it, as often as one likes."""
    case = hs.load_case(CASES / "free_floating.yaml", {"duration": "20 s"})
    runs = [hs.simulate(case), hs.simulate(case.scene()), hs.simulate(case)]
    assert runs[0].attrs["status"] == "complete"
    assert all(np.array_equal(run.position, runs[0].position) for run in runs)


def test_progress_is_told_until_the_end() -> None:
    told: list[tuple[float, int]] = []
    scene = replace(scene_of("base"), duration=300.0)
    hs.simulate(scene, lambda time, steps: told.append((time, steps)))
    assert told == sorted(told)
    assert len(told) > 1
    assert told[-1] == (300.0, 3000)


def test_an_interrupted_run_keeps_what_it_has() -> None:
    scene = replace(scene_of("base"), duration=300.0)

    def stop(time: float, steps: int) -> None:
        if time > 1.0:  # a chunk has at most 100 times the steps of the one before
            raise KeyboardInterrupt

    part, whole = hs.simulate(scene, stop), hs.simulate(scene)
    assert part.attrs["status"] == "interrupted"
    assert 1.0 <= part.time[-1] < 300.0
    for name in part.data_vars:
        if "time" in part[name].dims:
            assert np.array_equal(part[name], whole[name].sel(time=part.time)), name


def moored(stiffness: float, solver: Solver) -> Scene:
    """The barge on an additional spring in heave, a little out of balance."""
    scene = in_waves(scene_of("free_floating"))
    spring = LinearMooring("barge", stiffness=np.diag([0.0, 0.0, stiffness, 0.0, 0.0, 0.0]))
    scene = with_body(scene, position=(0.0, 0.0, 0.01, 0.0, 0.0, 0.0))
    forces = {**scene.forces, "rigid_rod": spring}
    return replace(scene, forces=forces, solver=solver, duration=100.0)


def test_an_unstable_run_says_when_where_and_what_to_try() -> None:
    """w h = sqrt(1e12 / 3e8) 0.5 = 29, where the midpoint rule stands 2 at most."""
    with pytest.raises(hs.SimulationError) as caught:
        hs.simulate(moored(1e12, Solver(method=Method.RK2, step=0.5)))
    message, part = str(caught.value), caught.value.dataset
    for word in ("at t = ", " s ", "barge", "rigid_rod", "smaller solver.step"):
        assert word in message
    assert caught.value.exit_code == 3
    assert part.attrs["status"] == "failed"
    assert part.attrs["status_message"] == message
    assert 0.0 < part.time[-1] < 100.0
    assert np.isfinite(part.position).all()
    assert part.position.sel(dof="heave").values[0, 0] == 0.01


def test_a_barge_that_turns_over_is_an_error() -> None:
    moment = steady("barge", pitch=3e12)
    scene = in_waves(scene_of("free_floating"))
    with pytest.raises(hs.SimulationError, match="pitch of body barge is beyond 85 deg") as caught:
        hs.simulate(replace(scene, forces={**scene.forces, "push": moment}))
    assert np.isfinite(motion(caught.value.dataset)).all()


def test_inputs_that_do_not_fit_are_refused_before_anything_is_computed() -> None:
    scene = scene_of("base")
    shallow = replace(scene, environment=replace(scene.environment, water_depth=30.0))
    with pytest.raises(hs.InputError, match=r"(?s)h851.nc.*water_depth: found 30.*inf"):
        hs.simulate(shallow)
    part = replace(
        hull(),
        heading=hull().heading[:4],
        excitation=hull().excitation[:, :4],
        froude_krylov=None,
        mean_drift=None,
        mean_drift_held=None,
        drift_imbalance=None,
    )
    beam = in_waves(scene, WaveTrain(SEA, heading=np.radians(90.0)))
    first = with_body(beam, hydrodynamics=part, wave_forces=WaveForces(first_order=True))
    with pytest.raises(hs.InputError, match=r"heading 90 deg is not covered.*Change environment"):
        hs.simulate(first)
