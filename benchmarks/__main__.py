"""Answer the questions named on the command line, or all but the long ones: a table each here, and
JSON and pictures in benchmarks/results/. With --keep, evidence, work_precision, chain
and flume write their pages, too.
The tables of the thesis are made by ``python -m cases.reverse_float_over.thesis``."""

from __future__ import annotations

import os
import sys

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as in hydrosim's own command line

from importlib import import_module

from benchmarks import ELSEWHERE
from benchmarks.report import keep, machine, save

QUESTIONS = (
    *("start_up", "steps_per_second", "method_costs", "step_limits", "wave_models"),
    *("many_runs", "kills"),
)
LONG = ("evidence", "work_precision", "chain", "flume", "database_cost")  # if named


def main(asked: list[str]) -> None:
    """Answer the questions, one after the other."""
    known = (*QUESTIONS, *LONG)
    keeps = "--keep" in asked
    asked = [each for each in asked if each != "--keep"]
    unknown = set(asked) - set(known)
    if unknown:
        raise SystemExit(f"no such question: {', '.join(unknown)}; there is {', '.join(known)}")
    here = machine()
    print("\n".join(f"{name}: {value}" for name, value in here.items()))
    for question in asked or QUESTIONS:
        answer = import_module(ELSEWHERE.get(question, f"benchmarks.{question}")).answer()
        print(f"\n# {question}\n\n{answer}")
        for path in [*save(question, answer, here), *(keep(answer) if keeps else ())]:
            print(f"written: {path}")


main(sys.argv[1:])
