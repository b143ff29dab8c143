"""Is anything lost of a run or a study that is ended by real signals, again and again?

A run, a study of a grid with seeds, one with `until` and one of operability are ended by each
signal, five times each: once while kernels are compiled or later, three times at random moments of
the whole command, and once while the result is written or after that. Each time the command goes on
with --resume. Results must be identical to those of commands that were left alone. And what do
checkpoints cost?
"""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
from collections import Counter
from dataclasses import dataclass, field, replace
from os import environ, scandir
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter, process_time, sleep

import numpy as np
import xarray as xr

from benchmarks.report import ROOT, Answer, Row
from benchmarks.scenes import base_case
from hydrosim import simulate
from hydrosim.compare.dataset import differences
from hydrosim.files.outputs import Output
from hydrosim.run.checkpoint import Checkpoint
from hydrosim.scene import Solver
from tests.command_line import heed_signals

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL)
KILLS, REPEATS = 5, 5
INTERRUPTED = 130, -signal.SIGINT
"""To a shell the same: Python ends itself by SIGINT after an interrupt in `exec` of a text."""
WRITING_S = 0.4  # after the first file of a result appears
COSTED = 2e-3  # s: a few seconds
FILES = ("cases/reverse_float_over", "hydro_db")
HEAD = f"case: {FILES[0]}/base.yaml\nduration: 800 s\n"
CRAWL = "crawl: {channel: position.barge.surge, statistic: change_absolute"
STUDIES = {
    "grid": f"""\
parameters: {{forces.interface.friction.static: [0.15, 0.2, 0.4]}}
seeds: 1-8
figures: {{{CRAWL}}}}}
""",
    "until": f"""\
seeds: 1-3
until: {{figure: crawl, wide: 1 mm, most: 24}}
figures: {{{CRAWL}}}}}
""",
    "limits": f"""\
seeds: 1-5
criteria: {{{CRAWL}, limit: 0.4 m}}}}
operability:
  heights: {{from: 0.5 m, to: 2.5 m, apart: 0.25 m}}
  peak_periods: [8 s, 9 s]
  probability: 50 %
""",
}
FINELY = ("--set", "duration=800 s", "--set", "solver.step=1e-3 s", "--checkpoint", "1")


def answer(kills: int = KILLS) -> Answer:
    """What comes of each command, by signal; the cost of checkpoints."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        for file in FILES:
            shutil.copytree(ROOT / file, folder / file, ignore=shutil.ignore_patterns("*.png"))
        commands = {"run": ("run", f"{FILES[0]}/base.yaml", *FINELY)}
        for study, text in STUDIES.items():
            (folder / f"{study}.yaml").write_text(HEAD + text)
            commands[study] = ("study", f"{study}.yaml")
        rows = []
        for title, arguments in commands.items():
            trial = _Trial(title, folder, arguments)
            rows += [trial.end_by(number, kills) for number in SIGNALS]
        cost = _checkpoint_cost(folder)
    return Answer({f"ended by signals, {kills} times each": rows, "cost": [cost]})


@dataclass
class _Trial:
    """A command in a folder, left alone at first: how long it takes with kernels compiled and
    without, and what it writes."""

    title: str
    folder: Path
    arguments: tuple[str, ...]
    lengths: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.inputs = self._names()
        for _ in range(2):
            begun = perf_counter()
            if self._begin().wait():
                raise RuntimeError(f"{self.title} fails when it is left alone: {self._told}")
            self.lengths.append(perf_counter() - begun)
        self.whole = xr.load_dataset(self._result)
        self.written = self._names()
        self._remove(self.written - self.inputs)

    def end_by(self, number: int, kills: int) -> Row:
        """What comes of the command, ended so often by a signal and resumed as often."""
        random = np.random.default_rng(number)
        shutil.rmtree(self._cache)
        ends, faults = Counter[int](), Counter[str]()
        while ends.total() < kills:
            first = not ends
            process = self._begin(*([] if first else ["--resume"]))
            if ends.total() == kills - 1:
                self._wait_for_writing(process)
                moment = random.uniform(0.0, WRITING_S)
            else:
                moment = random.uniform(0.0, self.lengths[0 if first else 1])
            try:
                process.wait(moment)
            except subprocess.TimeoutExpired:
                process.send_signal(number)
                code = process.wait()
                ends[code] += 1
                print(self.title, number, f"{moment:.2f} s: {code}", file=sys.stderr, flush=True)
                if code not in (0, *INTERRUPTED, -number) or "Traceback" in self._told:
                    faults[f"exit code {code}: {self._told}"] += 1
            else:
                faults += self._faults(process)
        process = self._begin("--resume")
        process.wait()
        faults += self._faults(process)
        return {
            "command": self.title,
            "left alone [s]": round(self.lengths[1], 1),
            "signal": signal.Signals(number).name,
            "exit codes": ", ".join(f"{code} ({times})" for code, times in sorted(ends.items())),
            "faults": ", ".join(f"{fault} ({times})" for fault, times in faults.items()) or "none",
        }

    def _faults(self, done: subprocess.Popen[bytes]) -> Counter[str]:
        """What is wrong with the result of a command that came to its end; the result goes."""
        if done.returncode:
            return Counter({f"exit code {done.returncode}: {self._told}": 1})
        lines = differences(self.whole, xr.load_dataset(self._result))
        names = self._names()
        faults = [*lines, *(f"file {name}" for name in names ^ self.written)]
        self._remove(names - self.inputs)
        return Counter(faults)

    @property
    def _result(self) -> Path:
        return self.folder / f"{self.title}.nc"

    @property
    def _cache(self) -> Path:
        return self.folder / "cache"

    @property
    def _told(self) -> str:
        return (self.folder / "told").read_text()

    def _begin(self, *more: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "hydrosim", *self.arguments, "-o", self._result.name]
        with (self.folder / "told").open("w") as told:
            return subprocess.Popen(
                [*command, *more],
                cwd=self.folder,
                env={**environ, "HYDROSIM_CACHE_DIR": str(self._cache)},
                stdout=subprocess.DEVNULL,
                stderr=told,
                preexec_fn=heed_signals,
            )

    def _wait_for_writing(self, process: subprocess.Popen[bytes]) -> None:
        """Wait until the first file of the result is there, or the process has ended."""
        before = self._files_of_result()
        while process.poll() is None and self._files_of_result() <= before:
            sleep(0.002)

    def _files_of_result(self) -> set[tuple[str, int]]:
        """The result and the temporary folders that it is written in."""
        name = self._result.name
        return {
            (entry.name, entry.inode())
            for entry in scandir(self.folder)
            if entry.name == name or entry.name.startswith(f".hydrosim-{name}-")
        }

    def _names(self) -> set[str]:
        names = {path.name for path in self.folder.iterdir()}
        return names - {"told", "cache"}

    def _remove(self, names: set[str]) -> None:
        for name in names:
            path = self.folder / name
            shutil.rmtree(path) if path.is_dir() else path.unlink()


def _checkpoint_cost(folder: Path) -> Row:
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
