"""`hydrosim ballast` from the command line."""

import re
from functools import partial
from pathlib import Path

import pytest
from command_line import Command, refusal, succeeds

ROOT = Path(__file__).parents[2]
CASE = f"""
title: tanks
duration: 1 hour
environment: {{water_depth: infinite}}
bodies:
  barge:
    hydrodynamics: {ROOT / "hydro_db" / "h851.nc"}
    mass: 1.56758e8 kg
    centre_of_gravity: [0 m, 0 m, -4.9 m]
    radii_of_gyration: [22.05 m, 67.6 m, 68.9 m]
    tanks:
      fore: {{box: [[10 m, -28 m, -12 m], [70 m, 28 m, 2 m]], level: 9 m}}
      aft: {{box: [[-70 m, -28 m, -12 m], [-10 m, 28 m, 2 m]], level: 9 m}}
    pumps:
      fore: {{source: fore, target: sea, rate: 12000 tonne/hour}}
      aft: {{source: aft, target: sea, rate: 12000 tonne/hour}}
"""


@pytest.fixture
def ballast(hydrosim: Command) -> Command:
    """The command on the case, in a folder of its own."""
    Path("case.yaml").write_text(CASE)
    return partial(hydrosim, "ballast", "case.yaml")


def test_a_loading_condition_is_told_and_drawn(ballast: Command) -> None:
    printed = succeeds(ballast, "--time", "30 min", "--lift", "20000 tonne_force")
    assert "144,758,000" in printed  # kg, as the case writes: 156,758 t less twice 6000
    assert "9,796,337" in printed  # with the other 20,000 t, about the centre of flotation
    assert "10,203,663" in printed
    assert all(f"[{unit}]" in printed for unit in ("kg", "m", "deg", "t/hour"))
    assert "Mass matrix" not in printed
    again = ballast("--time", "30 min", "--verbose")
    assert "Mass matrix about the body's origin [kg, kg m, kg m^2]" in again.out
    assert Path("case_ballast.png").stat().st_size > 1e4


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--lift", "30000 tonne_force"], "% of this can be pumped on level keel"),
        (["--lift", "3 m"], "--lift: found"),
        (["--body", "topside"], "--body: found topside; expected one of barge"),
        (["--set", "bodies.barge.pumps.fore.source=hold"], "found hold, which is no tank"),
        (["--heel", "5"], "--heel: found 286.5 deg"),
    ],
)
def test_what_is_wrong_is_told(ballast: Command, arguments: list[str], said: str) -> None:
    assert said in refusal(ballast, Path(), *arguments)


def test_pumps_that_wait_for_events_are_told_and_meshes_drawn(ballast: Command) -> None:
    """A tank from the recipe of a box, drawn by its triangles; its pump has not begun."""
    event = "{channel: position.barge.heave, above: 0.3 m}"
    tank = f"{{recipe: {ROOT / 'hydro_db' / 'box.yaml'}, depth: 8 m, level: 3 m}}"
    settings = (f"pumps.fore.start={event}", f"tanks.fore={tank}")
    changes = [part for setting in settings for part in ("--set", f"bodies.barge.{setting}")]
    printed = succeeds(ballast, "--time", "1 hour", *changes)
    waiting = "These pumps wait for events and are taken as not started: bodies.barge.pumps.fore."
    assert f"warning {waiting}" in printed
    assert Path("case_ballast.png").stat().st_size > 10_000


TABLE = (
    "{level: 0.5 m, table: {level: [0 m, 14 m], volume: [0 m^3, 47040 m^3],"
    " centroid: [[40 m, 0 m, -12 m], [40 m, 0 m, -5 m]],"
    " longitudinal: [1.008e6 m^4, 1.008e6 m^4], transverse: [878080 m^4, 878080 m^4]}}"
)


def test_what_surfaces_take_at_a_heel_does_not_depend_on_the_heading(ballast: Command) -> None:
    found = []
    for heading in ("0 deg", "25 deg", "90 deg"):
        level = ("--heel", "5 deg", "--set", "bodies.barge.tanks.fore.level=0.5 m")
        printed = succeeds(ballast, *level, "--set", f"bodies.barge.heading={heading}")
        row = re.search(r" heel [\d.]+ [\d.]+ ([\d.]+) ", printed)
        assert row is not None
        found.append(float(row[1]))
    assert found[1:] == [found[0]] * 2
    assert found[0] > 1.0


def test_a_table_that_meets_bottom_or_top_at_the_heel_is_told(ballast: Command) -> None:
    for heel, told in (("0.5 deg", False), ("-5 deg", True)):
        printed = succeeds(ballast, "--heel", heel, "--set", f"bodies.barge.tanks.fore={TABLE}")
        assert ("tanks.fore: a table has upright walls" in printed) == told


def test_a_film_of_fluid_is_remarked(ballast: Command) -> None:
    """With 1 mm between walls 56 m apart: tan(heel) = 0.001 / 28."""
    done = ballast("--set", "bodies.barge.tanks.fore.level=1 mm")
    assert "tanks.fore: its surface meets bottom or top at 0.002 deg of heel" in done.out
    assert "tanks.aft: its surface" not in done.out
