"""What becomes of mutants of the shipped cases, and of all other files that are read?

A message or a run: no traceback, no hang, no crash, nothing that is not finite, no other reading in
silence.

    python -m benchmarks.mutants --check 3000 --run 500 --seed 1 [--write FOLDER]
    python -m benchmarks.mutants --papers 1500 --seed 1 [--kinds NAMES]

`hydrosim check` is asked of so many, and so many with other numbers are run, shortened to 10 s,
each by a worker that is killed after 20 s of CPU time, with 8 GB of memory. Papers are studies,
recipes, results and files of other programs (`tests.generators.mutant_papers`).
"""

from __future__ import annotations

import argparse
import os
import resource

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.generators import mutant_papers
from tests.generators.mutant_trials import Asked, Outcome, prepare, tried
from tests.generators.mutants import SHORT, Mutant, mutants, text_of
from tests.generators.worker import COMPILING, Question, Worker

LIMIT = 20.0  # s of CPU time
MEMORY = 8_000_000_000  # bytes
BAD = ("hang", "crash", "silent")

Trial = tuple[str, Outcome, Mutant | None]
"""What was asked of which mutant, what came of it, and the mutant if it is one of a case."""


def tried_in_little_memory(asked: Asked) -> Outcome:
    """Try a mutant in a process that may have no more than `MEMORY`."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    return tried(asked)


def try_cases(checks: int, runs: int, seed: int) -> Iterator[Trial]:
    """Mutants of cases that are checked, and others that are run."""
    chosen = [("check", mutant) for mutant in mutants(checks, seed)]
    chosen += [("run", mutant) for mutant in mutants(runs, seed, of_values=True)]
    with TemporaryDirectory() as folder:
        prepare(Path(folder))
        died = Outcome("crash", "the process died")
        worker = Worker({"try": Question(tried_in_little_memory, LIMIT, died, patience=COMPILING)})
        for command, mutant in chosen:
            outcome = worker.ask("try", (command, mutant, folder)) or Outcome("hang")
            yield command, outcome, mutant


def try_papers(count: int, seed: int, kinds: list[str]) -> Iterator[Trial]:
    """Mutants of other files, of each of the ``kinds`` in turn."""
    with TemporaryDirectory() as folder:
        mutant_papers.prepare(Path(folder))
        for k in range(count):
            kind = kinds[k % len(kinds)]
            what, outcome = mutant_papers.trial(kind, seed * 1_000_000 + k, Path(folder))
            yield f"{kind} {what}", outcome, None


def read_arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else None)
    parser.add_argument("--check", type=int, default=0, help="how many cases to check")
    parser.add_argument("--run", type=int, default=0, help="how many cases to run")
    parser.add_argument("--papers", type=int, default=0, help="how many other files to read")
    parser.add_argument("--kinds", default="", help="of papers, by commas; default: all")
    parser.add_argument("--seed", type=int, default=1, help="of all mutants")
    parser.add_argument("--write", type=Path, help="folder for case files of offenders")
    parser.add_argument("--messages", action="store_true", help="print what is said of each")
    return parser.parse_args()


def main() -> int:
    """Answer what the command line asks: 1 if any mutant is an offence."""
    given = read_arguments()
    kinds = given.kinds.split(",") if given.kinds else [*mutant_papers.papers()]
    trials = [try_cases(given.check, given.run, given.seed)] if given.check + given.run else []
    trials += [try_papers(given.papers, given.seed, kinds)] if given.papers else []
    ends = Counter[str]()
    for number, (what, outcome, mutant) in enumerate(t for group in trials for t in group):
        ends[outcome.status] += 1
        if number % 100 == 99:
            print(f"{number + 1} done", flush=True)
        if outcome.status in BAD or (given.messages and outcome.message):
            about = f"{what} {mutant or ''}".strip()
            print(f"\n{number} {about}: {outcome.status}\n{outcome.message}", flush=True)
        if outcome.status in BAD and given.write and mutant:
            text = text_of(mutant, SHORT if what == "run" else None)
            given.write.mkdir(parents=True, exist_ok=True)
            (given.write / f"{number}_{what}.yaml").write_text(text)
    print(f"{ends.total()} mutants of seed {given.seed}, {dict(ends)}")
    return int(any(ends[status] for status in BAD))


if __name__ == "__main__":
    raise SystemExit(main())
