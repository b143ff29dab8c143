"""Are random operations right where they are complete and unwarned?

    python -m benchmarks.mixed_scenes --number 400 [--from 0] [--write FOLDER]

Cases are those of `mixed_cases`. Each is run in a worker that is killed after 60 s of CPU time.
Its references are runs by dopri5 at tolerances 1e-10 and 1e-11. They count where they agree to 1e-4
of the range of each motion. A line is printed for each case, as it is done.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import warnings
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from traceback import format_exc
from typing import NamedTuple
from unittest.mock import patch

import numpy as np

import hydrosim as hs
from benchmarks.mixed_cases import MESH, mesh_of, mixed_case
from benchmarks.random_cases import Case, read_arguments, text_of
from benchmarks.random_trial import WITHIN, distance
from benchmarks.worker import Question, Worker
from hydrosim.errors import HydrosimError, InputError
from hydrosim.studies.run import simulation
from hydrosim.studies.run.twin import Estimate

LIMIT = 60.0  # s of CPU
FIRM = 1e-4  # of the range of a motion: what references agree to
REFERENCES = (1e-10, 1e-11)


class Outcome(NamedTuple):
    """How a run ended, what was said, its positions (nt, nb, 6), CPU [s], evaluations."""

    status: str
    said: str = ""
    position: np.ndarray | None = None
    cpu: float = 0.0
    evaluations: int = 0
    events: int = 0


class Finding(NamedTuple):
    """A case, its run, how far that is from the reference, and references from each other."""

    number: int
    method: str
    outcome: Outcome
    apart: float
    references_apart: float

    @property
    def firm(self) -> bool:
        """Whether the references agree."""
        return self.references_apart <= FIRM

    @property
    def right(self) -> bool:
        """Whether the run agrees with a reference that counts."""
        return self.firm and self.apart <= WITHIN

    @property
    def warned(self) -> bool:
        """Whether the run has said anything."""
        return bool(self.outcome.said)


def _try(number: int) -> Outcome:
    return _outcome(number, mixed_case(number))


def _reference(question: tuple[int, float]) -> Outcome:
    number, tolerance = question
    case = mixed_case(number)
    each = dict.fromkeys(("relative", "position", "angle"), tolerance)
    case["solver"] = {"method": "dopri5", "step": 0.005, "tolerance": each}
    with patch.object(simulation, "estimated", lambda *_: Estimate()):
        return _outcome(number, case)


def _outcome(number: int, case: Case) -> Outcome:
    begin = process_time()
    try:
        with TemporaryDirectory() as folder, warnings.catch_warnings():
            warnings.simplefilter("ignore")
            mesh = mesh_of(number)
            if mesh is not None:
                Path(folder, MESH).write_text(mesh)
            path = Path(folder, "case.yaml")
            path.write_text(text_of(case))
            run = hs.simulate(hs.load_case(path))
    except InputError as error:
        return Outcome("refused", str(error))
    except HydrosimError as error:
        return Outcome("failed", str(error), None, process_time() - begin)
    except Exception:
        return Outcome("crash", format_exc(limit=-4))
    a = run.attrs
    return Outcome(
        str(a["status"]),
        str(a.get("warnings") or ""),
        run.position.values,
        process_time() - begin,
        int(a["solver_evaluations"]),
        int(a["solver_events"]),
    )


QUESTIONS = {
    "try": Question(_try, LIMIT, Outcome("crash", "the process died"), patient=True),
    "reference": Question(_reference, 2.0 * LIMIT, Outcome("crash", "the process died")),
}


def findings(first: int, count: int) -> Iterator[Finding]:
    """Run ``count`` cases from ``first`` on, and their references."""
    worker = Worker(QUESTIONS)
    for number in range(first, first + count):
        outcome = worker.ask("try", number) or Outcome("hang", "", None, LIMIT)
        apart = references_apart = float("nan")
        if outcome.status not in ("refused", "crash"):
            references = []
            for tolerance in REFERENCES:
                reference = worker.ask("reference", (number, tolerance))
                if reference is None or reference.status != "complete":
                    break
                references.append(reference.position)
            if len(references) == len(REFERENCES):
                references_apart = distance(*references)
                if outcome.status == "complete":
                    apart = distance(outcome.position, references[-1])
        method = mixed_case(number)["solver"]["method"]
        yield Finding(number, method, outcome, apart, references_apart)


def report(found: list[Finding]) -> None:
    """Print how many there are of each kind."""
    print(dict(Counter(f.outcome.status for f in found)))
    firm = [f for f in found if f.firm]
    complete = [f for f in firm if f.outcome.status == "complete"]
    unwarned = [f for f in complete if not f.warned]
    right = [f for f in complete if f.right]
    print(f"references agree to {FIRM:g}: {len(firm)}")
    print(f"of those complete: {len(complete)}")
    print(f"complete and unwarned: {len(unwarned)}")
    print(f"of those beyond {WITHIN:g}: {[(f.number, f.apart) for f in unwarned if not f.right]}")
    print(f"right: {len(right)}, of those warned: {sum(f.warned for f in right)}")
    print(f"beyond {LIMIT:g} s of CPU: {[f.number for f in found if f.outcome.cpu >= LIMIT]}")


def main() -> None:
    """The command line."""
    given = read_arguments(__doc__, 400)
    found = []
    for finding in findings(given.first, given.number):
        found.append(finding)
        print(_line(finding), flush=True)
        wrong = finding.firm and not finding.right and not finding.warned
        if wrong and given.write:
            text = text_of(mixed_case(finding.number))
            (given.write / f"{finding.number}.yaml").write_text(text)
    report(found)


def _line(f: Finding) -> str:
    o = f.outcome
    said = o.said.replace("\n", " | ")
    return (
        f"{f.number} {f.method} {o.status} apart {f.apart:.1e} references {f.references_apart:.1e}"
        f" cpu {o.cpu:.1f} evaluations {o.evaluations} events {o.events}: {said[:300]}"
    )


if __name__ == "__main__":
    main()
