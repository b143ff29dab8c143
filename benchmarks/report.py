"""What a benchmark reports: tables, remarks and a picture, and the machine that it ran on."""

from __future__ import annotations

import json
import platform
import subprocess
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

import psutil
from matplotlib.figure import Figure

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "benchmarks" / "results"

Row = Mapping[str, str | float]


@dataclass(frozen=True)
class Answer:
    """Tables by their titles, each a row per case with the same keys; remarks; a picture; texts of
    files of the repository to be ``kept``, and the path of the picture there."""

    tables: Mapping[str, Sequence[Row]]
    remarks: Sequence[str] = ()
    picture: Figure | None = field(default=None, compare=False)
    kept: Mapping[Path, str] = field(default_factory=dict, repr=False)
    kept_picture: Path | None = None

    def __str__(self) -> str:
        parts = [f"{title}\n\n{markdown(rows)}" for title, rows in self.tables.items()]
        return "\n\n".join([*parts, "\n".join(f"* {remark}" for remark in self.remarks)])


def markdown(rows: Sequence[Row]) -> str:
    """The rows as a table in markdown, columns aligned."""
    cells = [list(rows[0]), *([_text(value) for value in row.values()] for row in rows)]
    widths = [max(len(line[i]) for line in cells) for i in range(len(cells[0]))]
    cells.insert(1, ["-" * width for width in widths])
    padded = ([c.rjust(w) for c, w in zip(line, widths, strict=True)] for line in cells)
    return "\n".join(f"| {' | '.join(line)} |" for line in padded)


def page_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in markdown for a page, its columns not aligned: a changed figure changes one line
    alone."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def save(question: str, answer: Answer, here: Mapping[str, str]) -> list[Path]:
    """Write the answer as JSON, with the machine, and its picture; returns their paths."""
    RESULTS.mkdir(exist_ok=True)
    paths = [RESULTS / f"{question}.json"]
    content = {"machine": here, "tables": answer.tables, "remarks": answer.remarks}
    paths[0].write_text(json.dumps(content, indent=2) + "\n")
    if answer.picture is not None:
        paths.append(RESULTS / f"{question}.png")
        answer.picture.savefig(paths[-1])
    return paths


def keep(answer: Answer) -> list[Path]:
    """Write the files of the repository that the answer is kept in; returns their paths."""
    for path, text in answer.kept.items():
        path.write_text(text, "utf-8")
    if answer.picture is None or answer.kept_picture is None:
        return list(answer.kept)
    answer.picture.savefig(answer.kept_picture)
    return [*answer.kept, answer.kept_picture]


def machine() -> dict[str, str]:
    """The machine, how busy others keep it, the versions, and the commit of the sources."""
    packages = ("numpy", "scipy", "numba")
    return {
        "cpu": _cpu(),
        "cores": f"{psutil.cpu_count(logical=False)}, {psutil.cpu_count()} threads",
        "busy before": f"{psutil.cpu_percent(interval=1.0):.0f} %",
        "system": platform.platform(),
        "python": platform.python_version(),
        **{name: version(name) for name in packages},
        "commit": _commit(),
        "date": datetime.now(UTC).date().isoformat(),
    }


def _cpu() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    return next((s.split(":")[1].strip() for s in lines if s.startswith("model name")), "unknown")


def _commit() -> str:
    command = ["git", "describe", "--always", "--dirty"]
    try:
        found = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return found.stdout.strip()


def _text(value: str | float) -> str:
    if isinstance(value, int):
        return f"{value:,}"
    return value if isinstance(value, str) else f"{value:.3g}"
