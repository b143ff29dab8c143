"""Does every run know its error? Random scenes, run and judged by references.

    python -m benchmarks.error_scenes --kind joints --number 150 --way default rk4 automatic4
    python -m benchmarks.error_scenes --report

A scene of a kind (`error_cases`) is run in one way or in several: ``default`` with the solver that
was drawn, ``rk4`` at a fixed step that is stable, ``automatic4`` and ``automatic6`` with tolerances
of 1e-4 and 1e-6. A worker runs it and is killed after 60 s of CPU time. References are runs by
dopri5 at tolerances 1e-10 and 1e-11 without an estimate of their errors. `references` says how
far a run is from them; the range of a motion is that of the reference.

Each run is a line of JSON in FOLDER/KIND-WAY.jsonl. A second call goes on where the first has
ended, and several calls may share the folder. References are kept in FOLDER/references, or where
--references says; remove them after a change of physics.

In the report a reference counts for a question if its own error is at most a tenth of what is
judged. Warnings of the solution are told from those of what a scene stands for (databases,
headings, angles), which no reference can judge. Errors are relative to ranges of motions as the run
counts them: it has least ranges, which `references.least_ranges` gives.
"""

from __future__ import annotations

import argparse
import json
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import re
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from math import inf, nan
from pathlib import Path
from statistics import median
from time import process_time
from traceback import format_exc
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

import hydrosim as hs
from benchmarks.report import RESULTS, Row, markdown
from hydrosim.compile.compiled import Compiled
from hydrosim.errors import HydrosimError, InputError
from hydrosim.scene import Kinematics, Method, Scene
from tests.generators.error_cases import KINDS, SPACINGS, drawn_scene
from tests.generators.random_cases import text_of
from tests.generators.references import (
    COARSE,
    FINE,
    SMALLEST_RANGES,
    SPACING,
    at_stable_step,
    compile_reference,
    least_ranges,
    motion_errors,
    run_reference,
)
from tests.generators.worker import Question, Worker

WAYS = ("default", "rk4", "automatic4", "automatic6")
ACCURACIES = {"automatic4": 1e-4, "automatic6": 1e-6}
LIMIT = 60.0  # s of CPU
PATIENCE = 4.0  # times `LIMIT`, if kernels are compiled or radiation is fitted first
PARTED = 0.3  # of the range of a motion: a run is lost

Record = Mapping[str, Any]
Records = Sequence[Record]
WITHIN = 1e-3  # of the range of a motion: what is complete and unwarned keeps
BOUNDS = {"automatic4": 1e-4, "automatic6": 1e-6}
"""What automatic keeps, of the range of a motion."""
TENTH = 0.1
SMALLEST = 1e-7  # of the range of a motion: errors below are not judged
LOST = 1.0  # of the range of a motion: larger errors are alike
EDGES = (0.0, 0.1, 0.3, 1.0, 3.0, 10.0, inf)
GOOD = (0.3, 10.0)
OF_SOLUTION = (
    "solver.step",
    "solver.tolerance",
    "the energy balance",
    "friction of",
    "the motion of",
    "wrong by",
)
"""What warnings of the solution name."""
FIRST_WORDS = 8
STATUSES = ("complete", "failed", "refused", "crash", "hang")


class Outcome(NamedTuple):
    """A run: what it says (`Record`), positions (nt, nb, 6), largest contact force of each group
    (ng,), times (nt,), whether rotations are exact, and the least ranges of its motions."""

    record: Record
    position: np.ndarray | None = None
    force: np.ndarray | None = None
    time: np.ndarray | None = None
    exact: bool = True
    least: tuple[float, float] = SMALLEST_RANGES


class Reference(NamedTuple):
    """Positions (nt, nb, 6) and contact forces (ng,) of the finer reference, and of the coarser
    one."""

    position: np.ndarray
    force: np.ndarray
    coarse_position: np.ndarray
    coarse_force: np.ndarray


def run_scene(question: tuple[str, int, str]) -> Outcome:
    """Run a scene of a kind and number in a way."""
    kind, number, way = question
    begin = process_time()
    try:
        with drawn_scene(kind, number) as scene, warnings.catch_warnings():
            warnings.simplefilter("ignore")
            solved = _in_way(scene, way)
            begin = process_time()
            run = hs.simulate(solved)
    except InputError as error:
        return Outcome({"status": "refused", "message": str(error)})
    except HydrosimError as error:
        spent = process_time() - begin
        return Outcome({"status": "failed", "message": str(error), "cpu": spent})
    except Exception:
        return Outcome({"status": "crash", "message": format_exc(limit=-4)})
    record = _said(run, process_time() - begin)
    exact = scene.solver.kinematics is Kinematics.EXACT
    least = least_ranges(solved.solver, run.attrs.get("solver_accuracy"))
    motion = run.position.values, _contact_forces(run), run.time.values
    return Outcome(record, *motion, exact, least)


def _said(run: xr.Dataset, cpu: float) -> Record:
    """What a run says of itself."""
    a = run.attrs
    return {
        "status": str(a["status"]),
        "method": str(a["solver_method"]),
        "step": float(a.get("solver_step", nan)),
        "duration": float(run.time[-1] - run.time[0]),
        "stepped": str(a["solver_linear"]).startswith("stepped"),
        "cpu": cpu,
        "evaluations": int(a["solver_evaluations"]),
        "error_evaluations": int(a.get("error_evaluations", 0)),
        "events": int(a["solver_events"]),
        "warnings": str(a.get("warnings") or "").splitlines(),
        "said": _number(a.get("error_relative")),
        "said_parted": _number(a.get("error_parted")),
        "said_force": _number(a.get("error_contact_force")),
    }


def _number(value: Any) -> float | None:
    return None if value is None else float(value)


def _contact_forces(run: xr.Dataset) -> np.ndarray:
    """Largest contact force (ng,) of each group of contacts."""
    found = run.get("largest_contact_force")
    return np.zeros(0) if found is None else np.atleast_1d(found.values)


def _in_way(scene: Scene, way: str) -> Scene:
    if way == "default":
        return scene
    if way == "rk4":
        return at_stable_step(scene)
    accuracy = ACCURACIES[way]
    solver = replace(scene.solver, method=Method.AUTOMATIC, accuracy=accuracy)
    return replace(scene, solver=solver)


@lru_cache(maxsize=1)
def _compiled_reference(kind: str, number: int) -> tuple[Compiled, int]:
    with drawn_scene(kind, number) as scene:
        return compile_reference(scene, SPACINGS.get(kind, SPACING))


def try_reference(question: tuple[str, int, float]) -> Outcome:
    """Run a scene of a kind and number with a tolerance, or say why that fails."""
    kind, number, tolerance = question
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            compiled, finer = _compiled_reference(kind, number)
            run = run_reference(compiled, tolerance)
    except HydrosimError as error:
        return Outcome({"status": "failed", "message": str(error)})
    last = run.sizes["time"] - 1
    asked = np.union1d(np.arange(0, last + 1, finer), last)  # the end may be between samples
    return Outcome({"status": "complete"}, run.position.values[asked], _contact_forces(run))


QUESTIONS = {
    "run": Question(run_scene, LIMIT, Outcome({"status": "crash"}), PATIENCE),
    "reference": Question(try_reference, LIMIT, Outcome({"status": "crash"})),
}


class Judge:
    """A worker that runs scenes of a ``kind``, and a folder that keeps its ``references``."""

    def __init__(self, kind: str, references: Path) -> None:
        self._worker = Worker(QUESTIONS)
        self._kind = kind
        self._folder = references

    def record_of(self, number: int, way: str) -> Record:
        """The record of a run."""
        found = self._worker.ask("run", (self._kind, number, way))
        outcome = found or Outcome({"status": "hang", "cpu": LIMIT})
        record = {"number": number, "kind": self._kind, "way": way, **outcome.record}
        if record["status"] == "complete":
            reference = self._reference(number)
            if isinstance(reference, Reference):
                record |= compared(outcome, reference)
            else:
                record["no_reference"] = reference
        return record

    def _reference(self, number: int) -> Reference | str:
        """The reference of a number, made or kept, or why there is none."""
        path = self._folder / f"{self._kind}-{number}.npz"
        if not path.exists():
            made = self._new_reference(number)
            if isinstance(made, str):
                return made  # another time it may be quicker
            np.savez_compressed(path, **made._asdict())
        with np.load(path) as kept:
            return Reference(**kept)

    def _new_reference(self, number: int) -> Reference | str:
        found = []
        for tolerance in (COARSE, FINE):
            outcome = self._worker.ask("reference", (self._kind, number, tolerance))
            if outcome is None:
                return f"more than {LIMIT:g} s of CPU at {tolerance:g}"
            if outcome.position is None:
                return f"{outcome.record['status']}: {outcome.record.get('message', '')}"
            found.append(outcome)
        coarse, fine = found
        return Reference(fine.position, fine.force, coarse.position, coarse.force)


def compared(outcome: Outcome, reference: Reference) -> Record:
    """How far a run is from its reference, and how far references are apart; also with the
    smallest of all least ranges, whatever the run counts."""
    fine = reference.position

    def errors_of(motion: np.ndarray, least: tuple[float, float]) -> np.ndarray:
        return motion_errors(motion, fine, outcome.exact, least).max(axis=1)

    errors = errors_of(outcome.position, outcome.least)
    apart = errors_of(reference.coarse_position, outcome.least)
    return {
        "true": float(errors.max()),
        "true_strictly": float(errors_of(outcome.position, SMALLEST_RANGES).max()),
        "true_parted": _parting(outcome.time, errors),
        "true_force": force_error(outcome.force, reference.force),
        "apart": float(apart.max()),
        "apart_strictly": float(errors_of(reference.coarse_position, SMALLEST_RANGES).max()),
        "force_apart": force_error(reference.coarse_force, reference.force),
        "references_parted": _parting(outcome.time, apart),
    }


def force_error(ours: np.ndarray, theirs: np.ndarray) -> float:
    """Largest relative error of contact forces (ng,); NaN without any."""
    known = theirs > 0.0
    if not known.any():
        return nan
    return float((np.abs(ours - theirs)[known] / theirs[known]).max())


def _parting(time: np.ndarray, errors: np.ndarray) -> float:
    """Time [s] at which errors (nt,) first exceed `PARTED`; NaN if they do not."""
    lost = np.flatnonzero(errors > PARTED)
    return float(time[lost[0]]) if lost.size else nan


def judge_scenes(kind: str, ways: list[str], numbers: range, folder: Path, kept: Path) -> None:
    """Judge scenes that FOLDER does not hold yet."""
    kept.mkdir(parents=True, exist_ok=True)
    judge = Judge(kind, kept)
    known = {(r["number"], r["way"]) for r in read_records(folder) if r["kind"] == kind}
    for number in numbers:
        for way in ways:
            if (number, way) in known:
                continue
            record = judge.record_of(number, way)
            with (folder / f"{kind}-{way}.jsonl").open("a") as file:
                file.write(json.dumps(record) + "\n")
            print(_line(record), flush=True)


def read_records(folder: Path) -> Iterator[Record]:
    """All records of a folder."""
    for path in sorted(folder.glob("*.jsonl")):
        yield from map(json.loads, path.read_text().splitlines())


def _line(r: Record) -> str:
    figures = " ".join(f"{key} {r[key]:.1e}" for key in ("said", "true", "apart") if r.get(key))
    told = "; ".join(r.get("warnings", [])) or r.get("message", "")
    cost = f"cpu {r.get('cpu', nan):.1f} evaluations {r.get('evaluations', 0)}"
    spent = f"for errors {r.get('error_evaluations', 0)} events {r.get('events', 0)}"
    head = f"{r['kind']} {r['number']} {r['way']} {r.get('method', '')} {r['status']}"
    return f"{head} {figures} {cost} {spent}: {told[:200]}"


def report(records: Records) -> str:
    """All tables."""
    tables = {
        "How runs ended": status_table,
        f"Complete and unwarned: within {WITHIN:g} of the range?": unwarned_table,
        "automatic: within its tolerance, or told?": tolerance_table,
        "Error said over true error of motions": lambda rows: ratio_table(rows, ""),
        "Error said over true error of the largest contact force": lambda rows: ratio_table(
            rows, "_force"
        ),
        "References that part: is it told?": parting_table,
        "Warned though right: true error within a tenth of the bound": false_alarm_table,
        "The same by kind of warning": warning_table,
        "Cost of the estimate: its evaluations over those of the run": cost_table,
    }
    return "\n\n".join(
        f"{title}\n\n{markdown(rows) if rows else 'none'}"
        for title, rows in ((title, make(records)) for title, make in tables.items())
    )


def _by_way(records: Records) -> Iterator[tuple[str, str, Records]]:
    """Records by way and kind, and all kinds of a way."""
    for way in dict.fromkeys(r["way"] for r in records):
        own = [r for r in records if r["way"] == way]
        kinds = list(dict.fromkeys(r["kind"] for r in own))
        for kind in kinds:
            yield way, kind, [r for r in own if r["kind"] == kind]
        if len(kinds) > 1:
            yield way, "all", own


def _rows(records: Records, make: Callable[[str, Records], Row | None]) -> list[Row]:
    found = ((way, kind, make(way, own)) for way, kind, own in _by_way(records))
    return [{"way": way, "kind": kind, **row} for way, kind, row in found if row]


def status_table(records: Records) -> list[Row]:
    def row(_: str, own: Records) -> Row:
        count = Counter(r["status"] for r in own)
        cpu = [r["cpu"] for r in own if r.get("cpu") is not None]
        judged = sum("true" in r for r in own)
        times = {"CPU, median [s]": median(cpu) if cpu else 0.0, "all [s]": sum(cpu)}
        return {**{s: count[s] for s in STATUSES}, "with references": judged, **times}

    return _rows(records, row)


def _counts(r: Record, judged: float) -> bool:
    """Whether the references are good enough to judge an error of this size."""
    return bool(r.get("apart", inf) <= TENTH * judged)


def bound_of(way: str) -> float:
    """Error above which a run of this way has to say so, of the range."""
    return BOUNDS.get(way, WITHIN)


def is_of_solution(warning: str) -> bool:
    """Whether a warning is of the solution, not of what the scene stands for."""
    return any(text in warning for text in OF_SOLUTION)


def is_warned(r: Record) -> bool:
    """Whether a run warns of its solution."""
    return any(map(is_of_solution, r["warnings"]))


def unwarned_table(records: Records) -> list[Row]:
    def row(_: str, own: Records) -> Row | None:
        judged = [r for r in own if _counts(r, WITHIN) and not is_warned(r)]
        wrong = [r for r in judged if r["true"] > WITHIN]
        strictly = [r for r in judged if r["true_strictly"] > WITHIN >= r["true"]]
        strictly = [r for r in strictly if r["apart_strictly"] <= TENTH * WITHIN]
        return {
            "complete and unwarned": len(judged),
            "wrong": len(wrong),
            "share": _share(len(wrong), len(judged)),
            "which": _numbers(wrong, "true"),
            "wrong if no range is too small": _numbers(strictly, "true_strictly"),
        }

    return _rows(records, row)


def tolerance_table(records: Records) -> list[Row]:
    def row(way: str, own: Records) -> Row | None:
        if way not in BOUNDS:
            return None
        judged = [r for r in own if _counts(r, BOUNDS[way])]
        beyond = [r for r in judged if r["true"] > BOUNDS[way]]
        silent = [r for r in beyond if not is_told(r)]
        return {
            "judged": len(judged),
            "within": len(judged) - len(beyond),
            "beyond, told": len(beyond) - len(silent),
            "beyond, not told": len(silent),
            "share": _share(len(silent), len(judged)),
            "which": _numbers(silent, "true"),
        }

    return _rows(records, row)


def is_told(r: Record) -> bool:
    """Whether a run says that it is beyond the bound of its way, or that it parts."""
    said = r.get("said") or 0.0
    return is_warned(r) or said > bound_of(r["way"]) or r.get("said_parted") is not None


def ratio_of(r: Record, of: str = "") -> float | None:
    """Error said over the true one, each at most `LOST`; None where none is to be judged. ``of``
    is "" for motions, "_force" for contact forces."""
    said = r.get(f"said{of}")
    true = r.get(f"true{of}")
    apart = r.get("apart" if not of else "force_apart", inf)
    if said is None or true is None or np.isnan(true) or not r["stepped"]:
        return None
    largest = max(said, true)
    if not largest > SMALLEST or not apart <= TENTH * largest:
        return None
    return min(said, LOST) / max(min(true, LOST), 1e-300)


def ratio_table(records: Records, of: str) -> list[Row]:
    def row(_: str, own: Records) -> Row | None:
        complete = [r for r in own if r["status"] == "complete" and "true" in r and r["stepped"]]
        silent = sum(r.get(f"said{of}") is None for r in complete)
        found = [(ratio_of(r, of), r) for r in complete]
        judged = [(x, r) for x, r in found if x is not None]
        ratios = np.array([x for x, _ in judged])
        counts, _ = np.histogram(ratios, EDGES)
        names = [f"{a:g} to {b:g}" for a, b in pairwise(EDGES)]
        low = [r for x, r in judged if x < GOOD[0]]
        good = int(((ratios >= GOOD[0]) & (ratios <= GOOD[1])).sum())
        return {
            "no figure": silent,
            "judged": len(judged),
            **dict(zip(names, map(int, counts), strict=True)),
            f"in {GOOD[0]:g} to {GOOD[1]:g}": _share(good, len(judged)),
            f"below {GOOD[0]:g}": _share(len(low), len(judged)),
            "which": _numbers(low, f"true{of}"),
        }

    return _rows(records, row)


def parting_table(records: Records) -> list[Row]:
    def row(_: str, own: Records) -> Row | None:
        parted = [r for r in own if not np.isnan(r.get("references_parted", np.nan))]
        silent = [r for r in parted if not is_told(r)]
        timed = [r for r in parted if r.get("said_parted") is not None]
        return {
            "part": len(parted),
            "told": len(parted) - len(silent),
            "with a time": len(timed),
            "which are not told": _numbers(silent, "references_parted"),
        }

    return _rows(records, row)


def _is_right(r: Record) -> bool:
    """Whether the error is within a tenth of the bound of its way."""
    bound = bound_of(r["way"])
    return _counts(r, bound) and r["true"] <= TENTH * bound


def false_alarm_table(records: Records) -> list[Row]:
    def row(way: str, own: Records) -> Row:
        judged = [r for r in own if _counts(r, bound_of(way))]
        wolves = [r for r in judged if _is_right(r) and is_warned(r)]
        others = [r for r in judged if r["warnings"] and not is_warned(r)]
        return {
            "judged": len(judged),
            "warned though right": len(wolves),
            "share": _share(len(wolves), len(judged)),
            "warned of the model alone": len(others),
            "which": _numbers(wolves, "true"),
        }

    return _rows(records, row)


def warning_table(records: Records) -> list[Row]:
    """Warnings by their first words: how many runs that are judged have them, and how many of these
    are right."""
    given: Counter[tuple[str, str]] = Counter()
    right: Counter[tuple[str, str]] = Counter()
    for r in records:
        if not _counts(r, bound_of(r["way"])):
            continue
        for kind in {(r["way"], first_words(text)) for text in r["warnings"]}:
            given[kind] += 1
            right[kind] += _is_right(r)
    return [
        {"way": way, "warning": text, "given": count, "right": right[way, text]}
        for (way, text), count in sorted(given.items(), key=lambda item: (item[0][0], -item[1]))
    ]


def first_words(warning: str) -> str:
    """The first words of a warning, its numbers left out."""
    words = re.sub(r"\d+(\.\d+)?(e[-+]?\d+)?", "#", warning).split()
    return " ".join(words[:FIRST_WORDS]).replace("|", "/")


def cost_table(records: Records) -> list[Row]:
    def row(_: str, own: Records) -> Row | None:
        stepped = [r for r in own if r["status"] == "complete" and r["stepped"]]
        if not stepped:
            return None
        each = [r["error_evaluations"] / max(r["evaluations"], 1) for r in stepped]
        all_told = sum(r["error_evaluations"] for r in stepped)
        return {
            "runs": len(stepped),
            "median": median(each),
            "95 %": float(np.quantile(each, 0.95)),
            "largest": max(each),
            "all told": all_told / max(sum(r["evaluations"] for r in stepped), 1),
        }

    return _rows(records, row)


def _share(part: int, whole: int) -> str:
    return f"{part / whole:.1%}" if whole else "-"


def _numbers(those: Records, key: str) -> str:
    """Numbers of scenes and a figure, the first ten."""
    first = [f"{r['kind']} {r['number']} ({r[key]:.1e})" for r in those[:10]]
    return ", ".join(first + (["..."] if len(those) > 10 else []))


def read_arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--kind", choices=tuple(KINDS), default="contacts")
    parser.add_argument("--number", type=int, default=150, help="how many scenes")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument("--way", nargs="+", choices=WAYS, default=["default"])
    parser.add_argument("--folder", type=Path, default=RESULTS / "error_scenes")
    parser.add_argument("--references", type=Path, help="folder of references")
    parser.add_argument("--report", action="store_true", help="of what the folder holds alone")
    parser.add_argument("--show", action="store_true", help="print the cases, and run nothing")
    return parser.parse_args()


def main() -> None:
    """Judge scenes and report on all that the folder holds."""
    given = read_arguments()
    numbers = range(given.first, given.first + given.number)
    if given.show:
        print("---\n".join(text_of(KINDS[given.kind](number)) for number in numbers))
        return
    if not given.report:
        given.folder.mkdir(parents=True, exist_ok=True)
        kept = given.references or given.folder / "references"
        judge_scenes(given.kind, given.way, numbers, given.folder, kept)
    print(report(list(read_records(given.folder))))


if __name__ == "__main__":
    main()
