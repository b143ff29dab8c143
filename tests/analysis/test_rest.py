"""Places at rest: closed forms, and where damped runs of the base case settle."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scenes import block, in_waves, motion, moving, on_floor, scene_of, steady

import hydrosim as hs
from hydrosim.analysis.response import at_rest
from hydrosim.elements import constant
from hydrosim.errors import InputError
from hydrosim.linear.equilibrium import RESIDUAL_RTOL
from hydrosim.scene import Body, ForceElement, Scene, SecondOrder, WaveForces

Figure = Callable[[str, float], None]
LIFT = 316.1e6  # N


def scene(body: Body, **forces: ForceElement) -> Scene:
    return Scene("at rest", 10.0, (body,), forces=forces)


def test_block_between_spring_and_floor() -> None:
    """k z = F above the floor; pressed into it the floor's springs share the load. The friction
    does not hold it where it starts."""
    sticky = hs.StickSlip(0.5, 0.4, 1e5, 1e3, 1e3)
    mooring = hs.LinearMooring("block", np.diag([300.0, 200.0, 1e3, 0.0, 0.0, 0.0]))
    for force, z in ((500.0, 0.5), (-2.1e4, -1.0)):
        load = steady(surge=30.0, heave=force)
        floor = on_floor(2e4, sticky)
        at = at_rest(
            scene(
                block(10.0, ["surge", "heave"], position=moving(surge=1.0, heave=0.2)),
                mooring=mooring,
                load=load,
                floor=floor,
            )
        )
        np.testing.assert_allclose(at.position[0, [0, 2]], [0.1, z], rtol=1e-9)
        assert at.residual <= RESIDUAL_RTOL


def test_pendulum_finds_the_vertical() -> None:
    """A body on a line: straight below the anchor, stretched by its weight, whatever the start."""
    line = hs.Spring("block", (0.3, 0.0, 0.1), (2.0, 1.0, 50.0), 40.0, 5e3)
    load = steady(heave=-981.0)
    body = block(100.0, position=moving(surge=-3.0, sway=2.0, heave=5.0, roll=0.2))
    at = at_rest(scene(body, line=line, load=load))
    x, y, z = at.position[0, :3]
    arm = np.hypot(0.3, 0.1)
    np.testing.assert_allclose([x, y], [2.0, 1.0], atol=1e-6)
    np.testing.assert_allclose(z, 50.0 - 40.0 - 981.0 / 5e3 - arm, rtol=1e-9)
    assert at.residual <= RESIDUAL_RTOL


def test_nothing_to_hold_it_is_refused() -> None:
    load = steady(surge=100.0)
    with pytest.raises(InputError, match=r"equilibrium at 0 s.*unbalanced force"):
        at_rest(scene(block(10.0, ["surge"]), load=load))


def smooth(case: Scene, **forces: ForceElement) -> Scene:
    """The base case without friction, calm, under a steady lift."""
    fender = case.forces["interface"]
    assert isinstance(fender, hs.Fender)
    interface = replace(fender, friction=hs.Frictionless())
    others = {"mooring": case.forces["mooring"], "interface": interface, **forces}
    return replace(in_waves(case), forces=others)


@pytest.mark.parametrize("push", [0.0, 2e5])
def test_base_case_under_its_lift(push: float, figure: Figure) -> None:
    """Residual, and where a damped run ends up. The slowest that decays is sway, as exp(-0.008 1/s
    t): what the lift gave it is down to 1e-8 after 2400 s. Nothing holds yaw, which is left out."""
    base = scene_of("base")
    full = at_rest(base, time=4100.0)
    figure("residual over the weight", full.residual)
    figure("heave at rest [m]", full.position[0, 2])
    assert full.residual <= 1e-9

    lift = hs.AppliedForce(
        "barge",
        (0.0, 0.0, 0.0),
        {"heave": constant(LIFT), "surge": constant(push), "sway": constant(0.5 * push)},
    )
    still = smooth(base, lift=lift)
    rest = at_rest(still)
    body = replace(still.bodies[0], position=tuple(0.98 * rest.position[0]))
    run = hs.simulate(replace(still, bodies=(body,), duration=2400.0))
    end = motion(run)[-1]
    error = np.abs(end - rest.position[0])[:5] / np.array([1.0, 1.0, 1.0, 0.01, 0.01])
    figure("distance from where a run settles [m, 0.01 rad]", error.max())
    assert error.max() < 1e-6
    if push == 0.0:
        np.testing.assert_allclose(rest.position, full.position, atol=1e-9)


def test_mean_drift_pushes_on_the_mooring() -> None:
    """The offset is the mean load over the stiffness, where the hull has none of its own."""
    case = scene_of("free_floating")
    drifting = replace(
        case,
        bodies=(replace(case.bodies[0], wave_forces=WaveForces(True, SecondOrder.NEWMAN)),),
        environment=scene_of("base").environment,
    )
    offset = at_rest(drifting, mean_drift=True).position - at_rest(drifting).position
    steady_load = SecondOrder.MEAN_DRIFT
    held = replace(
        drifting,
        duration=1.0,
        bodies=(replace(drifting.bodies[0], wave_forces=WaveForces(False, steady_load)),),
        environment=replace(
            drifting.environment,
            waves=tuple(replace(train, ramp=0.0) for train in drifting.environment.waves),
        ),
    )
    load = hs.simulate(held).force_wave_second_order.values[0, 0, 0]
    mooring = case.forces["mooring"]
    assert isinstance(mooring, hs.LinearMooring)
    assert offset[0, 0] == pytest.approx(load / mooring.stiffness[0, 0], rel=1e-6)
