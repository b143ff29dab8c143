"""Mistakes that engineers make: each is refused with file, line, key and remedy, or asked about."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest
from text_tables import rows

from hydrosim.case import load_case
from hydrosim.compile.compile import compile_scene
from hydrosim.database.build.recipe import load_recipe
from hydrosim.errors import InputError
from hydrosim.simulation import simulate
from hydrosim.study.sweep import load_study

CASE = """\
title: Box at a quay
duration: 20 s
environment:
  water_depth: 20 m
  waves: {spectrum: jonswap, significant_height: 1 m, peak_period: 6 s, heading: 30 deg}
bodies:
  box:
    mass: 1000 tonne
    inertia: {roll: 2e4 tonne*m^2, pitch: 9e4 tonne*m^2, yaw: 9e4 tonne*m^2}
    weight: carried
    dofs: [surge, sway, heave]
    initial: {position: {heave: 0.1 m}}
forces:
  floor:
    type: fender
    body: box
    points: [[5 m, 0, -2 m]]
    plane: {point: [0, 0, -2 m], normal: [0, 0, 1]}
    normal: {stiffness: 10000 kN/m, damping: 100 kN*s/m}
    friction: {law: stick_slip, static: 0.4, kinetic: 0.3, stiffness: 2000 kN/m, damping: 50 kN*s/m}
  mooring:
    type: linear_mooring
    body: box
    stiffness: {surge: 100 kN/m}
    damping_ratio: {surge: 10 %}
solver: {step: 0.01 s}
output: {step: 0.1 s}
"""
CRAWL = "{channel: position.box.surge, statistic: end}"
STUDY = """\
case: case.yaml
parameters:
  environment.waves.significant_height: [1 m, 1.5 m]
seeds: 1-4
figures:
  crawl: {channel: position.box.surge, statistic: end}
criteria:
  drift: {channel: position.box.surge, statistic: largest, limit: 1 m}
"""
RECIPE = """\
title: A box
hull: {type: box, length: 40 m, beam: 20 m, draught: 5 m}
centre_of_gravity: [0, 0, 0]
radii_of_gyration: [7 m, 11 m, 11 m]
frequencies: {start: 0.2 rad/s, stop: 1 rad/s, step: 0.1 rad/s}
headings: {start: 0 deg, stop: 180 deg, step: 45 deg}
"""
NO_DAMPING = "forces.floor: found normal.damping; expected stiffness, or compression and force"
CLEARANCES = "clearances: {a: {of: bow of box, to: b}}"
START_OF_LINE = "[0, 0, 0.1 m]}\n  mooring:"
HULL = "hull: {type: box, length: 40 m, beam: 20 m, draught: 5 m}"
LINE = "line: {type: spring, body: box, point: [0, 0, 0], length: 10 m, stiffness: 10 kN/m, anchor:"
BODY = "    weight: carried\n"
MISSING = "hydrodynamics: no.nc\n    centre_of_gravity: [0, 0, 0]"
NORMAL = "{stiffness: 10000 kN/m, damping: 100 kN*s/m}"
POINTS = "points: [[5 m, 0, -2 m]]"
FLOOR = """\
    type: fender
    body: box
    points: [[5 m, 0, -2 m]]
    plane: {point: [0, 0, -2 m], normal: [0, 0, 1]}
"""
LANDING = """\
    type: landing
    body: box
    points: [[5 m, 0, -2 m]]
    on: {points: [[5 m, 0, -2 m]]}
"""
START = "{position: {heave: 0.1 m}}"
ELEMENT = """\
  fender:
    type: fender
    body: box
    points: [[1 m, 0, 0]]
    plane: {point: [0, 0, 0], normal: [1, 0, 0]}
    normal: {stiffness: 1 kN/m}
    friction: {law: none}
    group: quay
    capacity: 3 kN
"""


class Mistake(NamedTuple):
    """What is written in place of what; the line and the words of the message."""

    right: str
    wrong: str
    line: int
    words: tuple[str, ...]


def mistake(right: str, wrong: str, line: int, *words: str) -> Mistake:
    return Mistake(right, wrong, line, words)


def meant(key: str, name: str) -> tuple[str, ...]:
    return (f"{key}: found", f'did you mean "{name}"?')


IN_CASES = [
    # words of the trade, capitals, typing errors
    mistake("jonswap", "JONSWAP", 5, *meant("environment.waves.spectrum", "jonswap")),
    mistake("jonswap", "JONSPWAP", 5, *meant("environment.waves.spectrum", "jonswap")),
    mistake("jonswap", "PM", 5, *meant("environment.waves.spectrum", "pierson_moskowitz")),
    mistake("significant_height", "Hs", 5, *meant("environment.waves.Hs", "significant_height")),
    mistake("peak_period", "Tp", 5, *meant("environment.waves.Tp", "peak_period")),
    mistake("6 s,", "6 s, gamma: 2,", 5, *meant("environment.waves.gamma", "peak_enhancement")),
    mistake("heading:", "direction:", 5, *meant("environment.waves.direction", "heading")),
    mistake("water_depth", "depth", 4, *meant("environment.depth", "water_depth")),
    mistake("water_depth: 20 m", "rho: 1025", 4, *meant("environment.rho", "water_density")),
    mistake("inertia:", "kxx:", 9, *meant("bodies.box.kxx", "radii_of_gyration")),
    mistake(BODY, "    cog: [0, 0, 0]\n", 10, *meant("bodies.box.cog", "centre_of_gravity")),
    mistake(BODY, "    CoG: [0, 0, 0]\n", 10, *meant("bodies.box.CoG", "centre_of_gravity")),
    mistake("inertia:", "Inertia:", 9, *meant("bodies.box.Inertia", "inertia")),
    mistake("duration:", "Duration:", 2, *meant("Duration", "duration")),
    mistake("step: 0.01 s", "dt: 0.01 s", 26, *meant("solver.dt", "step")),
    mistake("step: 0.01 s", "method: RK4", 26, *meant("solver.method", "rk4")),
    mistake("type: fender", "type: Fender", 15, *meant("forces.floor.type", "fender")),
    mistake("linear_mooring", "mooring", 22, *meant("forces.mooring.type", "linear_mooring")),
    mistake("linear_mooring", "pto", 22, *meant("forces.mooring.type", "power_take_off")),
    mistake("linear_mooring", "rod", 22, *meant("forces.mooring.type", "strut")),
    mistake("linear_mooring", "hawser", 22, *meant("forces.mooring.type", "spring")),
    mistake("linear_mooring", "chain", 22, *meant("forces.mooring.type", "catenary")),
    mistake("static:", "mu:", 20, *meant("forces.floor.friction.mu", "static")),
    mistake("static:", "coefficient:", 20, *meant("friction.coefficient", "static")),
    mistake("{spectrum: jonswap, ", "{", 5, "to say which kind this is: jonswap, pierson"),
    mistake("stick_slip", "Coulomb", 20, *meant("forces.floor.friction.law", "coulomb")),
    mistake("{surge: 100", "{x: 100", 24, *meant("forces.mooring.stiffness.x", "surge")),
    mistake("[surge, sway", "[Surge, sway", 11, *meant("bodies.box.dofs", "surge")),
    mistake("forces:", "elements:", 13, *meant("elements", "forces")),
    mistake(POINTS, "point: [5 m, 0, 0]", 17, *meant("forces.floor.point", "points")),
    mistake(f"initial: {START}", "radiation: states", 12, *meant("box.radiation", "state_space")),
    # names
    mistake("body: box", "body: Box", 16, *meant("forces.floor.body", "box")),
    mistake("body: box", "body: barge", 16, "forces.floor.body", "a body of this case: box"),
    mistake("  mooring:", "  floor:", 21, 'key "floor" twice', "line 14", "remove one"),
    mistake("  mooring:", "  weight:", 21, "forces.weight", "expected another"),
    mistake("  box:", "  box 1:", 7, "bodies.box 1", "letters, digits and _"),
    # units
    mistake("1000 tonne", "9810 kN", 8, "bodies.box.mass", "divide a weight by 9.81"),
    mistake("1000 tonne", "1000 tons", 8, "bodies.box.mass", "tons differ; write tonne"),
    mistake("1000 tonne", "1,000 tonne", 8, "bodies.box.mass", "a number has no comma"),
    mistake("1000 tonne", "-1000 tonne", 8, "bodies.box.mass", "must be above 0"),
    mistake("10000 kN/m", "1000 t/m", 19, "forces.floor.normal.stiffness", "is in tonne_force"),
    mistake("{surge: 100 kN/m}", "{surge: 100 kN}", 24, "mooring.stiffness.surge", "in N/m"),
    mistake("20 s", "00:00:20", 2, "duration", "write 600 s or 10 min"),
    mistake("heading: 30 deg", "heading: 30 m", 5, "environment.waves.heading", "an angle in rad"),
    mistake("water_depth: 20 m", "water_depth: deep", 4, "water_depth", '"infinite"'),
    # forms
    mistake(POINTS, "points: [5 m, 0, 0]", 17, "forces.floor.points", "[[5 m, 0, 0]]"),
    mistake(POINTS, "points: [[5 m, 0]]", 17, "forces.floor.points.0", "a list of 2", "3 values"),
    mistake("[surge, sway, heave]", "surge, sway", 11, "box.dofs", "[surge, sway]"),
    mistake("normal: [0, 0, 1]", "normal: up", 18, "floor.plane.normal", "a list"),
    mistake("normal: [0, 0, 1]", "normal: [0, 0, 0]", 18, "floor.plane", "to the free side"),
    mistake(NORMAL, "10000 kN/m", 19, "floor.normal", "a mapping with some of stiffness"),
    mistake(NORMAL, "{compression: [0, 1], force: [0]}", 19, "floor.normal", "at least two"),
    mistake("static: 0.4", "static: 0.2", 20, "floor.friction", "static >= kinetic"),
    mistake("{surge: 100 kN/m}", "{surge: -100 kN/m}", 24, "mooring.stiffness", "0 or more"),
    mistake("  water", "  wind: 12 m/s\n  water", 4, "environment.wind", "the key speed"),
    mistake("step: 0.1 s", "step: 0.015 s", 27, "output.step", '"0.02 s" is one'),
    mistake(START, "{position: [0, 0, 0]}", 12, "box.initial.position", "expected 6 values"),
    mistake("    type: fender\n", "", 14, "forces.floor", 'no key "type"'),
    mistake("duration: 20 s\n", "", 1, 'found no key "duration"', "a time in s"),
    mistake(FLOOR, LANDING, 14, NO_DAMPING, "only the normal of a fender"),
    # the wrong place, the wrong file
    mistake("forces:\n", f"{ELEMENT}forces:\n", 13, "bodies.fender", 'move it below "forces:"'),
    mistake("  floor:", "  b: {mass: 1}\n  floor:", 14, "forces.b", 'move it below "bodies:"'),
    mistake(CASE, STUDY, 1, "a study", "hydrosim study"),
    mistake(BODY, "    hydrodynamics: no.nc\n", 7, "bodies.box", "no centre_of_gravity"),
    mistake(
        BODY, f"    {MISSING}\n", 10, "hydrodynamics: found no such file", "relative paths begin"
    ),
    mistake(BODY, "    hydrodynamics: {fil: a.nc}\n", 10, *meant("hydrodynamics.fil", "file")),
    mistake(BODY, "    hydrostatics: hull.stl\n", 10, "box.hydrostatics", "{mesh: hull.stl}"),
    # YAML
    mistake("    body: box", "\tbody: box", 16, "found a tab", "two blanks"),
    mistake("    dofs", "   dofs", 11, "another column", "mend the blanks"),
    mistake("    dofs", "      dofs", 11, "another column", "mend the blanks"),
    mistake("  mooring:", " mooring:", 21, '"mooring:" in column 2', '3, as "floor:" in line 14'),
    mistake("  floor:", " floor:", 14, '"floor:" in column 2', '3, as "mooring:" in line 21'),
    mistake("duration:", " duration:", 2, '"duration:" in column 2', "column 1", "in line 1"),
    mistake("-2 m]]", "-2 m] [1, 2]]", 17, "found no comma between two entries", '"[1"'),
    mistake("{surge: 10 %}", "{surge: 10: 1}", 25, "second colon"),
    mistake("{surge: 10 %}", "{surge: 10 %]", 25, 'bracket "{"'),
    mistake("title: Box", "title: 'Box", 1, "a quote that is not closed"),
    mistake("title: Box at", "title: Box: at", 1, "second colon", "in quotes"),
    mistake("title: Box", "title Box", 2, "no colon in line 1"),
    mistake("[[5 m, 0, -2 m]]", "[[5 m, 0, -2 m]", 17, 'bracket "["', '"]"'),
    mistake("10 %}", "10 %", 25, 'bracket "{"', '"}"'),
    mistake("body: box", "body:box", 16, "no colon with a blank", '"body: barge"'),
    mistake("law: stick", "law:stick", 20, "floor.friction", '"law: value"'),
    mistake("{surge: 100", "{surge 100", 24, "mooring.stiffness", '"surge: value"'),
    mistake(CASE, "only a text", 1, "found no keys"),
]
COMPILED = [
    mistake("{surge: 10 %", "{sway: 10 %", 25, "mooring.damping_ratio.sway", "give damping"),
    mistake("  mooring:", f"  {LINE} {START_OF_LINE}", 21, "forces.line", "different positions"),
    mistake("step: 0.01 s", "step: 0.1 s, unstable: error", 26, "solver.step", "Choose solver.s"),
    mistake("0.01 s}", "1e-11 s}", 2, "duration", "at most"),
    mistake("0.1 s}\n", f"0.1 s, {CLEARANCES}}}\n", 27, "clearances.a.of"),
]
IN_STUDIES = [
    mistake("seeds:", "title: x\nseeds:", 4, "title: found an unknown key", "case, studies, seeds"),
    mistake("seeds:", "seed:", 4, *meant("seed", "seeds")),
    mistake("1-4", "4-1", 4, "seeds", "runs backwards", 'write "1-4"'),
    mistake("surge, statistic: end", "surge statistic: end", 6, "no comma", '"statistic"'),
    mistake("statistic: end", "statistic: final", 6, *meant("figures.crawl.statistic", "end")),
    mistake("statistic: end", "statistic: [end]", 6, "figures.crawl.statistic: found a list"),
    mistake("statistic: largest", "statistic: final", 8, "criteria.drift.statistic: found"),
    mistake(
        CRAWL, "{result: friction, part: slip direction}", 6, *meant("part", "direction of slip")
    ),
    mistake("1-4", "-3", 4, "seeds", "not negative"),
    mistake("case.yaml", "none.yaml", 1, "case: found no such file", "a case file"),
    mistake("case: case.yaml\n", "", 1, 'no key "case"'),
    mistake("significant_h", "signifcant_h", 3, *meant("signifcant_height", "significant_height")),
    mistake("environment.waves.significant_height", "forces.flor.body", 3, '"floor"'),
    mistake("[1 m, 1.5 m]", "1 m, 1.5 m", 3, "in brackets: [1 m, 1.5 m]"),
    mistake("[1 m, 1.5 m]", "[1 m, 2 kN]", 3, "significant_height", '"kN"'),
    mistake("[1 m, 1.5 m]", "[1 m, 100 cm]", 2, "parameters", "twice"),
    mistake("statistic: end", "statistic: max", 6, *meant("figures.crawl.statistic", "largest")),
    mistake("limit:", "limits:", 8, *meant("criteria.drift.limits", "limit")),
    mistake("seeds: 1-4", "design: lhs", 4, *meant("design", "latin_hypercube")),
    mistake(STUDY, CASE, 1, "a case, with the key bodies", "hydrosim run"),
]
IN_RECIPES = [
    mistake("draught", "draft", 2, *meant("hull.draft", "draught")),
    mistake("5 m}", "5 ton}", 2, "hull.draught", "a length in m"),
    mistake("type: box", "type: Box", 2, *meant("hull.type", "box")),
    mistake("20 m", "-20 m", 2, "hull.beam", "must be above 0"),
    mistake("45 deg", "50 deg", 6, "headings", "a whole number of steps"),
    mistake("[7 m, 11 m, 11 m]", "[7 m, 11 m]", 4, "radii_of_gyration", "3 values"),
    mistake("0.2 rad/s", "0.2 s", 5, "frequencies.start", "a wave frequency in rad/s"),
    mistake(HULL, "hull: {type: mesh, file: no.stl}", 2, "hull.file: found no such file"),
    mistake(RECIPE, STUDY, 1, "a study, with the key case", "a recipe"),
    mistake(RECIPE, CASE, 1, "a case, with the key duration", "a recipe"),
]
ASKED = r"""
  heading: 30 deg | heading: 30 | environment.waves.heading | angles | 1718.9 deg
  {heave: 0.1 m} | {yaw: 90} | bodies.box.initial.position | angles | "90 deg"
  {surge: 10 %} | {surge: 10} | forces.mooring.damping_ratio.surge | damping | "10 %"
  0.4, kinetic: 0.3 | 40, kinetic: 30 | forces.floor.friction | friction | percentage
  10000 kN/m | 2000 | forces.floor.normal | softness | kN/m
  1000 tonne | 1e6 tonne | forces.floor.normal | softness | presses it by 981 m
  [0, 0, 1]} | [0, 0, -1]} | forces.floor.plane | plane | plane.normal reversed?
  [0, 0, -2 m], n | [0, 0, 3 m], n | forces.floor | overlap | point 1 is 4.9 m behind its plane
  [0, 0, -2 m], n | [0, 0, -20 m], n | bodies.box.initial.position | fall | 18.1 m
  height: 1 m | height: 12 m | environment.waves | steepness | waves break above
  height: 1 m | height: 120 m | environment.waves | waves | up to 20 m
  period: 6 s | period: 6 min | environment.waves | waves | a period of 347 s
  period: 6 s | period: 6 s, ramp: 1 hour | environment.waves.ramp | ramp | never reaches its full
  water_depth | wind: {speed: 15 m/s}\n  water_depth | environment.wind | streams | a wind_load
  water_depth | current: {speed: 1 m/s}\n  water_depth | environment.current | streams | no force
  {position: {heave: 0.1 m}} | {velocity: {surge: 20}} | velocity | speed | 20 m/s
  mooring: | LINE [90 m, 0, 0]}\n  mooring: | forces.line.length | lines | 80 m further
"""
"""What is written in place of what; the key, the question, what is found."""


def written(folder: Path, name: str, base: str, right: str, wrong: str) -> Path:
    """A file with a mistake in it, beside a case that is right."""
    assert right in base
    (folder / "case.yaml").write_text(CASE)
    path = folder / name
    path.write_text(base.replace(right, wrong, 1))
    return path


def test_the_files_are_right(tmp_path: Path) -> None:
    scene = load_case(written(tmp_path, "case.yaml", CASE, "Box", "Box")).scene()
    assert compile_scene(scene).notes.warnings == ()
    assert len(load_study(written(tmp_path, "study.yaml", STUDY, "case", "case")).scenes) == 8
    load_recipe(written(tmp_path, "recipe.yaml", RECIPE, "title", "title"))


WHERE = (
    ("case.yaml", CASE, load_case, IN_CASES),
    ("case.yaml", CASE, lambda path: simulate(load_case(path)), COMPILED),
    ("study.yaml", STUDY, load_study, IN_STUDIES),
    ("recipe.yaml", RECIPE, load_recipe, IN_RECIPES),
)


@pytest.mark.parametrize(
    ("name", "base", "load", "wrong"),
    [(name, base, load, wrong) for name, base, load, mistakes in WHERE for wrong in mistakes],
    ids=lambda of: of.wrong[:40].strip() if isinstance(of, Mistake) else "",
)
def test_a_mistake_is_told_in_one_line_with_its_place(
    name: str, base: str, load: Callable[[Path], object], wrong: Mistake, tmp_path: Path
) -> None:
    path = written(tmp_path, name, base, wrong.right, wrong.wrong)
    with pytest.raises(InputError) as error:
        load(path)
    text = str(error.value)
    assert text.startswith(f"{path}:{wrong.line}: ")
    assert all(word in text for word in wrong.words), text
    assert "\n" not in text


@pytest.mark.parametrize(
    ("right", "wrong", "key", "question", "found"), rows(ASKED.replace("LINE", LINE))
)
def test_what_is_possible_and_hardly_meant_is_asked_about(
    right: str, wrong: str, key: str, question: str, found: str, tmp_path: Path
) -> None:
    path = written(tmp_path, "case.yaml", CASE, right, wrong)
    asked = compile_scene(load_case(path).scene()).notes.warnings
    (text,) = [text for text in asked if text.endswith(f"accept: [{question}].")]
    assert key in text.partition(": found")[0]
    assert found in text
    path.write_text(f"{path.read_text()}accept: [{question}]\n")
    accepted = compile_scene(load_case(path).scene()).notes.warnings
    assert not [text for text in accepted if f"accept: [{question}]" in text]
