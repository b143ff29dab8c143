"""What is added to a copy of the package, in the files that `docs/extending.md` names.

A rope is a new kind of element with modes, a state and a tension. A hydraulic damper is a new law,
which acts along any coordinate. What follows (names, output, restart, ledger, step limits) they
must have by their kind.
"""

import shutil
from pathlib import Path

import pytest
from command_line import printed

import hydrosim

HERE = Path(__file__).parent
DOCS = HERE.parents[1] / "docs" / "extending.md"
ROPE = "elements/rope.py"
ROPE_LINES = {  # of files that are there: before which line stands what
    "elements/__init__.py": {
        "    stream_load,\n    tanks,": "    rope,\n",
        "    guides: Any": "    ropes: Any\n",
        "    tanks.TANK_FLOW_KIND": "    rope.ROPE_KIND,\n",
        "    if e.guides.pins.size > 0:\n        landing.add_force": (
            "    if e.ropes.lines.size > 0:\n"
            "        rope.add_force(t, y, modes, motion, bodies, e.ropes, loads)\n"
        ),
        "    if e.guides.pins.size > 0:\n        landing.add_energy": (
            "    if e.ropes.lines.size > 0:\n"
            "        rope.add_energy(t, y, modes, motion, bodies, e.ropes, stored)\n"
        ),
    },
    "elements/events.py": {
        "from hydrosim.elements import bushing": "from hydrosim.elements import rope\n",
        "    }\n\n\n@kernel\ndef write_outputs": (
            '        "rope": (elements.ropes.lines.size, rope.ROPE_OUTPUTS),\n'
        ),
        "\n\n@kernel\ndef motions_of_joints": (
            "    if elements.ropes.lines.size > 0:\n"
            "        first = out.size - elements.ropes.lines.size * rope.ROPE_OUTPUTS\n"
            "        rope.write_outputs(y, modes, motion, bodies, elements.ropes, out[first:])\n"
        ),
        "    if tanks.flows.size > 0:\n        pumping.set_initial_modes": (
            "    if elements.ropes.lines.size > 0:\n"
            "        rope.set_initial_modes(y, modes, motion, bodies, elements.ropes)\n"
        ),
        "    if tanks.flows.size > 0:\n        pumping.find_margins": (
            "    if elements.ropes.lines.size > 0:\n"
            "        rope.find_margins(y, modes, motion, bodies, elements.ropes, out)\n"
        ),
        "ROW_KINDS = {\n": "ROPE_ROW = 10\n",
        '    "link_table": LINK_ROW': '    "ropes": ROPE_ROW,\n',
        "    elif kind == LINK_ROW:": (
            "    elif kind == ROPE_ROW:\n"
            "        rope.transition(i, which, y, modes, motion, bodies, elements.ropes)\n"
        ),
        "    if kind == LINK_ROW and part == 0:": (
            "    if kind == ROPE_ROW:\n"
            "        return elements.ropes.state + i, elements.ropes.state + i + 1\n"
        ),
    },
}
ROPE_RUN = """
import numpy as np
import hydrosim as hs
from dataclasses import replace
from scipy.integrate import solve_ivp
from hydrosim.elements import AppliedForce, constant
from hydrosim.elements.rope import BROKEN, Rope
from hydrosim.scene import Body, LinearScenes, Scene, Solver, Start
from hydrosim.run.step_limits import scene_combinations

m, k, eta, weight = 1000.0, 1e5, 2e5, 5000.0


def hung(**rope):
    body = Body("block", m, m * np.eye(3), dofs=("heave",))
    load = AppliedForce("block", (0.0, 0.0, 0.0), {"heave": constant(-weight)})
    line = Rope("block", (0.0, 0.0, 0.0), (0.0, 0.0, 10.0), 9.98, k, eta, **rope)
    solver = Solver(step=0.01, linear=LinearScenes.STEP)
    forces = {"hawser": line, "weight": load}
    return Scene("hung", 20.0, (body,), forces=forces, solver=solver, output={"step": 0.1})


def slope(t, y):
    T = max(k * (0.02 - y[0] - y[2]), 0.0)
    return [y[1], (T - weight) / m, T / eta]


run = hs.simulate(hung())
t = run.time.values
exact = solve_ivp(slope, (0.0, 20.0), [0.0] * 3, t_eval=t, rtol=1e-10, atol=1e-12, max_step=0.01).y
assert np.abs(run.position.values[:, 0, 2] - exact[0]).max() < 1e-4
assert np.abs(run.rope_creep.values[:, 0] - exact[2]).max() < 1e-4
assert run.attrs["energy_residual_relative"] < 1e-5
assert run.rope_tension.attrs["units"] == "N"
half = replace(hung(), duration=10.0)
later = hs.simulate(replace(half, initial=Start(hs.simulate(half))))
for name in ("position", "rope_creep", "rope_tension", "rope_mode"):
    assert np.array_equal(later[name].values[-1], run[name].values[-1]), name
broken = hs.simulate(hung(breaks_at=7000.0))
assert broken.rope_mode.values[-1, 0] == BROKEN
assert broken.rope_tension.values.max() <= 7000.0
assert broken.attrs["energy_residual_relative"] < 1e-5
fall = broken.rope_mode.values[:, 0] == BROKEN
speed = broken.velocity.values[fall, 0, 2]
assert np.allclose(np.diff(speed), -weight / m * 0.1, rtol=1e-6)
texts = [each.contact for each in scene_combinations(hs.compile_scene(hung()))]
assert texts == ["no contact, ropes slack", "no contact, ropes taut"], texts
print("the rope holds")
"""


DAMPER = "elements/link/hydraulic_damper.py"
DAMPER_LINES = {
    "scene/links.py": {
        "@schema_class\nclass Stop(": (
            "@schema_class\n"
            "class HydraulicDamper(CoordinateElement):\n"
            "    type: Literal['hydraulic_damper'] = field(\n"
            "        default='hydraulic_damper', kw_only=True)\n"
            "    oil: LinkStiffness = field(kw_only=True)\n"
            "    orifice: LinkDamping = field(kw_only=True)\n"
            "    shortest: Place = field(kw_only=True)\n"
            "    longest: Place = field(kw_only=True)\n"
            "    stop: LinkStiffness = field(kw_only=True)\n\n\n"
        ),
        "SpringDamper | GasSpring | Stop": "HydraulicDamper | ",
    },
    "elements/link/laws.py": {
        "from hydrosim.elements.link.law import": (
            "from hydrosim.elements.link import hydraulic_damper\n"
            "from hydrosim.elements.link.hydraulic_damper import HydraulicDamper\n"
        ),
        "    state: int\n    mode: int\n": "    dampers: np.ndarray\n",
        "LAWS: dict[type[Link],": "HYDRAULIC = 5\n",
        "    Spring: (TENSION,": (
            "    HydraulicDamper: (HYDRAULIC, hydraulic_damper.DAMPER_CLASS),\n"
        ),
        '"gases": gas.CYLINDER': '"dampers": hydraulic_damper.DAMPER, ',
        "    if link.law == TENSION:\n        return tension.find_loads": (
            "    if link.law == HYDRAULIC:\n"
            "        load = y[p.state + link.state]\n"
            "        damper = p.dampers[link.constants]\n"
            "        return hydraulic_damper.find_loads(damper, mode, s, load)\n"
        ),
        "    if link.law == DRY_FRICTION:\n        dy": (
            "    if link.law == HYDRAULIC:\n"
            "        k = p.state + link.state\n"
            "        dy[k] = hydraulic_damper.load_rate(p.dampers[link.constants], s, y[k])\n"
        ),
        "    if link.law == TENSION or link.law == ELASTIC:": (
            "    if link.law == HYDRAULIC:\n"
            "        load = y[p.state + link.state]\n"
            "        damper = p.dampers[link.constants]\n"
            "        return hydraulic_damper.stored_energy(damper, mode, s, load)\n"
        ),
        "    if link.law == TENSION:\n        tension.find_margins": (
            "    if link.law == HYDRAULIC:\n"
            "        hydraulic_damper.find_margins(p.dampers[link.constants], mode, s, out)\n"
            "        return\n"
        ),
        "    if link.law == TENSION:\n        tension.transition": (
            "    if link.law == HYDRAULIC:\n"
            "        hydraulic_damper.transition(p.dampers[link.constants], mode, s)\n"
            "        return\n"
        ),
        "    if link.law == TENSION:\n        tension.set_initial_mode": (
            "    if link.law == HYDRAULIC:\n"
            "        hydraulic_damper.set_initial_mode(p.dampers[link.constants], mode, s)\n"
            "        y[p.state + link.state] = 0.0\n"
            "        return\n"
        ),
    },
}
DAMPER_RUN = '''
import numpy as np
import hydrosim as hs
from dataclasses import replace
from scipy.integrate import solve_ivp
from hydrosim.scene.links import HydraulicDamper
from hydrosim.scene import Body, Scene, Solver, Start

m, oil, orifice, stop, low, high = 1e3, 4e4, 3e2, 8e4, -0.4, 0.5
law = {"oil": oil, "orifice": orifice, "stop": stop}
speed = 1.5


def slope(t, y):
    beyond = min(y[0] - low, 0.0) + max(y[0] - high, 0.0)
    return [y[1], -(y[2] + stop * beyond) / m, oil * (y[1] - y[2] / orifice)]


def on_line():
    body = Body("block", m, m * np.eye(3), dofs=("surge",), velocity=(-speed, 0, 0, 0, 0, 0))
    line = {"point": (0.0, 0.0, 0.0), "anchor": (10.0, 0.0, 0.0)}
    damper = HydraulicDamper("block", **line, shortest=10 + low, longest=10 + high, **law)
    solver = Solver(step=0.0025)
    return Scene("it", 4.0, (body,), forces={"damper": damper}, solver=solver, output={"step": 0.1})


def about_axis():
    body = Body("block", m, m * np.eye(3), dofs=("yaw",), velocity=(0, 0, 0, 0, 0, speed))
    damper = HydraulicDamper("block", axis=(0, 0, 1), shortest=low, longest=high, **law)
    return replace(on_line(), bodies=(body,), forces={"damper": damper})


def in_joint():
    slider = hs.Slider("block", axis=(1, 0, 0), initial=hs.SlideInitial(0.0, speed))
    damper = HydraulicDamper("block", joint="it", shortest=low, longest=high, **law)
    body = Body("block", m, m * np.eye(3))
    return replace(on_line(), bodies=(body,), joints={"it": slider}, forces={"damper": damper})


for scene in (on_line(), about_axis(), in_joint()):
    run = hs.simulate(scene.with_output(states=True))
    t = run.time.values
    tight = {"rtol": 1e-12, "atol": 1e-12, "max_step": 1e-3}
    exact = solve_ivp(slope, (0.0, 4.0), [0.0, speed, 0.0], "DOP853", t, **tight).y
    shift = 10.0 if scene.forces["damper"].point else 0.0
    place = run.hydraulic_damper_place.values[:, 0] - shift
    assert np.abs(place - exact[0]).max() < 1e-7
    beyond = np.minimum(exact[0] - low, 0.0) + np.maximum(exact[0] - high, 0.0)
    assert np.abs(run.hydraulic_damper_load.values[:, 0] - exact[2] - stop * beyond).max() < 1e-2
    assert run.attrs["energy_residual_relative"] < 1e-6
    assert set(run.link_segment.values[:, 0].tolist()) == {0, 1, 2}
    half = replace(scene, duration=2.0).with_output(states=True)
    later = hs.simulate(replace(half, initial=Start(hs.simulate(half))))
    for name in ("position", "hydraulic_damper_load", "link_segment"):
        assert np.array_equal(later[name].values[-1], run[name].values[-1]), name
keys = """
title: a damper
duration: 4 s
bodies:
  block:
    mass: 1 tonne
    radii_of_gyration: [1 m, 1 m, 1 m]
    dofs: [surge]
    initial: {velocity: [-1.5 m/s, 0 m/s, 0 m/s, 0 rad/s, 0 rad/s, 0 rad/s]}
forces:
  damper:
    type: hydraulic_damper
    body: block
    point: [0 m, 0 m, 0 m]
    anchor: [10 m, 0 m, 0 m]
    shortest: 9.6 m
    longest: 10.5 m
    oil: 40 kN/m
    orifice: 300 N*s/m
    stop: 80 kN/m
solver: {method: rk4, step: 0.0025 s}
output: {step: 0.1 s}
"""
with open("damper.yaml", "w") as file:
    file.write(keys)
run, other = hs.simulate(on_line()), hs.simulate(hs.load_case("damper.yaml"))
assert np.array_equal(run.hydraulic_damper_load, other.hydraulic_damper_load)
print("the damper holds")
'''


def test_the_documentation_names_the_files_of_the_exercises() -> None:
    text = DOCS.read_text()
    for file in (*ROPE_LINES, *DAMPER_LINES):
        assert f"`hydrosim/{file}`" in text
    assert 1 + len(ROPE_LINES) <= 5
    assert 1 + len(DAMPER_LINES) <= 3


def test_a_damper_takes_few_lines() -> None:
    """All told, in both files."""
    source = (HERE / "exercises" / "hydraulic_damper.py").read_text()
    added = "".join(text for lines in DAMPER_LINES.values() for text in lines.values())
    assert count_code(source) + count_code(added) <= 120


def count_code(text: str) -> int:
    """Lines of code: neither empty nor of a docstring."""
    lines = text.split('"""')[::2]
    return sum(bool(line.strip()) for piece in lines for line in piece.splitlines())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("new", "lines", "script", "says"),
    [
        (ROPE, ROPE_LINES, ROPE_RUN, "the rope holds"),
        (DAMPER, DAMPER_LINES, DAMPER_RUN, "the damper holds"),
    ],
    ids=["rope", "damper"],
)
def test_an_exercise_in_few_files(new, lines, script, says, tmp_path):
    package = tmp_path / "hydrosim"
    original = Path(hydrosim.__file__).parent
    shutil.copytree(original, package, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(HERE / "exercises" / Path(new).name, package / new)
    for file, added_lines in lines.items():
        text = (package / file).read_text()
        for before, added in added_lines.items():
            assert text.count(before) == 1, (file, before)
            text = text.replace(before, added + before)
        (package / file).write_text(text)
    paths = {"PYTHONPATH": str(tmp_path), "HYDROSIM_CACHE_DIR": str(tmp_path / "cache")}
    assert says in printed(script, folder=tmp_path, **paths)
