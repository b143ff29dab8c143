"""Memory that a long run takes, over the size of its dataset."""

from pathlib import Path

import pytest
from command_line import printed

MOST = 3.4  # sizes of the dataset: its record is 1.3 of them, the tables of waves 0.4
CHILD = """
import resource
import sys
from pathlib import Path

import hydrosim as hs
from hydrosim.case.load import load_case
from hydrosim.results.dataset import write_run


def peak():
    unit = 1 if sys.platform == "darwin" else 1024
    return unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def size_of_run(duration):
    settings = [f"duration={duration} s", "environment.waves.repeat_period=21600 s"]
    run = hs.simulate(load_case(Path(sys.argv[1]), settings))
    write_run(run, Path(sys.argv[2], f"{duration}.nc"))
    return run.nbytes


size_of_run(600)  # programs and kernels are loaded
before = peak()
size = size_of_run(21600)
print((peak() - before) / size)
"""


@pytest.mark.slow
def test_a_long_run_takes_few_times_its_dataset(tmp_path: Path) -> None:
    assert float(printed(CHILD, "cases/reverse_float_over/base.yaml", str(tmp_path))) < MOST
