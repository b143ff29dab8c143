"""Mooring lines read from files of MoorDyn and MoorPy, or refused."""

import re
from collections.abc import Callable
from dataclasses import replace
from math import cos, pi, radians, sin
from pathlib import Path

import numpy as np
import pytest
import yaml
from text_tables import rows
from validation_data import unpacked

import hydrosim as hs
from hydrosim.analysis.line import lines_of_system
from hydrosim.case.lines.chains import (
    case_keys,
    mooring_lines,
    read_mooring_system,
    water_of_system,
)
from hydrosim.case.lines.system import MooringLine
from hydrosim.case.load import load_case
from hydrosim.elements.line.hang import pieces_of_segments
from hydrosim.errors import InputError
from hydrosim.files.text import Source
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene.catenary import Catenary

SEMI_TAUT = unpacked("lines/semi_taut.txt")
TYPES = """\
--- LINE TYPES ---
Name Diam MassDen EA BA/-zeta EI Cd Ca CdAx CaAx
(-) (m) (kg/m) (N) (N-s/-) (N-m^2) (-) (-) (-) (-)
chain 0.1 100 1e9 -1 {EI} 1.2 1 0.2 0
rope 0.2 30 1e8|2e8 -1 0 1.0 1 0.2 0
"""
POINTS = """\
--- POINTS ---
Node Type X Y Z M V FX FY FZ CdA CA
(-) (-) (m) (m) (m) (kg) (m^3) (kN) (kN) (kN) (m^2) (-)
1 Fixed 600 0 -100 0 0 0 0 0 0 0
2 Connect 200 0 -80 {mass} {volume} 0 0 {force} 0 0
3 Vessel 20 0 -5 0 0 0 0 0 0 0
4 Vessel 20 10 -5 0 0 0 0 0 0 0
"""
LINES = """\
--- LINES ---
Line LineType AttachA AttachB UnstrLen NumSegs Outputs
(-) (-) (-) (-) (m) (-) (-)
1 chain 1 2 420 20 -
2 rope 2 3 190 20 -
"""
OPTIONS = """\
--- SOLVER OPTIONS ---
100 WtrDpth
1025 rho
0.4 FrictionCoefficient
--- need this line ---
"""
VERSION_1 = """\
MoorDyn input file
--- LINE DICTIONARY ---
LineType Diam MassDenInAir EA BA/-zeta Can Cat Cdn Cdt
(-) (m) (kg/m) (N) (Pa-s/-) (-) (-) (-) (-)
chain 0.1 100 1e9 -1 1 0 1.2 0.2
rope 0.2 30 1e8 -1 1 0 1.0 0.2
--- NODE PROPERTIES ---
Node Type X Y Z M V FX FY FZ CdA CA
(-) (-) (m) (m) (m) (kg) (m^3) (kN) (kN) (kN) (m^2) (-)
1 Fix 600 0 -100 0 0 0 0 0 0 0
2 Connect 200 0 -80 3000 0.5 0 0 0 0 0
3 Vessel 20 0 -5 0 0 0 0 0 0 0
--- LINE PROPERTIES ---
Line LineType UnstrLen NumSegs NodeAnch NodeFair Flags/Outputs
(-) (-) (m) (-) (-) (-) (-)
1 chain 420 20 1 2 p
2 rope 190 20 2 3 p
--- SOLVER OPTIONS ---
100 WtrDpth
1025 rhoW
0.4 FrictionCoefficient
--- need this line ---
"""
MOORPY = """\
water_depth: 100
rho: 1025
line_types:
  - {name: chain, diameter: 0.1, mass_density: 100, stiffness: 1e9, transverse_drag: 1.2}
  - {name: rope, diameter: 0.2, mass_density: 30, stiffness: 1e8, transverse_drag: 1.0}
points:
  - {name: anchor, type: fixed, location: [600, 0, -100]}
  - {name: middle, type: free, location: [200, 0, -80], mass: 3000, volume: 0.5}
  - {name: fairlead, type: fairlead, location: [20, 0, -5]}
lines:
  - {name: 1, type: chain, endA: anchor, endB: middle, length: 420}
  - {name: 2, type: rope, endA: middle, endB: fairlead, length: 190}
"""
CASE = """\
title: moored
duration: 10 s
environment: {{water_depth: {depth}}}
bodies:
  fpso:
    mass: 1e6 kg
    radii_of_gyration: [5 m, 5 m, 5 m]
    centre_of_gravity: [1 m, 2 m, -3 m]
    location: [10 m, 5 m]
    heading: 30 deg
forces:
  mooring: {{type: lines, file: "{file}", body: fpso, capacity: 4 MN, breaks_at: 9 MN}}
"""


def version_2(EI: float = 0, mass: float = 3000, volume: float = 0.5, force: float = 0) -> str:
    """A file in the format of version 2."""
    points = POINTS.format(mass=mass, volume=volume, force=force)
    return "title\n" + TYPES.format(EI=EI) + points + LINES + OPTIONS


def written(folder: Path, text: str, name: str = "lines.txt") -> Path:
    """The text in a file."""
    path = folder / name
    path.write_text(text)
    return path


def lines_of(path: Path) -> dict[str, MooringLine]:
    """Its lines, in water of 1025 kg/m^3."""
    source = Source(path)
    system = read_mooring_system(source)
    assert system.depth == 100.0
    return mooring_lines(system, water_of_system(system, (1000.0, 9.81)), source)


@pytest.mark.parametrize(
    ("text", "name"), [(version_2(), "lines.txt"), (VERSION_1, "lines.dat"), (MOORPY, "lines.yaml")]
)
def test_formats(tmp_path: Path, text: str, name: str) -> None:
    """MoorDyn's versions and MoorPy's YAML give the same line: rope, clump, chain."""
    found = lines_of(written(tmp_path, text, name))
    assert list(found) == ["2"]
    line = found["2"]
    assert line.fairlead == (20.0, 0.0, -5.0)
    assert line.anchor == (600.0, 0.0, -100.0)
    rope, chain = line.segments
    assert (rope.length, rope.stiffness) == (190.0, 1e8)
    assert rope.drag == hs.LineDrag(coefficient=1.0, diameter=0.2)
    assert rope.weight == pytest.approx((30 - 1025 * pi / 4 * 0.2**2) * 9.81)
    assert rope.weight < 0.0  # it floats
    assert rope.hung == pytest.approx((3000 - 1025 * 0.5) * 9.81)
    assert (chain.length, chain.stiffness, chain.hung) == (420.0, 1e9, 0.0)
    assert chain.weight == pytest.approx((100 - 1025 * pi / 4 * 0.1**2) * 9.81)
    system = read_mooring_system(Source(tmp_path / name))
    assert system.friction == (0.0 if name.endswith("yaml") else 0.4)


def test_equilibrium_of_moorpy(validated: Callable[..., None]) -> None:
    """Lines in series: MoorPy 1.3.0 finds the free points of its own file by iteration."""
    found = {
        line.name: line.end_forces()
        for line in lines_of_system(read_mooring_system(Source(SEMI_TAUT)))
    }
    error = max(
        max(abs(found[name].H / H - 1.0), abs(found[name].V / V - 1.0))
        for name, H, V in (
            ("2", 945400.6201690922, 747355.2602907012),
            ("4", 945330.9268702156, 747319.0181364593),
            ("6", 945400.6201690922, 747355.2602907012),
        )
    )
    claim = "lines of rope and chain from MoorPy's file, pull at the fairlead"
    validated(Kind.PROGRAM, claim, "MoorPy 1.3.0", error, 1e-9, Feature.CATENARIES)


def test_chain_of_moordyn() -> None:
    """A chain in water 50 m deep: 991.6 kN at the fairlead by OrcaFlex, without friction."""
    (line,) = lines_of_system(read_mooring_system(Source(unpacked("lines/chain_50m.txt"))))
    assert line.friction == 0.5
    pull = replace(line, friction=0.0).end_forces()
    assert np.hypot(pull.H, pull.V) == pytest.approx(991.6e3, rel=0.015)


def test_case(tmp_path: Path) -> None:
    """A file is placed with the body of the case; points count from its centre of gravity."""
    path = written(tmp_path, CASE.format(depth="200 m", file=SEMI_TAUT), "case.yaml")
    forces = load_case(path).scene().forces
    assert list(forces) == ["mooring_2", "mooring_4", "mooring_6"]
    line = forces["mooring_4"]
    assert isinstance(line, Catenary)
    np.testing.assert_allclose(line.point, (-59.0, -2.0, -11.0))
    c, s = cos(radians(30)), sin(radians(30))
    np.testing.assert_allclose(line.anchor, (10 - 700 * c, 5 - 700 * s, -200))
    np.testing.assert_allclose([s.length for s in line.segments], (199.8, 497.702))
    assert line.friction == 0.0
    assert line.capacity == 4e6
    assert line.active is not None
    assert line.active.until is not None
    assert line.active.until.channel == "line_tension.mooring_4"


def test_keys(tmp_path: Path) -> None:
    """The keys of a file make the same elements as the file."""
    keys = yaml.safe_load(case_keys(SEMI_TAUT))
    text = CASE.format(depth="200 m", file=SEMI_TAUT).replace("1 m, 2 m, -3 m", "0 m, 0 m, 0 m")
    text = text.replace("10 m, 5 m", "0 m, 0 m").replace("30 deg", "0 deg")
    text = text.replace(", capacity: 4 MN, breaks_at: 9 MN", "")
    of_file = load_case(written(tmp_path, text, "file.yaml")).scene().forces
    whole = yaml.safe_load(text)
    whole["forces"] = keys["forces"]
    assert keys["environment"] == {"water_depth": "200 m"}
    path = written(tmp_path, yaml.dump(whole).replace("vessel", "fpso"), "keys.yaml")
    of_keys = load_case(path).scene().forces
    for name in ("2", "4", "6"):
        a, b = of_file[f"mooring_{name}"], of_keys[f"line_{name}"]
        for key in ("drag_width", "point", "anchor"):
            np.testing.assert_allclose(getattr(a, key), getattr(b, key), rtol=1e-11)
        one, other = (pieces_of_segments(line.segments) for line in (a, b))
        for key in ("length", "weight", "stiffness", "hung"):
            np.testing.assert_allclose(one[key], other[key], rtol=1e-11)


RODS = """\
--- RODS ---
ID RodType Attachment Xa Ya Za Xb Yb Zb NumSegs RodOutputs
(#) (name) (#/key) (m) (m) (m) (m) (m) (m) (-) (-)
1 can Free 0 0 -5 0 0 -10 4 p
"""
BODIES = """\
--- BODIES ---
ID Attachment X0 Y0 Z0 r0 p0 y0 Mass CG I Volume CdA Ca
(#) (-) (m) (m) (m) (deg) (deg) (deg) (kg) (m) (kg-m^2) (m^3) (m^2) (-)
1 CoupledPinned 0 0 0 0 0 0 1e6 0 0 1000 0 0
"""
FAILURE = """\
--- FAILURE ---
FailurePoint Line(s) FailTime FailTen
() (,) (s) (N)
3 2 30 0
"""


REFUSED = r"""
  1e9 | table.txt | found "table.txt"; expected a number for EA
  100 WtrDpth | bed.txt WtrDpth | found "bed.txt"; expected a numb
  END | 3 rope 2 4 190 20 -\nEND | found a bridle: lines 1
  Connect | Body2 | found points on Body2, the vessel; expected one
  Connect | Vessel | from one point of a body to another
  1 chain 1 2 420 20 -\n | | found the free end 2 of line 2
  2 rope 2 3 | 2 rope 2 9 | found no point at an end of line 2, "9"
  2 rope 2 3 | 2 hemp 2 3 | no line type of line 2, "hemp"
  2 rope 2 3 | 2 rope 2 R1A | found the end R1A of a rod
  190 | 0 | found 0 for the unstretched length of line 2; expected length in m; it must be above
  Connect | Pinned | found a point of type Pinned; expected Fixed
  END | RODSEND | lines.txt:22: found a rod; expected lines
  END | BODIESEND | \
    lines.txt:22: found a body that is CoupledPinned; expected coupled, fixed or free
  END | FAILUREEND | lines.txt:22: found a failure; expected none; the case has breaks_at
"""
REFUSED = REFUSED.replace("END", OPTIONS.replace("\n", r"\n"))


@pytest.mark.parametrize(("right", "wrong", "said"), rows(REFUSED))
def test_refused(tmp_path: Path, right: str, wrong: str, said: str) -> None:
    """What is no line of this kind is refused in words, with its line."""
    for name, section in (("RODS", RODS), ("BODIES", BODIES), ("FAILURE", FAILURE)):
        wrong = wrong.replace(name, section)
    text = version_2()
    assert right in text
    with pytest.raises(InputError, match=re.escape(said)):
        lines_of(written(tmp_path, text.replace(right, wrong)))


def test_a_force_and_another_file_are_refused(tmp_path: Path) -> None:
    """What is behind the end of a file is not read, as the programs do not."""
    assert list(lines_of(written(tmp_path, version_2() + "3 rope 2 4 190 20 -\n"))) == ["2"]
    with pytest.raises(InputError, match=r"lines.txt:11: found a force on point 2; expected 0"):
        lines_of(written(tmp_path, version_2(force=3)))
    with pytest.raises(InputError, match="found no section LINE TYPES; expected an input file of"):
        lines_of(written(tmp_path, "nothing\n"))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"depth": "150 m"}, "found depth 200 m there and water 150 m in the case"),
        ({"depth": "infinite"}, "found depth 200 m there and water without end in the case"),
        ({"file": "lines.txt"}, "forces.mooring.file: found no such file at"),
    ],
)
def test_case_refused(tmp_path: Path, changes: dict[str, str], said: str) -> None:
    """A file for other water, and none."""
    text = CASE.format(**{"depth": "200 m", "file": str(SEMI_TAUT), **changes})
    with pytest.raises(InputError) as caught:
        load_case(written(tmp_path, text, "case.yaml")).scene()
    assert said in str(caught.value)
