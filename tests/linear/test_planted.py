"""A joint that is not there yet: rows that a copy of the package states at the one door.

Nothing else of the copy differs: modes, limits, the place at rest, responses and exact propagation
must see the joint by themselves.
"""

import shutil
from pathlib import Path

import pytest
from command_line import printed

import hydrosim

COUNT = "    return events.held_directions(model.elements)\n"
DOOR = "    constraints.number[0] = 0\n"
JOINT = """    clear(constraints.J[0])
    constraints.J[0, 0], constraints.J[0, 1], constraints.bound[0] = 1.0, -1.0, 0.0
    constraints.number[0] = 1
"""
SCRIPT = """
import numpy as np
import hydrosim as hs
from dataclasses import replace
from hydrosim.elements import AppliedForce, Harmonic, LinearMooring
from hydrosim.linear.equilibrium import equilibrium
from hydrosim.scene import Body, LinearScenes, Scene, Solver
from hydrosim.run.step_limits import scene_combinations
from hydrosim.run.step_limits import scene_step_limits

bodies = tuple(
    Body(name, mass, np.eye(3), dofs=("surge",), location=(9.0 * mass, 0.0))
    for name, mass in (("one", 2.0), ("other", 3.0))
)
push = Harmonic(4.0, 2 * np.pi / 1.5, mean=6.0)
forces = {
    "spring": LinearMooring("one", np.diag([20.0, 0, 0, 0, 0, 0])),
    "push": AppliedForce("other", (0.0, 0.0, 0.0), {"surge": push}),
}
solver = Solver(step=0.05, linear=LinearScenes.EXACT)
scene = Scene("joined", 20.0, bodies, forces=forces, solver=solver, output={"step": 0.1})
model, state = compiled = hs.compile_scene(scene)
linear = hs.linearise(model, state)
(mode,) = hs.natural_modes(linear)
assert np.isclose(mode.natural_period, 2 * np.pi / 2.0, rtol=1e-9), mode.natural_period
w, load = 1.5, np.array([0.0, 4.0])
assert np.allclose(linear.response(w, load), 4.0 / (20.0 - 5.0 * w**2), rtol=1e-9)
x = 4.0 / (20.0 - 5.0 * w**2)
assert np.allclose(linear.reaction(w, load), (20.0 - 2.0 * w**2) * x, rtol=1e-9)
(only,) = scene_combinations(compiled)
assert np.allclose(np.abs(only.values), 2.0) and only.values.size == 2
(limit,) = scene_step_limits(compiled)
assert np.isclose(limit.step * 2.0, 2 * np.sqrt(2), rtol=2e-3), limit
rest = equilibrium(model, state, 0.0, 50.0)
assert np.allclose(rest.state.y[:2], 6.0 / 20.0, rtol=1e-9), rest
assert np.allclose(rest.drift, 0.0)
own = 2.0
runs = {}
for way in LinearScenes:
    run = hs.simulate(replace(scene, solver=replace(solver, linear=way)))
    t = run.time.values
    sines = 4.0 / 5.0 * (np.sin(w * t) - w / own * np.sin(own * t)) / (own**2 - w**2)
    exact = 0.3 * (1.0 - np.cos(own * t)) + sines
    runs[way] = np.abs(run.position.values[:, :, 0] - exact[:, None]).max()
    assert run.attrs["energy_residual_relative"] < 1e-5, run.attrs["energy_residual_relative"]
assert runs[LinearScenes.EXACT] < 1e-9, runs
assert runs[LinearScenes.STEP] < 3e-5, runs
print("all of it sees the joint", runs)
"""


@pytest.mark.slow
def test_a_joint_at_the_one_door_reaches_everything(tmp_path: Path) -> None:
    """Two bodies and a rigid rod: one body of both on a spring, in closed form. The copy has other
    kernels, and so a cache of its own. Steps: (w h)^4 w t / 120 of rk4 is 3e-5."""
    package = tmp_path / "hydrosim"
    own = Path(hydrosim.__file__).parent
    shutil.copytree(own, package, ignore=shutil.ignore_patterns("__pycache__"))
    dynamics = package / "integrate" / "dynamics.py"
    text = dynamics.read_text()
    assert text.count(COUNT) == text.count(DOOR) == 1
    dynamics.write_text(text.replace(COUNT, COUNT.rstrip() + " + 1\n").replace(DOOR, DOOR + JOINT))
    paths = {"PYTHONPATH": str(tmp_path), "HYDROSIM_CACHE_DIR": str(tmp_path / "cache")}
    assert "all of it sees the joint" in printed(SCRIPT, folder=tmp_path, **paths)
