"""Inputs of `benchmarks.checksums`: cases, studies and mutants that two versions are both to read.

Paths in them are relative to a folder with the shipped cases and databases.
"""

from pathlib import Path
from typing import Any

from tests.generators.error_cases import KINDS
from tests.generators.mixed_cases import MESH, mesh_of
from tests.generators.mutants import Mutant, mutants
from tests.generators.mutants import text_of as text_of_mutant
from tests.generators.random_cases import Case, text_of
from tests.generators.swinging_cases import swinging_case
from tests.generators.transition_cases import transition_cases

ROOT = Path(__file__).parents[2]
BASE = "../cases/reverse_float_over/base.yaml"
LATIN = "latin_hypercube"
SOBOL = "sobol_indices"
PAIR = """
title: two barges
duration: 200 s
environment:
  water_depth: infinite
  waves:
    {spectrum: jonswap, significant_height: 1 m, peak_period: 9 s, heading: 60 deg, ramp: 50 s}
bodies:
  starboard: &barge
    hydrodynamics: ../hydro_db/two_barges.nc
    mass: 1.23e6
    radiation: {model: state_space, length: 160 s, tolerance: 0.01}
    database_body: 2
    centre_of_gravity: [0, -7 m, 0]
    radii_of_gyration: [4.0, 11.0, 11.0]
  port:
    <<: *barge
    database_body: 1
    centre_of_gravity: [0, 7 m, 0]
    radii_of_gyration: [3.5, 10.4, 10.4]
forces:
  starboard_lines:
    {type: linear_mooring, body: starboard, stiffness: {surge: 1.5e5, sway: 1.5e5, yaw: 1.5e7}}
  port_lines:
    {type: linear_mooring, body: port, stiffness: {surge: 1.5e5, sway: 1.5e5, yaw: 1.5e7}}
  bilges: {type: linear_damping, body: port, damping: {roll: 5e6}}
  drag: {type: quadratic_damping, body: starboard, damping: {roll: 5e7}}
  tie: {type: spring, body: port, point: [5, -4, 1], anchor_body: starboard, anchor: [5, 4, 1],
        length: 6 m, stiffness: 1e5, damping: 1e4}
  side:
    type: fender
    body: port
    points: [[10, -5, 0], [-10, -5, 0]]
    plane: {body: starboard, point: [0, 8.9, 0], normal: [0, 1, 0]}
    normal: {stiffness: 4e6, damping: 1e4}
    friction: {law: friction_slope, coefficient: 0.3, slope: 1e5}
solver: {method: rk4, step: 0.05 s}
"""
CRAWL = "figures: {crawl: {channel: position.barge.surge, statistic: end}}"
STUDIES = {
    "friction": f"""
case: {BASE}
parameters: {{forces.interface.friction.static: [0.2, 0.4]}}
seeds: 1-2
duration: 700 s
output: {{step: 1 s, variables: [position, fender_mode]}}
""",
    "stages": """
case: ../cases/topside_removal/removal.yaml
seeds: 1-2
duration: 600 s
output: {step: 1 s, variables: []}
""",
    "pins": """
case: ../cases/lock_in/pins.yaml
seeds: 1-2
duration: 650 s
output: {step: 1 s, variables: []}
figures:
  closed: {channel: lock_rows.lock, statistic: end}
  lock_load: {channel: joint_force.lock.surge, statistic: largest_absolute}
studies:
  speed: {parameters: {joints.lock.window.speed: [0.01 m/s, 0.04 m/s]}}
  gap: {parameters: {joints.lock.window.gap: [0.05 m, 0.4 m]}}
""",
    **{
        design: f"""
case: {BASE}
duration: 60 s
{CRAWL}
design: {design}
samples: 4
parameters:
  sea: {{keys: {{environment.waves.seed: {{from: 1, to: 1000000}}}}}}
  C3:
    keys:
      forces.interface.friction.slip_damping: {{from: 10000, to: 1e10, scale: logarithmic}}
"""
        for design in (LATIN, SOBOL)
    },
    "until": f"""
case: {BASE}
seeds: [1, 4]
duration: 60 s
output: {{step: 0.5 s, start: 10 s, variables: [position], impulses: true}}
{CRAWL}
until: {{figure: crawl, wide: 0.1 m, most: 20}}
""",
    "operability": f"""
case: {BASE}
seeds: 1-30
duration: 60 s
output: {{step: 0.5 s, start: 10 s}}
criteria:
  heave: {{channel: position.barge.heave, statistic: largest, limit: 0.1 m}}
operability:
  heights: {{from: 0.4 m, to: 1.6 m, apart: 0.4 m}}
  peak_periods: [8 s]
  probability: 90 %
""",
}
"""Studies by name; the last is one of limits."""
RANDOM_CASES = {
    "contacts": (2, 7, 12),
    "held": (0, 5, 8),
    "joints": (14, 30, 78, 98, 128),
    "lines": (6, 23, 27, 32, 43, 48, 51, 55, 63, 65, 70, 76, 83, 113, 120, 127, 136),
    "mixtures": (3, 121),
}
"""Numbers of random cases by kind. Together they have elements of all kinds, currents with
profiles, gusts, meshes of hulls and pumps."""
FINE_STEP = 0.02  # s between records where a method chooses its steps
LONGEST = 30.0  # s: duration of a random case

MUTANTS = 450
CHECKED_MUTANTS = 40
SHORT = 10.0  # s: duration of mutants that are checked


def recorded_inputs() -> dict[str, Any]:
    """Texts of ``files`` by path; ``mutants`` of cases, of which most are refused when they are
    read, and others to be ``checked``: the case, a name, the text."""
    files = {f"studies/{name}.yaml": text for name, text in STUDIES.items()}
    return {
        "files": {"scenes/two barges.yaml": PAIR, **files, **_scene_files()},
        "mutants": [_texts(mutant) for mutant in mutants(MUTANTS, 1)],
        "checked": [_texts(mutant, SHORT) for mutant in mutants(CHECKED_MUTANTS, 2, True)],
    }


def _scene_files() -> dict[str, str]:
    """Cases of the generators, and meshes beside them."""
    drawn = {f"{kind} {n}": KINDS[kind](n) for kind, all_ in RANDOM_CASES.items() for n in all_}
    loop = next(case for case in map(swinging_case, range(100)) if "coupler" in case["bodies"])
    files = {}
    for name, case in {**transition_cases(), **drawn, "closed loop": loop}.items():
        _record_all_steps(case)
        mesh = mesh_of(int(name.split()[1])) if name.startswith("mixtures") else None
        mesh_name = f"{name.replace(' ', '_')}.stl"
        text = text_of(case).replace(MESH, mesh_name).replace(str(ROOT), "..")
        files[f"scenes/{name}.yaml"] = text
        if mesh:
            files[f"scenes/{mesh_name}"] = mesh
    return files


def _record_all_steps(case: Case) -> None:
    """Record the states of a case at each step, so that transitions can be counted."""
    solver = case.get("solver", {})
    has_steps = solver.get("method") in ("rk2", "heun", "rk4")
    case["duration"] = min(case["duration"], LONGEST)
    case["output"] = {"step": solver["step"] if has_steps else FINE_STEP, "states": True}


def _texts(mutant: Mutant, duration: float | None = None) -> tuple[str, str, str]:
    name = f"{mutant.case} {mutant.keys} {mutant.how}"
    return mutant.case, name, text_of_mutant(mutant, duration)
