"""Retardation functions and fits are the same to the bit with any number of threads of BLAS."""

from pathlib import Path

import pytest
from command_line import printed

PRINTED = """
import hashlib, sys
import numpy as np
from hydrosim.water import radiation
from hydrosim.database.load import read
from hydrosim.water.radiation.state_space import fit_group

def told(name, *arrays):
    digest = hashlib.sha256(b"".join(np.ascontiguousarray(array).tobytes() for array in arrays))
    print(name, digest.hexdigest())

def of_fit(name, model):
    told(name, model.dofs, model.decay, model.frequency, model.B, model.C)
    print(model.report)

for name in ("sphere", "h851"):
    db = read(f"{sys.argv[1]}/{name}.nc")
    given = db.frequency, db.added_mass, db.radiation_damping
    radiation.retardation(*given, checksum=name)
    memory = radiation.retardation(*given, checksum=name)  # from the cache
    told(name, memory.kernel, memory.added_mass_infinite)
    print(memory.report)
    if name == "sphere":
        for model in radiation.fit_state_space(name, memory, db.frequency, np.arange(6)):
            of_fit(name, model)
    else:
        of_fit(name, fit_group(memory, np.array([0, 2, 4]), db.frequency[-1]))
"""
DATABASES = Path(__file__).parents[3] / "hydro_db"


def with_threads(folder: Path, threads: str) -> str:
    changes = {"OPENBLAS_NUM_THREADS": threads, "HYDROSIM_CACHE_DIR": str(folder / threads)}
    return printed(PRINTED, str(DATABASES), **changes)


@pytest.fixture(scope="module")
def by_one_thread(tmp_path_factory: pytest.TempPathFactory) -> str:
    return with_threads(tmp_path_factory.mktemp("one"), "1")


@pytest.mark.parametrize("threads", ["2", pytest.param("4", marks=pytest.mark.slow)])
def test_threads_change_no_bit(tmp_path: Path, by_one_thread: str, threads: str) -> None:
    assert with_threads(tmp_path, threads) == by_one_thread
