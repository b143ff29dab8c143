"""Pumps that start and stop by events, and levels of tanks that others wait for."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose
from scenes import block, moving, observed_orders, scene, steady

import hydrosim as hs
from hydrosim.elements import LinearMooring
from hydrosim.errors import InputError
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Box, LevelReached, Method, Weight

MASS, DENSITY, AREA = 2e4, 1000.0, 5.0
LEFT = hs.Tank("left", Box((-3.0, -1.25, -0.5), (-1.0, 1.25, 2.0)), 2.0, DENSITY)
RIGHT = hs.Tank("right", Box((1.5, -1.0, -2.0), (4.0, 1.0, 0.5)), 0.4, DENSITY)
PUSH = {"push": steady(surge=3e3)}


def pushed(*pumps: hs.Pump, forces: dict[str, Any] = PUSH, **changes: Any) -> hs.Scene:
    """A body of constant inertia without weight: v = F t / m, whatever is pumped."""
    body = block(MASS, ("surge",), weight=Weight.CARRIED, tanks=(LEFT, RIGHT), pumps=pumps)
    body = replace(body, constant_inertia=True)
    still = scene(body, forces, 20.0, 0.5, **{"step": 0.1, **changes})
    return replace(still, environment=hs.Environment(gravity=1e-30)).with_output(states=True)


def levels(run: xr.Dataset, name: str) -> np.ndarray:
    return np.asarray(run.tank_level.sel(tank=f"{name} of block").values)


FAST = hs.When(channel="velocity.block.surge", above=1.2)
FASTER = hs.When(channel="speed.block", above=1.8, lasting=0.77)
NEVER = hs.When(channel="speed.block", above=9.0)


@pytest.mark.parametrize("method", Method)
def test_a_pump_runs_between_two_events_to_the_last_digit(
    method: Method, validated: Callable[..., None]
) -> None:
    """From v = 1.2 m/s, at 8 s, to 0.77 s after 1.8 m/s, 12.77 s."""
    run = hs.simulate(
        pushed(hs.Pump("across", 300.0, "left", "right", FAST, FASTER), method=method)
    )
    moved = 300.0 * np.clip(run.time.values - 8.0, 0.0, 4.77) / DENSITY / AREA
    error = np.abs(levels(run, "left") - (2.0 - moved)).max()
    claim = "level of a tank whose pump runs between two events [m]"
    validated(Kind.CLOSED_FORM, claim, "straight lines", error, 1e-9, Feature.PUMPS)
    assert_allclose(levels(run, "right"), 0.4 + moved, atol=1e-9)
    assert [*run.pump_mode.values[[0, 20, -1], 0]] == [0, 1, 2]


def test_times_and_levels_stand_beside_events() -> None:
    """One from a time to an event, one from an event to a time; one from a level, which it reads as
    an event, to an event that does not come: it empties the tank."""
    pumps = (
        hs.Pump("out", 300.0, "left", None, 1.3, FAST),
        hs.Pump("in", 200.0, None, "right", FAST, 11.1),
        hs.Pump("last", 1000.0, "left", None, LevelReached("right", above=0.5), NEVER),
    )
    run = hs.simulate(pushed(*pumps))
    t = run.time.values
    left = 10.0 - 0.3 * np.clip(t - 1.3, 0.0, 6.7) - 1.0 * np.maximum(t - 10.5, 0.0)
    right = 2.0 + 0.2 * np.clip(t - 8.0, 0.0, 3.1)
    assert_allclose(levels(run, "right"), right / AREA, atol=1e-9)
    assert_allclose(levels(run, "left"), np.maximum(left, 0.0) / AREA, atol=1e-9)
    assert int(run.pump_mode.values[-1, 2]) == 2


def test_a_pump_whose_source_is_empty_when_its_event_comes_does_not_run() -> None:
    first = hs.Pump("first", 4000.0, "left", None, stop=NEVER)
    run = hs.simulate(pushed(first, hs.Pump("second", 300.0, "left", "right", FAST)))
    assert np.all(levels(run, "left")[6:] == pytest.approx(0.0, abs=1e-12))
    assert_allclose(levels(run, "right"), 0.4, atol=1e-12)


def test_a_force_waits_for_the_level_of_a_tank() -> None:
    """The push begins when 1.5 m are left: after 2.5 m^3 at 0.5 m^3/s, 5 s."""
    waits = hs.Active(hs.When(channel="tank_level.left of block", below=1.5))
    forces = {"push": replace(steady(surge=3e3), active=waits)}
    run = hs.simulate(pushed(hs.Pump("out", 500.0, "left", None, stop=9.0), forces=forces))
    v = 0.15 * np.maximum(run.time.values - 5.0, 0.0)
    assert_allclose(run.velocity.values[:, 0, 0], v, atol=1e-9)


def swung(step: float) -> hs.Scene:
    """On springs, heeling and trimming; fluid goes across from when the body is up."""
    up = hs.When(channel="position.block.heave", above=0.02)
    low = hs.When(channel="tank_level.left of block", below=1.7)
    pumps = (
        hs.Pump("across", 300.0, "left", "right", up, low),
        hs.Pump("out", 40.0, "left", None, up, 9.3),
    )
    body = block(MASS, weight=Weight.CARRIED, tanks=(LEFT, RIGHT), pumps=pumps)
    body = replace(body, position=moving(surge=0.3, roll=0.1), velocity=moving(heave=0.4))
    stiffness = np.diag([3e4, 2e4, 2e6, 4e5, 5e5, 6e5])
    hung = scene(body, {"line": LinearMooring("block", stiffness)}, 12.0, 0.5, step=step)
    return replace(hung, environment=hs.Environment(gravity=1.0)).with_output(states=True)


def test_the_order_of_the_method_is_kept_through_events_of_pumps() -> None:
    exact = hs.simulate(swung(0.003125)).position.values
    steps = [0.05, 0.025, 0.0125]
    errors = [np.abs(hs.simulate(swung(h)).position.values - exact).max() for h in steps]
    assert np.all(observed_orders(steps, np.array(errors)) > 3.6)
    run = hs.simulate(swung(0.05))
    assert run.pump_mode.values.max(axis=0).tolist() == [2, 2]


@pytest.mark.parametrize(
    ("method", "step", "apart"),
    [
        *((Method.RK2, 0.01, 0.0), (Method.HEUN, 0.01, 0.0), (Method.RK4, 0.05, 0.0)),
        *((Method.DOPRI5, 0.05, 1e-6), (Method.ESDIRK4, 0.05, 1e-6)),
    ],
)
def test_a_restart_before_and_while_a_pump_runs_is_the_same_run(
    method: Method, step: float, apart: float
) -> None:
    """To the bit with equal steps; adaptive ones choose others, within their tolerance."""
    first = swung(step)
    full = replace(first, solver=replace(first.solver, method=method))
    run = hs.simulate(full)
    running = run.time.values[run.pump_mode.values[:, 0] == 1]
    assert running.size > 2
    for time in (float(running[0]) - 0.5, float(running[1])):
        start = hs.scene.Start(run, time)
        again = hs.simulate(replace(full, duration=12.0 - time, initial=start))
        for name in ("position", "velocity", "tank_level", "pump_rate", "energy_work_ballast"):
            later = run[name].sel(time=slice(time, None)).values
            assert np.abs(again[name].values - later).max() <= apart * np.abs(later).max(), name


@pytest.mark.parametrize(
    ("start", "tank", "said"),
    [
        (
            *(hs.When(channel="tank_level.none of block", below=1.0), LEFT),
            r"bodies\.block\.pumps\.out: channel: found tank_level\.none of block; expected"
            r" tank_level\. and left of block",
        ),
        (
            *(hs.When(channel="speed.none", below=1.0), LEFT),
            r"bodies\.block\.pumps\.out: channel: found speed\.none; expected speed\. and block",
        ),
        (
            *(FAST, replace(LEFT, plan=hs.Plan(np.array([0.0, 1.0]), np.array([2.0, 1.0])))),
            r"tanks\.left\.plan: found a plan, and a pump of this tank that begins or ends at",
        ),
    ],
)
def test_events_that_cannot_be_are_refused(start: hs.When, tank: hs.Tank, said: str) -> None:
    pump = hs.Pump("out", 1.0, "left", None, start)
    body = block(MASS, weight=Weight.CARRIED, tanks=(tank,), pumps=(pump,))
    with pytest.raises(InputError, match=said):
        hs.compile_scene(scene(body, PUSH, 5.0, 0.5))
