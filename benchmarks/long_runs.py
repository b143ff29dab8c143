"""How much memory does a run take, the longer it is?

`hydrosim run` of the base case, recorded every 0.5 s, in a sea that does not repeat itself in 18 h:
the most that each process takes, from its start to its end, with kernels and fits in the cache.
Packages that hydrosim works without, but that others load where they are installed (pandas loads
pyarrow, xarray loads dask), count, so each run is made with all of them and with none.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import xarray as xr

from benchmarks.report import ROOT, Answer, Row

HOURS = (0.01, 3.0, 18.0)
REPEATED = 18.1  # h
OPTIONAL = ("dask", "distributed", "pyarrow")
CASE = "cases/reverse_float_over/base.yaml"
MEGABYTE = 1e6
UNIT = 1 if sys.platform == "darwin" else 1024  # of the most memory that a process has had
PROGRAM = """
import sys
for name in {hidden!r}:
    sys.modules[name] = None
from hydrosim.__main__ import main
sys.argv[1:] = {arguments!r}
main()
"""


def answer() -> Answer:
    """The most memory by the length of the run."""
    with TemporaryDirectory() as folder:
        _peak(HOURS[0], folder, ())  # kernels are compiled, radiation is fitted
        rows = [_row(hours, folder) for hours in HOURS]
    return Answer({"Memory of hydrosim run, base case": rows})


def _row(hours: float, folder: str) -> Row:
    most = _peak(hours, folder, ())
    plain = _peak(hours, folder, OPTIONAL)
    with xr.open_dataset(_result(hours, folder)) as run:
        size = run.nbytes
    return {
        "hours": hours,
        "most [MB]": round(most / MEGABYTE),
        "without optional packages [MB]": round(plain / MEGABYTE),
        "of it the dataset [MB]": round(size / MEGABYTE),
    }


def _peak(hours: float, folder: str, hidden: tuple[str, ...]) -> int:
    """The most memory [B] that a new process takes for the run."""
    settings = (f"duration={hours} hour", f"environment.waves.repeat_period={REPEATED} hour")
    given = [argument for setting in settings for argument in ("--set", setting)]
    output = ["--output", str(_result(hours, folder)), "--overwrite"]
    program = PROGRAM.format(hidden=hidden, arguments=["run", CASE, *given, *output])
    with subprocess.Popen(
        [sys.executable, "-c", program], cwd=ROOT, stdout=subprocess.DEVNULL
    ) as process:
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise subprocess.CalledProcessError(process.returncode, "hydrosim run")
    return UNIT * usage.ru_maxrss


def _result(hours: float, folder: str) -> Path:
    return Path(folder, f"{hours}.nc")
