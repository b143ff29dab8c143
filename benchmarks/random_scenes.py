"""What becomes of random scenes? None may hang or crash; what is complete and unwarned is right.

    python -m benchmarks.random_scenes --number 3000 --seed 1 [--from 0] [--converge 200]

Scenes are those of `random_cases`, each run by a worker that is killed after 30 s of CPU time. Of
those that are complete, so many without a warning (and those with one that come along) are run at a
quarter of the step, too; where motions differ by more than 1e-3 of their range, it is measured how
fast two runs part that begin 1e-9 m apart. `--write FOLDER` keeps the case files of the offenders.
"""

from __future__ import annotations

import argparse
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from benchmarks.random_trial import OPEN, WITHIN, Convergence, Outcome, compared, tried
from benchmarks.report import Row, markdown
from benchmarks.worker import COMPILING, Question, Worker
from tests.generators.random_cases import random_case, text_of

SEEDS = 1_000_000  # scenes of a seed
KINDS = ("complete", "failed", "refused", "crash", "hang")
BLOCKED = Outcome("hang")
OF_ERROR = ("solver.step", "the energy balance", "friction of", "the motion of")
"""What warnings of the solution begin with, which a finer step can tell from false alarms; others
are of databases, headings, places and angles, of which it knows nothing."""


class Finding(NamedTuple):
    """What became of the scene ``number``."""

    number: int
    method: str
    outcome: Outcome
    convergence: Convergence | None

    @property
    def warned(self) -> bool:
        """Whether the run said that something is not as it should be."""
        return bool(self.outcome.warnings)

    @property
    def warned_of_error(self) -> bool:
        """Whether it said that its own solution may be wrong, and not what it stands for."""
        return any(line.startswith(OF_ERROR) for line in self.outcome.warnings.splitlines())


def _try(number: int) -> Outcome:
    return tried(random_case(number))


def _compare(number: int) -> Convergence:
    return compared(random_case(number))


QUESTIONS = {
    "try": Question(_try, 30.0, Outcome("crash", "the process died"), patience=COMPILING),
    "compare": Question(_compare, 90.0),
}


def findings(first: int, count: int, converge: int) -> Iterator[Finding]:
    """Run ``count`` scenes from ``first`` on; compare until ``converge`` unwarned ones are."""
    worker, done = Worker(QUESTIONS), 0
    for number in range(first, first + count):
        outcome = worker.ask("try", number) or BLOCKED
        convergence = None
        if outcome.status == "complete" and done < converge:
            convergence = worker.ask("compare", number)
        finding = Finding(number, random_case(number)["solver"]["method"], outcome, convergence)
        done += convergence is not None and not finding.warned_of_error
        yield finding


def offences(finding: Finding) -> Iterator[str]:
    """What is wrong with what became of a scene."""
    outcome, convergence = finding.outcome, finding.convergence
    if outcome.status in ("crash", "hang"):
        yield outcome.status
    if outcome.status == "complete" and not finding.warned_of_error:
        if not outcome.residual <= OPEN:
            yield "open ledger, no warning"
        if convergence and not convergence.apart <= WITHIN:
            yield "not converged, no warning"


def tables(found: list[Finding]) -> Iterator[tuple[str, list[Row]]]:
    """How scenes ended by method, what ledgers say, and what a finer step does."""
    methods = sorted({f.method for f in found})
    ends: list[Row] = []
    for method in (*methods, "all"):
        own = [f for f in found if method in (f.method, "all")]
        count = Counter(f.outcome.status for f in own)
        complete = [f for f in own if f.outcome.status == "complete"]
        unwarned = [f for f in complete if not f.warned]
        ends.append(
            {
                "method": method,
                **{kind: count[kind] for kind in KINDS},
                "warned": len(complete) - len(unwarned),
                f"unwarned above {OPEN:g}": sum(f.outcome.residual > OPEN for f in unwarned),
                "largest of them": max((f.outcome.residual for f in unwarned), default=0.0),
            }
        )
    yield "How they ended", ends
    judged = [f for f in found if f.convergence]
    if judged:
        yield (
            f"Motions at a quarter of the step, within {WITHIN:g} of their range",
            _agreement(judged),
        )


def _agreement(judged: list[Finding]) -> list[Row]:
    """Scenes that agree with themselves at a finer step, and that do not, by their warnings."""
    kinds = {
        "unwarned": [f for f in judged if not f.warned],
        "warned of what they stand for alone": [
            f for f in judged if f.warned and not f.warned_of_error
        ],
        "warned of their solution": [f for f in judged if f.warned_of_error],
    }
    rows: list[Row] = []
    for kind, those in kinds.items():
        agree = sum(f.convergence.apart <= WITHIN for f in those if f.convergence)
        apart = len(those) - agree
        rows.append({"": kind, "agree with the finer step": agree, "do not": apart})
    return rows


def report(found: list[Finding], folder: Path | None) -> None:
    """Print tables and offenders; keep the case files of the latter."""
    for title, rows in tables(found):
        print(f"\n{title}\n\n{markdown(rows)}")
    print("\nOffenders")
    for finding in found:
        for offence in offences(finding):
            print(f"{finding.number} {finding.method}: {offence}{_detail(finding)}")
            if folder is not None:
                text = f"# {offence}\n{text_of(random_case(finding.number))}"
                (folder / f"{finding.number}.yaml").write_text(text)


def _detail(finding: Finding) -> str:
    outcome, c = finding.outcome, finding.convergence
    parts = [outcome.message.strip()] if outcome.status in ("crash", "hang") else []
    parts += [f"residual {outcome.residual:.1e}"] if outcome.status == "complete" else []
    if c and not c.apart <= WITHIN:
        parts.append(f"{c.apart:.1e} apart")
        parts.append(c.remark or f"nearby runs part {c.grown:.1e} times, {c.rate:.2f} 1/s")
    return "; " + ", ".join(parts)


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--number", type=int, default=300, help="how many scenes")
    parser.add_argument("--seed", type=int, default=1, help="of all scenes")
    parser.add_argument("--from", type=int, default=0, dest="first", help="number of the first")
    parser.add_argument("--converge", type=int, default=0, help="how many unwarned to compare")
    parser.add_argument("--write", type=Path, help="folder for case files of offenders")
    parser.add_argument("--verbose", action="store_true", help="a line for each scene")
    given = parser.parse_args()
    found = []
    for finding in findings(given.seed * SEEDS + given.first, given.number, given.converge):
        found.append(finding)
        if given.verbose:
            print(finding, flush=True)
    report(found, given.write)


if __name__ == "__main__":
    main()
