"""Channels by name: those that follow from what is recorded, against a motion in closed form."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scenes import block, moving, on_floor, scene

import hydrosim as hs
from hydrosim.dofs import DOFS
from hydrosim.elements import Frictionless, Spring
from hydrosim.errors import InputError
from hydrosim.report.sentences.check import check_document
from hydrosim.report.sentences.run import run_document
from hydrosim.results.channels import (
    CHANNEL_KINDS,
    channel_names,
    channel_series,
    largest_loads,
    match_channels,
)

TIME = np.linspace(0.0, 20.0, 81)
OMEGA, ARM, DRIFT = 0.3, 7.0, 0.2


def turning() -> xr.Dataset:
    """A body that drifts along x and turns about z, with a point at its bow on a circle; and a
    still one; two contact points that press, one of them with a capacity."""
    angle, none = OMEGA * TIME, 0.0 * TIME
    position = np.zeros((TIME.size, 2, 6))
    position[:, 0, 0], position[:, 0, 5] = DRIFT * TIME, angle
    velocity, acceleration = np.zeros_like(position), np.zeros_like(position)
    velocity[:, 0, 0], velocity[:, 0, 5] = DRIFT, OMEGA
    origin = np.array([[10.0, 20.0, 1.0], [0.0, 0.0, 5.0]])
    bow = origin[0] + np.stack([DRIFT * TIME + ARM * np.cos(angle), ARM * np.sin(angle), none], 1)
    foot = np.broadcast_to(origin[1], bow.shape)
    motion, point = ("time", "body", "dof"), ("time", "point", "axis")
    press = np.stack([1e3 + TIME, 2e3 - TIME], axis=1)
    return xr.Dataset(
        {
            "position": (motion, position, {"units": "m or rad"}),
            "velocity": (motion, velocity, {"units": "m/s or rad/s"}),
            "acceleration": (motion, acceleration, {"units": "m/s^2 or rad/s^2"}),
            "reference_position": (("body", "axis"), origin),
            "point_position": (point, np.stack([bow, foot], axis=1), {"units": "m"}),
            "fender_normal_force": (("time", "fender"), press, {"units": "N"}),
        },
        coords={
            "time": TIME,
            "body": ["barge", "topside"],
            "dof": list(DOFS),
            "axis": ["x", "y", "z"],
            "point": ["bow of barge", "foot of topside"],
            "fender": ["pad 1", "pad 2"],
            "contact_group": ["pad"],
            "fender_group": ("fender", ["pad", "pad"]),
            "fender_capacity": ("fender", [4e3, np.nan]),
        },
    )


def test_a_point_on_a_circle() -> None:
    """Velocity and acceleration of uniform rotation; relative motion to a point at rest."""
    run, angle = turning(), OMEGA * TIME
    speed, pull = ARM * OMEGA, ARM * OMEGA**2
    expected = {
        "point_velocity.bow of barge.x": DRIFT - speed * np.sin(angle),
        "point_velocity.bow of barge.y": speed * np.cos(angle),
        "point_acceleration.bow of barge.x": -pull * np.cos(angle),
        "point_acceleration.bow of barge.y": -pull * np.sin(angle),
        "relative_position.bow of barge to foot of topside.y": 20.0 + ARM * np.sin(angle),
        "relative_position.foot of topside to bow of barge.z": 4.0 + 0.0 * angle,
        "relative_velocity.foot of topside to bow of barge.x": speed * np.sin(angle) - DRIFT,
        "speed.barge": DRIFT + 0.0 * angle,
    }
    for name, values in expected.items():
        np.testing.assert_allclose(channel_series(run, name)[0], values, atol=1e-13, err_msg=name)


def test_sums_of_groups_and_utilisation() -> None:
    values, unit = channel_series(turning(), "fender_normal_force.pad")
    assert unit == "N"
    np.testing.assert_allclose(values, 3e3)
    values, unit = channel_series(turning(), "utilisation.pad 1")
    assert unit == "1"
    np.testing.assert_allclose(values, (1e3 + TIME) / 4e3)
    assert "utilisation.pad 2" not in channel_names(turning())


def test_every_name_has_a_series_of_one_unit() -> None:
    run = turning()
    known = channel_names(run)
    assert len(known) == len(set(known))
    assert {name.partition(".")[0] for name in known} >= set(CHANNEL_KINDS)
    for name in known:
        values, unit = channel_series(run, name)
        assert values.shape == TIME.shape
        assert unit
        assert " or " not in unit


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("position.barge.surg", 'did you mean "position.barge.surge"'),
        ("positoin.barge.surge", 'did you mean "position.barge.surge"'),
        ("point_velocity.stern of barge.x", "point_velocity.bow of barge.x"),
        ("clearance.gap", "they need output: {clearances: ...}"),
        ("utilisation.pad 2", "utilisation.pad 1"),
        ("surge", 'did you mean "position.barge.surge"'),
        ("pad 1", 'did you mean "fender_'),
        ("utilised.pad 1", 'did you mean "utilisation.pad 1"'),
        ("nothing", "expected a channel of the run: position.*, velocity.*"),
    ],
)
def test_unknown_channels_are_told(name: str, said: str) -> None:
    with pytest.raises(InputError, match="found ") as error:
        channel_series(turning(), name)
    assert said in str(error.value)


def test_what_accelerations_need_is_said() -> None:
    run = turning().drop_vars("acceleration")
    assert not [name for name in channel_names(run) if "acceleration" in name]
    with pytest.raises(InputError, match="accelerations: true"):
        channel_series(run, "point_acceleration.bow of barge.z")


@pytest.mark.parametrize(("capacity", "told"), [(0.9e5, 1), (1.1e5, 0)])
def test_a_capacity_that_is_exceeded_is_told(capacity: float, told: int) -> None:
    """A line of 1e5 N/m, 1 m longer than without load, on a body that is held."""
    table = np.array([0.0, 1.0])
    line = Spring(
        "block",
        (0, 0, 0),
        (5.0, 0, 0),
        4.0,
        curve=hs.TensionCurve(table, 100000.0 * table),
        capacity=capacity,
    )
    held = scene(block(1e9, ("surge",)), {"line": line}, 0.2, 0.1, step=0.01)
    summary = str(run_document(hs.simulate(held)))
    assert summary.count("line carried 100 kN at 0 s, more than its capacity of 90 kN") == told
    assert "Loads beside capacities" in summary
    checked = str(check_document(held))
    assert "Loads of lines" in checked
    assert checked.count("of tension at the start") == told


def test_capacities_of_a_case_are_those_of_its_units() -> None:
    """Each point of an element has it; those of others have none."""
    law, line = Frictionless(), np.array([0.0, 1.0])
    pad = on_floor(1e7, law, ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)))
    forces = {
        "pad": replace(pad, capacity=3e6),
        "other": on_floor(1e7, law),
        "line": Spring(
            "block",
            (0, 0, 0),
            (5.0, 0, 0),
            4.0,
            curve=hs.TensionCurve(line, 100000.0 * line),
            capacity=200000.0,
        ),
        "slack": Spring(
            "block", (0, 0, 0), (-5.0, 0, 0), 9.0, curve=hs.TensionCurve(line, 100000.0 * line)
        ),
    }
    body = block(1e5, ("surge", "heave"), position=moving(heave=-0.1))
    run = hs.simulate(scene(body, forces, 0.5, 0.1, step=0.01))
    used = [name for name in channel_names(run) if name.startswith("utilisation.")]
    assert used == ["utilisation.pad 1", "utilisation.pad 2", "utilisation.line"]
    force = run.fender_normal_force.sel(fender="pad 2")
    np.testing.assert_allclose(channel_series(run, "utilisation.pad 2")[0], force / 3e6)
    tension = run.spring_tension.sel(spring="line")
    assert float(tension.max()) > 0.5e5
    loads = {load.unit: load for load in largest_loads(run)}
    assert [*loads] == ["pad 1", "pad 2", "line"]
    assert loads["line"].largest == float(tension.max())
    assert loads["line"].time == float(run.time[int(tension.argmax())])
    np.testing.assert_allclose(channel_series(run, "utilisation.line")[0], tension / 2e5)


def test_a_message_names_the_kinds_of_many_channels() -> None:
    many = [f"kind_{k}.{n}" for k in "ab" for n in range(40)]
    with pytest.raises(InputError) as error:
        match_channels(many, ["kind_c.1"], "--channels")
    assert "expected one of: kind_a.*, kind_b.*" in str(error.value)
    with pytest.raises(InputError) as error:
        match_channels(many, ["kind_a.x*"], "--channels")
    assert "kind_a.39" in str(error.value)
    assert "kind_b.0" not in str(error.value)
