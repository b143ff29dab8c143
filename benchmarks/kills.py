"""Is anything lost of a run or a sweep that is ended by real signals, again and again?

A run of a minute or more and a sweep of 200 runs are ended at ten random times by each signal, one
after the other: each time they go on with --resume, until they are done. Their results must be
identical to those of commands that were left alone. And what do checkpoints cost?
"""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter, process_time

import numpy as np
import xarray as xr

from benchmarks.report import ROOT, Answer, Row
from benchmarks.scenes import base_case
from hydrosim import simulate
from hydrosim.compare.dataset import differences
from hydrosim.files.outputs import Output
from hydrosim.run.checkpoint import Checkpoint
from hydrosim.scene import Solver

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL)
KILLS, REPEATS = 10, 5
STEP = 1e-4  # s: the base case takes a minute and more
COSTED = 2e-3  # s: a few seconds
RUNS = 200
FILES = ("cases/reverse_float_over", "hydro_db")


def answer(step: float = STEP, runs: int = RUNS, kills: int = KILLS) -> Answer:
    """Identical or not, by signal; the cost of checkpoints."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        for file in FILES:
            shutil.copytree(ROOT / file, folder / file, ignore=shutil.ignore_patterns("*.png"))
        case = folder / FILES[0] / "base.yaml"
        study = folder / "study.yaml"
        study.write_text(f"case: {case}\nseeds: 1-{runs}\nduration: 400 s\noutput: {{step: 1 s}}\n")
        finely = ("--set", f"solver.step={step:g} s", "--checkpoint", "1")
        rows = [*_ended(folder, ("run", case, *finely), kills)]
        rows += _ended(folder, ("study", study), kills)
        cost = _cost(folder)
    return Answer({f"ended by signals, up to {kills} times each": rows, "cost": [cost]})


def _ended(folder: Path, command: tuple[object, ...], kills: int) -> Iterator[Row]:
    """What comes of a command that is ended, by signal."""
    whole, result = (folder / f"{command[0]}_{name}.nc" for name in ("whole", "ended"))
    begun = perf_counter()
    if _begin(*command, "-o", whole).wait():
        raise RuntimeError(f"{command[0]} fails when it is left alone")
    length = perf_counter() - begun
    for number in SIGNALS:
        times, random = 0, np.random.default_rng(number)
        while times < kills and _end(command, result, number, random, length / kills, times):
            times += 1
        last = _begin(*command, "-o", result, *_on(result, times)).wait() if times == kills else 0
        found = differences(xr.load_dataset(whole), xr.load_dataset(result))
        left = [path.name for path in folder.glob(f"{result.name}.*")]
        yield {
            "command": str(command[0]),
            "left alone [s]": round(length, 1),
            "signal": signal.Signals(number).name,
            "times": times,
            "exit code": last,
            "differences": len(found),
            "left over": ", ".join(left) or "nothing",
        }
        result.unlink()


def _end(
    command: tuple[object, ...],
    result: Path,
    number: int,
    random: np.random.Generator,
    pace: float,
    times: int,
) -> bool:
    """Begin, or go on, and end it after a while; False if it was done before that."""
    process = _begin(*command, "-o", result, *_on(result, times))
    try:
        process.wait(random.uniform(0.0, 1.5 * pace))
    except subprocess.TimeoutExpired:
        process.send_signal(number)
        process.wait()
        return True
    return False


def _on(result: Path, times: int) -> list[str]:
    return ["--resume"] if times else []


def _begin(*arguments: object) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "hydrosim", *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def _cost(folder: Path) -> Row:
    """CPU time with checkpoints as often as they may be, over that without."""
    scene = replace(base_case(), solver=Solver(step=COSTED))
    output = Output(folder / "x.checkpoint", "checkpoint", folder / "x.yaml")
    times: dict[bool, list[float]] = {False: [], True: []}
    for _ in range(REPEATS):
        for kept in times:
            begun = process_time()
            simulate(scene, None, Checkpoint(output, every=0.0) if kept else None)
            times[kept].append(process_time() - begun)
    without, with_them = (median(times[kept]) for kept in (False, True))
    return {"without [s]": round(without, 2), "with [s]": round(with_them, 2)}
