"""How long until the first step?

Imports, and `hydrosim run` of 10 s of the base case, which takes no time to step: with what a run
before left in the cache, and with an empty cache, where kernels are compiled and radiation is
fitted. Each in new processes, from their start to their end.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter

from benchmarks.report import ROOT, Answer, Row

REPEATS = 7
FIRST_RUNS = 3
IMPORTS = (
    "pass",
    "import numpy, scipy, numba",
    "import numpy, scipy, numba, hydrosim",
    "import numpy, scipy, numba, xarray",
    "from hydrosim import load_case",
    "from hydrosim import simulate",
)
CASE = "cases/reverse_float_over/base.yaml"
RUN = f"from hydrosim.__main__ import main; import sys; sys.argv[1:] = {['run', CASE]!r}"


def answer() -> Answer:
    """Wall times of imports and of runs."""
    with TemporaryDirectory() as folder:
        first = [_seconds(_run(folder, str(i)), f"{folder}/{i}") for i in range(FIRST_RUNS)]
        warm: dict[str, list[float]] = {name: [] for name in (*IMPORTS, "run")}
        for _ in range(REPEATS):
            for name in IMPORTS:
                warm[name].append(_seconds(name, f"{folder}/0"))
            warm["run"].append(_seconds(_run(folder, "0"), f"{folder}/0"))
    runs: list[Row] = [
        {"cache": "empty: kernels compiled, radiation fitted", "time [s]": median(first)},
        {"cache": "as a run before left it", "time [s]": median(warm["run"])},
    ]
    return Answer(
        {
            f"Imports; medians of {REPEATS} interleaved processes": [
                {"python -c": name, "time [s]": median(warm[name])} for name in IMPORTS
            ],
            f"hydrosim run of 10 s of the base case; medians of {REPEATS} processes, of"
            f" {FIRST_RUNS} with an empty cache": runs,
        }
    )


def _run(folder: str, name: str) -> str:
    """A program that runs the case and writes to ``folder``."""
    arguments = ["--set", "duration=10 s", "--output", str(Path(folder) / f"{name}.nc")]
    return f"{RUN} + {arguments!r}; main()"


def _seconds(program: str, cache: str) -> float:
    """Wall time of a new process with this cache, whose modules are compiled as after a first
    import."""
    environment = {**os.environ, "HYDROSIM_CACHE_DIR": cache}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    begin = perf_counter()
    subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, env=environment, capture_output=True, check=True
    )
    return perf_counter() - begin
