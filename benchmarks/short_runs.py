"""Does the memory of a sweep of very many short runs stay what it is, and can it be read meanwhile?

A sphere that heaves in seas of ten heights, 20 s each: what a run costs is then what a sweep adds
to it. The command runs as anybody would start it, by processes of its own; its memory and theirs
is looked at all the time, and `hydrosim statistics` reads its folder now and then.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, sleep
from typing import NamedTuple

import psutil
import xarray as xr

from benchmarks.report import ROOT, Answer, Row

RUNS = int(os.environ.get("RUNS", "100000"))
HEIGHTS = 10
LOOKS = 6  # at the statistics, while it grows
PAUSE = 1.0  # s
MEGABYTE = 1e6
CASE = f"""
extends: {ROOT}/cases/sphere/decay.yaml
duration: 20 s
bodies: {{sphere: {{initial: null}}}}
environment:
  waves:
    spectrum: jonswap
    significant_height: 1 m
    peak_period: 6 s
    seed: 1
    ramp: 5 s
    repeat_period: 120 s
"""
STUDY = """
case: case.yaml
parameters: {{environment.waves.significant_height: [{heights}]}}
seeds: 1-{seeds}
output: {{step: 1 s, variables: []}}
figures: {{heave: {{channel: position.sphere.heave, statistic: largest}}}}
"""
IN = re.compile(r"so far +([\d,]+) of")


class Look(NamedTuple):
    """Seconds since the start; runs that are in; seconds to read them; memory [MB] of the client
    and of its processes, the largest since the look before."""

    time: float
    runs: int
    reading: float
    client: float
    worker: float


def answer() -> Answer:
    """A look a row; how long it took, and whether all is there."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        heights = ", ".join(f"{0.5 + 0.1 * k:.1f} m" for k in range(HEIGHTS))
        study = STUDY.format(heights=heights, seeds=RUNS // HEIGHTS)
        (folder / "case.yaml").write_text(CASE)
        (folder / "study.yaml").write_text(study)
        begun = perf_counter()
        sweep = _begin(folder, "sweep", "study.yaml", "-o", "runs.nc", "--scheduler", "local")
        looks = list(_looks(sweep, folder, begun))
        if sweep.returncode:
            raise RuntimeError(f"the sweep ended with {sweep.returncode}")
        took = perf_counter() - begun
        with xr.open_dataset(folder / "runs.nc") as runs:
            complete = int((runs.status == "complete").sum())
        size = (folder / "runs.nc").stat().st_size / MEGABYTE
    remarks = [
        f"{complete:,} of {RUNS:,} runs complete in {took / 60:.1f} min,"
        f" {1e3 * took / RUNS:.1f} ms each; the file has {size:.0f} MB."
    ]
    return Answer(
        {"a sweep of short runs, by two processes": [_row(look) for look in looks]}, remarks
    )


def _row(look: Look) -> Row:
    return {
        "time [s]": round(look.time),
        "runs": look.runs,
        "client [MB]": round(look.client),
        "largest worker [MB]": round(look.worker),
        "statistics [s]": f"{look.reading:.1f}" if look.reading else "-",
    }


def _looks(sweep: subprocess.Popen[bytes], folder: Path, begun: float) -> Iterator[Look]:
    """Rows for each twelfth of the runs, and one for the end."""
    process, client, worker, due = psutil.Process(sweep.pid), 0.0, 0.0, 0
    kept = folder / "runs.nc.partial" / "runs"
    while sweep.poll() is None:
        sleep(PAUSE)
        mine, others = _memory(process)
        client, worker = max(client, mine), max(worker, others)
        if not kept.exists() or _there(kept) < due:
            continue
        time, at = perf_counter() - begun, perf_counter()
        said = subprocess.run(
            [sys.executable, "-m", "hydrosim", "statistics", "runs.nc.partial"],
            cwd=folder,
            capture_output=True,
            text=True,
        ).stdout
        if found := IN.search(said):
            runs = int(found[1].replace(",", ""))
            look = Look(time, runs, perf_counter() - at, client, worker)
            print(_row(look), flush=True)
            yield look
            due, client, worker = runs + RUNS // LOOKS, 0.0, 0.0
    yield Look(perf_counter() - begun, RUNS, 0.0, client, worker)


def _there(kept: Path) -> int:
    """About how many runs are in, by the bytes of the first."""
    with kept.open("rb") as file:
        identity, first = len(file.readline()), file.readline()
    found = re.search(rb'"bytes": (\d+)', first)
    each = len(first) + int(found[1]) if found else 1
    return (kept.stat().st_size - identity) // each if found else 0


def _memory(process: psutil.Process) -> tuple[float, float]:
    """Of the client, and of the largest of its processes [MB]."""
    found = []
    for each in [process, *process.children(recursive=True)]:
        try:
            found.append(each.memory_info().rss / MEGABYTE)
        except psutil.NoSuchProcess:
            found.append(0.0)
    return found[0], max(found[1:], default=0.0)


def _begin(folder: Path, *arguments: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "hydrosim", *arguments]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL)
