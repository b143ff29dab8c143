"""`lightship`, `tanks` and `pumps` in a case file: what is built of them, and what is refused."""

from collections.abc import Callable
from pathlib import Path
from textwrap import indent

import numpy as np
import pytest
from numpy.testing import assert_allclose
from text_tables import rows

import hydrosim as hs
from hydrosim.database.build.barge import box
from hydrosim.database.build.recipe import barge_with_deck
from hydrosim.errors import InputError
from hydrosim.scene import Scene, Weight

DATABASES = Path(__file__).parents[2] / "hydro_db"
BARGE = """
title: tanks
duration: 1 hour
environment: {{water_density: 1000}}
bodies:
  barge:
    {mass}
    hydrodynamics:
      added_mass: {{surge: 1e5, sway: 1e5, heave: 1e6, roll: 1e7, pitch: 1e8, yaw: 1e7}}
      stiffness: {{heave: 5.0e6, roll: 6.0e7, pitch: 2.0e9}}
    tanks:
{tanks}
    pumps:
{pumps}
solver: {{step: 1 s}}
"""
LIGHTSHIP = (
    "lightship: {mass: 800 tonne, centre_of_gravity: [1, 0, 2], radii_of_gyration: [4, 13, 13]}"
)
TANKS = """\
wing: {box: [[-20 m, 2 m, -2 m], [10 m, -6 m, 3 m]], permeability: 98 %, density: 1000, level: 2 m}
peak:
  density: 1000
  level: 1 m
  free_surface: frozen
  table:
    level: [0, 2, 4]
    volume: [0, 80, 160]
    centroid: [[22, 0, -2], [22, 0, -1], [22, 0, 0]]
    longitudinal: [100, 100, 100]
    transverse: [500, 500, 500]
"""
PUMPS = """\
out: {source: wing, target: sea, rate: 200 tonne/hour, start: 60 s, stop: 30 min}
trim: {source: wing, target: peak, rate: 10 kg/s, start: {tank: wing, below: 1.9 m}}
"""
Load = Callable[..., Scene]


@pytest.fixture
def load(tmp_path: Path) -> Load:
    """A scene of the barge with parts of its text replaced."""

    def read(mass: str = LIGHTSHIP, tanks: str = TANKS, pumps: str = PUMPS) -> Scene:
        path = tmp_path / "case.yaml"
        parts = {"tanks": indent(tanks, " " * 6), "pumps": indent(pumps, " " * 6)}
        path.write_text(BARGE.format(mass=mass, **parts))
        return hs.load_case(path).scene()

    return read


def test_lightship_and_tanks_make_the_mass_of_the_body(load: Load) -> None:
    """By hand: a box of 30 x 8 m at 2 m, and 40 m^3 in the peak, about their common centre."""
    (body,) = load().bodies
    held = [(8e5, [1, 0, 2.0]), (0.98 * 480e3, [-5.0, -2.0, -1.0]), (40e3, [22.0, 0.0, -1.5])]
    mass = sum(m for m, _ in held)
    centre = sum(m * np.array(c) for m, c in held) / mass
    assert body.mass == pytest.approx(mass, rel=1e-12)
    assert_allclose(body.centre_of_gravity, centre, rtol=1e-12)
    own = [
        8e5 * np.square([4.0, 13.0, 13.0]),
        0.98 * 480e3 / 12.0 * np.array([8.0**2 + 2**2, 30**2 + 2**2, 30**2 + 8.0**2]),
        # area 40 m^2, 1 m high
        40e3 * np.array([500 / 40 + 1 / 12, 100 / 40 + 1 / 12, 600 / 40]),
    ]
    inertia = np.diag(sum(own))
    for m, c in held:
        d = np.array(c) - centre
        inertia += m * (d @ d * np.eye(3) - np.outer(d, d))
    assert_allclose(body.inertia, inertia, rtol=1e-12, atol=1e-3)
    assert body.weight == Weight.CARRIED


def test_a_case_with_pumps_runs(load: Load) -> None:
    """Mass falls by what is pumped; the peak takes what the wing gives."""
    run = hs.simulate(load())
    assert float(run.mass[0, 0] - run.mass[-1, 0]) == pytest.approx(200e3 / 3600 * 1740.0, rel=1e-9)
    begun = 60.0 + 0.98 * 240e3 * 0.1 / (200e3 / 3600)
    assert float(run.tank_level.sel(tank="peak of barge")[-1]) == pytest.approx(
        1.0 + 10.0 * (3600 - begun) / 40e3, rel=1e-6
    )


OUT = "out: {source: wing, target: sea, rate: 1}"


def write(path: Path, corners: np.ndarray) -> None:
    """Triangles (n, 3, 3) as a mesh file."""
    cells = [("triangle", np.arange(corners.size // 3).reshape(-1, 3))]
    pytest.importorskip("meshio").write_points_cells(path, corners.reshape(-1, 3), cells)


def test_a_tank_may_be_a_mesh_or_the_hull_of_a_recipe(load: Load, tmp_path: Path) -> None:
    """A box as a mesh in millimetres above its bottom, and from the recipe of a box."""
    corners = barge_with_deck(box(100.0, 20.0, 5.0), 8.0) + np.array([0.0, 0.0, 5.0])
    write(tmp_path / "tank.ply", corners * 1e3)
    own = "density: 1000, level: 2 m, permeability: 98 %}\n"
    forms = (
        "box: [[-50, -10, -5], [50, 10, 3]]",
        "mesh: tank.ply, scale: 0.001, waterline: 5 m",
        f"recipe: {DATABASES / 'box.yaml'}, depth: 8 m",
    )
    boxed, *others = (load(tanks=f"wing: {{{form}, {own}", pumps=OUT).bodies[0] for form in forms)
    for body in others:
        assert body.mass == pytest.approx(boxed.mass, rel=1e-6)
        assert_allclose(body.inertia, boxed.inertia, rtol=1e-6, atol=1.0)


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ("mesh: open.ply", r"tanks\.wing: .*open\.ply: found an open mesh.*Close the mesh"),
        ("mesh: none.ply", r"tanks\.wing: .*none\.ply: no such file"),
        ("mesh: open.ply, depth: 3 m", r"found depth of a mesh; expected it of a recipe"),
        ("level: 1 m", r"found none of them; expected one of box, table, mesh, recipe"),
    ],
)
def test_a_mesh_that_is_no_tank(load: Load, tmp_path: Path, keys: str, said: str) -> None:
    corners = barge_with_deck(box(100.0, 20.0, 5.0), 8.0)
    write(tmp_path / "open.ply", corners[corners[..., 2].min(axis=1) < 2.9])
    with pytest.raises(InputError, match=said):
        load(tanks=f"wing: {{{keys}}}\n", pumps=OUT)


def test_a_pump_by_an_event_is_the_pump_by_that_level(load: Load) -> None:
    by_event = PUMPS.replace("{tank: wing, ", "{channel: tank_level.wing of barge, ")
    assert by_event != PUMPS
    runs = [hs.simulate(load(pumps=pumps)) for pumps in (PUMPS, by_event)]
    levels, events = (run.tank_level.values for run in runs)
    assert_allclose(events, levels, atol=1e-9)
    assert [*runs[1].trigger.values] == ["trim of barge"]


UNPUMPABLE = r"""
  pumps | | out: {source: peak, target: sea, FLOW, stop: 50 min} | \
    pumps\.out: peak of barge runs dry at 360 s, before the pump stops
  pumps | | in: {source: sea, target: peak, FLOW, stop: 50 min} | \
    pumps\.in: peak of barge overflows at 1080 s
  pumps | | out: {source: tank, target: sea, FLOW} | \
    pumps\.out\.source: found tank, which is no tank; expected one of wing, peak, sea
  pumps | | out: {target: sea, FLOW} | pumps\.out: found no key "source"; expected one
  pumps | | out: {source: wing, target: sea, rate: 1, stop: {tank: wing, below: 3 m}} | \
    pumps\.out: has nothing to pump at 0 s: .* or its final level reached
  pumps | | out: {source: wing, target: sea, rate: 1, stop: {channel: level}} | \
    pumps\.out\.stop: found no value; expected either above or below
  pumps | below: 1.9 m | below: 9 m | \
    pumps\.trim\.start: found 9 m; expected 0 to 5 m, the height of the tank wing
  pumps | start: 60 s | start: 40 min | \
    pumps\.out\.stop: found 1800 s; expected a time after the start
  mass | | mass: 300 tonne\n    radii_of_gyration: [4, 13, 13] | \
    bodies\.barge: found 3e\+05 kg in all and 5\.104e\+05 kg in its tanks
  mass | lightship: | mass: 1000\n    lightship: | found lightship and mass; expected one of them
  mass | lightship: | weight: balanced\n    lightship: | weight: found balanced and tanks
  tanks | level: 2 m | level: 7 m | tanks\.wing\.level: found 7 m
  tanks | level: 2 m | level: 2, plan: {time: [1, 2], level: [1, 2]} | \
    tanks\.wing\.plan\.level: found 1 m at the first time
  tanks | 1000 | 1025 | fluids of 1025 and 1000 kg/m\^3
  tanks | longitudinal: [100, 100 | longitudinal: [100, -100 | \
    longitudinal.*found -100; expected a second moment of area.*0 or more
"""
RIGHT = {"mass": LIGHTSHIP, "tanks": TANKS, "pumps": PUMPS}
FLOW = "rate: 400 tonne/hour"


@pytest.mark.parametrize(("part", "right", "wrong", "said"), rows(UNPUMPABLE.replace("FLOW", FLOW)))
def test_what_cannot_be_pumped_is_refused(
    load: Load, part: str, right: str, wrong: str, said: str
) -> None:
    changed = RIGHT[part].replace(right, wrong, 1) if right else wrong
    with pytest.raises(InputError, match=said):
        hs.compile_scene(load(**{part: changed}))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"tanks": TANKS.replace("level: 1 m", "level: 0 m")}, "has nothing to pump at 0 s"),
        (
            {"mass": "mass: 2000 tonne\n    radii_of_gyration: [0.1, 0.1, 0.1]"},
            r"barge\.inertia, radii_of_gyration: found values .* of -\S+ kg m.* at 3600 s, with",
        ),
    ],
)
def test_a_tank_that_cannot_be_emptied(load: Load, changes: dict[str, str], said: str) -> None:
    with pytest.raises(InputError, match=said):
        hs.compile_scene(load(**changes, pumps=f"out: {{source: peak, target: sea, {FLOW}}}"))
