"""Which roots a scene compiles."""

from __future__ import annotations

from pathlib import Path

import pytest
from command_line import printed

pytestmark = pytest.mark.kernels
CASES = Path(__file__).parents[2] / "cases"
PROGRAM = """
import gc, sys
import hydrosim as hs
from hydrosim.jit.linking import CompiledKernel
hs.simulate(hs.load_case(*sys.argv[1:2], {"duration": 20.0}))
for one in gc.get_objects():
    if isinstance(one, CompiledKernel) and one.overloads:
        print(one.py_func.__module__ + "." + one.py_func.__qualname__)
"""
WATER = {"hydrosim.elements.linear_mooring.add_energy", "hydrosim.water.loads.wave_loads"}
EVERY_STAGE = {
    "hydrosim.elements.linear_mooring.add_force",
    "hydrosim.water.radiation.memory.radiation_states",
    "hydrosim.multibody.mass.accelerate_freely",
    "hydrosim.multibody.kinematics.acceleration_map",
    "hydrosim.integrate.dynamics.add_constraints",
    "hydrosim.integrate.dynamics.find_mass",
}


@pytest.mark.slow
def test_a_dry_block_with_friction_needs_nothing_of_the_water() -> None:
    dry, wet = roots("friction_block/exact"), roots("reverse_float_over/base")
    assert wet >= WATER
    assert not WATER & dry


@pytest.mark.slow
def test_what_every_stage_calls_is_no_root() -> None:
    """The door of one costs some percent of a step."""
    assert not EVERY_STAGE & roots("reverse_float_over/base")
    assert not EVERY_STAGE & roots("friction_block/exact")


def roots(case: str) -> set[str]:
    """Those that a run of a case calls."""
    return set(printed(PROGRAM, str(CASES / f"{case}.yaml")).split())
