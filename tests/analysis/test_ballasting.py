"""Loading conditions against hydrostatics by hand, and plans against all of their corners."""

from collections.abc import Callable
from dataclasses import replace
from itertools import combinations, product

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scenes import scene_of, steady, with_body
from scipy.optimize import root

import hydrosim as hs
from hydrosim.analysis.ballast import conditions, find_pump_plan
from hydrosim.analysis.seakeeping import LinearRequest, linear_analysis
from hydrosim.compile.compile import compile_in_calm
from hydrosim.compile.compiled import Compiled
from hydrosim.elements import LinearMooring
from hydrosim.errors import InputError
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Box, FreeSurface, Pump, Tank, TankTable, Weight

G, DENSITY, LEVEL = 9.81, 1025.0, 9.0
LOW, HIGH = -12.0, 2.0
PLACES = {  # x and y of opposite corners
    "fore_ps": ((10.0, 1.0), (70.0, 28.0)),
    "fore_sb": ((10.0, -28.0), (70.0, -1.0)),
    "aft_ps": ((-75.0, 1.0), (-10.0, 25.0)),
    "aft_sb": ((-70.0, -28.0), (-10.0, -1.0)),
}


def barge(*pumps: Pump, surface: FreeSurface = FreeSurface.QUASI_STATIC) -> hs.Scene:
    """H-851 in calm water with four tanks."""
    tanks = tuple(
        Tank(name, Box((*a, LOW), (*b, HIGH)), LEVEL, DENSITY, surface)
        for name, (a, b) in PLACES.items()
    )
    base = with_body(scene_of("free_floating"), tanks=tanks, pumps=pumps, weight=Weight.CARRIED)
    calm = replace(base.environment, waves=())
    return replace(base, environment=calm, duration=3600.0)


def out(rate: float = 6e6 / 3600, **rates: float) -> list[Pump]:
    """A pump out of each tank."""
    return [Pump(name, rates.get(name, rate), name, None) for name in PLACES]


@pytest.mark.parametrize("surface", FreeSurface)
def test_trim_and_heel_are_those_of_hydrostatics_by_hand(
    surface: FreeSurface, validated: Callable[..., None]
) -> None:
    """4000 t from fore to aft and 1500 t to the other side: where the potential of weight, linear
    buoyancy and free surfaces, written down here, is stationary."""
    pumps = (
        Pump("trim", 4e6 / 3600, "fore_ps", "aft_ps", stop=3600.0),
        Pump("heel", 1.5e6 / 3600, "aft_ps", "aft_sb", stop=3600.0),
    )
    scene = barge(*pumps, surface=surface)
    (found,) = conditions(compile_in_calm(scene), 3600.0)
    moved = {"fore_ps": -4e6, "aft_ps": 2.5e6, "aft_sb": 1.5e6}
    body, compiled = scene.bodies[0], compile_in_calm(scene)
    C, mass = compiled.model.stiffness[0][2:5, 2:5], body.mass
    db, moment, free = body.hydrodynamics, np.zeros(3), np.zeros(2)
    buoyancy = db.water_density * db.gravity * db.volume[0]
    for name, (a, b) in PLACES.items():
        (long, wide), middle = np.subtract(b, a), 0.5 * np.add(a, b)
        before, level = LEVEL, LEVEL + moved.get(name, 0.0) / (DENSITY * long * wide)
        for sign, h in ((-1.0, before), (1.0, level)):
            centre = np.array([*middle, LOW + 0.5 * h]) - body.centre_of_gravity
            moment += sign * DENSITY * long * wide * h * centre
        if surface == FreeSurface.QUASI_STATIC:
            free += DENSITY * np.array([long**3 * wide, long * wide**3]) / 12.0

    def slope(q: np.ndarray) -> np.ndarray:
        _, phi, theta = q
        s, c, S, T = np.sin(phi), np.cos(phi), np.sin(theta), np.cos(theta)
        n = np.array([-S, T * s, T * c])
        by = np.array([[0.0, T * c, -T * s], [-T, -S * s, -S * c]])  # dn/dphi, dn/dtheta
        square = free @ n[:2] ** 2
        slopes = moment - np.array([free[0] * n[0], free[1] * n[1], 0.0]) / n[2]
        slopes[2] += 0.5 * square / n[2] ** 2
        return C @ q + [mass * G - buoyancy, *(G * by @ slopes)]

    scale = np.array([1e8, 1e10, 1e11])
    exact = root(lambda q: slope(q) / scale, np.zeros(3), tol=1e-14).x
    assert np.abs(exact[1:]).min() > 1e-3
    error = np.abs(found.position[2:5] - exact).max() / np.abs(exact).max()
    claim = "trim and heel of a ballasted barge"
    validated(Kind.INDEPENDENT, claim, "hydrostatics by hand", error, 1e-9, Feature.TANKS)


def test_free_surfaces_take_their_moments_from_the_metacentric_heights() -> None:
    """rho i / displacement, in what is told and in the heights (differences of fourth order)."""
    heights = {}
    for surface in FreeSurface:
        (heights[surface],) = conditions(compile_in_calm(barge(surface=surface)))
    sizes = [np.subtract(b, a) for a, b in PLACES.values()]
    i = np.array([sum(a * b**3 for a, b in sizes), sum(a**3 * b for a, b in sizes)]) / 12.0
    loss = DENSITY * i / heights[FreeSurface.FROZEN].loading.mass
    assert_allclose(heights[FreeSurface.QUASI_STATIC].loss, loss, rtol=1e-12)
    assert not heights[FreeSurface.FROZEN].loss.any()
    frozen, free = (heights[x].metacentric for x in (FreeSurface.FROZEN, FreeSurface.QUASI_STATIC))
    assert_allclose(frozen - free, loss, rtol=1e-9)


def test_metacentric_heights_are_those_of_weight_and_buoyancy_whatever_holds_the_barge() -> None:
    """K / (m g) of the database's stiffness with the free surfaces' loss; lines come on top."""
    roll, pitch = 2e9, 7e9
    line = LinearMooring("barge", np.diag([0.0, 0.0, 0.0, roll, pitch, 0.0]))
    scene = barge()
    compiled = compile_in_calm(replace(scene, forces={**scene.forces, "line": line}))
    (found,), (alone,) = conditions(compiled), conditions(compile_in_calm(scene))
    C, weight = compiled.model.stiffness[0], found.loading.mass * G
    floating = np.diag(C)[3:5] - C[2, 3:5] ** 2 / C[2, 2]
    assert_allclose(found.metacentric, floating / weight - found.loss, rtol=1e-6)
    assert_allclose(found.metacentric, alone.metacentric, rtol=1e-9)
    held = np.array([roll, pitch]) / weight
    assert_allclose(found.held - found.metacentric, held, rtol=1e-6)


def corners(compiled: Compiled, lift: float, most: np.ndarray) -> float:
    """The least that must be pumped, by all corners of the polyhedron."""
    body, C = compiled.scene.bodies[0], compiled.model.stiffness[0]
    flotation = np.array([-C[4, 2], C[3, 2]]) / C[2, 2]
    middle = [
        0.5 * np.add(a, b) - body.centre_of_gravity[:2] - flotation for a, b in PLACES.values()
    ]
    A, b = np.vstack([np.ones(4), np.transpose(middle)]), np.array([lift / G, 0.0, 0.0])
    best = np.inf
    for free in combinations(range(4), 3):
        (held,) = {*range(4)} - {*free}
        for value in (0.0, most[held]):
            x = np.zeros(4)
            x[held] = value
            x[[*free]] = np.linalg.solve(A[:, free], b - A[:, held] * value)
            if np.all(x >= -1e-6) and np.all(x <= most + 1e-6):
                best = min(best, x.sum())
    return best


@pytest.mark.parametrize(("lift", "uneven"), [*product((60e6, 196.2e6), (False, True))])
def test_a_plan_is_the_best_corner_and_keeps_level_keel(lift: float, uneven: bool) -> None:
    pumps = out(aft_sb=5e6 / 3600) if uneven else out()
    compiled = compile_in_calm(barge(*pumps))
    found = find_pump_plan(compiled, "barge", 3600.0, lift)
    most = np.array([pump.rate * 3600.0 for pump in pumps])
    assert found.mass.sum() == pytest.approx(corners(compiled, lift, most), rel=1e-6)
    assert found.mass.sum() == pytest.approx(lift / G, rel=1e-6)
    assert np.all(found.rate <= [pump.rate * (1.0 + 1e-9) for pump in pumps])
    assert np.abs(found.position[0, 3:5]).max() <= 1e-6


def test_a_plan_for_a_rise_ends_at_that_height() -> None:
    found = find_pump_plan(compile_in_calm(barge(*out())), "barge", 3600.0, rise=0.5)
    start = conditions(compile_in_calm(barge(*out())))[0].position
    assert found.position[0, 2] - start[2] == pytest.approx(0.5, abs=1e-6)
    assert np.abs(found.position[0, 3:5]).max() <= 1e-6


def test_a_plan_that_cannot_be_met_says_what_limits_it() -> None:
    """Of 40,000 t in an hour 24,000 t at most; then in ten hours more than the tanks hold."""
    compiled = compile_in_calm(barge(*out()))
    with pytest.raises(InputError, match=r"at most 5\d\.\d% of this .* t/hour for 3600 s\)"):
        find_pump_plan(compiled, "barge", 3600.0, 40e6 * G)
    with pytest.raises(InputError, match=r"limited by .*aft_.* of barge empty"):
        find_pump_plan(compiled, "barge", 36000.0, 70e6 * G)
    with pytest.raises(InputError, match="cannot do any of this"):
        find_pump_plan(compiled, "barge", 3600.0, -1e6)


def test_periods_are_those_of_the_mass_at_the_time() -> None:
    """Of heave: at the end of pumping that of the barge that has this mass from the start."""
    table = TankTable(
        np.array([0.0, 20.0]),
        np.array([0.0, 4e4]),
        np.tile(scene_of("base").bodies[0].centre_of_gravity, (2, 1)),
        np.zeros((2, 3)),
    )
    tank = Tank("hold", table, 19.0, DENSITY, FreeSurface.FROZEN)
    pump = Pump("out", 2e7 / 3600, "hold", None, stop=3600.0)
    base = barge()
    scene = with_body(base, tanks=(tank,), pumps=(pump,))
    lighter = with_body(base, tanks=(), mass=base.bodies[0].mass - 2e7)
    periods = [
        linear_analysis(each, LinearRequest(time)).natural_period.sel(mode="barge heave").item()
        for each, time in ((scene, 3600.0), (lighter, 0.0), (scene, 0.0))
    ]
    assert periods[0] == pytest.approx(periods[1], rel=1e-6)
    assert periods[2] > periods[0] * 1.01


def shallow(level: float = 0.5) -> hs.Scene:
    """H-851 with a tank 100 x 54 x 14 m, full up to a level."""
    tank = Tank("mid", Box((-50.0, -27.0, LOW), (50.0, 27.0, HIGH)), level, DENSITY)
    return with_body(barge(), tanks=(tank,))


@pytest.mark.parametrize("level", [1e-3, 1e-5])
def test_heights_are_slopes_at_rest_however_soon_a_surface_meets_the_bottom(
    level: float,
) -> None:
    """At 0.002 deg of heel, with 1 mm: what is told to be taken is what is taken of both."""
    line = LinearMooring("barge", np.diag([0.0, 0.0, 0.0, 2e9, 7e9, 0.0]))
    scene = shallow(level)
    (tank,) = scene.bodies[0].tanks
    frozen = with_body(scene, tanks=(replace(tank, free_surface=FreeSurface.FROZEN),))
    (free,), (solid,) = (
        conditions(compile_in_calm(replace(each, forces={**each.forces, "line": line})))
        for each in (scene, frozen)
    )
    assert free.loss[0] > 8.0
    assert_allclose(solid.metacentric - free.metacentric, free.loss, rtol=1e-6)
    assert_allclose(solid.held - free.held, free.loss, rtol=1e-4)


@pytest.mark.parametrize("heel", np.radians([0.5, 5.0, 12.0]))
def test_at_a_heel_a_shallow_tank_takes_what_its_wedge_does(heel: float) -> None:
    """Between upright walls at 0.5 deg; beyond 1.06 deg the fluid is a triangle of b = (2 A / tan
    phi)^(1/2), A = 27 m^2, against the wall: the lever from the middle of the level tank."""
    (found,) = conditions(compile_in_calm(shallow()), heel=heel)
    i, A, tan = 100.0 * 54.0**3 / 12.0, 27.0, np.tan(heel)
    assert found.loss[0] == pytest.approx(DENSITY * i / found.loading.mass, rel=1e-12)
    assert np.tan(found.tanks[0].reach) == pytest.approx([0.5 / 27.0, 0.5 / 50.0], rel=1e-12)
    if tan < 0.5 / 27.0:
        lever = i * np.sin(heel) * (1.0 + 0.5 * tan**2)
    else:
        b = np.sqrt(2.0 * A / tan)
        aside, up = 27.0 - b / 3.0, b * tan / 3.0 - 0.25
        lever = 100.0 * A * (aside * np.cos(heel) + up * np.sin(heel))
    expected = DENSITY * lever / np.sin(heel) / found.loading.mass
    assert found.secant == pytest.approx(expected, rel=1e-9)


def test_at_rest_with_a_list_a_surface_takes_what_it_does_as_it_lies() -> None:
    """Under a moment that heels it: the loss is the second moment of the wedge's surface there,
    b / cos phi wide."""
    scene = shallow()
    heeling = steady("barge", roll=1.6e9)
    scene = replace(scene, forces={**scene.forces, "heeling": heeling})
    (found,) = conditions(compile_in_calm(scene))
    phi = abs(found.position[3])
    assert np.degrees(phi) > 2.0
    wide = np.sqrt(2.0 * 27.0 / np.tan(phi)) / np.cos(phi)
    expected = DENSITY * 100.0 * wide**3 / 12.0 / found.loading.mass
    assert found.loss[0] == pytest.approx(expected, rel=1e-6)


def test_a_response_beyond_what_a_surface_is_free_to_is_remarked() -> None:
    still = shallow(0.05)
    calm, base = linear_analysis(still, LinearRequest()), scene_of("free_floating")
    assert "free surface" not in calm.attrs["remarks"]
    found = linear_analysis(replace(still, environment=base.environment), LinearRequest())
    assert "the free surface in mid of barge is taken as at rest" in found.attrs["remarks"]
    assert "at a trim of 0.057 deg" in found.attrs["remarks"]
