"""What the records of `error_scenes` show, as tables in markdown.

A reference counts for a question if its own error is at most a tenth of what is judged. Warnings
of the solution are told from those of what a scene stands for (databases, headings, angles), which
no reference can judge. Errors are relative to ranges of motions as the run counts them: it has
least ranges, which `motion_errors.least_ranges` gives.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from math import inf
from statistics import median
from typing import Any

import numpy as np

from benchmarks.report import Row, markdown

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
