"""Scenes of `work_precision`: beginnings of all shipped cases, and scenes that are hard to solve.

The latter are a pendulum from three angles, a double pendulum from two, a ball on an elastic floor,
a block that slips where its load dips, a rail with friction, and a joint that breaks at a peak.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

import hydrosim as hs
from hydrosim.scene import LinearScenes, Scene
from hydrosim.simulation import prepare_scene
from tests.generators.error_cases import written_scene
from tests.generators.long_cases import ACCEPTED
from tests.generators.random_cases import Case

ROOT = Path(__file__).parents[2]
BEGINNING = 300.0  # s
LATER = {"reverse_float_over": 700.0, "lock_in": 700.0, "numerical_oscillation": 700.0}
"""The same of folders whose contacts close later [s]."""


def _case(duration: float, output_step: float, **parts: object) -> Case:
    """A dry case by rk4 at 0.1 s, unless its ``parts`` say otherwise."""
    case = {"title": "scene that is hard to solve", "duration": duration, "accept": list(ACCEPTED)}
    case |= {"environment": {"water_depth": "infinite"}, "solver": {"method": "rk4", "step": 0.1}}
    return {**case, **parts, "output": {"step": output_step}}


def _rod(z: float) -> Case:
    centre = [0.0, 0.0, z]
    body: Case = {"mass": 1000.0, "centre_of_gravity": centre, "radii_of_gyration": [0.5, 0.5, 0.5]}
    return {**body, "weight": "carried"}


def _pin(body: str, angle: float, **to: str) -> Case:
    hinge: Case = {"type": "hinge", "body": body, "point": [0, 0, 1], "axis": [0, 1, 0], **to}
    return {**hinge, "initial": {"angle": angle}}


def pendulum(angle: float) -> Case:
    """A rod on a hinge, let go at an angle from below [rad]."""
    return _case(60.0, 0.1, bodies={"b": _rod(-1.0)}, joints={"h": _pin("b", angle)})


def double_pendulum(first: float, second: float, duration: float) -> Case:
    """Two rods, let go at angles [rad]; the second one is from the first."""
    joints = {"h": _pin("b", first), "h2": _pin("c", second, to="b")}
    return _case(duration, 0.1, bodies={"b": _rod(-1.0), "c": _rod(-3.0)}, joints=joints)


def bounce(drop: float) -> Case:
    """A ball that falls on an elastic floor of 19 rad/s."""
    plane = {"point": [0, 0, 0], "normal": [0, 0, 1]}
    floor = {"type": "fender", "body": "b", "points": [[0, 0, 0]], "plane": plane}
    floor |= {"normal": {"stiffness": 361e3}, "friction": {"law": "none"}}
    body = {**_rod(drop), "dofs": ["heave"]}
    solver = {"method": "rk4", "step": 0.02}
    return _case(40.0, 0.04, bodies={"b": body}, forces={"c": floor}, solver=solver)


def dip() -> Case:
    """A block that rigid friction holds, but for 57 ms of every 0.4 s in which its load dips."""
    plane = {"point": [0, 0, 0], "normal": [0, 0, 1]}
    load = {"mean": 1e6, "amplitude": 2e5, "period": 0.4, "phase": -2.356194490192345}
    law = {"law": "coulomb", "static": 0.3, "kinetic": 0.1}
    floor = {"type": "fender", "body": "b", "points": [[0, 0, 0]], "plane": plane}
    ramp = {"time": [0, 2], "force": [0, 246e3]}
    mooring = {"type": "linear_mooring", "body": "b", "stiffness": {"surge": 1e5}}
    push = {"type": "applied_force", "body": "b", "force": {"surge": ramp}}
    contact = {**floor, "normal": {"prescribed": load}, "friction": law}
    forces = {"k": {**mooring, "damping": {"surge": 1e5}}, "p": push, "c": contact}
    return _case(10.0, 0.2, bodies={"b": _block("surge")}, forces=forces)


def _block(*dofs: str) -> Case:
    body: Case = {"mass": 1e6, "centre_of_gravity": [0, 0, 0], "radii_of_gyration": [1, 1, 1]}
    return {**body, "dofs": list(dofs)} if dofs else body


def _sine(amplitude: float, period: float) -> Case:
    harmonic = {"amplitude": amplitude, "period": period}
    return {"type": "applied_force", "body": "b", "force": {"surge": harmonic}}


def rail() -> Case:
    """A block on a rail, under 1.5 times its static friction, recorded every five periods."""
    friction = {"law": "coulomb", "static_force": 5e5, "kinetic_force": 1e5}
    joint = {"type": "slider", "body": "b", "axis": [1, 0, 0], "friction": friction}
    parts = {"joints": {"j": joint}, "forces": {"p": _sine(7.5e5, 1.0)}}
    return _case(10.0, 5.0, bodies={"b": _block()}, **parts)


def clamp() -> Case:
    """A moored block that a joint holds, until the third peak of a load that grows slowly."""
    joint = {"type": "fixed", "body": "b", "breaks_at": 1e6}
    mooring = {"type": "linear_mooring", "body": "b", "stiffness": {"surge": 2e6}}
    growing = {"time": [0, 10], "force": [0, 1e5]}
    grows = {"type": "applied_force", "body": "b", "force": {"surge": growing}}
    forces = {"k": mooring, "p": _sine(9.75e5, 1.0), "more": grows}
    return _case(10.0, 1.0, bodies={"b": _block("surge")}, joints={"j": joint}, forces=forces)


HARD: Mapping[str, Callable[[], Case]] = {
    **{f"pendulum from {angle:g} rad": partial(pendulum, angle) for angle in (1.0, 2.5, 3.1)},
    "double pendulum from 1.2 rad": partial(double_pendulum, 1.2, 0.5, 29.0),
    "double pendulum from 2 rad": partial(double_pendulum, 2.0, 0.0, 21.0),
    "ball on an elastic floor": partial(bounce, 20.0),
    "friction under a load that dips": dip,
    "rail with friction": rail,
    "joint that breaks": clamp,
}


def shipped_cases() -> dict[str, Path]:
    """Files of all shipped cases, by folder and name."""
    files = sorted((ROOT / "cases").glob("*/*.yaml"))
    return {f"{path.parent.name}/{path.stem}": path for path in files}


def scene_names() -> list[str]:
    """Names of all scenes."""
    return [*HARD, *shipped_cases()]


@contextmanager
def named_scene(name: str) -> Iterator[Scene]:
    """A scene by its name, to be stepped; files that it needs are there while the context lasts."""
    if name in HARD:
        with written_scene(HARD[name]()) as scene:
            yield _stepped(scene)
        return
    path = shipped_cases()[name]
    scene = prepare_scene(hs.load_case(path))
    longest = LATER.get(path.parent.name, BEGINNING)
    yield _stepped(replace(scene, duration=min(scene.duration, longest)))


def _stepped(scene: Scene) -> Scene:
    return replace(scene, solver=replace(scene.solver, linear=LinearScenes.STEP))
