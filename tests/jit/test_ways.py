"""The ways of kernels, `HYDROSIM_JIT`: linked machine code, numba's own, and Python."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import linked_kernels
import numpy as np
import pytest

import hydrosim as hs
from hydrosim import load_case

CASES = Path(__file__).parents[2] / "cases"
RUN = """
import sys
from dataclasses import replace
import numpy as np, hydrosim as hs
scene = hs.load_case(sys.argv[1]).scene()
run = hs.simulate(replace(scene, duration=float(sys.argv[2])))
np.save(sys.argv[3], run.position.values)
"""
KERNELS = """
import numpy as np, linked_kernels
from hydrosim.jit import kernels
scale = linked_kernels.Scale(2.0, np.array([1.0]))
print(kernels._ways.__name__, linked_kernels.twice_summed(np.arange(4.0), scale))
"""
UNKNOWN = "import numba; numba.version_info = numba.version_info._replace(short=(0, 99))\n"
CHANGED = "import numba.core.codegen; del numba.core.codegen.JITCodeLibrary\n"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "duration"), [("friction_block/slope_1e6.yaml", 4.0), ("sphere/irregular.yaml", 20.0)]
)
def test_python_computes_what_machine_code_does(case: str, duration: float, tmp_path: Path) -> None:
    path = CASES / case
    run(RUN, "python", str(path), str(duration), str(tmp_path / "motion.npy"))
    found = np.load(tmp_path / "motion.npy")
    scene = replace(load_case(path).scene(), duration=duration)
    expected = hs.simulate(scene).position.values
    assert np.ptp(expected) > 1e-6
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-9 * np.ptp(expected))


@pytest.mark.parametrize("way", ["plain", "python"])
def test_kernels_of_every_way_compute_the_same(way: str, tmp_path: Path) -> None:
    scale = linked_kernels.Scale(2.0, np.array([1.0]))
    done = run(KERNELS, way, cache=tmp_path)
    module, value = done.stdout.split()
    assert module == {"plain": "hydrosim.jit.plain", "python": "hydrosim.jit.interpreted"}[way]
    assert float(value) == linked_kernels.twice_summed(np.arange(4.0), scale)


@pytest.mark.parametrize("plant", [UNKNOWN, CHANGED])
def test_the_plain_way_takes_over_from_a_linking_that_does_not_know_numba(plant, tmp_path):
    done = run(plant + KERNELS, "linked", cache=tmp_path)
    assert done.stdout.split()[0] == "hydrosim.jit.plain"
    assert "hydrosim.jit.linking does not support numba" in done.stderr
    assert "Install numba 0.68" in done.stderr


def test_another_way_is_refused() -> None:
    command = [sys.executable, "-m", "hydrosim", "check", str(CASES / "sphere" / "decay.yaml")]
    environment = {**os.environ, "HYDROSIM_JIT": "fast"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 2
    said = "HYDROSIM_JIT: found fast; expected linked, plain, python."
    assert said in " ".join(done.stderr.split())


def run(
    program: str, way: str, *arguments: str, cache: Path | None = None
) -> subprocess.CompletedProcess[str]:
    """Run a program in a process of its own, by a way of kernels."""
    paths = [str(Path(linked_kernels.__file__).parent), str(CASES.parent)]
    environment = {**os.environ, "HYDROSIM_JIT": way, "PYTHONPATH": os.pathsep.join(paths)}
    if cache is not None:
        environment["HYDROSIM_CACHE_DIR"] = str(cache)
    command = [sys.executable, "-c", program, *arguments]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done
