"""The reverse float-over cases hold the thesis' numbers, in SI."""

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from hydrosim import elements, scene
from hydrosim.case import load_case
from hydrosim.dofs import DOFS

CASES = Path(__file__).parents[2] / "cases" / "reverse_float_over"
TONNE_FORCE = 1000.0 * 9.81  # N, with the thesis' g


@pytest.fixture(scope="module")
def base(cases: Path) -> scene.Scene:
    return load_case(cases / "base.yaml").scene()


def test_waves_and_water(base: scene.Scene) -> None:
    sea = scene.Jonswap(significant_height=1.5, peak_period=8.0, peak_enhancement=3.3)
    train = scene.WaveTrain(sea, heading=0.0, seed=1, ramp=200.0, repeat_period=10800.0)
    assert base.environment == scene.Environment(math.inf, 1025.0, 9.81, (train,))
    solver = scene.Solver(unstable=scene.Unstable.ERROR)
    assert (base.duration, base.solver, base.output_step) == (2000.0, solver, 0.5)


def test_barge(base: scene.Scene, cases: Path) -> None:
    (barge,) = base.bodies
    assert isinstance(barge.hydrodynamics, Path)
    assert barge.hydrodynamics.resolve() == cases.parents[1] / "hydro_db" / "h851.nc"
    assert barge.mass == 1.56758e8
    assert barge.centre_of_gravity == (0.0, 0.0, 7.5 - 12.4)  # KG less draught
    radii = [0.35 * 63, 0.26 * 260, 0.265 * 260]
    assert_allclose(barge.inertia, barge.mass * np.diag(np.square(radii)), rtol=1e-12)
    assert barge.dofs == DOFS
    assert barge.wave_forces == scene.WaveForces(True, scene.SecondOrder.NEWMAN)


def test_mooring(base: scene.Scene) -> None:
    mooring = base.forces["mooring"]
    assert isinstance(mooring, elements.LinearMooring)
    assert_array_equal(mooring.stiffness, np.diag([392.4e3, 392.4e3, 0, 0, 0, 0]))
    assert_array_equal(mooring.damping_ratio, [0.2, 0.2, 0, 0, 0, 0])


def test_lift_table_c(base: scene.Scene) -> None:
    lift = base.forces["deballast"]
    assert isinstance(lift, elements.AppliedForce)
    assert (lift.point, lift.frame) == ((0.0, 0.0, 0.0), "earth")
    assert list(lift.force) == ["heave"]
    time, force = lift.force["heave"].time, lift.force["heave"].value
    assert_array_equal(time, [0, 500, 4100])
    assert_array_equal(force, [0, 119.9e6, 316.1e6])
    rate = (force[2] - force[1]) / (time[2] - time[1])
    assert rate == pytest.approx(20000 * TONNE_FORCE / 3600, rel=1e-12)  # 20 000 t/h


def test_interface(base: scene.Scene) -> None:
    interface = base.forces["interface"]
    assert isinstance(interface, elements.Fender)
    (barge,) = base.bodies
    assert_array_equal(np.abs(interface.points[:, :2]), np.full((4, 2), 20.0))
    deck = barge.centre_of_gravity[2] + interface.points[:, 2]
    assert_allclose(deck, 15 - 12.4, rtol=1e-12)  # depth less draught
    assert_allclose(interface.plane.point[2] - deck, 1.0, rtol=1e-12)  # the air gap
    assert interface.plane.normal == (0.0, 0.0, -1.0)
    slope = np.diff(interface.normal.force) / np.diff(interface.normal.compression)
    assert_allclose(4 * slope, 20000 * TONNE_FORCE / 0.5, rtol=1e-12)  # 20 000 t per 0.5 m
    assert interface.friction == elements.StickSlip(0.2, 0.1, 5.6e8 / 4, 3.3e7 / 4, 1e6 / 4)


def test_no_friction_differs_in_friction_only(base: scene.Scene, cases: Path) -> None:
    slippery = load_case(cases / "no_friction.yaml").scene()
    assert slippery.forces["interface"].friction == elements.Frictionless()
    assert list(slippery.forces) == list(base.forces)
    assert slippery.environment == base.environment
    points = (s.forces["interface"].normal.force for s in (slippery, base))
    assert_array_equal(*points)


def test_free_floating_is_moored_in_the_same_sea(base: scene.Scene, cases: Path) -> None:
    free = load_case(cases / "free_floating.yaml").scene()
    assert list(free.forces) == ["mooring"]
    assert free.environment == base.environment
    assert free.bodies[0].mass == base.bodies[0].mass


@pytest.mark.parametrize("name", ["base", "no_friction", "free_floating"])
def test_the_recorded_text_is_the_whole_case(name: str, cases: Path) -> None:
    case = load_case(cases / f"{name}.yaml", ["environment.waves.seed=3"])
    again = cases / f"again_{name}.yaml"
    again.write_text(case.text)
    assert load_case(again).data == case.data
    assert case.scene().environment.waves[0].seed == 3


def test_the_cases_find_their_database() -> None:
    if not (CASES.parents[1] / "hydro_db" / "h851.nc").is_file():
        pytest.skip("hydro_db/h851.nc has not been built")
    for path in CASES.glob("*.yaml"):
        load_case(path)
