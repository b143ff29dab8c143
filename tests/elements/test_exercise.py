"""A new kind of element in a copy of the package: a rope with modes, a state and a tension.

The copy has the rope's own file and the lines below, in files that `docs/extending.md` names. What
follows (names, output, restart, ledger, step limits) it must have by its kind.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from command_line import printed

import hydrosim

HERE = Path(__file__).parent
DOCS = HERE.parents[1] / "docs" / "extending.md"
NEW = "elements/rope.py"
LINES = {  # of files that are there: before which line stands what
    "elements/__init__.py": {
        "    spring,\n    stream_load,": "    rope,\n",
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
        "    }\n\n\n@kernel\ndef joint_output_start": (
            '        "rope": (elements.ropes.lines.size, rope.ROPE_OUTPUTS),\n'
        ),
        "\n\n@root\ndef set_initial_modes": (
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
        "    if row >= springs.mode and": (
            "    ropes = elements.ropes\n"
            "    if row >= ropes.mode and ropes.lines.size > 0:\n"
            "        rope.transition(row - ropes.mode, which, y, modes, motion, bodies, ropes)\n"
            "        return\n"
        ),
        "    if row < fenders.mode or": (
            "    first = elements.ropes.state + row - elements.ropes.mode\n"
            "    if 0 <= row - elements.ropes.mode < elements.ropes.lines.size:\n"
            "        return first, first + 1\n"
        ),
    },
}
SCRIPT = """
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
    return Scene("hung", 20.0, (body,), forces=forces, solver=solver, output_step=0.1)


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


def test_the_documentation_names_the_files_of_the_exercise() -> None:
    text = DOCS.read_text()
    for file in LINES:
        assert f"`hydrosim/{file}`" in text
    assert 1 + len(LINES) <= 5


@pytest.mark.slow
def test_a_rope_is_added_in_three_files(tmp_path: Path) -> None:
    package = tmp_path / "hydrosim"
    own = Path(hydrosim.__file__).parent
    shutil.copytree(own, package, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(HERE / "exercises" / "rope.py", package / NEW)
    for file, lines in LINES.items():
        text = (package / file).read_text()
        for before, added in lines.items():
            assert text.count(before) == 1, (file, before)
            text = text.replace(before, added + before)
        (package / file).write_text(text)
    paths = {"PYTHONPATH": str(tmp_path), "HYDROSIM_CACHE_DIR": str(tmp_path / "cache")}
    assert "the rope holds" in printed(SCRIPT, folder=tmp_path, **paths)
