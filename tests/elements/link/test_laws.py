"""Laws along any coordinate: stops, gas springs, dry friction and springs of joints, against
independent integrations, with their energies and restarts."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from modes_apart import Event, integrate
from scenes import Acting, block, joint_of, moving, observed_orders, scene, steady, with_motions

import hydrosim as hs
from hydrosim.elements import (
    DryFriction,
    GasSpring,
    SpringDamper,
    Stop,
    TorsionSpring,
)
from hydrosim.errors import InputError
from hydrosim.files.series import select, units_along
from hydrosim.files.text import Source
from hydrosim.run.step_limits import scene_step_limits
from hydrosim.scene import ForceElement, Scene, Start

ORIGIN = (0.0, 0.0, 0.0)
ANCHOR = (10.0, 0.0, 0.0)
MASS, INERTIA = 1e3, 2e3
STEPS = (0.008, 0.004, 0.002)
LINE: dict[str, Any] = {"point": ORIGIN, "anchor": ANCHOR}
AXIS: dict[str, Any] = {"axis": (0.0, 0.0, 1.0)}
SLIDER: dict[str, Any] = {"joint": "it"}


def on(coordinate: dict[str, Any], x: float, rate: float, **forces: ForceElement) -> Scene:
    """A `MASS` or inertia from ``x`` along a line to its anchor, about an axis or in a slider."""
    if coordinate is AXIS:
        inertia = np.diag([MASS, MASS, MASS])
        start = {"velocity": moving(yaw=rate), "position": moving(yaw=x)}
        body = block(MASS, ("yaw",), inertia=inertia, **start)
        return scene(body, forces, 6.0, 0.08)
    if coordinate is LINE:
        body = block(MASS, ("surge",), velocity=moving(surge=-rate), position=moving(surge=-x))
        return scene(body, forces, 6.0, 0.08)
    free = (Acting(position=x, velocity=rate),)
    joint = joint_of("slider", "block", None, *free, point=ORIGIN, axis=(1.0, 0.0, 0.0))
    return replace(scene(block(MASS), forces, 6.0, 0.08), joints={"it": joint})


def place(run: xr.Dataset, coordinate: dict[str, Any]) -> np.ndarray:
    """The coordinate, from where it is at rest."""
    if coordinate is LINE:
        return np.asarray(-run.position.values[:, 0, 0])
    if coordinate is AXIS:
        return np.asarray(run.position.values[:, 0, 5])
    return np.asarray(run.joint_position.values[:, 0])


def judge(
    whole: Scene,
    coordinate: dict[str, Any],
    apart: tuple[Callable[..., Sequence[float]], Callable[[str], Sequence[Event]], str],
    start: Sequence[float],
    events: int,
) -> float:
    """Error, of the range, of the finest of three runs, whose order is 3.8 or more."""
    runs = [hs.simulate(replace(whole, solver=replace(whole.solver, step=h))) for h in STEPS]
    rates, ends, mode = apart
    exact, modes, _ = integrate(rates, ends, mode, start, runs[0].time.values)
    assert len(modes) - 1 >= events
    assert [int(run.solver_events) for run in runs] == [len(modes) - 1] * len(runs)
    errors = np.array([np.abs(place(run, coordinate) - exact[:, 0]).max() for run in runs])
    errors /= np.ptp(exact[:, 0])
    assert errors[-1] < 1e-11 or observed_orders(STEPS, errors)[-1] >= 3.7
    assert runs[-1].energy_residual_relative < 1e-7
    return float(errors[-1])


def check_restart(whole: Scene, time: float, *names: str) -> None:
    """A run that goes on from ``time`` is the same to the bit."""
    run = hs.simulate(whole)
    half = replace(whole, duration=time).with_output(states=True)
    start = Start(hs.simulate(half))
    later = hs.simulate(replace(whole, duration=whole.duration - time, initial=start))
    for name in ("position", "link_mode", "link_segment", *names):
        assert np.array_equal(later[name].values[-1], run[name].values[-1]), name


EVERY = pytest.mark.parametrize("coordinate", [LINE, AXIS, SLIDER], ids=["line", "axis", "slider"])


@EVERY
def test_stops_on_any_coordinate(coordinate: dict[str, Any], figure) -> None:
    """A mass between two stops with damping, which never pull."""
    k, c, low, high = 4e4, 1e3, -0.5, 0.8
    shift = 10.0 if coordinate is LINE else 0.0
    ends = {"lowest": low + shift, "highest": high + shift}
    stop = Stop("block", **coordinate, **ends, stiffness=k, damping=c)
    sides = {"low": (low, 1.0), "high": (high, -1.0)}

    def push(y: np.ndarray, side: str) -> float:
        end, _ = sides[side]
        return k * (end - y[0]) - c * y[1]

    def rates(t: float, y: np.ndarray, mode: str) -> list[float]:
        return [y[1], push(y, mode) / MASS if mode in sides else 0.0]

    def ends(mode: str) -> list[Event]:
        if mode == "away":
            return [(lambda t, y, m: y[0] - low, "low"), (lambda t, y, m: high - y[0], "high")]
        side = mode.removeprefix("loose ")
        end, sign = sides[side]
        if side == mode:
            return [(lambda t, y, m: sign * push(y, side), f"loose {side}")]
        return [(lambda t, y, m: sign * (end - y[0]), "away")]

    whole = on(coordinate, 0.1, 1.2, stop=stop)
    error = judge(whole, coordinate, (rates, ends, "away"), (0.1, 1.2), 9)
    figure("error", error)
    assert error < 1e-9
    check_restart(whole, 0.72, "stop_load")


@EVERY
def test_gas_springs_on_any_coordinate(coordinate: dict[str, Any], figure) -> None:
    """A mass that a constant force presses onto a gas spring, through both of its ends."""
    P, S, h, n, k, c = 2e3, 1.0, 0.9, 1.4, 1e5, 40.0
    neutral = 10.0 if coordinate is LINE else 0.0
    law = {"neutral": neutral, "push": P, "stroke": S, "gas_length": h, "exponent": n}
    gas = GasSpring("block", **coordinate, **law, stiffness=k, damping=c)
    load = {id(AXIS): steady(yaw=-P), id(LINE): steady(surge=P), id(SLIDER): steady(surge=-P)}

    def gas_push(x: float) -> float:
        return P * (h / (h + x)) ** n

    def force(y: np.ndarray, mode: str) -> float:
        x = y[0]
        if mode == "stroke":
            return gas_push(x) - c * y[1]
        end = 0.5 * S if mode == "long" else -0.5 * S
        return gas_push(end) - k * (x - end) - c * y[1]

    def rates(t: float, y: np.ndarray, mode: str) -> list[float]:
        return [y[1], (force(y, mode) - P) / MASS]

    def ends(mode: str) -> list[Event]:
        if mode == "stroke":
            return [
                (lambda t, y, m: 0.5 * S - y[0], "long"),
                (lambda t, y, m: y[0] + 0.5 * S, "short"),
            ]
        sign = 1.0 if mode == "long" else -1.0
        return [(lambda t, y, m: sign * y[0] - 0.5 * S, "stroke")]

    whole = on(coordinate, 0.0, 1.6, gas=gas, load=load[id(coordinate)])
    error = judge(whole, coordinate, (rates, ends, "stroke"), (0.0, 1.6), 6)
    figure("error", error)
    assert error < 1e-8
    run = hs.simulate(whole)
    assert float(run.gas_spring_load[0, 0]) == pytest.approx(-P + c * 1.6, rel=1e-12)
    check_restart(whole, 1.28, "gas_spring_load")


@EVERY
def test_dry_friction_on_any_coordinate(coordinate: dict[str, Any], figure) -> None:
    """A mass on a spring with dry friction, which sticks and slips until it rests."""
    static, kinetic, k, c, spring = 900.0, 600.0, 2e5, 3e3, 8e3
    law = {"static": static, "kinetic": kinetic, "stiffness": k, "damping": c}
    friction = DryFriction("block", **coordinate, **law)
    straight = np.array([-1.0, 1.0]), np.array([-spring, spring])
    if coordinate is AXIS:
        held: ForceElement = TorsionSpring(
            "block", curve=hs.TorsionCurve(*straight), axis=(0.0, 0.0, 1.0)
        )
    elif coordinate is LINE:
        held = hs.elements.Strut(
            "block", curve=hs.StrutCurve(*straight), point=ORIGIN, anchor=ANCHOR
        )
    else:
        held = SpringDamper("block", stiffness=spring, joint="it")
    whole = on(coordinate, 0.6, 0.0, friction=friction, held=held)

    def stretch(y: np.ndarray) -> float:
        return k * (y[0] - y[2])

    def rates(t: float, y: np.ndarray, mode: str) -> list[float]:
        load = {"up": kinetic, "down": -kinetic, "sticks": stretch(y) + c * y[1]}[mode]
        node_rate = 0.0 if mode == "sticks" else y[1]
        return [y[1], (-spring * y[0] - load) / MASS, node_rate]

    def slip(mode: str, t: float, y: np.ndarray) -> str:
        """The node is where the spring holds the kinetic force, and moves with the mass."""
        y[2] = y[0] - (kinetic if mode == "up" else -kinetic) / k
        return mode

    def ends(mode: str) -> list[Event]:
        if mode == "sticks":
            return [
                (lambda t, y, m: static - stretch(y), partial(slip, "up")),
                (lambda t, y, m: static + stretch(y), partial(slip, "down")),
            ]
        sign = 1.0 if mode == "up" else -1.0
        return [(lambda t, y, m: sign * y[1], "sticks")]

    runs = [hs.simulate(replace(whole, solver=replace(whole.solver, step=h))) for h in STEPS]
    exact, modes, _ = integrate(rates, ends, "sticks", (0.6, 0.0, 0.6), runs[0].time.values)
    assert len(modes) >= 6
    assert [int(run.solver_events) for run in runs] == [len(modes) - 1] * len(runs)
    errors = np.array([np.abs(place(run, coordinate) - exact[:, 0]).max() for run in runs]) / 1.2
    figure("order", observed_orders(STEPS, errors)[-1])
    assert errors[-1] < 1e-8
    assert observed_orders(STEPS, errors)[-1] >= 3.7
    assert runs[-1].energy_residual_relative < 1e-7
    assert np.abs(runs[-1].dry_friction_load.values).max() < static + c
    check_restart(whole, 0.08, "dry_friction_load")
    check_restart(whole, 1.04, "dry_friction_load")


def test_a_spring_of_a_joint_is_the_resistance_of_that_joint() -> None:
    """The same spring and damping as a link and as a property of the hinge."""
    k, c = 4e4, 2e2
    hinge = hs.Hinge("block", None, (0.0, 0.0, -2.0), axis=(0.0, 1.0, 0.0))
    body = block(MASS, inertia=np.diag([INERTIA, INERTIA, INERTIA]))
    free = with_motions(hinge, Acting(velocity=1.0))
    held = with_motions(hinge, Acting(k, damping=c, velocity=1.0))
    spring = SpringDamper("block", stiffness=k, damping=c, joint="it")
    runs = []
    for joint, forces in ((free, {"spring": spring}), (held, {})):
        runs.append(hs.simulate(replace(scene(body, forces, 4.0, 0.1), joints={"it": joint})))
    swing = runs[1].joint_position.values
    assert np.abs(runs[0].joint_position.values - swing).max() < 1e-12 * np.ptp(swing)
    load = runs[0].spring_damper_load.values
    assert np.abs(load + runs[1].joint_motion_force.values).max() < 1e-9 * np.ptp(load)


def test_step_limits_know_a_gas_spring_at_its_short_end() -> None:
    """The gas is stiffest there, and stiffer than the stops."""
    P, S, h, n, k = 2e3, 1.0, 0.55, 1.4, 1e4
    gas = {"push": P, "stroke": S, "gas_length": h, "exponent": n, "stiffness": k}
    stiffest = n * P / h * (h / (h - S / 2)) ** (n + 1)
    assert stiffest > 10.0 * k
    whole = on(SLIDER, 0.0, 0.0, gas=GasSpring("block", **SLIDER, **gas))
    (limit, *_) = scene_step_limits(hs.compile_scene(whole))
    assert limit.step == pytest.approx(2.0 * sqrt(2.0) / sqrt(stiffest / MASS), rel=2e-3)


def test_results_say_in_which_units_each_link_acts(tmp_path: Path) -> None:
    """Loads along lines and in slides are forces, about axes and in turns moments."""
    stop: dict[str, Any] = {"stiffness": 1e5, "highest": 20.0}
    turning = hs.Cylindrical("other", None, ORIGIN, axis=(0.0, 0.0, 1.0))
    forces = {
        "line": Stop("block", **LINE, **stop),
        "axis": Stop("block", **AXIS, **stop),
        "slide": Stop("other", joint="it", motion="offset", **stop),
        "turn": Stop("other", joint="it", motion="angle", **stop),
        "rest": SpringDamper("other", joint="it", motion="angle", damping=1.0),
    }
    whole = scene(block(MASS), forces, 1.0, 0.1)
    bodies = (*whole.bodies, block(MASS, name="other"))
    whole = replace(whole, bodies=bodies, joints={"it": turning})
    run = hs.simulate(whole)
    names = ["line", "axis", "slide", "turn"]
    units = {name: select(Source(tmp_path), run, f"stop_load.{name}")[1] for name in names}
    assert units == {"line": "N", "axis": "N m", "slide": "N", "turn": "N m"}
    assert units_along(run, "stop_place") == dict(zip(names, ["m", "rad", "m", "rad"], strict=True))
    assert select(Source(tmp_path), run, "spring_damper_load")[1] == "N m"
    run.to_netcdf(tmp_path / "run.nc")
    with xr.open_dataset(tmp_path / "run.nc") as read:
        assert units_along(read, "stop_load") == units


@pytest.mark.parametrize("joint", ["its", "ball"])
def test_a_joint_that_is_not_there_is_refused(joint: str) -> None:
    ball = hs.Ball("block", None, ORIGIN)
    stop = Stop("block", joint=joint, highest=1.0, stiffness=1.0, motion=None)
    whole = replace(scene(block(MASS), {"it": stop}, 1.0, 0.1), joints={"ball": ball})
    with pytest.raises(InputError, match=r"forces\.it"):
        hs.simulate(whole)


def test_a_coordinate_is_needed() -> None:
    with pytest.raises(InputError, match="point and anchor, axis, or joint"):
        hs.simulate(scene(block(MASS), {"it": Stop("block", highest=1.0, stiffness=1.0)}, 1.0, 0.1))
