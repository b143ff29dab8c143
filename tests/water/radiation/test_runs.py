"""Whole runs with memory by states, by convolution and without: against exact solutions, each
other, and themselves at finer steps."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from closed_forms import DECAY, FREQUENCY, INFINITE, added_mass, transfer
from scenes import SEA, in_contact, in_waves, motion, scene_of, with_body
from scipy.linalg import expm

import hydrosim as hs
from hydrosim.compile.compile import compile_for_linear
from hydrosim.compile.compiled import Compiled
from hydrosim.database import HydroDatabase
from hydrosim.linear.linearise import linearise
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import (
    ConstantRadiation,
    ConvolutionRadiation,
    LinearScenes,
    Method,
    Radiation,
    StateSpaceRadiation,
)

Figure = Callable[[str, float], None]
DOFS = ("surge", "sway", "heave", "roll", "pitch", "yaw")
UNIT = 1.5e5  # kg: of added mass; K and B are as large per second
MASS, STIFFNESS = 1e6, 1.1e6
SHALLOW = Path(__file__).parents[3] / "hydro_db" / "h851_50m.nc"
HEAVE = 2


def heaving() -> HydroDatabase:
    """Heave alone, with the added mass and damping of the closed form."""
    w = 0.01 * np.arange(1, 1501)
    A, B = np.zeros((2, w.size, 6, 6))
    A[:, HEAVE, HEAVE] = UNIT * added_mass(w)[:, 0, 0]
    B[:, HEAVE, HEAVE] = UNIT * transfer(w)[:, 0, 0].real
    stiffness = np.zeros((6, 6))
    stiffness[HEAVE, HEAVE] = STIFFNESS
    excitation = np.zeros((w.size, 2, 6), dtype=complex)
    excitation[:, :, HEAVE] = 1e5
    return HydroDatabase(
        source="closed form",
        frequency=w,
        heading=np.array([0.0, np.pi]),
        added_mass=A,
        radiation_damping=B,
        excitation=excitation,
        reference_point=np.zeros((1, 3)),
        water_depth=np.inf,
        water_density=1025.0,
        gravity=9.81,
        port_starboard_symmetric=True,
        hydrostatic_stiffness=stiffness,
        volume=np.array([MASS / 1025.0]),
        centre_of_gravity=np.zeros((1, 3)),
        centre_of_buoyancy=np.zeros((1, 3)),
        attributes={"accepted": "size of the heave load in long waves"},
    )


def decay(radiation: Radiation | str, step: float, **solver: Any) -> hs.Scene:
    """Free decay in heave from 1 m."""
    body = hs.Body(
        "buoy",
        MASS,
        MASS * np.eye(3),
        hydrodynamics=heaving(),
        dofs=("heave",),
        position=(0.0, 0.0, 1.0, 0.0, 0.0, 0.0),
        radiation=radiation,
    )
    settings = hs.Solver(**{"step": step, "linear": LinearScenes.STEP, **solver})
    return hs.Scene("decay", 32.0, (body,), hs.Environment(), solver=settings, output={"step": 0.8})


def exact_decay(time: np.ndarray) -> np.ndarray:
    """(m + A_inf) z'' + C z + R x' = 0 with x'' + 2 a x' + (a^2 + b^2) x = z'."""
    mass = MASS + UNIT * INFINITE
    J = np.zeros((4, 4))  # of z, z', x, x'
    J[0, 1] = 1.0
    J[1, 0], J[1, 3] = -STIFFNESS / mass, -UNIT / mass
    J[2, 3] = 1.0
    J[3, 1], J[3, 2], J[3, 3] = 1.0, -(DECAY**2 + FREQUENCY**2), -2.0 * DECAY
    return np.array([(expm(J * t) @ [1.0, 0.0, 0.0, 0.0])[0] for t in time])


LENGTH, STEP = 40.0, 0.05  # s
CONVOLUTION = ConvolutionRadiation(LENGTH, STEP)
STATES = StateSpaceRadiation(1e-4, LENGTH, STEP)


def errors(scenes: list[hs.Scene], reference: np.ndarray) -> np.ndarray:
    return np.array([np.abs(motion(hs.simulate(s)) - reference).max() for s in scenes])


@pytest.mark.kernels
@pytest.mark.parametrize("method", [Method.RK4, Method.HEUN, Method.DOPRI5, Method.ESDIRK4])
@pytest.mark.parametrize("radiation", [CONVOLUTION, STATES])
def test_decay_is_that_of_the_exact_linear_system(
    radiation: Radiation, method: Method, validated: Callable[..., None]
) -> None:
    """K and A_inf are known to 1e-4 from frequencies 0.01 rad/s apart and a table of 0.05 s."""
    run = hs.simulate(decay(radiation, 0.1 if method != Method.HEUN else 0.02, method=method))
    error = np.abs(motion(run)[:, HEAVE] - exact_decay(run.time.values)).max()
    claim = "decay with memory, as states and as an integral, four methods [m]"
    against = "linear system with a known kernel"
    validated(Kind.CLOSED_FORM, claim, against, error, 5e-4, Feature.RADIATION)


def test_order_in_the_step_of_a_decay(figure: Figure) -> None:
    """At fixed kernels, against steps of 0.0125 s: both are of order 4."""
    steps = (0.4, 0.2, 0.1)
    for radiation in (CONVOLUTION, STATES):
        finest = motion(hs.simulate(decay(radiation, 0.0125)))
        error = errors([decay(radiation, step) for step in steps], finest)
        order = np.log2(error[:-1] / error[1:])
        figure(f"{type(radiation).__name__}: error at 0.1 s [m]", error[-1])
        figure(f"{type(radiation).__name__}: observed order", order[-1])
        assert order.min() > 3.5


def with_radiation(scene: hs.Scene, radiation: Radiation | str, step: float) -> hs.Scene:
    return replace(with_body(scene, radiation=radiation), solver=hs.Solver(step=step)).with_output(
        step=0.8
    )


def oblique() -> hs.Scene:
    """The free barge in a regular wave at 30 deg, all six motions, from another place than rest."""
    wave = hs.WaveTrain(hs.RegularWave(1.0, 9.0), heading=np.radians(30.0), ramp=16.0)
    scene = in_waves(scene_of("free_floating"), wave)
    return with_body(replace(scene, duration=64.0), position=(0.0, 0.0, 0.5, 0.05, 0.02, 0.0))


def test_order_in_the_step_of_the_barge_in_a_regular_wave(figure: Figure) -> None:
    reference = motion(hs.simulate(with_radiation(oblique(), "convolution", 0.05)))
    steps = (0.8, 0.4, 0.2)
    scenes = [with_radiation(oblique(), "convolution", step) for step in steps]
    error = np.array([np.abs(motion(hs.simulate(s)) - reference).max(axis=0) for s in scenes])
    order = np.log2(error[:-1] / error[1:])
    for i, dof in enumerate(DOFS):
        figure(f"{dof}: observed order", order[-1, i])
    assert order[-1].min() > 3.0
    assert np.median(order[-1]) > 3.6


def test_order_in_the_step_through_contact(figure: Figure) -> None:
    """Steps are cut at events, where the history has two nodes at one time."""
    steps = (0.05, 0.025, 0.0125)
    runs = [
        motion(hs.simulate(with_radiation(in_contact(40.0), "convolution", step)))
        for step in (*steps, steps[-1] / 2)
    ]
    error = np.array([np.abs(run - runs[-1]).max() for run in runs[:-1]])
    order = np.log2(error[:-1] / error[1:])
    figure("error at 0.05 s [m]", error[0])
    figure("observed order", order[-1])
    assert order[-1] > 3.0


def test_state_space_agrees_with_convolution_on_the_base_case(
    figure: Figure, validated: Callable[..., None]
) -> None:
    """Until 700 s, 170 s after the first contact: 1e-3 of the standard deviation."""
    runs = [
        hs.simulate(replace(with_body(scene_of("base"), radiation=radiation), duration=700.0))
        for radiation in ("state_space", "convolution")
    ]
    fitted, direct = (motion(run)[:, [0, 2, 4]] for run in runs)
    difference = (fitted - direct).std(axis=0) / direct.std(axis=0)
    print(runs[0].attrs["radiation_barge"])
    for dof, value in zip(("surge", "heave", "pitch"), difference, strict=True):
        figure(f"{dof}: difference over standard deviation", value)
    figure("run time by states [s]", runs[0].attrs["wall_time"])
    figure("run time by convolution [s]", runs[1].attrs["wall_time"])
    assert (runs[0].fender_mode > 0).any()
    claim = "base case to 700 s, radiation as states, of the standard deviation"
    features = (Feature.RADIATION, Feature.FENDERS)
    validated(Kind.SELF, claim, "memory integral", difference.max(), 1e-3, *features)


def test_state_space_agrees_with_convolution_in_all_six_motions(figure: Figure) -> None:
    sea = hs.WaveTrain(SEA, heading=np.radians(30.0), ramp=20.0)
    scene = replace(in_waves(scene_of("free_floating"), sea), duration=200.0)
    fitted, direct = (
        motion(hs.simulate(with_body(scene, radiation=radiation)))
        for radiation in ("state_space", "convolution")
    )
    difference = (fitted - direct).std(axis=0) / direct.std(axis=0)
    for dof, value in zip(DOFS, difference, strict=True):
        figure(f"{dof}: difference over standard deviation", value)
    assert difference[[0, 2, 3, 4]].max() < 1e-3
    assert difference[[1, 5]].max() < 5e-3  # hardly held or not at all, so that errors add up


def test_constant_radiation_is_the_frequency_domain_at_its_period(figure: Figure) -> None:
    """Amplitude in a regular wave of that period, against |X| / |C - w^2 (m + A) + i w B|; and what
    radiation takes is what the waves put in."""
    period = 7.0
    w = 2.0 * np.pi / period
    scene = decay(ConstantRadiation(period), 0.1)
    waves = hs.Environment(waves=(hs.WaveTrain(hs.RegularWave(1.0, period), ramp=14.0),))
    run = hs.simulate(replace(scene, environment=waves, duration=280.0).with_output(step=0.1))
    A = UNIT * np.interp(w, *_table(added_mass))
    B = UNIT * np.interp(w, *_table(lambda w: transfer(w).real))
    expected = 1e5 / abs(STIFFNESS - w * w * (MASS + A) + 1j * w * B)
    last = motion(run.sel(time=slice(210.0, None)))[:, HEAVE]
    figure("amplitude over that of the frequency domain, less 1", np.ptp(last) / 2 / expected - 1)
    assert np.ptp(last) / 2 == pytest.approx(expected, rel=1e-3)
    assert run.attrs["energy_residual_relative"] < 1e-6
    lost = run.energy_dissipated_radiation
    force, v = run.force_radiation.values[:, 0, HEAVE], run.velocity.values[:, 0, HEAVE]
    assert force == pytest.approx(-B * v)
    assert float(lost[-1] - lost[0]) == pytest.approx(np.trapezoid(B * v * v, run.time), rel=1e-4)
    assert "damping at 7 s" in run.attrs["radiation_buoy"]


def _table(function: Callable[[np.ndarray], np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    w = heaving().frequency
    return w, function(w)[:, 0, 0]


def test_no_radiation_keeps_the_energy_of_a_decay() -> None:
    run = hs.simulate(decay("none", 0.05))
    natural = np.sqrt(STIFFNESS / (MASS + UNIT * INFINITE))
    assert motion(run)[:, HEAVE] == pytest.approx(np.cos(natural * run.time.values), abs=1e-3)


def test_a_period_outside_the_database_is_refused() -> None:
    for period in (0.3, 1000.0):
        with pytest.raises(hs.InputError, match=r"buoy.radiation.period: found .* 0.419 to 628 s"):
            hs.simulate(decay(ConstantRadiation(period), 0.1))


def test_linearised_constant_radiation_has_its_damping() -> None:
    model, state = hs.compile_scene(decay(ConstantRadiation(7.0), 0.1))
    w = 1.3
    B = UNIT * np.interp(2.0 * np.pi / 7.0, *_table(lambda w: transfer(w).real))
    stiffness = linearise(model, state).dynamic_stiffness(w)
    assert stiffness[0, 0].imag == pytest.approx(w * B)


def in_shallow_water(radiation: Radiation | str) -> hs.Scene:
    """The moored barge in 50 m of water, whose damping is jagged above 1.6 rad/s."""
    scene = in_waves(scene_of("free_floating"), hs.WaveTrain(SEA))
    scene = with_body(scene, hydrodynamics=SHALLOW, radiation=radiation)
    water = replace(scene.environment, water_depth=50.0)
    return replace(scene, environment=water, duration=60.0)


def test_a_group_that_no_fit_is_near_is_convolved_where_states_are_asked_for() -> None:
    """Surge, heave and pitch move as convolved, and the run says why. How near the nearest fit is
    depends on the machine's linear algebra."""
    run = hs.simulate(in_shallow_water(StateSpaceRadiation(tolerance=1e-4, length=20.0)))
    convolved = hs.simulate(in_shallow_water(ConvolutionRadiation(length=20.0)))
    said = run.attrs["radiation_barge"]
    assert "convolution over the last 20 s, retardation functions every 0.1 s" in said
    assert "for surge, heave, pitch of barge" in said
    assert "no passive state-space model within 0.0001 was found; the nearest has an" in said
    assert motion(run)[:, [0, 2, 4]] == pytest.approx(motion(convolved)[:, [0, 2, 4]], abs=1e-12)


def test_a_tolerance_that_a_fit_holds_takes_states() -> None:
    """Its motions are those of the convolution within that."""
    run = hs.simulate(in_shallow_water(StateSpaceRadiation(tolerance=4e-3)))
    convolved = hs.simulate(in_shallow_water("convolution"))
    assert "convolution" not in run.attrs["radiation_barge"]
    apart = np.abs(motion(run) - motion(convolved)).max(axis=0)
    assert np.all(apart <= 4e-3 * np.abs(motion(convolved)).max(axis=0))


def test_what_is_convolved_of_states_can_be_made_linear() -> None:
    """By states all the same, as of a scene with a convolution."""
    scenes = map(in_shallow_water, ("state_space", "convolution"))
    periods = [heave_period(compile_for_linear(scene)) for scene in scenes]
    assert periods[0] == pytest.approx(periods[1], rel=1e-12)


def heave_period(calm: Compiled) -> float:
    modes = hs.natural_modes(linearise(calm.model, calm.state))
    (mode,) = (mode for mode in modes if mode.dof == "heave")
    return mode.natural_period
