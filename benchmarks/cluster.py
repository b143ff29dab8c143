"""Do two workers of a dask scheduler make as many runs in a time as two threads of this process?

Seeds of the base case over 3 h by `hydrosim sweep`, with and without `--scheduler` by turns; the
scheduler and its workers have processes of their own, and answer over TCP. Times are those of the
whole command. The files of both must be identical.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter, sleep

import psutil

from benchmarks.report import ROOT, Answer, Row

RUNS = int(os.environ.get("RUNS", "120"))
WORKERS, REPEATS = 2, 3
STUDY = f"""
case: {ROOT}/cases/reverse_float_over/base.yaml
duration: 3 hour
seeds: 1-{RUNS}
output: {{step: 1 s, variables: []}}
figures: {{crawl: {{channel: position.barge.surge, statistic: end}}}}
"""
HERE = "threads of the command"


def answer() -> Answer:
    """Runs per minute by each, and their ratio."""
    with TemporaryDirectory() as name, _cluster(Path(name)) as address:
        folder, there = Path(name), f"{WORKERS} workers over TCP"
        (folder / "study.yaml").write_text(STUDY)
        options = {HERE: ["--workers", str(WORKERS)], there: ["--scheduler", address]}
        for more in options.values():  # compiles, the first time
            _sweep(folder, "first.nc", more)
        times: dict[str, list[float]] = {by: [] for by in options}
        busy = []
        for _ in range(REPEATS):
            for by, more in options.items():
                busy.append(psutil.cpu_percent(interval=1.0))
                times[by].append(_sweep(folder, f"{by.split()[-1]}.nc", more))
        same = _command(folder, "compare", "--exact", "command.nc", "TCP.nc").returncode == 0
    rows = [_row(by, found) for by, found in times.items()]
    ratios = [one / other for one, other in zip(times[HERE], times[there], strict=True)]
    remarks = [
        f"throughput over that without: {median(ratios):.2f} ({min(ratios):.2f} to"
        f" {max(ratios):.2f}); other programs took {max(busy):.0f} % of the machine at most.",
        f"the files are {'identical' if same else 'DIFFERENT'}.",
    ]
    return Answer({f"{RUNS} runs of 3 h, {REPEATS} repeats by turns": rows}, remarks)


def _row(by: str, found: list[float]) -> Row:
    return {
        "by": by,
        "time [s]": f"{median(found):.1f} ({min(found):.1f} to {max(found):.1f})",
        "runs per minute": round(60.0 * RUNS / median(found)),
    }


def _sweep(folder: Path, output: str, options: list[str]) -> float:
    begun = perf_counter()
    done = _command(folder, "sweep", "study.yaml", "-o", output, "--overwrite", *options)
    if done.returncode:
        raise RuntimeError(done.stderr)
    return perf_counter() - begun


def _command(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "hydrosim", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True)


@contextmanager
def _cluster(folder: Path) -> Iterator[str]:
    """The address of a scheduler with so many workers, each a process with one thread."""
    file = folder / "scheduler.json"
    where = "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(file), "--no-dashboard"
    processes = [_process("dask_scheduler", *where)]
    try:
        while not (file.exists() and file.stat().st_size):
            sleep(0.1)
        address = json.loads(file.read_text())["address"]
        alone = "--nworkers", str(WORKERS), "--nthreads", "1", "--host", "127.0.0.1"
        processes.append(_process("dask_worker", address, *alone, "--no-dashboard"))
        yield address
    finally:
        for process in reversed(processes):
            process.terminate()
            process.wait()


def _process(module: str, *arguments: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", f"distributed.cli.{module}", *arguments]
    quiet = subprocess.DEVNULL
    return subprocess.Popen(command, stdout=quiet, stderr=quiet)
