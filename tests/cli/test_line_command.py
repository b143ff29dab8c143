"""`hydrosim line` from the command line."""

from functools import partial
from pathlib import Path

import pytest
from command_line import Command, refusal, succeeds
from validation_data import unpacked

FILE = unpacked("lines/semi_taut.txt")
LINE = """
    type: catenary
    body: block
    point: [0 m, 0 m, 0 m]
    segments: [{length: 280 m, weight: 1 kN/m, stiffness: 800 MN}]
"""
CASE = f"""
title: moored
duration: 10 s
environment: {{water_depth: 60 m}}
bodies:
  block: {{mass: 1e6 kg, radii_of_gyration: [5 m, 5 m, 5 m], dofs: [surge, sway, yaw]}}
forces:
  bow:{LINE}    anchor: [260 m, 0 m, -60 m]
    seabed: {{friction: 0}}
  stern:{LINE}    anchor: [-260 m, 0 m, -60 m]
    seabed: {{friction: 0.5}}
"""


@pytest.fixture
def line(hydrosim: Command) -> Command:
    """The command in a folder of its own, with a case."""
    Path("case.yaml").write_text(CASE)
    return partial(hydrosim, "line")


def test_file(line: Command) -> None:
    """All lines at rest, one over offsets, and a picture."""
    printed = succeeds(line, FILE)
    assert "2 60 1,205 945.4 747.4 38.33 945.4 318.3 697.5" in printed
    assert "6 -60" in printed
    assert "Offset of the fairlead away from the anchor" in printed
    assert "Offset of the fairlead upward" in printed
    assert Path("semi_taut_line.png").stat().st_size > 1e4
    other = line(FILE, "--line", "4", "--offset", "5 m", "-o", "four.png")
    assert "4 180 1,205" in other.out
    assert "6 -60" not in other.out
    assert "-5.0" in other.out
    assert Path("four.png").exists()


def test_case(line: Command) -> None:
    """Lines of a case, with its bodies as they start; friction is explained on demand."""
    printed = succeeds(line, "case.yaml", "--line", "stern", "--verbose")
    assert "moored: line stern" in printed
    assert "With friction on the seabed the pull has no potential" in printed
    table = printed.split("Offset of the fairlead away from the anchor")[1].split("upward")[0]
    assert "stiffness [MN/m]" in table  # the case writes MN
    assert Path("case_line.png").exists()


def test_keys(line: Command) -> None:
    """`--case` prints keys alone."""
    keys = "line_2: type: catenary body: vessel point: [29 m, 50.23 m, -14 m]"
    assert keys in succeeds(line, FILE, "--case")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["case.yaml", "--line", "aft"], "--line: found aft; expected one of bow, stern"),
        (["case.yaml", "--case"], "--case: found case.yaml, a case; expected a file of MoorDyn"),
        ([FILE, "--set", "a=1"], "is no case; expected a case"),
        ([FILE, "--offset", "5 kN"], "--offset: found"),
        (["none.txt"], "none.txt: there is no such file; expected a case file (YAML), or an"),
    ],
)
def test_refused(line: Command, arguments: list[str], said: str) -> None:
    """Mistakes are told in words."""
    assert said in refusal(line, Path(), *arguments)
