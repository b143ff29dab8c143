"""What becomes of mutants of the shipped cases? A message or a run: no traceback, no hang, no
crash, nothing that is not finite.

    python -m tests.generators.mutant_trials --check 3000 --run 500 --seed 1 [--write FOLDER]

`hydrosim check` is asked of so many, and so many with other numbers are run, shortened to 10 s,
each by a worker that is killed after 20 s of CPU time, with 8 GB of memory.
"""

from __future__ import annotations

import argparse
import io
import os
import resource

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import shutil
import warnings
from collections import Counter
from contextlib import redirect_stderr, redirect_stdout
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from traceback import format_exc

import numpy as np
import xarray as xr

from benchmarks.random_trial import Outcome
from benchmarks.worker import COMPILING, Question, Worker
from hydrosim.__main__ import app
from hydrosim.errors import HydrosimError
from hydrosim.results.stages import FIGURES, TIME
from tests.generators.mutants import CASES, SHORT, Mutant, mutants, text_of

LIMIT = 20.0  # s of CPU time
MEMORY = 8_000_000_000  # bytes
WORDY = 3000  # characters of a message: more is not read
MAY_LACK = {
    *("slow_draught", "fender_closings", "fender_closing_speed", "fender_largest_force"),
    *(TIME, *FIGURES),
}
"""Variables that are not a number for bodies, contacts and stages that have none of it."""
Asked = tuple[str, Mutant, str]
"""check or run, of a mutant, in a copy of the cases."""


def prepare(folder: Path) -> None:
    """A copy of the cases in a ``folder``, with what they need."""
    shutil.copytree(CASES, folder / "cases", ignore=shutil.ignore_patterns("*.nc", "*.png"))
    (folder / "hydro_db").symlink_to(CASES.parent / "hydro_db")


def tried(asked: Asked) -> Outcome:
    """Check or run a mutant."""
    command, mutant, folder = asked
    path = Path(folder, "cases", mutant.case).with_name("mutant.yaml")
    result = path.with_suffix(".nc")
    path.write_text(text_of(mutant, SHORT if command == "run" else None))
    result.unlink(missing_ok=True)
    more = ["-o", str(result), "--set", "solver.unstable=warn"] if command == "run" else []
    try:
        with warnings.catch_warnings(), _quiet():
            warnings.simplefilter("ignore")
            app([command, str(path), *more], standalone_mode=False)
    except HydrosimError as error:
        return said("failed" if error.exit_code == 3 else "refused", str(error))
    except Exception:
        return Outcome("crash", format_exc(limit=-6))
    return _judged(result) if command == "run" else Outcome("complete")


def tried_in_little_memory(asked: Asked) -> Outcome:
    """The same in a process that may have no more than `MEMORY`."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    return tried(asked)


@cache
def _room() -> io.StringIO:
    return io.StringIO()


class _quiet:
    """Prints to nowhere, as to a terminal of a user."""

    def __enter__(self) -> None:
        self._both = redirect_stdout(_room()), redirect_stderr(_room())
        for each in self._both:
            each.__enter__()

    def __exit__(self, *error: object) -> None:
        for each in self._both:
            each.__exit__(*error)  # type: ignore[arg-type]


def said(status: str, message: str) -> Outcome:
    """A message is for people."""
    if len(message) > WORDY or any(ord(c) < 32 and c not in "\n\t" for c in message):
        return Outcome("crash", f"a message of {len(message)} characters: {message[:500]!r}")
    return Outcome(status, message)


def _wild(name: str, values: np.ndarray) -> bool:
    """Whether there is what is not finite; not a number may be what does not apply."""
    return bool(np.isinf(values).any() if name in MAY_LACK else not np.isfinite(values).all())


def _judged(result: Path) -> Outcome:
    run = xr.load_dataset(result, engine="netcdf4")
    wild = [str(n) for n, x in run.items() if x.dtype.kind == "f" and _wild(str(n), x.values)]
    if wild:
        return Outcome("crash", f"not finite, and {run.attrs['status']}: {', '.join(wild)}")
    return Outcome(str(run.attrs["status"]))


def main() -> int:
    """Answer what the command line asks."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else None)
    parser.add_argument("--check", type=int, default=3000, help="how many to check")
    parser.add_argument("--run", type=int, default=500, help="how many to run")
    parser.add_argument("--seed", type=int, default=1, help="of all mutants")
    parser.add_argument("--write", type=Path, help="folder for case files of offenders")
    parser.add_argument("--messages", action="store_true", help="print what is said of each")
    given = parser.parse_args()
    ends: dict[str, Counter[str]] = {"check": Counter(), "run": Counter()}
    chosen = mutants(given.check, given.seed) + mutants(given.run, given.seed, of_values=True)
    with TemporaryDirectory() as name:
        prepare(Path(name))
        died = Outcome("crash", "the process died")
        worker = Worker({"try": Question(tried_in_little_memory, LIMIT, died, patience=COMPILING)})
        for number, mutant in enumerate(chosen):
            command = "check" if number < given.check else "run"
            outcome = worker.ask("try", (command, mutant, name)) or Outcome("hang")
            ends[command][outcome.status] += 1
            if number % 100 == 99:
                print(f"{number + 1} done", flush=True)
            if outcome.status in ("hang", "crash") or given.messages:
                print(
                    f"\n{number} {command} {mutant}: {outcome.status}\n{outcome.message}",
                    flush=True,
                )
            if outcome.status in ("hang", "crash") and given.write:
                short = SHORT if command == "run" else None
                (given.write / f"{number}_{command}.yaml").write_text(text_of(mutant, short))
    for command, count in ends.items():
        print(f"{command}: {sum(count.values())} mutants of seed {given.seed}, {dict(count)}")
    return int(any(count["crash"] + count["hang"] for count in ends.values()))


if __name__ == "__main__":
    raise SystemExit(main())
