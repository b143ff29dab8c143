"""Tanks together with what else a scene may have: families of databases, convolution, rigid
friction."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose
from scenes import block, moving, on_floor, steady
from scenes import scene as dry_scene

import hydrosim as hs
from hydrosim.database.build.barge import box
from hydrosim.database.build.recipe import barge_with_deck
from hydrosim.elements import Coulomb, LinearDamping
from hydrosim.errors import InputError
from hydrosim.scene import (
    AtDraught,
    Box,
    ConvolutionRadiation,
    Family,
    Hull,
    Question,
    StateSpaceRadiation,
    Weight,
)

DATA = Path(__file__).parents[1] / "data" / "draughts"
FAMILY = Family((AtDraught(4.4, DATA / "4m4.nc"), AtDraught(3.6, DATA / "3m6.nc")))
ALONE = DATA / "4m.nc"
AREA, G, DENSITY = 60.0 * 20.0, 9.81, 1025.0
RATE = DENSITY * AREA * 0.6 / 100.0  # kg/s: 0.6 m of draught in 100 s

pytestmark = pytest.mark.filterwarnings("ignore")  # of coarse databases


def barge(source: Any, draught: float, **changes: Any) -> hs.Body:
    """A box of 60 x 20 x 8 m at a draught, with a tank amidships that is pumped out."""
    mass = DENSITY * AREA * draught
    tank = hs.Tank(
        "hold", Box((-15.0, -8.0, 0.5 - draught), (15.0, 8.0, 6.5 - draught)), 2.5, DENSITY
    )
    body = hs.Body(
        "barge",
        mass,
        mass * np.diag([7.0, 16.0, 16.0]) ** 2,
        hydrodynamics=source,
        hydrostatics=Hull(barge_with_deck(box(60.0, 20.0, draught), 8.0)),
        centre_of_gravity=(0.0, 0.0, 4.0 - draught),
        weight=Weight.CARRIED,
        radiation=StateSpaceRadiation(3e-3),
        tanks=(tank,),
        pumps=(hs.Pump("out", RATE, "hold", None, 5.0, 105.0),),
    )
    return replace(body, **changes)


def afloat(body: hs.Body, duration: float, step: float = 0.1, **changes: Any) -> hs.Scene:
    """It in still water, with some damping in heave and pitch."""
    damping = LinearDamping("barge", np.diag([0, 0, 3e6, 5e7, 1e9, 0.0]))
    still = hs.Scene("tanks", duration, (body,), solver=hs.Solver(step=step), output={"step": 0.5})
    return replace(still, forces={"damping": damping}, **changes).with_output(states=True)


def same_later(whole: xr.Dataset, later: xr.Dataset) -> None:
    rest = whole.sel(time=slice(float(later.time[0]), None))
    for name in ("position", "velocity", "tank_level", "force_radiation", "force_ballast"):
        assert np.array_equal(rest[name].values, later[name].values), name


def test_a_barge_with_a_family_rises_by_what_is_pumped_and_its_ledger_closes() -> None:
    """0.6 m of draught are pumped: it ends as much higher, its slow draught with it; the residual
    falls with the fourth power of the step."""
    residuals = []
    for step in (0.1, 0.05):
        run = hs.simulate(afloat(barge(FAMILY, 4.4), 250.0, step))
        residuals.append(float(np.abs(run.energy_residual).max()))
    heave = run.position.sel(dof="heave").values[:, 0]
    assert heave[-1] == pytest.approx(0.6, abs=1e-4)
    assert float(run.slow_draught[-1, 0]) == pytest.approx(3.8, abs=1e-3)
    assert residuals[1] <= 1e-7 * float(np.abs(run.energy_work_weight).max())
    assert residuals[1] <= residuals[0] / 8.0


def test_a_family_with_tanks_goes_on_in_the_midst_of_pumping_to_the_bit() -> None:
    whole = afloat(barge(FAMILY, 4.4, position=moving(roll=0.02)), 60.0)
    run = hs.simulate(whole)
    again = hs.simulate(replace(whole, duration=25.0, initial=hs.Start(run, 35.0)))
    same_later(run, again)


def test_a_family_starts_at_rest_where_its_weight_is_carried() -> None:
    """Half a metre too high at first: at_rest it floats at its draught, and stays."""
    body = barge(FAMILY, 4.4, pumps=(), position=moving(heave=0.5))
    run = hs.simulate(afloat(body, 20.0, at_rest=True))
    assert_allclose(run.position.values, 0.0, atol=1e-9)
    assert_allclose(run.slow_draught.values, 4.4, atol=1e-9)


def test_tanks_with_a_convolution_move_as_with_states_and_go_on_to_the_bit() -> None:
    """Within the tolerance of the fit of the states, 3e-3 of the memory."""
    start = {"position": moving(heave=0.2, roll=0.05)}
    runs = [
        hs.simulate(afloat(barge(ALONE, 4.0, radiation=radiation, **start), 60.0))
        for radiation in (ConvolutionRadiation(30.0, 0.1), StateSpaceRadiation(3e-3))
    ]
    memory, states = (run.position.values[:, 0] for run in runs)
    ranges = np.maximum(np.ptp(memory, axis=0), 1e-6)
    assert np.abs((memory - states) / ranges).max() <= 1e-2
    whole = afloat(barge(ALONE, 4.0, radiation=ConvolutionRadiation(30.0, 0.1), **start), 60.0)
    first = hs.simulate(replace(whole, duration=35.0))
    same_later(runs[0], hs.simulate(replace(whole, duration=25.0, initial=hs.Start(first))))


MASS, RATE_OUT, MU, KINETIC, STIFF = 2e4, 100.0, 0.3, 0.2, 1e8


def on_rough_floor(*pumps: hs.Pump, push: float = 0.0, duration: float = 60.0) -> xr.Dataset:
    """A block that stands on one rough point, pushed aside, with two tanks."""
    tanks = (
        hs.Tank("left", Box((-3.0, -1.0, 0.0), (-1.0, 1.0, 3.0)), 2.5, 1000.0),
        hs.Tank("right", Box((1.0, -1.0, 0.0), (3.0, 1.0, 3.0)), 0.5, 1000.0),
    )
    body = block(MASS, ("surge", "heave"), weight=Weight.CARRIED, tanks=tanks, pumps=pumps)
    body = replace(body, position=moving(heave=-MASS * G / STIFF))
    forces = {
        "push": steady(surge=push),
        "floor": on_floor(STIFF, Coulomb(MU, KINETIC)),
        "damping": LinearDamping("block", np.diag([0, 0, 1e5, 0, 0, 0.0])),
    }
    return hs.simulate(dry_scene(body, forces, duration, 0.5, step=0.01))


def test_what_rigid_friction_holds_stays_where_it_is_when_a_pump_starts() -> None:
    """The impulse of the flow, 1200 N s, goes into the floor: no real pump starts within the
    0.02 s in which friction could not take it."""
    run = on_rough_floor(hs.Pump("across", 300.0, "left", "right", 3.0, 20.0), duration=30.0)
    assert int(run.solver_events) >= 2
    assert np.abs(run.position.sel(dof="surge")).max() <= 1e-12
    assert np.all(run.fender_mode.values == 1)


def test_friction_lets_go_when_enough_weight_is_pumped_out() -> None:
    """mu m g = F; then m v' = F - mu_k m g with a mass that leaves at the body's own velocity."""
    push, start = 0.27 * MASS * G, 5.0
    run = on_rough_floor(hs.Pump("out", RATE_OUT, "left", None, start, 50.0), push=push)
    loose = start + (MASS - push / (MU * G)) / RATE_OUT
    t = run.time.values
    moving_now = np.clip(t - loose, 0.0, None)
    at = MASS - push / (MU * G)
    first = MASS - at
    mass = np.maximum(first - RATE_OUT * moving_now, MASS - RATE_OUT * 45.0)
    speed = push / RATE_OUT * np.log(first / mass) - KINETIC * G * (first - mass) / RATE_OUT
    pumping = t <= 50.0
    found = run.velocity.sel(dof="surge").values[:, 0]
    stuck = run.fender_mode.values[:, 0] == 1
    assert np.all(stuck == (t <= loose))
    assert_allclose(found[pumping], speed[pumping], atol=2e-4 * speed[pumping].max())


def test_a_lightship_that_would_sink_with_its_hull_is_refused() -> None:
    """60 x 20 x 8 m displace 9840 t; one that only floats deeper than its database is not refused
    for that."""
    heavy = DENSITY * AREA * 4.0 + 7e6
    with pytest.raises(InputError, match=r"barge\.lightship: found 1\.0\d+e\+07 kg.*still sink"):
        hs.compile_scene(afloat(barge(ALONE, 4.0, mass=heavy), 10.0))
    deeper = barge(ALONE, 4.0, mass=DENSITY * AREA * 5.5)
    hs.compile_scene(afloat(deeper, 10.0, accept=tuple(Question)))
