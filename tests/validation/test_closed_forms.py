"""Whole runs against closed forms: Airy waves, a box in heave."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from hydrosim import simulate
from hydrosim.analysis.response import at_rest
from hydrosim.elements import AppliedForce, constant
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Body, Environment, RegularWave, Scene, Solver, WaveForces, WaveTrain

BOX = Path(__file__).parents[2] / "hydro_db" / "box.nc"
LENGTH, BEAM, DRAUGHT = 100.0, 20.0, 5.0
RHO, G = 1025.0, 9.81
MASS = RHO * LENGTH * BEAM * DRAUGHT
Validated = Callable[..., None]


def box(**changes: object) -> Body:
    inertia = MASS * np.diag([7.0**2, 26.0**2, 26.0**2])
    return Body("box", MASS, inertia, BOX, dofs=("heave",), **changes)


def test_box_sinks_by_the_weight_of_its_waterplane(validated: Validated) -> None:
    load = AppliedForce("box", (0.0, 0.0, 0.0), {"heave": constant(-1e7)})
    rest = at_rest(Scene("loaded box", 1.0, (box(),), forces={"load": load}))
    sinkage = 1e7 / (RHO * G * LENGTH * BEAM)
    error = abs(rest.position[0, 2] / -sinkage - 1.0)
    validated(  # the panels' waterplane, in single precision
        Kind.CLOSED_FORM, "box under a load, sinkage", "F/(ρgA)", error, 1e-6, Feature.STIFFNESS
    )


def test_long_waves_lift_a_box_with_them(validated: Validated) -> None:
    """A wave 30 times as long as the box carries it: heave over amplitude is one but for the
    Smith effect and the box's length, exp(-k T / 2) sinc(k L / 2), and inertia, all known to first
    order: 1 - k T / 2 - (k L)^2 / 24 + w^2 (m + a) / (rho g A), with what is left below 1 %."""
    period = 44.0
    k = (2 * np.pi / period) ** 2 / G
    train = WaveTrain(RegularWave(1.0, period), ramp=4 * period)
    scene = Scene(
        "box in a long wave",
        20 * period,
        (box(wave_forces=WaveForces()),),
        Environment(waves=(train,)),
        solver=Solver(step=0.22),
        output={"step": 1.1},
    )
    late = simulate(scene).sel(time=slice(10 * period, None))
    heave, eta = late.position.sel(dof="heave").values[:, 0], late.wave_elevation.values
    ratio = float(heave @ eta / (eta @ eta))
    claim = "box in a wave 30 times its length, heave over amplitude"
    features = (Feature.WAVES, Feature.RADIATION, Feature.STIFFNESS)
    validated(Kind.CLOSED_FORM, claim, "1", abs(ratio - 1.0), 0.012, *features)
    assert abs(ratio - 1.0) < 0.01 + (k * LENGTH) ** 2 / 24


def test_airy_wave(validated: Validated) -> None:
    """The elevation at the origin that a run records."""
    amplitude, period = 1.5, 11.0
    train = WaveTrain(RegularWave(amplitude, period, phase=0.3), heading=0.6)
    body = Body("block", 1.0, np.eye(3), dofs=("heave",))
    scene = Scene("wave", 30.0, (body,), Environment(water_depth=30.0, waves=(train,)))
    run = simulate(scene)
    w = 2 * np.pi / period
    exact = amplitude * np.cos(w * run.time.values + 0.3)
    error = np.abs(run.wave_elevation.values - exact).max() / amplitude
    validated(
        Kind.CLOSED_FORM, "Airy wave, elevation", "a cos(ωt + ε)", error, 1e-12, Feature.WAVES
    )
