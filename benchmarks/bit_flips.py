"""Does a bit that flips in the folder of a sweep on its way ever change a number in silence?

    python -m benchmarks.bit_flips --count 200 --seed 1

A sweep of six runs ends after four. Then one bit of one of its files is changed, and it goes on
with --resume: to the result of a sweep that was left alone, or to a message that says what to do.
"""

from __future__ import annotations

import argparse
import re
import shutil
from collections import Counter
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from traceback import format_exc
from typing import NamedTuple

import xarray as xr

from benchmarks.mutants import CASES
from benchmarks.random_trial import Outcome
from benchmarks.worker import Question, Worker
from hydrosim.compare.exact import differences
from hydrosim.errors import HydrosimError
from hydrosim.studies.sweep.study import load_study
from hydrosim.studies.sweep.sweep import run_study

RUNS, ENDED_AFTER = 6, 4
LIMIT = 60.0  # s of CPU time
WAY_OUT = re.compile("--overwrite|Move it away")
STUDY = f"""
case: {CASES / "reverse_float_over" / "base.yaml"}
seeds: 1-{RUNS}
duration: 30 s
output: {{step: 0.5 s}}
figures: {{crawl: {{channel: position.barge.surge, statistic: end}}}}
"""


class Killed(BaseException):
    """Nothing is done any more."""


class Flip(NamedTuple):
    """One bit of one of the files in a folder, by numbers that any folder has."""

    file: float
    place: float
    bit: int


def prepare(folder: Path) -> None:
    """A sweep that was left alone, and what one has left that was not."""
    (folder / "study.yaml").write_text(STUDY)
    study = load_study(folder / "study.yaml")
    run_study(study, folder / "whole.nc", 1).close()

    def killed(done: int, _: int) -> None:
        if done == ENDED_AFTER:
            raise Killed

    try:
        run_study(study, folder / "runs.nc", 1, killed)
    except Killed:
        shutil.copytree(folder / "runs.nc.partial", folder / "left")


def flips(count: int, seed: int) -> list[Flip]:
    """So many of them; the same for a seed."""
    random = Random(seed)
    return [Flip(random.random(), random.random(), random.randrange(8)) for _ in range(count)]


def tried(asked: tuple[Flip, str]) -> Outcome:
    """What becomes of a sweep after a flip."""
    flip, name = asked
    folder = Path(name)
    result = folder / "runs.nc"
    result.unlink(missing_ok=True)
    shutil.rmtree(folder / "runs.nc.partial", ignore_errors=True)
    shutil.copytree(folder / "left", folder / "runs.nc.partial")
    where = _apply(flip, folder / "runs.nc.partial")
    try:
        run_study(load_study(folder / "study.yaml"), result, 1, resume=True).close()
    except HydrosimError as error:
        told = WAY_OUT.search(str(error))
        return Outcome("told" if told else "no way out", f"{where}: {error}")
    except Exception:
        return Outcome("crash", f"{where}: {format_exc(limit=-6)}")
    found = differences(xr.load_dataset(folder / "whole.nc"), xr.load_dataset(result))
    return Outcome("different" if found else "identical", f"{where}: {found}")


def _apply(flip: Flip, folder: Path) -> str:
    """Change the bit; where it is."""
    files = sorted(folder.iterdir())
    path = files[int(flip.file * len(files))]
    content = bytearray(path.read_bytes())
    at = int(flip.place * len(content))
    content[at] ^= 1 << flip.bit
    path.write_bytes(content)
    return f"{path.name}, byte {at}, bit {flip.bit}"


def main() -> int:
    """Answer what the command line asks."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else None)
    parser.add_argument("--count", type=int, default=200, help="how many bits")
    parser.add_argument("--seed", type=int, default=1, help="of all bits")
    given = parser.parse_args()
    ends: Counter[str] = Counter()
    with TemporaryDirectory() as name:
        prepare(Path(name))
        died = Outcome("crash", "the process died")
        worker = Worker({"try": Question(tried, LIMIT, died, patient=True)})
        for flip in flips(given.count, given.seed):
            outcome = worker.ask("try", (flip, name)) or Outcome("hang")
            ends[outcome.status] += 1
            if outcome.status not in ("identical", "told"):
                print(f"\n{flip}: {outcome.status}\n{outcome.message}", flush=True)
    print(f"{given.count} bits of seed {given.seed}, {dict(ends)}")
    return int(bool({*ends} - {"identical", "told"}))


if __name__ == "__main__":
    raise SystemExit(main())
