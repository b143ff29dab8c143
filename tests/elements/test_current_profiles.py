"""Currents that change over the depth, on hulls, dampers and loads."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scenes import block, catenary_of, moving, scene

import hydrosim as hs
from hydrosim.elements import CurrentLoad, LinearDamping, QuadraticDamping
from hydrosim.scene import CurrentPower, CurrentTable, Environment, Hull, Kinematics, Scene
from hydrosim.water import current

SHEARED = (0.0, 10.0, 30.0), (1.0, 0.5, 0.0), (0.0, 0.0, 0.0)
TWISTED = (0.0, 10.0, 30.0), (1.0, 0.5, 0.25), (0.0, np.pi / 2, np.pi / 2)
"""Depths, parts of the speed, and turns of the heading."""
Profile = tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]
HEADINGS = np.radians([0.0, 90.0, 180.0, 270.0])
LOAD = (HEADINGS, np.array([4e2, 0, -4e2, 0]), np.array([0, 4e2, 0, -4e2]), np.zeros(4))
DAMPING = np.diag([300.0, 300.0, 0, 0, 0, 0])


def sea(profile: Profile | None, speed: float = 2.0, heading: float = 0.3) -> Environment:
    """A current with a profile."""
    if profile is None:
        return Environment(current=hs.Current(speed, heading))
    depth, factor, turn = profile
    speeds = [speed * part for part in factor]
    table = CurrentTable(depth, speeds, [heading + angle for angle in turn])
    return Environment(current=hs.Current(profile=table))


def adrift(water: Environment, draught: float | None = None, **load: Any) -> Scene:
    """A block that the current drags along."""
    point = load.pop("point", (0.0, 0.0, -20.0))
    forces = {
        "load": CurrentLoad("block", point, *LOAD, **load),
        "drag": QuadraticDamping("block", DAMPING),
        "friction": LinearDamping("block", DAMPING, relative_to_current=True),
    }
    body = block(1e3, dofs=["surge", "sway"], draught=draught, velocity=moving(surge=0.4))
    return replace(scene(body, forces, 5.0, 0.5, step=0.05), environment=water)


def felt(still: Scene) -> dict[str, float]:
    """Speed of the current that each element of a scene feels."""
    e = hs.compile_scene(still).model.elements
    found = {"load": e.stream_loads, "drag": e.quadratic_dampings, "friction": e.linear_dampings}
    rows = {name: (p.each if name == "load" else p)[0] for name, p in found.items()}
    return {name: float(np.hypot(*row["stream"])) for name, row in rows.items()}


def test_means_and_values_by_hand() -> None:
    """2, 1 and 0 m/s at 0, 10 and 30 m: areas of trapezoids."""
    table = current.current_table(sea(SHEARED, heading=0.0))
    assert current.mean_current(table, 0.0, 20.0) == pytest.approx((22.5 / 20.0, 0.0), abs=1e-15)
    assert current.mean_current(table, 5.0, 40.0) == pytest.approx(
        ((6.25 + 10.0) / 35.0, 0.0), abs=1e-15
    )
    turned = current.current_table(sea(TWISTED, heading=0.0))
    assert current.mean_current(turned, 0.0, 10.0) == pytest.approx((1.0, 0.5), abs=1e-15)
    for depth in np.random.default_rng(2).uniform(-5.0, 40.0, 50):
        expected = [2.0 * max(1.0 - max(depth, 0.0) / 10.0, 0.0), 0.0]
        d = min(max(depth, 0.0), 30.0)
        expected[1] = 0.1 * d if d < 10.0 else 1.0 - 0.025 * (d - 10.0)
        assert current.current_at(turned, depth) == pytest.approx(expected, abs=1e-14)
        assert current.current_velocity(depth, turned) == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("exponent", [1.0 / 7.0, 0.5, 1.0, 2.0])
def test_power_law(exponent: float) -> None:
    """((D - d) / D)^a, and its mean 1 / (1 + a)."""
    law = hs.Current(1.0, profile=CurrentPower(exponent))
    table = current.current_table(Environment(water_depth=80.0, current=law))
    depth = np.linspace(0.0, 80.0, 4001)
    error = current.current_at(table, depth)[:, 0] - (1.0 - depth / 80.0) ** exponent
    assert np.abs(error).max() < 1e-3
    assert current.mean_current(table, 0.0, 80.0)[0] == pytest.approx(
        1.0 / (1.0 + exponent), abs=5e-4
    )
    with pytest.raises(hs.InputError, match="found a power law in water of infinite depth"):
        current.current_table(Environment(current=law))


def test_no_shear_is_the_uniform_current_to_the_bit() -> None:
    """Also without a draught."""
    same = (0.0, 3.0, 7.0), (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
    runs = [hs.simulate(adrift(sea(profile, 1.3))) for profile in (None, same)]
    for name in ("position", "velocity", "force_load", "force_drag"):
        assert np.array_equal(*(run[name].values for run in runs)), name


def test_current_on_each_element() -> None:
    """Over the draught; over the depths of a load; at its point where there is no draught."""
    table = current.current_table(sea(SHEARED))
    mean = float(np.hypot(*current.mean_current(table, 0.0, 8.0)))
    for speed in felt(adrift(sea(SHEARED), 8.0)).values():
        assert speed == pytest.approx(mean)
    own = felt(adrift(sea(SHEARED), 8.0, depth=(10.0, 30.0)))
    assert own == pytest.approx({"load": 0.5, "drag": mean, "friction": mean})
    hull = Hull(np.array([[[0.0, 0.0, -8.0], [1.0, 0.0, 2.0], [0.0, 1.0, 2.0]]]))
    load = {"load": adrift(sea(SHEARED)).forces["load"]}
    alone = replace(adrift(sea(SHEARED)), forces=load)
    point = hs.compile_scene(alone).model.elements.stream_loads.each[0]["stream"]
    assert np.hypot(*point) == pytest.approx(0.5)  # 20 m deep
    assert current.draught_of(replace(alone.bodies[0], hydrostatics=hull)) == 8.0


def test_current_on_a_line_is_the_mean_over_its_upper_half() -> None:
    """2 to 22 m deep: 1.8, 1, 0.9 m/s at 2, 10, 12 m; level lines feel that of their depth."""
    segment = (75.0, 300.0, 3e7, 0.0, 0.24)
    for anchor, expected in (((60.0, 0.0, -22.0), 1.31), ((60.0, 0.0, -2.0), 1.8)):
        line = catenary_of("block", (0.0, 0.0, -2.0), anchor, *segment)
        still = replace(scene(block(1e3), {"line": line}, 1.0, 0.1), environment=sea(SHEARED))
        stream = hs.compile_scene(still).model.elements.catenaries.lines[0]["stream"]
        assert np.hypot(*stream) == pytest.approx(expected)


@pytest.mark.parametrize("kinematics", Kinematics)
def test_a_block_adrift_comes_to_the_speed_it_feels(kinematics: Kinematics) -> None:
    """m v' = C (U - v): the mean over the draught, in magnitude and direction."""
    drag = {"drag": LinearDamping("block", DAMPING, relative_to_current=True)}
    body = block(1e3, dofs=["surge", "sway"], draught=10.0)
    still = scene(body, drag, 20.0, 1.0, step=0.05, kinematics=kinematics)
    run = hs.simulate(replace(still, environment=sea(TWISTED, heading=0.0)))
    part = 1.0 - np.exp(-0.3 * run.time.values)
    exact = np.outer(part, [1.0, 0.5])
    assert np.abs(run.velocity.values[:, 0, :2] - exact).max() < 1e-8


def test_a_current_with_shear_needs_a_draught() -> None:
    with pytest.raises(hs.InputError, match=r"bodies.block.draught: found none, and a current"):
        hs.compile_scene(adrift(sea(SHEARED)))
    above = adrift(sea(SHEARED), point=(0.0, 0.0, 2.0))
    above = replace(above, forces={"load": above.forces["load"]})
    with pytest.raises(hs.InputError, match=r"forces.load.depth: found none, a point 2 m above"):
        hs.compile_scene(above)
