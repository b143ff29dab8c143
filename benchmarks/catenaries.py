"""Are the forces of lines right, and is there a line that does not start?

Random lines of `random_lines.py` are solved without a guess and held against

* MoorPy's `catenary` at its tolerance 1e-12 m, where that solves: its forces satisfy the equations
  of the profile that it names, and no part hangs below the seabed (`unsolved`);
* the textbook equations at 50 digits (`exact_lines.py`): one piece, and chains of two to five
  pieces with clumps.

Each is solved again from guesses 20 % and 1e-3 off, which must give the same. Errors are those of H
and V at the fairlead in parts of the tension there.

    python -m benchmarks catenaries
    python -m benchmarks.catenaries --write     # tests/data/lines: samples for the tests
"""

from __future__ import annotations

import contextlib
import csv
import io
import lzma
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from importlib.metadata import version
from math import hypot, nan
from pathlib import Path
from time import perf_counter

import numpy as np

from benchmarks.exact_lines import Line, exact_pull, exact_stiffness, misses, misses_resting
from benchmarks.random_lines import random_chain, random_line
from benchmarks.report import ROOT, Answer, Row
from hydrosim.forces.line.shape import LinePull, solve
from hydrosim.rigid.kinematics import LINE_PIECE

MOORPY, PIECES, CHAINS = 500, 10_000, 2_000
KEPT = 150
SOLVED = 1e-9  # of the length; MoorPy is asked for 1e-12 m
FOLDER = ROOT / "tests" / "data" / "lines"
COLUMNS = ("length", "weight", "stiffness", "hung")
ENDS = ("x", "z", "bed", "friction", "H", "V")
MOST = 5  # pieces of a chain


def answer() -> Answer:
    """The tables."""
    left_out: Counter[str] = Counter()
    moorpy = list(zip(range(MOORPY), moorpy_lines(left_out), strict=False))
    rows: list[Row] = []
    against = [relative(pull_of(line), pull) for _, (line, *pull) in moorpy]
    rows.append({"lines": MOORPY, "against": f"MoorPy {version('moorpy')}", **spread(against)})
    drawn = {
        "one piece, those of MoorPy": [line for _, (line, *_) in moorpy],
        "one piece": [draw(random_line, 0, i) for i in range(PIECES)],
        "chains": [draw(random_chain, 1, i) for i in range(CHAINS)],
    }
    failed = 0
    for name, lines in drawn.items():
        errors = []
        for line in lines:
            pull = pull_of(line)
            if not pull.converged:
                failed += 1
                continue
            errors.append(relative(pull, map(float, exact_pull(line, pull.H, pull.V))))
        rows.append({"lines": len(lines), "against": f"50 digits, {name}", **spread(errors)})
    everything = [line for lines in drawn.values() for line in lines]
    guessed = [worst_of_guesses(line) for line in everything]
    rows.append({"lines": len(everything), "against": "itself from guesses", **spread(guessed)})
    remarks = [
        f"{failed} lines did not start.",
        "Left out as MoorPy does not solve them: "
        + ", ".join(f"{count} ({why})" for why, count in left_out.items()),
        f"A line without a guess takes {microseconds(drawn['one piece'][:1000]):.1f} us,"
        " called from Python.",
    ]
    return Answer({"Errors in parts of the tension": rows}, remarks)


def draw(maker: Callable[[np.random.Generator], Line], *seed: int) -> Line:
    """A random line of a seed."""
    return maker(np.random.default_rng(seed))


def pull_of(line: Line, H: float = nan, V: float = nan) -> LinePull:
    """The pull by hydrosim, from a guess."""
    pieces = np.array([tuple(row) for row in line.rows], dtype=LINE_PIECE)
    return LinePull(*solve(pieces, 0, pieces.size, line.x, line.z, line.bed, line.friction, H, V))


def relative(pull: LinePull, exact: Iterator[float] | list[float]) -> float:
    """Error in parts of the tension at the fairlead."""
    H, V = exact
    tension = hypot(H, V)
    return max(abs(pull.H - H), abs(pull.V - V)) / (tension if tension > 0.0 else 1.0)


def spread(errors: list[float]) -> dict[str, float]:
    """Median, 99th percentile and largest."""
    return {
        "median": float(np.median(errors)),
        "99 %": float(np.quantile(errors, 0.99)),
        "largest": float(np.max(errors)),
    }


def worst_of_guesses(line: Line) -> float:
    """Largest difference between the pulls from nothing and from guesses."""
    pull = pull_of(line)
    guesses = [(pull.H * a, pull.V * b) for a, b in ((1.2, 0.8), (0.8, 1.2), (1.001, 0.999))]
    return max(relative(pull_of(line, *guess), [pull.H, pull.V]) for guess in guesses)


def microseconds(lines: list[Line]) -> float:
    """Time of a solution."""
    pieces = [np.array([tuple(row) for row in line.rows], dtype=LINE_PIECE) for line in lines]
    start = perf_counter()
    for line, rows in zip(lines, pieces, strict=True):
        solve(rows, 0, rows.size, line.x, line.z, line.bed, line.friction, nan, nan)
    return (perf_counter() - start) / len(lines) * 1e6


def moorpy_lines(left_out: Counter[str]) -> Iterator[tuple[Line, float, float]]:
    """Lines that MoorPy solves, with H and V; the others are counted."""
    seed = 0
    while True:
        line = draw(random_line, 2, seed)
        seed += 1
        if line.rows[0][1] == 0.0:
            left_out["no weight"] += 1
            continue
        try:
            H, V, Va, profile = moorpy_pull(line)
        except Exception as error:
            left_out[type(error).__name__] += 1
            continue
        why = unsolved(line, H, V, Va, profile)
        if why:
            left_out[why] += 1
            continue
        yield line, H, V


def unsolved(line: Line, H: float, V: float, Va: float, profile: object) -> str:
    """Why forces, with V down at both ends, do not solve the equations of the profile that MoorPy
    names, or ""."""
    length, weight, _, _ = line.rows[0]
    if profile in (-1, -2):
        return "straight or bilinear line"
    if profile == 1 and line.bed == 0.0 and weight * length > V:
        return "hangs below the seabed that its anchor is on"
    if profile == 1 and misses(line, H, V, hangs=True) > SOLVED:
        return "misses its anchor"
    if profile in (2, 3) and misses(line, H, V, hangs=False) > SOLVED:
        return "misses its anchor"
    if profile == "U" and misses_resting(line, H, V, Va) > SOLVED:
        return "misses its anchor or the seabed between two hanging parts"
    return ""


def moorpy_pull(line: Line) -> tuple[float, float, float, object]:
    """H and V at the fairlead by MoorPy, V at the anchor, and the number of its profile."""
    from moorpy.Catenary import catenary

    length, weight, stiffness, _ = line.rows[0]
    CB = line.friction if line.bed == 0.0 else max(line.bed, -1e3 * length)
    with contextlib.redirect_stdout(io.StringIO()), np.errstate(all="ignore"):
        _, Va, x, z, info = catenary(
            line.x, line.z, length, stiffness, weight, CB=CB, Tol=1e-12, MaxIter=200
        )
    return -float(x), -float(z), -float(Va), info["ProfileType"]


def write() -> None:
    """Write the samples for the tests."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    left_out: Counter[str] = Counter()
    lines = [found for _, found in zip(range(MOORPY), moorpy_lines(left_out), strict=False)]
    save(
        FOLDER / "moorpy.csv.xz",
        (*COLUMNS[:3], *ENDS),
        [(*line.rows[0][:3], *line[1:], H, V) for line, H, V in lines],
    )
    makers = ((random_line, 3), (random_chain, 4))
    drawn = [draw(maker, first, i) for i in range(KEPT) for maker, first in makers]
    pieces = [f"{column}{i}" for i in range(1, MOST + 1) for column in COLUMNS]
    head = (*pieces, *ENDS, "Hx", "Hz", "Vx", "Vz")
    save(FOLDER / "exact.csv.xz", head, [exact_row(line) for line in drawn])


def exact_row(line: Line) -> tuple[float, ...]:
    """A line, its pull and its stiffness."""
    pull = pull_of(line)
    H, V = exact_pull(line, pull.H, pull.V)
    slopes = exact_stiffness(line, pull.H, pull.V)
    padded = [*line.rows, *[(0.0,) * 4] * (MOST - len(line.rows))]
    pieces = (value for row in padded for value in row)
    return (*pieces, *line[1:], float(H), float(V), *map(float, slopes))


def save(path: Path, head: tuple[str, ...], rows: Sequence[tuple[float, ...]]) -> None:
    """Write a table with all digits."""
    with lzma.open(path, "wt", preset=9 | lzma.PRESET_EXTREME, newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(head)
        writer.writerows([["" if v == 0.0 else repr(float(v)) for v in row] for row in rows])
    print(f"written: {path}")


if __name__ == "__main__":
    if sys.argv[1:] != ["--write"]:
        raise SystemExit(__doc__)
    write()
