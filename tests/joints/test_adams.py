"""Pendulums on one joint to the earth, against MSC ADAMS.

A body of 1 kg hangs on a joint, 2 m from its centre of gravity, and falls from rest for 5 s.
Project Chrono's test data has the place of its centre, the rotation of its frame, and the reaction
of the joint, in seven digits and with noise of about 3e-5 of the motion. The body's frame in the
data is that of the joint at the start: ours, parallel to the earth's at rest, after a turn.

The data do not tell in which axes and about which point the reaction is, nor on which body.
Newton's laws do, see `test_the_reaction_of_the_data_acts_on_the_ground`: it is the wrench on the
ground in the earth's axes, about the point of the joint on the ground.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
import xarray as xr
from jointed import carried, completed, joint, places, rotations, scene
from scipy.spatial.transform import Rotation
from validation_data import unpacked

from hydrosim.evidence import Feature, Kind
from hydrosim.scene import Scene

GRAVITY = 9.80665
ALONG, ACROSS = 0.04, 0.1  # inertia along the pendulum and across it [kg m^2]
PLACES, REACTIONS = 1e-4, 1e-3  # of the range
CLAIM = "pendulums on a hinge, a ball, a universal joint, a slider: "


class Pendulum(NamedTuple):
    """A joint at ``point``, with the body's centre at ``centre`` from it, and the frame of the data
    turned by ``turn`` [deg] about x; ``axes`` of the joint as the scene has them."""

    kind: str
    file: str
    point: tuple[float, float, float]
    centre: tuple[float, float, float]
    turn: float
    axes: dict[str, tuple[float, float, float]]


SLANT = (0.0, np.sqrt(0.5), np.sqrt(0.5))
PENDULUMS = (
    Pendulum("hinge", "Revolute_Case01", (0, 0, 0), (2, 0, 0), -90.0, {"axis": (0, 1, 0)}),
    Pendulum("ball", "Spherical_Case01", (0, 0, 0), (2, 0, 0), 0.0, {}),
    Pendulum(
        *("universal", "Universal_Case01", (0, 0, 0), (0, 2, 0), 90.0),
        {"axis": (1, 0, 0), "second": (0, 0, 1)},
    ),
    Pendulum("slider", "Prismatic_Case02", (1, 2, 3), (2, 0, 0), -45.0, {"axis": SLANT}),
)
EACH = pytest.mark.parametrize("pendulum", PENDULUMS, ids=lambda p: p.kind)


def recorded(pendulum: Pendulum, what: str) -> np.ndarray:
    """Columns of a file of the data, without the time."""
    path = unpacked(f"joints_adams/{pendulum.file}_{what}.txt")
    return np.loadtxt(path, skiprows=3)[:, 1:]


def pendulum_scene(pendulum: Pendulum) -> Scene:
    """The scene of ADAMS."""
    centre = np.array(pendulum.centre, float)
    inertia = np.where(centre != 0.0, ALONG, ACROSS)
    body = carried("rod", 1.0, inertia, np.add(pendulum.point, centre).tolist())
    held = joint(pendulum.kind, "rod", point=tuple(-centre), **pendulum.axes)
    return scene([body], {"pin": held}, 5.0, output_step=0.01, gravity=GRAVITY)


@cache
def run_on(kind: str) -> xr.Dataset:
    """Our run of the pendulum on a joint of this kind."""
    return completed(pendulum_scene(next(p for p in PENDULUMS if p.kind == kind)))


def reaction_on_the_ground(pendulum: Pendulum, run: xr.Dataset) -> np.ndarray:
    """Ours as the data have it (nt, 6): `joint_force` is the wrench on the body, about the joint's
    point on the body, in the earth's axes."""
    wrench = run.joint_force.sel(joint="pin").values
    on_body = places(run, "rod") - rotations(run, "rod") @ np.array(pendulum.centre)
    arm = on_body - np.array(pendulum.point)
    moment = wrench[:, 3:] + np.cross(arm, wrench[:, :3])
    return -np.hstack([wrench[:, :3], moment])


@EACH
def test_the_reaction_of_the_data_acts_on_the_ground(pendulum: Pendulum) -> None:
    """Newton and Euler on the data alone: the force on the body is m (a - g), with a from the
    second differences of places; the moment about its centre is the rate of I omega. The reaction
    is the opposite, in the earth's axes. Differences of seven digits are good to 1e-2."""
    step, place = 0.01, recorded(pendulum, "Pos")
    spread = 10  # steps of a difference, over which digits are lost in rounding
    h = spread * step
    acceleration = (place[2 * spread :] - 2.0 * place[spread:-spread] + place[: -2 * spread]) / h**2
    force = acceleration + np.array([0.0, 0.0, GRAVITY])
    found = recorded(pendulum, "Rforce")[spread:-spread]
    size = np.abs(force).max()
    assert np.abs(found + force).max() < 0.02 * size
    moment = recorded(pendulum, "Rtorque")[spread:-spread]
    arm = place[spread:-spread] - np.array(pendulum.point)
    rotation = Rotation.from_quat(recorded(pendulum, "Quat"), scalar_first=True)
    spin = (rotation[2 * spread :] * rotation[: -2 * spread].inv()).as_rotvec() / (2.0 * h)
    across = ACROSS * np.gradient(spin, step, axis=0)  # the pendulums turn about an axis across
    about_point = across + np.cross(arm, force)
    trimmed = slice(spread, -spread)  # one-sided differences at the ends
    assert np.abs((moment + about_point)[trimmed]).max() < 0.02 * size * 2.0


@EACH
def test_places_and_rotations_are_those_of_adams(
    pendulum: Pendulum, validated: Callable[..., None]
) -> None:
    run = run_on(pendulum.kind)
    place = recorded(pendulum, "Pos")
    error = np.abs(places(run, "rod") - place).max() / np.ptp(place, axis=0).max()
    validated(Kind.PROGRAM, CLAIM + "places", "MSC ADAMS", error, PLACES, Feature.JOINTS)
    start = Rotation.from_euler("x", pendulum.turn, degrees=True)
    ours = (Rotation.from_matrix(rotations(run, "rod")) * start).as_quat(scalar_first=True)
    theirs = recorded(pendulum, "Quat")
    ours *= np.sign(np.sum(ours * theirs, axis=1))[:, None]  # q and -q are one rotation
    error = np.abs(ours - theirs).max()
    validated(Kind.PROGRAM, CLAIM + "quaternions", "MSC ADAMS", error, PLACES, Feature.JOINTS)


@EACH
def test_reactions_are_those_of_adams(pendulum: Pendulum, validated: Callable[..., None]) -> None:
    """Over their largest, since that of the slider is constant."""
    ours = reaction_on_the_ground(pendulum, run_on(pendulum.kind))
    for name, columns in (("Rforce", slice(0, 3)), ("Rtorque", slice(3, 6))):
        theirs = recorded(pendulum, name)
        size = max(np.ptp(theirs, axis=0).max(), np.abs(theirs).max())
        free_of_load = name == "Rtorque" and size < 1e-9
        error = np.abs(ours[:, columns] - theirs).max() / (GRAVITY if free_of_load else size)
        validated(Kind.PROGRAM, CLAIM + "loads", "MSC ADAMS", error, REACTIONS, Feature.JOINTS)
