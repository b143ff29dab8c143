"""One line in all documented layouts of mooring files; what is not read is told or refused."""

import re
from pathlib import Path

import mooring_files as files
import numpy as np
import pytest
from text_tables import rows

import hydrosim as hs
from hydrosim.case.lines.chains import (
    case_keys,
    mooring_lines,
    read_mooring_system,
    water_of_system,
)
from hydrosim.case.lines.system import MooringLine, System
from hydrosim.case.load import load_case
from hydrosim.compile.compile import compile_scene
from hydrosim.errors import InputError
from hydrosim.files.text import Source

CASE = """\
title: moored
duration: 1 s
environment: {water_depth: 100 m}
bodies:
  float:
    mass: 1e6 kg
    radii_of_gyration: [5 m, 5 m, 5 m]
forces:
  spring:
    {type: linear_mooring, body: float, stiffness: {surge: 10 kN/m, sway: 10 kN/m, heave: 1 MN/m,
     roll: 1 GN*m/rad, pitch: 1 GN*m/rad, yaw: 1 GN*m/rad}}
  mooring: {type: lines, file: lines.txt, body: float}
"""


def system_of(folder: Path, text: str, name: str = "lines.txt") -> System:
    """The mooring system in a text."""
    path = folder / name
    path.write_text(text)
    return read_mooring_system(Source(path))


def only_line(system: System) -> MooringLine:
    """The one line of a system."""
    water = water_of_system(system, (1025.0, 9.81))
    (line,) = mooring_lines(system, water, Source(system.file)).values()
    return line


@pytest.mark.parametrize(
    ("text", "name"),
    [
        (files.version_2(), "lines.txt"),
        (files.version_2(options="depth = 100"), "lines.txt"),
        (files.version_2(options="WtrDpth=100"), "lines.txt"),
        (files.version_2(options="depth 100 m"), "lines.txt"),
        (files.version_2(options="100 WtrDpth ! of water\n# 50 WtrDpth"), "lines.txt"),
        (files.version_2(fairlead="Body1 5 0 -10"), "lines.txt"),
        (files.version_2(fairlead="Turbine1 5 0 -10"), "lines.txt"),
        (files.DOCUMENTED_1, "lines.dat"),
        (files.COUNTED_1.format(ends="NodeAnch NodeFair"), "lines.dat"),
        (files.COUNTED_1.format(ends="NodeA NodeB"), "lines.dat"),
        (files.MOORPY_YAML, "lines.yaml"),
        (files.RAFT_YAML, "lines.yaml"),
    ],
)
def test_layouts(tmp_path: Path, text: str, name: str) -> None:
    system = system_of(tmp_path, text, name)
    line = only_line(system)
    assert line.fairlead == (5.0, 0.0, -10.0)
    assert line.anchor == (500.0, 0.0, -100.0)
    (segment,) = line.segments
    weight = (80.0 - 1025.0 * np.pi / 4.0 * 0.1**2) * 9.81
    assert segment.weight == pytest.approx(weight, rel=1e-12)
    assert (segment.length, segment.stiffness) == (530.0, 400e6)
    assert segment.drag == hs.LineDrag(coefficient=1.6, diameter=0.1)
    assert segment.hung == 0.0
    assert system.depth == 100.0
    assert system.left_out == ()


@pytest.mark.parametrize(
    ("body", "fairlead", "expected"),
    [
        ("coupled 50 -3 -0.5 0 0 0", (5.0, 0.0, -10.0), (55.0, -3.0, -10.5)),
        ("vessel 1 0 0 0 0 90", (0.0, -4.0, -10.0), (5.0, 0.0, -10.0)),
        ("coupled 0 0 0 0 -90 0", (10.0, 2.0, 5.0), (-5.0, 2.0, 10.0)),
        ("coupled 0 0 0 90 0 0", (1.0, 2.0, 3.0), (1.0, -3.0, 2.0)),
    ],
)
def test_the_place_of_a_coupled_body(
    tmp_path: Path,
    body: str,
    fairlead: tuple[float, float, float],
    expected: tuple[float, float, float],
) -> None:
    """Yaw turns +x to +y; a positive pitch lowers the bow; a positive roll lowers starboard."""
    point = "Body1 " + " ".join(map(str, fairlead))
    system = system_of(tmp_path, files.version_2(point, f"{body} 0 0 0 0 0 0"))
    assert only_line(system).fairlead == pytest.approx(expected, abs=1e-12)


def test_points_of_a_fixed_body_are_on_the_earth(tmp_path: Path) -> None:
    text = files.version_2(body="fixed 400 0 0 0 0 0 0 0 0 0 0 0")
    system = system_of(tmp_path, text.replace("1     Fixed      500", "1     Body1  100"))
    assert only_line(system).anchor == (500.0, 0.0, -100.0)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ("3 stiffening", ["the option stiffening 3 in line 32"]),
        ("onlyname", ["the option onlyname in line 32"]),
        ("7 WaveKin", ["the option wavekin 7 in line 32"]),
        ("0 WaveKin", []),
        ("0.3 MU_KT", ["the option mu_kt 0.3 in line 32"]),
        ("0 SeafloorFile", []),
    ],
)
def test_options_that_are_not_read_are_told(tmp_path: Path, options: str, told: list[str]) -> None:
    text = files.version_2(options=f"{options}\n{files.DEPTH}")
    system = system_of(tmp_path, text)
    assert [each.found for each in system.left_out] == told
    (tmp_path / "case.yaml").write_text(CASE)
    warned = compile_scene(load_case(tmp_path / "case.yaml").scene()).notes.warnings
    assert [f"forces.mooring.file: found {each}" in "".join(warned) for each in told] == [
        True
    ] * len(told)
    if told:
        assert f"# Left out: found {told[0]}; it is left out." in case_keys(tmp_path / "lines.txt")
        assert "accept: [files]" in "".join(warned)
        (tmp_path / "case.yaml").write_text(CASE + "accept: [files]\n")
        quiet = compile_scene(load_case(tmp_path / "case.yaml").scene()).notes.warnings
        assert "option" not in "".join(quiet)


def test_friction_is_that_along_the_line(tmp_path: Path) -> None:
    """MU_KA is axial, MU_KT transverse (MoorDyn-F)."""
    options = f"0.7 MU_KT\n0.4 MU_KA\n{files.DEPTH}"
    assert system_of(tmp_path, files.version_2(options=options)).friction == 0.4


def test_bending_stiffness_is_left_out_if_it_is_accepted(tmp_path: Path) -> None:
    system = system_of(tmp_path, files.version_2(EI="2e4"))
    assert only_line(system).segments[0].stiffness == 400e6
    (tmp_path / "case.yaml").write_text(CASE)
    with pytest.raises(InputError) as caught:
        compile_scene(load_case(tmp_path / "case.yaml").scene())
    assert "forces.mooring.file: found EI of 20000 N m^2 for main in line 6" in str(caught.value)
    assert "accept: [bending]" in str(caught.value)
    (tmp_path / "case.yaml").write_text(CASE + "accept: [bending]\n")
    compile_scene(load_case(tmp_path / "case.yaml").scene())


def test_a_free_body_is_that_of_the_case(tmp_path: Path) -> None:
    """As MoorPy's page on input files has it."""
    text = files.version_2("Body1 5 0 -10", "free 0 0 0 0 0 0 1e6 0 0 1e3 0 0")
    system = system_of(tmp_path, text)
    assert only_line(system).fairlead == (5.0, 0.0, -10.0)
    assert [each.found for each in system.left_out] == ["the free body 1 in line 14"]


BASES = {
    "MAP": files.MAP,
    "BA": files.MAP.replace("CB ", "BA "),
    "rows": files.MAP.replace("CB ", "BA ").replace("#", "0"),
    "2": files.version_2(),
    "1": files.DOCUMENTED_1,
    "counted": files.COUNTED_1.format(ends="NodeA NodeB"),
    "YAML": files.MOORPY_YAML,
}
REFUSED = r"""
  MAP | | | :2: found the column CB, so this is an input file of MAP++; expected
  BA | | | :8: found depth, so this is an input file of MAP++; expected one of MoorDyn
  rows | depth | -100 | :11: found no column NumSegs, so this is an input file of MAP++
  2 | DEPTH | seabed.txt SeafloorFile | \
    :32: found seafloorfile seabed.txt; expected a level seabed, by WtrDpth
  2 | DEPTH | DEPTH\n90 depth | \
    :33: found depth 90; expected 100 again, as in line 32, or one of both
  2 | DEPTH | -1 FrictionCoefficient | \
    :32: found -1 for frictioncoefficient; expected coefficient of friction; it
  2 | DEPTH | nan rho | :32: found nan for rho; expected density in kg/m^3; give a finite number
  2 | 0.1     80.0 | 1e200   80.0 | \
    :6: found 1e200 for the diameter; expected diameter in m; it must be 1e+07
  2 | Coupled    5 | Body2 5 | :22: found a point on Body2; expected one of the bodies: Body1
  2 | OWN_BODY | coupled 0 0 0 5 0 10 0 0 0 0 0 0 | \
    :14: found rotations about several axes; expected one of r0, p0, y0
  2 | 1.6    1      1.0     0.5 | 1.6    1      1.0 | \
    :6: found 9 values under 12 names of columns; expected a value in each
  1 | (-)      (-)       (m)         (-)       (-)  | 1 2 3 4 5 | \
    :15: found numbers; expected the units of the columns
  counted | 2       NConnects | 3 NConnects | \
    :10: CONNECTION PROPERTIES: found 2 rows and the count 3; expected the same
  counted | NodeA NodeB | Start End | \
    :15: LINE PROPERTIES: found line linetype unstrlen numsegs start end flags/outputs; expected a
  1 | 2         Vessel | 1         Vessel | :12: found point 1 twice; expected each once
  1 | -- LINE PROPERTIES | -- POINT PROPERTIES | \
    :13: found a second section POINT PROPERTIES; expected one, as in line 8
  YAML | - {name: anchor1 | - [anchor1]\n  - {name: anchor1 | \
    :8: points.0: found a list of 1; expected a mapping
  YAML | location: [5, 0, -10] | location: 5 | :9: points.1.location: found 5; expected three
  YAML | [5, 0, -10] | [5, 0, true] | :9: found true for points.1.location.2; expected
  YAML | diameter: 0.1 | diameter: 1e200 | :4: found 1e+200 for line_types.0.diameter; expe
  YAML | stiffness: 400e6 | stiffness: ~ | :4: line_types.0: found name, diameter, mass_dens
  YAML | name: main | name: {a: 1} | :4: line_types.0.name: found
  YAML | length: 530 | length: [1] | :11: found a list of 1 for lines.0.length; expected length
  YAML | type: vessel | type: 3 | :9: points.1.type: found
  YAML | water_depth: 100 | water_depth: [1] | \
    :1: found a list of 1 for water_depth; expected depth
  YAML | name: fairlead1 | name: anchor1 | :9: points.1.name: found anchor1 twice; expected
  YAML | endA: anchor1 | endA: 2 | found no point at an end of line 1, "2"
"""


@pytest.mark.parametrize(
    ("base", "right", "wrong", "said"),
    rows(REFUSED.replace("DEPTH", files.DEPTH).replace("OWN_BODY", files.OWN_BODY)),
)
def test_refused(tmp_path: Path, base: str, right: str, wrong: str, said: str) -> None:
    assert right in BASES[base]
    text = BASES[base].replace(right, wrong) if right else BASES[base]
    name = "lines.yaml" if base == "YAML" else "lines.txt"
    said = f"{name}{said}" if said.startswith(":") else said
    with pytest.raises(InputError) as caught:
        only_line(system_of(tmp_path, text, name))
    assert said in str(caught.value)


def test_unknown_keys_of_yaml_are_told(tmp_path: Path) -> None:
    text = files.MOORPY_YAML.replace("length: 530", "length: 530, EI: 3").replace(
        "rho: 1025.0", "rho: 1025.0\nbathymetry: bed.txt"
    )
    told = [each.found for each in system_of(tmp_path, text, "lines.yaml").left_out]
    assert told == ["the key bathymetry in line 3", "the key lines.0.EI in line 12"]


def chain_of(count: int) -> str:
    """A line of so many pieces in series, from the anchor to the vessel."""
    head, _, rest = files.DOCUMENTED_1.partition("1         Fixed")
    _, middle, tail = rest.partition("-------------------------- LINE PROPERTIES")
    points = ["1 Fixed 500 0 -100 0 0 0 0 0 0 0", f"{count + 1} Vessel 5 0 -10 0 0 0 0 0 0 0"]
    points += [f"{k} Connect 100 0 -50 0 0 0 0 0 0 0" for k in range(2, count + 1)]
    titles = tail.splitlines()[:3]
    lines = [f"{k} main {530 / count} 5 {k} {k + 1} p" for k in range(1, count + 1)]
    return "\n".join([head + points[0], *points[1:], middle + titles[0], *titles[1:], *lines, ""])


@pytest.mark.parametrize(
    ("count", "said"),
    [
        (100, ""),
        (101, "found 101 lines in series from line 101; expected at most 100; join those"),
        (1001, "found 1,001 lines; expected at most 1,000"),
        (100_000, "bytes; expected at most 5,000,000 in an input file of MoorDyn"),
    ],
)
def test_sizes_are_bounded(tmp_path: Path, count: int, said: str) -> None:
    text = chain_of(count)
    if not said:
        assert len(only_line(system_of(tmp_path, text)).segments) == count
        return
    with pytest.raises(InputError) as caught:
        only_line(system_of(tmp_path, text))
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("text", "name"),
    [
        (files.version_2(), "lines.txt"),
        (files.version_2("Body1  5  0  -10", "coupled 0 0 0 0 0 90 0 0 0 0 0 0"), "lines.txt"),
        (files.DOCUMENTED_1, "lines.txt"),
        (files.COUNTED_1.replace("{ends}", "NodeAnch NodeFair"), "lines.txt"),
        (files.MOORPY_YAML, "lines.yaml"),
    ],
)
def test_no_other_name_changes_what_is_read(tmp_path: Path, text: str, name: str) -> None:
    """Names of sections, columns, options, types, keys."""

    def read(text: str) -> tuple[str, set[str]]:
        system = system_of(tmp_path, text, name)
        found = repr((only_line(system), system.depth, system.friction, system.density))
        return found, {entry.message for entry in system.left_out}

    right, told = read(text)
    words = re.split(r"([\s,{}:]+)", text)
    for k in [k for k, word in enumerate(words) if re.match(r"[A-Za-z]", word)]:
        for other in (f"{words[k]}x", "other"):
            try:
                found, told_now = read("".join([*words[:k], other, *words[k + 1 :]]))
            except InputError:
                continue
            assert found == right or not told_now <= told, f"{words[k]} -> {other}"


def test_a_remark_behind_the_columns_makes_no_file_of_map(tmp_path: Path) -> None:
    text = files.version_2().replace("20       p\n", "20       p   # shared line\n")
    assert only_line(system_of(tmp_path, text)).segments[0].length == 530.0
    text = files.DOCUMENTED_1.replace("NumSegs", "NumNodes")
    assert only_line(system_of(tmp_path, text)).segments[0].length == 530.0


def test_stiffness_under_fast_loads_is_told(tmp_path: Path) -> None:
    system = system_of(tmp_path, files.version_2().replace("400e6", "400e6|600e6|9e6"))
    assert only_line(system).segments[0].stiffness == 400e6
    (told,) = [entry.message for entry in system.left_out]
    assert told.startswith("found EA of 600e6|9e6 under fast loads for main in line 6; it is left")
