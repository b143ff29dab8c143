"""What a run says of bodies that were not where their loads are for."""

from dataclasses import replace
from math import radians

import numpy as np
import pytest
import xarray as xr
from scenes import ROOT, SEA, block, in_waves, moving, scene, scene_of, with_body

import hydrosim as hs
from hydrosim.elements import CurrentLoad, LinearMooring
from hydrosim.scene import Kinematics, Place, SecondOrder, TankTable, Weight

SWELL = replace(SEA, peak_period=15.0)  # its loads are known between headings 15 deg apart


def abeam(place: Place, **changes: object) -> hs.Scene:
    """The barge without its mooring, in waves abeam."""
    scene = in_waves(
        scene_of("free_floating"), hs.WaveTrain(SWELL, heading=radians(90.0), ramp=20.0)
    )
    loads = hs.WaveForces(headings=place, position=place)
    return replace(with_body(scene, wave_forces=loads, **changes), forces={}, duration=100.0)


def said(run: xr.Dataset) -> str:
    return str(run.attrs.get("warnings", ""))


def test_a_yaw_that_changes_the_loads() -> None:
    """10 deg of yaw turn the loads of waves abeam by 17 % and more; followed, nothing is said."""
    turned = moving(yaw=radians(10.0))
    met = said(hs.simulate(abeam(Place.MEAN, position=turned)))
    assert "waves act on it at its heading at rest" in met
    assert "Set wave_forces.headings: slow" in met
    assert "heading at rest" not in said(hs.simulate(abeam(Place.SLOW, position=turned)))
    assert said(hs.simulate(abeam(Place.MEAN))) == ""


def test_second_order_loads_follow_the_slow_heading_unless_they_are_told_not_to() -> None:
    for place in (Place.SLOW, Place.MEAN):
        scene = abeam(place, position=moving(yaw=radians(40.0)))
        (body,) = scene.bodies
        loads = replace(body.wave_forces, first_order=False, second_order=SecondOrder.MEAN_DRIFT)
        words = said(hs.simulate(with_body(scene, wave_forces=loads)))
        assert ("second-order loads are computed for its heading at rest" in words) == (
            place == Place.MEAN
        )
        assert "waves act on it" not in words


def test_a_drift_through_the_waves() -> None:
    """0.4 m/s across waves of 15 s, 350 m long, is half a radian after 70 s."""
    scene = abeam(Place.MEAN, velocity=moving(sway=0.4), radiation="none")
    met = said(hs.simulate(scene))
    assert "of the waves' phase" in met
    assert "Set wave_forces.position: slow" in met


def test_coupled_bodies_that_come_apart() -> None:
    """Two barges that share a database, one of which drifts off."""
    (barge,) = scene_of("free_floating").bodies
    one, other = (
        replace(
            barge,
            name=name,
            hydrodynamics=ROOT / "hydro_db" / "two_barges.nc",
            database_body=k,
            centre_of_gravity=(0.0, y, 0.0),
            mass=1.23e6,
            inertia=np.diag(1.23e6 * np.square([3.5, 10.4, 10.4])),
            radiation="none",
            velocity=moving(surge=u),
        )
        for name, k, y, u in (("port", 1, 7.0, 0.2), ("starboard", 2, -7.0, 0.0))
    )
    scene = replace(abeam(Place.MEAN), bodies=(one, other), duration=20.0)
    scene = replace(scene, environment=hs.Environment())
    assert "waves between them for their places at rest, 14 m apart" in said(hs.simulate(scene))
    still = replace(scene, bodies=(replace(one, velocity=(0.0,) * 6), other))
    assert "coupled" not in said(hs.simulate(still))


@pytest.mark.parametrize(("roll", "warned"), [(12.0, True), (8.0, False)])
def test_angles_that_are_not_small(roll: float, warned: bool) -> None:
    scene = abeam(Place.MEAN, position=moving(roll=radians(roll)))
    small = replace(scene, solver=replace(scene.solver, kinematics=Kinematics.LINEAR))
    calm = replace(small, environment=hs.Environment())
    assert ("solver.kinematics: linear assumes small angles" in said(hs.simulate(calm))) == warned


def test_munks_moment_beside_coefficients_is_said() -> None:
    """With the figure to take from the coefficients: (A_surge - A_sway) / 2 of sin(2 a)."""
    load = CurrentLoad(
        "barge",
        point=(0.0, 0.0, 0.0),
        headings=np.radians([0.0, 90.0, 180.0, 270.0]),
        **{name: np.array([0.0, 1.0, 0.0, -1.0]) for name in ("surge", "sway", "yaw")},
    )
    scene = replace(abeam(Place.MEAN), environment=hs.Environment(current=hs.Stream(1.0, 0.3)))
    compiled = hs.compile_scene(replace(scene, forces={"current": load}))
    A = compiled.model.added_mass
    (line,) = (text for text in compiled.notes.meetings if "Munk" in text)
    assert f"{0.5 * (A[0, 0] - A[1, 1]):.3g} sin(2 a)" in line
    bare = hs.compile_scene(scene)
    assert all("coefficients" not in text for text in bare.notes.meetings)


@pytest.mark.parametrize(("level", "warned"), [(0.05, True), (1.5, False)])
def test_a_table_whose_surface_met_the_bottom_is_told(level: float, warned: bool) -> None:
    """A table of a box 2 x 4 x 3 m that heels by 0.2 rad: 0.05 m are less than 2 tan(0.2)."""
    levels = np.array([0.0, 1.0, 2.0, 3.0])
    centroid = np.stack([0.0 * levels, 0.0 * levels, 0.5 * levels], axis=1)
    surface = np.tile([2.0**3 * 4.0 / 12.0, 0.0, 2.0 * 4.0**3 / 12.0], (4, 1))
    table = TankTable(levels, 8.0 * levels, centroid, surface)
    body = block(2e4, weight=Weight.CARRIED, tanks=(hs.Tank("wing", table, level),))
    line = {"line": LinearMooring("block", np.diag([1e5, 1e5, 1e5, 1e6, 1e6, 1e6]))}
    run = hs.simulate(scene(replace(body, position=moving(roll=0.2)), line, 2.0, 0.1, step=0.01))
    words = (
        "bodies.block.tanks.wing: its free surface is modelled for upright walls, but met bottom"
    )
    assert (words in said(run)) == warned
