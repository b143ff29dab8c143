"""Do random scenes turn as a whole, go on from a state on the way, and keep their energy?

    python -m benchmarks.scene_trials --kind joints --number 300 [--from 0] [--write FOLDER]

`tests.generators.scene_trials` judges each in a worker that is killed after 60 s of CPU time.
Scenes with contacts are not turned, since their generator turns none.
Whether a scene is right, `error_scenes` tells.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
from collections import Counter
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path

from tests.generators.articulated_cases import articulated_case
from tests.generators.moored_cases import moored_case
from tests.generators.random_cases import random_case, text_of
from tests.generators.scene_trials import Maker, Trial, offences, tried
from tests.generators.worker import COMPILING, Question, Worker

LIMIT = 60.0  # s of CPU
MAKERS: Mapping[str, Maker] = {
    "joints": articulated_case,
    "lines": moored_case,
    "contacts": random_case,
}
TURNING = ("joints", "lines")


def trials(kind: str, first: int, count: int) -> Iterator[tuple[int, Trial]]:
    """Run ``count`` cases of a ``kind`` from ``first`` on."""
    died = Trial("crash", "the process died")
    answer = partial(tried, MAKERS[kind], turns=kind in TURNING)
    worker = Worker({"try": Question(answer, LIMIT, died, COMPILING)})
    for number in range(first, first + count):
        yield number, worker.ask("try", number) or Trial("hang", cpu=LIMIT)


def read_arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--kind", choices=tuple(MAKERS), default="joints")
    parser.add_argument("--number", type=int, default=300, help="how many cases")
    parser.add_argument("--from", type=int, default=0, dest="first", help="number of the first")
    parser.add_argument("--write", type=Path, help="folder for case files of those that are wrong")
    return parser.parse_args()


def main() -> None:
    """The command line."""
    given = read_arguments()
    case_of = MAKERS[given.kind]
    found = {}
    for number, trial in trials(given.kind, given.first, given.number):
        found[number] = trial
        print(_line(case_of, number, trial), flush=True)
        if given.write and any(offences(trial)):
            (given.write / f"{number}.yaml").write_text(text_of(case_of(number)))
    print(dict(Counter(trial.status for trial in found.values())))
    for number, trial in found.items():
        for offence in offences(trial):
            print(f"{number}: {offence}")


def _line(case_of: Maker, number: int, t: Trial) -> str:
    said = t.said.replace("\n", " | ")
    method = case_of(number)["solver"]["method"]
    return (
        f"{number} {method} {t.status} turned {t.turned:.1e} cpu {t.cpu:.1f}"
        f" evaluations {t.evaluations} events {t.events} {'; '.join(t.wrong)}: {said[:300]}"
    )


if __name__ == "__main__":
    main()
